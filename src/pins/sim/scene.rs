//! Simulated boards as TOML files. An effect that a scene does not name is off.

use super::network::LINES;
use super::sensor::Sensor;
use crate::circuit::{Kind, Network};
use crate::files;
use crate::pins::Drives;
use crate::units::{Ampere, Farad, Hertz, Ohm, Seconds, Volt};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

mod check;

/// The scenes that are part of the program: (name, text).
const BUILTIN: [(&str, &str); 5] = [
    ("ideal", include_str!("../../../hw/scenes/ideal.toml")),
    ("fpga-paper", include_str!("../../../hw/scenes/fpga-paper.toml")),
    ("pi-zero", include_str!("../../../hw/scenes/pi-zero.toml")),
    ("pi4", include_str!("../../../hw/scenes/pi4.toml")),
    ("pi5", include_str!("../../../hw/scenes/pi5.toml")),
];

/// Why a scene cannot be used: which file, with line and caret or the key, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct SceneError(String);

impl SceneError {
    fn wrong(origin: &Path, problem: impl Display) -> SceneError {
        SceneError(format!("{}: {problem}", origin.display()))
    }
}

/// A simulated board with its circuit and sensors.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Scene {
    /// Of every random number.
    #[serde(default = "default_seed")]
    pub seed: u64,
    /// The network.
    pub circuit: CircuitScene,
    /// What is connected to the channels, from channel 0 on; the others are open.
    #[serde(default, rename = "sensor")]
    pub sensors: Vec<Sensor>,
    /// A clock that everything is quantised by: crossings are seen and lines switched at its edges.
    pub clock_period: Option<Seconds>,
    /// Calls that switch lines.
    pub calls: Option<CallsScene>,
    /// Lateness of the kernel's stamps.
    pub stamps: Option<DelayScene>,
    /// From an edge's stamp to the program.
    pub wake: Option<DelayScene>,
    /// From the end of a sleep to the program.
    pub sleep: Option<DelayScene>,
    /// Cost of other calls.
    #[serde(default)]
    pub reads: ReadsScene,
    /// The kernel's tick.
    pub ticks: Option<TicksScene>,
    /// What happens to edges on their way.
    pub events: Option<EventsScene>,
    /// Voltage noise at the sense inputs.
    pub noise: Option<NoiseScene>,
    /// What changes slowly, linearly from the start of the simulation on.
    pub drift: Option<DriftScene>,
    /// What walks at random.
    pub walk: Option<WalkScene>,
}

fn default_seed() -> u64 {
    1
}

/// The network: `c-a` and `c-b` serve the two-capacitor circuit, `c` the others.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CircuitScene {
    /// Which circuit; a scene with all capacitors serves every kind ([`Scene::with_kind`]).
    pub kind: Kind,
    /// Between nodes A and B.
    pub c_a: Option<Farad>,
    /// From node B to ground.
    pub c_b: Option<Farad>,
    /// From node A to ground.
    pub c: Option<Farad>,
    /// What the dielectrics absorb.
    #[serde(default)]
    pub absorption: AbsorptionScene,
    /// The lower calibration resistor.
    pub r_c1: Ohm,
    /// The other one.
    pub r_c2: Ohm,
    /// In series with each charger; absent: 0.
    pub r_p: Option<Ohm>,
    /// Output resistance of every pin.
    pub r_o: Ohm,
    /// Output resistance of single pins: `charge-a`, `charge-b`, `c1`, `c2`, `x0`...
    #[serde(default)]
    pub r_o_of: BTreeMap<String, Ohm>,
    /// Supply.
    pub v_dd: Volt,
    /// Thresholds of both sense inputs.
    pub threshold: Threshold,
    /// What else there is at node A.
    #[serde(default)]
    pub node_a: NodeScene,
    /// What else there is at node B.
    #[serde(default)]
    pub node_b: NodeScene,
}

impl CircuitScene {
    /// Its capacitors; `None` where one is missing.
    pub fn network(&self) -> Option<Network> {
        Network::new(self.kind, self.c_a, self.c_b, self.c)
    }
}

/// What each capacitor absorbs, by its key in the network: nothing where no branch is named.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct AbsorptionScene {
    /// Of `c-a`.
    pub c_a: Vec<BranchScene>,
    /// Of `c-b`.
    pub c_b: Vec<BranchScene>,
    /// Of `c`.
    pub c: Vec<BranchScene>,
}

/// A resistor and a capacitor in series beside the capacitor proper.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct BranchScene {
    /// Its capacitance, of that of the capacitor proper.
    pub share: f64,
    /// Its time constant.
    pub tau: Seconds,
}

/// Thresholds of a sense input.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Threshold {
    /// V_Th: a high input becomes low.
    pub falling: Volt,
    /// A low input becomes high; absent: no hysteresis.
    pub rising: Option<Volt>,
}

/// What hangs on a sense node unintended.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct NodeScene {
    /// Instead of the thresholds of the circuit.
    pub threshold: Option<Threshold>,
    /// Constant current out of the node; negative: into it.
    pub leakage: Option<Ampere>,
    /// Leakage to ground.
    pub leakage_resistance: Option<Ohm>,
    /// To V_DD.
    pub pull_up: Option<Ohm>,
    /// To ground.
    pub pull_down: Option<Ohm>,
}

/// A delay; absent values are 0.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DelayScene {
    /// Mean without the tail.
    pub mean: Seconds,
    /// Standard deviation without the tail.
    pub jitter: Option<Seconds>,
    /// How often it is much longer.
    pub tail_probability: Option<f64>,
    /// By how much on average.
    pub tail_mean: Option<Seconds>,
}

/// Calls that switch lines: overhead + lines x slot.
///
/// A line that moves after its slot does so as a write that is posted: behind the writes before it, and before any levels
/// that are read later, arming included.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CallsScene {
    /// Overhead, half before and half after the lines move.
    pub fixed: Seconds,
    /// For each line that is switched.
    pub per_line: Seconds,
    /// Relative standard deviation of the whole duration.
    pub jitter: Option<f64>,
    /// Where a line moves, from .. to, in slots since its own began: up to 1 within it, up to 100 after it, even after the
    /// call; absent: in the middle of it.
    pub moves_at: Option<[f64; 2]>,
    /// How often a call is preempted.
    pub tail_probability: Option<f64>,
    /// For how long on average.
    pub tail_mean: Option<Seconds>,
    /// A chip that nobody has touched for longer than this sleeps, or the way to it does: reading levels wakes it.
    pub asleep_after: Option<Seconds>,
    /// How much later the lines of a call move that has to wake it.
    pub wakes_in: Option<Seconds>,
}

/// Cost of calls that do not switch.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct ReadsScene {
    /// Reading the clock.
    pub clock: Option<Seconds>,
    /// Reading the levels.
    pub levels: Option<Seconds>,
    /// Arming.
    pub arm: Option<Seconds>,
}

/// A tick interrupts whatever runs, at whole multiples of its period on the clock that stamps: calls go on when it is over, edges are
/// stamped and sleepers woken then.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct TicksScene {
    /// Its period.
    pub every: Seconds,
    /// How long it takes.
    pub takes: Seconds,
}

/// What happens to edges between the pin and the program.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct EventsScene {
    /// Events that the kernel keeps; absent: 16 for each sense line, as in drivers/gpio/gpiolib-cdev.c.
    pub buffer: Option<u32>,
    /// Probability that the hardware loses an edge: no event, no gap.
    pub lost: Option<f64>,
    /// Probability that a second interrupt overwrites the stamp of the first.
    pub coalesced: Option<f64>,
    /// How much later that second interrupt comes, on average.
    pub bounce: Option<Seconds>,
    /// By how much more the stamps of node B are late than those of A.
    pub b_later: Option<Seconds>,
    /// A processor that has had nothing to do for longer than this when an edge comes wakes from a deeper sleep.
    pub deep_sleep_after: Option<Seconds>,
    /// By how much more a stamp is late then.
    pub deep_sleep_late: Option<Seconds>,
}

/// Voltage noise.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct NoiseScene {
    /// Root mean square.
    pub voltage: Volt,
    /// If named, the noise is wide-band and its first crossing counts.
    pub bandwidth: Option<Hertz>,
}

/// Slow changes; absent values are 0. Each discharge runs with the values of the beginning of its charge.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct DriftScene {
    /// Of every capacitor, relative.
    #[serde(default)]
    pub c_per_minute: f64,
    /// Of all thresholds.
    pub v_th_per_minute: Option<Volt>,
    /// Of the supply.
    pub v_dd_per_minute: Option<Volt>,
}

/// Random walks. Each discharge runs with the values of the beginning of its charge.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct WalkScene {
    /// Output resistance of all pins alike, standard deviation after a second; it grows as the root of the time.
    pub r_o: Ohm,
}

impl Scene {
    /// The names of the scenes that are part of the program.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }

    /// A scene that is part of the program.
    pub fn builtin(name: &str) -> Result<Scene, SceneError> {
        Scene::parse(builtin_text(name)?, Path::new(name))
    }

    /// A scene from a file (`*.toml`, relative to a folder), or one that is part of the program.
    pub fn named(name: &str, folder: &Path) -> Result<Scene, SceneError> {
        if name.ends_with(".toml") { Scene::load(&folder.join(name)) } else { Scene::builtin(name) }
    }

    /// The text of the same.
    pub fn text_of(name: &str, folder: &Path) -> Result<String, SceneError> {
        if name.ends_with(".toml") {
            read(&folder.join(name), files::SETTINGS_BYTES)
        } else {
            builtin_text(name).map(str::to_owned)
        }
    }

    /// A scene from a file.
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        Scene::parse(&read(path, files::SETTINGS_BYTES)?, path)
    }

    /// A scene from its text; `origin` stands in messages, and files that the scene names are beside it.
    pub fn parse(text: &str, origin: &Path) -> Result<Scene, SceneError> {
        let mut scene: Scene = toml::from_str(text).map_err(|error| SceneError::wrong(origin, error))?;
        for sensor in &mut scene.sensors {
            sensor.read_file(origin.parent().unwrap_or(Path::new("")))?;
        }
        scene.checked(origin)
    }

    /// The same board with the circuit of another figure.
    pub fn with_kind(mut self, kind: Kind) -> Result<Scene, SceneError> {
        self.circuit.kind = kind;
        self.checked(Path::new("scene"))
    }

    /// The same board with these sensors, from channel 0 on.
    pub fn with_sensors(mut self, sensors: Vec<Sensor>) -> Result<Scene, SceneError> {
        self.sensors = sensors;
        self.checked(Path::new("scene"))
    }

    /// Itself, if every value makes sense.
    fn checked(self, origin: &Path) -> Result<Scene, SceneError> {
        self.check().map_err(|problem| SceneError::wrong(origin, problem))?;
        Ok(self)
    }
}

fn builtin_text(name: &str) -> Result<&'static str, SceneError> {
    let found = BUILTIN.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text).ok_or_else(|| {
        let names = Scene::builtin_names().collect::<Vec<_>>().join(", ");
        SceneError(format!("there is no built-in scene \"{name}\"; there are {names}"))
    })
}

fn read(path: &Path, most_bytes: u64) -> Result<String, SceneError> {
    let refused =
        |error| SceneError(format!("cannot read {}: {error}; {}", path.display(), files::hint(&error)));
    files::read_text(path, most_bytes).map_err(refused)
}

/// The line that is written like this in [`Drives`]' display.
pub(super) fn line_named(name: &str) -> Option<Drives> {
    (0..LINES).map(|bit| Drives(1 << bit)).find(|line| line.to_string() == name)
}

impl Sensor {
    fn read_file(&mut self, folder: &Path) -> Result<(), SceneError> {
        let Sensor::File { path, points } = self else { return Ok(()) };
        let full = folder.join(path);
        for (index, line) in read(&full, files::TABLE_BYTES)?.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') || (index == 0 && line == "time_s,ohm") {
                continue;
            }
            let row = line.split_once(',').and_then(|(time, ohm)| {
                Some((time.trim().parse::<f64>().ok()?, ohm.trim().parse::<f64>().ok()?))
            });
            let later = |row: &(f64, f64)| points.last().is_none_or(|last| row.0 > last.0);
            match row.filter(|row| row.0.is_finite() && row.1.is_finite() && row.1 >= 0.0 && later(row)) {
                Some(row) => points.push(row),
                None => {
                    let number = index + 1;
                    let problem = format!(
                        "line {number}: \"{line}\" is not time_s,ohm with a later time and a resistance"
                    );
                    return Err(SceneError::wrong(&full, problem));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
