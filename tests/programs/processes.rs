//! What needs a second process: a socket handed over by the service manager, and a server that is killed.
//!
//! The second process is this test binary again, told by an environment variable to serve.

use crate::protocol::bench::{TIME, channels, reading};
use crate::waiting::{PATIENCE, until};
use cermd::stream::client::Client;
use cermd::stream::server::{Limits, Listener, Server};
use cermd::units::Nanos;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};

const SERVE: &str = "CERMD_TEST_SERVE";

/// Runs in the second process only: serves at the path, or on what the service manager has passed, for ever.
#[test]
fn serve() {
    let Ok(path) = std::env::var(SERVE) else { return };
    let listener = match path.as_str() {
        "" => Listener::from_systemd().unwrap().unwrap(),
        path => Listener::bind(Path::new(path), 0o600).unwrap(),
    };
    let mut server = Server::new(listener, &channels(), Limits::default()).unwrap();
    for seq in 1.. {
        server.publish_reading(&reading(0, seq), TIME);
        server.turn(Nanos::ZERO, &Default::default).unwrap();
    }
}

struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

fn start(path: &Path) -> Killed {
    let mut command = Command::new(std::env::current_exe().unwrap());
    Killed(
        command
            .args(["processes::serve", "--exact", "--nocapture"])
            .env(SERVE, path)
            .stdout(Stdio::null())
            .spawn()
            .unwrap(),
    )
}

#[test]
fn a_killed_server_leaves_whole_lines_and_its_successor_serves() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("s");
    for _ in 0..10 {
        // From the second round on there is the stale socket file of the round before.
        let server = start(&path);
        let mut socket = until("a connection", || UnixStream::connect(&path).ok());
        let mut bytes = vec![0; 100_000];
        socket.read_exact(&mut bytes).unwrap();

        let pid = server.0.id();
        let refusal = Listener::bind(&path, 0o600).unwrap_err();
        assert!(refusal.to_string().contains(&format!("already served by pid {pid} (")));

        drop(server); // SIGKILL, in the middle of publishing
        let _ = socket.read_to_end(&mut bytes); // ends, with or without ECONNRESET
        assert_eq!(bytes.last(), Some(&b'\n'), "half a line");
        for line in bytes.split_inclusive(|&byte| byte == b'\n') {
            serde_json::from_slice::<serde_json::Value>(line).unwrap();
        }
    }
}

#[test]
fn a_socket_passed_by_the_service_manager_is_served() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("s");
    let listener = UnixListener::bind(&path).unwrap();
    // As sd_listen_fds(3) says: descriptor 3, the process named by its id.
    let mut command = Command::new("sh");
    command.args(["-c", "LISTEN_PID=$$ LISTEN_FDS=1 exec \"$0\" processes::serve --exact --nocapture 3<&0"]);
    command.arg(std::env::current_exe().unwrap()).env(SERVE, "");
    let _server =
        Killed(command.stdin(Stdio::from(OwnedFd::from(listener))).stdout(Stdio::null()).spawn().unwrap());
    let mut client = Client::connect(&path, PATIENCE).unwrap();
    assert_eq!(client.version().channels, channels());
    assert!(client.message().unwrap().is_some());
}
