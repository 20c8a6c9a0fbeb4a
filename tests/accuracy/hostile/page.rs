//! `docs/coverage.md`, a part for each table of this test; `UPDATE_DOCS=1 cargo test --test accuracy hostile` writes it.

use super::{RARE, Seen, WIDE};
use crate::common::check_page;
use cermd::reading::Method;
use std::fmt::Write;
use std::sync::{Mutex, PoisonError};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/coverage.md");
/// Tests run side by side, and the page is one file.
static WRITER: Mutex<()> = Mutex::new(());

/// A table: a line for each board, with what each method makes of it.
#[derive(Debug, Default)]
pub struct Part {
    lines: Vec<(&'static str, [String; Method::ALL.len()])>,
}

impl Part {
    pub fn add(&mut self, name: &'static str, method: Method, r_ohm: f64, seen: &Seen, fails: bool) {
        if self.lines.last().is_none_or(|(last, _)| *last != name) {
            self.lines.push((name, Default::default()));
        }
        let cell = &mut self.lines.last_mut().expect("just added").1[method as usize];
        let share = (seen.numbers() >= RARE).then(|| seen.errors.within_2u());
        let within =
            share.map_or_else(|| "no number".to_owned(), |share| format!("{:.1}", 100.0 * share.value));
        let mark = match share {
            _ if fails && seen.says_so() => " (settling)",
            _ if fails => " ✘",
            Some(share) if share.value - share.margin > WIDE => " +",
            _ => "",
        };
        let separator = if cell.is_empty() { "" } else { "<br>" };
        write!(cell, "{separator}{r_ohm}: {within}{mark}").unwrap();
    }

    /// Held against the page below the heading `title`, or written there.
    pub fn check(&self, title: &str) {
        let mut text =
            Method::ALL.iter().fold("| |".to_owned(), |head, method| format!("{head} {} |", method.as_str()));
        text += "\n|---|";
        text += &"--:|".repeat(Method::ALL.len());
        text.push('\n');
        for (name, cells) in &self.lines {
            writeln!(text, "| {name} | {} |", cells.join(" | ")).unwrap();
        }
        // A page is of all rows on as many boards as usual.
        if ["CERMD_ROWS", "CERMD_BOARDS"].iter().any(|name| std::env::var_os(name).is_some()) {
            return;
        }
        let _one = WRITER.lock().unwrap_or_else(PoisonError::into_inner);
        let page = std::fs::read_to_string(PAGE).unwrap();
        let heading = format!("\n## {title}\n\n");
        let from = page.find(&heading).unwrap_or_else(|| panic!("no \"{title}\" in {PAGE}")) + heading.len();
        let to = page[from..].find("\n## ").map_or(page.len(), |length| from + length);
        let page = format!("{}{text}{}", &page[..from], &page[to..]);
        check_page("accuracy hostile", "coverage.md", &page);
    }
}
