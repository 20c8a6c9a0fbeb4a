//! The voltages of the circuit's nodes while nothing switches: Kirchhoff's laws on nodes A and B, solved in closed form.
//!
//! Seconds, volt, ohm and farad, all `f64`; no clocks, no noise, and nothing of the estimators.
//!
//! With u the voltage across C_A (from B to A), w the voltage of node B, and i_A, i_B the currents that resistors
//! push into the nodes,
//!
//! ```text
//! C_A du/dt = i_A            i_A = s_A - G_A (u + w)
//! C_B dw/dt = i_A + i_B      i_B = s_B - G_B w
//! ```
//!
//! The conductance matrix is symmetric, so in the coordinates sqrt(C_A) u, sqrt(C_B) w the two modes are
//! orthogonal and decay with real rates: a node's voltage is V(0) + k1 phi(r1, t) + k2 phi(r2, t) with
//! phi(r, t) = (1 - exp(-r t)) / r, or t where the rate is 0 (charge that cannot leave, or a constant current).
//!
//! Capacitors whose dielectric absorbs charge have a mode more for each branch: `absorption`.

use super::waveform::Waveform;
use crate::circuit::{Kind, Network, Node};
use crate::pins::{Drives, MAX_CHANNELS};
use crate::units::Farad;

mod absorption;

/// How many lines can drive: two chargers, two sinks of calibration resistors, the sensors' sinks.
pub const LINES: usize = 4 + MAX_CHANNELS;

/// The index of a single line in tables by line; the order is that of the bits of [`Drives`].
pub fn line_index(line: Drives) -> usize {
    (line.0.trailing_zeros() as usize).min(LINES - 1)
}

/// What hangs on a sense node besides the circuit proper.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sense {
    /// A high node becomes low here, volt.
    pub falling: f64,
    /// A low node becomes high here, volt; not below `falling`.
    pub rising: f64,
    /// Constant current from the node to ground, ampere.
    pub leakage: f64,
    /// Conductance to ground (leakage resistance, pull-down), siemens.
    pub to_ground: f64,
    /// Conductance to V_DD (pull-up), siemens.
    pub to_v_dd: f64,
}

/// A part of a capacitor's charge that comes and goes slowly: a capacitor beside it, through a resistor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Its capacitance, of that of the capacitor.
    pub share: f64,
    /// Its resistance times its capacitance, s.
    pub tau: f64,
}

/// A circuit as it is built, unknown to the estimators.
#[derive(Debug, Clone, PartialEq)]
pub struct SimCircuit {
    /// The capacitors and what they connect.
    pub network: Network,
    /// What the dielectrics absorb: of C_A or the only capacitor, and of C_B.
    pub absorption: [Vec<Branch>; 2],
    /// Supply, volt.
    pub v_dd: f64,
    /// Rc1, ohm.
    pub r_c1: f64,
    /// Rc2, ohm.
    pub r_c2: f64,
    /// In series with each charger, ohm.
    pub r_p: f64,
    /// Output resistance of each line, ohm, by [`line_index`].
    pub r_o: [f64; LINES],
    /// The sensors, ohm.
    pub r_x: [f64; MAX_CHANNELS],
    /// The sense nodes A and B.
    pub sense: [Sense; 2],
}

/// One node's connection to everything but the capacitors: current into it = `source` - `conductance` * voltage.
#[derive(Debug, Clone, Copy)]
struct Load {
    source: f64,
    conductance: f64,
}

impl Load {
    fn current(self, voltage: f64) -> f64 {
        self.source - self.conductance * voltage
    }

    fn add(&mut self, resistance: f64, to_voltage: f64) {
        self.conductance += 1.0 / resistance;
        self.source += to_voltage / resistance;
    }
}

impl SimCircuit {
    /// Whether there is a node B.
    pub fn has_b(&self) -> bool {
        self.network.kind() == Kind::TwoCapacitor
    }

    /// How the nodes go on from voltages `start`, which have been there for ever, while exactly the lines of `on` drive.
    pub fn flow(&self, start: [f64; 2], on: Drives) -> Flow {
        self.flow_from(start, &[], on)
    }

    /// How they go on from what has become of `before` after so many seconds.
    pub fn flow_after(&self, before: &Flow, seconds: f64, on: Drives) -> Flow {
        let branches: Vec<f64> = before.branches.iter().map(|branch| branch.at(seconds)).collect();
        self.flow_from(before.after(seconds), &branches, on)
    }

    fn flow_from(&self, start: [f64; 2], branches: &[f64], on: Drives) -> Flow {
        let load_a = self.load_a(on);
        if self.absorption.iter().any(|branches| !branches.is_empty()) {
            return self.absorbing(start, branches, load_a, self.load_b(on));
        }
        match self.network {
            Network::OneCapacitor { c: Farad(c) } | Network::SeriesCalibration { c: Farad(c) } => {
                let slope = load_a.current(start[0]) / c;
                Flow::of_modes(start, [load_a.conductance / c, 0.0], [[slope, 0.0], [0.0, 0.0]])
            }
            Network::TwoCapacitor { c_a, c_b } => two_modes(start, load_a, self.load_b(on), c_a.0, c_b.0),
        }
    }

    fn load_a(&self, on: Drives) -> Load {
        let mut load = self.load_of(Node::A);
        for line in on.lines() {
            let r_o = self.r_o[line_index(line)];
            match line {
                Drives::CHARGE_A => load.add(self.r_p + r_o, self.v_dd),
                Drives::CHARGE_B | Drives::C1 | Drives::C2 => {}
                x => load.add(self.r_x[line_index(x) - 4] + r_o, 0.0),
            }
        }
        load.conductance += self.calibration_conductance(on);
        load
    }

    fn load_b(&self, on: Drives) -> Load {
        let mut load = self.load_of(Node::B);
        if on.contains(Drives::CHARGE_B) {
            load.add(self.r_p + self.r_o[line_index(Drives::CHARGE_B)], self.v_dd);
        }
        load
    }

    fn load_of(&self, node: Node) -> Load {
        let sense = &self.sense[node.index()];
        Load {
            source: sense.to_v_dd * self.v_dd - sense.leakage,
            conductance: sense.to_v_dd + sense.to_ground,
        }
    }

    /// From node A to ground through Rc1 and Rc2, siemens. The node between them in Fig. 1(b) has no capacitor.
    fn calibration_conductance(&self, on: Drives) -> f64 {
        let sunk = |line: Drives, resistor: f64| {
            if on.contains(line) { 1.0 / (resistor + self.r_o[line_index(line)]) } else { 0.0 }
        };
        match self.network {
            Network::SeriesCalibration { .. } => {
                let beyond_r_c1 = sunk(Drives::C1, 0.0) + sunk(Drives::C2, self.r_c2);
                if beyond_r_c1 > 0.0 { 1.0 / (self.r_c1 + 1.0 / beyond_r_c1) } else { 0.0 }
            }
            _ => sunk(Drives::C1, self.r_c1) + sunk(Drives::C2, self.r_c2),
        }
    }
}

/// The two-capacitor network by its modes.
fn two_modes(start: [f64; 2], load_a: Load, load_b: Load, c_a: f64, c_b: f64) -> Flow {
    let (g_a, g_b) = (load_a.conductance, load_b.conductance);
    let (i_a, i_b) = (load_a.current(start[0]), load_b.current(start[1]));
    if g_b == 0.0 && load_b.source == 0.0 {
        // Nothing but the capacitors at node B: its charge moves with node A's, in a single mode.
        let slopes = [[i_a / c_a + i_a / c_b, 0.0], [i_a / c_b, 0.0]];
        return Flow::of_modes(start, [g_a / c_a + g_a / c_b, 0.0], slopes);
    }
    let (root_a, root_b) = (c_a.sqrt(), c_b.sqrt());
    let (first, coupling, second) = (g_a / c_a, g_a / (root_a * root_b), (g_a + g_b) / c_b);
    let half_difference = (first - second) / 2.0;
    let radius = half_difference.hypot(coupling);
    let fast = (first + second) / 2.0 + radius;
    // The product of the rates is exact where their difference would cancel.
    let slow = if fast > 0.0 { g_a * g_b / (c_a * c_b) / fast } else { 0.0 };
    let (x, y) = if radius == 0.0 {
        (1.0, 0.0)
    } else if half_difference >= 0.0 {
        (half_difference + radius, coupling)
    } else {
        (coupling, radius - half_difference)
    };
    let length = x.hypot(y);
    let (cos, sin) = (x / length, y / length);
    let (p, q) = (i_a / root_a, (i_a + i_b) / root_b);
    let (m_fast, m_slow) = (cos * p + sin * q, cos * q - sin * p);
    let at_b = [m_fast * sin / root_b, m_slow * cos / root_b];
    let at_a = [m_fast * cos / root_a + at_b[0], at_b[1] - m_slow * sin / root_a];
    Flow::of_modes(start, [fast, slow], [at_a, at_b])
}

/// The node voltages as functions of the time since a change.
#[derive(Debug, Clone, PartialEq)]
pub struct Flow {
    nodes: [Waveform; 2],
    /// Across the capacitors of absorbing branches: those of C_A, then those of C_B.
    branches: Vec<Waveform>,
}

impl Flow {
    fn of_modes(start: [f64; 2], rates: [f64; 2], slopes: [[f64; 2]; 2]) -> Flow {
        let nodes = [0, 1].map(|node| {
            let [first, second] = slopes[node];
            Waveform::of_two(start[node], [(rates[0], first), (rates[1], second)])
        });
        Flow { nodes, branches: Vec::new() }
    }

    /// The voltages of A and B after `seconds`; B of a circuit without it keeps its start.
    pub fn after(&self, seconds: f64) -> [f64; 2] {
        [self.nodes[0].at(seconds), self.nodes[1].at(seconds)]
    }

    /// One node's voltage.
    pub fn waveform(&self, node: Node) -> Waveform {
        self.nodes[node.index()].clone()
    }
}

#[cfg(test)]
pub(super) mod tests;
