//! Readings as they came, late or not: where stamps are often late, a number is what several of them say.

use super::point::Point;
use crate::estimate::limits::{ALIKE_BY_CHANCE, BY_CHANCE, REPEATS_OF, STATED};

/// The last readings.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Recent {
    points: [Point; REPEATS_OF],
    count: usize,
}

/// What they say of one more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repeats {
    /// How many are as it is.
    pub alike: u32,
    /// By how much it is above the lowest, relative, if that is more than noise: late stamps only ever make it higher.
    pub above: f64,
}

impl Recent {
    pub(super) fn take(&mut self, point: Point) -> Repeats {
        let recent = &self.points[..self.count];
        let apart = |other: &Point| (point.z - other.z) / point.u.hypot(other.u);
        // What is known much worse is like anything.
        let is_alike = |other: &&Point| other.u <= 2.0 * point.u && apart(other).abs() <= STATED;
        let lower = recent.iter().filter(|other| point.z - other.z > STATED * point.u && !is_alike(other));
        let above = lower.map(|other| -(other.z - point.z).exp_m1()).fold(0.0, f64::max);
        let repeats = Repeats { alike: recent.iter().filter(is_alike).count() as u32, above };
        if self.count == REPEATS_OF {
            self.points.rotate_left(1);
            self.count -= 1;
        }
        self.points[self.count] = point;
        self.count += 1;
        repeats
    }
}

impl Repeats {
    /// Whether so many are alike as late stamps, of which a reading has one with the probability `late`, are not by chance.
    pub fn are_enough(&self, late: f64) -> bool {
        let needed = (BY_CHANCE.ln() / (ALIKE_BY_CHANCE * late).ln()).ceil() - 1.0;
        f64::from(self.alike) >= needed
    }
}
