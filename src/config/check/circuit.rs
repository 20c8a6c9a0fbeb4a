//! `[circuit]`: can these parts measure at all, and would they last.

use super::Findings;
use crate::circuit::Node;
use crate::circuit::{Circuit, Defect, Network};
use crate::units::{Farad, Ohm, Quantity, Volt};
use std::ops::RangeInclusive;

/// What a GPIO pin may carry, ampere (Raspberry Pi: 16 mA at the strongest drive).
const PIN_LIMIT_A: f64 = 0.016;
/// Values outside these are slips of a prefix, not parts.
const CAPACITORS: RangeInclusive<Farad> = Farad(10e-12)..=Farad(1e-3);
const RESISTORS: RangeInclusive<Ohm> = Ohm(1.0)..=Ohm(100e6);
const SUPPLIES: RangeInclusive<Volt> = Volt(0.5)..=Volt(30.0);
/// Below this share of V_DD between the threshold and the level where node B ends, B crosses late and unsteadily.
const B_MARGIN: f64 = 0.05;
/// Below this ratio of the calibration resistors, differences of their times are mostly noise.
const CALIBRATION_RATIO: f64 = 1.5;

pub fn check(circuit: &Circuit, findings: &mut Findings) {
    absurd_values(circuit, findings);
    for defect in circuit.defects() {
        let (key, remedy) = match defect {
            Defect::NotPositive(name) => {
                let example = match name.as_bytes()[0] {
                    b'r' => Ohm::EXAMPLE,
                    b'v' => Volt::EXAMPLE,
                    _ => Farad::EXAMPLE,
                };
                (name, format!("the value of the part, such as \"{example}\""))
            }
            Defect::Order { .. } => ("r-c1", "the lower resistor as r-c1".to_owned()),
            Defect::Threshold { .. } => ("v-th", "\"1.3 V\", usual for a 3.3 V input".to_owned()),
            Defect::NoBCrossing { c_b_below, .. } => {
                ("c-b", format!("a c-b well below {c_b_below:.3}, or a larger c-a"))
            }
        };
        findings.error(format!("circuit.{key}"), defect.to_string(), remedy);
    }
    if !findings.has_errors() {
        weaknesses(circuit, findings);
    }
}

fn absurd_values(circuit: &Circuit, findings: &mut Findings) {
    match circuit.network {
        Network::TwoCapacitor { c_a, c_b } => {
            within(findings, "c-a", c_a, CAPACITORS);
            within(findings, "c-b", c_b, CAPACITORS);
        }
        Network::OneCapacitor { c } | Network::SeriesCalibration { c } => {
            within(findings, "c", c, CAPACITORS)
        }
    }
    within(findings, "r-c1", circuit.r_c1, RESISTORS);
    within(findings, "r-c2", circuit.r_c2, RESISTORS);
    within(findings, "r-charge", circuit.r_charge, RESISTORS);
    within(findings, "v-dd", circuit.v_dd, SUPPLIES);
}

/// An error for a positive value that no part has; other values are [defects](Defect).
fn within<Q>(findings: &mut Findings, name: &str, value: Q, range: RangeInclusive<Q>)
where
    Q: Quantity + PartialOrd + std::fmt::Display,
{
    if value.si() > 0.0 && !range.contains(&value) {
        findings.error(
            format!("circuit.{name}"),
            format!("{value} is not between {} and {}", range.start(), range.end()),
            format!("another prefix, as in \"{}\": M is mega, m is milli", Q::EXAMPLE),
        );
    }
}

fn weaknesses(circuit: &Circuit, findings: &mut Findings) {
    let charge_a = circuit.v_dd.0 / circuit.r_charge.0;
    if charge_a > PIN_LIMIT_A {
        findings.warning(
            "circuit.r-charge",
            format!("charging starts with {:.1} mA, above the 16 mA that a pin may deliver", 1e3 * charge_a),
            format!("at least \"{:.3}\", pin included", Ohm(circuit.v_dd.0 / PIN_LIMIT_A)),
        );
    }
    let sink_a = circuit.v_dd.0 / (circuit.r_c1.0 + circuit.r_o.0);
    if sink_a > PIN_LIMIT_A {
        findings.warning(
            "circuit.r-c1",
            format!("the discharge starts with {:.1} mA, above the 16 mA that a pin may sink", 1e3 * sink_a),
            format!("at least \"{:.3}\"", Ohm(circuit.v_dd.0 / PIN_LIMIT_A - circuit.r_o.0)),
        );
    }
    if circuit.r_second().0 < CALIBRATION_RATIO * circuit.r_c1.0 {
        findings.warning(
            "circuit.r-c2",
            format!("calibration at {} and {} is too close together", circuit.r_c1, circuit.r_second()),
            "r-c1 and r-c2 near the ends of the range of the sensor",
        );
    }
    let end = circuit.voltage(Node::B, Farad(f64::INFINITY));
    if let Some(end) = end.filter(|end| circuit.v_th.0 - end.0 < B_MARGIN * circuit.v_dd.0) {
        findings.warning(
            "circuit.c-b",
            format!(
                "node B ends at {end:.3}, close below its threshold {:.3}: it crosses late",
                circuit.v_th
            ),
            "a smaller c-b or a larger c-a",
        );
    }
}
