//! `[gpio]`: which lines the circuit is wired to.
//!
//! For: names of chips and lines. Must not know: whether they exist.

use serde::Deserialize;
use serde::de::{self, Deserializer, Visitor};
use std::fmt;

/// What switches and senses the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Backend {
    /// The character device, uAPI v2: Linux 5.10 and later.
    Chardev,
    /// The character device, uAPI v1: for kernels before 5.10. Needs chargers of their own.
    ChardevV1,
    /// The simulated circuit of `[mock]`.
    #[default]
    Mock,
}

/// `[gpio]`. Lines may stay out with the simulated circuit.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Gpio {
    /// Required where `[gpio]` is there; without `[gpio]`: `mock`.
    pub backend: Backend,
    /// The chip by label, name or path. Required for hardware.
    pub chip: Option<String>,
    /// The input at node A. Required for hardware.
    pub sense_a: Option<Line>,
    /// The input at node B. Required for hardware with two capacitors.
    pub sense_b: Option<Line>,
    /// The output that charges node A. Default: the sense line charges too (the wiring of the paper).
    pub charge_a: Option<Line>,
    /// The output that charges node B. Default: as `charge-a`; either both or none.
    pub charge_b: Option<Line>,
    /// The output that sinks Rc1. Required for hardware.
    pub sink_c1: Option<Line>,
    /// The output that sinks Rc2, or the far end of Rc1 + Rc2. Required for hardware.
    pub sink_c2: Option<Line>,
}

impl Gpio {
    /// Every line that has a key here, with that key.
    pub fn lines(&self) -> [(&'static str, Option<&Line>); 6] {
        [
            ("sense-a", self.sense_a.as_ref()),
            ("sense-b", self.sense_b.as_ref()),
            ("charge-a", self.charge_a.as_ref()),
            ("charge-b", self.charge_b.as_ref()),
            ("sink-c1", self.sink_c1.as_ref()),
            ("sink-c2", self.sink_c2.as_ref()),
        ]
    }
}

/// A line of the chip: its name, or its offset as a number or as digits.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Line {
    /// As `gpioinfo` shows it: `GPIO17`.
    Name(String),
    /// Counted from 0.
    Offset(u32),
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Line::Name(name) => f.write_str(name),
            Line::Offset(offset) => write!(f, "{offset}"),
        }
    }
}

impl<'de> Deserialize<'de> for Line {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Line, D::Error> {
        deserializer.deserialize_any(LineVisitor)
    }
}

struct LineVisitor;

impl Visitor<'_> for LineVisitor {
    type Value = Line;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a line's name such as \"GPIO17\", or its offset such as 17")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Line, E> {
        match text.parse() {
            Ok(offset) => Ok(Line::Offset(offset)),
            Err(_) if text.trim().is_empty() => Err(E::invalid_value(de::Unexpected::Str(text), &self)),
            Err(_) => Ok(Line::Name(text.to_owned())),
        }
    }

    fn visit_i64<E: de::Error>(self, offset: i64) -> Result<Line, E> {
        u32::try_from(offset)
            .map(Line::Offset)
            .map_err(|_| E::invalid_value(de::Unexpected::Signed(offset), &self))
    }
}
