//! `force = { .. }`: the four ways to say how the resistance of a sensor becomes a force.
//!
//! `{ fc1 = "5.75 N", fc2 = "1.05 N" }`, `{ alpha = "13346 N ohm" }`, `{ at-1-kohm = "13.3 N", exponent = 1.05 }` or
//! `{ table = "FILE.csv" }`, a file relative to that of the configuration.

use crate::units::{Newton, NewtonOhm};
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use std::path::PathBuf;

/// A sensor's characteristic as it is written.
pub type Force = crate::estimate::force::Force<PathBuf>;

#[derive(Deserialize)]
#[serde(
    rename_all = "kebab-case",
    deny_unknown_fields,
    expecting = "one of { fc1, fc2 }, { alpha }, { at-1-kohm, exponent }, { table }"
)]
struct Table {
    fc1: Option<Newton>,
    fc2: Option<Newton>,
    alpha: Option<NewtonOhm>,
    at_1_kohm: Option<Newton>,
    exponent: Option<f64>,
    table: Option<PathBuf>,
}

impl<'de> Deserialize<'de> for Force {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Force, D::Error> {
        let Table { fc1, fc2, alpha, at_1_kohm, exponent, table } = Table::deserialize(deserializer)?;
        match (fc1, fc2, alpha, at_1_kohm, exponent, table) {
            (Some(fc1), Some(fc2), None, None, None, None) => Ok(Force::Calibrated { fc1, fc2 }),
            (None, None, Some(alpha), None, None, None) => Ok(Force::Alpha(alpha)),
            (None, None, None, Some(at_1_kohm), Some(exponent), None) => {
                Ok(Force::PowerLaw { at_1_kohm, exponent })
            }
            (None, None, None, None, None, Some(table)) => Ok(Force::Table(table)),
            _ => Err(D::Error::custom(
                "force takes one of { fc1, fc2 }, { alpha }, { at-1-kohm, exponent }, { table }",
            )),
        }
    }
}
