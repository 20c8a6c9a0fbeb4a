//! A chip that sleeps when it is left alone, or the way to it: lines then move later in their calls than where it was just
//! touched, and no bracket shows it.

use crate::common::Bench;
use crate::common::chance::{WITHIN_2U, share_is};
use crate::common::decorated::Decorated;
use cermd::instrument::{Instrument, Message};
use cermd::pins::sim::{Scene, SimPins};
use cermd::pins::{Levels, Pins};
use cermd::reading::{Method, Status};
use cermd::units::Seconds;

const R_OHM: f64 = 100.0;
/// Boards, each with one reading: readings of one board share its calibration.
const BOARDS: u64 = 600;
/// Readings of a board before that: its calibration is no prior any more.
const BEFORE: u64 = 60;

/// How many boards are within two of their sigma, of how many that gave a number; and the mean error.
fn within_2u<P: Pins>(wakes_us: f64, pins_of: impl Fn(SimPins) -> P) -> (usize, usize, f64) {
    let (mut hits, mut errors) = (0, Vec::new());
    for seed in 0..BOARDS {
        let mut bench = Bench::new("pi4", Method::Tracked, R_OHM, seed, "");
        asleep(&mut bench.scene, wakes_us);
        let (pins, settings) = bench.parts();
        let mut instrument = Instrument::new(pins_of(pins), settings);
        let (mut seen, mut last) = (0, None);
        while seen < BEFORE || last.is_none() {
            let mut take = |message| {
                if let Message::Reading(reading) = message {
                    seen += 1;
                    last = match reading.status {
                        Status::Ok { r_ohm, .. } => r_ohm.u.map(|u| (r_ohm.value - R_OHM, u)),
                        _ => None,
                    };
                }
            };
            instrument.step(&mut take).unwrap();
            assert!(seen < 10 * BEFORE, "hardly any number");
        }
        let (error, u) = last.unwrap();
        hits += usize::from(error.abs() <= 2.0 * u);
        errors.push(error);
    }
    (hits, errors.len(), errors.iter().sum::<f64>() / errors.len() as f64)
}

fn asleep(scene: &mut Scene, wakes_us: f64) {
    let calls = scene.calls.as_mut().unwrap();
    (calls.asleep_after, calls.wakes_in) = (Some(Seconds(10e-6)), Some(Seconds(wakes_us * 1e-6)));
}

#[test]
fn what_sleeps_is_woken_before_a_call_that_is_timed() {
    for wakes_us in [1.0, 2.0, 5.0] {
        let (hits, boards, mean) = within_2u(wakes_us, |pins| pins);
        println!("{wakes_us} us: {hits} of {boards} within 2u, mean error {mean:.2} ohm");
        assert!(share_is(hits, boards, WITHIN_2U), "{wakes_us} us: {hits} of {boards}");
    }
    // And it is that which helps.
    let untouched = |pins| Decorated::told(pins, Levels { a: true, b: true });
    let (hits, boards, mean) = within_2u(2.0, untouched);
    println!("untouched: {hits} of {boards} within 2u, mean error {mean:.2} ohm");
    assert!(!share_is(hits, boards, WITHIN_2U), "{hits} of {boards}");
}
