//! uAPI v2, in two requests.
//!
//! The *drive request* holds sinks (open drain) and dedicated chargers (open source): a change of direction is one
//! SET_VALUES, which touches no interrupt. The *sense request* holds the sense lines, inputs with falling edges for ever. In
//! the published wiring, where the sense lines charge as well, they are reconfigured (SET_CONFIG) around each charge, but
//! never between [`arm`](crate::pins::Pins::arm) and the next charge: setting up an edge interrupt takes tens of microseconds.

use super::chips::{Chip, refused_edges};
use super::error::{ChardevError, as_io};
use super::request::{
    INPUT, SENSE, all, charging, drive_config, drive_request, release_request, sense_request, switching,
};
use super::wiring::{Lines, WiredLine, Wiring, titles};
use super::{Chardev, Failed, Held, SENSE_LINES};
use crate::circuit::Node;
use crate::pins::{Drives, Edge};
use crate::units::Nanos;
use gpiocdev_uapi::v2::{self, LineConfig, LineEdgeEvent, LineValues};
use nix::fcntl::{FcntlArg, OFlag, fcntl};
use std::fs::File;
use std::os::fd::{AsFd, BorrowedFd};
use std::slice;

/// `edge_irq_handler` of drivers/gpio/gpiolib-cdev.c draws a number for each interrupt of several lines only.
const ONE_NUMBER: &str = "uAPI v2 does not number the interrupts of a single sense line: edges that fall together are not noticed, \
    and the last one counts";

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
        let watch = |sense: &[WiredLine]| {
            let titles = titles(sense);
            get_line(sense_request(sense, &wiring.consumer), &titles)
                .map_err(|error| refused_edges(error, &chip, &titles))
        };
        let sense_file = watch(&lines.sense).map_err(|error| {
            // That of a single line is the better one to read.
            lines.sense.iter().find_map(|line| watch(slice::from_ref(line)).err()).unwrap_or(error)
        })?;
        fcntl(&sense_file, FcntlArg::F_SETFL(OFlag::O_NONBLOCK))
            .map_err(|errno| chip.refusal("F_SETFL", &titles(&lines.sense), &[], errno.into()))?;
        let wired = lines.wired();
        let blind_spots = if lines.sense.len() == 1 { vec![ONE_NUMBER] } else { Vec::new() };
        let held = V2 { lines, drive_file, sense_file, watching: true };
        Ok(Chardev::new(Box::new(held), chip.title(), wired, blind_spots))
    }
}

/// Makes every line of the wiring an input, one by one, and lets go of it: for after a kill. Raspberry Pi kernels leave outputs
/// driving when their owner dies (`persist_gpio_outputs`).
///
/// # Errors
/// The first failure; the other lines have been released all the same.
pub fn release_lines(wiring: &Wiring) -> Result<(), ChardevError> {
    let chip = Chip::find(&wiring.chip)?;
    wiring.resolve(&chip)?.release_each(&wiring.consumer, |line| {
        v2::get_line(&chip.file, release_request(line, &wiring.consumer))
            .map(drop)
            .map_err(|error| chip.refusal("GET_LINE", &line.title, &[line.offset], as_io(error)))
    })
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
}

/// Switches the drive lines. Whether they had to be configured anew for that.
///
/// Somebody who reads /sys/kernel/debug/gpio makes the kernel ask the controller for directions. A released charger is an
/// input there, and from then on the kernel does not let anybody set it (`gpiod_get_direction` in drivers/gpio/gpiolib.c
/// knows of emulated open drains only).
fn switch_drives(
    lines: &Lines,
    from: Drives,
    to: Drives,
    set: impl Fn(&LineValues) -> v2::Result<()>,
    configure: impl FnOnce(LineConfig) -> v2::Result<()>,
) -> Result<bool, Failed> {
    let titles_of = |values: LineValues| {
        let named = lines.drives.iter().enumerate().filter(|(bit, _)| values.mask & 1 << bit != 0);
        titles(named.map(|(_, line)| line))
    };
    let switch = |from| {
        let mut calls = switching(lines, from, to);
        calls.try_for_each(|call| set(&call).map_err(|error| ("SET_VALUES", as_io(error), titles_of(call))))
    };
    match switch(from) {
        Err((_, error, titles)) if error.raw_os_error() == Some(libc::EPERM) => {
            configure(drive_config(lines)).map_err(|error| ("SET_CONFIG", as_io(error), titles))?;
            switch(Drives::NONE).map(|()| true)
        }
        outcome => outcome.map(|()| false),
    }
}

/// What a failed call for the sense lines is told by.
fn of_sense(call: &'static str) -> impl Fn(v2::Error) -> Failed {
    move |error| (call, as_io(error), SENSE_LINES.to_owned())
}

impl Held for V2 {
    /// Sense lines that charge are released before any sink drives, and charge after all sinks are released.
    fn switch(&mut self, from: Drives, to: Drives) -> Result<bool, Failed> {
        let charged = self.charging_by_sense(from);
        let charge = self.charging_by_sense(to);
        if !charge.contains(charged) {
            self.configure_sense(charging(charged.only(charge)))?;
        }
        let set = |values: &LineValues| v2::set_line_values(&self.drive_file, values);
        let configure = |config| v2::set_line_config(&self.drive_file, config);
        let is_renewed = switch_drives(&self.lines, from, to, set, configure)?;
        if !charged.contains(charge) {
            self.configure_sense(charging(charge))?;
        }
        Ok(is_renewed)
    }

    fn watch(&mut self) -> Result<(), Failed> {
        if !self.watching {
            self.configure_sense(all(SENSE))?;
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
        let mut senses = Node::BOTH.into_iter().zip(&self.lines.sense);
        let at = Nanos(timestamp_ns as i64);
        let sense = senses.find(|(_, line)| line.offset == event.offset);
        Ok(sense.map(|(node, _)| Edge { node, at, seqno, line_seqno }))
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
        let _ = v2::set_line_config(&self.sense_file, all(INPUT));
        let _ = v2::set_line_config(&self.drive_file, all(INPUT));
    }
}

#[cfg(test)]
mod tests {
    use super::super::wiring::tests::{lines, wiring};
    use super::*;
    use std::cell::{Cell, RefCell};

    /// A kernel that takes some lines of the request for inputs, and lets nobody set these.
    struct Kernel {
        inputs: Cell<u64>,
        calls: RefCell<Vec<LineValues>>,
        /// What SET_CONFIG does to the inputs.
        after_config: u64,
    }

    impl Kernel {
        fn switch(&self, from: Drives, to: Drives) -> Result<bool, Failed> {
            let set = |values: &LineValues| {
                if values.mask & self.inputs.get() != 0 {
                    return Err(v2::Error::Os(v2::Errno(libc::EPERM)));
                }
                self.calls.borrow_mut().push(*values);
                Ok(())
            };
            let configure = |config: LineConfig| {
                assert_eq!(config.num_attrs, 2, "flags of the chargers, values of all");
                self.inputs.set(self.after_config);
                Ok(())
            };
            switch_drives(&lines(&wiring()), from, to, set, configure)
        }
    }

    fn kernel(inputs: u64, after_config: u64) -> Kernel {
        Kernel { inputs: Cell::new(inputs), calls: RefCell::default(), after_config }
    }

    /// Request order: x0, x1, c1, c2, charge-a, charge-b.
    const CHARGERS: u64 = 0b11_0000;

    #[test]
    fn chargers_that_the_kernel_takes_for_inputs_are_configured_anew_and_charge() {
        let looked_at = kernel(CHARGERS, 0);
        assert!(!looked_at.switch(Drives::NONE, Drives::C1).unwrap(), "a sink is as it was");
        assert!(looked_at.switch(Drives::C1, Drives::CHARGE).unwrap());
        // The sink has been released with everything else; the chargers are all that is left to do.
        assert_eq!(looked_at.calls.borrow()[1..], [LineValues { bits: CHARGERS, mask: CHARGERS }]);
        assert!(!looked_at.switch(Drives::CHARGE, Drives::NONE).unwrap());
    }

    #[test]
    fn a_kernel_that_still_refuses_is_told() {
        let (call, error, line) =
            kernel(CHARGERS, CHARGERS).switch(Drives::NONE, Drives::CHARGE).unwrap_err();
        assert_eq!((call, error.raw_os_error()), ("SET_VALUES", Some(libc::EPERM)));
        assert!(line.contains("charge-a (GPIO13)"), "{line}");
    }
}
