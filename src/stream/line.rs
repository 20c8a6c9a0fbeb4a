//! Lines of JSON: their class, and their numbers, which are rounded to what they are worth and absent when unknown.

use crate::stream::limits::{TAPE_DIGITS, TIME_DIGITS, UNCERTAINTY_DIGITS, VALUE_DIGITS};
use crate::units::rounded;
use serde::{Deserialize, Serialize, Serializer};

/// What a line is. Serde writes the tag of a struct and does not look at it when it reads.
#[derive(Deserialize)]
pub struct Tagged {
    pub class: String,
}

/// A message as a line, with its newline.
pub fn to_line(message: &impl Serialize) -> Vec<u8> {
    // Texts and finite numbers always serialise.
    let mut line = serde_json::to_vec(message).unwrap_or_default();
    line.push(b'\n');
    line
}

/// Whether a field is left out. NaN and infinity, which JSON cannot say, count as unknown.
pub fn is_unknown(number: &Option<f64>) -> bool {
    number.is_none_or(|number| !number.is_finite())
}

pub fn value<S: Serializer>(number: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    write(*number, VALUE_DIGITS, serializer)
}

pub fn uncertainty<S: Serializer>(number: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    write(*number, UNCERTAINTY_DIGITS, serializer)
}

/// Seconds and hertz, whether they may be missing or not.
pub fn time<S: Serializer, T: Into<Option<f64>> + Copy>(
    number: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    write((*number).into(), TIME_DIGITS, serializer)
}

/// The same of nanoseconds of a discharge, which are stamped as whole ones and halved by the middle of a call.
pub fn ns<S: Serializer, T: Into<Option<f64>> + Copy>(number: &T, serializer: S) -> Result<S::Ok, S::Error> {
    write((*number).into(), TAPE_DIGITS, serializer)
}

/// A field of two numbers, of which both are known or none.
pub fn pair<S: Serializer>(pair: &Option<[f64; 2]>, serializer: S) -> Result<S::Ok, S::Error> {
    /// A number by itself.
    struct Item(f64);
    impl Serialize for Item {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            write(Some(self.0), VALUE_DIGITS, serializer)
        }
    }
    pair.map(|pair| pair.map(Item)).serialize(serializer)
}

/// Whether such a field is left out.
pub fn is_unknown_pair(pair: &Option<[f64; 2]>) -> bool {
    pair.is_none_or(|pair| !pair.iter().all(|number| number.is_finite()))
}

/// Whole numbers have no ".0".
fn write<S: Serializer>(number: Option<f64>, digits: usize, serializer: S) -> Result<S::Ok, S::Error> {
    /// Below this every whole number is exact as an f64: 2^53.
    const WHOLE: f64 = 9_007_199_254_740_992.0;
    match number.map(|number| rounded(number, digits)) {
        Some(number) if number.fract() == 0.0 && number.abs() < WHOLE => {
            serializer.serialize_i64(number as i64)
        }
        Some(number) => serializer.serialize_f64(number),
        None => serializer.serialize_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Serialize;

    #[derive(Serialize)]
    struct Line {
        #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
        n: Option<f64>,
        #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
        u: Option<f64>,
    }

    fn written(n: f64, u: impl Into<Option<f64>>) -> String {
        serde_json::to_string(&Line { n: Some(n), u: u.into() }).unwrap()
    }

    #[test]
    fn numbers_have_their_digits_and_no_noise() {
        assert_eq!(written(2_841.300_000_04, 1.204), r#"{"n":2841.3,"u":1.2}"#);
        assert_eq!(written(1.9e6, 0.000_123_456), r#"{"n":1900000,"u":0.000123}"#);
        assert_eq!(written(0.1 + 0.2, 999.96), r#"{"n":0.3,"u":1000}"#);
        assert_eq!(written(-123_456_789.0, 0.0), r#"{"n":-123456800,"u":0}"#);
    }

    #[test]
    fn what_is_unknown_is_absent() {
        assert_eq!(written(f64::NAN, None), "{}");
        assert_eq!(written(1.0, f64::INFINITY), r#"{"n":1}"#);
    }
}
