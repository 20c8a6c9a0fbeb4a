//! The writer of a line.
//!
//! For: JSON that cannot hold null, NaN or infinity. Must not know: what the fields mean.

use std::io::Write;

/// Writes one JSON object into a buffer, field by field, in the order of the calls.
///
/// Writing to a `Vec` cannot fail, hence no method returns an error.
pub struct Object<'a> {
    out: &'a mut Vec<u8>,
}

impl<'a> Object<'a> {
    /// Begins a line: `{"class":"CLASS"`.
    pub fn line(out: &'a mut Vec<u8>, class: &str) -> Object<'a> {
        out.push(b'{');
        let mut object = Object { out };
        object.text("class", class);
        object
    }

    /// A string.
    pub fn text(&mut self, key: &str, value: &str) {
        self.key(key);
        write_json_string(self.out, value);
    }

    /// A boolean.
    pub fn flag(&mut self, key: &str, value: bool) {
        self.key(key);
        self.out.extend_from_slice(if value { b"true" } else { b"false" });
    }

    /// A whole number.
    pub fn integer(&mut self, key: &str, value: impl Into<i128>) {
        self.key(key);
        let value = value.into();
        // Nearly all are, and 128 bits are slow to write.
        let _ = match i64::try_from(value) {
            Ok(value) => write!(self.out, "{value}"),
            Err(_) => write!(self.out, "{value}"),
        };
    }

    /// A number with `digits` significant digits, trailing zeros left out. Unknown (`None`): no field.
    ///
    /// A value that is not finite is a fault of the caller: it is left out, and a debug build stops there.
    pub fn number(&mut self, key: &str, value: impl Into<Option<f64>>, digits: usize) {
        let Some(value) = value.into() else { return };
        debug_assert!(value.is_finite(), "{key} is {value}");
        if !value.is_finite() {
            return;
        }
        self.key(key);
        write_rounded(self.out, value, digits);
    }

    /// A nested object.
    pub fn object(&mut self, key: &str, fields: impl FnOnce(&mut Object<'_>)) {
        self.key(key);
        self.braces(fields);
    }

    /// A list of objects, one for each item.
    pub fn list<T>(
        &mut self,
        key: &str,
        items: impl IntoIterator<Item = T>,
        mut fields: impl FnMut(&mut Object<'_>, T),
    ) {
        self.key(key);
        self.out.push(b'[');
        for item in items {
            self.separate();
            self.braces(|object| fields(object, item));
        }
        self.out.push(b']');
    }

    /// A list of strings.
    pub fn texts<'t>(&mut self, key: &str, items: impl IntoIterator<Item = &'t str>) {
        self.key(key);
        self.out.push(b'[');
        for item in items {
            self.separate();
            write_json_string(self.out, item);
        }
        self.out.push(b']');
    }

    /// Ends the line: `}` and a newline.
    pub fn end(self) {
        self.out.extend_from_slice(b"}\n");
    }

    fn braces(&mut self, fields: impl FnOnce(&mut Object<'_>)) {
        self.out.push(b'{');
        fields(&mut Object { out: self.out });
        self.out.push(b'}');
    }

    fn key(&mut self, key: &str) {
        debug_assert!(
            key.bytes().all(|byte| byte.is_ascii_lowercase() || b"-_0123456789".contains(&byte)),
            "{key}"
        );
        self.separate();
        self.out.push(b'"');
        self.out.extend_from_slice(key.as_bytes());
        self.out.extend_from_slice(b"\":");
    }

    fn separate(&mut self) {
        if !matches!(self.out.last(), Some(b'{' | b'[')) {
            self.out.push(b',');
        }
    }
}

fn write_json_string(out: &mut Vec<u8>, text: &str) {
    let _ = serde_json::to_writer(out, text);
}

/// Appends a finite number with at most `digits` significant digits, never with an exponent.
///
/// By way of the decimal text: only there is a decimal rounding exact.
fn write_rounded(out: &mut Vec<u8>, value: f64, digits: usize) {
    let text = format!("{:.*e}", digits.saturating_sub(1), value.abs());
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0') } else { mantissa };
    let digits = mantissa.bytes().filter(|byte| *byte != b'.');
    if value < 0.0 {
        out.push(b'-');
    }
    if exponent < 0 {
        out.extend_from_slice(b"0.");
        out.extend(std::iter::repeat_n(b'0', exponent.unsigned_abs() as usize - 1));
        out.extend(digits);
        return;
    }
    let whole = exponent as usize + 1;
    out.extend(digits.clone().chain(std::iter::repeat(b'0')).take(whole));
    if digits.clone().nth(whole).is_some() {
        out.push(b'.');
        out.extend(digits.skip(whole));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn number(value: f64, digits: usize) -> String {
        let mut out = Vec::new();
        let mut object = Object::line(&mut out, "X");
        object.number("n", value, digits);
        object.end();
        let text = String::from_utf8(out).unwrap();
        text.trim_end().strip_prefix(r#"{"class":"X","n":"#).unwrap().strip_suffix('}').unwrap().to_owned()
    }

    #[test]
    fn numbers_have_their_digits_and_no_noise() {
        assert_eq!(number(2_841.3, 7), "2841.3");
        assert_eq!(number(2_841.300_000_04, 7), "2841.3");
        assert_eq!(number(1.9e6, 7), "1900000");
        assert_eq!(number(1.204, 3), "1.2");
        assert_eq!(number(0.1 + 0.2, 7), "0.3");
        assert_eq!(number(123_456_789.0, 7), "123456800");
        assert_eq!(number(0.000_123_456, 3), "0.000123");
        assert_eq!(number(999.96, 4), "1000");
        assert_eq!(number(0.0, 7), "0");
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        /// As if it were rounded, read and printed again.
        #[test]
        fn a_number_is_the_one_that_rounding_gives(value in -1e12f64..1e12, scale in -30i32..30, digits in 1usize..12) {
            let value = value * 10f64.powi(scale);
            let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap();
            prop_assert_eq!(number(value, digits), format!("{rounded}"));
        }
    }

    #[test]
    fn unknown_is_absent() {
        let mut out = Vec::new();
        let mut object = Object::line(&mut out, "X");
        object.number("n", None, 3);
        object.end();
        assert_eq!(out, b"{\"class\":\"X\"}\n");
    }

    #[test]
    fn nesting_and_escapes_are_json() {
        let mut out = Vec::new();
        let mut object = Object::line(&mut out, "X");
        object.object("empty", |_| {});
        object.list("items", [1, 2], |item, n| {
            item.integer("n", n);
            item.flag("odd", n == 1);
        });
        object.texts("ids", ["a\"\n", "\u{1}ü"]);
        object.texts("none", []);
        object.integer("big", u64::MAX);
        object.end();
        assert_eq!(out.pop(), Some(b'\n'));
        assert!(!out.contains(&b'\n'), "a line has no newline inside");
        let value: serde_json::Value = serde_json::from_slice(&out).unwrap();
        let expected = serde_json::json!({"class": "X", "empty": {}, "items": [{"n": 1, "odd": true},
            {"n": 2, "odd": false}], "ids": ["a\"\n", "\u{1}ü"], "none": [], "big": u64::MAX});
        assert_eq!(value, expected);
    }
}
