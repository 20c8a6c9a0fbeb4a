//! A process that is out of descriptors: in a file of its own, because the limit holds for the whole process.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

#[path = "programs/protocol/bench.rs"]
#[allow(dead_code, reason = "shared with the tests of the protocol")]
mod bench;

use bench::Bench;
use cermd::units::Nanos;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::resource::{Resource, getrlimit, setrlimit};
use std::fs::File;
use std::os::fd::AsFd;

#[test]
fn without_descriptors_the_server_neither_spins_nor_forgets() {
    let mut bench = Bench::new();
    let mut first = bench.connect();
    let waiting = std::os::unix::net::UnixStream::connect(bench.path()).unwrap();
    let (_, hard) = getrlimit(Resource::RLIMIT_NOFILE).unwrap();
    setrlimit(Resource::RLIMIT_NOFILE, 64, hard).unwrap();
    let hoard: Vec<File> = std::iter::from_fn(|| File::open("/dev/null").ok()).collect();

    bench.settle(); // comes to an end: the listener that cannot be served is not watched
    assert_eq!(bench.server.clients(), 1);
    let wake_at = bench.server.wake_at().unwrap();
    bench.publish(1);
    assert_eq!(bench.lines(&mut first).len(), 2, "the others are served meanwhile");

    drop(hoard);
    let turn = |bench: &mut Bench, now| bench.server.turn(now, &Default::default).unwrap();
    turn(&mut bench, wake_at - Nanos(1));
    assert_eq!(bench.server.clients(), 1);
    turn(&mut bench, wake_at);
    assert_eq!((bench.server.clients(), bench.server.wake_at()), (2, None));
    let mut fds = [PollFd::new(waiting.as_fd(), PollFlags::POLLIN)];
    assert_eq!(poll(&mut fds, PollTimeout::ZERO).unwrap(), 1, "it has got its VERSION");
}
