//! The lines that this daemon has asked for, kept where the service manager's cleaner finds them after a kill: the file of the
//! configuration may be another one by then, or none.

use super::error::is_of_others;
use crate::config::backend::{self, OpenError};
use crate::config::{Backend, Config};
use crate::files;
use crate::pins::chardev::Wiring;
use crate::pins::output::{self, OutputLine};
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// In the runtime directory.
const NAME: &str = "lines.json";

/// What was asked for.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Requested {
    /// By way of what.
    backend: Backend,
    /// `None`: nothing, the circuit is simulated.
    wiring: Option<Wiring>,
    /// The lines that follow triggers.
    #[serde(default)]
    outputs: Vec<OutputLine>,
}

/// What has become of lines that were to be released.
#[derive(Debug)]
pub enum Released {
    /// Each is an input.
    All,
    /// But for what other programs hold.
    ButOf(OpenError),
    /// The circuit is simulated, there are none.
    Nothing,
}

impl Requested {
    /// What opening this configuration asks for.
    pub fn of(config: &Config) -> Result<Requested, OpenError> {
        let backend = config.gpio.backend;
        let wiring = (backend != Backend::Mock).then(|| backend::wiring(config)).transpose()?;
        let outputs = config.triggers()?.into_iter().filter_map(|trigger| Some(trigger.output?.0)).collect();
        Ok(Requested { backend, wiring, outputs })
    }

    /// To be called before lines are asked for.
    ///
    /// # Errors
    /// It cannot be written; nothing older is left there then.
    pub fn keep(&self, folder: &Path) -> io::Result<()> {
        let path = folder.join(NAME);
        let text = serde_json::to_string(self)?;
        files::replace(&path, &text).inspect_err(|_| drop(std::fs::remove_file(&path)))
    }

    /// What was asked for last; `None`: nobody has kept it.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn last(folder: &Path) -> io::Result<Option<Requested>> {
        match files::read_text(&folder.join(NAME), files::SETTINGS_BYTES) {
            Ok(text) => Ok(Some(serde_json::from_str(&text)?)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Makes each of the lines an input, those of outputs first, which are inactive before they are.
    ///
    /// # Errors
    /// The first line that could not be had, if it is not another program that holds it; all others are inputs all the same.
    pub fn release(&self) -> Result<Released, OpenError> {
        let Some(wiring) = &self.wiring else { return Ok(Released::Nothing) };
        let way = backend::way(self.backend);
        // Each of them, whatever becomes of the others.
        let outputs = output::release_each(&self.outputs, way);
        let of_circuit = backend::release_lines(self.backend, wiring);
        let outputs = outputs.into_iter().map(|outcome| outcome.map_err(OpenError::from));
        let failures = std::iter::once(of_circuit).chain(outputs).filter_map(Result::err);
        match failures.min_by_key(is_of_others) {
            None => Ok(Released::All),
            Some(error) if is_of_others(&error) => Ok(Released::ButOf(error)),
            Some(error) => Err(error),
        }
    }
}

/// Where the service manager keeps files for a service until it has stopped (RuntimeDirectory= of systemd.exec(5)).
pub fn runtime_directory() -> Option<PathBuf> {
    let folders = std::env::var_os("RUNTIME_DIRECTORY")?;
    std::env::split_paths(&folders).next().filter(|folder| folder.is_absolute())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped() -> Config {
        Config::parse(include_str!("../../hw/cermd.toml"), "hw/cermd.toml").unwrap()
    }

    #[test]
    fn what_was_asked_for_is_found_again() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Requested::last(folder.path()).unwrap(), None);
        let mut config = shipped();
        let hardware = Requested::of(&config).unwrap();
        hardware.keep(folder.path()).unwrap();
        assert_eq!(Requested::last(folder.path()).unwrap(), Some(hardware));
        config.gpio.backend = Backend::Mock;
        let simulated = Requested::of(&config).unwrap();
        simulated.keep(folder.path()).unwrap();
        let last = Requested::last(folder.path()).unwrap().unwrap();
        assert!(last == simulated && matches!(last.release(), Ok(Released::Nothing)));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn lines_of_a_chip_that_is_gone_are_an_error() {
        let mut config = shipped();
        config.gpio.chip = Some("no-such-chip".to_owned());
        let error = Requested::of(&config).unwrap().release().unwrap_err().to_string();
        assert!(error.contains("no-such-chip"), "{error}");
    }

    #[test]
    fn what_is_damaged_is_no_silence() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(NAME), "{").unwrap();
        assert!(Requested::last(folder.path()).is_err());
    }
}
