//! The command lines of both programs: arguments and their help texts, from which the manual pages are made, too.
#![expect(missing_docs, reason = "a text at a flattened group would replace that of its verb")]

use crate::circuit::Kind;
use crate::instrument::settings::OffsetSource;
use crate::reading::Method;
use crate::record::LONGEST_LATENCY;
use crate::units::Ohm;
use clap::builder::PossibleValue;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// What to say to somebody without hardware.
pub const NO_HARDWARE: &str = "Without hardware: `cermctl demo` shows live readings of a simulated circuit; a file with \
                               [gpio] backend = \"mock\" and [mock] scene = \"pi4\" makes this daemon serve one.";

/// Measures resistances by timing RC discharges over GPIO lines, and streams them on a unix socket.
#[derive(Debug, Parser)]
#[command(name = "cermd", version, after_help = NO_HARDWARE)]
pub struct Cermd {
    /// The configuration file
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Check the configuration, say what is found, and exit
    #[arg(long)]
    pub check: bool,
    /// Make every line that the configuration names an input, and exit: for after a kill
    #[arg(long, conflicts_with = "check")]
    pub release_lines: bool,
}

/// Reads resistive sensors that cermd measures on GPIO lines, and looks after the instrument.
#[derive(Debug, Parser)]
#[command(name = "cermctl", version, after_help = "Nothing connected yet? Try `cermctl demo`.")]
pub struct Cermctl {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// What `cermctl` can do.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Show live readings of a simulated circuit: no hardware, no root, no daemon, no file left behind
    Demo(Demo),
    /// Show readings as they come, a live line per channel; survives a restart of the daemon
    Watch(Watch),
    /// Print the last reading of each channel
    Get(Get),
    /// Print what the daemon has counted and learned
    Stats(Stats),
    /// Say what is wrong with a configuration and, unless cermd holds it, with the circuit: every line is tested
    Check(Check),
    /// List the GPIO chips and lines of this machine, and who holds which
    Lines(Lines),
    /// Write readings, or the timings of discharges, to a file
    Record(Record),
    /// Estimate again from the timings on a tape
    Estimate(Estimate),
    /// Measure the zero or the force characteristic of a sensor, and put it into the configuration
    Calibrate(Calibrate),
}

const SECONDS: &str = "seconds above 0, such as 2.5";

/// Where the daemon listens.
#[derive(Debug, Args)]
pub struct Connection {
    /// The socket of the daemon
    #[arg(long, value_name = "PATH", env = "CERMD_SOCKET", default_value = "/run/cermd/cermd.sock")]
    pub socket: PathBuf,
}

/// `cermctl demo`.
#[derive(Debug, Args)]
pub struct Demo {
    /// The simulated board: ideal, fpga-paper, pi-zero, pi4 or pi5, with a hand pressing an FSR 402; or a scene file
    /// (*.toml) with its own sensors
    #[arg(long, value_name = "NAME|FILE", default_value = "pi4")]
    pub scene: String,
    /// How long to measure
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = number_of(SECONDS))]
    pub seconds: f64,
    /// Of every random number [default: the scene's own]
    #[arg(long, value_name = "NUMBER")]
    pub seed: Option<u64>,
    /// How to estimate [default: the best that the circuit allows]
    #[arg(long)]
    pub method: Option<Method>,
    /// How it is wired [default: as the scene, or as the method needs it]
    #[arg(long)]
    pub wiring: Option<Wiring>,
}

/// The wirings of the drawings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Wiring {
    /// One capacitor: least parts, most readings a second
    One,
    /// Two capacitors: each reading can be checked by a second crossing
    Two,
    /// One capacitor, Rc2 in series with Rc1: for qerm
    Series,
}

impl From<Wiring> for Kind {
    fn from(wiring: Wiring) -> Kind {
        match wiring {
            Wiring::One => Kind::OneCapacitor,
            Wiring::Two => Kind::TwoCapacitor,
            Wiring::Series => Kind::SeriesCalibration,
        }
    }
}

/// `cermctl watch`.
#[derive(Debug, Args)]
pub struct Watch {
    /// Only these channels [default: all]
    #[arg(value_name = "CHANNEL")]
    pub channels: Vec<String>,
    /// At most so many readings of each channel per second
    #[arg(long, value_name = "HERTZ", value_parser = number_of("hertz above 0, such as 10"))]
    pub max_hz: Option<f64>,
    /// The lines of the stream as they come
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub connection: Connection,
}

/// `cermctl get`.
#[derive(Debug, Args)]
pub struct Get {
    /// Only these channels [default: all]
    #[arg(value_name = "CHANNEL")]
    pub channels: Vec<String>,
    /// The lines of the stream as they come
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub connection: Connection,
}

/// `cermctl stats`.
#[derive(Debug, Args)]
pub struct Stats {
    /// The line of the stream as it comes
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub connection: Connection,
}

/// `cermctl check`.
#[derive(Debug, Args)]
pub struct Check {
    /// The configuration file
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
}

/// `cermctl lines`.
#[derive(Debug, Args)]
pub struct Lines {
    /// One object for each chip
    #[arg(long)]
    pub json: bool,
}

/// `cermctl record`.
#[derive(Debug, Args)]
pub struct Record {
    /// Only these channels [default: all]
    #[arg(value_name = "CHANNEL")]
    pub channels: Vec<String>,
    /// Stop after so long [default: at Ctrl-C]
    #[arg(long, value_name = "SECONDS", value_parser = number_of(SECONDS), conflicts_with = "count")]
    pub seconds: Option<f64>,
    /// Stop after so many readings, or discharges with --raw
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u64).range(1..))]
    pub count: Option<u64>,
    /// How to write readings
    #[arg(long, value_enum, default_value = "ndjson", conflicts_with = "raw")]
    pub format: Format,
    /// A tape: the timings of the discharges in the place of readings, for `cermctl estimate`
    #[arg(long)]
    pub raw: bool,
    /// Where to write; an existing file is replaced [default: standard output]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub connection: Connection,
}

/// How readings are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// The lines of the stream as they come
    Ndjson,
    /// A line of names, then one line per reading; what is not known is empty
    Csv,
}

/// `cermctl estimate`.
#[derive(Debug, Args)]
pub struct Estimate {
    /// The tape, or - for standard input
    #[arg(value_name = "TAPE")]
    pub tape: PathBuf,
    /// How to estimate; several times for several methods beside each other
    #[arg(long, required = true)]
    pub method: Vec<Method>,
    /// How late the kernel stamps a crossing: a duration such as "8 us", or auto for what the split calibration
    /// discharges on the tape tell [default: what the tape says, or else auto]
    #[arg(long, value_name = "DURATION|auto", value_parser = offset)]
    pub offset: Option<OffsetSource>,
    /// What all estimates come to, in the place of each: for each channel and method how many numbers, their mean, their
    /// standard deviation, the uncertainty that they state, and the root mean square of their deviations in units of that
    #[arg(long)]
    pub summary: bool,
    /// The summary as lines of JSON, as estimates always are
    #[arg(long, requires = "summary")]
    pub json: bool,
}

/// `cermctl calibrate`.
#[derive(Debug, Args)]
pub struct Calibrate {
    /// What to calibrate by.
    #[command(subcommand)]
    pub by: CalibrateBy,
}

/// What `cermctl calibrate` can calibrate by.
#[derive(Debug, Subcommand)]
pub enum CalibrateBy {
    /// With a short circuit in the sensor's place: find the zero
    Zero(Zero),
    /// With a known resistor in the sensor's place: below r-c1 find the zero, from there on the scale
    Reference(Reference),
    /// With weights on the sensor: find how its resistance becomes force
    Force(Force),
}

/// `cermctl calibrate zero`.
#[derive(Debug, Args)]
pub struct Zero {
    /// How many discharges to take
    #[arg(long, value_name = "NUMBER", default_value = "200", value_parser = clap::value_parser!(u64).range(2..=100_000))]
    pub count: u64,
    #[command(flatten)]
    pub update: Update,
    #[command(flatten)]
    pub connection: Connection,
}

/// `cermctl calibrate reference`.
#[derive(Debug, Args)]
pub struct Reference {
    /// The resistor as measured, such as 10.03 or "10.03 ohm"
    #[arg(value_name = "OHM", value_parser = ohm)]
    pub ohm: f64,
    #[command(flatten)]
    pub zero: Zero,
}

/// `cermctl calibrate force`.
#[derive(Debug, Args)]
pub struct Force {
    /// Pairs from a file of `force_n,r_ohm` lines [default: typed; the resistance is measured]
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// What to fit
    #[arg(long, value_enum, default_value = "alpha")]
    pub model: Model,
    /// Draw pairs, fit and residuals into this file, as SVG
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How many readings to average for each weight
    #[arg(long, value_name = "NUMBER", default_value = "20", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub count: u64,
    #[command(flatten)]
    pub update: Update,
    #[command(flatten)]
    pub connection: Connection,
}

/// The forms of a characteristic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Model {
    /// R = alpha / F
    Alpha,
    /// F = F_1k (R / 1 kohm)^-exponent
    Power,
    /// The pairs themselves, and interpolation between them
    Table,
}

/// What a calibration is written to.
#[derive(Debug, Args)]
pub struct Update {
    /// Which channel [default: the only one]
    #[arg(long, value_name = "ID")]
    pub channel: Option<String>,
    /// The configuration file of the daemon; a copy of it is kept when it is changed
    #[arg(long, value_name = "FILE", default_value = "/etc/cermd/cermd.toml")]
    pub config: PathBuf,
    /// Change the configuration without asking
    #[arg(long)]
    pub yes: bool,
    /// The result as a line of JSON
    #[arg(long)]
    pub json: bool,
}

impl ValueEnum for Method {
    fn value_variants<'a>() -> &'a [Method] {
        &Method::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.as_str()))
    }
}

fn ohm(text: &str) -> Result<f64, String> {
    let value = text.parse().or_else(|_| text.parse::<Ohm>().map(|ohm| ohm.0)).unwrap_or(f64::NAN);
    if (0.0..=1e6).contains(&value) {
        Ok(value)
    } else {
        Err("a resistance in ohm, such as 10.03".to_owned())
    }
}

/// Reads a number above 0; its error says what of, such as what.
fn number_of(what: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let value = text.parse().ok().filter(|value| *value > 0.0 && *value <= 1e9);
        value.ok_or_else(|| format!("a number of {what}"))
    }
}

fn offset(text: &str) -> Result<OffsetSource, String> {
    match text.parse()? {
        OffsetSource::Given(d_ns) if d_ns.abs() >= LONGEST_LATENCY.as_ns() => {
            Err("a latency is below 1 ms, such as 8 us".to_owned())
        }
        source => Ok(source),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_parsers_are_consistent() {
        Cermd::command().debug_assert();
        Cermctl::command().debug_assert();
    }

    #[test]
    fn the_help_names_every_board() {
        let help = Cermctl::command().find_subcommand_mut("demo").unwrap().render_long_help().to_string();
        for name in crate::pins::sim::Scene::builtin_names() {
            assert!(help.contains(name), "{name}");
        }
    }
}
