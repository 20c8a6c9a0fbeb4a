//! How short a charge may be: until what it remembers of the discharge before it is small beside a reading's uncertainty.
//!
//! Everything here is predicted from nominal values.
//!
//! The error of a reading is linear in the depths D_j from which the charges of its discharges began ([`charge_memory`](crate::circuit::Circuit::charge_memory)
//! has the derivation), and its coefficients c_j add up to nothing, since what is common to all of them cancels. So depths
//! within a span S make an error of S/2 times the sum of |c_j| at the most. The coefficients, with R' = R + Ro, m the memory
//! of the node and rho = (R_x - R_1)/(R_2 - R_1):
//!
//! | equation | sensor | R_1 | R_2 |
//! |---|---|---|---|
//! | (3), (11): the times or their sums | m R_x' | -m (1-rho) R_1' | -m rho R_2' |
//! | finished through R_2 after the progress theta: (16)-(19), QERM | q R_x', q = m g/theta | -m (1-rho) R_1' | the rest |
//! | tracked calibration | m R_x' or q R_x' | all of the rest | |
//!
//! In (11) and (19), m is the mean of both nodes by g. That the latency offset is found with such charges, too, adds some percent
//! to this at most.

use super::Config;
use super::limits::{
    CHARGE_SHARE, JITTER_S, LATENESS_S, LEAST_TAUS, NOISE_V, PER_DECADE, RESISTANCES, SWITCH_S,
};
use crate::circuit::{Chargers, Node};
use crate::estimate::method::Switching;
use crate::reading::Method;
use crate::units::{Nanos, Ohm, Seconds, Volt};

/// A resistance, and by how many of its own sigma an incomplete charge may change a reading of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remembered {
    /// The resistance where it is most.
    pub at: Ohm,
    /// Error over sigma.
    pub sigmas: f64,
}

impl Config {
    /// What charges through these of so many time constants remember, at most.
    pub fn remembered(&self, chargers: Chargers, taus: f64) -> Remembered {
        let none = Remembered { at: self.circuit.r_c2, sigmas: 0.0 };
        let Some(budget) = Budget::new(self, chargers) else { return none };
        let highest = self.circuit.resistance(self.last_node(), self.deadline().into()).unwrap_or_default();
        (0..RESISTANCES)
            .map(|step| Ohm(highest.0 * 10f64.powf(-f64::from(step) / PER_DECADE)))
            .map(|at| Remembered { at, sigmas: budget.sigmas(at) * (-taus).exp() })
            .filter(|found| found.sigmas.is_finite())
            .max_by(|a, b| a.sigmas.total_cmp(&b.sigmas))
            .unwrap_or(none)
    }

    /// The shortest charge through these that a reading does not suffer from.
    pub fn shortest_charge(&self, chargers: Chargers) -> Seconds {
        let taus = (self.remembered(chargers, 0.0).sigmas / CHARGE_SHARE).ln().max(LEAST_TAUS);
        Seconds(taus * self.circuit.charge_tau(chargers).0)
    }
}

/// The nominal values that error and uncertainty follow from; index 0 is node A.
struct Budget {
    method: Method,
    is_tracked: bool,
    r_o: f64,
    /// R_1 and R_2, with Ro.
    known: [f64; 2],
    nodes: usize,
    g: [f64; 2],
    memory: [f64; 2],
    /// Latency jitter and quantisation, s; trigger noise in s per ohm that the discharge runs through.
    jitter: f64,
    trigger: [f64; 2],
    /// Scatter of the instant of a switch, s.
    switch: f64,
    /// By how much depths differ.
    span: f64,
    /// Progress at which a discharge is switched, in g_A.
    fraction: f64,
}

/// How an equation sees the charges before the sensor, R_1 and R_2 (s/s x ohm), and its variance, ohm².
struct Sensitivity {
    by_depth: [f64; 3],
    variance: f64,
}

impl Budget {
    fn new(config: &Config, chargers: Chargers) -> Option<Budget> {
        let circuit = &config.circuit;
        let last = config.last_node();
        let both = |of: &dyn Fn(Node) -> Option<f64>| {
            Some([of(Node::A)?, if last == Node::B { of(Node::B)? } else { 0.0 }])
        };
        let forgets = (-LATENESS_S / circuit.charge_tau(chargers).0).exp();
        // A clock that is not that of Linux counts in hardware: its period is all the jitter there is.
        let coarser = config.measure.resolution.filter(|clock| *clock > Nanos(1));
        Some(Budget {
            method: config.method(),
            is_tracked: config.is_tracked(),
            r_o: circuit.r_o.0,
            known: [circuit.r_c1, circuit.r_second()].map(|r| r.0 + circuit.r_o.0),
            nodes: if last == Node::B { 2 } else { 1 },
            g: both(&|node| circuit.g(node).map(|g| g.0))?,
            memory: both(&|node| circuit.charge_memory(node, chargers))?,
            jitter: coarser.map_or(JITTER_S, |clock| clock.as_seconds() / 12f64.sqrt()),
            trigger: both(&|node| circuit.trigger(node, Volt(NOISE_V)))?,
            switch: SWITCH_S,
            span: 1.0 - (1.0 - circuit.left_at_crossing(last)?) * forgets,
            fraction: config.switch_fraction(),
        })
    }

    /// Error over sigma of a reading of `r`, before any charge has forgotten anything.
    fn sigmas(&self, r: Ohm) -> f64 {
        let equation = self.equation(r);
        let depths: f64 = equation.by_depth.iter().map(|by| by.abs()).sum();
        self.span / 2.0 * depths / equation.variance.sqrt()
    }

    /// The equation that a reading of `r` is likely to come from.
    fn equation(&self, r: Ohm) -> Sensitivity {
        let r = r.0 + self.r_o;
        let (rules, theta) = (self.method.rules(), self.fraction * self.g[0]);
        match rules.switching {
            Switching::Never => self.plain(r),
            Switching::AtFraction if rules.sinks_beside => {
                self.finished(r, theta / (1.0 + r / self.known[1]))
            }
            Switching::AtFraction => self.plain(r).or(self.finished(r, theta)),
            Switching::WhereBest => self.weighted(r, None).or(self.weighted(r, Some(theta))),
        }
    }

    /// Variance of a crossing through `r` (with Ro), s².
    fn variance(&self, node: usize, r: f64) -> f64 {
        self.jitter.powi(2) + (self.trigger[node] * r).powi(2)
    }

    /// The same of the sum of all nodes, relative to the sum of g: ohm².
    fn variance_of_sum(&self, r: f64) -> f64 {
        let sum: f64 = (0..self.nodes).map(|node| self.variance(node, r)).sum();
        sum / self.g.iter().sum::<f64>().powi(2)
    }

    fn mean_memory(&self) -> f64 {
        (0..self.nodes).map(|node| self.g[node] * self.memory[node]).sum::<f64>() / self.g.iter().sum::<f64>()
    }

    /// The weights of R_1 and R_2 in a reading of `r`.
    fn parts(&self, r: f64) -> [f64; 2] {
        let [r1, r2] = self.known;
        let rho = (r - r1) / (r2 - r1);
        [1.0 - rho, rho]
    }

    /// What both calibration discharges add, ohm².
    fn calibration(&self, r: f64) -> f64 {
        let [p1, p2] = self.parts(r);
        let each = [(p1, self.known[0]), (p2, self.known[1])];
        if self.is_tracked { 0.0 } else { each.map(|(p, r)| p * p * self.variance_of_sum(r)).iter().sum() }
    }

    /// The rest of the coefficients, given that of the sensor.
    fn depths(&self, r: f64, sensor: f64) -> [f64; 3] {
        let first =
            if self.is_tracked { 0.0 } else { -self.parts(r)[0] * self.known[0] * self.mean_memory() };
        [sensor, first, -sensor - first]
    }

    fn plain(&self, r: f64) -> Sensitivity {
        let by_depth = self.depths(r, self.mean_memory() * r);
        Sensitivity { by_depth, variance: self.variance_of_sum(r) + self.calibration(r) }
    }

    /// Two discharges end through R_2: the sensor's and that of R_2; a tracked calibration knows the latter.
    fn finished(&self, r: f64, theta: f64) -> Sensitivity {
        let (last, r2) = (self.nodes - 1, self.known[1]);
        let crossings = if self.is_tracked { 1.0 } else { 2.0 } * self.variance(last, r2) / (r2 * r2);
        let variance = (r / theta).powi(2) * crossings + (self.switch / theta).powi(2);
        let by_depth = self.depths(r, r * self.memory[last] * self.g[last] / theta);
        Sensitivity { by_depth, variance: variance + self.calibration(r) }
    }

    /// Nodes by inverse variance; `theta`: where the discharge is switched. Their memories may have different signs; that they
    /// cancel is not counted on.
    fn weighted(&self, r: f64, theta: Option<f64>) -> Sensitivity {
        let r2 = self.known[1];
        let (mut weights, mut sensor) = (0.0, 0.0);
        for node in 0..self.nodes {
            let (g, memory) = (self.g[node], self.memory[node].abs());
            let (weight, memory) = match theta.filter(|theta| *theta < g) {
                None => (g.powi(2) / self.variance(node, r), memory),
                Some(theta) => ((theta * r2 / r).powi(2) / self.variance(node, r2), memory * g / theta),
            };
            weights += weight;
            sensor += weight * memory;
        }
        let scatter = theta.map_or(0.0, |theta| (self.switch / theta).powi(2));
        Sensitivity { by_depth: self.depths(r, r * sensor / weights), variance: 1.0 / weights + scatter }
    }
}

impl Sensitivity {
    /// Whichever promises less variance.
    fn or(self, other: Sensitivity) -> Sensitivity {
        if other.variance < self.variance { other } else { self }
    }
}
