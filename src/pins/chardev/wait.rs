//! Waiting for edges, and how late wake-ups come.

use crate::pins::limits::{
    ALIGNED_TICKS, FIRST_SPIN_MARGIN, LEAST_SPIN_MARGIN, MOST_SPIN_MARGIN, SHORTEST_TICK,
};
use crate::pins::{kernel, monotonic};
use crate::units::Nanos;
use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, ppoll};
use nix::sys::time::{TimeSpec, TimeValLike};
use nix::time::{ClockId, ClockNanosleepFlags, clock_getres, clock_nanosleep};

/// The longest wait in one go: three quarters of the kernel's tick, which is the resolution of its coarse clocks.
///
/// A processor that has nothing to do until after the next tick stops the tick, and catches up on it before the interrupt
/// that ends the wait is handled and stamped (`tick_nohz_irq_enter`, kernel/time/tick-sched.c): stamps would be late by
/// some microseconds after long waits and not after short ones.
fn longest_wait() -> Nanos {
    Nanos(tick().unwrap_or(SHORTEST_TICK).0 / 4 * 3)
}

/// The period of the kernel's tick.
fn tick() -> Option<Nanos> {
    let resolution = clock_getres(ClockId::CLOCK_MONOTONIC_COARSE).ok()?;
    Some(Nanos(resolution.num_nanoseconds()))
}

/// The same where ticks are at whole multiples of it: since "tick/common: Align tick period during sched_timer setup" (kernel/time/tick-sched.c)
/// of Linux 6.4. It went into stable kernels before, too, whose first two numbers do not tell it.
pub(super) fn aligned_tick() -> Option<Nanos> {
    kernel().1.filter(|version| *version >= ALIGNED_TICKS).and_then(|_| tick())
}

/// Waits until one of the descriptors can be read, at most until an instant; whether one can. Returns early after a long
/// wait.
///
/// # Errors
/// `ENODEV` when the chip behind a descriptor has disappeared, else what `ppoll` answers.
pub(super) fn readable(watched: &mut [PollFd], until: Nanos) -> Result<bool, Errno> {
    let time = (until - monotonic()).clamp(Nanos::ZERO, longest_wait());
    let ready = match ppoll(watched, Some(TimeSpec::nanoseconds(time.0)), None) {
        Ok(ready) => ready > 0,
        Err(Errno::EINTR) => false,
        Err(errno) => return Err(errno),
    };
    let gone = PollFlags::POLLHUP | PollFlags::POLLERR | PollFlags::POLLNVAL;
    let lost = watched.iter().any(|fd| fd.revents().is_some_and(|events| events.intersects(gone)));
    if lost { Err(Errno::ENODEV) } else { Ok(ready) }
}

/// How long before an instant to stop sleeping and to spin, learned from how late wake-ups come.
///
/// A wake-up that comes later than the margin raises it by half, one in time lowers it by 1/256. In balance
/// p ln 1.5 = (1 - p)/256: the margin settles where one wake-up in a hundred is later than it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SpinMargin(pub Nanos);

impl SpinMargin {
    /// Learns from one wake-up.
    pub fn learn(&mut self, lateness: Nanos) {
        let margin = self.0.0;
        let next = if lateness > self.0 { margin + margin / 2 } else { margin - margin / 256 };
        self.0 = Nanos(next.clamp(LEAST_SPIN_MARGIN.0, MOST_SPIN_MARGIN.0));
    }

    /// [`Pins::sleep_until`](crate::pins::Pins::sleep_until): sleeps until shortly before `at`, then spins.
    pub fn sleep_until(&mut self, at: Nanos) {
        if monotonic() < at - self.0 {
            self.rest_until(at - self.0);
        }
        while monotonic() < at {
            std::hint::spin_loop();
        }
    }

    /// [`Pins::rest_until`](crate::pins::Pins::rest_until).
    pub fn rest_until(&mut self, at: Nanos) {
        let until = TimeSpec::nanoseconds(at.0);
        while monotonic() < at {
            // Interrupted, or ended: the clock tells.
            let _ = clock_nanosleep(ClockId::CLOCK_MONOTONIC, ClockNanosleepFlags::TIMER_ABSTIME, &until);
        }
        self.learn(monotonic() - at);
    }

    /// [`Pins::rest_before_edge`](crate::pins::Pins::rest_before_edge), where that spares a wake-up of [`readable`]: two thirds
    /// of its longest wait are left, in which the tick goes on.
    pub fn rest_before_edge(&mut self, at: Nanos) {
        let longest = longest_wait();
        let wake = at - Nanos(longest.0 / 3 * 2);
        if wake - monotonic() > longest {
            self.rest_until(wake);
        }
    }
}

impl Default for SpinMargin {
    fn default() -> SpinMargin {
        SpinMargin(FIRST_SPIN_MARGIN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, Exp};
    use std::os::fd::AsFd;

    #[test]
    fn one_wake_up_in_a_hundred_is_later_than_the_margin() {
        let mut random = crate::seed::rng(7);
        let lateness = Exp::new(1.0 / 20_000.0).unwrap();
        let (mut margin, mut late) = (SpinMargin::default(), 0);
        let mut draw = |margin: &mut SpinMargin| {
            let drawn = Nanos(lateness.sample(&mut random) as i64);
            let missed = drawn > margin.0;
            margin.learn(drawn);
            missed
        };
        for _ in 0..10_000 {
            draw(&mut margin);
        }
        for _ in 0..100_000 {
            late += u32::from(draw(&mut margin));
        }
        // The balance is at 0.954 %; the standard deviation of this count is about 30.
        assert!((850..1060).contains(&late), "{late} of 100000");
    }

    #[test]
    fn the_margin_stays_within_its_bounds() {
        let mut margin = SpinMargin::default();
        for _ in 0..10 {
            margin.learn(Nanos(50_000_000));
        }
        assert_eq!(margin.0, MOST_SPIN_MARGIN);
        for _ in 0..10_000 {
            margin.learn(Nanos(1));
        }
        assert_eq!(margin.0, LEAST_SPIN_MARGIN);
    }

    #[test]
    fn a_descriptor_that_hangs_up_is_a_chip_that_is_gone() {
        let (reader, writer) = nix::unistd::pipe().unwrap();
        let wait = |until| readable(&mut [PollFd::new(reader.as_fd(), PollFlags::POLLIN)], until);
        assert_eq!(wait(Nanos::ZERO), Ok(false), "nothing to read, and no time left");
        nix::unistd::write(&writer, b"edge").unwrap();
        assert_eq!(wait(Nanos::MAX), Ok(true), "something to read");
        drop(writer);
        assert_eq!(wait(Nanos::MAX), Err(Errno::ENODEV));
    }

    #[test]
    fn a_wait_ends_before_the_tick_would_be_stopped() {
        // CONFIG_HZ is 100 to 1000.
        assert!((Nanos(750_000)..=Nanos(7_500_000)).contains(&longest_wait()), "{}", longest_wait());
    }

    #[test]
    fn a_sleep_never_ends_early() {
        let mut margin = SpinMargin::default();
        for ahead in [-1_000, 0, 10_000, 300_000] {
            let at = monotonic() + Nanos(ahead);
            margin.sleep_until(at);
            assert!(monotonic() >= at);
        }
        assert!(margin.0 >= LEAST_SPIN_MARGIN);
    }

    #[test]
    fn a_rest_spares_a_wake_up_and_ends_before_the_edge() {
        let (longest, mut margin) = (longest_wait(), SpinMargin::default());
        let before = monotonic();
        // Two waits are as good as a rest and a wait.
        margin.rest_before_edge(before + Nanos(longest.0 / 3 * 5));
        assert_eq!(margin, SpinMargin::default(), "it has not slept");
        margin.rest_before_edge(before + Nanos(longest.0 * 3));
        let rested = monotonic() - before;
        assert!(rested > Nanos(longest.0 / 3 * 7), "woke after {rested}");
    }
}
