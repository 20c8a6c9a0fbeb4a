//! How long before a timed call the chip is touched.

use crate::instrument::limits::{AWAKE, FIRST_READ, MOST_LEAD, READ_STEP};
use crate::units::Nanos;

/// How long reading levels usually takes on this board where it has to wake the chip first, as far as that is known.
#[derive(Debug, Clone, Copy)]
pub struct Lead(Nanos);

impl Lead {
    /// As long as a read takes, and a little: what is left over is spun away.
    pub fn get(self) -> Nanos {
        (self.0 + AWAKE).min(MOST_LEAD)
    }

    /// Takes how long a read took. One that was interrupted says no more than another.
    pub fn learn(&mut self, read: Nanos) {
        self.0 = self.0 + (read - self.0).clamp(Nanos(-READ_STEP.0), READ_STEP);
    }
}

impl Default for Lead {
    fn default() -> Lead {
        Lead(FIRST_READ)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lead_is_that_of_the_board_whatever_one_read_in_ten_takes() {
        for read in [1_000, 15_000] {
            let mut lead = Lead::default();
            (0..1000).for_each(|i| lead.learn(Nanos(if i % 10 == 0 { 300_000 } else { read })));
            let wanted = Nanos(read) + AWAKE;
            assert!((wanted..=wanted + READ_STEP).contains(&lead.get()), "{:?}", lead);
        }
        let mut lead = Lead::default();
        (0..1000).for_each(|_| lead.learn(Nanos(10_000_000)));
        assert_eq!(lead.get(), MOST_LEAD);
    }
}
