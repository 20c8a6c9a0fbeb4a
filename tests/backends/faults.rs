//! Whatever goes wrong below, what comes out above is a sound reading or a named fault.
//!
//! 100,000 readings as a rule; `CERMD_READINGS=1000000 cargo test --test backends faults` for a long run, `CERMD_SEED`
//! for another one.

use crate::common::Bench;
use crate::common::faulty::{Faulty, Injection};
use crate::common::seed::rng;
use cermd::instrument::cycle::longest_reading;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::sim::SimPins;
use cermd::reading::{Bound, Measured, Method, Reading, Status};
use cermd::sensor::{Force, Law};
use cermd::units::Nanos;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// What injected delays and the scene's own preemptions may add to one reading.
const FOR_THE_SYSTEM: Nanos = Nanos(20_000_000);
/// Readings of one instrument; then another one, with other faults, another method and another sensor, follows.
const READINGS_EACH: u64 = 2000;

fn is_sound_number(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

fn is_sound_value(measured: Measured) -> bool {
    is_sound_number(measured.value) && measured.u.is_none_or(is_sound_number)
}

fn is_sound_bound(bound: Bound) -> bool {
    let (Bound::AtLeast(value) | Bound::AtMost(value)) = bound;
    is_sound_number(value)
}

fn is_sound(status: Status) -> bool {
    match status {
        Status::Ok { r_ohm, shown, .. } => {
            is_sound_value(r_ohm)
                && shown.is_none_or(|f_n| is_sound_value(Measured { value: f_n.value, u: f_n.u }))
        }
        Status::Open { r_min_ohm, shown } => is_sound_number(r_min_ohm) && shown.is_none_or(is_sound_bound),
        Status::Short { r_max_ohm, shown } => is_sound_number(r_max_ohm) && shown.is_none_or(is_sound_bound),
        Status::Fault(_) => true,
    }
}

/// An instrument with a sensor, a method and faults drawn at random.
fn draw(rng: &mut ChaCha8Rng) -> (Instrument<Faulty<SimPins>>, Nanos) {
    let method = Method::ALL[rng.random_range(0..Method::ALL.len())];
    // 1 ohm to 10 Mohm: short, ok and open.
    let r_ohm = 10f64.powf(rng.random_range(0.0..7.0));
    let (pins, mut settings) = Bench::new("pi4", method, r_ohm, rng.random(), "").parts();
    let law = Law::Calibrated { fc1_n: 5.75, fc2_n: 1.05 };
    settings.channels[0].force = Some(Force { law, u: None, range_n: None, tare_n: None });
    let mut pins = Faulty::new(pins, rng.random());
    for injection in Injection::ALL {
        // From never to often; a call that fails ends its cycle, and there are twenty of them in one.
        let most = if injection == Injection::FailingCall { -2.0 } else { -0.5 };
        pins = pins.with(injection, 10f64.powf(rng.random_range(-5.0..most)));
    }
    let bound = longest_reading(&settings) + FOR_THE_SYSTEM;
    (Instrument::new(pins, settings), bound)
}

#[test]
fn no_fault_becomes_a_number_that_is_none() {
    let readings = std::env::var("CERMD_READINGS").map_or(100_000, |count| count.parse().unwrap());
    let mut rng = rng(1);
    let mut seen = [0; 4];
    let mut longest = 0.0f64;
    for round in 0..readings / READINGS_EACH {
        let (mut instrument, bound) = draw(&mut rng);
        let mut last = Reading { seq: 0, ..FIRST };
        while last.seq < READINGS_EACH {
            // An error of the pins is told to the caller, who opens them again; here the next call may work.
            let _ = instrument.step(&mut |message| {
                let Message::Reading(reading) = message else { return };
                assert!(is_sound(reading.status), "round {round}: {reading:?}");
                assert_eq!(reading.seq, last.seq + 1, "round {round}");
                assert!(reading.at >= last.at, "round {round}: {last:?}, then {reading:?}");
                assert!(reading.duration.0 >= 0, "round {round}: {reading:?}");
                assert!(reading.duration <= bound, "round {round}: {reading:?}, at most {bound:?}");
                longest = longest.max(reading.duration.as_seconds() / bound.as_seconds());
                seen[kind(reading.status)] += 1;
                last = reading;
            });
            assert_eq!(instrument.pins().inner().conflicts(), 0);
        }
        // Whatever failed, the next thing that works leaves every line released.
        while instrument.pins().drive(cermd::pins::Drives::NONE).is_err() {}
        assert!(instrument.pins().inner().driving().is_none());
        let stats = instrument.stats();
        let counted = stats.ok + stats.open + stats.short + stats.faults.iter().sum::<u64>();
        assert_eq!((stats.readings, counted), (last.seq, last.seq));
    }
    println!("longest reading: {longest:.3} of its bound");
    assert!(longest > 0.2, "the bound bounds nothing");
    println!("ok {}, open {}, short {}, fault {}", seen[0], seen[1], seen[2], seen[3]);
    assert!(seen.iter().all(|&count| count > 0), "not every state has come up: {seen:?}");
}

const FIRST: Reading = Reading {
    channel: 0,
    seq: 0,
    at: cermd::units::Nanos::ZERO,
    status: Status::Fault(cermd::reading::Fault::Pins),
    suspect: None,
    method: Method::Tpcm,
    duration: cermd::units::Nanos::ZERO,
};

fn kind(status: Status) -> usize {
    match status {
        Status::Ok { .. } => 0,
        Status::Open { .. } => 1,
        Status::Short { .. } => 2,
        Status::Fault(_) => 3,
    }
}
