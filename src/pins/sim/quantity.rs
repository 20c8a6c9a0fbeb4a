//! Quantities in scene files: "2.2 uF", "40 ohm", "1.3 V".
//!
//! For: reading a number with an SI prefix and its unit. Must not know: what the quantity is used for.

use serde::{Deserialize, Deserializer, de};

const PREFIXES: [(&str, &str); 8] = [
    ("p", "e-12"),
    ("n", "e-9"),
    ("u", "e-6"),
    ("\u{b5}", "e-6"),
    ("m", "e-3"),
    ("", ""),
    ("k", "e3"),
    ("M", "e6"),
];

/// The value in the SI unit, or `None` if the text is not a number, a prefix and `unit`.
fn parse(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim().strip_suffix(unit)?;
    PREFIXES.iter().find_map(|(prefix, power)| {
        let number = text.strip_suffix(prefix)?.trim();
        // Parsed as one text, so that "2.2 uF" is the nearest number to 2.2e-6.
        format!("{number}{power}").parse::<f64>().ok().filter(|value| value.is_finite())
    })
}

macro_rules! quantity {
    ($($(#[$doc:meta])* $name:ident, $unit:literal, $example:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let text = String::deserialize(deserializer)?;
                parse(&text, $unit).map($name).ok_or_else(|| {
                    de::Error::custom(format!("\"{text}\" is not a quantity in {}; write it like \"{}\"", $unit, $example))
                })
            }
        }
    )*};
}

quantity! {
    /// Resistance in ohm.
    Ohm, "ohm", "2.32 kohm";
    /// Capacitance in farad.
    Farad, "F", "2.2 uF";
    /// Voltage in volt.
    Volt, "V", "1.3 V";
    /// Current in ampere.
    Ampere, "A", "5 uA";
    /// Duration in seconds.
    Seconds, "s", "8 us";
    /// Frequency in hertz.
    Hertz, "Hz", "50 MHz";
    /// Force in newton.
    Newton, "N", "8 N";
    /// The constant of F = alpha/R, newton ohm.
    NewtonOhm, "N ohm", "13346.46 N ohm";
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn reads_prefixes_and_refuses_other_units() {
        assert_eq!(parse("2.2 uF", "F"), Some(2.2e-6));
        assert_eq!(parse("680nF", "F"), Some(680e-9));
        assert_eq!(parse("2.32 kohm", "ohm"), Some(2320.0));
        assert_eq!(parse("-5 mV", "V"), Some(-5e-3));
        assert_eq!(parse("1 Mohm", "ohm"), Some(1e6));
        assert_eq!(parse("1 H", "F"), None);
        assert_eq!(parse("F", "F"), None);
        assert_eq!(parse("inf F", "F"), None);
    }
}
