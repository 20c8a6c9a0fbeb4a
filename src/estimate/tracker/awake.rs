//! Plain calibration discharges whose crossing finds the processor awake: is a stamp as late after a short wait as after a long one?
//!
//! A processor that has nothing to do for long sleeps more deeply, and stamps later. R_1, R_2 and a split that wait as long as they
//! take agree on a state, whatever all of them are late by; a sensor's discharge waits for another time. So the program wakes
//! shortly before some of them end, which changes nothing in the circuit: a switch to the resistor that sinks already. Such
//! discharges correct the state as long as they agree with it.

use super::{Tracker, quadratic};
use crate::estimate::law::{D, State};
use crate::estimate::limits::{AWAKE_EVERY, AWAKE_FIRST, AWAKE_MARGIN, AWAKE_REMEMBERED, AWAKE_SHOWS};
use crate::estimate::look::Looks;
use crate::record::{CalibrationKind, Record, Through};

/// By how much node A crossed beside what the state says, ns, and how many plain discharges there were: through R_1, and R_2.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Awake {
    beside_ns: [Looks<AWAKE_REMEMBERED>; 2],
    /// What the state's own uncertainty is of the last one, 1 sigma, ns.
    u_state_ns: [f64; 2],
    plain: [u32; 2],
}

impl Tracker {
    /// When the program is to wake in the next calibration discharge of a kind, ns after its start, if it is to.
    pub fn wake_ns(&self, kind: CalibrationKind) -> Option<f64> {
        let resistor = plain(kind).filter(|_| self.ready && !self.is_doubted())?;
        let every = if self.awake.beside_ns[resistor].taken() < AWAKE_FIRST { 1 } else { AWAKE_EVERY };
        let takes_ns = self.takes_ns()[resistor];
        let jitter_ns = self.noise.covariance([takes_ns; 2])?.aa.sqrt();
        let at_ns = takes_ns - AWAKE_MARGIN * jitter_ns;
        (self.awake.plain[resistor] % every == every - 1 && at_ns > 0.0).then_some(at_ns)
    }

    /// Takes a calibration discharge for what it shows; whether the state is to be corrected by it, `None` where the program did
    /// not wake in it.
    pub(super) fn takes_awake(&mut self, kind: CalibrationKind, record: &Record) -> Option<bool> {
        let resistor = plain(kind)?;
        self.awake.plain[resistor] = self.awake.plain[resistor].wrapping_add(1);
        let switch = record.switch?;
        if record.a_ns.is_some_and(|a_ns| a_ns > switch.on_ns) {
            let (beside_ns, u_state_ns) = self.beside(kind, record).unzip();
            self.awake.u_state_ns[resistor] = u_state_ns.unwrap_or(self.awake.u_state_ns[resistor]);
            self.awake.beside_ns[resistor].add(beside_ns, record.start);
        }
        let [shown_ns, u_ns] = self.shown_awake_ns(resistor);
        Some(shown_ns <= AWAKE_SHOWS * u_ns)
    }

    /// By how much node A crossed later than expected, ns, the variance of that, and what the state's own uncertainty is of it,
    /// 1 sigma.
    pub(super) fn beside(&self, kind: CalibrationKind, record: &Record) -> Option<([f64; 2], f64)> {
        let ([a, _], noise) = self.expected(kind, record);
        let (_, noise) = noise?;
        let u_state_ns = quadratic(&self.covariance, &a.by_state).sqrt();
        Some(([record.a_ns? - a.ns, noise.aa], u_state_ns))
    }

    /// By how much later stamps are after a wait as long as a discharge through R_1 or R_2, and the uncertainty of that, 1 sigma, ns.
    fn shown_awake_ns(&self, resistor: usize) -> [f64; 2] {
        let (looks, u_state_ns) = (&self.awake.beside_ns[resistor], self.awake.u_state_ns[resistor]);
        let is_known = looks.taken() >= AWAKE_FIRST;
        if is_known { [looks.median().abs(), looks.noise().hypot(u_state_ns)] } else { [0.0; 2] }
    }

    /// The same beyond what chance makes of none.
    fn later_asleep_ns(&self) -> [f64; 2] {
        [0, 1].map(|resistor| {
            let [shown_ns, u_ns] = self.shown_awake_ns(resistor);
            (shown_ns.powi(2) - (AWAKE_SHOWS * u_ns).powi(2)).max(0.0).sqrt()
        })
    }

    /// By how much stamps are later after long waits, ns, if that shows.
    pub fn later_ns(&self) -> Option<f64> {
        let shown = [0, 1].map(|resistor| self.shown_awake_ns(resistor)).into_iter();
        shown.filter(|[shown_ns, u_ns]| *shown_ns > AWAKE_SHOWS * u_ns).map(|[ns, _]| ns).reduce(f64::max)
    }

    /// What that does to a reading, 1 sigma, ohm: `by_state` is how it depends on the state. Its own stamp is later by anything up to
    /// what shows after a wait that was not shorter, and so are those that the state is of.
    pub fn asleep_ohm(&self, r_ohm: f64, by_state: &State, record: &Record) -> f64 {
        let [after_first, after_second] = self.later_asleep_ns();
        let longest = after_first.max(after_second);
        if longest == 0.0 {
            return 0.0;
        }
        let [first_ns, second_ns] = self.takes_ns();
        let waited_ns = record.a_ns.map(|a_ns| a_ns - record.switch.map_or(0.0, |switch| switch.on_ns));
        let is_by_second = record.switch.is_some_and(|switch| switch.to != Through::C1);
        let is_short = !is_by_second && waited_ns.is_some_and(|ns| ns <= first_ns);
        let of_stamp = by_state[D] * if is_short { after_first } else { longest };
        // Splits and R_2 contradict each other by so much: Ro is wrong, and g.
        of_stamp.hypot((self.r_ohm[0] + r_ohm) / second_ns * longest)
    }
}

fn plain(kind: CalibrationKind) -> Option<usize> {
    match kind {
        CalibrationKind::First => Some(0),
        CalibrationKind::Second => Some(1),
        CalibrationKind::Split => None,
    }
}
