//! The reports on a configuration that is wrong in one way or another.

use super::*;
use crate::config_file::ConfigFile;
use std::fs;

const FULL: &str = include_str!("../../config/tests_full.toml");

#[test]
fn a_file_that_is_not_there_gets_a_hint() {
    let report = check(Path::new("/nonexistent/cermd.toml"));
    assert!(!report.is_usable());
    insta::assert_snapshot!(report, @"error: /nonexistent/cermd.toml: No such file or directory (os error 2); `cermctl setup` writes one, --config names another, and `cermctl demo` needs none");
}

/// The report on FULL with a change, the file's folder left out.
fn rendered(change: impl FnOnce(&mut ConfigFile) -> &mut ConfigFile) -> (String, bool) {
    let mut config = ConfigFile::of(FULL);
    report_on(&change(&mut config).to_string())
}

fn report_on(config: &str) -> (String, bool) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cermd.toml");
    fs::write(&file, config).unwrap();
    fs::write(folder.path().join("index.csv"), "1.2,11122\n6.06,2200\n").unwrap();
    let report = check(&file);
    (report.to_string().replace(&format!("{}/", folder.path().display()), ""), report.is_usable())
}

#[test]
fn a_report_of_errors() {
    let (text, usable) = rendered(|c| c.set("circuit.r-c2", "1.27 kohm"));
    assert!(!usable);
    insta::assert_snapshot!(text, @r#"
    error: circuit.r-c1: 2.32 kohm is not below r-c2 = 1.27 kohm; try the lower resistor as r-c1
    error: channel.index.sink: missing; try the line that the sensor is wired to
    info: channel.thumb.force: it has no u: the data sheet of an FSR 402 stands in, 7.8 % (part to part 6 %, hysteresis 10 %); try `cermctl calibrate force`: it stores the residual of the sensor itself
    info: channel.index.zero-ohm: none: pins may differ by 8 ohm (1 sigma), and each uncertainty contains that; try `cermctl calibrate zero`
    info: channel.index.force: it has no u: the data sheet of an FSR 402 stands in, 7.8 % (part to part 6 %, hysteresis 10 %); try `cermctl calibrate force`: it stores the residual of the sensor itself
    cermd.toml: not usable: 2 error(s), 0 warning(s)
    "#);
}

#[test]
fn a_report_of_warnings() {
    let (text, usable) = rendered(|c| c.set("channel.index.sink", 17).set("measure.charge-time", "300 us"));
    assert!(usable);
    insta::assert_snapshot!(text, @r#"
    warning: circuit.r-charge: charging starts with 15.2 mA, above the 12 mA that a pin of pinctrl-rp1 may deliver; try at least "417 ohm", pin included
    info: channel.thumb.force: it has no u: the data sheet of an FSR 402 stands in, 7.8 % (part to part 6 %, hysteresis 10 %); try `cermctl calibrate force`: it stores the residual of the sensor itself
    info: channel.index.zero-ohm: none: pins may differ by 8 ohm (1 sigma), and each uncertainty contains that; try `cermctl calibrate zero`
    info: channel.index.force: it has no u: the data sheet of an FSR 402 stands in, 7.8 % (part to part 6 %, hysteresis 10 %); try `cermctl calibrate force`: it stores the residual of the sensor itself
    warning: measure.charge-time: 300 us is 1.8 time constants: the discharge before changes a reading by up to 229 of its u (at 62 kohm); try at least "1.6 ms", or without it
    info: circuit.r-c1: through Rc1, node A after 1.12 ms, node B after 1.89 ms
    info: circuit.r-c2: through Rc2, node A after 6.06 ms, node B after 10.2 ms
    info: measure.charge-time: 300 us (for B 775 us), as given, is 1.8 time constants: the discharge before changes a reading by up to 229 of its u (at 62 kohm)
    info: measure.deadline: 50 ms, enough for a sensor of 62.5 kohm
    info: measure.rate-hz: a cycle takes 35.7 ms (28 Hz) with the sensor at Rc2, 115 ms at most
    info: channel.thumb.on-above: 2 N: told 350 ms after it is so, or sooner, unless readings are faults
    info: channel.index.on-below: 5 kohm: told 170 ms after it is so, or sooner, unless readings are faults
    info: measure.method: cerm simulated, by calls and noise of the scene pi5: 100 ohm: no number, 1000 +- 69 ohm at 19.7 Hz (127 discharges a second), 10000 +- 154 ohm at 19.6 Hz (114 discharges a second), 50000 +- 742 ohm at 8.8 Hz (41 discharges a second)
    info: channel.thumb.force: at these resistances: 13.3 +- 1.4 N (readout 0.922 N), 1.33 +- 0.11 N (readout 0.0205 N), 0.267 +- 0.021 N (readout 0.00396 N)
    info: channel.index.force: at these resistances: 1.33 +- 0.11 N (readout 0.0204 N)
    cermd.toml: usable: 0 error(s), 2 warning(s)
    "#);
}

#[test]
fn a_report_of_a_refusal() {
    let (text, usable) = report_on(&FULL.replace("rate-hz", "rate"));
    assert!(!usable);
    insta::assert_snapshot!(text, @r#"
    error: cermd.toml: TOML parse error at line 24, column 1
       |
    24 | rate = 20
       | ^^^^
    unknown field `rate`, expected one of `method`, `rate-hz`, `average`, `idle`, `charge-time`, `settle-time`, `deadline`, `offset`, `resolution`, `calibration`, `t-l`, `switch-fraction`
    "#);
}

#[test]
fn the_shipped_configuration_is_good() {
    let report = check(&Path::new(env!("CARGO_MANIFEST_DIR")).join("hw/cermd.toml"));
    assert!(report.findings.0.iter().all(|finding| finding.severity == Severity::Info), "{report}");
}
