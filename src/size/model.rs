//! One reading by `tracked`, in closed form: what its variance and its time are made of.
//!
//! With R' = R + R_lim + Ro, N' = R_N + Ro and theta = s/R' the progress at a switch after s, a node that crosses at g tells
//!
//! ```text
//! not switched   var R = (jitter^2 + move^2 + (kappa R')^2) / g^2
//! switched       var R = (R'/(theta N'))^2 (jitter^2 + (kappa N')^2) + 2 move^2 / theta^2
//! ```
//!
//! both nodes by inverse variance. Among all ways to end a discharge counts the one with the least variance times time, as in
//! the instrument. Calibrations are not in it.

use super::Design;
use super::limits::{CALLS, READS, STAMP};
use crate::circuit::{Circuit, Node};
use crate::instrument::limits::{SHORTEST_TAIL_NS, SWITCH_FRACTIONS};
use crate::pins::sim::Scene;
use crate::units::{Ohm, Seconds, Volt};

/// What of a board decides how well it reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Platform {
    /// Supply.
    pub v_dd: Volt,
    /// Falling threshold of an input.
    pub v_th: Volt,
    /// Output resistance of a pin.
    pub r_o: Ohm,
    /// Of stamps, 1 sigma, s.
    jitter_s: f64,
    /// Of the instant at which a line moves, 1 sigma, s.
    move_s: f64,
    /// At an input, root mean square.
    noise: Volt,
    /// What the calls of a discharge take, s.
    calls_s: f64,
}

impl Platform {
    /// That of a scene.
    pub fn of(scene: &Scene) -> Platform {
        let seconds = |time: Option<Seconds>| time.map_or(0.0, |time| time.0);
        let uniform = |width: f64| width / 12f64.sqrt();
        let clock = uniform(seconds(scene.clock_period));
        let jitter = seconds(scene.stamps.and_then(|stamps| stamps.jitter));
        let (move_s, each_s) = scene.calls.map_or((clock, 0.0), |calls| {
            let [from, to] = calls.moves_at.unwrap_or_default();
            (uniform((to - from) * calls.per_line.0), calls.fixed.0 + calls.per_line.0)
        });
        let reads = scene.reads;
        let waits: f64 =
            [scene.wake, scene.stamps, scene.sleep].iter().flatten().map(|delay| delay.mean.0).sum();
        Platform {
            v_dd: scene.circuit.v_dd,
            v_th: scene.circuit.threshold.falling,
            r_o: scene.circuit.r_o,
            jitter_s: jitter.hypot(clock).max(uniform(STAMP.0)),
            move_s,
            noise: scene.noise.map_or(Volt(0.0), |noise| noise.voltage),
            calls_s: CALLS * (each_s + 2.0 * seconds(reads.clock))
                + seconds(reads.arm)
                + READS * seconds(reads.levels)
                + waits,
        }
    }
}

/// What a reading's variance, ohm², or its time, s, is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Of the variance: jitter of stamps, moves of lines, noise of voltage.
    pub variance: [f64; 3],
    /// Of the time: charge, discharge, calls.
    pub time: [f64; 3],
}

impl Shares {
    /// All of the variance, ohm².
    pub fn variance(&self) -> f64 {
        self.variance.iter().sum()
    }

    /// All of the time, s.
    pub fn seconds(&self) -> f64 {
        self.time.iter().sum()
    }
}

/// A design on a board.
pub struct Model {
    circuit: Circuit,
    platform: Platform,
    r_lim: f64,
    nodes: &'static [Node],
    g: [f64; 2],
    trigger: [f64; 2],
    /// Before a discharge that waits for A, or for B, s.
    charge: [f64; 2],
    pub deadline_s: f64,
}

impl Model {
    /// `None` if a node never crosses.
    pub fn new(design: &Design, platform: &Platform) -> Option<Model> {
        let (config, circuit) = (design.config(platform), design.circuit(platform));
        let nodes = design.kind().nodes();
        let mut model = Model {
            circuit,
            platform: *platform,
            r_lim: design.r_lim.0,
            nodes,
            g: [0.0; 2],
            trigger: [0.0; 2],
            charge: [0.0; 2],
            deadline_s: config.deadline().as_seconds(),
        };
        let charges = config.charges();
        for node in nodes {
            let index = node.index();
            model.g[index] = circuit.g(*node)?.0;
            model.trigger[index] = circuit.trigger(*node, platform.noise)?;
            model.charge[index] = [charges.to_a, charges.to_b][index].time().as_seconds();
        }
        Some(model)
    }

    /// What goes before a discharge that waits for the last node, s.
    pub fn before_s(&self) -> f64 {
        self.charge[self.nodes.len() - 1] + self.platform.calls_s
    }

    /// A full discharge of R_2 to the last node in its shares: charge, discharge, calls, s.
    pub fn second(&self) -> [f64; 3] {
        self.second_to(self.nodes.len() - 1)
    }

    /// What corrects a calibration that is followed: R_2 as far as the first node, s.
    pub fn calibration_s(&self) -> f64 {
        self.second_to(0).iter().sum()
    }

    fn second_to(&self, node: usize) -> [f64; 3] {
        let discharge = self.g[node] * (self.circuit.r_c2.0 + self.circuit.r_o.0);
        [self.charge[node], discharge, self.platform.calls_s]
    }

    /// The reading of a resistance with the least variance times time, both in their shares.
    pub fn reading(&self, r_ohm: f64) -> Option<Shares> {
        let path = r_ohm + self.r_lim + self.circuit.r_o.0;
        let price = |shares: &Shares| shares.variance() * shares.seconds();
        let ways = self.nodes.iter().flat_map(|last| {
            let switched = [self.circuit.r_c2, self.circuit.r_c1]
                .into_iter()
                .flat_map(|to| SWITCH_FRACTIONS.map(|fraction| Some((fraction, to.0 + self.circuit.r_o.0))));
            std::iter::once(None).chain(switched).filter_map(|switch| self.way(path, *last, switch))
        });
        ways.min_by(|a, b| price(a).total_cmp(&price(b)))
    }

    /// A discharge that waits for `last`, switched or not at a fraction of the time that it would take, to a resistor.
    fn way(&self, path: f64, last: Node, switch: Option<(f64, f64)>) -> Option<Shares> {
        let full = self.g[last.index()] * path;
        let limit = (self.deadline_s, self.circuit.r_c1.0 + self.circuit.r_o.0);
        let switch = match switch {
            None => (full > limit.0).then_some(limit),
            Some((fraction, to)) => Some((fraction * full.min(limit.0), to)),
        };
        let crosses = |node: usize| {
            let plain = self.g[node] * path;
            switch
                .filter(|(at, _)| *at < plain)
                .map_or(plain, |(at, to)| at + (self.g[node] - at / path) * to)
        };
        let takes = crosses(last.index());
        if switch.is_some_and(|(at, _)| takes - at < SHORTEST_TAIL_NS * 1e-9) {
            return None;
        }
        let Platform { jitter_s, move_s, calls_s, .. } = self.platform;
        let (mut information, mut parts) = (0.0, [0.0; 3]);
        for node in &self.nodes[..=last.index()] {
            let index = node.index();
            let split = switch.filter(|(at, _)| *at < self.g[index] * path);
            let each = match split {
                None => [jitter_s, move_s, self.trigger[index] * path].map(|s| (s / self.g[index]).powi(2)),
                Some((at, to)) => {
                    let lever = path * path / (at * to);
                    let [stamp, noise] = [jitter_s, self.trigger[index] * to].map(|s| (lever * s).powi(2));
                    [stamp, 2.0 * (move_s * path / at).powi(2), noise]
                }
            };
            let weight = 1.0 / each.iter().sum::<f64>();
            information += weight;
            parts = std::array::from_fn(|part| parts[part] + weight * weight * each[part]);
        }
        Some(Shares {
            variance: parts.map(|part| part / (information * information)),
            time: [self.charge[last.index()], takes, calls_s],
        })
    }
}
