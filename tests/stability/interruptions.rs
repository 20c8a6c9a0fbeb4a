//! The computer does something else for a while: preempted, suspended, or with another time on its clock.

use crate::by_hand::ByHand;
use crate::common::Errors;
use crate::common::chance::{Figure, mean_of, sigmas};
use crate::common::seed::rng;
use crate::disturbed::{Disturbed, Trouble};
use crate::paper::{self, Parts, R_O, Times};
use crate::scenario::{Board, Scenario, moving, percent, without_number};
use crate::switching::{HALF_CALL, STAMP};
use cermd::pins::sim::Scene;
use cermd::reading::Method;
use cermd::units::{Ampere, Nanos};
use rand::RngExt;

const PREEMPTED: Nanos = Nanos(50_000_000);
const R_OHM: f64 = 1000.0;
const TRUTH: Figure = Figure { value: R_OHM, u: 0.0, margin: 0.0 };
/// One discharge in so many is struck, any of the first few of them: a sensor's and a resistor's alike, whatever the order that cycles
/// have them in, but never two readings in a row.
const EVERY: u64 = 11;
const FIRST: u64 = 6;
/// Boards for a share that is predicted.
const MANY: u64 = 200;

/// Whether a discharge is, by its number.
fn one_of_some(seed: u64) -> impl Fn(u64) -> bool {
    move |discharge| {
        let of = (seed << 32) | (discharge / EVERY);
        discharge % EVERY == rng(of).random_range(0..FIRST)
    }
}

/// Discharges of a cycle, with those that are split; those of a resistor are taken again when they are struck, and not struck again.
const OF_A_CYCLE: f64 = 3.0 + 1.0 / 8.0;
const TAKEN_AGAIN: f64 = 2.0;

/// What shows of a sensor's discharge that is struck is that reading and no other.
fn expect_struck(it: &mut Scenario, errors: &Errors) {
    let readings = (errors.not_ok.len() + errors.without_u + errors.count()) as f64;
    // All alike but those taken again: p of a cycle = (of a cycle + p of what is taken again) / every.
    let predicted = OF_A_CYCLE / (EVERY as f64 * OF_A_CYCLE - TAKEN_AGAIN);
    let share = moving(errors) as f64 / readings;
    let u = (predicted * (1.0 - predicted) / readings).sqrt();
    let share = Figure { value: share, u, margin: sigmas() * u };
    it.expect("tpcm of ours: moving or unsettled", share, predicted, 0.0);
}

/// The errors of a method of ours whose discharges are struck now and then.
fn struck(board: &Board, method: Method, trouble: Trouble, lasts: Nanos) -> Errors {
    struck_on(20, board, method, trouble, lasts)
}

/// The same on so many boards.
fn struck_on(boards: u64, board: &Board, method: Method, trouble: Trouble, lasts: Nanos) -> Errors {
    board.errors_with(method, R_OHM, boards, 100, |pins, seed| {
        Disturbed::new(pins, trouble, lasts, one_of_some(seed))
    })
}

/// The share of numbers that are off by more than 5 of their own sigma and 1 %.
fn wrong(errors: &Errors) -> f64 {
    wrong_beside(errors, 0.0)
}

/// The same where the mean of undisturbed readings is off by so much.
fn wrong_beside(errors: &Errors, bias: f64) -> f64 {
    let is_wrong = |(error, u): &(&f64, &f64)| {
        let off = (**error - bias).abs();
        off > 5.0 * **u && off > 0.01 * R_OHM
    };
    let count = errors.errors.iter().zip(&errors.us).filter(is_wrong).count();
    count as f64 / (errors.count() + errors.not_ok.len()) as f64
}

/// The mean of an equation over cycles whose x discharge alone is struck.
fn by_hand(
    board: &Board,
    trouble: Trouble,
    lasts: Nanos,
    switch: Option<f64>,
    equation: paper::Equation,
) -> Option<Figure> {
    let is_one = trouble == Trouble::BeforeStart;
    let is_struck = move |discharge| if is_one { discharge == 2 } else { discharge % 3 == 2 };
    let around = |pins| Disturbed::new(pins, trouble, lasts, is_struck);
    let mut by_hand = ByHand::with(board, R_OHM, 1, around);
    by_hand.offset = STAMP;
    if trouble == Trouble::BeforeStart {
        // Our discharge would refuse it, unless it is planned to be so long.
        by_hand.pause = by_hand.pause + lasts;
    }
    let cycles = by_hand.cycles(200, switch);
    (cycles.len() > 100)
        .then(|| mean_of(&cycles.iter().map(|times| equation(&board.parts, times)).collect::<Vec<_>>()))
}

/// What a prediction leaves out: calls and clock readings take a microsecond, of a discharge of some hundreds.
const CALLS: f64 = 0.01;

/// What a method of ours says, where the mean of undisturbed readings is off by `bias`.
fn of_ours(it: &mut Scenario, method: Method, errors: &Errors, bias: f64, most_missing: f64) {
    let (wrong, missing) = (wrong_beside(errors, bias), without_number(errors));
    let figure = format!("{:.1} % wrong, {:.0} % no number", 100.0 * wrong, 100.0 * missing);
    it.cell(method, figure, wrong == 0.0 && missing < most_missing, true);
}

/// What each method of ours says.
fn ours(it: &mut Scenario, board: &Board, trouble: Trouble, lasts: Nanos) {
    for method in Method::ALL {
        let undisturbed = struck(board, method, trouble, Nanos::ZERO).mean();
        of_ours(it, method, &struck(board, method, trouble, lasts), undisturbed, 0.2);
    }
}

/// What those of ours say that switch, where a switch is struck.
fn ours_that_switch(it: &mut Scenario, board: &Board, trouble: Trouble, most_missing: f64) {
    for method in [Method::Qerm, Method::Cerm, Method::Tracked] {
        let board = if method == Method::Cerm { board.with("t-l = \"1 s\"") } else { board.clone() };
        of_ours(it, method, &struck(&board, method, trouble, PREEMPTED), 0.0, most_missing);
    }
}

const HOLDS_IF: &str = "no number is wrong, fewer than 20 % of readings have none";

fn scenario(title: &'static str) -> Scenario {
    Scenario::new(title, HOLDS_IF, "0..20")
}

/// A published method that is off by so many ohms.
fn published(it: &mut Scenario, method: Method, found: Figure, predicted: f64) {
    it.expect(
        format!("{} as printed: error, ohm", method.as_str()),
        found,
        predicted,
        (CALLS * predicted).abs(),
    );
    let figure = format!("{} off", percent(found.value / R_OHM));
    it.published(method, figure, found.within(0.01 * R_OHM), false);
}

/// The published methods without a switch, each with a prediction.
fn of_one_resistor(predicted: [f64; 2]) -> [(Method, paper::Equation, f64); 2] {
    [(Method::Tpcm, paper::tpcm, predicted[0]), (Method::Tcdic, paper::tcdic, predicted[1])]
}

/// The published methods that start late: R_x is too high by as much as passes.
fn published_start(it: &mut Scenario, board: &Board, trouble: Trouble, predicted: [f64; 2]) {
    for (method, equation, predicted) in of_one_resistor(predicted) {
        let undisturbed = by_hand(board, trouble, Nanos::ZERO, None, equation).unwrap();
        let found = by_hand(board, trouble, PREEMPTED, None, equation).unwrap().less(undisturbed);
        published(it, method, found, predicted);
    }
}

/// The published CERM whose switch, planned after so many seconds, is struck; its equation believes in `believed`.
fn published_switch(it: &mut Scenario, board: &Board, trouble: Trouble, switch: f64, believed: f64) {
    let full = Times::of(&board.parts, R_OHM, 0.0);
    let predicted = paper::cerm(&board.parts, &Times { switch: believed, ..full }) - R_OHM;
    let found = by_hand(board, trouble, PREEMPTED, Some(switch), paper::cerm).unwrap().less(TRUTH);
    published(it, Method::Cerm, found, predicted);
}

pub fn at_the_start() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let mut it =
        scenario("Preempted for 50 ms between the clock reading and the move of the line that starts");
    let [g_a, g_b] = board.parts.g();
    published_start(&mut it, &board, Trouble::AtStart, [50e-3 / g_a, 100e-3 / (g_a + g_b)]);
    ours(&mut it, &board, Trouble::AtStart, PREEMPTED);
    it.why = "the start is counted 50 ms too early. A call that takes so much longer than others is no start: `wide-bracket`, and the \
              discharge is taken again."
        .to_owned();
    it
}

/// Out of node A, ampere: a tenth of what a pin may have.
const LEAKAGE: f64 = 1e-6;

pub fn before_the_start() -> Scenario {
    let mut board = Board::quiet(Parts::PI4);
    board.scene.circuit.node_a.leakage = Some(Ampere(LEAKAGE));
    let parts = board.parts;
    let mut it = scenario("Preempted for 50 ms between charge and start, 1 uA of leakage at node A");
    // The charge that leaks away would have run through R_x: it takes the time that Q / (V / R) takes on the way.
    let c_t = parts.c_a * parts.c_b / (parts.c_a + parts.c_b);
    let v = paper::V_DD - LEAKAGE * 50e-3 / c_t;
    let theta = c_t * (paper::V_DD / v).ln();
    let [g_a, g_b] = parts.g();
    let predicted = [-theta / g_a, -2.0 * theta / (g_a + g_b)].map(|share| share * (R_OHM + R_O));
    published_start(&mut it, &board, Trouble::BeforeStart, predicted);
    ours(&mut it, &board, Trouble::BeforeStart, PREEMPTED);
    it.why = "1 uA takes 96 mV off node A in 50 ms. A discharge that starts so long after its charge is no discharge: `wide-bracket`, \
              and it is taken again."
        .to_owned();
    it
}

pub fn before_the_switch() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let mut it = scenario("Preempted for 50 ms before a planned switch");
    let switch = 0.9 * board.parts.g()[0] * (R_OHM + R_O);
    // B has crossed long before: T_c2,x is negative.
    published_switch(&mut it, &board, Trouble::BeforeSwitch, switch, switch + 50e-3);
    ours_that_switch(&mut it, &board, Trouble::BeforeSwitch, 0.01);
    it.why = "B crosses before the switch, and eq. (16) does not know that. It is a discharge in full then, with the equations of one."
        .to_owned();
    it
}

pub fn within_the_switch() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let mut it = scenario("Preempted for 50 ms between the clock reading and the release of the sensor");
    let switch = 0.5 * board.parts.g()[0] * (R_OHM + R_O);
    published_switch(&mut it, &board, Trouble::AtSwitch, switch, switch);
    ours_that_switch(&mut it, &board, Trouble::AtSwitch, 0.2);
    it.why = "the sensor is believed released while the discharge goes on through it. `wide-bracket`, as at the start.".to_owned();
    it
}

pub fn while_it_waits() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let parts = board.parts;
    let mut it = scenario("Preempted for 50 ms while it waits for an edge");
    // A program that reads the clock when it has been woken.
    let predicted = [50e-3 / parts.g()[0], 50e-3 / parts.g_single()];
    it.published(
        Method::Tpcm,
        format!("clock read by the program, {} off", percent(predicted[0] / R_OHM)),
        predicted[0] < 0.01 * R_OHM,
        false,
    );
    ours(&mut it, &board, Trouble::Waiting, PREEMPTED);
    it.why =
        "the kernel stamps edges in the interrupt; when the program reads them does not matter.".to_owned();
    it
}

pub fn wall_clock() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let parts = board.parts;
    let mut it = scenario("The wall clock is set forward by 1 s during a discharge");
    let second = Nanos(1_000_000_000);
    let [g_a, g_b] = parts.g();
    for (method, equation, predicted) in of_one_resistor([1.0 / g_a, 2.0 / (g_a + g_b)]) {
        let found = by_hand(&board, Trouble::WallClock, second, None, equation).unwrap().less(TRUTH);
        let what = format!("{} by the wall clock: error, ohm", method.as_str());
        it.expect(what, found, predicted, CALLS * predicted);
        let figure = format!("stamps of the wall clock, {:.1} Mohm off", 1e-6 * found.value);
        it.published(method, figure, found.within(0.01 * R_OHM), false);
    }
    for method in Method::ALL {
        // `CLOCK_MONOTONIC` is not set.
        of_ours(&mut it, method, &struck(&board, method, Trouble::WallClock, Nanos::ZERO), 0.0, 0.01);
    }
    let two_nodes = struck(&board, Method::Tcdic, Trouble::WallClock, second);
    it.require("tcdic of ours by the wall clock: no wrong numbers", wrong(&two_nodes) == 0.0);
    let single = struck_on(MANY, &board, Method::Tpcm, Trouble::WallClock, second);
    it.require("tpcm of ours by the wall clock: no wrong numbers", wrong(&single) == 0.0);
    expect_struck(&mut it, &single);
    it.why = "edges, switches and waits are all counted by CLOCK_MONOTONIC, which nobody sets. (Kernels before 5.7 with uAPI v1 stamp \
              edges by the wall clock: there, A and B contradict each other, and the reading is a `latency-outlier`; with one node it is \
              `moving` or `unsettled`, far from the reading before it.)"
        .to_owned();
    it
}

const TEN_SECONDS: Nanos = Nanos(10_000_000_000);

pub fn suspended() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let parts = board.parts;
    let mut it = scenario("Suspended for 10 s in the middle of a discharge");
    let [g_a, g_b] = parts.g();
    // Both edges are stamped at the resume, 0.3 ms after the call of the start, and no later, as others are.
    let shown = 2.0 * HALF_CALL + 0.3e-3 - STAMP;
    let predicted = [shown / g_a, 2.0 * shown / (g_a + g_b)].map(|all_ohm| all_ohm - R_O - R_OHM);
    for (method, equation, predicted) in of_one_resistor(predicted) {
        let found = by_hand(&board, Trouble::Suspended, TEN_SECONDS, None, equation).unwrap().less(TRUTH);
        published(&mut it, method, found, predicted);
    }
    ours(&mut it, &board, Trouble::Suspended, TEN_SECONDS);
    let single = struck_on(MANY, &board, Method::Tpcm, Trouble::Suspended, TEN_SECONDS);
    expect_struck(&mut it, &single);
    it.why = "CLOCK_MONOTONIC stands still while the capacitors go on: every edge is stamped when the system resumes. A and B, at the \
              same instant, contradict each other. With one node a reading of the moment of the suspend is far from that before it, and \
              `moving` or `unsettled`; the next one is back, and at rest."
        .to_owned();
    it
}

pub fn suspended_for_hours() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let mut it = Scenario::new(
        "Suspended for hours, in which the capacitors grow by 3 %",
        "fewer than 5 wrong numbers",
        "0..20",
    );
    for method in Method::ALL {
        // In the middle of the readings, at some point of a cycle.
        let around = |pins, seed| {
            let is_struck = move |discharge| discharge == 600 + seed;
            let pins = Disturbed::new(pins, Trouble::SuspendedBetween, TEN_SECONDS, is_struck);
            pins.growing(1.03)
        };
        let errors = board.errors_with(method, R_OHM, 20, 500, around);
        let count = wrong(&errors) * (errors.count() + errors.not_ok.len()) as f64 / 20.0;
        let figure =
            format!("{count:.1} wrong numbers, {:.1} without one", errors.not_ok.len() as f64 / 20.0);
        it.cell(method, figure, count < 5.0, true);
    }
    it.why = "a calibration of each reading is as old as its cycle. The tracked one does not know how long the system slept: its next \
              calibration discharges, and the readings that they make doubtful, are beyond their gates, and after three of them it \
              begins anew."
        .to_owned();
    it
}

#[test]
fn the_scene_has_no_leakage_of_its_own() {
    assert_eq!(Scene::builtin("pi4").unwrap().circuit.node_a.leakage, None);
}
