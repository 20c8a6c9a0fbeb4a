//! The latency offset: what it does when it is left in, and that split calibration finds it.
//!
//! Whole instruments in virtual time; every seed is fixed.

use crate::common::chance::{WITHIN_2U, mean_of, sd_of, share_is, share_is_in};
use crate::common::config::config;
use crate::common::{Bench, Errors, file_for, read, settle};
use cermd::circuit::Node;
use cermd::instrument::Message;
use cermd::pins::sim::{Kind, Scene, Sensor};
use cermd::reading::Method;
use cermd::units::Ohm;
use std::path::Path;

/// Lateness of every stamp, ns.
const D_NS: f64 = 8000.0;

/// 10 uF and 0.68 uF at 1.3 V, a computer that does nothing wrong but stamp each edge 8 us late, with this `jitter`; CERM
/// that finishes every discharge through Rc2; `measure` adds lines to its `[measure]`.
fn late_stamps(r_ohm: f64, jitter: &str, measure: &str, seed: u64) -> Bench {
    let scene = config(|c| {
        c.set("circuit.c-a", "10 uF").set("circuit.r-p", "180 ohm").set("circuit.r-o", "40 ohm");
        c.set("circuit.v-dd", "3.3 V").lines("circuit", "threshold = { falling = \"1.3 V\" }");
        c.set("stamps.mean", "8 us").set("stamps.jitter", jitter)
    });
    let scene = Scene::parse(&scene.to_string(), Path::new("late-stamps")).unwrap();
    let mut config = file_for(Kind::TwoCapacitor, Method::Cerm, "c-a = \"10 uF\"", "late-stamps");
    config.set("measure.t-l", "1 s").lines("measure", measure);
    Bench { scene: scene.with_sensors(vec![Sensor::Constant(Ohm(r_ohm))]).unwrap(), config, seed }
}

/// -2 d/(g_A + g_B) (Rc2 - Rx)/(Rc2 + Ro), ohm: both nodes' crossings through Rc2 are d too late in eq. (16) and (18),
/// and so in proportion are the inferred ones; with Rx = Rc2 it cancels against eq. (11)'s own.
fn bias_ohm(r_x: f64) -> f64 {
    let (c_a, c_b, v_dd, v_th) = (10e-6, 0.68e-6, 3.3, 1.3);
    let c_t: f64 = c_a * c_b / (c_a + c_b);
    let g_a = c_t * f64::ln(v_dd / v_th);
    let g_b = c_t * f64::ln(v_dd * c_a / (v_th * (c_a + c_b) - v_dd * c_b));
    -2.0 * D_NS * 1e-9 / (g_a + g_b) * (12_700.0 - r_x) / (12_700.0 + 40.0)
}

fn errors(bench: &Bench, r_ohm: f64, count: usize) -> Errors {
    let mut errors = Errors::default();
    let mut instrument = bench.instrument();
    settle(&mut instrument);
    // The first discharges are full ones, until the noise is known and a switch can be planned.
    read(&mut instrument, 20, |_| {});
    read(&mut instrument, count, |reading| errors.add(reading, r_ohm));
    assert_eq!(errors.inferred, errors.count());
    // The gate of 5 sigma, a sigma that is learned, closes for about one reading in 10 000.
    assert!(
        share_is_in(count - errors.count(), count, 0.0..=1e-4),
        "seed {}: {:?}",
        bench.seed,
        errors.not_ok
    );
    errors
}

#[test]
fn without_correction_the_bias_is_the_predicted_one() {
    for r_ohm in [100.0, 1000.0, 4000.0, 12_700.0, 16_200.0] {
        let found = errors(&late_stamps(r_ohm, "0 us", "offset = \"0 us\"", 1), r_ohm, 10);
        let (bias, predicted) = (found.mean(), bias_ohm(r_ohm));
        // Stamps are whole ns: six times off by half a ns, each of 1 ns / (g_A + g_B) = 0.8 mohm or a few of that.
        let tolerance = 0.01 * predicted.abs() + 0.01;
        assert!((bias - predicted).abs() < tolerance, "{r_ohm} ohm: {bias} instead of {predicted}");
    }
}

/// 40 instruments that each find an offset of their own. The switch comes where A crosses, now before it and now after.
#[test]
fn with_auto_the_bias_vanishes_within_its_uncertainty() {
    for r_ohm in [100.0, 1000.0, 4000.0] {
        let mut means = Vec::new();
        for seed in 0..40 {
            let found = errors(
                &late_stamps(r_ohm, "1.5 us", "offset = \"auto\"\nswitch-fraction = 1.0", seed),
                r_ohm,
                100,
            );
            means.push(found.mean());
        }
        let (bias, predicted) = (mean_of(&means), bias_ohm(r_ohm));
        println!("{r_ohm} ohm: bias {bias:.3} ohm, {predicted:.3} without correction");
        assert!(bias.u < 0.05 * predicted.abs(), "{r_ohm} ohm: {bias} shows nothing");
        assert!(bias.is(0.0, 0.0), "{r_ohm} ohm: {bias}, seeds 0..40");
    }
}

const INSTRUMENTS: u64 = 400;

/// (found - true) / u of many instruments, which is to be normal with mean 0 and standard deviation 1.
fn check_pulls(what: &str, pulls: &[f64]) {
    let (mean, sd) = (mean_of(pulls), sd_of(pulls));
    let within = pulls.iter().filter(|pull| pull.abs() <= 2.0).count();
    let row = format!("{what}: pulls {mean:.3}, sd {sd:.3}, {within} of {} within 2 u", pulls.len());
    println!("{row}");
    let sound = mean.is(0.0, 0.0) && sd.is(1.0, 0.0) && share_is(within, pulls.len(), WITHIN_2U);
    assert!(sound, "{row}, seeds 0..{INSTRUMENTS}");
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The true d is how much later than the voltage A's crossing is recorded, relative to when the line that started the
/// discharge really moved. Its median over all discharges leaves preempted calls and stretched stamps out, which `auto`
/// does too.
fn check_offset(scene: &str, r_o_ohm: f64) {
    let mut found = Vec::new();
    let mut lateness = Vec::new();
    for seed in 0..INSTRUMENTS {
        let mut instrument =
            Bench::with_kind(scene, Kind::TwoCapacitor, Method::Cerm, 1000.0, seed, "").instrument();
        while !instrument.stats().offset_is_known {
            let mut a_ns = None;
            let mut take = |message| {
                if let Message::Discharge { record, .. } = message {
                    a_ns = record.a_ns;
                }
            };
            instrument.step(&mut take).unwrap();
            let true_ns = instrument.pins().truth().crossing_ns(Node::A);
            lateness.extend(a_ns.zip(true_ns).map(|(a_ns, true_ns)| a_ns - true_ns));
        }
        found.push(instrument.stats().offset);
    }
    let d_ns = median(lateness);
    let of_d: Vec<f64> = found.iter().map(|offset| (offset.d_ns - d_ns) / offset.u_d_ns).collect();
    let of_r_o: Vec<f64> =
        found.iter().filter_map(|offset| offset.r_o_ohm).map(|(r_o, u)| (r_o - r_o_ohm) / u).collect();
    println!("{scene}: d {d_ns:.0} ns, found with u {:.0} ns", found[0].u_d_ns);
    assert_eq!(of_r_o.len(), of_d.len());
    check_pulls(&format!("{scene}: d"), &of_d);
    check_pulls(&format!("{scene}: Ro"), &of_r_o);
}

#[test]
fn auto_finds_offset_and_pin_resistance_of_a_board_within_their_uncertainties() {
    for scene in ["pi-zero", "pi4", "pi5"] {
        check_offset(scene, 40.0);
    }
}
