//! What a simulated circuit would have cost the processor: the time in calls, and that of spinning before instants.

use crate::pins::sim::SimPins;
use crate::pins::{Armed, Bracket, Drives, Edge, FIRST_SPIN_MARGIN, Levels, Particulars, Pins, PinsError};
use crate::units::Nanos;

/// Pins that count.
pub struct Metered {
    pins: SimPins,
    /// In calls that do something.
    pub calls: Nanos,
    /// Awake, because waiting ends more precisely then.
    pub spun: Nanos,
}

impl Metered {
    pub fn new(pins: SimPins) -> Metered {
        Metered { pins, calls: Nanos::ZERO, spun: Nanos::ZERO }
    }

    fn calling<T>(&mut self, call: impl FnOnce(&mut SimPins) -> T) -> T {
        let before = self.pins.now();
        let answer = call(&mut self.pins);
        self.calls = self.calls + (self.pins.now() - before);
        answer
    }
}

impl Pins for Metered {
    fn now(&mut self) -> Nanos {
        self.pins.now()
    }

    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.calling(|pins| pins.drive(on))
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.calling(SimPins::arm)
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.pins.edge(until)
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let left = at - self.pins.now();
        self.spun = self.spun + left.clamp(Nanos::ZERO, FIRST_SPIN_MARGIN);
        self.pins.sleep_until(at)
    }

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.rest_until(at)
    }

    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.rest_before_edge(at)
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.calling(SimPins::levels)
    }

    fn particulars(&self) -> Particulars<'_> {
        self.pins.particulars()
    }
}
