//! Against scripted pins: what is asked of them, in which order, and what is made of their answers.

use super::*;
use crate::instrument::limits::TICK_LASTS;
use crate::pins::{Particulars, Pins, PinsError};
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Calls take `call_ns` for a line and half of that for every further one; edges come as scripted.
struct Script {
    now: i64,
    call_ns: i64,
    on: Drives,
    edges: VecDeque<Edge>,
    levels: Levels,
    log: Vec<String>,
    fail_at: Option<&'static str>,
    panic_at: Option<&'static str>,
}

impl Script {
    /// Edges at these instants after the start: (node, ns, seqno, line_seqno).
    fn new(edges: &[(Node, i64, u32, u32)]) -> Script {
        let edges = edges
            .iter()
            .map(|(node, at, seqno, line_seqno)| Edge {
                node: *node,
                at: Nanos(START_BEFORE + 500 + at),
                seqno: *seqno,
                line_seqno: *line_seqno,
            })
            .collect();
        let high = Levels { a: true, b: true };
        Script {
            now: 0,
            call_ns: 1000,
            on: Drives::NONE,
            edges,
            levels: high,
            log: vec![],
            fail_at: None,
            panic_at: None,
        }
    }

    fn call(&mut self, name: String) -> Result<(), PinsError> {
        let is_at = |at: Option<&str>| at.is_some_and(|at| name.starts_with(at));
        if is_at(self.panic_at.take_if(|at| name.starts_with(*at))) {
            panic!("as scripted");
        }
        let fails = is_at(self.fail_at.take_if(|at| name.starts_with(*at)));
        self.log.push(name);
        if fails { Err(PinsError::Unwired(Drives::NONE)) } else { Ok(()) }
    }
}

impl Pins for Script {
    fn now(&mut self) -> Nanos {
        Nanos(self.now)
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.call(format!("drive {on}"))?;
        let lines = self.on.without(on).count() + on.without(self.on).count();
        self.on = on;
        let before = Nanos(self.now);
        self.now += self.call_ns * i64::from(lines + 1) / 2;
        Ok(Bracket { before, after: Nanos(self.now) })
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.call("arm".to_owned())?;
        assert_eq!(self.now, START_BEFORE - 100_000);
        Ok(Armed { levels: self.levels, seqno: 10, line_seqno: [4, u32::MAX] })
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.call("edge".to_owned())?;
        let edge = self.edges.pop_front();
        self.now = self.now.max(edge.map_or(until.0, |edge| edge.at.0));
        Ok(edge)
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.call(format!("sleep {}", at.0))?;
        self.now = self.now.max(at.0);
        Ok(())
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.call(format!("rest before {}", at.0))
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.call("levels".to_owned())?;
        Ok(self.levels)
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }
    fn particulars(&self) -> Particulars<'_> {
        Particulars::default()
    }
}

/// Two chargers on (1.5 us), 1 ms of charge, two off, 100 us of settling.
const START_BEFORE: i64 = 1500 + 1_000_000 + 1500 + 100_000;
/// Levels are read so long before a timed call.
const LEAD: i64 = 7000;
const A: (Node, i64, u32, u32) = (Node::A, 50_000, 11, 5);
const B: (Node, i64, u32, u32) = (Node::B, 60_000, 12, 0);

fn plan(switch: Option<(Nanos, Through)>) -> Plan {
    Plan {
        switch,
        settle: Nanos(100_000),
        widest_bracket: Nanos(3000),
        ..Plan::full(Through::X(2), Node::B, Charge::together(Nanos(1_000_000)), Nanos(5_000_000))
    }
}

#[test]
fn a_full_discharge_is_charged_armed_settled_started_and_stopped() {
    let mut pins = Script::new(&[A, B]);
    let record = run(&mut pins, plan(None)).unwrap().result.unwrap();
    // The line moves in the middle of a call for one line, 500 ns after its entry.
    assert_eq!((record.a_ns, record.b_ns), (Some(50_000.0), Some(60_000.0)));
    assert_eq!((record.start, record.switch, record.waited_ns), (Nanos(START_BEFORE), None, None));
    let expected = "drive charge-a+charge-b|sleep 1001500|drive none|arm|sleep 1096000|levels|sleep 1103000|drive x2|edge|edge|drive none";
    assert_eq!(pins.log.join("|"), expected);
}

#[test]
fn of_many_discharges_each_is_released_by_the_next_charge() {
    let mut pins = Script::new(&[A, B]);
    assert!(run_on(&mut pins, plan(None), &mut Lead::default()).unwrap().result.is_ok());
    assert_eq!(pins.on, Drives::x(2));
    // Three lines are switched at first, one more than from rest.
    pins.now = -500;
    pins.levels = Levels { a: true, b: false };
    assert_eq!(run_on(&mut pins, plan(None), &mut Lead::default()).unwrap().result, Err(Fault::NoCharge));
    assert!(pins.log.join("|").contains("edge|edge|drive charge-a+charge-b"));
    assert_eq!(pins.on, Drives::NONE, "after a fault nothing sinks");
}

#[test]
fn a_planned_switch_is_timed_by_the_entries_of_the_calls() {
    let mut pins = Script::new(&[A, B]);
    let record = run(&mut pins, plan(Some((Nanos(40_000), Through::C2)))).unwrap().result.unwrap();
    // 1 us for a call that switches a line: the next resistor is sunk after the first has been released.
    assert_eq!(record.switch, Some(Switch { at_ns: 40_000.0, on_ns: 41_000.0, to: Through::C2 }));
    let (log, at) = (pins.log.join("|"), START_BEFORE + 40_000);
    assert!(
        log.contains(&format!("drive x2|sleep {}|levels|sleep {at}|drive none|drive c2|edge", at - LEAD)),
        "{log}"
    );
    assert_eq!(pins.on, Drives::NONE);
}

#[test]
fn a_switch_to_what_sinks_already_wakes_the_program_and_touches_no_line() {
    let mut pins = Script::new(&[A, B]);
    let outcome = run(&mut pins, plan(Some((Nanos(40_000), Through::X(2))))).unwrap();
    let record = outcome.result.unwrap();
    assert_eq!(record.switch, Some(Switch { at_ns: 40_000.0, on_ns: 40_000.0, to: Through::X(2) }));
    assert_eq!((record.a_ns, record.b_ns), (Some(50_000.0), Some(60_000.0)));
    assert_eq!(outcome.calls, [Some(Nanos(1000)), None, None], "no length of a call that releases a line");
    let (log, at) = (pins.log.join("|"), START_BEFORE + 40_000);
    assert!(log.contains(&format!("drive x2|sleep {}|levels|sleep {at}|drive x2|edge", at - LEAD)), "{log}");
}

#[test]
fn a_charge_that_is_gone_before_the_start_is_no_charge() {
    let (mut discharge, _) = Discharge::new(plan(None), Nanos(LEAD), None);
    let drove = |at: i64| Event::Drove(Bracket { before: Nanos(at), after: Nanos(at + 1000) });
    let (high, low) = (Levels { a: true, b: true }, Levels { a: true, b: false });
    let armed = Event::Armed(Armed { levels: high, seqno: 10, line_seqno: [4, u32::MAX] }, None);
    for event in [drove(0), Event::Slept, drove(1_000_000), armed, Event::Slept] {
        discharge.handle(event);
    }
    assert_eq!(discharge.handle(Event::Levels(low)), Action::Done);
    assert_eq!(discharge.result(), Err(Fault::NoCharge));
}

#[test]
fn what_is_lost_has_a_name() {
    let result = |edges: &[_], levels| {
        let mut pins = Script { levels, ..Script::new(edges) };
        // Armed with both nodes high, whatever is read after the time-out.
        let (mut discharge, mut action) = Discharge::new(plan(None), Nanos(LEAD), None);
        while action != Action::Done {
            action = discharge.handle(match action {
                Action::Arm => {
                    let levels = Levels { a: true, b: true };
                    Event::Armed(Armed { levels, seqno: 10, line_seqno: [4, u32::MAX] }, None)
                }
                Action::Drive(on) => Event::Drove(pins.drive(on).unwrap()),
                Action::Sleep(at) | Action::Rest(at) => {
                    pins.sleep_until(at).unwrap();
                    Event::Slept
                }
                Action::WaitEdge { until, .. } => Event::Edge(pins.edge(until).unwrap()),
                Action::ReadLevels if pins.on.is_none() => Event::Levels(Levels { a: true, b: true }),
                Action::ReadLevels => Event::Levels(pins.levels().unwrap()),
                Action::Done => unreachable!(),
            });
        }
        discharge.result()
    };
    let (high, low) = (Levels { a: true, b: true }, Levels { a: false, b: false });
    let b_high = Levels { a: false, b: true };
    assert_eq!(result(&[(Node::A, 50_000, 12, 5)], high), Err(Fault::CoalescedEdge));
    assert_eq!(result(&[(Node::A, 50_000, 12, 6)], high), Err(Fault::LostEvent));
    assert_eq!(result(&[A], low), Err(Fault::MissedEdge));
    assert_eq!(result(&[], b_high), Err(Fault::MissedEdge));
    let without_a = result(&[(Node::B, 60_000, 11, 0)], low).unwrap();
    assert_eq!((without_a.a_ns, without_a.b_ns), (None, Some(60_000.0)));
    let open = result(&[], high).unwrap();
    assert_eq!((open.a_ns, open.b_ns, open.waited_ns), (None, None, Some(5_000_000.0 - 500.0)));
    let half = result(&[A], b_high).unwrap();
    assert_eq!((half.a_ns, half.b_ns), (Some(50_000.0), None));
    // Another processor has queued the edge of A, and is late with it.
    let late_a = result(&[(Node::B, 60_000, 12, 0), (Node::A, 50_000, 11, 5)], high).unwrap();
    assert_eq!((late_a.a_ns, late_a.b_ns), (Some(50_000.0), Some(60_000.0)));
    let twice = result(&[(Node::B, 60_000, 13, 0), (Node::A, 50_000, 11, 5)], high);
    assert_eq!(twice, Err(Fault::CoalescedEdge));
    // Chatter at the threshold: the first edge counts, and the numbers follow on.
    let chatter = result(&[A, (Node::A, 50_200, 12, 6), (Node::B, 60_000, 13, 0)], high).unwrap();
    assert_eq!((chatter.a_ns, chatter.b_ns), (Some(50_000.0), Some(60_000.0)));
}

#[test]
fn a_node_that_chatters_for_ever_does_not_make_the_wait_last_for_ever() {
    let chatter = |number: u32| (Node::A, 50_000 + 100_000 * i64::from(number), 11 + number, 5 + number);
    let mut pins = Script::new(&(0..1000).map(chatter).collect::<Vec<_>>());
    pins.levels = Levels { a: true, b: true };
    let record = run(&mut pins, plan(None)).unwrap().result.unwrap();
    assert_eq!((record.a_ns, record.b_ns), (Some(50_000.0), None));
    // 5 ms, and then one edge more.
    let waits = pins.log.iter().filter(|call| *call == "edge").count();
    assert_eq!(waits, 51);
}

#[test]
fn an_uncharged_node_and_a_slow_call_are_faults() {
    let mut pins = Script { levels: Levels { a: true, b: false }, ..Script::new(&[A, B]) };
    assert_eq!(run(&mut pins, plan(None)).unwrap().result, Err(Fault::NoCharge));
    assert!(!pins.log.contains(&"drive x2".to_owned()));
    let mut pins = Script::new(&[A, B]);
    let narrow = Plan { widest_bracket: Nanos(999), ..plan(None) };
    let outcome = run(&mut pins, narrow).unwrap();
    assert_eq!((outcome.result, outcome.calls[0]), (Err(Fault::WideBracket), Some(Nanos(1000))));
    assert_eq!(pins.on, Drives::NONE);
}

#[test]
fn what_a_call_took_longer_than_usual_its_line_may_have_moved_later() {
    let later = |usual: [Option<UsualCall>; 3]| {
        let plan = Plan { calls: usual, ..plan(Some((Nanos(20_000), Through::C2))) };
        run(&mut Script::new(&[A, B]), plan).unwrap().result.unwrap().later_ns
    };
    // Calls for one line take 1 us here.
    let usual = |length, longest| Some(UsualCall { length: Nanos(length), longest: Nanos(longest) });
    assert_eq!(later([None; 3]), None);
    assert_eq!(later([usual(900, 1000); 3]), None);
    let one = later([None, usual(800, 950), None]).unwrap();
    assert!((one - 200.0 / 2f64.sqrt()).abs() < 1e-9, "{one}");
    let all = later([usual(800, 950); 3]).unwrap();
    assert!((all - one * 3f64.sqrt()).abs() < 1e-9, "{all}");
}

#[test]
fn a_crossing_that_is_known_before_is_rested_for() {
    let mut pins = Script::new(&[A, B]);
    let plan = Plan { expected: [Some(Nanos(49_000)), Some(Nanos(61_000))], ..plan(None) };
    assert!(run(&mut pins, plan).unwrap().result.is_ok());
    let [a, b] = [49_000, 61_000].map(|after| START_BEFORE + after);
    let log = pins.log.join("|");
    assert!(
        log.ends_with(&format!("drive x2|rest before {a}|edge|rest before {b}|edge|drive none")),
        "{log}"
    );
}

#[test]
fn a_charge_that_was_left_alone_for_too_long_is_not_used() {
    let start = |late: i64| {
        let (mut discharge, _) = Discharge::new(plan(None), Nanos(LEAD), None);
        let drove = |at: i64| Event::Drove(Bracket { before: Nanos(at), after: Nanos(at + 1000) });
        discharge.handle(drove(0));
        discharge.handle(Event::Slept);
        discharge.handle(drove(1_000_000));
        let levels = Levels { a: true, b: true };
        discharge.handle(Event::Armed(Armed { levels, seqno: 10, line_seqno: [4, u32::MAX] }, None));
        discharge.handle(Event::Slept);
        discharge.handle(Event::Levels(levels));
        discharge.handle(Event::Slept);
        discharge.handle(drove(1_000_000 + plan(None).settle.0 + late))
    };
    assert!(matches!(start(LONGEST_PAUSE.0), Action::WaitEdge { .. }));
    assert_eq!(start(LONGEST_PAUSE.0 + 1), Action::Done);
}

#[test]
fn every_line_is_released_after_an_error_or_a_panic_anywhere() {
    for step in [
        "drive charge",
        "sleep 1001500",
        "drive none",
        "arm",
        "sleep 1096000",
        "levels",
        "sleep 1103000",
        "drive x2",
        "drive c2",
        "edge",
    ] {
        let mut pins = Script { fail_at: Some(step), ..Script::new(&[A, B]) };
        assert!(run(&mut pins, plan(Some((Nanos(40_000), Through::C2)))).is_err(), "{step}");
        assert_eq!(
            (pins.on, pins.log.last().unwrap().as_str()),
            (Drives::NONE, "drive none"),
            "error at {step}"
        );

        let mut pins = Script { panic_at: Some(step), ..Script::new(&[A, B]) };
        let caught = catch_unwind(AssertUnwindSafe(|| {
            run(&mut pins, plan(Some((Nanos(40_000), Through::C2)))).is_ok()
        }));
        assert!(caught.is_err(), "{step}");
        assert_eq!(
            (pins.on, pins.log.last().unwrap().as_str()),
            (Drives::NONE, "drive none"),
            "panic at {step}"
        );
    }
}

#[test]
fn a_discharge_that_does_not_end_is_finished_through_another_resistor() {
    let deadline = START_BEFORE + 5_000_000;
    let mut pins = Script::new(&[]);
    pins.levels = Levels { a: true, b: true };
    let limited = Plan { limit: Some(Through::C1), ..plan(None) };
    let (mut discharge, mut action) = Discharge::new(limited, Nanos(LEAD), None);
    let mut waits = 0;
    while action != Action::Done {
        action = discharge.handle(match action {
            Action::Arm => Event::Armed(pins.arm().unwrap(), None),
            Action::Drive(on) => Event::Drove(pins.drive(on).unwrap()),
            Action::Sleep(at) | Action::Rest(at) => {
                pins.sleep_until(at).unwrap();
                Event::Slept
            }
            Action::WaitEdge { until, .. } => {
                waits += 1;
                if waits == 2 {
                    let at = |ns| Nanos(deadline + ns);
                    pins.edges.push_back(Edge { node: Node::A, at: at(50_000), seqno: 11, line_seqno: 5 });
                    pins.edges.push_back(Edge { node: Node::B, at: at(60_000), seqno: 12, line_seqno: 0 });
                }
                Event::Edge(pins.edge(until).unwrap())
            }
            Action::ReadLevels => Event::Levels(pins.levels().unwrap()),
            Action::Done => unreachable!(),
        });
    }
    let record = discharge.result().unwrap();
    assert_eq!(record.switch, Some(Switch { at_ns: 5_000_000.0, on_ns: 5_001_000.0, to: Through::C1 }));
    assert_eq!((record.a_ns, record.b_ns), (Some(5_049_500.0), Some(5_059_500.0)));
}

#[test]
fn what_ended_early_is_drained_before_the_charge() {
    let mut pins = Script::new(&[A, B]);
    let (mut discharge, action) =
        Discharge::new(Plan { drain: Nanos(700_000), ..plan(None) }, Nanos(LEAD), None);
    assert_eq!(action, Action::Drive(Drives::C1));
    let drained = discharge.handle(Event::Drove(pins.drive(Drives::C1).unwrap()));
    assert_eq!(drained, Action::Rest(Nanos(1000 + 700_000)));
    assert_eq!(discharge.handle(Event::Slept), Action::Drive(Drives::CHARGE));
    let charging = Bracket { before: Nanos(701_000), after: Nanos(702_500) };
    assert_eq!(discharge.handle(Event::Drove(charging)), Action::Rest(Nanos(1_702_500)));
    assert_eq!(discharge.handle(Event::Slept), Action::Drive(Drives::NONE));
}

#[test]
fn a_start_that_would_meet_a_tick_comes_after_it() {
    let armed_at = |now: i64, settle: i64| {
        let plan = Plan { settle: Nanos(settle), ..plan(None) };
        let (mut discharge, _) = Discharge::new(plan, Nanos(LEAD), Some(Nanos(4_000_000)));
        let drove = |at: i64| Event::Drove(Bracket { before: Nanos(at), after: Nanos(at + 1000) });
        let levels = Levels { a: true, b: true };
        let armed = Armed { levels, seqno: 10, line_seqno: [4, u32::MAX] };
        for event in [drove(6_800_000), Event::Slept, drove(now - 10_000)] {
            discharge.handle(event);
        }
        discharge.handle(Event::Armed(armed, Some(Nanos(now))))
    };
    let start = Action::Drive(Drives::x(2));
    assert_eq!([armed_at(7_900_000, 0), armed_at(8_100_000, 0)], [start; 2]);
    // As late as levels can be read before.
    assert_eq!(armed_at(7_999_000, 0), Action::Sleep(Nanos(8_000_000 + TICK_LASTS.0 - LEAD)));
    assert_eq!(armed_at(8_039_000, 0), Action::Sleep(Nanos(8_039_000)));
    assert_eq!(armed_at(7_700_000, 100_000), Action::Sleep(Nanos(7_791_000 - LEAD)));
    assert_eq!(armed_at(7_910_000, 100_000), Action::Sleep(Nanos(8_000_000 + TICK_LASTS.0 - LEAD)));
}
