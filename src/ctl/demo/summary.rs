//! What the demo has shown, in a few lines.
//!
//! For: counts, what the instrument has found out about itself, and, because the circuit is simulated, the truth beside
//! it. Must not know: how either came about.

use super::super::terminal::{Line, Style};
use super::super::text::{measured, rough};
use super::board::Board;
use crate::pins::sim::SimPins;
use crate::stream::wire::{ReadingLine, StatsLine, StatusName};
use crate::units::Nanos;
use std::collections::BTreeMap;

/// What to do next.
const HINTS: [(&str, &str); 3] = [
    ("cermctl demo --scene pi5", "another board; or --method tcdic"),
    ("cermctl check --config FILE", "what to expect of your own circuit"),
    ("cermd --config FILE, cermctl watch", "on hardware; start from hw/cermd.toml"),
];

/// What remains of a reading.
#[derive(Debug, Clone, Copy)]
struct Number {
    channel: usize,
    at: Nanos,
    r_ohm: f64,
    u_ohm: Option<f64>,
}

/// The readings so far.
#[derive(Debug, Default)]
pub struct Tally {
    channels: Vec<String>,
    numbers: Vec<Number>,
    open: usize,
    short: usize,
    faults: BTreeMap<String, usize>,
    first: Option<Nanos>,
    last: Nanos,
}

impl Tally {
    /// One more.
    pub fn add(&mut self, reading: &ReadingLine) {
        self.last = Nanos(reading.t_mono_ns);
        self.first.get_or_insert(self.last);
        match (reading.status, reading.r_ohm) {
            (StatusName::Open, _) => self.open += 1,
            (StatusName::Short, _) => self.short += 1,
            (StatusName::Ok, Some(r_ohm)) => {
                let number = Number {
                    channel: self.index(&reading.channel),
                    at: self.last,
                    r_ohm,
                    u_ohm: reading.r_u_ohm,
                };
                self.numbers.push(number);
            }
            _ => *self.faults.entry(reading.fault.clone().unwrap_or_default()).or_default() += 1,
        }
    }

    fn index(&mut self, id: &str) -> usize {
        self.channels.iter().position(|known| known == id).unwrap_or_else(|| {
            self.channels.push(id.to_owned());
            self.channels.len() - 1
        })
    }

    /// The last lines of the demo.
    pub fn summary(&self, board: &Board, stats: &StatsLine, unicode: bool) -> Vec<Line> {
        let stats = &stats.instrument;
        let is_sought = !stats.offset_known;
        let mut lines = vec![Line::default(), self.counts()];
        lines.extend(self.fault_names());
        lines.extend(found(
            "latency offset",
            is_sought,
            [stats.offset_ns, stats.offset_u_ns],
            1e-3,
            "us",
            board.latency_ns(),
            unicode,
        ));
        lines.extend(found(
            "pin resistance",
            is_sought,
            [stats.r_o_ohm, stats.r_o_u_ohm],
            1.0,
            "ohm",
            board.r_o_ohm(),
            unicode,
        ));
        lines.push(self.honesty(board));
        lines.push(Line::default());
        lines.extend(HINTS.map(|(command, what)| {
            Line::default().add(Style::Bold, format!(" {command:<36}")).add(Style::Plain, what)
        }));
        lines
    }

    fn counts(&self) -> Line {
        let count = self.numbers.len() + self.open + self.short + self.faults.values().sum::<usize>();
        let seconds = self.first.map_or(0.0, |first| (self.last - first).as_seconds());
        let text =
            format!("{count} readings in {seconds:.1} s: {} numbers, {} open", self.numbers.len(), self.open);
        let short = if self.short > 0 { format!(", {} short", self.short) } else { String::new() };
        let faults = format!(", {} faults", self.faults.values().sum::<usize>());
        Line::default().add(Style::Notable, " simulated  ").add(Style::Bold, text + &short + &faults)
    }

    fn fault_names(&self) -> Option<Line> {
        let names: Vec<String> = self.faults.iter().map(|(name, count)| format!("{count} {name}")).collect();
        let why = if self.faults.contains_key("unsettled") { " (unsettled: the hand moved)" } else { "" };
        let line = row("faults").add(Style::Plain, names.join(", ")).add(Style::Dim, why);
        (!names.is_empty()).then_some(line)
    }

    /// Whether the uncertainties are true: a stated 1 sigma must hold what it promises.
    fn honesty(&self, board: &Board) -> Line {
        let mut simulation = board.simulation();
        let errors = self.numbers.iter().filter_map(|number| number.error(&mut simulation, board));
        let errors: Vec<f64> = errors.collect();
        let row = row("error of ohms");
        if errors.is_empty() {
            return row.add(Style::Plain, "too few readings at rest to tell; try --seconds 20");
        }
        let count = errors.len() as f64;
        let spread = (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt();
        let within = |u: f64| 100.0 * errors.iter().filter(|error| error.abs() <= u).count() as f64 / count;
        row.add(Style::Plain, format!("{spread:.2} u rms"))
            .add(Style::Dim, " (1 is honest)")
            .add(Style::Plain, format!(", {:.0} % within 2 u", within(2.0)))
            .add(Style::Dim, " (95)")
            .add(Style::Plain, format!(", {count} at rest"))
    }
}

impl Number {
    /// The error in units of the stated uncertainty; `None` without one, and while R_x itself changes by more than the
    /// uncertainty within a millisecond, when there is no one true value of the discharge.
    fn error(&self, simulation: &mut SimPins, board: &Board) -> Option<f64> {
        const HALF: Nanos = Nanos(500_000);
        let at = self.at - board.epoch.get();
        let u = self.u_ohm?;
        let [before, truth, after] =
            [at - HALF, at, at + HALF].map(|at| simulation.r_x(self.channel, at).unwrap_or(f64::NAN));
        ((after - before).abs() < u).then_some((self.r_ohm - truth) / u)
    }
}

fn row(name: &str) -> Line {
    Line::default().add(Style::Plain, format!("   {name:<16}"))
}

/// What the instrument has found, and the truth; nothing for a method that does not look for it.
fn found(
    name: &str,
    is_sought: bool,
    [value, u]: [Option<f64>; 2],
    scale: f64,
    unit: &str,
    truth: f64,
    unicode: bool,
) -> Option<Line> {
    let truth = rough(truth * scale, unit);
    if let (Some(value), Some(u)) = (value, u) {
        let found = measured(value * scale, Some(u * scale), unit, unicode);
        return Some(row(name).add(Style::Plain, found).add(Style::Dim, format!(" found, {truth} true")));
    }
    is_sought.then(|| row(name).add(Style::Dim, format!("still being looked for; {truth} true")))
}
