//! The fault injector does what it is asked for, and counts it.

use crate::common::chance::share_is;
use crate::common::faulty::{Faulty, Injection};
use crate::common::seed::seed;
use cermd::pins::sim::{Scene, SimPins};
use cermd::pins::{Armed, Bracket, Drives, Edge, Pins, PinsError};
use cermd::units::Nanos;

fn faulty(injection: Injection, probability: f64) -> Faulty<SimPins> {
    Faulty::new(SimPins::new(&Scene::builtin("ideal").unwrap(), None), seed(7)).with(injection, probability)
}

/// One discharge: what arming said, the start, and the edges.
fn discharge(pins: &mut Faulty<SimPins>) -> Result<(Armed, Bracket, Vec<Edge>), PinsError> {
    pins.drive(Drives::CHARGE)?;
    let charged = pins.now() + Nanos(20_000_000);
    pins.sleep_until(charged)?;
    pins.drive(Drives::NONE)?;
    let armed = pins.arm()?;
    let start = pins.drive(Drives::C1)?;
    let until = start.after + Nanos(50_000_000);
    let mut edges = Vec::new();
    while let Some(edge) = pins.edge(until)? {
        edges.push(edge);
    }
    pins.drive(Drives::NONE)?;
    Ok((armed, start, edges))
}

fn clean() -> (Armed, Bracket, Vec<Edge>) {
    discharge(&mut faulty(Injection::LostEdge, 0.0)).unwrap()
}

#[test]
fn a_lost_edge_leaves_no_gap() {
    let mut pins = faulty(Injection::LostEdge, 1.0);
    assert!(discharge(&mut pins).unwrap().2.is_empty());
    assert_eq!(pins.count(Injection::LostEdge), 2);
    let mut pins = pins.with(Injection::LostEdge, 0.0);
    let (armed, _, edges) = discharge(&mut pins).unwrap();
    assert_eq!(edges[0].seqno, armed.seqno.wrapping_add(1));
    assert_eq!(edges[0].line_seqno, armed.line_seqno[0].wrapping_add(1));
}

#[test]
fn a_delayed_stamp_is_later_and_time_has_passed() {
    let mut pins = faulty(Injection::DelayedStamp, 1.0);
    let (_, _, edges) = discharge(&mut pins).unwrap();
    for (late, punctual) in edges.iter().zip(clean().2) {
        assert!(late.at > punctual.at);
    }
    assert!(pins.now() >= edges[1].at);
}

#[test]
fn a_duplicate_has_a_number_of_its_own() {
    let mut pins = faulty(Injection::DuplicatedEdge, 1.0);
    let (armed, _, edges) = discharge(&mut pins).unwrap();
    let seqnos: Vec<_> = edges.iter().map(|edge| edge.seqno - armed.seqno).collect();
    assert_eq!(seqnos, [1, 2, 3, 4]);
    assert_eq!(edges[0].at, edges[1].at);
    assert_eq!(edges[3].line_seqno, 2);
    assert_eq!(pins.arm().unwrap().seqno, 4);
}

#[test]
fn a_gap_shows_in_both_numbers() {
    let (armed, _, edges) = discharge(&mut faulty(Injection::SeqnoGap, 1.0)).unwrap();
    assert_eq!(edges[0].seqno - armed.seqno, 2);
    assert_eq!(edges[0].line_seqno - armed.line_seqno[0], 2);
}

#[test]
fn a_failing_call_does_nothing() {
    let mut pins = faulty(Injection::FailingCall, 1.0);
    let error = pins.drive(Drives::CHARGE).unwrap_err();
    assert!(error.to_string().contains("drive"), "{error}");
    assert_eq!(pins.inner().driving(), Drives::NONE);
}

#[test]
fn a_wrong_level_is_wrong_in_one_node() {
    let mut pins = faulty(Injection::WrongLevel, 1.0);
    let levels = pins.levels().unwrap();
    assert!(levels.a != levels.b, "both are low while nothing was charged");
}

#[test]
fn a_long_bracket_is_as_long_as_it_says() {
    let mut pins = faulty(Injection::LongBracket, 1.0);
    let start = discharge(&mut pins).unwrap().1;
    assert!(start.width() > Nanos::ZERO);
    assert_eq!(clean().1.width(), Nanos::ZERO);
}

#[test]
fn counts_what_it_does_and_repeats_itself() {
    let run = || {
        let mut pins = faulty(Injection::LostEdge, 0.2);
        let edges: Vec<_> = (0..100).map(|_| discharge(&mut pins).unwrap().2.len()).collect();
        let lost = pins.count(Injection::LostEdge);
        assert_eq!(edges.iter().sum::<usize>() as u64, 200 - lost);
        (edges, lost)
    };
    let (edges, lost) = run();
    assert!(share_is(lost as usize, 200, 0.2), "{lost}");
    assert_eq!(run(), (edges, lost));
}
