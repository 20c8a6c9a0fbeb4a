//! `cermctl calibrate zero` and `reference`: what the instrument reads with a known resistor in the sensor's place.
//!
//! A reading that cannot be told from a short circuit has no number, and a zero may be negative. So what is averaged are
//! estimates from the timings of the discharges, which keep their sign, by the method of the daemon.

use super::{CtlError, Target, Value, silent, wait_for};
use crate::config::LARGEST_ZERO_OHM;
use crate::ctl::cli::Zero;
use crate::ctl::replay;
use crate::ctl::stream::Stream;
use crate::estimate::fit;
use crate::reading::Method;
use crate::record::Through;
use crate::stream::tape::{Entry, Header};
use crate::stream::wire::ServerMessage;
use crate::units::measured;
use serde::Serialize;

/// The result for a machine.
#[derive(Serialize)]
#[serde(tag = "class", rename = "ZERO")]
struct ZeroLine<'a> {
    channel: &'a str,
    zero_ohm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    zero_u_ohm: Option<f64>,
    reference_ohm: f64,
    discharges: usize,
}

/// Measures with `reference_ohm` in the sensor's place.
pub fn run(arguments: &Zero, reference_ohm: f64) -> Result<(), CtlError> {
    let target = Target::new(&arguments.update)?;
    let part = if reference_ohm > 0.0 { "reference resistor" } else { "short circuit" };
    let numbers = take(&target, arguments, part)?;
    let Some(mean) = fit::mean(&numbers) else { return Err(silent("number")) };
    let zero_ohm = mean.value - reference_ohm;
    if zero_ohm.is_nan() || zero_ohm.abs() > LARGEST_ZERO_OHM {
        return Err(CtlError::Said(format!(
            "a zero of {zero_ohm:.1} ohm is more than pins and a series resistor make up; is the {part} in the sensor's place?"
        )));
    }
    let text = measured(zero_ohm, mean.u, "ohm", false);
    target.say(&format!("{}: zero {text}, from {} discharges", target.id, numbers.len()))?;
    let result = ZeroLine {
        channel: &target.id,
        zero_ohm,
        zero_u_ohm: mean.u,
        reference_ohm,
        discharges: numbers.len(),
    };
    target.offer(&Value::ZeroOhm(zero_ohm), result)
}

/// Signed estimates of as many discharges as were asked for; those that gave none are left out.
fn take(target: &Target, arguments: &Zero, part: &str) -> Result<Vec<f64>, CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, std::slice::from_ref(&target.id))?;
    let method = method(&mut stream)?;
    if method.is_tracked() || target.config.is_tracked() {
        return Err(CtlError::said(
            "a tracked calibration takes too few discharges of Rc1 and Rc2 to tell a zero from; for the zero, set method = \
             \"cerm\" and calibration = \"each-reading\" in [measure] and reload cermd; it holds for every method",
        ));
    }
    stream.watch(None, true)?;
    let mut tape = Tape::default();
    while tape.of_sensor < arguments.count {
        wait_for(&mut stream, "discharge", |message| tape.take(message))?;
    }
    let Some(header) = tape.header else { return Err(silent("discharge")) };
    let estimates = replay::signed_ohm(&header, &tape.entries, method, &target.id)
        .map_err(|why| CtlError::Said(format!("{}: {why}", arguments.connection.socket.display())))?;
    let discharges = estimates.len();
    let fault = estimates.iter().rev().find_map(|estimate| estimate.err());
    let numbers: Vec<f64> = estimates.into_iter().flatten().collect();
    if 2 * numbers.len() < discharges || numbers.len() < 2 {
        let fault = fault.map(|fault| format!(" (the last fault: {fault})")).unwrap_or_default();
        let count = numbers.len();
        return Err(CtlError::Said(format!(
            "only {count} of {discharges} discharges gave a number{fault}; is the {part} in the sensor's place?"
        )));
    }
    Ok(numbers)
}

/// The method of the daemon.
fn method(stream: &mut Stream) -> Result<Method, CtlError> {
    let (_, stats) = stream.stats()?;
    let known = Method::ALL.into_iter().find(|method| method.as_str() == stats.instrument.method);
    known.ok_or_else(|| silent("method that this release knows"))
}

/// A header, both calibration discharges, and then discharges of the sensor among others.
#[derive(Default)]
struct Tape {
    header: Option<Header>,
    entries: Vec<Entry>,
    is_calibrated: [bool; 2],
    of_sensor: u64,
}

impl Tape {
    /// Takes a line; `None` if it is of no use.
    fn take(&mut self, message: ServerMessage) -> Option<()> {
        let entry = match message {
            // A later one tells an offset that was found meanwhile: what is before it does not count.
            ServerMessage::Tape(header) => {
                *self = Tape { header: Some(*header), ..Tape::default() };
                return Some(());
            }
            ServerMessage::Discharge(line) => self.header.as_ref()?.entry(&line).ok()?,
            _ => return None,
        };
        let Entry { record, .. } = entry;
        if record.through.channel().is_some() {
            if self.is_calibrated != [true; 2] {
                return None;
            }
            self.of_sensor += 1;
        } else if record.switch.is_none() {
            self.is_calibrated[usize::from(record.through != Through::C1)] = true;
        }
        self.entries.push(entry);
        Some(())
    }
}
