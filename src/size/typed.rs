//! Ranges, rates and errors as they are typed.

use crate::units::{Ampere, Hertz, Newton, Ohm, Percent, Quantity, rough};
use std::str::FromStr;

/// Ohm: what a sensor can have.
const RESISTANCES: [Ohm; 2] = [Ohm(1.0), Ohm(10e6)];
/// Newton: what it can bear.
const FORCES: [Newton; 2] = [Newton(1e-3), Newton(1e4)];
/// Hertz: beyond this not even the calls of the fastest board come after.
const RATES: [Hertz; 2] = [Hertz(1e-2), Hertz(1e4)];
/// Ampere: what pins are made for.
const CURRENTS: [Ampere; 2] = [Ampere(1e-3), Ampere(50e-3)];

/// `100ohm..100kohm`, or a single value.
fn range<Q: Quantity + FromStr + PartialOrd>(text: &str, [least, most]: [Q; 2]) -> Result<[Q; 2], String> {
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    let value = |part: &str| {
        let value = part.parse::<Q>().ok();
        value.ok_or_else(|| format!("\"{part}\" is not {} such as \"{}\"", Q::NAME, Q::EXAMPLE))
    };
    let [from, to] = [value(from)?, value(to)?];
    if !(from >= least && to <= most) {
        return Err(format!("it is to lie between {} and {}", shown(least), shown(most)));
    }
    if from > to {
        return Err("the smaller value comes first".to_owned());
    }
    Ok([from, to])
}

/// In text.
fn shown<Q: Quantity>(value: Q) -> String {
    rough(value.si(), Q::UNITS[0])
}

/// A single value.
fn one<Q: Quantity + FromStr + PartialOrd>(text: &str, within: [Q; 2]) -> Result<Q, String> {
    let [from, to] = range(text, within)?;
    if from == to { Ok(from) } else { Err(format!("one value is meant, such as \"{}\"", Q::EXAMPLE)) }
}

/// The resistances of a sensor.
pub fn ohms(text: &str) -> Result<[Ohm; 2], String> {
    range(text, RESISTANCES)
}

/// Its forces.
pub fn newtons(text: &str) -> Result<[Newton; 2], String> {
    range(text, FORCES)
}

/// What a pin may carry.
pub fn pin_current(text: &str) -> Result<Ampere, String> {
    one(text, CURRENTS)
}

/// Readings per second.
pub fn rate(text: &str) -> Result<Hertz, String> {
    one(text, RATES)
}

/// An error as it is typed: `0.5%`, `2ohm`, `0.02N`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wanted {
    /// Of the reading.
    Percent(Percent),
    /// Ohm.
    Ohm(Ohm),
    /// Newton.
    Newton(Newton),
}

impl Wanted {
    /// From what is typed.
    pub fn parse(text: &str) -> Result<Wanted, String> {
        let percent = text.parse().map(Wanted::Percent).ok();
        let wanted = percent
            .or_else(|| text.parse().map(Wanted::Ohm).ok())
            .or_else(|| text.parse().map(Wanted::Newton).ok())
            .ok_or("an error is a share, a resistance or a force, such as 0.5%, 2ohm or 0.02N")?;
        let (size, most) = match wanted {
            Wanted::Percent(Percent(percent)) => (percent, 50.0),
            Wanted::Ohm(Ohm(value)) | Wanted::Newton(Newton(value)) => (value, 1e6),
        };
        match size > 1e-6 && size <= most {
            true => Ok(wanted),
            false => Err("an error is above 0, and a share of it at most 50 %".to_owned()),
        }
    }
}
