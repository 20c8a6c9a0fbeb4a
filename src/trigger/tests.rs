//! States one by one, and what holds of any readings.

use super::*;
use crate::reading::{Bound, Branch, Method};
use proptest::prelude::*;

const MS: i64 = 1_000_000;
const RULES: TriggerRules = TriggerRules {
    quantity: Compared::Shown,
    on: 2.0,
    off: 1.5,
    hold: Nanos(20 * MS),
    stale: Nanos(100 * MS),
};
const DOWNWARDS: TriggerRules = TriggerRules { quantity: Compared::Resistance, on: 1e3, off: 2e3, ..RULES };

fn reading(at_ms: i64, status: Status) -> Reading {
    Reading {
        channel: 0,
        seq: 1,
        at: Nanos(at_ms * MS),
        status,
        suspect: None,
        method: Method::Tracked,
        duration: Nanos(2 * MS),
    }
}

/// A force, and its resistance by F = 2000 N ohm / R.
fn force(value: f64, u: Option<f64>) -> Status {
    // That of the characteristic is known to be wide, and the same at each press.
    let shown = Some(MeasuredValue { value, u: Some(9.0), repeat_u: u, is_extrapolated: false });
    let r_ohm = Measured { value: 2e3 / value, u: u.map(|u| u * 2e3 / value / value) };
    Status::Ok { branch: Branch::Direct, r_ohm, shown, is_moving: false, is_settling: false }
}

const FAULT: Status = Status::Fault(Fault::MissedEdge);
const OPEN: Status = Status::Open { r_min_ohm: 63e3, shown: Some(Bound::AtMost(0.2)) };
const SHORT: Status = Status::Short { r_max_ohm: 4.0, shown: Some(Bound::AtLeast(500.0)) };

/// The states that come of these, each with the ms that it was told at.
fn told(rules: TriggerRules, readings: impl IntoIterator<Item = (i64, Status)>) -> Vec<(i64, State)> {
    let mut trigger = Trigger::new(rules);
    let events = readings.into_iter().filter_map(|(at, status)| trigger.take(&reading(at, status)));
    events.map(|event| (event.at.0 / MS, event.state)).collect()
}

fn at_once(rules: TriggerRules) -> TriggerRules {
    TriggerRules { hold: Nanos::ZERO, ..rules }
}

#[test]
fn thresholds_have_a_hysteresis() {
    use State::{Pressed, Released};
    let forces = [1.0, 1.9, 2.1, 1.6, 1.4, 1.9, 2.1];
    let readings = || forces.iter().enumerate().map(|(at, f)| (at as i64, force(*f, Some(0.01))));
    let expected = [(0, Released), (2, Pressed), (4, Released), (6, Pressed)];
    assert_eq!(told(at_once(RULES), readings()), expected);
    // By resistance: pressed below 1 kohm, released above 2 kohm, which is 2 N and 1 N.
    let expected = [(0, Released), (2, Pressed)];
    assert_eq!(told(at_once(DOWNWARDS), readings()), expected);
}

#[test]
fn a_threshold_must_hold() {
    use State::{Pressed, Released};
    let at = |ms: i64, f: f64| (ms, force(f, Some(0.01)));
    let still = [at(0, 1.0), at(20, 1.0)];
    assert_eq!(told(RULES, still), [(20, Released)]);
    // A tap of 19 ms is none; the time counts anew.
    let tapped = [at(30, 3.0), at(49, 3.0), at(50, 1.0), at(60, 3.0), at(79, 3.0), at(80, 3.0)];
    assert_eq!(told(RULES, still.into_iter().chain(tapped)), [(20, Released), (80, Pressed)]);
    // What came before a gap has not held through it.
    let gap = [at(30, 3.0), at(200, 3.0), at(219, 3.0), at(220, 3.0)];
    assert_eq!(told(RULES, still.into_iter().chain(gap)), [(20, Released), (220, Pressed)]);
    // A reading without a number breaks nothing.
    let fault = [at(30, 3.0), (40, FAULT), at(50, 3.0)];
    assert_eq!(told(RULES, still.into_iter().chain(fault)), [(20, Released), (50, Pressed)]);
}

#[test]
fn a_number_decides_by_where_the_truth_is() {
    use State::{Pressed, Released};
    let rules = at_once(RULES);
    let released = (0, force(1.0, Some(0.01)));
    assert_eq!(told(rules, [released, (1, force(2.1, Some(0.06)))]), [(0, Released)]);
    assert_eq!(told(rules, [released, (1, force(2.1, Some(0.05)))]), [(0, Released), (1, Pressed)]);
    assert_eq!(told(rules, [released, (1, force(9.0, None))]), [(0, Released)], "of unknown uncertainty");
    // Nothing is known yet, and this does not tell.
    assert_eq!(told(rules, [(0, force(2.0, Some(0.1)))]), []);
    assert_eq!(told(rules, [(0, force(1.7, Some(0.1)))]), [(0, Released)]);
}

#[test]
fn bounds_are_known() {
    use State::{Pressed, Released};
    for rules in [at_once(RULES), at_once(DOWNWARDS)] {
        assert_eq!(
            told(rules, [(0, OPEN), (1, SHORT), (2, OPEN)]),
            [(0, Released), (1, Pressed), (2, Released)]
        );
    }
    // Below 1.9 N is not below 1.5 N; above 1.9 N is not above 2 N.
    let open = Status::Open { r_min_ohm: 1e3, shown: Some(Bound::AtMost(1.9)) };
    let short = Status::Short { r_max_ohm: 4.0, shown: Some(Bound::AtLeast(1.9)) };
    assert_eq!(told(at_once(RULES), [(0, SHORT), (1, open)]), [(0, Pressed)]);
    assert_eq!(told(at_once(RULES), [(0, OPEN), (1, short)]), [(0, Released)]);
    // A characteristic that gives no force there.
    let none = Status::Open { r_min_ohm: 63e3, shown: None };
    assert_eq!(told(at_once(RULES), [(0, none)]), []);
}

/// A broken wire is a bound by the direction of the law: of platinum hotter, of a thermistor colder than so much.
#[test]
fn a_bound_may_lie_on_either_side() {
    use State::{Pressed, Released};
    let open = |bound| Status::Open { r_min_ohm: 63e3, shown: Some(bound) };
    let short = |bound| Status::Short { r_max_ohm: 4.0, shown: Some(bound) };
    let hotter = TriggerRules { on: 40.0, off: -5.0, ..at_once(RULES) };
    let rising = [(0, short(Bound::AtMost(-240.0))), (1, open(Bound::AtLeast(800.0)))];
    assert_eq!(told(hotter, rising), [(0, Released), (1, Pressed)]);
    let colder = TriggerRules { on: -5.0, off: 40.0, ..at_once(RULES) };
    let falling = [(0, short(Bound::AtLeast(200.0))), (1, open(Bound::AtMost(-60.0)))];
    assert_eq!(told(colder, falling), [(0, Released), (1, Pressed)]);
}

#[test]
fn what_gets_old_is_unknown_and_why() {
    let mut trigger = Trigger::new(at_once(RULES));
    assert_eq!((trigger.look_at(), trigger.look(Nanos(1))), (None, None), "nothing was known");
    let unknown = |why, ms| Some(Event { state: State::Unknown(why), at: Nanos(ms * MS) });
    trigger.take(&reading(0, SHORT)).unwrap();
    assert_eq!((trigger.look_at(), trigger.look(Nanos(99 * MS))), (Some(Nanos(100 * MS)), None));
    assert_eq!(trigger.look(Nanos(100 * MS)), unknown(Why::Stale, 100));
    assert_eq!((trigger.look_at(), trigger.look(Nanos(300 * MS))), (None, None), "once");
    trigger.take(&reading(400, SHORT)).unwrap();
    assert_eq!(trigger.take(&reading(410, FAULT)), None);
    assert_eq!(trigger.look(Nanos(500 * MS)), unknown(Why::Fault, 500));
    trigger.take(&reading(600, SHORT)).unwrap();
    // The lines are away.
    assert_eq!(trigger.take(&reading(610, Status::Fault(Fault::Pins))), unknown(Why::Fault, 610));
}

fn status() -> impl Strategy<Value = Status> {
    prop_oneof![
        6 => (0.01f64..5.0, prop::option::weighted(0.9, 0.0f64..1.0)).prop_map(|(f, u)| force(f, u)),
        1 => Just(FAULT),
        1 => Just(Status::Fault(Fault::Pins)),
        1 => Just(OPEN),
        1 => Just(SHORT),
    ]
}

/// Readings, each so many ms after the one before, and whether somebody looks before it comes.
fn scenes() -> impl Strategy<Value = Vec<(i64, Status, bool)>> {
    prop::collection::vec((prop_oneof![9 => 1i64..30, 1 => 1i64..300], status(), any::<bool>()), 1..200)
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    #[test]
    fn of_any_readings(scene in scenes(), is_downwards in any::<bool>(), hold in 0i64..50) {
        let rules = TriggerRules { hold: Nanos(hold * MS), ..if is_downwards { DOWNWARDS } else { RULES } };
        let mut trigger = Trigger::new(rules);
        let (mut now, mut last) = (0, trigger.state());
        // Numbers since the last event that is not of a lack of them.
        let mut numbers: Vec<(i64, [f64; 2])> = Vec::new();
        for (gap, status, is_looked_at) in scene {
            now += gap;
            let mut events = Vec::new();
            if is_looked_at {
                events.extend(trigger.look(Nanos(now * MS)));
                prop_assert!(events.iter().all(|event| matches!(event.state, State::Unknown(_))), "by time alone");
            }
            let span = rules.quantity.span(&status);
            numbers.extend(span.map(|span| (now, span)));
            events.extend(trigger.take(&reading(now, status)));
            for Event { state, at } in events {
                prop_assert_eq!(at, Nanos(now * MS));
                prop_assert!(state != last, "{:?} twice", state);
                prop_assert!(!matches!((state, last), (State::Unknown(_), State::Unknown(_))));
                last = state;
                if matches!(state, State::Unknown(_)) {
                    continue;
                }
                prop_assert!(span.is_some(), "by a reading without a number");
                // All numbers of the time that it had to hold say so, and the time is full.
                let from = numbers.iter().rposition(|(at, _)| now - at >= hold);
                prop_assert!(from.is_some(), "held for {} ms", now - numbers[0].0);
                for (_, span) in &numbers[from.unwrap()..] {
                    let is_beyond = match (state, is_downwards) {
                        (State::Pressed, false) => span[0] >= rules.on,
                        (State::Pressed, true) => span[1] <= rules.on,
                        // Where nothing was known, `on` is the bound.
                        (_, false) => span[1] < rules.on,
                        (_, true) => span[0] > rules.on,
                    };
                    prop_assert!(is_beyond, "{:?} by {:?}", state, span);
                }
            }
            prop_assert_eq!(trigger.state(), last);
            if trigger.look_at().is_some_and(|at| Nanos(now * MS) >= at) && is_looked_at {
                prop_assert!(false, "known by what is too old");
            }
        }
        // Without numbers it is unknown in the end.
        for _ in 0..2 {
            now += 51;
            trigger.take(&reading(now, FAULT));
        }
        trigger.look(Nanos(now * MS));
        prop_assert!(matches!(trigger.state(), State::Unknown(_)));
    }
}
