//! `force = { .. }`: the four ways to say how the resistance of a sensor becomes a force, and how well that is known.
//!
//! `{ fc1 = "5.75 N", fc2 = "1.05 N" }`, `{ alpha = "13346 N ohm" }`, `{ at-1-kohm = "13.3 N", exponent = 1.05 }` or
//! `{ table = "FILE.csv" }`, a file relative to that of the configuration; each with `u = "8.7 %"`, how far the sensor is off
//! that (relative deviation of its resistance, 1 sigma), and `range = ["0.5 N", "20 N"]`, the forces that this was found with, and
//! `tare = "0.5 N"`, what is taken off every force.

use crate::sensor::Law;
use crate::units::{Newton, NewtonOhm, Percent};
use serde::Deserialize;
use std::path::PathBuf;

/// A sensor's characteristic as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Written")]
pub struct Characteristic {
    /// How force follows from resistance.
    pub law: ForceSource,
    /// How far the sensor is off that, relative.
    pub u: Option<f64>,
    /// The forces that it was found with, newton.
    pub range_n: Option<[f64; 2]>,
    /// What is taken off every force, newton.
    pub tare_n: Option<f64>,
}

/// Where a characteristic is.
#[derive(Debug, Clone, PartialEq)]
pub enum ForceSource {
    /// Here, with all of its numbers.
    Given(Law),
    /// In the file of its table.
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
    u: Option<Percent>,
    range: Option<[Newton; 2]>,
    tare: Option<Newton>,
}

impl TryFrom<Written> for Characteristic {
    type Error = &'static str;

    fn try_from(written: Written) -> Result<Characteristic, &'static str> {
        let Written { fc1, fc2, alpha, at_1_kohm, exponent, table, u, range, tare } = written;
        let law = match (fc1, fc2, alpha, at_1_kohm, exponent, table) {
            (Some(fc1), Some(fc2), None, None, None, None) => {
                ForceSource::Given(Law::Calibrated { fc1_n: fc1.0, fc2_n: fc2.0 })
            }
            (None, None, Some(alpha), None, None, None) => {
                ForceSource::Given(Law::Alpha { alpha_n_ohm: alpha.0 })
            }
            (None, None, None, Some(at_1_kohm), Some(exponent), None) => {
                ForceSource::Given(Law::Power { at_1_kohm_n: at_1_kohm.0, exponent })
            }
            (None, None, None, None, None, Some(table)) => ForceSource::File(table),
            _ => {
                return Err("force takes one of { fc1, fc2 }, { alpha }, { at-1-kohm, exponent }, { table }");
            }
        };
        let range_n = range.map(|range| range.map(|force| force.0));
        Ok(Characteristic { law, u: u.map(|u| u.0 / 100.0), range_n, tare_n: tare.map(|tare| tare.0) })
    }
}

#[cfg(test)]
impl From<Law> for Characteristic {
    fn from(law: Law) -> Characteristic {
        Characteristic { law: ForceSource::Given(law), u: None, range_n: None, tare_n: None }
    }
}
