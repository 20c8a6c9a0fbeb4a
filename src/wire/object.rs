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
        let _ = write!(self.out, "{}", value.into());
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
        let _ = write!(self.out, "{}", rounded(value, digits));
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
        self.separate();
        write_json_string(self.out, key);
        self.out.push(b':');
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

/// Rounded to `digits` significant decimal digits.
///
/// By way of the decimal text: only there is a decimal rounding exact, so that printing the result again
/// gives those digits and no tail like ...0000001.
fn rounded(value: f64, digits: usize) -> f64 {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    text.parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

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
