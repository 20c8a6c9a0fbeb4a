//! The three wirings.

use super::{Network, Node};
use crate::units::{Farad, named};
use serde::{Deserialize, Serialize};

named! {
    /// How capacitors and calibration resistors are wired.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    Kind {
        /// Two capacitors in series, Fig. 1(c).
        TwoCapacitor = "two-capacitor",
        /// One capacitor, Fig. 1(a).
        OneCapacitor = "one-capacitor",
        /// One capacitor, Rc2 in series with Rc1, Fig. 1(b).
        SeriesCalibration = "series-calibration",
    }
}

impl Kind {
    /// Its nodes, in the order in which a discharge crosses them.
    pub fn nodes(self) -> &'static [Node] {
        match self {
            Kind::TwoCapacitor => &Node::BOTH,
            Kind::OneCapacitor | Kind::SeriesCalibration => &[Node::A],
        }
    }

    /// The node that a discharge crosses last.
    pub fn last(self) -> Node {
        if self == Kind::TwoCapacitor { Node::B } else { Node::A }
    }

    /// R_1 and R_2, what the two calibration discharges run through, of Rc1 and Rc2, ohm.
    pub fn known(self, [r_c1, r_c2]: [f64; 2]) -> [f64; 2] {
        [r_c1, if self == Kind::SeriesCalibration { r_c1 + r_c2 } else { r_c2 }]
    }

    /// What the second calibration discharge runs through.
    pub fn second(self) -> &'static str {
        if self == Kind::SeriesCalibration { "Rc1 + Rc2" } else { "Rc2" }
    }
}

impl Network {
    /// Of this kind; `None` where a capacitor is missing.
    pub fn new(kind: Kind, c_a: Option<Farad>, c_b: Option<Farad>, c: Option<Farad>) -> Option<Network> {
        Some(match kind {
            Kind::TwoCapacitor => Network::TwoCapacitor { c_a: c_a?, c_b: c_b? },
            Kind::OneCapacitor => Network::OneCapacitor { c: c? },
            Kind::SeriesCalibration => Network::SeriesCalibration { c: c? },
        })
    }

    /// Its capacitors, that of node A first; `None` for the second where there is one.
    pub fn capacitors(&mut self) -> (&mut Farad, Option<&mut Farad>) {
        match self {
            Network::TwoCapacitor { c_a, c_b } => (c_a, Some(c_b)),
            Network::OneCapacitor { c } | Network::SeriesCalibration { c } => (c, None),
        }
    }

    /// How it is wired.
    pub fn kind(self) -> Kind {
        match self {
            Network::TwoCapacitor { .. } => Kind::TwoCapacitor,
            Network::OneCapacitor { .. } => Kind::OneCapacitor,
            Network::SeriesCalibration { .. } => Kind::SeriesCalibration,
        }
    }
}
