//! A sensor that changes while it is read: oscillations, a press, steps, ramps and late stamps, in virtual time.
//!
//! `docs/dynamic.md` is what comes out of it; `UPDATE_DOCS=1 cargo test --test accuracy dynamic` writes it anew. Every seed is
//! fixed; every check has two sides.

mod page;

use crate::common::chance::{Figure, WITHIN_2U, mean_of, share_is_in};
use crate::common::{self, Bench, check_page, name_of, read, rest, settle};
use cermd::pins::Pins;
use cermd::pins::sim::Sensor;
use cermd::pins::sim::scene::DelayScene;
use cermd::reading::{Method, Reading, Status};
use cermd::units::{Hertz, Ohm, Seconds};
use page::{HEAD, TAIL};
use std::collections::BTreeMap;
use std::f64::consts::{SQRT_2, TAU};
use std::fmt::Write;
use std::path::PathBuf;

const INSTRUMENTS: u64 = 8;
const READINGS: usize = 150;
/// Readings after which a motion has been seen.
const MEMORY: usize = 6;
const AMPLITUDE: f64 = 0.2;
/// A reading whose predicted error is greater is `unsettled`.
const LIMIT: f64 = 0.01;

/// Readings in a row that hang together: their motion, their calibration. So many are one of what chance chooses.
const BLOCK: usize = 25;

/// What became of the readings of a sensor that moves.
#[derive(Debug, Default)]
struct Seen {
    /// Errors in sigmas, or why there is no number.
    readings: Vec<Result<f64, &'static str>>,
    /// Sigmas as shares of R.
    us: Vec<f64>,
    seconds: f64,
}

impl Seen {
    fn add(&mut self, reading: &Reading, truth: f64) {
        self.seconds += reading.duration.as_seconds();
        self.readings.push(match reading.status {
            Status::Ok { r_ohm, .. } => {
                let u = r_ohm.u.unwrap();
                self.us.push(u / truth);
                Ok((r_ohm.value - truth) / u)
            }
            Status::Fault(fault) => Err(fault.as_str()),
            status => Err(name_of(&status)),
        });
    }

    /// The mean of something over the readings that it is there for.
    fn mean(&self, of: impl Fn(&Result<f64, &'static str>) -> Option<f64>) -> Figure {
        let values: Vec<Option<f64>> = self.readings.iter().map(of).collect();
        let mean = |values: &[Option<f64>]| {
            let count = values.iter().flatten().count();
            (count > 0).then(|| values.iter().flatten().sum::<f64>() / count as f64)
        };
        let blocks: Vec<f64> = values.chunks(BLOCK).filter_map(mean).collect();
        // Blocks have more numbers and fewer: the mean is that of all of them, its error that of the blocks.
        Figure { value: mean(&values).unwrap_or(f64::NAN), ..mean_of(&blocks) }
    }

    fn share(&self, name: &str) -> Figure {
        self.mean(|reading| Some(f64::from(u8::from(*reading == Err(name)))))
    }

    /// The share of the numbers that are off by less than so many of their own sigmas.
    fn within(&self, sigmas: f64) -> Figure {
        self.mean(|reading| reading.ok().map(|error| f64::from(u8::from(error.abs() <= sigmas))))
    }

    fn rms(&self) -> Figure {
        self.mean(|reading| reading.ok().map(|error| error * error)).sqrt()
    }

    fn worst(&self) -> f64 {
        self.readings.iter().flatten().fold(0.0, |worst, error| error.abs().max(worst))
    }

    fn median_u(&self) -> f64 {
        let mut us = self.us.clone();
        us.sort_by(f64::total_cmp);
        us.get(us.len() / 2).copied().unwrap_or(0.0)
    }

    fn in_words(&self) -> String {
        let mut others = BTreeMap::<_, usize>::new();
        self.readings
            .iter()
            .filter_map(|reading| reading.err())
            .for_each(|name| *others.entry(name).or_default() += 1);
        format!(
            "{} numbers, within 2u {}, rms {:.2} u, worst {:.1} u, median u {:.3} %, {:.1} ms, {others:?}",
            self.us.len(),
            self.within(2.0),
            self.rms(),
            self.worst(),
            100.0 * self.median_u(),
            1e3 * self.seconds / self.readings.len() as f64,
        )
    }
}

fn quiet(method: Method, rest_ohm: f64, seed: u64) -> Bench {
    let bench = Bench::new("pi4", method, rest_ohm, seed, "");
    Bench { scene: common::quiet(bench.scene), ..bench }
}

/// Readings of `sensor` by instruments that have settled with another one at rest, from the `skip`th on.
fn observe(bench: impl Fn(u64) -> Bench, sensor: &Sensor, skip: usize, readings: usize) -> Seen {
    let mut seen = Seen::default();
    for seed in 0..INSTRUMENTS {
        let mut instrument = bench(seed).instrument();
        settle(&mut instrument);
        rest(&mut instrument);
        instrument.pins().connect(0, sensor.clone());
        read(&mut instrument, skip, |_| {});
        for _ in 0..readings {
            let mut last = None;
            read(&mut instrument, 1, |reading| last = Some(*reading));
            let reading = last.unwrap();
            let truth = instrument.pins().r_x(0, reading.at).unwrap();
            seen.add(&reading, truth);
        }
    }
    seen
}

/// The second order of a full discharge through a sensor that oscillates, relative, 1 sigma: both nodes weighted by their g
/// (eq. (11)); the other methods' weights are not far from that.
fn predicted(r_ohm: f64, hertz: f64) -> f64 {
    // 2.2 uF / 680 nF from 3.3 V to 1.1 V, s/ohm.
    let ends = [5.707e-7, 1.0708e-6].map(|g: f64| g * (r_ohm + 40.0));
    let weights = ends.map(|end| end / (ends[0] + ends[1]));
    let sum = |of: &dyn Fn(f64) -> f64| weights[0] * of(ends[0]) + weights[1] * of(ends[1]);
    let at = sum(&|end| end / 2.0);
    AMPLITUDE / SQRT_2 * (TAU * hertz).powi(2) * sum(&|end| end * end / 24.0 + (end / 2.0 - at).powi(2) / 2.0)
}

/// Each method up to where its readings come often enough: with two stretches in a discharge nearly once a period, with one
/// four times.
fn fastest(method: Method) -> f64 {
    match method {
        Method::Tracked => 20.0,
        Method::Tcdic | Method::Cerm => 10.0,
        Method::Qerm => 10.0,
        Method::Tpcm => 5.0,
    }
}

fn oscillations() -> (String, String) {
    let (mut table, mut wrong) = (String::new(), String::new());
    for method in [Method::Tracked, Method::Cerm, Method::Tcdic, Method::Tpcm, Method::Qerm] {
        for r_ohm in [300.0, 1000.0, 5000.0, 16_200.0] {
            for hertz in [1.0, 2.0, 5.0, 10.0, 20.0].into_iter().filter(|hertz| *hertz <= fastest(method)) {
                let (mean, amplitude) = (Ohm(r_ohm), Ohm(AMPLITUDE * r_ohm));
                let sensor = Sensor::Sine { mean, amplitude, frequency: Hertz(hertz) };
                let seen = observe(|seed| quiet(method, r_ohm, seed), &sensor, MEMORY, READINGS);
                let predicted = predicted(r_ohm, hertz);
                // Above twice the limit hardly a number is left, and none is promised to be right.
                let is_blurred = predicted > 2.0 * LIMIT;
                let bounds = if is_blurred { 0.9..=1.0 } else { 0.0..=0.05 };
                let bounds = if predicted > 0.5 * LIMIT && !is_blurred { 0.0..=0.5 } else { bounds };
                // An oscillation is never off by more than 1.4 times its root mean square: where it is most of the error, all
                // is within two sigma.
                let within = seen.within(2.0);
                let is_true = is_blurred
                    || (within.is_in(WITHIN_2U..=1.0) && seen.rms().is_in(0.7..=1.0) && seen.worst() < 7.0);
                if !seen.share("unsettled").is_in(bounds) || !is_true {
                    writeln!(wrong, "{} {r_ohm} ohm {hertz} Hz: {}", method.as_str(), seen.in_words())
                        .unwrap();
                }
                writeln!(
                    table,
                    "| {} | {r_ohm} | {hertz} | {:.3} | {} | {} | {:.1} |",
                    method.as_str(),
                    100.0 * predicted,
                    if is_blurred { String::new() } else { format!("{:.3}", 100.0 * seen.median_u()) },
                    if is_blurred { String::new() } else { format!("{:.1}", 100.0 * within.value) },
                    100.0 * seen.share("unsettled").value
                )
                .unwrap();
            }
        }
    }
    (table, wrong)
}

#[test]
fn an_oscillation_is_read_with_its_second_order_stated_or_is_unsettled() {
    let (table, wrong) = oscillations();
    println!("{table}");
    assert!(wrong.is_empty(), "seeds 0..{INSTRUMENTS}\n{wrong}");
    let page = format!("{HEAD}{table}{TAIL}");
    check_page("accuracy dynamic", "dynamic.md", &page);
}

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

#[test]
fn a_press_from_100_kohm_to_1_kohm_is_true_where_it_is_a_number() {
    let mut failed = String::new();
    for method in [Method::Tracked, Method::Cerm] {
        for flank in [0.05, 0.1, 0.3, 1.0] {
            let seen = observe(|seed| quiet(method, 100e3, seed), &press(flank), 0, 400);
            let row = format!("{} flank {flank} s: {}", method.as_str(), seen.in_words());
            println!("{row}");
            let sound = seen.within(2.0).is_in(WITHIN_2U..=1.0)
                && seen.within(5.0).is_in(0.998..=1.0)
                && seen.rms().is_in(0.4..=1.0)
                && seen.share("unsettled").is_in(0.005..=0.4)
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

/// A step falls into a discharge as often as the discharge is long against the cycle; then there is no number.
#[test]
fn a_step_is_unsettled_when_it_falls_into_a_discharge_and_only_then() {
    let mut failed = String::new();
    for (low, high) in [(1000.0, 1300.0), (5000.0, 6000.0), (5000.0, 16_200.0), (13_000.0, 16_200.0)] {
        let seen = observe(|seed| quiet(Method::Tracked, low, seed), &steps(low, high), 0, 400);
        let steps = seen.seconds / 0.237;
        let count = seen.readings.len() as f64;
        let inside = 1.0708e-6 * (0.5 * (low + high) + 40.0) / (seen.seconds / count);
        let expected = steps * inside / count;
        let found = seen.mean(|reading| Some(f64::from(u8::from(reading.is_err()))));
        let row = format!("{low} to {high} ohm: expected {:.2} %, {}", 100.0 * expected, seen.in_words());
        println!("{row}");
        // At most one more reading for each step, whose change is greater than anything before it.
        let most = expected + steps / count;
        let numbers = seen.within(2.0).is_in(WITHIN_2U..=1.0) && seen.within(5.0).is_in(0.999..=1.0);
        if !found.is_in(0.5 * expected..=most) || !numbers {
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
            let mut bench = quiet(method, from, seed);
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
                let mut last = None;
                read(&mut instrument, 1, |reading| last = Some(*reading));
                let reading = last.unwrap();
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
            let sound = rest.share("latency-outlier").is_in(0.005..=0.03)
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
