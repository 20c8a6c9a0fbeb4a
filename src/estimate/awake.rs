//! Discharges through R_1 and R_2 whose crossing finds the processor awake: is a stamp as late after a short wait as after a long one?
//!
//! A processor that has nothing to do for long sleeps more deeply, and stamps later. Discharges through R_1, R_2 and both that wait as
//! long as they take agree with each other, whatever all of them are late by; a sensor's waits for another time. So the program
//! wakes shortly before some of them end, which changes nothing in the circuit: a switch to the resistor that sinks already.
//!
//! What they are compared with must not have been corrected by them: once there are enough, each by its own with the one just before it in
//! which the program slept, whatever the state has become.

use crate::estimate::limits::{
    AWAKE_AGAIN, AWAKE_EVERY, AWAKE_FIRST, AWAKE_MARGIN, AWAKE_PAIRS, AWAKE_REMEMBERED, AWAKE_SHOWS,
    AWAKE_YOUNG, LATEST_STAMP_NS,
};
use crate::estimate::look::{Looks, beyond};
use crate::record::{CalibrationKind, Record, Through};
use crate::units::Nanos;

/// By how much node A crossed beside a usual discharge, ns: through R_1, and through R_2.
#[derive(Debug, Clone, Copy, Default)]
pub struct AwakeTest {
    looks: [Looks<AWAKE_REMEMBERED>; 2],
    /// How well the usual one is known, 1 sigma, ns.
    u_usual_ns: [f64; 2],
    /// By how much it crossed beside the last one in which the program slept, and when that one did beside the state, with the variance.
    pairs: [Looks<AWAKE_REMEMBERED>; 2],
    asleep: [Option<[f64; 2]>; 2],
    /// Plain discharges so far, whether the program woke in them or not.
    plain: [u32; 2],
}

impl AwakeTest {
    /// What others have [found](Self::found).
    pub fn known(by_resistor: [[f64; 2]; 2]) -> AwakeTest {
        AwakeTest { looks: by_resistor.map(Looks::known), ..AwakeTest::default() }
    }

    /// By how much later or earlier stamps are after a wait as long as through each resistor, ns, with 1 sigma, once both are known.
    pub fn found(&self) -> Option<[[f64; 2]; 2]> {
        let [first, second] = [0, 1].map(|resistor| self.longer_ns(resistor));
        Some([first?, second?])
    }

    /// Whether the next plain discharge through a resistor is to be such a one, where they are calibration discharges.
    pub fn is_next(&self, resistor: usize) -> bool {
        let every = if self.looks[resistor].taken() < AWAKE_YOUNG { 1 } else { AWAKE_EVERY };
        self.plain[resistor] % every == every - 1
    }

    /// The resistor that is due, where they come beside calibration discharges.
    pub fn due(&self, now: Nanos) -> Option<usize> {
        let is_due = |resistor: &usize| self.looks[*resistor].is_due(now, AWAKE_FIRST, AWAKE_AGAIN);
        (0..2).filter(is_due).min_by_key(|resistor| self.looks[*resistor].tried())
    }

    /// Counts a plain discharge.
    pub fn count(&mut self, resistor: usize) {
        self.plain[resistor] = self.plain[resistor].wrapping_add(1);
    }

    /// Takes one in which the program woke, whether it told something or not: by how much it was longer, with its variance, and how well
    /// the usual one is known.
    pub fn add(&mut self, resistor: usize, longer_ns: Option<[f64; 2]>, u_usual_ns: f64, now: Nanos) {
        self.u_usual_ns[resistor] = u_usual_ns;
        self.looks[resistor].add(longer_ns, now);
        if let Some((awake, asleep)) = longer_ns.zip(self.asleep[resistor].take()) {
            self.pairs[resistor].add(Some([awake[0] - asleep[0], awake[1] + asleep[1]]), now);
        }
    }

    /// Takes one in which it slept, for the next in which it wakes: by how much it was longer than the state says, with its variance.
    pub fn add_asleep(&mut self, resistor: usize, longer_ns: Option<[f64; 2]>) {
        self.asleep[resistor] = longer_ns;
    }

    /// By how much longer those are in which it woke, ns, with 1 sigma, once that is known.
    fn longer_ns(&self, resistor: usize) -> Option<[f64; 2]> {
        let (looks, pairs) = (&self.looks[resistor], &self.pairs[resistor]);
        let (looks, first, u_usual_ns) = match pairs.taken() {
            ..AWAKE_PAIRS => (looks, AWAKE_FIRST, self.u_usual_ns[resistor]),
            _ => (pairs, AWAKE_PAIRS, 0.0),
        };
        (looks.taken() >= first).then(|| [looks.median(), looks.noise().hypot(u_usual_ns)])
    }

    /// By how much later stamps are after a wait as long as a discharge through a resistor, and the uncertainty of that, 1 sigma, ns.
    fn shown_ns(&self, resistor: usize) -> [f64; 2] {
        // What is more is no latency: the circuit was another one meanwhile.
        let latency = self.longer_ns(resistor).filter(|[longer_ns, _]| longer_ns.abs() <= LATEST_STAMP_NS);
        latency.map_or([0.0; 2], |[longer_ns, u_ns]| [longer_ns.abs(), u_ns])
    }

    /// Whether there were enough to tell whether they are like the others.
    pub fn tells(&self, resistor: usize) -> bool {
        self.longer_ns(resistor).is_some()
    }

    /// Whether they are longer than the others or shorter for certain.
    pub fn shows(&self, resistor: usize) -> bool {
        let [shown_ns, u_ns] = self.shown_ns(resistor);
        shown_ns > AWAKE_SHOWS * u_ns
    }

    /// By how much later stamps are after long waits, ns, if that shows.
    pub fn late_ns(&self) -> Option<f64> {
        let shown = [0, 1].into_iter().filter(|resistor| self.shows(*resistor));
        shown.map(|resistor| self.shown_ns(resistor)[0]).reduce(f64::max)
    }

    /// What of it is beyond so many sigma, after waits as long as through R_1 and R_2.
    pub fn beyond_ns(&self, sigmas: f64) -> [f64; 2] {
        [0, 1].map(|resistor| {
            let [shown_ns, u_ns] = self.shown_ns(resistor);
            beyond(shown_ns, sigmas * u_ns)
        })
    }
}

/// By how much the stamp of a sensor's discharge may be later or earlier than those that it is compared with, if they are later by so
/// much: after a wait that was no longer than one for R_1, which takes `first_ns`, as after that.
pub fn of_stamp_ns([after_first, after_second]: [f64; 2], record: &Record, first_ns: f64) -> f64 {
    let waited_ns = record.a_ns.map(|a_ns| a_ns - record.switch.map_or(0.0, |switch| switch.on_ns));
    let is_by_second = record.switch.is_some_and(|switch| switch.to != Through::C1);
    let is_short = !is_by_second && waited_ns.is_some_and(|ns| ns <= first_ns);
    if is_short { after_first } else { after_first.max(after_second) }
}

/// When to wake before a crossing that is due, ns; `jitter_ns`: its noise. How late it is stamped is not known. `None` where that is
/// before the start.
pub fn wake_ns(due_ns: f64, jitter_ns: f64) -> Option<f64> {
    Some(due_ns - LATEST_STAMP_NS - AWAKE_MARGIN * jitter_ns).filter(|at_ns| *at_ns > 0.0)
}

/// The resistor of a plain calibration discharge: 0 for R_1, 1 for R_2.
pub fn resistor_of(kind: CalibrationKind) -> Option<usize> {
    match kind {
        CalibrationKind::First => Some(0),
        CalibrationKind::Second => Some(1),
        CalibrationKind::Split => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::limits::AWAKE_COUNTS;
    use crate::record::Switch;

    fn tested(count: usize, of: [f64; 2]) -> AwakeTest {
        let mut test = AwakeTest::default();
        for (index, resistor) in (0..count).flat_map(|index| [(index, 0), (index, 1)]) {
            let noise = if index % 2 == 0 { 5e3 } else { -5e3 };
            test.add(resistor, Some([noise - of[resistor], 2.5e7]), 0.0, Nanos::ZERO);
        }
        test
    }

    #[test]
    fn what_is_beyond_noise_shows_and_counts() {
        assert_eq!(tested(AWAKE_FIRST - 1, [60e3; 2]).late_ns(), None);
        for count in [AWAKE_FIRST, 2 * AWAKE_REMEMBERED] {
            let none = tested(count, [0.0; 2]);
            assert_eq!((none.late_ns(), none.beyond_ns(AWAKE_COUNTS)), (None, [0.0; 2]), "{count}");
        }
        assert_eq!(tested(AWAKE_FIRST, [1e6; 2]).beyond_ns(AWAKE_COUNTS), [0.0; 2], "no latency");
        let late = tested(2 * AWAKE_REMEMBERED, [0.0, 4e3]);
        assert!(late.late_ns().is_some_and(|ns| (ns - 4e3).abs() < 1.0) && !late.shows(0), "{late:?}");
        let [first, second] = late.beyond_ns(AWAKE_COUNTS);
        assert!(first == 0.0 && (3.5e3..4e3).contains(&second), "{late:?}");
    }

    #[test]
    fn a_state_that_both_have_corrected_hides_no_half_of_it() {
        let mut test = AwakeTest::default();
        for index in 0..2 * AWAKE_PAIRS {
            assert_eq!(test.late_ns().is_some_and(|ns| ns > 3.5e3), index >= AWAKE_PAIRS, "{index}");
            let noise = if index % 2 == 0 { 1e3 } else { -1e3 };
            test.add_asleep(1, Some([2e3 + noise, 1e6]));
            test.add(1, Some([noise - 2e3, 1e6]), 0.0, Nanos::ZERO);
        }
        assert!(test.late_ns().is_some_and(|ns| (ns - 4e3).abs() < 1.0), "{test:?}");
    }

    #[test]
    fn a_short_wait_is_late_by_no_more_than_that_for_r_1() {
        let late = tested(2 * AWAKE_REMEMBERED, [0.0, 60e3]);
        let (first_ns, through) = (250e3, Through::X(0));
        let record = |a_ns: f64, to: Option<Through>| Record {
            through,
            start: Nanos::ZERO,
            second_ns: None,
            switch: to.map(|to| Switch { at_ns: 200e3, on_ns: 200e3, to }),
            a_ns: Some(a_ns),
            b_ns: None,
            u_switch_ns: None,
            later_ns: None,
            waited_ns: None,
        };
        let of = |a_ns, to| of_stamp_ns(late.beyond_ns(AWAKE_COUNTS), &record(a_ns, to), first_ns);
        assert_eq!((of(200e3, None), of(400e3, Some(Through::C1))), (0.0, 0.0));
        assert!(of(400e3, None) > 59e3 && of(300e3, Some(Through::C2)) > 59e3);
    }
}
