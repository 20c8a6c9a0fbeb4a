//! `cermctl zero`: what lies on a sensor now counts as no force from then on.

use super::{CtlError, Target, Value, force};
use crate::ctl::cli::Tare;
use crate::sensor::Force;
use crate::units::{ForceUnit, rough};
use serde::Serialize;

/// The result for a machine.
#[derive(Serialize)]
#[serde(tag = "class", rename = "TARE")]
struct TareLine<'a> {
    channel: &'a str,
    /// Absent: it is taken away.
    #[serde(skip_serializing_if = "Option::is_none")]
    tare_n: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    r_ohm: Option<f64>,
}

/// Measures the load, and offers it as the tare.
pub fn run(arguments: &Tare) -> Result<(), CtlError> {
    let target = Target::new(&arguments.update)?;
    let Some(force) = characteristic(&target)? else {
        return Err(CtlError::Said(format!(
            "{} gives no force that something could be taken off; first `cermctl calibrate force`, or for what its \
             resistance begins at, `cermctl calibrate zero`",
            target.id
        )));
    };
    if arguments.clear {
        let line = TareLine { channel: &target.id, tare_n: None, r_ohm: None };
        return target.offer(&Value::Tare(None), line);
    }
    let r_ohm = force::measure(&target, &arguments.connection, arguments.count)?.map_err(|reason| {
        CtlError::Said(format!("{reason}; a tare is a load that can be read (--clear takes one away)"))
    })?;
    let known = [target.config.circuit.r_c1.0, target.config.circuit.r_c2.0];
    let gross = Force { tare_n: None, ..force }.at_bound(r_ohm, known);
    let Some(tare_n) = gross else {
        return Err(CtlError::Said(format!("{} is outside the force table", rough(r_ohm, "ohm"))));
    };
    let unit = arguments.shown.unit;
    let shown = rough(tare_n / unit.newton(), ForceUnit::as_str(unit));
    target.say(&format!(
        "{}: {shown} of load, from {} readings, will count as none",
        target.id, arguments.count
    ))?;
    let line = TareLine { channel: &target.id, tare_n: Some(tare_n), r_ohm: Some(r_ohm) };
    target.offer(&Value::Tare(Some(tare_n)), line)
}

/// Of the channel, with its table if it has one.
fn characteristic(target: &Target) -> Result<Option<Force>, CtlError> {
    let settings = target.config.settings().map_err(CtlError::said)?;
    let channel = settings.channels.into_iter().find(|channel| channel.id == target.id);
    Ok(channel.and_then(|channel| channel.force))
}
