//! What the circuit will do: settings against predicted times, and the predictions themselves.
//!
//! Runs only for a valid circuit, an available method, and settings that are right in themselves.

use crate::circuit::{Chargers, Node};
use crate::config::Config;
use crate::config::Findings;
use crate::config::charge::Remembered;
use crate::config::limits::{LONGEST_WAIT, SHORT_CHARGE, SHORTEST_PART, SLOWEST_HZ};
use crate::estimate::method::Switching;
use crate::instrument::settings::OffsetSource;
use crate::units::{Hertz, Seconds, rounded_down};

pub fn check(config: &Config, findings: &mut Findings) {
    charge_time(config, findings);
    deadline(config, findings);
    rate(config, findings);
    switch(config, findings);
    split_calibration(config, findings);
    if !findings.has_errors() {
        predictions(config, findings);
        super::trigger::predict(config, findings);
    }
}

fn charge_time(config: &Config, findings: &mut Findings) {
    let charge = Seconds::from(config.charge_time());
    let shortest = config.shortest_charge(Chargers::OfA);
    if charge.0 < SHORT_CHARGE * shortest.0 {
        findings.warning(
            "measure.charge-time",
            format!("{charge:.3} {}", remembers(config)),
            format!("at least \"{shortest:.2}\", or without it"),
        );
    }
}

/// How complete a charge is, and what follows from it.
fn remembers(config: &Config) -> String {
    let charge = Seconds::from(config.charge_time());
    let taus = charge.0 / config.circuit.charge_tau(Chargers::OfA).0;
    let Remembered { at, sigmas } = config.remembered(Chargers::OfA, taus);
    let places = if sigmas < 10.0 { 2 } else { 0 };
    format!(
        "is {taus:.1} time constants: the discharge before changes a reading by up to {sigmas:.places$} of its u (at {at:.2})"
    )
}

fn deadline(config: &Config, findings: &mut Findings) {
    let calibration = config.discharge(config.circuit.r_second());
    let deadline = config.deadline();
    if deadline.as_seconds() < calibration.0 {
        findings.error(
            "measure.deadline",
            format!(
                "{:.3} is shorter than the discharge through {}, {calibration:.3}: even calibration would fail",
                Seconds::from(deadline),
                config.circuit.kind().second(),
            ),
            if 2.0 * calibration.0 < LONGEST_WAIT.as_seconds() {
                format!("at least \"{:.2}\", or without it", Seconds(2.0 * calibration.0))
            } else {
                "smaller capacitors".to_owned()
            },
        );
    }
}

fn rate(config: &Config, findings: &mut Findings) {
    let Some(rate) = config.measure.rate_hz else { return };
    let [fastest, _] = config.cycle(Seconds(0.0));
    // Where the calibration is tracked, without one: most readings have none.
    let [usual, _] = config.cycle(config.discharge(config.circuit.r_second()));
    // Downwards, or who follows it hears the same again.
    let most = rounded_down(1.0 / usual.0, 2);
    let remedy = match most < SLOWEST_HZ {
        true => "without it: as fast as the circuit allows, or smaller capacitors".to_owned(),
        false => format!(
            "at most {most}, none (as fast as the circuit allows), a shorter charge-time, or smaller capacitors"
        ),
    };
    if rate * fastest.0 > 1.0 {
        let what =
            if config.is_tracked() { "charging alone takes" } else { "calibration and charging alone take" };
        let reason = format!("{what} {fastest:.3}, {:.2}", Hertz(1.0 / fastest.0));
        findings.error("measure.rate-hz", reason, remedy);
    } else if rate * usual.0 > 1.0 {
        let reason =
            format!("a cycle with the sensor at {} takes {usual:.3}", config.circuit.kind().second());
        findings.warning("measure.rate-hz", reason, remedy);
    }
}

fn switch(config: &Config, findings: &mut Findings) {
    if config.method().rules().switching != Switching::AtFraction {
        return;
    }
    let latest = match (config.circuit.g(Node::A), config.circuit.g(config.last_node())) {
        (Some(a), Some(last)) => last.0 / a.0,
        _ => 1.0,
    };
    if config.switch_fraction() >= latest {
        findings.warning(
            "measure.switch-fraction",
            format!("the last crossing comes at {latest:.3} of T_xA, before the planned switch"),
            rounded_down(0.9 * latest, 2).to_string(),
        );
    }
}

/// The split calibration that finds the offset runs Rc1 up to the switch, and the second resistor from there. Who can do without the
/// offset can do without that.
fn split_calibration(config: &Config, findings: &mut Findings) {
    let circuit = &config.circuit;
    if !config.method().needs_offset() {
        return;
    }
    let (OffsetSource::Auto, Some(g_a), Some(g)) =
        (config.offset(), circuit.g(Node::A), circuit.g(config.last_node()))
    else {
        return;
    };
    let at = g_a.0 * config.switch_fraction();
    let parts = [
        ("Rc1", Seconds(at * (circuit.r_c1.0 + circuit.r_o.0))),
        (config.circuit.kind().second(), Seconds((g.0 - at) * (circuit.r_second().0 + circuit.r_o.0))),
    ];
    for (name, part) in parts {
        if part < SHORTEST_PART {
            findings.warning(
                "measure.offset",
                format!(
                    "\"auto\" splits a calibration discharge, and its part through {name} has only {:.2}",
                    Seconds(part.0.max(0.0)),
                ),
                "larger capacitors, another switch-fraction, or a measured offset such as \"8 us\"",
            );
        }
    }
}

fn predictions(config: &Config, findings: &mut Findings) {
    let circuit = &config.circuit;
    let nodes = if config.last_node() == Node::B { &Node::BOTH[..] } else { &[Node::A] };
    for (key, name, r) in
        [("r-c1", "Rc1", circuit.r_c1), ("r-c2", config.circuit.kind().second(), circuit.r_second())]
    {
        let times: Vec<String> = nodes
            .iter()
            .filter_map(|node| {
                circuit.crossing(*node, r).map(|time| format!("node {node:?} after {time:.3}"))
            })
            .collect();
        findings.info(format!("circuit.{key}"), format!("through {name}, {}", times.join(", ")));
    }
    let charge = config.charge_in_words();
    let whose = if config.measure.charge_time.is_some() { "as given" } else { "automatic" };
    findings.info("measure.charge-time", format!("{charge}, {whose}, {}", remembers(config)));
    let deadline = Seconds::from(config.deadline());
    if let Some(highest) = circuit.resistance(config.last_node(), deadline) {
        let above = if config.is_tracked() { "; one of more is finished early" } else { "" };
        findings
            .info("measure.deadline", format!("{deadline:.3}, enough for a sensor of {highest:.3}{above}"));
    }
    let [usual, calibrated] = config.cycle(config.discharge(circuit.r_second()));
    let more = match calibrated.0 > usual.0 {
        true => format!(", {calibrated:.3} with a calibration discharge in it"),
        false => String::new(),
    };
    let [_, longest] = config.cycle(deadline);
    findings.info(
        "measure.rate-hz",
        format!(
            "a cycle takes {usual:.3} ({:.3}) with the sensor at {}{more}, {longest:.3} at most",
            Hertz(1.0 / usual.0),
            config.circuit.kind().second(),
        ),
    );
}
