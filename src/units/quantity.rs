//! Physical quantities as text: a number, an optional prefix, a unit.

use super::force::{GRAVITY, POUND_FORCE_N};
use super::number::rounded;
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

/// Significant digits of a quantity in text when no precision is asked for: round-trips to 5e-13.
const DIGITS: usize = 13;

/// The prefixes that are written, and their powers of ten, largest first. `M` and `m` differ.
const PREFIXES: [(&str, i32); 7] = [("M", 6), ("k", 3), ("", 0), ("m", -3), ("u", -6), ("n", -9), ("p", -12)];

/// A physical quantity, held in its SI unit.
pub trait Quantity: Copy + fmt::Display {
    /// What it is, with its article: "a capacitance".
    const NAME: &'static str;
    /// How it may be written: "2.2 uF".
    const EXAMPLE: &'static str;
    /// The spellings of its unit that are accepted; the first is the one that is written.
    const UNITS: &'static [&'static str];
    /// Units that are meant by who writes a number without any, each from that number on; below them, that of [`Self::UNITS`].
    const MEANT: &'static [(f64, &'static str)] = &[];
    /// Other units that are accepted, and what one of them is in the SI unit.
    const OTHERS: &'static [(&'static str, f64)] = &[];
    /// From the value in the SI unit.
    fn from_si(value: f64) -> Self;
    /// The value in the SI unit.
    fn si(self) -> f64;
}

/// A text that is not the quantity that was asked for.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected {name} such as \"{example}\", got {got}{}", why(.got, .with_unit))]
pub struct ParseQuantityError {
    name: &'static str,
    example: &'static str,
    /// As it was written, in quotes if it was a text.
    got: String,
    /// What it would be with the unit that it lacks.
    with_unit: Option<String>,
}

fn why(got: &str, with_unit: &Option<String>) -> String {
    match with_unit {
        Some(right) => format!(": the unit is missing, write \"{right}\""),
        None if got.contains(',') => ": decimals have a point".to_owned(),
        None => String::new(),
    }
}

impl ParseQuantityError {
    /// `got`: without quotes; `text`: as it was written.
    fn new<Q: Quantity>(got: &str, text: String) -> ParseQuantityError {
        // Whatever is a quantity as soon as it has a unit.
        let number = got.trim();
        // Who writes no more than 1 means a part of it, not of a percent.
        let part = number.parse().ok().filter(|part: &f64| Q::UNITS[0] == "%" && (0.0..=1.0).contains(part));
        let number = part.map_or(number.to_owned(), |part| rounded(100.0 * part, 7).to_string());
        let size = number.parse().map_or(0.0, f64::abs);
        let meant = Q::MEANT.iter().rev().find(|(from, _)| size >= *from);
        let unit = meant.map_or(Q::UNITS[0], |(_, unit)| unit);
        let right = value_of::<Q>(&format!("{number}{unit}"));
        let with_unit = right.map(|value| Q::from_si(value).to_string());
        ParseQuantityError { name: Q::NAME, example: Q::EXAMPLE, got: text, with_unit }
    }
}

/// Reads `2.2 uF`: number, blanks if any, prefix if any, unit. Micro is `u`, U+00B5 or U+03BC.
fn parse<Q: Quantity>(text: &str) -> Result<Q, ParseQuantityError> {
    value_of::<Q>(text).map(Q::from_si).ok_or_else(|| ParseQuantityError::new::<Q>(text, format!("{text:?}")))
}

/// In the SI unit.
fn value_of<Q: Quantity>(text: &str) -> Option<f64> {
    let others = || Q::OTHERS.iter().find_map(|(unit, size)| Some(value_in(text.trim(), &[unit])? * size));
    value_in(text.trim(), Q::UNITS).or_else(others).filter(|value| value.is_finite())
}

fn value_in(text: &str, units: &[&str]) -> Option<f64> {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'e' | 'E');
    let (number, rest) = text.split_at(text.find(|c| !is_number(c))?);
    let (mantissa, exponent) = match number.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse().ok()?),
        None => (number, 0i32),
    };
    units.iter().find_map(|unit| {
        let prefix = match rest.trim_start().strip_suffix(unit)? {
            "\u{b5}" | "\u{3bc}" => "u",
            prefix => prefix,
        };
        let (_, power) = PREFIXES.iter().find(|(name, _)| *name == prefix)?;
        // As text, so that "2.2 uF" is the very number that 2.2e-6 is.
        format!("{mantissa}e{}", exponent.saturating_add(*power)).parse().ok()
    })
}

/// Writes with the prefix that puts the number between 1 and 1000, as far as there is one. The formatter's
/// precision counts significant digits.
fn write<Q: Quantity>(quantity: Q, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let digits = f.precision().unwrap_or(DIGITS).max(1);
    let value = rounded(quantity.si(), digits);
    let size = value.abs();
    let (prefix, power) = match PREFIXES.iter().find(|(_, power)| size >= 10f64.powi(*power)) {
        Some(found) => *found,
        None if size == 0.0 => ("", 0),
        None => PREFIXES[PREFIXES.len() - 1],
    };
    let scaled = rounded(value / 10f64.powi(power), digits);
    match scaled.abs() {
        // Beyond the prefixes: a row of zeros is hard to count.
        size if size >= 1e6 || (size < 1e-6 && size > 0.0) => write!(f, "{value:e} {}", Q::UNITS[0]),
        _ => write!(f, "{scaled} {prefix}{}", Q::UNITS[0]),
    }
}

/// Reads a quantity out of a string; a bare number is refused, because its unit would be a guess.
struct QuantityVisitor<Q>(PhantomData<Q>);

impl<Q: Quantity> Visitor<'_> for QuantityVisitor<Q> {
    type Value = Q;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} such as \"{}\"", Q::NAME, Q::EXAMPLE)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Q, E> {
        parse(text).map_err(E::custom)
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<Q, E> {
        bare::<Q, E>(&number.to_string())
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<Q, E> {
        bare::<Q, E>(&number.to_string())
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<Q, E> {
        bare::<Q, E>(&number.to_string())
    }
}

fn bare<Q: Quantity, E: de::Error>(number: &str) -> Result<Q, E> {
    Err(E::custom(ParseQuantityError::new::<Q>(number, number.to_owned())))
}

/// Declares a quantity; everything else about it follows.
macro_rules! quantity {
    ($(#[$doc:meta])* $type:ident, $name:literal, $example:literal, $units:expr $(, or $others:expr)? $(; $meant:expr)?) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
        pub struct $type(pub f64);

        impl Quantity for $type {
            const NAME: &'static str = $name;
            const EXAMPLE: &'static str = $example;
            const UNITS: &'static [&'static str] = &$units;
            $(const MEANT: &'static [(f64, &'static str)] = &$meant;)?
            $(const OTHERS: &'static [(&'static str, f64)] = &$others;)?
            fn from_si(value: f64) -> Self {
                $type(value)
            }
            fn si(self) -> f64 {
                self.0
            }
        }

        impl FromStr for $type {
            type Err = ParseQuantityError;
            fn from_str(text: &str) -> Result<Self, ParseQuantityError> {
                parse(text)
            }
        }

        impl fmt::Display for $type {
            /// With an engineering prefix; the precision, if given, counts significant digits.
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write(*self, f)
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                // Whatever it is: a number gets an error of its own.
                deserializer.deserialize_any(QuantityVisitor(PhantomData))
            }
        }
    };
}

quantity!(
    /// A resistance in ohm.
    Ohm, "a resistance", "2.32 kohm", ["ohm", "Ohm", "\u{3a9}", "\u{2126}"]
);
quantity!(
    /// A capacitance in farad; also the progress of a discharge, seconds per ohm.
    Farad, "a capacitance", "2.2 uF", ["F"]; [(1e-3, "uF"), (15.0, "nF")]
);
quantity!(
    /// A voltage in volt.
    Volt, "a voltage", "1.3 V", ["V"]
);
quantity!(
    /// A current in ampere.
    Ampere, "a current", "5 uA", ["A"]
);
quantity!(
    /// A force in newton; a mass stands for its weight under standard gravity.
    Newton, "a force", "5.75 N", ["N"], or [("g", 1e-3 * GRAVITY), ("lbf", POUND_FORCE_N)]
);
quantity!(
    /// A frequency in hertz.
    Hertz, "a frequency", "50 MHz", ["Hz"]
);
quantity!(
    /// A duration in seconds, for predictions; instants and time-outs are [`Nanos`](super::Nanos).
    Seconds, "a duration", "50 ms", ["s"]; [(10.0, "ms")]
);
quantity!(
    /// The same of what takes about as long as a discharge.
    Millis, "a duration", "3 ms", ["s"]; [(0.2, "ms")]
);
quantity!(
    /// The same of what the kernel takes: latencies.
    Micros, "a duration", "8 us", ["s"]; [(1e-3, "us"), (1e3, "ns")]
);
quantity!(
    /// The same of the period of a clock.
    Ticks, "a duration", "20 ns", ["s"]; [(1e-3, "us"), (1.0, "ns")]
);
quantity!(
    /// The sensor parameter alpha = F R of eq. (1), in newton ohm.
    NewtonOhm, "a sensor parameter alpha", "13346 N ohm",
    ["N ohm", "Nohm", "N \u{3a9}", "N\u{3a9}", "N \u{2126}", "N\u{2126}"]
);

quantity!(
    /// A temperature or a difference of two, in kelvin.
    Kelvin, "a number of kelvins", "3950 K", ["K"]
);
quantity!(
    /// A temperature in degrees Celsius.
    Celsius, "a temperature", "25 degC", ["degC", "\u{b0}C"]
);
quantity!(
    /// An illuminance in lux.
    Lux, "an illuminance", "10 lx", ["lx", "lux"]
);
quantity!(
    /// A length in metre.
    Metre, "a length", "100 mm", ["m"], or [("cm", 0.01)]
);
quantity!(
    /// An angle in degrees.
    Degree, "an angle", "270 deg", ["deg", "\u{b0}"]
);
quantity!(
    /// A relative uncertainty, or a part of a whole, in percent.
    Percent, "a relative uncertainty", "8.7 %", ["%"]
);

#[cfg(test)]
mod tests;
