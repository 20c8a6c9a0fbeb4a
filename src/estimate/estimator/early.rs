//! First crossings of [wide-band noise](crate::estimate::noise): early by more than in proportion to their times, which two known
//! resistors do not tell.
//!
//! ```text
//! early(T) = beta T ln(T/T_c2)
//! ```
//!
//! beside what is in proportion, which is taken for g. What goes on through R_2 is as early as its calibration; through R_1 a node
//! crosses later than that, which an offset that was found contains.

use super::Estimator;
use crate::estimate::method::Times;
use crate::estimate::method::dual::Gradient;
use crate::estimate::tracker::Tracker;
use crate::reading::Branch;

impl Estimator {
    /// What that does to a ratio.
    pub(super) fn early(&self, by: &Gradient, times: &Times<f64>, branch: Branch) -> f64 {
        let betas = self.noise().early();
        if betas == [0.0; 2] {
            return 0.0;
        }
        let later_ns = |node: usize, crossing: Option<f64>| {
            let ends = crossing.zip(times.c2[node]).map(|(ns, second)| (ns - times.d, second - times.d));
            ends.filter(|(ns, _)| *ns > 0.0).map_or(0.0, |(ns, second)| betas[node] * bend(ns, second))
        };
        let of_pair = |by: [f64; 2], later: [f64; 2]| by[0] * later[0] + by[1] * later[1];
        let first = [0, 1].map(|node| later_ns(node, times.c1[node]));
        let sensor = match branch {
            Branch::Direct => [0, 1].map(|node| later_ns(node, times.x[node])),
            Branch::Inferred => [0.0; 2],
        };
        of_pair(by.c1, first) + of_pair(by.x, sensor) + by.offset * self.of_offset_ns(times, first)
    }

    /// What an offset that was found contains of it, with crossings through R_1 that are so much later.
    fn of_offset_ns(&self, times: &Times<f64>, first: [f64; 2]) -> f64 {
        let covariance = self.noise().covariance(times.c2).filter(|_| self.offset().r_o().is_some());
        let Some(covariance) = covariance else { return 0.0 };
        let [a, b] = covariance.weights(self.nodes);
        self.r2_ohm / (self.r2_ohm - self.r1_ohm) * (a * first[0] + b * first[1])
    }

    /// What it does to a reading by a tracked state, whose offsets are those of both nodes, ohm.
    pub(super) fn early_ohm(&self, tracker: &Tracker, r_ohm: f64, branch: Branch) -> f64 {
        let betas = tracker.noise().early();
        if betas == [0.0; 2] || branch == Branch::Inferred {
            return 0.0;
        }
        let beta = betas[..self.nodes].iter().sum::<f64>() / self.nodes as f64;
        let r_o_ohm = tracker.offset().r_o().unwrap_or(0.0);
        let [x, first, second] = [r_ohm, self.r1_ohm, self.r2_ohm].map(|ohm| ohm + r_o_ohm);
        if x <= 0.0 {
            return 0.0;
        }
        beta * (bend(x, second) - bend(first, second) * (second - x) / (second - first))
    }
}

/// By how much more than in proportion to itself something is late, beside another.
fn bend(of: f64, beside: f64) -> f64 {
    of * (beside / of).ln()
}
