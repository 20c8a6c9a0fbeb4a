//! Leakage, by discharges that were held back.
//!
//! A discharge is interrupted [early or late](LEAK_HELD_AT) on its way for the time h. While everything floats, a leak of conductance
//! G takes G h off the rest of it, so that it ends G h (R_2+Ro) earlier; what feeds the node, as a pull-up does, makes it
//! later. At the voltage [between](LEAK_AVERAGE) either does what it does on average over a discharge, so that one number tells both. What
//! both levels differ by tells whether it is a resistor to ground at all: a current, a pull-up, a pull-up beside a leak and a
//! dielectric that takes charge in or gives it back are none, and what they do to readings is not known so well.
//!
//! What a leak at node A does to a reading: a discharge through R takes g (R+Ro) / (1 + G (R+Ro)), and two-point calibration
//! makes of it a resistance that is too high between R_1 and R_2 and too low elsewhere: [`error_ohm`]. Where R_2 sinks beside the
//! sensor (QERM), the leak takes the same part in the discharge as in that of R_2 alone and cancels: T_x* is g (R_x+Ro), and
//! only the calibration is wrong.

use crate::estimate::limits::{
    COVERAGE, GROSS_LEAK_SIEMENS, LEAK_AVERAGE, LEAK_BENT, LEAK_EVERY, LEAK_FIRST, LEAK_GROSS_FIRST,
    LEAK_HELD_AT, LEAK_HOLD, LEAK_LEFT, LEAK_REMEMBERED, LIKELY_LEAK_SIEMENS, LOOK_SHOWS,
};
use crate::estimate::look::{Looks, beyond};
use crate::record::Record;
use crate::units::Nanos;

/// The held discharges so far, siemens, at either level.
#[derive(Debug, Clone, Copy, Default)]
pub struct LeakTest {
    looks: [Looks<LEAK_REMEMBERED>; 2],
    /// The leak when it last changed.
    before: f64,
}

impl LeakTest {
    /// What others have [found](Self::found).
    pub fn known(levels: [[f64; 2]; 2]) -> LeakTest {
        let mut test = LeakTest { looks: levels.map(Looks::known), before: 0.0 };
        test.before = test.likely_siemens();
        test
    }

    /// The leak at either level with 1 sigma, siemens, once it is known. A level of which nothing is known is as the other.
    pub fn found(&self) -> Option<[[f64; 2]; 2]> {
        let [early, late] = &self.looks;
        let known =
            [[early, late], [late, early]].map(|[own, other]| if own.taken() > 0 { own } else { other });
        self.is_known().then(|| known.map(|looks| [looks.median(), looks.noise()]))
    }

    /// Whether a held discharge is due.
    pub fn is_due(&self, now: Nanos) -> bool {
        // Nothing is measured meanwhile, so it is seen at once when that is over.
        self.is_defect() || self.looks.iter().any(|looks| looks.is_due(now, LEAK_FIRST / 2, LEAK_EVERY))
    }

    /// After which part of it the next one is to be held.
    pub fn held_at(&self) -> f64 {
        LEAK_HELD_AT[self.next()]
    }

    /// The first ones at the end, where a defect of any kind shows, then by turns.
    fn next(&self) -> usize {
        let [early, late] = self.looks.each_ref().map(Looks::tried);
        usize::from(early + late < LEAK_GROSS_FIRST || late <= early)
    }

    /// Takes the one that was [due](Self::held_at), whether it told something or not. `lost_ns`: by how much it was shorter, with its
    /// variance; `r_ohm`: R_2.
    pub fn add(&mut self, lost: Option<(f64, f64)>, r_ohm: f64, now: Nanos) {
        let siemens = |(lost_ns, variance): (f64, f64)| {
            [siemens_by(lost_ns, r_ohm), siemens_by(variance.sqrt(), r_ohm).powi(2)]
        };
        self.looks[self.next()].add(lost.map(siemens), now);
    }

    /// The leak, siemens, if there is one that shows; negative for what feeds the node.
    pub fn siemens(&self) -> Option<f64> {
        let leak = self.likely_siemens();
        (self.is_known() && leak.abs() > self.gate()).then_some(leak)
    }

    /// 1 sigma of that, siemens.
    pub fn u_siemens(&self) -> f64 {
        let ([early, late], [of_early, of_late]) = (self.weights(), self.looks.each_ref().map(Looks::noise));
        (early * of_early).hypot(late * of_late)
    }

    /// By how much more or less it takes at the end of a discharge than at its beginning, beyond what noise does once in twenty times,
    /// siemens: nothing to speak of through a resistor to ground.
    pub fn bent_siemens(&self) -> f64 {
        let [early, late] = &self.looks;
        if !self.is_known() || early.taken() == 0 || late.taken() == 0 {
            return 0.0;
        }
        beyond(late.median() - early.median(), COVERAGE * early.noise().hypot(late.noise()))
    }

    /// Whether there is a leak beside which nothing can be measured.
    pub fn is_defect(&self) -> bool {
        self.is_known() && self.likely_siemens().abs() > GROSS_LEAK_SIEMENS
    }

    /// Whether the leak has come, grown or gone since this last was so.
    pub fn has_changed(&mut self) -> bool {
        let leak = self.likely_siemens();
        // Of a defect nothing is measured, however it changes.
        let is_defect = leak.abs().min(self.before.abs()) > GROSS_LEAK_SIEMENS;
        let has_changed = self.is_known() && !is_defect && (leak - self.before).abs() > self.gate();
        if has_changed {
            self.before = leak;
        }
        has_changed
    }

    /// Whether the look is wanting without which nothing is to be said of a sensor, or those that make sure of a defect.
    pub fn is_wanting(&self) -> bool {
        let tried: usize = self.looks.iter().map(Looks::tried).sum();
        tried == 0 || tried < LEAK_GROSS_FIRST && self.is_gross()
    }

    /// Whether there have been looks enough: for a defect a few that agree, since nothing else is so large.
    pub fn is_known(&self) -> bool {
        let taken: usize = self.looks.iter().map(Looks::taken).sum();
        taken >= if self.is_gross() { LEAK_GROSS_FIRST } else { LEAK_FIRST }
    }

    /// Whether each look so far has shown a defect.
    fn is_gross(&self) -> bool {
        let all = || self.looks.iter().flat_map(|looks| looks.remembered());
        [1.0, -1.0].iter().any(|sign| all().all(|siemens| sign * siemens > GROSS_LEAK_SIEMENS))
    }

    /// The likely leak, siemens, whether it shows or not: nobody has seen that there is none. Before there has been a look, one
    /// that could be.
    pub fn likely_siemens(&self) -> f64 {
        if !self.is_known() {
            return LIKELY_LEAK_SIEMENS;
        }
        let ([early, late], [by_early, by_late]) = (self.weights(), self.looks.each_ref().map(Looks::median));
        early * by_early + late * by_late
    }

    /// The parts of both levels in what a leak does on average over a discharge; of a level of which nothing is known, none.
    fn weights(&self) -> [f64; 2] {
        let [early, late] = LEAK_HELD_AT;
        let of_late = match self.looks.each_ref().map(Looks::taken) {
            [0, _] => 1.0,
            [_, 0] => 0.0,
            _ => (LEAK_AVERAGE - early) / (late - early),
        };
        [1.0 - of_late, of_late]
    }

    fn gate(&self) -> f64 {
        LOOK_SHOWS * self.u_siemens()
    }
}

/// What a leak does to a discharge of the sensor depends on this.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    pub r_ohm: f64,
    /// How long another resistor finished it, in times of the sensor's own part; 0 where none did.
    pub after: f64,
    /// It went on to node B.
    pub is_to_b: bool,
    /// Of the circuit.
    pub nodes: usize,
}

impl Course {
    pub fn of(record: &Record, r_ohm: f64, nodes: usize) -> Course {
        let ended_ns = record.b_ns.or(record.a_ns);
        let after =
            record.switch.zip(ended_ns).map(|(switch, ns)| (ns - switch.on_ns).max(0.0) / switch.at_ns);
        Course { r_ohm, after: after.unwrap_or(0.0), is_to_b: nodes == 2 && record.b_ns.is_some(), nodes }
    }

    /// What a known leak leaves in a reading that is corrected for its error, 1 sigma, ohm.
    pub fn left_ohm(&self, leak: &LeakTest, error_ohm: f64, [r1, r2]: [f64; 2]) -> f64 {
        let siemens = leak.likely_siemens();
        let [of_error, of_calibration, of_sensor] = LEAK_LEFT[self.nodes - 1];
        let error = of_error.hypot(leak.u_siemens() / siemens) * error_ohm;
        error.hypot((of_calibration * r1).hypot(of_sensor * self.r_ohm) * r2 * siemens)
    }

    /// What one that need not be to ground does beside that.
    pub fn bent_ohm(&self, leak: &LeakTest, [r1, r2]: [f64; 2]) -> f64 {
        let [of_error, of_calibration, of_sensor, to_a, to_b] = LEAK_BENT[self.nodes - 1];
        let error = of_error * (self.r_ohm - r1) * (r2 - self.r_ohm);
        let calibration = (of_calibration * r1).hypot(of_sensor * self.r_ohm) * r2;
        let finish = if self.is_to_b { to_b } else { to_a } * self.r_ohm.powi(2) * self.after;
        leak.bent_siemens() * error.hypot(calibration).hypot(finish)
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
        let spikes = tested(LEAK_FIRST, |index| if index % 5 == 0 { 200_000.0 } else { 1000.0 });
        assert_eq!(spikes.siemens(), None);
        // What does not show may still be there.
        assert!((spikes.likely_siemens() - siemens_by(1000.0, 12_700.0)).abs() < 1e-15);
        // One that goes is forgotten.
        let gone =
            tested(4 * LEAK_REMEMBERED, |index| if index < 2 * LEAK_REMEMBERED { 508_000.0 } else { 0.0 });
        assert_eq!((gone.siemens(), gone.likely_siemens()), (None, 0.0));
    }

    #[test]
    fn what_was_found_is_known_elsewhere_until_other_looks_replace_it() {
        let found = tested(2 * LEAK_REMEMBERED, |_| 508_000.0);
        let mut known = LeakTest::known(found.found().unwrap());
        let [of_found, of_known] = [&found, &known].map(|test| [test.likely_siemens(), test.u_siemens()]);
        assert!(of_found.iter().zip(of_known).all(|(found, known)| (found / known - 1.0).abs() < 1e-9));
        assert!(known.siemens().is_some() && !known.has_changed() && !known.is_wanting());
        for _ in 0..2 * LEAK_REMEMBERED {
            known.add(Some((0.0, 1.8e7)), 12_700.0, Nanos::ZERO);
        }
        assert_eq!((known.siemens(), known.likely_siemens()), (None, 0.0));
        assert_eq!(tested(1, |_| 508_000.0).found(), None);
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

    /// What a node loses while a discharge is held, in time, for 1 uA into it, a pull-up of 1 Mohm, or both of that and a leak of as much.
    #[test]
    fn what_is_no_resistor_to_ground_shows_by_the_two_levels() {
        let of = |current_ua: fn(f64) -> f64| {
            let mut test = LeakTest::default();
            for _ in 0..LEAK_FIRST {
                let v = 3.3 * 3f64.powf(-test.held_at());
                let lost_ns = LEAK_HOLD.as_ns() * 12_700.0 * 1e-6 * current_ua(v) / v;
                test.add(Some((lost_ns, 2.0 * 3000f64.powi(2))), 12_700.0, Nanos::ZERO);
            }
            test
        };
        let bent = |test: &LeakTest| 1e6 * test.bent_siemens();
        let to_ground = of(|v| v);
        assert!(bent(&to_ground) < 1e-9 && (1e6 * to_ground.likely_siemens() - 1.0).abs() < 1e-9);
        // On average over a discharge from 3.3 to 1.1 V: (1/1.1 V - 1/3.3 V) / ln 3 for each ampere.
        let current = of(|_| -1.0);
        let average = (1.0 / 1.1 - 1.0 / 3.3) / 3f64.ln();
        assert!((1e6 * current.likely_siemens() / -average - 1.0).abs() < 0.03, "{current:?}");
        assert!((0.2..0.3).contains(&bent(&current)), "{current:?}");
        let hidden = of(|v| v - (3.3 - v));
        assert!((0.7..0.9).contains(&bent(&hidden)), "{hidden:?}");
        assert!(hidden.likely_siemens().abs() < 0.2e-6, "{hidden:?}");
    }

    #[test]
    fn a_known_leak_leaves_less_with_one_node_and_more_that_is_none_to_ground() {
        let (r, test) = ([510.0, 12_740.0], tested(LEAK_FIRST, |_| 508_000.0));
        let course = |r_ohm, nodes| Course { r_ohm, after: 0.05, is_to_b: false, nodes };
        let error = error_ohm(1e-6, r, 5000.0, false).unwrap();
        assert!(course(5000.0, 1).left_ohm(&test, error, r) < 0.12 * error);
        assert!(course(5000.0, 2).left_ohm(&test, error, r) > error);
        // Nor is there certainty where the error is none.
        assert!(course(510.0, 2).left_ohm(&test, 0.0, r) > 1.0);
        assert_eq!(course(510.0, 1).bent_ohm(&test, r), 0.0);
        let bent =
            tested(LEAK_FIRST, |index| if [2, 3, 5, 7].contains(&index) { 300_000.0 } else { 500_000.0 });
        assert!(course(510.0, 2).bent_ohm(&bent, r) > course(510.0, 1).bent_ohm(&bent, r));
        let later = Course { after: 1.0, ..course(510.0, 1) };
        assert!(
            later.bent_ohm(&bent, r) > course(510.0, 1).bent_ohm(&bent, r)
                && course(510.0, 1).bent_ohm(&bent, r) > 0.5
        );
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
        let mut test = tested(2 * LEAK_REMEMBERED, |_| 0.0);
        let mut more = 0;
        while !test.has_changed() {
            test.add(Some((508_000.0, 1.8e7)), 12_700.0, Nanos::ZERO);
            more += 1;
            assert!(test.is_due(Nanos(1)) || test.siemens().is_some());
        }
        assert!(test.siemens().is_some() && !test.has_changed());
        assert!((LEAK_REMEMBERED - 2..=LEAK_REMEMBERED + 2).contains(&more), "{more}");
    }
}
