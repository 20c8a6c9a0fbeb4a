//! How noisy a crossing is, learned from the spread of the calibration discharges.
//!
//! A crossing is uncertain by a part that does not depend on the resistor (latency jitter, quantisation: eq. (4)) and
//! a part proportional to it (trigger noise: eq. (7)), hence to the time T that the discharge takes:
//!
//! ```text
//! sigma^2(T) = L^2 + (k T)^2
//! ```
//!
//! Two resistors give the unknowns: k of each node, and L of both. What the crossings of one discharge share is a covariance: the
//! instant of the start, whatever the resistor, and what a charge to another V_DD does to both in proportion to their times.
//! Variances come from successive differences, so that drift is not taken for noise.

mod gate;
mod skew;
mod spread;

use crate::estimate::limits::{
    LATE_NS, OFTEN_LATE, PROPORTIONAL_SHOWS, REMEMBERED, SHARED_VARIANCE, UNKNOWN_JITTER_NS, UNKNOWN_NOISE,
};
use crate::estimate::scatter;
use crate::reading::Fault;
use crate::record::CalibrationKind;
pub use gate::Gate;
use skew::Skew;
use spread::Spread;
pub use spread::is_step;

/// Covariance of the crossings of A and B in one discharge, ns².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Covariance {
    /// Variance of A.
    pub aa: f64,
    /// Variance of B.
    pub bb: f64,
    /// Covariance of A and B.
    pub ab: f64,
}

impl Covariance {
    /// The variance of p A + q B.
    pub fn of(&self, p: f64, q: f64) -> f64 {
        p * p * self.aa + q * q * self.bb + 2.0 * p * q * self.ab
    }

    /// What the first of so many `nodes` count by, 1 in sum: by inverse variance.
    pub fn weights(&self, nodes: usize) -> [f64; 2] {
        if nodes == 1 {
            return [1.0, 0.0];
        }
        let [a, b] = [1.0 / self.aa, 1.0 / self.bb];
        [a / (a + b), b / (a + b)]
    }

    /// Its inverse in the nodes that were seen; nothing in the others. `None` if it has none.
    pub fn inverse(&self, seen: [bool; 2]) -> Option<Covariance> {
        let Covariance { aa, bb, ab } = *self;
        let (determinant, adjugate) = match seen {
            [true, true] => (aa * bb - ab * ab, Covariance { aa: bb, bb: aa, ab: -ab }),
            [true, false] => (aa, Covariance { aa: 1.0, ..Covariance::default() }),
            [false, true] => (bb, Covariance { bb: 1.0, ..Covariance::default() }),
            [false, false] => return None,
        };
        (determinant > 0.0 && determinant.is_finite()).then(|| adjugate.scaled(1.0 / determinant))
    }

    /// Its product with a vector.
    pub fn times(&self, v: [f64; 2]) -> [f64; 2] {
        [self.aa * v[0] + self.ab * v[1], self.ab * v[0] + self.bb * v[1]]
    }

    /// The sum of both.
    pub fn plus(&self, other: &Covariance) -> Covariance {
        Covariance { aa: self.aa + other.aa, bb: self.bb + other.bb, ab: self.ab + other.ab }
    }

    /// The variance of a node.
    pub fn node(&self, node: usize) -> f64 {
        if node == 0 { self.aa } else { self.bb }
    }

    fn at_least(self, [a, b]: [f64; 2]) -> Covariance {
        Covariance { aa: self.aa.max(a), bb: self.bb.max(b), ab: self.ab }
    }

    /// Adds what a common cause does, which moves the crossings by `d`.
    pub fn add_outer(&mut self, d: [f64; 2]) {
        self.aa += d[0] * d[0];
        self.bb += d[1] * d[1];
        self.ab += d[0] * d[1];
    }

    /// Adds what may move the crossings by `d`, one of them or both: whatever is made of them is not moved by more (the square
    /// of a sum is no more than the sum of the squares, times how many there are).
    pub fn add_each(&mut self, d: [f64; 2]) {
        let count = d.iter().filter(|d| **d != 0.0).count() as f64;
        self.aa += count * d[0] * d[0];
        self.bb += count * d[1] * d[1];
    }

    fn scaled(&self, by: f64) -> Covariance {
        Covariance { aa: self.aa * by, bb: self.bb * by, ab: self.ab * by }
    }
}

/// Learns the noise of crossings from the two calibration discharges.
#[derive(Debug, Clone)]
pub struct Noise {
    nodes: usize,
    c1: Spread,
    c2: Spread,
    /// Of one time by the clock that counts it, eq. (4), ns².
    quantisation: f64,
    learned: Option<Learned>,
}

/// What both spreads together say about any discharge: changes with a calibration discharge, and is asked for more often.
#[derive(Debug, Clone, Copy)]
struct Learned {
    nodes: [VarianceLaw; 2],
    shared: CovarianceLaw,
    /// The greatest correlation of two crossings.
    correlated: f64,
    /// By which part of its time a crossing is early for each e-fold of that, where noise is wide-band.
    early: [f64; 2],
}

impl Noise {
    /// Nothing is known yet. One or two `nodes`; `resolution_ns`: period of the clock that stamps crossings. A spread cannot show
    /// quantisation where the noise is smaller: the same count comes each time.
    pub fn new(nodes: usize, resolution_ns: f64) -> Noise {
        let mut noise = Noise { nodes, c1: Spread::NEW, c2: Spread::NEW, quantisation: 0.0, learned: None };
        noise.set_resolution(resolution_ns);
        noise
    }

    /// The clock that stamps crossings has another period.
    pub fn set_resolution(&mut self, resolution_ns: f64) {
        self.quantisation = resolution_ns * resolution_ns / 12.0;
        self.learn();
    }

    /// Takes the crossings of a calibration discharge, ns, that of B if it was waited for; those of a split one tell nothing.
    /// `expected`: what is known to change in them; only the rest is looked at.
    ///
    /// # Errors
    /// [`Fault::LatencyOutlier`] if they are too far from the others: a spike, which has not been used.
    pub fn add(
        &mut self,
        kind: CalibrationKind,
        times: [Option<f64>; 2],
        expected: [f64; 2],
    ) -> Result<(), Fault> {
        let spread = match kind {
            CalibrationKind::First => &mut self.c1,
            CalibrationKind::Second => &mut self.c2,
            CalibrationKind::Split => return Ok(()),
        };
        let all = times[1].is_some() || self.nodes == 1;
        // A node that was not waited for is taken to be where it was expected.
        let away = [0, 1].map(|node: usize| times[node].map_or(0.0, |ns| ns - expected[node]));
        let judged = spread.add(away, times, all, self.quantisation);
        self.learn();
        judged
    }

    /// From now on, crossings of this kind come so much later, ns.
    pub fn expect_later(&mut self, kind: CalibrationKind, ns: [f64; 2]) {
        match kind {
            CalibrationKind::First => self.c1.expect_later(ns),
            CalibrationKind::Second => self.c2.expect_later(ns),
            CalibrationKind::Split => {}
        }
    }

    /// From now on, `expected` is what the crossings are on average.
    pub fn expect_what_comes(&mut self) {
        self.c1.expect_what_comes();
        self.c2.expect_what_comes();
    }

    fn learn(&mut self) {
        if !self.c1.is_known() || !self.c2.is_known() {
            return;
        }
        let least = |spread: &Spread| spread.time.map(|ns| (REMEMBERED * ns).powi(2).max(self.quantisation));
        let [least_1, least_2] = [least(&self.c1), least(&self.c2)];
        let (v1, v2) = (self.c1.covariance().at_least(least_1), self.c2.covariance().at_least(least_2));
        let usual = self.c2.usual_variance(least_2);
        let freedom = self.c1.freedom(self.nodes - 1).min(self.c2.freedom(self.nodes - 1));
        let nodes = VarianceLaw::through([(self.c1.time, v1), (self.c2.time, v2)], usual, self.quantisation);
        let early_ns = skew::early(self.c2.skew);
        self.learned = Some(Learned {
            nodes,
            early: [0, 1]
                .map(|node| if early_ns[node] > 0.0 { early_ns[node] / self.c2.time[node] } else { 0.0 }),
            shared: CovarianceLaw::through([(self.c1.time, v1), (self.c2.time, v2)], freedom),
            // Too much would make a combination of two crossings look exact: it takes many discharges to believe that.
            correlated: 1.0 - 1.0 / freedom.sqrt(),
        });
    }

    /// Takes whether a discharge of this kind was far from what was expected, where something else has judged it.
    pub fn tell_far(&mut self, kind: CalibrationKind, is_far: bool) {
        match kind {
            CalibrationKind::First => self.c1.tell_far(is_far),
            CalibrationKind::Second => self.c2.tell_far(is_far),
            CalibrationKind::Split => {}
        }
    }

    /// The share of discharges that have a late stamp, of both kinds alike.
    pub fn late_share(&self) -> f64 {
        let shares = [&self.c1, &self.c2].map(Spread::late_share);
        scatter::mean(shares.into_iter().flatten()).map_or(0.0, |mean| mean.value)
    }

    /// Whether a late stamp may look like any other: so many are late that several agree by chance, in a calibration, too, or noise
    /// is as great as what is late.
    pub fn hides_late(&self) -> bool {
        self.late_share() > OFTEN_LATE || self.jitter_ns().is_some_and(|jitter_ns| jitter_ns > LATE_NS)
    }

    /// The noise of a crossing without delay, which is that of latency, ns; `None` until known.
    pub fn jitter_ns(&self) -> Option<f64> {
        self.covariance([0.0; 2]).map(|noise| noise.aa.sqrt())
    }

    /// Whether enough discharges have been seen.
    pub fn is_known(&self) -> bool {
        self.learned.is_some()
    }

    /// What it may be of discharges whose nodes cross at `times` ns as long as nothing is known: wide for any board, ns².
    pub fn prior(times: [Option<f64>; 2]) -> Covariance {
        let variance = |ns: f64| UNKNOWN_JITTER_NS.powi(2) + (UNKNOWN_NOISE * ns).powi(2);
        let [aa, bb] = times.map(|ns| ns.map_or(0.0, variance));
        Covariance { aa, bb, ab: 0.0 }
    }

    /// The covariance of the crossings of a discharge whose nodes cross at `times` ns, nothing in those that do not; `None` until
    /// known.
    pub fn covariance(&self, times: [impl Into<Option<f64>>; 2]) -> Option<Covariance> {
        self.covariances([times.map(Into::into)]).map(|[covariance]| covariance)
    }

    /// The same for several discharges.
    pub fn covariances<const N: usize>(&self, discharges: [[Option<f64>; 2]; N]) -> Option<[Covariance; N]> {
        let Learned { nodes: [law_a, law_b], shared, correlated, .. } = self.learned?;
        Some(discharges.map(|[a_ns, b_ns]| {
            let (aa, bb) = (a_ns.map_or(0.0, |ns| law_a.at(ns)), b_ns.map_or(0.0, |ns| law_b.at(ns)));
            let most = if shared.proportional > 0.0 {
                correlated * (aa * bb).sqrt()
            } else {
                // Each crossing is stamped by an interrupt of its own.
                SHARED_VARIANCE * aa.min(bb)
            };
            let ab = a_ns.zip(b_ns).map_or(0.0, |(a_ns, b_ns)| shared.at(a_ns, b_ns).clamp(0.0, most));
            Covariance { aa, bb, ab }
        }))
    }

    /// By which part of its time a crossing of each node is early for each e-fold of that; 0 where noise does not show that it is
    /// wide-band.
    pub fn early(&self) -> [f64; 2] {
        self.learned.map_or([0.0; 2], |learned| learned.early)
    }

    /// What of the covariance of two crossings is the instant of their start, ns².
    pub fn of_start(&self, covariance: &Covariance) -> f64 {
        self.learned.map_or(0.0, |learned| learned.shared.constant.clamp(0.0, covariance.ab))
    }
}

/// Covariance of both crossings: S + s T_A T_B, ns².
#[derive(Debug, Clone, Copy)]
struct CovarianceLaw {
    constant: f64,
    proportional: f64,
}

impl CovarianceLaw {
    /// Through the covariances at two pairs of times, each known with so many degrees of freedom.
    fn through([(t1, v1), (t2, v2)]: [([f64; 2], Covariance); 2], freedom: f64) -> CovarianceLaw {
        let chance = ((v1.aa * v1.bb + v2.aa * v2.bb) / freedom).sqrt();
        if v2.ab - v1.ab > PROPORTIONAL_SHOWS * chance {
            let proportional = (v2.ab - v1.ab) / (t2[0] * t2[1] - t1[0] * t1[1]);
            let constant = (v1.ab - proportional * t1[0] * t1[1]).max(0.0);
            if proportional.is_finite() {
                return CovarianceLaw { constant, proportional };
            }
        }
        // The same through both; each tells it the better the less noise it has of its own.
        let (w1, w2) = (1.0 / (v1.aa * v1.bb), 1.0 / (v2.aa * v2.bb));
        CovarianceLaw { constant: (w1 * v1.ab + w2 * v2.ab) / (w1 + w2), proportional: 0.0 }
    }

    fn at(self, a_ns: f64, b_ns: f64) -> f64 {
        self.constant + self.proportional * a_ns * b_ns
    }
}

/// sigma²(T) = L² + k² T², ns².
#[derive(Debug, Clone, Copy)]
struct VarianceLaw {
    l2: f64,
    k2: f64,
}

impl VarianceLaw {
    /// Of both nodes, through their variances at two times. L is the same for both: one kernel stamps them. L² is at least
    /// the quantisation, k² at least zero. What of the later ones is more than `usual` says nothing of L: late stamps are in it.
    fn through(
        [(t1, v1), (t2, v2)]: [([f64; 2], Covariance); 2],
        usual: [f64; 2],
        quantisation: f64,
    ) -> [VarianceLaw; 2] {
        let (mut sum, mut weight) = (0.0, 0.0);
        for node in (0..2).filter(|node| t2[*node] > t1[*node]) {
            // What v2 says of the proportional part at t1; the rest of v1 is constant.
            let share = (t1[node] / t2[node]).powi(2);
            let later = share * v2.node(node).min(usual[node]);
            let l2 = (v1.node(node) - later) / (1.0 - share);
            // A variance is known to a constant part of itself.
            let doubt = (v1.node(node).powi(2) + later.powi(2)) / (1.0 - share).powi(2);
            sum += l2 / doubt;
            weight += 1.0 / doubt;
        }
        let l2 = if weight > 0.0 { (sum / weight).max(quantisation) } else { quantisation };
        [0, 1].map(|node| {
            let k2 = (v2.node(node) - l2).max(0.0) / (t2[node] * t2[node]);
            VarianceLaw { l2, k2: if k2.is_finite() { k2 } else { 0.0 } }
        })
    }

    fn at(self, time: f64) -> f64 {
        self.l2 + self.k2 * time * time
    }
}

#[cfg(test)]
mod tests;
