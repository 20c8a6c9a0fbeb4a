//! Two sensors on one board, charges of any length, and wake-ups that come late.

use crate::common::chance::{Figure, mean_of};
use crate::common::{Bench, Errors, quiet, seed, settle};
use cermd::circuit::{Chargers, Node};
use cermd::config::Config;
use cermd::instrument::discharge::Charge;
use cermd::instrument::settings::{Charges, Settings};
use cermd::instrument::{Instrument, Message};
use cermd::pins::sim::{Sensor, SimPins};
use cermd::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use cermd::reading::{Method, Reading};
use cermd::units::{Nanos, Ohm, Seconds};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

pub const INSTRUMENTS: u64 = 200;
const READINGS: usize = 40;
/// Readings of each instrument that do not count, after its offset is known.
const BEFORE: usize = 60;
/// The sensor that is read before is a short circuit: it falls farthest, and no method finishes it through Rc2.
pub const NEIGHBOUR_OHM: f64 = 0.5;
/// A charge that remembers nothing.
pub const LONG_TAUS: f64 = 16.0;
/// How late a wake-up from a rest is, and its scatter, ns.
const LATE_NS: [f64; 2] = [53_000.0, 5_000.0];
/// From a stamp until the program is awake, s.
const WAKE: f64 = 53e-6;
/// From the crossing that it is woken for to the release: the stamp is 8 us late, and a call releases the line.
const REACTION: f64 = WAKE + 9e-6;

/// Pins whose rests end late.
pub struct Late {
    pins: SimPins,
    rng: ChaCha8Rng,
}

impl Pins for Late {
    fn now(&mut self) -> Nanos {
        self.pins.now()
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.pins.drive(on)
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.pins.arm()
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.pins.edge(until)
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.sleep_until(at)
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let late_ns: f64 = Normal::new(LATE_NS[0], LATE_NS[1]).unwrap().sample(&mut self.rng);
        self.pins.sleep_until(at + Nanos(late_ns.max(0.0) as i64))
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.pins.levels()
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.rest_before_edge(at)
    }
    fn particulars(&self) -> Particulars<'_> {
        self.pins.particulars()
    }
}

/// Which chargers make the charges of an instrument, and for how many of their time constants.
pub type Charging = (Chargers, f64);

/// A method and the sensor that is looked at.
#[derive(Debug, Clone, Copy)]
pub struct Board {
    pub method: Method,
    pub r_ohm: f64,
}

/// What came of the sensor's readings.
pub struct Found {
    /// Mean error of each instrument, ohm.
    means: Vec<f64>,
    pub mean_u: f64,
    pub within_2u: Figure,
    /// The share of readings without a number.
    pub missing: f64,
}

impl Found {
    /// Mean error, ohm, less that of another charge.
    pub fn ohm_beyond(&self, other: &Found) -> Figure {
        mean_of(&self.means).less(mean_of(&other.means))
    }

    /// The same in the stated uncertainty of a reading.
    pub fn error_beyond(&self, other: &Found) -> Figure {
        self.ohm_beyond(other).times(1.0 / self.mean_u)
    }
}

impl Board {
    fn config(self) -> Config {
        Bench::new("pi4", self.method, self.r_ohm, 0, "").config.channel("y").parse()
    }

    pub fn tau(self, chargers: Chargers) -> Seconds {
        self.config().circuit.charge_tau(chargers)
    }

    /// What is charged when nothing is said: through A alone for so long, then through all chargers for so long.
    pub fn automatic(self) -> Charge {
        let charges = self.config().charges();
        if self.config().last_node() == Node::B { charges.to_b } else { charges.to_a }
    }

    /// The automatic time through these chargers, if no others were used.
    pub fn automatic_taus(self, chargers: Chargers) -> f64 {
        self.config().shortest_charge(chargers).0 / self.tau(chargers).0
    }

    /// Through A alone for another time, what B gets being as it is; or all of it through all chargers.
    fn settings(self, (chargers, taus): Charging) -> Settings {
        let mut settings = self.config().settings().unwrap();
        let time = Nanos::from_seconds(taus * self.tau(chargers).0);
        let charges = settings.charge;
        settings.charge = match chargers {
            Chargers::OfA => {
                let to_b = Charge { alone: time, ..charges.to_b };
                Charges { to_a: Charge::alone(time), to_b, ..charges }
            }
            Chargers::All => Charges::alike(Charge::together(time)),
        };
        settings
    }

    fn pins(self, sensors: &[f64], seed: u64) -> Late {
        let scene = quiet(Bench::new("pi4", self.method, self.r_ohm, seed, "").scene);
        let sensors = sensors.iter().map(|r_ohm| Sensor::Constant(Ohm(*r_ohm))).collect();
        let pins = SimPins::new(&scene.with_sensors(sensors).unwrap(), Some(seed::seed(seed)));
        Late { pins, rng: seed::rng(seed) }
    }

    /// Readings of the second channel, after those of another resistance on the first.
    pub fn measure(self, neighbour_ohm: f64, charging: Charging) -> Found {
        self.measure_leaking(neighbour_ohm, charging, f64::INFINITY)
    }

    /// The same with a resistance from B to ground.
    pub fn measure_leaking(self, neighbour_ohm: f64, charging: Charging, leak_ohm: f64) -> Found {
        let settings = self.settings(charging);
        let (mut all, mut means) = (Errors::default(), Vec::new());
        for seed in 0..INSTRUMENTS {
            let mut pins = self.pins(&[neighbour_ohm, self.r_ohm], seed);
            pins.pins.alter(|circuit| circuit.sense[1].to_ground = 1.0 / leak_ohm);
            let mut instrument = Instrument::new(pins, settings.clone());
            let mut errors = Errors::default();
            settle(&mut instrument);
            readings(&mut instrument, 1, BEFORE, |_| {});
            readings(&mut instrument, 1, READINGS, |reading| errors.add(reading, self.r_ohm));
            if errors.count() > 0 {
                means.push(errors.mean());
            }
            all.add_board(errors);
        }
        let missing = 1.0 - all.count() as f64 / (INSTRUMENTS as f64 * READINGS as f64);
        Found { means, mean_u: all.mean_u(), within_2u: all.within_2u(), missing }
    }

    /// Readings per second of a sensor that is alone.
    pub fn rate_alone(self, charging: Charging) -> f64 {
        let mut settings = self.settings(charging);
        settings.channels.truncate(1);
        let mut instrument = Instrument::new(self.pins(&[self.r_ohm], 1), settings);
        settle(&mut instrument);
        readings(&mut instrument, 0, BEFORE, |_| {});
        let mut seconds = 0.0;
        readings(&mut instrument, 0, 1000, |reading| seconds += reading.duration.as_seconds());
        1000.0 / seconds
    }

    /// The mean error that charges of so many time constants make by the closed form, ohm: eq. (3) or (11) of discharges that
    /// follow R_x (that through R_1), R_1 (that through R_2) and the neighbour (that of the sensor). For the methods and
    /// resistances that use these equations.
    pub fn predicted_ohm(self, (chargers, taus): Charging) -> Option<f64> {
        let nodes = match (self.method, chargers) {
            (Method::Tpcm, _) => &[Node::A][..],
            // All of the charge through A: what B gets after that takes a part of it away.
            (Method::Tcdic, Chargers::All) => &Node::BOTH,
            _ => return None,
        };
        let circuit = self.config().circuit;
        let g_of = |node: &Node| circuit.g(*node).unwrap().0;
        let (mut memory, mut g) = (0.0, 0.0);
        for node in nodes {
            memory += g_of(node) * circuit.charge_memory(*node, chargers)?;
            g += g_of(node);
        }
        let with_r_o = |r: Ohm| r.0 + circuit.r_o.0;
        let [r1, r2, rx] = [circuit.r_c1, circuit.r_c2, Ohm(self.r_ohm)].map(with_r_o);
        let rho = (rx - r1) / (r2 - r1);
        let left = circuit.left_at_crossing(*nodes.last()?)?;
        // Where B crosses before the program has been woken for A, it is not woken again.
        let last_gap = g_of(nodes.last()?) - g_of(&Node::A);
        let late = |r: f64| if last_gap * r < WAKE { REACTION - last_gap * r } else { REACTION };
        let depth = |r: f64| 1.0 - left * (-late(r) / (r * circuit.c_total().0)).exp();
        let after_neighbour = depth(with_r_o(Ohm(NEIGHBOUR_OHM)));
        let depths = rx * after_neighbour - (1.0 - rho) * r1 * depth(rx) - rho * r2 * depth(r1);
        // The charge lasts until the program is awake.
        let late = LATE_NS[0] * 1e-9 / self.tau(chargers).0;
        Some(memory / g * depths * (-taus - late).exp())
    }
}

fn readings(instrument: &mut Instrument<Late>, channel: usize, count: usize, mut each: impl FnMut(&Reading)) {
    let mut seen = 0;
    while seen < count {
        instrument
            .step(&mut |message| match message {
                Message::Reading(reading) if reading.channel == channel => {
                    seen += 1;
                    each(&reading);
                }
                _ => {}
            })
            .unwrap();
    }
}
