//! The board of the demo: a scene, a configuration that fits it, and the truth, which only the one who imagines a circuit
//! can know.

use super::super::CtlError;
use crate::config::{ChannelTable, Characteristic, Config, ForceSource, Measure, Mock, Server, backend};
use crate::ctl::cli;
use crate::pins::Drives;
use crate::pins::sim::network::line_index;
use crate::pins::sim::{Kind, Scene, Sensor, SimPins};
use crate::sensor::{FSR_402, Law};
use crate::units::{Newton, Ohm, Seconds};
use std::path::Path;

/// The channels, as far as a hand has fingers.
const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

/// A simulated board.
#[derive(Debug)]
pub struct Board {
    pub config: Config,
    scene: Scene,
    seed: Option<u64>,
}

impl Board {
    /// As the command line wants it; `socket`: where it is to be served.
    pub fn new(arguments: &cli::Demo, socket: &Path) -> Result<Board, CtlError> {
        let scene = Scene::named(&arguments.scene, Path::new(""))?;
        let scene = if is_file(&arguments.scene) { scene } else { scene.with_sensors(vec![hand()])? };
        let circuits = arguments.method.map(|method| method.rules().circuits);
        let other = circuits.filter(|kinds| !kinds.contains(&scene.circuit.kind)).and_then(<[Kind]>::first);
        let scene = match arguments.wiring.or(other.copied()) {
            Some(kind) => scene.with_kind(kind)?,
            None => scene,
        };
        Ok(Board { config: config(&scene, arguments, socket), seed: arguments.seed, scene })
    }

    /// The circuit in virtual time. Two of them behave alike.
    pub fn simulation(&self) -> SimPins {
        SimPins::new(&self.scene, self.seed)
    }

    /// The same with the first of its sensors alone.
    pub fn with_first_sensor(self) -> Result<Board, CtlError> {
        let (mut sensors, mut config) = (self.scene.sensors.clone(), self.config);
        sensors.truncate(1);
        config.channels.truncate(1);
        Ok(Board { scene: self.scene.with_sensors(sensors)?, config, seed: self.seed })
    }

    /// The same circuit with a resistor in the place of its sensors.
    pub fn resting(&self, r: Ohm) -> Option<SimPins> {
        let scene = self.scene.clone().with_sensors(vec![Sensor::Constant(r)]).ok()?;
        Some(SimPins::new(&scene, self.seed))
    }

    /// How late a crossing is stamped, ns, without the rare long delays: what a latency offset should be.
    pub fn latency_ns(&self) -> f64 {
        let stamps = self.scene.stamps.map_or(0.0, |stamps| stamps.mean.0);
        let clock = self.scene.clock_period.map_or(0.0, |period| period.0 / 2.0);
        (stamps + clock) * 1e9
    }

    /// Output resistance of the pin of Rc1, ohm.
    pub fn r_o_ohm(&self) -> f64 {
        self.scene.network().r_o[line_index(Drives::C1)]
    }
}

/// Whether that is no built-in scene.
pub fn is_file(scene: &str) -> bool {
    scene.ends_with(".toml")
}

fn hand() -> Sensor {
    Sensor::Hand { alpha: FSR_402, peak: Newton(10.0), period: Seconds(3.0) }
}

fn name_of(index: usize) -> String {
    FINGERS.get(index).map_or_else(|| format!("x{index}"), |name| (*name).to_owned())
}

fn config(scene: &Scene, arguments: &cli::Demo, socket: &Path) -> Config {
    let channel = |index: usize| ChannelTable {
        force: Some(Characteristic {
            law: ForceSource::Given(Law::Alpha { alpha_n_ohm: FSR_402.0 }),
            u: None,
            range_n: None,
            tare_n: None,
        }),
        // The simulated pins are alike.
        ..ChannelTable::commissioned(&name_of(index), 0.0)
    };
    let channels = (0..scene.sensors.len().max(1)).map(channel).collect();
    Config {
        measure: Measure { method: arguments.method, ..Measure::default() },
        server: Server { socket: socket.to_owned(), mode: 0o600 },
        mock: Some(Mock { scene: arguments.scene.clone(), seed: arguments.seed }),
        ..Config::of(backend::circuit_of(scene), channels)
    }
}
