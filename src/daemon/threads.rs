//! The threads that do the work, begun and ended together: one measures, one watches triggers if there are any.

use super::error::system;
use super::measuring::{Measuring, Stuck};
use super::requested::{self, Requested};
use super::triggering::{self, ChannelEvent, Triggering};
use super::{DaemonError, Loaded};
use crate::config::backend::{self, AnyPins, OpenError};
use crate::pins::monotonic;
use crate::pins::output::Output;
use std::os::fd::{AsFd, BorrowedFd};

/// Both threads. Dropping them ends them: outputs first, so that these are inactive before anything else ends.
#[derive(Debug)]
pub struct Threads {
    /// `None`: no channel has a trigger.
    triggering: Option<Triggering>,
    /// Runs the instrument.
    pub measuring: Measuring,
}

/// The outputs of triggers, in their order; `None`: there is none, or it is to be tried again.
pub type Outputs = Vec<Option<Output>>;

impl Threads {
    /// Begins to measure. Without pins, by saying why, and trying to open them.
    ///
    /// # Errors
    /// The system has no descriptor or thread left.
    pub fn start(
        pins: Result<AnyPins, OpenError>,
        outputs: Outputs,
        loaded: &Loaded,
    ) -> Result<Threads, DaemonError> {
        for blind_spot in pins.iter().flat_map(|pins| pins.particulars().blind_spots) {
            log::info!("{blind_spot}");
        }
        let (config, triggers) = (&loaded.config, &loaded.triggers);
        let start = || {
            let way = backend::way(config.gpio.backend);
            Triggering::start(triggers.clone(), outputs, way, &config.realtime).map_err(system("thread"))
        };
        let started = if triggers.is_empty() { None } else { Some(start()?) };
        let (triggering, tap) = started.unzip();
        let measuring = Measuring::start(pins, config.clone(), loaded.settings.clone(), tap);
        Ok(Threads { triggering, measuring: measuring.map_err(system("thread"))? })
    }

    /// Ends both, outputs first; every line is an input then. What was measured, and that no trigger is known any more, can still
    /// be read.
    ///
    /// # Errors
    /// The measuring thread hangs.
    pub fn stop(&mut self) -> Result<(), Stuck> {
        self.triggering.iter_mut().for_each(Triggering::stop);
        self.measuring.stop()
    }

    /// Readable when there is something to tell.
    pub fn descriptors(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        let triggering = self.triggering.iter().map(|triggering| triggering.wake().as_fd());
        triggering.chain([self.measuring.wake().as_fd()])
    }

    /// The events since the last call.
    pub fn events(&mut self) -> Vec<ChannelEvent> {
        self.triggering.as_mut().map(Triggering::take).unwrap_or_default()
    }

    /// Each changes while its thread is alive and not stuck.
    pub fn beats(&self) -> [u64; 2] {
        let beat = self.measuring.beat();
        [beat, self.triggering.as_ref().map_or(beat, Triggering::beat)]
    }

    /// Whether one has ended by itself, which it never should.
    pub fn have_ended(&self) -> bool {
        self.triggering.as_ref().is_some_and(Triggering::has_ended) || self.measuring.has_ended()
    }
}

/// The lines of the circuit. The cleaner finds what is asked for, if the service manager has a place for it.
///
/// # Errors
/// What is wrong with the hardware.
pub fn open(loaded: &Loaded) -> Result<AnyPins, OpenError> {
    if let Some(folder) = requested::runtime_directory() {
        if let Err(error) = Requested::of(&loaded.config)?.keep(&folder) {
            let until =
                "after a kill those of the configuration file are released, whatever it names by then";
            log::warn!("{}: the lines are not kept: {error}; {until}", folder.display());
        }
    }
    backend::open(&loaded.config, monotonic())
}

/// The lines of the triggers, each inactive.
///
/// # Errors
/// The first one that cannot be had.
pub fn open_outputs(loaded: &Loaded) -> Result<Outputs, OpenError> {
    Ok(triggering::open(&loaded.triggers, backend::way(loaded.config.gpio.backend))?)
}

/// All of them to be tried again.
pub fn no_outputs(loaded: &Loaded) -> Outputs {
    loaded.triggers.iter().map(|_| None).collect()
}
