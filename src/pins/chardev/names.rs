//! For: finding a line by name or offset. Must not know: what the line is used for.

use super::chips::LineListing;
use super::error::OpenError;

/// How many similar names an unknown one is answered with.
const SUGGESTIONS: usize = 3;

/// The offset of a line given by name or number on the chip called `chip`.
///
/// # Errors
/// [`OpenError::NoLine`] with the most similar names, or with the range of offsets.
pub(super) fn line_offset(lines: &[LineListing], wanted: &str, chip: &str) -> Result<u32, OpenError> {
    let refuse = |nearest: String| {
        Err(OpenError::NoLine { chip: chip.to_string(), wanted: wanted.to_string(), nearest })
    };
    let named: Vec<u32> =
        lines.iter().filter(|line| line.name.as_deref() == Some(wanted)).map(|line| line.offset).collect();
    match (named.as_slice(), wanted.parse::<u32>()) {
        ([offset], _) => Ok(*offset),
        ([], Ok(offset)) if (offset as usize) < lines.len() => Ok(offset),
        ([], Ok(_)) => refuse(format!("its offsets go from 0 to {}", lines.len().saturating_sub(1))),
        ([], Err(_)) => refuse(nearest_names(lines, wanted)),
        (several, _) => refuse(format!("several lines have this name: give the offset, one of {several:?}")),
    }
}

fn nearest_names(lines: &[LineListing], wanted: &str) -> String {
    let mut names: Vec<&str> = lines.iter().filter_map(|line| line.name.as_deref()).collect();
    if names.is_empty() {
        return format!(
            "its lines have no names: give an offset from 0 to {}",
            lines.len().saturating_sub(1)
        );
    }
    names.sort_by_key(|name| edit_distance(name, wanted));
    names.truncate(SUGGESTIONS);
    format!("did you mean {}?", names.join(", "))
}

/// How many characters have to be changed, inserted or left out (Levenshtein), case apart.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let change = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = change.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Vec<LineListing> {
        (0..28)
            .map(|offset| LineListing { offset, name: Some(format!("GPIO{offset}")), ..Default::default() })
            .collect()
    }

    #[test]
    fn lines_are_found_by_name_and_by_offset() {
        assert_eq!(line_offset(&header(), "GPIO17", "chip").unwrap(), 17);
        assert_eq!(line_offset(&header(), "17", "chip").unwrap(), 17);
        let mut odd = header();
        odd[3].name = Some("17".to_string());
        assert_eq!(line_offset(&odd, "17", "chip").unwrap(), 3, "a name comes before an offset");
    }

    #[test]
    fn an_unknown_line_is_answered_with_the_nearest_names() {
        let message = line_offset(&header(), "gpio71", "gpiochip0 [pinctrl-rp1]").unwrap_err().to_string();
        assert!(
            message.starts_with("chip gpiochip0 [pinctrl-rp1] has no line \"gpio71\"; did you mean GPIO1,"),
            "{message}"
        );
        let message = line_offset(&header(), "28", "chip").unwrap_err().to_string();
        assert!(message.contains("from 0 to 27"), "{message}");
        let bare = vec![LineListing::default(); 4];
        let message = line_offset(&bare, "GPIO1", "chip").unwrap_err().to_string();
        assert!(message.contains("no names: give an offset from 0 to 3"), "{message}");
    }

    #[test]
    fn a_name_that_two_lines_have_is_refused() {
        let mut twice = header();
        twice[4].name = Some("GPIO9".to_string());
        let message = line_offset(&twice, "GPIO9", "chip").unwrap_err().to_string();
        assert!(message.contains("one of [4, 9]"), "{message}");
    }

    #[test]
    fn edit_distance_counts_changes() {
        assert_eq!(edit_distance("GPIO17", "gpio17"), 0);
        assert_eq!(edit_distance("GPIO17", "GPIO7"), 1);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
    }
}
