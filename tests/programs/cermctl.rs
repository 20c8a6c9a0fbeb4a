//! `cermctl` as a person or a script meets it: the real program, a real daemon on a simulated circuit, a real socket.
//!
//! No test depends on how fast anything is; every wait ends.

mod characterize;
pub mod daemon;
mod errors;
mod tapes;
pub mod terminal;

use crate::waiting::until_so;
use daemon::{Daemon, config, ctl, json_lines, lines_of, scene};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};

/// What a verb prints; it must succeed and have nothing to complain of.
fn output(command: &mut assert_cmd::Command) -> String {
    let assert = command.assert().success().stderr("");
    String::from_utf8(assert.get_output().stdout.clone()).unwrap()
}

#[test]
fn get_prints_the_last_reading_of_each_channel() {
    let daemon = Daemon::start();
    until_so("a reading that has settled", || !output(&mut daemon.ctl(&["get"])).contains("settling"));
    let text = output(&mut daemon.ctl(&["get"]));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2, "{text}");
    assert!(
        // 100 ohm are 133 N, beyond what its characteristic is said of.
        lines[0].contains("thumb") && lines[0].contains(" N  ") && lines[0].contains("ohm  extrapolated"),
        "{text}"
    );
    assert!(lines[1].contains("index") && !lines[1].contains(" N "), "a channel without force: {text}");
    let of_index = json_lines(output(&mut daemon.ctl(&["get", "--json", "index"])).as_bytes());
    assert_eq!(of_index.len(), 1);
    assert_eq!((&of_index[0]["class"], &of_index[0]["channel"]), (&"READING".into(), &"index".into()));
    let r_ohm = of_index[0]["r_ohm"].as_f64().unwrap();
    assert!((r_ohm - 2000.0).abs() < 20.0, "{r_ohm}");
}

#[test]
fn stats_are_a_table_for_people_and_a_line_for_machines() {
    let daemon = Daemon::start();
    until_so("an offset", || daemon.stats()["offset_known"] == true);
    let text = output(&mut daemon.ctl(&["stats"]));
    for wanted in [
        "backend ",
        "mock\n",
        "uptime ",
        " s\n",
        "latency offset ",
        " us\n",
        "pin resistance",
        " +- ",
        " ohm\n",
    ] {
        assert!(text.contains(wanted), "{wanted:?} is missing:\n{text}");
    }
}

#[test]
fn watch_prints_lines_into_a_pipe_and_ends_quietly_when_it_closes() {
    let daemon = Daemon::start();
    for arguments in [["watch", "index"].as_slice(), &["watch", "--json", "index"]] {
        let mut watch = daemon.spawn(arguments);
        let mut lines = BufReader::new(watch.child().stdout.take().unwrap()).lines();
        let first = lines.next().unwrap().unwrap();
        assert!(first.contains("index") && !first.contains('\x1b'), "{first}");
        drop(lines);
        assert_eq!(watch.end(), (Some(0), String::new()));
    }
}

#[test]
fn what_readings_come_to_is_said_afterwards() {
    let daemon = Daemon::start();
    let mut watch = daemon.spawn(&["watch", "index"]);
    let mut lines = BufReader::new(watch.child().stdout.take().unwrap()).lines().map(Result::unwrap);
    assert_eq!(lines.by_ref().take(20).count(), 20);
    watch.interrupt();
    let last = lines.last().unwrap();
    assert!(last.starts_with(" index: ") && last.contains(" ok") && last.ends_with(" ohm rms"), "{last}");
    assert_eq!(watch.end(), (Some(0), String::new()));
    // Of the last seconds, by the daemon: readings every 10 ms, or later where the machine has no time for it.
    let index = &daemon.stats()["channels"]["index"];
    let [readings, span_s] = ["readings", "span_s"].map(|key| index[key].as_f64().unwrap());
    let rate_hz = index["rate_hz"].as_f64().unwrap();
    assert!((rate_hz - (readings - 1.0) / span_s).abs() < 0.01 && rate_hz < 101.0, "{index}");
    let u_ohm = index["r_u_ohm"].as_f64().unwrap();
    assert!((0.001..100.0).contains(&u_ohm) && index["ok"].as_f64() == Some(readings), "{index}");
    let stats = output(&mut daemon.ctl(&["stats"]));
    assert!(stats.contains("channel index ") && stats.contains("/s, 100 % ok"), "{stats}");
}

#[test]
fn a_fault_says_what_to_look_at() {
    let daemon = Daemon::start_as(&config(), scene().set("circuit.r-c2", "100 Mohm"));
    let hint =
        "nothing falls in a discharge through Rc2; look at the wire from sink-c2 through Rc2 to node A";
    let stdout = daemon.ctl(&["get", "thumb"]).assert().success().get_output().stdout.clone();
    let text = String::from_utf8(stdout).unwrap();
    assert!(text.contains("no-calibration  fault") && text.contains(hint), "{text}");
    until_so("STATS that have it", || {
        daemon.stats()["hint"].as_str().is_some_and(|text| text.starts_with(hint))
    });
}

#[test]
fn watch_chooses_and_thins() {
    let daemon = Daemon::start();
    let mut watch = daemon.spawn(&["watch", "--json", "--max-hz", "10", "index"]);
    let lines = BufReader::new(watch.child().stdout.take().unwrap()).lines();
    let mut stamps = lines.map(|line| -> i64 {
        let line: Value = serde_json::from_str(&line.unwrap()).unwrap();
        assert_eq!(line["channel"], "index");
        line["t_mono_ns"].as_i64().unwrap()
    });
    // Until the daemon knows of the limit, readings come every 10 ms, or later where the machine has no time for it.
    let mut last = stamps.next().unwrap();
    let mut in_a_row = 0;
    let is_thinned = stamps.take(10_000).any(|stamp| {
        // Nine cycles; a stamp is that of the middle of a discharge.
        let is_far = stamp - std::mem::replace(&mut last, stamp) > 89_900_000;
        in_a_row = if is_far { in_a_row + 1 } else { 0 };
        in_a_row == 5
    });
    assert!(is_thinned);
}

#[test]
fn watch_survives_a_restart_of_the_daemon() {
    let mut daemon = Daemon::start();
    let mut watch = daemon.spawn(&["watch"]);
    let mut lines = BufReader::new(watch.child().stdout.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().contains("ohm"));
    daemon.kill();
    let mut complaints = BufReader::new(watch.child().stderr.take().unwrap()).lines();
    let gone = complaints.next().unwrap().unwrap();
    assert_eq!(gone, "cermctl: cermd closed the connection; waiting for it to come back");
    daemon.run();
    assert_eq!(complaints.next().unwrap().unwrap(), "cermctl: connected again");
    // What was in the pipe is behind us after so many lines.
    assert_eq!(lines.by_ref().take(50).filter(|line| line.is_ok()).count(), 50);
    watch.interrupt();
    // Read on, or it cannot end for a full pipe.
    lines.for_each(drop);
    assert_eq!(watch.end(), (Some(0), String::new()));
}

#[test]
fn record_writes_csv_with_nothing_for_the_unknown() {
    let daemon = Daemon::start();
    let text = output(&mut daemon.ctl(&["record", "--count", "6", "--format", "csv", "index"]));
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 7, "{text}");
    assert!(rows.iter().all(|row| row.len() == 28), "{text}");
    let column = |name: &str| rows[0].iter().position(|column| *column == name).unwrap();
    for row in &rows[1..] {
        assert_eq!((row[column("channel")], row[column("f_n")], row[column("fault")]), ("index", "", ""));
        assert!(row[column("r_ohm")].parse::<f64>().unwrap() > 1900.0, "{text}");
    }
}

#[test]
fn record_ends_with_a_whole_line_whatever_ends_it() {
    let daemon = Daemon::start();
    let file = daemon.path("by-count");
    output(&mut daemon.ctl(&["record", "--count", "5", "--output", file.to_str().unwrap()]));
    assert_eq!(lines_of(&file).len(), 5);

    let file = daemon.path("by-time");
    output(&mut daemon.ctl(&["record", "--seconds", "0.5", "-o", file.to_str().unwrap()]));
    assert!(lines_of(&file).iter().all(|line| line["class"] == "READING"));

    let file = daemon.path("by-ctrl-c");
    let mut record = daemon.spawn(&["record", "-o", file.to_str().unwrap()]);
    until_so("a recording", || fs::metadata(&file).is_ok_and(|file| file.len() > 2000));
    record.interrupt();
    assert_eq!(record.end(), (Some(0), String::new()));
    assert!(lines_of(&file).len() > 5);
}

/// The limit of a file's size stands for a disk that is full: as there, the last write is cut short, and the next one fails.
#[test]
fn a_recording_without_room_ends_with_a_whole_line() {
    let daemon = Daemon::start();
    for (format, name) in [("--raw", "tape"), ("--format=ndjson", "lines"), ("--format=csv", "table")] {
        let file = daemon.path(name);
        let script = "ulimit -f 16; trap '' XFSZ; exec \"$0\" record --output \"$1\" \"$2\"";
        let mut command = std::process::Command::new("sh");
        command.args(["-c", script, env!("CARGO_BIN_EXE_cermctl")]).arg(&file).arg(format);
        let ended = command.env("CERMD_SOCKET", daemon.socket()).output().unwrap();
        let complaint = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(1), "{complaint}");
        assert!(complaint.contains(file.to_str().unwrap()) && complaint.contains("too large"), "{complaint}");
        let text = fs::read_to_string(&file).unwrap();
        let last = text.lines().last().unwrap();
        assert!(text.len() > 4096 && text.ends_with('\n'), "{name} ends with {last}");
        let rest = if name == "table" { last.split(',').count() == 28 } else { last.ends_with('}') };
        assert!(rest, "{last}");
    }
}

#[test]
fn a_recording_says_when_the_daemon_ends_it() {
    let mut daemon = Daemon::start();
    let file = daemon.path("cut");
    let record = daemon.spawn(&["record", "-o", file.to_str().unwrap()]);
    until_so("a recording", || fs::metadata(&file).is_ok_and(|file| file.len() > 2000));
    daemon.kill();
    let (status, complaint) = record.end();
    assert_eq!(status, Some(1));
    assert_eq!(complaint, "cermctl: the recording ends here: cermd closed the connection\n");
    assert!(lines_of(&file).len() > 5);
}

#[test]
fn both_checks_say_the_same() {
    let daemon = Daemon::start();
    let cases = [
        ("measure", "rate-hz = 100", 0, ": usable: 0 error(s)"),
        ("mock", "scene = \"missing.toml\"", 1, "error: mock.scene: cannot read "),
        ("mock", "scene = \"pi9\"", 1, "there is no built-in scene \"pi9\"; there are ideal,"),
        ("channel.thumb", "force = { table = \"t.csv\" }", 1, "error: channel.thumb.force: "),
        ("circuit", "r-c1 = \"12.7 kohm\"", 1, "error: circuit.r-c1"),
        ("measure", "rate-hertz = 100", 1, "unknown field `rate-hertz`"),
    ];
    for (table, line, status, wanted) in cases {
        let file = daemon.path("checked.toml");
        fs::write(&file, config().lines(table, line).to_string()).unwrap();
        let ours = ctl(&["check", "--config", file.to_str().unwrap()]).assert().code(status);
        let ours = String::from_utf8(ours.get_output().stdout.clone()).unwrap();
        assert!(ours.contains(wanted), "{wanted}\n{ours}");
        let mut theirs = assert_cmd::Command::new(env!("CARGO_BIN_EXE_cermd"));
        // What it costs the processor is measured anew each time.
        let both = ours.split("\nTo be expected of one processor: ").next().unwrap().to_owned();
        assert!(status == 1 || both.len() < ours.len(), "{ours}");
        theirs.arg("--config").arg(&file).arg("--check").assert().code(status).stdout(both);
    }
}

#[test]
fn the_demo_needs_nothing_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = output(ctl(&["demo", "--seconds", "2", "--seed", "7"]).env("TMPDIR", folder.path()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    assert!(!text.contains('\x1b'), "{text}");
    let live: Vec<&str> = text.lines().filter(|line| line.starts_with("simulated  ")).collect();
    assert!(!live.is_empty() && live.iter().all(|line| line.contains("thumb")), "{text}");
    let summary = text.lines().filter(|line| !line.starts_with("simulated  "));
    assert!(summary.clone().all(|line| line.chars().count() <= 80), "wider than a terminal:\n{text}");
    for wanted in [
        "board pi4, method tracked",
        " readings in ",
        "latency offset",
        "8.00 us true",
        "40.0 ohm true",
        "cermctl check",
    ] {
        assert!(text.contains(wanted), "{wanted:?} is missing:\n{text}");
    }
}

#[test]
fn the_demo_ends_properly_at_ctrl_c() {
    let folder = tempfile::tempdir().unwrap();
    let mut demo = std::process::Command::new(env!("CARGO_BIN_EXE_cermctl"))
        .args(["demo", "--seconds", "3600", "--scene", "ideal", "--method", "tcdic"])
        .env("TMPDIR", folder.path())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(demo.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("thumb")));
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(demo.id() as i32), nix::sys::signal::SIGINT).unwrap();
    assert!(lines.any(|line| line.contains(" readings in ")), "a summary");
    // In this method the offset cancels: as long as it is not found nobody misses it.
    lines.for_each(|line| assert!(!line.contains("latency offset"), "{line}"));
    assert!(demo.wait().unwrap().success());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_demo_runs_every_board_by_every_method_it_allows() {
    for (scene, method) in [("pi5", "qerm"), ("pi-zero", "tpcm"), ("fpga-paper", "cerm")] {
        let text = output(&mut ctl(&["demo", "--seconds", "0.5", "--scene", scene, "--method", method]));
        assert!(text.contains(&format!("board {scene}, method {method}")), "{text}");
    }
}

#[test]
fn the_demo_runs_on_one_capacitor() {
    let text = output(&mut ctl(&["demo", "--seconds", "4", "--wiring", "one"]));
    assert!(text.contains("board pi4, method tracked") && text.contains(" one-capacitor, a hand"), "{text}");
    let numbers = text.split(" numbers").next().and_then(|text| text.rsplit(' ').next());
    assert!(numbers.and_then(|count| count.parse().ok()).is_some_and(|count: usize| count > 10), "{text}");
    // Which has no second node for this.
    let error = ctl(&["demo", "--wiring", "one", "--method", "tcdic"]).assert().failure();
    let error = String::from_utf8_lossy(&error.get_output().stderr).into_owned();
    assert!(error.contains("needs kind = \"two-capacitor\""), "{error}");
}
