//! Leakage, by discharges that were held back.
//!
//! A discharge is interrupted at [half of its way](LEAK_HELD_AT) for the time h. While everything floats, a leak of conductance
//! G takes G h off the rest of it, so that it ends G h (R_2+Ro) earlier; what feeds the node, as a pull-up does, makes it
//! later. At that voltage either does what it does on average over a discharge, so that one number tells both. A dielectric
//! that takes charge in or gives it back looks the same.
//!
//! What a leak at node A does to a reading: a discharge through R takes g (R+Ro) / (1 + G (R+Ro)), and two-point calibration
//! makes of it a resistance that is too high between R_1 and R_2 and too low elsewhere: [`error_ohm`]. Where R_2 sinks beside the
//! sensor (QERM), the leak takes the same part in the discharge as in that of R_2 alone and cancels: T_x* is g (R_x+Ro), and
//! only the calibration is wrong.

#[cfg(doc)]
use crate::estimate::limits::LEAK_HELD_AT;
use crate::estimate::limits::{
    GROSS_LEAK_SIEMENS, LEAK_EVERY, LEAK_FIRST, LEAK_GROSS_FIRST, LEAK_HOLD, LEAK_REMEMBERED,
    LIKELY_LEAK_SIEMENS,
};
use crate::estimate::look::Looks;
use crate::units::Nanos;

/// The held discharges so far, siemens.
#[derive(Debug, Clone, Copy, Default)]
pub struct LeakTest {
    looks: Looks<LEAK_REMEMBERED>,
    /// The leak when it last changed.
    before: f64,
}

impl LeakTest {
    /// Whether a held discharge is due.
    pub fn is_due(&self, now: Nanos) -> bool {
        // Nothing is measured meanwhile, so it is seen at once when that is over.
        let is_defect = self.is_known() && self.looks.median().abs() > GROSS_LEAK_SIEMENS;
        is_defect || self.looks.is_due(now, LEAK_FIRST, LEAK_EVERY)
    }

    /// Takes one, whether it told something or not. `lost_ns`: by how much it was shorter, with its variance; `r_ohm`: R_2.
    pub fn add(&mut self, lost: Option<(f64, f64)>, r_ohm: f64, now: Nanos) {
        let siemens = |(lost_ns, variance): (f64, f64)| {
            [siemens_by(lost_ns, r_ohm), siemens_by(variance.sqrt(), r_ohm).powi(2)]
        };
        self.looks.add(lost.map(siemens), now);
    }

    /// The leak, siemens, if there is one that shows; negative for what feeds the node.
    pub fn siemens(&self) -> Option<f64> {
        let leak = self.likely_siemens();
        (self.is_known() && leak.abs() > self.looks.gate()).then_some(leak)
    }

    /// Whether the leak has come, grown or gone since this last was so.
    pub fn has_changed(&mut self) -> bool {
        let leak = self.likely_siemens();
        // Of a defect nothing is measured, however it changes.
        let is_defect = leak.abs().min(self.before.abs()) > GROSS_LEAK_SIEMENS;
        let has_changed = self.is_known() && !is_defect && (leak - self.before).abs() > self.looks.gate();
        if has_changed {
            self.before = leak;
        }
        has_changed
    }

    /// Whether the look is wanting without which nothing is to be said of a sensor, or those that make sure of a defect.
    pub fn is_wanting(&self) -> bool {
        let tried = self.looks.tried();
        tried == 0 || tried < LEAK_GROSS_FIRST && self.is_gross()
    }

    /// Whether there have been looks enough: for a defect a few that agree, since nothing else is so large.
    pub fn is_known(&self) -> bool {
        self.looks.taken() >= if self.is_gross() { LEAK_GROSS_FIRST } else { LEAK_FIRST }
    }

    /// Whether each look so far has shown a defect.
    fn is_gross(&self) -> bool {
        let all =
            |sign: f64| self.looks.remembered().iter().all(|siemens| sign * siemens > GROSS_LEAK_SIEMENS);
        all(1.0) || all(-1.0)
    }

    /// The likely leak, siemens, whether it shows or not: nobody has seen that there is none. Before there has been a look, one
    /// that could be.
    pub fn likely_siemens(&self) -> f64 {
        if self.is_known() { self.looks.median() } else { LIKELY_LEAK_SIEMENS }
    }
}

/// The leak that makes a held discharge through `r_ohm` shorter by `lost_ns`, siemens.
pub fn siemens_by(lost_ns: f64, r_ohm: f64) -> f64 {
    lost_ns / (LEAK_HOLD.as_ns() * r_ohm)
}

/// By how much a leak at node A makes a reading of `r_ohm` too high (or too low, where negative), ohm; `None`: no
/// resistance is too high for it. `sinks_beside`: R_2 sinks with the sensor.
pub fn error_ohm(siemens: f64, [r1, r2]: [f64; 2], r_ohm: f64, sinks_beside: bool) -> Option<f64> {
    if sinks_beside {
        // The chord itself.
        let [t1, t2] = [r1, r2].map(|r| r / (1.0 + siemens * r));
        return Some(r_ohm - t1 - (r_ohm - r1) / (r2 - r1) * (t2 - t1));
    }
    // The chord from R_1 to R_2 taken for the curve r / (1 + G r), the other way round.
    let left = 1.0 + siemens * (r2 + r1 - r_ohm);
    (left > 0.0).then(|| siemens * (r_ohm - r1) * (r2 - r_ohm) / left)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tested(count: usize, lost_ns: impl Fn(usize) -> f64) -> LeakTest {
        let mut test = LeakTest::default();
        for index in 0..count {
            test.add(Some((lost_ns(index), 2.0 * 3000f64.powi(2))), 12_700.0, Nanos::ZERO);
        }
        test
    }

    #[test]
    fn a_megohm_shows_at_once_and_spikes_do_not() {
        // 40 ms / 1 Mohm * 12.7 kohm.
        assert_eq!(tested(LEAK_FIRST - 1, |_| 508_000.0).siemens(), None);
        assert_eq!(tested(LEAK_FIRST - 1, |_| 0.0).likely_siemens(), LIKELY_LEAK_SIEMENS);
        for sign in [1.0, -1.0] {
            let found = tested(LEAK_FIRST, |_| sign * 508_000.0).siemens().unwrap();
            assert!((found * 1e6 - sign).abs() < 1e-9, "{found}");
        }
        let spikes = tested(LEAK_FIRST, |index| if index % 4 == 0 { 200_000.0 } else { 1000.0 });
        assert_eq!(spikes.siemens(), None);
        // What does not show may still be there.
        assert!((spikes.likely_siemens() - siemens_by(1000.0, 12_700.0)).abs() < 1e-15);
        // One that goes is forgotten.
        let gone = tested(2 * LEAK_REMEMBERED, |index| if index < LEAK_REMEMBERED { 508_000.0 } else { 0.0 });
        assert_eq!((gone.siemens(), gone.likely_siemens()), (None, 0.0));
    }

    #[test]
    fn a_defect_is_known_by_the_first_looks_and_one_spike_is_none() {
        // 40 ms / 50 kohm * 12.7 kohm.
        let defect = |count| tested(count, |_| 10.16e6);
        assert!(defect(LEAK_GROSS_FIRST - 1).is_wanting() && !defect(LEAK_GROSS_FIRST).is_wanting());
        assert!(LeakTest::default().is_wanting() && !tested(1, |_| 1000.0).is_wanting());
        assert_eq!(defect(LEAK_GROSS_FIRST - 1).siemens(), None);
        assert!(defect(LEAK_GROSS_FIRST).siemens().unwrap() > GROSS_LEAK_SIEMENS);
        let spike = tested(LEAK_GROSS_FIRST, |index| if index == 0 { 30e6 } else { 0.0 });
        assert!(!spike.is_known() && spike.siemens().is_none());
        assert!(!tested(LEAK_GROSS_FIRST, |index| if index == 0 { 30e6 } else { -30e6 }).is_known());
        let mut failed = LeakTest::default();
        (0..LEAK_GROSS_FIRST).for_each(|_| failed.add(None, 12_700.0, Nanos::ZERO));
        assert!(!failed.is_wanting() && !failed.is_known());
    }

    #[test]
    fn an_error_is_that_of_the_chord() {
        let (siemens, [r1, r2]) = (1e-5, [2320.0, 12_700.0]);
        let time = |r: f64| r / (1.0 + siemens * r);
        for r_ohm in [1.0, 100.0, 1000.0, 2320.0, 6000.0, 12_700.0, 30_000.0, 1e6] {
            let found = r1 + (time(r_ohm) - time(r1)) / (time(r2) - time(r1)) * (r2 - r1);
            let error = error_ohm(siemens, [r1, r2], found, false).unwrap();
            assert!((error - (found - r_ohm)).abs() < 1e-9 * r_ohm, "{r_ohm}: {found} {error}");
        }
        assert_eq!(error_ohm(siemens, [r1, r2], 200_000.0, false), None);
    }

    #[test]
    fn beside_r_2_a_leak_spoils_the_calibration_alone() {
        let (g, siemens, [r1, r2]) = (0.5, 1e-6, [470.0, 13_170.0]);
        let alone = |r: f64| g / (1.0 / r + siemens);
        for r_ohm in [1000.0, 5000.0, 40_000.0] {
            // g = s/R_x + T3 (1/R_2 + G), with the sensor released half-way.
            let s = 0.5 * g / (1.0 / r_ohm + 1.0 / r2 + siemens);
            let t3 = (g - s / r_ohm) / (1.0 / r2 + siemens);
            let t_x = s * alone(r2) / (alone(r2) - t3);
            let found = r1 + (t_x - alone(r1)) / (alone(r2) - alone(r1)) * (r2 - r1);
            let error = error_ohm(siemens, [r1, r2], found, true).unwrap();
            assert!((error - (found - r_ohm)).abs() < 1e-9 * r_ohm, "{r_ohm}: {found} {error}");
        }
    }

    #[test]
    fn the_first_tests_follow_each_other_and_failed_ones_end_too() {
        assert!(LeakTest::default().is_due(Nanos(1)) && tested(LEAK_FIRST - 1, |_| 0.0).is_due(Nanos(1)));
        let test = tested(LEAK_FIRST, |_| 0.0);
        assert!(!test.is_due(Nanos(1)) && test.is_due(LEAK_EVERY));
        let mut failed = LeakTest::default();
        (0..LEAK_FIRST).for_each(|_| failed.add(None, 12_700.0, LEAK_EVERY));
        assert!(!failed.is_due(LEAK_EVERY + Nanos(1)) && failed.siemens().is_none());
    }

    #[test]
    fn a_leak_that_comes_is_looked_at_again_at_once() {
        let mut test = tested(LEAK_REMEMBERED, |_| 0.0);
        let mut more = 0;
        while !test.has_changed() {
            test.add(Some((508_000.0, 1.8e7)), 12_700.0, Nanos::ZERO);
            more += 1;
            assert!(test.is_due(Nanos(1)) || test.siemens().is_some());
        }
        assert!(test.siemens().is_some() && !test.has_changed());
        assert!((LEAK_REMEMBERED / 2..=LEAK_REMEMBERED / 2 + 1).contains(&more), "{more}");
    }
}
