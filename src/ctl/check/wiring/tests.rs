//! Broken boards on the simulated circuit, and what is said of each.

use super::*;
use crate::config::{Config, Finding, Severity};
use crate::config_file;
use crate::decorated::Decorated;
use crate::pins::sim::{Scene, Sensor, SimPins};
use crate::units::Farad;

fn config() -> Config {
    config_file::config(|c| c.channel("thumb").set("mock.scene", "ideal")).parse()
}

fn found(board: impl FnOnce(&mut Scene), cut: Drives) -> Vec<Finding> {
    let mut scene = Scene::builtin("ideal").unwrap();
    board(&mut scene);
    let config = config();
    let mut pins = Decorated::cut(SimPins::new(&scene, None), cut);
    let mut findings = Findings::default();
    test(&mut pins, &config, &mut findings).unwrap();
    assert_eq!(pins.pins.conflicts(), 0);
    findings.0
}

/// The only error or warning, as a sentence.
fn complaint(board: impl FnOnce(&mut Scene), cut: Drives) -> String {
    let findings = found(board, cut);
    let complaints: Vec<_> = findings.iter().filter(|finding| finding.severity != Severity::Info).collect();
    assert_eq!(complaints.len(), 1, "{findings:?}");
    complaints[0].to_string()
}

fn says(complaint: &str, words: &[&str]) {
    for word in words {
        assert!(complaint.contains(word), "\"{word}\" is missing in: {complaint}");
    }
}

#[test]
fn a_sound_board_is_described() {
    for name in ["ideal", "pi4", "pi5", "pi-zero"] {
        let findings = found(|scene| *scene = Scene::builtin(name).unwrap(), Drives::NONE);
        assert!(findings.iter().all(|finding| finding.severity == Severity::Info), "{name}: {findings:?}");
        assert!(findings.iter().any(|finding| finding.key == "wiring"));
    }
    let findings = found(|scene| scene.sensors = vec![Sensor::Constant(Ohm(5_000.0))], Drives::NONE);
    says(&findings[1].to_string(), &["channel.thumb.sink", "5 kohm"]);
}

#[test]
fn what_an_earlier_charge_has_left_does_not_pass_for_chargers() {
    let config = config();
    let mut pins = SimPins::new(&Scene::builtin("ideal").unwrap(), None);
    let charging = pins.drive(Drives::CHARGE).unwrap();
    pins.sleep_until(charging.after + config.charges().anew.time()).unwrap();
    pins.drive(Drives::NONE).unwrap();
    let mut findings = Findings::default();
    test(&mut Decorated::cut(pins, Drives::CHARGE), &config, &mut findings).unwrap();
    let findings = findings.0;
    says(&findings[0].to_string(), &["error: gpio.charge-a", "low after the charge"]);
}

#[test]
fn cut_wires_are_named() {
    says(&complaint(|_| {}, Drives::C1), &["error: gpio.sink-c1", "through Rc1", "wire"]);
    says(&complaint(|_| {}, Drives::C2), &["error: gpio.sink-c2", "through Rc2", "wire"]);
    says(&complaint(|_| {}, Drives::x(0)), &["warning: channel.thumb.sink", "no discharge", "press it"]);
    let neither = found(|_| {}, Drives::CHARGE);
    says(&neither[0].to_string(), &["error: gpio.charge-a", "low after the charge"]);
    says(&neither[1].to_string(), &["error: gpio.charge-b"]);
}

#[test]
fn an_open_sensor_is_no_error() {
    let said = complaint(|scene| scene.sensors = vec![Sensor::Constant(Ohm(10e6))], Drives::NONE);
    says(&said, &["warning: channel.thumb.sink", "press it"]);
}

#[test]
fn swapped_calibration_resistors_are_told() {
    let swap = |scene: &mut Scene| {
        std::mem::swap(&mut scene.circuit.r_c1, &mut scene.circuit.r_c2);
    };
    says(&complaint(swap, Drives::NONE), &["error: circuit.r-c1", "look swapped", "sink-c1 and sink-c2"]);
}

#[test]
fn a_wrong_resistor_is_told_by_the_ratio() {
    let said = complaint(|scene| scene.circuit.r_c2 = Ohm(18_000.0), Drives::NONE);
    says(&said, &["warning: circuit.r-c2", "measured again"]);
}

#[test]
fn capacitors_of_another_size_are_told_by_the_times() {
    let findings = found(|scene| scene.circuit.c_b = Some(Farad(220e-9)), Drives::NONE);
    says(&findings[1].to_string(), &["warning: circuit.c-a", "was predicted", "printed value"]);
    // So small that node B does not cross: V_Th (C_A + C_B) <= V_DD C_B.
    let findings = found(|scene| scene.circuit.c_a = Some(Farad(220e-9)), Drives::NONE);
    says(&findings[0].to_string(), &["error: gpio.sense-b", "node B stays high", "both capacitors"]);
}

#[test]
fn a_missing_capacitor_is_told_from_a_small_one() {
    // What is left are the picofarads of the wires.
    let findings = found(|scene| scene.circuit.c_b = Some(Farad(20e-12)), Drives::NONE);
    says(&findings[0].to_string(), &["error: circuit.c-b", "C_B: missing"]);
    let findings = found(|scene| scene.circuit.c_a = Some(Farad(20e-12)), Drives::NONE);
    says(&findings[0].to_string(), &["error: circuit.c-a", "C_A: missing"]);
}

#[test]
fn a_pull_beside_a_node_is_found() {
    // What pulls at one node moves the other through the capacitors.
    let down = found(|scene| scene.circuit.node_a.pull_down = Some(Ohm(50e3)), Drives::NONE);
    says(
        &down[0].to_string(),
        &["error: gpio.sense-a", "falls by itself", "pull-downs (some drivers leave them on)"],
    );
    let weak = |name, change: fn(&mut Scene)| {
        let board = |scene: &mut Scene| {
            *scene = Scene::builtin(name).unwrap();
            change(scene);
        };
        complaint(board, Drives::NONE)
    };
    for name in ["ideal", "pi4"] {
        let leaks = weak(name, |scene| scene.circuit.node_a.leakage_resistance = Some(Ohm(1e6)));
        says(&leaks, &["warning: wiring", "charge leaks away as through", "Mohm", "moisture"]);
        let feeds = weak(name, |scene| scene.circuit.node_a.pull_up = Some(Ohm(5e6)));
        says(&feeds, &["warning: wiring", "charge comes in as through", "pull-ups"]);
    }
    let up = found(|scene| scene.circuit.node_a.pull_up = Some(Ohm(50e3)), Drives::NONE);
    says(
        &up[0].to_string(),
        &["error: gpio.sense-a", "rises by itself", "pull-ups (some drivers leave them on"],
    );
}
