//! 500 clients at 100 readings a second, one of which does not read.

use super::process::{Home, PATIENCE, Stream, config, until};
use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::resource::{Resource, getrlimit, setrlimit};
use serde_json::Value;
use std::io::{ErrorKind, Read};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;

const CLIENTS: usize = 500;
/// More than the daemon and the kernel keep for a client that does not read (1024 lines and some tens).
const READINGS: u64 = 1250;
/// What the resident memory of the daemon stays below, KiB.
const MEMORY_KIB: u64 = 64 * 1024;

/// A client that reads; the numbers of its readings must follow on.
struct Reader {
    socket: UnixStream,
    bytes: Vec<u8>,
    last: Option<u64>,
}

impl Reader {
    fn new(home: &Home) -> Reader {
        let socket = until("a connection", || UnixStream::connect(home.socket()).ok());
        socket.set_nonblocking(true).unwrap();
        Reader { socket, bytes: Vec::new(), last: None }
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
                let seq = line["seq"].as_u64().unwrap();
                assert!(self.last.is_none_or(|last| seq == last + 1), "after {:?}: {line}", self.last);
                assert_eq!(line["lost"], 0, "{line}");
                self.last = Some(seq);
            }
        }
    }
}

/// Reads a stalled client's backlog up to a reading; answers how many it has lost, which must be all that it did not
/// get.
fn lost_by(stalled: &mut Stream, newest: u64) -> u64 {
    let first = stalled.next_of("READING");
    assert_eq!(first["lost"], 0, "{first}");
    let (mut last, mut lost) = (first["seq"].as_u64().unwrap(), 0);
    while last < newest {
        let line = stalled.next_of("READING");
        let seq = line["seq"].as_u64().unwrap();
        let gap = line["lost"].as_u64().unwrap();
        assert_eq!(seq, last + gap + 1, "{line}");
        lost += gap;
        last = seq;
    }
    lost
}

#[test]
fn only_the_client_that_stalls_loses_readings() {
    let (soft, hard) = getrlimit(Resource::RLIMIT_NOFILE).unwrap();
    setrlimit(Resource::RLIMIT_NOFILE, soft.max(2048.min(hard)), hard).unwrap();
    let home = Home::new(&config(&["thumb"], "offset = \"8 us\"\nrate-hz = 100"));
    let daemon = home.start();
    let mut stalled = home.connect();
    assert_eq!(stalled.next().unwrap()["class"], "VERSION");
    let mut readers: Vec<Reader> = (1..CLIENTS).map(|_| Reader::new(&home)).collect();
    let mut memory_kib = 0;
    while readers.iter().any(|reader| reader.last.is_none_or(|last| last < READINGS)) {
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

    let lost = lost_by(&mut stalled, READINGS);
    assert!(lost > 0, "the stalled client was not stalled for long enough");
    stalled.send(r#"{"class":"STATS"}"#);
    let stats = stalled.next_of("STATS");
    assert_eq!((&stats["clients"], &stats["lost"]), (&CLIENTS.into(), &lost.into()), "{stats}");
    println!(
        "{CLIENTS} clients, {READINGS} readings: the stalled one lost {lost}; VmRSS at most {memory_kib} KiB"
    );
    assert!(memory_kib < MEMORY_KIB, "{memory_kib} KiB");
}
