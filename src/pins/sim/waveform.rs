//! The voltage of one node between two changes, V(t) = V(0) + k1 phi(r1, t) + k2 phi(r2, t) + ..., and when it passes a
//! threshold.

use crate::pins::limits::{MOST_BRANCHES, MOST_DOUBLINGS, MOST_ROOT_STEPS, TURN_HALVINGS};

/// The most modes that a node can have: one for each capacitor and each of its absorbing branches.
pub const MODES: usize = 2 + 2 * MOST_BRANCHES;

/// A voltage as a function of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waveform {
    /// Volt at time 0.
    pub start: f64,
    modes: usize,
    rates: [f64; MODES],
    slopes: [f64; MODES],
}

/// Instants in ascending order, at most one fewer than there are modes.
#[derive(Debug, Clone, Copy, Default)]
pub struct Instants {
    at: [f64; MODES],
    count: usize,
}

impl Instants {
    fn push(&mut self, t: f64) {
        self.at[self.count] = t;
        self.count += 1;
    }

    /// From the first to the last.
    pub fn iter(&self) -> impl Iterator<Item = f64> {
        self.at[..self.count].iter().copied()
    }
}

/// (1 - exp(-rate t)) / rate, continuous down to rate 0.
fn progress(rate: f64, t: f64) -> f64 {
    if rate > 0.0 { -(-rate * t).exp_m1() / rate } else { t }
}

impl Waveform {
    /// From its value at time 0 (volt) and its modes, the fastest first: how each decays (1/s, not negative), and its slope
    /// at time 0 (V/s).
    pub fn new(start: f64, modes: impl IntoIterator<Item = (f64, f64)>) -> Waveform {
        let mut waveform = Waveform { start, modes: 0, rates: [0.0; MODES], slopes: [0.0; MODES] };
        for (rate, slope) in modes.into_iter().take(MODES) {
            (waveform.rates[waveform.modes], waveform.slopes[waveform.modes]) = (rate, slope);
            waveform.modes += 1;
        }
        waveform
    }

    /// Rate and slope of each mode, the fastest first; one without a slope contributes nothing, at whatever rate.
    pub fn modes(&self) -> impl DoubleEndedIterator<Item = (f64, f64)> {
        let modes = self.rates[..self.modes].iter().copied().zip(self.slopes[..self.modes].iter().copied());
        modes.filter(|(_, slope)| *slope != 0.0)
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

    /// The times after 0 at which the voltage turns.
    pub fn turns(&self) -> Instants {
        let mut terms = [(0.0, 0.0); MODES];
        let mut count = 0;
        for (place, term) in terms.iter_mut().zip(self.modes()) {
            (*place, count) = (term, count + 1);
        }
        roots(&terms[..count])
    }

    /// The first time in `from`..=`until` at which the voltage is at or below `threshold`.
    ///
    /// The search is relative: its error is a few units in the last place of the time itself.
    pub fn falls_after(&self, from: f64, threshold: f64, until: f64) -> Option<f64> {
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
        for turn in self.turns().iter().filter(|turn| *turn > from && *turn < until) {
            if self.at(turn) <= threshold {
                return Some(self.root(threshold, above, turn));
            }
            above = turn;
        }
        self.falls_on_last_stretch(threshold, above, until)
    }

    fn single_mode(&self, (rate, slope): (f64, f64), threshold: f64) -> Option<f64> {
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

/// Where a sum of slope exp(-rate t), the fastest first, is zero after time 0.
///
/// Divided by its slowest term the sum is a constant and what decays; that has a derivative of one term fewer, and is
/// monotone between the roots of this. A sum has at most as many roots as its slopes change their sign.
fn roots(terms: &[(f64, f64)]) -> Instants {
    let mut found = Instants::default();
    let Some((&(slowest, constant), others)) = terms.split_last() else { return found };
    if !terms.windows(2).any(|pair| pair[0].1 * pair[1].1 < 0.0) {
        return found;
    }
    if let &[(rate, slope)] = others {
        let t = (-slope / constant).ln() / (rate - slowest);
        if t > 0.0 && t.is_finite() {
            found.push(t);
        }
        return found;
    }
    let value = |t: f64| {
        others.iter().fold(constant, |sum, (rate, slope)| sum + slope * (-(rate - slowest) * t).exp())
    };
    let mut derivative = [(0.0, 0.0); MODES];
    for (place, (rate, slope)) in derivative.iter_mut().zip(others) {
        *place = (*rate, slope * (slowest - rate));
    }
    let mut from = 0.0;
    for turn in roots(&derivative[..others.len()]).iter() {
        if value(from) * value(turn) < 0.0 {
            found.push(halve(value, from, turn));
        }
        from = turn;
    }
    if value(from) * constant < 0.0 {
        let mut step = 1.0 / (others[0].0 - slowest);
        let mut doublings = 0..MOST_DOUBLINGS;
        while value(from) * value(from + step) > 0.0 && doublings.next().is_some() {
            step *= 2.0;
        }
        found.push(halve(value, from, from + step));
    }
    found
}

/// Where a function changes its sign between two instants.
fn halve(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let at_low = value(low);
    for _ in 0..TURN_HALVINGS {
        let middle = 0.5 * (low + high);
        if value(middle) * at_low > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
