//! What a sensor had at an instant, and how far that can be trusted.

use crate::estimate::limits::{BEYOND_NOISE, OPEN_LN};
use crate::units::Nanos;

/// All that a discharge goes through at the least: of that there is a logarithm.
pub(super) const LEAST_OHM: f64 = 1e-3;

/// What a sensor had at an instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Point {
    pub(super) at: Nanos,
    /// ln(R_x+Ro), and 1 sigma.
    pub(super) z: f64,
    pub(super) u: f64,
    /// With 1 sigma, 1/s.
    pub(super) slope: Option<[f64; 2]>,
    pub(super) trust: Trust,
}

/// How far a point can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Trust {
    #[default]
    Sound,
    /// A change that came all at once, or a stamp that was late: the next one tells.
    Sudden,
    /// The sensor changed in the middle of it: a slope, but no value.
    Mixed,
    /// It contradicts itself as if a stamp were late.
    Doubtful,
    /// All that is known is that it was below.
    Below,
}

/// 1 sigma, relative, of a reading of which so much, as a logarithm, may be a late stamp's: all of it, or nothing (GUM, rectangular).
pub(super) fn late_by(above: f64) -> f64 {
    -(-above).exp_m1() / 3f64.sqrt()
}

/// Takes one more, and forgets the first where there is no room.
pub(super) fn push<const N: usize>(points: &mut [Point; N], count: &mut usize, point: Point) {
    if *count == N {
        points.rotate_left(1);
        *count -= 1;
    }
    points[*count] = point;
    *count += 1;
}

impl Point {
    /// The same sensor through so many more ohms.
    pub(super) fn beyond(self, more_ohm: f64) -> Point {
        let all_ohm = (self.z.exp() + more_ohm).max(LEAST_OHM);
        let parts = self.z.exp() / all_ohm;
        let slope = self.slope.map(|slope| slope.map(|part| parts * part));
        Point { z: all_ohm.ln(), u: if self.is_open() { self.u } else { parts * self.u }, slope, ..self }
    }

    /// It is above a bound, and no number.
    pub(super) fn is_open(&self) -> bool {
        self.u >= OPEN_LN
    }

    /// By how much noise may take it to there: of what is near 0 it is the same in ohm wherever it goes, not in parts of itself.
    pub(super) fn noise_to(&self, next: &Point) -> f64 {
        let rise = (next.z - self.z).max(0.0);
        let noise = BEYOND_NOISE * self.u.hypot(rise.exp() * next.u);
        if rise > 0.0 { noise.ln_1p() } else { noise }
    }

    /// How fast it went from here to there, 1/s.
    pub(super) fn speed_to(&self, next: &Point) -> f64 {
        (next.z - self.z) / self.seconds_to(next)
    }

    /// How long it took, never 0.
    pub(super) fn seconds_to(&self, next: &Point) -> f64 {
        (next.at - self.at).as_seconds().max(1e-6)
    }
}
