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

    /// An innovation in the direction that moves the observations by `by`, in sigma.
    pub fn along(&self, by: [f64; 2], v: [f64; 2]) -> f64 {
        let [a, b] = self.inverse.times(v);
        let information = self.inverse.of(by[0], by[1]);
        if information > 0.0 { (by[0] * a + by[1] * b) / information.sqrt() } else { 0.0 }
    }

    /// How many such observations the state is the mean of, in the direction that moves them by `by`.
    pub fn remembered(&self, by: [f64; 2]) -> f64 {
        let [a, b] = self.inverse.times(by);
        // The share of an innovation's variance, in that direction, that is the state's.
        let (all, state) = (a * by[0] + b * by[1], self.by_state.of(a, b));
        if state > 0.0 { all / state } else { f64::INFINITY }
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
