//! What a simulated discharge costs the CPU. Targets: `ideal` below 2 us, `pi4` below 5 us.

use cermd::pins::sim::{Scene, SimPins};
use cermd::pins::{Drives, Pins, PinsError};
use cermd::units::Nanos;
use criterion::Criterion;

const MS: Nanos = Nanos(1_000_000);

/// Charge, release, arm, discharge through Rc1, both crossings, release.
fn discharge(pins: &mut SimPins) -> Result<Nanos, PinsError> {
    let charging = pins.drive(Drives::CHARGE)?;
    pins.sleep_until(charging.after + Nanos(10 * MS.0))?;
    pins.drive(Drives::NONE)?;
    pins.arm()?;
    let start = pins.drive(Drives::C1)?;
    let until = start.after + Nanos(50 * MS.0);
    pins.edge(until)?;
    let last = pins.edge(until)?;
    pins.drive(Drives::NONE)?;
    Ok(last.map_or(Nanos::ZERO, |edge| edge.at - start.after))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut criterion = Criterion::default().configure_from_args();
    for name in ["ideal", "fpga-paper", "pi4"] {
        let scene = Scene::builtin(name)?;
        let mut pins = SimPins::new(&scene, None);
        assert!(discharge(&mut pins)? > Nanos::ZERO, "the discharge has to end");
        criterion.bench_function(&format!("discharge {name}"), |b| b.iter(|| discharge(&mut pins)));
    }
    criterion.final_summary();
    Ok(())
}
