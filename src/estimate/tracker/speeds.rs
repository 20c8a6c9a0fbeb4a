//! How fast a part of the state walks: what each of some speeds makes of the same observations (Bayes).
//!
//! An observation tells the part itself, with noise. For each speed there is a Kalman filter of that one number, and its
//! innovations tell how likely the speed is: a walk that is assumed too slow lags, one that is assumed too fast believes noise.
//! What is assumed is the mean of all speeds by their likelihoods, which lasts as long as nothing tells them apart.

use crate::estimate::limits::{
    LEAST_LIKELY, LIKELIHOOD_OF, SLOWEST_WALK, SPEEDS, SPEEDS_APART, TELLING, WALK_AT_FIRST,
};
use crate::units::Nanos;

/// One speed, and where the part is if it is the true one.
#[derive(Debug, Clone, Copy, Default)]
struct Guess {
    /// Per root second.
    walk: f64,
    /// Logarithms of how likely it is before anything has been seen, and by now; the likeliest has 0.
    prior: f64,
    likelihood: f64,
    /// Of the part, beside what the state says, and the variance.
    beside: f64,
    variance: f64,
}

/// How fast a part of the state walks.
#[derive(Debug, Clone, Copy)]
pub struct Speeds {
    guesses: [Guess; SPEEDS],
    /// Per root second, by all of them.
    walk: f64,
    seen_at: Option<Nanos>,
}

impl Speeds {
    /// Of d, g and Ro.
    pub fn of_all() -> [Speeds; 3] {
        std::array::from_fn(|index| Speeds::new(SLOWEST_WALK[index], WALK_AT_FIRST[index]))
    }

    /// None is slower than `slowest`; before anything has been seen, all up to `at_first` are as likely, and faster ones less.
    pub fn new(slowest: f64, at_first: f64) -> Speeds {
        let guesses = std::array::from_fn(|index| {
            let walk = slowest * SPEEDS_APART.powi(index as i32);
            let prior = 2.0 * (at_first / walk).ln().min(0.0);
            Guess { walk, prior, likelihood: prior, ..Guess::default() }
        });
        let mut speeds = Speeds { guesses, walk: slowest, seen_at: None };
        speeds.settle();
        speeds
    }

    /// Per root second, in the unit of what [`Speeds::add`] is told.
    pub fn walk(&self) -> f64 {
        self.walk
    }

    /// The part was seen `beside` what the state says, with this variance of its own.
    pub fn add(&mut self, now: Nanos, beside: f64, variance: f64) {
        let seconds = self.seen_at.replace(now).map(|at| (now - at).as_seconds().max(0.0));
        for guess in &mut self.guesses {
            let Some(seconds) = seconds else {
                (guess.beside, guess.variance) = (beside, variance);
                continue;
            };
            let known = guess.variance + guess.walk.powi(2) * seconds;
            let (all, innovation) = (known + variance, beside - guess.beside);
            // A late stamp says little of how fast anything walks.
            let square = (innovation * innovation / all).min(TELLING * TELLING);
            guess.likelihood -= 0.5 * ((all / variance).ln() + square);
            guess.beside += known / all * innovation;
            guess.variance = known * variance / all;
        }
        self.settle();
    }

    /// The state has been corrected by so much.
    pub fn corrected(&mut self, by: f64) {
        self.guesses.iter_mut().for_each(|guess| guess.beside -= by);
    }

    /// Forgets a little, lets none become so unlikely that it cannot come back, and takes the mean.
    fn settle(&mut self) {
        let best = self.guesses.iter().map(|guess| guess.likelihood).fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut all) = (0.0, 0.0);
        for guess in &mut self.guesses {
            let likelihood = guess.likelihood - best;
            guess.likelihood = (likelihood + (guess.prior - likelihood) / LIKELIHOOD_OF).max(-LEAST_LIKELY);
            let weight = guess.likelihood.exp();
            (sum, all) = (sum + weight * guess.walk, all + weight);
        }
        self.walk = sum / all;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::mean_of;
    use rand_distr::{Distribution, StandardNormal};

    const BOARDS: u64 = 200;
    const SLOWEST: f64 = 0.01;

    /// The speed that is found where a part is seen 75 times a second with a noise of 1: it walks as fast as `walk` says of
    /// the time in seconds, and one of 500 observations is `late`.
    fn found(seed: u64, seconds: f64, late: f64, walk: impl Fn(f64) -> f64) -> f64 {
        let mut rng = crate::seed::rng(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut speeds = Speeds::new(SLOWEST, 1.0);
        let mut part = 0.0;
        for index in 0..(75.0 * seconds) as i64 {
            let at = index as f64 / 75.0;
            part += walk(at) / 75f64.sqrt() * normal();
            let stamp = if index % 500 == 499 { late } else { 0.0 };
            speeds.add(Nanos((1e9 * at) as i64), part + normal() + stamp, 1.0);
        }
        speeds.walk()
    }

    fn mean_found(seconds: f64, late: f64, walk: impl Fn(f64) -> f64) -> crate::chance::Figure {
        let all = (0..BOARDS).map(|seed| found(seed, seconds, late, &walk)).collect::<Vec<_>>();
        mean_of(&all)
    }

    #[test]
    fn a_speed_is_found_and_one_that_changes_is_found_again() {
        for walk in [0.05, 0.3, 1.0] {
            let is = mean_found(60.0, 0.0, |_| walk).times(1.0 / walk);
            assert!(is.is_in(0.8..=1.3), "{is} times {walk}");
        }
        let begun = mean_found(40.0, 0.0, |at| if at > 30.0 { 0.3 } else { 0.0 });
        assert!(begun.is_in(0.2..=0.4), "{begun} of 0.3 ten seconds after it has begun");
        let ended = mean_found(60.0, 0.0, |at| if at < 10.0 { 1.0 } else { 0.0 });
        assert!(ended.is_in(0.0..=0.1), "{ended} fifty seconds after 1 has ended");
    }

    #[test]
    fn what_stands_still_is_not_taken_to_walk_though_stamps_are_late() {
        let (still, late) = (mean_found(60.0, 0.0, |_| 0.0), mean_found(60.0, 4.0, |_| 0.0));
        assert!(still.is_in(SLOWEST..=3.0 * SLOWEST), "{still}");
        assert!(late.is_in(SLOWEST..=5.0 * SLOWEST), "{late}");
    }
}
