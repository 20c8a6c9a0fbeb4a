//! What flows beside the resistors of the circuit, by what discharges lose while they are held.
//!
//! Node A loses the current K v: K is the conductance of a leak to ground, and depends on v for anything else. What flows at B counts at A,
//! too, and B falls faster than that, as if it lost J more. Both are known at two places of a discharge, and between them and beyond as
//! of a conductance and a current side by side, a + b/v for K and a + b v for J.
//!
//! Must not know: discharges other than those that were held.

use super::hold;
use crate::estimate::limits::{FALLS, LEAK_HELD_AT};
use crate::record::Crossings;

/// What a calibration knows, as far as times are undone by it.
#[derive(Debug, Clone, Copy)]
pub struct Ways {
    /// R_1 and R_2 with Ro, ohm.
    pub r_ohm: [f64; 2],
    /// How long discharges through them take without leaks, ns, offset included; `None`: not known yet.
    pub ns: Option<[Crossings; 2]>,
    /// The offset, ns.
    pub d_ns: f64,
}

impl Ways {
    /// How long a discharge through R_1 or R_2 takes until a node crosses, ns, offset left out.
    pub fn whole_ns(&self, resistor: usize, node: usize) -> Option<f64> {
        self.ns.and_then(|ns| ns[resistor][node]).map(|ns| ns - self.d_ns).filter(|ns| *ns > 0.0)
    }

    /// Where a node crosses, in parts of A's way.
    pub fn end(&self, node: usize) -> Option<f64> {
        let whole_ns = |node| self.whole_ns(1, node);
        if node == 0 { Some(1.0) } else { Some(whole_ns(1)? / whole_ns(0)?) }
    }
}

/// What flows beside the resistors.
#[derive(Debug, Clone, Copy)]
pub struct Beside {
    /// What it was found from: what was lost, and how long R_2 takes, ns.
    lost: [[f64; 2]; 2],
    whole_ns: f64,
    /// K and J at two places, siemens.
    levels: [[f64; 2]; 2],
    /// In parts of A's way.
    places: [f64; 2],
}

impl Beside {
    /// From what was lost. The rest of a discharge leaks, too, and begins elsewhere after it was held: what it does by that is found by
    /// turns.
    pub fn of(lost: [[f64; 2]; 2], ways: &Ways) -> Beside {
        let mut beside = Beside { lost, whole_ns: f64::NAN, levels: lost, places: LEAK_HELD_AT };
        for _ in 0..TURNS {
            let Some(next) = beside.next(ways) else { break };
            beside = next;
        }
        beside
    }

    /// Whether it was found from the same, on a circuit that is still the same.
    pub fn is_of(&self, lost: &[[f64; 2]; 2], ways: &Ways) -> bool {
        let is_near = |now: f64| (now / self.whole_ns - 1.0).abs() < AS_LONG;
        self.lost == *lost && ways.whole_ns(1, 0).is_some_and(is_near)
    }

    /// How many times as long plain discharges through R_1 or R_2 (0, 1) would take without, until A crosses and until B does.
    pub fn times(&self, resistor: usize, ways: &Ways) -> [f64; 2] {
        [0, 1]
            .map(|node| ways.end(node).map_or(1.0, |end| self.longer(node, [0.0, end], ways.r_ohm[resistor])))
    }

    fn next(&self, ways: &Ways) -> Option<Beside> {
        let (lost, whole_ns, r_ohm) = (self.lost, ways.whole_ns(1, 0)?, ways.r_ohm[1]);
        let hold_ns = hold(whole_ns, r_ohm).as_ns();
        let mut next = Beside { whole_ns, ..*self };
        for level in 0..2 {
            let at_ns = LEAK_HELD_AT[level] * whole_ns / self.longer(0, [0.0, 1.0], r_ohm);
            let from = at_ns * self.longer(0, [0.0, LEAK_HELD_AT[level]], r_ohm) / whole_ns;
            let moved = self.levels[0][level] * hold_ns * r_ohm / whole_ns;
            // While it was held, by what is not so before and after that.
            let held = |node: usize, lost: f64| {
                let (whole_ns, end) = (ways.whole_ns(1, node)?, ways.end(node)?);
                let before_ns = at_ns * self.longer(node, [0.0, from], r_ohm);
                let rest_ns =
                    whole_ns / self.longer(node, [0.0, end], r_ohm) - at_ns - lost * hold_ns * r_ohm;
                let after_ns = rest_ns * self.longer(node, [from + moved, end], r_ohm);
                Some((whole_ns - before_ns - after_ns) / (hold_ns * r_ohm))
            };
            let (of_a, more) = (lost[0][level], lost[1][level]);
            next.levels[0][level] = held(0, of_a)?;
            next.levels[1][level] = held(1, of_a + more).map_or(0.0, |of_b| of_b - next.levels[0][level]);
            next.places[level] = from + moved / 2.0;
        }
        let is_sound = next.places[1] - next.places[0] > NEAREST
            && next.levels.as_flattened().iter().all(|k| k.is_finite());
        is_sound.then_some(next)
    }

    /// How many times as long a part of a discharge through `r_ohm` would take without.
    pub fn longer(&self, node: usize, way: [f64; 2], r_ohm: f64) -> f64 {
        let slower = |siemens: f64| 1.0 / (1.0 + siemens * r_ohm).max(SLOWEST);
        1.0 / self.mean(node, way, slower)
    }

    /// The mean of something that goes by what `node` loses (siemens), from one place of a discharge to another, in parts of A's way.
    pub fn mean(&self, node: usize, [from, to]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
        let at = |(part, weight): (f64, f64)| weight * of(self.siemens_at(node, from + part * (to - from)));
        GAUSS.map(at).iter().sum()
    }

    fn siemens_at(&self, node: usize, place: f64) -> f64 {
        let ([at_a, more_at_b], voltage) = (self.levels, |place: f64| FALLS.powf(-place));
        let [early, late] = self.places.map(voltage);
        let between = |[at_early, at_late]: [f64; 2], part: f64| at_early + (at_late - at_early) * part;
        let of_a = between(at_a, (1.0 / voltage(place) - 1.0 / early) / (1.0 / late - 1.0 / early));
        if node == 0 { of_a } else { of_a + between(more_at_b, (voltage(place) - early) / (late - early)) }
    }
}

/// Places and weights of a mean by three values, exact for polynomials of the fifth degree (Gauss and Legendre).
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
/// After so many turns what is left is less than what the law leaves out.
pub const TURNS: usize = 4;
/// Nearer places tell no difference, in parts of A's way.
const NEAREST: f64 = 0.1;
/// Of R_2 whose time differs by less the same is true.
const AS_LONG: f64 = 1e-3;
/// No discharge goes on beside something that feeds it by more.
const SLOWEST: f64 = 0.1;
