//! Pairs of force and resistance as people write them.
//!
//! For: lines such as `120 g`, `1.2 N, 11122 ohm` and `1.20,11122`. Must not know: how a resistance is measured.

use super::CalibrateError;
use crate::estimate::fit::Pair;
use crate::units::{Newton, Ohm};

/// Standard gravity, m/s^2: what a mass weighs (CGPM 1901).
const GRAVITY: f64 = 9.80665;

/// A line of input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Line {
    /// Both numbers.
    Pair(Pair),
    /// A force, newton, under which the resistance is to be measured.
    Force(f64),
}

/// The pairs of a CSV file. Empty lines, lines that begin with `#` and a line of names before the first pair are passed
/// over.
///
/// # Errors
/// [`CalibrateError::Pair`] with the number of the line.
pub fn of_csv(text: &str, origin: &str) -> Result<Vec<Pair>, CalibrateError> {
    let mut pairs = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        let is_header = pairs.is_empty() && line.starts_with(|c: char| c.is_ascii_alphabetic());
        if line.is_empty() || line.starts_with('#') || is_header {
            continue;
        }
        let wrong = |reason| CalibrateError::Pair { origin: origin.to_owned(), line: index + 1, reason };
        match parse(line).map_err(wrong)? {
            Line::Pair(pair) => pairs.push(pair),
            Line::Force(_) => return Err(wrong(format!("{line:?} has no resistance: {EXAMPLE}"))),
        }
    }
    Ok(pairs)
}

const EXAMPLE: &str = "write \"force_n,r_ohm\", such as \"1.20,11122\"";

/// One line.
///
/// # Errors
/// What is wrong with it, and how it is written.
pub fn parse(line: &str) -> Result<Line, String> {
    let (left, right) = match line.split_once(',') {
        Some((left, right)) => (left, Some(right)),
        None => (line, None),
    };
    let f_n = force(left.trim())
        .ok_or_else(|| format!("{left:?} is no weight: write \"1.2 N\", \"120 g\" or \"0.12 kg\""))?;
    let Some(right) = right else { return Ok(Line::Force(f_n)) };
    let r_ohm = ohm(right.trim()).ok_or_else(|| format!("{right:?} is no resistance: {EXAMPLE}"))?;
    Ok(Line::Pair(Pair { f_n, r_ohm }))
}

/// Newton; a number alone is in newton.
fn force(text: &str) -> Option<f64> {
    let kilograms = |number: &str, scale: f64| number.trim().parse::<f64>().ok().map(|m| m * scale * GRAVITY);
    let f_n = if let Some(number) = text.strip_suffix("kg") {
        kilograms(number, 1.0)
    } else if let Some(number) = text.strip_suffix('g') {
        kilograms(number, 1e-3)
    } else {
        text.parse().ok().or_else(|| text.parse::<Newton>().ok().map(|newton| newton.0))
    };
    f_n.filter(|f_n| is_physical(*f_n, 1e6))
}

/// A number alone is in ohm.
fn ohm(text: &str) -> Option<f64> {
    let r_ohm = text.parse().ok().or_else(|| text.parse::<Ohm>().ok().map(|ohm| ohm.0));
    r_ohm.filter(|r_ohm| is_physical(*r_ohm, 1e9))
}

/// Squares and reciprocals of what passes stay finite.
fn is_physical(value: f64, limit: f64) -> bool {
    value > 1e-6 && value < limit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_forces() {
        let force = |text: &str| match parse(text).unwrap() {
            Line::Force(f_n) => f_n,
            other => panic!("{other:?}"),
        };
        assert_eq!((force("1.2 N"), force("1.2"), force("1200 mN")), (1.2, 1.2, 1.2));
        assert!((force("500 g") - 4.903325).abs() < 1e-12 && force("0.5kg") == force("500g"));
        let pair = Line::Pair(Pair { f_n: 1.2, r_ohm: 11_122.0 });
        assert_eq!((parse("1.20,11122"), parse("1.2 N, 11.122 kohm")), (Ok(pair), Ok(pair)));
        for wrong in
            ["", "heavy", "-1", "0", "NaN", "inf", "1 ohm", "1,", "1,0", "1,-5", "1,2,3", "1,NaN", "g"]
        {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_wrong_line_is_named() {
        let good = of_csv("force_n,r_ohm\n# light\n1.20,11122\n\n6.06,2200\n", "w.csv").unwrap();
        assert_eq!(good.len(), 2);
        for (text, line) in [("1,2\nforce_n,r_ohm\n", 2), ("# a\n\n1.2\n", 3), ("1,2\n1,x\n", 2)] {
            let error = of_csv(text, "w.csv").unwrap_err().to_string();
            assert!(error.starts_with(&format!("w.csv, line {line}: ")), "{error}");
        }
    }
}
