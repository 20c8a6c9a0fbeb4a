//! uAPI v2, in two requests.
//!
//! The *drive request* holds sinks (open drain) and dedicated chargers (open source): a change of direction is one
//! SET_VALUES, which touches no interrupt. The *sense request* holds the sense lines, inputs with falling edges for ever. In
//! the published wiring, where the sense lines charge as well, they are reconfigured (SET_CONFIG) around each charge, but
//! never between [`arm`](crate::pins::Pins::arm) and the next charge: setting up an edge interrupt takes tens of microseconds.

use super::chips::Chip;
use super::error::{ChardevError, as_io};
use super::request::{charging, drive_request, inputs, sense_request, switching, watching};
use super::wiring::{Lines, Wiring, titles};
use super::{Chardev, Failed, Held, SENSE_LINES};
use crate::pins::{Drives, Edge};
use crate::units::Nanos;
use gpiocdev_uapi::v2::{self, LineConfig, LineEdgeEvent, LineValues};
use nix::fcntl::{FcntlArg, OFlag, fcntl};
use std::fs::File;
use std::os::fd::{AsFd, BorrowedFd};

struct V2 {
    lines: Lines,
    drive_file: File,
    sense_file: File,
    /// Whether the sense lines are inputs with falling edges; where they charge, only from `arm` to the next charge.
    watching: bool,
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
        let get_line = |request: v2::LineRequest, titles: &str| {
            let offsets = request.offsets.0[..request.num_lines as usize].to_vec();
            v2::get_line(&chip.file, request)
                .map_err(|error| chip.refusal("GET_LINE", titles, &offsets, as_io(error)))
        };
        let drive_file = get_line(drive_request(&lines, &wiring.consumer), &titles(&lines.drives))?;
        let sense_titles = titles(&lines.sense);
        let sense_file = get_line(sense_request(&lines, &wiring.consumer), &sense_titles)?;
        fcntl(&sense_file, FcntlArg::F_SETFL(OFlag::O_NONBLOCK))
            .map_err(|errno| chip.refusal("F_SETFL", &sense_titles, &[], errno.into()))?;
        let (wired, watching) = (lines.wired(), !lines.sense_charges);
        let held = V2 { lines, drive_file, sense_file, watching };
        Ok(Chardev::new(Box::new(held), chip.title(), wired, Vec::new()))
    }
}

impl V2 {
    /// The sense lines that are to charge, when `on` drives and they are wired for it.
    fn charging_by_sense(&self, on: Drives) -> Drives {
        if self.lines.sense_charges { on.only(Drives::CHARGE) } else { Drives::NONE }
    }

    fn configure_sense(&mut self, config: LineConfig) -> Result<(), Failed> {
        self.watching = false;
        v2::set_line_config(&self.sense_file, config).map_err(of_sense("SET_CONFIG"))
    }

    fn titles(&self, values: LineValues) -> String {
        let named = self.lines.drives.iter().enumerate().filter(|(bit, _)| values.mask & 1 << bit != 0);
        titles(named.map(|(_, line)| line))
    }
}

/// What a failed call for the sense lines is told by.
fn of_sense(call: &'static str) -> impl Fn(v2::Error) -> Failed {
    move |error| (call, as_io(error), SENSE_LINES.to_owned())
}

impl Held for V2 {
    /// Sense lines that charge are released before any sink drives, and charge after all sinks are released.
    fn switch(&mut self, from: Drives, to: Drives) -> Result<(), Failed> {
        let charged = self.charging_by_sense(from);
        let charge = self.charging_by_sense(to);
        if !charge.contains(charged) {
            self.configure_sense(charging(charged.only(charge)))?;
        }
        for values in switching(&self.lines, from, to) {
            v2::set_line_values(&self.drive_file, &values)
                .map_err(|error| ("SET_VALUES", as_io(error), self.titles(values)))?;
        }
        if !charged.contains(charge) {
            self.configure_sense(charging(charge))?;
        }
        Ok(())
    }

    fn watch(&mut self) -> Result<(), Failed> {
        if !self.watching {
            self.configure_sense(watching())?;
            self.watching = true;
        }
        Ok(())
    }

    fn next_edge(&mut self) -> Result<Option<Edge>, Failed> {
        let mut words = [0; size_of::<LineEdgeEvent>() / size_of::<u64>()];
        match v2::read_event(&self.sense_file, &mut words) {
            Ok(_) => {}
            Err(v2::Error::Os(errno)) if [libc::EAGAIN, libc::EINTR].contains(&errno.0) => return Ok(None),
            Err(error) => return Err(of_sense("read")(error)),
        }
        let event = LineEdgeEvent::from_slice(&words).map_err(of_sense("read"))?;
        let LineEdgeEvent { timestamp_ns, seqno, line_seqno, .. } = *event;
        let node = self.lines.node_at(event.offset);
        Ok(node.map(|node| Edge { node, at: Nanos(timestamp_ns as i64), seqno, line_seqno }))
    }

    fn levels(&self) -> Result<[bool; 2], Failed> {
        let mut values = LineValues { bits: 0, mask: (1 << self.lines.sense.len()) - 1 };
        v2::get_line_values(&self.sense_file, &mut values).map_err(of_sense("GET_VALUES"))?;
        Ok([0, 1].map(|line| values.get(line).unwrap_or(true)))
    }

    fn descriptors(&self) -> [BorrowedFd<'_>; 2] {
        [self.sense_file.as_fd(); 2]
    }
}

impl Drop for V2 {
    /// Every line becomes an input before the kernel gets it back: some kernels leave outputs as they are. Nothing can
    /// be done about an error here; the chip is gone.
    fn drop(&mut self) {
        let _ = v2::set_line_config(&self.sense_file, inputs());
        let _ = v2::set_line_config(&self.drive_file, inputs());
    }
}
