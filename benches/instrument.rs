//! What measuring costs the CPU, in virtual time: `cargo bench --bench instrument`.
//!
//! Targets: an `ideal` discharge below 2 us, a `pi4` one below 5 us, an estimate below 200 ns.

#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up has failed")]

#[path = "../tests/common/mod.rs"]
mod common;

use cermd::circuit::Node;
use cermd::estimate::Estimator;
use cermd::instrument::Message;
use cermd::instrument::discharge::{self, Charge, Plan};
use cermd::pins::sim::{Scene, SimPins};
use cermd::reading::{Branch, Method, Status};
use cermd::record::{Record, Through};
use cermd::sensor::Channel;
use cermd::units::Nanos;
use common::{Bench, read, settle};
use criterion::Criterion;
use std::hint::black_box;

/// Of the daemon with 2.2 uF and 680 nF: a full discharge through Rc1.
const PLAN: Plan = Plan {
    settle: Nanos(20_000),
    ..Plan::full(Through::C1, Node::B, Charge::together(Nanos(10_000_000)), Nanos(50_000_000))
};

fn discharges(criterion: &mut Criterion) {
    for name in ["ideal", "fpga-paper", "pi4"] {
        let mut pins = SimPins::new(&Scene::builtin(name).unwrap(), None);
        assert!(discharge::run(&mut pins, PLAN).unwrap().result.is_ok());
        criterion.bench_function(&format!("discharge/{name}"), |bencher| {
            bencher.iter(|| discharge::run(&mut pins, black_box(PLAN)).unwrap());
        });
    }
}

/// The record of a sensor's discharge that gave a number with its uncertainty by this branch, and what estimated it.
fn record_of(bench: &Bench, wanted: Branch) -> Option<(Estimator, Record)> {
    let mut instrument = bench.instrument();
    settle(&mut instrument);
    let (mut last, mut found) = (None, None);
    for _ in 0..20_000 {
        let step = instrument.step(&mut |message| match message {
            Message::Discharge { record, .. } => last = Some(record),
            Message::Reading(reading) => match reading.status {
                Status::Ok { branch, r_ohm, .. } if branch == wanted && r_ohm.u.is_some() => found = last,
                _ => {}
            },
        });
        step.unwrap();
        if let Some(record) = found {
            return Some((instrument.cycle().estimator().clone(), record));
        }
    }
    None
}

/// An estimate by each method and branch, and for the methods that have two of them what decides between them.
fn estimates(criterion: &mut Criterion) {
    for method in Method::ALL {
        for (branch, r_ohm) in [(Branch::Direct, 20_000.0), (Branch::Inferred, 500.0)] {
            let found = record_of(&Bench::new("pi4", method, r_ohm, 1, ""), branch);
            let Some((estimator, record)) = found else { continue };
            let sensor = Channel::default();
            let name = format!("{}/{}", method.as_str(), branch.as_str());
            criterion.bench_function(&format!("estimate/{name}"), |bencher| {
                bencher.iter(|| estimator.status(black_box(&record), &sensor));
            });
            if branch == Branch::Inferred {
                criterion.bench_function(&format!("predict/{}", method.as_str()), |bencher| {
                    bencher.iter(|| estimator.predict(black_box(0.5), 0.9, 300.0));
                });
            }
        }
    }
}

/// Three or four discharges, the estimate and the plan of the next one.
fn cycles(criterion: &mut Criterion) {
    for name in ["ideal", "pi4"] {
        let mut instrument = Bench::new(name, Method::Cerm, 1000.0, 1, "").instrument();
        settle(&mut instrument);
        criterion.bench_function(&format!("cycle/{name}"), |bencher| {
            bencher.iter(|| {
                read(&mut instrument, 1, |reading| {
                    black_box(*reading);
                })
            });
        });
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    discharges(&mut criterion);
    estimates(&mut criterion);
    cycles(&mut criterion);
    criterion.final_summary();
}
