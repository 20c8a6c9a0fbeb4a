//! What the instrument runs with: every default filled in and every file read.

use crate::circuit::{Kind, Node};
use crate::instrument::diagnosis::Nominal;
use crate::instrument::discharge::Charge;
use crate::pins::Drives;
use crate::reading::Method;
use crate::record::Through;
use crate::sensor::Channel;
use crate::units::{Micros, Nanos};
use std::str::FromStr;

/// Where the latency offset comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OffsetSource {
    /// Split calibration.
    Auto,
    /// Given, ns.
    Given(f64),
}

impl FromStr for OffsetSource {
    type Err = String;
    /// As people write it: `auto`, or a duration such as `8 us`.
    fn from_str(text: &str) -> Result<OffsetSource, String> {
        if text == "auto" {
            return Ok(OffsetSource::Auto);
        }
        let d: Micros = text.parse().map_err(|error| format!("{error}; or \"auto\""))?;
        Ok(OffsetSource::Given(Nanos::from(d).as_ns()))
    }
}

/// How to charge, by what the discharge waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Charges {
    /// Node A: B may float wherever it is.
    pub to_a: Charge,
    /// Node B, which was charged not long ago.
    pub to_b: Charge,
    /// Node B, of which nothing is known.
    pub anew: Charge,
}

impl Charges {
    /// The same for every discharge.
    pub fn alike(charge: Charge) -> Charges {
        Charges { to_a: charge, to_b: charge, anew: charge }
    }

    /// So many times as long.
    pub fn times(self, factor: f64) -> Charges {
        let longer = |time: Nanos| Nanos((factor * time.as_ns()) as i64);
        let charge = |Charge { alone, together }| Charge { alone: longer(alone), together: longer(together) };
        Charges { to_a: charge(self.to_a), to_b: charge(self.to_b), anew: charge(self.anew) }
    }
}

/// Everything that the measuring thread needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// How the circuit is wired.
    pub kind: Kind,
    /// Rc1 and Rc2, ohm.
    pub r_c_ohm: [f64; 2],
    /// When node A should cross in a discharge through R_1, by nominal values: what diagnosis and charges compare with.
    pub nominal: Nanos,
    /// Length of what goes before the charge after a discharge that ended before its time.
    pub drain: Nanos,
    /// How to charge.
    pub charge: Charges,
    /// Rp + Ro of a charger, and Ro, ohm: the nominal values that this follows from; `None`: somebody has said how long.
    pub charge_ohm: Option<[f64; 2]>,
    /// Pause between charge and discharge.
    pub settle: Nanos,
    /// The longest discharge through a sensor.
    pub deadline: Nanos,
    /// From the start of one cycle to the next; `None`: at once.
    pub period: Option<Nanos>,
    /// What is published is the mean over this time; `None`: each reading.
    pub average: Option<Nanos>,
    /// The latency offset, ns, where the calibration is not tracked; `None`: found by split calibration.
    pub offset_ns: Option<f64>,
    /// Period of the clock that stamps crossings.
    pub resolution: Nanos,
    /// The calibration is followed over many readings instead of taken anew for each.
    pub tracked: bool,
    /// T_L of eq. (19); `None`: where the predicted uncertainties cross.
    pub t_l: Option<Nanos>,
    /// The planned switch comes at this fraction of the predicted T_xA.
    pub switch_fraction: f64,
    /// Of so many cycles each of them is read in one.
    pub every: Vec<u32>,
    /// The sensors.
    pub channels: Vec<Channel>,
}

impl Settings {
    /// R_1 and R_2 of the [ratio](crate::estimate::method), ohm.
    pub fn r_ohm(&self) -> [f64; 2] {
        self.kind.known(self.r_c_ohm)
    }

    /// The chargers there are.
    pub fn chargers(&self) -> Drives {
        match self.kind.last() {
            Node::A => Drives::CHARGE_A,
            Node::B => Drives::CHARGE,
        }
    }

    /// The node whose crossing ends a discharge.
    pub fn last(&self) -> Node {
        self.method.rules().last(self.kind)
    }

    /// How many nodes the method times.
    pub fn nodes(&self) -> usize {
        self.last().index() + 1
    }

    /// What is known of the board.
    pub fn board(&self) -> Nominal {
        let nodes = &Node::BOTH[..self.nodes()];
        Nominal { kind: self.kind, nodes, r_ohm: self.r_ohm(), nominal_ns: self.nominal.as_ns() }
    }

    /// The discharge of R_2.
    pub fn second(&self) -> Through {
        if self.kind == Kind::SeriesCalibration { Through::C12 } else { Through::C2 }
    }
}
