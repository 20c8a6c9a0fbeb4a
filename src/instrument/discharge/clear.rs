//! When to begin, so that nothing whose instant counts meets the kernel's tick.
//!
//! The tick interrupts whatever runs, at whole multiples of its period on `CLOCK_MONOTONIC`: a line that is switched then moves
//! later in its call, and an edge that comes then is stamped when the tick is over.

use super::Plan;
use crate::circuit::Node;
use crate::instrument::limits::{TICK_LASTS, TICK_SOON};
use crate::units::Nanos;

/// The instant to begin this plan at, that which is asked for or one shortly after it; `tick`: the period, where it is known.
pub(super) fn clear_start(plan: &Plan, at: Nanos, tick: Option<Nanos>) -> Nanos {
    let Some(period) = tick.filter(|period| *period > TICK_SOON + TICK_LASTS) else { return at };
    let [a_falls, b_falls] = plan.falls;
    let exactly = |after| Some([after, Nanos::ZERO]);
    let switch = plan.switch.map(|(after, _)| after);
    // One call after the other.
    let lasts = plan.calls.into_iter().flatten().fold(Nanos::ZERO, |sum, usual| sum + usual.length);
    let counts = [
        exactly(Nanos::ZERO),
        switch.map(|after| [after, lasts]),
        switch.map(|after| [after + plan.hold, lasts]),
        a_falls,
        b_falls.filter(|_| plan.last == Node::B),
    ];
    let mut start = at;
    for _ in counts {
        let meets_for = |[after, within]: [Nanos; 2]| meets_for(start + after, within, period);
        match counts.into_iter().flatten().map(meets_for).max() {
            None | Some(Nanos::ZERO) => return start,
            Some(longer) => start = start + longer,
        }
    }
    // There is no clear start, or it is far.
    at
}

/// How much later what comes at an instant, give or take something, would have to come to meet no tick; 0: it meets none.
fn meets_for(at: Nanos, within: Nanos, period: Nanos) -> Nanos {
    let before = TICK_SOON + within;
    let since = (at + before).0.rem_euclid(period.0);
    Nanos(((before + TICK_LASTS + within).0 - since).max(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::discharge::Charge;
    use crate::record::Through;
    use proptest::prelude::*;

    const PERIOD: Nanos = Nanos(4_000_000);

    fn plan(switch: Option<i64>, falls: [Option<i64>; 2], last: Node) -> Plan {
        let charge = Charge::alone(Nanos(1_000_000));
        Plan {
            switch: switch.map(|after| (Nanos(after), Through::C2)),
            falls: falls.map(|after| after.map(|after| [Nanos(after), Nanos::ZERO])),
            ..Plan::full(Through::X(0), last, charge, Nanos(60_000_000))
        }
    }

    #[test]
    fn what_would_meet_a_tick_is_begun_after_it() {
        let start = |plan: &Plan, at| clear_start(plan, Nanos(at), Some(PERIOD)).0;
        let plain = plan(None, [None; 2], Node::A);
        let over = TICK_LASTS.0;
        assert_eq!(start(&plain, 8_000_000), 8_000_000 + over);
        assert_eq!(start(&plain, 8_000_000 - TICK_SOON.0), 8_000_000 + over);
        for clear in [8_000_000 + over, 10_000_000, 12_000_000 - TICK_SOON.0 - 1] {
            assert_eq!(start(&plain, clear), clear);
        }
        let switched = plan(Some(100_000), [None; 2], Node::A);
        assert_eq!(start(&switched, 7_905_000), 7_900_000 + over);
        let falls = [Some(500_000), Some(700_000)];
        assert_eq!(start(&plan(None, falls, Node::A), 7_500_000), 7_500_000 + over);
        assert_eq!(start(&plan(None, falls, Node::A), 7_300_000), 7_300_000, "nobody waits for B");
        assert_eq!(start(&plan(None, falls, Node::B), 7_300_000), 7_300_000 + over);
        assert_eq!(clear_start(&plain, Nanos(8_000_000), None), Nanos(8_000_000), "not known");
        assert_eq!(clear_start(&plain, Nanos(8_000_000), Some(Nanos(20_000))), Nanos(8_000_000), "no tick");
    }

    proptest! {
        #[test]
        fn a_start_is_hardly_later_and_clear(
            at in 0i64..1_000_000_000_000,
            switch in proptest::option::of(1i64..60_000_000),
            a in 1i64..60_000_000,
            b_later in 1i64..60_000_000,
            waits_for_b: bool,
        ) {
            let last = if waits_for_b { Node::B } else { Node::A };
            let plan = plan(switch, [Some(a), Some(a + b_later)], last);
            let start = clear_start(&plan, Nanos(at), Some(PERIOD));
            prop_assert!(start >= Nanos(at) && start.0 - at <= 4 * (TICK_SOON + TICK_LASTS).0);
            let mut after = vec![0, a];
            after.extend(switch);
            after.extend(waits_for_b.then_some(a + b_later));
            for after in after {
                prop_assert_eq!(meets_for(start + Nanos(after), Nanos::ZERO, PERIOD), Nanos::ZERO);
            }
        }
    }
}
