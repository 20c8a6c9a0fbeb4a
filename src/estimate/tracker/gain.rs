//! The linear algebra of the filter: all unknowns, two observations.

use super::Matrix;
use crate::estimate::law::{State, UNKNOWNS};
use crate::estimate::noise::Covariance;

fn dot(a: &State, b: &State) -> f64 {
    (0..UNKNOWNS).map(|i| a[i] * b[i]).sum()
}

/// Kalman's gain for two observations.
pub struct Gain {
    /// By observation, for each part of the state.
    pub of: [[f64; 2]; UNKNOWNS],
    /// Rows of the observation times the covariance.
    hp: [State; 2],
    /// What the state's uncertainty makes of the innovation's covariance, all of that, and its inverse.
    pub by_state: Covariance,
    all: Covariance,
    inverse: Covariance,
}

impl Gain {
    /// For a state with covariance `p`, observed through the `rows` that are `seen` with `noise`; `None` if that has no
    /// inverse.
    pub fn new(p: &Matrix, rows: &[State; 2], noise: &Covariance, seen: [bool; 2]) -> Option<Gain> {
        let hp = [0, 1].map(|row: usize| {
            let mut product = [0.0; UNKNOWNS];
            for (j, slot) in product.iter_mut().enumerate() {
                *slot = (0..UNKNOWNS).map(|i| rows[row][i] * p[i][j]).sum();
            }
            product
        });
        let by_state =
            Covariance { aa: dot(&hp[0], &rows[0]), bb: dot(&hp[1], &rows[1]), ab: dot(&hp[0], &rows[1]) };
        let all = by_state.plus(noise);
        let inverse = all.inverse(seen)?;
        let of = std::array::from_fn(|i| inverse.times([hp[0][i], hp[1][i]]));
        Some(Gain { of, hp, by_state, all, inverse })
    }

    /// The normalised square of an innovation.
    pub fn normalised(&self, v: [f64; 2]) -> f64 {
        self.inverse.of(v[0], v[1])
    }

    /// An innovation of one observation, in sigma.
    pub fn sigmas(&self, which: usize, v: [f64; 2]) -> f64 {
        v[which] / self.all.node(which).sqrt()
    }

    /// How far an innovation says that the state is off in the direction that moves the observations by `by`, and the variance of
    /// that by all but the direction's own, which is `known`.
    pub fn along(&self, by: [f64; 2], v: [f64; 2], known: f64) -> Option<(f64, f64)> {
        let ([a, b], [p, q]) = (self.inverse.times(v), self.inverse.times(by));
        let information = by[0] * p + by[1] * q;
        let noise = (self.all.of(p, q) - self.by_state.of(p, q)) / information.powi(2);
        (information > 0.0 && noise > 0.0)
            .then(|| ((by[0] * a + by[1] * b) / information, noise.max(1.0 / information - known)))
    }

    /// By how much the observations lower v^T P v.
    pub fn lowers(&self, v: &State) -> f64 {
        self.inverse.of(dot(&self.hp[0], v), dot(&self.hp[1], v))
    }

    /// The state's covariance once the observations are taken in.
    pub fn posterior(&self, p: &Matrix) -> Matrix {
        let taken = |i: usize, j: usize| self.of[i][0] * self.hp[0][j] + self.of[i][1] * self.hp[1][j];
        // Rounding must not make it asymmetric.
        std::array::from_fn(|i| std::array::from_fn(|j| p[i][j] - (taken(i, j) + taken(j, i)) / 2.0))
    }
}
