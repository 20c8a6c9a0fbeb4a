//! The command lines of what changes a configuration: `cermctl calibrate` and `cermctl zero`.

use super::{ConfigFile, Connection, ForceUnitArg};
use crate::units::Ohm;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

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
    /// The resistor as measured, such as "10.03 ohm"
    #[arg(value_name = "OHM", value_parser = ohm, allow_hyphen_values = true)]
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

/// `cermctl zero`.
#[derive(Debug, Args)]
pub struct Tare {
    /// Take the tare away: all that lies on the sensor counts again
    #[arg(long, conflicts_with = "count")]
    pub clear: bool,
    /// How many readings to average
    #[arg(long, value_name = "NUMBER", default_value = "20", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub count: u64,
    #[command(flatten)]
    pub shown: ForceUnitArg,
    #[command(flatten)]
    pub update: Update,
    #[command(flatten)]
    pub connection: Connection,
}

/// What a calibration is written to; a copy of the file as it was is kept.
#[derive(Debug, Args)]
pub struct Update {
    /// Which channel [default: the only one]
    #[arg(long, value_name = "ID")]
    pub channel: Option<String>,
    #[command(flatten)]
    pub file: ConfigFile,
    /// Change the configuration without asking
    #[arg(long)]
    pub yes: bool,
    /// The result as a line of JSON
    #[arg(long)]
    pub json: bool,
}

pub(super) fn ohm(text: &str) -> Result<f64, String> {
    // The unit of a number alone is in the name of the argument.
    let value =
        text.parse().or_else(|_| text.parse::<Ohm>().map(|ohm| ohm.0)).map_err(|error| error.to_string())?;
    if (0.0..=1e6).contains(&value) {
        Ok(value)
    } else {
        Err("a resistance of 0 to 1 Mohm, such as \"10.03 ohm\"".to_owned())
    }
}
