//! Whether a resistance is told from a short circuit.

use crate::estimate::limits::{BEYOND_NOISE, COVERAGE, MOSTLY_UNRESOLVED, UNRESOLVED_MEMORY};

/// What of the last readings of a sensor was.
#[derive(Debug, Clone, Copy, Default)]
pub struct Resolved {
    /// The share of those that were not, or were faults.
    unresolved: f64,
}

impl Resolved {
    /// Whether a resistance of so many sigma is. Where hardly any of the last readings was, the one that is by chance is what noise has
    /// put farthest up.
    pub fn tells(&mut self, sigmas: f64) -> bool {
        let from = if self.unresolved > MOSTLY_UNRESOLVED { BEYOND_NOISE } else { COVERAGE };
        self.counts(sigmas > COVERAGE);
        sigmas > from
    }

    /// Counts a reading that is not, as a fault, or one that is.
    pub fn counts(&mut self, is_resolved: bool) {
        let is_unresolved = f64::from(u8::from(!is_resolved));
        self.unresolved += (is_unresolved - self.unresolved) / UNRESOLVED_MEMORY;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_a_short_circuit_what_noise_has_put_up_is_no_number_and_a_resistance_is_one_at_once() {
        let mut resolved = Resolved::default();
        let noise = |index: usize| if index % 40 == 39 { 2.5 } else { 0.3 };
        assert_eq!(
            (0..80).filter(|index| resolved.tells(noise(*index))).collect::<Vec<_>>(),
            [39],
            "by chance"
        );
        assert!(resolved.tells(6.0), "for certain");
        let after = (0..80).filter(|_| !resolved.tells(3.0)).count();
        assert!((1..=8).contains(&after), "no more than as long as it was not for certain: {after}");
        (0..80).for_each(|_| resolved.counts(false));
        assert!(!resolved.tells(3.0), "faults tell as little");
    }
}
