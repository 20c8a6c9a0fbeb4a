//! `[gpio]`, `[mock]` and the sinks of the channels: is every line there, once.

use super::Findings;
use super::channels::key;
use crate::circuit::Kind;
use crate::config::{Backend, Config, Gpio, Line};

pub fn check(config: &Config, findings: &mut Findings) {
    equal_lines(config, findings);
    if config.gpio.backend == Backend::Mock {
        return scene(config, findings);
    }
    if config.gpio.chip.is_none() {
        findings.error(
            "gpio.chip",
            "missing",
            "the chip's label, such as \"pinctrl-rp1\" (see `cermctl lines`)",
        );
    }
    let two_nodes = config.circuit.kind() == Kind::TwoCapacitor;
    missing_lines(&config.gpio, two_nodes, findings);
    chargers(&config.gpio, two_nodes, findings);
    for (index, channel) in config.channels.iter().enumerate() {
        if channel.sink.is_none() {
            findings.error(key(index, channel, "sink"), "missing", "the line that the sensor is wired to");
        }
    }
}

fn scene(config: &Config, findings: &mut Findings) {
    if config.mock.as_ref().is_none_or(|mock| mock.scene.trim().is_empty()) {
        findings.error(
            "mock.scene",
            "missing: without hardware there has to be a simulated circuit",
            "scene = \"pi4\" under [mock], or lines under [gpio]",
        );
    }
}

fn missing_lines(gpio: &Gpio, two_nodes: bool, findings: &mut Findings) {
    for (name, line) in gpio.lines() {
        let of_node_b = name.ends_with("-b");
        let needed = !name.starts_with("charge") && (two_nodes || !of_node_b);
        if needed && line.is_none() {
            findings.error(
                format!("gpio.{name}"),
                "missing",
                "a line's name such as \"GPIO5\", or its offset",
            );
        }
        if of_node_b && !two_nodes && line.is_some() {
            findings.warning(
                format!("gpio.{name}"),
                "not used: this circuit has no node B",
                "kind = \"two-capacitor\", or without it",
            );
        }
    }
}

fn chargers(gpio: &Gpio, two_nodes: bool, findings: &mut Findings) {
    match (&gpio.charge_a, &gpio.charge_b) {
        (Some(_), None) if two_nodes => {
            findings.error(
                "gpio.charge-b",
                "missing, while charge-a is there",
                "a charger for both nodes, or for none",
            );
        }
        (None, Some(_)) if two_nodes => {
            findings.error(
                "gpio.charge-a",
                "missing, while charge-b is there",
                "a charger for both nodes, or for none",
            );
        }
        (None, _) if gpio.backend == Backend::ChardevV1 => findings.error(
            "gpio.charge-a",
            "missing: this kernel interface cannot turn a sense line into a charger",
            "lines of their own as chargers, or backend = \"chardev\"",
        ),
        _ => {}
    }
}

fn equal_lines(config: &Config, findings: &mut Findings) {
    let own = config.gpio.lines().into_iter().map(|(name, line)| (format!("gpio.{name}"), line));
    let sinks = config.channels.iter().enumerate().map(|(i, c)| (key(i, c, "sink"), c.sink.as_ref()));
    let mut seen: Vec<(String, &Line)> = Vec::new();
    for (key, line) in own.chain(sinks).filter_map(|(key, line)| line.map(|line| (key, line))) {
        match seen.iter().find(|(_, other)| *other == line) {
            Some((first, _)) => {
                findings.error(key, format!("{line} is {first} already"), "a line of its own")
            }
            None => seen.push((key, line)),
        }
    }
}
