//! A sensor that changes while it is read: oscillations, a press, steps, ramps and late stamps, in virtual time.
//!
//! `docs/dynamic.md` is what comes out of it; `UPDATE_DOCS=1 cargo test --test accuracy dynamic` writes it anew. Every seed is
//! fixed; every check has two sides.

mod changes;
mod hand;

use crate::common::chance::{Figure, WITHIN_2U, mean_of};
use crate::common::{self, Bench, check_page, name_of, next_reading, read, rest, settle};
use cermd::pins::sim::{Kind, Sensor};
use cermd::reading::{Method, Reading, Status};
use cermd::units::{Hertz, Ohm};
use std::collections::BTreeMap;
use std::f64::consts::{SQRT_2, TAU};
use std::fmt::Write;

const INSTRUMENTS: u64 = 8;
const READINGS: usize = 150;
/// Readings after which a motion has been seen.
const MEMORY: usize = 6;
const AMPLITUDE: f64 = 0.2;

/// Readings in a row that hang together: their motion, their calibration. So many are one of what chance chooses.
const BLOCK: usize = 25;

/// A number, as seen by who knows the truth.
#[derive(Debug, Clone, Copy)]
struct Number {
    /// Its error in its own sigmas.
    error: f64,
    /// It says that the sensor moves.
    is_moving: bool,
}

/// What became of the readings of a sensor that moves.
#[derive(Debug, Default)]
struct Seen {
    /// Numbers, or why there is none.
    readings: Vec<Result<Number, &'static str>>,
    /// Sigmas as shares of R.
    us: Vec<f64>,
    seconds: f64,
}

impl Seen {
    fn add(&mut self, reading: &Reading, truth: f64) {
        self.seconds += reading.duration.as_seconds();
        self.readings.push(match reading.status {
            Status::Ok { r_ohm, is_moving, .. } => {
                let u = r_ohm.u.unwrap();
                self.us.push(u / truth);
                Ok(Number { error: (r_ohm.value - truth) / u, is_moving })
            }
            Status::Fault(fault) => Err(fault.as_str()),
            status => Err(name_of(&status)),
        });
    }

    /// The mean of something over the readings that it is there for.
    fn mean(&self, of: impl Fn(&Result<Number, &'static str>) -> Option<f64>) -> Figure {
        let values: Vec<Option<f64>> = self.readings.iter().map(of).collect();
        let mean = |values: &[Option<f64>]| {
            let count = values.iter().flatten().count();
            (count > 0).then(|| values.iter().flatten().sum::<f64>() / count as f64)
        };
        let blocks: Vec<f64> = values.chunks(BLOCK).filter_map(mean).collect();
        if blocks.len() < 2 {
            return Figure { value: f64::NAN, u: f64::NAN, margin: f64::NAN };
        }
        // Blocks have more numbers and fewer: the mean is that of all of them, its error that of the blocks.
        Figure { value: mean(&values).unwrap_or(f64::NAN), ..mean_of(&blocks) }
    }

    fn share(&self, name: &str) -> Figure {
        self.mean(|reading| Some(share_of(reading.is_err_and(|error| error == name))))
    }

    /// Of the numbers, the share that says that the sensor moves.
    fn moving(&self) -> Figure {
        self.mean(|reading| reading.ok().map(|number| share_of(number.is_moving)))
    }

    /// The share of the numbers that are off by less than so many of their own sigmas.
    fn within(&self, sigmas: f64) -> Figure {
        self.mean(|reading| reading.ok().map(|number| share_of(number.error.abs() <= sigmas)))
    }

    /// The same of those that say that the sensor moves.
    fn moving_within(&self, sigmas: f64) -> Figure {
        let moving = |reading: &Result<Number, _>| reading.ok().filter(|number| number.is_moving);
        self.mean(|reading| moving(reading).map(|number| share_of(number.error.abs() <= sigmas)))
    }

    fn rms(&self) -> Figure {
        self.mean(|reading| reading.ok().map(|number| number.error.powi(2))).sqrt()
    }

    fn worst(&self) -> f64 {
        self.readings.iter().flatten().fold(0.0, |worst, number| number.error.abs().max(worst))
    }

    fn median_u(&self) -> f64 {
        let mut us = self.us.clone();
        us.sort_by(f64::total_cmp);
        us.get(us.len() / 2).copied().unwrap_or(0.0)
    }

    fn seconds_each(&self) -> f64 {
        self.seconds / self.readings.len() as f64
    }

    fn in_words(&self) -> String {
        let mut others = BTreeMap::<_, usize>::new();
        self.readings
            .iter()
            .filter_map(|reading| reading.err())
            .for_each(|name| *others.entry(name).or_default() += 1);
        format!(
            "{} numbers, {:.3} moving, within 2u {} (moving {}), rms {:.2} u, worst {:.1} u, median u {:.3} %, {:.1} ms, {others:?}",
            self.us.len(),
            self.moving().value,
            self.within(2.0),
            self.moving_within(2.0),
            self.rms(),
            self.worst(),
            100.0 * self.median_u(),
            1e3 * self.seconds_each(),
        )
    }
}

fn share_of(is_so: bool) -> f64 {
    f64::from(u8::from(is_so))
}

type Case = (Method, Kind);

/// Every method, and `tracked` where there is one node.
const CASES: [Case; 6] = [
    (Method::Tracked, Kind::TwoCapacitor),
    (Method::Tracked, Kind::OneCapacitor),
    (Method::Cerm, Kind::TwoCapacitor),
    (Method::Tcdic, Kind::TwoCapacitor),
    (Method::Tpcm, Kind::TwoCapacitor),
    (Method::Qerm, Kind::SeriesCalibration),
];

fn name((method, kind): Case) -> String {
    let nodes = if (method, kind) == (Method::Tracked, Kind::OneCapacitor) { ", one node" } else { "" };
    format!("{method}{nodes}")
}

fn quiet((method, kind): Case, rest_ohm: f64, seed: u64) -> Bench {
    let bench = Bench::with_kind("pi4", kind, method, rest_ohm, seed, "");
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
            let reading = next_reading(&mut instrument);
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

/// Where an oscillation of 20 Hz is read a dozen times a period, one or two in a hundred readings come after a gap that is too long.
const UNSETTLED: f64 = 0.03;

fn oscillations() -> (String, String) {
    let (mut table, mut wrong) = (String::new(), String::new());
    for case in CASES {
        for r_ohm in [300.0, 1000.0, 5000.0, 16_200.0] {
            for hertz in [1.0, 2.0, 5.0, 10.0, 20.0].into_iter().filter(|hertz| *hertz <= fastest(case.0)) {
                let (mean, amplitude) = (Ohm(r_ohm), Ohm(AMPLITUDE * r_ohm));
                let sensor = Sensor::Sine { mean, amplitude, frequency: Hertz(hertz) };
                let seen = observe(|seed| quiet(case, r_ohm, seed), &sensor, MEMORY, READINGS);
                // An oscillation is never off by more than 1.4 times its root mean square: where it is most of the error, all
                // is within two sigma, up to 1.4 sigma of it.
                let is_true = seen.within(2.0).is_in(WITHIN_2U..=1.0)
                    && seen.rms().is_in(0.5..=1.2)
                    && seen.worst() < 7.0
                    && seen.share("unsettled").is_in(0.0..=UNSETTLED);
                if !is_true {
                    writeln!(wrong, "{} {r_ohm} ohm {hertz} Hz: {}", name(case), seen.in_words()).unwrap();
                }
                writeln!(
                    table,
                    "| {} | {r_ohm} | {hertz} | {:.3} | {:.3} | {:.1} | {:.1} | {:.1} |",
                    name(case),
                    100.0 * predicted(r_ohm, hertz),
                    100.0 * seen.median_u(),
                    100.0 * seen.within(2.0).value,
                    100.0 * seen.moving().value,
                    100.0 * seen.share("unsettled").value
                )
                .unwrap();
            }
        }
    }
    (table, wrong)
}

#[test]
fn an_oscillation_is_read_with_its_second_order_stated() {
    let (table, wrong) = oscillations();
    println!("{table}");
    assert!(wrong.is_empty(), "seeds 0..{INSTRUMENTS}\n{wrong}");
    let page = format!("{HEAD}{table}{HAND}{}{TAIL}", hand::table());
    check_page("accuracy dynamic", "dynamic.md", &page);
}

const HEAD: &str = "# A sensor that changes while it is read

![Error and honesty over resistance and speed of the sensor: which cells fail, and by which cause](map-speed.svg)

The picture is of `cermctl characterize`; the rest of the page is of tests. Where it says so, the stated uncertainty is not enough: a sensor of 16 kohm
or more that changes by a hundred times its value in a second does so within a discharge. Such readings are marked `moving`, most of them,
and understate their error by up to 29 times.

A discharge takes its time: about 1 us for each ohm with 2.2 uF / 680 nF. Each crossing tells the mean conductance
1/(R_x+Ro) over its stretch of the discharge. The stated instant of a reading (`time`, `t_mono_ns`) is the weighted mean
of the middles of these stretches: for a steady change the reading is R_x at that instant.

What is left is of the second order. It is predicted from the last six readings and from what the two nodes of each of
them disagree by, and added to the stated uncertainty. Where that is most of it, the reading is marked `moving`. So
is one whose crossings contradict each other as a changing sensor makes them, with an uncertainty as large as they differ by;
if one late stamp would do, after readings that were at rest, it is `latency-outlier`. Of one stretch, a change that was not to
be expected may have come at any instant: its bound is what one step can have done. Only where twice the uncertainty is more
than the value there is no number: the reading is `fault`, `unsettled`.

With a single capacitor a discharge has one stretch: of a change that comes and goes within it (a sensor of 14 kohm and 3.4 uF take 56 ms,
which is a period of 18 Hz) it tells the mean, and nothing that would show in u or in `moving`. Take a smaller capacitor, or two.

Everything below is **simulated**: board `pi4` without its rare late stamps, R_x = R (1 + 0.2 sin(2 pi f t)), 8
instruments with 150 readings each. Written by `UPDATE_DOCS=1 cargo test --test accuracy dynamic`; do not edit. `predicted` is the
second order of a full discharge of two nodes (1 sigma), `u` the median of what is stated, noise included, `within 2u` the share
of the numbers that are R_x at their instant within twice their own sigma. `unsettled`: no numbers, after a calibration discharge through
Rc2 that the oscillation has not waited for.

| method | R / ohm | f / Hz | predicted / % | u / % | within 2u / % | moving / % | unsettled / % |
|---|--:|--:|--:|--:|--:|--:|--:|
";

const HAND: &str = "
## A hand

A hand presses an FSR 402 again and again for 40 s, on 8 boards `pi4` with their late stamps, from untouched to some 10 N and back, each
time a little differently. Readings of a sensor that changes by more than a tenth within its discharge have no one true value and are not
in the table. `rms`: of the errors, in units of their own sigma (1 is exact). `beyond 10 u`: of the numbers that do not say that the sensor
moves.

| method | readings/s | rms | within 2u / % | moving / % | unsettled / % | beyond 10 u |
|---|--:|--:|--:|--:|--:|--:|
";

const TAIL: &str = "
## What cannot be seen

- One stretch tells no slope: `tpcm`, `qerm`, and `cerm` and `tracked` when they switch before A crosses. Then a change shows only
  from reading to reading, and one that comes back between two of them does not show: above about a quarter of the rate
  of readings the stated uncertainty is too small. Where `tracked` switches, the sensor's part is so short (1 ms at 1 kohm)
  that 20 Hz do no harm.
- A motion in step with the readings shows the same value and slope each time, and at its turning points nothing tells of it:
  `tcdic` at 16.2 kohm and 10 Hz was off by up to 16 u while a look for a leak, 5 s after the start, made cycles last
  0.1 s.
- A change that repeats within one discharge averages out in it; it is told by what is left of it.
- A step in the middle of a single stretch gives a value in between. It is told because nothing before it was as fast; on a
  sensor that steps all the time it may pass.
- A late stamp while the sensor moves shows when it is beside the way that the last readings went, the bend of that way included, by
  more than they are beside it themselves: the reading is `moving` then. One that is late as the sensor moves is not seen: the readings
  of a moving hand are as good as the kernel's latency lets them. With one stretch it looks like motion at rest, too: one reading is
  `moving` or `unsettled`, and forgotten when the next one is back.
- Two nodes that disagree always by some sigma, by leakage or by wide-band noise at the threshold, look like a sensor that
  every discharge catches in the same motion: at rest a part of the readings is `moving` then (rows 5 and 18 of
  [stability.md](stability.md)).
";
