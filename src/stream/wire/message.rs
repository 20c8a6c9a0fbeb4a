//! What the server says: VERSION, READING, EVENT, STATS, ERROR and the lines of a tape.

use super::{EventLine, PROTO_MAJOR, PROTO_MINOR, StatsLine};
use crate::reading::{Bound, Measured, MeasuredValue, Method, Reading, Status};
use crate::stream::line::{Tagged, is_unknown, uncertainty, value};
use crate::stream::tape::{DischargeLine, Header};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A line of the server, read.
#[derive(Debug, Clone, PartialEq)]
pub enum ServerMessage {
    /// The first line of a connection, and again after the channels have changed.
    Version(VersionLine),
    /// A reading.
    Reading(Box<ReadingLine>),
    /// A channel has passed a threshold.
    Event(EventLine),
    /// Figures of the daemon.
    Stats(Box<StatsLine>),
    /// A refusal, or a warning.
    Error(ErrorLine),
    /// What the discharges after it belong to.
    Tape(Box<Header>),
    /// The timings of a discharge.
    Discharge(Box<DischargeLine>),
    /// Any other class, of a later minor protocol.
    Other {
        /// Its class.
        class: String,
    },
}

/// A line that is not of this protocol.
#[derive(Debug, thiserror::Error)]
#[error("the server sent what is not a line of this protocol ({0}); is it a cermd of this major version?")]
pub struct UnreadableLine(pub(crate) String);

impl ServerMessage {
    /// Reads a line of the server.
    ///
    /// # Errors
    /// It is not a JSON object with a class, or a field has another type than this protocol says.
    pub fn parse(line: &[u8]) -> Result<ServerMessage, UnreadableLine> {
        fn read<T: DeserializeOwned>(line: &[u8]) -> Result<T, UnreadableLine> {
            serde_json::from_slice(line).map_err(|error| UnreadableLine(error.to_string()))
        }
        let Tagged { class } = read(line)?;
        Ok(match class.as_str() {
            "VERSION" => ServerMessage::Version(read(line)?),
            "READING" => ServerMessage::Reading(read(line)?),
            "EVENT" => ServerMessage::Event(read(line)?),
            "STATS" => ServerMessage::Stats(read(line)?),
            "ERROR" => ServerMessage::Error(read(line)?),
            "TAPE" => ServerMessage::Tape(read(line)?),
            "DISCHARGE" => ServerMessage::Discharge(read(line)?),
            _ => ServerMessage::Other { class },
        })
    }
}

/// VERSION.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "class", rename = "VERSION")]
pub struct VersionLine {
    /// Other than [`PROTO_MAJOR`]: this stream is not for us.
    pub proto_major: u32,
    /// Above [`PROTO_MINOR`]: there may be fields and classes that we do not know.
    pub proto_minor: u32,
    /// The release of the server.
    pub release: String,
    /// What it measures.
    pub channels: Vec<ChannelInfo>,
}

/// A channel as VERSION announces it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelInfo {
    /// The name in configuration and stream.
    pub id: String,
    /// What it measures.
    pub unit: Unit,
    /// Whether it has a trigger: there will be EVENTs of it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub trigger: bool,
}

/// What the values of a channel are measured in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// The channel has a force calibration.
    #[serde(rename = "N")]
    Newton,
    /// The channel is read as a resistance.
    #[serde(rename = "ohm")]
    Ohm,
    /// The channel has a law: "degC", "lx", "mm", or as its table says.
    #[serde(untagged)]
    Other(String),
}

impl Unit {
    /// By its name.
    pub fn named(name: &str) -> Unit {
        match name {
            "N" => Unit::Newton,
            "ohm" => Unit::Ohm,
            other => Unit::Other(other.to_owned()),
        }
    }

    /// Its name.
    pub fn as_str(&self) -> &str {
        match self {
            Unit::Newton => "N",
            Unit::Ohm => "ohm",
            Unit::Other(name) => name,
        }
    }

    /// What a channel shows that has neither force nor law: the resistance itself.
    fn of_itself<T>(&self, resistance: T) -> Option<T> {
        (*self == Unit::Ohm).then_some(resistance)
    }

    /// As it is written where there are more letters than those of ASCII.
    pub fn symbol(&self) -> &str {
        match self.as_str() {
            "degC" => "\u{b0}C",
            "deg" => "\u{b0}",
            "ohm" => "\u{3a9}",
            name => name,
        }
    }
}

impl VersionLine {
    /// What this release says of these channels.
    pub fn new(channels: &[ChannelInfo]) -> VersionLine {
        VersionLine {
            proto_major: PROTO_MAJOR,
            proto_minor: PROTO_MINOR,
            release: env!("CARGO_PKG_VERSION").to_owned(),
            channels: channels.to_vec(),
        }
    }
}

/// The state of a reading, without its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StatusName {
    /// `r_ohm` is there.
    Ok,
    /// `r_min_ohm` is there.
    Open,
    /// `r_max_ohm` is there.
    Short,
    /// `fault` is there.
    #[default]
    Fault,
}

/// READING. Absent means unknown.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(tag = "class", rename = "READING")]
pub struct ReadingLine {
    /// The id of the channel.
    pub channel: String,
    /// Counts the readings of the instrument.
    pub seq: u64,
    /// The middle of the x discharge, RFC 3339, UTC.
    pub time: String,
    /// The same on `CLOCK_MONOTONIC`, ns.
    pub t_mono_ns: i64,
    /// What it says.
    #[serde(flatten)]
    pub state: StateLine,
    /// What on the board a fault looks like, and what to look at, for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// How long the cycle took, us.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_us: Option<u64>,
    /// Readings that this client has missed since the last one it got.
    pub lost: u64,
}

/// What is known of a sensor, in READING and ESTIMATE. Absent means unknown.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StateLine {
    /// Which of the numbers are there.
    pub status: StatusName,
    /// Ohm.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub r_ohm: Option<f64>,
    /// 1 sigma, ohm.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub r_u_ohm: Option<f64>,
    /// Newton.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub f_n: Option<f64>,
    /// 1 sigma of all, readout and characteristic, newton.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub f_u_n: Option<f64>,
    /// 1 sigma of the readout alone: how well readings of one sensor can be told apart, newton.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub f_repeat_u_n: Option<f64>,
    /// What the channel shows, in `unit`: a force, what its law gives, or the resistance itself where it has neither.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub value: Option<f64>,
    /// 1 sigma of all, readout and force or law, in `unit`.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub value_u: Option<f64>,
    /// 1 sigma of the readout alone, in `unit`; not of a resistance.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub value_repeat_u: Option<f64>,
    /// Of the values beside it: that of the channel in VERSION.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The force is outside those that the sensor was calibrated with, or the value is outside of where its law holds.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub extrapolated: bool,
    /// The sensor changed while it was read; `r_u_ohm` and what follows from it contain that.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub moving: bool,
    /// `r_u_ohm` and what follows from it are still a prior, and wide.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub settling: bool,
    /// Open: lower bound, ohm.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub r_min_ohm: Option<f64>,
    /// Open: upper bound, newton.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub f_max_n: Option<f64>,
    /// Short: upper bound, ohm.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub r_max_ohm: Option<f64>,
    /// Short: lower bound, newton.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub f_min_n: Option<f64>,
    /// Open or short: lower bound, in `unit`.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub value_min: Option<f64>,
    /// Open or short: upper bound, in `unit`.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub value_max: Option<f64>,
    /// Why there is no number; a text, because later releases know more faults.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// How it was estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// "direct" or "inferred", eq. (19).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub branch: Option<String>,
}

impl ReadingLine {
    /// With nothing lost. `channel`: its id; `time`: `reading.at` on the wall clock, RFC 3339.
    pub fn new(reading: &Reading, channel: &str, unit: &Unit, time: String) -> ReadingLine {
        let is_fault = matches!(reading.status, Status::Fault(_));
        ReadingLine {
            channel: channel.to_owned(),
            seq: reading.seq,
            time,
            t_mono_ns: reading.at.0,
            state: StateLine::new(&reading.status, reading.method, unit),
            hint: reading.suspect.filter(|_| is_fault).map(|suspect| suspect.to_string()),
            duration_us: (!is_fault).then(|| (reading.duration.0.max(0).unsigned_abs() + 500) / 1000),
            lost: 0,
        }
    }
}

impl StateLine {
    /// By this method, of a channel that measures in this unit.
    pub fn new(status: &Status, method: Method, unit: &Unit) -> StateLine {
        let mut line = StateLine::default();
        match *status {
            Status::Ok { branch, r_ohm, shown, is_moving, is_settling } => {
                line.status = StatusName::Ok;
                (line.r_ohm, line.r_u_ohm) = (Some(r_ohm.value), r_ohm.u);
                let Measured { value, u } = r_ohm;
                let itself = MeasuredValue { value, u, repeat_u: None, is_extrapolated: false };
                line.set_value(shown.or(unit.of_itself(itself)), unit);
                (line.moving, line.settling) = (is_moving, is_settling);
                line.method = Some(method.to_string());
                line.branch = Some(branch.to_string());
            }
            Status::Open { r_min_ohm, shown } => {
                line.status = StatusName::Open;
                line.r_min_ohm = Some(r_min_ohm);
                line.set_bound(shown.or(unit.of_itself(Bound::AtLeast(r_min_ohm))), unit);
            }
            Status::Short { r_max_ohm, shown } => {
                line.status = StatusName::Short;
                line.r_max_ohm = Some(r_max_ohm);
                line.set_bound(shown.or(unit.of_itself(Bound::AtMost(r_max_ohm))), unit);
            }
            Status::Fault(fault) => line.fault = Some(fault.to_string()),
        }
        line
    }

    fn set_value(&mut self, shown: Option<MeasuredValue>, unit: &Unit) {
        let Some(MeasuredValue { value, u, repeat_u, is_extrapolated }) = shown else { return };
        self.extrapolated = is_extrapolated;
        (self.value, self.value_u, self.value_repeat_u) = (Some(value), u, repeat_u);
        self.unit = Some(unit.as_str().to_owned());
        if *unit == Unit::Newton {
            (self.f_n, self.f_u_n, self.f_repeat_u_n) = (Some(value), u, repeat_u);
        }
    }

    fn set_bound(&mut self, bound: Option<Bound>, unit: &Unit) {
        match bound {
            None => return,
            Some(Bound::AtLeast(value)) => self.value_min = Some(value),
            Some(Bound::AtMost(value)) => self.value_max = Some(value),
        }
        self.unit = Some(unit.as_str().to_owned());
        if *unit == Unit::Newton {
            (self.f_min_n, self.f_max_n) = (self.value_min, self.value_max);
        }
    }
}

/// ERROR: what was wrong with a request, or what was lost, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "class", rename = "ERROR")]
pub struct ErrorLine {
    /// For programs.
    pub code: ErrorCode,
    /// For people.
    pub message: String,
    /// With [`ErrorCode::Lost`]: how many discharges are missing here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost: Option<u64>,
}

/// What an ERROR is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorCode {
    /// Not a JSON object with a class, or not the fields of that class.
    BadRequest,
    /// No request has this class.
    UnknownClass,
    /// No channel has this id.
    UnknownChannel,
    /// More than [`MAX_LINE_BYTES`](super::MAX_LINE_BYTES).
    LineTooLong,
    /// POLL, but a channel has no reading yet.
    NoReading,
    /// Discharges of a raw stream were lost, because the client reads too slowly.
    Lost,
    /// Too many clients.
    Busy,
    /// A code of a later minor protocol.
    #[serde(other)]
    Other,
}

impl ErrorLine {
    /// From its parts.
    pub fn new(code: ErrorCode, message: impl Into<String>) -> ErrorLine {
        ErrorLine { code, message: message.into(), lost: None }
    }

    /// Discharges are missing here.
    pub fn lost(count: u64) -> ErrorLine {
        let message = format!("{count} lines of the tape were lost here: read faster");
        ErrorLine { lost: Some(count), ..ErrorLine::new(ErrorCode::Lost, message) }
    }
}

#[cfg(test)]
mod tests;
