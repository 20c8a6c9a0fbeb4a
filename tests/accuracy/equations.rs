//! The paper's equations on uncertainty, against the spread of simulated discharges.
//!
//! Discharges of the `fpga-paper` board; "without clock" and "without noise" switch one of its two sources of error off.
//! Every bound is the standard error of a standard deviation from so many discharges, as often as chance allows.

use crate::common::chance::{sd_of, sigmas};
use crate::common::seed;
use cermd::circuit::Node;
use cermd::estimate::method::{Switched, Times, cerm, tcdic, tpcm};
use cermd::instrument::discharge::{Charge, Plan, run};
use cermd::pins::sim::{Scene, Sensor, SimPins};
use cermd::record::{Record, Through};
use cermd::sensor::{Force, Law};
use cermd::units::{Farad, Nanos, Ohm};
use proptest::prelude::*;
use rand::RngExt;

const DISCHARGES: usize = 4000;
const SEED: u64 = 1;
const CLOCK_NS: f64 = 20.0;
/// V_DD, V_Th, noise voltage (V) and Ro (ohm) of the board.
const V_DD: f64 = 3.3;
const V_TH: f64 = 1.441;
const VOLTAGE: f64 = 0.22e-3;
const R_O: f64 = 40.0;
const R_C1: f64 = 2320.0;
const R_C2: f64 = 12_700.0;

fn board() -> Scene {
    Scene::builtin("fpga-paper").unwrap()
}

fn without_clock() -> Scene {
    Scene { clock_period: None, ..board() }
}

/// The board's own C_B, and one for which C_A >> C_B holds.
const C_B: [f64; 2] = [22e-9, 1e-9];

fn with_c_b(mut scene: Scene, c_b: f64) -> Scene {
    scene.circuit.c_b = Some(Farad(c_b));
    scene
}

/// One discharge, with a switch to Rc2 after so many ns.
fn discharge(pins: &mut SimPins, through: Through, switch_ns: Option<f64>) -> Record {
    let plan = Plan {
        switch: switch_ns.map(|ns| (Nanos(ns as i64), Through::C2)),
        ..Plan::full(through, Node::B, Charge::together(Nanos(163_840)), Nanos(100_000_000))
    };
    run(pins, plan).unwrap().result.unwrap()
}

/// How far chance takes the standard deviation of so many normal values; a ratio of two, sqrt(2) times as far.
fn of_sd() -> f64 {
    sigmas() / (2.0 * DISCHARGES as f64).sqrt()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn sd(values: &[f64]) -> f64 {
    sd_of(values).value
}

#[track_caller]
fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found:e} instead of {expected:e}");
}

#[test]
fn quantisation_is_uniform_over_a_cycle_whatever_the_time_eq_4_and_5() {
    for low in [100.0, 400.0, 900.0] {
        let mut pins = SimPins::new(&Scene { noise: None, ..board() }, Some(seed::seed(SEED)));
        let mut rng = seed::rng(SEED);
        let lateness: Vec<f64> = (0..DISCHARGES)
            .map(|_| {
                pins.connect(0, Sensor::Constant(Ohm(low + 100.0 * rng.random::<f64>())));
                let record = discharge(&mut pins, Through::X(0), None);
                record.a_ns.unwrap() - pins.truth().crossing_ns(Node::A).unwrap()
            })
            .collect();
        // The spread of a uniform distribution is known better than that of a normal one: by 0.63.
        assert_near("u_q(T)", sd(&lateness), CLOCK_NS / 12f64.sqrt(), 0.63 * of_sd());
        // Crossings count from the next edge of the clock: d is half a cycle.
        assert!((mean(&lateness) - CLOCK_NS / 2.0).abs() < sigmas() * 5.77 / (DISCHARGES as f64).sqrt());
    }
}

#[test]
fn trigger_noise_is_proportional_to_the_resistance_eq_7_and_8() {
    let c_t = 330e-9 * 22e-9 / 352e-9;
    let mut pins = SimPins::new(&without_clock(), Some(seed::seed(SEED)));
    for r_x in [1000.0, R_C1, 5000.0, R_C2, 100e3] {
        pins.connect(0, Sensor::Constant(Ohm(r_x)));
        let times: Vec<f64> =
            (0..DISCHARGES).map(|_| discharge(&mut pins, Through::X(0), None).a_ns.unwrap()).collect();
        // Stamps are whole ns.
        let of_eq_7 = (VOLTAGE * (r_x + R_O) * c_t / V_TH * 1e9).hypot(1.0 / 12f64.sqrt());
        assert_near("u_trigger(T)", sd(&times), of_eq_7, of_sd());
        if r_x >= R_C1 {
            let of_eq_8 = VOLTAGE / (V_TH * (V_DD / V_TH).ln());
            assert_near("u_trigger(T)/T", sd(&times) / mean(&times), of_eq_8, of_sd());
        }
    }
}

/// Many cycles, the x discharge in full or switched at a fraction of T_xA.
fn cycles(scene: &Scene, r_x: f64, fraction: Option<f64>) -> Vec<Times<f64>> {
    let mut pins = SimPins::new(scene, Some(seed::seed(SEED)));
    pins.connect(0, Sensor::Constant(Ohm(r_x)));
    discharge(&mut pins, Through::X(0), None);
    let t_xa = pins.truth().crossing_ns(Node::A).unwrap();
    let both = |record: &Record| [Some(record.a_ns.unwrap()), Some(record.b_ns.unwrap())];
    (0..DISCHARGES)
        .map(|_| {
            let c1 = both(&discharge(&mut pins, Through::C1, None));
            let c2 = both(&discharge(&mut pins, Through::C2, None));
            let x = discharge(&mut pins, Through::X(0), fraction.map(|fraction| fraction * t_xa));
            let switch = x.switch.map(|switch| Switched { at: switch.at_ns, on: switch.on_ns });
            Times { c1, c2, x: both(&x), switch, beside: None, d: 0.0 }
        })
        .collect()
}

/// Relative standard deviation of something in all cycles.
fn relative(cycles: &[Times<f64>], of: impl Fn(&Times<f64>) -> f64) -> f64 {
    let values: Vec<f64> = cycles.iter().map(of).collect();
    sd(&values) / mean(&values)
}

/// u(T_B)/u(T_A) and T_B/T_A of a circuit, by eq. (9) and (10).
fn b_over_a(c_b: f64) -> (f64, f64) {
    let (c_a, v_b_at_a) = (330e-9, (V_TH * (330e-9 + c_b) - V_DD * c_b) / 330e-9);
    // V_B moves by C_A/(C_A + C_B) of V_A's slope, which is in proportion to V_A.
    let slope = v_b_at_a * c_a / (c_a + c_b);
    (V_TH / slope, (V_DD / v_b_at_a).ln() / (V_DD / V_TH).ln())
}

/// Where C_A >> C_B, eq. (12) and (24) hold as they stand. With the paper's own capacitors node B, whose voltage falls more
/// slowly, makes both 3 % worse.
#[test]
fn two_nodes_are_better_than_one_by_the_root_of_two_eq_12_and_24() {
    for (c_b, paper_is_off_by) in C_B.into_iter().zip([0.06, 0.01]) {
        let (u_b, t_b) = b_over_a(c_b);
        let exact = 1f64.hypot(u_b) / (1.0 + t_b);
        assert!((exact * 2f64.sqrt() - 1.0).abs() < paper_is_off_by, "{exact}");
        for r_x in [5000.0, 10_000.0, 16_200.0] {
            let cycles = cycles(&with_c_b(without_clock(), c_b), r_x, None);
            let u = |ratio: fn(&Times<f64>) -> Option<f64>| {
                sd(&cycles.iter().map(|times| ratio(times).unwrap()).collect::<Vec<_>>())
            };
            let gain = u(tcdic::ratio) / u(|times| tpcm::ratio(times, Node::A));
            assert_near("(12) u_TCDIC / u_TPCM", gain, exact, 1.5 * of_sd());
            let sum = relative(&cycles, |times| times.c1[0].unwrap() + times.c1[1].unwrap());
            let single = relative(&cycles, |times| times.c1[0].unwrap());
            assert_near("(24) of T_c1A + T_c1B", sum / single, exact, 1.5 * of_sd());
        }
    }
}

/// What (20), (22) and the sum of both give with D = T_c2B - T_c2,x and the uncertainties of A and B each their own, in
/// units of u(T_c2A)/T_c2A.
struct Inferred {
    a: f64,
    b: f64,
    sum: f64,
}

fn propagated(c_b: f64, fraction: f64) -> Inferred {
    let (u_b, t_b) = b_over_a(c_b);
    // Rc2 would have run through D for as long as it takes to the switch: that part of T_c2A.
    let d = fraction;
    let of = |c2a: f64, c2b: f64| (c2a * c2a + u_b * u_b * ((c2b - 1.0 / d).powi(2) + 1.0 / (d * d))).sqrt();
    Inferred { a: of(1.0, 0.0), b: of(0.0, 1.0 / t_b), sum: of(1.0 / (1.0 + t_b), 1.0 / (1.0 + t_b)) }
}

fn check_inferred(c_b: f64, r_x: f64, fraction: f64) {
    let cycles = cycles(&with_c_b(without_clock(), c_b), r_x, Some(fraction));
    let unit = relative(&cycles, |times| times.c2[0].unwrap());
    let expected = propagated(c_b, fraction);
    let found =
        |of: fn([f64; 2]) -> f64| relative(&cycles, |times| of(cerm::inferred(times).unwrap())) / unit;
    let what = format!("{r_x} ohm, switched at {fraction}");
    assert_near(&format!("(20) T_i,xA, {what}"), found(|[a, _]| a), expected.a, 1.5 * of_sd());
    assert_near(&format!("(22) T_i,xB, {what}"), found(|[_, b]| b), expected.b, 1.5 * of_sd());
    assert_near(&format!("(25) their sum, {what}"), found(|[a, b]| a + b), expected.sum, 1.5 * of_sd());
}

/// (21) and (23) as they stand, sqrt(3) and 1, where C_A >> C_B; with the paper's own capacitors 1.93 and 1.17.
///
/// (25) leaves out that both inferred times come from one T_c2,x and one T_c2B: sqrt(3/2), not 1, is right.
#[test]
fn inferred_times_have_constant_relative_uncertainty_eq_21_23_and_25() {
    let limit = propagated(C_B[1], 1.0);
    assert_near("(21)", limit.a, 3f64.sqrt(), 0.01);
    assert_near("(23)", limit.b, 1.0, 0.01);
    assert_near("(25), with the covariance", limit.sum, 1.5f64.sqrt(), 0.01);
    let own = propagated(C_B[0], 1.0);
    assert_eq!(format!("{:.2} {:.2} {:.2}", own.a, own.b, own.sum), "1.93 1.17 1.40");
    for c_b in C_B {
        for r_x in [100.0, 681.0, 2000.0, 10_000.0] {
            check_inferred(c_b, r_x, 1.0);
        }
    }
}

/// (21) and (23) break down when the switch comes before A's crossing, so that T_c2,x grows: as when it comes at a fixed
/// T_L while R_x rises. At A's crossing T_c2B - T_c2,x is T_c2A whatever R_x, and nothing rises.
#[test]
fn inferred_times_get_worse_the_earlier_the_switch() {
    for c_b in C_B {
        for fraction in [0.5, 0.25, 0.1] {
            check_inferred(c_b, 2000.0, fraction);
        }
        let early = propagated(c_b, 0.25);
        assert!(early.a > 3.0 * 3f64.sqrt() && early.b > 5.0, "{} {}", early.a, early.b);
    }
}

/// Eq. (27), as printed, for the times of A and B in full.
fn force_of_eq_27(times: &Times<f64>, [xa, xb]: [f64; 2], [f_c1, f_c2]: [f64; 2]) -> f64 {
    let sum = |times: [Option<f64>; 2]| times[0].unwrap() + times[1].unwrap();
    let (sum_c1, sum_c2) = (sum(times.c1) - 2.0 * times.d, sum(times.c2) - 2.0 * times.d);
    let x = xa + xb;
    (sum_c2 - sum_c1) / (1.0 / f_c2 * (x - sum_c1) - 1.0 / f_c1 * (x - sum_c2))
}

proptest! {
    #![proptest_config(seed::cases(256))]

    #[test]
    fn force_from_times_is_eq_27(
        r_x in 60.0..20e3f64, alpha in 1e3..1e5f64, d in 0.0..20e3f64, fraction in 0.1..1.0f64
    ) {
        let (g_a, g_b, rest) = (17.1, 18.9, R_C2 + R_O);
        let crossings = |r: f64| [Some((r + R_O) * g_a + d), Some((r + R_O) * g_b + d)];
        let at = fraction * (r_x + R_O) * g_a;
        let switched = at + rest * (g_b - at / (r_x + R_O)) + d;
        let (c1, c2, x) = (crossings(R_C1), crossings(R_C2), crossings(r_x));
        let full = Times { c1, c2, x, switch: None, beside: None, d };
        let split = Times { x: [None, Some(switched)], switch: Some(Switched { at, on: at }), ..full };
        let f_n = [alpha / R_C1, alpha / R_C2];
        let law = Law::Calibrated { fc1_n: f_n[0], fc2_n: f_n[1] };
        let pair = Force { law, u: None, range_n: None, tare_n: None };
        let force = |ratio: f64| {
            pair.shown(R_C1 + ratio * (R_C2 - R_C1), [R_C1, R_C2]).unwrap().value
        };
        let direct = full.x.map(|crossing| crossing.unwrap() - d);
        for (found, printed) in [
            (force(tcdic::ratio(&full).unwrap()), force_of_eq_27(&full, direct, f_n)),
            (force(cerm::ratio(&split).unwrap()), force_of_eq_27(&split, cerm::inferred(&split).unwrap(), f_n)),
        ] {
            prop_assert!((found / printed - 1.0).abs() < 1e-12, "{found} {printed}");
            prop_assert!((found * r_x / alpha - 1.0).abs() < 1e-9, "{found} N at {r_x} ohm");
        }
    }
}
