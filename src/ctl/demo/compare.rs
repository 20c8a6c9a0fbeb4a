//! `cermctl demo --compare`: the same hand on the same circuit, read by every method that works on it, side by side.
//!
//! No daemon: each method has an instrument and a circuit of its own, and these behave alike. On a terminal they keep step with the
//! wall clock; else they run as fast as they can.

mod front;
mod table;

use super::super::CtlError;
use super::super::interrupt::Interrupt;
use super::super::limits::REDRAW_AFTER;
use super::super::terminal::Terminal;
use super::board::Board;
use crate::ctl::cli;
use crate::instrument::{Instrument, Message};
use crate::pins::Pins;
use crate::pins::sim::SimPins;
use crate::reading::Method;
use crate::units::Nanos;
use console::style;
use std::path::Path;
use std::time::{Duration, Instant};
use table::MethodRow;

/// Where to go on.
const HINTS: [(&str, &str); 3] = [
    ("docs/averages.md", "the same for more resistances, of many boards"),
    ("cermctl size --help", "which circuit gives the error that you need"),
    ("cermctl demo", "tracked alone, with force"),
];

/// Shows it.
pub fn run(arguments: &cli::Demo) -> Result<(), CtlError> {
    let (interrupt, mut terminal) = (Interrupt::new()?, Terminal::new());
    let mut runners = Runner::all(arguments)?;
    let fronts = std::thread::spawn(front::all(&Runner::boards(arguments)?));
    for line in introduction(arguments, runners.len()) {
        terminal.say(&line)?;
    }
    let (began, end) = (Instant::now(), Duration::from_secs_f64(arguments.seconds));
    while terminal.is_live && !interrupt.is_set() && began.elapsed() < end {
        go_on(&mut runners, Nanos::from_seconds(began.elapsed().as_secs_f64()))?;
        terminal.draw(&lines(&runners, terminal.size().0, terminal.unicode))?;
        std::thread::sleep(REDRAW_AFTER);
    }
    if !terminal.is_live {
        go_on(&mut runners, Nanos::from_seconds(arguments.seconds))?;
        let width = terminal.size().0;
        lines(&runners, width, terminal.unicode).iter().try_for_each(|line| terminal.say(line))?;
    }
    let fronts =
        fronts.join().map_err(|_| CtlError::said("the front has died: this is a mistake in cermctl"))?;
    let hints = HINTS.map(|(what, why)| format!(" {}{why}", style(format!("{what:<22}")).bold()));
    let width = terminal.size().0;
    let mut last = front::lines(&fronts, width, terminal.unicode);
    last.push(String::new());
    last.extend(hints);
    last.iter().try_for_each(|line| terminal.say(line))
}

fn introduction(arguments: &cli::Demo, methods: usize) -> [String; 3] {
    let first = format!(
        " {}  {}  board {}",
        style("cermd demo --compare").bold(),
        style("simulated").yellow(),
        arguments.scene
    );
    let second = format!(" the same sensor, read by {methods} methods");
    [first, style(second).dim().to_string(), String::new()]
}

/// Every line of the table.
fn lines(runners: &[Runner], width: usize, unicode: bool) -> Vec<String> {
    let rows = runners.iter().map(|runner| runner.row.line(width, unicode));
    std::iter::once(table::head(width)).chain(rows).collect()
}

fn go_on(runners: &mut [Runner], until: Nanos) -> Result<(), CtlError> {
    runners.iter_mut().try_for_each(|runner| runner.go_on(until))
}

/// One method at work.
struct Runner {
    instrument: Instrument<SimPins>,
    truth: SimPins,
    row: MethodRow,
}

impl Runner {
    /// A board for each method.
    fn boards(arguments: &cli::Demo) -> Result<Vec<(Method, Board)>, CtlError> {
        let kind = Board::new(arguments, Path::new(""))?.config.circuit.kind();
        let of = |method| {
            let arguments = cli::Demo { method: Some(method), ..arguments.clone() };
            Ok((method, Board::new(&arguments, Path::new(""))?.with_first_sensor()?))
        };
        Method::on(kind).map(of).collect()
    }

    fn all(arguments: &cli::Demo) -> Result<Vec<Runner>, CtlError> {
        Runner::boards(arguments)?.into_iter().map(|(method, board)| Runner::new(method, &board)).collect()
    }

    fn new(method: Method, board: &Board) -> Result<Runner, CtlError> {
        let settings = board.config.settings().map_err(CtlError::said)?;
        let instrument = Instrument::new(board.simulation(), settings);
        Ok(Runner { instrument, truth: board.simulation(), row: MethodRow::new(method) })
    }

    fn go_on(&mut self, until: Nanos) -> Result<(), CtlError> {
        while self.instrument.pins().now() < until {
            let (row, truth) = (&mut self.row, &self.truth);
            let step = self.instrument.step(&mut |message| {
                if let Message::Reading(reading) = message {
                    row.take(&reading, truth.r_x(reading.channel, reading.at));
                }
            });
            step.map_err(CtlError::said)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ctl::cli::{Cermctl, Verb};
    use clap::Parser;

    fn shown(line: &str, seconds: f64, width: usize) -> String {
        let Verb::Demo(arguments) = Cermctl::try_parse_from(line.split(' ')).unwrap().verb else { panic!() };
        let mut runners = Runner::all(&arguments).unwrap();
        go_on(&mut runners, Nanos::from_seconds(seconds)).unwrap();
        let mut all = lines(&runners, width, true);
        all.extend(front::lines(&front::all(&Runner::boards(&arguments).unwrap())(), width, true));
        let all: Vec<String> =
            all.iter().map(|line| console::strip_ansi_codes(line).trim_end().to_owned()).collect();
        assert!(all.iter().all(|line| console::measure_text_width(line) <= width), "{all:#?}");
        all.join("\n")
    }

    #[test]
    fn side_by_side_at_80_columns() {
        insta::assert_snapshot!(shown("cermctl demo --compare --scene pi4", 7.0, 80));
    }

    #[test]
    fn side_by_side_at_40_columns() {
        insta::assert_snapshot!(shown("cermctl demo --compare --scene pi4 --wiring one", 7.0, 40));
    }
}
