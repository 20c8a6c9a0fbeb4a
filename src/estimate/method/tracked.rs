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

use crate::estimate::law::{Course, D, R_O, State};
use crate::estimate::motion::Seen;
use crate::estimate::noise::Covariance;
use crate::estimate::tracker::{Tracker, bilinear, quadratic};
use crate::reading::{Branch, Fault};
use crate::record::Switch;

/// Residuals of the two nodes that disagree by more sigma cannot both be right.
const GATE: f64 = 5.0;
/// Residuals that disagree by more sigma enlarge the uncertainty as much (Birge's ratio): chance does so once in 70 readings.
const DOUBT: f64 = 2.45;
/// A conductance of fewer sigma is not told from none: chance makes one reading in 10^9 of an open sensor a number.
const RESOLVED: f64 = 6.0;
/// Bounds, and the interval that 2 u stand for, are so many sigma of the conductance wide.
const COVERAGE: f64 = 2.0;

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
    pub seen: Seen,
}

/// Solves for R_x.
///
/// # Errors
/// [`Fault::Implausible`] if no resistance fits.
pub fn solve(tracker: &Tracker, observed: &Observed) -> Result<Solution, Fault> {
    let fit = Fit::new(tracker, observed).ok_or(Fault::Implausible)?;
    fit.solution(tracker.state()[R_O]).ok_or(Fault::Implausible)
}

/// The variance to be expected of a sensor of `r_ohm`, switched (or not) as given; `None` if that cannot be.
pub fn predict(
    tracker: &Tracker,
    r_ohm: f64,
    switch: Option<(Switch, f64)>,
    u_switch_ns: f64,
) -> Option<Solution> {
    let course = Course { first_ohm: r_ohm, switch };
    let crossings = [0, 1].map(|node| {
        let is_there = node < tracker.nodes();
        is_there.then(|| course.crossing(tracker.state(), node).ns)
    });
    Fit::new(tracker, &Observed { crossings, switch, u_switch_ns })?.solution(tracker.state()[R_O])
}

/// The lower bound of a resistance that cannot be told from an open circuit, ohm; `None` where it can.
pub fn beyond(tracker: &Tracker, observed: &Observed) -> Option<f64> {
    let fit = Fit::new(tracker, observed)?;
    let highest = fit.siemens.max(0.0) + COVERAGE * fit.u_siemens;
    let r_min_ohm = 1.0 / highest - tracker.state()[R_O];
    let is_open = fit.siemens <= RESOLVED * fit.u_siemens;
    (is_open && r_min_ohm > 0.0 && r_min_ohm.is_finite()).then_some(r_min_ohm)
}

impl Observed {
    fn branch(&self, state: &State) -> Branch {
        let last = self.crossings[1].or(self.crossings[0]).unwrap_or(0.0) - state[D];
        match self.switch {
            Some((switch, _)) if last > switch.on_ns => Branch::Inferred,
            _ => Branch::Direct,
        }
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
        let (crossing_ns, g) = (crossing_ns - state[D], state[node]);
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

    /// With the instant of the switch, both its ends, per ohm.
    fn by_switch(&self, y: f64) -> f64 {
        self.next.map_or(0.0, |next| next - y)
    }

    /// With the state, at a given R_x.
    fn by_state(&self, state: &State, y: f64) -> State {
        let mut by = [0.0; 4];
        by[self.node] = 1.0;
        let rest = self.next.map_or(0.0, |next| (state[self.node] - self.missing) * next);
        by[R_O] = rest + self.through_ns * y * y;
        by[D] = -self.by_crossing(y);
        by
    }
}

/// The conductance of the sensor and its pin that fits a discharge best.
struct Fit {
    /// y = 1/(R_x+Ro), siemens.
    siemens: f64,
    /// 1 sigma, siemens.
    u_siemens: f64,
    /// The same with a calibration known exactly.
    bound_siemens: f64,
    /// How y depends on the state at a given R_x.
    by_state: State,
    branch: Branch,
    seen: Seen,
}

impl Fit {
    fn new(tracker: &Tracker, observed: &Observed) -> Option<Fit> {
        let (state, branch) = (tracker.state(), observed.branch(tracker.state()));
        // A switch after the last crossing has changed nothing.
        let switch = observed.switch.filter(|_| branch == Branch::Inferred);
        let [a_ns, b_ns] = observed.crossings;
        let u_switch_ns = observed.u_switch_ns;
        let Some(b_ns) = b_ns.filter(|_| tracker.nodes() == 2) else {
            return Fit::of_one(tracker, u_switch_ns, Equation::new(state, a_ns?, 0, switch), branch);
        };
        let b = Equation::new(state, b_ns, 1, switch);
        let Some(a_ns) = a_ns else { return Fit::of_one(tracker, u_switch_ns, b, branch) };
        // Whether A had crossed by the switch is told better by B than by A's own late stamp.
        let switch = switch.filter(|(switch, _)| switch.at_ns * b.missing < state[0] * b.through_ns);
        Fit::of_two(tracker, u_switch_ns, [Equation::new(state, a_ns, 0, switch), b], branch)
    }

    fn of_one(tracker: &Tracker, u_switch_ns: f64, one: Equation, branch: Branch) -> Option<Fit> {
        let y = one.missing / one.through_ns;
        let noise = tracker.noise().covariance([one.late_ns; 2])?;
        let noise = if one.node == 0 { noise.aa } else { noise.bb };
        let u_switch_ns = tracker.u_switch_ns(u_switch_ns);
        let own = one.by_crossing(y).powi(2) * noise + (one.by_switch(y) * u_switch_ns).powi(2);
        let by_state = one.by_state(tracker.state(), y).map(|by| by / one.through_ns);
        let own = own / (one.through_ns * one.through_ns);
        let fit = Fit {
            siemens: y,
            u_siemens: (own + quadratic(tracker.covariance(), &by_state)).sqrt(),
            bound_siemens: own.sqrt(),
            by_state,
            branch,
            seen: Seen::over(one.through_ns),
        };
        (one.through_ns > 0.0 && fit.u_siemens.is_finite()).then_some(fit)
    }

    fn of_two(tracker: &Tracker, u_switch_ns: f64, both: [Equation; 2], branch: Branch) -> Option<Fit> {
        let state = tracker.state();
        let noise = tracker.noise().covariance(both.map(|one| one.late_ns))?;
        let u_switch_ns = tracker.u_switch_ns(u_switch_ns);
        let through = both.map(|one| one.through_ns);
        let alone = both.map(|one| one.missing / one.through_ns);
        // The weights depend on y, but hardly: the last node's own value does for a start.
        let mut y = alone[1];
        for is_last in [false, true] {
            let own = own_noise(&noise, u_switch_ns, &both, y.max(0.0));
            let rows = both.map(|one| one.by_state(state, y.max(0.0)));
            let p = tracker.covariance();
            let all = Covariance {
                aa: own.aa + quadratic(p, &rows[0]),
                bb: own.bb + quadratic(p, &rows[1]),
                ab: own.ab + bilinear(p, &rows[0], &rows[1]),
            };
            let information = inner(&all, through, through)?;
            let weights = weights(&all, through)?.map(|weight| weight / information);
            y = weights[0] * both[0].missing + weights[1] * both[1].missing;
            if is_last {
                let left = [0, 1].map(|node| both[node].missing - through[node] * y);
                let misfit = inner(&all, left, left)?;
                // A late stamp that the other node is too noisy to refute is doubted as far as it may be one.
                let doubt = if misfit > DOUBT * DOUBT { misfit } else { 1.0 };
                let fit = Fit {
                    siemens: y,
                    u_siemens: (doubt / information).sqrt(),
                    bound_siemens: (1.0 / inner(&own, through, through)?).sqrt(),
                    by_state: std::array::from_fn(|i| weights[0] * rows[0][i] + weights[1] * rows[1][i]),
                    branch,
                    seen: seen(
                        through,
                        weights,
                        alone,
                        all.of(1.0 / through[0], -1.0 / through[1]),
                        y,
                        state[R_O],
                    )
                    .contradicting(misfit > GATE * GATE),
                };
                return (y.is_finite() && fit.u_siemens.is_finite()).then_some(fit);
            }
        }
        None
    }

    /// R_x = 1/y - Ro. 2 u stand for the interval of y +- 2 sigma, which 1/y makes longer: half of its length.
    fn solution(&self, r_o_ohm: f64) -> Option<Solution> {
        let Fit { siemens: y, u_siemens: u, bound_siemens, by_state, branch, seen } = *self;
        let square = y * y - (COVERAGE * u).powi(2);
        if y <= 0.0 || square <= 0.0 {
            return None;
        }
        let solution = Solution {
            r_ohm: 1.0 / y - r_o_ohm,
            variance: (u / square).powi(2),
            bound: (bound_siemens / (y * y)).powi(2),
            by_state: by_state.map(|by| -by / (y * y)),
            branch,
            seen,
        };
        (solution.r_ohm.is_finite() && solution.variance.is_finite()).then_some(solution)
    }
}

/// The covariance of the residuals by the crossings' noise and by the switch.
fn own_noise(noise: &Covariance, u_switch_ns: f64, both: &[Equation; 2], y: f64) -> Covariance {
    let [a, b] = both.map(|one| one.by_crossing(y));
    let [switch_a, switch_b] = both.map(|one| one.by_switch(y) * u_switch_ns);
    Covariance {
        aa: a * a * noise.aa + switch_a * switch_a,
        bb: b * b * noise.bb + switch_b * switch_b,
        ab: a * b * noise.ab + switch_a * switch_b,
    }
}

/// When it was so, and what each crossing says alone. `variance`: of the difference of both conductances.
fn seen(
    through_ns: [f64; 2],
    weights: [f64; 2],
    alone: [f64; 2],
    variance: f64,
    y: f64,
    r_o_ohm: f64,
) -> Seen {
    if alone.iter().any(|alone| *alone <= 0.0) {
        return Seen::over(through_ns[1]);
    }
    let shares = [0, 1].map(|node| weights[node] * through_ns[node]);
    let r_ohm = alone.map(|alone| 1.0 / alone - r_o_ohm);
    Seen::over_two(through_ns, shares, r_ohm, variance.sqrt() / (y * y))
}

/// S^-1 v.
fn weights(s: &Covariance, v: [f64; 2]) -> Option<[f64; 2]> {
    let determinant = s.aa * s.bb - s.ab * s.ab;
    (determinant > 0.0 && determinant.is_finite())
        .then(|| [(s.bb * v[0] - s.ab * v[1]) / determinant, (s.aa * v[1] - s.ab * v[0]) / determinant])
}

/// u^T S^-1 v.
fn inner(s: &Covariance, u: [f64; 2], v: [f64; 2]) -> Option<f64> {
    let weights = weights(s, v)?;
    Some(u[0] * weights[0] + u[1] * weights[1])
}
