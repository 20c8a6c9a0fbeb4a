//! What a discharge would tell, before it is made.

use super::{Estimator, Predicted};
use crate::circuit::Node;
use crate::estimate::method::tracked::{self, Solution};
use crate::estimate::method::{Switched, Times, dual};
use crate::reading::Branch;
use crate::record::{Switch, Through};

impl Estimator {
    /// What a discharge goes on through after a switch, ohm.
    pub fn ohm_after(&self, switch: Switch) -> f64 {
        if switch.to == Through::C1 { self.r1_ohm } else { self.r2_ohm }
    }

    /// What an x discharge through `r_ohm` would tell that waits for `last`, switched as given or not at all.
    pub fn predict_tracked(
        &self,
        r_ohm: f64,
        switch: Option<Switch>,
        u_switch_ns: f64,
        last: Node,
    ) -> Option<Solution> {
        let switch = switch.map(|switch| (switch, self.ohm_after(switch)));
        tracked::predict(self.tracker()?, r_ohm, switch, u_switch_ns, last)
    }

    /// The variances of the ratio to be expected from a direct and from an inferred estimate of a sensor at `ratio`,
    /// switched at `fraction` of the time in which A crosses.
    pub fn predict(&self, ratio: f64, fraction: f64, u_switch_ns: f64) -> Option<Predicted> {
        // A prior is not what discharges are planned by.
        let (c1, c2) = self.calibration().filter(|_| self.noise().is_known())?;
        let (d, rules, last) = (self.offset().d_ns, self.method.rules(), self.last().index());
        let full = [0, 1].map(|node| {
            let (c1, c2) = (c1[node]?, c2[node]?);
            self.x_discharge_ns(c1 + ratio * (c2 - c1), node)
        });
        let at = fraction * (full[0]? - d);
        let rest = (c2[last]? - d) * (1.0 - at / (full[last]? - d));
        if !(at > 0.0 && rest > 0.0) {
            return None;
        }
        let mut switched = full;
        switched[last] = Some(at + rest + d);
        let variance = |x: [Option<f64>; 2], switch, late: [Option<f64>; 2], branch| {
            let times = dual::variables(&Times { c1, c2, x, switch, beside: None, d });
            let covariances = self.covariances(late, u_switch_ns, 0.0)?;
            let by = (rules.ratio)(&times, branch)?.by;
            Some((covariances.of(&by), covariances.of_offset(&by)))
        };
        let (direct, _) = variance(full, None, full, Branch::Direct)?;
        let switch = Some(Switched { at, on: at });
        let (inferred, by_offset) = variance(switched, switch, c2, Branch::Inferred)?;
        Some(Predicted { direct, inferred, by_offset })
    }

    /// When a node crosses in an x discharge of this method, given the crossing `x_ns` through the sensor alone; d included in
    /// both.
    pub fn x_discharge_ns(&self, x_ns: f64, node: usize) -> Option<f64> {
        if !self.method.rules().sinks_beside {
            return Some(x_ns);
        }
        let (_, c2) = self.calibration()?;
        let d = self.offset().d_ns;
        Some(d + 1.0 / (1.0 / (x_ns - d) + 1.0 / (c2[node]? - d)))
    }
}
