//! `law = { kind = .. }`: how the resistance of a sensor becomes something else than a force, and how well that is known.
//!
//! `{ kind = "ntc", r25 = "10 kohm", beta = "3950 K", u = "1 %" }`, `{ kind = "ntc", a = .., b = .., c = .. }`,
//! `{ kind = "pt1000", class = "B" }`, `{ kind = "ldr", at-10-lux = "15 kohm", gamma = 0.7 }`,
//! `{ kind = "position", r0 = "20 ohm", r1 = "10 kohm", span = "100 mm" }` or `{ kind = "table", table = "FILE.csv", unit = "degC" }`,
//! a file relative to that of the configuration. Every uncertainty is 1 sigma.

use crate::sensor::Transducer;
use crate::sensor::ldr::Ldr;
use crate::sensor::ntc::{Curve, Ntc};
use crate::sensor::position::Position;
use crate::sensor::pt1000::{Class, Pt1000};
use crate::units::{Celsius, Degree, Kelvin, Lux, Metre, Ohm, Percent};
use serde::Deserialize;
use std::path::PathBuf;

/// A law as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Written")]
pub enum LawSource {
    /// Here, with all of its numbers.
    Given(Transducer),
    /// In the file of its table.
    File {
        /// The file.
        table: PathBuf,
        /// What its values are in.
        unit: String,
        /// How far the sensor's resistance is off it, relative, 1 sigma.
        u: Option<f64>,
    },
}

#[derive(Deserialize)]
#[serde(
    tag = "kind",
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case",
    deny_unknown_fields,
    expecting = "a law such as { kind = \"ntc\", r25 = \"10 kohm\", beta = \"3950 K\" }"
)]
enum Written {
    Ntc {
        r25: Option<Ohm>,
        beta: Option<Kelvin>,
        beta_u: Option<Percent>,
        a: Option<f64>,
        b: Option<f64>,
        c: Option<f64>,
        u: Option<Percent>,
        range: Option<[Celsius; 2]>,
    },
    Pt1000 {
        class: Option<Class>,
    },
    Ldr {
        at_10_lux: Ohm,
        gamma: f64,
        gamma_u: Option<f64>,
        u: Option<Percent>,
        range: Option<[Lux; 2]>,
    },
    Position {
        r0: Ohm,
        r1: Ohm,
        span: String,
        u: Option<String>,
    },
    Table {
        table: PathBuf,
        unit: String,
        u: Option<Percent>,
    },
}

/// Of percent.
fn share(percent: Percent) -> f64 {
    percent.0 / 100.0
}

impl TryFrom<Written> for LawSource {
    type Error = String;

    fn try_from(written: Written) -> Result<LawSource, String> {
        Ok(LawSource::Given(match written {
            Written::Ntc { r25, beta, beta_u, a, b, c, u, range } => {
                let curve = match (r25, beta, beta_u, a, b, c) {
                    (Some(r25), Some(beta), beta_u, None, None, None) => {
                        Curve::Beta { r25_ohm: r25.0, beta_k: beta.0, beta_u: beta_u.map(share) }
                    }
                    (None, None, None, Some(a_per_k), Some(b_per_k), Some(c_per_k)) => {
                        Curve::SteinhartHart { a_per_k, b_per_k, c_per_k }
                    }
                    _ => return Err("an ntc takes r25 and beta, or a, b and c".to_owned()),
                };
                let range_degc = range.map(|range| range.map(|end| end.0));
                Transducer::Ntc(Ntc { curve, u: u.map(share), range_degc })
            }
            Written::Pt1000 { class } => Transducer::Pt1000(Pt1000 { class }),
            Written::Ldr { at_10_lux, gamma, gamma_u, u, range } => {
                let range_lx = range.map(|range| range.map(|end| end.0));
                Transducer::Ldr(Ldr { at_10_lx_ohm: at_10_lux.0, gamma, gamma_u, u: u.map(share), range_lx })
            }
            Written::Position { r0, r1, span, u } => {
                let (span, unit) = extent("span", &span)?;
                let u = u.map(|u| extent("u", &u)).transpose()?;
                if let Some((_, other)) = u.filter(|(_, other)| *other != unit) {
                    return Err(format!("u is in {other}, and span in {unit}: write both in the same"));
                }
                let u = u.map(|(u, _)| u);
                Transducer::Position(Position { r0_ohm: r0.0, r1_ohm: r1.0, span, unit: unit.to_owned(), u })
            }
            Written::Table { table, unit, u } => return Ok(LawSource::File { table, unit, u: u.map(share) }),
        }))
    }
}

/// A length in mm, an angle in deg, or a part in %.
fn extent(key: &str, text: &str) -> Result<(f64, &'static str), String> {
    let length = text.parse().map(|Metre(length)| (1e3 * length, "mm"));
    let angle = text.parse().map(|Degree(angle)| (angle, "deg"));
    let part = text.parse().map(|Percent(part)| (part, "%"));
    length.or(angle).or(part).map_err(|_| {
        format!("{key} = {text:?} is no length, angle or part: write \"100 mm\", \"270 deg\" or \"100 %\"")
    })
}
