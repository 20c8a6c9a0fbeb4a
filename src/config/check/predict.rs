//! What the circuit will do: settings against predicted times, and the predictions themselves.
//!
//! Runs only for a valid circuit, an available method, and settings that are right in themselves.

use crate::circuit::Node;
use crate::config::Config;
use crate::config::Findings;
use crate::config::charge::{Noise, Prediction, Remembered};
use crate::config::limits::{SHORT_CHARGE, SHORTEST_PART};
use crate::estimate::method::Switching;
use crate::instrument::settings::{OffsetSource, Settings};
use crate::reading::Measured;
use crate::units::{Seconds, measured, rough};

pub fn check(config: &Config, findings: &mut Findings) {
    charge_time(config, findings);
    deadline(config, findings);
    rate(config, findings);
    switch(config, findings);
    split_calibration(config, findings);
    if !findings.has_errors() {
        predictions(config, findings);
    }
}

fn charge_time(config: &Config, findings: &mut Findings) {
    let (charge, shortest) = (Seconds::from(config.charge_time()), config.shortest_charge());
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
    let taus = config.charge_time().as_seconds() / config.circuit.charge_tau().0;
    let Remembered { at, sigmas } = config.remembered(taus);
    format!(
        "is {taus:.1} time constants: the discharge before changes a reading by up to {sigmas:.2} of its u (at {at:.2})"
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
            format!("at least \"{:.2}\", or without it", Seconds(2.0 * calibration.0)),
        );
    }
}

fn rate(config: &Config, findings: &mut Findings) {
    let Some(rate) = config.measure.rate_hz else { return };
    let [fastest, _] = config.cycle(Seconds(0.0));
    let [_, usual] = config.cycle(config.discharge(config.circuit.r_second()));
    let remedy = format!("at most {:.1}, a shorter charge-time, or smaller capacitors", 1.0 / usual.0);
    if rate * fastest.0 > 1.0 {
        let reason = format!("calibration and charging alone take {fastest:.3}, {:.1} Hz", 1.0 / fastest.0);
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
            format!("{:.2}", 0.9 * latest),
        );
    }
}

/// The split calibration that finds the offset runs Rc1 up to the switch, and the second resistor from there.
fn split_calibration(config: &Config, findings: &mut Findings) {
    let circuit = &config.circuit;
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
    let charge = Seconds::from(config.charge_time());
    let whose = if config.measure.charge_time.is_some() { "as given" } else { "automatic" };
    findings.info("measure.charge-time", format!("{charge:.3}, {whose}, {}", remembers(config)));
    let deadline = Seconds::from(config.deadline());
    if let Some(highest) = circuit.resistance(config.last_node(), deadline) {
        findings.info("measure.deadline", format!("{deadline:.3}, enough for a sensor of {highest:.3}"));
    }
    let [_, usual] = config.cycle(config.discharge(circuit.r_second()));
    let [_, longest] = config.cycle(deadline);
    findings.info(
        "measure.rate-hz",
        format!(
            "a cycle takes {usual:.3} ({:.1} Hz) with the sensor at {}, {longest:.3} at most",
            1.0 / usual.0,
            config.circuit.kind().second(),
        ),
    );
}

/// What readings of some resistances are to be expected: their errors, their forces, and how often they come. `how`: where the
/// noise is known from.
pub fn readings(config: &Config, settings: &Settings, noise: Noise, how: &str, findings: &mut Findings) {
    let predictions = config.predictions(noise);
    let with_rate = |Prediction { r, u, period }: &Prediction| {
        let [most, least] = period.map(|period| format!("{:.1}", 1.0 / period.0));
        let rate = if most == least { least } else { format!("{least} to {most}") };
        format!("{} at {rate} Hz", measured(r.0, Some(u.0), "ohm", false))
    };
    let text = predictions.iter().map(with_rate).collect::<Vec<_>>().join(", ");
    findings.info("measure.method", format!("{} with {how}: {text}", config.method()));
    for channel in &settings.channels {
        let Some(force) = &channel.force else { continue };
        let pins_u_ohm = |r_ohm| channel.pins_u_ohm(r_ohm, settings.r_ohm());
        let of = |Prediction { r, u, .. }: &Prediction| {
            let f_n = force.at(Measured { value: r.0, u: Some(u.0) }, pins_u_ohm(r.0), settings.r_ohm())?;
            let repeat = f_n.repeat_u.map(|u| rough(u, "N")).unwrap_or_default();
            Some(format!("{} (readout {repeat})", measured(f_n.value, f_n.u, "N", false)))
        };
        let text = predictions.iter().filter_map(of).collect::<Vec<_>>().join(", ");
        findings.info(format!("channel.{}.force", channel.id), format!("at these resistances: {text}"));
    }
}
