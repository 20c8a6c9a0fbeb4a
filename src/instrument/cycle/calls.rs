//! How long the calls take that switch lines: an interrupted one is told from a usual one.

use crate::estimate::noise::Gate;
use crate::estimate::scatter::median;
use crate::instrument::limits::{FIRST_CALLS, LONGER_CALL};
use crate::units::Nanos;

/// Follows how long a call takes that switches one line, to tell an interrupted one from a usual one, and to place the
/// moment at which the line moves.
#[derive(Debug, Clone, Copy)]
pub struct CallGate {
    first_ns: [f64; FIRST_CALLS],
    seen: usize,
    /// The median, ns.
    single_ns: f64,
    /// Of what calls are longer than the median, in units of what is usual.
    gate: Gate,
}

impl Default for CallGate {
    fn default() -> CallGate {
        CallGate { first_ns: [0.0; FIRST_CALLS], seen: 0, single_ns: 0.0, gate: Gate::new(1.0) }
    }
}

impl CallGate {
    /// How long a call for one line usually takes; `None` until a few have been seen.
    pub fn single(&self) -> Option<Nanos> {
        (self.seen >= FIRST_CALLS).then_some(Nanos(self.single_ns as i64))
    }

    fn usual_ns(&self) -> f64 {
        LONGER_CALL.0 * self.single_ns + LONGER_CALL.1
    }

    /// A call for so many lines that takes longer than this was interrupted: a line may have moved anywhere in it. No later
    /// time tells, for a switch that comes late looks like another resistance. A call for two lines takes less than two.
    pub fn widest(&self, lines: u32) -> Nanos {
        if self.seen < FIRST_CALLS {
            return Nanos::MAX;
        }
        Nanos((f64::from(lines) * self.single_ns + self.gate.sigma() * self.usual_ns()) as i64)
    }

    /// Takes a call for one line. Once there is a median, it steps towards each value, not by it: a long call moves it no
    /// more than a short one. The steps are small beside the jitter of crossings.
    pub fn add(&mut self, call: Nanos) {
        let call_ns = call.as_ns();
        if self.seen < FIRST_CALLS {
            self.first_ns[self.seen] = call_ns;
            self.seen += 1;
            if self.seen == FIRST_CALLS {
                self.single_ns = median(&mut self.first_ns);
            }
            return;
        }
        self.gate.admits((call_ns - self.single_ns) / self.usual_ns());
        let step_ns = (0.01 * self.single_ns).max(1.0);
        self.single_ns += (call_ns - self.single_ns).clamp(-step_ns, step_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_first_call_and_long_calls_now_and_then_change_little() {
        let mut calls = CallGate::default();
        assert_eq!((calls.single(), calls.widest(1)), (None, Nanos::MAX));
        for index in 0..1000 {
            calls.add(Nanos(if index % 50 == 0 { 40_000 } else { 1100 + index % 7 * 10 }));
        }
        let single = calls.single().unwrap();
        assert!((1100..1170).contains(&single.0), "{single}");
        assert!(calls.widest(1) < Nanos(4000) && calls.widest(2) > Nanos(2 * 1100));
        // Another kernel, another processor clock: it follows.
        (0..1000).for_each(|_| calls.add(Nanos(2300)));
        assert!((2290..=2300).contains(&calls.single().unwrap().0));
    }

    /// Of two thousand calls of 1.1 us each tenth takes so many ns: how many of these are refused.
    fn refused(long_ns: i64) -> usize {
        let mut calls = CallGate::default();
        let long = (0..2000).filter(|index| {
            let call = Nanos(if index % 10 == 9 { long_ns } else { 1100 });
            let is_refused = call > calls.widest(1);
            calls.add(call);
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
