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

#[cfg(test)]
mod tests {
    use super::*;

    const U: f64 = 1e-3;

    /// What the readings before say of the last one, each `(ln R, 1 sigma)`.
    fn of_the_last(readings: &[(f64, f64)]) -> Repeats {
        let mut recent = Recent::default();
        readings.iter().map(|&(z, u)| recent.take(Point { z, u, ..Point::default() })).last().unwrap()
    }

    #[test]
    fn what_is_alike_is_near_and_known_as_well() {
        let repeats = of_the_last(&[(7.0, U), (7.0 + 2.0 * U, 2.0 * U), (7.0, 3.0 * U), (7.1, U), (7.0, U)]);
        assert_eq!(repeats, Repeats { alike: 2, above: 0.0 });
    }

    #[test]
    fn what_is_above_is_relative_to_the_reading() {
        let twice = of_the_last(&[(7.0, U), (8.0, U), (7.0 + 2f64.ln(), U)]);
        assert_eq!(twice.alike, 0);
        assert!((twice.above - 0.5).abs() < 1e-12, "{twice:?}");
        // One that only noise has put above is not.
        assert_eq!(of_the_last(&[(7.0, U), (7.0 + 2.0 * U, U)]).above, 0.0);
    }

    #[test]
    fn what_is_long_past_says_nothing() {
        let mut readings = vec![(7.0, U)];
        readings.extend([(8.0, U); REPEATS_OF]);
        assert_eq!(of_the_last(&[&readings[..], &[(7.0, U)]].concat()).alike, 0);
        assert_eq!(of_the_last(&readings), Repeats { alike: REPEATS_OF as u32 - 1, above: 1.0 - (-1f64).exp() });
    }

    #[test]
    fn the_more_often_stamps_are_late_the_more_have_to_be_alike() {
        let needed = |late| (0..).find(|&alike| Repeats { alike, above: 0.0 }.are_enough(late)).unwrap();
        assert_eq!([0.03, 0.1, 0.2, 0.3, 0.5].map(needed), [2, 3, 4, 4, 5]);
        assert!(needed(1.0) < REPEATS_OF as u32);
    }
}
