//! From a scene to a running simulation.
//!
//! For: turning quantities into ns and giving each effect its own random numbers, so that switching one on does not
//! change the draws of another. Must not know: how effects work.

use super::analog::Analog;
use super::kernel::{Coalescing, Events};
use super::latency::{Calls, Delay, Tail};
use super::noise::Noise;
use super::scene::{CallsScene, DelayScene, Scene};
use super::sensor::{Sensor, Source};
use super::truth::Truth;
use super::{Circuit, Reads, SimPins};
use crate::units::{Nanos, Seconds};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Streams of the generator, by what they serve.
const CALLS: u64 = 0;
const NOISE: u64 = 1;
const EVENTS: u64 = 2;
const SENSORS: u64 = 16;

fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

fn whole_ns(duration: Option<Seconds>) -> i64 {
    duration.map_or(0, |s| (s.0 * 1e9).round() as i64)
}

fn tail(probability: Option<f64>, mean: Option<Seconds>) -> Option<Tail> {
    Some(Tail { probability: probability?, mean_ns: mean?.0 * 1e9 })
}

impl From<DelayScene> for Delay {
    fn from(delay: DelayScene) -> Delay {
        Delay {
            mean_ns: delay.mean.0 * 1e9,
            jitter_ns: delay.jitter.map_or(0.0, |s| s.0 * 1e9),
            tail: tail(delay.tail_probability, delay.tail_mean),
        }
    }
}

impl From<CallsScene> for Calls {
    fn from(calls: CallsScene) -> Calls {
        Calls {
            fixed_ns: calls.fixed.0 * 1e9,
            per_line_ns: calls.per_line.0 * 1e9,
            jitter: calls.jitter.unwrap_or(0.0),
            moves_at: calls.moves_at.unwrap_or([0.5; 2]),
            tail: tail(calls.tail_probability, calls.tail_mean),
        }
    }
}

impl SimPins {
    /// A board with empty capacitors and released lines at virtual time 0, in virtual time. The scene's seed is
    /// used unless another is given.
    pub fn new(scene: &Scene, seed_override: Option<u64>) -> SimPins {
        let seed = seed_override.unwrap_or(scene.seed);
        let circuit = scene.network();
        let clock_ns = scene.clock_period.map(|period| whole_ns(Some(period)));
        let events = scene.events.unwrap_or_default();
        let coalescing = events
            .coalesced
            .zip(events.bounce)
            .map(|(probability, bounce)| Coalescing { probability, bounce_ns: bounce.0 * 1e9 });
        let noise = scene.noise.map(|noise| Noise {
            voltage: noise.voltage.0,
            sample_spacing: noise.bandwidth.map(|bandwidth| 0.5 / bandwidth.0),
        });
        let sources = (SENSORS..)
            .zip(&scene.sensors)
            .map(|(number, sensor)| Source::new(sensor.clone(), seed, number))
            .collect();
        let sense_lines = if circuit.has_b() { 2 } else { 1 };
        let reads = scene.reads.unwrap_or_default();
        SimPins {
            now_ns: 0,
            epoch: Nanos::ZERO,
            pace: None,
            events: Events::new(
                events.buffer,
                sense_lines,
                scene.stamps.map(Delay::from),
                events.lost,
                coalescing,
                clock_ns,
                stream(seed, EVENTS),
            ),
            analog: Analog::new(
                circuit,
                sources,
                whole_ns(Some(scene.sample_interval)),
                noise,
                stream(seed, NOISE),
            )
            .with_drift(scene.drift),
            calls: scene.calls.map(Calls::from),
            wake: scene.wake.map(Delay::from),
            sleep: scene.sleep.map(Delay::from),
            reads: Reads {
                clock_ns: whole_ns(reads.clock),
                levels_ns: whole_ns(reads.levels),
                arm_ns: whole_ns(reads.arm),
            },
            clock_ns,
            armed: false,
            conflicts: 0,
            truth: Truth::default(),
            seed,
            rng: stream(seed, CALLS),
        }
    }

    /// Connects another sensor to a channel of the scene, now.
    pub fn connect(&mut self, channel: usize, sensor: Sensor) {
        self.catch_up(self.now_ns);
        self.analog.connect(channel, Source::new(sensor, self.seed, SENSORS + channel as u64));
        self.analog.switch(self.driving(), self.now_ns);
    }

    /// Changes the circuit now: a wire that breaks, a capacitor that falls off, a supply that dips.
    pub fn alter(&mut self, change: impl FnOnce(&mut Circuit)) {
        self.catch_up(self.now_ns);
        change(&mut self.analog.circuit);
        self.analog.switch(self.driving(), self.now_ns);
    }
}
