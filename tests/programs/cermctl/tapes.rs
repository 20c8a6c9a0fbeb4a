//! `record --raw`, and `estimate` on good and bad tapes.

use super::daemon::{Daemon, config, ctl, json_lines, lines_of, scene};
use crate::waiting::until_so;
use serde_json::Value;

const TAPE: &str = r#"{"class":"TAPE","proto_major":1,"circuit":{"kind":"two-capacitor","r_c1_ohm":2320,"r_c2_ohm":12700},"offset_ns":8000,"channels":[{"id":"thumb","force":{"fc1_n":5.75,"fc2_n":1.05}}]}
{"class":"DISCHARGE","seq":1,"through":"c1","a_ns":1440112,"b_ns":2598211}
{"class":"DISCHARGE","seq":2,"through":"c2","a_ns":7756123,"b_ns":13987001}
{"class":"DISCHARGE","seq":3,"channel":"thumb","through":"x","a_ns":650000,"b_ns":1170000}
{"class":"DISCHARGE","seq":4,"channel":"thumb","through":"x","switch":{"at_ns":547000.0,"on_ns":547250.0,"to":"c2"},"a_ns":1200000,"b_ns":7540000}
"#;

fn estimate(method: &str, more: &[&str], tape: &str) -> assert_cmd::Command {
    let mut command = ctl(&["estimate", "--method", method]);
    command.args(more).arg("-").write_stdin(tape);
    command
}

fn estimates(method: &str, more: &[&str], tape: &str) -> Vec<Value> {
    json_lines(&estimate(method, more, tape).assert().success().stderr("").get_output().stdout)
}

#[test]
fn a_tape_gives_the_readings_that_were_made_of_it() {
    // Given, because one that is found is also followed, and a tape has only one.
    let daemon = Daemon::start_as(config().set("measure.offset", "1 us"), &scene());
    let tape = daemon.path("tape");
    let readings = daemon.path("readings");
    // The readings begin before the tape and end after it.
    let mut watch = daemon.spawn(&["record", "-o", readings.to_str().unwrap()]);
    until_so("readings", || std::fs::metadata(&readings).is_ok_and(|file| file.len() > 0));
    daemon.ctl(&["record", "--raw", "--count", "400", "-o", tape.to_str().unwrap()]).assert().success();
    let last = daemon.stats()["published"].as_u64().unwrap();
    until_so("the readings of the tape", || {
        let text = std::fs::read_to_string(&readings).unwrap();
        text.lines()
            .filter_map(|line| serde_json::from_str::<Value>(line).ok())
            .any(|line| line["seq"].as_u64().unwrap() > last)
    });
    watch.interrupt();
    assert_eq!(watch.end(), (Some(0), String::new()));

    assert_eq!(lines_of(&tape)[0]["offset_ns"], 1000.0);
    let numbers = |lines: &[Value], class: &str| -> Vec<(String, String, f64)> {
        assert!(lines.iter().all(|line| line["class"] == class));
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let ok = lines.iter().filter(|line| line["status"] == "ok");
        ok.map(|line| (text(&line["channel"]), text(&line["branch"]), line["r_ohm"].as_f64().unwrap()))
            .collect()
    };
    let output = ctl(&["estimate", "--method", "cerm", tape.to_str().unwrap()]).output().unwrap();
    let estimated = numbers(&json_lines(&output.stdout), "ESTIMATE");
    let read = numbers(&lines_of(&readings), "READING");
    assert!(estimated.len() > 150 && read.len() > estimated.len(), "{} {}", estimated.len(), read.len());
    let same = |(a, b): (&(String, String, f64), &(String, String, f64))| {
        a.0 == b.0 && a.1 == b.1 && (a.2 / b.2 - 1.0).abs() < 1e-6
    };
    // Two streams of one instrument: somewhere in the readings, one for one, are the estimates.
    let found = read.windows(estimated.len()).any(|window| window.iter().zip(&estimated).all(same));
    assert!(found, "first estimates {:?}", &estimated[..4]);
    let inferred = estimated.iter().filter(|number| number.1 == "inferred").count();
    assert!(inferred > 50 && inferred < estimated.len(), "both branches occur: {inferred} inferred");
}

#[test]
fn a_tape_has_one_header_also_when_the_offset_is_found_meanwhile() {
    let daemon = Daemon::start();
    let tape = daemon.path("tape");
    let mut record = daemon.spawn(&["record", "--raw", "-o", tape.to_str().unwrap()]);
    until_so("an offset", || daemon.stats()["offset_known"] == true);
    let size = || std::fs::metadata(&tape).map_or(0, |file| file.len());
    let before = size();
    until_so("more tape", || size() > before + 10_000);
    record.interrupt();
    assert_eq!(record.end(), (Some(0), String::new()));
    let lines = lines_of(&tape);
    assert_eq!(lines[0]["class"], "TAPE");
    assert!(lines[1..].iter().all(|line| line["class"] == "DISCHARGE"));
    ctl(&["estimate", "--method", "tcdic", tape.to_str().unwrap()]).assert().success().stderr("");
}

#[test]
fn a_tape_that_begins_later_knows_the_offset_that_was_found() {
    let daemon = Daemon::start();
    until_so("an offset", || daemon.stats()["offset_known"] == true);
    let tape = daemon.path("tape");
    daemon.ctl(&["record", "--raw", "--count", "50", "-o", tape.to_str().unwrap()]).assert().success();
    let offset_ns = lines_of(&tape)[0]["offset_ns"].as_f64().unwrap();
    assert!((offset_ns - 1000.0).abs() < 50.0, "{offset_ns}");
    ctl(&["estimate", "--method", "cerm", tape.to_str().unwrap()]).assert().success().stderr("");
}

#[test]
fn the_offset_is_the_tapes_or_the_one_given() {
    let value = |more: &[&str], tape: &str| estimates("cerm", more, tape)[1]["r_ohm"].as_f64().unwrap();
    let given = value(&["--offset", "8 us"], TAPE);
    assert_eq!(given, value(&[], TAPE));
    assert!((value(&["--offset", "0 s"], TAPE) - given).abs() > 1.0);
    let without = TAPE.replace("\"offset_ns\":8000,", "");
    estimate("cerm", &[], &without).assert().code(1).stderr(
        "cermctl: standard input: cerm needs the latency offset, and the tape has neither offset_ns nor enough split \
         calibration discharges; give it with --offset, e.g. --offset \"8 us\"\n",
    );
    assert_eq!(estimates("tcdic", &[], &without).len(), 2);
}

#[test]
fn a_tape_without_split_discharges_has_no_tracked_calibration() {
    let lines = estimates("tracked", &[], TAPE);
    assert_eq!(lines[0]["status"], "ok", "a full discharge needs none");
    assert_eq!((&lines[1]["status"], &lines[1]["fault"]), (&"fault".into(), &"no-calibration".into()));
}

#[test]
fn a_missing_crossing_is_a_state_and_no_number() {
    let tape = TAPE.replace(",\"b_ns\":1170000", "");
    let lines = estimates("cerm", &[], &tape);
    assert_eq!((&lines[0]["status"], &lines[0]["fault"]), (&"fault".into(), &"missed-edge".into()));
    assert!(lines[0].get("r_ohm").is_none());
    assert_eq!(lines[1]["status"], "ok");
    let tape = TAPE.replace(",\"a_ns\":1440112,\"b_ns\":2598211", "");
    let lines = estimates("cerm", &[], &tape);
    assert!(lines.iter().all(|line| line["fault"] == "no-calibration"), "{lines:?}");
}

#[test]
fn a_crossing_before_the_switch_counts_as_direct() {
    let late = TAPE.replace("\"at_ns\":547000.0,\"on_ns\":547250.0", "\"at_ns\":1500000,\"on_ns\":1500250");
    let late = late.replace("\"a_ns\":1200000,\"b_ns\":7540000", "\"a_ns\":650000,\"b_ns\":1170000");
    let lines = estimates("cerm", &[], &late);
    assert_eq!((&lines[0]["r_ohm"], &lines[1]["branch"]), (&lines[1]["r_ohm"], &"direct".into()));
}

#[test]
fn bad_tapes_say_which_line() {
    let swap = |tape: &str, first: usize, second: usize| {
        let mut lines: Vec<&str> = tape.lines().collect();
        lines.swap(first, second);
        lines.join("\n")
    };
    let cases = [
        ("", "line 1: the tape is empty"),
        (&TAPE[..TAPE.len() - 40], "line 5: "),
        (&TAPE[..100], "line 1: not the header of a tape"),
        (&swap(TAPE, 2, 3), "line 4: seq 2 comes after 3"),
        (&swap(TAPE, 0, 1), "line 1: not the header of a tape"),
        (
            &TAPE.replace("2320", "12700").replace("r_c2_ohm\":12700", "r_c2_ohm\":2320"),
            "line 1: r_c1_ohm = 12700 is not below",
        ),
        (&TAPE.replace("650000", "0"), "line 4: a_ns is 0;"),
        (&TAPE.replace("7756123", "-7756123"), "line 3: a_ns is -7756123;"),
        (&TAPE.replace("547250.0", "546000.0"), "line 5: switch.on_ns is before switch.at_ns"),
        (&TAPE.replace("\"seq\":3", "\"seq\":3,\"seq\":4"), "line 4: duplicate field"),
        (&TAPE.replace("DISCHARGE", "READING"), "line 2: the class is \"READING\""),
        ("\u{0}\u{1}\u{2}", "line 1: not the header of a tape"),
    ];
    for (tape, wanted) in cases {
        let assert = estimate("cerm", &[], tape).assert().code(1).stdout("");
        let complaint = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        let begin = format!("cermctl: standard input: {wanted}");
        assert!(complaint.starts_with(&begin) && complaint.lines().count() == 1, "{wanted}: {complaint}");
    }
    estimate("qerm", &[], TAPE).assert().code(1).stderr(
        "cermctl: standard input: qerm does not work on a two-capacitor tape; take tpcm, tcdic, cerm or tracked\n",
    );
    let mut binary = ctl(&["estimate", "--method", "cerm", "-"]);
    binary.write_stdin(vec![0xff, 0xfe]).assert().code(1);
}
