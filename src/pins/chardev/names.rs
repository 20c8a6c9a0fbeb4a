//! A line of a chip by its name or offset.

use super::chips::LineListing;
use super::error::ChardevError;
use crate::pins::limits::SUGGESTIONS;

/// The offset of a line given by name or number on the chip called `chip`.
///
/// # Errors
/// [`ChardevError::Wiring`] with what could be asked for instead.
pub(super) fn line_offset(lines: &[LineListing], wanted: &str, chip: &str) -> Result<u32, ChardevError> {
    let named: Vec<u32> =
        lines.iter().filter(|line| line.name.as_deref() == Some(wanted)).map(|line| line.offset).collect();
    let instead = match (named.as_slice(), wanted.parse::<u32>()) {
        ([offset], _) => return Ok(*offset),
        ([], Ok(offset)) if (offset as usize) < lines.len() => return Ok(offset),
        ([], Ok(_)) => format!("its offsets go from 0 to {}", lines.len().saturating_sub(1)),
        ([], Err(_)) => similar_names(lines, wanted),
        (_, _) => format!("several lines have this name: give the offset, one of {named:?}"),
    };
    Err(ChardevError::Wiring(format!("chip {chip} has no line \"{wanted}\"; {instead}")))
}

/// The nearest by edit distance, letters of either case alike.
fn similar_names(lines: &[LineListing], wanted: &str) -> String {
    let mut names: Vec<String> = lines.iter().filter_map(|line| line.name.clone()).collect();
    if names.is_empty() {
        let last = lines.len().saturating_sub(1);
        return format!("its lines have no names: give an offset from 0 to {last}");
    }
    let wanted = wanted.to_lowercase();
    names.sort_by_key(|name| strsim::levenshtein(&name.to_lowercase(), &wanted));
    names.truncate(SUGGESTIONS);
    format!("did you mean {}?", names.join(", "))
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
}
