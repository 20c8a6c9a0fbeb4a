//! Dielectric absorption, by discharges after a long charge.
//!
//! A dielectric takes part in a discharge as far as it can follow, and by how much depends on how long the discharge is: two known
//! resistors tell nothing of it. But a discharge through R_2 that comes after a rest at V_DD, in which the dielectric has been
//! filled, is longer than the usual ones, which find it as the discharges before have left it. By which share of the time it
//! is longer tells how much readings may be off: up to R_1 a few times that share of R_1, beyond it the same share of the
//! resistance and a little more, as integrations of the network with branches of one time constant and of five decades show
//! (docs/stability.md, "What capacitors remember"). A charge that is always too short looks the same.

use crate::estimate::limits::{
    ABSORPTION_EVERY, ABSORPTION_FIRST, ABSORPTION_GROWS, ABSORPTION_LIKELY, ABSORPTION_REMEMBERED,
    BY_ABSORPTION,
};
use crate::estimate::look::Looks;
use crate::units::Nanos;

/// Discharges after a rest so far.
#[derive(Debug, Clone, Copy, Default)]
pub struct AbsorptionTest(Looks<ABSORPTION_REMEMBERED>);

impl AbsorptionTest {
    /// What others have found to [show](Self::share).
    pub fn known(share: f64) -> AbsorptionTest {
        AbsorptionTest(Looks::known([share, 0.0]))
    }

    /// Whether one is due.
    pub fn is_due(&self, now: Nanos) -> bool {
        self.0.is_due(now, ABSORPTION_FIRST, ABSORPTION_EVERY)
    }

    /// Takes one, whether it told something or not: by which share it was longer than usual, and the variance of that.
    pub fn add(&mut self, longer: Option<[f64; 2]>, now: Nanos) {
        self.0.add(longer, now);
    }

    /// By which share of their time discharges are longer after a rest, if that shows.
    pub fn share(&self) -> Option<f64> {
        self.beyond(self.0.gate())
    }

    /// What that may do to a reading, 1 sigma, ohm: what is not told to the user may be there. Up to R_1 it is R_1 that is known
    /// wrongly, and counts if it is likely; what R_x is more is off by the same share, and counts beyond so many `sigmas`.
    pub fn u_ohm(&self, r1_ohm: f64, r_ohm: f64, sigmas: f64) -> f64 {
        let beyond = |sigmas: f64| self.beyond(sigmas * self.0.noise()).unwrap_or(0.0);
        let more_ohm = (r_ohm - ABSORPTION_GROWS * r1_ohm).max(0.0);
        beyond(ABSORPTION_LIKELY) * BY_ABSORPTION * r1_ohm + beyond(sigmas) * more_ohm
    }

    fn beyond(&self, chance: f64) -> Option<f64> {
        let share = self.0.median().abs();
        (self.0.taken() >= ABSORPTION_FIRST && share > chance).then_some(share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_beyond_noise_shows() {
        let shown = |share: f64| {
            let mut test = AbsorptionTest::default();
            for index in 0..ABSORPTION_FIRST {
                assert!(test.is_due(Nanos(1)) && test.share().is_none());
                let noise = if index % 2 == 0 { 5e-4 } else { -5e-4 };
                test.add(Some([share + noise, 2.5e-7]), Nanos::ZERO);
            }
            assert!(!test.is_due(Nanos(1)) && test.is_due(ABSORPTION_EVERY));
            test.share()
        };
        assert!(shown(0.0).is_none() && shown(2e-3).is_some_and(|share| (share - 2e-3).abs() < 6e-4));
    }
}
