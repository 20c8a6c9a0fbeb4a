//! The voltage of one node between two changes, V(t) = V(0) + k1 phi(r1, t) + k2 phi(r2, t), and when it passes a
//! threshold.

use crate::pins::limits::{MOST_DOUBLINGS, MOST_ROOT_STEPS};

/// A voltage as a function of time, with at most one extremum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waveform {
    /// Volt at time 0.
    pub start: f64,
    /// Decay of each mode, 1/s, not negative.
    pub rates: [f64; 2],
    /// Slope of each mode at time 0, V/s.
    pub slopes: [f64; 2],
}

/// (1 - exp(-rate t)) / rate, continuous down to rate 0.
fn progress(rate: f64, t: f64) -> f64 {
    if rate > 0.0 { -(-rate * t).exp_m1() / rate } else { t }
}

impl Waveform {
    /// Volt at time `t` (seconds).
    pub fn at(&self, t: f64) -> f64 {
        let [first, second] = self.modes(|slope, rate| slope * progress(rate, t));
        self.start + first + second
    }

    /// dV/dt at time `t`, V/s.
    pub fn slope(&self, t: f64) -> f64 {
        let [first, second] = self.modes(|slope, rate| slope * (-rate * t).exp());
        first + second
    }

    /// Where it goes in the end, volt.
    fn end(&self) -> f64 {
        let [first, second] = self.modes(|slope, rate| slope / rate);
        self.start + first + second
    }

    /// What each mode contributes; one without a slope contributes nothing, at whatever rate.
    fn modes(&self, of: impl Fn(f64, f64) -> f64) -> [f64; 2] {
        [0, 1].map(|i| if self.slopes[i] == 0.0 { 0.0 } else { of(self.slopes[i], self.rates[i]) })
    }

    /// The time after 0 at which the voltage turns, if there is one.
    pub fn turn(&self) -> Option<f64> {
        let [first, second] = self.slopes;
        let spread = self.rates[0] - self.rates[1];
        if first * second >= 0.0 || spread == 0.0 {
            return None;
        }
        let t = (-first / second).ln() / spread;
        (t > 0.0 && t.is_finite()).then_some(t)
    }

    /// The first time in `from`..=`until` at which the voltage is at or below `threshold`.
    ///
    /// The search is relative: its error is a few units in the last place of the time itself.
    pub fn falls_after(&self, from: f64, threshold: f64, until: f64) -> Option<f64> {
        if self.slopes[1] == 0.0 && from == 0.0 {
            return self.single_mode(threshold).filter(|t| *t <= until);
        }
        if self.at(from) <= threshold {
            return (from <= until).then_some(from);
        }
        // The voltage is monotone on either side of the turn; only a falling stretch can cross.
        if let Some(turn) = self.turn().filter(|turn| *turn > from && *turn < until) {
            if self.at(turn) <= threshold {
                return Some(self.root(threshold, from, turn));
            }
            return self.falls_on_last_stretch(threshold, turn, until);
        }
        self.falls_on_last_stretch(threshold, from, until)
    }

    fn single_mode(&self, threshold: f64) -> Option<f64> {
        let drop = threshold - self.start;
        if drop >= 0.0 {
            return Some(0.0);
        }
        let (rate, slope) = (self.rates[0], self.slopes[0]);
        if slope >= 0.0 {
            return None;
        }
        let share = rate * (drop / slope);
        if rate == 0.0 { Some(drop / slope) } else { (share < 1.0).then(|| -(-share).ln_1p() / rate) }
    }

    fn falls_on_last_stretch(&self, threshold: f64, from: f64, until: f64) -> Option<f64> {
        if until.is_finite() {
            return (self.at(until) <= threshold).then(|| self.root(threshold, from, until));
        }
        if self.end() >= threshold {
            return None;
        }
        let mut step = if self.rates[0] > 0.0 { 1.0 / self.rates[0] } else { 1e-6 };
        for _ in 0..MOST_DOUBLINGS {
            if self.at(from + step) <= threshold {
                return Some(self.root(threshold, from, from + step));
            }
            step *= 2.0;
        }
        None
    }

    /// The crossing in `above`..=`below`, which bracket it: Newton's method, halving where it would leave the
    /// bracket or does not converge.
    fn root(&self, threshold: f64, above: f64, below: f64) -> f64 {
        let (mut above, mut below) = (above, below);
        let mut t = 0.5 * (above + below);
        let mut width = below - above;
        for _ in 0..MOST_ROOT_STEPS {
            let excess = self.at(t) - threshold;
            if excess > 0.0 {
                above = t;
            } else {
                below = t;
            }
            let newton = t - excess / self.slope(t);
            if (newton - t).abs() <= 2.0 * f64::EPSILON * t || below - above <= 2.0 * f64::EPSILON * t {
                break;
            }
            let inside = newton > above && newton < below;
            let shrinks = (newton - t).abs() < 0.5 * width;
            let next = if inside && shrinks { newton } else { 0.5 * (above + below) };
            width = (next - t).abs();
            t = next;
        }
        t
    }
}
