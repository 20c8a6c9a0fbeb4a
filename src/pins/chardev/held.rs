//! What the backends keep of a chip while they hold lines of it: its title, for errors, and how late its wake-ups come.

use super::error::{hint, is_gone};
use super::wait::{self, SpinMargin, longest_wait, time_left};
use crate::pins::{PinsError, monotonic};
use crate::units::Nanos;
use nix::errno::Errno;
use nix::poll::PollFd;
use nix::sys::time::{TimeSpec, TimeValLike};
use nix::time::{ClockId, ClockNanosleepFlags, clock_nanosleep};
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

    /// [`Pins::sleep_until`](crate::pins::Pins::sleep_until): sleeps until shortly before `at`, then spins.
    pub fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let wake = at - self.margin.get();
        if monotonic() < wake {
            self.rest_until(wake)?;
        }
        while monotonic() < at {
            std::hint::spin_loop();
        }
        Ok(())
    }

    /// [`Pins::rest_until`](crate::pins::Pins::rest_until). Sleeping fails only if the system is at fault.
    pub fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let until = TimeSpec::nanoseconds(at.0);
        while let Err(errno) =
            clock_nanosleep(ClockId::CLOCK_MONOTONIC, ClockNanosleepFlags::TIMER_ABSTIME, &until)
        {
            if errno != Errno::EINTR {
                return Err(self.failed("clock_nanosleep", "CLOCK_MONOTONIC", errno.into()));
            }
        }
        self.margin.learn(monotonic() - at);
        Ok(())
    }

    /// [`Pins::rest_before_edge`](crate::pins::Pins::rest_before_edge), where that spares a wake-up of
    /// [`readable`](wait::readable): two thirds of its longest wait are left, in which the tick goes on.
    pub fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        let longest = longest_wait();
        let wake = at - Nanos(longest.0 / 3 * 2);
        if time_left(wake) > longest { self.rest_until(wake) } else { Ok(()) }
    }
}

/// What errors call all sense lines together.
pub(in crate::pins) const SENSE_LINES: &str = "the sense lines";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pins::limits::LEAST_SPIN_MARGIN;

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

    #[test]
    fn a_sleep_never_ends_early() {
        let mut chip = HeldChip::new("gpiochip0".to_owned());
        for ahead in [-1_000, 0, 10_000, 300_000] {
            let at = monotonic() + Nanos(ahead);
            chip.sleep_until(at).unwrap();
            assert!(monotonic() >= at);
        }
        assert!(chip.spin_margin() >= LEAST_SPIN_MARGIN);
    }

    #[test]
    fn a_rest_spares_a_wake_up_and_ends_before_the_edge() {
        let (longest, mut chip) = (longest_wait(), HeldChip::new("gpiochip0".to_owned()));
        let before = monotonic();
        // Two waits are as good as a rest and a wait.
        chip.rest_before_edge(before + Nanos(longest.0 / 3 * 5)).unwrap();
        assert_eq!(chip.margin, SpinMargin::default(), "it has not slept");
        chip.rest_before_edge(before + Nanos(longest.0 * 3)).unwrap();
        let rested = monotonic() - before;
        assert!(rested > Nanos(longest.0 / 3 * 7), "woke after {rested}");
    }
}
