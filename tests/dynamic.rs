//! A sensor that changes while it is read: steps, ramps, oscillations and a press, in virtual time. Every seed is fixed.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot be set up fails")]

mod common;

use cermd::pins::sim::Sensor;
use cermd::reading::{Method, Reading, Status};
use cermd::units::{Hertz, Ohm, Seconds};
use common::{Bench, read, settle};

/// What became of the readings of a sensor that moves.
#[derive(Debug, Default)]
struct Seen {
    /// Errors in sigmas, and sigmas as shares of R.
    errors: Vec<f64>,
    us: Vec<f64>,
    faults: std::collections::BTreeMap<&'static str, usize>,
    readings: usize,
    seconds: f64,
}

impl Seen {
    fn add(&mut self, reading: &Reading, truth: f64) {
        self.readings += 1;
        self.seconds += reading.duration.as_seconds();
        match reading.status {
            Status::Ok { r_ohm, .. } => {
                let u = r_ohm.u.unwrap();
                self.errors.push((r_ohm.value - truth) / u);
                self.us.push(u / truth);
            }
            Status::Fault(fault) => *self.faults.entry(fault.as_str()).or_default() += 1,
            status => *self.faults.entry(status.as_str()).or_default() += 1,
        }
    }

    fn share(&self, name: &str) -> f64 {
        self.faults.get(name).copied().unwrap_or(0) as f64 / self.readings as f64
    }

    fn beyond(&self, sigmas: f64) -> f64 {
        self.errors.iter().filter(|error| error.abs() > sigmas).count() as f64 / self.errors.len() as f64
    }

    fn rms(&self) -> f64 {
        (self.errors.iter().map(|error| error * error).sum::<f64>() / self.errors.len() as f64).sqrt()
    }

    fn u(&self) -> f64 {
        let mut us = self.us.clone();
        us.sort_by(f64::total_cmp);
        us.get(us.len() / 2).copied().unwrap_or(f64::NAN)
    }

    fn row(&self) -> String {
        let (beyond2, beyond5) = (100.0 * (1.0 - self.beyond(2.0)), 100.0 * self.beyond(5.0));
        let worst = self.errors.iter().fold(0.0f64, |worst, error| worst.max(error.abs()));
        format!(
            "ok {:5.1} %, unsettled {:5.1} %, outlier {:4.1} %, within 2u {beyond2:5.1} %, rms {:.2} u, beyond 5u {beyond5:.2} %, worst {worst:.1} u, u {:.3} %, {:.1} ms  {:?}",
            100.0 * self.errors.len() as f64 / self.readings as f64,
            100.0 * self.share("unsettled"),
            100.0 * self.share("latency-outlier"),
            self.rms(),
            100.0 * self.u(),
            1e3 * self.seconds / self.readings as f64,
            self.faults
        )
    }
}

const INSTRUMENTS: u64 = 8;
const READINGS: usize = 150;

fn observe(method: Method, sensor: &Sensor, rest_ohm: f64, measure: &str) -> Seen {
    let mut seen = Seen::default();
    for seed in 0..INSTRUMENTS {
        let bench = Bench::new("pi4", method, rest_ohm, seed, measure);
        let mut instrument = bench.instrument();
        settle(&mut instrument);
        read(&mut instrument, 40, |_| {});
        instrument.pins().connect(0, sensor.clone());
        for _ in 0..READINGS {
            let mut last = None;
            read(&mut instrument, 1, |reading| last = Some(*reading));
            let reading = last.unwrap();
            let truth = instrument.pins().r_x(0, reading.at).unwrap();
            seen.add(&reading, truth);
        }
    }
    seen
}

#[test]
fn explore() {
    for method in [Method::Tracked, Method::Cerm, Method::Tcdic, Method::Tpcm, Method::Qerm] {
        for r in [300.0, 1000.0, 2500.0, 5000.0, 16_200.0] {
            let rest = observe(method, &Sensor::Constant(Ohm(r)), r, "");
            println!("{method:?} {r} at rest: {}", rest.row());
            for f in [1.0, 2.0, 5.0, 10.0, 20.0] {
                let sensor = Sensor::Sine { mean: Ohm(r), amplitude: Ohm(0.2 * r), frequency: Hertz(f) };
                let seen = observe(method, &sensor, r, "");
                println!("{method:?} {r} {f} Hz: {}", seen.row());
            }
        }
    }
    let _ = Seconds(0.0);
}

#[test]
fn debug() {
    let (method, r, f) = (Method::Tracked, 16_200.0, 20.0);
    for seed in 0..8 {
        let sensor = Sensor::Sine { mean: Ohm(r), amplitude: Ohm(0.2 * r), frequency: Hertz(f) };
        let bench = Bench::new("pi4", method, r, seed, "");
        let mut instrument = bench.instrument();
        settle(&mut instrument);
        read(&mut instrument, 40, |_| {});
        instrument.pins().connect(0, sensor.clone());
        for k in 0..150 {
            let mut last = None;
            read(&mut instrument, 1, |reading| last = Some(*reading));
            let reading = last.unwrap();
            let truth = instrument.pins().r_x(0, reading.at).unwrap();
            let before = instrument.pins().r_x(0, reading.at - cermd::units::Nanos(1_000_000)).unwrap();
            match reading.status {
                Status::Ok { r_ohm, .. } => println!(
                    "{seed} {k} {:.1} err {:+.3} % u {:.3} % slope {:.2}",
                    truth,
                    100.0 * (r_ohm.value / truth - 1.0),
                    100.0 * r_ohm.u.unwrap() / truth,
                    100.0 * (truth - before) / truth
                ),
                s => println!("{seed} {k} {truth:.1} {s:?}"),
            }
        }
    }
}
