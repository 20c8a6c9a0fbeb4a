//! How a sensor has gone on from reading to reading, and what goes beyond that.

use super::Point;
use crate::estimate::limits::{BEYOND_NOISE, MOTION_POINTS, STATED, SUDDEN};
use crate::units::Nanos;

/// How fast it went in both halves of what is remembered, in one direction and as far as that is more than noise: no single change,
/// and no late stamp that is over, is in both.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drift {
    /// 1/s.
    pub(super) speed: f64,
    /// It is believed for half as long again as it was seen.
    until: Nanos,
}

impl Drift {
    pub(super) fn of<'a>(points: impl DoubleEndedIterator<Item = &'a Point> + Clone) -> Drift {
        let middle = points.clone().count().saturating_sub(1) / 2;
        let ends = (points.clone().next(), points.clone().nth(middle), points.clone().next_back());
        let (Some(first), Some(middle), Some(last)) = ends else {
            return Drift { speed: 0.0, until: Nanos::ZERO };
        };
        let [before, after] = [(first, middle), (middle, last)].map(|(from, to)| {
            let speed = from.speed_to(to);
            (speed.abs() - to.u.hypot(from.u) / from.seconds_to(to)).max(0.0).copysign(speed)
        });
        let is_one_way = before.signum() == after.signum();
        let most = if is_one_way { 2.0 * before.abs().min(after.abs()) } else { 0.0 };
        let until = last.at + Nanos((last.at - first.at).0 / 2);
        Drift { speed: first.speed_to(last).clamp(-most, most), until }
    }

    /// By how much it went from here to there beside it.
    pub(super) fn step(&self, from: &Point, to: &Point) -> f64 {
        to.z - from.z - self.speed * (to.at.min(self.until) - from.at).as_seconds()
    }

    /// How fast it went from point to point beside it, as far as that is more than noise, 1/s. The way back of what has been gone
    /// at once is none: a late stamp that is over is one change, not two.
    pub(super) fn speeds_beside<'a>(
        self,
        points: impl Iterator<Item = &'a Point> + Clone,
    ) -> impl Iterator<Item = f64> {
        let mut gone = None;
        points.clone().zip(points.skip(1)).map(move |(point, next)| {
            let (step, noise) = (self.step(point, next), point.u.hypot(next.u));
            let is_back = gone.take().is_some_and(|gone: f64| (gone + step).abs() <= BEYOND_NOISE * noise);
            let beyond = if is_back { 0.0 } else { (step.abs() - STATED * noise).max(0.0) };
            gone = (beyond > 0.0).then_some(step);
            beyond / point.seconds_to(next)
        })
    }
}

/// The greatest change of the speed from point to point, 1/s²; `None` of fewer than three.
pub(super) fn bend<'a>(points: impl Iterator<Item = &'a Point> + Clone) -> Option<f64> {
    let (first, second, third) = (points.clone(), points.clone().skip(1), points.skip(2));
    let bends = first.zip(second).zip(third).map(|((first, second), third)| {
        2.0 * (second.speed_to(third) - first.speed_to(second)).abs() / first.seconds_to(third)
    });
    bends.reduce(f64::max)
}

/// By how much a point is above the parabola that the last three went; `None` where that may be noise, or others were beside
/// theirs nearly as much, or too few are known to compare with.
pub(super) fn above_its_way<'a>(points: impl Iterator<Item = &'a Point>, next: &'a Point) -> Option<f64> {
    let mut way = [next; MOTION_POINTS + 1];
    let count = points.zip(&mut way).map(|(point, place)| *place = point).count();
    let mut besides = way[..=count].windows(4).map(Beside::of).rev();
    let (now, before) = (besides.next()?, besides);
    let others = before.len();
    let most = SUDDEN * second_greatest(before.map(Beside::bend_changes)) * now.seconds3;
    (others >= 2 && now.by > most + BEYOND_NOISE * now.noise).then_some(now.by)
}

/// By how much the last of four points is beside the parabola through the others.
struct Beside {
    by: f64,
    /// 1 sigma of it.
    noise: f64,
    /// What a steady change of the bend, 1/s³, makes of it is so many times that.
    seconds3: f64,
}

impl Beside {
    /// By Lagrange's polynomials.
    fn of(four: &[&Point]) -> Beside {
        let (next, before) = (four[3], &four[..3]);
        let (mut way, mut square, mut seconds3) = (0.0, next.u * next.u, 1.0);
        for (index, point) in before.iter().enumerate() {
            let others = before.iter().enumerate().filter(|(other, _)| *other != index);
            let weight = others.fold(1.0, |weight, (other, at)| {
                let apart = if other < index { at.seconds_to(point) } else { -point.seconds_to(at) };
                weight * at.seconds_to(next) / apart
            });
            way += weight * point.z;
            square += (weight * point.u).powi(2);
            seconds3 *= point.seconds_to(next);
        }
        Beside { by: next.z - way, noise: square.sqrt(), seconds3 }
    }

    /// By how much the bend changed, as far as that is more than noise, 1/s³.
    fn bend_changes(self) -> f64 {
        (self.by.abs() - STATED * self.noise).max(0.0) / self.seconds3
    }
}

/// What is left when the greatest may have been a step; 0 for fewer than two.
pub(super) fn second_greatest(values: impl Iterator<Item = f64>) -> f64 {
    let pick = |(most, second): (f64, f64), value: f64| (most.max(value), second.max(value.min(most)));
    values.fold((0.0, 0.0), pick).1
}
