//! Pins and cycle put together: the measuring loop, one step at a time.
//!
//! For: which discharges in which order, each of them step by step, and what is wrong with the board; the daemon's measuring
//! thread runs it, tests do in virtual time. Must not know: files, threads, clients. A step allocates nothing, but to report an
//! error of the pins.
//!
//! ```
//! use cermd::config::Config;
//! use cermd::instrument::{Instrument, Message};
//! use cermd::pins::sim::{Scene, SimPins};
//! use cermd::reading::Status;
//!
//! let config = r#"
//!     circuit = { kind = "two-capacitor", c-a = "2.2 uF", c-b = "680 nF", r-c1 = "470 ohm", r-c2 = "12.7 kohm" }
//!     measure = { method = "tcdic" }
//!     channel = [{ id = "thumb" }]
//! "#;
//! let settings = Config::parse(config, "example")?.settings()?;
//! // The simulated board has a sensor of 1 kohm.
//! let mut instrument = Instrument::new(SimPins::new(&Scene::builtin("pi4")?, None), settings);
//! let mut r_ohm = None;
//! while r_ohm.is_none() {
//!     instrument.step(&mut |message| {
//!         if let Message::Reading(reading) = message {
//!             if let Status::Ok { r_ohm: measured, .. } = reading.status {
//!                 r_ohm = Some(measured.value);
//!             }
//!         }
//!     })?;
//! }
//! assert!(r_ohm.is_some_and(|r_ohm| (950.0..1050.0).contains(&r_ohm)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cycle;
pub mod diagnosis;
pub mod discharge;
pub mod limits;
pub mod settings;
pub mod stats;

use crate::instrument::cycle::{Cycle, Next};
use crate::instrument::discharge::Lead;
use crate::instrument::limits::NAP;
use crate::instrument::settings::Settings;
use crate::instrument::stats::Stats;
use crate::pins::{Drives, Pins, PinsError};
use crate::reading::{Fault, Measured, Reading};
use crate::record::Record;
use crate::units::Nanos;

/// What comes out of the instrument.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Message {
    /// A reading of a channel.
    Reading(Reading),
    /// The timings of a discharge, counted from 1.
    Discharge {
        /// Counts the discharges.
        seq: u64,
        /// When it was asked for: what goes before it began.
        asked: Nanos,
        /// Its timings.
        record: Record,
        /// It was held back, to look for a leak or for absorption.
        is_held: bool,
        /// What was read by it, with its sign, before the zero and the scale of the channel, ohm, with 1 sigma of what other
        /// readings share with it.
        as_read_ohm: Option<Measured>,
    },
}

/// A circuit that is being measured.
#[derive(Debug)]
pub struct Instrument<P> {
    pins: P,
    cycle: Cycle,
    period: Option<Nanos>,
    tick: Option<Nanos>,
    discharges: u64,
    lead: Lead,
}

impl<P: Pins> Instrument<P> {
    /// Ready to take its first discharge.
    pub fn new(pins: P, settings: Settings) -> Instrument<P> {
        let (period, cycle) = (settings.period, Cycle::new(settings));
        Instrument { pins, period, cycle, tick: None, discharges: 0, lead: Lead::default() }
    }

    /// What has been counted and learned.
    pub fn stats(&self) -> Stats {
        let particulars = self.pins.particulars();
        Stats {
            spin_margin: particulars.spin_margin,
            renewed: particulars.renewed,
            blind_spots: particulars.blind_spots.len(),
            ..self.cycle.stats()
        }
    }

    /// The pins.
    pub fn pins(&mut self) -> &mut P {
        &mut self.pins
    }

    /// The order of discharges, for looking at.
    pub fn cycle(&self) -> &Cycle {
        &self.cycle
    }

    /// Does the next thing: sleeps towards the next cycle, takes one discharge, or reports a reading.
    ///
    /// # Errors
    /// If the pins cannot be used. Every channel that has not been read gets a reading with [`Fault::Pins`] first; the
    /// next step begins a new cycle. If the measurement was stopped, no reading is made up.
    pub fn step(&mut self, out: &mut impl FnMut(Message)) -> Result<(), PinsError> {
        let result = self.try_step(out);
        if !matches!(result, Ok(()) | Err(PinsError::Stopped)) {
            self.report_failure(out);
        }
        result
    }

    /// Every channel that has not been read in this cycle gets a reading with [`Fault::Pins`]: between two cycles, all of
    /// them.
    pub fn report_failure(&mut self, out: &mut impl FnMut(Message)) {
        self.cycle.fail(Fault::Pins);
        while !self.cycle.is_at_start() {
            let now = self.pins.now();
            let Next::Report(reading) = self.cycle.next(now) else { break };
            out(Message::Reading(reading));
        }
    }

    fn try_step(&mut self, out: &mut impl FnMut(Message)) -> Result<(), PinsError> {
        let mut now = self.pins.now();
        if self.cycle.may_rest() {
            let Some(later) = self.rested(now)? else { return Ok(()) };
            now = later;
        }
        match self.cycle.next(now) {
            Next::Report(reading) => out(Message::Reading(reading)),
            Next::Discharge(plan) => {
                let is_held = self.cycle.is_holding();
                let outcome = discharge::run_on(&mut self.pins, plan, &mut self.lead)?;
                let reading = self.cycle.done(&outcome, self.pins.now());
                if let Ok(record) = outcome.result {
                    self.discharges += 1;
                    let (seq, as_read_ohm) = (self.discharges, self.cycle.as_read_ohm());
                    out(Message::Discharge { seq, asked: now, record, is_held, as_read_ohm });
                }
                if let Some(reading) = reading {
                    out(Message::Reading(reading));
                }
            }
        }
        Ok(())
    }

    /// The time when the next cycle has come, which is slept towards; `None`: not yet. A cycle that took too long begins the next one
    /// at once, and the ticks it missed are gone.
    fn rested(&mut self, mut now: Nanos) -> Result<Option<Nanos>, PinsError> {
        let Some(period) = self.period else { return Ok(Some(now)) };
        let tick = self.tick.unwrap_or(now);
        if now < tick {
            self.pins.drive(Drives::NONE)?;
            self.pins.rest_until(tick.min(now + NAP))?;
            if tick > now + NAP {
                return Ok(None);
            }
            // What is slept is no part of a reading.
            now = self.pins.now();
        }
        self.tick = Some(tick.max(now - period) + period);
        Ok(Some(now))
    }
}
