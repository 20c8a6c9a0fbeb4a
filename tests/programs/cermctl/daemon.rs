//! A real cermd on a simulated circuit, for a test.

use crate::common::config::{self, ConfigFile};
use crate::waiting::{PATIENCE, until_so};
use assert_cmd::Command;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::fs;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use tempfile::TempDir;

/// Small capacitors, for hundreds of readings a second; `thumb` at 100 ohm is read by switched discharges, `index` at
/// 2 kohm by full ones.
pub fn config() -> ConfigFile {
    config::config(|c| {
        c.set("circuit.c-a", "330 nF").set("circuit.c-b", "22 nF").set("circuit.r-charge", "40 ohm");
        c.set("measure.method", "cerm").set("measure.rate-hz", 100);
        // A reading is that of one discharge, as a tape has it.
        c.set("measure.idle", true);
        c.set("measure.charge-time", "500 us").set("measure.t-l", "10 us");
        c.channel("thumb").lines("channel.thumb", "force = { alpha = \"13346 N ohm\" }").channel("index");
        // Both in the directory that it runs in.
        c.set("server.socket", "socket").set("mock.scene", "scene.toml")
    })
}

/// A line moves at any instant of its slot, so that readings differ; there is no noise that could ever be an outlier.
pub fn scene() -> ConfigFile {
    let mut scene = config::config(|c| {
        c.set("circuit.c-a", "330 nF").set("circuit.c-b", "22 nF").set("circuit.r-o", "40 ohm");
        c.set("circuit.v-dd", "3.3 V").lines("circuit", "threshold = { falling = \"1.3 V\" }")
    });
    scene.set("stamps.mean", "1 us");
    scene.lines("calls", "fixed = \"100 ns\"\nper-line = \"10 ns\"\nmoves-at = [0.0, 1.0]");
    scene.sensor("100 ohm").sensor("2 kohm");
    scene
}

/// A directory with a configuration, a scene and, while it runs, a daemon.
pub struct Daemon {
    pub folder: TempDir,
    child: Option<Child>,
}

impl Daemon {
    pub fn start() -> Daemon {
        Daemon::start_as(&config(), &scene())
    }

    /// With a configuration and a scene.
    pub fn start_as(config: &ConfigFile, scene: &ConfigFile) -> Daemon {
        let mut daemon = Daemon { folder: tempfile::tempdir().unwrap(), child: None };
        fs::write(daemon.path("scene.toml"), scene.to_string()).unwrap();
        fs::write(daemon.path("cermd.toml"), config.to_string()).unwrap();
        daemon.run();
        daemon
    }

    /// Starts it (again), and waits until it answers.
    pub fn run(&mut self) {
        let child = std::process::Command::new(env!("CARGO_BIN_EXE_cermd"))
            .arg("--config")
            .arg(self.path("cermd.toml"))
            .current_dir(self.folder.path())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        self.child = Some(child);
        until_so("a cermd that serves", || UnixStream::connect(self.socket()).is_ok());
    }

    /// As the out-of-memory killer would.
    pub fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }

    pub fn pid(&self) -> u32 {
        self.child.as_ref().unwrap().id()
    }

    /// SIGHUP.
    pub fn reload(&self) {
        kill(Pid::from_raw(self.pid() as i32), Signal::SIGHUP).unwrap();
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
    command
        .args(arguments)
        .env_remove("CERMD_SOCKET")
        .env_remove("COLUMNS")
        .env("LC_ALL", "C")
        .timeout(PATIENCE);
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
        until_so("the end of cermctl", || self.child().try_wait().unwrap().is_some());
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

pub fn lines_of(path: &Path) -> Vec<Value> {
    json_lines(&fs::read(path).unwrap())
}

/// Every line must be whole.
pub fn json_lines(bytes: &[u8]) -> Vec<Value> {
    assert!(bytes.is_empty() || bytes.ends_with(b"\n"), "the last line is not whole");
    let lines = bytes.split_inclusive(|byte| *byte == b'\n');
    lines.map(|line| serde_json::from_slice(line).unwrap()).collect()
}
