//! `cermctl calibrate zero` and `reference`: what the instrument reads with a known resistor in the sensor's place.
//!
//! A reading that cannot be told from a short circuit has no number, and a zero may be negative. So what is averaged are
//! estimates from the timings of the discharges, which keep their sign, by the method of the daemon.

use super::{CtlError, Target, Value, silent, wait_for};
use crate::config::LARGEST_ZERO_OHM;
use crate::ctl::cli::Zero;
use crate::ctl::progress::Progress;
use crate::ctl::replay::Replay;
use crate::ctl::stream::Stream;
use crate::estimate::fit;
use crate::reading::{Fault, Measured, Method};
use crate::sensor::SCALES;
use crate::stream::wire::ServerMessage;
use crate::units::{measured, sample};
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

/// The same of a scale.
#[derive(Serialize)]
#[serde(tag = "class", rename = "SCALE")]
struct ScaleLine<'a> {
    channel: &'a str,
    scale: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale_u: Option<f64>,
    reference_ohm: f64,
    discharges: usize,
}

/// Measures with `reference_ohm` in the sensor's place.
pub fn run(arguments: &Zero, reference_ohm: f64) -> Result<(), CtlError> {
    let target = Target::new(&arguments.update)?;
    let part = if reference_ohm > 0.0 { "reference resistor" } else { "short circuit" };
    let numbers = take(&target, arguments, part)?;
    let Some(mean) = mean_of(&numbers) else { return Err(silent("number")) };
    if reference_ohm >= target.config.circuit.r_c1.0 {
        return scale(&target, mean, reference_ohm, numbers.len());
    }
    let zero_ohm = mean.value - reference_ohm;
    if zero_ohm.is_nan() || zero_ohm.abs() > LARGEST_ZERO_OHM {
        return Err(CtlError::Said(format!(
            "a zero of {zero_ohm:.1} ohm is more than pins and a series resistor make up; is the {part} in the sensor's place?"
        )));
    }
    let text = measured(zero_ohm, mean.u, "ohm", false);
    target.say(&format!("{}: zero {text}, from {} discharges", target.id, numbers.len()))?;
    target.say("with it, what pins differ by is out of low resistances; a reference of about r-c2 takes out the rest")?;
    let result = ZeroLine {
        channel: &target.id,
        zero_ohm,
        zero_u_ohm: mean.u,
        reference_ohm,
        discharges: numbers.len(),
    };
    target.offer(&Value::ZeroOhm(zero_ohm), result)
}

/// What is left of it beside the zero, as a part of the reference.
fn scale(target: &Target, mean: Measured, reference_ohm: f64, discharges: usize) -> Result<(), CtlError> {
    let channel = target.config.channels.iter().find(|channel| channel.id == target.id);
    let Some(zero_ohm) = channel.and_then(|channel| channel.zero_ohm) else {
        return Err(CtlError::said(
            "a resistor of kilohms tells what pins differ by only beside the zero; first `cermctl calibrate zero`",
        ));
    };
    let (scale, u) = ((mean.value - zero_ohm) / reference_ohm, mean.u.map(|u| u / reference_ohm));
    if !SCALES.contains(&scale) {
        return Err(CtlError::Said(format!(
            "{:.1} ohm were read; is the reference resistor in the sensor's place, and are r-c1 and r-c2 as measured?",
            mean.value
        )));
    }
    let u_text = u.map(|u| format!(" +- {u:.5}")).unwrap_or_default();
    target.say(&format!("{}: scale {scale:.5}{u_text}, from {discharges} discharges", target.id))?;
    target.say("with it, what pins differ by is out of the uncertainty")?;
    let result = ScaleLine { channel: &target.id, scale, scale_u: u, reference_ohm, discharges };
    target.offer(&Value::Scale(scale), result)
}

/// Signed estimates of as many discharges as were asked for; those that gave none are left out.
fn take(target: &Target, arguments: &Zero, part: &str) -> Result<Vec<Measured>, CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, std::slice::from_ref(&target.id))?;
    let method = method(&mut stream)?;
    stream.watch(None, true)?;
    let (mut replay, mut estimates) = (None, Vec::new());
    let mut progress = Progress::new();
    while (estimates.len() as u64) < arguments.count {
        let is_of_tape =
            |message: &_| matches!(message, ServerMessage::Tape(_) | ServerMessage::Discharge(_));
        match wait_for(&mut stream, "discharge", |message| is_of_tape(&message).then_some(message))? {
            // A later one tells an offset that was found meanwhile: what is before it does not count.
            ServerMessage::Tape(header) => {
                target.check_circuit(&header)?;
                // A tracked calibration has too few discharges to be found again from here: what the daemon read counts.
                let is_followed = method.is_tracked() || header.tracked;
                let again = || Replay::new(&header, method, None).map_err(CtlError::said);
                replay = if is_followed { None } else { Some(again()?) };
                estimates.clear();
            }
            ServerMessage::Discharge(line) => {
                let Some(replay) = &mut replay else {
                    // An open sensor never gives a number: not to be waited for without end.
                    let is_of_sensor = line.channel.is_some();
                    let as_read = line.as_read_ohm.map(|value| Measured { value, u: line.shared_u_ohm });
                    estimates.extend(is_of_sensor.then(|| as_read.ok_or(None)));
                    continue;
                };
                let entry = replay.header().entry(&line).map_err(CtlError::said)?;
                estimates.extend(replay.signed_ohm(&entry).map(|estimate| estimate.map_err(Some)));
            }
            _ => {}
        }
        progress.show(|| so_far(&estimates, arguments.count));
    }
    drop(progress);
    let discharges = estimates.len();
    let fault =
        estimates.iter().rev().find_map(|estimate: &Result<_, Option<Fault>>| estimate.err().flatten());
    let numbers: Vec<Measured> = estimates.into_iter().flatten().collect();
    if 2 * numbers.len() < discharges || numbers.len() < 2 {
        let fault = fault.map(|fault| format!(" (the last fault: {fault})")).unwrap_or_default();
        let count = numbers.len();
        return Err(CtlError::Said(format!(
            "only {count} of {discharges} discharges gave a number{fault}; is the {part} in the sensor's place?"
        )));
    }
    Ok(numbers)
}

/// Among them those that gave no number.
fn so_far<E>(estimates: &[Result<Measured, E>], count: u64) -> String {
    let numbers: Vec<Measured> = estimates.iter().flatten().copied().collect();
    let mean = mean_of(&numbers).map_or_else(String::new, |mean| {
        let mean = measured(mean.value, mean.u, "ohm", false);
        format!(": {mean}")
    });
    format!("{} of {count} discharges{mean}", estimates.len())
}

/// Their mean: known as well as they scatter, and as well as what all of them share.
fn mean_of(numbers: &[Measured]) -> Option<Measured> {
    let values: Vec<f64> = numbers.iter().map(|number| number.value).collect();
    let shared = sample::rms(numbers.iter().filter_map(|number| number.u)).unwrap_or(0.0);
    fit::mean(&values).map(|mean| Measured { u: mean.u.map(|u| u.hypot(shared)), ..mean })
}

/// The method of the daemon.
fn method(stream: &mut Stream) -> Result<Method, CtlError> {
    let (_, stats) = stream.stats()?;
    let known = Method::ALL.into_iter().find(|method| method.as_str() == stats.instrument.method);
    known.ok_or_else(|| silent("method that this release knows"))
}
