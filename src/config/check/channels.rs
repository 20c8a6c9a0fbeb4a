//! `[[channel]]`: names that clients can tell apart, and characteristics that are physical.

use crate::config::Findings;
use crate::config::limits::{EVERY, LARGEST_ZERO_OHM, LONGEST_ID};
use crate::config::{ChannelTable, Characteristic, ForceSource, LawSource, Severity};
use crate::pins::MAX_CHANNELS;
use crate::sensor::{self, ABSURD_ZERO_OHM, Defect, SCALES, UNCALIBRATED_U, UNLIKE_PINS_OHM};
use crate::units::Ohm;

/// The name of a channel's key: by the channel's id, or by its number (from 1) where the id is unfit to print.
pub fn key(index: usize, channel: &ChannelTable, name: &str) -> String {
    if is_printable(&channel.id) {
        format!("channel.{}.{name}", channel.id)
    } else {
        format!("channel.#{}.{name}", index + 1)
    }
}

fn is_printable(id: &str) -> bool {
    !id.trim().is_empty() && !id.contains(char::is_control)
}

/// Whether there are few enough to look at each.
pub fn number(channels: &[ChannelTable], findings: &mut Findings) -> bool {
    if channels.is_empty() {
        findings.error("channel", "there is none", "[[channel]] with id = \"thumb\"");
    }
    if channels.len() > MAX_CHANNELS {
        findings.error(
            "channel",
            format!("there are {}, more than the {MAX_CHANNELS} that may share one circuit", channels.len()),
            "a second circuit with a daemon of its own",
        );
    }
    channels.len() <= MAX_CHANNELS
}

pub fn check(channels: &[ChannelTable], findings: &mut Findings) {
    for (index, channel) in channels.iter().enumerate() {
        id(index, channels, findings);
        zero(index, channel, findings);
        every(index, channel, findings);
        scale(index, channel, findings);
        if let Some(characteristic) = &channel.force {
            force(&key(index, channel, "force"), characteristic, findings);
        }
        if let Some(source) = &channel.law {
            law(&key(index, channel, "law"), source, channel.force.is_some(), findings);
        }
    }
}

fn id(index: usize, channels: &[ChannelTable], findings: &mut Findings) {
    let channel = &channels[index];
    let key = key(index, channel, "id");
    if !is_printable(&channel.id) {
        findings.error(
            key,
            format!("{:?} is empty or has control characters", channel.id),
            "a word such as \"thumb\"",
        );
    } else if channel.id.len() > LONGEST_ID {
        findings.error(key, format!("longer than {LONGEST_ID} bytes"), "a word such as \"thumb\"");
    } else if channels[..index].iter().any(|other| other.id == channel.id) {
        findings.error(key, "two channels have this id", "another id for one of them");
    }
}

fn every(index: usize, channel: &ChannelTable, findings: &mut Findings) {
    if !EVERY.contains(&channel.every) {
        let reason = format!("not between {} and {}", EVERY.start(), EVERY.end());
        findings.error(key(index, channel, "every"), reason, "10, or without it: in each cycle");
    }
}

fn zero(index: usize, channel: &ChannelTable, findings: &mut Findings) {
    let key = key(index, channel, "zero-ohm");
    let zero = Ohm(channel.zero_ohm.unwrap_or(0.0));
    let reason = format!("{zero} is more than pins and a series resistor make up");
    let remedy = "0.0, or what a short circuit in the sensor's place reads";
    if !zero.0.is_finite() {
        findings.error(key, "not a number", remedy);
    } else if zero.0.abs() > ABSURD_ZERO_OHM {
        findings.error(key, reason, remedy);
    } else if zero.0.abs() > LARGEST_ZERO_OHM {
        findings.warning(key, reason, remedy);
    }
}

/// A scale is of what a zero leaves; and what is not known.
fn scale(index: usize, channel: &ChannelTable, findings: &mut Findings) {
    let at = |name| key(index, channel, name);
    match (channel.zero_ohm, channel.scale) {
        (_, Some(scale)) if !SCALES.contains(&scale) => findings.error(
            at("scale"),
            format!("{scale} is not between {} and {}", SCALES.start(), SCALES.end()),
            "what `cermctl calibrate reference` finds, near 1",
        ),
        (None, Some(_)) => findings.error(
            at("scale"),
            "it has no zero-ohm, which a scale is found with",
            "`cermctl calibrate zero`, then `cermctl calibrate reference`",
        ),
        (None, None) => findings.add(
            Severity::Info,
            at("zero-ohm"),
            format!(
                "none: pins may differ by {UNLIKE_PINS_OHM} ohm (1 sigma), and each uncertainty contains that"
            ),
            Some("`cermctl calibrate zero`"),
        ),
        (Some(_), None) => findings.add(
            Severity::Info,
            at("scale"),
            "none: what pins may differ by is in the uncertainty, in proportion to the resistance",
            Some("`cermctl calibrate reference` with a known resistor of about r-c2"),
        ),
        (Some(_), Some(_)) => {}
    }
}

fn force(key: &str, characteristic: &Characteristic, findings: &mut Findings) {
    let Characteristic { law, u, range_n, tare_n } = characteristic;
    let fault = match law {
        ForceSource::File(file) if file.as_os_str().is_empty() => Some(no_file()),
        ForceSource::File(_) => None,
        ForceSource::Given(law) => law.defect(),
    };
    let fault = fault.or(sensor::defect_of_bounds(*u, *range_n, *tare_n));
    match fault {
        Some((reason, remedy)) => findings.error(key, reason, remedy),
        None if u.is_none() => findings.add(
            Severity::Info,
            key,
            format!(
                "it has no u: the data sheet of an FSR 402 stands in, {:.1} % (part to part 6 %, hysteresis 10 %)",
                100.0 * UNCALIBRATED_U
            ),
            Some("`cermctl calibrate force`: it stores the residual of the sensor itself"),
        ),
        None => {}
    }
}

fn no_file() -> Defect {
    ("table names no file".to_owned(), "a CSV file beside the configuration")
}

/// A channel follows one law; and what is not known of it.
fn law(key: &str, source: &LawSource, has_force: bool, findings: &mut Findings) {
    if has_force {
        return findings.error(
            key,
            "the channel has a force, too",
            "the one of the two that the sensor follows",
        );
    }
    let (defect, has_u) = match source {
        LawSource::File { table, .. } if table.as_os_str().is_empty() => (Some(no_file()), false),
        LawSource::File { unit, u, .. } => (sensor::table::defect_of(unit, *u), u.is_some()),
        LawSource::Given(law) => (law.defect(), law.has_u()),
    };
    match defect {
        Some((reason, remedy)) => findings.error(key, reason, remedy),
        None if !has_u => findings.add(
            Severity::Info,
            key,
            "it does not say how far the sensor may be off it: values have no value_u, only value_repeat_u of the readout",
            Some("u, 1 sigma: 58 % of the tolerance in its data sheet (pt1000: class)"),
        ),
        None => {}
    }
}
