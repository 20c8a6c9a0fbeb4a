//! One sense line of uAPI v1, with its stamps and its count of edges.

use crate::circuit::Node;
use crate::pins::{clock, monotonic};
use crate::units::Nanos;
use gpio_cdev::LineEventHandle;
use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::time::ClockId;
use std::error::Error;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};

/// An input whose falling edges are stamped.
#[derive(Debug)]
pub(super) struct SenseLine {
    /// Where it is.
    pub node: Node,
    /// What errors call it.
    pub title: String,
    /// How many edges have been handed out or dropped.
    pub line_seqno: u32,
    handle: LineEventHandle,
    stamped_by: ClockId,
    next: Option<Nanos>,
}

impl SenseLine {
    /// Takes over an event line. `stamped_by` is the clock of this kernel's stamps.
    pub fn new(
        node: Node,
        title: String,
        handle: LineEventHandle,
        stamped_by: ClockId,
    ) -> io::Result<SenseLine> {
        fcntl(&handle, FcntlArg::F_SETFL(OFlag::O_NONBLOCK))?;
        Ok(SenseLine { node, title, line_seqno: 0, handle, stamped_by, next: None })
    }

    /// When the next edge came, if one is there; it stays the next one until it is [taken](Self::take).
    pub fn peek(&mut self) -> io::Result<Option<Nanos>> {
        if self.next.is_none() {
            self.next = match self.handle.get_event() {
                Ok(event) => Some(to_monotonic(event.timestamp(), self.stamped_by)),
                Err(error) => match last_call(&error) {
                    nothing if nothing.kind() == io::ErrorKind::WouldBlock => None,
                    nothing if nothing.kind() == io::ErrorKind::Interrupted => None,
                    failure => return Err(failure),
                },
            };
        }
        Ok(self.next)
    }

    /// Takes the edge that was looked at, and counts it.
    pub fn take(&mut self) {
        self.next = None;
        self.line_seqno = self.line_seqno.wrapping_add(1);
    }

    /// Whether the line is high.
    pub fn is_high(&self) -> io::Result<bool> {
        self.handle.get_value().map(|value| value != 0).map_err(|error| last_call(&error))
    }
}

impl AsFd for SenseLine {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.handle.as_fd()
    }
}

/// The clock that a kernel stamps the edges of uAPI v1 by: the wall clock until 5.6, `CLOCK_MONOTONIC` from 5.7 on.
pub(super) fn stamping_clock(release: &str) -> ClockId {
    if before(release, (5, 7)) { ClockId::CLOCK_REALTIME } else { ClockId::CLOCK_MONOTONIC }
}

/// Whether a kernel release ("5.4.0-1103-raspi") comes before a version. One that cannot be read does not.
fn before(release: &str, version: (u32, u32)) -> bool {
    let mut numbers = release.split(|c: char| !c.is_ascii_digit()).map_while(|digits| digits.parse().ok());
    matches!((numbers.next(), numbers.next()), (Some(major), Some(minor)) if (major, minor) < version)
}

fn to_monotonic(stamp_ns: u64, stamped_by: ClockId) -> Nanos {
    let ahead = match stamped_by {
        ClockId::CLOCK_MONOTONIC => Nanos::ZERO,
        other => clock(other) - monotonic(),
    };
    Nanos(stamp_ns as i64) - ahead
}

/// What the kernel answered to the call that gave this error. gpio-cdev keeps the number of a failed ioctl in a type
/// that cannot be named here; but it has made no other call since, so it still is the thread's last one.
pub(super) fn last_call(error: &gpio_cdev::Error) -> io::Error {
    let kept = error.source().and_then(|source| source.downcast_ref::<io::Error>()?.raw_os_error());
    kept.map_or_else(io::Error::last_os_error, io::Error::from_raw_os_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_kernels_stamp_by_the_wall_clock() {
        for (release, wall) in [
            ("4.19.0-27-arm64", true),
            ("5.6.19", true),
            ("5.7.0", false),
            ("5.10.103-v7l+", false),
            ("6.12.43+deb13-cloud-arm64", false),
            ("unknown", false),
        ] {
            assert_eq!(stamping_clock(release) == ClockId::CLOCK_REALTIME, wall, "{release}");
        }
    }

    #[test]
    fn stamps_of_the_wall_clock_become_monotonic() {
        let (before, wall) = (monotonic(), clock(ClockId::CLOCK_REALTIME));
        let at = to_monotonic(wall.0 as u64, ClockId::CLOCK_REALTIME);
        let slack = monotonic() - before;
        assert!(at >= before - slack && at <= before + slack + slack, "{at} is not near {before}");
        assert_eq!(to_monotonic(5, ClockId::CLOCK_MONOTONIC), Nanos(5));
    }

    #[test]
    fn the_answer_of_the_kernel_is_kept() {
        let missing = gpio_cdev::Chip::new("/nonexistent").unwrap_err();
        assert_eq!(last_call(&missing).raw_os_error(), Some(libc::ENOENT));
        let file = tempfile::NamedTempFile::new().unwrap();
        let no_chip = gpio_cdev::Chip::new(file.path()).unwrap_err();
        assert_eq!(last_call(&no_chip).raw_os_error(), Some(libc::ENOTTY));
    }
}
