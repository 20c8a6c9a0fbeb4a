//! What each method reads now, a line each: value with its uncertainty, how far it is off, how many a second.

use crate::ctl::limits::RATE_WINDOW;
use crate::reading::{Measured, Method, Reading, Status};
use crate::units::{Nanos, measured, rough, rounded};
use console::{Style, style};
use std::collections::VecDeque;

/// From this width on there are units and a status.
const WIDE: usize = 70;

/// One method.
pub struct MethodRow {
    method: Method,
    last: Option<(Status, Option<f64>)>,
    times: VecDeque<Nanos>,
}

/// The names of the columns.
pub fn head(width: usize) -> String {
    let head = if width >= WIDE {
        format!(" {:<9}{:>22}{:>16}{:>13}   status", "method", "reads", "it is off by", "a second")
    } else {
        format!(" {:<8}{:>20}{:>6}{:>5}", "method", "reads", "off", "Hz")
    };
    style(head).dim().to_string()
}

impl MethodRow {
    pub fn new(method: Method) -> MethodRow {
        MethodRow { method, last: None, times: VecDeque::new() }
    }

    /// One more; `truth`: R_x at its time, ohm.
    pub fn take(&mut self, reading: &Reading, truth: Option<f64>) {
        self.last = Some((reading.status, truth));
        self.times.push_back(reading.at);
        while self.times.front().is_some_and(|first| reading.at - *first > RATE_WINDOW) {
            self.times.pop_front();
        }
    }

    /// Readings per second.
    fn rate(&self) -> String {
        let span = self
            .times
            .back()
            .zip(self.times.front())
            .map_or(0.0, |(last, first)| (*last - *first).as_seconds());
        if span > 0.0 { format!("{:.0}", (self.times.len() - 1) as f64 / span) } else { String::new() }
    }

    /// In so many columns.
    pub fn line(&self, width: usize, unicode: bool) -> String {
        let ([reads, off], status, colour) = self.words(width >= WIDE, unicode);
        let (method, rate) = (self.method.as_str(), self.rate());
        if width >= WIDE {
            let status = colour.apply_to(status);
            format!(" {}{reads:>22}{off:>16}{rate:>13}   {status}", style(format!("{method:<9}")).bold())
        } else {
            format!(" {}{reads:>20}{off:>6}{rate:>5}", style(format!("{method:<8}")).bold())
        }
    }

    fn words(&self, is_wide: bool, unicode: bool) -> ([String; 2], &'static str, Style) {
        let (plain, Some((status, truth))) = (Style::new(), self.last) else {
            return (Default::default(), "waiting", Style::new().dim());
        };
        match status {
            Status::Ok { r_ohm: Measured { value, u }, is_moving, is_settling, .. } => {
                let unit = if is_wide { " ohm" } else { "" };
                let off =
                    truth.map_or(String::new(), |truth| format!("{:+}{unit}", rounded(value - truth, 2)));
                let mark = if is_moving {
                    "moving"
                } else if is_settling {
                    "settling"
                } else {
                    "ok"
                };
                ([measured(value, u, "ohm", unicode), off], mark, plain.green())
            }
            Status::Open { r_min_ohm, .. } => {
                ([format!("> {}", rough(r_min_ohm, "ohm")), String::new()], "open", plain.dim())
            }
            Status::Short { r_max_ohm, .. } => {
                ([format!("< {}", rough(r_max_ohm, "ohm")), String::new()], "short", plain.yellow())
            }
            // With a hand on the sensor that is what happens: it is no failure of the board.
            Status::Fault(fault) => ([fault.as_str().to_owned(), String::new()], "no number", plain.yellow()),
        }
    }
}
