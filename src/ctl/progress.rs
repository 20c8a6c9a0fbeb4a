//! How far something is: one line on standard error that is rewritten, and nothing where that is no terminal.

use super::limits::REDRAW_AFTER;
use super::terminal::cut;
use console::Term;
use std::time::Instant;

/// The line. Dropping it takes it away.
pub struct Progress {
    term: Term,
    drawn: Option<Instant>,
}

impl Progress {
    /// Nothing yet.
    pub fn new() -> Progress {
        Progress { term: Term::stderr(), drawn: None }
    }

    /// So far.
    pub fn show(&mut self, text: impl FnOnce() -> String) {
        if !self.term.is_term() || self.drawn.is_some_and(|drawn| drawn.elapsed() < REDRAW_AFTER) {
            return;
        }
        self.drawn = Some(Instant::now());
        let width = usize::from(self.term.size().1).saturating_sub(1);
        // Progress that cannot be shown is none.
        let _ = self.term.clear_line().and_then(|()| self.term.write_str(&cut(&text(), width, false)));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.drawn.is_some() {
            let _ = self.term.clear_line();
        }
    }
}
