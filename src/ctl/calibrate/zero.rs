//! `cermctl calibrate zero` and `reference`: what the instrument reads with a known resistor in the sensor's place.
//!
//! For: a zero with its uncertainty. Must not know: how it gets into the configuration.
//!
//! A reading that cannot be told from a short circuit has no number, and a zero may be negative. So what is averaged are
//! estimates from the timings of the discharges, which keep their sign, by the method of the daemon.

use super::{CalibrateError, CtlError, Target, Value};
use crate::config::LARGEST_ZERO_OHM;
use crate::ctl::cli::Zero;
use crate::ctl::replay;
use crate::ctl::stream::{Next, Stream};
use crate::ctl::text::measured;
use crate::estimate::fit;
use crate::reading::{Fault, Method};
use crate::stream::wire::ServerMessage;
use std::time::{Duration, Instant};

/// How long to wait for the next discharge or reading.
const PATIENCE: Duration = Duration::from_secs(10);

/// Measures with `reference_ohm` in the sensor's place.
pub fn run(arguments: &Zero, reference_ohm: f64) -> Result<(), CtlError> {
    let target = Target::new(&arguments.update)?;
    let part = if reference_ohm > 0.0 { "reference resistor" } else { "short circuit" };
    let numbers = take(&target, arguments, part)?;
    let Some(mean) = fit::mean(&numbers) else { return Err(CalibrateError::Silent("number").into()) };
    let zero_ohm = mean.value - reference_ohm;
    if zero_ohm.is_nan() || zero_ohm.abs() > LARGEST_ZERO_OHM {
        return Err(CalibrateError::NoZero { zero_ohm, part }.into());
    }
    let text = measured(zero_ohm, mean.u, "ohm", false);
    target.say(&format!("{}: zero {text}, from {} discharges", target.id, numbers.len()))?;
    let result = serde_json::json!({
        "class": "ZERO", "channel": target.id, "zero_ohm": zero_ohm, "zero_u_ohm": mean.u,
        "reference_ohm": reference_ohm, "discharges": numbers.len(),
    });
    target.offer(&Value::ZeroOhm(zero_ohm), result)
}

/// Signed estimates of as many discharges as were asked for; those that gave none are left out.
fn take(target: &Target, arguments: &Zero, part: &'static str) -> Result<Vec<f64>, CtlError> {
    let channels = [target.id.clone()];
    let mut stream = Stream::connect(&arguments.connection.socket, &channels)?;
    let method = method(&mut stream)?;
    if method.is_tracked() || target.config.is_tracked() {
        return Err(CalibrateError::Tracked.into());
    }
    stream.watch(&channels, None, true)?;
    let tape = tape(&mut stream, arguments.count)?;
    let estimates = replay::signed_ohm(&tape, method, &target.id)
        .map_err(|source| CtlError::Tape { path: arguments.connection.socket.clone(), source })?;
    let discharges = estimates.len();
    let fault = estimates.iter().rev().find_map(|estimate| estimate.err()).map(Fault::as_str);
    let numbers: Vec<f64> = estimates.into_iter().flatten().collect();
    if 2 * numbers.len() < discharges || numbers.len() < 2 {
        return Err(CalibrateError::FewNumbers { numbers: numbers.len(), discharges, fault, part }.into());
    }
    Ok(numbers)
}

/// The method of the daemon, which a reading tells.
fn method(stream: &mut Stream) -> Result<Method, CtlError> {
    until(stream, "reading", |message| match message {
        ServerMessage::Reading(reading) => {
            let name = reading.method.as_deref();
            Ok(Method::ALL.into_iter().find(|method| Some(method.as_str()) == name))
        }
        _ => Ok(None),
    })
}

/// A header, calibration discharges, and then so many discharges of the sensor.
fn tape(stream: &mut Stream, count: u64) -> Result<String, CtlError> {
    let (mut lines, mut header) = (String::new(), None);
    let (mut is_calibrated, mut of_sensor) = ([false; 2], 0);
    let mut since = Instant::now();
    while of_sensor < count {
        let (line, message) = next(stream, &mut since, "discharge")?;
        refuse(&message)?;
        match (message, &header) {
            // A later one tells an offset that was found meanwhile: what is before it does not count.
            (ServerMessage::Tape(found), _) => {
                header = Some(found);
                (lines, is_calibrated, of_sensor) = (String::new(), [false; 2], 0);
            }
            (ServerMessage::Discharge(discharge), Some(header)) => {
                let Ok(entry) = header.entry(&discharge) else { continue };
                match (entry.record.through.channel(), entry.record.switch) {
                    (Some(_), _) if is_calibrated != [true; 2] => continue,
                    (Some(_), _) => of_sensor += 1,
                    (None, None) => {
                        let is_first = entry.record.through == crate::record::Through::C1;
                        is_calibrated[usize::from(!is_first)] = true;
                    }
                    (None, Some(_)) => {}
                }
            }
            _ => continue,
        }
        since = Instant::now();
        lines.push_str(&String::from_utf8_lossy(&line));
        lines.push('\n');
    }
    Ok(lines)
}

/// The next line; waits for it while there has been `what` in time.
fn next(
    stream: &mut Stream,
    since: &mut Instant,
    what: &'static str,
) -> Result<(Vec<u8>, ServerMessage), CtlError> {
    loop {
        if since.elapsed() > PATIENCE {
            return Err(CalibrateError::Silent(what).into());
        }
        match stream.next()? {
            Next::Line(line, message) => return Ok((line, message)),
            Next::Quiet => {}
            Next::Ended => return Err(crate::stream::client::ClientError::Closed.into()),
        }
    }
}

fn refuse(message: &ServerMessage) -> Result<(), CtlError> {
    match message {
        ServerMessage::Error(error) => Err(CtlError::Refused(error.message.clone())),
        _ => Ok(()),
    }
}

/// Waits for the message that `found` recognises.
pub fn until<T>(
    stream: &mut Stream,
    what: &'static str,
    mut found: impl FnMut(&ServerMessage) -> Result<Option<T>, CtlError>,
) -> Result<T, CtlError> {
    let mut since = Instant::now();
    loop {
        let (_, message) = next(stream, &mut since, what)?;
        refuse(&message)?;
        if let Some(found) = found(&message)? {
            return Ok(found);
        }
    }
}
