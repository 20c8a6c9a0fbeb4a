//! A gate for spikes that cannot be kept narrow by noise that was taken for too small.

use crate::estimate::limits::{GATE_NARROWER, GATE_WIDER, GATE_WIDEST};

/// A gate of so many sigma.
///
/// What is refused is never learned from: a gate that is narrower than the noise would keep the noise small that is learned,
/// and itself narrow. So each value that it refuses widens it. In balance p ln 1.5 = (1 - p)/80: no more than three values in
/// a hundred are refused for long. More than that are no spikes but noise; let in, they are learned as such. But a program
/// that is preempted or suspended again and again does not make noise of it: what is far away says nothing about the gate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    least: f64,
    sigma: f64,
}

impl Gate {
    /// Never narrower than so many sigma.
    pub const fn new(least: f64) -> Gate {
        Gate { least, sigma: least }
    }

    /// How many sigma it is wide now.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// Whether a value so many sigma away is let in.
    pub fn admits(&mut self, away: f64) -> bool {
        let widest = GATE_WIDEST * self.least;
        let admits = away <= self.sigma;
        let factor = if admits { 1.0 - GATE_NARROWER } else { GATE_WIDER };
        if away <= widest {
            self.sigma = (self.sigma * factor).clamp(self.least, widest);
        }
        admits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spikes_are_refused_for_ever_as_long_as_they_are_rare() {
        let mut gate = Gate::new(5.0);
        let refused = (0..100_000).filter(|index| {
            let is_spike = index % 50 == 0;
            let admitted = gate.admits(if is_spike { 20.0 } else { 1.0 });
            assert!(admitted || is_spike);
            !admitted
        });
        assert_eq!(refused.count(), 2000);
        assert!(!gate.admits(15.0), "{gate:?}");
    }

    #[test]
    fn what_is_frequent_is_let_in() {
        let mut gate = Gate::new(5.0);
        let refused = (0..100_000).filter(|index| !gate.admits(if index % 10 == 0 { 12.0 } else { 1.0 }));
        assert!(refused.count() < 3100);
    }

    #[test]
    fn what_is_far_away_is_refused_however_frequent_and_widens_nothing() {
        let mut gate = Gate::new(5.0);
        assert!((0..1000).all(|index| gate.admits(1.0) && (index % 2 == 0 || !gate.admits(21.0))));
        assert!(!gate.admits(5.1), "{gate:?}");
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        assert!(!Gate::new(5.0).admits(f64::NAN));
    }
}
