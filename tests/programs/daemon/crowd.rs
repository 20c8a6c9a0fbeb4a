//! 500 clients at 100 readings a second, one of which does not read.
//!
//! How many clients a machine serves before one of them falls behind is a figure of that machine (`cargo bench --bench
//! fanout`). What holds on any machine, however busy: each client can account for every reading.

use super::process::{Daemon, Home, config};
use crate::waiting::{PATIENCE, until, until_so};
use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use serde_json::Value;
use std::io::{ErrorKind, Read};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::time::Duration;

const CLIENTS: usize = 500;
/// More than the daemon and the kernel keep for a client that does not read (1024 lines and some tens).
const READINGS: u64 = 1250;
/// What the resident memory of the daemon stays below, KiB.
const MEMORY_KIB: u64 = 64 * 1024;

/// Accounts for readings: a gap between two of them is as long as the second one says.
#[derive(Default)]
struct Account {
    last: Option<u64>,
    lost: u64,
}

impl Account {
    fn enter(&mut self, line: &Value) {
        let (seq, lost) = (line["seq"].as_u64().unwrap(), line["lost"].as_u64().unwrap());
        assert!(self.last.is_none_or(|last| seq == last + lost + 1), "after {:?}: {line}", self.last);
        self.last = Some(seq);
        self.lost += lost;
    }

    fn is_up_to(&self, seq: u64) -> bool {
        self.last.is_some_and(|last| last >= seq)
    }
}

/// A client that reads.
struct Reader {
    socket: UnixStream,
    bytes: Vec<u8>,
    account: Account,
}

impl Reader {
    fn new(home: &Home) -> Reader {
        let socket = until("a connection", || UnixStream::connect(home.socket()).ok());
        socket.set_nonblocking(true).unwrap();
        Reader { socket, bytes: Vec::new(), account: Account::default() }
    }

    fn read(&mut self) {
        let mut chunk = [0; 4096];
        loop {
            match self.socket.read(&mut chunk) {
                Ok(0) => panic!("the daemon is gone"),
                Ok(length) => self.bytes.extend_from_slice(&chunk[..length]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) => panic!("{error}"),
            }
        }
        let whole = self.bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1);
        let lines: Vec<u8> = self.bytes.drain(..whole).collect();
        for line in lines.split_inclusive(|&byte| byte == b'\n') {
            let line: Value = serde_json::from_slice(line).unwrap();
            if line["class"] == "READING" {
                self.account.enter(&line);
            }
        }
    }
}

#[test]
fn every_client_accounts_for_every_reading() {
    crate::protocol::bench::allow_descriptors(2048);
    let home = Home::new(&config(&["thumb"], "offset = \"8 us\"\nrate-hz = 100"));
    let daemon = home.start();
    let mut stalled = home.connect();
    assert_eq!(stalled.next().unwrap()["class"], "VERSION");
    let mut readers: Vec<Reader> = (1..CLIENTS).map(|_| Reader::new(&home)).collect();
    let mut memory_kib = 0;
    while !readers.iter().all(|reader| reader.account.is_up_to(READINGS)) {
        let ready: Vec<bool> = {
            let mut fds: Vec<PollFd> =
                readers.iter().map(|reader| PollFd::new(reader.socket.as_fd(), PollFlags::POLLIN)).collect();
            match poll(&mut fds, PollTimeout::try_from(PATIENCE).unwrap()) {
                Ok(0) => panic!("silence"),
                Err(Errno::EINTR) => continue,
                result => result.unwrap(),
            };
            fds.iter().map(|fd| fd.any() == Some(true)).collect()
        };
        readers.iter_mut().zip(ready).filter(|(_, ready)| *ready).for_each(|(reader, _)| reader.read());
        memory_kib = memory_kib.max(daemon.memory_kib("VmRSS"));
    }

    let mut account = Account::default();
    while !account.is_up_to(READINGS) {
        account.enter(&stalled.next_of("READING"));
    }
    assert!(account.lost > 0, "the stalled client was not stalled for long enough");
    let lost_by_readers: u64 = readers.iter().map(|reader| reader.account.lost).sum();
    stalled.send(r#"{"class":"STATS"}"#);
    let stats = stalled.next_of("STATS");
    assert_eq!(stats["clients"], CLIENTS, "{stats}");
    // The readers do not read any more, and may lose some now.
    assert!(stats["lost"].as_u64().unwrap() >= account.lost + lost_by_readers, "{stats}");
    println!(
        "{CLIENTS} clients, {READINGS} readings: the stalled one lost {}, the others {lost_by_readers}; \
         VmRSS at most {memory_kib} KiB",
        account.lost
    );
    assert!(memory_kib < MEMORY_KIB, "{memory_kib} KiB");
}

/// Clients that come and go ten times a second would fill the log otherwise.
#[test]
fn too_few_descriptors_are_told_once() {
    const DESCRIPTORS: usize = 40;
    let home = Home::new(&config(&["thumb"], "offset = \"8 us\""));
    let daemon = home.start();
    let mut first = home.connect();
    first.next_of("READING");
    let pid = daemon.pid().to_string();
    let limited = Command::new("prlimit").args(["--pid", &pid, &format!("--nofile={DESCRIPTORS}")]).status();
    assert!(limited.unwrap().success());
    let mut waiting: Vec<UnixStream> =
        (0..DESCRIPTORS).map(|_| UnixStream::connect(home.socket()).unwrap()).collect();
    home.wait_for_log("no further clients for now");
    // Each of these leaves a descriptor for one more, and the next is one too many again.
    for _ in 0..15 {
        std::thread::sleep(Duration::from_millis(100));
        waiting.remove(0);
        waiting.push(UnixStream::connect(home.socket()).unwrap());
    }
    first.next_of("READING");
    assert_eq!(home.log().matches("no further clients").count(), 1, "{}", home.log());
}

/// As root only, for whom alone there are other users: what the limits say of them is tested beside the limits.
#[test]
fn a_crowd_of_one_user_does_not_shut_out_root() {
    if !nix::unistd::Uid::effective().is_root() {
        println!("skipped: only root can be another user");
        return;
    }
    const NOBODY: u32 = 65534;
    let home = Home::new(config(&["thumb"], "offset = \"8 us\"").set("server.mode", "0666"));
    std::fs::set_permissions(home.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    // 32 clients in all.
    let mut limited = Command::new("sh");
    limited.args(["-c", "ulimit -n 96 && exec \"$0\" --config \"$1\""]);
    limited.arg(env!("CARGO_BIN_EXE_cermd")).arg(home.config()).current_dir(home.path());
    let _daemon = Daemon::spawn(&mut limited);
    home.connect().next_of("READING");
    let mut crowd: Vec<_> = (0..10)
        .map(|_| Command::new(env!("CARGO_BIN_EXE_cermctl")))
        .map(|mut watch| {
            watch.args(["watch", "--socket"]).arg(home.socket()).uid(NOBODY).gid(NOBODY);
            Daemon::spawn(watch.stdout(Stdio::null()).stderr(Stdio::null()))
        })
        .collect();
    until_so("two of ten to be refused", || {
        crowd.iter_mut().map(Daemon::has_ended).filter(|&has| has).count() == 2
    });
    home.connect().next_of("READING");
}
