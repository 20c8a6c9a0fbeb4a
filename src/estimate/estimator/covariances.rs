//! The uncertainty of everything that enters an estimate, and its propagation.

use crate::estimate::law;
use crate::estimate::mean::Basis;
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
        crossings
            + by.switch * by.switch * self.single[0]
            + self.of_offset(by)
            + self.of_common(by)
            + self.tracker.map_or(0.0, |tracker| tracker.variance(&by_state(tracker, by)))
    }

    /// What readings have of their own, and how they depend on a tracked state.
    pub fn basis(&self, by: &Gradient) -> Basis {
        let by_state = self.tracker.map(|tracker| by_state(tracker, by));
        let shared = self.tracker.zip(by_state).map_or(0.0, |(tracker, by)| tracker.variance(&by));
        let own = (self.of(by) - shared - self.of_offset(by) - self.of_common(by)).max(0.0);
        Basis { own, by_state, by_switch: None }
    }

    /// The part of an error that all switches have in common.
    fn of_common(&self, by: &Gradient) -> f64 {
        self.common.0 * (by.switch + by.offset * self.common.1).powi(2)
    }

    /// The part that a better known d would take away.
    pub fn of_offset(&self, by: &Gradient) -> f64 {
        by.offset * by.offset * self.single[1]
    }
}

/// How something depends on a tracked state.
fn by_state(tracker: &Tracker, by: &Gradient) -> law::State {
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
    by_state
}
