//! What chance allows: bounds from the sampling error of a figure. What is known to be off besides has a budget of its own.

use std::f64::consts::FRAC_PI_2;
use std::fmt;
use std::ops::{BitAnd, RangeInclusive};

/// A run of all tests judges fewer figures than this.
const FIGURES: f64 = 5000.0;
/// If all that is expected is true, fewer than one run in so many fails.
const RUNS: f64 = 1000.0;
/// How often a figure that is as expected may be found outside of its bounds.
pub const FALSE_ALARM: f64 = 1.0 / (FIGURES * RUNS);

/// The share of normal errors that are within two of their standard deviations.
pub const WITHIN_2U: f64 = 0.954_499_736;

/// A figure of a sample, and how far chance may take it from what is true.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    pub value: f64,
    /// Its standard error.
    pub u: f64,
    pub margin: f64,
}

impl Figure {
    /// One that chance has no part in.
    pub fn exact(value: f64) -> Figure {
        Figure { value, u: 0.0, margin: 0.0 }
    }

    /// Whether it is below a limit.
    pub fn below(self, limit: f64) -> Verdict {
        Verdict { holds: self.value < limit, is_open: (self.value - limit).abs() <= self.margin }
    }

    /// Whether it is so far from zero at most.
    pub fn within(self, limit: f64) -> Verdict {
        Figure { value: self.value.abs(), ..self }.below(limit)
    }

    /// Whether nothing speaks against a value that is known as well as `budget` says.
    pub fn is(self, expected: f64, budget: f64) -> bool {
        (self.value - expected).abs() <= self.margin + budget
    }

    /// Whether nothing speaks against what is promised: a value in this range.
    pub fn is_in(self, promised: RangeInclusive<f64>) -> bool {
        self.value + self.margin >= *promised.start() && self.value - self.margin <= *promised.end()
    }

    pub fn times(self, factor: f64) -> Figure {
        Figure { value: factor * self.value, u: factor.abs() * self.u, margin: factor.abs() * self.margin }
    }

    /// Less another one that has nothing to do with it.
    pub fn less(self, other: Figure) -> Figure {
        Figure {
            value: self.value - other.value,
            u: self.u.hypot(other.u),
            margin: self.margin.hypot(other.margin),
        }
    }

    /// As a part of another one that has nothing to do with it.
    pub fn over(self, other: Figure) -> Figure {
        let [own, others] = [self, other].map(|of| of.times(1.0 / of.value));
        let ratio = Figure { value: 1.0, ..own.less(others) };
        ratio.times(self.value / other.value)
    }

    pub fn sqrt(self) -> Figure {
        let half = 0.5 / self.value.sqrt();
        Figure { value: self.value.sqrt(), u: half * self.u, margin: half * self.margin }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(4);
        write!(f, "{:.digits$} +- {:.digits$}", self.value, self.margin)
    }
}

/// What a sample says of a criterion.
#[derive(Debug, Clone, Copy)]
pub struct Verdict {
    pub holds: bool,
    /// Chance may have decided.
    is_open: bool,
}

impl Verdict {
    pub fn may_be(self, expected: bool) -> bool {
        self.is_open || self.holds == expected
    }
}

impl From<bool> for Verdict {
    fn from(holds: bool) -> Verdict {
        Verdict { holds, is_open: false }
    }
}

impl BitAnd for Verdict {
    type Output = Verdict;

    fn bitand(self, other: Verdict) -> Verdict {
        let both = |of: fn(Verdict) -> bool| of(self) && of(other);
        // Open, unless one of them fails for certain or both hold for certain.
        let is_open = both(|of| of.may_be(true)) && !both(|of| of.holds && !of.is_open);
        Verdict { holds: both(|of| of.holds), is_open }
    }
}

/// The mean of values that have nothing to do with each other: boards, or what a board does again from the beginning, not
/// readings that share a calibration.
pub fn mean_of(values: &[f64]) -> Figure {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let u = (variance / count).sqrt();
    Figure { value: mean, u, margin: student(values.len() - 1, FALSE_ALARM) * u }
}

/// The root mean square of values that have nothing to do with each other.
pub fn rms_of(values: &[f64]) -> Figure {
    mean_of(&values.iter().map(|value| value * value).collect::<Vec<_>>()).sqrt()
}

/// The standard deviation of values that have nothing to do with each other.
pub fn sd_of(values: &[f64]) -> Figure {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    rms_of(&values.iter().map(|value| value - mean).collect::<Vec<_>>())
}

/// Something of values of boards, all together: its error from what it becomes without each of the boards (jackknife).
pub fn of_boards(boards: &[&[f64]], of: impl Fn(&[f64]) -> f64) -> Figure {
    let without = |left_out: usize| {
        let others = boards.iter().enumerate().filter(|(index, _)| *index != left_out);
        of(&others.flat_map(|(_, board)| board.iter().copied()).collect::<Vec<_>>())
    };
    let count = boards.len() as f64;
    let parts: Vec<f64> = (0..boards.len()).map(without).collect();
    let spread = mean_of(&parts);
    let factor = count - 1.0;
    Figure { value: without(usize::MAX), u: factor * spread.u, margin: factor * spread.margin }
}

/// How many standard errors a figure may be off whose standard error is known.
pub fn sigmas() -> f64 {
    student(1_000_000, FALSE_ALARM)
}

/// How many of `n` trials that have nothing to do with each other may come out, with a chance of `p` each: exact.
pub fn binomial(n: u64, p: f64) -> RangeInclusive<u64> {
    assert!((0.0..=1.0).contains(&p), "{p}");
    let lowest = |p: f64| {
        // So many or fewer come out with a chance of less than half a false alarm.
        let (mut k, mut below) = (0u64, 0.0);
        let mut ln_mass = n as f64 * (1.0 - p).ln();
        loop {
            below += ln_mass.exp();
            if below > FALSE_ALARM / 2.0 || k == n {
                return k;
            }
            ln_mass += ((n - k) as f64 / (k + 1) as f64).ln() + p.ln() - (1.0 - p).ln();
            k += 1;
        }
    };
    lowest(p)..=n - lowest(1.0 - p)
}

/// The share of trials that come out, and whether it may be by chance `p`.
pub fn share_is(hits: usize, n: usize, p: f64) -> bool {
    binomial(n as u64, p).contains(&(hits as u64))
}

/// The same where the chance is known to lie between two, or is promised to.
pub fn share_is_in(hits: usize, n: usize, p: RangeInclusive<f64>) -> bool {
    let [fewest, most] = [p.start(), p.end()].map(|p| binomial(n as u64, p.clamp(0.0, 1.0)));
    (*fewest.start()..=*most.end()).contains(&(hits as u64))
}

/// Whether fewer than such a share of trials come out.
pub fn share_below(hits: usize, n: usize, p: f64) -> Verdict {
    Verdict { holds: (hits as f64) < p * n as f64, is_open: share_is(hits, n, p) }
}

/// What a value with Student's distribution exceeds, up or down, with a chance of `alpha`.
fn student(freedom: usize, alpha: f64) -> f64 {
    // With t = sqrt(n) tan(phi), the density of phi is cos(phi)^(n-1); beyond t = 40 next to nothing is left of many.
    let n = freedom as f64;
    let end = if freedom > 100 { (40.0 / n.sqrt()).atan() } else { FRAC_PI_2 };
    let area = |from: f64| simpson(|phi| phi.cos().max(0.0).powf(n - 1.0), from, end);
    let (mut low, mut high) = (0.0, end);
    for _ in 0..50 {
        let middle = (low + high) / 2.0;
        if area(middle) > alpha * area(0.0) { low = middle } else { high = middle }
    }
    n.sqrt() * low.tan()
}

fn simpson(of: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    const STEPS: usize = 1000;
    let h = (to - from) / STEPS as f64;
    let inner: f64 = (1..STEPS).map(|i| (2 + 2 * (i % 2)) as f64 * of(from + h * i as f64)).sum();
    (of(from) + inner + of(to)) * h / 3.0
}

#[test]
fn quantiles_are_those_of_the_tables() {
    for (freedom, alpha, t) in
        [(7, 0.001, 5.408), (10, 0.05, 2.228), (30, 0.001, 3.646), (100_000, 5.733e-7, 5.0)]
    {
        assert!((student(freedom, alpha) / t - 1.0).abs() < 1e-3, "{freedom}: {}", student(freedom, alpha));
    }
    // Of ten coins, all or none: 1 in 1024 each, too often for a false alarm; of a hundred, 24 or 76 or beyond.
    assert_eq!((binomial(10, 0.5), binomial(100, 0.5)), (0..=10, 25..=75));
    assert!(share_is(0, 20, 0.0) && !share_is(1, 20, 0.0));
}

#[test]
fn what_boards_say_together_is_as_uncertain_as_their_mean() {
    let values = [[1.0, 2.0], [5.0, 3.0], [4.0, 4.5], [2.5, 0.5]];
    let boards = values.each_ref().map(|board| &board[..]);
    let together = of_boards(&boards, |all| all.iter().sum::<f64>() / all.len() as f64);
    let mean = mean_of(&values.map(|board| (board[0] + board[1]) / 2.0));
    assert!(
        (together.value - mean.value).abs() < 1e-12 && (together.margin / mean.margin - 1.0).abs() < 1e-12
    );
}

#[test]
fn chance_leaves_a_verdict_open_only_near_the_limit() {
    let at = |value| Figure { value, u: 0.1, margin: 0.5 }.below(1.0);
    let [low, near, high] = [0.2, 0.9, 1.6].map(at);
    assert!(!low.may_be(false) && near.may_be(false) && near.may_be(true) && !high.may_be(true));
    assert!((near & low).may_be(false) && !(near & high).may_be(true) && !(low & low).may_be(false));
    assert!(share_below(3, 1000, 0.1).may_be(true) && !share_below(3, 1000, 0.1).may_be(false));
}
