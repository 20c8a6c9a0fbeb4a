//! Tapes: the timings of discharges as lines of JSON, for recording and for estimating again later.
//!
//! The first line is a `TAPE`, every other one a `DISCHARGE`; times are in ns since the start of that discharge:
//!
//! ```
//! use cermd::tape::Header;
//!
//! let header = r#"{"class":"TAPE","proto_major":1,"circuit":{"kind":"two-capacitor","r_c1_ohm":2320,"r_c2_ohm":12700},"offset_ns":8000,"channels":[{"id":"thumb"}]}"#;
//! let discharge = r#"{"class":"DISCHARGE","seq":3,"channel":"thumb","through":"x","switch":{"at_ns":74700,"on_ns":74950,"to":"c2"},"a_ns":911000,"b_ns":1742000}"#;
//! let header = Header::parse(header)?;
//! let entry = header.parse_discharge(2, discharge)?;
//! assert_eq!((entry.seq, entry.record.a_ns), (3, Some(911_000.0)));
//! # Ok::<(), cermd::tape::TapeError>(())
//! ```

mod check;
#[cfg(feature = "programs")]
mod found;
mod looks;
mod reader;

pub use looks::TapeLooks;
pub use reader::Reader;

pub(crate) use super::limits::PROTO_MAJOR;
use super::line::{Tagged, is_unknown, ns, uncertainty, value};
use crate::circuit::Kind;
use crate::record::{Record, Switch, Through};
use crate::sensor::Channel;
use crate::units::Nanos;
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The first line of a tape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "class", rename = "TAPE")]
pub struct Header {
    /// Major version of the format.
    pub proto_major: u32,
    /// The resistors and how they are wired.
    pub circuit: TapeCircuit,
    /// Period of the clock that stamps crossings, ns; absent: 1, as Linux counts.
    #[serde(default, skip_serializing_if = "is_unknown")]
    pub resolution_ns: Option<f64>,
    /// The latency offset.
    #[serde(flatten)]
    pub offset: TapeOffset,
    /// What looks had shown.
    #[serde(flatten)]
    pub looks: TapeLooks,
    /// The calibration was followed, not taken anew for each reading.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub tracked: bool,
    /// The sensors.
    pub channels: Vec<Channel>,
}

/// What is known of the latency offset at the beginning of a tape, and with it; what is absent is not known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct TapeOffset {
    /// The latency offset d of the crossings, ns.
    #[serde(serialize_with = "ns", skip_serializing_if = "is_unknown")]
    pub offset_ns: Option<f64>,
    /// 1 sigma, ns.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub offset_u_ns: Option<f64>,
    /// By how much d changes with an error that all switches have in common.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub offset_by_switch: Option<f64>,
    /// How much the instants of switches scatter at the most, ns.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub switch_u_ns: Option<f64>,
    /// Output resistance of a calibration pin, ohm.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub r_o_ohm: Option<f64>,
    /// 1 sigma, ohm.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub r_o_u_ohm: Option<f64>,
}

/// The circuit of a tape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TapeCircuit {
    /// Which circuit.
    pub kind: Kind,
    /// Rc1, ohm.
    pub r_c1_ohm: f64,
    /// Rc2, ohm.
    pub r_c2_ohm: f64,
}

/// The timings of one discharge as a line of a tape, ns since its start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "class", rename = "DISCHARGE")]
pub struct DischargeLine {
    /// Its number on the tape.
    pub seq: u64,
    /// When it started, `CLOCK_MONOTONIC`, ns; absent: not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t_ns: Option<i64>,
    /// The channel whose sensor takes part; absent: a calibration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// What it started through.
    pub through: Resistor,
    /// It was held back: on its way (with a switch) to look for a leak, or before it to look for absorption: no calibration.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held: bool,
    /// The second of two resistors was sunk by then; absent: at the start.
    #[serde(default, serialize_with = "ns", skip_serializing_if = "is_unknown")]
    pub second_ns: Option<f64>,
    /// Where it was switched to another resistor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub switch: Option<SwitchLine>,
    /// The crossing of node A; absent: not seen.
    #[serde(default, serialize_with = "ns", skip_serializing_if = "is_unknown")]
    pub a_ns: Option<f64>,
    /// The crossing of node B; absent: not seen.
    #[serde(default, serialize_with = "ns", skip_serializing_if = "is_unknown")]
    pub b_ns: Option<f64>,
    /// When a wait for a crossing ended in vain, the node being above its threshold still.
    #[serde(default, serialize_with = "ns", skip_serializing_if = "is_unknown")]
    pub waited_ns: Option<f64>,
    /// How much later than usual its lines may have been switched, 1 sigma; absent: its calls took no longer than usual.
    #[serde(default, serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub later_ns: Option<f64>,
    /// What its recorder read by it, with its sign, before the zero and the scale of the channel, ohm; absent: nothing, or a
    /// calibration.
    #[serde(default, serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub as_read_ohm: Option<f64>,
    /// What other readings of the time share of its error, as that of the calibration, 1 sigma, ohm; absent: not known.
    #[serde(default, serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub shared_u_ohm: Option<f64>,
}

/// From one resistor to the next, ns since the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SwitchLine {
    /// The first resistor was released.
    #[serde(serialize_with = "ns")]
    pub at_ns: f64,
    /// The next one was sunk.
    #[serde(serialize_with = "ns")]
    pub on_ns: f64,
    /// The next one.
    pub to: Resistor,
    /// 1 sigma of each of these instants as far as the recorder knows; absent: only the tape's own scatter tells.
    #[serde(default, serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub u_ns: Option<f64>,
}

/// What a discharge runs through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Resistor {
    /// Rc1.
    C1,
    /// Rc2.
    C2,
    /// Rc1 and Rc2 in series.
    C12,
    /// The sensor.
    X,
    /// The sensor, and Rc1 and Rc2 in series, at once.
    #[serde(rename = "x+c12")]
    XWithC12,
}

/// What is wrong with a tape.
#[derive(Debug, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct TapeError {
    /// Counted from 1.
    pub line: usize,
    /// What, and what to do.
    pub reason: String,
    /// The tape ends in the middle of this line.
    pub is_cut: bool,
}

/// One discharge of a tape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// The number that it has on the tape.
    pub seq: u64,
    /// Whether its start is known.
    pub is_timed: bool,
    /// Whether it was held back, to look for a leak or for absorption.
    pub is_held: bool,
    /// Its timings.
    pub record: Record,
}

impl Header {
    /// R_1 and R_2 of the ratio that the methods know R_x by, ohm.
    pub fn r_ohm(&self) -> [f64; 2] {
        let TapeCircuit { kind, r_c1_ohm, r_c2_ohm } = self.circuit;
        kind.known([r_c1_ohm, r_c2_ohm])
    }

    /// Reads the first line of a tape.
    ///
    /// # Errors
    /// [`TapeError`] of line 1.
    pub fn parse(text: &str) -> Result<Header, TapeError> {
        let at = |reason: String| TapeError { line: 1, reason, is_cut: false };
        let header: Header = read(text, "TAPE")
            .map_err(|error| at(format!("not the header of a tape: {}", explain(&error))))?;
        header.check().map_err(at)?;
        Ok(header)
    }

    /// A record as a line.
    pub fn discharge(&self, seq: u64, record: &Record, held: bool) -> DischargeLine {
        let channel = record.through.channel().and_then(|index| self.channels.get(index));
        DischargeLine {
            seq,
            t_ns: Some(record.start.0),
            channel: channel.map(|channel| channel.id.clone()),
            through: record.through.into(),
            held,
            second_ns: record.second_ns.filter(|second_ns| *second_ns > 0.0),
            switch: record.switch.map(|s| SwitchLine {
                at_ns: s.at_ns,
                on_ns: s.on_ns,
                to: s.to.into(),
                u_ns: record.u_switch_ns,
            }),
            a_ns: record.a_ns,
            b_ns: record.b_ns,
            waited_ns: record.waited_ns,
            later_ns: record.later_ns,
            as_read_ohm: None,
            shared_u_ohm: None,
        }
    }

    /// Reads a `DISCHARGE`; `number` counts the lines of the tape from 1.
    ///
    /// # Errors
    /// [`TapeError`] of that line.
    pub fn parse_discharge(&self, number: usize, text: &str) -> Result<Entry, TapeError> {
        let at = |reason: String| TapeError { line: number, reason, is_cut: false };
        let damage = |error: serde_json::Error| match error.is_data() {
            true => explain(&error),
            false => format!("damaged ({}): without this line the tape can be read", explain(&error)),
        };
        let line = read(text, "DISCHARGE").map_err(|error| at(damage(error)))?;
        self.entry(&line).map_err(at)
    }

    /// What a line says.
    ///
    /// # Errors
    /// Why it cannot be a discharge of this tape.
    pub fn entry(&self, line: &DischargeLine) -> Result<Entry, String> {
        let position = |id: &String| {
            let found = self.channels.iter().position(|channel| channel.id == *id);
            found.ok_or_else(|| format!("channel {id:?} is not in the header"))
        };
        let channel = line.channel.as_ref().map(position).transpose()?;
        let through = |resistor| self.through(resistor, channel);
        let switch =
            |s: SwitchLine| Ok::<_, String>(Switch { at_ns: s.at_ns, on_ns: s.on_ns, to: through(s.to)? });
        let record = Record {
            through: through(line.through)?,
            start: Nanos(line.t_ns.unwrap_or(0)),
            second_ns: line.second_ns,
            switch: line.switch.map(switch).transpose()?,
            a_ns: line.a_ns,
            b_ns: line.b_ns,
            u_switch_ns: line.switch.and_then(|switch| switch.u_ns),
            waited_ns: line.waited_ns,
            later_ns: line.later_ns,
        };
        check::times(&record)?;
        Ok(Entry { seq: line.seq, is_timed: line.t_ns.is_some(), is_held: line.held, record })
    }

    fn through(&self, resistor: Resistor, channel: Option<usize>) -> Result<Through, String> {
        let series = self.circuit.kind == Kind::SeriesCalibration;
        let through = match (resistor, channel) {
            (Resistor::C1, _) => Through::C1,
            (Resistor::C2, _) if !series => Through::C2,
            (Resistor::C12, _) if series => Through::C12,
            (Resistor::X, Some(channel)) => Through::X(channel),
            (Resistor::XWithC12, Some(channel)) if series => Through::XWithC12(channel),
            (Resistor::X | Resistor::XWithC12, None) => {
                return Err("a discharge of the sensor names its channel".to_owned());
            }
            (Resistor::C2, _) => return Err("this circuit has \"c12\" in the place of \"c2\"".to_owned()),
            _ => return Err("\"c12\" exists only in a circuit with series calibration".to_owned()),
        };
        Ok(through)
    }
}

impl From<Through> for Resistor {
    fn from(through: Through) -> Resistor {
        match through {
            Through::C1 => Resistor::C1,
            Through::C2 => Resistor::C2,
            Through::C12 => Resistor::C12,
            Through::X(_) => Resistor::X,
            Through::XWithC12(_) => Resistor::XWithC12,
        }
    }
}

/// Reads a line of this class.
fn read<T: DeserializeOwned>(text: &str, class: &str) -> serde_json::Result<T> {
    // Of any other line, only this is looked at: the text of a null is rare, and so is an id that has it.
    if text.contains("null") {
        if let Some(key) = null(&serde_json::from_str(text)?) {
            return Err(serde_json::Error::custom(format!(
                "{key} is null: leave it out, it is not known then"
            )));
        }
    }
    let found: Tagged = serde_json::from_str(text)?;
    if found.class != class {
        return Err(serde_json::Error::custom(format!("the class is {:?}, not {class:?}", found.class)));
    }
    serde_json::from_str(text)
}

/// The key of the first null in it. Serde takes one for a field that is absent, and a crossing that somebody has not filled in
/// would make a fault without a word.
fn null(value: &Value) -> Option<String> {
    match value {
        Value::Object(fields) => fields.iter().find_map(|(key, value)| match value {
            Value::Null => Some(key.clone()),
            _ => null(value).map(|inner| format!("{key}.{inner}")),
        }),
        Value::Array(values) => values.iter().find_map(|value| match value {
            Value::Null => Some("an item".to_owned()),
            _ => null(value),
        }),
        _ => None,
    }
}

/// Without serde_json's own "at line 1 column ..", which counts from the start of one line.
fn explain(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let what = text.split(" at line ").next().unwrap_or_default();
    if error.column() == 0 { what.to_owned() } else { format!("{what}, in column {}", error.column()) }
}

#[cfg(test)]
mod tests;
