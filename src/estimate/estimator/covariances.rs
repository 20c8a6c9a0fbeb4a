//! The uncertainty of everything that enters an estimate, and its propagation.

use crate::estimate::law;
use crate::estimate::method::dual::Gradient;
use crate::estimate::noise::Covariance;
use crate::estimate::tracker::Tracker;

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
    /// Law of propagation: g^T C g for a gradient g.
    pub fn of(&self, by: &Gradient) -> f64 {
        let [c1, c2, x] = &self.crossings;
        let crossings = c1.of(by.c1[0], by.c1[1]) + c2.of(by.c2[0], by.c2[1]) + x.of(by.x[0], by.x[1]);
        let common = self.common.0 * (by.switch + by.offset * self.common.1).powi(2);
        crossings
            + by.switch * by.switch * self.single[0]
            + self.of_offset(by)
            + common
            + self.tracker.map_or(0.0, |tracker| tracked_part(tracker, by))
    }

    /// The part that a better known d would take away.
    pub fn of_offset(&self, by: &Gradient) -> f64 {
        by.offset * by.offset * self.single[1]
    }
}

/// What the uncertainty of a tracked state adds.
fn tracked_part(tracker: &Tracker, by: &Gradient) -> f64 {
    let mut by_state = law::State::default();
    by_state[law::D] = by.offset;
    // What node B is later is taken off all of its crossings.
    by_state[law::D_B] = -(by.c1[1] + by.c2[1] + by.x[1]);
    for (crossings, by) in tracker.calibration().iter().zip([by.c1, by.c2]) {
        for (crossing, by) in crossings.iter().zip(by) {
            for (sum, partial) in by_state.iter_mut().zip(crossing.by_state) {
                *sum += by * partial;
            }
        }
    }
    tracker.variance(&by_state)
}
