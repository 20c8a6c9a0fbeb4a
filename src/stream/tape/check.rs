//! Whether a tape can be: resistors, channels and times that a circuit may have.

use super::{Header, PROTO_MAJOR, TapeCircuit};
use crate::record::{LONGEST_LATENCY, MAX_CHANNELS, Record};
use crate::sensor::{Channel, SCALES};
use crate::stream::limits::{LARGEST, LONGEST_NS};

impl Header {
    /// The first thing that is wrong with it.
    pub(super) fn check(&self) -> Result<(), String> {
        let found = self.proto_major;
        if found != PROTO_MAJOR {
            return Err(format!(
                "this is a tape of version {found}; this release reads version {PROTO_MAJOR}"
            ));
        }
        let TapeCircuit { r_c1_ohm, r_c2_ohm, .. } = self.circuit;
        if !(is_of_a_part(r_c1_ohm) && is_of_a_part(r_c2_ohm)) {
            return Err(format!(
                "r_c1_ohm and r_c2_ohm must be resistances above 0, and are {r_c1_ohm:e} and {r_c2_ohm:e}"
            ));
        }
        let [r1, r2] = self.r_ohm();
        if r1 >= r2 {
            return Err(format!("r_c1_ohm = {r1} is not below r_c2_ohm = {r2}; are they swapped?"));
        }
        let is_period = |ns: f64| ns > 0.0 && ns <= LONGEST_LATENCY.as_ns();
        if self.resolution_ns.is_some_and(|ns| !is_period(ns)) {
            return Err("resolution_ns is the period of a clock: above 0 and up to 1 ms".to_owned());
        }
        if self.channels.is_empty() || self.channels.len() > MAX_CHANNELS {
            return Err(format!("a tape has 1 to {MAX_CHANNELS} channels"));
        }
        if self.offset.offset_ns.is_some_and(|d_ns| d_ns.abs() >= LONGEST_LATENCY.as_ns()) {
            return Err("offset_ns is a latency: it must be below 1 ms".to_owned());
        }
        for (index, channel) in self.channels.iter().enumerate() {
            if self.channels[..index].iter().any(|other| other.id == channel.id) {
                return Err(format!("two channels have the id {:?}", channel.id));
            }
            check_channel(channel).map_err(|reason| format!("channel {:?}: {reason}", channel.id))?;
        }
        Ok(())
    }
}

fn check_channel(channel: &Channel) -> Result<(), String> {
    if let Some(zero_ohm) = channel.zero_ohm.filter(|zero_ohm| zero_ohm.abs() > LARGEST) {
        return Err(format!("zero_ohm = {zero_ohm:e} is no resistance of wires and pins"));
    }
    if let Some(scale) = channel.scale.filter(|scale| !SCALES.contains(scale)) {
        return Err(format!("scale = {scale:e} is no part of a resistance that is near 1"));
    }
    channel.defect().map_or(Ok(()), |(defect, _)| Err(defect))
}

/// Whether a resistance is that of a part.
fn is_of_a_part(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}

/// Whether times are positive, not absurd, and in order.
pub(super) fn times(record: &Record) -> Result<(), String> {
    let times = [
        ("a_ns", record.a_ns),
        ("b_ns", record.b_ns),
        ("switch.at_ns", record.switch.map(|switch| switch.at_ns)),
        ("switch.on_ns", record.switch.map(|switch| switch.on_ns)),
        ("waited_ns", record.waited_ns),
    ];
    for (name, time) in times.into_iter().filter_map(|(name, time)| Some((name, time?))) {
        if time <= 0.0 {
            return Err(format!("{name} is {time}; a time since the start is above 0"));
        }
        if time > LONGEST_NS {
            return Err(format!("{name} is {time:e}; times are in nanoseconds"));
        }
    }
    let lengths =
        [("second_ns", record.second_ns), ("switch.u_ns", record.u_switch_ns), ("later_ns", record.later_ns)];
    for (name, time) in lengths {
        if let Some(time) = time.filter(|time| !(0.0..=LONGEST_NS).contains(time)) {
            return Err(format!("{name} is {time}; it is 0 or a short time"));
        }
    }
    if record.switch.is_some_and(|switch| switch.on_ns < switch.at_ns) {
        return Err(
            "switch.on_ns is before switch.at_ns: the first resistor is released before the next is sunk"
                .to_owned(),
        );
    }
    Ok(())
}
