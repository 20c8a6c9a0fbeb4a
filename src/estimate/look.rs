//! What rare discharges beside the usual ones have shown: the median of those that are remembered, and how much of it may be noise.

use crate::estimate::limits::{COVERAGE, LOOK_SHOWS, LOOK_SURPRISE, OF_DEVIATION};
use crate::estimate::scatter::Usual;
use crate::units::Nanos;
use std::f64::consts::FRAC_PI_2;

/// What of something that shows is more than chance makes of none.
pub fn beyond(shown: f64, chance: f64) -> f64 {
    (shown.powi(2) - chance.powi(2)).max(0.0).sqrt()
}

/// What all looks have shown, as it is told to who comes later; `None`: too few, or nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Found {
    /// What leaks [early and late](crate::estimate::leak) in a discharge, whether it shows or not, siemens, with 1 sigma.
    pub leak_siemens: Option<[[f64; 2]; 2]>,
    /// The same of what node B loses more.
    pub leak_more_at_b: Option<[[f64; 2]; 2]>,
    /// By how much later stamps are after [waits](crate::estimate::awake) as long as through R_1 and R_2, ns, with 1 sigma.
    pub late_ns: Option<[[f64; 2]; 2]>,
    /// By which share of their time discharges are longer [after a rest](crate::estimate::absorption).
    pub absorbed: Option<f64>,
}

/// Looks so far, the last `N` of them with what they have shown.
#[derive(Debug, Clone, Copy)]
pub struct Looks<const N: usize> {
    shown: [f64; N],
    taken: usize,
    /// Those that came to nothing, and those since the last one that did not.
    failed: usize,
    failed_in_row: usize,
    usual: Usual,
    /// Of the last one alone, as far as it is known without the others.
    variance: f64,
    /// The last one disagrees with those before it: a spike, or news.
    is_surprised: bool,
    last: Option<Nanos>,
}

impl<const N: usize> Default for Looks<N> {
    fn default() -> Looks<N> {
        Looks {
            shown: [0.0; N],
            taken: 0,
            failed: 0,
            failed_in_row: 0,
            usual: Usual::NONE,
            variance: 0.0,
            is_surprised: false,
            last: None,
        }
    }
}

impl<const N: usize> Looks<N> {
    /// As if so many as are remembered had shown this, with 1 sigma of it: later ones replace them one by one.
    pub fn known([shown, noise]: [f64; 2]) -> Looks<N> {
        let variance = noise.powi(2) * N as f64 / FRAC_PI_2;
        let usual = Usual::of(&mut [shown]);
        Looks { shown: [shown; N], taken: N, usual, variance, ..Looks::default() }
    }

    /// Whether another one is due: `first` of them follow each other, and then there is one in every so long.
    pub fn is_due(&self, now: Nanos, first: usize, every: Nanos) -> bool {
        let is_old = self.last.is_none_or(|last| now - last >= every);
        let is_first = self.taken < first && self.failed < first;
        let is_surprised = self.is_surprised && self.failed_in_row < first;
        is_first || is_surprised || is_old
    }

    /// Takes one, whether it told something or not: what it showed, and the variance of that.
    pub fn add(&mut self, shown: Option<[f64; 2]>, now: Nanos) {
        self.last = Some(now);
        let Some([shown, variance]) = shown.filter(|[shown, _]| shown.is_finite()) else {
            self.failed += 1;
            self.failed_in_row += 1;
            return;
        };
        self.failed_in_row = 0;
        self.shown[self.taken % N] = shown;
        self.variance = variance;
        self.taken += 1;
        // A spike is none, so it is not the mean.
        let mut remembered = self.shown;
        self.usual = Usual::of(&mut remembered[..self.taken.min(N)]);
        self.is_surprised = (shown - self.median()).abs() > LOOK_SURPRISE * variance.sqrt();
    }

    /// How many have told something.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// How many there have been, those that came to nothing included.
    pub fn tried(&self) -> usize {
        self.taken + self.failed
    }

    /// What those that are remembered have shown.
    pub fn remembered(&self) -> &[f64] {
        &self.shown[..self.taken.min(N)]
    }

    /// What they show, 0 before the first.
    pub fn median(&self) -> f64 {
        self.usual.place
    }

    /// The noise of that, 1 sigma; 0 before the first.
    pub fn noise(&self) -> f64 {
        self.of_median(self.variance.sqrt())
    }

    /// The same, or more where they differ by more than that makes them: many of them may be late.
    pub fn noise_among(&self) -> f64 {
        let [own, among] = [self.noise(), self.of_median(self.usual.sigma())];
        let by_chance = own * (1.0 + COVERAGE * OF_DEVIATION / self.count().sqrt());
        if among > by_chance { among } else { own }
    }

    /// The variance of a median is pi/2 times that of the mean.
    fn of_median(&self, sigma: f64) -> f64 {
        sigma * (FRAC_PI_2 / self.count()).sqrt()
    }

    fn count(&self) -> f64 {
        self.taken.clamp(1, N) as f64
    }

    /// What shows beyond it.
    pub fn gate(&self) -> f64 {
        LOOK_SHOWS * self.noise()
    }
}
