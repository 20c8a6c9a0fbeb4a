//! What a charge of finite length remembers of the discharge before it.
//!
//! A discharge ends somewhere on one line of states, since the same charge has left C_A and C_B: with V_DD as the unit of
//! voltage, node A is the *depth* D below it and node B is k D, with k = C_A/(C_A+C_B). It ends after its last crossing, by
//! as much as the system takes to release the sink: so D is between that crossing's own depth `1 - exp(-g/C_T)` and 1, and
//! differs from discharge to discharge, most after a low resistance, which falls on quickly.
//!
//! The charge then shrinks the deviations a = V_DD - V_A and b = V_DD - V_B from their start (D, k D) by
//!
//! ```text
//! (Rp+Ro) da/dt = -(1/C_A + 1/C_B) a - b / C_B
//! (Rp+Ro) db/dt = -a / C_B - b / C_B
//! ```
//!
//! whose matrix is symmetric with trace 1/C_A + 2/C_B and determinant 1/(C_A C_B). The slower of its two time constants is
//! tau = (Rp+Ro) (C_B + 2 C_A + sqrt(C_B^2 + 4 C_A^2)) / 2, `2 (Rp+Ro) C_A` where C_A >> C_B, since C_A then discharges
//! through both chargers in series; the faster one is at least 6.8 times shorter (the limit of C_A = C_B) and gone long before. The
//! second line makes the slow mode (x, 1) with x = (Rp+Ro) C_B/tau - 1, and the part of the start that is in it leaves
//!
//! ```text
//! (a, b) = (x, 1) (x + k)/(x^2 + 1) D exp(-t/tau)
//! ```
//!
//! A discharge from there instead of from V_DD reaches the threshold after another progress. With e = exp(-theta/C_T), eq. (9)
//! is V_A = (1 - a) e and V_B = 1 - b - k (1 - a)(1 - e), so that to first order, with v = V_Th/V_DD,
//!
//! ```text
//! dg_A = -C_T a          dg_B = -C_T (b - (1 - v) a) / (k e_B),   e_B = exp(-g_B/C_T)
//! ```
//!
//! One capacitor: the same with x = 0, k = 0 for node A alone, that is a = D exp(-t/tau), tau = (Rp+Ro) C.
//!
//! **Through A alone**, B floating, the same charge comes back into both capacitors: (a, b) = (1, k) D exp(-t/tau) with
//! tau = (Rp+Ro) C_T, many times shorter; the equations above with no charger at B. B stays wherever leaks have brought it.
//!
//! What all discharges find alike is only another g, and cancels in every method; what their D differ by does not.

use super::{Circuit, Network};
use crate::circuit::Node;
use crate::units::Seconds;

/// Which nodes are charged through Rp + Ro to V_DD.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chargers {
    /// A, every other node floating.
    OfA,
    /// All.
    All,
}

impl Circuit {
    /// The slowest time constant of the charge.
    pub fn charge_tau(&self, chargers: Chargers) -> Seconds {
        let c = match (self.network, chargers) {
            (Network::TwoCapacitor { c_a, c_b }, Chargers::All) => {
                (c_b.0 + 2.0 * c_a.0 + c_b.0.hypot(2.0 * c_a.0)) / 2.0
            }
            _ => self.c_total().0,
        };
        Seconds(self.r_charge.0 * c)
    }

    /// The time constant with which its own charger brings B back to V_DD while A is held there; `None` without a B.
    pub fn charge_tau_b(&self) -> Option<Seconds> {
        match self.network {
            Network::TwoCapacitor { c_a, c_b } => Some(Seconds(self.r_charge.0 * (c_a.0 + c_b.0))),
            _ => None,
        }
    }

    /// What is left of node A's voltage, as a share of V_DD, when a node crosses its threshold: e = 1 - D.
    pub fn left_at_crossing(&self, node: Node) -> Option<f64> {
        self.g(node).map(|g| (-g.0 / self.c_total().0).exp())
    }

    /// By how much a node's g changes, relative, with the depth D from which a charge begins: to be multiplied by
    /// exp(-t/tau).
    pub fn charge_memory(&self, node: Node, chargers: Chargers) -> Option<f64> {
        let (a, b, k) = match (self.network, chargers) {
            (Network::TwoCapacitor { c_a, c_b }, Chargers::OfA) => {
                let k = c_a.0 / (c_a.0 + c_b.0);
                (1.0, k, k)
            }
            (Network::TwoCapacitor { c_a, c_b }, Chargers::All) => {
                let k = c_a.0 / (c_a.0 + c_b.0);
                let x = self.r_charge.0 * c_b.0 / self.charge_tau(chargers).0 - 1.0;
                let slow = (x + k) / (x * x + 1.0);
                (slow * x, slow, k)
            }
            (Network::OneCapacitor { .. } | Network::SeriesCalibration { .. }, _) => (1.0, 0.0, 1.0),
        };
        let e = self.left_at_crossing(node)?;
        let later = match node {
            Node::A => -a,
            Node::B => -(b - (1.0 - self.v_th.0 / self.v_dd.0) * a) / (k * e),
        };
        // In units of C_T, g is -ln e.
        Some(later / -e.ln())
    }
}
