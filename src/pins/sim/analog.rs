//! The circuit in virtual time: the solution of the network carried from one change of lines to the next, and the instants
//! at which a sense input falls.

use super::network::{Flow, SimCircuit, line_index};
use super::scene::{DriftScene, NoiseScene, Scene, WalkScene};
use super::sensor::ActiveSensor;
use crate::circuit::Node;
use crate::pins::limits::SAMPLE_NS;
use crate::pins::{Drives, Levels};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// A sense input that fell. Seconds count from the last change of the network, at `since_ns`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fall {
    pub node: Node,
    /// The last change before it, ns.
    pub since_ns: i64,
    /// The voltage passed the threshold, s after `since_ns`.
    pub crossed: f64,
    /// The input changed, s after `since_ns`: with noise.
    pub seen: f64,
    /// The first whole ns by which it has happened.
    pub due_ns: i64,
}

/// The network between two changes.
#[derive(Debug, Clone)]
struct Stretch {
    since_ns: i64,
    /// A sensor changes here; `None`: none does.
    until_ns: Option<i64>,
    flow: Flow,
    high: [bool; 2],
    falls: Option<[Option<Fall>; 2]>,
    told: [bool; 2],
}

/// The circuit, its sensors and its present state.
#[derive(Debug, Clone)]
pub(super) struct Analog {
    pub circuit: SimCircuit,
    sources: Vec<ActiveSensor>,
    /// Lines of the sensors that change with time.
    varying: Drives,
    noise: Option<NoiseScene>,
    drift: Option<DriftSoFar>,
    walk: Option<Walk>,
    rng: ChaCha8Rng,
    on: Drives,
    stretch: Stretch,
}

/// Slow changes of the circuit, and until when they are in it.
#[derive(Debug, Clone, Copy)]
struct DriftSoFar {
    rates: DriftScene,
    applied_minutes: f64,
}

impl DriftSoFar {
    fn apply(&mut self, circuit: &mut SimCircuit, now_ns: i64) {
        let now_minutes = seconds(now_ns) / 60.0;
        let minutes = now_minutes - self.applied_minutes;
        let rate = self.rates.c_per_minute;
        // Linear in time, applied bit by bit to what may have been altered in between.
        let factor = (1.0 + rate * now_minutes) / (1.0 + rate * self.applied_minutes);
        let (first, second) = circuit.network.capacitors();
        [first].into_iter().chain(second).for_each(|c| c.0 *= factor);
        circuit.v_dd += self.rates.v_dd_per_minute.map_or(0.0, |rate| rate.0 * minutes);
        let v_th = self.rates.v_th_per_minute.map_or(0.0, |rate| rate.0 * minutes);
        for sense in &mut circuit.sense {
            sense.falling += v_th;
            sense.rising += v_th;
        }
        self.applied_minutes = now_minutes;
    }
}

/// Random changes of the circuit, and until when they are in it.
#[derive(Debug, Clone)]
struct Walk {
    scene: WalkScene,
    applied_ns: i64,
    rng: ChaCha8Rng,
}

impl Walk {
    fn apply(&mut self, circuit: &mut SimCircuit, now_ns: i64) {
        let root_seconds = seconds(now_ns - self.applied_ns).sqrt();
        let step = self.scene.r_o.0 * root_seconds * self.rng.sample::<f64, _>(StandardNormal);
        // A resistance that would become negative turns back.
        circuit.r_o = circuit.r_o.map(|r_o| (r_o + step).abs());
        self.applied_ns = now_ns;
    }
}

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

impl Analog {
    /// Everything empty and released at time 0.
    pub fn new(
        scene: &Scene,
        circuit: SimCircuit,
        sources: Vec<ActiveSensor>,
        rng: ChaCha8Rng,
        walk_rng: ChaCha8Rng,
    ) -> Analog {
        let flow = circuit.flow([0.0; 2], Drives::NONE);
        let mut analog = Analog {
            circuit,
            sources,
            varying: Drives::NONE,
            noise: scene.noise,
            drift: scene.drift.map(|rates| DriftSoFar { rates, applied_minutes: 0.0 }),
            walk: scene.walk.map(|scene| Walk { scene, applied_ns: 0, rng: walk_rng }),
            rng,
            on: Drives::NONE,
            stretch: Stretch::new(0, None, flow, [false; 2]),
        };
        analog.sensors_changed();
        analog
    }

    /// Connects another sensor; to be followed by [`Analog::switch`].
    pub fn connect(&mut self, channel: usize, source: ActiveSensor) {
        if let Some(place) = self.sources.get_mut(channel) {
            *place = source;
            self.sensors_changed();
        }
    }

    fn sensors_changed(&mut self) {
        self.varying = Drives::NONE;
        for (channel, source) in self.sources.iter_mut().enumerate() {
            if source.is_constant() {
                self.circuit.r_x[channel] = source.r_x(0.0);
            } else {
                self.varying = self.varying.and(Drives::x(channel));
            }
        }
    }

    /// The lines that drive.
    pub fn on(&self) -> Drives {
        self.on
    }

    /// R_x of a channel at an instant, ohm.
    pub fn r_x(&self, channel: usize, at_ns: i64) -> Option<f64> {
        self.sources.get(channel).map(|source| source.clone().r_x(seconds(at_ns)))
    }

    /// The node voltages at an instant of the present stretch.
    #[cfg(test)]
    pub fn voltages(&self, at_ns: i64) -> [f64; 2] {
        self.stretch.flow.after(seconds(at_ns - self.stretch.since_ns))
    }

    /// The input levels at an instant that has been reached by [`Analog::next_fall`].
    pub fn levels(&self, at_ns: i64) -> Levels {
        let [a, b] = self.stretch.high_at(at_ns, &self.circuit);
        Levels { a, b: b || !self.circuit.has_b() }
    }

    /// Makes exactly `on` drive from `at_ns` on. Falls before that have to be taken first.
    pub fn switch(&mut self, on: Drives, at_ns: i64) {
        if on.contains(Drives::CHARGE_A) {
            if let Some(drift) = &mut self.drift {
                drift.apply(&mut self.circuit, at_ns);
            }
            if let Some(walk) = &mut self.walk {
                walk.apply(&mut self.circuit, at_ns);
            }
        }
        self.on = on;
        self.begin_stretch(at_ns);
    }

    /// Takes the next fall that has happened by `by_ns`, in order of time, going on through changes of the sensors.
    pub fn next_fall(&mut self, by_ns: i64) -> Option<Fall> {
        loop {
            let change_ns = self.stretch.until_ns.filter(|until_ns| *until_ns <= by_ns);
            if let Some(fall) = self.fall_in_stretch(change_ns.unwrap_or(by_ns)) {
                self.stretch.told[fall.node.index()] = true;
                return Some(fall);
            }
            self.begin_stretch(change_ns?);
        }
    }

    fn fall_in_stretch(&mut self, by_ns: i64) -> Option<Fall> {
        let falls = self.stretch.falls.unwrap_or_else(|| Node::BOTH.map(|node| self.find_fall(node)));
        self.stretch.falls = Some(falls);
        let waiting = |node: Node| {
            falls[node.index()].filter(|fall| fall.due_ns <= by_ns && !self.stretch.told[node.index()])
        };
        match (waiting(Node::A), waiting(Node::B)) {
            (Some(a), Some(b)) => Some(if b.seen < a.seen { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    fn find_fall(&mut self, node: Node) -> Option<Fall> {
        if node == Node::B && !self.circuit.has_b() {
            return None;
        }
        let stretch = &self.stretch;
        let sense = &self.circuit.sense[node.index()];
        let waveform = stretch.flow.waveform(node);
        let until = stretch.until_ns.map_or(f64::INFINITY, |until_ns| seconds(until_ns - stretch.since_ns));
        // Only what has risen can fall: over a maximum.
        let from = match stretch.high[node.index()] {
            true => 0.0,
            false if waveform.highest(0.0, until) < sense.rising => return None,
            false => waveform.turns().find(|turn| waveform.at(*turn) >= sense.rising)?,
        };
        let crossed = waveform.falls_after(from, sense.falling, until)?;
        let shift = match &self.noise {
            Some(noise) => noise.shift(waveform.slope(crossed).abs(), &mut self.rng),
            None => 0.0,
        };
        let seen = (crossed + shift).max(0.0);
        let due_ns = stretch.since_ns.saturating_add((crossed.min(seen) * 1e9).ceil() as i64);
        Some(Fall { node, since_ns: stretch.since_ns, crossed, seen, due_ns })
    }

    fn begin_stretch(&mut self, at_ns: i64) {
        let high = self.stretch.high_at(at_ns, &self.circuit);
        let changing = self.on.only(self.varying);
        let mut until_ns = None;
        if !changing.is_none() {
            let cell_ns = at_ns.div_euclid(SAMPLE_NS) * SAMPLE_NS;
            until_ns = Some(cell_ns.saturating_add(SAMPLE_NS));
            for line in changing.lines() {
                let channel = line_index(line) - 4;
                self.circuit.r_x[channel] = self.sources[channel].r_x(seconds(cell_ns + SAMPLE_NS / 2));
            }
        }
        let flow =
            self.circuit.flow_after(&self.stretch.flow, seconds(at_ns - self.stretch.since_ns), self.on);
        self.stretch = Stretch::new(at_ns, until_ns, flow, high);
    }
}

impl Stretch {
    fn new(since_ns: i64, until_ns: Option<i64>, flow: Flow, high: [bool; 2]) -> Stretch {
        Stretch { since_ns, until_ns, flow, high, falls: None, told: [false; 2] }
    }

    /// Levels with hysteresis. A fall counts from when it has been told of, so that none is ever passed over.
    fn high_at(&self, at_ns: i64, circuit: &SimCircuit) -> [bool; 2] {
        let t = seconds(at_ns - self.since_ns);
        Node::BOTH.map(|node| {
            let i = node.index();
            if self.high[i] && !self.told[i] {
                return true;
            }
            let waveform = self.flow.waveform(node);
            let fall = self.falls.filter(|_| self.told[i]).and_then(|falls| falls[i]);
            let from = fall.map_or(0.0, |fall| fall.crossed);
            if waveform.highest(from, t.max(from)) < circuit.sense[i].rising {
                return false;
            }
            if fall.is_none() && waveform.at(t) >= circuit.sense[i].rising {
                return true;
            }
            let mut since = waveform.turns().filter(|turn| (from..t).contains(turn)).peekable();
            // What has fallen rises only after it has turned.
            if fall.is_some() && since.peek().is_none() {
                return false;
            }
            since.map(|turn| waveform.at(turn)).fold(waveform.at(t), f64::max) >= circuit.sense[i].rising
        })
    }
}
