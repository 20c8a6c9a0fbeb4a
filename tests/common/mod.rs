//! A bench: a scene, a configuration, and the instrument between them, in virtual time.
#![allow(dead_code)] // Each test program uses its own part.

pub mod chance;
pub mod config;
pub mod decorated;
pub mod faulty;
pub mod seed;

use cermd::characterize::cell::Cell;
use cermd::characterize::watch::{Deviation, Found};
use cermd::instrument::settings::Settings;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::sim::{Kind, Scene, Sensor, SimPins};
use cermd::reading::{Method, Reading, Status};
use cermd::record::Record;
use cermd::units::{Nanos, Ohm};
use chance::{Figure, mean_of, of_boards};
use config::{ConfigFile, config};

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

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64
}

/// The root mean square.
pub fn rms(values: &[f64]) -> f64 {
    mean_square(values).sqrt()
}

/// Errors of readings against the truth.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    pub errors: Vec<f64>,
    pub us: Vec<f64>,
    pub inferred: usize,
    pub without_u: usize,
    /// Of each error, whether its reading says that the sensor moves.
    pub moving: Vec<bool>,
    /// Numbers off by more than ten of their sigma that neither move nor settle.
    pub wild: usize,
    /// States, of faults their names.
    pub not_ok: Vec<&'static str>,
    /// Where the errors of each board begin.
    boards: Vec<usize>,
}

impl Errors {
    /// Those of a cell, one board after the other.
    pub fn of(found: &[Found]) -> Errors {
        let mut all = Errors::default();
        for board in found {
            all.next_board();
            for told in &board.told {
                match told.what {
                    Ok(Deviation { u_ohm: None, .. }) => all.without_u += 1,
                    Ok(Deviation { error_ohm, u_ohm: Some(u_ohm), is_moving, .. }) => {
                        all.errors.push(error_ohm);
                        all.us.push(u_ohm);
                        all.moving.push(is_moving);
                    }
                    Err(state) => all.not_ok.push(state),
                }
            }
        }
        all
    }

    /// What is added from now on is of another board, whose errors have nothing to do with those before.
    pub fn next_board(&mut self) {
        self.boards.push(self.errors.len());
    }

    /// Adds the errors of another board.
    pub fn add_board(&mut self, board: Errors) {
        self.next_board();
        self.errors.extend(board.errors);
        self.us.extend(board.us);
        self.moving.extend(board.moving);
        self.not_ok.extend(board.not_ok);
        self.inferred += board.inferred;
        self.without_u += board.without_u;
        self.wild += board.wild;
    }

    /// Something of the errors of all boards together.
    pub fn together(&self, of: impl Fn(&[f64]) -> f64) -> Figure {
        let boards: Vec<&[f64]> = self.by_boards().map(|(errors, _)| errors).collect();
        of_boards(&boards, of)
    }

    /// Errors and uncertainties of each board that has any.
    fn by_boards(&self) -> impl Iterator<Item = (&[f64], &[f64])> {
        let ends = self.boards.iter().skip(1).copied().chain([self.count()]);
        let boards = self.boards.iter().copied().zip(ends).filter(|(from, to)| from < to);
        boards.map(|(from, to)| (&self.errors[from..to], &self.us[from..to]))
    }

    /// The mean over boards of something of each, from its errors and its uncertainties.
    pub fn by_board(&self, of: impl Fn(&[f64], &[f64]) -> f64) -> Figure {
        mean_of(&self.by_boards().map(|(errors, us)| of(errors, us)).collect::<Vec<_>>())
    }

    /// The share of readings within two of their own sigma.
    pub fn within_2u(&self) -> Figure {
        let by_board = self.by_board(|errors, us| {
            let hits = errors.iter().zip(us).filter(|(error, u)| error.abs() <= 2.0 * **u).count();
            hits as f64 / errors.len() as f64
        });
        // Boards have more numbers and fewer: the share is that of all of them, its error that of the boards.
        Figure { value: self.coverage(), ..by_board }
    }

    /// The root mean square error, of what is predicted.
    pub fn rms_ratio(&self, predicted: f64) -> Figure {
        self.by_board(|errors, _| mean_square(errors)).sqrt().times(1.0 / predicted)
    }

    /// The root mean square of errors in their own sigma.
    pub fn pulls(&self) -> Figure {
        let pulls =
            |errors: &[f64], us: &[f64]| errors.iter().zip(us).map(|(e, u)| e / u).collect::<Vec<_>>();
        self.by_board(|errors, us| mean_square(&pulls(errors, us))).sqrt()
    }

    pub fn mean_error(&self) -> Figure {
        let by_board = self.by_board(|errors, _| errors.iter().sum::<f64>() / errors.len() as f64);
        Figure { value: self.mean(), ..by_board }
    }

    pub fn add(&mut self, reading: &Reading, truth: f64) {
        match reading.status {
            Status::Ok { branch, r_ohm, is_moving, is_settling, .. } => {
                let Some(u) = r_ohm.u else {
                    self.without_u += 1;
                    return;
                };
                self.errors.push(r_ohm.value - truth);
                self.us.push(u);
                self.moving.push(is_moving);
                let is_wild = !is_moving && !is_settling && (r_ohm.value - truth).abs() > 10.0 * u;
                self.wild += usize::from(is_wild);
                self.inferred += usize::from(branch == cermd::reading::Branch::Inferred);
            }
            Status::Fault(fault) => self.not_ok.push(fault.as_str()),
            status => self.not_ok.push(name_of(&status)),
        }
    }

    /// Without the readings that say that the sensor moves: these are counted as states.
    pub fn at_rest(&self) -> Errors {
        let mut rest = Errors { not_ok: self.not_ok.clone(), ..Errors::default() };
        let mut boards = self.boards.iter().peekable();
        for (index, is_moving) in self.moving.iter().enumerate() {
            while boards.next_if(|first| **first <= index).is_some() {
                rest.next_board();
            }
            if *is_moving {
                rest.not_ok.push("moving");
            } else {
                rest.errors.push(self.errors[index]);
                rest.us.push(self.us[index]);
                rest.moving.push(false);
            }
        }
        rest
    }

    pub fn count(&self) -> usize {
        self.errors.len()
    }

    pub fn mean(&self) -> f64 {
        self.errors.iter().sum::<f64>() / self.count() as f64
    }

    pub fn sd(&self) -> f64 {
        let mean = self.mean();
        (self.errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (self.count() - 1) as f64).sqrt()
    }

    /// Half the width that the middle 68.27 % of the errors take: what one spike of a thousand does not change.
    pub fn spread(&self) -> f64 {
        spread_of(&self.errors)
    }

    pub fn max(&self) -> f64 {
        self.errors.iter().fold(0.0, |max, e| e.abs().max(max))
    }

    pub fn mean_u(&self) -> f64 {
        rms(&self.us)
    }

    /// The share of readings within two of their own sigma.
    pub fn coverage(&self) -> f64 {
        let within = self.errors.iter().zip(&self.us).filter(|(e, u)| e.abs() <= 2.0 * **u).count();
        within as f64 / self.count() as f64
    }
}

/// See [`Errors::spread`].
pub fn spread_of(errors: &[f64]) -> f64 {
    let mut errors = errors.to_vec();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
    (at(0.841_345) - at(0.158_655)) / 2.0
}
