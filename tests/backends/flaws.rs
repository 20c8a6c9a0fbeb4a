//! The contract, on a fake that keeps it and on fakes that break it in one way each.

use super::clauses::{Bench, check, clauses, dropping_releases};
use cermd::circuit::Node;
use cermd::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use cermd::units::Nanos;
use std::collections::VecDeque;

const BENCH: Bench = Bench { charge: Nanos(500_000), discharge: Nanos(10_000_000), node_b: true };
/// Rc1 and Rc2.
const OHMS: [f64; 2] = [1_000.0, 5_000.0];
/// Progress at which A and B cross, in ns/ohm.
const CROSSINGS: [f64; 2] = [1_000.0, 1_200.0];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flaw {
    None,
    BracketAhead,
    AllowsConflicts,
    NeverCharges,
    SwapsNodes,
    SkipsNumbers,
    ReadsHigh,
    GivesUpEarly,
    KeepsEdges,
    LosesEdgesInSleep,
    WakesEarly,
    RestsTooShort,
    RestsTooLong,
    RepeatsEdges,
    IgnoresSwitch,
    KeepsDriving,
}

/// A circuit by the law of progress, on a clock that each call moves by a microsecond.
struct Fake {
    flaw: Flaw,
    now: i64,
    driving: Drives,
    progress: f64,
    edges: VecDeque<Edge>,
    seqno: u32,
    line_seqno: [u32; 2],
}

impl Fake {
    fn new(flaw: Flaw) -> Fake {
        let edges = VecDeque::new();
        Fake { flaw, now: 1_000, driving: Drives::NONE, progress: 9e9, edges, seqno: 0, line_seqno: [0; 2] }
    }

    fn run_until(&mut self, until: i64) {
        let step = (until - self.now).max(0);
        let sinks = [Drives::C1, Drives::C2].into_iter().zip(OHMS);
        let rate: f64 =
            sinks.filter(|(sink, _)| self.driving.contains(*sink)).map(|(_, ohm)| 1.0 / ohm).sum();
        let from = self.progress;
        self.progress += step as f64 * rate;
        for (node, crossing) in Node::BOTH.into_iter().zip(CROSSINGS) {
            if from < crossing && crossing <= self.progress {
                self.cross(node, self.now + ((crossing - from) / rate) as i64);
            }
        }
        if self.driving.contains(Drives::CHARGE) && step >= 400_000 && self.flaw != Flaw::NeverCharges {
            self.progress = 0.0;
        }
        self.now += step;
    }

    fn cross(&mut self, node: Node, at: i64) {
        let node = if self.flaw == Flaw::SwapsNodes { Node::BOTH[1 - node.index()] } else { node };
        self.seqno += if self.flaw == Flaw::SkipsNumbers { 2 } else { 1 };
        self.line_seqno[node.index()] += 1;
        let line_seqno = self.line_seqno[node.index()];
        self.edges.push_back(Edge { node, at: Nanos(at), seqno: self.seqno, line_seqno });
    }

    fn tick(&mut self) -> i64 {
        self.run_until(self.now + 1_000);
        self.now
    }
}

impl Pins for Fake {
    fn now(&mut self) -> Nanos {
        Nanos(self.tick())
    }

    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        if on.conflicts() && self.flaw != Flaw::AllowsConflicts {
            return Err(PinsError::Conflict(on));
        }
        if on == self.driving && self.flaw == Flaw::RepeatsEdges && self.progress > CROSSINGS[1] {
            self.cross(Node::B, self.now);
        }
        let before = Nanos(self.tick());
        let stuck = match self.flaw {
            Flaw::KeepsDriving => on.is_none() && self.driving == Drives::C1 && self.progress < CROSSINGS[0],
            Flaw::IgnoresSwitch => on == Drives::C2 && self.driving == Drives::C1,
            _ => false,
        };
        if !stuck {
            self.driving = on;
        }
        let after = Nanos(self.tick() + if self.flaw == Flaw::BracketAhead { 1_500 } else { 0 });
        Ok(Bracket { before, after })
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.tick();
        if self.flaw != Flaw::KeepsEdges {
            self.edges.clear();
        }
        Ok(Armed { levels: self.levels()?, seqno: self.seqno, line_seqno: self.line_seqno })
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        if self.flaw == Flaw::GivesUpEarly && self.driving.is_none() {
            return Ok(None);
        }
        if self.edges.is_empty() {
            self.run_until(until.0);
        }
        let edge = self.edges.pop_front();
        self.now = self.now.max(edge.map_or(0, |edge| edge.at.0));
        Ok(edge)
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.run_until(at.0 - if self.flaw == Flaw::WakesEarly { 10_000 } else { 0 });
        if self.flaw == Flaw::LosesEdgesInSleep && self.driving == Drives::C1 {
            self.edges.clear();
        }
        Ok(())
    }

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(if self.flaw == Flaw::RestsTooShort { at - Nanos(10_000) } else { at })
    }

    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        let before = Nanos(if self.flaw == Flaw::RestsTooLong { 0 } else { 500_000 });
        self.sleep_until(at - before)
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        let high = |node: Node| self.flaw == Flaw::ReadsHigh || self.progress < CROSSINGS[node.index()];
        Ok(Levels { a: high(Node::A), b: high(Node::B) })
    }

    fn particulars(&self) -> Particulars<'_> {
        Particulars::default()
    }
}

fn broken(flaw: Flaw) -> Vec<&'static str> {
    let outcomes = check(&mut Fake::new(flaw), &BENCH);
    outcomes.into_iter().filter(|(_, outcome)| outcome.is_err()).map(|(name, _)| name).collect()
}

#[test]
fn a_faithful_backend_keeps_every_clause() {
    for (name, outcome) in check(&mut Fake::new(Flaw::None), &BENCH) {
        assert_eq!(outcome, Ok(()), "{name}");
    }
}

#[test]
fn every_clause_is_broken_by_some_flaw() {
    let flaws = [
        (Flaw::BracketAhead, "time never goes back, and calls lie within their brackets"),
        (Flaw::AllowsConflicts, "a charger against a sink is refused, and nothing changes"),
        (Flaw::NeverCharges, "all sense lines are high after a charge"),
        (Flaw::SwapsNodes, "a discharge gives one numbered edge a node, A before B"),
        (Flaw::SkipsNumbers, "a discharge gives one numbered edge a node, A before B"),
        (Flaw::ReadsHigh, "all sense lines are low after a discharge"),
        (Flaw::GivesUpEarly, "waiting for an edge ends without one, and not early"),
        (Flaw::KeepsEdges, "arming forgets the edges before it, but not their numbers"),
        (Flaw::LosesEdgesInSleep, "edges that come during a sleep are kept"),
        (Flaw::WakesEarly, "a sleep or a rest never ends early"),
        (Flaw::RestsTooShort, "a sleep or a rest never ends early"),
        (Flaw::RestsTooLong, "a rest before an edge ends before it, and leaves it"),
        (Flaw::RepeatsEdges, "driving what drives already changes nothing"),
        (Flaw::IgnoresSwitch, "a discharge goes on when another resistor takes over"),
        (Flaw::KeepsDriving, "when nothing is to drive, nothing drives"),
    ];
    for (flaw, name) in flaws {
        assert!(broken(flaw).contains(&name), "{flaw:?} breaks only {:?}", broken(flaw));
    }
    let demanded = clauses::<Fake>().map(|(name, _)| name);
    assert!(demanded.iter().all(|name| flaws.iter().any(|(_, broken)| broken == name)));
}

#[test]
fn a_drop_that_leaves_a_sink_on_is_noticed() {
    /// A circuit that outlives its backends, which may forget to release.
    struct Held<'a>(&'a std::cell::RefCell<Fake>, bool);
    impl Drop for Held<'_> {
        fn drop(&mut self) {
            if self.1 {
                self.0.borrow_mut().driving = Drives::NONE;
            }
        }
    }
    impl Pins for Held<'_> {
        fn now(&mut self) -> Nanos {
            self.0.borrow_mut().now()
        }
        fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
            self.0.borrow_mut().drive(on)
        }
        fn arm(&mut self) -> Result<Armed, PinsError> {
            self.0.borrow_mut().arm()
        }
        fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
            self.0.borrow_mut().edge(until)
        }
        fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
            self.0.borrow_mut().sleep_until(at)
        }
        fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
            self.0.borrow_mut().rest_until(at)
        }
        fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
            self.0.borrow_mut().rest_before_edge(at)
        }
        fn levels(&mut self) -> Result<Levels, PinsError> {
            self.0.borrow_mut().levels()
        }
        fn particulars(&self) -> Particulars<'_> {
            Particulars::default()
        }
    }
    for releases in [true, false] {
        let circuit = std::cell::RefCell::new(Fake::new(Flaw::None));
        let held = dropping_releases(|| Ok::<_, PinsError>(Held(&circuit, releases)), &BENCH);
        assert_eq!(held.is_ok(), releases, "{held:?}");
    }
}
