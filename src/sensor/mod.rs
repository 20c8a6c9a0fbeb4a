//! What is known of a sensor before it is measured.
//!
//! For: its zero, and how its resistance becomes what it stands for, as a configuration gives them and a tape carries them: a force,
//! or by a law of another kind a temperature, an illuminance, a position. Must not know: how the resistance is measured.

pub mod force;
pub mod ldr;
mod limits;
pub mod ntc;
pub mod position;
pub mod pt1000;
mod relation;
pub mod table;
mod transducer;

pub use force::{Force, Law, Table, defect_of_bounds};
pub use limits::{ABSURD_ZERO_OHM, FSR_402, SCALES, UNCALIBRATED_N, UNCALIBRATED_U, UNLIKE_PINS_OHM};
pub use transducer::Transducer;

use crate::reading::{Bound, Measured, MeasuredValue};
use serde::{Deserialize, Serialize};

/// What is wrong with a characteristic, and what to write instead.
pub type Defect = (String, &'static str);

/// A sensor.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Channel {
    /// Its name.
    pub id: String,
    /// What a short circuit in its place reads, ohm; absent: as pins are that nobody has looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero_ohm: Option<f64>,
    /// What a known resistor in its place reads, less the zero, as a part of its resistance; absent: as for the zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Its characteristic, if it is to give forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<Force>,
    /// Its law, if it is to give something else; not with a force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<Transducer>,
}

/// What a sensor shows at a resistance, in the unit of its law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// The value.
    pub value: f64,
    /// How it changes with the resistance, per ohm.
    pub slope: f64,
    /// How far the sensor may be off its law there, 1 sigma; `None`: nobody has said.
    pub own_u: Option<f64>,
    /// It is outside of where the law is known to hold.
    pub is_extrapolated: bool,
}

impl Channel {
    /// The sensor's own resistance of one that was read, ohm.
    pub fn corrected(&self, r_ohm: f64) -> f64 {
        (r_ohm - self.zero_ohm.unwrap_or(0.0)) / self.scale.unwrap_or(1.0)
    }

    /// The other way round.
    pub fn as_read(&self, r_ohm: f64) -> f64 {
        r_ohm * self.scale.unwrap_or(1.0) + self.zero_ohm.unwrap_or(0.0)
    }

    /// What a resistance is uncertain by because the pins of the sensor and of R_1 and R_2 may differ, 1 sigma, ohm; it is the same
    /// in all readings. Theirs bend what is between: a resistance of R_1 reads too high by what the sensor's pin has more than
    /// that of R_1, and so on in proportion. A zero takes out what there is at 0 ohm, a scale the rest.
    pub fn pins_u_ohm(&self, r_ohm: f64, [r1, r2]: [f64; 2]) -> f64 {
        let share = |r_ohm: f64| (r_ohm - r1) / (r2 - r1);
        UNLIKE_PINS_OHM
            * match (self.zero_ohm, self.scale) {
                (None, _) => (1.0 + (1.0 - share(r_ohm)).powi(2) + share(r_ohm).powi(2)).sqrt(),
                (Some(_), None) => 2f64.sqrt() * (share(r_ohm) - share(0.0)).abs(),
                (Some(_), Some(_)) => 0.0,
            }
    }

    /// What its value is in: "N", the unit of its law, or "ohm" where there is neither force nor law.
    pub fn unit(&self) -> &str {
        match (&self.force, &self.law) {
            (Some(_), _) => "N",
            (None, Some(law)) => law.unit(),
            (None, None) => "ohm",
        }
    }

    /// What it shows at a resistance whose uncertainty contains what pins may differ by; `None` where its law says nothing.
    /// `known`: R_1 and R_2, ohm.
    pub fn value_at(&self, Measured { value, u }: Measured, known: [f64; 2]) -> Option<MeasuredValue> {
        let shown = self.shown(value, known)?;
        let pins_u_ohm = self.pins_u_ohm(value, known);
        let readout_u_ohm = u.map(|u| (u * u - pins_u_ohm * pins_u_ohm).max(0.0).sqrt());
        let slope = shown.slope.abs();
        let repeat_u = readout_u_ohm.map(|u| u * slope).filter(|u| u.is_finite());
        let common_u = shown.own_u.map(|own_u| own_u.hypot(pins_u_ohm * slope));
        Some(MeasuredValue {
            value: shown.value,
            u: repeat_u.zip(common_u).map(|(repeat_u, common_u)| repeat_u.hypot(common_u)),
            repeat_u,
            is_extrapolated: shown.is_extrapolated,
        })
    }

    /// What it shows above a resistance, by the direction of its law.
    pub fn bound_above(&self, r_ohm: f64, known: [f64; 2]) -> Option<Bound> {
        let Shown { value, slope, .. } = self.shown(r_ohm, known)?;
        Some(if slope > 0.0 { Bound::AtLeast(value) } else { Bound::AtMost(value) })
    }

    /// The same below it.
    pub fn bound_below(&self, r_ohm: f64, known: [f64; 2]) -> Option<Bound> {
        let Shown { value, slope, .. } = self.shown(r_ohm, known)?;
        Some(if slope > 0.0 { Bound::AtMost(value) } else { Bound::AtLeast(value) })
    }

    fn shown(&self, r_ohm: f64, known: [f64; 2]) -> Option<Shown> {
        let shown = match (&self.force, &self.law) {
            (Some(force), _) => force.shown(r_ohm, known),
            (None, Some(law)) => law.shown(r_ohm),
            (None, None) => None,
        };
        shown.filter(|shown| shown.value.is_finite() && shown.slope.is_finite())
    }

    /// What is wrong with its characteristic.
    pub fn defect(&self) -> Option<Defect> {
        match (&self.force, &self.law) {
            (Some(_), Some(_)) => {
                Some(("it has both force and law".to_owned(), "the one that the sensor follows"))
            }
            (Some(force), None) => force.defect(),
            (None, Some(law)) => law.defect(),
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests;
