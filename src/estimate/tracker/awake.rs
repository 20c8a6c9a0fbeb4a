//! Calibration discharges in which the [program wakes](crate::estimate::awake): the first of them are held against a state that only
//! others have corrected; then they correct it, too, as long as they agree with it.

use super::{Tracker, quadratic};
use crate::estimate::awake::{AwakeTest, of_stamp_ns, resistor_of, wake_ns};
use crate::estimate::law::{D, State};
use crate::estimate::limits::AWAKE_COUNTS;
use crate::record::{CalibrationKind, Record};

impl Tracker {
    /// What they have shown.
    pub fn awake(&self) -> &AwakeTest {
        &self.awake
    }

    /// The same, for those that come before there is a state.
    pub fn awake_mut(&mut self) -> &mut AwakeTest {
        &mut self.awake
    }

    /// When the program is to wake in the next calibration discharge of a kind, ns after its start, if it is to.
    pub fn wake_ns(&self, kind: CalibrationKind) -> Option<f64> {
        let is_next = |resistor: &usize| self.ready && !self.is_doubted() && self.awake.is_next(*resistor);
        let takes_ns = self.takes_ns()[resistor_of(kind).filter(is_next)?];
        wake_ns(takes_ns, self.noise.covariance([takes_ns; 2])?.aa.sqrt())
    }

    /// Takes a calibration discharge for what it shows; whether the state is to be corrected by it, `None` where the program did
    /// not wake in it.
    pub(super) fn takes_awake(&mut self, kind: CalibrationKind, record: &Record) -> Option<bool> {
        let resistor = resistor_of(kind)?;
        self.awake.count(resistor);
        let (longer_ns, u_state_ns) = self.beside(kind, record).unzip();
        let Some(switch) = record.switch else {
            self.awake.add_asleep(resistor, longer_ns);
            return None;
        };
        // It crossed before.
        if record.a_ns.is_none_or(|a_ns| a_ns <= switch.on_ns) {
            return None;
        }
        self.awake.add(resistor, longer_ns, u_state_ns.unwrap_or(0.0), record.start);
        Some(self.awake.tells(resistor) && !self.awake.shows(resistor))
    }

    /// By how much node A crossed later than expected, ns, the variance of that, and what the state's own uncertainty is of it,
    /// 1 sigma.
    pub(super) fn beside(&self, kind: CalibrationKind, record: &Record) -> Option<([f64; 2], f64)> {
        let ([a, _], noise) = self.expected(kind, record);
        let (_, noise) = noise?;
        let u_state_ns = quadratic(&self.covariance, &a.by_state).sqrt();
        Some(([record.a_ns? - a.ns, noise.aa], u_state_ns))
    }

    /// What stamps that are later after long waits do to a reading, 1 sigma, ohm; `by_state`: how it depends on the state.
    pub fn asleep_ohm(&self, r_ohm: f64, by_state: &State, record: &Record) -> f64 {
        let [first_ns, second_ns] = self.takes_ns();
        let later_ns = self.awake.beyond_ns(AWAKE_COUNTS);
        let of_stamp_ns = of_stamp_ns(later_ns, record, first_ns);
        // Splits and R_2 contradict each other by so much: Ro is wrong, and g.
        let longest_ns = later_ns.into_iter().fold(0.0, f64::max);
        (by_state[D] * of_stamp_ns).hypot((self.r_ohm[0] + r_ohm) / second_ns * longest_ns)
    }
}
