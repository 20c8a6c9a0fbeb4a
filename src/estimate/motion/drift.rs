//! How a sensor has gone on from reading to reading, and what goes beyond that.

use super::Point;
use crate::estimate::limits::{BEYOND_NOISE, STATED};
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

/// What is left when the greatest may have been a step; 0 for fewer than two.
pub(super) fn second_greatest(values: impl Iterator<Item = f64>) -> f64 {
    let pick = |(most, second): (f64, f64), value: f64| (most.max(value), second.max(value.min(most)));
    values.fold((0.0, 0.0), pick).1
}
