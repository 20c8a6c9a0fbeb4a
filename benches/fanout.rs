//! What it costs to serve 500 clients at 100 readings a second: `cargo bench --bench fanout`.
//!
//! Prints figures and asserts nothing: they are of the machine that it runs on. The clients live in a process of
//! their own, so that time and memory are the server's alone. Three rounds: all clients read; one in five never
//! reads; none reads.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a bench that cannot go on has failed")]

use cermd::reading::{Branch, Measured, MeasuredValue, Method, Reading, Status};
use cermd::stream::server::{Limits, Listener, Server};
use cermd::stream::wire::{ChannelInfo, Unit};
use cermd::units::Nanos;
use jiff::Timestamp;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::resource::{Resource, UsageWho, getrlimit, getrusage, setrlimit};
use std::io::Read;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const CLIENTS: usize = 500;
const PERIOD: Duration = Duration::from_millis(10);
const READINGS: u64 = 1500;

fn main() {
    let (_, hard) = getrlimit(Resource::RLIMIT_NOFILE).unwrap();
    setrlimit(Resource::RLIMIT_NOFILE, hard.min(4096), hard).unwrap();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let count = |index: usize| arguments[index].parse().unwrap();
    match arguments.first().map(String::as_str) {
        Some("clients") => play_clients(Path::new(&arguments[2]), count(1)),
        Some("round") => round(count(1)),
        _ => {
            println!(
                "{CLIENTS} clients, {} readings/s, {READINGS} readings a round",
                1000 / PERIOD.as_millis()
            );
            for reading_clients in [CLIENTS, CLIENTS * 4 / 5, 0] {
                // A process each: a heap that was used before would hide what the clients take.
                assert!(ourselves("round", reading_clients).status().unwrap().success());
            }
        }
    }
}

fn ourselves(role: &str, reading_clients: usize) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.arg(role).arg(reading_clients.to_string());
    command
}

fn round(reading_clients: usize) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("s");
    let channels = [ChannelInfo { id: "thumb".to_owned(), unit: Unit::Newton, trigger: false }];
    let listener = Listener::bind(&path, 0o600).unwrap();
    let mut server = Server::new(listener, &channels, Limits::default()).unwrap();
    let mut clients = ourselves("clients", reading_clients).arg(&path).spawn().unwrap();

    let (memory_before, kernel_before) = (status_kib("/proc/self/status", "RssAnon"), kernel_kib());
    while server.clients() < CLIENTS {
        turn(&mut server);
    }
    let mut durations = Vec::new();
    let (cpu_before, start) = (cpu_time(), Instant::now());
    for seq in 1..=READINGS {
        let due = start + PERIOD * seq as u32;
        while wait(&server, due.saturating_duration_since(Instant::now())) {
            turn(&mut server);
        }
        let published = Instant::now();
        server.publish_reading(&reading(seq), Timestamp::constant(1_795_232_400, 123_456_789));
        turn(&mut server);
        durations.push(published.elapsed());
    }
    let cpu = cpu_time() - cpu_before;
    let memory = status_kib("/proc/self/status", "RssAnon") - memory_before;
    let kernel = kernel_kib() - kernel_before;
    clients.kill().unwrap();
    clients.wait().unwrap();

    durations.sort_unstable();
    let per_reading = cpu / READINGS as u32;
    println!("{reading_clients} of {CLIENTS} clients read:");
    println!(
        "  CPU of the server      {per_reading:>10.1?} per reading, {:?} per client",
        per_reading / CLIENTS as u32
    );
    println!(
        "  published to last sent {:>10.1?} median, {:.1?} at 99 %, {:.1?} at most",
        durations[durations.len() / 2],
        durations[durations.len() * 99 / 100],
        durations[durations.len() - 1]
    );
    println!(
        "  memory of the daemon   {:>10} bytes per client ({memory} KiB)",
        memory * 1024 / CLIENTS as i64
    );
    println!(
        "  memory of the kernel   {:>10} bytes per client (slab, both ends of each socket)",
        kernel * 1024 / CLIENTS as i64
    );
}

fn reading(seq: u64) -> Reading {
    let r_ohm = Measured { value: 2841.3 + (seq as f64).sin(), u: Some(1.234) };
    let (value, u) = (4.697 + (seq as f64).cos(), Some(0.002_34));
    let shown = Some(MeasuredValue { value, u, repeat_u: u, is_extrapolated: false });
    Reading {
        channel: 0,
        seq,
        at: Nanos(81_234_567_890 + seq as i64 * 10_000_000),
        status: Status::Ok { branch: Branch::Direct, r_ohm, shown, is_moving: false, is_settling: false },
        suspect: None,
        method: Method::Cerm,
        duration: Nanos(9_000_000),
    }
}

fn turn(server: &mut Server) {
    server.turn(Nanos::ZERO, &Default::default).unwrap();
}

/// Whether the server has something to do before the time is over.
fn wait(server: &Server, longest: Duration) -> bool {
    let mut fds = [PollFd::new(server.as_fd(), PollFlags::POLLIN)];
    poll(&mut fds, PollTimeout::try_from(longest).unwrap()).unwrap() > 0
}

fn cpu_time() -> Duration {
    let usage = getrusage(UsageWho::RUSAGE_SELF).unwrap();
    let micros = |time: nix::sys::time::TimeVal| (time.tv_sec() * 1_000_000 + time.tv_usec()) as u64;
    Duration::from_micros(micros(usage.user_time()) + micros(usage.system_time()))
}

fn status_kib(file: &str, key: &str) -> i64 {
    let text = std::fs::read_to_string(file).unwrap();
    let line = text.lines().find(|line| line.starts_with(key)).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

fn kernel_kib() -> i64 {
    status_kib("/proc/meminfo", "Slab")
}

/// The other process: the first `reading_clients` read whatever comes.
fn play_clients(path: &Path, reading_clients: usize) {
    let sockets: Vec<UnixStream> = (0..CLIENTS).map(|_| UnixStream::connect(path).unwrap()).collect();
    let mut fds: Vec<PollFd> = sockets[..reading_clients]
        .iter()
        .map(|socket| PollFd::new(socket.as_fd(), PollFlags::POLLIN))
        .collect();
    let mut bytes = vec![0; 65536];
    loop {
        poll(&mut fds, PollTimeout::NONE).unwrap();
        for (mut socket, fd) in sockets.iter().zip(&fds) {
            if fd.any() == Some(true) && socket.read(&mut bytes).unwrap() == 0 {
                return;
            }
        }
    }
}
