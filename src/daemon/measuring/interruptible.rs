//! Pins whose waits end when the thread is to stop, and meanwhile give signs of life, however long a discharge takes; and that
//! may be away.

use super::{NAP, Shared};
use crate::config::backend::AnyPins;
use crate::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError, monotonic};
use crate::units::Nanos;
use std::sync::Arc;

/// Pins whose waits fail with [`PinsError::Stopped`] when the thread is to stop.
pub(super) struct Interruptible {
    /// The pins themselves; `None` until they can be opened (again).
    pub pins: Option<AnyPins>,
    pub shared: Arc<Shared>,
}

impl Interruptible {
    fn pins(&mut self) -> Result<&mut AnyPins, PinsError> {
        let gone = || PinsError::Gone { chip: "of before".to_owned(), call: "open", line: "it".to_owned() };
        self.pins.as_mut().ok_or_else(gone)
    }

    /// The next instant to wait for on the way to `until`.
    fn next_stop(&mut self, until: Nanos) -> Result<Nanos, PinsError> {
        if self.shared.is_stopped() {
            return Err(PinsError::Stopped);
        }
        Ok(until.min(self.now() + NAP))
    }
}

impl Pins for Interruptible {
    fn now(&mut self) -> Nanos {
        self.pins.as_mut().map_or_else(monotonic, |pins| pins.now())
    }

    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.pins()?.drive(on)
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.pins()?.arm()
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        loop {
            let stop = self.next_stop(until)?;
            let edge = self.pins()?.edge(stop)?;
            if edge.is_some() || stop == until {
                return Ok(edge);
            }
        }
    }

    /// Before a planned switch: as long as that waits, not cut into pieces at its end.
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.rest_until(at - NAP)?;
        self.pins()?.sleep_until(at)
    }

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        while self.now() < at {
            let stop = self.next_stop(at)?;
            self.pins()?.rest_until(stop)?;
        }
        Ok(())
    }

    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.rest_until(at - NAP)?;
        self.pins()?.rest_before_edge(at)
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.pins()?.levels()
    }

    fn particulars(&self) -> Particulars<'_> {
        self.pins.as_ref().map_or_else(Particulars::default, |pins| pins.particulars())
    }
}
