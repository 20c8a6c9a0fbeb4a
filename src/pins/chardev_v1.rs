//! Real GPIO lines through the Linux character device, uAPI v1 (kernels before 5.10).
//!
//! One request a line: an event line for each sense line, an output ([`CdevPin`]) for each sink and charger; v1 sets all lines
//! of a request at once, without a mask, and lines that do not change are not to be touched. v1
//! (drivers/gpio/gpiolib-cdev.c, `lineevent_*` and `linehandle_*`) does not number events and cannot reconfigure
//! an event line, so circuits whose sense lines charge are refused; what else it cannot see is told by
//! [`Particulars::blind_spots`](crate::pins::Particulars::blind_spots).
//!
//! For that the stated uncertainty has no term of its own. An edge that is lost leaves a level without an edge, and is a
//! fault as with v2. One that is coalesced has the stamp of a later crossing of the threshold: where that happens in
//! calibration discharges as well it is part of the noise that is learned from them, and if it is far off it is refused as an
//! outlier. A pull-down is looked for as a leak is.

use super::chardev::chips::{Chip, refused_edges};
use super::chardev::error::ChardevError;
use super::chardev::wiring::{WiredLine, Wiring};
use super::chardev::{Chardev, Failed, Held};
use super::{Drives, Edge, Node, clock, kernel, monotonic};
use crate::units::Nanos;
use embedded_hal::digital::OutputPin;
use gpio_cdev::{EventRequestFlags, LineEventHandle, LineRequestFlags};
use linux_embedded_hal::CdevPin;
use nix::fcntl::{FcntlArg, OFlag, fcntl};
use nix::time::ClockId;
use std::error::Error;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};

/// GPIOHANDLE_REQUEST_BIAS_DISABLE (include/uapi/linux/gpio.h), since Linux 5.5; gpio-cdev has no name for it.
const BIAS_DISABLE: LineRequestFlags = LineRequestFlags::from_bits_retain(1 << 7);
const FIRST_BIAS: (u32, u32) = (5, 5);
/// The first kernel that stamps edges by `CLOCK_MONOTONIC`.
const FIRST_MONOTONIC: (u32, u32) = (5, 7);

const NO_NUMBERS: &str = "uAPI v1 does not number edges: lost and coalesced ones are not noticed";
const SHORT_BUFFER: &str = "uAPI v1 keeps 16 edges a line and drops the newest";
const NO_BIAS: &str = "this kernel (before 5.5) cannot switch pulls off: see that none is on";
const WALL_CLOCK: &str = "this kernel (before 5.7) stamps edges by the wall clock: a step of it moves them";

const NEEDS_CHARGERS: &str = "backend \"chardev-v1\" needs charge-a (and charge-b): uAPI v1 cannot turn a sense line \
    into an output and back; wire chargers, or use a kernel from 5.10 on with backend \"chardev\"";

/// Requests all lines of the wiring; nothing drives afterwards.
///
/// # Errors
/// [`ChardevError`], with the likely cause. A wiring without dedicated chargers is refused.
pub fn open(wiring: &Wiring) -> Result<Chardev, ChardevError> {
    if wiring.sense_charges() {
        return Err(ChardevError::Wiring(NEEDS_CHARGERS.to_string()));
    }
    let chip = Chip::find(&wiring.chip)?;
    let lines = wiring.resolve(&chip)?;
    let is_before = |version| kernel().1.is_some_and(|running| running < version);
    let (no_bias, wall_clock) = (is_before(FIRST_BIAS), is_before(FIRST_MONOTONIC));
    let bias = if no_bias { LineRequestFlags::empty() } else { BIAS_DISABLE };
    let mut requests = Requests::new(&chip)?;
    let switches = lines.drives.iter().map(|line| {
        let (kind, released) = match line.charges() {
            true => (LineRequestFlags::OPEN_SOURCE, 0),
            false => (LineRequestFlags::OPEN_DRAIN, 1),
        };
        let flags = LineRequestFlags::OUTPUT | kind | bias.clone();
        let pin = requests.ask("GET_LINEHANDLE", line, |found| {
            CdevPin::new(found.request(flags, released, &wiring.consumer)?)
        })?;
        Ok(DriveLine { line: line.clone(), pin })
    });
    let switches = switches.collect::<Result<_, _>>()?;
    let sense = Node::BOTH.into_iter().zip(&lines.sense).map(|(node, line)| {
        let (flags, edges) = (LineRequestFlags::INPUT | bias.clone(), EventRequestFlags::FALLING_EDGE);
        let handle = requests
            .ask("GET_LINEEVENT", line, |found| found.events(flags, edges, &wiring.consumer))
            .map_err(|error| refused_edges(error, &chip, &line.title))?;
        fcntl(&handle, FcntlArg::F_SETFL(OFlag::O_NONBLOCK))
            .map_err(|errno| chip.refusal("F_SETFL", &line.title, &[], errno.into()))?;
        Ok(SenseLine { node, title: line.title.clone(), count: 0, handle })
    });
    let sense = sense.collect::<Result<_, _>>()?;
    let mut blind_spots = vec![NO_NUMBERS, SHORT_BUFFER];
    blind_spots.extend(no_bias.then_some(NO_BIAS));
    blind_spots.extend(wall_clock.then_some(WALL_CLOCK));
    let held = V1 { switches, sense, seqno: 0, wall_clock };
    Ok(Chardev::new(Box::new(held), chip.title(), lines.wired(), blind_spots))
}

/// Makes every line of the wiring an input, one by one, and lets go of it.
///
/// # Errors
/// The first failure; the other lines have been released all the same.
pub fn release_lines(wiring: &Wiring) -> Result<(), ChardevError> {
    let chip = Chip::find(&wiring.chip)?;
    let (lines, mut requests) = (wiring.resolve(&chip)?, Requests::new(&chip)?);
    let input = LineRequestFlags::INPUT;
    lines.release_each(&wiring.consumer, |line| {
        requests
            .ask("GET_LINEHANDLE", line, |found| found.request(input.clone(), 0, &wiring.consumer))
            .map(drop)
    })
}

/// A line that is driven both ways, at this level from the request on.
pub(super) fn output(
    chip: &Chip,
    offset: u32,
    high: bool,
    title: &str,
    consumer: &str,
) -> Result<CdevPin, ChardevError> {
    let line = WiredLine { part: Drives::NONE, offset, title: title.to_owned() };
    Requests::new(chip)?.ask("GET_LINEHANDLE", &line, |found| {
        CdevPin::new(found.request(LineRequestFlags::OUTPUT, high.into(), consumer)?)
    })
}

/// Asks one chip for single lines.
struct Requests<'a> {
    chip: &'a Chip,
    cdev: gpio_cdev::Chip,
}

impl<'a> Requests<'a> {
    fn new(chip: &'a Chip) -> Result<Requests<'a>, ChardevError> {
        let cdev = gpio_cdev::Chip::new(&chip.listing.path)
            .map_err(|error| chip.refusal("open", "the device node", &[], last_call(&error)))?;
        Ok(Requests { chip, cdev })
    }

    fn ask<T>(
        &mut self,
        call: &'static str,
        line: &WiredLine,
        request: impl FnOnce(gpio_cdev::Line) -> Result<T, gpio_cdev::Error>,
    ) -> Result<T, ChardevError> {
        let got = self.cdev.get_line(line.offset).and_then(request);
        got.map_err(|error| self.chip.refusal(call, &line.title, &[line.offset], last_call(&error)))
    }
}

/// A drive line.
struct DriveLine<P> {
    line: WiredLine,
    /// Open drain for a sink, open source for a charger.
    pin: P,
}

impl<P: OutputPin> DriveLine<P> {
    fn set(&mut self, on: bool) -> Result<(), P::Error> {
        // An open-drain line sinks when low, an open-source line charges when high; otherwise both are inputs.
        self.pin.set_state((on == self.line.charges()).into())
    }
}

/// By a call for each line that changes. Of the one that fails, the title comes with the error of its pin.
fn switch<P: OutputPin>(
    switches: &mut [DriveLine<P>],
    from: Drives,
    to: Drives,
) -> Result<(), (String, P::Error)> {
    for on in [false, true] {
        let change = if on { to.without(from) } else { from.without(to) };
        for switch in switches.iter_mut().filter(|switch| change.contains(switch.line.part)) {
            switch.set(on).map_err(|error| (switch.line.title.clone(), error))?;
        }
    }
    Ok(())
}

/// An input whose falling edges are stamped.
struct SenseLine {
    node: Node,
    title: String,
    /// How many edges have been read.
    count: u32,
    handle: LineEventHandle,
}

struct V1 {
    /// In switching order.
    switches: Vec<DriveLine<CdevPin>>,
    sense: Vec<SenseLine>,
    seqno: u32,
    /// Whether stamps are of `CLOCK_REALTIME`.
    wall_clock: bool,
}

impl Held for V1 {
    fn switch(&mut self, from: Drives, to: Drives) -> Result<bool, Failed> {
        switch(&mut self.switches, from, to)
            .map(|()| false)
            .map_err(|(title, error)| ("SET_LINE_VALUES", last_call(error.inner()), title))
    }

    fn watch(&mut self) -> Result<(), Failed> {
        Ok(())
    }

    /// Of edges at both nodes, that of A comes first.
    fn next_edge(&mut self) -> Result<Option<Edge>, Failed> {
        for line in &mut self.sense {
            let at = match line.handle.get_event() {
                Ok(event) if self.wall_clock => to_monotonic(event.timestamp()),
                Ok(event) => Nanos(event.timestamp() as i64),
                Err(error) => match last_call(&error) {
                    nothing if nothing.kind() == io::ErrorKind::WouldBlock => continue,
                    nothing if nothing.kind() == io::ErrorKind::Interrupted => continue,
                    failure => return Err(("read", failure, line.title.clone())),
                },
            };
            line.count = line.count.wrapping_add(1);
            self.seqno = self.seqno.wrapping_add(1);
            return Ok(Some(Edge { node: line.node, at, seqno: self.seqno, line_seqno: line.count }));
        }
        Ok(None)
    }

    fn levels(&self) -> Result<[bool; 2], Failed> {
        let mut high = [true; 2];
        for line in &self.sense {
            let level = line.handle.get_value();
            let level = level.map_err(|e| ("GET_LINE_VALUES", last_call(&e), line.title.clone()))?;
            high[line.node.index()] = level != 0;
        }
        Ok(high)
    }

    fn descriptors(&self) -> [BorrowedFd<'_>; 2] {
        // There is one sense line at least.
        [0, self.sense.len() - 1].map(|line| self.sense[line].handle.as_fd())
    }
}

impl Drop for V1 {
    /// Every line is released, then requested as an input before the kernel gets it back: some kernels leave outputs
    /// as they are. Nothing can be done about an error here; the chip is gone.
    fn drop(&mut self) {
        self.switches.iter_mut().for_each(|switch| drop(switch.set(false)));
        for switch in self.switches.drain(..) {
            let _ = switch.pin.into_input_pin();
        }
    }
}

fn to_monotonic(wall_ns: u64) -> Nanos {
    Nanos(wall_ns as i64) - (clock(ClockId::CLOCK_REALTIME) - monotonic())
}

/// What the kernel answered to the call that gave this error. gpio-cdev keeps the number of a failed ioctl in a type
/// that cannot be named here; but it has made no other call since, so it still is the thread's last one.
pub(super) fn last_call(error: &gpio_cdev::Error) -> io::Error {
    let kept = error.source().and_then(|source| source.downcast_ref::<io::Error>()?.raw_os_error());
    kept.map_or_else(io::Error::last_os_error, io::Error::from_raw_os_error)
}

#[cfg(test)]
mod tests;
