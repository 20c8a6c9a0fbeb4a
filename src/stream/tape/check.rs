//! Whether a tape can be: resistors, channels and times that a circuit may have.

use super::{Header, PROTO_MAJOR, TapeCircuit, TapeOffset};
use crate::circuit::RESISTORS;
use crate::record::{LONGEST_LATENCY, MAX_CHANNELS, RESOLUTIONS, Record};
use crate::sensor::{ABSURD_ZERO_OHM, Channel, SCALES};
use crate::stream::limits::{LARGEST_BY_SWITCH, LONGEST_NS};
use crate::units::Ohm;

impl Header {
    /// The first thing that is wrong with it. What a configuration may say has the limits that it has there: a number that no
    /// configuration has makes estimates that are no numbers, and nobody would be told why.
    pub(super) fn check(&self) -> Result<(), String> {
        let found = self.proto_major;
        if found != PROTO_MAJOR {
            return Err(format!(
                "this is a tape of version {found}; this release reads version {PROTO_MAJOR}"
            ));
        }
        self.circuit.check()?;
        let [r1, r2] = self.r_ohm();
        if r1 >= r2 {
            return Err(format!("r_c1_ohm = {r1} is not below r_c2_ohm = {r2}; are they swapped?"));
        }
        let periods = RESOLUTIONS.start().as_ns()..=RESOLUTIONS.end().as_ns();
        if let Some(ns) = self.resolution_ns.filter(|ns| !periods.contains(ns)) {
            return Err(format!(
                "resolution_ns = {ns:e} is no period of a clock: write 1 to 1e6 (1 ms), or leave it away for that of Linux"
            ));
        }
        if self.channels.is_empty() || self.channels.len() > MAX_CHANNELS {
            return Err(format!("a tape has 1 to {MAX_CHANNELS} channels"));
        }
        self.offset.check()?;
        self.looks.check()?;
        for (index, channel) in self.channels.iter().enumerate() {
            if self.channels[..index].iter().any(|other| other.id == channel.id) {
                return Err(format!("two channels have the id {:?}", channel.id));
            }
            check_channel(channel).map_err(|reason| format!("channel {:?}: {reason}", channel.id))?;
        }
        Ok(())
    }
}

impl TapeCircuit {
    fn check(&self) -> Result<(), String> {
        for (name, r_ohm) in [("r_c1_ohm", self.r_c1_ohm), ("r_c2_ohm", self.r_c2_ohm)] {
            if !RESISTORS.contains(&Ohm(r_ohm)) {
                let [least, greatest] = [RESISTORS.start(), RESISTORS.end()];
                return Err(format!(
                    "{name} = {r_ohm:e} is no resistor: write what was measured, in ohm, between {least} and {greatest}"
                ));
            }
        }
        Ok(())
    }
}

impl TapeOffset {
    fn check(&self) -> Result<(), String> {
        if self.offset_ns.is_some_and(|d_ns| d_ns.abs() >= LONGEST_LATENCY.as_ns()) {
            return Err("offset_ns is a latency: it must be below 1 ms".to_owned());
        }
        let (latency, r_ohm) = (LONGEST_LATENCY.as_ns(), ABSURD_ZERO_OHM);
        let by = LARGEST_BY_SWITCH;
        for (name, value, [least, greatest]) in [
            ("offset_u_ns", self.offset_u_ns, [0.0, latency]),
            ("offset_by_switch", self.offset_by_switch, [-by, by]),
            ("switch_u_ns", self.switch_u_ns, [0.0, latency]),
            ("r_o_ohm", self.r_o_ohm, [-r_ohm, r_ohm]),
            ("r_o_u_ohm", self.r_o_u_ohm, [0.0, r_ohm]),
        ] {
            if let Some(value) = value.filter(|value| !(least..=greatest).contains(value)) {
                return Err(beyond(name, value, [least, greatest]));
            }
        }
        Ok(())
    }
}

/// What is said of a number that is none that anybody has found.
pub(super) fn beyond(name: &str, value: f64, [least, greatest]: [f64; 2]) -> String {
    format!(
        "{name} = {value:e} is not between {least:e} and {greatest:e}: leave it away, it is not known then"
    )
}

fn check_channel(channel: &Channel) -> Result<(), String> {
    if let Some(zero_ohm) = channel.zero_ohm.filter(|zero_ohm| zero_ohm.abs() > ABSURD_ZERO_OHM) {
        return Err(format!(
            "zero_ohm = {zero_ohm:e} is more than pins and a series resistor make up: write what a short circuit in the sensor's \
             place reads, in ohm, or leave it away, it is not known then"
        ));
    }
    if let Some(scale) = channel.scale.filter(|scale| !SCALES.contains(scale)) {
        return Err(format!(
            "scale = {scale:e} is not between {} and {}: write what `cermctl calibrate reference` finds, near 1, or leave it away",
            SCALES.start(),
            SCALES.end()
        ));
    }
    channel.defect().map_or(Ok(()), |(defect, _)| Err(defect))
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
