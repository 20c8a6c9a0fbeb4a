//! From values to places along an axis, and where its ticks stand.

use super::limits::EDGE;
use crate::units::{Farad, Ohm, Seconds, rounded};

/// How a value is written at a tick or in words.
pub type Writer = fn(f64) -> String;

pub fn seconds(value: f64) -> String {
    format!("{:.3}", Seconds(value))
}

/// Below 1 ohm without a prefix: milliohms look like megohms.
pub fn ohms(value: f64) -> String {
    if value.abs() < 1.0 { format!("{} ohm", rounded(value, 3)) } else { format!("{:.3}", Ohm(value)) }
}

pub fn farads(value: f64) -> String {
    format!("{:.3}", Farad(value))
}

pub fn percent(value: f64) -> String {
    format!("{} %", rounded(100.0 * value, 3))
}

/// So many significant digits, zeros included: 2.0.
pub fn digits(value: f64, count: i32) -> String {
    let size = rounded(value.abs(), count.max(1) as usize).max(1e-9).log10().floor() as i32;
    format!("{value:.*}", (count - 1 - size).clamp(0, 9) as usize)
}

pub fn plain(value: f64) -> String {
    rounded(value, 3).to_string()
}

/// One axis of a plot, logarithmic.
#[derive(Debug, Clone)]
pub struct Axis {
    /// What is along it, without the unit where `write` has it.
    pub label: String,
    pub from: f64,
    pub to: f64,
    pub write: Writer,
}

impl Axis {
    /// Whole decades around all values that are above zero; `None` without any.
    pub fn decades(label: &str, write: Writer, values: impl Iterator<Item = f64>) -> Option<Axis> {
        let (from, to) = values
            .filter(|value| value.is_finite() && *value > 0.0)
            .fold((f64::INFINITY, 0.0f64), |(from, to), value| (from.min(value), to.max(value)));
        let (low, high) = ((from * EDGE).log10().floor(), (to / EDGE).log10().ceil());
        let high = if high == low { low + 1.0 } else { high };
        (to > 0.0).then(|| Axis {
            label: label.to_owned(),
            from: 10f64.powf(low),
            to: 10f64.powf(high),
            write,
        })
    }

    /// The part of the way from the first to the last value; beyond both ends for what lies beyond.
    pub fn share(&self, value: f64) -> f64 {
        // What is not above zero lies far below.
        if value <= 0.0 { -10.0 } else { (value / self.from).ln() / (self.to / self.from).ln() }
    }

    pub fn contains(&self, value: f64) -> bool {
        value > 0.0 && (self.from / EDGE..=self.to * EDGE).contains(&value)
    }

    /// Values with words, and those with a faint line only; `most` is how many words there is room for.
    pub fn ticks(&self, most: usize) -> (Vec<f64>, Vec<f64>) {
        let [low, high] = [self.from, self.to].map(|end| end.log10());
        let (first, last) = ((low - 1e-9).floor() as i32, (high + 1e-9).ceil() as i32);
        // By way of the text, so that a tick is the number that it says.
        let at = |digit: i32, power: i32| format!("{digit}e{power}").parse().unwrap_or(f64::NAN);
        let all = |digits: &[i32]| -> Vec<f64> {
            let every = (first..=last).flat_map(|power| digits.iter().map(move |digit| at(*digit, power)));
            every.filter(|value| (-1e-9..=1.0 + 1e-9).contains(&self.share(*value))).collect()
        };
        let decades = all(&[1]);
        let between = all(&[2, 3, 4, 5, 6, 7, 8, 9]);
        let finer = all(&[1, 2, 5]);
        if finer.len() <= most && decades.len() < 4 {
            return (finer, between);
        }
        let every = decades.len().div_ceil(most.max(1));
        (decades.into_iter().step_by(every).collect(), if every > 1 { Vec::new() } else { between })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_hold_all_values_and_ticks_are_round() {
        let axis = Axis::decades("time", seconds, [0.002, 9.0, -1.0, f64::NAN].into_iter()).unwrap();
        assert_eq!((axis.from, axis.to), (0.001, 10.0));
        let (words, lines) = axis.ticks(9);
        assert_eq!(words, [0.001, 0.01, 0.1, 1.0, 10.0]);
        assert_eq!(lines.len(), 4 * 8);
        assert_eq!(words.iter().map(|tick| (axis.write)(*tick)).collect::<Vec<_>>()[0], "1 ms");
        assert!((axis.share(0.1) - 0.5).abs() < 1e-12 && axis.contains(10.0) && !axis.contains(0.0009));
        assert_eq!(axis.ticks(3).0, [0.001, 0.1, 10.0]);
        assert_eq!([0.0999, 2.0, 123.4].map(|value| digits(value, 2)), ["0.10", "2.0", "123"]);
        assert!(Axis::decades("none", plain, [0.0].into_iter()).is_none());
    }

    #[test]
    fn one_decade_has_ticks_within() {
        let axis = Axis::decades("R", ohms, [150.0, 900.0].into_iter()).unwrap();
        assert_eq!(axis.ticks(9).0, [100.0, 200.0, 500.0, 1000.0]);
    }
}
