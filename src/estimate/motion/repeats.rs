//! Readings as they came, late or not: where stamps are often late, a number is what several of them say.

use super::point::{self, Point};
use crate::estimate::limits::{
    ALIKE_BY_CHANCE, BY_CHANCE, MUCH_BETTER, OFTEN_LATE, REPEATS_OF, SELDOM_LATE, STATED,
};
use std::f64::consts::FRAC_PI_2;

/// The last readings.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Recent {
    points: [Point; REPEATS_OF],
    count: usize,
}

impl Recent {
    /// All of them, as they are kept.
    pub(super) fn points(&mut self) -> &mut [Point] {
        &mut self.points[..self.count]
    }

    /// What of one more reading may be a late stamp, 1 sigma, relative. `late`: the share of readings that have one;
    /// `is_confirmed`: its own second crossing says the same. `None` where so many have one that only others like it would make
    /// it a number.
    pub(super) fn late_by(&mut self, point: &Point, late: f64, is_confirmed: bool) -> Option<f64> {
        let by = if late <= SELDOM_LATE { Some(0.0) } else { self.compare(point, late, is_confirmed) };
        point::push(&mut self.points, &mut self.count, *point);
        by
    }

    fn compare(&self, point: &Point, late: f64, is_confirmed: bool) -> Option<f64> {
        let recent = &self.points[..self.count];
        // A sensor that has been lower since has changed, or those before were late: they prove nothing.
        let since = recent.iter().rposition(|other| is_above(point, other)).map_or(0, |lower| lower + 1);
        let (mut alike, mut count) = ([0.0; REPEATS_OF], 0);
        for other in recent[since..].iter().filter(|other| is_alike(point, other)) {
            alike[count] = other.z;
            count += 1;
        }
        // That a second crossing is as late, and agrees, is as rare as that another reading does.
        if is_proven(count + usize::from(is_confirmed), late) {
            return Some(above_middle(point, &mut alike[..count], late));
        }
        let may_be_above = |other: &&Point| !is_alike(point, other) && point.z - other.z > STATED * point.u;
        let lowest = recent.iter().filter(may_be_above).map(|other| other.z).fold(point.z, f64::min);
        (late <= OFTEN_LATE).then(|| point::late_by(point.z - lowest))
    }
}

/// Whether two say the same, and the other knows it as well: one that is known much worse is like anything.
fn is_alike(point: &Point, other: &Point) -> bool {
    other.u <= MUCH_BETTER * point.u && !is_above(point, other) && !is_above(other, point)
}

/// Whether one is above another by more than noise.
fn is_above(point: &Point, other: &Point) -> bool {
    point.z - other.z > STATED * point.u.hypot(other.u)
}

/// Whether late stamps are not as late as so many others by chance.
fn is_proven(alike: usize, late: f64) -> bool {
    let needed = (BY_CHANCE.ln() / (ALIKE_BY_CHANCE * late).ln()).ceil() - 1.0;
    alike as f64 >= needed
}

/// By how much one is above the middle of those that are alike and not late, relative, if that is late sooner than noise.
fn above_middle(point: &Point, alike: &mut [f64], late: f64) -> f64 {
    alike.sort_unstable_by(f64::total_cmp);
    let in_time = alike.len() as f64 * (1.0 - late);
    let above = alike.get((in_time / 2.0) as usize).map_or(0.0, |middle| point.z - middle);
    // With few late stamps it is noise, as with hardly fewer.
    if above > sigmas_exceeded(late - SELDOM_LATE) * point.u { above } else { 0.0 }
}

/// How many sigma normal noise exceeds with this probability, within 2 % of one (G. Pólya, 1945).
fn sigmas_exceeded(probability: f64) -> f64 {
    if probability < 0.5 { (-FRAC_PI_2 * (4.0 * probability * (1.0 - probability)).ln()).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const U: f64 = 1e-3;
    const AT_REST: [(f64, f64); 6] = [(7.0, U); 6];

    /// What of the last one may be late, each `(ln R, 1 sigma)`.
    fn of_the_last(readings: &[(f64, f64)], late: f64) -> Option<f64> {
        let mut recent = Recent::default();
        let mut take =
            |&(z, u): &(f64, f64)| recent.late_by(&Point { z, u, ..Point::default() }, late, false);
        readings.iter().map(&mut take).last().unwrap()
    }

    fn after(readings: &[(f64, f64)], last: f64, late: f64) -> Option<f64> {
        of_the_last(&[readings, &[(last, U)]].concat(), late)
    }

    #[test]
    fn where_few_are_late_nothing_is() {
        assert_eq!([7.0, 8.0].map(|z| after(&AT_REST, z, SELDOM_LATE)), [Some(0.0); 2]);
    }

    #[test]
    fn what_several_say_is_a_number_and_what_one_says_alone_is_not() {
        for late in [0.1, 0.3, 0.5] {
            assert_eq!(after(&AT_REST, 7.0, late), Some(0.0));
            assert_eq!(after(&AT_REST[..1], 7.0, late).is_some(), late <= OFTEN_LATE);
        }
        // Twice as much may be half of it.
        let twice = after(&AT_REST, 7.0 + 2f64.ln(), 0.1).unwrap();
        assert!((twice - 0.5 / 3f64.sqrt()).abs() < 1e-12, "{twice}");
        assert_eq!(after(&AT_REST, 7.0 + 2f64.ln(), 0.3), None);
        // Late stamps only ever make a reading higher.
        assert_eq!(after(&AT_REST, 6.0, 0.1), Some(0.0));
    }

    #[test]
    fn what_is_known_much_worse_is_like_nothing() {
        assert_eq!(after(&[(7.0, 3.0 * U); 6], 7.0, 0.3), None);
        assert_eq!(after(&[(7.0, 2.0 * U); 6], 7.0, 0.3), Some(0.0));
    }

    #[test]
    fn what_is_above_those_like_it_by_more_than_noise_may_be_late() {
        let above = |sigma: f64, late| after(&AT_REST, 7.0 + sigma * U, late).unwrap() / U;
        assert_eq!([above(1.3, 0.1), above(-2.0, 0.1), above(0.5, 0.3)], [0.0; 3]);
        assert!((above(1.6, 0.1) - 1.6).abs() < 1e-9 && (above(0.7, 0.3) - 0.7).abs() < 1e-9);
    }

    #[test]
    fn what_was_lower_since_is_no_proof() {
        let late = [&AT_REST[..], &[(8.0, U), (8.0, U), (7.0, U), (8.0, U)]].concat();
        assert!(after(&late, 8.0, 0.1).unwrap() > 0.3);
        // As they come after a change.
        let changed = [&AT_REST[..], &[(8.0, U); 3]].concat();
        assert_eq!(after(&changed, 8.0, 0.1), Some(0.0));
        // Late ones between do not matter.
        let beside = [&AT_REST[..4], &[(8.0, U); 4], &[(7.0, U)]].concat();
        assert_eq!(after(&beside, 7.0, 0.1), Some(0.0));
    }

    #[test]
    fn what_is_long_past_says_nothing() {
        let since = [&AT_REST[..], &[(8.0, U); REPEATS_OF - 4]].concat();
        // Four are left of six, where five are needed.
        assert_eq!(after(&since, 7.0, 0.3), None);
        assert_eq!(after(&since[..since.len() - 1], 7.0, 0.3), Some(0.0));
    }

    #[test]
    fn the_more_often_stamps_are_late_the_more_have_to_be_alike() {
        let needed = |late| (0..).find(|&alike| is_proven(alike, late)).unwrap();
        assert_eq!([0.03, 0.1, 0.2, 0.3, 0.5].map(needed), [2, 3, 4, 5, 6]);
        assert!(needed(1.0) < REPEATS_OF);
    }

    #[test]
    fn of_normal_noise_as_much_is_beyond() {
        for (probability, expected) in
            [(0.158_655, 1.0), (0.05, 1.644_854), (0.3, 0.524_401), (0.5, 0.0), (0.9, 0.0)]
        {
            let found = sigmas_exceeded(probability);
            assert!((found - expected).abs() <= 0.02 * expected, "{probability}: {found}");
        }
    }
}
