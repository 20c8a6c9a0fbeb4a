//! A hand that presses an FSR 402 again and again, on a board that stamps some edges late.

use super::{CASES, Case, INSTRUMENTS, Seen, name};
use crate::common::chance::WITHIN_2U;
use crate::common::{Bench, next_with_truth, rest, settle};
use cermd::pins::Pins;
use cermd::pins::sim::Sensor;
use cermd::units::Nanos;
use std::fmt::Write;
use std::sync::LazyLock;

const SECONDS: f64 = 40.0;
/// How long a discharge takes for each ohm.
const SECONDS_PER_OHM: f64 = 1e-6;
/// Of the numbers that do not move so many may be beyond ten sigma: a stamp that is late as the hand would have moved looks like it.
const BEYOND_10: f64 = 2e-4;

/// What each method makes of it.
static SEEN: LazyLock<Vec<(Case, Seen)>> = LazyLock::new(|| {
    let mut all: Vec<(Case, Seen)> = CASES.map(|case| (case, Seen::default())).into();
    for (case, seen) in &mut all {
        (0..INSTRUMENTS).for_each(|seed| presses(*case, seed, seen));
    }
    all
});

fn presses((method, kind): Case, seed: u64, seen: &mut Seen) {
    let bench = Bench::with_kind("pi4", kind, method, 1e5, seed, "");
    let mut instrument = bench.instrument();
    settle(&mut instrument);
    rest(&mut instrument);
    instrument.pins().connect(0, Sensor::hand());
    let end = instrument.pins().now() + Nanos::from_seconds(SECONDS);
    while instrument.pins().now() < end {
        next_with_truth(&mut instrument, SECONDS_PER_OHM, |reading, truth| seen.add(reading, truth));
    }
}

/// How many numbers that do not move are beyond ten sigma, and of how many.
fn beyond(seen: &Seen) -> [f64; 2] {
    let still = || seen.readings.iter().flatten().filter(|number| !number.is_moving);
    [still().filter(|number| number.error.abs() > 10.0).count(), still().count()].map(|count| count as f64)
}

/// A line for each method.
pub fn table() -> String {
    let mut table = String::new();
    for (case, seen) in SEEN.iter() {
        let [within, moving, unsettled] =
            [seen.within(2.0), seen.moving(), seen.share("unsettled")].map(|share| 100.0 * share.value);
        let [beyond, still] = beyond(seen);
        writeln!(
            table,
            "| {} | {:.0} | {:.2} | {within:.1} | {moving:.1} | {unsettled:.1} | {beyond} of {still} |",
            name(*case),
            1.0 / seen.seconds_each(),
            seen.rms().value,
        )
        .unwrap();
    }
    table
}

#[test]
fn the_presses_of_a_hand_are_numbers_that_are_true() {
    let mut failed = String::new();
    for (case, seen) in SEEN.iter() {
        let [beyond, still] = beyond(seen);
        let most = BEYOND_10 * still;
        let row = format!("{}: {beyond} beyond 10 u, {}", name(*case), seen.in_words());
        println!("{row}");
        let sound = seen.within(2.0).is_in(WITHIN_2U..=1.0)
            && seen.rms().is_in(0.5..=1.2)
            && seen.moving_within(2.0).is_in(0.93..=1.0)
            && beyond <= 1.0 + most + 3.0 * most.sqrt();
        if !sound {
            writeln!(failed, "{row}").unwrap();
        }
    }
    assert!(failed.is_empty(), "seeds 0..{INSTRUMENTS}\n{failed}");
}
