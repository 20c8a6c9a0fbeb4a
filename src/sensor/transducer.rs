//! The laws beside force, behind one face.

use super::ldr::Ldr;
use super::ntc::Ntc;
use super::position::Position;
use super::pt1000::Pt1000;
use super::relation::Relation;
use super::table::Tabled;
use super::{Defect, Shown};
use serde::{Deserialize, Serialize};

/// How what a sensor shows follows from its resistance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Transducer {
    /// A thermistor whose resistance falls with temperature.
    Ntc(Ntc),
    /// A platinum resistor of 1 kohm at 0 degC.
    Pt1000(Pt1000),
    /// A photoresistor.
    Ldr(Ldr),
    /// A potentiometer, or whatever is linear in its resistance.
    Position(Position),
    /// Measured pairs.
    Table(Tabled),
}

impl Transducer {
    fn relation(&self) -> &dyn Relation {
        match self {
            Transducer::Ntc(law) => law,
            Transducer::Pt1000(law) => law,
            Transducer::Ldr(law) => law,
            Transducer::Position(law) => law,
            Transducer::Table(law) => law,
        }
    }

    /// What its values are in: "degC", "lx", "mm", or as a table says.
    pub fn unit(&self) -> &str {
        self.relation().unit()
    }

    /// What it says at a resistance, ohm; `None` where it says nothing.
    pub fn shown(&self, r_ohm: f64) -> Option<Shown> {
        self.relation().shown(r_ohm)
    }

    /// What is wrong with it.
    pub fn defect(&self) -> Option<Defect> {
        self.relation().defect()
    }

    /// Whether it says how far the sensor may be off it; without that no value has an uncertainty.
    pub fn has_u(&self) -> bool {
        match self {
            Transducer::Ntc(law) => law.u.is_some(),
            Transducer::Pt1000(law) => law.class.is_some(),
            Transducer::Ldr(law) => law.u.is_some(),
            Transducer::Position(law) => law.u.is_some(),
            Transducer::Table(law) => law.u.is_some(),
        }
    }
}
