//! A reading: what a client is told about one channel, once per x discharge.
//!
//! For: the states of physics kept apart from numbers, so that a fault can never become one. Must not know: how it
//! was estimated, or how it is sent.

use crate::circuit::Node;
use crate::units::{Nanos, named};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A value with its 1-sigma standard uncertainty (GUM).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The value; its unit is the field's.
    pub value: f64,
    /// 1 sigma; `None` where it is not known.
    pub u: Option<f64>,
}

/// What a sensor shows, with what is known of it, in the unit of its channel: newton of a force, or that of its law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredValue {
    /// The value.
    pub value: f64,
    /// 1 sigma of all: the readout, and the sensor's deviation from its law. `None`: as for the resistance, or nobody has said how
    /// well the law is known.
    pub u: Option<f64>,
    /// 1 sigma of the readout alone: how well two readings of one sensor can be told apart.
    pub repeat_u: Option<f64>,
    /// It is outside of where the law is known to hold.
    pub is_extrapolated: bool,
}

/// What is known of a value where the resistance is no number but a bound, in the unit of the channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// The value is above this.
    AtLeast(f64),
    /// The value is below this.
    AtMost(f64),
}

#[cfg(test)]
impl From<Measured> for MeasuredValue {
    /// By a law that is exact everywhere.
    fn from(Measured { value, u }: Measured) -> MeasuredValue {
        MeasuredValue { value, u, repeat_u: u, is_extrapolated: false }
    }
}

named! {
    /// How the estimate was made; [`Method::rules`] has what each method decides.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    Method {
        /// Two-point calibration, one node: eq. (3).
        Tpcm = "tpcm",
        /// Quantization error reduction, series calibration.
        Qerm = "qerm",
        /// Two capacitors: eq. (11).
        Tcdic = "tcdic",
        /// Compact error reduction: eq. (16)-(19).
        Cerm = "cerm",
        /// Tracked calibration, one discharge per reading.
        Tracked = "tracked",
    }
}

named! {
    /// Which line of eq. (19) a reading comes from; for QERM, whether x was released before the crossing.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    Branch {
        /// The whole discharge ran through the sensor.
        Direct = "direct",
        /// The discharge was finished through a calibration resistor.
        Inferred = "inferred",
    }
}

named! {
    /// Why there is no number.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    Fault {
        /// A node did not reach its high level by the end of the charge.
        NoCharge = "no-charge",
        /// A node is below its threshold, but no edge was reported.
        MissedEdge = "missed-edge",
        /// Events were lost to a full buffer.
        LostEvent = "lost-event",
        /// Two interrupts of one line fell together: the stamp is of the second.
        CoalescedEdge = "coalesced-edge",
        /// A call that switches lines took so long that its instant is not known well enough, or the program did not get to
        /// start the discharge for long after its charge.
        WideBracket = "wide-bracket",
        /// A crossing is later than the other node's crossing allows.
        LatencyOutlier = "latency-outlier",
        /// The sensor has changed so much during the discharge that the error may be as large as the value.
        Unsettled = "unsettled",
        /// A calibration discharge did not end in time.
        NoCalibration = "no-calibration",
        /// The calibration has changed suddenly; it is being found again.
        CalibrationStep = "calibration-step",
        /// Current leaves the nodes by a path of its own; through a resistor of 0 ohm a discharge would take time.
        Leakage = "leakage",
        /// Current enters the nodes by a path of its own; through a resistor of 0 ohm a discharge would take less than no time.
        PullUp = "pull-up",
        /// The times do not fit the law of the circuit (order or denominators).
        Implausible = "implausible",
        /// The GPIO lines could not be used.
        Pins = "pins",
    }
}

/// What a fault looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Suspect {
    /// A node is low after the charge.
    Uncharged(Node),
    /// Nothing falls through Rc1.
    FirstOpen,
    /// Nothing falls through Rc2.
    SecondOpen,
    /// Nothing falls through either.
    BothOpen,
    /// A node stays high while the other one falls.
    StaysHigh(Node),
    /// Node B falls before node A.
    NodesSwapped,
    /// Rc1 is where Rc2 should be.
    ResistorsSwapped,
    /// C_A is not there.
    NoCA,
    /// C_B is not there.
    NoCB,
    /// One of the capacitors is not there, or the only one.
    NoCapacitor,
    /// Another path to ground.
    Leak,
    /// Another path to the supply.
    Pull,
}

impl Suspect {
    /// What was seen.
    pub fn seen(self) -> &'static str {
        self.texts().0
    }

    /// What to look at or for, beginning with "look".
    pub fn look(self) -> &'static str {
        self.texts().1
    }

    fn texts(self) -> (&'static str, &'static str) {
        match self {
            Suspect::Uncharged(Node::A) => (
                "node A is low after the charge",
                "look at the wires from charge-a through its resistor to node A and on to sense-a, and for a short circuit to \
                 ground",
            ),
            Suspect::Uncharged(Node::B) => (
                "node B is low after the charge",
                "look at the wires from charge-b through its resistor to node B and on to sense-b, and for a short circuit to \
                 ground",
            ),
            Suspect::FirstOpen => (
                "nothing falls in a discharge through Rc1",
                "look at the wire from sink-c1 through Rc1 to node A",
            ),
            Suspect::SecondOpen => (
                "nothing falls in a discharge through Rc2",
                "look at the wire from sink-c2 through Rc2 to node A (series calibration: to Rc1)",
            ),
            Suspect::BothOpen => (
                "nothing falls in a discharge through Rc1, nor through Rc2",
                "look at the wire of sense-a, and those of sink-c1 and sink-c2 through Rc1 and Rc2 to node A",
            ),
            Suspect::StaysHigh(Node::A) => {
                ("node A stays high while node B falls", "look at the wire of sense-a")
            }
            Suspect::StaysHigh(Node::B) => (
                "node B stays high while node A falls",
                "look at the wire of sense-b, both capacitors (C_A from node A to node B, C_B from there to ground), and for a \
                 pull-up left on",
            ),
            Suspect::NodesSwapped => (
                "node B falls before node A",
                "look whether sense-a and sense-b, or C_A and C_B, are swapped",
            ),
            Suspect::ResistorsSwapped => {
                ("Rc1 and Rc2 look swapped", "look at sink-c1 and sink-c2, r-c1 and r-c2")
            }
            Suspect::NoCA => {
                ("node A falls at once and node B does not", "look for C_A: missing or without contact")
            }
            Suspect::NoCB => ("nodes A and B fall at once", "look for C_B: missing or without contact"),
            Suspect::NoCapacitor => {
                ("node A falls at once", "look for a capacitor that is missing or without contact")
            }
            Suspect::Leak => (
                "current leaves the nodes by a path of its own",
                "look for pull-downs (some drivers leave them on), leaking capacitors, moisture, a sensor wired to ground, and \
                 whether r-c1 and r-c2 are as measured",
            ),
            Suspect::Pull => (
                "current enters the nodes by a path of its own",
                "look for pull-ups (some drivers leave them on, whatever they are asked), and whether r-c1 and r-c2 are as \
                 measured",
            ),
        }
    }
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.seen(), self.look())
    }
}

/// What is known about a channel. Never holds NaN, infinity, or a negative resistance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Status {
    /// A number.
    Ok {
        /// Which equation.
        branch: Branch,
        /// Ohm.
        r_ohm: Measured,
        /// What the sensor shows; `None` for a channel without force and law, or where that says nothing.
        shown: Option<MeasuredValue>,
        /// The sensor changed while it was read, and u contains that: it is more than all else.
        is_moving: bool,
        /// u is still a prior, and wide: too little has been seen to know the noise, or what leaks. Or it is the first that is
        /// none, which no number before it confirms.
        is_settling: bool,
    },
    /// The resistance is above what the deadline resolves.
    Open {
        /// Lower bound, ohm.
        r_min_ohm: f64,
        /// What belongs to it.
        shown: Option<Bound>,
    },
    /// The resistance is below what can be told from 0.
    Short {
        /// Upper bound (2 sigma), ohm.
        r_max_ohm: f64,
        /// What belongs to it.
        shown: Option<Bound>,
    },
    /// Not known.
    Fault(Fault),
}

/// One reading of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Index of the channel in the configuration.
    pub channel: usize,
    /// Counts the readings of the instrument from 1.
    pub seq: u64,
    /// When R_x was what the reading says, about the middle of its part of the x discharge; `CLOCK_MONOTONIC`.
    pub at: Nanos,
    /// What is known.
    pub status: Status,
    /// What on the board a fault looks like.
    pub suspect: Option<Suspect>,
    /// How it was estimated.
    pub method: Method,
    /// How long the cycle's share of this reading took, charge and calibration included.
    pub duration: Nanos,
}
