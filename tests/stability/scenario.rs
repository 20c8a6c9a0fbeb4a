//! A scenario: a board, what is expected of each method on it, and the row of the table that comes of it.

use crate::common::chance::{Figure, Verdict, share_below, share_is_in};
use crate::common::{self, Bench, Errors, file_for, kind_of};
use crate::paper::Parts;
use crate::picture;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::sim::{Kind, Scene, Sensor, SimPins};
use cermd::reading::{Fault, Method};
use cermd::units::{Farad, Ohm, Volt};
use std::fmt::{Display, Write};
use std::ops::RangeInclusive;

/// How somebody fares with a method where something is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// By the row's own criterion.
    Holds,
    /// It does not, and the readings say so: by their uncertainty, or by a state in the place of a number.
    Told,
    /// It does not, and nobody is told.
    Fails,
}

impl Mark {
    pub const ALL: [Mark; 3] = [Mark::Holds, Mark::Told, Mark::Fails];

    pub fn sign(self) -> char {
        ['✔', '!', '✘'][self as usize]
    }

    pub fn word(self) -> &'static str {
        ["holds", "told", "fails"][self as usize]
    }
}

/// What was found of a method.
pub struct Cell {
    /// By our methods; else by the published equations on the same discharges, or by another program.
    pub is_ours: bool,
    pub mark: Mark,
    pub text: String,
}

/// One row of the table, and what is wrong with it.
pub struct Scenario {
    pub title: &'static str,
    pub holds_if: &'static str,
    pub cells: [Vec<Cell>; Method::ALL.len()],
    pub why: String,
    pub wrong: String,
    seeds: String,
}

impl Scenario {
    /// `seeds`: those that the failure is to be repeated with.
    pub fn new(title: &'static str, holds_if: &'static str, seeds: impl Into<String>) -> Scenario {
        let (cells, why, wrong) = (Default::default(), String::new(), String::new());
        Scenario { title, holds_if, cells, why, wrong, seeds: seeds.into() }
    }

    fn require_of(&mut self, what: impl Display, is_so: bool) {
        println!("{}: {what}", self.title);
        if !is_so {
            writeln!(self.wrong, "{}: {what}, seeds {}", self.title, self.seeds).unwrap();
        }
    }

    /// Asserts that a figure is what is predicted as well as `budget` says: what the prediction leaves out, not chance.
    pub fn expect(&mut self, what: impl Display, found: Figure, predicted: f64, budget: f64) {
        let is_so = found.is(predicted, budget);
        self.require_of(format!("{what}: {found:.5}, predicted {predicted:.5} +- {budget:.5}"), is_so);
    }

    /// Asserts that a figure is within what is promised.
    pub fn promise(&mut self, what: impl Display, found: Figure, promised: RangeInclusive<f64>) {
        let is_so = found.is_in(promised.clone());
        self.require_of(format!("{what}: {found:.5}, promised {promised:.5?}"), is_so);
    }

    /// Asserts that so many of `n` trials, which have nothing to do with each other, come out with a chance in this range.
    pub fn expect_share(
        &mut self,
        what: impl Display,
        hits: usize,
        n: usize,
        predicted: RangeInclusive<f64>,
    ) {
        let is_so = share_is_in(hits, n, predicted.clone());
        self.require_of(format!("{what}: {hits} of {n}, predicted {predicted:.5?}"), is_so);
    }

    /// Asserts what chance has no part in.
    pub fn require(&mut self, what: impl Display, is_so: bool) {
        self.require_of(format!("{what}: {is_so}"), is_so);
    }

    /// A figure of one of our methods, whether it holds, and whether it was predicted to.
    pub fn cell(&mut self, method: Method, figure: impl Display, holds: impl Into<Verdict>, expected: bool) {
        self.put(method, (true, figure.to_string()), holds.into(), expected, false);
    }

    /// The same of readings that may tell what is wrong.
    pub fn cell_of(
        &mut self,
        method: Method,
        figure: impl Display,
        errors: &Errors,
        holds: impl Into<Verdict>,
        expected: bool,
    ) {
        self.put(method, (true, figure.to_string()), holds.into(), expected, tells(errors));
    }

    /// The same of published equations, or of a program that is not ours.
    pub fn published(
        &mut self,
        method: Method,
        figure: impl Display,
        holds: impl Into<Verdict>,
        expected: bool,
    ) {
        self.put(method, (false, format!("published: {figure}")), holds.into(), expected, false);
    }

    fn put(
        &mut self,
        method: Method,
        (is_ours, text): (bool, String),
        verdict: Verdict,
        expected: bool,
        is_told: bool,
    ) {
        let mark = match (verdict.holds, is_told) {
            (true, _) => Mark::Holds,
            (false, true) => Mark::Told,
            (false, false) => Mark::Fails,
        };
        println!("{}: {}: {text}: {}", self.title, method.as_str(), mark.word());
        if !verdict.may_be(expected) {
            let was = if expected { "hold" } else { "fail" };
            writeln!(
                self.wrong,
                "{}: {}: was to {was}, but {text}, seeds {}",
                self.title,
                method.as_str(),
                self.seeds
            )
            .unwrap();
        }
        self.cells[method as usize].push(Cell { is_ours, mark, text });
    }

    /// That there is no number is right by the row's criterion, and no more than told.
    pub fn only_told(&mut self, method: Method) {
        self.cells[method as usize].last_mut().unwrap().mark = Mark::Told;
    }

    /// The row of the picture: of several findings the worst.
    pub fn picture(&self) -> picture::Row {
        let worst = |cells: &[Cell], is_ours: bool| {
            let found = cells.iter().filter(|cell| cell.is_ours == is_ours);
            found.max_by_key(|cell| cell.mark as usize).map(|cell| (cell.mark, cell.text.clone()))
        };
        let marks =
            self.cells.iter().map(|cells| [false, true].map(|is_ours| worst(cells, is_ours))).collect();
        // What comes after a colon is in the table.
        let name = self.title.split(':').next().unwrap_or_default().to_owned();
        picture::Row { name, marks }
    }

    /// The row in Markdown.
    pub fn row(&self, number: usize) -> String {
        let mut row = format!("| {number} | {} | {} |", self.title, self.holds_if);
        for cell in &self.cells {
            let texts: Vec<String> =
                cell.iter().map(|Cell { mark, text, .. }| format!("{} {text}", mark.sign())).collect();
            let text = if cell.is_empty() { "–".to_owned() } else { texts.join("<br>") };
            write!(row, " {text} |").unwrap();
        }
        row
    }
}

/// A board that a scenario changes.
#[derive(Debug, Clone)]
pub struct Board {
    pub scene: Scene,
    pub parts: Parts,
    /// `None`: that of the method.
    pub kind: Option<Kind>,
    /// More lines of `[measure]`.
    pub measure: String,
}

impl Board {
    /// `pi4` with other capacitors and resistors, and without its rare long delays.
    pub fn quiet(parts: Parts) -> Board {
        let board = Board::pi4(parts);
        Board { scene: common::quiet(board.scene), ..board }
    }

    /// `pi4` with other capacitors and resistors.
    pub fn pi4(parts: Parts) -> Board {
        Board { scene: Scene::builtin("pi4").unwrap(), parts, kind: None, measure: String::new() }
    }

    /// The board of the paper.
    pub fn paper() -> Board {
        let measure = "resolution = \"20 ns\"\ncharge-time = \"163.84 us\"\nsettle-time = \"0 us\"\n";
        Board {
            scene: Scene::builtin("fpga-paper").unwrap(),
            parts: Parts::PAPER,
            kind: None,
            measure: measure.to_owned(),
        }
    }

    /// The same with more lines of `[measure]`.
    pub fn with(&self, measure: &str) -> Board {
        Board { measure: format!("{}{measure}\n", self.measure), ..self.clone() }
    }

    pub fn bench(&self, method: Method, r_ohm: f64, seed: u64) -> Bench {
        let Parts { c_a, c_b, c, r_c1, r_c2, v_th } = self.parts;
        let kind = self.kind.unwrap_or(kind_of(method));
        let mut scene = self.scene.clone();
        let circuit = &mut scene.circuit;
        (circuit.c_a, circuit.c_b, circuit.c) = (Some(Farad(c_a)), Some(Farad(c_b)), Some(Farad(c)));
        (circuit.r_c1, circuit.r_c2) = (Ohm(r_c1), Ohm(r_c2));
        circuit.threshold.falling = Volt(v_th);
        let scene = scene.with_kind(kind).unwrap().with_sensors(vec![Sensor::Constant(Ohm(r_ohm))]).unwrap();
        let capacitors = match kind {
            Kind::TwoCapacitor => format!("c-a = \"{c_a} F\"\nc-b = \"{c_b} F\""),
            _ => format!("c = \"{c} F\""),
        };
        let mut config = file_for(kind, method, &capacitors, "pi4");
        config.set("circuit.r-c1", format!("{r_c1} ohm")).set("circuit.r-c2", format!("{r_c2} ohm"));
        config.set("circuit.v-th", format!("{v_th} V")).lines("measure", &self.measure);
        Bench { scene, config, seed }
    }

    /// The errors of one instrument for each seed: so many readings, after as many as it needs to settle.
    pub fn errors(&self, method: Method, r_ohm: f64, seeds: u64, readings: usize) -> Errors {
        self.errors_with(method, r_ohm, seeds, readings, |pins, _| pins)
    }

    /// The same with something around the pins of each seed.
    pub fn errors_with<P: Pins>(
        &self,
        method: Method,
        r_ohm: f64,
        seeds: u64,
        readings: usize,
        around: impl Fn(SimPins, u64) -> P,
    ) -> Errors {
        let mut all = Errors::default();
        for seed in 0..seeds {
            all.next_board();
            let (pins, settings) = self.bench(method, r_ohm, seed).parts();
            let mut instrument = Instrument::new(around(pins, seed), settings);
            let (mut unsettled, mut before, mut counted) = (MOST_UNSETTLED, SETTLING, 0);
            while counted < readings {
                if unsettled > 0 && instrument.stats().offset_is_known {
                    unsettled = 0;
                }
                let mut take = |message| {
                    let Message::Reading(reading) = message else { return };
                    match (unsettled, before) {
                        (0, 0) => {
                            counted += 1;
                            all.add(&reading, r_ohm);
                        }
                        (0, _) => before -= 1,
                        _ => unsettled -= 1,
                    }
                };
                instrument.step(&mut take).unwrap();
            }
        }
        all
    }
}

/// Readings after which an instrument that has not found its offset is looked at as it is.
const MOST_UNSETTLED: usize = 400;
/// Readings after that which do not count.
const SETTLING: usize = 60;

/// What first-order propagation leaves out, and what a noise that is learned from some tens of discharges adds.
pub const FIRST_ORDER: f64 = 0.03;

/// The root mean square of all errors.
pub fn rms(errors: &Errors) -> f64 {
    common::rms(&errors.errors)
}

/// The share of readings without a number.
pub fn without_number(errors: &Errors) -> f64 {
    let others = errors.not_ok.len() + errors.without_u;
    others as f64 / (others + errors.count()) as f64
}

/// The readings that say that the sensor moves, as numbers or without one.
pub fn moving(errors: &Errors) -> usize {
    let faults = errors.not_ok.iter().filter(|name| **name == Fault::Unsettled.as_str()).count();
    faults + errors.moving.iter().filter(|is_moving| **is_moving).count()
}

/// A relative error in percent, two digits that count.
pub fn percent(relative: f64) -> String {
    let percent = 100.0 * relative;
    match percent.abs() {
        p if p >= 9.95 => format!("{percent:.0} %"),
        p if p >= 0.995 => format!("{percent:.1} %"),
        p if p >= 0.0995 => format!("{percent:.2} %"),
        _ => format!("{percent:.3} %"),
    }
}

/// Whether the numbers are true: most readings are numbers, and 90 % of these within two of their own sigma.
pub fn is_true(errors: &Errors) -> Verdict {
    let others = errors.not_ok.len() + errors.without_u;
    share_below(others, others + errors.count(), 0.1) & errors.within_2u().times(-1.0).below(-0.9)
}

/// Whether readings say what they are worth: 90 % of the numbers are within two of their own sigma, and what is none has a
/// state.
fn tells(errors: &Errors) -> bool {
    errors.count() == 0 || errors.without_u == 0 && errors.within_2u().value > 0.9
}

/// The figures that [`is_true`] judges.
pub fn truth(errors: &Errors, r_ohm: f64) -> String {
    let mut text = String::new();
    if errors.count() > 0 {
        write!(text, "error {}, {:.0} % in 2u", percent(rms(errors) / r_ohm), 100.0 * errors.coverage())
            .unwrap();
    }
    let missing = without_number(errors);
    // What would be 0 %, rounded, is left out.
    if missing > 0.005 {
        let separator = if text.is_empty() { "" } else { ", " };
        write!(text, "{separator}{:.0} % no number", 100.0 * missing).unwrap();
    }
    text
}
