//! One x discharge against a tracked calibration: weighted least squares on the [law](crate::estimate::law), in conductance.
//!
//! The unknown is y = 1/(R_x+Ro). A crossing T says that the progress g of its node was reached,
//!
//! ```text
//! g = (T-d) y                                    when it came before the switch
//! g = at y + (T-d-on)/(N+Ro)                     after it
//! ```
//!
//! which is linear in y, and is solved at one go whatever the resistance: there is nothing that could fail to converge. Both
//! crossings are used, weighted by the inverse of the covariance of their residuals: noise of the crossings, the instant of
//! the switch, and the tracked state, with all that these share. With a state known exactly the variance is the Cramer-Rao
//! bound of the discharge.
//!
//! What is nearly symmetric is the distribution of y, not that of R_x: where y is no longer known to a sixth of itself, the
//! sensor is `open` above a bound.

use super::{Kind, Node, Rules, Switching, tcdic, tpcm};
use crate::estimate::law::{D, D_B, R_O, Route, State, d_ns};
use crate::estimate::limits::{BEYOND_NOISE, COVERAGE, DOUBT, RESOLVED};
use crate::estimate::motion::Evidence;
use crate::estimate::noise::Covariance;
use crate::estimate::tracker::Tracker;
use crate::reading::{Branch, Fault};
use crate::record::Switch;

/// What it decides. Until there is a state, both calibration discharges give readings in closed form.
pub(super) const RULES: Rules = Rules {
    circuits: &[Kind::TwoCapacitor, Kind::OneCapacitor],
    switching: Switching::WhereBest,
    ratio: |times, _| tcdic::ratio(times).or_else(|| tpcm::ratio(times, Node::A)),
    evidence: |times, _, scale| tcdic::evidence(times, scale).or_else(|| tpcm::evidence(times)),
    ..Rules::usual('T')
};

/// An x discharge as it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// Crossings of A and B, ns; the last of them is there.
    pub crossings: [Option<f64>; 2],
    /// The switch, and the resistor after it, ohm.
    pub switch: Option<(Switch, f64)>,
    /// Type-B uncertainty of the switch, ns.
    pub u_switch_ns: f64,
    /// [`Record::later_ns`](crate::record::Record::later_ns), or 0.
    pub later_ns: f64,
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
    /// How it depends on the instant of the switch, ohm/ns.
    pub by_switch: f64,
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
    let solve = || {
        let fit = Conductance::new(tracker, observed, None)?;
        let solution = fit.solution(tracker.state()[R_O])?;
        match fit.branch {
            Branch::Direct => Some(solution),
            Branch::Inferred => Some(Solution { variance: fit.inferred_variance()?, ..solution }),
        }
    };
    solve().ok_or(Fault::Implausible)
}

/// The variance to be expected of a sensor of `r_ohm` in a discharge that waits for `last`, switched (or not) as given; `None`
/// if that cannot be.
pub fn predict(
    tracker: &Tracker,
    r_ohm: f64,
    switch: Option<(Switch, f64)>,
    u_switch_ns: f64,
    last: Node,
) -> Option<Solution> {
    let route = Route { first_ohm: r_ohm, switch };
    let crossings =
        [0, 1].map(|node| (node <= last.index()).then(|| route.crossing(tracker.state(), node).ns));
    let observed = Observed { crossings, switch, u_switch_ns, later_ns: 0.0 };
    let siemens = 1.0 / (r_ohm + tracker.state()[R_O]);
    Conductance::new(tracker, &observed, Some(siemens))?.solution(tracker.state()[R_O])
}

/// The lower bound of a resistance that cannot be told from an open circuit, ohm; `None` where it can. Beside a low one the
/// clock is coarse, which makes none of it open: what counts is how well a sensor above `r2_ohm` would be known.
pub fn beyond(tracker: &Tracker, observed: &Observed, r2_ohm: f64) -> Option<f64> {
    let r_o_ohm = tracker.state()[R_O];
    let fit = Conductance::new(tracker, observed, None)?;
    if fit.is_resolved() || fit.evidence.contradicts {
        return None;
    }
    let above = 1.0 / (r2_ohm + r_o_ohm);
    if fit.siemens > above && Conductance::new(tracker, observed, Some(above))?.is_resolved() {
        return None;
    }
    let highest = fit.siemens.max(0.0) + COVERAGE * fit.u_siemens;
    let r_min_ohm = 1.0 / highest - r_o_ohm;
    (r_min_ohm > 0.0 && r_min_ohm.is_finite()).then_some(r_min_ohm)
}

impl Observed {
    /// Where a crossing is so near to the switch that noise could have it on either side: before one to a lower resistor, that one
    /// finished it, since of a sensor that did so itself that tells less, but nothing that is wrong; after one to a higher resistor, the
    /// sensor did, since what that one leaves to do takes it far longer.
    fn branch(&self, tracker: &Tracker) -> Branch {
        let state = tracker.state();
        let last =
            [1, 0].into_iter().find_map(|node| Some((node, self.crossings[node]? - d_ns(state, node))));
        let (Some((switch, next_ohm)), Some((node, last_ns))) = (self.switch, last) else {
            return Branch::Direct;
        };
        let next_ns = [0, 1].map(|node| state[node] * (next_ohm + state[R_O]));
        let u_ns = |late_ns: [f64; 2]| {
            let noise = tracker.noise().covariance(late_ns).map_or(0.0, |noise| noise.node(node));
            noise.sqrt().hypot(tracker.u_switch_ns(self.u_switch_ns))
        };
        let switched_ns = if next_ns[node] < switch.at_ns {
            switch.on_ns - COVERAGE * u_ns(next_ns)
        } else if last_ns > switch.on_ns {
            switch.on_ns + BEYOND_NOISE * u_ns([last_ns; 2])
        } else {
            switch.on_ns
        };
        if last_ns > switched_ns { Branch::Inferred } else { Branch::Direct }
    }
}

/// What one crossing says: the progress that the sensor has to account for, `missing = through_ns y`.
#[derive(Clone, Copy)]
struct Equation {
    node: usize,
    /// How long the sensor took part, ns.
    through_ns: f64,
    /// g less what was progress through the next resistor, ns/ohm.
    missing: f64,
    /// 1/(N+Ro) if the crossing came after the switch.
    next: Option<f64>,
    /// When the node would cross through the last resistor alone: what its noise goes by, ns.
    late_ns: f64,
}

impl Equation {
    /// `switch`: the one that came before the crossing, if one did.
    fn new(state: &State, crossing_ns: f64, node: usize, switch: Option<(Switch, f64)>) -> Equation {
        let (crossing_ns, g) = (crossing_ns - d_ns(state, node), state[node]);
        match switch {
            Some((switch, next_ohm)) => {
                let next = 1.0 / (next_ohm + state[R_O]);
                let missing = g - (crossing_ns - switch.on_ns) * next;
                Equation { node, through_ns: switch.at_ns, missing, next: Some(next), late_ns: g / next }
            }
            None => Equation { node, through_ns: crossing_ns, missing: g, next: None, late_ns: crossing_ns },
        }
    }

    /// How the residual `missing - through_ns y` changes with its crossing (and, the other way round, with d), per ohm.
    fn by_crossing(&self, y: f64) -> f64 {
        -self.next.unwrap_or(y)
    }

    /// With the time until the switch, per ohm; when the next resistor was sunk is part of the crossing's own noise.
    fn by_switch(&self, y: f64) -> f64 {
        self.next.map_or(0.0, |_| -y)
    }

    /// With how late a line was switched at the most: the first one, or another.
    fn by_call(&self, y: f64) -> f64 {
        -y.max(self.next.unwrap_or(y))
    }

    /// With the state, at a given R_x.
    fn by_state(&self, state: &State, y: f64) -> State {
        let mut by = State::default();
        by[self.node] = 1.0;
        let rest = self.next.map_or(0.0, |next| (state[self.node] - self.missing) * next);
        by[R_O] = rest + self.through_ns * y * y;
        by[D] = -self.by_crossing(y);
        by[D_B] = by[D] * self.node as f64;
        by
    }
}

/// The conductance of the sensor and its pin that fits a discharge best.
struct Conductance {
    /// y = 1/(R_x+Ro), siemens.
    siemens: f64,
    /// 1 sigma, siemens.
    u_siemens: f64,
    /// The same with a calibration known exactly.
    bound_siemens: f64,
    /// How y depends on the state at a given R_x, and on the instant of the switch.
    by_state: State,
    by_switch: f64,
    branch: Branch,
    evidence: Evidence,
}

impl Conductance {
    /// The sensor conducts for certain.
    fn is_resolved(&self) -> bool {
        self.siemens > RESOLVED * self.u_siemens
    }

    /// `siemens`: where that is known before.
    fn new(tracker: &Tracker, observed: &Observed, siemens: Option<f64>) -> Option<Conductance> {
        let (state, branch) = (tracker.state(), observed.branch(tracker));
        // A switch after the last crossing has changed nothing.
        let switch = observed.switch.filter(|_| branch == Branch::Inferred);
        let b_ns = observed.crossings[1].filter(|_| tracker.nodes() == 2);
        let b = b_ns.map(|ns| Equation::new(state, ns, 1, switch));
        // Whether A had crossed by the switch is told better by B than by A's own late stamp.
        let is_before_a = |at_ns: f64| b.is_none_or(|b| at_ns * b.missing < state[0] * b.through_ns);
        let switch = switch.filter(|(switch, _)| is_before_a(switch.at_ns));
        let a = observed.crossings[0].map(|ns| Equation::new(state, ns, 0, switch));
        let nodes = [a, b];
        let noise = tracker.noise().covariance(nodes.map(|node| node.map(|one| one.late_ns)))?;
        let u_switch_ns = tracker.u_switch_ns(observed.u_switch_ns);
        let u_ns = [u_switch_ns, observed.later_ns];
        let near = |y: f64| Conductance::near(y.max(0.0), tracker, &noise, u_ns, &nodes, branch);
        // The weights depend on y, but hardly: the last node's own value does for a start.
        let last = b.or(a)?;
        let first = || Some(near(last.missing / last.through_ns)?.siemens);
        near(siemens.or_else(first)?)
    }

    /// The least squares with the weights that the residuals have near a conductance; by how much all switches scatter, ns, and
    /// the calls of this discharge were longer than usual.
    fn near(
        near: f64,
        tracker: &Tracker,
        noise: &Covariance,
        [u_switch_ns, later_ns]: [f64; 2],
        nodes: &[Option<Equation>; 2],
        branch: Branch,
    ) -> Option<Conductance> {
        let (state, seen) = (tracker.state(), nodes.map(|node| node.is_some()));
        let of_nodes = |of: &dyn Fn(&Equation) -> f64| nodes.map(|node| node.as_ref().map_or(0.0, of));
        let (through, missing) = (of_nodes(&|one| one.through_ns), of_nodes(&|one| one.missing));
        let [a, b] = of_nodes(&|one| one.by_crossing(near));
        // Covariance of the residuals by noise and switch, and with what is not known of the state.
        let mut own = Covariance { aa: a * a * noise.aa, bb: b * b * noise.bb, ab: a * b * noise.ab };
        // A late start is in the crossing of A, and in the time until the switch, not in how long B takes after it. It is half
        // of what a switch scatters by.
        if let [Some(Equation { next: None, .. }), Some(Equation { next: Some(_), .. })] = nodes {
            let start = (0.5 * u_switch_ns * u_switch_ns).min(noise.aa);
            own.ab += a * a * start - a * b * tracker.noise().of_start(noise);
        }
        let by_switch = of_nodes(&|one| one.by_switch(near));
        own.add_outer(by_switch.map(|by| by * u_switch_ns));
        own.add_each(of_nodes(&|one| one.by_call(near)).map(|by| by * later_ns));
        let rows = nodes.map(|node| node.map_or(State::default(), |one| one.by_state(state, near)));
        let all = Covariance {
            aa: own.aa + tracker.variance(&rows[0]),
            bb: own.bb + tracker.variance(&rows[1]),
            ab: own.ab + tracker.covariance_of(&rows[0], &rows[1]),
        };
        let (inverse, own) = (all.inverse(seen)?, own.inverse(seen)?);
        let information = inverse.of(through[0], through[1]);
        let weights = inverse.times(through).map(|weight| weight / information);
        let y = weights[0] * missing[0] + weights[1] * missing[1];
        let left = [0, 1].map(|node| missing[node] - through[node] * y);
        let misfit = inverse.of(left[0], left[1]);
        let contradicts = misfit > BEYOND_NOISE * BEYOND_NOISE;
        // A late stamp that the other node is too noisy to refute is doubted as far as it may be one. Over two stretches of the
        // discharge a sensor that moves looks the same: that is for `motion` to tell.
        let is_one_stretch = through[0] == through[1];
        let doubt = if is_one_stretch && !contradicts && misfit > DOUBT * DOUBT { misfit } else { 1.0 };
        let evidence = match nodes {
            [Some(a), Some(b)] => {
                let u_siemens = all.of(1.0 / a.through_ns, -1.0 / b.through_ns).sqrt();
                evidence_of_two([a, b], weights, state[R_O], u_siemens / (y * y))
            }
            [one, other] => Evidence::over(one.or(*other)?.through_ns),
        };
        let fit = Conductance {
            siemens: y,
            u_siemens: (doubt / information).sqrt(),
            bound_siemens: (1.0 / own.of(through[0], through[1])).sqrt(),
            by_state: std::array::from_fn(|i| weights[0] * rows[0][i] + weights[1] * rows[1][i]),
            by_switch: weights[0] * by_switch[0] + weights[1] * by_switch[1],
            branch,
            evidence: evidence.contradicting(contradicts),
        };
        (y.is_finite() && fit.u_siemens.is_finite()).then_some(fit)
    }

    /// R_x = 1/y - Ro, to the first order.
    fn solution(&self, r_o_ohm: f64) -> Option<Solution> {
        let Conductance { siemens: y, u_siemens: u, bound_siemens, by_state, by_switch, branch, evidence } =
            *self;
        let solution = Solution {
            r_ohm: 1.0 / y - r_o_ohm,
            variance: (u / (y * y)).powi(2),
            bound: (bound_siemens / (y * y)).powi(2),
            by_state: by_state.map(|by| -by / (y * y)),
            by_switch: -by_switch / (y * y),
            branch,
            evidence,
        };
        (y > 0.0 && solution.r_ohm.is_finite() && solution.variance.is_finite()).then_some(solution)
    }

    /// Of what a known resistor finished, y is as symmetric as noise is: 2 u stand for the interval of y +- 2 sigma, which 1/y makes
    /// longer, half of its length. (What the sensor finished itself took a time in proportion to R.) Ohm².
    fn inferred_variance(&self) -> Option<f64> {
        let square = self.siemens.powi(2) - (COVERAGE * self.u_siemens).powi(2);
        (square > 0.0).then(|| (self.u_siemens / square).powi(2))
    }
}

/// When it was so, and what each crossing says alone; `u_ohm`: of the difference.
fn evidence_of_two(nodes: [&Equation; 2], weights: [f64; 2], r_o_ohm: f64, u_ohm: f64) -> Evidence {
    let through = nodes.map(|node| node.through_ns);
    if nodes.iter().any(|node| node.missing / node.through_ns <= 0.0) {
        return Evidence::over(through[1]);
    }
    let shares = [weights[0] * through[0], weights[1] * through[1]];
    let r_ohm = nodes.map(|node| 1.0 / (node.missing / node.through_ns) - r_o_ohm);
    Evidence::over_two(through, shares, r_ohm, Some(u_ohm))
}
