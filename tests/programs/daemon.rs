//! The daemon as its users and the service manager see it: the real program, a simulated circuit, real signals.

mod crowd;
mod held;
mod killed;
pub mod process;
mod socket;

use crate::common::config::ConfigFile;
use crate::waiting::until_so;
use nix::sys::signal::Signal;
use process::{Daemon, Home, config, program};
use serde_json::{Value, json};
use std::fs::{self, File};
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::UnixDatagram;
use std::process::Stdio;

const FAST: &str = "offset = \"8 us\"";

fn ids(version: &Value) -> Vec<&str> {
    version["channels"].as_array().unwrap().iter().map(|channel| channel["id"].as_str().unwrap()).collect()
}

#[test]
fn serves_readings_and_statistics() {
    let home = Home::new(&config(&["thumb", "index"], FAST));
    let _daemon = home.start();
    let mut stream = home.connect();
    assert_eq!(ids(&stream.next().unwrap()), ["thumb", "index"]);
    // The scene has one sensor of 1 kohm, on the first channel; the other is open. A stamp may be late now and then.
    let mut numbers = 0;
    for _ in 0..40 {
        let reading = stream.next_of("READING");
        if reading["channel"] == "thumb" {
            let is_ok = reading["status"] == "ok";
            numbers += usize::from(is_ok);
            assert!(is_ok || reading["fault"] == "latency-outlier", "{reading}");
            let r_ohm = reading["r_ohm"].as_f64();
            assert!(r_ohm.is_none_or(|r_ohm| (800.0..1200.0).contains(&r_ohm)), "{reading}");
        } else {
            assert_eq!(reading["status"], "open", "{reading}");
        }
    }
    assert!(numbers > 10, "{numbers}");
    stream.send(r#"{"class":"STATS"}"#);
    let stats = stream.next_of("STATS");
    assert_eq!(
        (&stats["backend"], &stats["method"], &stats["clients"]),
        (&json!("mock"), &json!("tracked"), &json!(1))
    );
    assert_eq!(stats["lost"], 0);
}

#[test]
fn term_and_int_end_it_cleanly() {
    for signal in [Signal::SIGTERM, Signal::SIGINT] {
        let home = Home::new(&config(&["thumb"], FAST));
        let daemon = home.start();
        let mut stream = home.connect();
        stream.next_of("READING");
        daemon.signal(signal);
        stream.drain();
        assert_eq!(daemon.end().code(), Some(0), "{signal}");
        assert!(!home.socket().exists(), "{signal}: the socket file is still there");
        assert!(home.log().contains("stopping"), "{}", home.log());
    }
}

#[test]
fn hangup_puts_a_new_file_in_force() {
    let home = Home::new(&config(&["thumb", "index"], FAST));
    let daemon = home.start();
    let mut stream = home.connect();
    let mut line = stream.next_of("READING");

    home.configure(config(&["ring"], FAST));
    daemon.signal(Signal::SIGHUP);
    while line["class"] != "VERSION" {
        assert!(["thumb", "index"].contains(&line["channel"].as_str().unwrap()), "{line}");
        line = stream.next().unwrap();
    }
    assert_eq!(ids(&line), ["ring"]);
    for expected in 1..=20 {
        let reading = stream.next().unwrap();
        assert_eq!((&reading["channel"], &reading["seq"]), (&json!("ring"), &json!(expected)), "{reading}");
    }
}

/// Hangs up with a file that is wrong; readings go on, uninterrupted.
fn survives(wrong: impl ToString, because: &str) {
    survives_what(|home| home.configure(wrong), because);
}

fn survives_what(change: impl FnOnce(&Home), because: &str) {
    let home = Home::new(&config(&["thumb"], FAST));
    let daemon = home.start();
    let mut stream = home.connect();
    let mut seq = stream.next_of("READING")["seq"].as_u64().unwrap();
    change(&home);
    daemon.signal(Signal::SIGHUP);
    home.wait_for_log("the old configuration stays in force");
    assert!(home.log().contains(because), "{}", home.log());
    let told = nix::time::clock_gettime(nix::time::ClockId::CLOCK_MONOTONIC).unwrap();
    let told_ns = told.tv_sec() * 1_000_000_000 + told.tv_nsec();
    let mut measured_ns = 0;
    while measured_ns < told_ns {
        let reading = stream.next().unwrap();
        assert_eq!(
            (&reading["class"], &reading["channel"]),
            (&json!("READING"), &json!("thumb")),
            "{reading}"
        );
        // While nobody reads, a busy machine may lose some.
        seq += 1 + reading["lost"].as_u64().unwrap();
        assert_eq!(reading["seq"], seq, "the measurement was interrupted");
        measured_ns = reading["t_mono_ns"].as_i64().unwrap();
    }
}

#[test]
fn hangup_with_a_bad_file_changes_nothing() {
    survives("what = is this", "cermd.toml");
    survives(config(&["thumb"], FAST).set("circuit.r-c1", "22 kohm"), "circuit.r-c");
}

#[test]
fn hangup_without_a_file_changes_nothing() {
    survives_what(|home| fs::remove_file(home.config()).unwrap(), "No such file");
}

#[test]
fn hangup_with_a_file_whose_scene_is_missing_changes_nothing() {
    survives(config(&["thumb"], FAST).set("mock.scene", "nowhere.toml"), "nowhere.toml");
}

/// What is no file may never answer, or never end.
#[test]
fn a_pipe_or_a_device_in_the_place_of_a_file_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.toml");
    nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
    let endless = folder.path().join("endless.toml");
    std::os::unix::fs::symlink("/dev/zero", &endless).unwrap();
    for path in [&pipe, &endless] {
        let path = path.to_str().unwrap();
        survives(config(&["thumb"], FAST).set("mock.scene", path), "no regular file");
        let force = format!("force = {{ table = \"{path}\" }}");
        survives(config(&["thumb"], FAST).lines("channel.thumb", &force), "no regular file");
        let home = Home::new(&config(&["thumb"], FAST));
        let daemon = home.start();
        home.connect().next_of("READING");
        fs::remove_file(home.config()).unwrap();
        std::os::unix::fs::symlink(path, home.config()).unwrap();
        daemon.signal(Signal::SIGHUP);
        home.wait_for_log("no regular file");
        home.connect().next_of("READING");
        daemon.signal(Signal::SIGTERM);
        assert_eq!(daemon.end().code(), Some(0));
    }
}

/// After a kill there may be another file, of other lines.
#[test]
fn the_lines_that_were_asked_for_are_released_whatever_the_file_says() {
    const RUNTIME: &str = "RUNTIME_DIRECTORY";
    let simulated = config(&["thumb"], FAST);
    let mut hardware = simulated.clone();
    hardware.set("gpio.backend", "chardev").set("gpio.chip", "a-chip-that-is-gone");
    let lines =
        [("sense-a", 1), ("sense-b", 2), ("charge-a", 3), ("charge-b", 4), ("sink-c1", 5), ("sink-c2", 6)];
    for (key, line) in lines {
        hardware.set(&format!("gpio.{key}"), line);
    }
    hardware.set("channel.thumb.sink", 7);
    let home = Home::new(&hardware);
    let runtime = home.path().join("run");
    fs::create_dir(&runtime).unwrap();
    let release = || {
        let mut command = home.command();
        let output =
            command.arg("--release-lines").env(RUNTIME, &runtime).stderr(Stdio::piped()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    // It does not get its lines, but it has asked for them.
    assert_eq!(Daemon::spawn(home.command().env(RUNTIME, &runtime)).end().code(), Some(69));
    for later in [simulated.to_string(), "what = is this".to_owned()] {
        home.configure(later);
        let (code, said) = release();
        assert!(code == Some(69) && said.contains("a-chip-that-is-gone"), "{code:?} {said}");
    }
    home.configure(&simulated);
    let daemon = Daemon::spawn(home.command().env(RUNTIME, &runtime));
    home.connect().next_of("READING");
    daemon.signal(Signal::SIGKILL);
    daemon.end();
    home.configure(&hardware);
    let (code, said) = release();
    assert!(code == Some(0) && said.contains("no line to release"), "{code:?} {said}");
    // Without a word of what was asked for, the file has to do.
    fs::remove_dir_all(&runtime).unwrap();
    assert!(release().1.contains("a-chip-that-is-gone"));
}

#[test]
fn without_a_configuration_it_refuses_and_says_how_to_simulate() {
    let output = program().output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    for hint in
        ["No hardware was touched", "--config", "cermctl demo", "backend = \"mock\"", "scene = \"pi4\""]
    {
        assert!(said.contains(hint), "{hint} is missing in:\n{said}");
    }
}

#[test]
fn check_says_what_the_library_says() {
    for (name, value, code) in
        [("circuit.r-c1", "2.32 kohm", 0), ("circuit.r-c0", "2.32 kohm", 1), ("circuit.r-c1", "22 kohm", 1)]
    {
        let home = Home::new(config(&["thumb"], FAST).set(name, value));
        let output = home.command().arg("--check").stdout(Stdio::piped()).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(said, cermd::ctl::check::check(&home.config()).to_string());
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(!home.socket().exists());
    }
}

#[test]
fn what_keeps_it_from_starting_is_said_in_a_sentence() {
    // 78: the next start would end in the same way, so the unit leaves it.
    for (name, value, because, code) in [
        ("mock.scene", "nowhere.toml", "nowhere.toml", 78),
        ("server.socket", "/nowhere/s", "create its directory", 1),
        ("circuit.r-c1", "22 kohm", "not usable", 78),
        ("circuit.r-c0", "22 kohm", "r-c0", 78),
    ] {
        let home = Home::new(config(&["thumb"], FAST).set(name, value));
        assert_eq!(home.start().end().code(), Some(code), "{name}");
        assert!(home.log().contains(because) && home.log().contains("ERROR"), "{}", home.log());
        assert!(!home.log().contains("panicked"), "{}", home.log());
    }
}

/// As a unit whose condition does not hold: started, over, and why.
#[test]
fn without_its_chip_it_is_over_and_no_failure() {
    let mut text = ConfigFile::of(include_str!("../../hw/cermd.toml"));
    let home = Home::new(text.set("gpio.chip", "no-such-chip").set("server.socket", "s"));
    let manager = UnixDatagram::bind(home.path().join("manager")).unwrap();
    let status = Daemon::spawn(home.command().env("NOTIFY_SOCKET", home.path().join("manager"))).end();
    assert_eq!(status.code(), Some(69));
    let mut said = [0; 500];
    let bytes = manager.recv(&mut said).unwrap();
    let said = std::str::from_utf8(&said[..bytes]).unwrap();
    assert!(
        said.starts_with("READY=1\nSTATUS=there is no GPIO chip") && said.contains("no-such-chip"),
        "{said}"
    );
}

/// Starts a daemon that cannot start, its log in a file, JOURNAL_STREAM naming that file by `device` and `inode`.
fn log_lines(home: &Home, device: u64, inode: u64) -> Vec<String> {
    let mut command = home.command();
    command.env("JOURNAL_STREAM", format!("{device}:{inode}"));
    assert_eq!(Daemon::spawn(&mut command).end().code(), Some(78));
    home.log().lines().map(str::to_owned).collect()
}

#[test]
fn lines_carry_priorities_only_into_the_journal() {
    let mut bad = config(&["thumb"], FAST);
    let home = Home::new(bad.set("circuit.r-c1", "22 kohm"));
    let log = File::create(home.log_file()).unwrap().metadata().unwrap();
    let into_journal = log_lines(&home, log.dev(), log.ino());
    assert!(
        into_journal.len() > 1 && into_journal.iter().all(|line| line.starts_with("<3>")),
        "{into_journal:?}"
    );

    let home = Home::new(&bad);
    let log = File::create(home.log_file()).unwrap().metadata().unwrap();
    let redirected = log_lines(&home, log.dev(), log.ino() + 1);
    assert!(!redirected.iter().any(|line| line.starts_with('<')), "{redirected:?}");
}

#[test]
fn the_service_manager_is_told_of_readiness_reload_and_end() {
    let home = Home::new(&config(&["thumb"], FAST));
    let manager = process::notify::Manager::new(&home);
    let mut command = home.command();
    manager.watch(&mut command);
    let daemon = Daemon::spawn(&mut command);
    let ready = manager.wait_for("READY=1");
    assert!(ready.contains("STATUS="), "{ready}");
    // From here on a client is served: it is not told too early.
    std::os::unix::net::UnixStream::connect(home.socket()).unwrap();
    for text in [config(&["index"], FAST).to_string(), "what = is this".to_owned()] {
        home.configure(text);
        daemon.signal(Signal::SIGHUP);
        // Type=notify-reload, systemd.service(5).
        let reloading = manager.wait_for("RELOADING=1");
        assert!(reloading.contains("MONOTONIC_USEC="), "{reloading}");
        manager.wait_for("READY=1");
    }
    daemon.signal(Signal::SIGTERM);
    manager.wait_for("STOPPING=1");
    assert_eq!(daemon.end().code(), Some(0));
    let messages = manager.messages();
    assert!(!messages.iter().any(|message| message.contains("WATCHDOG=1")), "nobody asked for a watchdog");
}

#[test]
fn the_watchdog_is_fed_if_it_is_ours() {
    let home = Home::new(&config(&["thumb"], "offset = \"8 us\"\nrate-hz = 0.2"));
    let manager = process::notify::Manager::new(&home);
    let mut command = home.command();
    manager.watch(&mut command);
    let daemon = Daemon::spawn(command.env("WATCHDOG_USEC", "100000"));
    let status = manager.wait_for("WATCHDOG=1");
    assert!(status.contains("STATUS=") && status.contains("readings"), "{status}");
    // Readings come every five seconds: these signs of life do not depend on them.
    (0..10).for_each(|_| drop(manager.wait_for("WATCHDOG=1")));
    drop(daemon);

    let mut command = home.command();
    manager.watch(&mut command);
    let other = Daemon::spawn(command.env("WATCHDOG_USEC", "100000").env("WATCHDOG_PID", "1"));
    manager.wait_for("READY=1");
    home.connect().next_of("READING");
    other.signal(Signal::SIGTERM);
    manager.wait_for("STOPPING=1");
    let of_other = manager.messages();
    let begin = of_other.iter().rposition(|message| message.contains("READY=1")).unwrap();
    assert!(!of_other[begin..].iter().any(|message| message.contains("WATCHDOG=1")), "{of_other:?}");
}

#[test]
fn many_reloads_leave_no_descriptor_behind() {
    let home = Home::new(&config(&["thumb"], FAST));
    let daemon = home.start();
    let mut stream = home.connect();
    stream.next_of("READING");
    let descriptors = || fs::read_dir(format!("/proc/{}/fd", daemon.pid())).unwrap().count();
    let before = descriptors();
    for _ in 0..20 {
        daemon.signal(Signal::SIGHUP);
        stream.next_of("VERSION");
        stream.next_of("READING");
    }
    until_so("the descriptors of the old measurement to go", || descriptors() <= before);
}
