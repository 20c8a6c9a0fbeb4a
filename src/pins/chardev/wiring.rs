//! Which line of which chip plays which part, and in which order lines switch.

use super::chips::{Chip, LineListing};
use super::error::ChardevError;
use crate::pins::limits::{RELEASE_ATTEMPTS, RELEASE_PAUSE, SUGGESTIONS};
use crate::pins::{Drives, MAX_CHANNELS};
use serde::{Deserialize, Serialize};
use std::thread;

/// How a circuit is wired to the lines of one chip. A line is given by name ("GPIO17") or by offset ("17").
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
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
    /// The part it plays when it drives; none: it senses.
    pub part: Drives,
    /// Its number on the chip.
    pub offset: u32,
    /// What errors call it: `sink-c1 (GPIO20)`.
    pub title: String,
}

impl WiredLine {
    /// Whether it pulls up (open source); otherwise it sinks (open drain).
    pub fn charges(&self) -> bool {
        Drives::CHARGE.contains(self.part)
    }
}

/// The titles of some lines, for errors of a call that was made for all of them.
pub(super) fn titles<'a>(lines: impl IntoIterator<Item = &'a WiredLine>) -> String {
    lines.into_iter().map(|line| line.title.as_str()).collect::<Vec<_>>().join(", ")
}

/// The lines of a circuit, found on their chip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::pins) struct Lines {
    /// Node A, then node B if the circuit has it.
    pub sense: Vec<WiredLine>,
    /// In the order in which they switch: that of [`Drives::lines`].
    pub drives: Vec<WiredLine>,
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

    /// Tries `release` on every line, and is [`patient`] with those that are busy. Keeps the first failure; that another program
    /// than `consumer` holds a line is one only if there is no other.
    pub fn release_each(
        &self,
        consumer: &str,
        mut release: impl FnMut(&WiredLine) -> Result<(), ChardevError>,
    ) -> Result<(), ChardevError> {
        let mut attempts_left = RELEASE_ATTEMPTS;
        let lines = self.drives.iter().chain(&self.sense);
        let failures: Vec<_> =
            lines.filter_map(|line| patient(&mut attempts_left, || release(line)).err()).collect();
        let first = failures.into_iter().min_by_key(|failure| failure.is_held_by_others_than(consumer));
        first.map_or(Ok(()), Err)
    }
}

/// Tries again and again while a line is busy: the kernel closes the files of a killed process with a delay.
pub(in crate::pins) fn patient<T>(
    attempts_left: &mut u32,
    mut attempt: impl FnMut() -> Result<T, ChardevError>,
) -> Result<T, ChardevError> {
    let mut outcome = attempt();
    while *attempts_left > 0 && outcome.as_ref().is_err_and(ChardevError::is_busy) {
        *attempts_left -= 1;
        thread::sleep(RELEASE_PAUSE);
        outcome = attempt();
    }
    outcome
}

impl Wiring {
    /// Whether the sense lines have to charge as well, as in the published circuit.
    pub fn sense_charges(&self) -> bool {
        self.charge_a.is_none() && self.charge_b.is_none()
    }

    /// Finds every line on the chip.
    ///
    /// # Errors
    /// [`ChardevError::Wiring`] for what cannot be, and for names the chip does not have.
    pub(in crate::pins) fn resolve(&self, chip: &Chip) -> Result<Lines, ChardevError> {
        if self.sinks_x.len() > MAX_CHANNELS {
            let count = self.sinks_x.len();
            return Err(ChardevError::Wiring(format!(
                "{count} channels: at most {MAX_CHANNELS} share a circuit"
            )));
        }
        let lines = self.lines(|wanted| line_offset(&chip.listing.lines, wanted, &chip.title()))?;
        distinct(&lines)?;
        Ok(lines)
    }

    /// The lines by their keys in a configuration, their offsets as `find` tells by names or offsets.
    fn lines<E>(&self, find: impl Fn(&str) -> Result<u32, E>) -> Result<Lines, E> {
        let sensors = self.sinks_x.iter().enumerate();
        let sensors = sensors.map(|(i, name)| (Drives::x(i), format!("sink-x{i}"), Some(name)));
        let others = [
            (Drives::C1, "sink-c1", Some(&self.sink_c1)),
            (Drives::C2, "sink-c2", Some(&self.sink_c2)),
            (Drives::CHARGE_A, "charge-a", self.charge_a.as_ref()),
            (Drives::CHARGE_B, "charge-b", self.charge_b.as_ref()),
            (Drives::NONE, "sense-a", Some(&self.sense_a)),
            (Drives::NONE, "sense-b", self.sense_b.as_ref()),
        ];
        let others = others.map(|(part, key, name)| (part, key.to_owned(), name));
        let wired = sensors.chain(others).filter_map(|(part, key, wanted)| {
            let title = format!("{key} ({})", wanted?);
            Some(find(wanted?).map(|offset| WiredLine { part, offset, title }))
        });
        let wired = wired.collect::<Result<Vec<_>, _>>()?;
        let (sense, drives) = wired.into_iter().partition(|line| line.part.is_none());
        Ok(Lines { sense, drives, sense_charges: self.sense_charges() })
    }
}

fn distinct(lines: &Lines) -> Result<(), ChardevError> {
    let mut seen: Vec<&WiredLine> = Vec::new();
    for line in lines.sense.iter().chain(&lines.drives) {
        if let Some(other) = seen.iter().find(|other| other.offset == line.offset) {
            return Err(ChardevError::Wiring(format!(
                "{} and {} are the same line, offset {}",
                other.title, line.title, line.offset
            )));
        }
        seen.push(line);
    }
    Ok(())
}

/// The offset of a line given by name or number on the chip called `chip`.
///
/// # Errors
/// [`ChardevError::Wiring`] with what could be asked for instead.
pub(in crate::pins) fn line_offset(
    lines: &[LineListing],
    wanted: &str,
    chip: &str,
) -> Result<u32, ChardevError> {
    let named: Vec<u32> =
        lines.iter().filter(|line| line.name.as_deref() == Some(wanted)).map(|line| line.offset).collect();
    let instead = match (named.as_slice(), wanted.parse::<u32>()) {
        ([offset], _) => return Ok(*offset),
        ([], Ok(offset)) if (offset as usize) < lines.len() => return Ok(offset),
        ([], Ok(_)) => format!("its offsets go from 0 to {}", lines.len().saturating_sub(1)),
        ([], Err(_)) => similar_names(lines, wanted),
        (_, _) => format!("several lines have this name: give the offset, one of {named:?}"),
    };
    Err(ChardevError::Wiring(format!("chip {chip} has no line \"{wanted}\"; {instead}")))
}

/// The nearest by edit distance, letters of either case alike.
fn similar_names(lines: &[LineListing], wanted: &str) -> String {
    let mut names: Vec<String> = lines.iter().filter_map(|line| line.name.clone()).collect();
    if names.is_empty() {
        let last = lines.len().saturating_sub(1);
        return format!("its lines have no names: give an offset from 0 to {last}");
    }
    let wanted = wanted.to_lowercase();
    names.sort_by_key(|name| strsim::levenshtein(&name.to_lowercase(), &wanted));
    names.truncate(SUGGESTIONS);
    format!("did you mean {}?", names.join(", "))
}

#[cfg(test)]
pub(in crate::pins) mod tests;
