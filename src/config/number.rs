//! A number that has its unit in the name of its key, and who writes it in the value, too.

use serde::Deserialize;
use serde::de::Deserializer;

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
