//! The linear algebra of the filter: four unknowns, two observations.
//!
//! For: gain and covariance. Must not know: what is observed.

use super::Matrix;
use crate::estimate::law::State;
use crate::estimate::noise::Covariance;

/// Kalman's gain for two observations.
pub struct Gain {
    /// By observation, for each part of the state.
    pub of: [[f64; 2]; 4],
    /// Rows of the observation times the covariance.
    hp: [State; 2],
    /// Inverse of the innovation's covariance.
    inverse: [[f64; 2]; 2],
}

impl Gain {
    /// For a state with covariance `p`, observed through `rows` with `noise`; `None` if that has no inverse.
    pub fn new(p: &Matrix, rows: &[State; 2], noise: &Covariance) -> Option<Gain> {
        let hp = [0, 1].map(|row: usize| {
            let mut product = [0.0; 4];
            for (j, slot) in product.iter_mut().enumerate() {
                *slot = (0..4).map(|i| rows[row][i] * p[i][j]).sum();
            }
            product
        });
        let dot = |a: &State, b: &State| (0..4).map(|i| a[i] * b[i]).sum::<f64>();
        let (aa, bb) = (dot(&hp[0], &rows[0]) + noise.aa, dot(&hp[1], &rows[1]) + noise.bb);
        let ab = dot(&hp[0], &rows[1]) + noise.ab;
        let determinant = aa * bb - ab * ab;
        if !(determinant > 0.0 && determinant.is_finite()) {
            return None;
        }
        let inverse = [[bb / determinant, -ab / determinant], [-ab / determinant, aa / determinant]];
        let mut of = [[0.0; 2]; 4];
        for (i, row) in of.iter_mut().enumerate() {
            for (j, slot) in row.iter_mut().enumerate() {
                *slot = hp[0][i] * inverse[0][j] + hp[1][i] * inverse[1][j];
            }
        }
        Some(Gain { of, hp, inverse })
    }

    /// The normalised square of an innovation.
    pub fn normalised(&self, v: [f64; 2]) -> f64 {
        let m = &self.inverse;
        v[0] * (m[0][0] * v[0] + m[0][1] * v[1]) + v[1] * (m[1][0] * v[0] + m[1][1] * v[1])
    }

    /// The state's covariance once the observations are taken in.
    pub fn posterior(&self, p: &Matrix) -> Matrix {
        let taken = |i: usize, j: usize| self.of[i][0] * self.hp[0][j] + self.of[i][1] * self.hp[1][j];
        // Rounding must not make it asymmetric.
        std::array::from_fn(|i| std::array::from_fn(|j| p[i][j] - (taken(i, j) + taken(j, i)) / 2.0))
    }
}
