//! What the backends keep of a chip while they hold lines of it: its title, for errors, and how late its wake-ups come.

use super::error::{hint, is_gone};
use super::wait::{self, SpinMargin};
use crate::pins::PinsError;
use crate::units::Nanos;
use nix::errno::Errno;
use nix::poll::PollFd;
use std::io;

/// A chip with lines that are held.
#[derive(Debug)]
pub(in crate::pins) struct HeldChip {
    title: String,
    margin: SpinMargin,
}

impl HeldChip {
    /// Nothing is known of its wake-ups yet.
    pub fn new(title: String) -> HeldChip {
        HeldChip { title, margin: SpinMargin::default() }
    }

    /// How long before an instant sleeping turns into spinning.
    pub fn spin_margin(&self) -> Nanos {
        self.margin.get()
    }

    /// A failed call: the chip is gone, or what is known of the failure without looking anything up.
    pub fn failed(&self, call: &'static str, line: &str, source: io::Error) -> PinsError {
        let (errno, line) = (source.raw_os_error().unwrap_or_default(), line.to_owned());
        if is_gone(errno) {
            return PinsError::Gone { chip: self.title.clone(), call, line };
        }
        PinsError::Call { call, line, source, hint: hint(errno) }
    }

    /// [`wait::readable`] for sense lines.
    pub fn edges_come(&self, watched: &mut [PollFd], until: Nanos) -> Result<bool, PinsError> {
        wait::readable(watched, until).map_err(|errno| self.failed("ppoll", SENSE_LINES, errno.into()))
    }

    /// [`Pins::sleep_until`](crate::pins::Pins::sleep_until).
    pub fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let outcome = wait::sleep_until(at, &mut self.margin);
        self.slept(outcome)
    }

    /// [`Pins::rest_until`](crate::pins::Pins::rest_until).
    pub fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let outcome = wait::rest_until(at, &mut self.margin);
        self.slept(outcome)
    }

    /// [`Pins::rest_before_edge`](crate::pins::Pins::rest_before_edge).
    pub fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        let outcome = wait::rest_before(at, &mut self.margin);
        self.slept(outcome)
    }

    /// Sleeping fails only if the system is at fault.
    fn slept(&self, outcome: Result<(), Errno>) -> Result<(), PinsError> {
        outcome.map_err(|errno| self.failed("clock_nanosleep", "CLOCK_MONOTONIC", errno.into()))
    }
}

/// What errors call all sense lines together.
pub(in crate::pins) const SENSE_LINES: &str = "the sense lines";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disappearance_of_a_chip_is_told_from_other_failures() {
        let chip = HeldChip::new("gpiochip0".to_owned());
        let error = chip.failed("GET_VALUES", "sense", io::Error::from_raw_os_error(libc::ENODEV));
        let expected = "the GPIO chip gpiochip0 is gone, says GET_VALUES on sense: its driver was unbound, or the board \
                        unplugged";
        assert!(matches!(error, PinsError::Gone { .. }) && error.to_string() == expected, "{error}");
        let error = chip.failed("SET_VALUES", "c1", io::Error::from_raw_os_error(libc::EIO));
        assert!(matches!(error, PinsError::Call { call: "SET_VALUES", .. }), "{error}");
    }
}
