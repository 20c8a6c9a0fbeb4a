//! The socket that is served. A service waits for what is in its way to go: its manager would only start it again and again.

use super::error::{DaemonError, system};
use super::limits::LISTEN_AGAIN;
use super::{Loaded, Signals, is_service, notify, readable, reloaded, wait_for};
use crate::stream::server::{ListenError, Listener};
use sd_notify::NotifyState;
use std::os::fd::AsFd;
use std::path::Path;

/// A socket that clients can connect to, and its name for the log.
#[derive(Debug)]
pub struct Listening {
    pub(super) listener: Listener,
    pub(super) place: String,
}

impl Listening {
    /// Binds the socket of the configuration.
    ///
    /// # Errors
    /// What is in the way.
    pub fn new(loaded: &Loaded) -> Result<Listening, ListenError> {
        let server = &loaded.config.server;
        let listener = Listener::bind(&server.socket, server.mode)?;
        Ok(Listening { listener, place: server.socket.display().to_string() })
    }

    /// The socket that systemd has passed, or else that of the configuration as soon as nothing is in its way any more; SIGHUP reads the
    /// file again. `None`: a signal has asked for the end before.
    pub(super) fn of_service(
        loaded: &mut Loaded,
        path: &Path,
        signals: &mut Signals,
    ) -> Result<Option<Listening>, DaemonError> {
        // What systemd passes is the same at each start.
        let passed = Listener::from_systemd().map_err(|error| DaemonError::NotUsable(error.to_string()))?;
        if let Some(listener) = passed {
            return Ok(Some(Listening { listener, place: "the socket passed by systemd".to_owned() }));
        }
        let mut said = String::new();
        loop {
            let error = match Listening::new(loaded) {
                Ok(listening) => return Ok(Some(listening)),
                Err(error) if !is_service() => return Err(error.into()),
                Err(error) => error.to_string(),
            };
            if said != error {
                log::error!("{error}; trying again every {} ms", LISTEN_AGAIN.as_millis());
            }
            let status = format!("no socket: {error}");
            notify(&[NotifyState::Ready, NotifyState::Status(&status), NotifyState::Watchdog]);
            said = error;
            wait_for(&mut [readable(signals.as_fd())], LISTEN_AGAIN).map_err(system("poll"))?;
            let asked = signals.take();
            if asked.end {
                return Ok(None);
            }
            if let Some(new) = asked.reload.then(|| reloaded(path)).flatten() {
                *loaded = new;
            }
        }
    }
}
