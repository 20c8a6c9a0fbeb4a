//! A press, steps, ramps and late stamps.

use super::{CASES, Case, INSTRUMENTS, MEMORY, READINGS, name, observe, quiet, share_of};
use crate::common::chance::{WITHIN_2U, mean_of, share_is_in};
use crate::common::{Bench, kind_of, next_reading, read, rest, settle};
use cermd::pins::Pins;
use cermd::pins::sim::scene::DelayScene;
use cermd::pins::sim::{Kind, Sensor};
use cermd::reading::{Method, Status};
use cermd::units::{Hertz, Ohm, Seconds};
use std::fmt::Write;
use std::path::PathBuf;

/// Force from that of 100 kohm to that of 1 kohm and back, again and again, each flank `flank` seconds long.
fn press(flank: f64) -> Sensor {
    let smooth = |share: f64| share.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * share.clamp(0.0, 1.0));
    let period = 2.0 * flank + 0.6;
    let force = |t: f64| {
        let phase = t.rem_euclid(period);
        smooth(phase / flank) * smooth((2.0 * flank + 0.3 - phase) / flank)
    };
    let points = (0..60_000).map(|index| {
        let t = 1e-3 * f64::from(index);
        (t, 1.0 / (1e-5 + (1e-3 - 1e-5) * force(t)))
    });
    Sensor::File { path: PathBuf::new(), points: points.collect() }
}

/// The share of readings without a number that the fastest flank may cost: those whose discharge saw the force change by more than
/// the half of it, longer discharges more often.
fn most_unsettled(case: Case) -> f64 {
    match case {
        (Method::Tpcm, _) => 0.3,
        (Method::Tracked | Method::Qerm, Kind::TwoCapacitor | Kind::SeriesCalibration) => 0.12,
        _ => 0.05,
    }
}

#[test]
fn a_press_from_100_kohm_to_1_kohm_is_numbers_that_are_true() {
    let mut failed = String::new();
    for case in CASES {
        for flank in [0.05, 0.1, 0.3, 1.0] {
            let seen = observe(|seed| quiet(case, 100e3, seed), &press(flank), 0, 400);
            let row = format!("{} flank {flank} s: {}", name(case), seen.in_words());
            println!("{row}");
            let sound = seen.within(2.0).is_in(WITHIN_2U..=1.0)
                && seen.within(5.0).is_in(0.998..=1.0)
                && seen.moving_within(2.0).is_in(0.93..=1.0)
                && seen.moving().is_in(0.002..=0.4)
                && seen.share("unsettled").is_in(0.0..=most_unsettled(case))
                && seen.share("latency-outlier").is_in(0.0..=0.02);
            if !sound {
                writeln!(failed, "{row}").unwrap();
            }
        }
    }
    assert!(failed.is_empty(), "seeds 0..{INSTRUMENTS}\n{failed}");
}

/// Between two resistances, every 0.237 s.
fn steps(low: f64, high: f64) -> Sensor {
    let points = (1..250).flat_map(|index| {
        let t = 0.237 * f64::from(index);
        let (before, after) = if index % 2 == 0 { (high, low) } else { (low, high) };
        [(t, before), (t + 1e-6, after)]
    });
    Sensor::File { path: PathBuf::new(), points: points.collect() }
}

/// A step falls into a discharge as often as the discharge is long against the cycle; then the number says so, or there is none.
#[test]
fn a_step_is_told_when_it_falls_into_a_discharge_and_only_then() {
    let mut failed = String::new();
    let steps_between = [(1000.0, 1300.0), (5000.0, 6000.0), (5000.0, 16_200.0), (13_000.0, 16_200.0)];
    for (case, (low, high)) in CASES.into_iter().flat_map(|case| steps_between.map(|ohms| (case, ohms))) {
        let seen = observe(|seed| quiet(case, low, seed), &steps(low, high), 0, 400);
        let count = seen.readings.len() as f64;
        let steps = seen.seconds / 0.237;
        // To the crossing of A; of B it is twice as long.
        let inside = 5.7e-7 * (0.5 * (low + high) + 40.0) / (seen.seconds / count);
        let expected = steps * inside / count;
        let told = seen
            .mean(|reading| Some(share_of(reading.is_ok_and(|number| number.is_moving) || reading.is_err())));
        let row = format!("{} {low} to {high} ohm: expected {expected:.3}, {}", name(case), seen.in_words());
        println!("{row}");
        // Those that the step falls into, and the two after it at most, which cannot know that it is over.
        let most = 2.0 * expected + 2.0 * steps / count;
        let sound = told.is_in(0.5 * expected..=most)
            && seen.within(2.0).is_in(WITHIN_2U..=1.0)
            && seen.within(5.0).is_in(0.999..=1.0)
            && seen.moving_within(2.0).is_in(0.93..=1.0);
        if !sound {
            writeln!(failed, "{row}").unwrap();
        }
    }
    assert!(failed.is_empty(), "seeds 0..{INSTRUMENTS}\n{failed}");
}

/// 50 kohm in a second: a tenth of a millisecond in the instant is 5 ohm.
#[test]
fn the_instant_of_a_ramp_is_right_for_direct_and_inferred_readings() {
    let mut failed = String::new();
    for (method, from, to, measure) in [
        (Method::Tracked, 4000.0, 14_000.0, ""),
        (Method::Tracked, 300.0, 2000.0, ""),
        (Method::Cerm, 4000.0, 14_000.0, "t-l = \"0 s\"\noffset = \"auto\""),
        (Method::Cerm, 4000.0, 14_000.0, "t-l = \"1 s\"\noffset = \"auto\""),
        (Method::Tcdic, 4000.0, 14_000.0, ""),
        (Method::Tpcm, 4000.0, 14_000.0, ""),
        (Method::Qerm, 4000.0, 14_000.0, ""),
    ] {
        let (mut means, mut count) = (Vec::new(), 0.0);
        for seed in 0..8 * INSTRUMENTS {
            let mut bench = quiet((method, kind_of(method)), from, seed);
            bench.config.lines("measure", measure);
            let mut instrument = bench.instrument();
            settle(&mut instrument);
            rest(&mut instrument);
            let start = Seconds(instrument.pins().now().as_seconds());
            let ramp = Sensor::Ramp {
                from: Ohm(from),
                to: Ohm(to),
                start,
                duration: Seconds(0.2 + (to - from) / 50e3),
            };
            instrument.pins().connect(0, ramp);
            read(&mut instrument, 4, |_| {});
            let (mut sum, mut weights) = (0.0, 0.0);
            loop {
                let reading = next_reading(&mut instrument);
                if reading.at.as_seconds() > start.0 + 0.19 + (to - from) / 50e3 {
                    break;
                }
                let Status::Ok { r_ohm, .. } = reading.status else { continue };
                let truth = instrument.pins().r_x(0, reading.at).unwrap();
                let weight = (r_ohm.u.unwrap() / truth).powi(-2);
                sum += weight * (r_ohm.value / truth - 1.0);
                weights += weight;
                count += 1.0;
            }
            // On so short a way an instrument now and then has none that is settled.
            means.extend((weights > 0.0).then(|| sum / weights));
        }
        let silent = 8 * INSTRUMENTS as usize - means.len();
        // Readings of one instrument share a calibration.
        let mean = mean_of(&means);
        let row = format!(
            "{} {from} to {to} ohm {measure:?}: mean error {} %, {count} readings",
            method.as_str(),
            mean.times(100.0)
        );
        println!("{row}");
        if count < 100.0 || !mean.is(0.0, 0.0) || !share_is_in(silent, 8 * INSTRUMENTS as usize, 0.0..=0.02) {
            writeln!(failed, "{row}").unwrap();
        }
    }
    assert!(failed.is_empty(), "seeds 0..{}\n{failed}", 8 * INSTRUMENTS);
}

#[test]
fn a_late_stamp_stays_an_outlier_at_rest_and_harms_little_in_motion() {
    let late = |method, r_ohm, seed| {
        let mut bench = Bench::new("pi4", method, r_ohm, seed, "");
        bench.scene.stamps = bench.scene.stamps.map(|stamps| DelayScene {
            tail_probability: Some(0.01),
            tail_mean: Some(Seconds(200e-6)),
            ..stamps
        });
        bench
    };
    let mut failed = String::new();
    for method in [Method::Tracked, Method::Tcdic] {
        for r_ohm in [5000.0, 16_200.0] {
            let rest =
                observe(|seed| late(method, r_ohm, seed), &Sensor::Constant(Ohm(r_ohm)), 0, 4 * READINGS);
            let sine = Sensor::Sine { mean: Ohm(r_ohm), amplitude: Ohm(0.2 * r_ohm), frequency: Hertz(2.0) };
            let moving = observe(|seed| late(method, r_ohm, seed), &sine, MEMORY, 4 * READINGS);
            let row = format!(
                "{} {r_ohm} ohm at rest: {}\n    at 2 Hz: {}",
                method.as_str(),
                rest.in_words(),
                moving.in_words()
            );
            println!("{row}");
            // Over one stretch alone it is told as a change that came all at once.
            let told = rest.mean(|reading| {
                let is_told =
                    reading.as_ref().map_or_else(|fault| *fault == "latency-outlier", |ok| ok.is_moving);
                Some(f64::from(u8::from(is_told)))
            });
            let sound = told.is_in(0.005..=0.03)
                && rest.share("unsettled").is_in(0.0..=0.002)
                && rest.within(5.0).is_in(0.998..=1.0)
                && moving.within(2.0).is_in(0.93..=1.0)
                && moving.within(5.0).is_in(0.98..=1.0);
            if !sound {
                writeln!(failed, "{row}").unwrap();
            }
        }
    }
    assert!(failed.is_empty(), "seeds 0..{INSTRUMENTS}\n{failed}");
}
