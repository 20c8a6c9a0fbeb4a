//! When to begin, so that nothing whose instant counts meets the kernel's tick.
//!
//! The tick interrupts whatever runs, at whole multiples of its period on `CLOCK_MONOTONIC`: a line that is switched then moves
//! later in its call, and an edge that comes then is stamped when the tick is over.

use super::Plan;
use crate::circuit::Node;
use crate::instrument::limits::{MOST_OF_A_TICK, TICK_LASTS, TICK_SOON};
use crate::units::Nanos;

/// The instant to begin this plan at, that which is asked for or one shortly after it; `tick`: the period, where it is known.
pub(super) fn clear_start(plan: &Plan, at: Nanos, tick: Option<Nanos>) -> Nanos {
    let Some(period) = tick else { return at };
    let [start, release, sink] = plan.calls.map(|usual| usual.map_or(Nanos::ZERO, |usual| usual.length));
    let switch = plan.switch.map(|(after, _)| [after, after + release + sink]);
    let counts = [
        Some([Nanos::ZERO, start]),
        switch,
        switch.map(|[_, end]| [end + plan.hold - sink, end + plan.hold]),
        plan.falls[0],
        plan.falls[1].filter(|_| plan.last == Node::B),
    ];
    let known = || counts.into_iter().flatten().filter(|[from, to]| *to - *from <= MOST_OF_A_TICK);
    let mut begin = at;
    for _ in counts {
        let longest = known().map(|[from, to]| wait([begin + from, begin + to], period)).max();
        match longest.unwrap_or_default() {
            Nanos::ZERO => return begin,
            _ if begin - at > MOST_OF_A_TICK => break,
            longer => begin = begin + longer,
        }
    }
    at
}

/// How much later what lasts from an instant to another would have to come to meet no tick; 0: it meets none.
fn wait([from, to]: [Nanos; 2], period: Nanos) -> Nanos {
    let since_soon = (to + TICK_SOON).0.rem_euclid(period.0.max(1));
    let over = TICK_SOON + TICK_LASTS + (to - from);
    Nanos((over.0 - since_soon).max(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::discharge::{Charge, UsualCall};
    use crate::record::Through;
    use proptest::prelude::*;

    const PERIOD: Nanos = Nanos(4_000_000);

    fn plan(switch: Option<i64>, falls: [Option<[i64; 2]>; 2], last: Node) -> Plan {
        let charge = Charge::alone(Nanos(1_000_000));
        Plan {
            switch: switch.map(|after| (Nanos(after), Through::C2)),
            falls: falls.map(|fall| fall.map(|at| at.map(Nanos))),
            ..Plan::full(Through::X(0), last, charge, Nanos(60_000_000))
        }
    }

    fn calls(lengths: [i64; 3]) -> [Option<UsualCall>; 3] {
        lengths.map(|ns| Some(UsualCall { length: Nanos(ns), longest: Nanos(2 * ns) }))
    }

    #[test]
    fn what_would_meet_a_tick_is_begun_after_it() {
        let start = |plan: &Plan, at| clear_start(plan, Nanos(at), Some(PERIOD)).0;
        let plain = plan(None, [None; 2], Node::A);
        let (soon, over) = (TICK_SOON.0, TICK_LASTS.0);
        assert_eq!(start(&plain, 8_000_000), 8_000_000 + over);
        assert_eq!(start(&plain, 8_000_000 - soon), 8_000_000 + over);
        for clear in [8_000_000 + over, 10_000_000, 12_000_000 - soon - 1] {
            assert_eq!(start(&plain, clear), clear);
        }
        let switched = plan(Some(100_000), [None; 2], Node::A);
        assert_eq!(start(&switched, 7_905_000), 7_900_000 + over);
        let falls = [Some([500_000, 508_000]), Some([700_000, 720_000])];
        assert_eq!(
            start(&plan(None, falls, Node::A), 7_490_000),
            7_500_000 + over,
            "stamped while there is one"
        );
        assert_eq!(start(&plan(None, falls, Node::A), 7_300_000), 7_300_000, "nobody waits for B");
        assert_eq!(start(&plan(None, falls, Node::B), 7_300_000), 7_300_000 + over);
        assert_eq!(clear_start(&plain, Nanos(8_000_000), None), Nanos(8_000_000), "not known");
        assert_eq!(
            clear_start(&plain, Nanos(8_000_000), Some(Nanos(20_000))),
            Nanos(8_000_000),
            "nothing but ticks"
        );
    }

    #[test]
    fn calls_are_over_before_a_tick() {
        let start = |plan: &Plan, at| clear_start(plan, Nanos(at), Some(PERIOD)).0;
        let plain = Plan { calls: calls([30_000, 20_000, 25_000]), ..plan(None, [None; 2], Node::A) };
        assert_eq!(start(&plain, 7_966_000), 8_000_000 + TICK_LASTS.0);
        assert_eq!(start(&plain, 7_964_000), 7_964_000);
        let switched = Plan { switch: Some((Nanos(500_000), Through::C2)), ..plain };
        assert_eq!(start(&switched, 7_451_000), 7_500_000 + TICK_LASTS.0);
        assert_eq!(start(&switched, 7_449_000), 7_449_000);
        let held = Plan { hold: Nanos(300_000), ..switched };
        assert_eq!(start(&held, 7_160_000), 7_180_000 + TICK_LASTS.0);
        // On a chip behind a slow bus nothing is so short.
        let slow = Plan { calls: calls([300_000; 3]), ..switched };
        assert_eq!(start(&slow, 7_990_000), 7_990_000);
    }

    proptest! {
        #[test]
        fn a_start_is_hardly_later_and_clear(
            at in 0i64..1_000_000_000_000,
            period in prop::sample::select(vec![1_000_000i64, 3_333_333, 4_000_000, 10_000_000]),
            switch in proptest::option::of(1i64..60_000_000),
            lengths in [500i64..8_000, 500i64..8_000, 500i64..8_000],
            hold in prop::sample::select(vec![0i64, 5_000_000]),
            a in [1i64..60_000_000, 0i64..100_000],
            b in [1i64..60_000_000, 0i64..100_000],
            waits_for_b: bool,
        ) {
            let last = if waits_for_b { Node::B } else { Node::A };
            let [a, b] = [a, b].map(|[from, lasts]| [from, from + lasts]);
            let plan = Plan { calls: calls(lengths), hold: Nanos(hold), ..plan(switch, [Some(a), Some(b)], last) };
            let start = clear_start(&plan, Nanos(at), Some(Nanos(period))).0;
            prop_assert!((at..=at + 2 * MOST_OF_A_TICK.0 + 60_000).contains(&start), "{}", start - at);
            let mut counts = vec![[0, lengths[0]], a];
            counts.extend(switch.map(|at| [at, at + lengths[1]]));
            counts.extend(switch.map(|at| [at + lengths[1] + hold, at + lengths[1] + hold + lengths[2]]));
            counts.extend(waits_for_b.then_some(b));
            let meets = |[from, to]: &[i64; 2]| {
                let tick = (start + to).div_euclid(period) * period;
                tick + 39_999 >= start + from
            };
            // Where ticks are rare and little counts there is a clear start; it is found unless it is far.
            let is_easy = period >= 3_333_333 && switch.is_none() && !waits_for_b && a[1] - a[0] < 50_000;
            let met = counts.iter().filter(|one| meets(one)).count();
            prop_assert!(met == 0 || start == at && !is_easy, "{met} of {counts:?}");
        }
    }
}
