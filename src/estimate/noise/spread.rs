//! How the crossings of one calibration resistor scatter, and which of them are no noise.

use super::{Covariance, Gate, Skew};
use crate::estimate::limits::{
    ALIKE_BY_CHANCE, BEYOND_NOISE, BY_CHANCE, COVERAGE, FAR_OF, LATE_NS, NEVER_SO_LATE, NOISE_MEMORY,
    NOISE_WARM_UP, OUTLIERS_OF_A_STEP, SHORTEST_THIRD, TOO_MANY_LATE, WEIGHT_OF_A_THIRD,
};
use crate::estimate::scatter::{MEDIAN_DEVIATION, Usual, median};
use crate::reading::Fault;

/// The spread of the crossings of one calibration resistor.
#[derive(Debug, Clone)]
pub struct Spread {
    warm_up: [[f64; 2]; NOISE_WARM_UP],
    seen: usize,
    /// Of the times: what their noise goes by.
    pub time: [f64; 2],
    /// Of the times less what was expected.
    mean: [f64; 2],
    last: [f64; 2],
    /// Whether node B was waited for in the last one.
    last_had_b: bool,
    sum: Covariance,
    /// Of A alone, and of both.
    weight: [f64; 2],
    /// Of the times less what was expected, and less their running mean.
    pub skew: [Skew; 2],
    gate: Gate,
    outliers_in_row: u32,
    /// The last so many of them were where the one before was.
    alike_in_row: u32,
    /// The share of discharges that are so far off that no gate would let them in.
    far: f64,
    /// The same before the outliers in a row, which may turn out to be a step.
    far_before: f64,
    /// The last one that was refused.
    refused: [f64; 2],
    /// Where most are, late ones or not: of noise that late stamps were taken for, none is far off.
    usual: [Usual; 2],
}

impl Spread {
    pub const NEW: Spread = Spread {
        warm_up: [[0.0; 2]; NOISE_WARM_UP],
        seen: 0,
        time: [0.0; 2],
        mean: [0.0; 2],
        last: [0.0; 2],
        last_had_b: true,
        sum: Covariance { aa: 0.0, bb: 0.0, ab: 0.0 },
        weight: [0.0; 2],
        skew: [Skew::NEW; 2],
        gate: Gate::new(BEYOND_NOISE),
        outliers_in_row: 0,
        alike_in_row: 0,
        far: 0.0,
        far_before: 0.0,
        refused: [0.0; 2],
        usual: [Usual::NONE; 2],
    };

    /// `times`: of the nodes that were waited for, which may be `all` that there are; only discharges in which they were begin it.
    pub fn add(
        &mut self,
        away: [f64; 2],
        times: [Option<f64>; 2],
        all: bool,
        quantisation: f64,
    ) -> Result<(), Fault> {
        let has_b = times[1].is_some();
        if self.seen < NOISE_WARM_UP {
            if all {
                self.warm_up[self.seen] = away;
                self.seen += 1;
                if self.seen == NOISE_WARM_UP {
                    self.begin(quantisation);
                }
            }
            return Ok(());
        }
        let sigmas = self.sigmas(away, self.mean, has_b, quantisation);
        if self.outliers_in_row == 0 {
            self.far_before = self.far;
        }
        let nodes = if all { 2 } else { 1 };
        self.tell_far((0..nodes).any(|node| is_far(away[node], &self.usual[node])));
        (0..nodes).for_each(|node| self.usual[node].add(away[node], quantisation.sqrt()));
        if !self.gate.admits(sigmas) {
            // A step is where the next ones are, too; late stamps are anywhere.
            let is_alike = self.sigmas(away, self.refused, has_b, quantisation) <= self.gate.sigma();
            self.refused = away;
            self.outliers_in_row += 1;
            self.alike_in_row = if is_alike { self.alike_in_row + 1 } else { 1 };
            let is_step = is_step(self.outliers_in_row, self.far_before)
                || is_step(self.alike_in_row, ALIKE_BY_CHANCE * self.far_before);
            if !is_step {
                return Err(Fault::LatencyOutlier);
            }
            // What a step has moved was not late; so many in a row are no late stamps either.
            let far = if self.outliers_in_row < NEVER_SO_LATE { self.far_before } else { 0.0 };
            (self.mean, self.last, self.far) = (away, away, far);
            (0..nodes).for_each(|node| self.usual[node].place = away[node]);
        }
        (self.outliers_in_row, self.alike_in_row) = (0, 0);
        self.learn(away, times);
        Ok(())
    }

    /// What comes is so much later from now on, ns.
    pub fn expect_later(&mut self, ns: [f64; 2]) {
        self.warm_up[..self.seen].iter_mut().for_each(|away| (0..2).for_each(|node| away[node] += ns[node]));
        for node in 0..2 {
            for away in [&mut self.time, &mut self.mean, &mut self.last, &mut self.refused] {
                away[node] += ns[node];
            }
            self.usual[node].place += ns[node];
        }
    }

    pub fn tell_far(&mut self, is_far: bool) {
        self.far += (f64::from(u8::from(is_far)) - self.far) / FAR_OF;
    }

    /// Once it has begun.
    pub fn late_share(&self) -> Option<f64> {
        (self.seen == NOISE_WARM_UP).then_some(self.far)
    }

    /// Differences of successive discharges; those of B, and with B, only where both have waited for it.
    fn learn(&mut self, away: [f64; 2], times: [Option<f64>; 2]) {
        let has_b = times[1].is_some();
        let step = [away[0] - self.last[0], away[1] - self.last[1]];
        self.sum.aa += step[0] * step[0];
        self.weight[0] += 1.0;
        if has_b && self.last_had_b {
            self.sum.bb += step[1] * step[1];
            self.sum.ab += step[0] * step[1];
            self.weight[1] += 1.0;
        }
        let keep = 1.0 - 1.0 / NOISE_MEMORY;
        if self.weight[0] > NOISE_MEMORY {
            self.sum.aa *= keep;
            self.weight[0] *= keep;
        }
        if self.weight[1] > NOISE_MEMORY {
            (self.sum.bb, self.sum.ab) = (keep * self.sum.bb, keep * self.sum.ab);
            self.weight[1] *= keep;
        }
        for node in 0..2 {
            let Some(time) = times[node] else { continue };
            self.skew[node].add(away[node] - self.mean[node]);
            self.mean[node] += (away[node] - self.mean[node]) / NOISE_WARM_UP as f64;
            (self.last[node], self.time[node]) = (away[node], time);
        }
        self.last_had_b = has_b;
    }

    /// From now on something else is expected, namely what comes.
    pub fn expect_what_comes(&mut self) {
        (self.mean, self.last) = ([0.0; 2], [0.0; 2]);
        self.usual.iter_mut().for_each(|usual| usual.place = 0.0);
    }

    /// After the warm-up: differences that are outliers by the median of their absolute values are left out.
    fn begin(&mut self, quantisation: f64) {
        self.usual = [0, 1].map(|node| Usual::of(&mut self.warm_up.map(|pair| pair[node])));
        // Less than a count does not show.
        let resolution_ns = (12.0 * quantisation).sqrt();
        let mut limit = [0.0; 2];
        for (node, limit) in limit.iter_mut().enumerate() {
            let mut steps = [0.0; NOISE_WARM_UP - 1];
            for (step, pair) in steps.iter_mut().zip(self.warm_up.windows(2)) {
                *step = (pair[1][node] - pair[0][node]).abs();
            }
            *limit = BEYOND_NOISE * (median(&mut steps) / MEDIAN_DEVIATION).max(1.0);
        }
        // Where many have a late stamp steps tell nothing, but the shortest interval of a third of them does.
        let thirds = [0, 1].map(|node| shortest_third(&mut self.warm_up.map(|pair| pair[node])));
        let (too_many, away) = TOO_MANY_LATE;
        let late = [0, 1].map(|node| {
            let (middle, sigma) = thirds[node];
            let beyond = (away * sigma.max(resolution_ns)).max(LATE_NS);
            self.warm_up.iter().filter(|pair| (pair[node] - middle).abs() > beyond).count()
        });
        let late = late[0].max(late[1]);
        self.far = (late as f64 + 0.5) / (NOISE_WARM_UP as f64 + 1.0);
        if late >= too_many {
            self.weight = [WEIGHT_OF_A_THIRD; 2];
            let [a, b] = thirds.map(|(_, sigma)| 2.0 * self.weight[0] * sigma * sigma);
            self.sum = Covariance { aa: a, bb: b, ab: 0.0 };
            (self.mean, self.last) = (thirds.map(|third| third.0), thirds.map(|third| third.0));
            self.time = self.mean;
            return;
        }
        for pair in self.warm_up.windows(2) {
            let step = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            if step[0].abs() <= limit[0] && step[1].abs() <= limit[1] {
                self.sum.add_outer(step);
                self.weight = self.weight.map(|weight| weight + 1.0);
            }
        }
        self.mean = self.usual.map(|usual| usual.place);
        (self.last, self.time) = (self.mean, self.mean);
    }

    /// How far the farther node is from the running mean, or another place.
    fn sigmas(&self, away: [f64; 2], from: [f64; 2], has_b: bool, quantisation: f64) -> f64 {
        let variance = self.covariance().at_least([quantisation; 2]);
        // The running mean has a variance of its own: 1/(2 x 16 - 1) of a single time's.
        let of = |node: usize| (away[node] - from[node]).abs() / (1.04 * variance.node(node)).sqrt();
        if has_b { of(0).max(of(1)) } else { of(0) }
    }

    /// Half the mean square of successive differences, which has two degrees of freedom for three of them. With few of
    /// them, as much more as makes 2 sigma the 95 % limit of Student's distribution (to 2 % from 8 degrees on).
    pub fn covariance(&self) -> Covariance {
        let [a, b] =
            [0, 1].map(|node| 0.5 * (1.0 + 1.3 / self.freedom(node)).powi(2) / self.weight[node].max(1.0));
        Covariance { aa: a * self.sum.aa, bb: b * self.sum.bb, ab: b * self.sum.ab }
    }

    /// No variance of noise is more by how far most of all values are from their middle, those included that were not let in; none is
    /// below `least`.
    pub fn usual_variance(&self, least: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|node| (COVERAGE * self.usual[node].sigma()).powi(2).max(least[node]))
    }

    pub fn is_known(&self) -> bool {
        self.seen == NOISE_WARM_UP
    }

    pub fn freedom(&self, node: usize) -> f64 {
        (self.weight[node] * 2.0 / 3.0).max(1.0)
    }
}

/// Whether so many outliers in a row are no late stamps, of which there is this share, but a step.
pub fn is_step(in_row: u32, late_share: f64) -> bool {
    in_row >= NEVER_SO_LATE
        || in_row >= OUTLIERS_OF_A_STEP && late_share.powf(in_row.into()) < 10.0 * BY_CHANCE
}

/// Whether a value is so far from where most are that no gate would let it in.
fn is_far(away: f64, usual: &Usual) -> bool {
    (away - usual.place).abs() > (BEYOND_NOISE * usual.sigma()).max(LATE_NS)
}

/// The middle of the shortest interval that has a third of the values, and the sigma of normal ones that have it so short:
/// what lies outside of it may be anything.
fn shortest_third(values: &mut [f64]) -> (f64, f64) {
    values.sort_unstable_by(f64::total_cmp);
    let shortest = values.windows(values.len() / 3 + 1).map(|part| [part[0], part[part.len() - 1]]);
    let [low, high] = shortest.min_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0]))).unwrap_or_default();
    ((low + high) / 2.0, (high - low) / SHORTEST_THIRD)
}
