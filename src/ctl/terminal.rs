//! Standard output, whatever it is: a terminal of some width, a pipe, a file.
//!
//! For: lines that are rewritten in place, never wrapped, coloured only where that is wanted. Must not know: what they
//! say.

use super::CtlError;
use std::io::{self, IsTerminal, Write};

/// The width of what is not a terminal, and of a terminal that does not tell.
const USUAL_WIDTH: usize = 80;
const HIDE_CURSOR: &str = "\x1b[?25l";
const SHOW_CURSOR: &str = "\x1b[?25h";
const CLEAR_TO_END_OF_LINE: &str = "\x1b[K";

/// How a piece of text looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    Plain,
    Bold,
    Dim,
    Good,
    Notable,
    Bad,
    Bar,
}

impl Style {
    /// Select Graphic Rendition (ECMA-48): only the eight basic colours, which every theme makes legible.
    fn code(self) -> &'static str {
        match self {
            Style::Plain => "",
            Style::Bold => "\x1b[1m",
            Style::Dim => "\x1b[2m",
            Style::Good => "\x1b[32m",
            Style::Notable => "\x1b[33m",
            Style::Bad => "\x1b[31m",
            Style::Bar => "\x1b[36m",
        }
    }
}

/// Text in pieces, one line of it.
#[derive(Debug, Clone, Default)]
pub struct Line(Vec<(Style, String)>);

impl Line {
    /// With one more piece.
    pub fn add(mut self, style: Style, text: impl Into<String>) -> Line {
        self.0.push((style, text.into()));
        self
    }

    /// With all of another one.
    pub fn join(mut self, other: Line) -> Line {
        self.0.extend(other.0);
        self
    }

    /// Without its style.
    #[cfg(test)]
    pub fn text(&self) -> String {
        self.render(usize::MAX, false, '>')
    }

    fn length(&self) -> usize {
        self.0.iter().map(|(_, text)| text.chars().count()).sum()
    }

    /// Cut to `width` characters, the last of which is `cut` then: half a number is another number. Every character is one
    /// column wide.
    fn render(&self, width: usize, colours: bool, cut: char) -> String {
        let mut out = String::new();
        let is_cut = self.length() > width;
        let mut left = if is_cut { width.saturating_sub(1) } else { width };
        for (style, text) in &self.0 {
            let piece: String = text.chars().take(left).collect();
            left -= piece.chars().count();
            let code = if colours { style.code() } else { "" };
            let reset = if code.is_empty() { "" } else { "\x1b[0m" };
            out.extend([code, &piece, reset]);
        }
        if is_cut && width > 0 {
            out.push(cut);
        }
        out
    }
}

/// Standard output. Dropping it shows the cursor again.
#[derive(Debug)]
pub struct Terminal {
    is_live: bool,
    colours: bool,
    unicode: bool,
    /// The lengths of the lines that the next [`draw`](Terminal::draw) writes over, in characters.
    drawn: Vec<usize>,
}

impl Terminal {
    /// As it is now.
    pub fn new() -> Terminal {
        let is_live = io::stdout().is_terminal() && variable("TERM").as_deref() != Some("dumb");
        // https://no-color.org: any value but an empty one.
        Terminal {
            is_live,
            colours: is_live && variable("NO_COLOR").is_none(),
            unicode: speaks_utf8(),
            drawn: Vec::new(),
        }
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
        match terminal_size::terminal_size_of(io::stdout()) {
            Some((terminal_size::Width(columns), _)) if columns > 0 => usize::from(columns),
            _ => USUAL_WIDTH,
        }
    }

    /// Writes these lines over the last ones drawn.
    pub fn draw(&mut self, lines: &[Line]) -> Result<(), CtlError> {
        let mut text = String::from(HIDE_CURSOR);
        let width = self.width();
        // A terminal that has become narrower since has wrapped them.
        let rows: usize = self.drawn.iter().map(|length| length.div_ceil(width).max(1)).sum();
        if rows > 0 {
            text += &format!("\x1b[{rows}A");
        }
        for line in lines {
            text += &format!("\r{}{CLEAR_TO_END_OF_LINE}\n", self.render(line, width));
        }
        // What is left of a longer drawing.
        text += "\x1b[J";
        self.drawn = lines.iter().map(|line| line.length().min(width)).collect();
        write(&text)
    }

    /// Writes a line that stays. On anything but a terminal it is not cut.
    pub fn say(&mut self, line: &Line) -> Result<(), CtlError> {
        self.drawn.clear();
        let width = if self.is_live { self.width() } else { usize::MAX };
        write(&(self.render(line, width) + "\n"))
    }

    fn render(&self, line: &Line, width: usize) -> String {
        line.render(width, self.colours, if self.unicode { '…' } else { '>' })
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if self.is_live {
            // If that fails, there is no cursor to be shown either.
            let _ = write(SHOW_CURSOR);
        }
    }
}

fn write(text: &str) -> Result<(), CtlError> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(CtlError::Output)
}

fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

/// The locale (locale(7): the first of these that is set counts); where nothing is said, as in containers, UTF-8.
fn speaks_utf8() -> bool {
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(variable);
    let says_so = |locale: &str| locale.to_lowercase().replace('-', "").contains("utf8");
    variable("TERM").as_deref() != Some("linux") && locale.is_none_or(|locale| says_so(&locale))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_by_characters_and_not_by_codes() {
        let line = Line::default().add(Style::Bold, "a±b").add(Style::Plain, "cd").add(Style::Bad, "e");
        assert_eq!(line.render(80, false, '…'), "a±bcde");
        assert_eq!(line.render(6, false, '…'), "a±bcde");
        assert_eq!(line.render(4, false, '…'), "a±b…");
        assert_eq!(line.render(2, true, '>'), "\x1b[1ma\x1b[0m\x1b[31m\x1b[0m>");
        assert_eq!(line.render(1, false, '>'), ">");
        assert_eq!(line.render(0, false, '>'), "");
    }
}
