//! Values whose key says more of them than their type: a number that has its unit in the name of its key, and who writes it in
//! the value, too; a duration whose size is known from what it is for, and who leaves its unit away.

use crate::instrument::settings::OffsetSource;
use crate::units::Nanos;
use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};
use std::fmt;

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a number, without a unit")]
enum Bare {
    Alone(f64),
}

/// Reads a number; its error says that no unit belongs there.
pub fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Bare::deserialize(deserializer).map(|Bare::Alone(number)| number)
}

/// The same for a key that may be missing.
pub fn optional<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    number(deserializer).map(Some)
}

/// Reads a duration for a key that may be missing; the error of one without a unit advises what is meant by such a number there.
pub fn duration<'de, D: Deserializer<'de>, Size: Deserialize<'de>>(
    deserializer: D,
) -> Result<Option<Nanos>, D::Error>
where
    Nanos: From<Size>,
{
    Size::deserialize(deserializer).map(|size| Some(size.into()))
}

/// Reads an offset for a key that may be missing.
pub fn offset<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<OffsetSource>, D::Error> {
    deserializer.deserialize_any(OffsetVisitor).map(Some)
}

/// A number alone gets the same error as one in a string.
struct OffsetVisitor;

impl Visitor<'_> for OffsetVisitor {
    type Value = OffsetSource;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"auto\", or a duration such as \"8 us\"")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<OffsetSource, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<OffsetSource, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<OffsetSource, E> {
        self.visit_str(&number.to_string())
    }
}
