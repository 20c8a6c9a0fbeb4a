//! A tape that begins later than the daemon knows what looks had shown by then.

use super::tests::{config, replayed};
use super::*;
use crate::config::tape_header;
use crate::daemon::rounds::Round;
use crate::instrument::{Instrument, Message};
use crate::pins::Pins;
use crate::pins::sim::{Scene, Sensor, SimPins};
use crate::stream::tape::{Reader, TapeLooks};
use crate::units::{Ohm, Seconds};

/// Resistances of the sensors, ohm.
const TRUTHS: [f64; 2] = [1000.0, 5000.0];
/// Of these seconds, the tape has those from the first on.
const RECORDED_S: [f64; 2] = [40.0, 43.0];
/// Rounds that the daemon keeps.
const KEPT: usize = 40;

/// The tape of a board with a leak at node A, and how many readings were made meanwhile. `tells`: it has what looks had shown.
fn recorded(method: &str, leak: Ohm, tells: bool) -> (String, usize) {
    let config = config("two-capacitor", &format!("method = \"{method}\""));
    let settings = config.settings().unwrap();
    let sensors = TRUTHS.map(|r_ohm| Sensor::Constant(Ohm(r_ohm))).into();
    let mut scene = Scene::builtin("pi4").unwrap().with_sensors(sensors).unwrap();
    scene.circuit.node_a.leakage_resistance = Some(leak);
    let mut instrument = Instrument::new(SimPins::new(&scene, Some(crate::seed::seed(1))), settings.clone());
    let (mut round, mut rounds, mut lines, mut readings) = (Round::default(), Vec::new(), Vec::new(), 0);
    let (mut header, [from, to]) = (None, RECORDED_S.map(|s| Nanos::from(Seconds(s))));
    let plain = tape_header(&settings, None);
    let began = instrument.pins().now();
    loop {
        let now = instrument.pins().now() - began;
        if now >= to {
            break;
        }
        if now >= from && header.is_none() && instrument.cycle().is_at_start() {
            let stats = instrument.stats();
            let looks = if tells { TapeLooks::of(&instrument.cycle().found()) } else { TapeLooks::default() };
            header = Some(Header { looks, ..tape_header(&settings, Some(stats.offset)) });
        }
        instrument
            .step(&mut |message| match message {
                // As between two looks.
                Message::Discharge { is_held: true, .. } => {}
                Message::Discharge { seq, record, .. } if header.is_some() => {
                    lines.push(plain.discharge(seq, &record, false));
                }
                Message::Discharge { seq, record, .. } => {
                    rounds.extend(round.add(&settings, &plain, (seq, &record)));
                }
                Message::Reading(_) => readings += usize::from(header.is_some()),
            })
            .unwrap();
    }
    let forgotten = rounds.len().saturating_sub(KEPT);
    let lines = rounds
        .into_iter()
        .skip(forgotten)
        .flatten()
        .chain(lines)
        .map(|line| serde_json::to_string(&line).unwrap() + "\n");
    (serde_json::to_string(&header).unwrap() + "\n" + &lines.collect::<String>(), readings)
}

#[test]
fn a_tape_that_begins_later_has_the_leak_in_its_uncertainties() {
    for (method, leak) in [("tracked", 20e6), ("cerm", 20e6), ("tracked", 1e6), ("cerm", 1e6)] {
        let (tape, readings) = recorded(method, Ohm(leak), true);
        let method = *Method::ALL.iter().find(|known| known.as_str() == method).unwrap();
        let estimates = replayed(&tape, method);
        assert_eq!(estimates.len(), readings, "{method}");
        let of = |id: &str| if id == "thumb" { TRUTHS[0] - 1.5 } else { TRUTHS[1] };
        let numbers = estimates.iter().filter_map(|line| {
            let [r_ohm, u] = [line.state.r_ohm?, line.state.r_u_ohm?];
            Some((r_ohm - of(&line.channel)).abs() < 2.0 * u)
        });
        let (within, count) =
            numbers.fold((0, 0), |(within, count), is| (within + usize::from(is), count + 1));
        assert!(
            10 * count > 9 * readings && 10 * within >= 9 * count,
            "{method} {leak}: {within} of {count} of {readings}"
        );
    }
}

#[test]
fn it_says_whether_a_leak_is_in_them() {
    let ignores = |tape: &str| {
        let reader = Reader::open(tape.as_bytes()).unwrap();
        let mut replay = Replay::new(reader.header(), Method::Cerm, None).unwrap();
        reader.for_each(|entry| drop(replay.take(&entry.unwrap())));
        replay.ignores_leaks()
    };
    assert!(ignores(&recorded("cerm", Ohm(20e6), false).0));
    assert!(!ignores(&recorded("cerm", Ohm(20e6), true).0));
}
