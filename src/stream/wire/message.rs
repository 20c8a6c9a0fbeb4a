//! What the server says: VERSION, READING, STATS, ERROR and the lines of a tape.

use super::number::{is_unknown, seconds, uncertainty, value};
use super::{PROTO_MAJOR, PROTO_MINOR};
use crate::reading::{Measured, Reading, Status};
use crate::stream::tape::{DischargeLine, Header};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A line of the server, read.
#[derive(Debug, Clone, PartialEq)]
pub enum ServerMessage {
    /// The first line of a connection, and again after the channels have changed.
    Version(VersionLine),
    /// A reading.
    Reading(Box<ReadingLine>),
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
        #[derive(Deserialize)]
        struct Class {
            class: String,
        }
        fn read<T: DeserializeOwned>(line: &[u8]) -> Result<T, UnreadableLine> {
            serde_json::from_slice(line).map_err(|error| UnreadableLine::new(error.to_string()))
        }
        let Class { class } = read(line)?;
        Ok(match class.as_str() {
            "VERSION" => ServerMessage::Version(read(line)?),
            "READING" => ServerMessage::Reading(read(line)?),
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
}

/// What the values of a channel are measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// The channel has a force calibration.
    #[serde(rename = "N")]
    Newton,
    /// The channel is read as a resistance.
    #[serde(rename = "ohm")]
    Ohm,
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// 1 sigma, newton.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub f_u_n: Option<f64>,
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
    /// Why there is no number; a text, because later releases know more faults.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// What on the board a fault looks like, and what to look at, for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// How it was estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// "direct" or "inferred", eq. (19).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub branch: Option<String>,
    /// How long the cycle took, us.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_us: Option<u64>,
    /// Readings that this client has missed since the last one it got.
    pub lost: u64,
}

impl ReadingLine {
    /// With nothing lost. `channel`: its id; `time`: `reading.at` on the wall clock, RFC 3339.
    pub fn new(reading: &Reading, channel: &str, time: String) -> ReadingLine {
        let mut line = ReadingLine {
            channel: channel.to_owned(),
            seq: reading.seq,
            time,
            t_mono_ns: reading.at.0,
            status: StatusName::Fault,
            r_ohm: None,
            r_u_ohm: None,
            f_n: None,
            f_u_n: None,
            r_min_ohm: None,
            f_max_n: None,
            r_max_ohm: None,
            f_min_n: None,
            fault: None,
            hint: None,
            method: None,
            branch: None,
            duration_us: Some((reading.duration.0.max(0).unsigned_abs() + 500) / 1000),
            lost: 0,
        };
        let parts = |measured: Option<Measured>| (measured.map(|m| m.value), measured.and_then(|m| m.u));
        match reading.status {
            Status::Ok { branch, r_ohm, f_n } => {
                line.status = StatusName::Ok;
                (line.r_ohm, line.r_u_ohm) = parts(Some(r_ohm));
                (line.f_n, line.f_u_n) = parts(f_n);
                line.method = Some(reading.method.as_str().to_owned());
                line.branch = Some(branch.as_str().to_owned());
            }
            Status::Open { r_min_ohm, f_max_n } => {
                line.status = StatusName::Open;
                (line.r_min_ohm, line.f_max_n) = (Some(r_min_ohm), f_max_n);
            }
            Status::Short { r_max_ohm, f_min_n } => {
                line.status = StatusName::Short;
                (line.r_max_ohm, line.f_min_n) = (Some(r_max_ohm), f_min_n);
            }
            Status::Fault(fault) => {
                line.fault = Some(fault.as_str().to_owned());
                line.hint = reading.suspect.map(|suspect| suspect.as_str().to_owned());
                line.duration_us = None;
            }
        }
        line
    }
}

/// STATS: figures of the server and of the instrument behind it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "class", rename = "STATS")]
pub struct StatsLine {
    /// How many are connected.
    pub clients: u64,
    /// Readings that were published.
    pub published: u64,
    /// Lines that clients have lost, summed over the clients.
    pub lost: u64,
    /// What the daemon tells.
    #[serde(flatten)]
    pub instrument: InstrumentStats,
}

/// What the daemon tells of its instrument in STATS.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct InstrumentStats {
    /// The backend of `[gpio]`.
    pub backend: String,
    /// How readings are estimated.
    pub method: String,
    /// Whether the GPIO lines can be used at present.
    pub gpio_works: bool,
    /// Since the daemon was started, s.
    #[serde(serialize_with = "seconds")]
    pub uptime_s: f64,
    /// Cycles of the instrument.
    pub cycles: u64,
    /// Readings of every status.
    pub readings: u64,
    /// Readings with a number.
    pub ok: u64,
    /// Readings above what the deadline resolves.
    pub open: u64,
    /// Readings that cannot be told from a short circuit.
    pub short: u64,
    /// Readings without a number, by the name of the fault.
    pub faults: BTreeMap<String, u64>,
    /// What on the board the faults look like, for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// The resistance of a leak beside the sensors, ohm.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub leak_ohm: Option<f64>,
    /// Discharges that were tried again.
    pub retried: u64,
    /// Whether the latency offset has been found or was given.
    pub offset_known: bool,
    /// The latency offset d, ns.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub offset_ns: Option<f64>,
    /// 1 sigma, ns.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub offset_u_ns: Option<f64>,
    /// The resistance of a driven pin, ohm.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub r_o_ohm: Option<f64>,
    /// 1 sigma, ohm.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub r_o_u_ohm: Option<f64>,
    /// How long before a planned switch the thread stops sleeping, ns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spin_margin_ns: Option<u64>,
    /// How many things the backend cannot see.
    pub blind_spots: u64,
    /// Each wish of `[realtime]`, and what became of it, for people.
    pub realtime: BTreeMap<String, String>,
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
    /// Only for root and the daemon's own user.
    Forbidden,
    /// Not possible in this version.
    Unsupported,
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
mod tests {
    use super::*;
    use crate::reading::{Branch, Fault, Method, Suspect};
    use crate::stream::wire::to_line;
    use crate::units::Nanos;

    const TIME: &str = "2026-11-21T03:40:00.123456789Z";

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

    fn line(message: &impl Serialize) -> String {
        String::from_utf8(to_line(message)).unwrap()
    }

    fn written(status: Status) -> String {
        line(&ReadingLine::new(&reading(status), "thumb", TIME.to_owned()))
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
        assert_eq!(
            line(&ReadingLine::new(&suspected, "thumb", TIME.to_owned())),
            format!(
                "{head}\"fault\",\"fault\":\"no-calibration\",\"hint\":\"nothing falls in a discharge through Rc2; look at \
                 the wire from sink-c2 through Rc2 to node A (series calibration: to Rc1)\",\"lost\":0}}\n"
            )
        );
    }

    #[test]
    fn version_byte_by_byte() {
        assert_eq!(
            line(&VersionLine::new(&[ChannelInfo { id: "thumb".into(), unit: Unit::Newton }])),
            format!(
                "{{\"class\":\"VERSION\",\"proto_major\":1,\"proto_minor\":0,\"release\":\"{}\",\
                 \"channels\":[{{\"id\":\"thumb\",\"unit\":\"N\"}}]}}\n",
                env!("CARGO_PKG_VERSION")
            )
        );
    }

    #[test]
    fn a_loss_is_a_number_and_a_later_code_is_no_mistake() {
        let lost = ErrorLine::lost(17);
        assert_eq!(
            line(&lost),
            "{\"class\":\"ERROR\",\"code\":\"lost\",\"message\":\"17 lines of the tape were lost here: read faster\",\
             \"lost\":17}\n"
        );
        assert_eq!(ServerMessage::parse(line(&lost).as_bytes()).unwrap(), ServerMessage::Error(lost));
        let later = ServerMessage::parse(br#"{"class":"ERROR","code":"new","message":"of a later release"}"#);
        assert_eq!(
            later.unwrap(),
            ServerMessage::Error(ErrorLine::new(ErrorCode::Other, "of a later release"))
        );
    }

    #[test]
    fn stats_are_read_back() {
        let instrument = InstrumentStats {
            uptime_s: 12.5,
            faults: [("missed-edge".to_owned(), 2)].into(),
            offset_ns: Some(8012.3),
            ..InstrumentStats::default()
        };
        let stats = StatsLine { clients: 1, published: 7, lost: 0, instrument };
        let text = line(&stats);
        assert!(
            text.starts_with("{\"class\":\"STATS\",\"clients\":1,\"published\":7,\"lost\":0,\"backend\""),
            "{text}"
        );
        assert_eq!(ServerMessage::parse(text.as_bytes()).unwrap(), ServerMessage::Stats(Box::new(stats)));
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
