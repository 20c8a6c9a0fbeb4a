//! Real GPIO lines through the Linux character device, by either version of its uAPI.
//!
//! One shape, [`Chardev`], over what the two versions do in their own ways: [v2](Chardev::open) from kernel 5.10 on,
//! [v1](super::chardev_v1::open) before.
//!
//! Kernel behaviour: drivers/gpio/gpiolib-cdev.c. A level change while an edge is being set up gives no event, so
//! `arm` reads the levels last. Unread events survive a change of direction, so `arm` drains them.

use self::error::{hint, is_gone};
use self::wait::{SpinMargin, aligned_tick, readable};
use super::limits::MOST_STALE_EDGES;
use super::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError, later, monotonic};
use crate::units::Nanos;
use nix::poll::{PollFd, PollFlags};
use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};

pub(super) mod chips;
pub(super) mod error;
mod request;
mod v2;
mod wait;
pub(super) mod wiring;

pub use chips::{ChipListing, LineListing, list};
pub use error::ChardevError;
pub use v2::release_lines;
pub use wiring::Wiring;

/// What errors call all sense lines together.
pub(super) const SENSE_LINES: &str = "the sense lines";

/// A call that failed, what the kernel answered, and the line or request it was made for.
pub(super) type Failed = (&'static str, io::Error, String);

/// The lines of a circuit as one version of the uAPI holds them; when dropped, all of them are inputs.
pub(super) trait Held: Send {
    /// Switches from one set of driving lines to another: releases, then drives. Whether lines had to be configured anew for
    /// that: all of them were released then.
    fn switch(&mut self, from: Drives, to: Drives) -> Result<bool, Failed>;
    /// Watches for falling edges of the sense lines from here on, if that is not so already; nothing drives.
    fn watch(&mut self) -> Result<(), Failed>;
    /// The next edge that is there, without waiting.
    fn next_edge(&mut self) -> Result<Option<Edge>, Failed>;
    /// Whether each node is high.
    fn levels(&self) -> Result<[bool; 2], Failed>;
    /// Readable when there is an edge; where one descriptor is all, twice.
    fn descriptors(&self) -> [BorrowedFd<'_>; 2];
}

/// The lines of one circuit, held until dropped; then all of them are inputs.
pub struct Chardev {
    held: Box<dyn Held>,
    /// Name and label of the chip.
    chip: String,
    wired: Drives,
    /// What drives now; `None` after a failed call, when every line may.
    driving: Option<Drives>,
    /// The highest of the edges that were read, and the last of each node.
    seqno: u32,
    line_seqno: [u32; 2],
    margin: SpinMargin,
    renewed: u64,
    /// Where the kernel keeps to multiples of it.
    tick: Option<Nanos>,
    blind_spots: Vec<&'static str>,
}

impl Chardev {
    /// Takes over lines of which none drives.
    pub(super) fn new(
        held: Box<dyn Held>,
        chip: String,
        wired: Drives,
        blind_spots: Vec<&'static str>,
    ) -> Chardev {
        Chardev {
            held,
            chip,
            wired,
            driving: Some(Drives::NONE),
            seqno: 0,
            line_seqno: [0; 2],
            margin: SpinMargin::default(),
            renewed: 0,
            tick: aligned_tick(),
            blind_spots,
        }
    }

    fn next_edge(&mut self) -> Result<Option<Edge>, PinsError> {
        let edge = self.held.next_edge().map_err(|failed| explain(&self.chip, failed))?;
        if let Some(edge) = edge {
            self.seqno = later(self.seqno, edge.seqno);
            self.line_seqno[edge.node.index()] = edge.line_seqno;
        }
        Ok(edge)
    }
}

/// A failed call: the chip is gone, or what is known of the failure without looking anything up.
pub(super) fn explain(chip: &str, (call, source, line): Failed) -> PinsError {
    if is_gone(&source) {
        return PinsError::Gone { chip: chip.to_owned(), call, line };
    }
    let hint = hint(source.raw_os_error().unwrap_or_default());
    PinsError::Call { call, line, source, hint }
}

/// What is to drive when `on` is asked for and these lines are wired. A circuit without a charger of node B is
/// charged by that of node A alone.
fn to_be_driven(on: Drives, wired: Drives) -> Result<Drives, PinsError> {
    if on.conflicts() {
        return Err(PinsError::Conflict(on));
    }
    let on = on.without(Drives::CHARGE_B.without(wired));
    let unwired = on.without(wired);
    if unwired.is_none() { Ok(on) } else { Err(PinsError::Unwired(unwired)) }
}

impl Pins for Chardev {
    fn now(&mut self) -> Nanos {
        monotonic()
    }

    /// Where it takes several calls, the bracket is around all of them.
    ///
    /// # Errors
    /// [`PinsError::Unwired`] if a line of `on` is not wired, before anything is touched.
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        let on = to_be_driven(on, self.wired)?;
        let before = monotonic();
        let released = match self.driving.take() {
            Some(driving) => Ok(driving),
            None => self.held.switch(self.wired, Drives::NONE).map(|_| Drives::NONE),
        };
        let is_renewed = released
            .and_then(|from| self.held.switch(from, on))
            .map_err(|failed| explain(&self.chip, failed))?;
        self.renewed += u64::from(is_renewed);
        self.driving = Some(on);
        Ok(Bracket { before, after: monotonic() })
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.held.watch().map_err(|failed| explain(&self.chip, failed))?;
        // Not for ever: on a line that catches a radio, edges may come faster than they are read.
        for _ in 0..MOST_STALE_EDGES {
            if self.next_edge()?.is_none() {
                break;
            }
        }
        Ok(Armed { levels: self.levels()?, seqno: self.seqno, line_seqno: self.line_seqno })
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        loop {
            // Before the look: an edge of the last moment counts.
            let is_last = monotonic() >= until;
            let descriptors = self.held.descriptors();
            let count = if descriptors[0].as_raw_fd() == descriptors[1].as_raw_fd() { 1 } else { 2 };
            let mut watched = descriptors.map(|fd| PollFd::new(fd, PollFlags::POLLIN));
            let is_there = readable(&mut watched[..count], until)
                .map_err(|errno| explain(&self.chip, ("ppoll", errno.into(), SENSE_LINES.to_owned())))?;
            let edge = if is_there { self.next_edge()? } else { None };
            if edge.is_some() || is_last {
                return Ok(edge);
            }
        }
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.margin.sleep_until(at);
        Ok(())
    }

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.margin.rest_until(at);
        Ok(())
    }

    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.margin.rest_before_edge(at);
        Ok(())
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        let [a, b] = self.held.levels().map_err(|failed| explain(&self.chip, failed))?;
        Ok(Levels { a, b })
    }

    fn particulars(&self) -> Particulars<'_> {
        let (spin_margin, renewed) = (Some(self.margin.0), self.renewed);
        Particulars { spin_margin, renewed, tick: self.tick, blind_spots: &self.blind_spots }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_drive_is_refused() {
        let wired = Drives::CHARGE_A.and(Drives::C1).and(Drives::x(0));
        let refused = |on| to_be_driven(on, wired).unwrap_err();
        assert!(matches!(refused(Drives::CHARGE.and(Drives::C1)), PinsError::Conflict(_)));
        assert!(matches!(refused(Drives::C2.and(Drives::C1)), PinsError::Unwired(Drives::C2)));
        assert_eq!(to_be_driven(Drives::CHARGE, wired).unwrap(), Drives::CHARGE_A);
        assert_eq!(to_be_driven(Drives::x(0), wired).unwrap(), Drives::x(0));
    }

    #[test]
    fn the_disappearance_of_a_chip_is_told_from_other_failures() {
        let failed = |call, errno| {
            explain("gpiochip0", (call, io::Error::from_raw_os_error(errno), "sense".to_owned()))
        };
        let error = failed("GET_VALUES", libc::ENODEV);
        let expected = "the GPIO chip gpiochip0 is gone, says GET_VALUES on sense: its driver was unbound, or the board \
                        unplugged";
        assert!(matches!(error, PinsError::Gone { .. }) && error.to_string() == expected, "{error}");
        let error = failed("SET_VALUES", libc::EIO);
        assert!(matches!(error, PinsError::Call { call: "SET_VALUES", .. }), "{error}");
    }
}
