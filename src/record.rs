//! The timings of one discharge.
//!
//! For: what passes from [`discharge`](crate::instrument::discharge) to the methods, and onto a tape. Must not know: how they
//! were taken, or what follows from them.

use crate::circuit::Node;
use crate::units::Nanos;
use std::ops::RangeInclusive;

/// The most sensors that share one pair of capacitors.
pub const MAX_CHANNELS: usize = 16;
/// What is longer is no latency offset d: a slip of the unit.
pub const LONGEST_LATENCY: Nanos = Nanos(1_000_000);

/// Periods that the clock of stamps may have: Linux counts in the first, and the last is coarser than any clock (judgement).
pub const RESOLUTIONS: RangeInclusive<Nanos> = Nanos(1)..=Nanos(1_000_000);

/// Which resistors a discharge (or a part of it) runs through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Through {
    /// Rc1.
    C1,
    /// Rc2.
    C2,
    /// Rc1 + Rc2 in series (Fig. 1(b)).
    C12,
    /// The sensor of a channel.
    X(usize),
    /// The sensor of a channel and Rc1 + Rc2 at once (QERM).
    XWithC12(usize),
}

impl Through {
    /// The channel whose sensor takes part.
    pub fn channel(self) -> Option<usize> {
        match self {
            Through::X(channel) | Through::XWithC12(channel) => Some(channel),
            _ => None,
        }
    }
}

/// The kinds of calibration discharge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CalibrationKind {
    /// Through R_1.
    First,
    /// Through R_2.
    Second,
    /// Through R_1, then through R_2.
    Split,
}

impl CalibrationKind {
    /// Every kind.
    pub const ALL: [CalibrationKind; 3] =
        [CalibrationKind::First, CalibrationKind::Second, CalibrationKind::Split];
}

/// The planned change of resistor in the middle of a discharge. Times in ns since its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switch {
    /// The first resistor was released.
    pub at_ns: f64,
    /// The next one was sunk.
    pub on_ns: f64,
    /// The next one.
    pub to: Through,
}

/// How unlike the places are at which a release and a sinking happen within their calls: 1-sigma type-B uncertainty of the
/// time from start to switch, in parts of [`Record::u_switch_ns`]. One two-hundredth of a call; on emulated arm64 a line is
/// released 38 ns later in a call of 8 us than one is sunk. It is the same each time: no mean takes it away.
pub const UNLIKE_CALLS: f64 = 0.0125;

/// The timings of one discharge, in ns since its start; crossings include the latency offset d, switches do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// What it started through.
    pub through: Through,
    /// When it started.
    pub start: Nanos,
    /// When the second of two resistors that sink at once was sunk, ns; `None` for a single one.
    pub second_ns: Option<f64>,
    /// The switch, if one was made before node B (or the only node) crossed; to the same resistor where the program has only woken.
    pub switch: Option<Switch>,
    /// The crossing of node A.
    pub a_ns: Option<f64>,
    /// The crossing of node B.
    pub b_ns: Option<f64>,
    /// 1-sigma type-B uncertainty of the time from start to switch, from how long a call takes for a line, ns; `None` where
    /// nobody has told, as on an old tape: then what switches scatter by is all that is known.
    pub u_switch_ns: Option<f64>,
    /// How much later than usual its lines may have been switched, 1 sigma, ns, since a call took longer than usual; `None` if none
    /// did.
    pub later_ns: Option<f64>,
    /// When a wait ended in vain, ns: a node that had not crossed was still above its threshold then.
    pub waited_ns: Option<f64>,
}

/// The crossings of A and B, ns; `None` for a node that there is not, or that was not seen.
pub type Crossings = [Option<f64>; 2];

impl Record {
    /// The crossings of A and B, ns.
    pub fn crossings(&self) -> Crossings {
        [self.a_ns, self.b_ns]
    }

    /// The crossings of a discharge that came to its end, in a circuit with so many nodes: that of A, and that of B if B was
    /// waited for. `None` if a node was waited for in vain.
    pub fn ended(&self, nodes: usize) -> Option<Crossings> {
        let b_ns = self.b_ns.filter(|_| nodes == 2);
        let in_vain = nodes == 2 && b_ns.is_none() && self.waited_ns.is_some();
        self.a_ns.filter(|_| !in_vain).map(|a_ns| [Some(a_ns), b_ns])
    }

    /// The crossings of the nodes of a circuit with so many, if all of them were seen.
    pub fn complete(&self, nodes: usize) -> Option<Crossings> {
        let b_ns = if nodes == 2 { Some(self.b_ns?) } else { None };
        Some([Some(self.a_ns?), b_ns])
    }

    /// Which calibration discharge it is, if it is one.
    pub fn calibration_kind(&self) -> Option<CalibrationKind> {
        let to = self.switch.map(|switch| switch.to);
        match (self.through, to) {
            (Through::C1, None | Some(Through::C1)) => Some(CalibrationKind::First),
            (Through::C2 | Through::C12, None | Some(Through::C2 | Through::C12)) => {
                Some(CalibrationKind::Second)
            }
            (Through::C1, Some(Through::C2 | Through::C12)) => Some(CalibrationKind::Split),
            _ => None,
        }
    }

    /// Whether nothing was switched, and the program has only woken before the end.
    pub fn is_woken(&self) -> bool {
        self.switch.is_some_and(|switch| switch.to == self.through && switch.on_ns == switch.at_ns)
    }

    /// The crossing of a node, ns.
    pub fn crossing(&self, node: Node) -> Option<f64> {
        self.crossings()[node.index()]
    }
}
