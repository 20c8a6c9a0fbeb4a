//! The law of the circuit: a discharge runs along one fixed trajectory, and only its speed depends on the resistor.
//!
//! For: planning (predicted times), checking a configuration, documentation. Must not know: GPIO lines,
//! configuration files, or how measured times become a resistance; nominal values never enter an estimate.
//!
//! The *progress* of a discharge is `theta = sum of t_i / (R_i + Ro)` over its parts, in s/ohm = F. Node A crosses
//! its threshold at `theta = g_A`, node B at `theta = g_B`, whatever the resistors were. Equation numbers are those
//! of the paper on the compact error reduction method: (2), (6) one capacitor; (9), (10) two capacitors, with C_A
//! between the nodes A and B, C_B from B to ground, and the resistors at A.

use crate::units::{Farad, Ohm, Seconds, Volt};
use std::ops::RangeInclusive;

mod charge;
mod kind;
mod node;

pub use charge::Chargers;
pub use kind::Kind;
pub use node::Node;

/// What resistors are sold; outside is a slip of a prefix (judgement).
pub const RESISTORS: RangeInclusive<Ohm> = Ohm(1.0)..=Ohm(100e6);
/// Supply voltage V_DD when nothing else is said.
pub const NOMINAL_V_DD: Volt = Volt(3.3);
/// Falling threshold V_Th of an input when nothing else is said.
pub const NOMINAL_V_TH: Volt = Volt(1.3);
/// Rp + Ro of a charger when nothing else is said, 180 ohm and a pin of 40 ohm: 3.3 V over it stay below the 16 mA that a pin
/// may deliver. The parts of hw/wiring.md, 220 ohm and 40 ohm, leave more room; hw/cermd.toml says so.
pub const NOMINAL_R_CHARGE: Ohm = Ohm(220.0);
/// Output resistance Ro of a sinking pin, for predictions only.
pub const NOMINAL_R_O: Ohm = Ohm(40.0);

/// The capacitors, and how the calibration resistors are wired to them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Network {
    /// Fig. 1(c): TCDIC and CERM; node A alone serves TPCM too.
    TwoCapacitor {
        /// Between nodes A and B.
        c_a: Farad,
        /// From node B to ground.
        c_b: Farad,
    },
    /// Fig. 1(a): TPCM.
    OneCapacitor {
        /// From node A to ground.
        c: Farad,
    },
    /// Fig. 1(b): QERM; Rc2 is in series with Rc1.
    SeriesCalibration {
        /// From node A to ground.
        c: Farad,
    },
}

/// A circuit by its nominal values. What it promises means nothing unless they are above zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circuit {
    /// The capacitors.
    pub network: Network,
    /// Calibration resistor Rc1, the lower one.
    pub r_c1: Ohm,
    /// Calibration resistor Rc2.
    pub r_c2: Ohm,
    /// Supply voltage V_DD.
    pub v_dd: Volt,
    /// Falling threshold V_Th of the sense inputs.
    pub v_th: Volt,
    /// Rp + Ro of a charger.
    pub r_charge: Ohm,
    /// Output resistance Ro of a sinking pin.
    pub r_o: Ohm,
}

impl Circuit {
    /// The capacitance that a discharge sees: C, or C_T = C_A C_B / (C_A + C_B).
    pub fn c_total(&self) -> Farad {
        match self.network {
            Network::TwoCapacitor { c_a, c_b } => Farad(c_a.0 * c_b.0 / (c_a.0 + c_b.0)),
            Network::OneCapacitor { c } | Network::SeriesCalibration { c } => c,
        }
    }

    /// The voltage of a node at a progress: eq. (6), (9). `None` for a node that the circuit does not have.
    pub fn voltage(&self, node: Node, theta: Farad) -> Option<Volt> {
        let v_a = self.v_dd.0 * (-theta.0 / self.c_total().0).exp();
        match (node, self.network) {
            (Node::A, _) => Some(Volt(v_a)),
            (Node::B, Network::TwoCapacitor { c_a, c_b }) => {
                Some(Volt((v_a * c_a.0 + self.v_dd.0 * c_b.0) / (c_a.0 + c_b.0)))
            }
            (Node::B, _) => None,
        }
    }

    /// The progress g at which a node crosses its threshold: eq. (2), (10) divided by R + Ro. `None` for a node
    /// that the circuit does not have or that never crosses.
    pub fn g(&self, node: Node) -> Option<Farad> {
        let (v_dd, v_th) = (self.v_dd.0, self.v_th.0);
        let ratio = match (node, self.network) {
            (Node::A, _) => v_dd / v_th,
            (Node::B, Network::TwoCapacitor { c_a, c_b }) => {
                v_dd * c_a.0 / (v_th * (c_a.0 + c_b.0) - v_dd * c_b.0)
            }
            (Node::B, _) => return None,
        };
        // A ratio of 1 or less: the threshold is not below the start. Negative, infinite: not above the end.
        (ratio > 1.0 && ratio.is_finite()).then(|| Farad(self.c_total().0 * ratio.ln()))
    }

    /// When a node crosses its threshold in a full discharge through `r`: eq. (2), (10).
    pub fn crossing(&self, node: Node, r: Ohm) -> Option<Seconds> {
        self.g(node).map(|g| Seconds(g.0 * (r.0 + self.r_o.0)))
    }

    /// The resistance whose full discharge brings a node to its threshold after `time`: what a deadline resolves.
    pub fn resistance(&self, node: Node, time: Seconds) -> Option<Ohm> {
        self.g(node).map(|g| Ohm(time.0 / g.0 - self.r_o.0))
    }

    /// Voltage noise over the slope of a node at its crossing, in seconds per ohm that the discharge runs through (eq. (7)). `None`
    /// for a node that never crosses.
    pub fn trigger(&self, node: Node, noise: Volt) -> Option<f64> {
        let share = match (node, self.network) {
            (Node::B, Network::TwoCapacitor { c_a, c_b }) => c_a.0 / (c_a.0 + c_b.0),
            _ => 1.0,
        };
        let volt = self.v_dd.0 * self.left_at_crossing(node)? * share;
        Some(noise.0 * self.c_total().0 / volt)
    }

    /// How it is wired.
    pub fn kind(&self) -> Kind {
        self.network.kind()
    }

    /// The resistor of the second calibration discharge: Rc2, or Rc1 + Rc2 where they are in series.
    pub fn r_second(&self) -> Ohm {
        Ohm(self.kind().known([self.r_c1.0, self.r_c2.0])[1])
    }
}

#[cfg(test)]
mod tests;
