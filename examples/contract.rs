//! Holds a real chip with a real circuit to the contract of `Pins`, and times the calls.
//!
//! `contract --chip LABEL [--backend chardev-v1] [--sense-charges] [--release-lines]`: the pinout is that of the example configuration.
//! One line a clause, "held" or "broken"; exit status 1 if any is broken.

#[path = "../tests/backends/clauses.rs"]
mod clauses;

use cermd::pins::chardev::{Chardev, Wiring};
use cermd::pins::realtime::{Realtime, Wishes};
use cermd::pins::{Drives, Pins, chardev, chardev_v1};
use cermd::units::Nanos;
use clap::{Parser, ValueEnum};
use clauses::{Bench, check, dropping_releases};
use std::error::Error;
use std::process::ExitCode;

#[derive(Parser)]
struct Options {
    /// Label, name or path of the chip.
    #[arg(long)]
    chip: String,
    #[arg(long, value_enum, default_value = "chardev")]
    backend: Backend,
    /// The sense lines charge too.
    #[arg(long)]
    sense_charges: bool,
    /// Only make all lines inputs, as after a kill.
    #[arg(long)]
    release_lines: bool,
    /// Time to charge, in microseconds.
    #[arg(long, default_value_t = 10_000)]
    charge_us: i64,
    /// Longer than any discharge, in microseconds.
    #[arg(long, default_value_t = 60_000)]
    discharge_us: i64,
}

#[derive(Clone, Copy, ValueEnum)]
enum Backend {
    Chardev,
    ChardevV1,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let realtime = Realtime::request(&Wishes {
        fifo_priority: Some(50),
        lock_memory: true,
        cpu: Some(0),
        no_deep_idle: true,
    });
    for (what, right) in &realtime.rights {
        println!("{what}: {right}");
    }
    let wiring = wiring(&options);
    let held = match (options.backend, options.release_lines) {
        (Backend::Chardev, true) => chardev::release_lines(&wiring).map(|()| true).map_err(Into::into),
        (Backend::ChardevV1, true) => chardev_v1::release_lines(&wiring).map(|()| true).map_err(Into::into),
        (Backend::Chardev, false) => hold(|| Chardev::open(&wiring), &options),
        (Backend::ChardevV1, false) => hold(|| chardev_v1::open(&wiring), &options),
    };
    match held {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("contract: {error}");
            ExitCode::FAILURE
        }
    }
}

fn wiring(options: &Options) -> Wiring {
    let charger = |line: &str| (!options.sense_charges).then(|| line.to_string());
    Wiring {
        chip: options.chip.clone(),
        sense_a: "GPIO5".to_string(),
        sense_b: Some("GPIO6".to_string()),
        charge_a: charger("GPIO13"),
        charge_b: charger("GPIO19"),
        sink_c1: "GPIO20".to_string(),
        sink_c2: "GPIO21".to_string(),
        sinks_x: vec!["GPIO16".to_string()],
        consumer: "contract".to_string(),
    }
}

fn hold<P, E>(mut open: impl FnMut() -> Result<P, E>, options: &Options) -> Result<bool, Box<dyn Error>>
where
    P: Pins,
    E: Error + 'static,
{
    let bench = Bench {
        charge: Nanos(options.charge_us * 1_000),
        discharge: Nanos(options.discharge_us * 1_000),
        node_b: true,
    };
    let mut pins = open()?;
    let mut outcomes = check(&mut pins, &bench);
    durations(&mut pins)?;
    drop(pins);
    outcomes.push(("a drop releases every line", dropping_releases(open, &bench)));
    for (clause, outcome) in &outcomes {
        match outcome {
            Ok(()) => println!("held: {clause}"),
            Err(seen) => println!("broken: {clause}: {seen}"),
        }
    }
    Ok(outcomes.iter().all(|(_, outcome)| outcome.is_ok()))
}

/// Prints how long each kind of call takes here: the median of some.
fn durations<P: Pins>(pins: &mut P) -> Result<(), Box<dyn Error>> {
    const CALLS: usize = 101;
    let x = Drives::x(0);
    let changes = [
        ("charge", Drives::NONE, Drives::CHARGE),
        ("end of charge", Drives::CHARGE, Drives::NONE),
        ("start of a discharge", Drives::NONE, x),
        ("switch from x to c2", x, Drives::C2),
        ("switch from c2 to x", Drives::C2, x),
    ];
    for (what, from, to) in changes {
        let mut widths = Vec::with_capacity(CALLS);
        for _ in 0..CALLS {
            pins.drive(from)?;
            widths.push(pins.drive(to)?.width());
        }
        pins.drive(Drives::NONE)?;
        widths.sort();
        println!("{what}: {}", widths[CALLS / 2]);
    }
    let mut arming = Vec::with_capacity(CALLS);
    for _ in 0..CALLS {
        pins.drive(Drives::CHARGE)?;
        pins.drive(Drives::NONE)?;
        let begin = pins.now();
        pins.arm()?;
        arming.push(pins.now() - begin);
    }
    arming.sort();
    println!("arming after a charge: {}", arming[CALLS / 2]);
    Ok(())
}
