//! What a discharge asks for, and what comes of it.

#[cfg(doc)]
use super::Discharge;
#[cfg(doc)]
use crate::pins::Pins;
use crate::pins::{Armed, Bracket, Drives, Edge, Levels};
use crate::units::Nanos;

/// What is to be done next on the pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// [`Pins::drive`].
    Drive(Drives),
    /// [`Pins::sleep_until`].
    Sleep(Nanos),
    /// [`Pins::rest_until`].
    Rest(Nanos),
    /// [`Pins::arm`].
    Arm,
    /// [`Pins::edge`], after [`Pins::rest_before_edge`] if it is known when it comes.
    WaitEdge {
        /// When it is due.
        expected: Option<Nanos>,
        /// The longest wait.
        until: Nanos,
    },
    /// [`Pins::levels`].
    ReadLevels,
    /// Nothing: take the [`Discharge::result`].
    Done,
}

/// What came of an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Lines were switched.
    Drove(Bracket),
    /// The instant has come.
    Slept,
    /// Edges are watched; and what time it is, if that is asked for.
    Armed(Armed, Option<Nanos>),
    /// An edge, or none until the instant.
    Edge(Option<Edge>),
    /// The levels.
    Levels(Levels),
}
