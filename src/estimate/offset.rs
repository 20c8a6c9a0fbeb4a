//! The latency offset d and the pins' resistance Ro, by split calibration.
//!
//! One round is three discharges: R_1 in full, R_2 in full, and a split one that runs through R_1 for the time s and
//! then through R_2 for the time c until a node crosses. The progress g of a node is the same in all of them, and d
//! cancels in D = T_c2 - c (both are crossings), so
//!
//! ```text
//! s/(R_1+Ro) = D/(R_2+Ro)          =>  Ro = (s R_2 - D R_1)/(D - s)
//! g = (T_c2 - T_c1)/(R_2-R_1)
//! d = T_c1 - g (R_1+Ro)
//! ```
//!
//! The switch comes before either node has crossed, so both nodes tell D and d; they are weighted by the noise of their
//! crossings. The rounds are averaged; their scatter gives the uncertainties (GUM type A). Rounds that a latency spike has
//! spoilt are left out. What the scatter does not show is an error of s that is the same each time: the line that starts
//! the discharge is sunk, the one that ends s is released ([`UNLIKE_CALLS`], type B).
//!
//! Nor what the law leaves out, as a dielectric that lags behind in R_1 and gives back after the switch: rounds that switch as late as
//! they can show more of it. By what these differ from the others the offset may be off, and readings as well.

use crate::estimate::limits::{
    ELSEWHERE, ELSEWHERE_AT_LEAST, ELSEWHERE_MARGIN, ELSEWHERE_SHOWS, FEWEST_ROUNDS, SPLIT_FRACTION,
    UNKNOWN_OFFSET_NS,
};
use crate::estimate::look::beyond;
use crate::estimate::noise::{Covariance, Noise};
use crate::estimate::scatter::{SwitchScatter, Usual, expected_ns, mean};
use crate::record::{Crossings, Record, UNLIKE_CALLS};

/// What the split calibration found; each uncertainty is 1 sigma.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Offset {
    /// How much later than the truth a crossing is stamped, ns.
    pub d_ns: f64,
    /// Its uncertainty, ns; 0 for a given offset.
    pub u_d_ns: f64,
    /// By how much that of node B is greater, ns.
    pub b_later_ns: f64,
    /// Output resistance of a calibration pin, ohm; `None` for a given offset.
    pub r_o_ohm: Option<(f64, f64)>,
    /// How much switches scatter.
    pub scatter: SwitchScatter,
    /// By how much d changes with an error that all switches have in common.
    pub by_switch: f64,
    /// What the law leaves out of Ro, and so of any resistance, 1 sigma, ohm.
    pub left_out_ohm: f64,
    /// It is still to be found: d and its uncertainty are what boards have.
    pub is_prior: bool,
}

impl Offset {
    /// An offset that is known from elsewhere.
    pub fn given(d_ns: f64) -> Offset {
        Offset { d_ns, ..Offset::default() }
    }

    /// One that is still to be found.
    pub fn unknown() -> Offset {
        Offset { u_d_ns: UNKNOWN_OFFSET_NS, is_prior: true, ..Offset::default() }
    }

    /// Ro, ohm.
    pub fn r_o(&self) -> Option<f64> {
        self.r_o_ohm.map(|(r_o_ohm, _)| r_o_ohm)
    }

    /// The variance of d but for the error that all switches have in common, ns²; `u_common_ns`: the uncertainty of that.
    pub fn own_variance(&self, u_common_ns: f64) -> f64 {
        (self.u_d_ns.powi(2) - (self.by_switch * u_common_ns).powi(2)).max(0.0)
    }
}

#[derive(Debug, Clone, Copy)]
struct Round {
    d_ns: f64,
    r_o_ohm: f64,
    s_ns: f64,
    difference_ns: f64,
    /// The progress g, weighted as D was, ns/ohm.
    g: f64,
    /// It switched as late as it could.
    is_late: bool,
    u_switch_ns: f64,
    /// Of D, as far as it is due to its crossings, ns²; `None` while the noise is not known.
    variance: Option<f64>,
}

/// Where most values are: a spike is elsewhere.
fn usual_of(scratch: &mut Vec<f64>, values: impl Iterator<Item = f64>) -> Usual {
    scratch.clear();
    scratch.extend(values);
    Usual::of(scratch)
}

/// How late a split discharge can switch before node A crosses at `first_ns`, ns after its start; `None` where noise leaves it little
/// later than the others.
pub fn latest_ns(first_ns: f64, noise: &Noise) -> Option<f64> {
    let jitter_ns = noise.covariance([Some(first_ns); 2])?.aa.sqrt();
    let latest_ns = (ELSEWHERE * first_ns).min(first_ns - ELSEWHERE_MARGIN * jitter_ns);
    (latest_ns > ELSEWHERE_AT_LEAST * first_ns).then_some(latest_ns)
}

/// Whether one switched so late.
pub fn is_late(at_ns: f64, first_ns: f64) -> bool {
    at_ns >= f64::midpoint(SPLIT_FRACTION, ELSEWHERE_AT_LEAST) * first_ns
}

/// Collects rounds of a split calibration, the last ones up to a number.
#[derive(Debug, Clone, Default)]
pub struct SplitCalibration {
    r1_ohm: f64,
    r2_ohm: f64,
    nodes: usize,
    rounds: Vec<Round>,
    /// How many rounds have been taken, and how many came to nothing.
    taken: usize,
    failed: usize,
    /// For sorting: allocated once.
    scratch: Vec<f64>,
}

impl SplitCalibration {
    /// For calibration resistors `r1_ohm` < `r2_ohm` and a circuit with one or two nodes; remembers `window` rounds.
    pub fn new(r1_ohm: f64, r2_ohm: f64, nodes: usize, window: usize) -> SplitCalibration {
        let (rounds, scratch) = (Vec::with_capacity(window), Vec::with_capacity(window));
        SplitCalibration { r1_ohm, r2_ohm, nodes, rounds, taken: 0, failed: 0, scratch }
    }

    /// Forgets every round; the memory stays.
    pub fn clear(&mut self) {
        self.rounds.clear();
        self.scratch.clear();
        (self.taken, self.failed) = (0, 0);
    }

    /// How many rounds have been taken.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// How many have been, those that came to nothing included.
    pub fn tried(&self) -> usize {
        self.taken + self.failed
    }

    /// Whether the next round is to switch as late as it can: every second one.
    pub fn is_next_late(&self) -> bool {
        self.tried() % 2 == 1
    }

    /// Takes one round: crossings of the plain discharges and the record of the split one. A round whose split
    /// discharge was not switched in time, or that does not fit the law, tells nothing and is passed over.
    pub fn add(&mut self, c1: Crossings, c2: Crossings, split: &Record, noise: &Noise) {
        let Some(round) = self.round(c1, c2, split, noise) else {
            self.failed += 1;
            return;
        };
        if self.rounds.len() < self.rounds.capacity() {
            self.rounds.push(round);
        } else {
            let oldest = self.taken % self.rounds.len();
            self.rounds[oldest] = round;
        }
        self.taken += 1;
    }

    fn round(&self, c1: Crossings, c2: Crossings, split: &Record, noise: &Noise) -> Option<Round> {
        let switch = split.switch?;
        let ends = split.complete(self.nodes)?;
        let covariance = noise.covariance(c2);
        // Alike while the noise is not known.
        let alike = Covariance { aa: 1.0, bb: 1.0, ab: 0.0 };
        let weights = covariance.unwrap_or(alike).weights(self.nodes);
        // Of each node, the crossings through R_1, R_2 and both.
        let nodes = [0, 1].map(|node| Some([c1[node]?, c2[node]?, ends[node]?]));
        let nodes = || nodes.into_iter().flatten();
        let weighted = |of: &dyn Fn([f64; 3]) -> f64| {
            nodes().zip(weights).map(|(node, weight)| weight * of(node)).sum::<f64>()
        };
        let (s, (r1, r2)) = (switch.at_ns, (self.r1_ohm, self.r2_ohm));
        let difference_ns = weighted(&|[_, c2, end]| c2 - (end - switch.on_ns));
        if s <= 0.0 || difference_ns <= s || nodes().any(|[_, _, end]| end <= switch.on_ns) {
            return None;
        }
        let r_o_ohm = (s * r2 - difference_ns * r1) / (difference_ns - s);
        let g = weighted(&|[c1, c2, _]| (c2 - c1) / (r2 - r1));
        let d_ns = weighted(&|[c1, ..]| c1) - g * (r1 + r_o_ohm);
        // Two crossings through R_2 are in D: the plain discharge's and the split one's.
        let variance = covariance.map(|covariance| 2.0 * covariance.of(weights[0], weights[1]));
        let sound = d_ns.is_finite() && r_o_ohm.is_finite();
        let u_switch_ns = expected_ns(split);
        let is_late = is_late(s, c1[0]? - d_ns);
        sound.then_some(Round { d_ns, r_o_ohm, s_ns: s, difference_ns, g, is_late, u_switch_ns, variance })
    }

    /// What the law leaves out of Ro, 1 sigma, ohm: by how much late rounds differ from others, as far as that is certain: the real
    /// kernel stamps kinds of discharge unlike each other by some of their noise. As much is in d, but there it hides behind the
    /// jitter of the crossing through R_1.
    fn left_out_ohm<'a>(rounds: impl Iterator<Item = &'a Round> + Clone) -> f64 {
        let of = |late: bool| {
            let rounds = rounds.clone().filter(move |round| round.is_late == late);
            let enough = rounds.clone().nth(FEWEST_ROUNDS - 1).is_some();
            mean(rounds.map(|round| round.r_o_ohm))
                .filter(|_| enough)
                .and_then(|r_o| Some((r_o.value, r_o.u?)))
        };
        let (Some((late, u_late)), Some((usual, u_usual))) = (of(true), of(false)) else { return 0.0 };
        beyond(late - usual, ELSEWHERE_SHOWS * u_late.hypot(u_usual))
    }

    /// The result so far; `None` for fewer than four rounds.
    ///
    /// The scatter of switch instants is what remains of the scatter of D, given s, when the noise of its crossings is
    /// taken away, and as much more as that cannot tell.
    pub fn result(&mut self) -> Option<Offset> {
        if self.rounds.len() < FEWEST_ROUNDS {
            return None;
        }
        // What is usual in d alone may be far off in Ro, as rounds beside a capacitor that is missing are.
        let usual_d = usual_of(&mut self.scratch, self.rounds.iter().map(|round| round.d_ns));
        let usual_r_o = usual_of(&mut self.scratch, self.rounds.iter().map(|round| round.r_o_ohm));
        let is_usual = |round: &&Round| usual_d.has(round.d_ns) && usual_r_o.has(round.r_o_ohm);
        let kept = self.rounds.iter().filter(is_usual);
        let mean_of =
            |of: fn(&Round) -> f64| mean(kept.clone().map(of)).and_then(|mean| Some((mean.value, mean.u?)));
        let (d, r_o) = (mean_of(|round| round.d_ns)?, mean_of(|round| round.r_o_ohm)?);
        let (s, difference_ns) = (mean_of(|round| round.s_ns)?.0, mean_of(|round| round.difference_ns)?.0);
        let r_o_by_switch = difference_ns * (self.r2_ohm - self.r1_ohm) / (difference_ns - s).powi(2);
        let g = mean_of(|round| round.g)?.0;
        let by_switch = -g * r_o_by_switch;
        let u_common_ns = UNLIKE_CALLS * mean_of(|round| round.u_switch_ns)?.0;

        let left_out_ohm = Self::left_out_ohm(kept.clone());
        let slope = (self.r2_ohm + r_o.0) / (self.r1_ohm + r_o.0);
        let late_ns = |round: &Round| (round.difference_ns - slope * round.s_ns) / slope;
        let usual = usual_of(&mut self.scratch, kept.clone().map(late_ns));
        let mut scatter = SwitchScatter::default();
        for round in kept.filter(|round| usual.has(late_ns(round))) {
            if let Some(variance) = round.variance {
                scatter.add(late_ns(round) - usual.place, variance / (slope * slope), round.u_switch_ns);
            }
        }
        Some(Offset {
            d_ns: d.0,
            u_d_ns: d.1.hypot(by_switch * u_common_ns).hypot(g * left_out_ohm),
            r_o_ohm: Some((r_o.0, r_o.1.hypot(r_o_by_switch * u_common_ns).hypot(left_out_ohm))),
            left_out_ohm,
            scatter,
            by_switch,
            ..Offset::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Switch, Through};
    use crate::units::Nanos;

    /// By many rounds on a board whose late rounds end so much later than the law says; stamps jitter by a tenth of a microsecond.
    fn found(later_ns: f64) -> Offset {
        let (r, r_o, per_ohm, d) = ([470.0, 12_700.0], 40.0, 2_000.0, 8_000.0);
        let plain = |r: f64| [Some(per_ohm * (r + r_o) + d), None];
        let (noise, first_ns) = (Noise::new(1, 1.0), per_ohm * (r[0] + r_o));
        let mut split = SplitCalibration::new(r[0], r[1], 1, 256);
        for round in 0..256 {
            let late = split.is_next_late();
            let at_ns = if late { ELSEWHERE } else { SPLIT_FRACTION } * first_ns;
            let rest_ns = (first_ns - at_ns) * (r[1] + r_o) / (r[0] + r_o);
            let jitter_ns = if round / 2 % 2 == 0 { 100.0 } else { -100.0 };
            let end_ns = at_ns + rest_ns + d + jitter_ns + if late { later_ns } else { 0.0 };
            let record = Record {
                through: Through::C1,
                start: Nanos::ZERO,
                second_ns: None,
                switch: Some(Switch { at_ns, on_ns: at_ns, to: Through::C2 }),
                a_ns: Some(end_ns),
                b_ns: None,
                u_switch_ns: Some(0.0),
                waited_ns: None,
                later_ns: None,
            };
            split.add(plain(r[0]), plain(r[1]), &record, &noise);
        }
        split.result().unwrap()
    }

    #[test]
    fn what_late_rounds_show_is_in_the_uncertainty() {
        let law = found(0.0);
        assert!((law.d_ns - 8_000.0).abs() < 1.0 && law.u_d_ns < 1.0, "{law:?}");
        let left_out = found(20_000.0);
        let error_ns = (left_out.d_ns - 8_000.0).abs();
        assert!(error_ns > 100.0 && (error_ns..4.0 * error_ns).contains(&left_out.u_d_ns), "{left_out:?}");
    }
}
