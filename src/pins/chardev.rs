//! Real GPIO lines through the Linux character device, uAPI v2 (kernel 5.10 and later).
//!
//! Two requests. The *drive request* holds sinks (open drain) and dedicated chargers (open source): a change of
//! direction is one SET_VALUES, which touches no interrupt. The *sense request* holds the sense lines, inputs with
//! falling edges for ever. In the published wiring, where the sense lines charge as well, they are reconfigured
//! (SET_CONFIG) around each charge, but never between [`arm`](Pins::arm) and the next charge: setting up an edge
//! interrupt takes tens of microseconds.
//!
//! Kernel behaviour: drivers/gpio/gpiolib-cdev.c. A level change while an edge is being set up gives no event, so
//! `arm` reads the levels last. Unread events survive a change of direction, so `arm` drains them.

use self::chips::Chip;
use self::edges::EdgeBuffer;
use self::error::as_io;
use self::held::{HeldChip, SENSE_LINES};
use self::request::{charging, drive_request, inputs, released, sense_request, switching, watching};
use self::wiring::{Lines, titles};
use super::limits::MOST_STALE_READS;
use super::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError, monotonic};
use crate::units::Nanos;
use gpiocdev_uapi::v2::{self, LineConfig, LineValues};
use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::poll::{PollFd, PollFlags};
use std::fs::File;
use std::os::fd::AsFd;

pub(super) mod chips;
mod edges;
pub(super) mod error;
pub(super) mod held;
mod names;
pub(super) mod release;
mod request;
mod wait;
pub(super) mod wiring;

pub use chips::{ChipListing, LineListing, Listing, list};
pub use error::{Cause, ChardevError, Holder};
pub use release::release_lines;
pub use wiring::Wiring;

/// The lines of one circuit, held until dropped; then all of them are inputs.
#[derive(Debug)]
pub struct Chardev {
    chip: HeldChip,
    lines: Lines,
    wired: Drives,
    drive_file: File,
    sense_file: File,
    /// What drives now; `None` after a failed call, when every line may.
    driving: Option<Drives>,
    /// Whether the sense lines are inputs with falling edges; where they charge, only from `arm` to the next charge.
    watching: bool,
    edges: EdgeBuffer,
}

impl Chardev {
    /// Requests all lines of the wiring; nothing drives afterwards.
    ///
    /// # Errors
    /// [`ChardevError`], with the likely cause: no such chip or line, no permission, a line held by someone else, a
    /// kernel without uAPI v2.
    pub fn open(wiring: &Wiring) -> Result<Chardev, ChardevError> {
        let chip = Chip::find(&wiring.chip)?;
        let lines = wiring.resolve(&chip)?;
        let get_line = |request: v2::LineRequest, titles: String| {
            let offsets = request.offsets.0[..request.num_lines as usize].to_vec();
            v2::get_line(&chip.file, request)
                .map_err(|error| chip.refusal("GET_LINE", titles, &offsets, as_io(error)))
        };
        let drive_titles = titles(lines.drives.iter().map(|drive| &drive.line));
        let drive_file = get_line(drive_request(&lines, &wiring.consumer), drive_titles)?;
        let sense_titles = titles(&lines.sense);
        let sense_file = get_line(sense_request(&lines, &wiring.consumer), sense_titles.clone())?;
        fcntl(&sense_file, FcntlArg::F_SETFL(OFlag::O_NONBLOCK))
            .map_err(|errno| chip.refusal("F_SETFL", sense_titles, &[], errno.into()))?;
        Ok(Chardev {
            chip: HeldChip::new(chip.title()),
            wired: lines.wired(),
            driving: Some(Drives::NONE),
            watching: !lines.sense_charges,
            lines,
            drive_file,
            sense_file,
            edges: EdgeBuffer::default(),
        })
    }

    /// The sense lines that are to charge, when `on` drives and they are wired for it.
    fn charging_by_sense(&self, on: Drives) -> Drives {
        if self.lines.sense_charges { on.only(Drives::CHARGE) } else { Drives::NONE }
    }

    fn configure_sense(&mut self, config: LineConfig) -> Result<(), PinsError> {
        self.watching = false;
        v2::set_line_config(&self.sense_file, config)
            .map_err(|error| self.chip.failed("SET_CONFIG", SENSE_LINES, as_io(error)))
    }

    fn set_values(&self, values: &LineValues) -> Result<(), PinsError> {
        v2::set_line_values(&self.drive_file, values)
            .map_err(|error| self.chip.failed("SET_VALUES", &self.titles(*values), as_io(error)))
    }

    /// Releases, then drives: sense lines that charge are released before any sink drives, and charge after all
    /// sinks are released.
    fn switch(&mut self, from: Drives, to: Drives) -> Result<(), PinsError> {
        let charged = self.charging_by_sense(from);
        let charge = self.charging_by_sense(to);
        if !charge.contains(charged) {
            self.configure_sense(charging(charged.only(charge)))?;
        }
        for values in switching(&self.lines, from, to) {
            self.set_values(&values)?;
        }
        if !charged.contains(charge) {
            self.configure_sense(charging(charge))?;
        }
        Ok(())
    }

    fn release_all(&mut self) -> Result<(), PinsError> {
        if self.lines.sense_charges {
            self.configure_sense(inputs())?;
        }
        self.set_values(&released(&self.lines))
    }

    fn titles(&self, values: LineValues) -> String {
        let named = self.lines.drives.iter().enumerate().filter(|(bit, _)| values.mask & 1 << bit != 0);
        titles(named.map(|(_, drive)| &drive.line))
    }

    /// Fetches what edges there are, without waiting; whether there were any.
    fn fetch(&mut self) -> Result<bool, PinsError> {
        match v2::read_event(&self.sense_file, self.edges.room()) {
            Ok(words) => Ok(self.edges.filled(words, &self.lines)),
            Err(v2::Error::Os(errno)) if [libc::EAGAIN, libc::EINTR].contains(&errno.0) => Ok(false),
            Err(error) => Err(self.chip.failed("read", SENSE_LINES, as_io(error))),
        }
    }
}

/// What is to drive when `on` is asked for and these lines are wired. A circuit without a charger of node B is
/// charged by that of node A alone.
pub(super) fn to_be_driven(on: Drives, wired: Drives) -> Result<Drives, PinsError> {
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

    /// The published wiring takes a SET_CONFIG of the sense lines where a charger switches; the bracket is around all
    /// calls.
    ///
    /// # Errors
    /// [`PinsError::Unwired`] if a line of `on` is not wired, before anything is touched.
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        let on = to_be_driven(on, self.wired)?;
        let before = monotonic();
        let from = match self.driving.take() {
            Some(driving) => driving,
            None => self.release_all().map(|()| Drives::NONE)?,
        };
        self.switch(from, on)?;
        self.driving = Some(on);
        Ok(Bracket { before, after: monotonic() })
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        if !self.watching {
            self.configure_sense(watching())?;
            self.watching = true;
            self.driving = self.driving.map(|driving| driving.without(self.charging_by_sense(driving)));
        }
        // Not for ever: on a line that catches a radio, edges may come faster than they are read.
        let mut reads = 0;
        while self.fetch()? && reads < MOST_STALE_READS {
            reads += 1;
        }
        self.edges.forget();
        let EdgeBuffer { seqno, line_seqno, .. } = self.edges;
        Ok(Armed { levels: self.levels()?, seqno, line_seqno })
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        loop {
            if let Some(edge) = self.edges.take() {
                return Ok(Some(edge));
            }
            // Before the look: an edge of the last moment counts.
            let is_last = monotonic() >= until;
            let mut watched = [PollFd::new(self.sense_file.as_fd(), PollFlags::POLLIN)];
            let is_ready = self.chip.edges_come(&mut watched, until)?;
            if !(is_ready && self.fetch()?) && is_last {
                return Ok(None);
            }
        }
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.chip.sleep_until(at)
    }

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.chip.rest_until(at)
    }

    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.chip.rest_before_edge(at)
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        let mask = (1 << self.lines.sense.len()) - 1;
        let mut values = LineValues { bits: 0, mask };
        v2::get_line_values(&self.sense_file, &mut values)
            .map_err(|error| self.chip.failed("GET_VALUES", SENSE_LINES, as_io(error)))?;
        Ok(Levels { a: values.get(0).unwrap_or(true), b: values.get(1).unwrap_or(true) })
    }

    fn particulars(&self) -> Particulars<'_> {
        Particulars { spin_margin: Some(self.chip.spin_margin()), blind_spots: &[] }
    }
}

impl Drop for Chardev {
    /// Every line becomes an input before the kernel gets it back: some kernels leave outputs as they are. Nothing can
    /// be done about an error here; the chip is gone.
    fn drop(&mut self) {
        let _ = v2::set_line_config(&self.sense_file, inputs());
        let _ = v2::set_line_config(&self.drive_file, inputs());
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
}
