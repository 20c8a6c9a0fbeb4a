//! A cell of a sweep: a board, how it is read, and what comes of it over many instruments.

use super::change::Change;
use super::limits::{RAMP, SINCE_START, TOLERANCE, WARM};
use super::watch::{Found, Watch, watch};
use crate::config::{Config, SettingsError};
use crate::instrument::Instrument;
use crate::instrument::settings::Settings;
use crate::pins::PinsError;
use crate::pins::sim::{Scene, SceneError, Sensor, SimPins};
use crate::units::{Farad, Nanos, Ohm, Seconds};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt;

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The name of the scene.
    pub name: String,
    /// The board, in the wiring of the configuration.
    pub scene: Scene,
    /// How it is read: one channel.
    pub config: Config,
    /// The sensor, ohm.
    pub r_ohm: f64,
    /// What is other than that.
    pub change: Option<Change>,
    /// Of the first instrument; each one has the next.
    pub seed: u64,
    /// How many, each on a board of its own.
    pub instruments: u64,
    /// Published readings of each.
    pub readings: usize,
}

/// Why a cell cannot be measured.
#[derive(Debug, thiserror::Error)]
pub enum CellError {
    /// No such board.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No such configuration.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Two outputs against each other: a fault of the instrument.
    #[error("the simulated board: {0}")]
    Pins(#[from] PinsError),
}

impl Cell {
    /// The board and the settings of every instrument.
    fn parts(&self) -> Result<(Scene, Settings), CellError> {
        let mut config = self.config.clone();
        let scene = match self.change {
            Some(change) => change.apply(self.scene.clone(), &mut config),
            None => self.scene.clone(),
        };
        Ok((scene.with_sensors(vec![self.sensor()])?, config.settings()?))
    }

    fn sensor(&self) -> Sensor {
        match self.change {
            Some(Change::Speed(share_per_s)) => {
                let [from, to] = RAMP.map(|share| Ohm(share * self.r_ohm));
                let duration = Seconds((RAMP[1] - RAMP[0]) / share_per_s);
                Sensor::Ramp { from, to, start: WARM.into(), duration }
            }
            _ => Sensor::Constant(Ohm(self.r_ohm)),
        }
    }

    fn watch(&self) -> Watch {
        let (from, until) = match self.change {
            Some(Change::Speed(share_per_s)) => {
                (Some(WARM), WARM + Nanos::from_seconds((RAMP[1] - RAMP[0]) / share_per_s))
            }
            Some(Change::SinceStart) => (None, Nanos::from_seconds(SINCE_START[SINCE_START.len() - 1])),
            _ => (Some(WARM), Nanos::MAX),
        };
        Watch { start: Nanos::ZERO, from, until, readings: self.readings }
    }

    /// Measures, one instrument after the other; `None` if it was stopped.
    ///
    /// # Errors
    /// The board or the configuration cannot be.
    pub fn measure(&self, is_stopped: &dyn Fn() -> bool) -> Result<Option<Vec<Found>>, CellError> {
        let (scene, settings) = self.parts()?;
        let mut all = Vec::new();
        for seed in self.seed..self.seed + self.instruments {
            let pins = SimPins::new(&of_its_own(&scene, seed), Some(seed));
            let mut instrument = Instrument::new(pins, settings.clone());
            let truth = |pins: &SimPins, at| pins.r_x(0, at).unwrap_or(self.r_ohm);
            all.push(watch(&mut instrument, &self.watch(), truth, || !is_stopped())?);
            if is_stopped() {
                return Ok(None);
            }
        }
        Ok(Some(all))
    }

    /// Whether the instrument would start with this configuration.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(&self) -> Result<(), String> {
        let findings = self.config.check();
        if findings.has_errors() {
            Err(format!("scene {}: {}", self.name, findings.errors()))
        } else {
            Ok(())
        }
    }

    /// How long an instrument runs, seconds on its own clock.
    pub fn seconds(&self) -> f64 {
        if self.change == Some(Change::SinceStart) {
            return SINCE_START[SINCE_START.len() - 1];
        }
        let [_, usual] = self.config.cycle(self.config.discharge(Ohm(self.r_ohm)));
        let each = self.config.average().map_or(usual.0, Nanos::as_seconds);
        WARM.as_seconds() + self.readings as f64 * each
    }

    /// About how many discharges all instruments take.
    pub fn cost(&self) -> f64 {
        let [fastest, _] = self.config.cycle(Seconds(0.0));
        self.instruments as f64 * self.seconds() / fastest.0
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (method, kind, r) = (self.config.method(), self.config.circuit.kind(), Ohm(self.r_ohm));
        write!(f, "{method}, {kind}, {r:.3}")?;
        if let Some(average) = self.config.average() {
            write!(f, ", mean over {:.3}", Seconds::from(average))?;
        }
        match self.change.map(Change::columns) {
            Some((vary, _, Some(name))) => write!(f, ", {vary} {name}"),
            Some((vary, ..)) => write!(f, ", {vary}"),
            None => Ok(()),
        }
    }
}

/// A board whose crossings fall elsewhere in the cycles of its clock, if it has one.
fn of_its_own(scene: &Scene, seed: u64) -> Scene {
    let mut scene = scene.clone();
    if scene.clock_period.is_some() {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let circuit = &mut scene.circuit;
        for c in [&mut circuit.c_a, &mut circuit.c_b, &mut circuit.c].into_iter().flatten() {
            *c = Farad(c.0 * (1.0 + rng.random_range(-TOLERANCE..TOLERANCE)));
        }
    }
    scene
}
