//! `[measure]`: values that are wrong in any circuit, and methods that are wrong in this one.

use crate::circuit::Kind;
use crate::config::Findings;
use crate::config::limits::{LARGEST_SWITCH_FRACTION, LONGEST_WAIT, SLOWEST_HZ};
use crate::config::{Calibration, Config, Measure};
use crate::instrument::settings::OffsetSource;
use crate::reading::Method;
use crate::record::{LONGEST_LATENCY, RESOLUTIONS};
use crate::units::{Nanos, Seconds};

pub fn check(config: &Config, findings: &mut Findings) {
    let measure = &config.measure;
    method(measure.method, config.circuit.kind(), findings);
    calibration(measure, config.circuit.kind(), findings);
    if measure.t_l.is_some() && !config.method().rules().has_time_limit {
        findings.warning("measure.t-l", "not used: only \"cerm\" has it", "method = \"cerm\", or without it");
    }
    durations(measure, findings);
    rates(measure, findings);
    numbers(measure, findings);
    if let Some(OffsetSource::Given(d_ns)) = measure.offset {
        if !(0.0..=LONGEST_LATENCY.as_ns()).contains(&d_ns) {
            let reason = format!("{} is not between 0 and 1 ms", Seconds(d_ns * 1e-9));
            findings.error("measure.offset", reason, "\"auto\", or \"8 us\"");
        }
    }
}

fn calibration(measure: &Measure, kind: Kind, findings: &mut Findings) {
    if !Method::can_be_tracked(kind) && measure.calibration == Some(Calibration::Tracked) {
        let reason = "a tracked calibration does not know the circuit with series calibration";
        findings.error("measure.calibration", reason, "\"each-reading\"");
    }
    if measure.method.is_some_and(Method::is_tracked) && measure.calibration == Some(Calibration::EachReading)
    {
        let reason = "not used: method \"tracked\" has a tracked calibration";
        findings.warning("measure.calibration", reason, "without it, or method = \"cerm\"");
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

fn rates(measure: &Measure, findings: &mut Findings) {
    if measure.idle && measure.rate_hz.is_none() {
        findings.warning("measure.idle", "not used: there is no rate-hz to be idle between", "rate-hz = 10");
    }
    let both = measure.average.zip(measure.every());
    if let Some((average, period)) = both.filter(|(average, period)| average > period) {
        findings.error(
            "measure.average",
            format!(
                "{:.3} is longer than the {:.3} between readings",
                Seconds::from(average),
                Seconds::from(period)
            ),
            "without it: all that rate-hz leaves",
        );
    }
}

fn durations(measure: &Measure, findings: &mut Findings) {
    let (derived, default) = ("without it: it is derived", "without it: there is a default");
    for (name, time, least, longest, remedy) in [
        ("charge-time", measure.charge_time, Nanos(1), LONGEST_WAIT, derived),
        ("deadline", measure.deadline, Nanos(1), LONGEST_WAIT, derived),
        ("average", measure.average, Nanos(1), LONGEST_WAIT, "\"50 ms\", or without it: each reading"),
        ("settle-time", measure.settle_time, Nanos::ZERO, LONGEST_WAIT, default),
        ("t-l", measure.t_l, Nanos::ZERO, Nanos::MAX, default),
    ] {
        let Some(time) = time.filter(|time| !(least..=longest).contains(time)) else { continue };
        let reason = match time > longest {
            true => format!("{:.3} is longer than a minute", Seconds::from(time)),
            false if least > Nanos::ZERO => "not above zero".to_owned(),
            false => "below zero".to_owned(),
        };
        findings.error(format!("measure.{name}"), reason, remedy);
    }
}

fn numbers(measure: &Measure, findings: &mut Findings) {
    // Not a number is not at least anything.
    let rate = measure.rate_hz.is_none_or(|rate| rate.is_finite() && rate >= SLOWEST_HZ);
    let resolution = measure.resolution.is_none_or(|clock| RESOLUTIONS.contains(&clock));
    let fraction = measure.switch_fraction;
    let fraction = fraction.is_none_or(|fraction| fraction > 0.0 && fraction < LARGEST_SWITCH_FRACTION);
    for (name, is_right, reason, remedy) in [
        (
            "rate-hz",
            rate,
            "not a number of at least one reading in a minute, 0.017",
            "20, or without it: as fast as the circuit allows",
        ),
        ("resolution", resolution, "not between 1 ns and 1 ms", "\"1 ns\""),
        ("switch-fraction", fraction, "not between 0 and 1.3", "0.9"),
    ] {
        if !is_right {
            findings.error(format!("measure.{name}"), reason, remedy);
        }
    }
}
