//! The real daemon as a child process, on a simulated circuit, in a directory of its own.

use crate::common::config::{self, ConfigFile};
use crate::waiting::{PATIENCE, until, until_so};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

/// Where a daemon lives: its configuration, its socket and its log.
pub struct Home {
    directory: tempfile::TempDir,
}

/// A configuration of the simulated Pi 4, with small capacitors for fast readings and channels of these names, which
/// listens in the same directory.
pub fn config(channels: &[&str], measure: &str) -> ConfigFile {
    config::config(|c| {
        c.set("circuit.c-a", "100 nF").set("circuit.c-b", "33 nF").set("circuit.v-th", "1.1 V");
        c.set("gpio.backend", "mock").lines("measure", measure);
        // Both in the directory that it runs in.
        c.set("server.socket", "s").set("server.mode", "0600").set("mock.scene", "fast.toml");
        channels.iter().fold(c, |c, id| c.channel(id))
    })
}

impl Home {
    pub fn new(config: &ConfigFile) -> Home {
        let home = Home { directory: tempfile::tempdir().unwrap() };
        let mut fast = ConfigFile::of(include_str!("../../../hw/scenes/pi4.toml"));
        fast.set("circuit.c-a", "100 nF").set("circuit.c-b", "33 nF");
        fs::write(home.path().join("fast.toml"), fast.to_string()).unwrap();
        home.configure(config);
        home
    }

    /// Writes the configuration file, whatever that is.
    pub fn configure(&self, config: impl ToString) {
        fs::write(self.config(), config.to_string()).unwrap();
    }

    pub fn path(&self) -> &Path {
        self.directory.path()
    }

    pub fn config(&self) -> PathBuf {
        self.path().join("cermd.toml")
    }

    pub fn socket(&self) -> PathBuf {
        self.path().join("s")
    }

    pub fn log_file(&self) -> PathBuf {
        self.path().join("log")
    }

    /// All that its daemons have said so far.
    pub fn log(&self) -> String {
        fs::read_to_string(self.log_file()).unwrap_or_default()
    }

    /// The program with its configuration, its log in the file, and nothing of a service manager.
    pub fn command(&self) -> Command {
        let mut command = self.within(program());
        command.arg("--config").arg(self.config());
        command
    }

    /// In its directory, and heard by its log.
    pub fn within(&self, mut command: Command) -> Command {
        command.current_dir(self.path());
        command.stderr(File::options().create(true).append(true).open(self.log_file()).unwrap());
        command
    }

    pub fn start(&self) -> Daemon {
        Daemon::spawn(&mut self.command())
    }

    /// Connects as soon as somebody listens.
    pub fn connect(&self) -> Stream {
        let socket = until("a connection", || UnixStream::connect(self.socket()).ok());
        Stream::new(socket)
    }

    pub fn wait_for_log(&self, text: &str) {
        until_so(text, || self.log().contains(text));
    }
}

/// The daemon's program, without arguments and without the environment of a service manager.
pub fn program() -> Command {
    unmanaged(Path::new(env!("CARGO_BIN_EXE_cermd")))
}

/// Any program, without the environment of a service manager.
pub fn unmanaged(program: &Path) -> Command {
    let mut command = Command::new(program);
    for name in
        ["NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID", "LISTEN_FDS", "LISTEN_PID", "JOURNAL_STREAM"]
    {
        command.env_remove(name);
    }
    command.env_remove("RUST_LOG").stdout(Stdio::null());
    command
}

/// A running daemon; killed when it goes out of scope.
pub struct Daemon(Child);

impl Daemon {
    pub fn spawn(command: &mut Command) -> Daemon {
        Daemon(command.spawn().unwrap())
    }

    pub fn pid(&self) -> u32 {
        self.0.id()
    }

    pub fn signal(&self, signal: Signal) {
        kill(Pid::from_raw(self.pid() as i32), signal).unwrap();
    }

    pub fn has_ended(&mut self) -> bool {
        self.0.try_wait().unwrap().is_some()
    }

    /// Waits for its end.
    pub fn end(mut self) -> ExitStatus {
        until("the end of the daemon", || self.0.try_wait().unwrap())
    }

    /// A figure of /proc/PID/status, KiB.
    pub fn memory_kib(&self, key: &str) -> u64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.pid())).unwrap();
        let line = status.lines().find(|line| line.starts_with(key)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // Both fail only if it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A client that takes every line for what it must be: one whole JSON object.
pub struct Stream(BufReader<UnixStream>);

impl Stream {
    fn new(socket: UnixStream) -> Stream {
        socket.set_read_timeout(Some(PATIENCE)).unwrap();
        Stream(BufReader::new(socket))
    }

    /// The next line; `None` at the end of the stream.
    pub fn next(&mut self) -> Option<Value> {
        let mut line = String::new();
        match self.0.read_line(&mut line) {
            Ok(0) => return None,
            // The daemon was killed with requests of ours unread: unix(7).
            Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => return None,
            Ok(_) => {}
            Err(error) => panic!("{error}"),
        }
        assert!(line.ends_with('\n'), "half a line: {line:?}");
        Some(serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line:?}: {error}")))
    }

    /// The next line of a class, passing over others.
    pub fn next_of(&mut self, class: &str) -> Value {
        loop {
            let line = self.next().unwrap_or_else(|| panic!("the stream ended before a {class}"));
            if line["class"] == class {
                return line;
            }
        }
    }

    pub fn send(&mut self, line: &str) {
        use std::io::Write;
        writeln!(self.0.get_mut(), "{line}").unwrap();
    }

    /// Reads to the end; how many lines there were.
    pub fn drain(&mut self) -> usize {
        std::iter::from_fn(|| self.next()).count()
    }
}

pub mod notify {
    //! A service manager's end of sd_notify(3).

    use super::Home;
    use crate::waiting::PATIENCE;
    use std::cell::RefCell;
    use std::os::unix::net::UnixDatagram;
    use std::path::PathBuf;
    use std::process::Command;

    pub struct Manager {
        path: PathBuf,
        socket: UnixDatagram,
        seen: RefCell<Vec<String>>,
    }

    impl Manager {
        pub fn new(home: &Home) -> Manager {
            let path = home.path().join("notify");
            let socket = UnixDatagram::bind(&path).unwrap();
            socket.set_read_timeout(Some(PATIENCE)).unwrap();
            Manager { path, socket, seen: RefCell::default() }
        }

        pub fn watch(&self, command: &mut Command) {
            command.env("NOTIFY_SOCKET", &self.path);
        }

        /// The next message that holds this line.
        pub fn wait_for(&self, line: &str) -> String {
            self.wait_for_one(line, |message| message.lines().any(|found| found == line))
        }

        /// The next message of which that is so.
        pub fn wait_for_one(&self, what: &str, is_it: impl Fn(&str) -> bool) -> String {
            loop {
                let mut bytes = [0; 4096];
                let length = match self.socket.recv(&mut bytes) {
                    Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
                    result => result.unwrap_or_else(|error| panic!("no {what}: {error}")),
                };
                let message = String::from_utf8(bytes[..length].to_vec()).unwrap();
                self.seen.borrow_mut().push(message.clone());
                if is_it(&message) {
                    return message;
                }
            }
        }

        /// All messages so far.
        pub fn messages(&self) -> Vec<String> {
            self.seen.borrow().clone()
        }
    }
}
