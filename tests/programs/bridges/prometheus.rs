use super::bench::{Bridge, get};
use crate::cermctl::daemon::Daemon;
use crate::waiting::{until, until_so};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::net::SocketAddr;

fn sample(address: SocketAddr, name: &str) -> Option<f64> {
    let (head, page) = get(address, "/metrics", "");
    assert!(head.starts_with("HTTP/1.1 200 OK"), "{head}");
    let line = page.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ').map(str::to_owned));
    line.map(|value| value.parse().unwrap())
}

const R: &str = "cermd_resistance_ohms{channel=\"index\"}";
const UNKNOWN: &str = "cermd_channel_status{channel=\"index\",status=\"unknown\"}";

#[test]
fn a_scrape_is_fresh_or_says_nothing() {
    let mut daemon = Daemon::start();
    let bridge =
        Bridge::start(&daemon, &["bridge", "prometheus", "--listen", "127.0.0.1:0", "--stale", "1 s"]);
    let address = bridge.address();
    let r = until("a reading", || sample(address, R));
    assert!((r - 2000.0).abs() < 100.0, "{r}");
    assert!(sample(address, "cermd_up") == Some(1.0) && sample(address, UNKNOWN) == Some(0.0));
    until_so("figures", || sample(address, "cermd_readings_total{status=\"ok\"}") > Some(0.0));
    let (head, page) = get(address, "/metrics", "Accept: application/openmetrics-text;version=1.0.0\r\n");
    assert!(head.contains("application/openmetrics-text") && page.ends_with("# EOF\n"), "{head}\n{page}");

    // It hangs: the connection stays, and readings stay away.
    let pid = Pid::from_raw(daemon.pid() as i32);
    kill(pid, Signal::SIGSTOP).unwrap();
    until_so("silence", || sample(address, R).is_none());
    kill(pid, Signal::SIGCONT).unwrap();
    until("readings after a halt", || sample(address, R));

    daemon.kill();
    until_so("the news of a kill", || sample(address, "cermd_up") == Some(0.0));
    assert_eq!(sample(address, R), None);
    daemon.run();
    until("readings of the next daemon", || sample(address, R));
}

#[test]
fn it_waits_for_a_daemon_and_ends_when_told() {
    let mut daemon = Daemon::start();
    daemon.kill();
    let mut bridge = Bridge::start(&daemon, &["bridge", "prometheus", "--listen", "127.0.0.1:0"]);
    let address = bridge.address();
    bridge.says("nobody answers");
    assert_eq!(sample(address, "cermd_up"), Some(0.0));
    daemon.run();
    until("readings", || sample(address, R));
    bridge.process.interrupt();
    assert_eq!(bridge.process.end().0, Some(0));
}

#[test]
fn an_address_that_is_taken_is_told() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let assert = crate::cermctl::daemon::ctl(&["bridge", "prometheus", "--listen", &address])
        .assert()
        .failure()
        .code(1);
    let said = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(said.contains(&format!("--listen {address}")) && said.contains("choose another port"), "{said}");
}
