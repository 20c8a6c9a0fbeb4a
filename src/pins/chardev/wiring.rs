//! Which line of which chip plays which part, and in which order lines switch.

use super::chips::Chip;
use super::error::ChardevError;
use super::names::line_offset;
use crate::circuit::Node;
use crate::pins::{Drives, MAX_CHANNELS};

/// How a circuit is wired to the lines of one chip. A line is given by name ("GPIO17") or by offset ("17").
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wiring {
    /// Label ("pinctrl-rp1"), name ("gpiochip0") or path ("/dev/gpiochip0") of the chip.
    pub chip: String,
    /// Senses node A.
    pub sense_a: String,
    /// Senses node B, in circuits that have it.
    pub sense_b: Option<String>,
    /// Charges node A. Without any charge line the sense lines charge too.
    pub charge_a: Option<String>,
    /// Charges node B.
    pub charge_b: Option<String>,
    /// Sinks Rc1.
    pub sink_c1: String,
    /// Sinks Rc2.
    pub sink_c2: String,
    /// Sink the sensors, one a channel.
    pub sinks_x: Vec<String>,
    /// What other programs see as the consumer of the lines; the kernel keeps 31 bytes of it.
    pub consumer: String,
}

/// A line found on its chip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::pins) struct WiredLine {
    /// Its number on the chip.
    pub offset: u32,
    /// What errors call it: `sink-c1 (GPIO20)`.
    pub title: String,
}

/// The titles of some lines, for errors of a call that was made for all of them.
pub(super) fn titles<'a>(lines: impl IntoIterator<Item = &'a WiredLine>) -> String {
    lines.into_iter().map(|line| line.title.as_str()).collect::<Vec<_>>().join(", ")
}

/// A line that drives, and the part it plays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::pins) struct DriveLine {
    /// One line of a set.
    pub part: Drives,
    /// Where it is.
    pub line: WiredLine,
}

impl DriveLine {
    /// Whether it pulls up (open source); otherwise it sinks (open drain).
    pub fn charges(&self) -> bool {
        Drives::CHARGE.contains(self.part)
    }
}

/// The lines of a circuit, found on their chip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::pins) struct Lines {
    /// Node A, then node B if the circuit has it.
    pub sense: Vec<WiredLine>,
    /// In the order in which they switch: that of [`Drives::lines`].
    pub drives: Vec<DriveLine>,
    /// Whether the sense lines charge: there are no chargers among `drives`.
    pub sense_charges: bool,
}

impl Lines {
    /// Every part that some line can play.
    pub fn wired(&self) -> Drives {
        let drives = self.drives.iter().fold(Drives::NONE, |set, drive| set.and(drive.part));
        match (self.sense_charges, self.sense.len()) {
            (false, _) => drives,
            (true, 1) => drives.and(Drives::CHARGE_A),
            (true, _) => drives.and(Drives::CHARGE),
        }
    }

    /// The node that a sense line with this offset is at.
    pub fn node_at(&self, offset: u32) -> Option<Node> {
        let position = self.sense.iter().position(|line| line.offset == offset)?;
        Node::BOTH.get(position).copied()
    }
}

impl Wiring {
    /// The key of each sense line in a configuration, and its name or offset.
    fn sense_parts(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let b = self.sense_b.as_deref().map(|name| ("sense-b", name));
        std::iter::once(("sense-a", self.sense_a.as_str())).chain(b)
    }

    /// The same for the drive lines, in switching order.
    fn drive_parts(&self) -> impl Iterator<Item = (Drives, String, &str)> {
        let sensors = self.sinks_x.iter().enumerate();
        let sensors =
            sensors.map(|(channel, name)| (Drives::x(channel), format!("sink-x{channel}"), Some(name)));
        let others = [
            (Drives::C1, "sink-c1", Some(&self.sink_c1)),
            (Drives::C2, "sink-c2", Some(&self.sink_c2)),
            (Drives::CHARGE_A, "charge-a", self.charge_a.as_ref()),
            (Drives::CHARGE_B, "charge-b", self.charge_b.as_ref()),
        ];
        let others = others.into_iter().map(|(part, key, name)| (part, key.to_string(), name));
        sensors.chain(others).filter_map(|(part, key, name)| Some((part, key, name?.as_str())))
    }

    /// Whether the sense lines have to charge as well, as in the published circuit.
    pub fn sense_charges(&self) -> bool {
        self.charge_a.is_none() && self.charge_b.is_none()
    }

    /// Finds every line on the chip.
    ///
    /// # Errors
    /// [`ChardevError::Wiring`] for what cannot be, [`ChardevError::NoLine`] for names the chip does not have.
    pub(in crate::pins) fn resolve(&self, chip: &Chip) -> Result<Lines, ChardevError> {
        self.check()?;
        let known = chip.lines()?;
        let find = |key: &str, wanted: &str| {
            let offset = line_offset(&known, wanted, &chip.title())?;
            Ok::<_, ChardevError>(WiredLine { offset, title: format!("{key} ({wanted})") })
        };
        let sense = self.sense_parts().map(|(key, name)| find(key, name)).collect::<Result<Vec<_>, _>>()?;
        let drives = self
            .drive_parts()
            .map(|(part, key, name)| Ok(DriveLine { part, line: find(&key, name)? }))
            .collect::<Result<Vec<_>, ChardevError>>()?;
        let lines = Lines { sense, drives, sense_charges: self.sense_charges() };
        distinct(&lines)?;
        Ok(lines)
    }

    fn check(&self) -> Result<(), ChardevError> {
        let refuse = |why: String| Err(ChardevError::Wiring(why));
        if self.sinks_x.len() > MAX_CHANNELS {
            return refuse(format!(
                "{} channels: at most {MAX_CHANNELS} share a circuit",
                self.sinks_x.len()
            ));
        }
        if self.charge_a.is_none() && self.charge_b.is_some() {
            return refuse("charge-b without charge-a: node A would never be charged".to_string());
        }
        if self.charge_b.is_some() && self.sense_b.is_none() {
            return refuse("charge-b without sense-b: the circuit has no node B".to_string());
        }
        Ok(())
    }
}

fn distinct(lines: &Lines) -> Result<(), ChardevError> {
    let all: Vec<&WiredLine> =
        lines.sense.iter().chain(lines.drives.iter().map(|drive| &drive.line)).collect();
    for (position, line) in all.iter().enumerate() {
        if let Some(other) = all[..position].iter().find(|other| other.offset == line.offset) {
            return Err(ChardevError::Wiring(format!(
                "{} and {} are the same line, offset {}",
                other.title, line.title, line.offset
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
pub(in crate::pins) mod tests;
