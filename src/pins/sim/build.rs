//! From a scene to a running simulation. Each effect has its own random numbers, so that switching one on does not change
//! the draws of another.

use super::analog::Analog;
use super::kernel::Events;
use super::network::LINES;
use super::scene::Scene;
use super::sensor::{Sensor, Source};
use super::truth::Truth;
use super::{SimCircuit, SimPins};
use crate::units::Nanos;
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

impl SimPins {
    /// A board with empty capacitors and released lines at virtual time 0, in virtual time. The scene's seed is
    /// used unless another is given.
    pub fn new(scene: &Scene, seed_override: Option<u64>) -> SimPins {
        let seed = seed_override.unwrap_or(scene.seed);
        let circuit = scene.network();
        let sources =
            (SENSORS..).zip(&scene.sensors).map(|(number, sensor)| Source::new(sensor.clone(), seed, number));
        let sense_lines = if circuit.has_b() { 2 } else { 1 };
        SimPins {
            now_ns: 0,
            epoch: Nanos::ZERO,
            pace: None,
            events: Events::new(scene, sense_lines, stream(seed, EVENTS)),
            analog: Analog::new(scene, circuit, sources.collect(), stream(seed, NOISE), stream(seed, WALK)),
            posted: VecDeque::with_capacity(4 * LINES),
            scene: Scene { seed, ..scene.clone() },
            armed: false,
            conflicts: 0,
            truth: Truth::default(),
            rng: stream(seed, CALLS),
        }
    }

    /// Connects another sensor to a channel of the scene, now.
    pub fn connect(&mut self, channel: usize, sensor: Sensor) {
        self.catch_up(self.now_ns);
        self.analog.connect(channel, Source::new(sensor, self.scene.seed, SENSORS + channel as u64));
        self.analog.switch(self.analog.on(), self.now_ns);
    }

    /// Changes the circuit now: a wire that breaks, a capacitor that falls off, a supply that dips.
    pub fn alter(&mut self, change: impl FnOnce(&mut SimCircuit)) {
        self.catch_up(self.now_ns);
        change(&mut self.analog.circuit);
        self.analog.switch(self.analog.on(), self.now_ns);
    }
}
