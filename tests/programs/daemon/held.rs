//! A daemon whose lines another program holds: a service waits for them, by hand it says so and ends.
//!
//! It runs in a second process, this test binary again, where the kernel's first answer is put in its place; that of a real kernel is
//! in tests/vm. Further attempts open a simulated board, whose scene is away for as long as the lines are held.

use super::FAST;
use super::process::notify::Manager;
use super::process::{Daemon, Home, config, unmanaged};
use cermd::config::backend::OpenError;
use cermd::ctl::log;
use cermd::daemon::{self, Loaded, Signals};
use cermd::pins::chardev::ChardevError;
use nix::sys::signal::Signal;
use serde_json::json;
use std::path::Path;
use std::process::Command;
use std::{env, fs, io, process, thread};

const SERVE: &str = "CERMD_TEST_HELD";
const HOLDER: &str = "held by another consumer: GPIO5 (\"gpiomon\")";

/// Runs in the second process only.
#[test]
fn serve() {
    let Ok(path) = env::var(SERVE) else { return };
    log::start();
    let held = |_: &Loaded| {
        fs::rename("fast.toml", "held.toml").unwrap();
        Err(OpenError::Hardware(ChardevError::Call {
            call: "GET_LINE",
            line: "sense-a (GPIO5) of gpiochip0 [fake]".to_owned(),
            source: io::Error::from_raw_os_error(nix::libc::EBUSY),
            hint: HOLDER.to_owned(),
            for_a_group: false,
            consumers: vec!["gpiomon".to_owned()],
        }))
    };
    let loaded = Loaded::load(Path::new(&path)).unwrap();
    let listening = daemon::Listening::new(&loaded).unwrap();
    let started = daemon::Daemon::start(loaded, listening, Signals::new().unwrap(), held);
    match started.and_then(|mut daemon| daemon.serve(Some(Path::new(&path)))) {
        Ok(()) => process::exit(0),
        Err(error) => {
            eprintln!("{error}");
            process::exit(1)
        }
    }
}

fn command(home: &Home) -> Command {
    let mut command = home.within(unmanaged(&env::current_exe().unwrap()));
    command.args(["daemon::held::serve", "--exact", "--nocapture"]).env(SERVE, home.config());
    command
}

/// As a service, up to where it waits.
fn waiting(home: &Home) -> (Daemon, Manager) {
    let manager = Manager::new(home);
    let mut command = command(home);
    manager.watch(&mut command);
    let daemon = Daemon::spawn(&mut command);
    let ready = manager.wait_for("READY=1");
    assert!(ready.contains("STATUS=waiting: ") && ready.contains(HOLDER), "{ready}");
    (daemon, manager)
}

#[test]
fn a_service_waits_and_starts_by_itself() {
    let home = Home::new(&config(&["thumb"], FAST));
    let (daemon, manager) = waiting(&home);
    // All the while, or the daemon would wait for its manager.
    let told = thread::spawn(move || {
        manager.wait_for_one("status without a wait", |message| message.contains(" readings, "));
        manager
    });
    let mut stream = home.connect();
    stream.send(r#"{"class":"STATS"}"#);
    assert_eq!(stream.next_of("STATS")["gpio_works"], false);
    // Twice: it is alive, and waits.
    for _ in 0..2 {
        assert_eq!(stream.next_of("READING")["fault"], "pins");
    }
    fs::rename(home.path().join("held.toml"), home.path().join("fast.toml")).unwrap();
    while stream.next_of("READING")["status"] != "ok" {}
    let messages = told.join().unwrap().messages();
    assert!(messages.len() > 2 && messages[1].starts_with("STATUS=waiting: "), "{messages:?}");
    assert!(messages[1..].iter().all(|message| !message.contains("READY=1")), "{messages:?}");
    assert_eq!(home.log().matches(HOLDER).count(), 1, "{}", home.log());
    daemon.signal(Signal::SIGTERM);
    assert_eq!(daemon.end().code(), Some(0));
}

#[test]
fn it_ends_while_it_waits() {
    for signal in [Signal::SIGTERM, Signal::SIGINT] {
        let home = Home::new(&config(&["thumb"], FAST));
        let (daemon, manager) = waiting(&home);
        daemon.signal(signal);
        manager.wait_for("STOPPING=1");
        assert_eq!(daemon.end().code(), Some(0), "{signal}");
        assert!(!home.socket().exists());
    }
}

#[test]
fn a_file_of_other_lines_ends_the_wait() {
    let home = Home::new(&config(&["thumb"], FAST));
    let (daemon, manager) = waiting(&home);
    home.configure(config(&["index"], FAST).set("mock.scene", "held.toml"));
    daemon.signal(Signal::SIGHUP);
    manager.wait_for("RELOADING=1");
    manager.wait_for("READY=1");
    let reading = home.connect().next_of("READING");
    assert_eq!((&reading["channel"], reading.get("fault") == Some(&json!("pins"))), (&json!("index"), false));
}

#[test]
fn by_hand_it_says_so_and_ends() {
    let home = Home::new(&config(&["thumb"], FAST));
    assert_eq!(Daemon::spawn(&mut command(&home)).end().code(), Some(1));
    assert!(home.log().contains(HOLDER) && !home.log().contains("trying again"), "{}", home.log());
    assert!(!home.socket().exists());
}
