//! What changes a configuration, and what must not: a tare, what is not in force, several at once, no room, an interruption.

use super::*;

#[test]
fn what_lies_on_a_sensor_is_taken_off() {
    let daemon = daemon_with("cerm", "r-o-of = {}", ["11122 ohm", SHORT]);
    let mut file = ConfigFile::of(&config_of(&daemon));
    fs::write(daemon.path("cermd.toml"), file.set("channel.thumb.zero-ohm", 0.0).to_string()).unwrap();
    let before = config_of(&daemon);
    let path = daemon.path("cermd.toml").to_str().unwrap().to_owned();
    let zero = |arguments: &[&str]| {
        let mut command = daemon.ctl(&["zero", "--yes", "--json", "--config", &path]);
        let json = stdout(command.args(arguments));
        let line: Value = serde_json::from_str(&json).unwrap();
        fs::remove_file(line["kept"].as_str().unwrap()).unwrap();
        line
    };
    let line = zero(&["--channel", "thumb"]);
    let tare_n = line["tare_n"].as_f64().unwrap();
    assert!((tare_n - 1.2).abs() < 0.01, "{line}");
    assert!(config_of(&daemon).contains(", tare = \"1."), "{}", config_of(&daemon));
    // A second time gives the same, whether the daemon has taken it over or not.
    daemon.reload();
    until_so("forces without the tare", || {
        let line = &json_lines(&daemon.ctl(&["get", "--json", "thumb"]).output().unwrap().stdout)[0];
        line["f_n"].as_f64().is_some_and(|f_n| f_n.abs() < 0.02)
    });
    assert!((zero(&["--channel", "thumb"])["tare_n"].as_f64().unwrap() - tare_n).abs() < 0.01);
    assert!(zero(&["--channel", "thumb", "--clear"])["tare_n"].is_null());
    assert_eq!(config_of(&daemon), before);
    // A channel without a force.
    let error = daemon.ctl(&["zero", "--channel", "index", "--config", &path]).assert().code(1);
    let error = String::from_utf8(error.get_output().stderr.clone()).unwrap();
    assert!(error.contains("first `cermctl calibrate force`"), "{error}");
}

/// A reload was forgotten, or the daemon runs by another file: what it reads is not of the file that would be changed.
#[test]
fn what_is_not_in_force_is_not_calibrated() {
    let daemon = daemon("11122 ohm", SHORT);
    let path = daemon.path("cermd.toml").to_str().unwrap().to_owned();
    let force = ["force", "--channel", "thumb", "--count", "5", "--yes"];
    let weights = "1.2 N\n6.06 N, 2204 ohm\n\n";
    let refused = |key: &str, [was, is]: [&str; 2]| {
        let before = config_of(&daemon);
        let wanted = format!("cermd measures with {key} = {was}, and {path} says {is}: ");
        let mut commands = vec![calibrate(&daemon, &force)];
        commands.push(daemon.ctl(&["zero", "--channel", "thumb", "--yes", "--config", &path]));
        // A zero and a reference do without zero and scale, but not without the resistors.
        if key.starts_with("r-c") {
            commands.push(calibrate(&daemon, &["reference", "11122 ohm", "--channel", "thumb", "--yes"]));
            commands.push(calibrate(&daemon, &["zero", "--channel", "index", "--count", "5", "--yes"]));
        }
        for mut command in commands {
            let assert = command.write_stdin(weights).assert().code(1);
            let error = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
            assert!(error.contains(&wanted) && error.contains("`systemctl reload cermd`"), "{error}");
        }
        assert_eq!(config_of(&daemon), before);
    };
    let write = |key: &str, value: f64| {
        let mut file = ConfigFile::of(&config_of(&daemon));
        fs::write(&path, file.set(key, value).to_string()).unwrap();
    };
    write("channel.thumb.zero-ohm", 219.4);
    refused("zero-ohm of thumb", ["0", "219.4"]);
    daemon.reload();
    until_so("the zero is in force", || {
        calibrate(&daemon, &force).write_stdin(weights).output().unwrap().status.success()
    });
    write("channel.thumb.scale", 1.002);
    refused("scale of thumb", ["1", "1.002"]);
    let file = config_of(&daemon);
    let r_c1 = ConfigFile::of(&file).set("circuit.r-c1", "480 ohm").to_string();
    fs::write(&path, r_c1).unwrap();
    refused("r-c1 in ohm", ["470", "480"]);
}

#[test]
fn each_of_several_changes_within_a_second_has_its_own_copy() {
    const CHANGES: usize = 4;
    let folder = Folder::new();
    let mut texts = vec![folder.config()];
    for _ in 0..CHANGES {
        stdout(&mut folder.force(&["--csv", "weights.csv", "--model", "table", "--yes"]));
        texts.push(folder.config());
    }
    texts.sort();
    let mut copies: Vec<String> =
        kept(folder.0.path()).iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    copies.push(folder.config());
    copies.sort();
    assert_eq!(copies, texts);
    texts.dedup();
    assert_eq!(texts.len(), CHANGES + 1, "two of them name the same table");
}

/// The limit of a file's size stands for a disk that is full.
#[test]
fn without_room_nothing_is_changed() {
    let folder = Folder::new();
    let before = folder.config();
    for model in ["alpha", "table"] {
        let mut command = Command::new("sh");
        let script = "ulimit -f 0; trap '' XFSZ; exec \"$0\" \"$@\"";
        command.args(["-c", script, env!("CARGO_BIN_EXE_cermctl"), "calibrate", "force", "--model", model]);
        command
            .args(["--csv", "weights.csv", "--yes", "--config", "cermd.toml"])
            .current_dir(folder.0.path());
        let error = String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap();
        assert!(error.contains("File too large"), "{error}");
        assert_eq!(folder.config(), before);
        let files = fs::read_dir(folder.0.path()).unwrap().map(|entry| entry.unwrap().file_name());
        let mut files: Vec<_> = files.collect();
        files.sort();
        assert_eq!(files, ["cermd.toml", "weights.csv"], "{model}");
    }
}

/// Wherever it is interrupted: all of the change or nothing, and no file that has no use. The first interruption comes while it
/// waits for its weights, however the system divides its time.
#[test]
fn an_interruption_leaves_no_half_of_a_change() {
    use nix::sys::signal::{Signal, kill};
    use std::io::Write;
    use std::process::{Child, Command as Process, Stdio};
    use std::time::{Duration, Instant};
    const INTERRUPTIONS: u32 = 24;
    let start = |folder: &Folder| {
        let mut process = Process::new(env!("CARGO_BIN_EXE_cermctl"));
        process.args("calibrate force --csv /dev/stdin --model table --yes --config cermd.toml".split(' '));
        process.current_dir(folder.0.path()).stdin(Stdio::piped());
        process.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let give_weights = |child: &mut Child| child.stdin.take().unwrap().write_all(CSV.as_bytes()).unwrap();
    let folder = Folder::new();
    let mut child = start(&folder);
    let began = Instant::now();
    give_weights(&mut child);
    assert!(child.wait().unwrap().success());
    let usual: Duration = began.elapsed();
    let mut changed = 0;
    for number in 0..INTERRUPTIONS {
        let folder = Folder::new();
        let before = folder.config();
        let mut child = start(&folder);
        if number > 0 {
            give_weights(&mut child);
            std::thread::sleep(usual * number / INTERRUPTIONS);
        }
        // It may have ended, but it was not waited for: the number is still its own.
        kill(nix::unistd::Pid::from_raw(child.id() as i32), Signal::SIGINT).unwrap();
        child.wait().unwrap();
        let is_changed = folder.config() != before;
        assert!(number > 0 || !is_changed, "it has changed something without weights");
        changed += u32::from(is_changed);
        let mut names: Vec<_> =
            fs::read_dir(folder.0.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names.len(), if is_changed { 4 } else { 2 }, "after {number}/{INTERRUPTIONS}: {names:?}");
    }
    println!("{INTERRUPTIONS} interruptions within {usual:.0?}: {changed} came after the change");
    assert!(changed < INTERRUPTIONS, "none came in time");
}
