//! One x discharge against a tracked calibration: weighted least squares on the [law](crate::estimate::law).
//!
//! The unknown is R_x alone. Both crossings are used, each as the law has it, whether it comes before the switch or after
//! it, weighted by the inverse of the covariance of their residuals: noise of the crossings, the instant of the switch,
//! and the tracked state, with all that these share. With a state known exactly the variance is the Cramer-Rao bound of
//! the discharge.

use super::{Dual, Kind, Node, Rules, Scale, Switching, Times, tcdic, tpcm};
use crate::estimate::law::{Route, State};
use crate::estimate::limits::{BEYOND_NOISE, COVERAGE};
use crate::estimate::motion::Evidence;
use crate::estimate::noise::Covariance;
use crate::estimate::tracker::{Tracker, bilinear, quadratic};
use crate::reading::{Branch, Fault};
use crate::record::Switch;

/// Steps of Gauss and Newton; each squares the relative error, which is small from the start.
const STEPS: usize = 4;

/// The method. Until there is a state, both calibration discharges give readings in closed form.
#[derive(Debug)]
pub struct Tracked;

impl Rules for Tracked {
    fn circuits(&self) -> &'static [Kind] {
        &[Kind::TwoCapacitor, Kind::OneCapacitor]
    }

    fn switching(&self) -> Switching {
        Switching::WhereBest
    }

    fn ratio(&self, times: &Times<Dual>, _: Branch) -> Option<Dual> {
        tcdic::ratio(times).or_else(|| tpcm::ratio(times, Node::A))
    }

    fn evidence(&self, times: &Times<Dual>, branch: Branch, scale: &Scale<'_>) -> Option<Evidence> {
        tcdic::evidence(times, scale).or_else(|| tpcm::Tpcm.evidence(times, branch, scale))
    }
}

/// An x discharge as it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// Crossings of A and B, ns; the last of them is there.
    pub crossings: [Option<f64>; 2],
    /// The switch, and the resistor after it, ohm.
    pub switch: Option<(Switch, f64)>,
    /// Type-B uncertainty of the switch, ns.
    pub u_switch_ns: f64,
}

/// R_x and what is known about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution {
    /// Ohm.
    pub r_ohm: f64,
    /// All of it, ohm².
    pub variance: f64,
    /// As it would be with a calibration known exactly: the Cramer-Rao bound, ohm².
    pub bound: f64,
    /// How R_x depends on the state: the variance that the calibration brings is v^T P v.
    pub by_state: State,
    /// Whether the switch came before the last crossing.
    pub branch: Branch,
    /// When it was so, and whether both crossings say so.
    pub evidence: Evidence,
}

/// Solves for R_x.
///
/// # Errors
/// [`Fault::Implausible`] if no resistance fits.
pub fn solve(tracker: &Tracker, observed: &Observed) -> Result<Solution, Fault> {
    let mut r_ohm = start(tracker, observed).filter(|r| r.is_finite()).ok_or(Fault::Implausible)?;
    for _ in 0..STEPS {
        let fit = Fit::new(tracker, observed, r_ohm).ok_or(Fault::Implausible)?;
        // The law has a pole at R = -Ro.
        r_ohm = (r_ohm + fit.step).max(-0.99 * tracker.state()[crate::estimate::law::R_O]);
    }
    let fit = Fit::new(tracker, observed, r_ohm).ok_or(Fault::Implausible)?;
    let solution = fit.solution(r_ohm, observed.branch(tracker.state()));
    if solution.r_ohm.is_finite() && solution.variance.is_finite() {
        Ok(solution)
    } else {
        Err(Fault::Implausible)
    }
}

/// The variance to be expected of a sensor of `r_ohm`, switched (or not) as given; `None` if that cannot be.
pub fn predict(
    tracker: &Tracker,
    r_ohm: f64,
    switch: Option<(Switch, f64)>,
    u_switch_ns: f64,
) -> Option<Solution> {
    let route = Route { first_ohm: r_ohm, switch };
    let crossings = [0, 1].map(|node| Some(route.crossing(tracker.state(), node).ns));
    let observed = Observed { crossings, switch, u_switch_ns };
    let fit = Fit::new(tracker, &observed, r_ohm)?;
    Some(fit.solution(r_ohm, observed.branch(tracker.state())))
}

/// The lower bound of a resistance, ohm, that a discharge finished through R_1 or R_2 cannot tell from an open circuit.
pub fn beyond(tracker: &Tracker, observed: &Observed) -> Option<f64> {
    if observed.branch(tracker.state()) == Branch::Direct {
        return None;
    }
    let (siemens, u) = conductance(tracker, observed)?;
    let r_min_ohm = 1.0 / (siemens.max(0.0) + COVERAGE * u) - tracker.r_o_ohm().0;
    (siemens <= COVERAGE * u && r_min_ohm > 0.0 && r_min_ohm.is_finite()).then_some(r_min_ohm)
}

/// The conductance 1/(R_x+Ro) of a discharge that was switched, and its uncertainty, siemens. The law is linear in it.
fn conductance(tracker: &Tracker, observed: &Observed) -> Option<(f64, f64)> {
    // Where the linear law is evaluated does not matter; far away, where no crossing comes before the switch.
    let reference_ohm = 1e7;
    let through = reference_ohm + tracker.state()[crate::estimate::law::R_O];
    let fit = Fit::new(tracker, observed, reference_ohm)?;
    let siemens = 1.0 / through - fit.step / (through * through);
    Some((siemens, fit.variance.sqrt() / (through * through)))
}

impl Observed {
    /// How long the sensor took part in what ended with a crossing, ns.
    fn end_ns(&self, crossing_ns: f64, state: &State) -> f64 {
        let end_ns = crossing_ns - state[crate::estimate::law::D];
        self.switch.map_or(end_ns, |(switch, _)| end_ns.min(switch.at_ns))
    }

    fn branch(&self, state: &State) -> Branch {
        let last = self.crossings[1].or(self.crossings[0]).unwrap_or(0.0) - state[crate::estimate::law::D];
        match self.switch {
            Some((switch, _)) if last > switch.on_ns => Branch::Inferred,
            _ => Branch::Direct,
        }
    }
}

/// The last node's equation alone, in closed form.
fn start(tracker: &Tracker, observed: &Observed) -> Option<f64> {
    let [g_a, g_b, r_o, d] = *tracker.state();
    let (g, crossing) = match observed.crossings {
        [_, Some(b)] if tracker.nodes() == 2 => (g_b, b - d),
        [Some(a), _] => (g_a, a - d),
        _ => return None,
    };
    let through_x = match (observed.branch(tracker.state()), observed.switch) {
        (Branch::Inferred, Some((switch, next_ohm))) => {
            let rest = (crossing - switch.on_ns) / (next_ohm + r_o);
            switch.at_ns / (g - rest)
        }
        _ => crossing / g,
    };
    (through_x > 0.0).then_some(through_x - r_o)
}

/// The normal equations of one unknown, at a resistance.
struct Fit {
    step: f64,
    /// (J^T S^-1 J)^-1.
    variance: f64,
    bound: f64,
    by_state: State,
    evidence: Evidence,
}

impl Fit {
    fn new(tracker: &Tracker, observed: &Observed, r_ohm: f64) -> Option<Fit> {
        let state = tracker.state();
        // A switch after the last crossing has changed nothing.
        let switch = if observed.branch(state) == Branch::Inferred { observed.switch } else { None };
        let route = Route { first_ohm: r_ohm, switch };
        let nodes = [0, 1].map(|node| {
            let seen = observed.crossings[node].is_some() && node < tracker.nodes();
            (route.crossing(state, node), if seen { observed.crossings[node] } else { None })
        });
        let noise = tracker.observation(&route, observed.u_switch_ns)?;
        let rows = nodes.map(|(crossing, _)| crossing.by_state);
        let p = tracker.covariance();
        let all = Covariance {
            aa: noise.aa + quadratic(p, &rows[0]),
            bb: noise.bb + quadratic(p, &rows[1]),
            ab: noise.ab + bilinear(p, &rows[0], &rows[1]),
        };
        let seen = nodes.map(|(_, seen)| seen.is_some());
        let (inverse, alone) = (all.inverse(seen)?, noise.inverse(seen)?);
        let j = nodes.map(|(crossing, _)| crossing.by_first);
        let residual = nodes.map(|(crossing, seen)| seen.map_or(0.0, |seen| seen - crossing.ns));
        let information = inverse.of(j[0], j[1]);
        let weights = inverse.times(j).map(|weight| weight / information);
        let step = weights[0] * residual[0] + weights[1] * residual[1];
        let mut by_state = [0.0; 4];
        for (index, by) in by_state.iter_mut().enumerate() {
            *by = -(weights[0] * rows[0][index] + weights[1] * rows[1][index]);
        }
        let left = [residual[0] - j[0] * step, residual[1] - j[1] * step];
        let evidence = match nodes.map(|(_, seen)| seen.map(|ns| observed.end_ns(ns, state))) {
            [Some(a), Some(b)] => {
                let by_node = [0, 1].map(|node| r_ohm + residual[node] / j[node]);
                let u_ohm = all.of(1.0 / j[0], -1.0 / j[1]).sqrt();
                Evidence::over_two([a, b], [weights[0] * j[0], weights[1] * j[1]], by_node, Some(u_ohm))
            }
            [a, b] => Evidence::over(b.or(a)?),
        };
        Some(Fit {
            step,
            variance: 1.0 / information,
            bound: 1.0 / alone.of(j[0], j[1]),
            by_state,
            evidence: evidence.contradicting(inverse.of(left[0], left[1]) > BEYOND_NOISE * BEYOND_NOISE),
        })
    }

    fn solution(&self, r_ohm: f64, branch: Branch) -> Solution {
        let Fit { variance, bound, by_state, evidence, .. } = *self;
        Solution { r_ohm, variance, bound, by_state, branch, evidence }
    }
}
