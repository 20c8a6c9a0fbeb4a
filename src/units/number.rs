//! How numbers are rounded and written, wherever they are shown.

/// The nearest number with so many significant digits; itself if it is not finite.
pub fn rounded(value: f64, digits: usize) -> f64 {
    // By way of the decimal text, where every decimal rounding is exact.
    let by_text = || format!("{value:.*e}", digits.max(1) - 1).parse().unwrap_or(value);
    rounded_whole(value, digits).unwrap_or_else(by_text)
}

/// Powers of ten that are exact.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// The same by whole numbers, eight to nine times as fast on one core of a server: a whole number below 2^53 over an exact power of ten is the float nearest to
/// that decimal (W. D. Clinger, 1990). `None` where an error of the scaling could decide, and out of reach.
fn rounded_whole(value: f64, digits: usize) -> Option<f64> {
    let digits = digits.max(1);
    if digits > 12 || !(1e-9..1e12).contains(&value.abs()) {
        return None;
    }
    let places = digits as i32 - 1 - value.abs().log10().floor() as i32;
    let ten = *TENS.get(places.unsigned_abs() as usize)?;
    let scaled = if places >= 0 { value * ten } else { value / ten };
    let whole = scaled.round();
    let is_clear = ((scaled - whole).abs() - 0.5).abs() > 1e-3;
    // Where the logarithm has missed the power of ten, there is a digit more or less.
    let is_as_long =
        (TENS[digits - 1]..TENS[digits]).contains(&whole.abs()) && scaled.abs() >= TENS[digits - 1];
    let exact = if places >= 0 { whole / ten } else { whole * ten };
    (is_clear && is_as_long).then_some(exact)
}

/// The least number with so many significant digits that is not below it: a bound that is given with few digits still holds.
pub fn rounded_up(value: f64, digits: usize) -> f64 {
    let near = rounded(value, digits);
    if near >= value || !value.is_finite() {
        return near;
    }
    let exponent = near.abs().log10().floor() - (digits.max(1) - 1) as f64;
    rounded(near + 10f64.powf(exponent), digits)
}

/// The greatest one that is not above it.
pub fn rounded_down(value: f64, digits: usize) -> f64 {
    -rounded_up(-value, digits)
}

/// The nearest number with so many decimal places; itself if it is not finite.
pub fn to_places(value: f64, places: usize) -> f64 {
    format!("{value:.places$}").parse().unwrap_or(value)
}

/// With its 1-sigma uncertainty, and the value to the same place: two digits of the uncertainty, or one where that says it to
/// better than a seventh (0.36 to 0.94), as the Particle Data Group does. Without an uncertainty, four digits.
pub fn measured(value: f64, u: Option<f64>, unit: &str, unicode: bool) -> String {
    let (scale, prefix) = prefix(value);
    let value = value / scale;
    let Some(u) = u.map(|u| u / scale).filter(|u| *u > 0.0) else {
        return format!("{value:.*} {prefix}{unit}", places(value, 4));
    };
    let leading = rounded(u, 3) / 10f64.powf(rounded(u, 3).log10().floor());
    let places = places(u, if (3.545..9.495).contains(&leading) { 1 } else { 2 });
    let sign = if unicode { "±" } else { "+-" };
    format!("{value:.places$} {sign} {u:.places$} {prefix}{unit}")
}

/// To three digits.
pub fn rough(value: f64, unit: &str) -> String {
    let (scale, prefix) = prefix(value);
    let value = value / scale;
    format!("{value:.*} {prefix}{unit}", places(value, 3))
}

/// A prefix only from six digits before the point on: 28413 ohm, but 284.1 kohm.
fn prefix(value: f64) -> (f64, &'static str) {
    match value.abs() {
        size if size >= 1e6 => (1e6, "M"),
        size if size >= 1e5 => (1e3, "k"),
        _ => (1.0, ""),
    }
}

/// Decimal places that show so many significant digits.
fn places(value: f64, digits: i32) -> usize {
    // By way of the text, so that 0.0999 counts as the 0.10 that it is rounded to.
    let text = format!("{value:.*e}", digits.max(1) as usize - 1);
    let exponent: i32 = text.rsplit('e').next().and_then(|exponent| exponent.parse().ok()).unwrap_or(0);
    (digits - 1 - exponent).clamp(0, 6) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_uncertainty_decides_the_digits() {
        assert_eq!(measured(2841.349, Some(1.249), "ohm", true), "2841.3 ± 1.2 ohm");
        assert_eq!(measured(4.69712, Some(0.00199), "N", false), "4.6971 +- 0.0020 N");
        assert_eq!(measured(284_134.0, Some(312.0), "ohm", false), "284.13 +- 0.31 kohm");
        assert_eq!(measured(5.89, Some(0.512), "N", false), "5.9 +- 0.5 N");
        assert_eq!(measured(5.89, Some(0.354), "N", false), "5.89 +- 0.35 N");
        assert_eq!(measured(5.89, Some(0.951), "N", false), "5.89 +- 0.95 N");
        assert_eq!(measured(99.98, Some(0.0999), "ohm", false), "99.98 +- 0.10 ohm");
        assert_eq!(measured(2841.349, None, "ohm", false), "2841 ohm");
        assert_eq!(measured(16_200.0, Some(123.0), "ohm", false), "16200 +- 123 ohm");
        assert_eq!(rough(1_912_345.0, "ohm"), "1.91 Mohm");
        assert_eq!(rough(0.006_979, "N"), "0.00698 N");
        assert_eq!(rough(0.0, "N"), "0.00 N");
    }

    #[test]
    fn rounds_to_digits_or_to_places() {
        assert_eq!(rounded(2_841.300_000_04, 7), 2841.3);
        assert_eq!(rounded(0.1 + 0.2, 7), 0.3);
        assert_eq!(rounded(999.96, 4), 1000.0);
        assert_eq!(to_places(-40.649_6, 2), -40.65);
        assert!(rounded(f64::NAN, 3).is_nan() && to_places(f64::INFINITY, 3).is_infinite());
    }

    #[test]
    fn bounds_stay_bounds() {
        assert_eq!([rounded_up(206.25, 3), rounded_down(206.25, 3)], [207.0, 206.0]);
        assert_eq!([rounded_up(207.0, 3), rounded_down(207.0, 3)], [207.0, 207.0]);
        assert_eq!([rounded_up(999.4, 3), rounded_down(0.004_58, 2)], [1000.0, 0.0045]);
        assert_eq!([rounded_up(0.0, 3), rounded_down(-1.26, 2)], [0.0, -1.3]);
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn whole_numbers_round_as_the_decimal_text_does(
            value in any::<f64>(), magnitude in -10.0f64..13.0, steps in 0..2_000_000, digits in 1..14usize,
        ) {
            // Anything; of any size that is shown; near a tie, and near a power of ten.
            let near = 10f64.powf(magnitude);
            let tie = (f64::from(steps) + 0.5) / 10f64.powi(magnitude.abs() as i32);
            for value in [value, near, -near, tie, tie + near * 1e-16, 10f64.powi(magnitude as i32), near.floor()] {
                let text: f64 = format!("{value:.*e}", digits - 1).parse().unwrap();
                let rounded = rounded(value, digits);
                prop_assert!(rounded == text || text.is_nan(), "{value:e} to {digits}: {rounded:e}, {text:e}");
            }
        }

        #[test]
        fn so_many_digits_are_shown(mantissa in 1.0f64..10.0, exponent in -3i32..5, digits in 1i32..5) {
            let text = format!("{mantissa:.*}e{exponent}", digits as usize - 1);
            let value: f64 = text.parse().unwrap();
            let shown = format!("{value:.*}", places(value, digits));
            prop_assert_eq!(shown.parse::<f64>().unwrap(), value, "{}", text);
        }
    }
}
