//! A bench: a scene, a configuration, and the instrument between them, in virtual time.
#![allow(dead_code, unused_imports)] // Each test program uses its own part.

pub mod chance;
pub mod config;
pub mod decorated;
pub mod errors;
pub mod faulty;
pub mod seed;

use cermd::characterize::cell::Cell;
use cermd::characterize::watch::Found;
use cermd::instrument::settings::Settings;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::sim::{Kind, Scene, Sensor, SimPins};
use cermd::reading::{Method, Reading, Status};
use cermd::record::Record;
use cermd::units::{Nanos, Ohm};
use config::{ConfigFile, config};
pub use errors::{Errors, rms, spread_of};

/// What a test runs: a board by name, and what is changed on it and in the configuration.
#[derive(Debug, Clone)]
pub struct Bench {
    pub scene: Scene,
    pub config: ConfigFile,
    pub seed: u64,
}

/// As many boards as usual, or so many times as many.
pub fn times() -> u64 {
    std::env::var("CERMD_BOARDS").map_or(1, |times| times.parse().expect("CERMD_BOARDS is a whole number"))
}

/// The name of a status in the stream.
pub fn name_of(status: &Status) -> &'static str {
    match status {
        Status::Ok { .. } => "ok",
        Status::Open { .. } => "open",
        Status::Short { .. } => "short",
        Status::Fault(_) => "fault",
    }
}

/// Time for each published reading of these instruments, s.
pub fn published_s(found: &[Found]) -> f64 {
    let readings = found.iter().map(|found| found.told.len()).sum::<usize>();
    found.iter().map(|found| found.times.whole_s()).sum::<f64>() / readings as f64
}

pub fn kind_of(method: Method) -> Kind {
    match method {
        Method::Qerm => Kind::SeriesCalibration,
        _ => Kind::TwoCapacitor,
    }
}

/// The circuit table that goes with a board.
pub fn circuit_of(name: &str, kind: Kind) -> &'static str {
    match (name, kind) {
        ("fpga-paper", Kind::TwoCapacitor) => {
            "c-a = \"330 nF\"\nc-b = \"22 nF\"\nr-c1 = \"2.32 kohm\"\nv-th = \"1.4 V\"\nr-charge = \"120 ohm\""
        }
        ("fpga-paper", _) => "c = \"20 nF\"\nr-c1 = \"2.32 kohm\"\nv-th = \"1.4 V\"",
        (_, Kind::TwoCapacitor) => "c-a = \"2.2 uF\"\nc-b = \"680 nF\"\nv-th = \"1.1 V\"",
        _ => "c = \"470 nF\"\nv-th = \"1.1 V\"",
    }
}

/// A file for one sensor, `x`, at the usual calibration resistors.
pub fn file_for(kind: Kind, method: Method, circuit: &str, scene: &str) -> ConfigFile {
    config(|c| {
        // What the capacitors are comes with the other lines.
        let c = match kind {
            Kind::TwoCapacitor => c,
            Kind::OneCapacitor => c.one_capacitor("one-capacitor", ""),
            Kind::SeriesCalibration => c.one_capacitor("series-calibration", ""),
        };
        c.lines("circuit", circuit).set("measure.method", method.as_str());
        c.channel("x").set("mock.scene", scene)
    })
}

impl Bench {
    /// A built-in board with a sensor of `r_ohm` on one channel, read by `method`; `measure` adds lines to `[measure]`.
    pub fn new(name: &str, method: Method, r_ohm: f64, seed: u64, measure: &str) -> Bench {
        Bench::with_kind(name, kind_of(method), method, r_ohm, seed, measure)
    }

    pub fn with_kind(name: &str, kind: Kind, method: Method, r_ohm: f64, seed: u64, measure: &str) -> Bench {
        let scene = Scene::builtin(name).unwrap().with_kind(kind).unwrap();
        let scene = scene.with_sensors(vec![Sensor::Constant(Ohm(r_ohm))]).unwrap();
        let mut config = file_for(kind, method, circuit_of(name, kind), name);
        config.lines("measure", measure);
        if name == "fpga-paper" {
            config.set("measure.resolution", "20 ns");
        }
        Bench { scene, config, seed }
    }

    /// So many instruments with so many readings each, beginning at this seed.
    pub fn cell(&self, r_ohm: f64, instruments: u64, readings: usize) -> Cell {
        let (scene, config) = (self.scene.clone(), self.config.parse());
        let (name, seed) = ("bench".to_owned(), seed::seed(self.seed));
        Cell { name, scene, config, r_ohm, change: None, seed, instruments, readings }
    }

    pub fn instrument(&self) -> Instrument<SimPins> {
        let (pins, settings) = self.parts();
        Instrument::new(pins, settings)
    }

    /// What an instrument is made of.
    pub fn parts(&self) -> (SimPins, Settings) {
        let settings = self.config.parse().settings().unwrap();
        (SimPins::new(&self.scene, Some(seed::seed(self.seed))), settings)
    }
}

/// The page that the test program `test` writes, `name` in docs: written if that is asked for; otherwise it has to be on
/// disk as it would be.
pub fn check_page(test: &str, name: &str, page: &str) {
    let path = format!("{}/docs/{name}", env!("CARGO_MANIFEST_DIR"));
    if std::env::var_os("UPDATE_DOCS").is_some() && seed::family() == 0 {
        std::fs::write(&path, page).unwrap();
    }
    // A page is of the first family of seeds.
    if seed::family() != 0 {
        return;
    }
    let on_disk = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        on_disk == page,
        "{path} is out of date; write it with UPDATE_DOCS=1 cargo test --test {test}\n{page}"
    );
}

/// Steps until so many readings have come, and hands each to `each`.
pub fn read(instrument: &mut Instrument<SimPins>, count: usize, mut each: impl FnMut(&Reading)) {
    let mut seen = 0;
    while seen < count {
        instrument
            .step(&mut |message| {
                if let Message::Reading(reading) = message {
                    seen += 1;
                    each(&reading);
                }
            })
            .unwrap();
    }
    assert_eq!(instrument.pins().conflicts(), 0, "two outputs against each other");
}

/// The next reading.
pub fn next_reading(instrument: &mut Instrument<SimPins>) -> Reading {
    let mut last = None;
    read(instrument, 1, |reading| last = Some(*reading));
    last.unwrap()
}

/// The next reading of a sensor that moves, handed to `add` with the resistance at its instant, which is NaN of what is no number. A number
/// whose sensor changed so much in a discharge of `seconds_per_ohm` that there is no one true value is left out.
pub fn next_with_truth(
    instrument: &mut Instrument<SimPins>,
    seconds_per_ohm: f64,
    mut add: impl FnMut(&Reading, f64),
) {
    let reading = next_reading(instrument);
    let Status::Ok { r_ohm, .. } = reading.status else { return add(&reading, f64::NAN) };
    let half = Nanos::from_seconds(0.5 * seconds_per_ohm * r_ohm.value.max(1000.0));
    let truth = instrument.pins().one_r_x(reading.channel, reading.at, half);
    truth.into_iter().for_each(|truth| add(&reading, truth));
}

/// Steps until the second of two instants, and hands each message of a step after the first one to `each`.
pub fn hear_between(
    instrument: &mut Instrument<SimPins>,
    [from, to]: [Nanos; 2],
    mut each: impl FnMut(Message),
) {
    while instrument.pins().now() < to {
        let counts = instrument.pins().now() > from;
        instrument
            .step(&mut |message| {
                if counts {
                    each(message)
                }
            })
            .unwrap();
    }
}

/// A board without what happens once in some hundred readings: late stamps, preempted calls.
pub fn quiet(mut scene: Scene) -> Scene {
    for delay in [&mut scene.stamps, &mut scene.wake, &mut scene.sleep] {
        let delay = delay.as_mut().unwrap();
        (delay.tail_probability, delay.tail_mean) = (None, None);
    }
    let calls = scene.calls.as_mut().unwrap();
    (calls.tail_probability, calls.tail_mean) = (None, None);
    scene
}

/// Steps until the offset is known.
pub fn settle<P: Pins>(instrument: &mut Instrument<P>) {
    let mut steps = 0;
    while !instrument.stats().offset_is_known {
        instrument.step(&mut |_| {}).unwrap();
        steps += 1;
        assert!(steps < 100_000, "the offset is never found");
    }
}

/// Reads until what is done once after a start is over: the first look for a leak, which makes cycles longer for a while.
pub fn rest(instrument: &mut Instrument<SimPins>) {
    while instrument.pins().now() < Nanos(8_000_000_000) {
        read(instrument, 1, |_| {});
    }
}

/// Records of discharges, in order.
pub fn records(instrument: &mut Instrument<SimPins>, count: usize) -> Vec<Record> {
    let mut records = Vec::new();
    while records.len() < count {
        instrument
            .step(&mut |message| {
                if let Message::Discharge { record, .. } = message {
                    records.push(record);
                }
            })
            .unwrap();
    }
    records
}
