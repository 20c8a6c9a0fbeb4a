//! Which stretches of a discharge an equation rests on, and whether they agree.
//!
//! For: the instant of an estimate, and what [`motion`](crate::estimate::motion) judges it by. Must not know: earlier readings.

use super::{Covariances, Estimator, GATE};
use crate::estimate::method::dual::Dual;
use crate::estimate::method::{Times, cerm, tpcm};
use crate::estimate::motion::Evidence;
use crate::reading::{Branch, Method};

impl Estimator {
    /// What the equation of a branch rests on. Without covariances nothing contradicts.
    pub(super) fn evidence(
        &self,
        times: &Times<Dual>,
        branch: Branch,
        covariance: Option<&Covariances<'_>>,
    ) -> Evidence {
        let span = self.r2_ohm - self.r1_ohm;
        let u = |of: &Dual| covariance.map_or(f64::INFINITY, |covariance| covariance.of(&of.by).sqrt());
        let ends = [0, 1].map(|node| times.x[node].value - times.d.value);
        let two = |end_ns, weights, ratios: [Dual; 2]| {
            let u_ohm = span * u(&(ratios[1] - ratios[0]));
            Evidence::over_two(end_ns, weights, ratios.map(|ratio| self.r1_ohm + span * ratio.value), u_ohm)
        };
        let at_ns = times.at.value;
        match (self.method, branch) {
            (Method::Tpcm, _) | (Method::Qerm, Branch::Direct) => Evidence::over(ends[0]),
            (Method::Tracked, _) if self.nodes == 1 => Evidence::over(ends[0]),
            (Method::Qerm, Branch::Inferred) => Evidence::over(at_ns),
            (Method::Cerm, Branch::Inferred) if times.x[0].value <= 0.0 => Evidence::over(at_ns),
            // On which side of the switch A crossed is told by the times that do not hold its own jitter.
            (Method::Cerm, Branch::Inferred) if cerm::inferred(times)[0].value > at_ns => {
                let residual = cerm::residual_a(times);
                // Not `>`: what cannot be compared is no agreement.
                let agrees = residual.value.abs() <= GATE * u(&residual);
                Evidence::over(at_ns).contradicting(!agrees)
            }
            (Method::Cerm, Branch::Inferred) => {
                two([ends[0], at_ns], [0.0, 1.0], [tpcm::ratio(times, 0), cerm::ratio(times)])
            }
            // T_A + T_B = (g_A + g_B) (R_x + Ro): each node's own estimate counts by its g.
            (Method::Tcdic | Method::Cerm | Method::Tracked, _) => {
                let g = [0, 1].map(|node| times.c2[node].value - times.c1[node].value);
                let weights = g.map(|of_node| of_node / (g[0] + g[1]));
                two(ends, weights, [0, 1].map(|node| tpcm::ratio(times, node)))
            }
        }
    }
}
