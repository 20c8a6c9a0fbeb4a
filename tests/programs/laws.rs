//! Sensors beside force, with the real programs: what the daemon says of a thermistor and a slider, and what is made of that.

use crate::cermctl::daemon::{Daemon, config, ctl, json_lines, lines_of, scene};
use crate::waiting::until_so;
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::net::UnixStream;
use std::path::Path;

/// A thermistor of 2 kohm, and a slider that stands at a fifth of its way; both are read once a cycle.
fn daemon() -> Daemon {
    let mut config = config();
    config.unset(&["channel.thumb.force"]);
    config.lines(
        "channel.thumb",
        r#"law = { kind = "position", r0 = "0 ohm", r1 = "500 ohm", span = "100 mm" }"#,
    );
    let ntc = r#"law = { kind = "ntc", r25 = "5 kohm", beta = "3950 K", u = "1 %", beta-u = "1 %" }"#;
    config.lines("channel.index", ntc).set("measure.offset", "1 us");
    Daemon::start_as(&config, &scene())
}

/// By the equation that the page has.
fn degc(r_ohm: f64) -> f64 {
    1.0 / (1.0 / 298.15 + (r_ohm / 5000.0).ln() / 3950.0) - 273.15
}

fn number(line: &Value, key: &str) -> f64 {
    line[key].as_f64().unwrap_or_else(|| panic!("{key} of {line}"))
}

#[test]
fn a_thermistor_is_a_temperature_in_all_that_is_said() {
    let daemon = daemon();
    let socket = BufReader::new(UnixStream::connect(daemon.socket()).unwrap());
    let mut lines = socket.lines().map(|line| -> Value { serde_json::from_str(&line.unwrap()).unwrap() });
    let version = lines.next().unwrap();
    assert_eq!(version["channels"][0]["unit"], "mm");
    assert_eq!(version["channels"][1]["unit"], "degC");
    let settled =
        |line: &Value| line["channel"] == "index" && line["settling"] != true && line["moving"] != true;
    for line in lines.filter(settled).take(50) {
        assert_eq!((line["status"].as_str(), line["unit"].as_str()), (Some("ok"), Some("degC")), "{line}");
        assert!(line.get("f_n").is_none() && line.get("extrapolated").is_none(), "{line}");
        let (value, r_ohm, slope) =
            (number(&line, "value"), number(&line, "r_ohm"), (320.3f64).powi(2) / 3950.0 / 2000.0);
        // The stream has seven digits of each.
        assert!((value - degc(r_ohm)).abs() < 1e-4, "{line}");
        let [u, repeat_u, r_u_ohm] = ["value_u", "value_repeat_u", "r_u_ohm"].map(|key| number(&line, key));
        assert!((repeat_u / (r_u_ohm * slope) - 1.0).abs() < 0.02, "{line}");
        // 1 % of R_25 and of beta: 0.26 K, and 0.24 K more at 0.4 R_25.
        assert!((u / repeat_u.hypot(0.260).hypot(0.238) - 1.0).abs() < 0.02, "{line}");
        assert!((value - degc(2000.0)).abs() < 5.0 * repeat_u + 0.05, "{line}");
    }
}

#[test]
fn people_and_tapes_get_the_same_values() {
    let daemon = daemon();
    let text = |arguments: &[&str]| {
        let assert = daemon.ctl(arguments).assert().success().stderr("");
        String::from_utf8(assert.get_output().stdout.clone()).unwrap()
    };
    until_so("readings that have settled", || !text(&["get"]).contains("settling"));
    let get = text(&["get"]);
    assert!(get.contains(" +- ") && get.contains(" degC  ") && get.contains(" mm  "), "{get}");
    until_so("figures of values", || text(&["stats"]).contains(" degC rms"));

    let csv = text(&["record", "--count", "3", "--format", "csv", "index"]);
    let rows: Vec<Vec<&str>> = csv.lines().map(|row| row.split(',').collect()).collect();
    let cell = |row: usize, name: &str| rows[row][rows[0].iter().position(|column| *column == name).unwrap()];
    assert_eq!((cell(3, "unit"), cell(3, "f_n"), cell(3, "value_max")), ("degC", "", ""));
    let [r_ohm, value] = ["r_ohm", "value"].map(|name| cell(3, name).parse::<f64>().unwrap());
    assert!((value - degc(r_ohm)).abs() < 1e-4, "{csv}");

    let tape = daemon.path("tape");
    text(&["record", "--raw", "--count", "400", "-o", tape.to_str().unwrap()]);
    assert_eq!(lines_of(&tape)[0]["channels"][1]["law"]["kind"], "ntc");
    let output = ctl(&["estimate", "--method", "cerm", tape.to_str().unwrap()]).output().unwrap();
    let estimates = json_lines(&output.stdout);
    let (mut temperatures, mut places) = (0, 0);
    // In the first rounds u is a wide prior, which 100 ohm may not be told from 0 by: no value then.
    let is_settled = |line: &&Value| line["status"] == "ok" && line["settling"] != true;
    for line in estimates.iter().filter(is_settled) {
        let (value, r_ohm) = (number(line, "value"), number(line, "r_ohm"));
        if line["channel"] == "index" {
            assert!((value - degc(r_ohm)).abs() < 1e-4 && line["unit"] == "degC", "{line}");
            temperatures += 1;
        } else {
            // Nobody has said how good the slider is.
            assert!((value - r_ohm / 5.0).abs() < 1e-3 && line.get("value_u").is_none(), "{line}");
            places += 1;
        }
    }
    assert!(temperatures > 5 && places > 5, "{temperatures} {places}");
}

#[test]
fn a_sensor_that_is_not_there_has_a_bound_by_its_law() {
    let mut config = config();
    config.unset(&["channel.thumb.force"]).set("measure.offset", "1 us");
    config.lines(
        "channel.thumb",
        r#"law = { kind = "position", r0 = "0 ohm", r1 = "5 kohm", span = "100 mm" }"#,
    );
    config.lines("channel.index", r#"law = { kind = "ntc", r25 = "5 kohm", beta = "3950 K" }"#);
    let mut scene = scene();
    scene.set("sensor.0.constant", "100 Mohm").set("sensor.1.constant", "100 Mohm");
    let daemon = Daemon::start_as(&config, &scene);
    let of = |channel: &str| {
        let output = daemon.ctl(&["get", "--json", channel]).output().unwrap();
        json_lines(&output.stdout).remove(0)
    };
    until_so("open", || ["thumb", "index"].iter().all(|channel| of(channel)["status"] == "open"));
    let (slider, thermistor) = (of("thumb"), of("index"));
    let bound = number(&thermistor, "r_min_ohm");
    assert!((number(&thermistor, "value_max") - degc(bound)).abs() < 1e-3, "{thermistor}");
    assert!(
        (number(&slider, "value_min") / number(&slider, "r_min_ohm") * 50.0 - 1.0).abs() < 1e-5,
        "{slider}"
    );
    assert!(thermistor.get("value_min").is_none() && slider.get("value_max").is_none());
    let text = String::from_utf8(daemon.ctl(&["get"]).output().unwrap().stdout).unwrap();
    assert!(text.contains(" degC  > ") && text.contains("< ") && text.contains(" mm  > "), "{text}");
}

/// The lines of docs/sensors.md, from its own configuration. `UPDATE_DOCS=1 cargo test --test programs laws` writes them anew.
#[test]
fn the_worked_example_is_what_check_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = root.join("docs/sensors.md");
    let text = fs::read_to_string(&page).unwrap();
    let config = text.split("```toml\n").find(|block| block.starts_with("[circuit]")).unwrap();
    let scene = fs::read_to_string(root.join("hw/scenes/pi4.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("cermd.toml", config.split("```").next().unwrap());
    let constant = scene.lines().find(|line| line.starts_with("constant = ")).unwrap();
    write("scene.toml", &scene.replace(constant, "constant = \"8.06 kohm\""));
    let path = folder.path().join("cermd.toml");
    let output = ctl(&["check", "--config", path.to_str().unwrap()]).assert().success().get_output().clone();
    let said = String::from_utf8(output.stdout).unwrap();
    let line_of =
        |text: &str, begin: &str| text.lines().find(|line| line.starts_with(begin)).unwrap().to_owned();
    let mut new = text.clone();
    for begin in ["info: measure.method: ", "info: channel.bath.law: "] {
        new = new.replace(&line_of(&text, begin), &line_of(&said, begin));
    }
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(&page, &new).unwrap();
    }
    assert_eq!(text, new, "docs/sensors.md is out of date");
}
