//! `cermctl` on a terminal of its own: script(1) makes one, and what it gets is put on a screen here.

use super::daemon::{Daemon, config, scene};
use crate::waiting::until_so;
use std::process::Stdio;

/// Three characters that some terminals show as one picture of two columns, and others as two pictures.
const ASTRONAUT: &str = "\u{1f469}\u{200d}\u{1f680}";

/// Which row the cursor is on, on a terminal that shows the longest form of everything.
#[derive(Default)]
struct Screen {
    row: usize,
    column: usize,
    wraps: bool,
    /// The rows that redrawing began at.
    begun_at: Vec<usize>,
}

impl Screen {
    fn show(columns: usize, text: &str) -> Screen {
        let mut screen = Screen { wraps: true, ..Screen::default() };
        let mut rest = text.chars();
        while let Some(c) = rest.next() {
            match c {
                '\x1b' => {
                    let code: String = rest.by_ref().take_while(|c| *c != '[').collect();
                    assert_eq!(code, "", "not a sequence that is known here");
                    let mut number = String::new();
                    let last = rest.by_ref().find(|c| {
                        number.push(*c);
                        c.is_ascii_alphabetic()
                    });
                    screen.obey(last.unwrap_or('m'), number.trim_end_matches(char::is_alphabetic));
                }
                '\n' => (screen.row, screen.column) = (screen.row + 1, 0),
                '\r' => screen.column = 0,
                '\u{200d}' => {}
                c => {
                    let width = if u32::from(c) >= 0x1f000 { 2 } else { 1 };
                    if screen.column + width > columns && screen.wraps {
                        (screen.row, screen.column) = (screen.row + 1, 0);
                    }
                    screen.column = (screen.column + width).min(columns);
                }
            }
        }
        screen
    }

    fn obey(&mut self, code: char, number: &str) {
        match (code, number) {
            ('A', rows) => self.row = self.row.saturating_sub(rows.parse().unwrap_or(1)),
            ('J', _) => self.begun_at.push(self.row),
            ('h', "?7") => self.wraps = true,
            ('l', "?7") => self.wraps = false,
            _ => {}
        }
    }
}

/// What `cermctl` writes to a terminal of so many columns until there is enough of it.
pub fn on_a_terminal(
    daemon: &Daemon,
    arguments: &str,
    columns: usize,
    is_enough: impl Fn(&str) -> bool,
) -> String {
    let file = daemon.path("typescript");
    let program = env!("CARGO_BIN_EXE_cermctl");
    let command = format!("stty cols {columns} rows 24; exec {program} {arguments}");
    let mut script = std::process::Command::new("script")
        .args(["--quiet", "--flush", "--return", "--command", &command])
        .arg(&file)
        .current_dir(daemon.folder.path())
        .env("CERMD_SOCKET", daemon.socket())
        .env("TERM", "xterm-256color")
        .env("LC_ALL", "C.UTF-8")
        .env_remove("COLUMNS")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let written = || String::from_utf8_lossy(&std::fs::read(&file).unwrap_or_default()).into_owned();
    until_so("enough on the terminal", || is_enough(&written()) || script.try_wait().unwrap().is_some());
    let _ = script.kill();
    script.wait().unwrap();
    written()
}

#[test]
fn live_lines_stay_where_they_are_whatever_the_name() {
    let daemon = Daemon::start_as(config().set("channel.thumb.id", ASTRONAUT), &scene());
    let text = on_a_terminal(&daemon, "watch", 62, |text| text.matches("\x1b[?7h").count() > 20);
    let (_, text) = text.split_once('\n').unwrap();
    assert!(text.contains(ASTRONAUT), "{text}");
    let screen = Screen::show(62, text);
    assert!(screen.begun_at.len() > 20, "{text}");
    assert!(screen.begun_at.iter().all(|row| *row == screen.begun_at[0]), "{:?}", screen.begun_at);
    // What is written would not hold by itself.
    let wrapped = Screen::show(62, &text.replace("\x1b[?7l", ""));
    assert!(wrapped.begun_at.last() > wrapped.begun_at.first(), "{:?}", wrapped.begun_at);
}
