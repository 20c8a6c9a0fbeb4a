//! `[measure]`: values that are wrong in any circuit, and methods that are wrong in this one.

use super::Findings;
use crate::circuit::Kind;
use crate::config::{Calibration, Config, Measure, Offset};
use crate::reading::Method;
use crate::record::LONGEST_LATENCY;
use crate::units::{Nanos, Seconds};

/// A longer wait is a slip of a prefix.
const LONGEST_WAIT: Nanos = Nanos(60_000_000_000);
/// Beyond this fraction of T_xA even a late node B has crossed.
const LARGEST_SWITCH_FRACTION: f64 = 1.3;

pub fn check(config: &Config, findings: &mut Findings) {
    let measure = &config.measure;
    method(measure.method, config.circuit.kind(), findings);
    calibration(measure, config.circuit.kind(), findings);
    if measure.t_l.is_some() && !config.method().rules().has_time_limit {
        findings.warning("measure.t-l", "not used: only \"cerm\" has it", "method = \"cerm\", or without it");
    }
    durations(measure, findings);
    if measure.rate_hz.is_some_and(|rate| !rate.is_finite() || rate <= 0.0) {
        findings.error(
            "measure.rate-hz",
            "not above zero",
            "20, or without it: as fast as the circuit allows",
        );
    }
    if let Some(Offset::Fixed(d)) = measure.offset {
        if d < Nanos::ZERO || d > LONGEST_LATENCY {
            findings.error(
                "measure.offset",
                format!("{} is not between 0 and 1 ms", Seconds::from(d)),
                "\"auto\", or \"8 us\"",
            );
        }
    }
    if measure.switch_fraction.is_some_and(|fraction| !(fraction > 0.0 && fraction < LARGEST_SWITCH_FRACTION))
    {
        findings.error("measure.switch-fraction", "not between 0 and 1.3", "0.9");
    }
}

fn calibration(measure: &Measure, kind: Kind, findings: &mut Findings) {
    if kind == Kind::SeriesCalibration && measure.calibration == Some(Calibration::Tracked) {
        let reason = "a tracked calibration does not know the circuit with series calibration";
        findings.error("measure.calibration", reason, "\"each-reading\"");
    }
    if measure.method.is_some_and(Method::is_tracked) && measure.calibration == Some(Calibration::EachReading)
    {
        let reason = "not used: method \"tracked\" has a tracked calibration";
        findings.warning("measure.calibration", reason, "without it, or method = \"cerm\"");
    }
    if measure.resolution.is_some_and(|resolution| resolution < Nanos(1) || resolution > Nanos(1_000_000)) {
        findings.error("measure.resolution", "not between 1 ns and 1 ms", "\"1 ns\"");
    }
}

fn method(method: Option<Method>, kind: Kind, findings: &mut Findings) {
    let Some(method) = method.filter(|method| !method.rules().circuits.contains(&kind)) else { return };
    let kinds: Vec<String> =
        method.rules().circuits.iter().map(|kind| format!("\"{}\"", kind.as_str())).collect();
    findings.error(
        "measure.method",
        format!("\"{}\" needs kind = {}", method.as_str(), kinds.join(" or ")),
        format!("\"{}\", or another circuit", Method::best(kind).as_str()),
    );
}

fn durations(measure: &Measure, findings: &mut Findings) {
    for (name, time) in [("charge-time", measure.charge_time), ("deadline", measure.deadline)] {
        if time.is_some_and(|time| time <= Nanos::ZERO) {
            findings.error(format!("measure.{name}"), "not above zero", "without it: it is derived");
        }
    }
    for (name, time) in [("settle-time", measure.settle_time), ("t-l", measure.t_l)] {
        if time.is_some_and(|time| time < Nanos::ZERO) {
            findings.error(format!("measure.{name}"), "below zero", "without it: there is a default");
        }
    }
    let waits = [
        ("charge-time", measure.charge_time),
        ("settle-time", measure.settle_time),
        ("deadline", measure.deadline),
    ];
    for (name, wait) in waits {
        if let Some(wait) = wait.filter(|wait| *wait > LONGEST_WAIT) {
            let reason = format!("{:.3} is longer than a minute", Seconds::from(wait));
            findings.error(format!("measure.{name}"), reason, "without it: it is derived");
        }
    }
}
