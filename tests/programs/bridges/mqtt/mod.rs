mod broker;

use super::bench::Bridge;
use crate::cermctl::daemon::{Daemon, ctl};
use broker::{Broker, Publish, Session};

const AVAILABILITY: &str = "cermd/bench/availability";
const INDEX: &str = "cermd/bench/channel/index";

fn start(daemon: &Daemon, broker: &Broker, more: &[&str]) -> Bridge {
    let port = broker.address().port().to_string();
    let arguments = ["bridge", "mqtt", "--broker", "127.0.0.1", "--port", &port, "--id", "bench"];
    Bridge::start(daemon, &[&arguments, more].concat())
}

/// Until the availability says so; no reading after it may be from before.
fn until_available(session: &mut Session, wanted: &str) {
    while session.next_on(AVAILABILITY).payload != wanted {}
}

fn is_number(publish: &Publish) -> bool {
    publish.json()["r_ohm"].as_f64().is_some_and(|r_ohm| (r_ohm - 2000.0).abs() < 200.0)
}

#[test]
fn a_board_introduces_itself_and_tells_what_it_reads() {
    let daemon = Daemon::start();
    let broker = Broker::new();
    let password = daemon.path("password");
    std::fs::write(&password, "secret\nnot this\n").unwrap();
    let login = ["--user", "board", "--password-file", password.to_str().unwrap()];
    let mut bridge = start(&daemon, &broker, &login);
    let (mut session, connect) = broker.accept(0);
    assert_eq!(connect.client_id, "cermd-bench");
    assert_eq!(connect.will, [AVAILABILITY, "offline"]);
    assert_eq!(connect.login, Some(["board", "secret"].map(str::to_owned)));
    let device = session.next_on("homeassistant/device/bench/config");
    assert!(device.is_retained);
    assert_eq!(device.json()["cmps"]["index_resistance"]["state_topic"], INDEX);
    until_available(&mut session, "online");
    while !is_number(&session.next_on(INDEX)) {}
    assert_eq!(session.next_on("cermd/bench/instrument").json()["gpio_works"], true);

    // Home Assistant has started again.
    session.say("homeassistant/status", "online");
    session.next_on("homeassistant/device/bench/config");

    bridge.process.interrupt();
    let last = std::iter::from_fn(|| session.next()).last().unwrap();
    assert_eq!((&*last.topic, &*last.payload), (AVAILABILITY, "offline"));
    assert_eq!(bridge.process.end().0, Some(0));
}

#[test]
fn outages_of_either_side_leave_nothing_stale() {
    let mut daemon = Daemon::start();
    let broker = Broker::new();
    // Everything is news: as much as possible could wait somewhere.
    let bridge =
        start(&daemon, &broker, &["--change", "0.001", "--at-most-every", "10 ms", "--no-discovery"]);
    let (mut session, _) = broker.accept(0);
    while !is_number(&session.next_on(INDEX)) {}

    // The broker is gone, and back after readings that nobody has taken.
    drop(session);
    let before = daemon.stats()["readings"].as_u64().unwrap();
    crate::waiting::until_so("readings", || daemon.stats()["readings"].as_u64().unwrap() > before + 100);
    let back = jiff::Timestamp::now();
    let (mut session, _) = broker.accept(0);
    let first = session.next().unwrap();
    assert_eq!((&*first.topic, &*first.payload), (AVAILABILITY, "online"));
    let reading = session.next_on(INDEX);
    let time: jiff::Timestamp = reading.json()["time"].as_str().unwrap().parse().unwrap();
    assert!(time >= back - jiff::SignedDuration::from_millis(200), "a reading of {time}, told after {back}");

    // The daemon is gone, and back.
    daemon.kill();
    until_available(&mut session, "offline");
    let killed = jiff::Timestamp::now();
    daemon.run();
    let after: Vec<_> =
        std::iter::from_fn(|| session.next()).take_while(|publish| publish.topic != INDEX).collect();
    assert!(after.iter().any(|publish| publish.topic == AVAILABILITY && publish.payload == "online"));
    let reading = session.next_on(INDEX).json();
    assert!(reading["time"].as_str().unwrap().parse::<jiff::Timestamp>().unwrap() > killed, "{reading}");
    drop(bridge);
}

#[test]
fn a_refusal_is_told_with_what_to_do() {
    let daemon = Daemon::start();
    let broker = Broker::new();
    let bridge = start(&daemon, &broker, &[]);
    drop(broker.accept(5));
    let said = bridge.says("NotAuthorized");
    assert!(said.contains("look at --user and --password-file"), "{said}");
    // It tries again.
    broker.accept(0).0.next_on(AVAILABILITY);

    let missing = ["bridge", "mqtt", "--broker", "localhost", "--ca", "/nowhere/ca.pem"];
    let assert = ctl(&missing).assert().failure().code(1);
    let said = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(said.contains("/nowhere/ca.pem: "), "{said}");
}

#[test]
fn what_is_no_host_is_refused_at_once() {
    for broker in ["", "127.0.0.1:1", "broker.local:1883", "mqtt://broker", "[::1]", "a b"] {
        let assert = ctl(&["bridge", "mqtt", "--broker", broker]).assert().failure().code(2);
        let said = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        assert!(said.contains("a port goes to --port"), "{broker}: {said}");
    }
    // These are hosts: what is missing then is something else.
    for broker in ["::1", "fe80::1%eth0", "broker.local"] {
        let assert =
            ctl(&["bridge", "mqtt", "--broker", broker, "--ca", "/nowhere/ca.pem"]).assert().failure();
        let said = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        assert!(said.contains("/nowhere/ca.pem: "), "{broker}: {said}");
    }
}
