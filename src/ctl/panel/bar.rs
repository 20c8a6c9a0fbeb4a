//! How full something is: bars, sparklines, and what their ends stand for.

/// What a bar is empty and full at.
#[derive(Debug, Clone, PartialEq)]
pub struct Ends {
    /// In words; an empty one is 0.
    pub ends: [String; 2],
}

impl Ends {
    pub fn in_words(&self) -> String {
        let [from, to] = &self.ends;
        format!("{} to {to}", if from.is_empty() { "0" } else { from })
    }
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
