//! What is said when something is wrong: one sentence with a hint, and the exit status.

use super::daemon::{Daemon, config, ctl};
use crate::waiting::until_so;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::os::unix::process::CommandExt;

/// Standard error of a verb that fails, without the changing name of the directory.
fn failure(command: &mut assert_cmd::Command, folder: &str) -> String {
    let assert = command.assert().code(1);
    let complaint = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    complaint.replace(folder, "DIR").trim_end().to_owned()
}

#[test]
fn no_daemon() {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().to_str().unwrap();
    let socket = format!("{name}/socket");
    insta::assert_snapshot!(failure(&mut ctl(&["get", "--socket", &socket]), name), @"cermctl: no socket DIR/socket: is cermd running? (systemctl status cermd); no hardware? try `cermctl demo`");
    drop(UnixListener::bind(&socket).unwrap());
    insta::assert_snapshot!(failure(&mut ctl(&["watch", "--socket", &socket]), name), @"cermctl: nobody answers at DIR/socket: cermd was killed or is still starting (systemctl status cermd); no hardware? try `cermctl demo`");
}

#[test]
fn no_permission() {
    let daemon = Daemon::start();
    let mode = |path, bits| fs::set_permissions(path, fs::Permissions::from_mode(bits)).unwrap();
    mode(daemon.folder.path().to_owned(), 0o755);
    // Of the group only: closed to the owner, and to others.
    mode(daemon.socket(), 0o060);
    let refused = || {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_cermctl"));
        command.arg("get").env("CERMD_SOCKET", daemon.socket());
        if nix::unistd::geteuid().is_root() {
            // Root may do everything; nobody (65534 on every distribution) may not.
            command.uid(65534).gid(65534);
        }
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    let is_refusal =
        |said: &str, hint: &str| said.starts_with("cermctl: no permission for ") && said.ends_with(hint);
    let mut gid = nix::unistd::getegid().as_raw();
    if gid == 0 {
        let said = refused();
        let hint = "it belongs to root: try sudo, or run cermd by its unit, as a user of its own\n";
        assert!(is_refusal(&said, hint), "{said}");
        // Of a number that is nobody's; as root it may be given away.
        gid = 54321;
        std::os::unix::fs::chown(daemon.socket(), None, Some(gid)).unwrap();
    }
    let group = nix::unistd::Group::from_gid(gid.into()).unwrap();
    let group = group.map_or_else(|| gid.to_string(), |group| group.name);
    let said = refused();
    let hint = format!("it is open to group {group}: sudo usermod -aG {group} $USER, then log in again\n");
    assert!(is_refusal(&said, &hint), "{said}");
}

#[test]
fn help_that_cannot_be_written_is_a_failure() {
    let status = |program: &str, argument: &str, to: &str| {
        let to = fs::File::options().write(true).open(to).unwrap();
        let mut command = std::process::Command::new(program);
        command.arg(argument).stdout(to).stderr(std::process::Stdio::null()).status().unwrap().code()
    };
    for program in [env!("CARGO_BIN_EXE_cermctl"), env!("CARGO_BIN_EXE_cermd")] {
        for argument in ["--help", "--version"] {
            assert_eq!(status(program, argument, "/dev/full"), Some(1), "{program} {argument}");
            assert_eq!(status(program, argument, "/dev/null"), Some(0), "{program} {argument}");
        }
        assert_eq!(status(program, "--no-such-thing", "/dev/null"), Some(2), "{program}");
    }
}

#[test]
fn no_such_channel() {
    let daemon = Daemon::start();
    for verb in ["get", "watch", "record"] {
        let complaint = failure(&mut daemon.ctl(&[verb, "thumb", "toe"]), "-");
        assert_eq!(complaint, "cermctl: no channel \"toe\": there is thumb, index");
    }
}

#[test]
fn no_such_file() {
    let daemon = Daemon::start();
    let name = daemon.folder.path().to_str().unwrap().to_owned();
    let output = format!("{name}/missing/file");
    insta::assert_snapshot!(failure(&mut daemon.ctl(&["record", "-o", &output]), &name), @"cermctl: DIR/missing/file: No such file or directory (os error 2); is the path right, and is its directory there?");
    insta::assert_snapshot!(failure(&mut ctl(&["estimate", "--method", "cerm", &output]), &name), @"cermctl: DIR/missing/file: No such file or directory (os error 2); is the path right, and is its directory there?");
    insta::assert_snapshot!(failure(&mut ctl(&["demo", "--scene", &format!("{output}.toml")]), &name), @"cermctl: --scene: cannot read DIR/missing/file.toml: No such file or directory (os error 2); is the path right?");
    insta::assert_snapshot!(failure(&mut ctl(&["demo", "--scene", "pi9"]), &name), @r#"cermctl: --scene: there is no built-in scene "pi9"; there are ideal, fpga-paper, pi-zero, pi4, pi5"#);
}

#[test]
fn an_instrument_that_has_not_measured_yet() {
    // A daemon whose first cycle takes longer than anybody waits.
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("socket");
    let mut config = config();
    config.set("measure.charge-time", "50 s").unset(&["measure.rate-hz"]).set("mock.scene", "ideal");
    fs::write(folder.path().join("cermd.toml"), config.to_string()).unwrap();
    let mut slow = std::process::Command::new(env!("CARGO_BIN_EXE_cermd"))
        .arg("--config")
        .arg("cermd.toml")
        .current_dir(folder.path())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // The socket is there before anybody listens.
    until_so("a cermd that serves", || UnixStream::connect(&socket).is_ok());
    let mut get = ctl(&["get", "--socket", socket.to_str().unwrap()]);
    let complaint = failure(&mut get, "-");
    slow.kill().unwrap();
    slow.wait().unwrap();
    insta::assert_snapshot!(complaint, @"cermctl: no reading of thumb yet: `cermctl stats` tells whether the instrument measures");
}

#[test]
fn usage_is_explained_by_the_parser() {
    for arguments in [
        ["lines", "gpiochip0"].as_slice(),
        &[],
        &["record", "--raw", "--format", "csv"],
        &["record", "--count", "0"],
        &["record", "--count", "5", "--seconds", "5"],
        &["record", "--seconds", "-1"],
        &["watch", "--max-hz", "0"],
        &["demo", "--method", "magic"],
        &["demo", "--seconds", "NaN"],
        &["estimate", "--method", "cerm"],
        &["estimate", "--method", "cerm", "--offset", "8", "-"],
        &["estimate", "--method", "cerm", "--offset", "5 s", "-"],
        &["estimate", "--method", "cerm", "--offset=-1 ms", "-"],
        &["watch", "--unit", "stone"],
    ] {
        let assert = ctl(arguments).assert().code(2);
        let complaint = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        assert!(
            complaint.contains("Usage: cermctl") || complaint.contains("--help"),
            "{arguments:?}: {complaint}"
        );
    }
}

/// Advice that is refused in its turn is none.
#[test]
fn an_offset_without_a_unit_is_told_which_one() {
    let with = |offset: &str| {
        ctl(&["estimate", "--method", "cerm", "--offset", offset, "-"]).write_stdin("").assert()
    };
    let complaint = String::from_utf8(with("8").code(2).get_output().stderr.clone()).unwrap();
    assert!(complaint.contains("the unit is missing, write \"8 us\"; or \"auto\""), "{complaint}");
    // As far as the tape, which is empty.
    with("8 us").code(1);
}

#[test]
fn a_full_disk_is_an_error_of_its_own() {
    let daemon = Daemon::start();
    let full = || fs::File::create("/dev/full").unwrap();
    let config = daemon.path("cermd.toml");
    let check = ["--check", "--config", config.to_str().unwrap()];
    for (program, arguments) in [
        (env!("CARGO_BIN_EXE_cermd"), check.as_slice()),
        (env!("CARGO_BIN_EXE_cermctl"), &["check", check[1], check[2]]),
        (env!("CARGO_BIN_EXE_cermctl"), &["lines", "--json"]),
    ] {
        let run = |stderr: std::process::Stdio| {
            let mut command = std::process::Command::new(program);
            command.args(arguments).stdout(full()).stderr(stderr).output().unwrap()
        };
        let output = run(std::process::Stdio::piped());
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {complaint}");
        let is_told = complaint.contains("standard output: No space left on device");
        assert!(is_told || arguments[0] == "lines", "{arguments:?}: {complaint}");
        // Neither is there anybody to tell.
        assert_eq!(run(full().into()).status.code(), Some(1), "{arguments:?}");
    }
}
