//! A cell of a sweep: a board, how it is read, and what comes of it over many instruments.

use super::change::Change;
use super::limits::{COLD, LEAST_WARM, SINCE_START, SWING, TOLERANCE, WARM, WARM_CYCLES};
use super::watch::{Found, WatchSpan, watch};
use crate::config::{Config, SettingsError};
use crate::instrument::Instrument;
use crate::instrument::limits::LONGEST_UNSEEN;
use crate::instrument::settings::Settings;
use crate::pins::PinsError;
use crate::pins::sim::{Scene, SceneError, Sensor, SimPins};
use crate::sensor::Channel;
use crate::units::{Farad, Nanos, Ohm, Seconds};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt;
use std::path::PathBuf;

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
        let settings = config.settings()?;
        Ok((scene.with_sensors(vec![self.sensor(&settings.channels[0])])?, settings))
    }

    /// Behind what the zero of its channel says.
    fn sensor(&self, channel: &Channel) -> Sensor {
        match self.change {
            Some(Change::Speed(share_per_s)) => {
                let points = self.back_and_forth(share_per_s).into_iter();
                let points = points.map(|(at, r_ohm)| (at, channel.as_read(r_ohm))).collect();
                Sensor::File { path: PathBuf::new(), points }
            }
            _ => Sensor::Constant(Ohm(channel.as_read(self.r_ohm))),
        }
    }

    /// Seconds and ohm where it turns: always as fast, with the resistance in the middle, once through it in the time of all readings,
    /// or, where that would go too far, again and again.
    fn back_and_forth(&self, share_per_s: f64) -> Vec<(f64, f64)> {
        let takes_s = self.seconds() - self.warm().as_seconds();
        let swing = SWING.min(0.5 * share_per_s * takes_s);
        let step_s = 2.0 * swing / share_per_s;
        // Without an offset, readings count late.
        let steps = ((COLD.as_seconds() + 2.0 * takes_s) / step_s).ceil() as u32;
        let turn = |index: u32| {
            let part = if index % 2 == 0 { 1.0 - swing } else { 1.0 + swing };
            (self.warm().as_seconds() + f64::from(index) * step_s, part * self.r_ohm)
        };
        (0..=steps).map(turn).collect()
    }

    fn watch(&self, channel: &Channel, index: u64) -> WatchSpan {
        let (from, until) = match self.change {
            Some(Change::SinceStart) => (None, Nanos::from_seconds(SINCE_START[SINCE_START.len() - 1])),
            // The sensor moves from then on.
            Some(Change::Speed(_)) => (Some(self.warm()), Nanos::MAX),
            _ if self.config.is_tracked() => {
                (Some(self.warm() + staggered(index, self.instruments)), Nanos::MAX)
            }
            _ => (Some(self.warm()), Nanos::MAX),
        };
        let channel = channel.clone();
        WatchSpan { channel, start: Nanos::ZERO, from, until, readings: self.readings }
    }

    /// Measures, one instrument after the other; `None` if it was stopped.
    ///
    /// # Errors
    /// The board or the configuration cannot be.
    pub fn measure(&self, is_stopped: &dyn Fn() -> bool) -> Result<Option<Vec<Found>>, CellError> {
        let (scene, settings) = self.parts()?;
        let channel = &settings.channels[0];
        let mut all = Vec::new();
        for index in 0..self.instruments {
            let seed = self.seed.wrapping_add(index);
            let pins = SimPins::new(&of_its_own(&scene, seed), Some(seed));
            let mut instrument = Instrument::new(pins, settings.clone());
            let truth =
                |pins: &SimPins, at| pins.r_x(0, at).map_or(self.r_ohm, |r_ohm| channel.corrected(r_ohm));
            all.push(watch(&mut instrument, &self.watch(channel, index), truth, || !is_stopped())?);
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
            self.parts().map(drop).map_err(|error| format!("{self}: {error}"))
        }
    }

    /// From when on readings count.
    fn warm(&self) -> Nanos {
        let [_, usual] = self.config.cycle(self.config.discharge(Ohm(self.r_ohm)));
        if self.scene.clock_period.is_none() || self.config.is_tracked() {
            return WARM;
        }
        Nanos::from_seconds(WARM_CYCLES * usual.0).clamp(LEAST_WARM, WARM)
    }

    /// How long an instrument runs, seconds on its own clock, but for what it is [staggered] by.
    pub fn seconds(&self) -> f64 {
        if self.change == Some(Change::SinceStart) {
            return SINCE_START[SINCE_START.len() - 1];
        }
        let [_, usual] = self.config.cycle(self.config.discharge(Ohm(self.r_ohm)));
        let each = self.config.average().map_or(usual.0, Nanos::as_seconds);
        self.warm().as_seconds() + self.readings as f64 * each
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

/// How much later one of so many tracked instruments counts than [`WARM`]. What all do every two seconds they would do at the same
/// instant after their starts: few readings of each would have all of it or nothing.
pub fn staggered(index: u64, instruments: u64) -> Nanos {
    let part = (index as f64 + 0.5) / instruments as f64;
    Nanos((part * LONGEST_UNSEEN.as_ns()) as i64)
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

#[cfg(test)]
mod tests {
    use super::super::limits::{MAP_OHM, SPEEDS};
    use super::super::sweep::Sweep;
    use super::*;
    use crate::reading::Method;

    fn moving(seed: u64) -> Vec<Cell> {
        let scene = Scene::builtin("pi4").unwrap();
        let sweep = Sweep {
            name: "pi4".to_owned(),
            scene,
            config: None,
            methods: vec![Method::Tracked, Method::Tpcm],
            kinds: Vec::new(),
            r_ohm: Vec::new(),
            averages: Vec::new(),
            instruments: Some(2),
            seed,
        };
        let cells = sweep.maps().unwrap().into_iter();
        cells.filter(|cell| matches!(cell.change, Some(Change::Speed(_)))).collect()
    }

    #[test]
    fn a_moving_sensor_has_the_stated_resistance_in_the_middle_and_the_stated_speed_throughout() {
        let cells = moving(1);
        assert!(cells.len() >= 2 * SPEEDS.len() * MAP_OHM.len());
        for cell in cells {
            let Some(Change::Speed(speed)) = cell.change else { panic!("{cell}") };
            let points = cell.back_and_forth(speed);
            let last = WARM.as_seconds() + 2.0 * (cell.seconds() - WARM.as_seconds());
            assert!(points.last().unwrap().0 > last, "{cell}: it stops");
            for pair in points.windows(2) {
                let [(t0, r0), (t1, r1)] = [pair[0], pair[1]];
                assert!(((r1 - r0).abs() / (t1 - t0) / (speed * cell.r_ohm) - 1.0).abs() < 1e-6, "{cell}");
                assert!((0.5 * (r0 + r1) / cell.r_ohm - 1.0).abs() < 1e-9, "{cell}");
                assert!(r0.min(r1) > 0.499 * cell.r_ohm, "{cell}");
            }
        }
    }

    /// With seeds that reach beyond the last one.
    #[test]
    fn the_fastest_sensor_is_read_as_often_as_the_slowest() {
        for cell in moving(u64::MAX).iter().filter(|cell| cell.r_ohm == 1000.0) {
            let found = cell.measure(&|| false).unwrap().unwrap();
            assert!(found.iter().all(|found| found.told.len() == cell.readings), "{cell}: {found:?}");
        }
    }
}
