//! Every plan against everything that can happen to it: no two outputs ever oppose each other, and every line ends as an
//! input.
//!
//! What can happen is a tree. At each call the pins answer in one of several ways (levels, edges, a call that takes long) or
//! it fails, is interrupted, or the program dies in it; a call that switches several lines does so one by one, as every
//! backend does (tests/backends/clauses.rs), and may end after any of them. The tree is walked leaf by leaf, with one
//! mishap at most on each way.

use super::*;
use crate::circuit::Kind;
use crate::config_file::config;
use crate::instrument::cycle::{Cycle, Next};
use crate::pins::sim::{Scene, SimPins};
use crate::pins::{Particulars, Pins, PinsError};
use crate::reading::Method;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// A way down the tree: at each fork, which branch of how many.
#[derive(Default)]
struct Branches {
    forks: Vec<(usize, usize)>,
    at: usize,
}

impl Branches {
    fn choose(&mut self, of: usize) -> usize {
        if self.at == self.forks.len() {
            self.forks.push((0, of));
        }
        self.at += 1;
        self.forks[self.at - 1].0
    }

    /// On to the next leaf; `false`: that was the last.
    fn advance(&mut self) -> bool {
        self.at = 0;
        while let Some((branch, of)) = self.forks.pop() {
            if branch + 1 < of {
                self.forks.push((branch + 1, of));
                return true;
            }
        }
        false
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Mishap {
    Failed,
    /// By a panic, which unwinds.
    Interrupted,
    /// Nothing of the program runs any more.
    Died,
}

/// Edges before nothing more comes.
const MOST_EDGES: u32 = 3;
const CALL: Nanos = Nanos(10);
const WIDEST: Nanos = Nanos(100);

struct Adversary<'a> {
    way: &'a mut Branches,
    on: Drives,
    now: Nanos,
    armed: bool,
    edges: u32,
    line_seqno: [u32; 2],
    mishap: Option<Mishap>,
    conflicts: u64,
    /// Drives before it releases, as no backend may.
    is_flawed: bool,
}

impl Adversary<'_> {
    fn new(way: &mut Branches, on: Drives) -> Adversary<'_> {
        Adversary {
            way,
            on,
            now: Nanos::ZERO,
            armed: false,
            edges: 0,
            line_seqno: [0; 2],
            mishap: None,
            conflicts: 0,
            is_flawed: false,
        }
    }

    /// A call that switches these lines one by one, or none.
    fn call(&mut self, lines: &[Drives]) -> Result<(), PinsError> {
        if self.mishap == Some(Mishap::Died) {
            return Err(PinsError::Stopped);
        }
        self.now = self.now + CALL;
        // After none, one, .. or all of the lines.
        let ends = 3 * (lines.len() + 1);
        let end = if self.mishap.is_none() { self.way.choose(1 + ends) } else { 0 };
        let reached = if end == 0 { lines.len() } else { (end - 1) / 3 };
        for line in &lines[..reached] {
            let is_release = self.on.contains(*line);
            self.on = if is_release { self.on.without(*line) } else { self.on.and(*line) };
            self.conflicts += u64::from(self.on.conflicts());
        }
        self.mishap = match end.checked_sub(1).map(|end| end % 3) {
            None => return Ok(()),
            Some(0) => Some(Mishap::Failed),
            Some(1) => Some(Mishap::Interrupted),
            Some(_) => Some(Mishap::Died),
        };
        match self.mishap {
            // Without the words of a panic that nobody expects.
            Some(Mishap::Interrupted) => resume_unwind(Box::new(())),
            // Whatever a dead program does from here on has no effect.
            _ => Err(PinsError::Stopped),
        }
    }
}

impl Pins for Adversary<'_> {
    fn now(&mut self) -> Nanos {
        self.now
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.conflicts += u64::from(on.conflicts());
        let (releases, drives) = (self.on.without(on), on.without(self.on));
        let mut lines: Vec<Drives> = releases.lines().chain(drives.lines()).collect();
        if self.is_flawed {
            lines.reverse();
        }
        let before = self.now;
        self.call(&lines)?;
        // How long it takes counts from the start on.
        if self.armed && self.mishap.is_none() && self.way.choose(2) == 1 {
            self.now = self.now + WIDEST;
        }
        Ok(Bracket { before, after: self.now })
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.call(&[])?;
        self.armed = true;
        let high = self.way.choose(2) == 0;
        Ok(Armed { levels: Levels { a: high, b: high }, seqno: 0, line_seqno: [0; 2] })
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.call(&[])?;
        let kinds = if self.edges < MOST_EDGES { 4 } else { 1 };
        let node = match self.way.choose(kinds) {
            0 => {
                self.now = self.now.max(until);
                return Ok(None);
            }
            2 => Node::B,
            kind => {
                // One before it was lost.
                self.line_seqno[0] += u32::from(kind == 3);
                Node::A
            }
        };
        self.edges += 1;
        self.line_seqno[node.index()] += 1;
        let line_seqno = self.line_seqno[node.index()];
        Ok(Some(Edge { node, at: self.now, seqno: self.edges, line_seqno }))
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.call(&[])?;
        self.now = self.now.max(at);
        Ok(())
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.call(&[])?;
        let high = self.way.choose(2) == 0;
        Ok(Levels { a: high, b: high })
    }
    fn particulars(&self) -> Particulars<'_> {
        Particulars::default()
    }
}

/// Each combination of what a plan can have.
fn plans() -> Vec<Plan> {
    let through = [0, 15].map(Through::X).into_iter();
    let through = through.chain([Through::C1, Through::C2, Through::C12, Through::XWithC12(0)]);
    let to = [None, Some(Through::C1), Some(Through::C2), Some(Through::C12), Some(Through::X(0))];
    let limits = [None, Some(Through::C1), Some(Through::C2)];
    let time = Nanos(1000);
    let charges = [Charge::alone(time), Charge::together(time), Charge { alone: time, together: time }];
    let boards = [(Drives::CHARGE, Node::B), (Drives::CHARGE, Node::A), (Drives::CHARGE_A, Node::A)];
    let with =
        |plan: Plan, (chargers, last), to: Option<Through>, limit, [hold, drain, settle]: [Nanos; 3]| Plan {
            switch: to.map(|to| (Nanos(500), to)),
            expected: [Some(Nanos(300)), Some(Nanos(600))],
            widest_bracket: WIDEST,
            ..Plan { chargers, last, limit, hold, drain, settle, ..plan }
        };
    let mut plans = Vec::new();
    for (through, charge) in through.flat_map(|through| charges.map(|charge| (through, charge))) {
        let plan = Plan::full(through, Node::B, charge, Nanos(5000));
        for (to, limit) in to.iter().flat_map(|to| limits.map(|limit| (*to, limit))) {
            for (board, waits) in boards.iter().flat_map(|board| (0..8).map(|waits| (*board, waits))) {
                let waits = [1, 2, 4].map(|bit| if waits & bit > 0 { time } else { Nanos::ZERO });
                plans.push(with(plan, board, to, limit, waits));
            }
        }
    }
    plans
}

/// What was seen on the way to one leaf.
struct Leaf {
    mishap: Option<Mishap>,
    /// What drives at the end, or when the program died.
    on: Drives,
    conflicts: u64,
}

fn walk(plan: Plan, on: Drives, way: &mut Branches, is_flawed: bool) -> Leaf {
    let mut board = Adversary { is_flawed, ..Adversary::new(way, on) };
    let outcome = catch_unwind(AssertUnwindSafe(|| run(&mut board, plan).map(drop)));
    let is_whole = matches!(outcome, Ok(Ok(())));
    assert_eq!(is_whole, board.mishap.is_none(), "a mishap is told, and only that");
    Leaf { mishap: board.mishap, on: board.on, conflicts: board.conflicts }
}

#[test]
fn whatever_happens_no_outputs_oppose_each_other_and_every_line_ends_as_an_input() {
    let plans = plans();
    let (mut leaves, mut conflicts, mut left_driving) = ([0u64; 4], 0, 0u64);
    let mut left_by_the_dead = HashSet::from([Drives::NONE]);
    for plan in &plans {
        let mut way = Branches::default();
        loop {
            let leaf = walk(*plan, Drives::NONE, &mut way, false);
            leaves[leaf.mishap.map_or(0, |mishap| 1 + mishap as usize)] += 1;
            conflicts += leaf.conflicts;
            match leaf.mishap {
                Some(Mishap::Died) => drop(left_by_the_dead.insert(leaf.on)),
                _ => left_driving += u64::from(!leaf.on.is_none()),
            }
            if !way.advance() {
                break;
            }
        }
    }
    // The next life: after the cleaner, which makes inputs of lines one by one, or without it, from what the kernel has left
    // driving.
    let mut next_lives = 0;
    for on in &left_by_the_dead {
        let mut rest = *on;
        for line in on.lines() {
            rest = rest.without(line);
            conflicts += u64::from(rest.conflicts());
        }
        left_driving += u64::from(!rest.is_none());
        for plan in &plans {
            let leaf = walk(*plan, *on, &mut Branches::default(), false);
            next_lives += 1;
            conflicts += leaf.conflicts;
            left_driving += u64::from(!leaf.on.is_none());
        }
    }
    let [sound, failed, interrupted, died] = leaves;
    println!(
        "{} plans: {sound} ways without a mishap, {failed} failures, {interrupted} interruptions, {died} deaths, \
         {} states left by them, {next_lives} next lives: {conflicts} conflicts, {left_driving} times a line left driving",
        plans.len(),
        left_by_the_dead.len()
    );
    assert!(leaves.iter().all(|count| *count > 100_000) && left_by_the_dead.len() > 8);
    assert_eq!((conflicts, left_driving), (0, 0));
}

#[test]
fn the_walk_sees_lines_that_are_made_before_others_are_broken() {
    let plan = plans().into_iter().find(|plan| plan.drain > Nanos::ZERO).unwrap();
    assert!(walk(plan, Drives::NONE, &mut Branches::default(), true).conflicts > 0);
    assert_eq!(walk(plan, Drives::NONE, &mut Branches::default(), false).conflicts, 0);
}

/// What of a plan decides which lines switch in which order.
fn shape(plan: &Plan) -> String {
    let of_any_channel = |through: Through| match through {
        Through::X(_) => Through::X(0),
        Through::XWithC12(_) => Through::XWithC12(0),
        other => other,
    };
    let waits = [plan.hold, plan.drain, plan.settle, plan.charge.alone, plan.charge.together];
    let (through, to) = (of_any_channel(plan.through), plan.switch.map(|(_, to)| of_any_channel(to)));
    let (waits, limit) = (waits.map(|wait| wait > Nanos::ZERO), plan.limit.map(of_any_channel));
    format!("{through:?} {to:?} {limit:?} {waits:?} {} {:?}", plan.chargers, plan.last)
}

#[test]
fn every_plan_of_the_instrument_is_among_them() {
    const DISCHARGES: usize = 300;
    let walked: HashSet<String> = plans().iter().map(shape).collect();
    let mut made = HashSet::new();
    for kind in [Kind::TwoCapacitor, Kind::OneCapacitor, Kind::SeriesCalibration] {
        for method in Method::ALL.into_iter().filter(|method| method.rules().circuits.contains(&kind)) {
            let config = config(|c| {
                let c = match kind {
                    Kind::TwoCapacitor => c,
                    _ => c.one_capacitor(kind.as_str(), "470 nF"),
                };
                c.set("circuit.v-th", "1.1 V")
                    .set("measure.method", method.as_str())
                    .channel("x")
                    .channel("y")
            });
            let scene = Scene::builtin("pi4").unwrap().with_kind(kind).unwrap();
            let (mut pins, mut lead) = (SimPins::new(&scene, None), Lead::default());
            let (mut cycle, mut discharges) = (Cycle::new(config.parse().settings().unwrap()), 0);
            while discharges < DISCHARGES {
                if let Next::Discharge(plan) = cycle.next(pins.now()) {
                    discharges += 1;
                    made.insert(shape(&plan));
                    let outcome = run_on(&mut pins, plan, &mut lead).unwrap();
                    cycle.done(&outcome, pins.now());
                }
            }
        }
    }
    let strange: Vec<&String> = made.difference(&walked).collect();
    println!("{} shapes of {} are made by the instrument", made.len(), walked.len());
    assert!(made.len() > 10 && strange.is_empty(), "not walked through: {strange:#?}");
}
