//! Tapes of a generator of its own: nothing of the crate's circuit, simulation or estimators is in it, and what these share by
//! mistake shows here. The crate only reads them.
//!
//! [`network`] integrates the circuit, [`board`] draws one at random and stamps its crossings, [`variants`] says what is
//! wrong with it; here a daemon's order of discharges is written down, those by which it looks for that included.

mod board;
mod network;
mod variants;

use super::{Seen, Trial, each, judge};
use board::{Board, DEADLINE_S, Path, R_C2, SECOND_S, Then, Timed, Way, Wiring};
use cermd::ctl::replay::Replay;
use cermd::reading::Method;
use cermd::tape::Reader;
use network::Load;
use serde_json::{Value, json};
use variants::{VARIANTS, Variant};

/// Between the calls that release and sink.
const PAUSE_S: f64 = 1150e-9;
const BOARDS: u64 = 45;
/// So many estimates of each tape count: the last ones.
const COUNTED: usize = 20;
/// The cycle from which on a daemon has followed its calibration for long enough, and that by which one that finds its offset has.
const STATE_FROM: usize = 48;
const OFFSET_FROM: usize = 64;
/// How well a plan knows a crossing, s.
const JITTER_S: f64 = 2e-6;
/// By which part of it a discharge moves what is usual, and beyond how many sigma from that one is refused.
const USUAL_STEP: f64 = 0.125;
const REFUSED: f64 = 4.0;
/// A sensor below this is released for Rc2 and needs no more than node A; one above that is finished through Rc1, ohm. What
/// pays for `tracked` is Rc2 up to its own resistance, since stamps weigh less there.
const RELEASED_BELOW: f64 = 2320.0;
const FINISHED_ABOVE: f64 = 20_000.0;

/// Looks for leaks: after which parts of Rc2's time they are held, in their order, and for how long.
const LEAK_HELD_AT: [f64; 8] = [0.6, 0.6, 0.1, 0.1, 0.6, 0.1, 0.6, 0.1];
const LEAK_HOLD_S: f64 = 40e-3;
/// Those that wait for node B, too, once the first ones have shown a leak: as many.
const LEAK_HELD_TO_B_AT: [f64; 8] = [0.6, 0.1, 0.6, 0.1, 0.6, 0.1, 0.6, 0.1];
/// Looks for absorption: how many after those for leaks, and the rest before them.
const ABSORPTION_LOOKS: usize = 16;
const ABSORPTION_REST_S: f64 = 20e-3;
/// Wakes beside the calibration discharges, and how long before its crossing a discharge has one.
const WAKES: usize = 20;
const WAKES_BEFORE_S: f64 = 100e-6 + 6.0 * JITTER_S;
/// Of those that follow a calibration, so many plain discharges in a row have wakes, and so many splits switch late.
const WAKES_IN_ROW: usize = 40;
const LATE_IN_ROW: usize = 6;

/// A tape that is written.
struct Tape<'a> {
    board: Board<'a>,
    method: Method,
    r_x: f64,
    lines: Vec<String>,
    /// Ro as the daemon has found it at first, ohm.
    r_o: f64,
    /// When A crosses in plain discharges through R_1 and R_2, s.
    usual: [f64; 2],
    leak_looks: usize,
    absorption_looks: usize,
}

impl<'a> Tape<'a> {
    fn new(number: u64, variant: &'a Variant, method: Method, r_x: f64) -> Tape<'a> {
        let wiring = if method == Method::Qerm { Wiring::Series } else { variant.wiring };
        let kind = match wiring {
            Wiring::Two => "two-capacitor",
            Wiring::One => "one-capacitor",
            Wiring::Series => "series-calibration",
        };
        let circuit = json!({ "kind": kind, "r_c1_ohm": variant.r_c1, "r_c2_ohm": R_C2 });
        let mut header = json!({ "class": "TAPE", "proto_major": 1, "circuit": circuit, "channels": [{ "id": "x", "zero_ohm": 0, "scale": 1 }] });
        if let Some(clock) = variant.clock.filter(|clock| clock.is_told) {
            header["resolution_ns"] = clock.period_ns.into();
        }
        let board = Board::new(number, variant, wiring, r_x);
        let lines = vec![header.to_string()];
        Tape {
            r_o: board.r_o(),
            board,
            method,
            r_x,
            lines,
            usual: [0.0; 2],
            leak_looks: 0,
            absorption_looks: 0,
        }
    }

    fn write(mut self) -> String {
        for cycle in 0..self.board.variant.cycles {
            self.calibrate(cycle);
            if self.board.variant.looks && cycle == 0 {
                self.look_for_leak();
            }
            self.read(cycle);
            if self.board.variant.looks {
                self.look(cycle);
            }
        }
        self.lines.join("\n")
    }

    /// Whether the daemon follows the calibration by now, and plans by what it knows.
    fn follows(&self, cycle: usize) -> bool {
        self.method == Method::Tracked && self.board.variant.looks && cycle >= STATE_FROM
    }

    /// The node that ends a discharge: that which tells the method enough.
    fn last(&self, cycle: usize) -> usize {
        let needs_a = match self.method {
            Method::Tpcm => true,
            _ => self.follows(cycle) && self.r_x < RELEASED_BELOW,
        };
        usize::from(self.board.wiring == Wiring::Two && !needs_a)
    }

    fn way(&self, cycle: usize, first: Path, then: Option<Then>) -> Way {
        Way { first, then, last: self.last(cycle), rest: 0.0 }
    }

    /// What A's crossing takes for each ohm, by the tape so far, s.
    fn per_ohm(&self) -> f64 {
        let ([r1, r2], [first, second]) = (self.board.known_ohm(), self.usual);
        (second - first) / (r2 - r1)
    }

    fn calibrate(&mut self, cycle: usize) {
        let since = cycle.saturating_sub(STATE_FROM);
        let wakes = self.follows(cycle) && (since < WAKES_IN_ROW || since % 2 == 1);
        for (index, path) in [Path::C1, Path::C2].into_iter().enumerate() {
            let then = if wakes { self.wake(index) } else { None };
            let woken = then.map(|then| self.add(&self.way(cycle, path, Some(then)), false));
            // What contradicts those before it is asked once more, without a wake.
            if woken.is_none_or(|timed| self.is_far(index, &timed)) {
                let timed = self.add(&self.way(cycle, path, None), false);
                self.learn(index, &timed);
            }
        }
        if self.method == Method::Tpcm {
            return;
        }
        let [r1, _] = self.board.known_ohm();
        let late = 0.98 * self.per_ohm() * (r1 + self.r_o) - JITTER_S;
        let is_late = self.follows(cycle) && (since < LATE_IN_ROW || since % 2 == 1);
        let at = if is_late { late } else { 0.9 * self.per_ohm() * r1 };
        let split = self.way(cycle, Path::C1, Some(switched(at, Path::C2)));
        self.add(&split, false);
    }

    fn learn(&mut self, index: usize, timed: &Timed) {
        let Some(stamp) = timed.stamps[0] else { return };
        let usual = &mut self.usual[index];
        *usual += if *usual > 0.0 { USUAL_STEP * (stamp - *usual) } else { stamp };
    }

    /// Whether a filter would refuse it.
    fn is_far(&self, index: usize, timed: &Timed) -> bool {
        timed.stamps[0].is_none_or(|stamp| (stamp - self.usual[index]).abs() > REFUSED * timed.sigma)
    }

    /// The discharge of the sensor, switched as soon as the daemon knows what it needs for that.
    fn read(&mut self, cycle: usize) {
        let knows = !self.board.variant.looks
            || match self.method {
                Method::Tracked => cycle >= STATE_FROM,
                _ => cycle >= OFFSET_FROM,
            };
        let due = self.per_ohm() * (self.r_x + self.r_o);
        let is_tracked = self.method == Method::Tracked && !self.board.variant.to_end;
        let released_below = if is_tracked { R_C2 } else { RELEASED_BELOW };
        let then = match self.method {
            Method::Tracked if knows && self.r_x > FINISHED_ABOVE => Some(switched(0.8 * due, Path::C1)),
            Method::Tracked | Method::Cerm if knows && self.r_x < released_below => {
                Some(switched(0.9 * due, Path::C2))
            }
            Method::Qerm if knows && self.r_x < RELEASED_BELOW => {
                let together = 1.0 / (1.0 / due + 1.0 / self.usual[1]);
                let at = to_ns(0.9 * together);
                Some(Then { at, on: at, to: Path::C2 })
            }
            _ => None,
        };
        let first = if self.method == Method::Qerm { Path::Beside } else { Path::X };
        self.add(&self.way(cycle, first, then), false);
    }

    /// What the daemon does where no reading waits for it.
    fn look(&mut self, cycle: usize) {
        if self.leak_looks < self.due_looks() {
            self.look_for_leak();
        } else if self.absorption_looks < ABSORPTION_LOOKS {
            self.absorption_looks += 1;
            let way = Way { first: Path::C2, then: None, last: 0, rest: ABSORPTION_REST_S };
            self.add(&way, true);
        }
        if self.method != Method::Tracked && cycle < WAKES {
            let first = [Path::C1, Path::C2][cycle % 2];
            let then = self.wake(cycle % 2);
            self.add(&Way { first, then, last: 0, rest: 0.0 }, true);
        }
    }

    /// How many held discharges the daemon wants at once.
    fn due_looks(&self) -> usize {
        let Variant { beside, .. } = self.board.variant;
        let asks_for_b = self.last(0) == 1 && beside.iter().any(|load| *load != Load::NONE);
        LEAK_HELD_AT.len() + if asks_for_b { LEAK_HELD_TO_B_AT.len() } else { 0 }
    }

    fn look_for_leak(&mut self) {
        let held_at = LEAK_HELD_AT.iter().chain(&LEAK_HELD_TO_B_AT).nth(self.leak_looks);
        let at = to_ns(held_at.unwrap() * self.usual[1]);
        let last = usize::from(self.leak_looks >= LEAK_HELD_AT.len());
        self.leak_looks += 1;
        let then = Some(Then { at, on: at + LEAK_HOLD_S, to: Path::C2 });
        self.add(&Way { first: Path::C2, then, last, rest: 0.0 }, true);
        // What leaks at B is nothing that a charge may remember.
        let [_, at_b] = self.board.variant.beside;
        self.board.charges_anew |= last == 1 && self.leak_looks == self.due_looks() && at_b != Load::NONE;
    }

    /// The program wakes before a plain discharge ends.
    fn wake(&self, index: usize) -> Option<Then> {
        let at = to_ns(self.usual[index] - WAKES_BEFORE_S);
        (at > 0.0).then_some(Then { at, on: at, to: [Path::C1, Path::C2][index] })
    }

    /// Takes a discharge; its line.
    fn add(&mut self, way: &Way, is_held: bool) -> Timed {
        let timed = self.board.discharge(way);
        let Variant { has_t, told_ns, .. } = *self.board.variant;
        let ns = |seconds: f64| (seconds * 1e9).round();
        let through = self.name(way.first);
        let mut line = json!({ "class": "DISCHARGE", "seq": self.lines.len(), "through": through });
        for (key, stamp) in ["a_ns", "b_ns"].into_iter().zip(timed.stamps) {
            if let Some(stamp) = stamp {
                line[key] = ns(stamp).into();
            }
        }
        if timed.stamps[way.last].is_none() {
            line["waited_ns"] = ns(DEADLINE_S).into();
        }
        if matches!(way.first, Path::X | Path::Beside) {
            line["channel"] = "x".into();
        }
        if way.first == Path::Beside {
            line["second_ns"] = ns(SECOND_S).into();
        }
        if has_t {
            line["t_ns"] = timed.start_ns.into();
        }
        if is_held {
            line["held"] = true.into();
        }
        if let Some(then) = way.then.filter(|_| timed.is_switched) {
            line["switch"] = json!({ "at_ns": ns(then.at), "on_ns": ns(then.on), "to": self.name(then.to) });
            if let Some(told_ns) = told_ns {
                line["switch"]["u_ns"] = told_ns.into();
            }
        }
        self.lines.push(line.to_string());
        timed
    }

    fn name(&self, path: Path) -> &'static str {
        match path {
            Path::C1 => "c1",
            Path::C2 if self.board.wiring == Wiring::Series => "c12",
            Path::C2 => "c2",
            Path::X => "x",
            Path::Beside => "x+c12",
        }
    }
}

/// One resistor released, the next one sunk after it.
fn switched(at: f64, to: Path) -> Then {
    let at = to_ns(at);
    Then { at, on: at + PAUSE_S, to }
}

/// An instant that a tape can have.
fn to_ns(seconds: f64) -> f64 {
    (seconds * 1e9).round() * 1e-9
}

fn run(variant: &Variant, method: Method, r_x: f64) -> Seen {
    let mut seen = Seen::default();
    for number in 0..BOARDS {
        let tape = Tape::new(number, variant, method, r_x).write();
        let reader = Reader::open(tape.as_bytes()).unwrap();
        let mut replay = Replay::new(reader.header(), method, None).unwrap();
        let estimates: Vec<_> = reader.filter_map(|entry| replay.take(&entry.unwrap())).collect();
        assert_eq!(estimates.len(), variant.cycles);
        seen.errors.next_board();
        let skipped = if variant.from_first { 0 } else { estimates.len() - COUNTED };
        for estimate in &estimates[skipped..] {
            let line = serde_json::to_value(estimate).unwrap();
            seen.readings += 1;
            take(&line, r_x, &mut seen);
        }
    }
    seen
}

fn take(line: &Value, r_x: f64, seen: &mut Seen) {
    match (line["r_ohm"].as_f64(), line["r_u_ohm"].as_f64()) {
        (Some(r_ohm), Some(u)) => {
            seen.errors.errors.push(r_ohm - r_x);
            seen.errors.us.push(u);
            let is_wild =
                (r_ohm - r_x).abs() > 10.0 * u && line["moving"] != true && line["settling"] != true;
            seen.errors.wild += usize::from(is_wild);
        }
        (Some(_), None) => seen.errors.without_u += 1,
        _ => seen.errors.not_ok.push(name_of(line)),
    }
}

/// Of what is no number.
fn name_of(line: &Value) -> &'static str {
    use cermd::reading::Fault;
    let name = line["fault"].as_str();
    Fault::ALL.iter().map(|fault| fault.as_str()).find(|fault| name == Some(fault)).unwrap_or("short")
}

#[test]
fn hostile_tapes() {
    let trials = VARIANTS.iter().flat_map(|variant| {
        each(variant.cases).map(move |(method, r_ohm)| Trial {
            name: variant.name,
            method,
            r_ohm,
            fails: variant.fails.contains(&(method, r_ohm)),
            least_numbers: variant.least_numbers,
            wild: variant.wild,
            run: move || run(variant, method, r_ohm),
        })
    });
    judge("tapes of an independent law", trials);
}
