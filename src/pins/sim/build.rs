//! From a scene to a running simulation. Each effect has its own random numbers, so that switching one on does not change
//! the draws of another.

use super::analog::Analog;
use super::kernel::Events;
use super::network::{Branch, LINES, Sense, line_index};
use super::scene::{AbsorptionScene, BranchScene, NodeScene, Scene, Threshold, line_named};
use super::sensor::{ActiveSensor, Sensor};
use super::truth::Truth;
use super::{Kind, SimCircuit, SimPins};
use crate::circuit::Network;
use crate::pins::MAX_CHANNELS;
use crate::units::{Farad, Nanos, Ohm};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Streams of the generator, by what they serve.
const CALLS: u64 = 0;
const NOISE: u64 = 1;
const EVENTS: u64 = 2;
const WALK: u64 = 3;
const SENSORS: u64 = 16;

fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

impl Scene {
    /// The network with every sensor open.
    pub fn network(&self) -> SimCircuit {
        let circuit = &self.circuit;
        let mut r_o = [circuit.r_o.0; LINES];
        for (name, value) in &circuit.r_o_of {
            if let Some(line) = line_named(name) {
                r_o[line_index(line)] = value.0;
            }
        }
        SimCircuit {
            // A missing capacitor has been refused by the check.
            network: circuit.network().unwrap_or(Network::OneCapacitor { c: Farad(f64::NAN) }),
            absorption: self.absorption(),
            v_dd: circuit.v_dd.0,
            r_c1: circuit.r_c1.0,
            r_c2: circuit.r_c2.0,
            r_p: circuit.r_p.map_or(0.0, |r| r.0),
            r_o,
            r_x: [f64::INFINITY; MAX_CHANNELS],
            sense: [&circuit.node_a, &circuit.node_b].map(|node| node.sense(circuit.threshold)),
        }
    }

    fn absorption(&self) -> [Vec<Branch>; 2] {
        let AbsorptionScene { c_a, c_b, c } = &self.circuit.absorption;
        let branches = match self.circuit.kind {
            Kind::OneCapacitor | Kind::SeriesCalibration => [&c[..], &[]],
            Kind::TwoCapacitor => [&c_a[..], &c_b[..]],
        };
        let branch = |scene: &BranchScene| Branch { share: scene.share, tau: scene.tau.0 };
        branches.map(|branches| branches.iter().map(branch).collect())
    }
}

impl NodeScene {
    fn sense(&self, threshold: Threshold) -> Sense {
        let threshold = self.threshold.unwrap_or(threshold);
        let siemens = |r: Option<Ohm>| r.map_or(0.0, |r| 1.0 / r.0);
        Sense {
            falling: threshold.falling.0,
            rising: threshold.rising.unwrap_or(threshold.falling).0,
            leakage: self.leakage.map_or(0.0, |i| i.0),
            to_ground: siemens(self.leakage_resistance) + siemens(self.pull_down),
            to_v_dd: siemens(self.pull_up),
        }
    }
}

impl SimPins {
    /// A board with empty capacitors and released lines at virtual time 0, in virtual time. The scene's seed is
    /// used unless another is given.
    pub fn new(scene: &Scene, seed_override: Option<u64>) -> SimPins {
        let seed = seed_override.unwrap_or(scene.seed);
        let circuit = scene.network();
        let sources = (SENSORS..)
            .zip(&scene.sensors)
            .map(|(number, sensor)| ActiveSensor::new(sensor.clone(), seed, number));
        let sense_lines = if circuit.has_b() { 2 } else { 1 };
        SimPins {
            now_ns: 0,
            epoch: Nanos::ZERO,
            pace: None,
            events: Events::new(scene, sense_lines, stream(seed, EVENTS)),
            analog: Analog::new(scene, circuit, sources.collect(), stream(seed, NOISE), stream(seed, WALK)),
            posted: VecDeque::with_capacity(4 * LINES),
            scene: Scene { seed, ..scene.clone() },
            touched_ns: 0,
            armed: false,
            conflicts: 0,
            truth: Truth::default(),
            rng: stream(seed, CALLS),
        }
    }

    /// Connects another sensor to a channel of the scene, now.
    pub fn connect(&mut self, channel: usize, sensor: Sensor) {
        self.catch_up(self.now_ns);
        self.analog.connect(channel, ActiveSensor::new(sensor, self.scene.seed, SENSORS + channel as u64));
        self.analog.switch(self.analog.on(), self.now_ns);
    }

    /// Changes the circuit now: a wire that breaks, a capacitor that falls off, a supply that dips.
    pub fn alter(&mut self, change: impl FnOnce(&mut SimCircuit)) {
        self.catch_up(self.now_ns);
        change(&mut self.analog.circuit);
        self.analog.switch(self.analog.on(), self.now_ns);
    }
}
