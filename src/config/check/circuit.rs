//! `[circuit]`: can these parts measure at all, and would they last.

use crate::circuit::{Circuit, Kind, Network, Node, RESISTORS};
use crate::config::Findings;
use crate::config::limits::{
    B_MARGIN, CALIBRATION_RATIO, CAPACITORS, SHORTEST_DISCHARGE, STRONGEST_PIN_A, SUPPLIES, pin_limit_a,
};
use crate::units::{Farad, Ohm, Quantity, Volt, rounded_up};
use std::fmt::Display;
use std::ops::RangeInclusive;

/// `chip`: the GPIO chip, as it is configured: by its label it says what a pin may carry.
pub fn check(circuit: &Circuit, chip: &str, findings: &mut Findings) {
    match circuit.network {
        Network::TwoCapacitor { c_a, c_b } => {
            part(findings, "c-a", c_a, CAPACITORS);
            part(findings, "c-b", c_b, CAPACITORS);
        }
        Network::OneCapacitor { c } | Network::SeriesCalibration { c } => part(findings, "c", c, CAPACITORS),
    }
    part(findings, "r-c1", circuit.r_c1, RESISTORS);
    part(findings, "r-c2", circuit.r_c2, RESISTORS);
    part(findings, "r-charge", circuit.r_charge, RESISTORS);
    part(findings, "v-dd", circuit.v_dd, SUPPLIES);
    part(findings, "v-th", circuit.v_th, Volt(0.0)..=Volt(f64::INFINITY));
    if !findings.has_errors() {
        contradictions(circuit, findings);
    }
    if !findings.has_errors() {
        weaknesses(circuit, chip, findings);
    }
}

/// An error for a value that no part has.
fn part<Q: Quantity + PartialOrd + Display>(
    findings: &mut Findings,
    name: &str,
    value: Q,
    range: RangeInclusive<Q>,
) {
    let key = format!("circuit.{name}");
    if value.si().is_nan() || value.si() <= 0.0 {
        let remedy = format!("the value of the part, such as \"{}\"", Q::EXAMPLE);
        findings.error(key, format!("{name} is not above zero"), remedy);
    } else if !range.contains(&value) {
        let reason = format!("{value} is not between {} and {}", range.start(), range.end());
        let remedy = format!("another prefix, as in \"{}\": M is mega, m is milli", Q::EXAMPLE);
        findings.error(key, reason, remedy);
    }
}

/// What keeps parts that are right in themselves from measuring.
fn contradictions(&Circuit { network, r_c1, r_c2, v_dd, v_th, .. }: &Circuit, findings: &mut Findings) {
    // In series with Rc1, any Rc2 makes the second discharge the slower one.
    if r_c1 >= r_c2 && network.kind() != Kind::SeriesCalibration {
        let reason = format!("{r_c1} is not below r-c2 = {r_c2}");
        findings.error("circuit.r-c1", reason, "the lower resistor as r-c1");
    }
    if v_th >= v_dd {
        let reason = format!("the threshold {v_th:.4} is not below the supply {v_dd:.4}");
        findings.error("circuit.v-th", reason, "\"1.3 V\", usual for a 3.3 V input");
    } else if let Network::TwoCapacitor { c_a, c_b } = network {
        // Where node B ends.
        let floor = Volt(v_dd.0 * c_b.0 / (c_a.0 + c_b.0));
        if v_th <= floor {
            let reason = format!("node B never falls below {floor:.4}, and its threshold is {v_th:.4}");
            let below = Farad(c_a.0 * v_th.0 / (v_dd.0 - v_th.0));
            findings.error("circuit.c-b", reason, format!("a c-b well below {below:.3}, or a larger c-a"));
        }
    }
}

fn weaknesses(circuit: &Circuit, chip: &str, findings: &mut Findings) {
    let known_a = pin_limit_a(chip);
    let (supply, limit_a) = (circuit.v_dd.0, known_a.unwrap_or(STRONGEST_PIN_A));
    let of = known_a.map(|_| format!(" of {chip}")).unwrap_or_default();
    for (key, r, r_o, begins, does, pin) in [
        ("r-charge", circuit.r_charge.0, 0.0, "charging", "deliver", ", pin included"),
        ("r-c1", circuit.r_c1.0, circuit.r_o.0, "the discharge", "sink", ""),
    ] {
        let milliampere = 1e3 * supply / (r + r_o);
        if milliampere > 1e3 * limit_a {
            let reason = format!(
                "{begins} starts with {milliampere:.1} mA, above the {:.0} mA that a pin{of} may {does}",
                1e3 * limit_a
            );
            // Upwards, or who follows it hears the same again.
            let least = rounded_up(supply / limit_a - r_o, 3);
            let remedy = format!("at least \"{:.3}\"{pin}", Ohm(least));
            findings.warning(format!("circuit.{key}"), reason, remedy);
        }
    }
    if circuit.r_second().0 < CALIBRATION_RATIO * circuit.r_c1.0 {
        findings.warning(
            "circuit.r-c2",
            format!("calibration at {} and {} is too close together", circuit.r_c1, circuit.r_second()),
            "r-c1 and r-c2 near the ends of the range of the sensor",
        );
    }
    let key = if circuit.kind() == Kind::TwoCapacitor { "circuit.c-a" } else { "circuit.c" };
    if let Some(time) = circuit.crossing(Node::A, circuit.r_c1).filter(|time| *time < SHORTEST_DISCHARGE) {
        let reason = format!("the discharge through Rc1 takes {time:.2}: too short to be started and timed");
        findings.error(key, reason, "larger capacitors, or another prefix: u is micro, n is nano");
    }
    let (end, v_th) = (circuit.voltage(Node::B, Farad(f64::INFINITY)), circuit.v_th);
    if let Some(end) = end.filter(|end| v_th.0 - end.0 < B_MARGIN * supply) {
        let reason = format!("node B ends at {end:.3}, close below its threshold {v_th:.3}: it crosses late");
        findings.warning("circuit.c-b", reason, "a smaller c-b or a larger c-a");
    }
}
