//! `force = { .. }`: the four ways to say how the resistance of a sensor becomes a force.
//!
//! `{ fc1 = "5.75 N", fc2 = "1.05 N" }`, `{ alpha = "13346 N ohm" }`, `{ at-1-kohm = "13.3 N", exponent = 1.05 }` or
//! `{ table = "FILE.csv" }`, a file relative to that of the configuration.

use crate::sensor::Force;
use crate::units::{Newton, NewtonOhm};
use serde::Deserialize;
use std::path::PathBuf;

/// A sensor's characteristic as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Written")]
pub enum Characteristic {
    /// With all of its numbers.
    Given(Force),
    /// By the file that its table is in.
    File(PathBuf),
}

#[derive(Deserialize)]
#[serde(
    rename_all = "kebab-case",
    deny_unknown_fields,
    expecting = "one of { fc1, fc2 }, { alpha }, { at-1-kohm, exponent }, { table }"
)]
struct Written {
    fc1: Option<Newton>,
    fc2: Option<Newton>,
    alpha: Option<NewtonOhm>,
    at_1_kohm: Option<Newton>,
    exponent: Option<f64>,
    table: Option<PathBuf>,
}

impl TryFrom<Written> for Characteristic {
    type Error = &'static str;

    fn try_from(written: Written) -> Result<Characteristic, &'static str> {
        let Written { fc1, fc2, alpha, at_1_kohm, exponent, table } = written;
        Ok(Characteristic::Given(match (fc1, fc2, alpha, at_1_kohm, exponent, table) {
            (Some(fc1), Some(fc2), None, None, None, None) => {
                Force::Calibrated { fc1_n: fc1.0, fc2_n: fc2.0 }
            }
            (None, None, Some(alpha), None, None, None) => Force::Alpha { alpha_n_ohm: alpha.0 },
            (None, None, None, Some(at_1_kohm), Some(exponent), None) => {
                Force::Power { at_1_kohm_n: at_1_kohm.0, exponent }
            }
            (None, None, None, None, None, Some(table)) => return Ok(Characteristic::File(table)),
            _ => {
                return Err("force takes one of { fc1, fc2 }, { alpha }, { at-1-kohm, exponent }, { table }");
            }
        }))
    }
}
