//! `[gpio]`, `[mock]` and the sinks of the channels: is every line there, once.

use super::channels::key;
use crate::circuit::Kind;
use crate::config::Findings;
use crate::config::{Backend, Config, Gpio, LineName};

pub fn check(config: &Config, findings: &mut Findings) {
    equal_lines(config, findings);
    let gpio = &config.gpio;
    if gpio.backend == Backend::Mock {
        if config.mock.as_ref().is_none_or(|mock| mock.scene.trim().is_empty()) {
            let remedy = "scene = \"pi4\" under [mock], or lines under [gpio]";
            findings.error(
                "mock.scene",
                "missing: without hardware there has to be a simulated circuit",
                remedy,
            );
        }
        return;
    }
    if gpio.chip.is_none() {
        let remedy = "the chip's label, such as \"pinctrl-rp1\" (see `cermctl lines`)";
        findings.error("gpio.chip", "missing", remedy);
    }
    let of_outputs = config.channels.iter().enumerate().filter_map(|(index, channel)| {
        Some((key(index, channel, "output.chip"), channel.output.as_ref()?.chip.as_ref()?))
    });
    let of_circuit = gpio.chip.iter().map(|chip| ("gpio.chip".to_owned(), chip));
    for (key, chip) in of_circuit.chain(of_outputs).filter(|(_, chip)| is_a_number(chip)) {
        let reason = format!("{chip} is a number, which may be another chip's after a reboot");
        findings.warning(key, reason, "the chip's label, if no other has the same (see `cermctl lines`)");
    }
    let has_node_b = config.circuit.kind() == Kind::TwoCapacitor;
    for (key, name, is_needed, is_of_node_b) in lines(gpio) {
        if name.is_none() && is_needed && (has_node_b || !is_of_node_b) {
            findings.error(key, "missing", "a line's name such as \"GPIO5\", or its offset");
        }
        if name.is_some() && is_of_node_b && !has_node_b {
            let remedy = "kind = \"two-capacitor\", or without it";
            findings.warning(key, "not used: this circuit has no node B", remedy);
        }
    }
    chargers(gpio, has_node_b, findings);
    for (index, channel) in config.channels.iter().enumerate().filter(|(_, channel)| channel.sink.is_none()) {
        findings.error(key(index, channel, "sink"), "missing", "the line that the sensor is wired to");
    }
}

/// Whether a chip is named in the order in which the kernel found it.
fn is_a_number(chip: &str) -> bool {
    let number = chip.trim_start_matches("/dev/").strip_prefix("gpiochip").unwrap_or_default();
    !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit())
}

/// The lines that have a key in `[gpio]`: whether they are needed (chargers are not, or not alone: see [`chargers`]), and
/// whether they are at node B.
fn lines(gpio: &Gpio) -> [(&'static str, Option<&LineName>, bool, bool); 6] {
    [
        ("gpio.sense-a", gpio.sense_a.as_ref(), true, false),
        ("gpio.sense-b", gpio.sense_b.as_ref(), true, true),
        ("gpio.charge-a", gpio.charge_a.as_ref(), false, false),
        ("gpio.charge-b", gpio.charge_b.as_ref(), false, true),
        ("gpio.sink-c1", gpio.sink_c1.as_ref(), true, false),
        ("gpio.sink-c2", gpio.sink_c2.as_ref(), true, false),
    ]
}

fn chargers(gpio: &Gpio, has_node_b: bool, findings: &mut Findings) {
    let pair = "a charger for both nodes, or for none";
    match (&gpio.charge_a, &gpio.charge_b) {
        (Some(_), None) if has_node_b => {
            findings.error("gpio.charge-b", "missing, while charge-a is there", pair);
        }
        (None, Some(_)) if has_node_b => {
            findings.error("gpio.charge-a", "missing, while charge-b is there", pair);
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
    let mut seen: Vec<(String, &LineName)> = Vec::new();
    for (key, line) in every_line(config) {
        match seen.iter().find(|(_, other)| *other == line) {
            Some((first, _)) => {
                findings.error(key, format!("{} is {first} already", line.0), "a line of its own")
            }
            None => seen.push((key, line)),
        }
    }
}

/// The lines of the circuit by their keys, as they are written.
pub fn every_line(config: &Config) -> Vec<(String, &LineName)> {
    let own = lines(&config.gpio).into_iter().map(|(key, name, ..)| (key.to_owned(), name));
    let sinks = config.channels.iter().enumerate().map(|(i, c)| (key(i, c, "sink"), c.sink.as_ref()));
    own.chain(sinks).filter_map(|(key, line)| Some((key, line?))).collect()
}
