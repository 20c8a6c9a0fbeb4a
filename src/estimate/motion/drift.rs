//! How a sensor has gone on from reading to reading, and what goes beyond that.

use super::Point;
use crate::estimate::limits::{BEYOND_NOISE, LATE_ON_ITS_WAY, MOTION_POINTS, STATED, SUDDEN};
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

/// By how much a point is above the parabola nearest to those before it, which says more than the last three where those are noisy;
/// `None` where that may be noise, or what others are beside it.
pub(super) fn above_all<'a>(points: impl Iterator<Item = &'a Point>, next: &Point) -> Option<f64> {
    let parabola = Parabola::nearest(points, next)?;
    let above = -parabola.at_next;
    (above > LATE_ON_ITS_WAY * parabola.noise.hypot(next.u)).then_some(above)
}

/// A parabola through points with noise, from the next one on.
struct Parabola {
    /// Where it is at the next one, relative to that.
    at_next: f64,
    /// 1 sigma of that; more where the points are beside the parabola by more than their noise.
    noise: f64,
}

impl Parabola {
    /// By weighted least squares; `None` of fewer than five points, or of points that are at one time.
    fn nearest<'a>(points: impl Iterator<Item = &'a Point>, next: &Point) -> Option<Parabola> {
        let mut rows = [[0.0; 3]; MOTION_POINTS];
        let count =
            points.zip(&mut rows).map(|(p, row)| *row = [p.seconds_to(next), p.z - next.z, p.u]).count();
        let rows = &rows[..count];
        let span = rows.first()?[0];
        let ([mut s0, mut s1, mut s2, mut s3, mut s4], [mut t0, mut t1, mut t2]) = ([0.0; 5], [0.0; 3]);
        for [seconds, z, u] in rows {
            let (x, weight) = (seconds / span, 1.0 / (u * u));
            let [w1, w2] = [x * weight, x * x * weight];
            (s0, s1, s2, s3, s4) = (s0 + weight, s1 + w1, s2 + w2, s3 + x * w2, s4 + x * x * w2);
            (t0, t1, t2) = (t0 + weight * z, t1 + w1 * z, t2 + w2 * z);
        }
        // The inverse of the normal equations' matrix, by cofactors.
        let [c00, c01, c02] = [s2 * s4 - s3 * s3, s2 * s3 - s1 * s4, s1 * s3 - s2 * s2];
        let [c11, c12, c22] = [s0 * s4 - s2 * s2, s1 * s2 - s0 * s3, s0 * s2 - s1 * s1];
        let det = s0 * c00 + s1 * c01 + s2 * c02;
        if count < 5 || det <= 1e-12 * s0 * s2 * s4 {
            return None;
        }
        let [a, b, c] =
            [c00 * t0 + c01 * t1 + c02 * t2, c01 * t0 + c11 * t1 + c12 * t2, c02 * t0 + c12 * t1 + c22 * t2]
                .map(|sum| sum / det);
        let beside = |[seconds, z, u]: &[f64; 3]| {
            let x = seconds / span;
            ((z - a - b * x - c * x * x) / u).powi(2)
        };
        let excess = rows.iter().map(beside).sum::<f64>() / (count - 3) as f64;
        Some(Parabola { at_next: a, noise: (c00 / det * excess.max(1.0)).sqrt() })
    }
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
