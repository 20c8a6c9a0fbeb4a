//! The arguments of `cermctl size`.

use crate::circuit::Kind;
use crate::size::{self, Stock, Wanted};
use crate::units::{Ampere, Hertz, Newton, Ohm};
use clap::{ArgGroup, Args, ValueEnum};
use std::path::PathBuf;

/// `cermctl size`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("wanted").required(true).multiple(true).args(["error", "rate"]))]
#[command(group = ArgGroup::new("range").required(true).args(["r", "sensor"]))]
pub struct Size {
    /// From the least to the greatest resistance of the sensor, such as 100ohm..100kohm
    #[arg(long, value_name = "FROM..TO", value_parser = size::ohms)]
    pub r: Option<[Ohm; 2]>,
    /// A sensor whose range is that of its forces
    #[arg(long, value_enum, requires = "force")]
    pub sensor: Option<SensorName>,
    /// From the least to the greatest force, such as 0.2N..20N
    #[arg(long, value_name = "FROM..TO", value_parser = size::newtons, requires = "sensor", conflicts_with = "r")]
    pub force: Option<[Newton; 2]>,
    /// How uncertain a reading may be, 1 sigma: of the reading, in ohm or in newton, such as 0.5%, 2ohm or 0.02N
    /// [default: as little as the rate allows]
    #[arg(long, value_name = "ERROR", value_parser = Wanted::parse)]
    pub error: Option<Wanted>,
    /// Readings per second at the least, such as 200Hz [default: as many as the error allows]
    #[arg(long, value_name = "HERTZ", value_parser = size::rate)]
    pub rate: Option<Hertz>,
    /// The board: pi4, pi5 or pi-zero, or a scene file (*.toml) whose noise was measured
    #[arg(long, visible_alias = "board", value_name = "NAME|FILE", default_value = "pi4")]
    pub scene: String,
    /// What a pin may carry, such as 8mA [default: 16 mA of a pi-zero, 12 mA of a pi5, 8 mA else]
    #[arg(long, value_name = "CURRENT", value_parser = size::pin_current)]
    pub pin_current: Option<Ampere>,
    /// Build from these capacitors and calibration resistors, as many of each as it takes, such as "2.2uF, 680nF, 470ohm,
    /// 10kohm" [default: film capacitors of E12, resistors of E96]
    #[arg(long, value_name = "PARTS")]
    pub have: Option<Stock>,
    /// How it is wired [default: whatever is better]
    #[arg(long)]
    pub wiring: Option<Kind>,
    /// Write a configuration for the circuit, with comments on what to measure; the file must not be there yet
    #[arg(long, value_name = "FILE")]
    pub write: Option<PathBuf>,
    /// The result as a line of JSON
    #[arg(long)]
    pub json: bool,
}

/// Sensors whose characteristic is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SensorName {
    /// Force-sensing resistor, F = 13.3 kN ohm / R
    Fsr402,
}
