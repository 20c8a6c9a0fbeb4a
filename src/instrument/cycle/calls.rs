//! How long the calls take that switch lines: an interrupted one is told from a usual one.

use crate::estimate::noise::Gate;
use crate::estimate::scatter::Usual;
use crate::instrument::discharge::{Call, Calls, UsualCall};
use crate::instrument::limits::{CALL_STEP, FIRST_CALLS, LONGER_CALL, OFTEN, UNLIKE};
use crate::units::Nanos;

/// Follows how long the calls of each kind take that switch one line.
#[derive(Debug, Clone, Copy)]
pub struct CallGate {
    kinds: [Lengths; 3],
    /// Of what starts are longer than the median, in units of what is usual.
    gate: Gate,
}

/// How long one kind of call takes.
#[derive(Debug, Clone, Copy)]
struct Lengths {
    first_ns: [f64; FIRST_CALLS],
    seen: usize,
    usual: Usual,
}

impl Default for CallGate {
    fn default() -> CallGate {
        let unseen = Lengths { first_ns: [0.0; FIRST_CALLS], seen: 0, usual: Usual::NONE };
        CallGate { kinds: [unseen; 3], gate: Gate::new(1.0) }
    }
}

impl Lengths {
    fn known(&self) -> Option<Usual> {
        (self.seen >= FIRST_CALLS).then_some(self.usual)
    }

    /// The steps are small beside the jitter of crossings.
    fn add(&mut self, call_ns: f64) {
        if self.known().is_some() {
            self.seen = self.seen.saturating_add(1);
            return self.usual.add(call_ns, (CALL_STEP * self.usual.place).max(1.0));
        }
        self.first_ns[self.seen] = call_ns;
        self.seen += 1;
        if self.seen == FIRST_CALLS {
            self.usual = Usual::of(&mut self.first_ns);
        }
    }
}

impl CallGate {
    /// How long a call for one line usually takes, by [`Call`]; `None` until a few have been seen.
    pub fn usual(&self) -> [Option<UsualCall>; 3] {
        self.kinds.map(|lengths| {
            let usual = lengths.known()?;
            let [length, longest] = [usual.place, usual.greatest()].map(|ns| Nanos(ns as i64));
            Some(UsualCall { length, longest })
        })
    }

    /// How long calls usually take of the kind that takes longest, ns; 0 until a few have been seen.
    pub fn longest_ns(&self) -> f64 {
        self.kinds.iter().filter_map(Lengths::known).map(|usual| usual.place).fold(0.0, f64::max)
    }

    /// How much longer calls usually take that release or sink in the middle of a discharge than those that start it, negative: shorter,
    /// ns; `None` if no more than calls of one kind differ by. A line may then move in another place of its call, too.
    pub fn unlike_ns(&self) -> Option<f64> {
        let often = |lengths: &Lengths| lengths.known().filter(|_| lengths.seen >= OFTEN);
        let [start, switches @ ..] = &self.kinds;
        let start = often(start)?;
        let longer = |usual: Usual| {
            Some(usual.place - start.place).filter(|_| !start.has(usual.place) && !usual.has(start.place))
        };
        let longer = switches.iter().filter_map(|lengths| longer(often(lengths)?));
        let greatest = longer.max_by(|a, b| a.abs().total_cmp(&b.abs()));
        greatest.filter(|longer_ns| longer_ns.abs() > UNLIKE * start.place)
    }

    fn start(&self) -> Option<f64> {
        Some(self.kinds[Call::Start as usize].known()?.place)
    }

    /// A call for so many lines that takes longer than this was interrupted: a line may have moved anywhere in it. No later
    /// time tells, for a switch that comes late looks like another resistance. A call for two lines takes less than two.
    pub fn widest(&self, lines: u32) -> Nanos {
        let widest = |single_ns| f64::from(lines) * single_ns + self.gate.sigma() * longer_ns(single_ns);
        self.start().map_or(Nanos::MAX, |single_ns| Nanos(widest(single_ns) as i64))
    }

    /// Takes the calls of a discharge.
    pub fn add(&mut self, calls: &Calls) {
        if let (Some(single_ns), Some(call)) = (self.start(), calls[Call::Start as usize]) {
            self.gate.admits((call.as_ns() - single_ns) / longer_ns(single_ns));
        }
        for (lengths, call) in self.kinds.iter_mut().zip(calls) {
            call.iter().for_each(|call| lengths.add(call.as_ns()));
        }
    }
}

/// By how much a call may be longer than the median.
fn longer_ns(single_ns: f64) -> f64 {
    LONGER_CALL.0 * single_ns + LONGER_CALL.1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(ns: i64) -> Calls {
        [Some(Nanos(ns)), None, None]
    }

    #[test]
    fn a_long_first_call_and_long_calls_now_and_then_change_little() {
        let mut calls = CallGate::default();
        assert_eq!((calls.usual(), calls.widest(1)), ([None; 3], Nanos::MAX));
        for index in 0..1000 {
            calls.add(&start(if index % 50 == 0 { 40_000 } else { 1100 + index % 7 * 10 }));
        }
        let [Some(usual), None, None] = calls.usual() else { panic!("{calls:?}") };
        assert!((1100..1170).contains(&usual.length.0) && usual.longest < Nanos(1600), "{usual:?}");
        assert!(calls.widest(1) < Nanos(4000) && calls.widest(2) > Nanos(2 * 1100));
        // Another kernel, another processor clock: it follows.
        (0..1000).for_each(|_| calls.add(&start(2300)));
        assert!((2290..=2300).contains(&calls.usual()[0].unwrap().length.0));
    }

    #[test]
    fn switches_that_take_longer_than_starts_are_told() {
        let told = |release: i64, sink: i64| {
            let mut calls = CallGate::default();
            for index in 0..1000 {
                let jitter = index % 7 * 20;
                calls.add(&[1100, release, sink].map(|ns| Some(Nanos(ns + jitter))));
            }
            calls.unlike_ns()
        };
        assert_eq!(CallGate::default().unlike_ns(), None);
        assert_eq!((told(1100, 1120), told(1250, 1000)), (None, None));
        for (release, sink, longer_ns) in [(3100, 1100, 2000.0), (1300, 6100, 5000.0), (1100, 500, -600.0)] {
            let told_ns = told(release, sink).unwrap();
            assert!((told_ns - longer_ns).abs() < 20.0, "{told_ns} for {longer_ns}");
        }
        let mut early = CallGate::default();
        (0..OFTEN - 1).for_each(|_| early.add(&[1100, 9100, 1100].map(|ns| Some(Nanos(ns)))));
        assert_eq!(early.unlike_ns(), None, "that may pass");
        let mut starts = CallGate::default();
        (0..1000).for_each(|_| starts.add(&start(1100)));
        assert_eq!(starts.unlike_ns(), None, "nothing was switched");
    }

    /// Of two thousand calls of 1.1 us each tenth takes so many ns: how many of these are refused.
    fn refused(long_ns: i64) -> usize {
        let mut calls = CallGate::default();
        let long = (0..2000).filter(|index| {
            let call = start(if index % 10 == 9 { long_ns } else { 1100 });
            let is_refused = call[0] > Some(calls.widest(1));
            calls.add(&call);
            is_refused
        });
        long.count()
    }

    #[test]
    fn calls_that_are_often_somewhat_longer_are_usual_and_preempted_ones_never_are() {
        assert_eq!(refused(2000), 0);
        assert!(refused(3500) < 70);
        assert_eq!(refused(50_000_000), 200);
    }
}
