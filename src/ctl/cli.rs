//! The command lines of both programs: arguments and their help texts, from which the manual pages are made, too.
#![expect(missing_docs, reason = "a text at a flattened group would replace that of its verb")]

mod bridge;
mod calibrate;
mod characterize;
mod setup;
mod size;

pub use bridge::{Bridge, BridgeTo, Feeding, Iio, Mqtt, Page, Prometheus, Web};
pub use calibrate::{Calibrate, CalibrateBy, Force, Model, Reference, Tare, Update, Zero};
pub use characterize::{Characterize, known_ohm};
pub use setup::Setup;
pub use size::{SensorName, Size};

use crate::circuit::Kind;
use crate::instrument::settings::OffsetSource;
use crate::reading::Method;
use crate::record::LONGEST_LATENCY;
use crate::units::ForceUnit;
use clap::builder::PossibleValue;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// What to say to somebody without hardware.
pub const NO_HARDWARE: &str = "Without hardware: `cermctl demo` shows live readings of a simulated circuit; a file with \
                               [gpio] backend = \"mock\" and [mock] scene = \"pi4\" makes this daemon serve one.";

/// The arguments of this process; or the exit status, once the help, the version or the mistake is printed, or could not be.
pub fn arguments<T: Parser>() -> Result<T, ExitCode> {
    T::try_parse().map_err(|error| {
        let printed = error.print().and_then(|()| io::stdout().flush());
        match printed {
            // Whoever reads our output has had enough.
            Err(why) if why.kind() != io::ErrorKind::BrokenPipe => {
                // If nobody can be told, the status says it.
                let _ = writeln!(io::stderr(), "standard output: {why}");
                ExitCode::FAILURE
            }
            _ => ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(1)),
        }
    })
}

/// Measures resistances by timing RC discharges over GPIO lines, and streams them on a unix socket.
#[derive(Debug, Parser)]
#[command(name = "cermd", version, after_help = NO_HARDWARE)]
pub struct Cermd {
    #[command(flatten)]
    pub file: ConfigFile,
    /// Check the configuration, say what is found, and exit
    #[arg(long)]
    pub check: bool,
    /// Make every line an input that was asked for, and exit: for after a kill. Where $RUNTIME_DIRECTORY does not tell,
    /// those that the configuration names
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
    /// Find the circuit for a sensor: capacitors, resistors and settings for a wanted error or rate, with what to expect of it
    Size(Size),
    /// List the GPIO chips and lines of this machine, and who holds which
    Lines(Lines),
    /// Write readings, or the timings of discharges, to a file
    Record(Record),
    /// Estimate again from the timings on a tape
    Estimate(Estimate),
    /// Measure the zero or the force characteristic of a sensor, and put it into the configuration
    Calibrate(Calibrate),
    /// Measure error against time of every method, circuit and mean, and where they fail: simulated, live, or from a tape
    Characterize(Characterize),
    /// Tare: what lies on a sensor now counts as no force (the zero of its resistance is `calibrate zero`)
    Zero(Tare),
    /// Set the instrument up, from wires to the first reading: chip, configuration, test, service, zero; --undo takes it back
    Setup(Setup),
    /// Tell another system what cermd reads, until Ctrl-C; survives restarts of both
    Bridge(Bridge),
    /// Serve a page for browsers: every channel live, and the health of the instrument
    Web(Web),
}

const SECONDS: &str = "seconds above 0, such as 2.5";

/// Where the service has its configuration.
pub const CONFIGURATION: &str = "/etc/cermd/cermd.toml";

/// Where the configuration is, for every program and verb.
#[derive(Debug, Args)]
pub struct ConfigFile {
    /// The configuration file, see cermd.toml(5)
    #[arg(long = "config", value_name = "FILE", default_value = CONFIGURATION)]
    pub path: PathBuf,
}

/// Where the daemon listens.
#[derive(Debug, Args)]
pub struct Connection {
    /// The socket of the daemon
    #[arg(long, value_name = "PATH", env = "CERMD_SOCKET", default_value = "/run/cermd/cermd.sock")]
    pub socket: PathBuf,
}

/// `cermctl demo`.
#[derive(Debug, Clone, Args)]
pub struct Demo {
    /// The simulated board: ideal, fpga-paper, pi-zero, pi4 or pi5, with a hand pressing an FSR 402; or a scene file
    /// (*.toml) with its own sensors
    #[arg(long, value_name = "NAME|FILE", default_value = "pi4")]
    pub scene: String,
    /// How long to measure
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = number_of(SECONDS), allow_negative_numbers = true)]
    pub seconds: f64,
    /// Of every random number [default: the scene's own]
    #[arg(long, value_name = "NUMBER")]
    pub seed: Option<u64>,
    /// How to estimate [default: the best that the circuit allows]
    #[arg(long)]
    pub method: Option<Method>,
    /// How it is wired [default: as the scene, or as the method needs it]
    #[arg(long)]
    pub wiring: Option<Kind>,
    /// All methods side by side on the same sensor: what each reads, how far off it is, how fast; then error against time.
    /// On anything but a terminal as fast as it can be computed
    #[arg(long, conflicts_with = "method")]
    pub compare: bool,
    #[command(flatten)]
    pub shown: ForceUnitArg,
}

/// What forces are shown in; lines for machines are always in newton.
#[derive(Debug, Clone, Args)]
pub struct ForceUnitArg {
    /// What forces are shown in; a mass stands for its weight
    #[arg(long, value_enum, default_value = "N", ignore_case = true)]
    pub unit: ForceUnit,
}

impl ValueEnum for ForceUnit {
    fn value_variants<'a>() -> &'a [ForceUnit] {
        &ForceUnit::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.as_str()))
    }
}

/// By the names of the drawings.
impl ValueEnum for Kind {
    fn value_variants<'a>() -> &'a [Kind] {
        &[Kind::OneCapacitor, Kind::TwoCapacitor, Kind::SeriesCalibration]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self {
            Kind::OneCapacitor => ("one", "One capacitor: least parts, most readings a second"),
            Kind::TwoCapacitor => ("two", "Two capacitors: each reading can be checked by a second crossing"),
            Kind::SeriesCalibration => ("series", "One capacitor, Rc2 in series with Rc1: for qerm"),
        };
        Some(PossibleValue::new(name).help(help))
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
    #[command(flatten)]
    pub shown: ForceUnitArg,
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
    #[command(flatten)]
    pub shown: ForceUnitArg,
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
    #[command(flatten)]
    pub file: ConfigFile,
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
    #[arg(long, value_name = "SECONDS", value_parser = number_of(SECONDS), allow_negative_numbers = true, conflicts_with = "count")]
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
    #[arg(long, value_name = "DURATION|auto", value_parser = offset, allow_hyphen_values = true)]
    pub offset: Option<OffsetSource>,
    /// What all estimates come to, in the place of each: for each channel and method how many numbers, their mean, their
    /// standard deviation, the uncertainty that they state, and the root mean square of their deviations in units of that
    #[arg(long)]
    pub summary: bool,
    /// The summary as lines of JSON, as estimates always are
    #[arg(long, requires = "summary")]
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

    /// Every default that a configuration file has, below a command.
    fn default_files(command: &clap::Command) -> Vec<(String, String)> {
        let own = command.get_arguments().filter(|argument| argument.get_long() == Some("config"));
        let own = own.flat_map(clap::Arg::get_default_values).map(|file| file.to_string_lossy().into_owned());
        let own = own.map(|file| (command.get_name().to_owned(), file));
        own.chain(command.get_subcommands().flat_map(default_files)).collect()
    }

    #[test]
    fn the_configuration_is_in_one_place() {
        let files = [default_files(&Cermd::command()), default_files(&Cermctl::command())].concat();
        for name in ["cermd", "check", "zero", "reference", "force"] {
            assert!(files.iter().any(|(command, _)| command == name), "{name}: {files:?}");
        }
        assert!(files.iter().all(|(_, file)| file == "/etc/cermd/cermd.toml"), "{files:?}");
    }

    #[test]
    fn the_help_names_every_board() {
        let help = Cermctl::command().find_subcommand_mut("demo").unwrap().render_long_help().to_string();
        for name in crate::pins::sim::Scene::builtin_names() {
            assert!(help.contains(name), "{name}");
        }
    }
}
