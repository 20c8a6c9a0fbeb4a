//! What one discharge is to do.

use super::UsualCall;
use crate::circuit::Node;
use crate::pins::Drives;
use crate::record::Through;
use crate::units::Nanos;

/// How capacitors are charged.
///
/// A discharge takes the same charge out of both capacitors, which are in series. Charging through A alone puts it back into
/// both, with the time constant Rp C_T; all chargers together need Rp C_A and more, and are there for what B has lost
/// otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Charge {
    /// How long through A alone, every other node floating.
    pub alone: Nanos,
    /// How long after that through all chargers of the circuit.
    pub together: Nanos,
}

impl Charge {
    /// Through A alone.
    pub const fn alone(time: Nanos) -> Charge {
        Charge { alone: time, together: Nanos::ZERO }
    }

    /// Through all chargers.
    pub const fn together(time: Nanos) -> Charge {
        Charge { alone: Nanos::ZERO, together: time }
    }

    /// All of it.
    pub fn time(self) -> Nanos {
        self.alone + self.together
    }
}

/// From when to when each node may fall through its threshold and be stamped, since the start; `None`: nobody knows.
pub type Falls = [Option<[Nanos; 2]>; 2];

/// What one discharge is to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// What to discharge through first.
    pub through: Through,
    /// After how long to switch, and to what. Comes to nothing if the last node crosses earlier. To what sinks already: the program
    /// wakes then, and touches no line.
    pub switch: Option<(Nanos, Through)>,
    /// How long nothing sinks between the release and the next sinking of that switch.
    pub hold: Nanos,
    /// Chargers of the circuit.
    pub chargers: Drives,
    /// The node whose crossing ends the discharge: B, or A in circuits that have no other.
    pub last: Node,
    /// How long to sink through R_1 before the charge; 0: not at all. A discharge that ended before its time leaves the
    /// capacitors as no other does, and an incomplete charge would remember it.
    pub drain: Nanos,
    /// How to charge.
    pub charge: Charge,
    /// How long to leave everything floating between charge and start; at least as long as arming takes.
    pub settle: Nanos,
    /// When each node crosses, since the start, where that is known before: the system may rest until then. `None`: it is
    /// waited for all the time.
    pub expected: [Option<Nanos>; 2],
    /// When nodes fall, as far as that can be told before: the kernel's tick should not meet that.
    pub falls: Falls,
    /// The longest wait for the last crossing, from the start (or from the switch to `limit`).
    pub timeout: Nanos,
    /// What finishes a discharge that was not switched and has not ended by then; `None`: nothing.
    pub limit: Option<Through>,
    /// The longest call that still tells when a line was switched.
    pub widest_bracket: Nanos,
    /// How long the calls for one line usually take, by [`Call`](super::Call); `None`: not known yet.
    pub calls: [Option<UsualCall>; 3],
}

impl Plan {
    /// A full discharge after a charge, started at once: nothing is known of the calls or of when it ends.
    pub const fn full(through: Through, last: Node, charge: Charge, timeout: Nanos) -> Plan {
        Plan {
            through,
            switch: None,
            hold: Nanos::ZERO,
            chargers: Drives::CHARGE,
            last,
            drain: Nanos::ZERO,
            charge,
            settle: Nanos::ZERO,
            expected: [None; 2],
            falls: [None; 2],
            timeout,
            limit: None,
            widest_bracket: Nanos::MAX,
            calls: [None; 3],
        }
    }
}

impl Through {
    /// The lines that sink for this discharge.
    pub fn drives(self) -> Drives {
        match self {
            Through::C1 => Drives::C1,
            Through::C2 | Through::C12 => Drives::C2,
            Through::X(channel) => Drives::x(channel),
            Through::XWithC12(channel) => Drives::x(channel).and(Drives::C2),
        }
    }
}
