//! What calibration discharges say of the filter's own assumptions: how fast the state walks, how much switches scatter, and
//! whether discharges of different kinds tell the same.

use super::Tracker;
use super::gain::Gain;
use crate::estimate::law::{D, R_O, State, UNKNOWNS};
use crate::estimate::limits::{
    FASTEST_WALK, LAST_OF, LAST_SHOWS, LEARN_WALK, MISFIT_OF, MISFIT_SHOWS, SLOWEST_WALK, TREND_OF, WALK_CALM,
};
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
        let mut direction = State::default();
        match kind {
            CalibrationKind::First => direction[D] = 1.0,
            CalibrationKind::Second => direction[..2].copy_from_slice(&self.state[..2]),
            CalibrationKind::Split => direction[R_O] = 1.0,
        }
        let by = rows.map(|row| (0..UNKNOWNS).map(|i| row[i] * direction[i]).sum::<f64>());
        let away = gain.along(by, innovation);
        // A walk that lags shows in as many innovations as the state is the mean of.
        let remembered = gain.remembered(by).clamp(TREND_OF[0], TREND_OF[1]);
        let (walk, trend) = (&mut self.walk[kind as usize], &mut self.trend[kind as usize]);
        let last = &mut self.last_trend[kind as usize];
        let mut faster = away * *trend - WALK_CALM.0 / remembered.max(WALK_CALM.1);
        // One that has just begun to lag need not wait until it is all that the state remembers.
        if last.abs() > LAST_SHOWS * (2.0 * LAST_OF - 1.0).sqrt().recip() {
            faster = faster.max(away * *last);
        }
        *walk = (*walk * (LEARN_WALK * faster.clamp(-4.0, 4.0)).exp())
            .clamp(SLOWEST_WALK[kind as usize], FASTEST_WALK[kind as usize]);
        *trend += (away - *trend) / remembered;
        *last += (away - *last) / LAST_OF;
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
