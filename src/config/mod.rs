//! The configuration: one TOML file, kebab-case, every quantity with its unit.
//!
//! For: what a user may decide, with defaults derived from the circuit; [`Config::check`], which says what is wrong and
//! what to do; and from there to settings, pins and the header of a tape. Must not know: how anything is measured.
//!
//! Unknown keys, wrong units and wrong types are refused while parsing, with line and caret; values that parse but
//! cannot work are [findings](Finding).
//!
//! ```
//! use cermd::config::Config;
//!
//! let text = r#"
//!     circuit = { kind = "one-capacitor", c = "470 nF", r-c1 = "12.7 kohm", r-c2 = "470 ohm" }
//!     channel = [{ id = "thumb" }]
//! "#;
//! let findings = Config::parse(text, "example")?.check();
//! assert_eq!(findings.0[0].key, "circuit.r-c1");
//! assert!(findings.has_errors());
//! # Ok::<(), cermd::config::ConfigError>(())
//! ```

pub mod backend;
mod charge;
pub(crate) mod check;
mod circuit;
mod derived;
mod finding;
mod force;
mod gpio;
mod law;
mod limits;
mod number;
#[doc(hidden)]
pub mod pairs;
mod settings;
mod trigger;

pub use finding::{Finding, Findings, Severity};
pub use force::{Characteristic, ForceSource};
pub use gpio::{Backend, Gpio, LineName};
pub use law::LawSource;
pub use limits::{LARGEST_ZERO_OHM, LONGEST_WAIT, STRONGEST_PIN_A, pin_limit_a};
pub use settings::{SettingsError, tape_header};
pub use trigger::{OutputTable, TriggerSettings, When};

use crate::circuit::Circuit;
use crate::files::{self, FileError};
use crate::instrument::settings::OffsetSource;
use crate::pins::realtime::Wishes;
use crate::reading::Method;
use crate::units::{Micros, Millis, Nanos, Ticks};
use serde::Deserialize;
use serde::de::{self, Deserializer};
use std::io;
use std::path::{Path, PathBuf};

/// Everything the file says.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Config {
    /// The parts on the board. Required.
    #[serde(deserialize_with = "circuit::deserialize")]
    pub circuit: Circuit,
    /// The GPIO lines. Default: the simulated circuit of `[mock]`.
    #[serde(default)]
    pub gpio: Gpio,
    /// How to measure. Default: derived from the circuit.
    #[serde(default)]
    pub measure: Measure,
    /// What makes waiting more precise. Default: nothing is asked for.
    #[serde(default)]
    pub realtime: Wishes,
    /// The sensors, 1 to [`MAX_CHANNELS`](crate::pins::MAX_CHANNELS) of them.
    #[serde(default, rename = "channel")]
    pub channels: Vec<ChannelTable>,
    /// Where readings are served.
    #[serde(default)]
    pub server: Server,
    /// The simulated circuit. Default: none.
    pub mock: Option<Mock>,
    /// The folder that the names of files count from: that of the configuration file.
    #[serde(skip)]
    pub base: PathBuf,
}

/// `[measure]`: how to measure. Everything has a default.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Measure {
    /// The method. Default: `tracked`, or `qerm` with series calibration.
    pub method: Option<Method>,
    /// Readings of each channel per second, hertz, at least one in a minute (0.017); each of them is the mean over the time since
    /// the one before.
    /// Default: as fast as the circuit allows.
    #[serde(deserialize_with = "number::optional")]
    pub rate_hz: Option<f64>,
    /// What is published is the mean over this time, up to 1 min. Default: each reading, or what `rate-hz` leaves; shorter than that:
    /// with a rest until the next one.
    pub average: Option<Nanos>,
    /// With `rate-hz`: no more discharges than that needs. Default: spare time goes into accuracy.
    pub idle: bool,
    /// How long node A is charged before each discharge, above 0 up to 1 min; B's charger follows for half of its time
    /// constant where B is waited for. Default: the shortest charge whose being incomplete (most of which cancels) changes a
    /// reading by no more than a tenth of its uncertainty: 7 to 10 time constants.
    #[serde(deserialize_with = "number::duration::<_, Millis>")]
    pub charge_time: Option<Nanos>,
    /// The pause between the end of the charge and the start of the discharge, 0 to 1 min. Default: what the calls between
    /// them take.
    #[serde(deserialize_with = "number::duration::<_, Micros>")]
    pub settle_time: Option<Nanos>,
    /// The longest discharge through a sensor, up to 1 min, and not below the predicted discharge through Rc2 (Rc1 +
    /// Rc2 where they are in series); a higher resistance reads `open`. Default: 5 times that discharge; of `tracked` less, down
    /// to 2 times, where `rate-hz` or `average` ask for readings sooner.
    #[serde(deserialize_with = "number::duration::<_, Millis>")]
    pub deadline: Option<Nanos>,
    /// The latency offset d of the crossings, 0 to 1 ms. Default: `auto`, as split discharges show it, one in eight cycles. In
    /// `tpcm` and `tcdic` it cancels; they use what these discharges show of dielectrics, and take none with `0 us`.
    #[serde(deserialize_with = "number::offset")]
    pub offset: Option<OffsetSource>,
    /// Period of the clock that stamps crossings, 1 ns to 1 ms. Default: 1 ns, as Linux counts.
    #[serde(deserialize_with = "number::duration::<_, Ticks>")]
    pub resolution: Option<Nanos>,
    /// Where the calibration of `tpcm`, `tcdic` and `cerm` comes from; that of `tracked` is tracked. Default:
    /// `each-reading`.
    pub calibration: Option<Calibration>,
    /// Time limit T_L of eq. (19): a discharge whose T_xA is below it is finished through Rc2; 0 or above. Default: where the
    /// predicted uncertainties of both branches cross.
    #[serde(deserialize_with = "number::duration::<_, Millis>")]
    pub t_l: Option<Nanos>,
    /// The planned switch comes at this fraction of the predicted T_xA, above 0 and below 1.3. Default: 0.9.
    #[serde(deserialize_with = "number::optional")]
    pub switch_fraction: Option<f64>,
}

impl Measure {
    /// From one reading to the next, as `rate-hz` asks.
    fn every(&self) -> Option<Nanos> {
        self.rate_hz.map(|hertz| Nanos::from_seconds(1.0 / hertz))
    }
}

/// How often the calibration discharges are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Calibration {
    /// Anew for each reading.
    EachReading,
    /// As often as they pay; in between, the calibration is followed.
    Tracked,
}

/// `[[channel]]`: one sensor.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct ChannelTable {
    /// Its name in the stream, unique. Required.
    pub id: String,
    /// The line that sinks the sensor's far end. Required, except with the simulated circuit.
    pub sink: Option<LineName>,
    /// What the instrument reads with a short circuit in the sensor's place, ohm; subtracted. Default: not known, and in the
    /// uncertainty.
    #[serde(default, deserialize_with = "number::optional")]
    pub zero_ohm: Option<f64>,
    /// What it reads with a known resistor there, less the zero, as a part of its resistance; divided by. Default: as for the
    /// zero.
    #[serde(default, deserialize_with = "number::optional")]
    pub scale: Option<f64>,
    /// Of so many cycles, 1 to 1000, it is read in one. Default: 1, in each.
    #[serde(default = "each")]
    pub every: u32,
    /// How resistance becomes force. Default: not at all, the channel gives ohm only.
    pub force: Option<Characteristic>,
    /// How it becomes something else. Default: not at all; not with a force.
    pub law: Option<LawSource>,
    /// Pressed from here on upwards, in what the channel shows or in ohm. Default: the channel has no trigger.
    pub on_above: Option<String>,
    /// Released below this. Default: 0.8 of `on-above`; none in the unit of a law.
    pub off_below: Option<String>,
    /// Pressed from here on downwards, in the place of `on-above`.
    pub on_below: Option<String>,
    /// Released above this. Default: 1.25 of `on-below`; none in the unit of a law.
    pub off_above: Option<String>,
    /// How long all numbers must be beyond a threshold, 0 to 1 min. Default: 0, the first one is enough.
    #[serde(default, deserialize_with = "number::duration::<_, Millis>")]
    pub hold: Option<Nanos>,
    /// How long the last number is good for, up to 1 min; after that the state is not known. Default: three times the longest
    /// time between two readings, and 100 ms at least.
    pub stale: Option<Nanos>,
    /// The line that follows the trigger. Default: none.
    pub output: Option<OutputTable>,
}

/// In each cycle.
fn each() -> u32 {
    1
}

impl ChannelTable {
    /// A sensor whose zero and scale have been measured.
    pub fn commissioned(id: &str, zero_ohm: f64) -> ChannelTable {
        ChannelTable {
            id: id.to_owned(),
            zero_ohm: Some(zero_ohm),
            scale: Some(1.0),
            ..ChannelTable::default()
        }
    }
}

impl Default for ChannelTable {
    /// A sensor without a name, of which nothing is known.
    fn default() -> ChannelTable {
        ChannelTable {
            id: String::new(),
            sink: None,
            zero_ohm: None,
            scale: None,
            every: each(),
            force: None,
            law: None,
            on_above: None,
            off_below: None,
            on_below: None,
            off_above: None,
            hold: None,
            stale: None,
            output: None,
        }
    }
}

/// `[server]`: the socket that clients connect to.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Server {
    /// Path, at most 107 bytes. Default: `/run/cermd/cermd.sock`.
    pub socket: PathBuf,
    /// Permissions of the socket, written as octal digits in a string. Default: `"0660"`, owner and group.
    #[serde(deserialize_with = "permissions")]
    pub mode: u32,
}

impl Default for Server {
    fn default() -> Server {
        Server { socket: PathBuf::from("/run/cermd/cermd.sock"), mode: 0o660 }
    }
}

fn permissions<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    let text = String::deserialize(deserializer)?;
    let mode = u32::from_str_radix(&text, 8).ok().filter(|mode| *mode <= 0o777 && !text.starts_with('+'));
    mode.ok_or_else(|| {
        de::Error::custom(format!("expected octal permissions such as \"0660\", got \"{text}\""))
    })
}

/// `[mock]`: the simulated circuit.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Mock {
    /// A scene file (its name ends in `.toml`), or the name of a built-in scene. Required.
    pub scene: String,
    /// Seed of its noise. Default: the scene's own.
    pub seed: Option<u64>,
}

/// A configuration that cannot be read: the file, with line and caret, and what to do. Values that cannot work are [findings](Finding) instead.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ConfigError(String);

impl Config {
    /// With everything but these as it is where a file says nothing.
    pub fn of(circuit: Circuit, channels: Vec<ChannelTable>) -> Config {
        Config {
            circuit,
            channels,
            gpio: Gpio::default(),
            measure: Measure::default(),
            realtime: Wishes::default(),
            server: Server::default(),
            mock: None,
            base: PathBuf::new(),
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read or parsed.
    pub fn load(path: &Path) -> Result<Config, ConfigError> {
        let unread = FileError::at(path, |error| match error.kind() {
            io::ErrorKind::NotFound => {
                "`cermctl setup` writes one, --config names another, and `cermctl demo` needs none"
            }
            _ => files::hint(error),
        });
        let text = files::read_text(path, files::SETTINGS_BYTES);
        let text = text.map_err(|error| ConfigError(unread(error).to_string()))?;
        Config::of_file(&text, path)
    }

    /// Reads the text of a file, beside which the files are that it names.
    ///
    /// # Errors
    /// When it cannot be parsed.
    pub fn of_file(text: &str, path: &Path) -> Result<Config, ConfigError> {
        let mut config = Config::parse(text, &path.display().to_string())?;
        config.base = path.parent().map(Path::to_owned).unwrap_or_default();
        Ok(config)
    }

    /// Reads a text; `origin` names it in errors. Relative file names count from the working directory.
    ///
    /// # Errors
    /// When it cannot be parsed.
    pub fn parse(text: &str, origin: &str) -> Result<Config, ConfigError> {
        toml::from_str(text).map_err(|error| ConfigError(format!("{origin}: {error}")))
    }
}

#[cfg(test)]
mod tests;
