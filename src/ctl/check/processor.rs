//! What measuring is going to cost the processor: computing, by a rehearsal on this machine; waiting and calls, by real
//! discharges where there were some, else by the scene that is rehearsed on.

use super::expect;
use super::metered::Metered;
use crate::config::Config;
use crate::ctl::limits::METERED;
use crate::instrument::settings::Settings;
use crate::instrument::{Instrument, Message};
use crate::pins::sim::{Scene, Sensor, SimPins};
use crate::pins::{self, Pins};
use crate::units::{Nanos, Ohm, rough};
use nix::time::ClockId;

/// What the calling thread has had of a processor.
pub fn time() -> Nanos {
    pins::clock(ClockId::CLOCK_THREAD_CPUTIME_ID)
}

/// Of a sensor, per discharge in seconds.
#[derive(Debug, Default)]
struct Cost {
    r_ohm: f64,
    discharges_hz: f64,
    /// With what simulating took.
    computing: f64,
    calls: f64,
    spun: f64,
}

/// Lines for `cermctl check`; nothing for a circuit that never measures. `busy`: of a real discharge.
pub fn text(config: &Config, settings: &Settings, busy: Option<Nanos>) -> String {
    let Some((scene, _)) = expect::board(config, None) else { return String::new() };
    let short = expect::shortened(settings);
    let all: Vec<Cost> = expect::resistances(config, settings)
        .into_iter()
        .filter_map(|r_ohm| rehearse(&short, &scene, r_ohm))
        .map(|cost| Cost { calls: busy.map_or(cost.calls, Nanos::as_seconds), ..cost })
        .collect();
    let Some(most) = all.iter().max_by(|a, b| a.discharges_hz.total_cmp(&b.discharges_hz)) else {
        return String::new();
    };
    let share = |cost: &Cost| {
        let percent = 100.0 * cost.discharges_hz * (cost.computing + cost.calls + cost.spun);
        format!("{} at {:.3}", rough(percent, "%"), Ohm(cost.r_ohm))
    };
    let shares: Vec<String> = all.iter().map(share).collect();
    let us = |seconds: f64| rough(1e6 * seconds, "us");
    let calls = match busy {
        Some(_) => "in calls and wake-ups (measured: real discharges)",
        None => "in calls (by the scene, without wake-ups)",
    };
    format!(
        "\nTo be expected of one processor: {}.\n\
         A discharge costs {} of computing (measured: this program on this machine), {} {calls}, {} awake before switches (by the scene).\n",
        shares.join(", "),
        us(most.computing),
        us(most.calls),
        us(most.spun)
    )
}

fn rehearse(settings: &Settings, scene: &Scene, r_ohm: f64) -> Option<Cost> {
    let sensors = settings.channels.iter().map(|channel| Sensor::Constant(Ohm(channel.as_read(r_ohm))));
    let scene = scene.clone().with_sensors(sensors.collect()).ok()?;
    let mut instrument = Instrument::new(Metered::new(SimPins::new(&scene, None)), settings.clone());
    let (since, used) = (expect::warm_up(&mut instrument, settings, Nanos::ZERO)?, time());
    let counts = |pins: &Metered| [pins.calls, pins.spun];
    let (before, until) = (counts(instrument.pins()), since + METERED.max(expect::longest(settings)));
    let mut discharges = 0usize;
    while instrument.pins().now() <= until {
        let count = &mut |message| discharges += usize::from(matches!(message, Message::Discharge { .. }));
        instrument.step(count).ok()?;
    }
    let per_discharge = |spent: Nanos| spent.as_seconds() / discharges.max(1) as f64;
    let (now, after) = (instrument.pins().now(), counts(instrument.pins()));
    Some(Cost {
        r_ohm,
        discharges_hz: discharges as f64 / (now - since).as_seconds(),
        computing: per_discharge(time() - used),
        calls: per_discharge(after[0] - before[0]),
        spun: per_discharge(after[1] - before[1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config_file::config;

    fn cost(scene: &str, measure: &str) -> Cost {
        let config = config(|c| {
            c.set("circuit.v-th", "1.1 V")
                .set("gpio.backend", "mock")
                .set("mock.scene", scene)
                .lines("measure", measure)
                .channel("x")
        })
        .parse();
        let (scene, _) = expect::board(&config, None).unwrap();
        rehearse(&config.settings().unwrap(), &scene, 1000.0).unwrap()
    }

    #[test]
    fn a_board_without_latencies_costs_computing_alone() {
        let (ideal, pi4) = (cost("ideal", ""), cost("pi4", ""));
        assert!(ideal.calls == 0.0 && pi4.calls > 1e-6, "{ideal:?} {pi4:?}");
        // Some microseconds, whatever the build and the machine are.
        assert!((1e-7..1e-2).contains(&ideal.computing) && (1e-7..1e-2).contains(&pi4.computing), "{pi4:?}");
        // A switch is waited for awake; nothing else is.
        let tpcm = cost("pi4", "method = \"tpcm\"");
        assert!(tpcm.spun < pi4.spun && pi4.spun < 1e-3, "{tpcm:?} {pi4:?}");
        let idle = cost("pi4", "rate-hz = 10\nidle = true");
        assert!(idle.discharges_hz < 0.5 * pi4.discharges_hz, "{idle:?}");
    }
}
