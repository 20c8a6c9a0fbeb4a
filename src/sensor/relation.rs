//! What every law beside force answers, and what may be wrong with the numbers that several have.

use super::limits::{LONGEST_UNIT, PARTS_OHM};
use super::{Defect, Shown};
use crate::units::Ohm;
use std::cmp::Ordering;

/// A law of one kind.
pub(super) trait Relation {
    /// What the values are in.
    fn unit(&self) -> &str;
    /// What it says at a resistance, ohm; `None`: nothing.
    fn shown(&self, r_ohm: f64) -> Option<Shown>;
    /// What is wrong with its numbers.
    fn defect(&self) -> Option<Defect>;
}

/// What is wrong with a resistance of a part.
pub(super) fn defect_of_part(name: &str, r_ohm: f64) -> Option<Defect> {
    (!PARTS_OHM.contains(&r_ohm)).then(|| {
        (format!("{name} = {} is beyond any sensor", Ohm(r_ohm)), "another prefix: M is mega, m is milli")
    })
}

/// What is wrong with a relative uncertainty.
pub(super) fn defect_of_share(name: &str, u: Option<f64>) -> Option<Defect> {
    let u = u.filter(|u| !(*u > 0.0 && *u <= 1.0))?;
    Some((
        format!("{name} = {} % is not above 0 % and up to 100 %", 100.0 * u),
        "1 sigma: a tolerance of +-5 % is u = \"2.9 %\"",
    ))
}

/// What is wrong with the two ends of where a law holds.
pub(super) fn defect_of_range(range: Option<[f64; 2]>, remedy: &'static str) -> Option<Defect> {
    let [least, greatest] =
        range.filter(|[least, greatest]| least.partial_cmp(greatest) != Some(Ordering::Less))?;
    Some((format!("range: {least} is not below {greatest}"), remedy))
}

/// What is wrong with the name of a unit.
pub(super) fn defect_of_unit(unit: &str) -> Option<Defect> {
    let reason = if unit.trim() != unit || unit.is_empty() || unit.contains(char::is_control) {
        format!("unit = {unit:?} is empty, or has blanks around it or control characters")
    } else if unit.len() > LONGEST_UNIT {
        format!("unit = {unit:?} is longer than {LONGEST_UNIT} bytes")
    } else if matches!(unit, "N" | "ohm") {
        return Some((
            format!("unit = {unit:?} is what a channel has without a law"),
            "force = { table = \"FILE.csv\" } for forces, no law for ohms",
        ));
    } else {
        return None;
    };
    Some((reason, "\"degC\", \"lx\", \"mm\", \"%\""))
}
