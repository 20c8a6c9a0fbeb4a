//! What any [`Pins`] must do, as checks that run on the simulated circuit, on fakes and on real kernels alike.
//!
//! A clause leaves nothing driving, whether it holds or not, so clauses can follow each other on one backend.

use cermd::circuit::Node;
use cermd::pins::{Bracket, Drives, Edge, Pins, PinsError};
use cermd::units::Nanos;

/// A wait in which nothing is expected to happen.
const A_WHILE: Nanos = Nanos(200_000);

/// The circuit that a backend is checked on: two calibration resistors, Rc1 < Rc2, thresholds without noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bench {
    /// Long enough to charge all nodes.
    pub charge: Nanos,
    /// Longer than any discharge through Rc2.
    pub discharge: Nanos,
    /// Whether there is a node B.
    pub node_b: bool,
}

/// A clause of the contract: holds, or says what was seen instead.
pub type Clause<P> = fn(&mut P, &Bench) -> Result<(), String>;

/// All clauses, each with what it demands.
pub fn clauses<P: Pins>() -> [(&'static str, Clause<P>); 13] {
    [
        ("time never goes back, and calls lie within their brackets", brackets_are_ordered),
        ("a charger against a sink is refused, and nothing changes", conflicts_are_refused),
        ("all sense lines are high after a charge", charging_raises_levels),
        ("a discharge gives one numbered edge a node, A before B", edges_come_in_order),
        ("all sense lines are low after a discharge", discharging_lowers_levels),
        ("waiting for an edge ends without one, and not early", waiting_ends_at_its_time),
        ("arming forgets the edges before it, but not their numbers", arming_forgets),
        ("edges that come during a sleep are kept", sleeping_keeps_edges),
        ("a sleep or a rest never ends early", sleeping_is_never_short),
        ("a rest before an edge ends before it, and leaves it", resting_leaves_the_edge),
        ("driving what drives already changes nothing", driving_is_idempotent),
        ("a discharge goes on when another resistor takes over", switching_continues),
        ("when nothing is to drive, nothing drives", releasing_stops),
    ]
}

/// Runs every clause; the name of each with its outcome.
pub fn check<P: Pins>(pins: &mut P, bench: &Bench) -> Vec<(&'static str, Result<(), String>)> {
    let outcome = |clause: Clause<P>, pins: &mut P| {
        let held = clause(pins, bench);
        let released = pins.drive(Drives::NONE).map(drop).map_err(said);
        held.and(released)
    };
    clauses().into_iter().map(|(name, clause)| (name, outcome(clause, pins))).collect()
}

/// That dropping a backend releases its lines: a discharge that has just begun does not end. Only for circuits that
/// outlive the backend, such as those of a kernel.
///
/// # Errors
/// What was seen instead.
pub fn dropping_releases<P: Pins, E: std::fmt::Display>(
    mut open: impl FnMut() -> Result<P, E>,
    bench: &Bench,
) -> Result<(), String> {
    let mut pins = open().map_err(|error| error.to_string())?;
    charge(&mut pins, bench)?;
    pins.drive(Drives::C1).map_err(said)?;
    drop(pins);
    let mut pins = open().map_err(|error| error.to_string())?;
    let later = pins.now() + bench.discharge;
    pins.sleep_until(later).map_err(said)?;
    let levels = pins.levels().map_err(said)?;
    demand(levels.a && levels.b, || format!("the discharge went on after the drop: {levels:?}"))
}

fn said(error: PinsError) -> String {
    error.to_string()
}

fn demand(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise()) }
}

fn nodes(bench: &Bench) -> &'static [Node] {
    if bench.node_b { &Node::BOTH } else { &[Node::A] }
}

fn charge<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    pins.drive(Drives::CHARGE).map_err(said)?;
    let charged = pins.now() + bench.charge;
    pins.sleep_until(charged).map_err(said)?;
    pins.drive(Drives::NONE).map(drop).map_err(said)
}

/// Charges, arms and starts a discharge through Rc1; when it began.
fn start<P: Pins>(pins: &mut P, bench: &Bench) -> Result<Bracket, String> {
    charge(pins, bench)?;
    pins.arm().map_err(said)?;
    pins.drive(Drives::C1).map_err(said)
}

/// The edges of a discharge through Rc1, one a node.
fn edges<P: Pins>(pins: &mut P, bench: &Bench) -> Result<Vec<Edge>, String> {
    let deadline = pins.now() + bench.discharge;
    let mut next = |node: &Node| match pins.edge(deadline).map_err(said)? {
        Some(edge) if edge.node == *node => Ok(edge),
        other => Err(format!("expected an edge of node {node:?}, got {other:?}")),
    };
    nodes(bench).iter().map(&mut next).collect()
}

fn no_edge<P: Pins>(pins: &mut P, until: Nanos) -> Result<(), String> {
    let edge = pins.edge(until).map_err(said)?;
    demand(edge.is_none(), || format!("expected no edge, got {edge:?}"))
}

fn brackets_are_ordered<P: Pins>(pins: &mut P, _: &Bench) -> Result<(), String> {
    for on in [Drives::C1, Drives::C2, Drives::NONE, Drives::CHARGE, Drives::NONE] {
        let before = pins.now();
        let bracket = pins.drive(on).map_err(said)?;
        let after = pins.now();
        let ordered = before <= bracket.before && bracket.before <= bracket.after && bracket.after <= after;
        demand(ordered, || format!("{before}, {bracket:?}, {after} when {on} was to drive"))?;
    }
    Ok(())
}

fn conflicts_are_refused<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    charge(pins, bench)?;
    let conflict = Drives::CHARGE_A.and(Drives::C1);
    match pins.drive(conflict) {
        Err(PinsError::Conflict(refused)) if refused == conflict => {}
        other => return Err(format!("{conflict} gave {other:?}")),
    }
    let later = pins.now() + bench.discharge;
    pins.sleep_until(later).map_err(said)?;
    let levels = pins.levels().map_err(said)?;
    demand(levels.a && levels.b, || format!("the refused sink has discharged: {levels:?}"))
}

fn charging_raises_levels<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    charge(pins, bench)?;
    let armed = pins.arm().map_err(said)?.levels;
    let levels = pins.levels().map_err(said)?;
    demand(armed == levels, || format!("{armed:?} at arming, {levels:?} after"))?;
    demand(levels.a && levels.b, || format!("{levels:?}"))
}

fn edges_come_in_order<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    for _ in 0..3 {
        charge(pins, bench)?;
        let armed = pins.arm().map_err(said)?;
        let mut earliest = pins.drive(Drives::C1).map_err(said)?.before;
        for (count, edge) in (1..).zip(edges(pins, bench)?) {
            let now = pins.now();
            demand(earliest <= edge.at && edge.at <= now, || format!("{edge:?} not in {earliest} to {now}"))?;
            earliest = edge.at;
            let expected = armed.seqno.wrapping_add(count);
            demand(edge.seqno == expected, || format!("{edge:?} should have seqno {expected}"))?;
            let expected = armed.line_seqno[edge.node.index()].wrapping_add(1);
            demand(edge.line_seqno == expected, || format!("{edge:?} should have line_seqno {expected}"))?;
        }
    }
    Ok(())
}

fn discharging_lowers_levels<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    start(pins, bench)?;
    edges(pins, bench)?;
    let levels = pins.levels().map_err(said)?;
    demand(nodes(bench).iter().all(|node| !levels.of(*node)), || format!("{levels:?}"))?;
    demand(bench.node_b || levels.b, || "an absent node B reads low".to_string())
}

fn waiting_ends_at_its_time<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    charge(pins, bench)?;
    pins.arm().map_err(said)?;
    let until = pins.now() + A_WHILE;
    no_edge(pins, until)?;
    let now = pins.now();
    demand(now >= until, || format!("returned at {now}, asked to wait until {until}"))
}

fn arming_forgets<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    charge(pins, bench)?;
    let first = pins.arm().map_err(said)?;
    let end = pins.drive(Drives::C1).map_err(said)?.after + bench.discharge;
    pins.sleep_until(end).map_err(said)?;
    charge(pins, bench)?;
    let second = pins.arm().map_err(said)?;
    let until = pins.now() + A_WHILE;
    no_edge(pins, until)?;
    let count = nodes(bench).len() as u32;
    let counted = second.seqno == first.seqno.wrapping_add(count);
    demand(counted, || format!("{count} edges between {first:?} and {second:?}"))
}

fn sleeping_keeps_edges<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    let end = start(pins, bench)?.after + bench.discharge;
    pins.sleep_until(end).map_err(said)?;
    for node in nodes(bench) {
        let kept = pins.edge(end).map_err(said)?;
        demand(kept.is_some_and(|edge| edge.node == *node && edge.at < end), || {
            format!("expected the edge of node {node:?} from before {end}, got {kept:?}")
        })?;
    }
    no_edge(pins, end)
}

fn sleeping_is_never_short<P: Pins>(pins: &mut P, _: &Bench) -> Result<(), String> {
    for ahead in [-1_000_000, 0, 1_000, 50_000, 1_000_000, 5_000_000] {
        let at = pins.now() + Nanos(ahead);
        pins.sleep_until(at).map_err(said)?;
        let now = pins.now();
        demand(now >= at, || format!("woke at {now}, asked for {at}"))?;
        let at = now + Nanos(ahead);
        pins.rest_until(at).map_err(said)?;
        let now = pins.now();
        demand(now >= at, || format!("rested until {now}, asked for {at}"))?;
    }
    Ok(())
}

/// Through Rc2: before a shorter discharge there may be no time to rest.
fn resting_leaves_the_edge<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    let mut due = None;
    for _ in 0..2 {
        charge(pins, bench)?;
        pins.arm().map_err(said)?;
        let begin = pins.drive(Drives::C2).map_err(said)?.before;
        let rested = match due {
            Some(due) => pins.rest_before_edge(begin + due).map(|()| pins.now()).map_err(said)?,
            None => begin,
        };
        let first = edges(pins, bench)?.first().map_or(Nanos::ZERO, |edge| edge.at);
        demand(rested < first, || format!("rested until {rested}, the edge came at {first}"))?;
        due = Some(first - begin);
    }
    Ok(())
}

fn driving_is_idempotent<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    start(pins, bench)?;
    pins.drive(Drives::C1).map_err(said)?;
    let last = edges(pins, bench)?.last().map_or(Nanos::ZERO, |edge| edge.at);
    pins.drive(Drives::C1).map_err(said)?;
    no_edge(pins, last + bench.discharge)
}

fn switching_continues<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    let begin = start(pins, bench)?.after;
    let plain = duration(begin, &edges(pins, bench)?);
    let begin = start(pins, bench)?.after;
    pins.sleep_until(begin + Nanos(plain.0 / 4)).map_err(said)?;
    pins.drive(Drives::C2).map_err(said)?;
    let split = duration(begin, &edges(pins, bench)?);
    demand(split > plain, || format!("{split} by way of the larger Rc2, {plain} through Rc1 alone"))
}

fn duration(begin: Nanos, edges: &[Edge]) -> Nanos {
    edges.last().map_or(Nanos::ZERO, |edge| edge.at - begin)
}

fn releasing_stops<P: Pins>(pins: &mut P, bench: &Bench) -> Result<(), String> {
    let begin = start(pins, bench)?.after;
    let plain = edges(pins, bench)?.first().map_or(Nanos::ZERO, |edge| edge.at - begin);
    let begin = start(pins, bench)?.after;
    pins.sleep_until(begin + Nanos(plain.0 / 4)).map_err(said)?;
    let until = pins.drive(Drives::NONE).map_err(said)?.after + bench.discharge;
    no_edge(pins, until)?;
    let levels = pins.levels().map_err(said)?;
    demand(levels.a && levels.b, || format!("{levels:?} some time after the release"))
}
