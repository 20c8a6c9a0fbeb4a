//! A sensor that changes while it is read.

use crate::common::{Bench, Errors, next_reading};
use cermd::pins::sim::Sensor;
use cermd::reading::Method;
use cermd::units::{Ohm, Seconds};

const INSTRUMENTS: u64 = 60;

/// A sensor that changes by 1000 ohm in a second: half a millisecond in the time of a reading is half an ohm.
#[test]
fn a_reading_of_a_changing_sensor_is_of_its_stated_instant() {
    let ramp =
        Sensor::Ramp { from: Ohm(1000.0), to: Ohm(3000.0), start: Seconds(8.0), duration: Seconds(2.0) };
    let mut all = Errors::default();
    for seed in 0..INSTRUMENTS {
        all.next_board();
        let mut bench = Bench::new("pi4", Method::Tracked, 1000.0, seed, "");
        bench.scene = bench.scene.with_sensors(vec![ramp.clone()]).unwrap();
        let mut instrument = bench.instrument();
        let mut seconds = 0.0;
        while seconds < 9.9 {
            let reading = next_reading(&mut instrument);
            seconds = reading.at.as_seconds();
            if (8.1..9.9).contains(&seconds) {
                all.add(&reading, instrument.pins().r_x(0, reading.at).unwrap());
            }
        }
    }
    println!(
        "ramp of 1000 ohm/s (simulated): mean {:.3}, sd {:.3}, u {:.3}, inferred {} of {}, others {}",
        all.mean(),
        all.sd(),
        all.mean_u(),
        all.inferred,
        all.count(),
        all.not_ok.len()
    );
    assert!(all.count() > 1000 && all.inferred * 2 > all.count());
    let mean = all.mean_error();
    assert!(mean.margin < 0.5 && mean.is(0.0, 0.0), "{mean}, seeds 0..{INSTRUMENTS}");
}
