//! When a node crosses, as a function of everything that it depends on.
//!
//! A discharge through R (and from a switch on through N) advances by t/(R+Ro) in the time t; a node crosses when the
//! sum reaches its g:
//!
//! ```text
//! T = d + g (R+Ro)                               when it crosses before the switch
//! T = d + on + (g - at/(R+Ro)) (N+Ro)            after it
//! ```
//!
//! Each node has a d of its own: its edges take another way through the kernel.

use crate::record::Switch;

/// How many things a calibration has to know.
pub const UNKNOWNS: usize = 7;
/// What it has to know: progress g of A and B at the threshold (ns/ohm), Ro (ohm), d of A, how much later B is stamped (ns), and
/// how fast either g changes (1/s).
pub type State = [f64; UNKNOWNS];
/// The index of Ro in a [`State`].
pub const R_O: usize = 2;
/// The index of node A's d in a [`State`].
pub const D: usize = 3;
/// The index of what node B's d is greater by.
pub const D_B: usize = 4;

/// The index of how fast A's g changes in a [`State`]; that of B's comes after it.
pub const RATE: usize = 5;

/// The latency offset of a node, ns.
pub fn d_ns(state: &State, node: usize) -> f64 {
    state[D] + if node == 1 { state[D_B] } else { 0.0 }
}

/// The resistors of a discharge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Route {
    /// What it starts through, ohm.
    pub first_ohm: f64,
    /// When it was switched, and what it goes on through, ohm.
    pub switch: Option<(Switch, f64)>,
}

/// A crossing and what it depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// As it would be stamped, d included, ns since the start.
    pub ns: f64,
    /// By the state.
    pub by_state: State,
    /// By the time that it ran through the first resistor, without a unit. When the next one was sunk is uncertain as a start is:
    /// that is part of the crossing's own noise.
    pub by_switch: f64,
}

impl Route {
    /// When `node` (0 for A, 1 for B) crosses.
    pub fn crossing(&self, state: &State, node: usize) -> Crossing {
        let (g, r_o, d) = (state[node], state[R_O], d_ns(state, node));
        let first = self.first_ohm + r_o;
        let mut by_state = [0.0; UNKNOWNS];
        by_state[D] = 1.0;
        by_state[D_B] = node as f64;
        match self.switch {
            Some((switch, next_ohm)) if switch.at_ns < g * first => {
                let next = next_ohm + r_o;
                let done = switch.at_ns / first;
                by_state[node] = next;
                by_state[R_O] = g - done + done * next / first;
                Crossing { ns: d + switch.on_ns + (g - done) * next, by_state, by_switch: -next / first }
            }
            _ => {
                by_state[node] = first;
                by_state[R_O] = g;
                Crossing { ns: d + g * first, by_state, by_switch: 0.0 }
            }
        }
    }

    /// Both nodes' crossings if each were through the resistor that it crosses in alone: what their noise goes by, ns.
    pub fn late_ns(&self, state: &State) -> [f64; 2] {
        [0, 1].map(|node| {
            let first = state[node] * (self.first_ohm + state[R_O]);
            match self.switch {
                Some((switch, next_ohm)) if switch.at_ns < first => state[node] * (next_ohm + state[R_O]),
                _ => first,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Through;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn progress_at_the_crossing_is_g_and_derivatives_are_slopes(
            state in (100.0..2000.0f64, 1.05..2.0f64, 10.0..100.0f64, 0.0..20_000.0f64)
                .prop_map(|(g, factor, r_o, d)| [g, g * factor, r_o, d, 0.3 * d - 1000.0, 1e-4, 2e-4]),
            first_ohm in 10.0..1e5f64,
            next_ohm in 100.0..20_000.0f64,
            fraction in prop::option::of(0.01..0.95f64),
            gap in 0.0..1000.0f64,
            node in 0usize..2,
        ) {
            let at_ns = fraction.map(|fraction| fraction * state[node] * (first_ohm + state[R_O]));
            let switch = at_ns.map(|at_ns| (Switch { at_ns, on_ns: at_ns + gap, to: Through::C2 }, next_ohm));
            let route = Route { first_ohm, switch };
            let crossing = route.crossing(&state, node);
            let t = crossing.ns - d_ns(&state, node);
            let progress = match switch {
                None => t / (first_ohm + state[R_O]),
                Some((s, next)) => s.at_ns / (first_ohm + state[R_O]) + (t - s.on_ns) / (next + state[R_O]),
            };
            prop_assert!((progress / state[node] - 1.0).abs() < 1e-9);

            let slope = |of: &dyn Fn(f64) -> f64, scale: f64| (of(1e-6 * scale) - of(-1e-6 * scale)) / (2e-6 * scale);
            for index in 0..UNKNOWNS {
                let moved = |by: f64| { let mut s = state; s[index] += by; route.crossing(&s, node).ns };
                let found = slope(&moved, state[index].max(1.0));
                // The difference of two long times has their rounding.
                let rounding = 1e-15 * crossing.ns.abs() / (1e-6 * state[index].max(1.0));
                let close = (found - crossing.by_state[index]).abs() < 1e-5 * (1.0 + found.abs()) + rounding;
                prop_assert!(close, "{index}: {found} {crossing:?}");
            }
            let by_switch = slope(&|by| {
                let switch = switch.map(|(s, next)| (Switch { at_ns: s.at_ns + by, ..s }, next));
                Route { first_ohm, switch }.crossing(&state, node).ns
            }, 1e6);
            prop_assert!((by_switch - crossing.by_switch).abs() < 1e-5 * (1.0 + by_switch.abs()));
        }
    }
}
