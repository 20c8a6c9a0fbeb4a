//! Pins with one thing about them changed.

use cermd::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use cermd::units::Nanos;

/// Pins of which some lines drive nothing, as with wires that are cut, and whose levels are told or made up.
#[derive(Debug)]
pub struct Decorated<P> {
    pub pins: P,
    /// Lines that drive nothing.
    pub cut: Drives,
    /// What every look at the levels answers, without one; `None`: what they are. Arming looks all the same.
    pub levels: Option<Levels>,
    /// It does not know when the kernel's tick comes.
    pub hides_tick: bool,
}

impl<P> Decorated<P> {
    pub fn cut(pins: P, cut: Drives) -> Decorated<P> {
        Decorated { pins, cut, levels: None, hides_tick: false }
    }

    pub fn told(pins: P, levels: Levels) -> Decorated<P> {
        Decorated { levels: Some(levels), ..Decorated::cut(pins, Drives::NONE) }
    }

    pub fn without_tick(pins: P) -> Decorated<P> {
        Decorated { hides_tick: true, ..Decorated::cut(pins, Drives::NONE) }
    }
}

impl<P: Pins> Pins for Decorated<P> {
    fn now(&mut self) -> Nanos {
        self.pins.now()
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.pins.drive(on.without(self.cut))
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.pins.arm()
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.pins.edge(until)
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.sleep_until(at)
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.rest_until(at)
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.rest_before_edge(at)
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.levels.map_or_else(|| self.pins.levels(), Ok)
    }
    fn particulars(&self) -> Particulars<'_> {
        let particulars = self.pins.particulars();
        Particulars { tick: particulars.tick.filter(|_| !self.hides_tick), ..particulars }
    }
}
