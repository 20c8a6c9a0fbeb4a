//! The daemon: the measuring thread, the server, signals, and the service manager, tied together.
//!
//! For: the only place with threads and the only one that knows that time passes by itself. Must not know: equations,
//! the format of lines, or what a line of GPIO is.
//!
//! The main thread waits in one `poll` for the server, for results and for signals. The measuring thread never waits
//! for it.

mod ending;
mod error;
mod heartbeat;
mod limits;
mod listening;
mod measuring;
pub(crate) mod publish;
mod requested;
pub(crate) mod rounds;
mod signals;
mod threads;
mod triggering;

use crate::config::backend::{self, AnyPins, OpenError};
use crate::config::{Backend, Config, Severity, TriggerSettings, tape_header};
use crate::instrument::settings::Settings;
use crate::pins::{clock, monotonic};
use crate::stream::server::{Limits, Server};
use crate::stream::tape::{Header, TapeLooks};
use crate::units::Nanos;
pub use error::DaemonError;
use error::{is_held, system};
use heartbeat::Heartbeat;
use limits::LOOK_AFTER;
pub use listening::Listening;
use measuring::{Lost, Update};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::time::ClockId;
use publish::Known;
pub use requested::Released;
use requested::Requested;
use sd_notify::NotifyState;
pub use signals::{Signalled, Signals, StopHandle};
use std::env;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::path::Path;
use std::time::Duration;
use threads::{Threads, no_outputs, open, open_outputs};

/// What is said when a reload fails.
const KEPT: &str = "the old configuration stays in force";

/// A configuration that has passed its check, with every file that it names.
#[derive(Debug, Clone)]
pub struct Loaded {
    config: Config,
    settings: Settings,
    triggers: Vec<TriggerSettings>,
    /// Of a tape that begins now, but for an offset that was found since.
    tape_header: Header,
}

impl Loaded {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its remedy.
    pub fn load(path: &Path) -> Result<Loaded, DaemonError> {
        Loaded::new(Config::load(path)?, path)
    }

    /// Checks a configuration; `path` names it in messages.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its remedy.
    pub fn new(config: Config, path: &Path) -> Result<Loaded, DaemonError> {
        let findings = config.check();
        if findings.has_errors() {
            let errors = findings.errors();
            return Err(DaemonError::NotUsable(format!("{}: not usable\n{errors}", path.display())));
        }
        for finding in findings.of(Severity::Warning) {
            log::warn!("{finding}");
        }
        if config.gpio.backend == Backend::Mock {
            backend::scene(&config)?;
        }
        let (settings, triggers) = (config.settings()?, config.triggers()?);
        Ok(Loaded { tape_header: tape_header(&settings, None), settings, triggers, config })
    }
}

/// Runs until SIGTERM or SIGINT; SIGHUP reads the file again.
///
/// # Errors
/// What keeps it from starting, or from going on. Every line is released.
pub fn run(path: &Path) -> Result<(), DaemonError> {
    let mut signals = Signals::new().map_err(system("signals"))?;
    let mut loaded = Loaded::load(path)?;
    let Some(listening) = Listening::of_service(&mut loaded, path, &mut signals)? else { return Ok(()) };
    let started = Daemon::start(loaded, listening, signals, open).inspect_err(|error| {
        // To the service manager that is no failure, as a condition of its own would be none: ready, and over.
        if error.is_absent() {
            notify(&[NotifyState::Ready, NotifyState::Status(&error.to_string())]);
        }
    });
    started?.serve(Some(path))
}

/// The parts of a running daemon.
#[derive(Debug)]
pub struct Daemon {
    // Before the server: no reading is published any more when the socket goes.
    threads: Threads,
    server: Server,
    signals: Signals,
    loaded: Loaded,
    known: Known,
    started: Nanos,
    heartbeat: Heartbeat,
    /// Whether the service manager waits for signs of life.
    has_watchdog: bool,
}

impl Daemon {
    /// Has the pins opened by `open`, starts to measure, and tells the service manager that it is
    /// ready.
    ///
    /// # Errors
    /// What is missing.
    pub fn start(
        loaded: Loaded,
        listening: Listening,
        signals: Signals,
        open: impl FnOnce(&Loaded) -> Result<AnyPins, OpenError>,
    ) -> Result<Daemon, DaemonError> {
        let Listening { listener, place } = listening;
        let channels = publish::channels(&loaded);
        let mut server =
            Server::new(listener, &channels, Limits::of_this_process()).map_err(system("epoll"))?;
        server.set_tape_header(&loaded.tape_header);
        let pins = waited_for(open(&loaded))?;
        let outputs = waited_for(open_outputs(&loaded))?.unwrap_or_else(|_| no_outputs(&loaded));
        let known = Known::of(&pins);
        let threads = Threads::start(pins, outputs, &loaded)?;
        log::info!("serving {} channel(s) on {place}", loaded.config.channels.len());
        let watchdog = sd_notify::watchdog_enabled();
        notify(&[NotifyState::Ready, NotifyState::Status(&known.away_or("measuring"))]);
        Ok(Daemon {
            threads,
            server,
            signals,
            loaded,
            known,
            started: monotonic(),
            heartbeat: Heartbeat::new(watchdog),
            has_watchdog: watchdog.is_some(),
        })
    }

    /// Serves until a signal asks for the end. `path`: what SIGHUP reads again.
    ///
    /// # Errors
    /// The measuring thread or the system has failed.
    pub fn serve(&mut self, path: Option<&Path>) -> Result<(), DaemonError> {
        loop {
            let [clients, signals] = self.wait().map_err(system("poll"))?;
            self.publish();
            let now = monotonic();
            let uptime = now - self.started;
            let stats = || publish::stats(&self.known, &self.loaded.config, uptime);
            // Each call into the kernel that a reading does without is time that the next one has.
            if clients || self.server.wake_at().is_some_and(|at| now >= at) {
                self.server.turn(now, &stats).map_err(system("epoll_wait"))?;
            } else {
                self.server.tell(&stats);
            }
            self.threads.measuring.set_watched(self.server.is_watched());
            let asked = if signals { self.signals.take() } else { Signalled::default() };
            if asked.end {
                notify(&[NotifyState::Stopping, NotifyState::Status("stopping")]);
                log::info!(
                    "stopping: {} readings in {:.0} s",
                    self.known.stats.readings,
                    (now - self.started).as_seconds()
                );
                return Ok(());
            }
            if let (true, Some(path)) = (asked.reload, path) {
                self.reload(path)?;
            }
            if self.threads.have_ended() {
                return Err(DaemonError::Died);
            }
            self.give_sign_of_life(now);
        }
    }

    /// Until there is something to do; whether clients or signals are a part of it.
    fn wait(&self) -> io::Result<[bool; 2]> {
        let mut descriptors = vec![readable(self.server.as_fd()), readable(self.signals.as_fd())];
        descriptors.extend(self.threads.descriptors().map(readable));
        let now = monotonic();
        let until = self.server.wake_at().map(|at| Duration::from_nanos((at - now).0.max(0) as u64));
        let timeout = until.unwrap_or(LOOK_AFTER).min(LOOK_AFTER).min(self.heartbeat.patience(now));
        wait_for(&mut descriptors, timeout)?;
        Ok([0, 1].map(|index| descriptors[index].any().unwrap_or(true)))
    }

    fn publish(&mut self) {
        // Empty when nothing was written since: that is no error.
        let _ = self.threads.measuring.wake().read();
        // Of readings that are in the ring by now, and are told first.
        let events = self.threads.events();
        let (before, found_before) = (self.known.stats, self.known.found);
        let to_wall = clock(ClockId::CLOCK_REALTIME) - monotonic();
        let mut lost = Lost::default();
        while let Some(update) = self.threads.measuring.next() {
            if let Update::Lost(some) = &update {
                lost.add(*some);
            }
            publish::publish(&mut self.server, &mut self.known, &self.loaded, update, to_wall);
        }
        for told in events {
            publish::publish_event(&mut self.server, &self.loaded, &told, to_wall);
        }
        if lost.is_some() {
            let Lost { readings, discharges } = lost;
            log::warn!(
                "{readings} readings and {discharges} discharges were lost: this process gets too little time"
            );
        }
        let found = self.known.stats;
        let is_found = found.offset_is_known && !before.offset_is_known;
        if is_found {
            publish::log_offset(&found);
        }
        // The offset is followed, and what looks show; a tape that is being recorded keeps what it began with.
        let has_changed = found.offset != before.offset || self.known.found != found_before;
        if is_found || (has_changed && !self.server.wants_raw()) {
            self.announce_tape_header();
        }
    }

    /// With the offset as soon as it is known, and what looks have found: a tape that begins later holds no split discharges, and too
    /// few looks, to find them from.
    fn announce_tape_header(&mut self) {
        let stats = &self.known.stats;
        let found = stats.offset_is_known.then_some(stats.offset);
        let looks = TapeLooks::of(&self.known.found);
        let header = Header { looks, ..tape_header(&self.loaded.settings, found) };
        self.server.set_tape_header(&header);
    }

    /// Reads the configuration again.
    fn reload(&mut self, path: &Path) -> Result<(), DaemonError> {
        let result = reloaded(path).map_or(Ok(()), |loaded| self.change_to(loaded));
        notify(&[NotifyState::Ready]);
        result
    }

    fn change_to(&mut self, loaded: Loaded) -> Result<(), DaemonError> {
        if loaded.config.server != self.loaded.config.server {
            log::warn!("[server] takes effect at the next start: the socket stays where it is");
        }
        // The lines of the old configuration are released before those of the new one are asked for, and its last
        // readings are published under its own channels.
        self.threads.stop()?;
        self.publish();
        match open(&loaded).and_then(|pins| Ok((pins, open_outputs(&loaded)?))) {
            Ok((pins, outputs)) => {
                self.threads = Threads::start(Ok(pins), outputs, &loaded)?;
                self.loaded = loaded;
                self.known = Known::default();
                log::info!(
                    "the new configuration is in force: {} channel(s)",
                    self.loaded.config.channels.len()
                );
            }
            Err(error) => {
                log::error!("{KEPT}: {error}");
                let pins = open(&self.loaded);
                self.known = Known::of(&pins);
                // The outputs are tried again, too.
                self.threads = Threads::start(pins, no_outputs(&self.loaded), &self.loaded)?;
            }
        }
        // Also where they are as they were: readings and discharges begin anew.
        self.server.set_channels(&publish::channels(&self.loaded));
        self.announce_tape_header();
        Ok(())
    }

    /// Only while the threads go on that do the work: one that is stuck must be found by the service manager.
    fn give_sign_of_life(&mut self, now: Nanos) {
        if !self.heartbeat.is_due(now, self.threads.beats()) {
            return;
        }
        let stats = &self.known.stats;
        let (faults, clients) = (stats.faults.iter().sum::<u64>(), self.server.clients());
        // One line for `systemctl status`.
        let counts = format!("{} readings, {faults} faults, {clients} clients", stats.readings);
        let status = self.known.away_or(&counts);
        let states = [NotifyState::Status(&status), NotifyState::Watchdog];
        notify(if self.has_watchdog { &states } else { &states[..1] });
    }
}

fn readable(descriptor: BorrowedFd<'_>) -> PollFd<'_> {
    PollFd::new(descriptor, PollFlags::POLLIN)
}

/// Until one of them is, a signal has come or the time is over.
fn wait_for(descriptors: &mut [PollFd<'_>], timeout: Duration) -> io::Result<()> {
    match poll(descriptors, PollTimeout::try_from(timeout).unwrap_or(PollTimeout::MAX)) {
        Ok(_) | Err(nix::errno::Errno::EINTR) => Ok(()),
        Err(errno) => Err(errno.into()),
    }
}

/// Reads the configuration again; `None` where it is wrong, which leaves everything as it is. The service manager waits for READY=1
/// after that: sd_notify(3) on RELOADING=1.
fn reloaded(path: &Path) -> Option<Loaded> {
    log::info!("reading {} again", path.display());
    if let Ok(now) = NotifyState::monotonic_usec_now() {
        notify(&[NotifyState::Reloading, now]);
    }
    Loaded::load(path).inspect_err(|error| log::error!("{KEPT}: {error}")).ok()
}

/// Makes lines inputs, for after a kill: those that were asked for, as the runtime directory says; where nobody has kept
/// them, those of the configuration.
///
/// # Errors
/// The configuration cannot be read, or a line could not be had that no other program holds; all others are inputs all the same.
pub fn release_lines(path: &Path) -> Result<Released, DaemonError> {
    let kept = requested::runtime_directory().and_then(|folder| {
        let complain =
            |error: &io::Error| log::warn!("{}: the lines that were kept: {error}", folder.display());
        Requested::last(&folder).inspect_err(complain).ok().flatten()
    });
    let requested = match kept {
        Some(requested) => requested,
        None => Requested::of(&Config::load(path)?)?,
    };
    Ok(requested.release()?)
}

/// `Ok(Err)`: another program holds a line, and this is a service, which starts and tries again: its manager would only do that
/// for it, without end. By hand it is better told at once.
fn waited_for<T>(opened: Result<T, OpenError>) -> Result<Result<T, OpenError>, OpenError> {
    match opened {
        Err(error) if !is_held(&error) || !is_service() => Err(error),
        opened => Ok(opened),
    }
}

/// Whether a service manager has started this, and hears what is the matter.
fn is_service() -> bool {
    env::var_os("NOTIFY_SOCKET").is_some()
}

/// Without a service manager nobody listens, and that is no error.
fn notify(states: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(states) {
        log::debug!("sd_notify: {error}");
    }
}
