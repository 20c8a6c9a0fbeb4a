//! Tapes: the timings of discharges as lines of JSON, for recording and for estimating again later.
//!
//! For: reading and writing [`Record`]s with everything that is needed to estimate from them. Must not know: how they
//! were taken, or the equations.
//!
//! The first line is a `TAPE`, every other one a `DISCHARGE`; times are in ns since the start of that discharge:
//!
//! ```json
//! {"class":"TAPE","proto_major":1,"circuit":{"kind":"two-capacitor","r_c1_ohm":2320,"r_c2_ohm":12700},"offset_ns":8000,"channels":[{"id":"thumb"}]}
//! {"class":"DISCHARGE","seq":3,"channel":"thumb","through":"x","switch":{"at_ns":74700,"on_ns":74950,"to":"c2"},"a_ns":911000,"b_ns":1742000}
//! ```

use crate::circuit::Kind;
use crate::estimate::force::Force;
use crate::estimate::offset;
use crate::instrument::settings::{Channel, OffsetSource, Settings};
use crate::record::{Record, Switch, Through};
use crate::units::{Nanos, Newton, NewtonOhm};
use serde::{Deserialize, Serialize};

/// The protocol that this release writes; a tape of another major version is refused.
pub const PROTO_MAJOR: u32 = 1;
/// The longest line that is read, bytes.
const LONGEST_LINE: usize = 65_536;
/// No discharge takes longer, ns (one hour): a greater number is a mistake of units.
const LONGEST_NS: f64 = 3.6e12;
/// No resistance and no force is greater, nor smaller than its reciprocal, ohm, newton.
const LARGEST: f64 = 1e12;

/// The first line of a tape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    class: HeaderClass,
    /// Major version of the format.
    pub proto_major: u32,
    /// The resistors and how they are wired.
    pub circuit: TapeCircuit,
    /// The latency offset d of the crossings, ns; absent: not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_ns: Option<f64>,
    /// The sensors.
    pub channels: Vec<TapeChannel>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum HeaderClass {
    #[serde(rename = "TAPE")]
    Tape,
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

/// A sensor of a tape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TapeChannel {
    /// Its name.
    pub id: String,
    /// What a short circuit in its place reads, ohm.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub zero_ohm: f64,
    /// Its characteristic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<TapeForce>,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The shape of a [`Force`] on a tape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "force is one of {\"fc1_n\", \"fc2_n\"}, {\"alpha_n_ohm\"}"
)]
pub enum TapeForce {
    /// The forces that belong to Rc1 and Rc2, newton.
    Pair {
        /// F_c1.
        fc1_n: f64,
        /// F_c2.
        fc2_n: f64,
    },
    /// Eq. (1).
    Alpha {
        /// N ohm.
        alpha_n_ohm: f64,
    },
}

#[derive(Serialize, Deserialize)]
struct Line {
    class: LineClass,
    seq: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    channel: Option<String>,
    through: Resistor,
    /// The second of two resistors was sunk by then; absent: at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    second_ns: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    switch: Option<SwitchLine>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    a_ns: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    b_ns: Option<f64>,
}

// As a field and not as serde's tag, which is written but not looked at when a struct is read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum LineClass {
    #[serde(rename = "DISCHARGE")]
    Discharge,
}

#[derive(Serialize, Deserialize)]
struct SwitchLine {
    at_ns: f64,
    on_ns: f64,
    to: Resistor,
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Resistor {
    #[serde(rename = "c1")]
    C1,
    #[serde(rename = "c2")]
    C2,
    #[serde(rename = "c12")]
    C12,
    #[serde(rename = "x")]
    X,
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
}

/// One discharge of a tape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// The number that it has on the tape.
    pub seq: u64,
    /// Its timings.
    pub record: Record,
}

impl Header {
    /// Of what an instrument with these settings records. `found_ns`: the latency offset where it had to be found, and has
    /// been.
    pub fn new(settings: &Settings, found_ns: Option<f64>) -> Header {
        let [r_c1_ohm, r_c2_ohm] = settings.r_c_ohm;
        let channel = |channel: &Channel| TapeChannel {
            id: channel.id.clone(),
            zero_ohm: channel.zero_ohm,
            force: channel.force.as_ref().and_then(TapeForce::of),
        };
        Header {
            class: HeaderClass::Tape,
            proto_major: PROTO_MAJOR,
            circuit: TapeCircuit { kind: settings.kind, r_c1_ohm, r_c2_ohm },
            offset_ns: match settings.offset {
                OffsetSource::Given(d_ns) => Some(d_ns),
                OffsetSource::Auto => found_ns,
            },
            channels: settings.channels.iter().map(channel).collect(),
        }
    }

    /// As a line, without its end.
    pub fn to_line(&self) -> String {
        // Strings and finite numbers always serialise.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// R_1 and R_2 of the [ratio](crate::estimate::method), ohm.
    pub fn r_ohm(&self) -> [f64; 2] {
        let TapeCircuit { kind, r_c1_ohm, r_c2_ohm } = self.circuit;
        kind.known([r_c1_ohm, r_c2_ohm])
    }

    /// Reads the first line of a tape.
    ///
    /// # Errors
    /// [`TapeError`] of line 1.
    pub fn parse(text: &str) -> Result<Header, TapeError> {
        let at = |reason: String| TapeError { line: 1, reason };
        let header: Header = serde_json::from_str(text)
            .map_err(|error| at(format!("not the header of a tape: {}", explain(&error))))?;
        if header.proto_major != PROTO_MAJOR {
            let found = header.proto_major;
            return Err(at(format!(
                "this is a tape of version {found}; this release reads version {PROTO_MAJOR}"
            )));
        }
        let [r1, r2] = header.r_ohm();
        let TapeCircuit { r_c1_ohm, r_c2_ohm, .. } = header.circuit;
        if !(is_sound(r_c1_ohm) && is_sound(r_c2_ohm)) {
            return Err(at(format!(
                "r_c1_ohm and r_c2_ohm must be resistances above 0, and are {r_c1_ohm:e} and {r_c2_ohm:e}"
            )));
        }
        if r1 >= r2 {
            return Err(at(format!("r_c1_ohm = {r1} is not below r_c2_ohm = {r2}; are they swapped?")));
        }
        if header.channels.is_empty() || header.channels.len() > crate::pins::MAX_CHANNELS {
            return Err(at(format!("a tape has 1 to {} channels", crate::pins::MAX_CHANNELS)));
        }
        if header.offset_ns.is_some_and(|d_ns| d_ns.abs() >= offset::LONGEST.as_ns()) {
            return Err(at("offset_ns is a latency: it must be below 1 ms".to_owned()));
        }
        for (index, channel) in header.channels.iter().enumerate() {
            if header.channels[..index].iter().any(|other| other.id == channel.id) {
                return Err(at(format!("two channels have the id {:?}", channel.id)));
            }
            channel.check().map_err(|reason| at(format!("channel {:?}: {reason}", channel.id)))?;
        }
        Ok(header)
    }

    /// A record as a line, without its end; NaN and infinity cannot be written and leave the field out.
    pub fn discharge_line(&self, seq: u64, record: &Record) -> String {
        let finite = |time: Option<f64>| time.filter(|time| time.is_finite());
        let line = Line {
            class: LineClass::Discharge,
            seq,
            channel: record
                .through
                .channel()
                .and_then(|index| self.channels.get(index))
                .map(|c| c.id.clone()),
            through: record.through.into(),
            second_ns: record.second_ns.filter(|second_ns| *second_ns > 0.0),
            switch: record.switch.map(|s| SwitchLine { at_ns: s.at_ns, on_ns: s.on_ns, to: s.to.into() }),
            a_ns: finite(record.a_ns),
            b_ns: finite(record.b_ns),
        };
        serde_json::to_string(&line).unwrap_or_default()
    }

    /// Reads a `DISCHARGE`; `number` counts the lines of the tape from 1.
    ///
    /// # Errors
    /// [`TapeError`] of that line.
    pub fn parse_discharge(&self, number: usize, text: &str) -> Result<Entry, TapeError> {
        let at = |reason: String| TapeError { line: number, reason };
        if text.len() > LONGEST_LINE {
            return Err(at(format!("{} bytes long; a line has {LONGEST_LINE} at most", text.len())));
        }
        let line: Line = serde_json::from_str(text).map_err(|error| at(explain(&error)))?;
        let channel = match &line.channel {
            None => None,
            Some(id) => match self.channels.iter().position(|channel| channel.id == *id) {
                None => return Err(at(format!("channel {id:?} is not in the header"))),
                found => found,
            },
        };
        let through = |resistor| self.through(resistor, channel).map_err(at);
        let switch = match &line.switch {
            None => None,
            Some(s) => Some(Switch { at_ns: s.at_ns, on_ns: s.on_ns, to: through(s.to)? }),
        };
        let record = Record {
            through: through(line.through)?,
            start: Nanos::ZERO,
            second_ns: line.second_ns,
            switch,
            a_ns: line.a_ns,
            b_ns: line.b_ns,
            u_switch_ns: None,
            waited_ns: None,
        };
        check_times(&record).map_err(at)?;
        Ok(Entry { seq: line.seq, record })
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

impl TapeForce {
    /// A tape gives the ohms; forces by a table or a power law are for the configuration to tell.
    fn of(force: &Force) -> Option<TapeForce> {
        match force {
            Force::Calibrated { fc1, fc2 } => Some(TapeForce::Pair { fc1_n: fc1.0, fc2_n: fc2.0 }),
            Force::Alpha(alpha) => Some(TapeForce::Alpha { alpha_n_ohm: alpha.0 }),
            Force::PowerLaw { .. } | Force::Table(_) => None,
        }
    }
}

impl From<&TapeForce> for Force {
    fn from(force: &TapeForce) -> Force {
        match *force {
            TapeForce::Pair { fc1_n, fc2_n } => Force::Calibrated { fc1: Newton(fc1_n), fc2: Newton(fc2_n) },
            TapeForce::Alpha { alpha_n_ohm } => Force::Alpha(NewtonOhm(alpha_n_ohm)),
        }
    }
}

impl TapeChannel {
    fn check(&self) -> Result<(), String> {
        if self.zero_ohm.abs() > LARGEST {
            return Err(format!("zero_ohm = {:e} is no resistance of wires and pins", self.zero_ohm));
        }
        match &self.force {
            Some(TapeForce::Pair { fc1_n, fc2_n })
                if !(is_sound(*fc1_n) && is_sound(*fc2_n) && fc1_n > fc2_n) =>
            {
                Err(format!(
                    "fc1_n = {fc1_n:e} must exceed fc2_n = {fc2_n:e}, and both be above 0: more force, less resistance"
                ))
            }
            Some(TapeForce::Alpha { alpha_n_ohm }) if !is_sound(*alpha_n_ohm) => {
                Err(format!("alpha_n_ohm = {alpha_n_ohm:e} must be above 0, such as 13346"))
            }
            _ => Ok(()),
        }
    }
}

/// Whether a force or a resistance is that of a part.
fn is_sound(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
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

/// Times are positive, not absurd, and in order.
fn check_times(record: &Record) -> Result<(), String> {
    let times = [
        ("a_ns", record.a_ns),
        ("b_ns", record.b_ns),
        ("switch.at_ns", record.switch.map(|switch| switch.at_ns)),
        ("switch.on_ns", record.switch.map(|switch| switch.on_ns)),
    ];
    for (name, time) in times {
        match time {
            Some(time) if time <= 0.0 => {
                return Err(format!("{name} is {time}; a time since the start is above 0"));
            }
            Some(time) if time > LONGEST_NS => {
                return Err(format!("{name} is {time:e}; times are in nanoseconds"));
            }
            _ => {}
        }
    }
    if let Some(second_ns) = record.second_ns.filter(|second_ns| !(0.0..=LONGEST_NS).contains(second_ns)) {
        return Err(format!("second_ns is {second_ns}; it is 0 or a short time"));
    }
    if record.switch.is_some_and(|switch| switch.on_ns < switch.at_ns) {
        return Err(
            "switch.on_ns is before switch.at_ns: the first resistor is released before the next is sunk"
                .to_owned(),
        );
    }
    Ok(())
}

/// Without serde_json's own "at line 1 column ..", which counts from the start of one line.
fn explain(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let what = text.split(" at line ").next().unwrap_or_default();
    format!("{what}, in column {}", error.column())
}

#[cfg(test)]
mod tests;
