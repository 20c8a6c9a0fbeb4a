//! Standard output, whatever it is: a terminal of some width, a pipe, a file.

use super::CtlError;
use console::{Term, measure_text_width, truncate_str};
use std::io;

/// Columns of a terminal that does not tell.
const USUAL_WIDTH: u16 = 80;

/// Standard output. Dropping it shows the cursor again.
#[derive(Debug)]
pub struct Terminal {
    out: Term,
    is_live: bool,
    unicode: bool,
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

    /// Whether lines can be rewritten in place.
    pub fn is_live(&self) -> bool {
        self.is_live
    }

    /// Whether there are more characters than those of ASCII.
    pub fn unicode(&self) -> bool {
        self.unicode
    }

    /// Columns.
    pub fn width(&self) -> usize {
        let columns = self.out.size_checked().map(|(_, columns)| columns).filter(|columns| *columns > 0);
        usize::from(columns.unwrap_or(USUAL_WIDTH))
    }

    /// Writes these lines over the last ones drawn, cut to the width of the terminal.
    pub fn draw(&mut self, lines: &[String]) -> Result<(), CtlError> {
        let width = self.width();
        // A terminal that has become narrower since has wrapped them.
        let rows = self.drawn.iter().map(|columns| columns.div_ceil(width).max(1)).sum();
        self.drawn = lines.iter().map(|line| measure_text_width(line).min(width)).collect();
        self.paint(rows, lines, width).map_err(CtlError::Output)
    }

    fn paint(&self, rows: usize, lines: &[String], width: usize) -> io::Result<()> {
        self.out.hide_cursor()?;
        self.out.move_cursor_up(rows)?;
        self.out.clear_to_end_of_screen()?;
        for line in lines {
            self.out.write_line(&self.cut(line, width))?;
        }
        self.out.flush()
    }

    /// Writes a line that stays. On anything but a terminal it is not cut.
    pub fn say(&mut self, line: &str) -> Result<(), CtlError> {
        self.drawn.clear();
        let width = if self.is_live { self.width() } else { usize::MAX };
        let said = self.out.write_line(&self.cut(line, width)).and_then(|()| self.out.flush());
        said.map_err(CtlError::Output)
    }

    /// With a mark where something was cut off: half a number is another number.
    fn cut(&self, line: &str, width: usize) -> String {
        truncate_str(line, width, if self.unicode { "…" } else { ">" }).into_owned()
    }
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
