//! What the demo has shown, in a few lines: counts, what the instrument has found out about itself, and, because the
//! circuit is simulated, the truth beside it.

use super::super::text::{measured, rough};
use super::board::Board;
use crate::pins::sim::SimPins;
use crate::stream::wire::{ReadingLine, StatsLine, StatusName};
use crate::units::Nanos;
use console::{Style, style};
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
    pub fn summary(&self, board: &Board, stats: &StatsLine, unicode: bool) -> Vec<String> {
        let stats = &stats.instrument;
        let found = Found { is_sought: !stats.offset_known, unicode };
        let mut lines = vec![String::new(), self.counts()];
        lines.extend(self.fault_names());
        let latency_ns = board.latency_ns();
        lines.extend(found.row(
            "latency offset",
            [stats.offset_ns, stats.offset_u_ns],
            (1e-3, "us"),
            latency_ns,
        ));
        lines.extend(found.row(
            "pin resistance",
            [stats.r_o_ohm, stats.r_o_u_ohm],
            (1.0, "ohm"),
            board.r_o_ohm(),
        ));
        lines.extend([self.honesty(board), String::new()]);
        lines.extend(
            HINTS.map(|(command, what)| format!(" {}{what}", style(format!("{command:<36}")).bold())),
        );
        lines
    }

    fn counts(&self) -> String {
        let (numbers, faults) = (self.numbers.len(), self.faults.values().sum::<usize>());
        let count = numbers + self.open + self.short + faults;
        let seconds = self.first.map_or(0.0, |first| (self.last - first).as_seconds());
        let short = if self.short > 0 { format!(", {} short", self.short) } else { String::new() };
        let open = self.open;
        let text = format!(
            "{count} readings in {seconds:.1} s: {numbers} numbers, {open} open{short}, {faults} faults"
        );
        format!(" {}  {}", style("simulated").yellow(), style(text).bold())
    }

    fn fault_names(&self) -> Option<String> {
        let names: Vec<String> = self.faults.iter().map(|(name, count)| format!("{count} {name}")).collect();
        let why = if self.faults.contains_key("unsettled") { " (unsettled: the hand moved)" } else { "" };
        (!names.is_empty()).then(|| row("faults", &format!("{}{}", names.join(", "), style(why).dim())))
    }

    /// Whether the uncertainties are true: a stated 1 sigma must hold what it promises.
    fn honesty(&self, board: &Board) -> String {
        let mut simulation = board.simulation();
        let errors = self.numbers.iter().filter_map(|number| number.error(&mut simulation, board));
        let errors: Vec<f64> = errors.collect();
        if errors.is_empty() {
            return row("error of ohms", "too few readings at rest to tell; try --seconds 20");
        }
        let count = errors.len() as f64;
        let spread = (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt();
        let within = 100.0 * errors.iter().filter(|error| error.abs() <= 2.0).count() as f64 / count;
        let [one, two] = ["(1 is honest)", "(95)"].map(|text| Style::new().dim().apply_to(text));
        let text = format!("{spread:.2} u rms {one}, {within:.0} % within 2 u {two}, {count} at rest");
        row("error of ohms", &text)
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

fn row(name: &str, text: &str) -> String {
    format!("   {name:<16}{text}")
}

/// What the instrument has found.
struct Found {
    /// Not everything yet.
    is_sought: bool,
    unicode: bool,
}

impl Found {
    /// A value with its uncertainty, and the truth; nothing for a method that does not look for it.
    fn row(
        &self,
        name: &str,
        found: [Option<f64>; 2],
        (scale, unit): (f64, &str),
        truth: f64,
    ) -> Option<String> {
        let [value, u] = found.map(|number| number.map(|number| number * scale));
        let truth = rough(truth * scale, unit);
        if let (Some(value), Some(_)) = (value, u) {
            let found = measured(value, u, unit, self.unicode);
            return Some(row(name, &format!("{found}{}", style(format!(" found, {truth} true")).dim())));
        }
        let text = style(format!("still being looked for; {truth} true")).dim();
        self.is_sought.then(|| row(name, &text.to_string()))
    }
}
