//! The measuring thread: it runs the instrument and never waits for anybody. Results leave through a ring, and an event
//! descriptor wakes whoever reads it.
//!
//! In the loop nothing is allocated, logged or locked. A full ring loses results and counts them.

mod interruptible;

use super::ending::{self, Hung};
use super::limits::{NAP, NAPS_TO_REOPEN, RING, STATS_EVERY, TAKEN_APART};
use super::triggering::Tap;
use crate::config::Config;
use crate::config::backend::{self, AnyPins, OpenError};
use crate::estimate::look::Found;
use crate::instrument::settings::Settings;
use crate::instrument::stats::Stats;
use crate::instrument::{Instrument, Message};
use crate::pins::realtime::{self, Realtime};
use crate::pins::{Pins, PinsError};
use crate::units::Nanos;
use interruptible::Interruptible;
use nix::sys::eventfd::{EfdFlags, EventFd};
use rtrb::{Consumer, Producer, PushError, RingBuffer};
use std::io;
use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// What the measuring thread tells.
#[derive(Debug)]
pub enum Update {
    /// A reading or a discharge.
    Message(Message),
    /// What a full ring has lost between the update before and the next one.
    Lost(Lost),
    /// What became of the wishes of `[realtime]`. Comes first.
    Realtime(realtime::Rights),
    /// What looks have found, for tapes that begin now; before the counters.
    Found(Found),
    /// Counters, from time to time.
    Stats(Stats),
    /// The pins failed; they are opened again by and by.
    Failed(PinsError),
    /// They cannot be opened.
    NotOpened(OpenError),
    /// They work again: a cycle has been finished.
    Recovered,
}

/// Messages that found no room.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lost {
    /// Readings.
    pub readings: u64,
    /// Discharges.
    pub discharges: u64,
}

impl Lost {
    /// Whether there are any.
    pub fn is_some(&self) -> bool {
        *self != Lost::default()
    }

    /// Counts those of another gap, too.
    pub fn add(&mut self, other: Lost) {
        self.readings += other.readings;
        self.discharges += other.discharges;
    }

    fn count(&mut self, update: &Update) {
        match update {
            Update::Message(Message::Reading(_)) => self.readings += 1,
            Update::Message(Message::Discharge { .. }) => self.discharges += 1,
            _ => {}
        }
    }
}

/// What both sides share.
#[derive(Debug)]
struct Shared {
    stop: AtomicBool,
    beat: AtomicU64,
    /// Whether a reading wakes whoever reads the ring.
    watched: AtomicBool,
    wake: EventFd,
}

impl Shared {
    /// Whether the thread is to stop; each look is a sign of life.
    fn is_stopped(&self) -> bool {
        self.beat.fetch_add(1, Ordering::Relaxed);
        self.stop.load(Ordering::Relaxed)
    }
}

/// The measuring thread does not end.
#[derive(Debug, thiserror::Error)]
#[error(
    "the measuring thread hangs in a call of its pins: it is left behind, and its lines are released with this process"
)]
pub struct Stuck;

/// A running measurement. Dropping it stops the thread; every line is released before the thread ends.
#[derive(Debug)]
pub struct Measuring {
    shared: Arc<Shared>,
    results: Consumer<Update>,
    /// What the thread could not tell any more.
    left: Lost,
    thread: Option<JoinHandle<Lost>>,
}

impl Measuring {
    /// Starts to measure. Without pins, it says why, and tries to open them again. `tap`: who gets readings besides.
    ///
    /// # Errors
    /// The system has no descriptor or thread left.
    pub fn start(
        pins: Result<AnyPins, OpenError>,
        config: Config,
        settings: Settings,
        tap: Option<Tap>,
    ) -> io::Result<Measuring> {
        let (sender, results) = RingBuffer::new(RING);
        let shared = Arc::new(Shared {
            stop: AtomicBool::new(false),
            beat: AtomicU64::new(0),
            watched: AtomicBool::new(true),
            wake: EventFd::from_flags(EfdFlags::EFD_CLOEXEC | EfdFlags::EFD_NONBLOCK)?,
        });
        let lost = Lost::default();
        let mut worker = Worker { shared: Arc::clone(&shared), sender, lost, tap, config, said: None };
        let thread = thread::Builder::new().name("cermd-measure".to_owned()).spawn(move || {
            worker.run(pins, settings);
            worker.lost
        })?;
        Ok(Measuring { shared, results, left: lost, thread: Some(thread) })
    }

    /// Readable when there are results.
    pub fn wake(&self) -> &EventFd {
        &self.shared.wake
    }

    /// The next result, if there is one.
    pub fn next(&mut self) -> Option<Update> {
        self.results.pop().ok().or_else(|| {
            let left = std::mem::take(&mut self.left);
            left.is_some().then_some(Update::Lost(left))
        })
    }

    /// Whether readings are urgent: if nobody waits for them they are only kept, and come with the next counters.
    pub fn set_watched(&self, watched: bool) {
        let was_watched = self.shared.watched.swap(watched, Ordering::Relaxed);
        if watched && !was_watched {
            // What was kept until now is urgent from now on.
            let _ = self.shared.wake.write(1);
        }
    }

    /// Changes while the thread is alive and not stuck.
    pub fn beat(&self) -> u64 {
        self.shared.beat.load(Ordering::Relaxed)
    }

    /// Whether the thread has ended by itself, which it never should.
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Stops the thread and waits for its end; every line is released then. What it has told can still be read.
    ///
    /// # Errors
    /// It does not end: a call of it hangs in the kernel. Its lines are released when the process ends.
    pub fn stop(&mut self) -> Result<(), Stuck> {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(left) = ending::end(&mut self.thread).map_err(|Hung| Stuck)? {
            self.left = left;
        }
        Ok(())
    }
}

impl Drop for Measuring {
    fn drop(&mut self) {
        if let Err(error) = self.stop() {
            log::error!("{error}");
        }
    }
}

struct Worker {
    shared: Arc<Shared>,
    sender: Producer<Update>,
    /// What has found no room since the last update that did.
    lost: Lost,
    tap: Option<Tap>,
    config: Config,
    /// What was said last about pins that do not work; `None` while they do.
    said: Option<String>,
}

impl Worker {
    fn run(&mut self, pins: Result<AnyPins, OpenError>, settings: Settings) {
        // Rights are the thread's own, and held as long as it lives.
        let realtime = Realtime::request(&self.config.realtime);
        self.send(Update::Realtime(realtime.rights.clone()));
        let pins = pins.map_err(|error| self.complain(error.to_string(), Update::NotOpened(error)));
        let shared = Arc::clone(&self.shared);
        let mut instrument = Instrument::new(Interruptible { pins: pins.ok(), shared }, settings);
        if instrument.pins().pins.is_none() {
            self.reopen(&mut instrument);
        }
        let mut stats_due = Nanos::ZERO;
        let mut offset_was_known = false;
        // Those without pins count, too.
        let mut cycles_before = instrument.stats().cycles;
        while !self.shared.is_stopped() {
            let result = instrument.step(&mut |message| self.tell(message));
            if let Err(error) = result {
                if matches!(error, PinsError::Stopped) {
                    return;
                }
                if matches!(error, PinsError::Gone { .. }) {
                    // The lines drive no more. This thread is told in the middle of the chip's removal, with a priority
                    // above it; a line closed there makes the kernel (7.3) warn in free_irq.
                    thread::sleep(TAKEN_APART);
                }
                self.complain(error.to_string(), Update::Failed(error));
                // The faults are counted, and it may be long until the next word.
                self.tell_stats(&instrument);
                self.reopen(&mut instrument);
                cycles_before = instrument.stats().cycles;
            }
            if self.said.is_some()
                && instrument.stats().cycles > cycles_before
                && self.send(Update::Recovered)
            {
                self.said = None;
            }
            let now = instrument.pins().now();
            let offset_is_known = instrument.cycle().offset_is_known();
            if now >= stats_due || offset_is_known != offset_was_known {
                stats_due = now + STATS_EVERY;
                offset_was_known = offset_is_known;
                self.tell_stats(&instrument);
            }
        }
    }

    fn tell_stats(&mut self, instrument: &Instrument<Interruptible>) {
        self.send(Update::Found(instrument.cycle().found()));
        self.send(Update::Stats(instrument.stats()));
    }

    /// Opens the pins again until that works or the thread is to stop. What was learned stays.
    fn reopen(&mut self, instrument: &mut Instrument<Interruptible>) {
        // The old pins go first: a line has one holder at a time.
        instrument.pins().pins = None;
        loop {
            for _ in 0..NAPS_TO_REOPEN {
                if self.shared.is_stopped() {
                    return;
                }
                thread::sleep(Duration::from_nanos(NAP.0.unsigned_abs()));
            }
            let now = instrument.pins().now();
            match backend::open(&self.config, now) {
                Ok(pins) => {
                    instrument.pins().pins = Some(pins);
                    return;
                }
                Err(error) => self.complain(error.to_string(), Update::NotOpened(error)),
            }
            // Silence would look like a daemon that hangs.
            instrument.report_failure(&mut |message| self.tell(message));
            self.tell_stats(instrument);
        }
    }

    /// Says why the pins do not work, unless that was said last: the same reason every second would fill the log.
    fn complain(&mut self, why: String, update: Update) {
        if self.said.as_ref() != Some(&why) && self.send(update) {
            self.said = Some(why);
        }
    }

    fn tell(&mut self, message: Message) {
        let reading = match &message {
            Message::Reading(reading) => Some(*reading),
            Message::Discharge { .. } => None,
        };
        self.push(Update::Message(message));
        // After the main thread: it is to tell of a reading before what follows from it.
        if let (Some(reading), Some(tap)) = (&reading, &mut self.tap) {
            tap.give(reading);
        }
        // A discharge waits for the reading that it leads to.
        if reading.is_some() && self.shared.watched.load(Ordering::Relaxed) {
            self.wake();
        }
    }

    /// Returns whether there was room.
    fn send(&mut self, update: Update) -> bool {
        let has_room = self.push(update);
        self.wake();
        has_room
    }

    /// What was lost goes before the next that finds room: it stands where the gap is.
    fn push(&mut self, update: Update) -> bool {
        if self.lost.is_some() {
            if self.sender.slots() < 2 {
                self.lost.count(&update);
                return false;
            }
            let _ = self.sender.push(Update::Lost(mem::take(&mut self.lost)));
        }
        let Err(PushError::Full(update)) = self.sender.push(update) else { return true };
        self.lost.count(&update);
        false
    }

    fn wake(&self) {
        // It fails only when the counter would overflow: then it is readable anyway.
        let _ = self.shared.wake.write(1);
    }
}

#[cfg(test)]
mod tests;
