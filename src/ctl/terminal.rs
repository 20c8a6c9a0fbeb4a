//! Standard output, whatever it is: a terminal of some width, a pipe, a file.

use super::CtlError;
use console::{Term, measure_text_width, truncate_str};
use std::io;

/// Of a terminal that does not tell.
const USUAL_WIDTH: u16 = 80;
const USUAL_HEIGHT: u16 = 24;
/// DECAWM, reset and set: whether a line goes on on the next row.
const WRAP_OFF: &str = "\x1b[?7l";
const WRAP_ON: &str = "\x1b[?7h";

/// Standard output. Dropping it shows the cursor again.
#[derive(Debug)]
pub struct Terminal {
    out: Term,
    /// Whether lines can be rewritten in place.
    pub is_live: bool,
    /// Whether there are more characters than those of ASCII.
    pub unicode: bool,
    /// Columns of each line that the next [`draw`](Terminal::draw) writes over.
    drawn: Vec<usize>,
}

impl Terminal {
    /// As it is now.
    pub fn new() -> Terminal {
        let out = Term::buffered_stdout();
        let is_live = out.is_term() && !console::is_dumb();
        Terminal { out, is_live, unicode: speaks_utf8(), drawn: Vec::new() }
    }

    /// Columns and rows: of the environment (`COLUMNS`, as for other programs), of the terminal, or what is usual.
    pub fn size(&self) -> (usize, usize) {
        let (rows, columns) = self.out.size_checked().unwrap_or((USUAL_HEIGHT, USUAL_WIDTH));
        let at_least_one = |size: u16, usual: u16| usize::from(if size > 0 { size } else { usual });
        (columns_wanted().unwrap_or(at_least_one(columns, USUAL_WIDTH)), at_least_one(rows, USUAL_HEIGHT))
    }

    /// Writes these lines over the last ones drawn, cut to the size of the terminal.
    pub fn draw(&mut self, lines: &[String]) -> Result<(), CtlError> {
        let (width, height) = self.size();
        let lines = self.fitting(lines, height);
        // A terminal that has become narrower since has wrapped them.
        let rows = self.drawn.iter().map(|columns| columns.div_ceil(width).max(1)).sum();
        self.drawn = lines.iter().map(|line| measure_text_width(line).min(width)).collect();
        self.paint(rows, &lines, width).map_err(CtlError::Output)
    }

    /// No more than there is room for above the cursor: what has scrolled away cannot be written over.
    fn fitting(&self, lines: &[String], height: usize) -> Vec<String> {
        let room = height.saturating_sub(1).max(1);
        if lines.len() <= room {
            return lines.to_vec();
        }
        let more = format!(" and {} lines more: they need a taller window", lines.len() + 1 - room);
        lines[..room - 1].iter().cloned().chain([more]).collect()
    }

    fn paint(&self, rows: usize, lines: &[String], width: usize) -> io::Result<()> {
        self.out.hide_cursor()?;
        self.out.move_cursor_up(rows)?;
        self.out.clear_to_end_of_screen()?;
        // Terminals do not agree on how wide an emoji is: what one takes for too long must not become two rows.
        self.out.write_str(WRAP_OFF)?;
        for line in lines {
            self.out.write_line(&cut(line, width, self.unicode))?;
        }
        self.out.write_str(WRAP_ON)?;
        self.out.flush()
    }

    /// Writes a line that stays, on as many rows as its words need.
    pub fn say(&mut self, line: &str) -> Result<(), CtlError> {
        self.drawn.clear();
        let width = if self.out.is_term() { Some(self.size().0) } else { columns_wanted() };
        let text = width.map_or_else(|| line.to_owned(), |width| wrapped(line, width));
        self.out.write_line(&text).and_then(|()| self.out.flush()).map_err(CtlError::Output)
    }
}

/// With a mark where something was cut off: half a number is another number.
pub fn cut(line: &str, width: usize, unicode: bool) -> String {
    truncate_str(line, width, if unicode { "…" } else { ">" }).into_owned()
}

/// Between words; what goes on is indented by more than the line begins with.
pub fn wrapped(line: &str, width: usize) -> String {
    let leading = line.len() - line.trim_start_matches(' ').len();
    let indent = " ".repeat((leading + 4).min(width / 4));
    let options = textwrap::Options::new(width)
        .word_splitter(textwrap::WordSplitter::NoHyphenation)
        .subsequent_indent(&indent);
    textwrap::fill(&glued(line), options).replace(GLUE, " ")
}

/// A blank at which no line ends.
const GLUE: char = '\u{a0}';

/// A number with its uncertainty and its unit in one piece.
fn glued(line: &str) -> String {
    let is_sign = |text: &str| text.starts_with('±') || text.starts_with("+-");
    let holds = |(at, _): (usize, &str)| {
        let (before, after) = (&line[..at], &line[at + 1..]);
        let counts = before.ends_with(|c: char| c.is_ascii_digit())
            && (is_sign(after) || after.starts_with(|c: char| c.is_alphabetic() || c == '%'));
        counts || before.ends_with('±') || before.ends_with("+-")
    };
    let mut glued = line.to_owned();
    for (at, blank) in line.rmatch_indices(' ').filter(|blank| holds(*blank)) {
        glued.replace_range(at..at + blank.len(), &GLUE.to_string());
    }
    glued
}

/// What the user wants in the place of what the terminal says.
fn columns_wanted() -> Option<usize> {
    std::env::var("COLUMNS").ok()?.parse().ok().filter(|columns| *columns > 0)
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if self.is_live {
            // If that fails, there is no cursor to be shown either.
            let _ = self.out.show_cursor().and_then(|()| self.out.flush());
        }
    }
}

/// The locale (locale(7): the first of these that is set counts); where nothing is said, as in containers, UTF-8.
fn speaks_utf8() -> bool {
    let variable = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(variable);
    let says_so = |locale: &str| locale.to_lowercase().replace('-', "").contains("utf8");
    variable("TERM").as_deref() != Some("linux") && locale.is_none_or(|locale| says_so(&locale))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_is_drawn_that_would_scroll_away() {
        let terminal = Terminal::new();
        let lines: Vec<String> = (0..9).map(|line| line.to_string()).collect();
        assert_eq!(terminal.fitting(&lines, 10), lines);
        assert_eq!(terminal.fitting(&lines, 9)[6..], ["6", " and 2 lines more: they need a taller window"]);
        assert_eq!(terminal.fitting(&lines, 0).len(), 1);
    }

    #[test]
    fn words_stay_whole() {
        assert_eq!(wrapped("  info: a b-c d", 12), "  info: a\n   b-c d");
        assert_eq!(wrapped("short", 12), "short");
        assert_eq!(wrapped("it is 9.5 ± 0.5 kohm", 18), "it is\n    9.5 ± 0.5 kohm");
    }
}
