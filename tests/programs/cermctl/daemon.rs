//! A real cermd on a simulated circuit, for a test.

use assert_cmd::Command;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::fs;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Small capacitors, for hundreds of readings a second; `thumb` at 100 ohm is read by switched discharges, `index` at
/// 2 kohm by full ones.
pub const CONFIG: &str = r#"
[circuit]
kind = "two-capacitor"
c-a = "330 nF"
c-b = "22 nF"
r-c1 = "2.32 kohm"
r-c2 = "12.7 kohm"
r-charge = "40 ohm"
[measure]
method = "cerm"
rate-hz = 100
charge-time = "500 us"
t-l = "10 us"
[[channel]]
id = "thumb"
force = { alpha = "13346 N ohm" }
[[channel]]
id = "index"
[server]
socket = "SOCKET"
[mock]
scene = "scene.toml"
"#;

/// A line moves at any instant of its slot, so that readings differ; there is no noise that could ever be an outlier.
const SCENE: &str = r#"
[circuit]
kind = "two-capacitor"
c-a = "330 nF"
c-b = "22 nF"
r-c1 = "2.32 kohm"
r-c2 = "12.7 kohm"
r-o = "40 ohm"
v-dd = "3.3 V"
threshold = { falling = "1.3 V" }
[stamps]
mean = "1 us"
[calls]
fixed = "100 ns"
per-line = "10 ns"
moves-at = [0.0, 1.0]
[[sensor]]
constant = "100 ohm"
[[sensor]]
constant = "2 kohm"
"#;

/// Nothing in these tests takes longer unless it hangs.
pub const LONGEST: Duration = Duration::from_secs(60);

/// A directory with a configuration, a scene and, while it runs, a daemon.
pub struct Daemon {
    pub folder: TempDir,
    child: Option<Child>,
}

impl Daemon {
    pub fn start() -> Daemon {
        Daemon::start_with("", "")
    }

    /// With a change to the configuration.
    pub fn start_with(from: &str, to: &str) -> Daemon {
        Daemon::start_as((from, to), &[])
    }

    /// With changes to the scene.
    pub fn start_in_scene(changes: &[(&str, &str)]) -> Daemon {
        Daemon::start_as(("", ""), changes)
    }

    /// With a change to the configuration and changes to the scene.
    pub fn start_as((from, to): (&str, &str), changes: &[(&str, &str)]) -> Daemon {
        let mut daemon = Daemon { folder: tempfile::tempdir().unwrap(), child: None };
        let scene = changes.iter().fold(SCENE.to_owned(), |scene, (from, to)| scene.replacen(from, to, 1));
        fs::write(daemon.path("scene.toml"), scene).unwrap();
        let config = CONFIG.replace("SOCKET", daemon.socket().to_str().unwrap()).replacen(from, to, 1);
        fs::write(daemon.path("cermd.toml"), config).unwrap();
        daemon.run();
        daemon
    }

    /// Starts it (again), and waits until it answers.
    pub fn run(&mut self) {
        let child = std::process::Command::new(env!("CARGO_BIN_EXE_cermd"))
            .arg("--config")
            .arg(self.path("cermd.toml"))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        self.child = Some(child);
        wait_until("cermd serves", || UnixStream::connect(self.socket()).is_ok());
    }

    /// As the out-of-memory killer would.
    pub fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn socket(&self) -> PathBuf {
        self.path("socket")
    }

    /// `cermctl` that talks to it.
    pub fn ctl(&self, arguments: &[&str]) -> Command {
        let mut command = ctl(arguments);
        command.env("CERMD_SOCKET", self.socket());
        command
    }

    /// The same as a process that goes on.
    pub fn spawn(&self, arguments: &[&str]) -> Running {
        let child = std::process::Command::new(env!("CARGO_BIN_EXE_cermctl"))
            .args(arguments)
            .env("CERMD_SOCKET", self.socket())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        Running(Some(child.unwrap()))
    }

    pub fn stats(&self) -> Value {
        let output = self.ctl(&["stats", "--json"]).output().unwrap();
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        self.kill();
    }
}

/// `cermctl` without a daemon, in an environment that is always the same.
pub fn ctl(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cermctl"));
    command.args(arguments).env_remove("CERMD_SOCKET").env("LC_ALL", "C").timeout(LONGEST);
    command
}

/// A `cermctl` in the background; killed when it is dropped.
pub struct Running(Option<Child>);

impl Running {
    pub fn child(&mut self) -> &mut Child {
        self.0.as_mut().unwrap()
    }

    /// Ctrl-C.
    pub fn interrupt(&mut self) {
        kill(Pid::from_raw(self.child().id() as i32), Signal::SIGINT).unwrap();
    }

    /// Exit status and standard error, when it has ended.
    pub fn end(mut self) -> (Option<i32>, String) {
        wait_until("cermctl ends", || self.child().try_wait().unwrap().is_some());
        let output = self.0.take().unwrap().wait_with_output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let since = Instant::now();
    while !is_so() {
        assert!(since.elapsed() < LONGEST, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

pub fn lines_of(path: &Path) -> Vec<Value> {
    json_lines(&fs::read(path).unwrap())
}

/// Every line must be whole.
pub fn json_lines(bytes: &[u8]) -> Vec<Value> {
    assert!(bytes.is_empty() || bytes.ends_with(b"\n"), "the last line is not whole");
    let lines = bytes.split_inclusive(|byte| *byte == b'\n');
    lines.map(|line| serde_json::from_slice(line).unwrap()).collect()
}
