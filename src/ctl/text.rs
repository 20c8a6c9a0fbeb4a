//! Numbers as people read them: values with their uncertainties and units, bars, and sparklines.

/// With its 1-sigma uncertainty: two digits of the uncertainty (GUM 7.2.6), the value to the same place.
pub fn measured(value: f64, u: Option<f64>, unit: &str, unicode: bool) -> String {
    let (scale, prefix) = prefix(value);
    let value = value / scale;
    let Some(u) = u.map(|u| u / scale).filter(|u| *u > 0.0) else {
        return format!("{value:.*} {prefix}{unit}", places(value, 4));
    };
    let places = places(u, 2);
    let sign = if unicode { "±" } else { "+-" };
    format!("{value:.places$} {sign} {u:.places$} {prefix}{unit}")
}

/// To three digits.
pub fn rough(value: f64, unit: &str) -> String {
    let (scale, prefix) = prefix(value);
    let value = value / scale;
    format!("{value:.*} {prefix}{unit}", places(value, 3))
}

/// A prefix only from five digits before the point on: 2841 ohm, but 284.1 kohm.
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

/// A bar of `width` columns, filled to a share of 0 to 1, to an eighth of a column: what is full, and what is empty.
pub fn bar(share: f64, width: usize, unicode: bool) -> (String, String) {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let share = share.clamp(0.0, 1.0);
    let eighths = (share * width as f64 * 8.0).round() as usize;
    let (full, part) = if unicode { (eighths / 8, EIGHTHS[eighths % 8]) } else { ((eighths + 4) / 8, "") };
    let filled = if unicode { "█" } else { "#" }.repeat(full) + part;
    let empty = if unicode { "·" } else { "." }.repeat(width.saturating_sub(filled.chars().count()));
    (filled, empty)
}

/// One column for each share of 0 to 1; `None`: a blank.
pub fn sparkline(shares: impl Iterator<Item = Option<f64>>, unicode: bool) -> String {
    const LEVELS: [[char; 8]; 2] =
        [['_', '.', '-', '-', '=', '=', '#', '#'], ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█']];
    let level = |share: f64| LEVELS[usize::from(unicode)][(share.clamp(0.0, 1.0) * 7.0).round() as usize];
    shares.map(|share| share.map_or(' ', level)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uncertainty_decides_the_digits() {
        assert_eq!(measured(2841.349, Some(1.249), "ohm", true), "2841.3 ± 1.2 ohm");
        assert_eq!(measured(4.69712, Some(0.00199), "N", false), "4.6971 +- 0.0020 N");
        assert_eq!(measured(284_134.0, Some(312.0), "ohm", false), "284.13 +- 0.31 kohm");
        assert_eq!(measured(99.98, Some(0.0999), "ohm", false), "99.98 +- 0.10 ohm");
        assert_eq!(measured(2841.349, None, "ohm", false), "2841 ohm");
        assert_eq!(measured(16_200.0, Some(123.0), "ohm", false), "16200 +- 123 ohm");
        assert_eq!(rough(1_912_345.0, "ohm"), "1.91 Mohm");
        assert_eq!(rough(0.006_979, "N"), "0.00698 N");
        assert_eq!(rough(0.0, "N"), "0.00 N");
    }

    #[test]
    fn bars_keep_their_width() {
        for unicode in [true, false] {
            for share in 0..=100 {
                let (full, empty) = bar(f64::from(share) / 100.0, 9, unicode);
                assert_eq!(full.chars().count() + empty.chars().count(), 9);
            }
        }
        assert_eq!(bar(0.5, 3, true), ("█▌".to_owned(), "·".to_owned()));
        assert_eq!(bar(2.0, 3, false), ("###".to_owned(), String::new()));
        assert_eq!(sparkline([Some(0.0), None, Some(1.0)].into_iter(), true), "▁ █");
    }
}
