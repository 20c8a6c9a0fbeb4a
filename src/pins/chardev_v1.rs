//! Real GPIO lines through the Linux character device, uAPI v1 (kernels before 5.10).
//!
//! One request a line: an event line for each sense line, an output ([`CdevPin`]) for each sink and charger. v1
//! (drivers/gpio/gpiolib-cdev.c, `lineevent_*` and `linehandle_*`) does not number events and cannot reconfigure
//! an event line, so circuits whose sense lines charge are refused; what else it cannot see is told by
//! [`Particulars::blind_spots`].
//!
//! For that the stated uncertainty has no term of its own. An edge that is lost leaves a level without an edge, and is a
//! fault as with v2. One that is coalesced has the stamp of a later crossing of the threshold: where that happens in
//! calibration discharges as well it is part of the noise that is learned from them, and if it is far off it is refused as an
//! outlier. A pull-down is looked for as a leak is.

use self::sense::{SenseLine, last_call, stamping_clock};
use self::switches::{Switch, Switches};
use super::chardev::chips::Chip;
use super::chardev::error::{Cause, ChardevError};
use super::chardev::held::HeldChip;
use super::chardev::release::each_line;
use super::chardev::to_be_driven;
use super::chardev::wiring::{DriveLine, WiredLine, Wiring};
use super::limits::MOST_STALE_EDGES;
use super::{Armed, Bracket, Drives, Edge, Levels, Node, Particulars, Pins, PinsError, monotonic};
use crate::units::Nanos;
use gpio_cdev::{EventRequestFlags, LineHandle, LineRequestFlags};
use linux_embedded_hal::CdevPin;
use nix::poll::{PollFd, PollFlags};
use nix::time::ClockId;
use std::io;
use std::os::fd::AsFd;

mod sense;
mod switches;

/// GPIOHANDLE_REQUEST_BIAS_DISABLE (include/uapi/linux/gpio.h), since Linux 5.5; gpio-cdev has no name for it.
const BIAS_DISABLE: LineRequestFlags = LineRequestFlags::from_bits_retain(1 << 7);

const NO_NUMBERS: &str = "uAPI v1 does not number edges: lost and coalesced ones are not noticed";
const SHORT_BUFFER: &str = "uAPI v1 keeps 16 edges a line and drops the newest";
const NO_BIAS: &str = "this kernel (before 5.5) cannot switch pulls off: see that none is on";
const WALL_CLOCK: &str = "this kernel (before 5.7) stamps edges by the wall clock: a step of it moves them";

const NEEDS_CHARGERS: &str = "backend \"chardev-v1\" needs charge-a (and charge-b): uAPI v1 cannot turn a sense line \
    into an output and back; wire chargers, or use a kernel from 5.10 on with backend \"chardev\"";
const NO_V1: &str =
    "the kernel refuses a flag, or has no uAPI v1 (CONFIG_GPIO_CDEV_V1): use backend \"chardev\"";

/// The lines of one circuit, held until dropped; then all of them are inputs.
pub struct ChardevV1 {
    chip: HeldChip,
    wired: Drives,
    switches: Switches<CdevPin>,
    sense: Vec<SenseLine>,
    seqno: u32,
    blind_spots: Vec<&'static str>,
}

impl ChardevV1 {
    /// Requests all lines of the wiring; nothing drives afterwards.
    ///
    /// # Errors
    /// [`ChardevError`], with the likely cause. A wiring without dedicated chargers is refused.
    pub fn open(wiring: &Wiring) -> Result<ChardevV1, ChardevError> {
        if wiring.sense_charges() {
            return Err(ChardevError::Wiring(NEEDS_CHARGERS.to_string()));
        }
        let chip = Chip::find(&wiring.chip)?;
        let lines = wiring.resolve(&chip)?;
        let mut requests = Requests::new(&chip, &wiring.consumer)?;
        let switches = lines.drives.iter().map(|drive| requests.drive(drive)).collect::<Result<_, _>>()?;
        let switches = Switches::new(switches);
        let release = nix::sys::utsname::uname().map(|name| name.release().to_string_lossy().into_owned());
        let stamped_by = stamping_clock(&release.unwrap_or_default());
        let nodes = Node::BOTH.into_iter().zip(&lines.sense);
        let sense =
            nodes.map(|(node, line)| requests.sense(node, line, stamped_by)).collect::<Result<_, _>>()?;
        let mut blind_spots = vec![NO_NUMBERS, SHORT_BUFFER];
        blind_spots.extend((!requests.bias).then_some(NO_BIAS));
        blind_spots.extend((stamped_by == ClockId::CLOCK_REALTIME).then_some(WALL_CLOCK));
        Ok(ChardevV1 {
            chip: HeldChip::new(chip.title()),
            wired: lines.wired(),
            switches,
            sense,
            seqno: 0,
            blind_spots,
        })
    }

    /// Takes the earliest edge that is there.
    fn next(&mut self) -> Result<Option<Edge>, PinsError> {
        let mut earliest: Option<(Nanos, &mut SenseLine)> = None;
        for line in &mut self.sense {
            let at = line.peek().map_err(|error| self.chip.failed("read", &line.title, error))?;
            if let Some(at) = at.filter(|at| earliest.as_ref().is_none_or(|(first, _)| at < first)) {
                earliest = Some((at, line));
            }
        }
        let Some((at, line)) = earliest else { return Ok(None) };
        line.take();
        self.seqno = self.seqno.wrapping_add(1);
        Ok(Some(Edge { node: line.node, at, seqno: self.seqno, line_seqno: line.line_seqno }))
    }

    fn poll(&self, until: Nanos) -> Result<(), PinsError> {
        let [Some(a), b] = [self.sense.first(), self.sense.get(1)] else { return Ok(()) };
        let mut watched = [a, b.unwrap_or(a)].map(|line| PollFd::new(line.as_fd(), PollFlags::POLLIN));
        self.chip.edges_come(&mut watched, until).map(drop)
    }
}

impl Pins for ChardevV1 {
    fn now(&mut self) -> Nanos {
        monotonic()
    }

    /// A call for each line that changes; the bracket is around all of them.
    ///
    /// # Errors
    /// [`PinsError::Unwired`] if a line of `on` is not wired, before anything is touched.
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        let on = to_be_driven(on, self.wired)?;
        let before = monotonic();
        let outcome = self.switches.drive(on);
        let after = monotonic();
        outcome.map(|()| Bracket { before, after }).map_err(|(part, error)| {
            let source = last_call(error.inner());
            self.chip.failed("SET_LINE_VALUES", self.switches.title(part), source)
        })
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        // Not for ever: on a line that catches a radio, edges may come faster than they are read.
        for _ in 0..MOST_STALE_EDGES {
            if self.next()?.is_none() {
                break;
            }
        }
        let mut line_seqno = [0; 2];
        for line in &self.sense {
            line_seqno[line.node.index()] = line.line_seqno;
        }
        Ok(Armed { levels: self.levels()?, seqno: self.seqno, line_seqno })
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        loop {
            if let Some(edge) = self.next()? {
                return Ok(Some(edge));
            }
            if monotonic() >= until {
                return Ok(None);
            }
            self.poll(until)?;
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
        let mut high = [true; 2];
        for line in &self.sense {
            let level = line.is_high();
            high[line.node.index()] =
                level.map_err(|error| self.chip.failed("GET_LINE_VALUES", &line.title, error))?;
        }
        Ok(Levels { a: high[0], b: high[1] })
    }

    fn particulars(&self) -> Particulars<'_> {
        Particulars { spin_margin: Some(self.chip.spin_margin()), blind_spots: &self.blind_spots }
    }
}

impl Drop for ChardevV1 {
    /// Every line is released, then requested as an input before the kernel gets it back: some kernels leave outputs
    /// as they are. Nothing can be done about an error here; the chip is gone.
    fn drop(&mut self) {
        let switches = std::mem::replace(&mut self.switches, Switches::new(Vec::new()));
        for pin in switches.into_released() {
            let _ = pin.into_input_pin();
        }
    }
}

/// Makes every line of the wiring an input, one by one, and lets go of it.
///
/// # Errors
/// The first failure; the other lines have been released all the same.
pub fn release_lines(wiring: &Wiring) -> Result<(), ChardevError> {
    let chip = Chip::find(&wiring.chip)?;
    let lines = wiring.resolve(&chip)?;
    let mut requests = Requests::new(&chip, &wiring.consumer)?;
    each_line(&lines, |line| requests.handle(line, LineRequestFlags::INPUT, 0).map(drop))
}

/// Requests single lines of one chip.
struct Requests<'a> {
    chip: &'a Chip,
    cdev: gpio_cdev::Chip,
    consumer: &'a str,
    /// Whether the kernel still has to refuse BIAS_DISABLE.
    bias: bool,
}

impl<'a> Requests<'a> {
    fn new(chip: &'a Chip, consumer: &'a str) -> Result<Requests<'a>, ChardevError> {
        let cdev = gpio_cdev::Chip::new(&chip.path)
            .map_err(|error| chip.refusal("open", "the device node".to_string(), &[], last_call(&error)))?;
        Ok(Requests { chip, cdev, consumer, bias: true })
    }

    /// A released sink or charger.
    fn drive(&mut self, drive: &DriveLine) -> Result<Switch<CdevPin>, ChardevError> {
        let (kind, released) = match drive.charges() {
            true => (LineRequestFlags::OPEN_SOURCE, 0),
            false => (LineRequestFlags::OPEN_DRAIN, 1),
        };
        let handle = self.unbiased(|requests, bias| {
            requests.handle(&drive.line, LineRequestFlags::OUTPUT | kind.clone() | bias, released)
        })?;
        let pin = CdevPin::new(handle)
            .map_err(|error| self.refusal("GET_LINEINFO", &drive.line, last_call(&error)))?;
        Ok(Switch { part: drive.part, title: drive.line.title.clone(), pin })
    }

    fn sense(
        &mut self,
        node: Node,
        line: &WiredLine,
        stamped_by: ClockId,
    ) -> Result<SenseLine, ChardevError> {
        let handle = self.unbiased(|requests, bias| {
            let found = requests.line(line)?;
            found
                .events(LineRequestFlags::INPUT | bias, EventRequestFlags::FALLING_EDGE, requests.consumer)
                .map_err(|error| requests.refusal("GET_LINEEVENT", line, last_call(&error)))
        })?;
        SenseLine::new(node, line.title.clone(), handle, stamped_by)
            .map_err(|error| self.refusal("F_SETFL", line, error))
    }

    fn handle(
        &mut self,
        line: &WiredLine,
        flags: LineRequestFlags,
        value: u8,
    ) -> Result<LineHandle, ChardevError> {
        let found = self.line(line)?;
        found
            .request(flags, value, self.consumer)
            .map_err(|error| self.refusal("GET_LINEHANDLE", line, last_call(&error)))
    }

    fn line(&mut self, line: &WiredLine) -> Result<gpio_cdev::Line, ChardevError> {
        let found = self.cdev.get_line(line.offset);
        found.map_err(|error| self.refusal("GET_LINEINFO", line, last_call(&error)))
    }

    /// Makes a request with pulls switched off; on kernels that do not know the flag, without.
    fn unbiased<T>(
        &mut self,
        mut request: impl FnMut(&mut Self, LineRequestFlags) -> Result<T, ChardevError>,
    ) -> Result<T, ChardevError> {
        if self.bias {
            match request(self, BIAS_DISABLE) {
                Err(ChardevError::Call { source, .. }) if source.raw_os_error() == Some(libc::EINVAL) => {
                    self.bias = false;
                }
                other => return other,
            }
        }
        request(self, LineRequestFlags::empty())
    }

    fn refusal(&self, call: &'static str, line: &WiredLine, source: io::Error) -> ChardevError {
        let is_unknown = [Some(libc::EINVAL), Some(libc::ENOTTY)].contains(&source.raw_os_error());
        match self.chip.refusal(call, line.title.clone(), &[line.offset], source) {
            ChardevError::Call { call, line, source, .. } if is_unknown => {
                ChardevError::Call { call, line, source, cause: Cause::Hint(NO_V1) }
            }
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::chardev::wiring::tests::wiring;
    use super::*;

    #[test]
    fn a_wiring_without_chargers_is_refused_with_the_reason() {
        let wiring = Wiring { charge_a: None, charge_b: None, ..wiring() };
        let message = ChardevV1::open(&wiring).err().unwrap().to_string();
        assert!(message.contains("charge-a") && message.contains("uAPI v1"), "{message}");
    }
}
