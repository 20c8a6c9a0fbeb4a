//! `characterize`: a folder that grows, whatever interrupts it.

use super::daemon::{Daemon, ctl};
use crate::waiting::until_so;
use cermd::characterize::table::{self, Row, Source};
use cermd::reading::Method;
use serde_json::Value;
use std::fs;
use std::path::Path;

const SMALL: [&str; 9] =
    ["characterize", "--scene", "pi4", "--circuit", "two", "--method", "tcdic,tracked", "--instruments", "2"];

fn small(folder: &Path, more: &[&str]) -> assert_cmd::Command {
    let mut command = ctl(&SMALL);
    command.args(more).arg("--out").arg(folder);
    command
}

fn rows(folder: &Path) -> Vec<Row> {
    table::read(&fs::read_to_string(folder.join("points.csv")).unwrap()).unwrap()
}

fn complaint(command: &mut assert_cmd::Command) -> String {
    String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap()
}

#[test]
fn a_sweep_is_a_table_with_its_provenance_and_is_not_measured_twice() {
    let folder = tempfile::tempdir().unwrap();
    let asked = ["--r", "100 ohm,1000", "--average", "0 s,100 ms"];
    small(folder.path(), &asked).assert().success().stderr("");
    let first = rows(folder.path());
    let cells: Vec<_> = first.iter().map(|row| (row.method, row.average_s, row.r_ohm)).collect();
    let expected = [Method::Tcdic, Method::Tracked].into_iter().flat_map(|method| {
        [None, Some(0.1)].into_iter().flat_map(move |mean| [100.0, 1000.0].map(|r_ohm| (method, mean, r_ohm)))
    });
    assert_eq!(cells, expected.collect::<Vec<_>>());
    for row in &first {
        let parts = [row.charge_s, row.discharge_s, row.calibration_s, row.overhead_s].map(Option::unwrap);
        let whole = row.published_s.unwrap();
        assert!((parts.iter().sum::<f64>() / whole - 1.0).abs() < 1e-4, "{row:?}");
        assert!(row.rms_ohm.unwrap() < 3.0 * row.u_ohm.unwrap(), "{row:?}");
    }
    let text = fs::read_to_string(folder.path().join("provenance.json")).unwrap();
    let provenance: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((provenance["source"].as_str(), provenance["seed"].as_u64()), (Some("simulated"), Some(1)));
    assert!(provenance["command"].as_str().unwrap().starts_with("cermctl characterize --scene pi4 "));
    assert!(provenance["text"].as_str().unwrap().contains("Raspberry Pi 4"));

    // What is there stays, and what is not is added.
    let points = folder.path().join("points.csv");
    let mark = fs::read_to_string(&points).unwrap().replace(&first[0].rms_ohm.unwrap().to_string(), "1234.5");
    fs::write(&points, mark).unwrap();
    small(folder.path(), &["--r", "100,470", "--average", "0 s"]).assert().success().stderr("");
    let second = rows(folder.path());
    assert_eq!(second.len(), first.len() + 2);
    assert_eq!(second.iter().filter(|row| row.rms_ohm == Some(1234.5)).count(), 1);

    let said = complaint(&mut small(folder.path(), &["--r", "100", "--seed", "2"]));
    assert!(said.contains("the table there has seed 1, not 2; name another folder"), "{said}");
    let said = complaint(ctl(&["characterize", "--scene", "pi5", "--out"]).arg(folder.path()));
    assert!(said.contains("the table there has board pi4, not pi5"), "{said}");
}

#[test]
fn a_sweep_that_is_stopped_goes_on_and_ends_as_if_nothing_had_been() {
    let folder = tempfile::tempdir().unwrap();
    let [stopped, whole] = ["stopped", "whole"].map(|name| folder.path().join(name));
    let asked = ["--r", "100,200,300,500,1000,2000,3000,5000", "--average", "0 s,50 ms,100 ms"];
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_cermctl"))
        .args(SMALL)
        .args(asked)
        .arg("--out")
        .arg(&stopped)
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let lines = || fs::read_to_string(stopped.join("points.csv")).unwrap_or_default().lines().count();
    until_so("some rows", || lines() > 3);
    let pid = nix::unistd::Pid::from_raw(child.id() as i32);
    nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGINT).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let said = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    assert!(said.contains(" of 48 points are in ") && said.contains("the same command goes on"), "{said}");
    let before = rows(&stopped).len();
    assert!((3..48).contains(&before), "{before}");
    small(&stopped, &asked).assert().success();
    small(&whole, &asked).assert().success();
    assert_eq!(rows(&stopped), rows(&whole));
}

#[test]
fn what_cannot_be_is_said_before_anything_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("report");
    let run = |arguments: &[&str]| {
        let mut command = ctl(&["characterize"]);
        command.args(arguments).arg("--out").arg(&out);
        command
    };
    for (arguments, says) in [
        (&["--scene", "pi9"][..], "there is no built-in scene \"pi9\""),
        (&["--scene", "missing.toml"], "cannot read missing.toml"),
        (&["--circuit", "one", "--method", "qerm"], "none of these works on these circuits"),
        (&["--config", "missing.toml"], "--config names another"),
        (&["--tape", "missing", "--truth", "x=1"], "is the path right"),
    ] {
        let said = complaint(&mut run(arguments));
        assert!(said.contains(says), "{arguments:?}: {said}");
        assert!(!out.exists(), "{arguments:?}");
    }
    for arguments in
        [&["--r", "0"][..], &["--average", "2 min"], &["--truth", "x=1"], &["--instruments", "0"]]
    {
        run(arguments).assert().code(2);
    }
    // A file where the folder is to be.
    fs::write(&out, "").unwrap();
    let said = complaint(&mut small(&out, &["--r", "100"]));
    assert!(said.contains("a folder is wanted, and that is a file"), "{said}");
}

#[test]
fn a_tape_is_judged_by_what_its_recorder_knew() {
    let daemon = Daemon::start();
    until_so("an offset", || daemon.stats()["offset_known"] == true);
    let tape = daemon.path("bench.tape");
    daemon.ctl(&["record", "--raw", "--count", "1200", "-o", tape.to_str().unwrap()]).assert().success();
    let out = daemon.path("report");
    let run = |truth: &str| {
        let mut command = ctl(&["characterize", "--tape", tape.to_str().unwrap(), "--truth", truth]);
        command.arg("--out").arg(&out);
        command
    };
    let said = complaint(&mut run("middle=2000"));
    assert!(said.contains("no channel \"middle\": there is thumb, index"), "{said}");
    let said = complaint(run("thumb=1 kohm").args(["--truth", "thumb=2 kohm"]));
    assert!(said.contains("--truth names thumb twice") && !out.exists(), "{said}");
    run("index=2 kohm").assert().success();
    let first = rows(&out);
    let cerm = first.iter().find(|row| row.method == Method::Cerm && row.average_s.is_none()).unwrap();
    assert_eq!((cerm.source, cerm.r_ohm, cerm.scene.as_str()), (Source::Tape, 2000.0, "bench, index"));
    assert!(cerm.readings > 200 && cerm.rms_ohm.unwrap() < 20.0, "{cerm:?}");
    // A hundred a second.
    assert!((0.009..0.02).contains(&cerm.published_s.unwrap()), "{cerm:?}");
    let mean = first.iter().find(|row| row.method == Method::Cerm && row.average_s == Some(0.1)).unwrap();
    assert!(mean.rms_ohm.unwrap() < cerm.rms_ohm.unwrap(), "{mean:?} {cerm:?}");
    // Another channel with the same resistor is another question.
    run("thumb=2 kohm").assert().success();
    assert!(rows(&out).iter().any(|row| row.scene == "bench, thumb"));
    // Another tape of the same name is not taken for the first.
    let text = fs::read_to_string(&tape).unwrap();
    fs::write(&tape, text.lines().take(1000).flat_map(|line| [line, "\n"]).collect::<String>()).unwrap();
    let said = complaint(&mut run("index=2 kohm"));
    assert!(said.contains("the table there has another scene, configuration or tape"), "{said}");
}
