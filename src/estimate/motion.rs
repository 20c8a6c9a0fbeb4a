//! A sensor that changes while it is read: when a reading is right, by how much it is off, and what a contradiction means.
//!
//! A discharge counts progress, so each crossing tells the *mean conductance* y = 1/(R_x+Ro) over its stretch of the
//! discharge, from the start to that crossing (or to the switch, if that came first). While y changes steadily this mean
//! is y in the middle of the stretch, and a weighted sum of two of them is y at the weighted mean of the middles: the
//! instant of the reading, right to the first order. What is left is of the second order: with stretches of the lengths
//! e_i, weights w_i and z = ln(R_x+Ro), relative to R_x+Ro,
//!
//! ```text
//! error = (z'' - z'²) sum w_i (e_i²/24 + (e_i/2 - at)²/2) + z'² sum w_i (e_i/2 - at)²
//! ```
//!
//! (the last part because resistances are averaged, not conductances). z' and z'' are those of the last few readings: the
//! two stretches of one discharge give a slope each time, which no rhythm of readings can hide, and for a hand that
//! trembles about a mean the root mean squares of value, slope and bend belong together as z'' = z'²/z. Where readings follow the
//! sensor, z'' is no more than what its speed changes by from one to the next.

mod drift;
mod evidence;
mod point;
mod repeats;
mod resolved;

use crate::estimate::limits::{
    BEYOND_NOISE, COVERAGE, FAST, FOLLOWED, MOTION_POINTS, MUCH_BETTER, OPEN_LN, STATED, SUDDEN,
};
use crate::reading::Fault;
use crate::units::Nanos;
use drift::{Drift, above_all, above_its_way, bend, second_greatest};
pub use evidence::Evidence;
use evidence::Pair;
use point::{LEAST_OHM, Point, Trust};
use repeats::Recent;
use resolved::Resolved;

/// What the sensor's own change, and a stamp that may be late, add to a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// 1 sigma, ohm.
    pub u_ohm: f64,
    /// Its change is more than all else that is not known of the reading.
    pub is_moving: bool,
}

/// The last readings of a sensor.
#[derive(Debug, Clone, Copy, Default)]
pub struct Motion {
    points: [Point; MOTION_POINTS],
    count: usize,
    /// The last one changed by more than its noise can hide.
    is_fast: bool,
    recent: Recent,
    /// Ro that they go through, ohm, if it is known.
    r_o_ohm: Option<f64>,
    /// There was a last one, and it was not settling.
    was_settled: bool,
    /// The last one before a rise that one stretch alone has shown: two late stamps in a row look like it.
    before_rise: Option<Point>,
    /// Whether they are told from a short circuit.
    pub resolved: Resolved,
}

impl Motion {
    /// Takes an estimate (`r_ohm` with `u_ohm`) of a discharge that began at `start`; answers what the sensor's own change
    /// adds to its uncertainty. `r_o_ohm`: Ro, if it is known; `late`: the share of discharges with a late stamp.
    ///
    /// # Errors
    /// [`Fault::LatencyOutlier`] if it contradicts itself as by one late stamp, or if too few others are like it where many are
    /// late; [`Fault::Unsettled`] if the sensor has changed so much that the error may be as large as the value.
    pub fn judge(
        &mut self,
        start: Nanos,
        [r_ohm, u_ohm]: [f64; 2],
        r_o_ohm: Option<f64>,
        evidence: &Evidence,
        late: f64,
    ) -> Result<Moved, Fault> {
        self.goes_through(r_o_ohm);
        let all_ohm = through(r_ohm, r_o_ohm);
        // Where the value is anything, nothing can be said of how it changes, but that it was no more.
        if u_ohm >= all_ohm {
            let z = (all_ohm + COVERAGE * u_ohm).ln();
            self.push(Point { at: start, z, u: 0.0, slope: None, trust: Trust::Below });
            let at_rest = Moved { u_ohm: 0.0, is_moving: false };
            return if evidence.contradicts { Err(Fault::LatencyOutlier) } else { Ok(at_rest) };
        }
        let pair = evidence.pair.map(|pair| pair.map(|r_ohm| through(r_ohm, r_o_ohm), all_ohm));
        let mut point = Point {
            at: start + Nanos(evidence.at_ns as i64),
            z: all_ohm.ln(),
            u: u_ohm / all_ohm,
            slope: pair.and_then(Pair::slope),
            trust: Trust::Sound,
        };
        let late_by =
            self.recent.late_by(&point, late, evidence.is_confirmed()).ok_or(Fault::LatencyOutlier)?;
        let late_by = late_by.hypot(self.unseen(&point));
        let error = if evidence.contradicts && !self.explains(&point) {
            let Some(pair) = pair else { return Err(Fault::LatencyOutlier) };
            // Where the sensor was moving already, it moves still.
            self.is_fast |= !self.is_late_stamp(pair);
            point.trust = if self.is_fast { Trust::Mixed } else { Trust::Doubtful };
            let error = self.between(&point, Some(pair));
            self.push(point);
            if !self.is_fast {
                return Err(Fault::LatencyOutlier);
            }
            error
        } else {
            let error = self.follow(point, pair, evidence);
            self.is_fast = error > FAST.max(STATED * point.u);
            error
        };
        // What is late has not moved.
        let moved = Moved { u_ohm: error.hypot(late_by) * all_ohm, is_moving: error > point.u };
        let is_number = moved.u_ohm <= u_ohm || COVERAGE * moved.u_ohm < r_ohm;
        if is_number { Ok(moved) } else { Err(Fault::Unsettled) }
    }

    /// Where Ro has just become known, or is known no longer, the sensor has not changed by it; by as little as it is followed by,
    /// nobody sees.
    fn goes_through(&mut self, r_o_ohm: Option<f64>) {
        if self.r_o_ohm.is_some() != r_o_ohm.is_some() {
            let more_ohm = r_o_ohm.unwrap_or(0.0) - self.r_o_ohm.unwrap_or(0.0);
            let points = self.points[..self.count].iter_mut().chain(self.recent.points());
            points.chain(&mut self.before_rise).for_each(|point| *point = point.beyond(more_ohm));
        }
        self.r_o_ohm = r_o_ohm;
    }

    /// Takes a point that goes with those before it; answers its predicted error, 1 sigma, relative.
    fn follow(&mut self, mut point: Point, pair: Option<Pair>, evidence: &Evidence) -> f64 {
        self.settle(evidence.contradicts);
        self.forget_what_is_gone(&point);
        let late = if pair.is_some_and(Pair::is_apart) { 0.0 } else { self.late_on_its_way(&point) };
        let is_sudden = self.is_sudden(&point);
        let unproven = self.unproven(&point, pair, is_sudden || late > 0.0);
        let hidden = if is_sudden { self.hidden(&point, pair).max(late) } else { late };
        if hidden > FAST.max(STATED * point.u) {
            point.trust = Trust::Sudden;
        }
        self.push(point);
        self.error(evidence, is_sudden).hypot(hidden.max(unproven))
    }

    /// Whether a reading is settling, or the first that is not, be it the first of all: no other has yet been known well enough to
    /// tell a late stamp of it, or of its calibration, from the sensor.
    pub fn settles(&mut self, is_settling: bool) -> bool {
        !std::mem::replace(&mut self.was_settled, !is_settling) || is_settling
    }

    /// Takes a reading that is no number: a resistance above `r_min_ohm`.
    pub fn is_open(&mut self, at: Nanos, r_min_ohm: f64) {
        self.settle(false);
        self.push(Point {
            at,
            z: (2.0 * r_min_ohm.max(LEAST_OHM)).ln(),
            u: OPEN_LN,
            slope: None,
            trust: Trust::Sound,
        });
    }

    /// Forgets everything.
    pub fn forget(&mut self) {
        *self = Motion::default();
    }

    /// The last resistance, ohm; that of an unsettled reading, too.
    pub fn last_ohm(&self, r_o_ohm: Option<f64>) -> Option<f64> {
        self.points().last().map(|point| point.z.exp() - r_o_ohm.unwrap_or(0.0))
    }

    fn points(&self) -> &[Point] {
        &self.points[..self.count]
    }

    fn sound(&self) -> impl DoubleEndedIterator<Item = &Point> + Clone {
        self.points().iter().filter(|point| matches!(point.trust, Trust::Sound | Trust::Sudden))
    }

    /// Where it was last, or what it was below; a mean over its way, if there is nothing else.
    fn last(&self) -> Option<&Point> {
        let last = self.points().last();
        let below = last.filter(|point| point.trust == Trust::Below);
        below.or_else(|| self.sound().next_back()).or(last.filter(|point| point.trust == Trust::Mixed))
    }

    /// Slopes inside of discharges, each with 1 sigma.
    fn slopes(&self) -> impl Iterator<Item = [f64; 2]> + Clone {
        self.points().iter().filter(|point| point.trust != Trust::Doubtful).filter_map(|point| point.slope)
    }

    fn push(&mut self, point: Point) {
        point::push(&mut self.points, &mut self.count, point);
    }

    /// What was doubtful has been a change, or else a late stamp that says nothing.
    fn settle(&mut self, was_change: bool) {
        if was_change {
            let points = self.points[..self.count].iter_mut();
            points.filter(|point| point.trust != Trust::Below).for_each(|point| point.trust = Trust::Sound);
            return;
        }
        let mut kept = 0;
        for index in 0..self.count {
            if self.points[index].trust != Trust::Doubtful {
                self.points.swap(kept, index);
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// A sensor that has at once what it had before a sudden change never changed: had it come back in the middle of this
    /// discharge, this would be something in between.
    fn forget_what_is_gone(&mut self, point: &Point) {
        let Some(rest) = self.points().iter().rposition(|point| point.trust != Trust::Sudden) else { return };
        let before = self.points[rest];
        let is_known = before.trust == Trust::Sound && !before.is_open();
        let is_near = |other: &Point| (point.z - other.z).abs() <= BEYOND_NOISE * point.u.hypot(other.u);
        // What is near both is no return.
        let is_back = is_near(&before) && !self.points().last().is_some_and(is_near);
        if is_known && is_back {
            self.count = rest + 1;
        }
    }

    /// Speeds from reading to reading, 1/s.
    fn speeds(&self) -> impl Iterator<Item = f64> {
        self.sound().zip(self.sound().skip(1)).map(|(point, next)| point.speed_to(next))
    }

    /// Whether a slope inside of a discharge is one that the neighbours have, too.
    fn explains(&self, point: &Point) -> bool {
        let (Some([slope, _]), Some(last)) = (point.slope, self.points().last()) else { return false };
        let now = last.speed_to(point).abs();
        let speed = second_greatest(self.speeds().map(f64::abs).chain([now]));
        slope.abs() <= SUDDEN * speed.max(self.slope_scatter())
    }

    /// What the slopes of the discharges scatter by beyond their noise and without the greatest, 1/s.
    fn slope_scatter(&self) -> f64 {
        let greatest = self.slopes().map(|[slope, _]| slope.abs()).fold(0.0, f64::max);
        let slopes = || self.slopes().filter(|[slope, _]| slope.abs() < greatest);
        let count = slopes().count() as f64;
        if count < 2.0 {
            return 0.0;
        }
        let mean = slopes().map(|[slope, _]| slope).sum::<f64>() / count;
        let excess = slopes().map(|[slope, u]| (slope - mean).powi(2) - u * u).sum::<f64>() / count;
        excess.max(0.0).sqrt()
    }

    /// Whether one late stamp would do: no node is early, and they are not later and later as a rising resistance makes
    /// them.
    fn is_late_stamp(&self, pair: Pair) -> bool {
        let Some(last) = self.sound().next_back() else { return true };
        // Whatever is below what an open sensor has at least is early.
        let doubt = (BEYOND_NOISE * pair.u_ohm.hypot(last.u)).min(OPEN_LN);
        let [a, b] = pair.r_ohm;
        let is_early = a.min(b) < last.z - doubt;
        let rises = b > a && a > last.z + doubt;
        !is_early && !rises
    }

    /// Whether it has changed faster than anything before it, beside its drift: since the last point, or since one that the last
    /// went along with and that says better where the sensor was.
    fn is_sudden(&self, point: &Point) -> bool {
        let Some(last) = self.last() else { return false };
        if last.trust == Trust::Below {
            return point.z - last.z > BEYOND_NOISE * point.u;
        }
        if last.trust == Trust::Mixed {
            return (point.z - last.z).abs() > last.noise_to(point);
        }
        if last.is_open() {
            // Anywhere above its bound, and how it came below nobody has seen.
            let mut bounds = self.sound().filter(|point| point.is_open());
            return bounds.any(|bound| bound.z - point.z > OPEN_LN + BEYOND_NOISE * point.u);
        }
        let drift = Drift::of(self.sound());
        let slopes = self.slopes().map(|[slope, u]| (slope - drift.speed).abs() - STATED * u);
        let speed = second_greatest(drift.speeds_beside(self.sound())).max(second_greatest(slopes));
        let is_faster = |from: &Point, to: &Point| {
            let seconds = (to.at - from.at).as_seconds();
            drift.step(from, to).abs() > SUDDEN * speed * seconds + from.noise_to(to)
        };
        let knows_better = |from: &&Point| MUCH_BETTER * from.u < last.u && !is_faster(from, last);
        is_faster(last, point) || self.sound().filter(knows_better).any(|from| is_faster(from, point))
    }

    /// What of a point may be a late stamp while the sensor moves, relative: all that it is above its way, but of a way that three points
    /// tell no more than it is from where the drift and the last point together let it be, or nothing.
    fn late_on_its_way(&self, point: &Point) -> f64 {
        let Some(last) = self.sound().next_back() else { return 0.0 };
        let most = Drift::of(self.sound()).step(last, point).abs() + (point.z - last.z).abs();
        let above = above_its_way(self.sound(), point).map_or(0.0, |above| above.min(most));
        // One that was late, or may have an error of its own, is no part of the way.
        let way = self.points().iter().filter(|point| point.trust == Trust::Sound);
        point::late_by(above.max(above_all(way, point).unwrap_or(0.0)))
    }

    /// What of the first point that is known much better than all before it may be a late stamp, which those are too uncertain to
    /// tell.
    fn unseen(&self, point: &Point) -> f64 {
        let Some(last) = self.sound().next_back() else { return 0.0 };
        let is_first = !last.is_open() && self.sound().all(|before| before.u > MUCH_BETTER * point.u);
        if is_first { point::late_by((point.z - last.z).max(0.0) + last.u) } else { 0.0 }
    }

    /// What a rise may hide that only the reading before has shown, where there is one stretch and no more: it takes a third one to
    /// tell it from two late stamps.
    fn unproven(&mut self, point: &Point, pair: Option<Pair>, is_sudden: bool) -> f64 {
        let is_above = |before: &Point| pair.is_none() && point.z - before.z > before.noise_to(point);
        if let Some(before) = self.before_rise.take().filter(is_above) {
            return point::late_by(Drift::of(self.sound()).step(&before, point)).abs();
        }
        let last = self.last().filter(|last| is_sudden && is_above(last));
        self.before_rise = last.copied();
        0.0
    }

    /// What a sudden change may hide that came perhaps in the middle of this discharge: as much as its two stretches
    /// disagree by, or as it is from the reading before.
    fn hidden(&self, point: &Point, pair: Option<Pair>) -> f64 {
        self.between(point, pair).min(self.since_last(point))
    }

    /// What a change in the middle of a discharge does to it: as much as its two stretches disagree by, of which one step, whenever
    /// it came, makes no more than 1.5 times as much.
    fn between(&self, point: &Point, pair: Option<Pair>) -> f64 {
        let apart = pair.filter(|pair| pair.is_apart());
        apart.map_or_else(|| self.since_last(point), |pair| pair.difference().hypot(pair.u_ohm))
    }

    /// The same of one stretch, over which the mean conductance is m times what was to be expected. If one step came after its
    /// middle, the sensor had 1/m of that mean there; if it came earlier, at the least (2m - 1)/m of it. Nothing is more likely
    /// between (GUM, rectangular).
    fn since_last(&self, point: &Point) -> f64 {
        let Some(last) = self.last() else { return 0.0 };
        let m = (-Drift::of(self.sound()).step(last, point)).exp();
        if 2.0 * m > 1.0 { (m - 1.0).abs() / (2.0 * m - 1.0).min(1.0) / 3f64.sqrt() } else { f64::INFINITY }
    }

    /// The predicted error of the last reading, 1 sigma, relative.
    fn error(&self, evidence: &Evidence, is_sudden: bool) -> f64 {
        let count = self.sound().count() as f64;
        let mean = self.sound().map(|point| point.z).sum::<f64>() / count;
        let spread = (self.sound().map(|point| (point.z - mean).powi(2)).sum::<f64>() / count).sqrt();
        if spread <= 0.0 {
            return 0.0;
        }
        let (between, inside) = (self.square_between(is_sudden, spread), self.square_inside());
        let square = between.max(inside);
        // A sine about a mean bends so much; what readings follow bends as they do.
        let sine = square / spread;
        let followed = bend(self.sound()).filter(|_| inside <= FOLLOWED * between);
        let bend = followed.map_or(sine, |bend| sine.min(bend));
        1e-18 * (bend * evidence.bend_ns2 + square * (evidence.bend_ns2 + evidence.apart_ns2))
    }

    /// Mean square of the speed from reading to reading, less its noise, without the greatest, which may have been a step
    /// that is over: of five of an oscillation the other four have 0.8 of it. A speed that grows counts alone.
    fn square_between(&self, is_sudden: bool, spread: f64) -> f64 {
        let (mut sum, mut most, mut count, mut newest) = (0.0, 0.0f64, 0.0, 0.0);
        for (point, next) in self.sound().zip(self.sound().skip(1)) {
            let noise = (point.u.powi(2) + next.u.powi(2)) / point.seconds_to(next).powi(2);
            newest = point.speed_to(next).powi(2) - noise;
            (sum, most, count) = (sum + newest, most.max(newest), count + 1.0);
        }
        if count < 2.0 {
            return 0.0;
        }
        let square = ((sum - most) / (0.8 * (count - 1.0))).max(0.0);
        // Of an oscillation the greatest is twice the mean, and a little more of one that has just turned.
        if newest == most && newest > 3.0 * square && !is_sudden {
            return newest;
        }
        square * self.shortened(square, spread)
    }

    /// By how much the square of the speed from reading to reading is less than that at an instant: what trembles about a mean
    /// turns round in between. For a sine of frequency f read every T, differences are 2 sin(pi f T) of its values and
    /// should be 2 pi f T; faster ones than half the rate of readings look slower.
    fn shortened(&self, square: f64, spread: f64) -> f64 {
        let (mut first, last) = (self.sound(), self.sound().next_back());
        let (Some(first), Some(last)) = (first.next(), last) else { return 1.0 };
        let interval = (last.at - first.at).as_seconds() / (self.sound().count() as f64 - 1.0).max(1.0);
        let sine = (square.sqrt() * interval / (2.0 * spread)).min(1.0);
        if sine > 0.0 { (sine.asin() / sine).powi(2) } else { 1.0 }
    }

    /// Mean square of the slopes inside of the discharges, less its noise; 0 where a single one that noise has brought near
    /// to the gate could make it. After a change in the middle of a discharge only what came since counts, from the second
    /// reading on without the change itself.
    fn square_inside(&self) -> f64 {
        let mixed = self.points().iter().rposition(|point| point.trust == Trust::Mixed);
        let since = mixed.map_or(0, |mixed| if mixed + 3 > self.count { mixed } else { mixed + 1 });
        let slopes = || self.points()[since..].iter().filter_map(|point| point.slope);
        let count = slopes().count() as f64;
        let normalised = slopes().map(|[slope, u]| (slope / u).powi(2)).sum::<f64>() / count;
        if count == 0.0 || normalised < 1.0 + 10.0 * (2.0 / count).sqrt() {
            return 0.0;
        }
        (slopes().map(|[slope, u]| slope * slope - u * u).sum::<f64>() / count).max(0.0)
    }
}

/// All that a discharge is known to go through, whose logarithm there is even where noise has made a sensor negative, ohm.
fn through(r_ohm: f64, r_o_ohm: Option<f64>) -> f64 {
    (r_ohm + r_o_ohm.unwrap_or(0.0)).max(LEAST_OHM)
}

#[cfg(test)]
mod tests;
