//! The command line of `cermctl characterize`.

use super::calibrate::ohm;
use crate::circuit::Kind;
use crate::config::LONGEST_WAIT;
use crate::reading::Method;
use crate::units::{Nanos, Seconds};
use clap::Args;
use std::path::PathBuf;

/// `cermctl characterize`.
#[derive(Debug, Args)]
pub struct Characterize {
    /// The folder for points.csv, provenance.json and the report. What is there already is not measured again
    #[arg(long, value_name = "FOLDER")]
    pub out: PathBuf,
    /// The simulated board: ideal, fpga-paper, pi-zero, pi4 or pi5, or a scene file (*.toml) [default: pi4]
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "tape")]
    pub scene: Option<String>,
    /// Read as this configuration says. With a circuit on GPIO lines, and without --scene: that circuit, with known resistors
    /// for which it asks, one after the other
    #[arg(long, value_name = "FILE", conflicts_with = "tape")]
    pub config: Option<PathBuf>,
    /// What was recorded with a known resistor on each channel
    #[arg(long, value_name = "TAPE", requires = "truth")]
    pub tape: Option<PathBuf>,
    /// The resistor of a channel of the tape as measured, such as thumb=997.3; several times for several channels
    #[arg(long, value_name = "CHANNEL=OHM", requires = "tape", value_parser = truth)]
    pub truth: Vec<(String, f64)>,
    /// Only these methods [default: all that a circuit allows]
    #[arg(long, value_delimiter = ',')]
    pub method: Vec<Method>,
    /// Only these wirings [default: all that the scene has capacitors for]
    #[arg(long, value_delimiter = ',', conflicts_with_all = ["config", "tape"])]
    pub circuit: Vec<Kind>,
    /// Only these resistances, such as "100 ohm,4.7 kohm" [default: four over the range; live: as they are typed]
    #[arg(long, value_name = "OHM", value_delimiter = ',', value_parser = known_ohm, conflicts_with = "tape")]
    pub r: Vec<f64>,
    /// Only means over these times, such as "0 s,100 ms"; 0 s: each reading [default: each, and 10 ms to 10 s; live: each, and 1 s]
    #[arg(long, value_name = "DURATION", value_delimiter = ',', value_parser = average, conflicts_with = "tape")]
    pub average: Vec<Nanos>,
    /// So many simulated instruments for each point, each on a board of its own [default: as many as there is time for]
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub instruments: Option<u64>,
    /// Of the first of them [default: the scene's own]
    #[arg(long, value_name = "NUMBER", conflicts_with = "tape")]
    pub seed: Option<u64>,
    /// The maps of where methods fail, too [default: unless --method, --circuit, --r or --average is given; not of fpga-paper]
    #[arg(long, conflicts_with = "tape")]
    pub maps: bool,
}

/// A resistor that is known.
pub fn known_ohm(text: &str) -> Result<f64, String> {
    ohm(text)
        .ok()
        .filter(|ohm| *ohm > 0.0)
        .ok_or_else(|| "a resistance above 0, such as \"4.7 kohm\"".to_owned())
}

fn truth(text: &str) -> Result<(String, f64), String> {
    let (channel, ohm) = text.rsplit_once('=').ok_or("a channel and its resistor, such as thumb=997.3")?;
    Ok((channel.to_owned(), known_ohm(ohm)?))
}

fn average(text: &str) -> Result<Nanos, String> {
    let time: Nanos = text.parse().map_err(|error| format!("{error}"))?;
    let is_right = (Nanos::ZERO..=LONGEST_WAIT).contains(&time);
    is_right
        .then_some(time)
        .ok_or_else(|| format!("at most {}, such as \"100 ms\"", Seconds::from(LONGEST_WAIT)))
}
