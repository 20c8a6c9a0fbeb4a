//! What the demo has shown, in a few lines: counts, what the instrument has found out about itself, and, because the
//! circuit is simulated, the truth beside it.

use super::board::Board;
use crate::estimate::method::Switching;
use crate::pins::sim::SimPins;
use crate::reading::Fault;
use crate::stream::wire::{ReadingLine, StatsLine, StatusName};
use crate::units::sample::rms;
use crate::units::{Nanos, measured, rough};
use console::{Style, style};
use std::collections::BTreeMap;

/// What to do next.
const HINTS: [(&str, &str); 3] = [
    ("cermctl demo --compare", "all methods side by side"),
    ("cermctl check", "what to expect of your own circuit"),
    ("sudo cermctl setup", "on hardware: from wires to readings"),
];

/// The readings so far.
pub struct Tally<'a> {
    board: &'a Board,
    truth: SimPins,
    /// Numbers, open ones, short ones.
    counts: [usize; 3],
    /// Numbers of a hand that moved meanwhile.
    moving: usize,
    /// No numbers, since it moved too fast for one.
    unsettled: usize,
    faults: BTreeMap<String, usize>,
    /// Of the numbers whose truth can be told, in units of their uncertainties.
    errors: Vec<f64>,
    /// When the first and the last one were.
    span: Option<[Nanos; 2]>,
}

impl Tally<'_> {
    /// Nothing yet; `truth`: a circuit that behaves as the measured one.
    pub fn new(board: &Board, truth: SimPins) -> Tally<'_> {
        Tally {
            board,
            truth,
            counts: [0; 3],
            moving: 0,
            unsettled: 0,
            faults: BTreeMap::new(),
            errors: Vec::new(),
            span: None,
        }
    }

    /// One more.
    pub fn add(&mut self, reading: &ReadingLine) {
        let at = Nanos(reading.t_mono_ns);
        self.span.get_or_insert([at; 2])[1] = at;
        match (reading.state.status, reading.state.r_ohm) {
            (StatusName::Open, _) => self.counts[1] += 1,
            (StatusName::Short, _) => self.counts[2] += 1,
            (StatusName::Ok, Some(r_ohm)) => {
                self.counts[0] += 1;
                self.moving += usize::from(reading.state.moving);
                self.errors.extend(self.error(reading, r_ohm));
            }
            // That is what hands do, and no failure.
            _ if reading.state.fault.as_deref() == Some(Fault::Unsettled.as_str()) => self.unsettled += 1,
            _ => *self.faults.entry(reading.state.fault.clone().unwrap_or_default()).or_default() += 1,
        }
    }

    /// The error in units of the stated uncertainty; `None` without one, and while R_x has no one value within a discharge (a
    /// millisecond for each kilohm, one at the least).
    fn error(&self, reading: &ReadingLine, r_ohm: f64) -> Option<f64> {
        let half = Nanos::from_seconds(0.5e-6 * r_ohm.max(1000.0));
        let channel = self.board.config.channels.iter().position(|channel| channel.id == reading.channel)?;
        let truth = self.truth.one_r_x(channel, Nanos(reading.t_mono_ns), half)?;
        Some((r_ohm - truth) / reading.state.r_u_ohm?)
    }

    /// The last lines of the demo.
    pub fn summary(&self, stats: &StatsLine, unicode: bool) -> Vec<String> {
        let stats = &stats.instrument;
        // A value with its uncertainty, and the truth; nothing of what is given, or not found and cancels.
        let cancels = self.board.config.method().rules().switching == Switching::Never;
        let found = |name, value: Option<f64>, u: Option<f64>, unit, truth| {
            let truth = rough(truth, unit);
            let text = match (value, u) {
                (Some(value), Some(u_found)) if u_found > 0.0 => {
                    let dim = style(format!(" found, {truth} true")).dim();
                    format!("{}{dim}", measured(value, u, unit, unicode))
                }
                _ if stats.offset_known || cancels => return None,
                _ => style(format!("still being looked for; {truth} true")).dim().to_string(),
            };
            Some(row(name, &text))
        };
        let in_us = |ns: f64| ns * 1e-3;
        let [offset, u] = [stats.offset_ns, stats.offset_u_ns].map(|ns| ns.map(in_us));
        let mut lines = vec![String::new(), self.counts()];
        lines.extend(self.fault_names());
        lines.extend(found("latency offset", offset, u, "us", in_us(self.board.latency_ns())));
        lines.extend(found("pin resistance", stats.r_o_ohm, stats.r_o_u_ohm, "ohm", self.board.r_o_ohm()));
        lines.extend([self.honesty(), String::new()]);
        lines.extend(
            HINTS.map(|(command, what)| format!(" {}{what}", style(format!("{command:<36}")).bold())),
        );
        lines
    }

    fn counts(&self) -> String {
        let ([numbers, open, short], faults) = (self.counts, self.faults.values().sum::<usize>());
        let count = numbers + open + short + self.unsettled + faults;
        let seconds = self.span.map_or(0.0, |[first, last]| (last - first).as_seconds());
        let short = if short > 0 { format!(", {short} short") } else { String::new() };
        let moving = if self.moving > 0 { format!(" ({} moving)", self.moving) } else { String::new() };
        let fast =
            if self.unsettled > 0 { format!(", {} too fast to read", self.unsettled) } else { String::new() };
        let text = format!(
            "{count} readings in {seconds:.1} s: {numbers} numbers{moving}, {open} open{short}{fast}, {faults} faults"
        );
        format!(" {}  {}", style("simulated").yellow(), style(text).bold())
    }

    fn fault_names(&self) -> Option<String> {
        let names: Vec<String> = self.faults.iter().map(|(name, count)| format!("{count} {name}")).collect();
        (!names.is_empty()).then(|| row("faults", &names.join(", ")))
    }

    /// Whether the uncertainties are true: a stated 1 sigma must hold what it promises.
    fn honesty(&self) -> String {
        let errors = &self.errors;
        let Some(spread) = rms(errors.iter().copied()) else {
            return row("error of ohms", "too few numbers to tell; try --seconds 20");
        };
        let count = errors.len() as f64;
        let within = 100.0 * errors.iter().filter(|error| error.abs() <= 2.0).count() as f64 / count;
        let [one, two] = ["(1 is honest)", "(95)"].map(|text| Style::new().dim().apply_to(text));
        let text = format!("{spread:.2} u rms {one}, {within:.0} % within 2 u {two} of {count}");
        row("error of ohms", &text)
    }
}

fn row(name: &str, text: &str) -> String {
    format!("   {name:<16}{text}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ctl::cli::{Cermctl, Verb};
    use crate::instrument::{Instrument, Message};
    use crate::pins::Pins;
    use crate::reading::Reading;
    use crate::stream::wire::Unit;
    use clap::Parser;
    use std::path::Path;

    /// What a demo of so many seconds has counted, in virtual time.
    fn tally_of<T>(line: &str, seconds: i64, look: impl FnOnce(&Tally) -> T) -> T {
        let Verb::Demo(arguments) = Cermctl::try_parse_from(line.split(' ')).unwrap().verb else { panic!() };
        let board = Board::new(&arguments, Path::new("")).unwrap();
        let settings = board.config.settings().unwrap();
        let mut tally = Tally::new(&board, board.simulation());
        let mut instrument = Instrument::new(board.simulation(), settings);
        while instrument.pins().now() < Nanos(seconds * 1_000_000_000) {
            let mut readings: Vec<Reading> = Vec::new();
            instrument
                .step(&mut |message| {
                    if let Message::Reading(reading) = message {
                        readings.push(reading)
                    }
                })
                .unwrap();
            for reading in readings {
                let id = &board.config.channels[reading.channel].id;
                tally.add(&ReadingLine::new(&reading, id, &Unit::Newton, String::new()));
            }
        }
        look(&tally)
    }

    /// Sensors that are far apart, and one that goes from one value to another all at once.
    const MANY: &str = r#"
        [[sensor]]
        constant = "1 kohm"
        [[sensor]]
        hand = { peak = "8 N", period = "2 s" }
        [[sensor]]
        constant = "100 ohm"
        [[sensor]]
        step = { before = "1 kohm", after = "13 Mohm", at = "6 s" }
    "#;

    #[test]
    fn each_of_several_sensors_is_held_against_its_own_truth() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("many.toml");
        let pi4 = include_str!("../../../hw/scenes/pi4.toml");
        let (board, _) = pi4.split_once("[[sensor]]").unwrap();
        std::fs::write(&path, format!("{board}{MANY}")).unwrap();
        for method in ["tracked", "tcdic", "tpcm", "cerm"] {
            let line = format!("cermctl demo --scene {} --method {method}", path.display());
            tally_of(&line, 12, |tally| {
                let squares: f64 = tally.errors.iter().map(|error| error * error).sum();
                let rms = (squares / tally.errors.len() as f64).sqrt();
                assert!(
                    tally.errors.len() > 50 && (0.7..1.3).contains(&rms),
                    "{method}: {rms} u rms of {}",
                    tally.errors.len()
                );
            });
        }
    }

    #[test]
    fn a_hand_that_is_too_fast_for_a_slow_method_is_no_fault() {
        tally_of("cermctl demo --method tpcm", 12, |tally| {
            assert!(tally.unsettled > 0 && !tally.faults.contains_key(Fault::Unsettled.as_str()));
            let counts = console::strip_ansi_codes(&tally.counts()).into_owned();
            assert!(counts.contains(" too fast to read, ") && counts.contains("numbers"), "{counts}");
        });
    }
}
