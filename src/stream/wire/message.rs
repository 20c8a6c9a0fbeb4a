//! What the server says: written by the server, read by clients.
//!
//! For: VERSION, READING, STATS, ERROR and the lines of a tape. Must not know: to whom it is said.

use super::{ChannelInfo, Object, PROTO_MAJOR, PROTO_MINOR, UnixTime};
use crate::reading::{Measured, Reading, Status};
use serde::Deserialize;
use serde_json::{Map, Value};

/// Significant digits of a value: more than any reading has of its own.
const VALUE_DIGITS: usize = 7;
/// Significant digits of an uncertainty (GUM: two are enough, one more against rounding).
const UNCERTAINTY_DIGITS: usize = 3;

/// Appends a VERSION line.
pub fn write_version(out: &mut Vec<u8>, channels: &[ChannelInfo]) {
    let mut object = Object::line(out, "VERSION");
    object.integer("proto_major", PROTO_MAJOR);
    object.integer("proto_minor", PROTO_MINOR);
    object.text("release", env!("CARGO_PKG_VERSION"));
    object.list("channels", channels, |item, channel| {
        item.text("id", &channel.id);
        item.text("unit", channel.unit.as_str());
    });
    object.end();
}

/// Appends a READING line up to its last field, which differs from client to client; see [`end_reading`].
///
/// `time` is `reading.at` on the wall clock.
pub(crate) fn begin_reading(out: &mut Vec<u8>, reading: &Reading, channel: &str, time: UnixTime) {
    let mut object = Object::line(out, "READING");
    object.text("channel", channel);
    object.integer("seq", reading.seq);
    object.text("time", &time.to_string());
    object.integer("t_mono_ns", reading.at.0);
    object.text("status", reading.status.as_str());
    let duration_us = (reading.duration.0 + 500) / 1000;
    match reading.status {
        Status::Ok { branch, r_ohm, f_n } => {
            write_measured(&mut object, ["r_ohm", "r_u_ohm"], r_ohm);
            if let Some(f_n) = f_n {
                write_measured(&mut object, ["f_n", "f_u_n"], f_n);
            }
            object.text("method", reading.method.as_str());
            object.text("branch", branch.as_str());
            object.integer("duration_us", duration_us);
        }
        Status::Open { r_min_ohm, f_max_n } => {
            object.number("r_min_ohm", r_min_ohm, VALUE_DIGITS);
            object.number("f_max_n", f_max_n, VALUE_DIGITS);
            object.integer("duration_us", duration_us);
        }
        Status::Short { r_max_ohm, f_min_n } => {
            object.number("r_max_ohm", r_max_ohm, VALUE_DIGITS);
            object.number("f_min_n", f_min_n, VALUE_DIGITS);
            object.integer("duration_us", duration_us);
        }
        Status::Fault(fault) => {
            object.text("fault", fault.as_str());
            if let Some(suspect) = reading.suspect {
                object.text("hint", &suspect.to_string());
            }
        }
    }
}

fn write_measured(object: &mut Object<'_>, [value, uncertainty]: [&str; 2], measured: Measured) {
    object.number(value, measured.value, VALUE_DIGITS);
    object.number(uncertainty, measured.u, UNCERTAINTY_DIGITS);
}

/// Appends the end of a READING line: how many readings its client has missed since the last one it got.
pub(crate) fn end_reading(out: &mut Vec<u8>, lost: u64) {
    out.extend_from_slice(b",\"lost\":");
    out.extend_from_slice(lost.to_string().as_bytes());
    out.extend_from_slice(b"}\n");
}

/// Appends a whole READING line with nothing lost, as a recording or a single answer needs it.
pub fn write_reading(out: &mut Vec<u8>, reading: &Reading, channel: &str, time: UnixTime) {
    begin_reading(out, reading, channel, time);
    end_reading(out, 0);
}

/// A line of the server, read.
#[derive(Debug, Clone, PartialEq)]
pub enum ServerMessage {
    /// The first line of a connection, and again after the channels have changed.
    Version(VersionLine),
    /// A reading.
    Reading(Box<ReadingLine>),
    /// Figures of the daemon, field by field.
    Stats(Map<String, Value>),
    /// A refusal, or a warning.
    Error {
        /// For programs; see [`ErrorCode`](super::ErrorCode).
        code: String,
        /// For people.
        message: String,
    },
    /// Any other class: a line of a tape, or of a later minor protocol.
    Other {
        /// Its class.
        class: String,
    },
}

/// VERSION.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
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

/// The state of a reading, without its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StatusName {
    /// `r_ohm` is there.
    Ok,
    /// `r_min_ohm` is there.
    Open,
    /// `r_max_ohm` is there.
    Short,
    /// `fault` is there.
    Fault,
}

/// READING. Absent means unknown.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ReadingLine {
    /// The id of the channel.
    pub channel: String,
    /// Counts the readings of the instrument.
    pub seq: u64,
    /// The middle of the x discharge, RFC 3339, UTC.
    pub time: String,
    /// The same on `CLOCK_MONOTONIC`, ns.
    pub t_mono_ns: i64,
    /// Which of the numbers are there.
    pub status: StatusName,
    /// Ohm.
    pub r_ohm: Option<f64>,
    /// 1 sigma, ohm.
    pub r_u_ohm: Option<f64>,
    /// Newton.
    pub f_n: Option<f64>,
    /// 1 sigma, newton.
    pub f_u_n: Option<f64>,
    /// Open: lower bound, ohm.
    pub r_min_ohm: Option<f64>,
    /// Open: upper bound, newton.
    pub f_max_n: Option<f64>,
    /// Short: upper bound, ohm.
    pub r_max_ohm: Option<f64>,
    /// Short: lower bound, newton.
    pub f_min_n: Option<f64>,
    /// Why there is no number; a text, because later releases know more faults.
    pub fault: Option<String>,
    /// What on the board a fault looks like, and what to look at, for people.
    pub hint: Option<String>,
    /// How it was estimated.
    pub method: Option<String>,
    /// "direct" or "inferred", eq. (19).
    pub branch: Option<String>,
    /// How long the cycle took, us.
    pub duration_us: Option<u64>,
    /// Readings that this client has missed since the last one it got.
    pub lost: u64,
}

/// A line that is not of this protocol.
#[derive(Debug, thiserror::Error)]
#[error("the server sent what is not a line of this protocol ({0}); is it a cermd of this major version?")]
pub struct UnreadableLine(String);

impl UnreadableLine {
    pub(crate) fn new(why: impl Into<String>) -> UnreadableLine {
        UnreadableLine(why.into())
    }
}

impl ServerMessage {
    /// Reads a line of the server.
    ///
    /// # Errors
    /// It is not a JSON object with a class, or a field has another type than this protocol says.
    pub fn parse(line: &[u8]) -> Result<ServerMessage, UnreadableLine> {
        let unreadable = |error: serde_json::Error| UnreadableLine::new(error.to_string());
        let Value::Object(mut fields) = serde_json::from_slice(line).map_err(unreadable)? else {
            return Err(UnreadableLine::new("not an object"));
        };
        let Some(Value::String(class)) = fields.remove("class") else {
            return Err(UnreadableLine::new("no class"));
        };
        Ok(match class.as_str() {
            "VERSION" => {
                ServerMessage::Version(VersionLine::deserialize(Value::Object(fields)).map_err(unreadable)?)
            }
            "READING" => {
                let reading = ReadingLine::deserialize(Value::Object(fields)).map_err(unreadable)?;
                ServerMessage::Reading(Box::new(reading))
            }
            "STATS" => ServerMessage::Stats(fields),
            "ERROR" => {
                let mut text = |key: &str| match fields.remove(key) {
                    Some(Value::String(text)) => Ok(text),
                    _ => Err(UnreadableLine::new(format!("ERROR without {key}"))),
                };
                ServerMessage::Error { code: text("code")?, message: text("message")? }
            }
            _ => ServerMessage::Other { class },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::Suspect;
    use crate::reading::{Branch, Fault, Method};
    use crate::stream::wire::Unit;
    use crate::units::Nanos;

    const TIME: UnixTime = UnixTime(1_795_232_400_123_456_789);

    fn reading(status: Status) -> Reading {
        Reading {
            channel: 0,
            seq: 1041,
            at: Nanos(81_234_567_890),
            status,
            suspect: None,
            method: Method::Cerm,
            duration: Nanos(18_230_400),
        }
    }

    fn written(status: Status) -> String {
        let mut out = Vec::new();
        write_reading(&mut out, &reading(status), "thumb", TIME);
        String::from_utf8(out).unwrap()
    }

    fn ok() -> Status {
        let r_ohm = Measured { value: 2841.3, u: Some(1.2) };
        let f_n = Some(Measured { value: 4.697, u: Some(0.002) });
        Status::Ok { branch: Branch::Direct, r_ohm, f_n }
    }

    #[test]
    fn the_lines_of_the_protocol_byte_by_byte() {
        assert_eq!(
            written(ok()),
            "{\"class\":\"READING\",\"channel\":\"thumb\",\"seq\":1041,\"time\":\"2026-11-21T03:40:00.123456789Z\",\
             \"t_mono_ns\":81234567890,\"status\":\"ok\",\"r_ohm\":2841.3,\"r_u_ohm\":1.2,\"f_n\":4.697,\
             \"f_u_n\":0.002,\"method\":\"cerm\",\"branch\":\"direct\",\"duration_us\":18230,\"lost\":0}\n"
        );
        let head = "{\"class\":\"READING\",\"channel\":\"thumb\",\"seq\":1041,\
                    \"time\":\"2026-11-21T03:40:00.123456789Z\",\"t_mono_ns\":81234567890,\"status\":";
        assert_eq!(
            written(Status::Open { r_min_ohm: 1.9e6, f_max_n: Some(0.007) }),
            format!(
                "{head}\"open\",\"r_min_ohm\":1900000,\"f_max_n\":0.007,\"duration_us\":18230,\"lost\":0}}\n"
            )
        );
        assert_eq!(
            written(Status::Short { r_max_ohm: 4.5, f_min_n: None }),
            format!("{head}\"short\",\"r_max_ohm\":4.5,\"duration_us\":18230,\"lost\":0}}\n")
        );
        assert_eq!(
            written(Status::Fault(Fault::MissedEdge)),
            format!("{head}\"fault\",\"fault\":\"missed-edge\",\"lost\":0}}\n")
        );
        let suspected =
            Reading { suspect: Some(Suspect::SecondOpen), ..reading(Status::Fault(Fault::NoCalibration)) };
        let mut out = Vec::new();
        write_reading(&mut out, &suspected, "thumb", TIME);
        assert_eq!(
            String::from_utf8(out).unwrap(),
            format!(
                "{head}\"fault\",\"fault\":\"no-calibration\",\"hint\":\"nothing falls in a discharge through Rc2; look at \
                 the wire from sink-c2 through Rc2 to node A (series calibration: to Rc1)\",\"lost\":0}}\n"
            )
        );
    }

    #[test]
    fn version_byte_by_byte() {
        let mut out = Vec::new();
        write_version(&mut out, &[ChannelInfo { id: "thumb".into(), unit: Unit::Newton }]);
        assert_eq!(
            String::from_utf8(out).unwrap(),
            format!(
                "{{\"class\":\"VERSION\",\"proto_major\":1,\"proto_minor\":0,\"release\":\"{}\",\
                 \"channels\":[{{\"id\":\"thumb\",\"unit\":\"N\"}}]}}\n",
                env!("CARGO_PKG_VERSION")
            )
        );
    }

    #[test]
    fn readings_are_read_back() {
        let ServerMessage::Reading(line) = ServerMessage::parse(written(ok()).as_bytes()).unwrap() else {
            panic!("not a reading");
        };
        assert_eq!((line.status, line.seq, line.lost), (StatusName::Ok, 1041, 0));
        assert_eq!(
            (line.r_ohm, line.r_u_ohm, line.f_n, line.f_u_n),
            (Some(2841.3), Some(1.2), Some(4.697), Some(0.002))
        );
        assert_eq!((line.duration_us, line.r_min_ohm, line.fault), (Some(18230), None, None));
    }

    #[test]
    fn unknown_fields_and_classes_pass_wrong_types_do_not() {
        let text = written(ok());
        let with = |from: &str, to: &str| ServerMessage::parse(text.replace(from, to).as_bytes());
        assert!(with("\"lost\":0", "\"lost\":0,\"new\":{\"a\":1}").is_ok());
        assert!(with("\"lost\":0", "\"lost\":\"0\"").is_err());
        assert!(with("2841.3", "\"2841.3\"").is_err());
        assert!(with("\"status\":\"ok\"", "\"status\":\"fine\"").is_err());
        let other = ServerMessage::parse(br#"{"class":"NEW","x":1}"#).unwrap();
        assert_eq!(other, ServerMessage::Other { class: "NEW".into() });
        assert!(ServerMessage::parse(b"{}").is_err());
        assert!(ServerMessage::parse(b"[1]").is_err());
        assert!(ServerMessage::parse(b"\xff").is_err());
    }
}
