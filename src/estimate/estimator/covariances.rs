//! The uncertainty of everything that enters an estimate.
//!
//! For: the law of propagation of uncertainty. Must not know: the equations.

use crate::estimate::law;
use crate::estimate::noise::Covariance;
use crate::estimate::tracker::{Tracker, quadratic};

/// The covariance matrix of all [`Times`](crate::estimate::method::Times), block by block.
pub(super) struct Covariances<'a> {
    /// Of the crossings through R_1, R_2 and the sensor.
    pub crossings: [Covariance; 3],
    /// Variances of the instant of the switch and of `d`.
    pub single: [f64; 2],
    /// The variance of an error that all switches have in common, and by how much it changes `d`.
    pub common: (f64, f64),
    /// Where the crossings through R_1 and R_2, and d, come from instead.
    pub tracker: Option<&'a Tracker>,
}

impl Covariances<'_> {
    /// Law of propagation: g^T C g for a gradient in the order of [`Times::to_array`](crate::estimate::method::Times::to_array).
    pub fn of(&self, by: &[f64; 9]) -> f64 {
        let crossings =
            self.crossings.iter().enumerate().map(|(i, block)| block.of(by[2 * i], by[2 * i + 1]));
        // When R_2 comes in hardly matters beside when the sensor goes.
        let single = by[6] * by[6] * self.single[0] + by[8] * by[8] * self.single[1];
        let common = self.common.0 * (by[6] + by[8] * self.common.1).powi(2);
        crossings.sum::<f64>()
            + single
            + common
            + self.tracker.map_or(0.0, |tracker| tracked_part(tracker, by))
    }

    /// The part that a better known d would take away.
    pub fn of_offset(&self, by: &[f64; 9]) -> f64 {
        by[8] * by[8] * self.single[1]
    }
}

/// What the uncertainty of a tracked state adds.
fn tracked_part(tracker: &Tracker, by: &[f64; 9]) -> f64 {
    let mut by_state = [0.0; 4];
    by_state[law::D] = by[8];
    for (index, crossing) in tracker.calibration().iter().flatten().enumerate() {
        for (sum, partial) in by_state.iter_mut().zip(crossing.by_state) {
            *sum += by[index] * partial;
        }
    }
    quadratic(tracker.covariance(), &by_state)
}
