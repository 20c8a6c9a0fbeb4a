//! A server and its clients in one thread.

use cermd::reading::{Branch, Measured, MeasuredValue, Method, Reading, Status};
use cermd::stream::server::{Limits, Listener, Server};
use cermd::stream::wire::{ChannelInfo, InstrumentStats, Unit};
use cermd::units::Nanos;
use jiff::Timestamp;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use serde_json::Value;
use std::io::{ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;

/// The wall-clock time of every reading.
pub const TIME: Timestamp = Timestamp::constant(1_795_232_400, 123_456_789);

/// Two channels.
pub fn channels() -> [ChannelInfo; 2] {
    let channel = |id: &str, unit| ChannelInfo { id: id.to_owned(), unit, trigger: false };
    [channel("thumb", Unit::Newton), channel("index", Unit::Ohm)]
}

/// A reading; they come at 100 Hz.
pub fn reading(channel: usize, seq: u64) -> Reading {
    let r_ohm = Measured { value: 2841.3 + seq as f64, u: Some(1.2) };
    let u = Some(0.002);
    let force = MeasuredValue { value: 4.697, u, repeat_u: u, is_extrapolated: false };
    let shown = (channel == 0).then_some(force);
    Reading {
        channel,
        seq,
        at: Nanos(81_234_567_890 + seq as i64 * 10_000_000),
        status: Status::Ok { branch: Branch::Direct, r_ohm, shown, is_moving: false, is_settling: false },
        suspect: None,
        method: Method::Cerm,
        duration: Nanos(9_000_000),
    }
}

/// A server on a socket of its own.
pub struct Bench {
    pub server: Server,
    directory: tempfile::TempDir,
    published: u64,
}

/// A client that reads only when it is told to.
pub struct Peer {
    socket: UnixStream,
    bytes: Vec<u8>,
}

impl Bench {
    pub fn new() -> Bench {
        Bench::with(Limits::default())
    }

    pub fn with(limits: Limits) -> Bench {
        let directory = tempfile::tempdir().unwrap();
        let listener = Listener::bind(&directory.path().join("s"), 0o600).unwrap();
        Bench { server: Server::new(listener, &channels(), limits).unwrap(), directory, published: 0 }
    }

    pub fn path(&self) -> PathBuf {
        self.directory.path().join("s")
    }

    /// Lets the server do all it can do now.
    pub fn settle(&mut self) {
        loop {
            let stats = || InstrumentStats { uptime_s: 12.5, ..InstrumentStats::default() };
            self.server.turn(Nanos::ZERO, &stats).unwrap();
            let mut fds = [PollFd::new(self.server.as_fd(), PollFlags::POLLIN)];
            if poll(&mut fds, PollTimeout::ZERO).unwrap() == 0 {
                return;
            }
        }
    }

    /// Publishes readings of the channels by turns, each offered to every client before the next.
    pub fn publish(&mut self, count: u64) {
        for _ in 0..count {
            self.published += 1;
            let channel = (self.published + 1) % 2;
            self.server.publish_reading(&reading(channel as usize, self.published), TIME);
            self.settle();
        }
    }

    pub fn connect(&mut self) -> Peer {
        let socket = UnixStream::connect(self.path()).unwrap();
        socket.set_nonblocking(true).unwrap();
        self.settle();
        Peer { socket, bytes: Vec::new() }
    }

    /// All lines that the client can get now. That they parse shows that none is a half one.
    pub fn lines(&mut self, peer: &mut Peer) -> Vec<Value> {
        loop {
            self.settle();
            if peer.receive() == 0 {
                break;
            }
        }
        let whole = peer.bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1);
        assert_eq!(whole, peer.bytes.len(), "half a line");
        let bytes = std::mem::take(&mut peer.bytes);
        let lines = bytes.split_inclusive(|&byte| byte == b'\n');
        lines.map(|line| serde_json::from_slice(line).unwrap()).collect()
    }

    /// Sends all of it, the server reading meanwhile.
    pub fn send_through(&mut self, peer: &mut Peer, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            match peer.socket.write(bytes) {
                Ok(length) => bytes = &bytes[length..],
                Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock),
            }
            self.settle();
        }
    }

    /// Sends a line if there is room for it in the socket.
    pub fn send_some(&mut self, peer: &mut Peer, line: &[u8]) -> bool {
        let has_sent = match peer.socket.write(line) {
            Ok(length) => {
                assert_eq!(length, line.len());
                true
            }
            Err(error) => {
                assert_eq!(error.kind(), ErrorKind::WouldBlock);
                false
            }
        };
        self.settle();
        has_sent
    }
}

impl Peer {
    pub fn send(&mut self, line: &str) {
        self.send_bytes(line.as_bytes());
        self.send_bytes(b"\n");
    }

    pub fn send_bytes(&mut self, bytes: &[u8]) {
        self.socket.write_all(bytes).unwrap();
    }

    pub fn close_writing(&mut self) {
        self.socket.shutdown(Shutdown::Write).unwrap();
    }

    /// Takes what has come; says how many bytes.
    pub fn receive(&mut self) -> usize {
        let before = self.bytes.len();
        match self.socket.read_to_end(&mut self.bytes) {
            Ok(_) => {}
            Err(error) => assert!(matches!(error.kind(), ErrorKind::WouldBlock), "{error}"),
        }
        self.bytes.len() - before
    }

    pub fn is_closed(&mut self) -> bool {
        self.socket.read(&mut [0]).is_ok_and(|length| length == 0)
    }
}

/// Raises the limit of open files as far as it may be raised; two thousand sockets in one process are above the
/// usual soft limit.
pub fn allow_descriptors(count: u64) {
    use nix::sys::resource::{Resource, getrlimit, setrlimit};
    let (soft, hard) = getrlimit(Resource::RLIMIT_NOFILE).unwrap();
    if soft < count {
        setrlimit(Resource::RLIMIT_NOFILE, count.min(hard), hard).unwrap();
    }
}
