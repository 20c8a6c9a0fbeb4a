//! `record --raw`, and `estimate` on good and bad tapes.

use super::daemon::{Daemon, config, ctl, json_lines, lines_of, scene};
use crate::waiting::until_so;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

const TAPE: &str = r#"{"class":"TAPE","proto_major":1,"circuit":{"kind":"two-capacitor","r_c1_ohm":2320,"r_c2_ohm":12700},"offset_ns":8000,"leak_siemens":[0,0],"leak_u_siemens":[0,0],"channels":[{"id":"thumb","force":{"fc1_n":5.75,"fc2_n":1.05}}]}
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
    // A tape that begins later than the daemon does not tell of the leak that had not been looked for yet.
    until_so("the first look for a leak is over", || daemon.stats()["cycles"].as_u64() > Some(40));
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

/// As the pages say it: recorded in the middle, read again by any method.
#[test]
fn a_tape_of_a_tracked_calibration_may_begin_at_any_time() {
    let daemon = Daemon::start_as(config().set("measure.method", "tracked"), &scene());
    until_so("a state", || daemon.stats()["offset_known"] == true);
    // Discharges that keep the state end at node A.
    let cycles = || daemon.stats()["cycles"].as_u64().unwrap();
    let since = cycles();
    until_so("the beginning is over", || cycles() > since + 300);
    let tape = daemon.path("tape");
    daemon.ctl(&["record", "--raw", "--count", "400", "-o", tape.to_str().unwrap()]).assert().success();
    for method in ["tracked", "cerm", "tcdic", "tpcm"] {
        let arguments = ["estimate", "--method", method, "--summary", "--json", tape.to_str().unwrap()];
        let rows = json_lines(&ctl(&arguments).assert().success().stderr("").get_output().stdout);
        for (row, truth) in rows.iter().zip([2000.0, 100.0]) {
            let of = |key: &str| row[key].as_f64().unwrap();
            assert!(of("n") > 10.0 && (of("r_mean_ohm") / truth - 1.0).abs() < 0.02, "{row}");
        }
    }

    let lines = std::fs::read_to_string(&tape).unwrap();
    // Discharges that nobody let go on to node B, as those of larger capacitors.
    let until_a = |line: &str| match line.split_once(",\"b_ns\":") {
        Some((begin, rest)) if line.contains("\"channel\":") => {
            format!("{begin}{}\n", &rest[rest.find([',', '}']).unwrap()..])
        }
        _ => format!("{line}\n"),
    };
    let until_a: String = lines.lines().map(until_a).collect();
    let rows = estimates("tracked", &["--summary", "--json"], &until_a);
    assert!(rows[0]["n"].as_u64() > Some(10), "{rows:?}");
    estimate("cerm", &["--summary"], &until_a).assert().code(1).stderr(
        "cermctl: standard input: no number: the discharges of this tape end at node A, and cerm needs node B, too; take \
         --method tracked, or record a cermd with method = \"cerm\"\n",
    );
    // What a tape of another origin lacks is said.
    let calibrations = |line: &&str| line.contains("TAPE") || line.contains("\"channel\"");
    let without: String = lines.lines().filter(calibrations).map(|line| format!("{line}\n")).collect();
    for method in ["tracked", "cerm"] {
        estimate(method, &["--summary"], &without).assert().code(1).stderr(format!(
            "cermctl: standard input: no number: the tape shows too few whole rounds of calibration discharges to follow the \
             calibration of {method} by; record it again, all of it: `cermctl record --raw` begins with them\n"
        ));
    }
}

#[test]
fn the_offset_is_the_tapes_or_the_one_given() {
    let value = |more: &[&str], tape: &str| estimates("cerm", more, tape)[1]["r_ohm"].as_f64().unwrap();
    let given = value(&["--offset", "8 us"], TAPE);
    assert_eq!(given, value(&[], TAPE));
    assert!((value(&["--offset", "0 s"], TAPE) - given).abs() > 1.0);
    let without = TAPE.replace("\"offset_ns\":8000,", "");
    // What needs it is a state, and the tape goes on.
    let lines = estimates("cerm", &[], &without);
    assert_eq!((&lines[0]["status"], &lines[1]["fault"]), (&"ok".into(), &"no-calibration".into()));
    let full = |line: &&str| !line.contains("\"seq\":3");
    let switched: String = without.lines().filter(full).map(|line| format!("{line}\n")).collect();
    estimate("cerm", &[], &switched).assert().code(1).stderr(
        "cermctl: standard input: cerm needs the latency offset, and the tape has neither offset_ns nor enough split \
         calibration discharges; give it with --offset, e.g. --offset \"8 us\"\n",
    );
    assert_eq!(estimates("tcdic", &[], &without).len(), 2);
    // A calibration that is followed takes none.
    estimate("tracked", &["--offset", "8 us"], TAPE).assert().code(1).stderr(
        "cermctl: standard input: the calibration of this tape is followed (tracked), and the latency offset with it: leave \
         --offset away\n",
    );
}

/// Of a tape of another origin: what nothing on it tells of is said, once, whatever is printed.
#[test]
fn a_tape_without_a_look_for_a_leak_says_so() {
    let without = TAPE.replace("\"leak_siemens\":[0,0],\"leak_u_siemens\":[0,0],", "");
    for more in [&[][..], &["--method", "tpcm", "--summary", "--json"]] {
        estimate("cerm", more, &without).assert().success().stderr(
            "cermctl: standard input: this tape shows no look for a leak: what one beside the sensor does is not in u \
             (docs/tapes.md)\n",
        );
    }
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
        (&TAPE[..100], "line 1: not the header of a tape"),
        (&swap(TAPE, 2, 3), "line 4: seq 2 comes after 3"),
        (&swap(TAPE, 0, 1), "line 1: not the header of a tape"),
        (
            &TAPE.replace("2320", "12700").replace("r_c2_ohm\":12700", "r_c2_ohm\":2320"),
            "line 1: r_c1_ohm = 12700 is not below",
        ),
        (
            &TAPE.replace("\"id\"", "\"zero_ohm\":1e12,\"id\""),
            "line 1: channel \"thumb\": zero_ohm = 1e12 is more than",
        ),
        (&TAPE.replace("650000", "null"), "line 4: a_ns is null: leave it out"),
        (&TAPE.replace("650000", "0"), "line 4: a_ns is 0;"),
        (&TAPE.replace("7756123", "-7756123"), "line 3: a_ns is -7756123;"),
        (&TAPE.replace("547250.0", "546000.0"), "line 5: switch.on_ns is before switch.at_ns"),
        (&TAPE.replace("\"seq\":3", "\"seq\":3,\"seq\":4"), "line 4: duplicate field"),
        (&TAPE.replace("650000", "65\"0"), "line 4: damaged ("),
        (&TAPE.replace("DISCHARGE", "READING"), "line 2: the class is \"READING\""),
        ("\u{0}\u{1}\u{2}", "line 1: not the header of a tape"),
    ];
    for (tape, wanted) in cases {
        let assert = estimate("cerm", &[], tape).assert().code(1);
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

#[test]
fn a_tape_that_ends_in_half_a_line_gives_all_before_it() {
    let assert = estimate("cerm", &[], &TAPE[..TAPE.len() - 40]).assert().success();
    let warning = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(
        warning.starts_with("cermctl: standard input: the tape is cut off in its last line: line 5: "),
        "{warning}"
    );
    let lines = json_lines(&assert.get_output().stdout);
    assert_eq!(lines, estimates("cerm", &[], TAPE)[..1]);
}

#[test]
fn a_tape_without_end_is_estimated_as_it_comes() {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_cermctl"))
        .args(["estimate", "--method", "tcdic", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
    let mut output = BufReader::new(output);
    for (index, line) in TAPE.lines().take(4).enumerate() {
        writeln!(input, "{line}").unwrap();
        if index == 3 {
            let mut estimate = String::new();
            output.read_line(&mut estimate).unwrap();
            assert!(estimate.contains("\"seq\":3"), "{estimate}");
        }
    }
    drop(input);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_summary_tells_each_channel_by_each_method() {
    let again = TAPE.replace("\"seq\":4", "\"seq\":5");
    let x = again.lines().nth(3).unwrap().replace("\"seq\":3", "\"seq\":4").replace("650000", "651000");
    let tape: String = again.lines().take(4).chain([x.as_str()]).map(|line| format!("{line}\n")).collect();
    let rows = estimates("cerm", &["--method", "tpcm", "--summary", "--json"], &tape);
    let each = estimates("tpcm", &[], &tape);
    let [a, b] = [0, 1].map(|index: usize| each[index]["r_ohm"].as_f64().unwrap());
    assert_eq!(rows.len(), 2);
    assert_eq!(
        (&rows[0]["method"], &rows[1]["method"], &rows[1]["n"]),
        (&"cerm".into(), &"tpcm".into(), &2.into())
    );
    assert!((rows[1]["r_mean_ohm"].as_f64().unwrap() - (a + b) / 2.0).abs() < 1e-3, "{rows:?}");
    assert!((rows[1]["r_sd_ohm"].as_f64().unwrap() / ((b - a).abs() / 2f64.sqrt()) - 1.0).abs() < 5e-3);
    let text = estimate("tpcm", &["--summary"], &tape).assert().success().get_output().stdout.clone();
    assert!(String::from_utf8(text).unwrap().starts_with("thumb  tpcm  n 2  mean "));
}

#[test]
fn a_tape_of_a_running_daemon_has_its_uncertainties_and_states() {
    let daemon = Daemon::start();
    until_so("the offset is found", || daemon.stats()["offset_known"] == true);
    let (tape, readings) = (daemon.path("tape"), daemon.path("readings"));
    let mut watch = daemon.spawn(&["record", "-o", readings.to_str().unwrap()]);
    until_so("readings are recorded", || std::fs::metadata(&readings).is_ok_and(|file| file.len() > 0));
    daemon.ctl(&["record", "--raw", "--count", "1600", "-o", tape.to_str().unwrap()]).assert().success();
    watch.interrupt();
    watch.end();
    let read: BTreeMap<i64, Value> =
        lines_of(&readings).into_iter().map(|line| (line["t_mono_ns"].as_i64().unwrap(), line)).collect();
    let output = ctl(&["estimate", "--method", "cerm", tape.to_str().unwrap()]).output().unwrap();
    let (mut ratios, mut within) = ([Vec::new(), Vec::new()], 0);
    // It begins in the middle of a cycle.
    let estimates = json_lines(&output.stdout).into_iter();
    for estimate in estimates.skip_while(|estimate| estimate["fault"] == "no-calibration") {
        let at = estimate["t_mono_ns"].as_i64().unwrap();
        // The last ones may come after the last reading.
        let Some((_, read)) = read.range(at - 1..=at + 1).next() else { continue };
        let names = ["channel", "status", "branch"].map(|name| (&estimate[name], &read[name]));
        assert!(names.iter().all(|(again, read)| again == read), "{read} {estimate}");
        let numbers = ["r_ohm", "r_u_ohm"].map(|name| estimate[name].as_f64().zip(read[name].as_f64()));
        // Until it knows the noise, a tape tells no uncertainty.
        if let [Some((r_ohm, read)), Some((u, read_u))] = numbers {
            within += usize::from((r_ohm - read).abs() < 0.2 * u);
            ratios[usize::from(estimate["branch"] == "inferred")].push(u / read_u);
        }
    }
    for (ratios, branch) in ratios.iter_mut().zip(["direct", "inferred"]) {
        assert!(ratios.len() > 200, "{branch}: {}", ratios.len());
        ratios.sort_unstable_by(f64::total_cmp);
        // What is learned of the noise from the discharges of a tape alone is known to about a tenth.
        let median = ratios[ratios.len() / 2];
        assert!((0.7..1.4).contains(&median), "{branch}: {median}");
    }
    let count = ratios[0].len() + ratios[1].len();
    assert!(within * 20 > count * 19, "{within} of {count}");
}
