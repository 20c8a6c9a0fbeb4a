//! What the demo has shown, in a few lines: counts, what the instrument has found out about itself, and, because the
//! circuit is simulated, the truth beside it.

use super::board::Board;
use crate::pins::sim::SimPins;
use crate::stream::wire::{ReadingLine, StatsLine, StatusName};
use crate::units::{Nanos, measured, rough};
use console::{Style, style};
use std::collections::BTreeMap;

/// What to do next.
const HINTS: [(&str, &str); 3] = [
    ("cermctl demo --scene pi5", "another board, --wiring one, --method tcdic"),
    ("cermctl check --config FILE", "what to expect of your own circuit"),
    ("cermd --config FILE, cermctl watch", "on hardware; start from hw/cermd.toml"),
];

/// The readings so far.
pub struct Tally<'a> {
    board: &'a Board,
    truth: SimPins,
    /// Numbers, open ones, short ones.
    counts: [usize; 3],
    /// Numbers of a hand that moved meanwhile.
    moving: usize,
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
            _ => *self.faults.entry(reading.state.fault.clone().unwrap_or_default()).or_default() += 1,
        }
    }

    /// The error in units of the stated uncertainty; `None` without one, and while R_x itself changes by more than the
    /// uncertainty within a millisecond, when there is no one true value of the discharge.
    fn error(&self, reading: &ReadingLine, r_ohm: f64) -> Option<f64> {
        const HALF: Nanos = Nanos(500_000);
        let channel = self.board.config.channels.iter().position(|channel| channel.id == reading.channel)?;
        let (at, u) = (Nanos(reading.t_mono_ns), reading.state.r_u_ohm?);
        let r_x = |at| self.truth.r_x(channel, at);
        let (before, truth, after) = (r_x(at - HALF)?, r_x(at)?, r_x(at + HALF)?);
        ((after - before).abs() < u).then_some((r_ohm - truth) / u)
    }

    /// The last lines of the demo.
    pub fn summary(&self, stats: &StatsLine, unicode: bool) -> Vec<String> {
        let stats = &stats.instrument;
        // A value with its uncertainty, and the truth; nothing for a method that does not look for it.
        let found = |name, value: Option<f64>, u: Option<f64>, unit, truth| {
            let truth = rough(truth, unit);
            let text = match (value, u) {
                (Some(value), Some(_)) => {
                    let dim = style(format!(" found, {truth} true")).dim();
                    format!("{}{dim}", measured(value, u, unit, unicode))
                }
                _ if stats.offset_known => return None,
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
        let count = numbers + open + short + faults;
        let seconds = self.span.map_or(0.0, |[first, last]| (last - first).as_seconds());
        let short = if short > 0 { format!(", {short} short") } else { String::new() };
        let moving = if self.moving > 0 { format!(" ({} moving)", self.moving) } else { String::new() };
        let text = format!(
            "{count} readings in {seconds:.1} s: {numbers} numbers{moving}, {open} open{short}, {faults} faults"
        );
        format!(" {}  {}", style("simulated").yellow(), style(text).bold())
    }

    fn fault_names(&self) -> Option<String> {
        let names: Vec<String> = self.faults.iter().map(|(name, count)| format!("{count} {name}")).collect();
        let why =
            if self.faults.contains_key("unsettled") { " (unsettled: the hand moved too fast)" } else { "" };
        (!names.is_empty()).then(|| row("faults", &format!("{}{}", names.join(", "), style(why).dim())))
    }

    /// Whether the uncertainties are true: a stated 1 sigma must hold what it promises.
    fn honesty(&self) -> String {
        let errors = &self.errors;
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

fn row(name: &str, text: &str) -> String {
    format!("   {name:<16}{text}")
}
