//! What calibration discharges say of the filter's own assumptions: how fast the state walks, how much switches scatter, and
//! whether discharges of different kinds tell the same.

use super::Tracker;
use super::gain::Gain;
use crate::estimate::law::{D, R_O, State, UNKNOWNS};
use crate::estimate::limits::{MISFIT_OF, MISFIT_SHOWS};
use crate::estimate::noise::Covariance;
use crate::record::CalibrationKind;

impl Tracker {
    /// The discharge through R_1 tells how fast d walks, that through R_2 how fast g does, a split one how fast Ro does.
    pub(super) fn learn_walk(
        &mut self,
        kind: CalibrationKind,
        gain: &Gain,
        rows: &[State; 2],
        innovation: [f64; 2],
    ) {
        let (part, unit) = self.walking(kind);
        let mut direction = State::default();
        direction[part] = unit;
        if kind == CalibrationKind::Second {
            direction[1] = self.state[1];
        }
        let by = rows.map(|row| (0..UNKNOWNS).map(|i| row[i] * direction[i]).sum::<f64>());
        let known = self.covariance[part][part] / unit.powi(2);
        if let Some((beside, variance)) = gain.along(by, innovation, known) {
            self.speeds[kind as usize].add(self.at, beside, variance);
        }
    }

    /// The part of the state whose walk a kind of discharge tells, and the unit of its speed: of both g it is what they are.
    fn walking(&self, kind: CalibrationKind) -> (usize, f64) {
        match kind {
            CalibrationKind::First => (D, self.jitter_ns().max(1.0)),
            CalibrationKind::Second => (0, self.state[0]),
            CalibrationKind::Split => (R_O, 1.0),
        }
    }

    /// What is beside the state is so by another number once that has been corrected.
    pub(super) fn correct_speeds(&mut self, by: &State) {
        for kind in CalibrationKind::ALL {
            let (part, unit) = self.walking(kind);
            self.speeds[kind as usize].corrected(by[part] / unit);
        }
    }

    /// A state that is right leaves nothing over on average, whatever the kind of discharge.
    pub(super) fn learn_misfit(
        &mut self,
        kind: CalibrationKind,
        gain: &Gain,
        innovation: [f64; 2],
        seen: [bool; 2],
    ) {
        for (node, mean) in self.means[kind as usize].iter_mut().enumerate() {
            if seen[node] {
                *mean += (gain.sigmas(node, innovation) - *mean) / MISFIT_OF;
            }
        }
    }

    /// By how much more the state is uncertain than its covariance says, since discharges of different kinds contradict each
    /// other (Birge's ratio): whatever it is that no state explains, readings have it too.
    pub fn misfit(&self) -> f64 {
        // The variance of such a running mean of values of variance 1.
        let chance = 1.0 / (2.0 * MISFIT_OF - 1.0);
        let squares: f64 = self.means.iter().flatten().map(|mean| mean * mean / chance).sum();
        let per_crossing = squares / (3 * self.nodes) as f64;
        if per_crossing > MISFIT_SHOWS { per_crossing } else { 1.0 }
    }

    /// How late the switch seems to have been by the nodes that were seen, and how well they would tell it if it never
    /// scattered; `steady`: the innovation's covariance then; `expected_ns`: as in [`Tracker::u_switch_ns`].
    pub(super) fn learn_scatter(
        &mut self,
        by: [f64; 2],
        steady: &Covariance,
        innovation: [f64; 2],
        seen: [bool; 2],
        expected_ns: f64,
    ) {
        let Some(inverse) = steady.inverse(seen).filter(|_| by[0] != 0.0) else { return };
        let (weights, information) = (inverse.times(by), inverse.of(by[0], by[1]));
        let late_ns = (weights[0] * innovation[0] + weights[1] * innovation[1]) / information;
        self.scatter.add(late_ns, 1.0 / information, expected_ns);
    }
}
