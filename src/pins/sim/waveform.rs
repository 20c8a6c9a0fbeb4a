//! The voltage of one node between two changes, V(t) = V(0) + k1 phi(r1, t) + k2 phi(r2, t) + ..., and when it passes a
//! threshold.

use crate::pins::limits::{MOST_DOUBLINGS, MOST_ROOT_STEPS};

/// A mode: how it decays (1/s, not negative), and its slope at time 0 (V/s).
pub type Mode = (f64, f64);

/// A voltage as a function of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Waveform {
    /// Volt at time 0.
    pub start: f64,
    modes: Modes,
}

/// The fastest first.
#[derive(Debug, Clone, PartialEq)]
enum Modes {
    Two([Mode; 2]),
    Many(Vec<Mode>),
}

/// (1 - exp(-rate t)) / rate, continuous down to rate 0.
fn progress(rate: f64, t: f64) -> f64 {
    if rate > 0.0 { -(-rate * t).exp_m1() / rate } else { t }
}

impl Waveform {
    /// Of two modes, the faster first.
    pub fn of_two(start: f64, modes: [Mode; 2]) -> Waveform {
        Waveform { start, modes: Modes::Two(modes) }
    }

    /// Of any number of modes, the fastest first.
    pub fn of_many(start: f64, modes: Vec<Mode>) -> Waveform {
        Waveform { start, modes: Modes::Many(modes) }
    }

    /// The modes; one without a slope contributes nothing, at whatever rate.
    pub fn modes(&self) -> impl Iterator<Item = Mode> {
        let modes = match &self.modes {
            Modes::Two(modes) => &modes[..],
            Modes::Many(modes) => modes,
        };
        modes.iter().copied().filter(|(_, slope)| *slope != 0.0)
    }

    /// Volt at time `t` (seconds).
    pub fn at(&self, t: f64) -> f64 {
        self.modes().fold(self.start, |sum, (rate, slope)| sum + slope * progress(rate, t))
    }

    /// dV/dt at time `t`, V/s.
    pub fn slope(&self, t: f64) -> f64 {
        self.modes().fold(0.0, |sum, (rate, slope)| sum + slope * (-rate * t).exp())
    }

    /// Where it goes in the end, volt.
    fn end(&self) -> f64 {
        self.modes().fold(self.start, |sum, (rate, slope)| sum + slope / rate)
    }

    /// The times after 0 at which the voltage turns, in ascending order.
    pub fn turns(&self) -> impl Iterator<Item = f64> + use<> {
        let (one, many) = match &self.modes {
            Modes::Two([first, second]) => (root_of_two(*first, *second), Vec::new()),
            Modes::Many(_) => (None, roots(&self.modes().collect::<Vec<_>>())),
        };
        one.into_iter().chain(many)
    }

    /// A voltage that it does not exceed between two times, and usually comes near to: what rises reaches its end, what
    /// falls has not begun.
    pub fn highest(&self, from: f64, to: f64) -> f64 {
        let rises = self.modes().filter(|(_, slope)| *slope > 0.0);
        rises.fold(self.at(from), |sum, (rate, slope)| {
            sum + slope * (-rate * from).exp() * progress(rate, to - from)
        })
    }

    /// The first time in `from`..=`until` at which the voltage is at or below `threshold`.
    ///
    /// The search is relative: its error is a few units in the last place of the time itself.
    pub fn falls_after(&self, from: f64, threshold: f64, until: f64) -> Option<f64> {
        if let Modes::Many(_) = self.modes {
            if let Some(found) = self.falls_step_by_step(from, threshold, until) {
                return found;
            }
        }
        let mut modes = self.modes();
        let first = modes.next().unwrap_or_default();
        if modes.next().is_none() && from == 0.0 {
            return self.single_mode(first, threshold).filter(|t| *t <= until);
        }
        if self.at(from) <= threshold {
            return (from <= until).then_some(from);
        }
        // The voltage is monotone between two turns; only a falling stretch can cross.
        let mut above = from;
        for turn in self.turns().filter(|turn| *turn > from && *turn < until) {
            if self.at(turn) <= threshold {
                return Some(self.root(threshold, above, turn));
            }
            above = turn;
        }
        self.falls_on_last_stretch(threshold, above, until)
    }

    /// By steps that never go past the first crossing, for what falls only slows down and what rises is left out of the
    /// slope; `None` where what rises is so much that they do not get there.
    fn falls_step_by_step(&self, from: f64, threshold: f64, until: f64) -> Option<Option<f64>> {
        let mut t = from;
        for _ in 0..MOST_ROOT_STEPS {
            let excess = self.at(t) - threshold;
            if excess <= 0.0 {
                return Some(Some(t));
            }
            let falls = self.modes().filter(|(_, slope)| *slope < 0.0);
            let (slope, rest) = falls.fold((0.0, 0.0), |(all, rest), (rate, slope)| {
                let now = -slope * (-rate * t).exp();
                (all + now, rest + now / rate)
            });
            let step = excess / slope;
            if rest < excess || t + step > until {
                return Some(None);
            }
            if step <= 2.0 * f64::EPSILON * t {
                return Some(Some(t));
            }
            t += step;
        }
        None
    }

    fn single_mode(&self, (rate, slope): Mode, threshold: f64) -> Option<f64> {
        let drop = threshold - self.start;
        if drop >= 0.0 {
            return Some(0.0);
        }
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
        let fastest = self.modes().map(|(rate, _)| rate).next().filter(|rate| *rate > 0.0);
        let mut step = fastest.map_or(1e-6, |rate| 1.0 / rate);
        for _ in 0..MOST_DOUBLINGS {
            if self.at(from + step) <= threshold {
                return Some(self.root(threshold, from, from + step));
            }
            step *= 2.0;
        }
        None
    }

    /// The crossing in `above`..=`below`, which bracket it.
    fn root(&self, threshold: f64, above: f64, below: f64) -> f64 {
        root(|t| (self.at(t) - threshold, self.slope(t)), above, below)
    }
}

/// Where a function, given with its slope, is zero between an instant at which it is above zero and one at which it is not:
/// Newton's method, halving where it would leave the bracket or does not converge.
fn root(function: impl Fn(f64) -> (f64, f64), mut above: f64, mut below: f64) -> f64 {
    let mut t = 0.5 * (above + below);
    let mut width = (below - above).abs();
    for _ in 0..MOST_ROOT_STEPS {
        let (value, slope) = function(t);
        *(if value > 0.0 { &mut above } else { &mut below }) = t;
        let newton = t - value / slope;
        let (low, high) = (above.min(below), above.max(below));
        if (newton - t).abs() <= 2.0 * f64::EPSILON * t || high - low <= 2.0 * f64::EPSILON * t {
            break;
        }
        let is_inside = newton > low && newton < high;
        let shrinks = (newton - t).abs() < 0.5 * width;
        let next = if is_inside && shrinks { newton } else { 0.5 * (above + below) };
        width = (next - t).abs();
        t = next;
    }
    t
}

/// Where the sum of two slope exp(-rate t) is zero after time 0.
fn root_of_two((rate, slope): Mode, (slower, other): Mode) -> Option<f64> {
    if slope * other >= 0.0 || rate == slower {
        return None;
    }
    let t = (-slope / other).ln() / (rate - slower);
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// Where a sum of slope exp(-rate t), the fastest first, is zero after time 0.
///
/// Divided by its slowest term the sum is a constant and what decays; that has a derivative of one term fewer, and is
/// monotone between the roots of this.
fn roots(terms: &[Mode]) -> Vec<f64> {
    let Some((&(slowest, constant), others)) = terms.split_last() else { return Vec::new() };
    if let &[first] = others {
        return root_of_two(first, (slowest, constant)).into_iter().collect();
    }
    if is_of_one_sign(terms) {
        return Vec::new();
    }
    let derivative: Vec<Mode> =
        others.iter().map(|(rate, slope)| (*rate, slope * (slowest - rate))).collect();
    let sum = |terms: &[Mode], t: f64| -> f64 {
        terms.iter().map(|(rate, slope)| slope * (-(rate - slowest) * t).exp()).sum()
    };
    let value = |t: f64| constant + sum(others, t);
    let change_of_sign = |from: f64, to: f64| {
        let sign = value(from).signum();
        root(|t| (sign * value(t), sign * sum(&derivative, t)), from, to)
    };
    let (mut found, mut from) = (Vec::new(), 0.0);
    for turn in roots(&derivative) {
        if value(from) * value(turn) < 0.0 {
            found.push(change_of_sign(from, turn));
        }
        from = turn;
    }
    if value(from) * constant < 0.0 {
        let mut step = 1.0 / (others[0].0 - slowest);
        let mut doublings = 0..MOST_DOUBLINGS;
        while value(from) * value(from + step) > 0.0 && doublings.next().is_some() {
            step *= 2.0;
        }
        found.push(change_of_sign(from, from + step));
    }
    found
}

/// Whether a sum of slope exp(-rate t), the fastest first, is so for certain: as summed from the slowest term on it is made of
/// differences of exponentials, none of them negative, with the sums of slopes as factors.
fn is_of_one_sign(terms: &[Mode]) -> bool {
    let sums = terms.iter().rev().scan(0.0, |sum, (_, slope)| {
        *sum += slope;
        Some(*sum)
    });
    let (least, most) = sums.fold((0.0f64, 0.0f64), |(least, most), sum| (least.min(sum), most.max(sum)));
    least == 0.0 || most == 0.0
}
