//! Charge that does not go through the resistors, but beside them or into a dielectric: no number where the law of the circuit
//! does not hold, a wider one where it nearly does.

use super::Estimator;
use crate::circuit::NOMINAL_R_O;
use crate::estimate::absorption::AbsorptionTest;
use crate::estimate::awake::{AwakeTest, of_stamp_ns, resistor_of};
use crate::estimate::leak::{Beside, Course, LeakTest, Ways};
use crate::estimate::limits::{
    ABSORPTION_LIKELY, BEYOND_NOISE, COVERAGE, GROSS_LEAK_SIEMENS, HIGHEST_R_O_OHM, LATEST_STAMP_NS,
    RESISTOR_TOLERANCE, UNKNOWN_JITTER_NS,
};
use crate::estimate::method::dual::Gradient;
use crate::estimate::tracker::Tracker;
use crate::reading::{Fault, Measured};
use crate::record::{CalibrationKind, Crossings, Record};
use crate::units::Nanos;

impl Estimator {
    /// Says nothing of leaks.
    pub fn ignore_leaks(&mut self) {
        self.leak = None;
    }

    /// Takes over what looks have told of leaks.
    pub fn set_leak(&mut self, leak: &LeakTest) {
        self.leak = Some(*leak);
    }

    /// The same where something else is [undone](LeakTest::undone) from now on: the calibration in force is as if it had been before, and one
    /// that is followed is found anew.
    pub fn undo_leak(&mut self, leak: &LeakTest) {
        let before = self.undone_times();
        self.set_leak(leak);
        let now = self.undone_times();
        let known = [(&mut self.c1, CalibrationKind::First), (&mut self.c2, CalibrationKind::Second)];
        for (index, (calibration, kind)) in known.into_iter().enumerate() {
            let Some(ns) = calibration else { continue };
            let times = [0, 1].map(|node| now[index][node] / before[index][node]);
            let more_ns = [0, 1].map(|node| ns[node].map_or(0.0, |ns| ns * (times[node] - 1.0)));
            self.noise.expect_later(kind, more_ns);
            *ns = [0, 1].map(|node| ns[node].map(|ns| ns + more_ns[node]));
        }
        self.begin_anew();
    }

    /// Takes a discharge in which the program woke, beside those of calibration: as [`AwakeTest::add`].
    pub fn add_awake(&mut self, resistor: usize, longer_ns: Option<[f64; 2]>, now: Nanos) {
        let awake = self.tracker.as_mut().map_or(&mut self.awake, Tracker::awake_mut);
        awake.add(resistor, longer_ns, 0.0, now);
    }

    /// Whether nothing is said of leaks.
    pub fn ignores_leaks(&self) -> bool {
        self.leak.is_none()
    }

    /// Takes over what others have found of stamps after long waits.
    pub fn set_awake(&mut self, awake: AwakeTest) {
        *self.tracker.as_mut().map_or(&mut self.awake, Tracker::awake_mut) = awake;
    }

    /// Whether stamps are later after long waits.
    pub fn awake(&self) -> &AwakeTest {
        self.tracker.as_ref().map_or(&self.awake, Tracker::awake)
    }

    /// What that does to a ratio, 1 sigma: each of its crossings may be later by what shows after such a wait, and d is by any of them.
    pub(super) fn asleep(&self, by: &Gradient, record: &Record) -> Option<f64> {
        let ((c1, _), later_ns) = (self.calibration()?, self.awake().beyond_ns(COVERAGE));
        let ([after_first, after_second], of_stamp) = (later_ns, of_stamp_ns(later_ns, record, c1[0]?));
        let crossings = [(by.c1, after_first), (by.c2, after_second), (by.x, of_stamp)];
        let of_crossings = crossings.map(|([a, b], late_ns)| a.hypot(b) * late_ns);
        Some(of_crossings.into_iter().fold(by.offset * after_first.max(after_second), f64::hypot))
    }

    /// Takes over what capacitors absorb.
    pub fn set_absorption(&mut self, absorption: &AbsorptionTest) {
        self.absorption = *absorption;
    }

    /// Whether a discharge through 0 ohm would take the time that a pin explains: Ro if d is known, Ro + d/g if not. A path
    /// of its own bends the straight line of times against resistors, and where that line begins tells it.
    pub(super) fn check_paths(&self) -> Result<(), Fault> {
        let leak = self.leak.as_ref().map(LeakTest::likely_siemens);
        if let Some(siemens) = leak.filter(|siemens| siemens.abs() > GROSS_LEAK_SIEMENS) {
            return Err(if siemens > 0.0 { Fault::Leakage } else { Fault::PullUp });
        }
        let Some((at_zero_ohm, u_ohm, unknown_ohm)) = self.at_zero() else { return Ok(()) };
        let tolerance_ohm = RESISTOR_TOLERANCE * self.r1_ohm * self.r2_ohm / (self.r2_ohm - self.r1_ohm);
        let doubt_ohm = tolerance_ohm + BEYOND_NOISE * u_ohm;
        if at_zero_ohm > HIGHEST_R_O_OHM + unknown_ohm + doubt_ohm {
            return Err(Fault::Leakage);
        }
        if at_zero_ohm < -doubt_ohm { Err(Fault::PullUp) } else { Ok(()) }
    }

    /// What a discharge through 0 ohm seems to run through, its uncertainty, and what an unknown d may add to it, ohm.
    fn at_zero(&self) -> Option<(f64, f64, f64)> {
        if let Some(tracker) = self.tracker() {
            let (r_o_ohm, u_ohm) = tracker.offset().r_o_ohm?;
            return Some((r_o_ohm, u_ohm, 0.0));
        }
        let (c1, c2) = self.calibration()?;
        let span = self.r2_ohm - self.r1_ohm;
        let (c1_ns, c2_ns) = (c1[0]?, c2[0]?);
        let per_ohm = (c2_ns - c1_ns) / span;
        if per_ohm <= 0.0 {
            return None;
        }
        let jitter_ns = self.noise.covariance(c2).map_or(UNKNOWN_JITTER_NS, |noise| noise.aa.sqrt());
        let u_ns = jitter_ns * self.r2_ohm.hypot(self.r1_ohm) / span;
        let unknown_ns = if self.offset.r_o_ohm.is_some() { 0.0 } else { LATEST_STAMP_NS };
        Some(((c1_ns - self.offset.d_ns) / per_ohm - self.r1_ohm, u_ns / per_ohm, unknown_ns / per_ohm))
    }

    /// What a leak may make of a reading; `None` if no resistance is too high for it.
    pub(super) fn leaked(&self, r_ohm: f64, record: &Record) -> Option<Leaked> {
        let Some(leak) = &self.leak else { return Some(Leaked::default()) };
        let (r, beside) = ([self.r1_ohm, self.r2_ohm], self.method.rules().sinks_beside);
        let (course, left) = (Course::of(record, r_ohm, self.nodes), leak.left());
        let shows = leak.siemens().is_some() || leak.undone().is_any();
        Some(Leaked {
            shows,
            left_ohm: course.left_ohm(&left, r, beside)?,
            bent_ohm: course.bent_ohm(&left, r),
        })
    }

    /// The same estimate with what leaks, dielectrics and stamps may have made of it in its uncertainty. `None` if the sensor may have
    /// any higher resistance.
    pub(super) fn with_defects(&self, r_ohm: Measured, leaked: &Leaked, stamps_ohm: f64) -> Option<Measured> {
        let Leaked { left_ohm, bent_ohm, .. } = *leaked;
        let is_bounded = r_ohm.value < self.r2_ohm || r_ohm.value > COVERAGE * left_ohm;
        let path_ohm = r_ohm.value + self.offset().r_o().unwrap_or(0.0);
        // What chance makes of no dielectric would show in readings of a calibration that is followed, and in their means.
        let sigmas = if self.tracker.is_some() { ABSORPTION_LIKELY } else { COVERAGE };
        let absorption_ohm = self.absorption.u_ohm(self.r1_ohm, path_ohm, sigmas);
        // That of the way that both sink, of which the sensor's resistance is a steeper function.
        let beside =
            if self.method.rules().sinks_beside { (1.0 + path_ohm / self.r2_ohm).powi(2) } else { 1.0 };
        let by_rounds_ohm = beside * self.offset.left_out_ohm;
        let left_out_ohm = self.state().map_or(by_rounds_ohm, |tracker| tracker.left_out_ohm(r_ohm.value));
        let defects = [left_ohm, bent_ohm, absorption_ohm, left_out_ohm, stamps_ohm];
        let u = r_ohm.u.map(|u| defects.into_iter().fold(u, f64::hypot));
        is_bounded.then_some(Measured { value: r_ohm.value, u })
    }

    /// What is undone of leaks in times, and by what. `None`: nothing.
    fn undoing(&self) -> Option<(Beside, Ways)> {
        let undone = self.leak.as_ref().map(LeakTest::undone).filter(|undone| undone.is_any())?;
        let ns = self.calibration().map(|(c1, c2)| [c1, c2]);
        let ways = Ways { r_ohm: self.paths_ohm(), ns, d_ns: self.offset().d_ns };
        let known = self.beside.filter(|beside| beside.is_of(&undone.lost(), &ways));
        Some((known.unwrap_or_else(|| Beside::of(undone.lost(), &ways)), ways))
    }

    /// How many times as long plain discharges through R_1 and R_2 would take without what is undone, until A crosses and until B does.
    fn undone_times(&self) -> [[f64; 2]; 2] {
        let undoing = self.undoing();
        let times = |resistor| undoing.map_or([1.0; 2], |(beside, ways)| beside.times(resistor, &ways));
        [0, 1].map(times)
    }

    /// R_1 and R_2 with Ro, as it usually is as long as it is not known, ohm.
    pub fn paths_ohm(&self) -> [f64; 2] {
        let r_o_ohm = self.r_o_ohm().unwrap_or(NOMINAL_R_O.0);
        [self.r1_ohm + r_o_ohm, self.r2_ohm + r_o_ohm]
    }

    /// A discharge as it would have been without the leak that shows.
    pub fn without_leak(&mut self, record: &Record) -> Record {
        let Some((beside, ways)) = self.undoing() else { return *record };
        self.beside = Some(beside);
        beside.left_out_of(record, &ways)
    }

    /// When the nodes cross on the board, in plain discharges of a kind that would cross then without, ns.
    pub fn with_leak_ns(&self, ns: Crossings, kind: CalibrationKind) -> Crossings {
        let Some((resistor, (beside, ways))) = resistor_of(kind).zip(self.undoing()) else { return ns };
        let times = beside.times(resistor, &ways);
        [0, 1].map(|node| ns[node].map(|ns| ns / times[node]))
    }
}

/// What a leak makes of a reading, ohm.
#[derive(Default)]
pub(super) struct Leaked {
    shows: bool,
    /// What is not undone, and what one that need not be to ground does beside that, 1 sigma.
    left_ohm: f64,
    bent_ohm: f64,
}

impl Leaked {
    /// What is not undone, 1 sigma, ohm.
    pub(super) fn left_ohm(&self) -> f64 {
        self.left_ohm
    }

    /// By how much a leak that shows may make the crossings disagree, 1 sigma, ohm: they have it for a part of the way each, and what
    /// is left of it in one need not be in the other.
    pub(super) fn disagree_ohm(&self) -> f64 {
        if self.shows { self.left_ohm.hypot(self.bent_ohm) } else { 0.0 }
    }
}
