//! The socket of the daemon: whose it is, and what is done when it is another one's.

use super::FAST;
use super::process::{self, Daemon, Home, config};
use nix::sys::signal::Signal;
use std::fs::{self, File};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixListener;
use std::process::{Command, Stdio};

#[test]
fn a_live_socket_is_refused_and_a_stale_one_replaced() {
    let home = Home::new(&config(&["thumb"], FAST));
    let first = home.start();
    home.connect().next_of("READING");
    assert_eq!(home.start().end().code(), Some(1));
    let owner = format!("is already served by pid {} (cermd", first.pid());
    assert!(home.log().contains(&owner), "{}", home.log());
    home.connect().next_of("READING");

    first.signal(Signal::SIGKILL);
    first.end();
    assert!(home.socket().exists());
    let _second = home.start();
    home.connect().next_of("READING");
    assert!(home.log().contains("which nobody serves any more"), "{}", home.log());
}

/// Its manager would start it ten times a second.
#[test]
fn a_service_waits_for_a_socket_that_another_one_serves() {
    let home = Home::new(&config(&["thumb"], FAST));
    let first = home.start();
    home.connect().next_of("READING");
    let manager = process::notify::Manager::new(&home);
    let managed = || {
        let mut command = home.command();
        manager.watch(&mut command);
        Daemon::spawn(&mut command)
    };
    let told = |wanted: &str| manager.wait_for_one(wanted, |message| message.contains(wanted));
    let second = managed();
    let owner = format!("is already served by pid {} (cermd", first.pid());
    let text = told("STATUS=");
    assert!(text.starts_with("READY=1\nSTATUS=no socket: ") && text.contains(&owner), "{text}");
    // It does not stop being alive, and says it in the log only once; a configuration that is wrong changes nothing.
    home.configure("");
    second.signal(Signal::SIGHUP);
    home.wait_for_log("the old configuration stays in force");
    for _ in 0..3 {
        assert!(told("WATCHDOG=1").contains(&owner));
    }
    assert_eq!(home.log().matches(&owner).count(), 1, "{}", home.log());
    assert_eq!(home.log().matches("reading ").count(), 1, "once for each signal: {}", home.log());
    home.configure(config(&["index"], FAST));
    second.signal(Signal::SIGHUP);
    told("RELOADING=1");
    told("READY=1");

    first.signal(Signal::SIGTERM);
    assert_eq!(first.end().code(), Some(0));
    told("STATUS=measuring");
    assert_eq!(home.connect().next_of("READING")["channel"], "index");

    // Another one, which is told to end while it waits, does so and leaves the socket.
    let third = managed();
    told(&format!("is already served by pid {} (cermd", second.pid()));
    third.signal(Signal::SIGTERM);
    assert_eq!(third.end().code(), Some(0));
    home.connect().next_of("READING");
}

#[test]
fn a_socket_of_the_service_manager_is_served_and_left() {
    let home = Home::new(&config(&["thumb"], FAST));
    let passed = home.path().join("passed");
    let listener = UnixListener::bind(&passed).unwrap();
    let manager = process::notify::Manager::new(&home);
    // As sd_listen_fds(3) says: descriptor 3, the process named by its id.
    let mut command = Command::new("sh");
    command.args(["-c", "LISTEN_PID=$$ LISTEN_FDS=1 exec \"$0\" --config \"$1\" 3<&0"]);
    command.arg(env!("CARGO_BIN_EXE_cermd")).arg(home.config());
    command.stdin(Stdio::from(OwnedFd::from(listener))).stderr(File::create(home.log_file()).unwrap());
    manager.watch(&mut command);
    let daemon = Daemon::spawn(&mut command);
    manager.wait_for("READY=1");
    assert!(!home.socket().exists(), "it made a socket of its own");
    fs::rename(&passed, home.socket()).unwrap();
    home.connect().next_of("READING");
    assert!(home.log().contains("passed by systemd"), "{}", home.log());
    daemon.signal(Signal::SIGTERM);
    manager.wait_for("STOPPING=1");
    assert_eq!(daemon.end().code(), Some(0));
    assert!(home.socket().exists(), "systemd's file is systemd's");
}
