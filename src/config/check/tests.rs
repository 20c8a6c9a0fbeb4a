//! One test per finding: a good configuration, one thing wrong.

use super::*;
use crate::config::{Finding, Severity};
use crate::config_file::{self, ConfigFile};
use crate::pins::MAX_CHANNELS;
use crate::units::{Nanos, Seconds};
use proptest::prelude::*;

mod advice;
mod channels;
mod trigger;

/// A good configuration with something changed.
fn config(change: impl FnOnce(&mut ConfigFile) -> &mut ConfigFile) -> Config {
    let lines = [
        ("sense-a", "GPIO5"),
        ("sense-b", "GPIO6"),
        ("charge-a", "GPIO13"),
        ("charge-b", "GPIO19"),
        ("sink-c1", "GPIO20"),
        ("sink-c2", "GPIO21"),
    ];
    let good = config_file::config(|c| {
        c.set("gpio.backend", "chardev").set("gpio.chip", "pinctrl-bcm2835").set("measure.method", "cerm");
        for (line, name) in lines {
            c.set(&format!("gpio.{line}"), name);
        }
        c.channel("thumb").set("channel.thumb.sink", "GPIO16");
        c.lines("channel.thumb", "force = { fc1 = \"5.75 N\", fc2 = \"1.05 N\" }");
        c.set("server.socket", "/run/cermd/cermd.sock")
    });
    change(&mut good.clone()).parse()
}

/// The circuit with one capacitor and two lines less.
fn one_capacitor<'a>(c: &'a mut ConfigFile, kind: &str) -> &'a mut ConfigFile {
    c.one_capacitor(kind, "1 uF").unset(&["gpio.sense-b", "gpio.charge-b"])
}

/// The findings that are not predictions, as they are printed.
fn complaints(config: &Config) -> Vec<String> {
    let findings = config.check();
    findings.0.iter().filter(|f| f.severity != Severity::Info).map(Finding::to_string).collect()
}

/// Exactly one complaint, that begins as said.
#[track_caller]
fn one(change: impl FnOnce(&mut ConfigFile) -> &mut ConfigFile, beginning: &str) {
    let complaints = complaints(&config(change));
    assert!(complaints.len() == 1 && complaints[0].starts_with(beginning), "{complaints:#?}");
    assert!(complaints[0].contains("; try "), "{complaints:#?}");
}

/// One complaint about an added line of `[measure]`.
#[track_caller]
fn one_measure(line: &str, beginning: &str) {
    one(|c| c.lines("measure", line), beginning);
}

/// One complaint about another `force`.
#[track_caller]
fn one_force(force: &str, beginning: &str) {
    one(|c| c.lines("channel.thumb", &format!("force = {force}")), beginning);
}

#[test]
fn a_good_one_has_predictions_only() {
    let findings: Vec<String> = config(|c| c).check().0.iter().map(Finding::to_string).collect();
    insta::assert_snapshot!(findings.join("\n"), @r#"
    info: channel.thumb.force: it has no u: the data sheet of an FSR 402 stands in, 7.8 % (part to part 6 %, hysteresis 10 %); try `cermctl calibrate force`: it stores the residual of the sensor itself
    info: circuit.r-c1: through Rc1, node A after 247 us, node B after 418 us
    info: circuit.r-c2: through Rc2, node A after 6.16 ms, node B after 10.4 ms
    info: measure.charge-time: 1.04 ms (for B 1.36 ms), automatic, is 9.1 time constants: the discharge before changes a reading by up to 0.10 of its u (at 64 kohm)
    info: measure.deadline: 52.2 ms, enough for a sensor of 63.7 kohm
    info: measure.rate-hz: a cycle takes 25.4 ms (39.4 Hz) with the sensor at Rc2, 67.1 ms at most
    "#);
}

#[test]
fn series_calibration_is_good_too() {
    let config = config(|c| one_capacitor(c, "series-calibration").set("measure.method", "qerm"));
    let findings: Vec<String> = config.check().0.iter().map(Finding::to_string).collect();
    insta::assert_snapshot!(findings.join("\n"), @r#"
    info: channel.thumb.force: it has no u: the data sheet of an FSR 402 stands in, 7.8 % (part to part 6 %, hysteresis 10 %); try `cermctl calibrate force`: it stores the residual of the sensor itself
    info: circuit.r-c1: through Rc1, node A after 475 us
    info: circuit.r-c2: through Rc1 + Rc2, node A after 12.3 ms
    info: measure.charge-time: 2.13 ms, automatic, is 9.7 time constants: the discharge before changes a reading by up to 0.10 of its u (at 66 kohm)
    info: measure.deadline: 61.5 ms, enough for a sensor of 66 kohm
    info: measure.rate-hz: a cycle takes 31.5 ms (31.8 Hz) with the sensor at Rc1 + Rc2, 80.7 ms at most
    "#);
}

#[test]
fn circuit_values() {
    one(
        |c| c.set("circuit.r-c1", "12.7 kohm"),
        "error: circuit.r-c1: 12.7 kohm is not below r-c2 = 12.7 kohm",
    );
    one(|c| c.set("circuit.r-c1", "15 kohm"), "error: circuit.r-c1: 15 kohm is not below");
    one(|c| c.set("circuit.c-a", "0 F"), "error: circuit.c-a: c-a is not above zero");
    one(
        |c| c.set("circuit.r-c1", "-1 ohm"),
        "error: circuit.r-c1: r-c1 is not above zero; try the value of the part, such as \"2.32 kohm\"",
    );
    one(|c| c.set("circuit.c-a", "2.2 F"), "error: circuit.c-a: 2.2 F is not between 10 pF and 1 mF");
    one(
        |c| c.set("circuit.r-c1", "2.32 mohm"),
        "error: circuit.r-c1: 2.32 mohm is not between 1 ohm and 100 Mohm",
    );
    one(|c| c.set("circuit.c-b", "1.43 uF"), "error: circuit.c-b: node B never falls below 1.3 V");
    one(|c| c.set("circuit.c-b", "1.4 uF"), "warning: circuit.c-b: node B ends at 1.28 V");
    one(|c| c.set("circuit.r-c2", "680 ohm"), "warning: circuit.r-c2: calibration at");
    one(
        |c| c.set("circuit.r-c1", "100 ohm"),
        "warning: circuit.r-c1: the discharge starts with 23.6 mA, above the 16 mA",
    );
}

/// By what its maker says of each; a simulated circuit has no such pins.
#[test]
fn what_a_pin_may_carry_is_that_of_the_chip() {
    let of = |chip: &str, r_charge: &str| {
        complaints(&config(|c| c.set("gpio.chip", chip).set("circuit.r-charge", r_charge)))
    };
    for (chip, least, limit) in [
        ("pinctrl-bcm2711", "413 ohm", "8 mA"),
        ("pinctrl-rp1", "275 ohm", "12 mA"),
        ("pinctrl-bcm2835", "207 ohm", "16 mA"),
    ] {
        assert_eq!(of(chip, least), Vec::<String>::new(), "{chip}");
        let said = of(chip, "200 ohm");
        assert!(said.len() == 1 && said[0].contains(&format!("above the {limit} that a pin")), "{said:?}");
        assert!(said[0].ends_with(&format!("try at least \"{least}\", pin included")), "{said:?}");
    }
    let simulated =
        config(|c| c.set("circuit.r-charge", "260 ohm").set("gpio.backend", "mock").set("mock.scene", "pi4"));
    assert!(complaints(&simulated).iter().all(|said| !said.contains("mA")), "{:?}", complaints(&simulated));
}

#[test]
fn circuit_nominals() {
    let circuit = |line: &str| config(|c| c.lines("circuit", line));
    for (line, beginning) in [
        ("v-th = \"3.3 V\"", "error: circuit.v-th: the threshold 3.3 V is not below the supply 3.3 V"),
        (
            "v-dd = \"48 V\"\nr-charge = \"4 kohm\"",
            "error: circuit.v-dd: 48 V is not between 500 mV and 30 V",
        ),
        ("r-charge = \"100 ohm\"", "warning: circuit.r-charge: charging starts with 33.0 mA"),
    ] {
        let complaints = complaints(&circuit(line));
        assert!(complaints.iter().any(|complaint| complaint.starts_with(beginning)), "{complaints:#?}");
    }
}

#[test]
fn a_chip_may_have_another_number_after_a_reboot() {
    for chip in ["gpiochip0", "/dev/gpiochip14"] {
        one(
            |c| c.set("gpio.chip", chip),
            &format!(
                "warning: gpio.chip: {chip} is a number, which may be another chip's after a reboot; try the chip's label"
            ),
        );
        let output = format!("on-above = '2 N'\noutput = {{ line = 17, chip = '{chip}' }}");
        one(
            |c| c.lines("channel.thumb", &output),
            &format!("warning: channel.thumb.output.chip: {chip} is a number"),
        );
    }
    for label in ["pinctrl-bcm2835", "gpiochip", "gpiochip_sodimm", "/dev/gpio/by-name"] {
        assert_eq!(complaints(&config(|c| c.set("gpio.chip", label))), Vec::<String>::new(), "{label}");
    }
}

#[test]
fn lines_that_are_missing() {
    for key in [
        "gpio.chip",
        "gpio.sense-a",
        "gpio.sense-b",
        "gpio.charge-a",
        "gpio.charge-b",
        "gpio.sink-c1",
        "gpio.sink-c2",
        "channel.thumb.sink",
    ] {
        one(|c| c.unset(&[key]), &format!("error: {key}: missing"));
    }
}

#[test]
fn sense_lines_may_charge_in_uapi_v2_only() {
    let own = ["gpio.charge-a", "gpio.charge-b"];
    assert_eq!(complaints(&config(|c| c.unset(&own))), Vec::<String>::new());
    one(
        |c| c.unset(&own).set("gpio.backend", "chardev-v1"),
        "error: gpio.charge-a: missing: this kernel interface",
    );
    assert_eq!(complaints(&config(|c| c.set("gpio.backend", "chardev-v1"))), Vec::<String>::new());
}

#[test]
fn lines_that_are_equal() {
    one(|c| c.set("gpio.sink-c2", "GPIO20"), "error: gpio.sink-c2: GPIO20 is gpio.sink-c1 already");
    one(|c| c.set("channel.thumb.sink", "GPIO5"), "error: channel.thumb.sink: GPIO5 is gpio.sense-a already");
    one(
        |c| c.set("gpio.sense-a", 5).set("gpio.sense-b", "5"),
        "error: gpio.sense-b: 5 is gpio.sense-a already",
    );
}

#[test]
fn lines_that_are_not_used() {
    let series = config(|c| c.one_capacitor("series-calibration", "1 uF").set("measure.method", "qerm"));
    let complaints = complaints(&series);
    assert_eq!(complaints.len(), 2, "{complaints:#?}");
    assert!(complaints[0].starts_with("warning: gpio.sense-b: not used"));
    assert!(complaints[1].starts_with("warning: gpio.charge-b: not used"));
}

#[test]
fn the_simulated_circuit() {
    one(|c| c.unset(&["gpio"]), "error: mock.scene: missing");
    one(|c| c.unset(&["gpio"]).set("mock.scene", ""), "error: mock.scene: missing");
    let mock = config(|c| c.unset(&["gpio", "channel.thumb.sink"]).set("mock.scene", "pi4"));
    assert_eq!(complaints(&mock), Vec::<String>::new());
}

#[test]
fn methods() {
    assert_eq!(complaints(&config(|c| c.set("measure.method", "tracked"))), Vec::<String>::new());
    one(
        |c| c.set("measure.method", "tracked").set("measure.calibration", "each-reading"),
        "warning: measure.calibration: not used",
    );
    one_measure("resolution = \"0 s\"", "error: measure.resolution: not between");
    one(
        |c| c.set("measure.method", "qerm"),
        "error: measure.method: \"qerm\" needs kind = \"series-calibration\"",
    );
    one(
        |c| one_capacitor(c, "series-calibration"),
        "error: measure.method: \"cerm\" needs kind = \"two-capacitor\"",
    );
    one(
        |c| one_capacitor(c, "one-capacitor").set("measure.method", "tcdic"),
        "error: measure.method: \"tcdic\" needs kind = \"two-capacitor\"",
    );
    for method in ["tpcm", "tcdic"] {
        let complaints = complaints(&config(|c| c.set("measure.method", method)));
        assert_eq!(complaints, Vec::<String>::new(), "{method}");
    }
    let series = config(|c| one_capacitor(c, "series-calibration").set("measure.method", "tpcm"));
    assert_eq!(complaints(&series), Vec::<String>::new());
}

#[test]
fn durations() {
    one_measure("charge-time = \"0 s\"", "error: measure.charge-time: not above zero");
    one_measure("charge-time = \"400 us\"", "warning: measure.charge-time: 400 us is 3.5 time constants");
    one_measure("settle-time = \"-1 us\"", "error: measure.settle-time: below zero");
    one_measure("deadline = \"0 s\"", "error: measure.deadline: not above zero");
    one_measure(
        "deadline = \"10 ms\"",
        "error: measure.deadline: 10 ms is shorter than the discharge through Rc2, 10.4 ms",
    );
    one_measure(
        "deadline = \"50 s\"\ncharge-time = \"90 s\"",
        "error: measure.charge-time: 90 s is longer than a minute",
    );
    one_measure("t-l = \"-1 ms\"", "error: measure.t-l: below zero");
    one(|c| c.set("measure.method", "tcdic").set("measure.t-l", "1 ms"), "warning: measure.t-l: not used");
}

#[test]
fn rates() {
    for rate in ["0", "-1", "nan", "inf", "0.0166", "1e-10", "1e-300"] {
        let line = format!("rate-hz = {rate}");
        one_measure(&line, "error: measure.rate-hz: not a number of at least one reading in a minute, 0.017");
    }
    assert_eq!(complaints(&config(|c| c.set("measure.rate-hz", 0.017))), Vec::<String>::new());
    one_measure("rate-hz = 100", "error: measure.rate-hz: calibration and charging alone take");
    one_measure("rate-hz = 45", "warning: measure.rate-hz: a cycle with the sensor at Rc2 takes");
    // 86 readings a second are simulated of these at Rc2 (docs/methods.md).
    assert_eq!(
        complaints(&config(|c| c.set("measure.method", "tracked").set("measure.rate-hz", 70))),
        Vec::<String>::new()
    );
    assert_eq!(complaints(&config(|c| c.set("measure.rate-hz", 10))), Vec::<String>::new());
}

#[test]
fn offsets_and_switches() {
    one_measure("offset = \"2 ms\"", "error: measure.offset: 2 ms is not between 0 and 1 ms");
    one_measure("offset = \"-1 us\"", "error: measure.offset: -1 us is not between");
    for fraction in ["0.0", "1.3", "-0.5", "nan"] {
        one_measure(
            &format!("switch-fraction = {fraction}"),
            "error: measure.switch-fraction: not between 0 and 1.3",
        );
    }
    // The paper's circuit: B follows A closely.
    fn paper(c: &mut ConfigFile) -> &mut ConfigFile {
        c.set("circuit.c-a", "330 nF").set("circuit.c-b", "22 nF").set("circuit.r-c1", "2.32 kohm")
    }
    one(
        |c| paper(c).set("measure.switch-fraction", 1.2).set("measure.offset", "8 us"),
        "warning: measure.switch-fraction: the last crossing comes at 1.116 of T_xA",
    );
    one(
        paper,
        "warning: measure.offset: \"auto\" splits a calibration discharge, and its part through Rc1 has only 41 us",
    );
    // Nothing is missing where the offset cancels.
    assert_eq!(complaints(&config(|c| paper(c).set("measure.method", "tcdic"))), [""; 0]);
}

#[test]
fn sockets() {
    let long = format!("/{}", "x".repeat(107));
    one(|c| c.set("server.socket", long), "error: server.socket: the path has 108 bytes, and 1 to 107");
    one(|c| c.set("server.socket", ""), "error: server.socket: the path has 0 bytes");
    one(|c| c.set("server.mode", "0666"), "warning: server.mode: \"0666\" lets everybody write");
    one(|c| c.set("server.mode", "060"), "warning: server.mode: \"0060\" keeps even the owner out");
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    /// Whatever passes can be planned with; whatever does not is refused without a panic.
    #[test]
    fn what_passes_can_be_planned(
        c_a in quantity("F", -12..-3), c_b in quantity("F", -12..-5),
        r_c1 in quantity("ohm", 0..5), r_c2 in quantity("ohm", 2..9),
        deadline in quantity("s", -4..2), method in prop_oneof![Just("cerm"), Just("tcdic"), Just("tpcm")],
    ) {
        let config = config(|c| {
            c.set("circuit.c-a", c_a).set("circuit.c-b", c_b).set("circuit.r-c1", r_c1).set("circuit.r-c2", r_c2);
            c.set("measure.method", method).set("measure.deadline", deadline)
        });
        if !config.check().has_errors() {
            let calibration = config.circuit.crossing(config.last_node(), config.circuit.r_c2);
            prop_assert!(calibration.is_some_and(|time| time.0 > 0.0 && time.0 <= config.deadline().as_seconds()));
            prop_assert!(config.charge_time() > Nanos::ZERO);
            prop_assert!(config.cycle(Seconds(0.0)).iter().all(|cycle| cycle.0.is_finite()));
        }
    }
}

/// A quantity of any sign and of any size between these powers of ten, as text.
fn quantity(unit: &'static str, powers: std::ops::Range<i32>) -> impl Strategy<Value = String> {
    (-0.5..10.0f64, powers).prop_map(move |(mantissa, power)| format!("{mantissa}e{power} {unit}"))
}

#[test]
fn a_discharge_too_short_to_be_timed_is_an_error() {
    let short = |c_f: &str| {
        let config = config_file::config(|c| {
            let c = c.one_capacitor("one-capacitor", c_f).set("circuit.r-c1", "300 ohm");
            c.set("gpio.backend", "mock").set("mock.scene", "pi4").channel("x")
        });
        complaints(&config.parse())
    };
    assert!(
        short("1 nF")[0].starts_with("error: circuit.c: the discharge through Rc1 takes"),
        "{:?}",
        short("1 nF")
    );
    assert!(!short("100 nF").iter().any(|text| text.contains("too short to be started")));
}

#[test]
fn a_priority_above_that_of_interrupts_is_warned_of() {
    one(|c| c.set("realtime.priority", 50), "warning: realtime.priority: 50 is not below 50");
    one(|c| c.set("realtime.priority", 99), "warning: realtime.priority: 99 is not below 50");
    assert!(complaints(&config(|c| c.set("realtime.priority", 49))).is_empty());
}
