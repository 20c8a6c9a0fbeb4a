use super::network::tests::{Charge, exact_discharge};
use super::*;
use crate::chance::{Figure, mean_of, sd_of, share_is};
use crate::circuit::Node;
use crate::seed::seed;
use crate::units::{Ohm, Seconds};

mod effects;

const MS: i64 = 1_000_000;

fn ideal() -> SimPins {
    SimPins::new(&Scene::builtin("ideal").unwrap(), None)
}

/// Charges, arms and discharges through `on`; the edges that come within 100 ms.
fn discharge(pins: &mut SimPins, on: Drives) -> (Bracket, Vec<Edge>) {
    pins.drive(Drives::CHARGE).unwrap();
    let charged = pins.now() + Nanos(20 * MS);
    pins.sleep_until(charged).unwrap();
    pins.drive(Drives::NONE).unwrap();
    let armed = pins.arm().unwrap();
    assert_eq!(armed.levels, Levels { a: true, b: true });
    let start = pins.drive(on).unwrap();
    let until = pins.now() + Nanos(100 * MS);
    let mut edges = Vec::new();
    while edges.len() < 2 {
        match pins.edge(until).unwrap() {
            Some(edge) => edges.push(edge),
            None => break,
        }
    }
    pins.drive(Drives::NONE).unwrap();
    assert_eq!(pins.conflicts(), 0);
    (start, edges)
}

#[test]
fn every_built_in_scene_runs() {
    for name in Scene::builtin_names() {
        let mut pins = SimPins::new(&Scene::builtin(name).unwrap(), None);
        let (start, edges) = discharge(&mut pins, Drives::C1);
        assert_eq!(edges.iter().map(|edge| edge.node).collect::<Vec<_>>(), Node::BOTH, "{name}");
        assert!(edges[0].at > start.before && edges[1].at > edges[0].at, "{name}");
    }
}

#[test]
fn ideal_stamps_are_the_exact_times_in_whole_nanoseconds() {
    let mut pins = ideal();
    pins.connect(0, Sensor::Constant(Ohm(1234.5)));
    let (start, edges) = discharge(&mut pins, Drives::x(0));
    let exact = exact_discharge(pins.circuit(), Charge::For(20e-3), Drives::x(0), None);
    for (edge, exact) in edges.iter().zip([exact.a.unwrap(), exact.b.unwrap()]) {
        let measured = (edge.at - start.after).as_ns();
        assert!((measured - exact * 1e9).abs() <= 0.5, "{measured} ns, exact {exact} s");
        let truth = pins.truth().crossing_ns(edge.node).unwrap();
        assert!((truth - exact * 1e9).abs() < 1e-4, "{truth} ns, exact {exact} s");
    }
    assert_eq!(start.width(), Nanos::ZERO);
}

/// The ideal scene with more effects, written as at the end of its file.
fn with(effects: &str) -> Scene {
    let text = include_str!("../../../hw/scenes/ideal.toml");
    Scene::parse(&format!("{text}\n{effects}"), std::path::Path::new("test")).unwrap()
}

/// Lateness of the stamps of many discharges, ns after the true crossing of that node; truth counts from the first
/// change of lines, whose instant is exact as long as calls cost nothing.
fn lateness(scene: &Scene, node: Node, on: Drives, discharges: usize) -> Vec<f64> {
    let mut pins = SimPins::new(scene, Some(seed(42)));
    (0..discharges)
        .map(|_| {
            let (start, edges) = discharge(&mut pins, on);
            let edge = edges.iter().find(|edge| edge.node == node).unwrap();
            (edge.at - start.before).as_ns() - pins.truth().crossing_ns(node).unwrap()
        })
        .collect()
}

fn assert_normal(values: &[f64], mean: f64, sigma: f64) {
    let (found_mean, found_sigma) = (mean_of(values), sd_of(values));
    // Stamps are whole ns.
    assert!(found_mean.is(mean, 0.0), "mean {found_mean}, wanted {mean}");
    assert!(found_sigma.is(sigma, 0.1), "sigma {found_sigma}, wanted {sigma}");
}

#[test]
fn stamps_are_late_by_mean_and_jitter() {
    let scene = with("[stamps]\nmean = \"8 us\"\njitter = \"1.5 us\"");
    assert_normal(&lateness(&scene, Node::A, Drives::C1, 4000), 8000.0, 1500.0);
    assert_normal(&lateness(&scene, Node::B, Drives::C1, 4000), 8000.0, 1500.0);
}

#[test]
fn a_stamp_is_never_before_its_crossing() {
    let scene = with("[stamps]\nmean = \"1 us\"\njitter = \"3 us\"");
    assert!(lateness(&scene, Node::A, Drives::C1, 2000).iter().all(|late| *late > -0.51));
}

#[test]
fn the_tail_of_lateness_is_as_frequent_and_as_long_as_named() {
    let scene = with("[stamps]\nmean = \"1 us\"\ntail-probability = 0.1\ntail-mean = \"50 us\"");
    let late = lateness(&scene, Node::A, Drives::C1, 10_000);
    let tail: Vec<f64> = late.iter().map(|late| late - 1000.0).filter(|late| *late > 1.0).collect();
    assert!(share_is(tail.len(), late.len(), 0.1), "{}", tail.len());
    let mean = mean_of(&tail);
    // What is below 1 ns does not count as tail.
    assert!(mean.is(50_000.0, 1.0), "{mean}");
}

/// Eq. (7): dt = voltage / |dV/dt|, at the crossing of A |dV/dt| = V_Th / ((R + Ro) C_T).
#[test]
fn trigger_noise_is_eq_7() {
    let scene = with("[noise]\nvoltage = \"1 mV\"");
    let c_t = 2.2e-6 * 680e-9 / 2.88e-6;
    for (on, r) in [(Drives::C1, 510.0), (Drives::C2, 12_740.0)] {
        assert_normal(&lateness(&scene, Node::A, on, 4000), 0.0, 1e9 * 1e-3 * r * c_t / 1.3);
    }
}

#[test]
fn wide_band_noise_crosses_early_and_more_so_at_high_r() {
    let mut scene = with("[noise]\nvoltage = \"1 mV\"\nbandwidth = \"10 MHz\"");
    // High enough for many samples in that unit.
    scene.circuit.r_c1 = Ohm(2320.0);
    let c_t = 2.2e-6 * 680e-9 / 2.88e-6;
    // In units of voltage / slope, of which there are samples every 50 ns.
    let earliness = |on, r: f64| {
        let unit_ns = 1e9 * 1e-3 * r * c_t / 1.3;
        mean_of(&lateness(&scene, Node::A, on, 1000)).times(-1.0 / unit_ns)
    };
    let (low, high) = (earliness(Drives::C1, 2360.0), earliness(Drives::C2, 12_740.0));
    let beyond = |figure: Figure, least: f64| figure.value - figure.margin > least;
    assert!(beyond(low, 1.0), "{low}");
    assert!(beyond(high.less(low), 0.3), "{high} against {low}");
}

#[test]
fn calls_take_overhead_and_slots_and_move_lines_in_the_middle() {
    let scene = with("[calls]\nfixed = \"600 ns\"\nper-line = \"500 ns\"");
    let mut pins = SimPins::new(&scene, None);
    let charging = pins.drive(Drives::CHARGE).unwrap();
    assert_eq!(charging.width(), Nanos(1600));
    pins.drive(Drives::NONE).unwrap();
    pins.arm().unwrap();
    pins.drive(Drives::C1).unwrap();
    let switch = pins.drive(Drives::C2).unwrap();
    assert_eq!(switch.width(), Nanos(1600));
    // C1 drove 550 ns into a call of 1100 ns; the switch releases it 550 ns into the next and drives C2 500 ns later.
    let changes = pins.truth().changes();
    assert_eq!(changes, [(0.0, Drives::C1), (1100.0, Drives::NONE), (1600.0, Drives::C2)]);
    assert_eq!(pins.drive(Drives::C2).unwrap().width(), Nanos(600));
}

#[test]
fn a_chip_that_was_left_alone_moves_its_lines_late_unless_levels_are_read_before() {
    let timing = "fixed = \"600 ns\"\nper-line = \"500 ns\"\nasleep-after = \"10 us\"\nwakes-in = \"2 us\"";
    let scene = with(&format!("[calls]\n{timing}"));
    let released_ns = |rest_ns, reads: bool| {
        let mut pins = SimPins::new(&scene, None);
        pins.arm().unwrap();
        let start = pins.drive(Drives::C1).unwrap();
        pins.sleep_until(start.before + Nanos(rest_ns)).unwrap();
        if reads {
            pins.levels().unwrap();
        }
        let release = pins.drive(Drives::NONE).unwrap();
        assert_eq!(release.width(), Nanos(1100), "the write is posted");
        pins.sleep_until(release.after + Nanos(5000)).unwrap();
        pins.truth().changes()[1].0 - release.before.as_ns() + start.before.as_ns()
    };
    assert_eq!([released_ns(10_000, false), released_ns(11_000, false)], [0.0, 2000.0]);
    assert_eq!(released_ns(11_000, true), 0.0);
}

#[test]
fn calls_jitter_within_their_sigma_and_are_preempted() {
    let scene = with("[calls]\nfixed = \"10 us\"\nper-line = \"0 s\"\njitter = 0.05");
    let mut pins = SimPins::new(&scene, Some(seed(1)));
    let widths: Vec<f64> = (0..4000).map(|_| pins.drive(Drives::NONE).unwrap().width().as_ns()).collect();
    assert_normal(&widths, 10_000.0, 500.0);
    let scene =
        with("[calls]\nfixed = \"1 us\"\nper-line = \"0 s\"\ntail-probability = 0.5\ntail-mean = \"1 ms\"");
    let mut pins = SimPins::new(&scene, Some(seed(1)));
    let long = (0..1000).filter(|_| pins.drive(Drives::NONE).unwrap().width() > Nanos(1001)).count();
    assert!(share_is(long, 1000, 0.5), "{long}");
}

#[test]
fn edges_wake_late_and_sleeps_end_late() {
    let scene = with("[wake]\nmean = \"50 us\"\n[sleep]\nmean = \"3 us\"");
    let mut pins = SimPins::new(&scene, None);
    pins.sleep_until(Nanos(1000)).unwrap();
    assert_eq!(pins.now(), Nanos(4000));
    let (_, edges) = discharge(&mut pins, Drives::C1);
    assert_eq!(pins.now(), edges[1].at + Nanos(50_000));
}

#[test]
fn reads_cost_what_the_scene_says() {
    let mut pins = SimPins::new(&with("[reads]\nclock = \"50 ns\"\nlevels = \"1 us\"\narm = \"2 us\""), None);
    assert_eq!(pins.now(), Nanos(0));
    pins.levels().unwrap();
    pins.arm().unwrap();
    assert_eq!(pins.now(), Nanos(3050));
    assert_eq!(pins.drive(Drives::NONE).unwrap().width(), Nanos(50));
}

#[test]
fn the_same_seed_gives_the_same_stamps() {
    let scene = Scene::builtin("pi4").unwrap();
    let stamps = |seed| {
        let mut pins = SimPins::new(&scene, seed);
        let discharges = [Drives::C1, Drives::C2, Drives::x(0)];
        discharges.map(|on| discharge(&mut pins, on).1.iter().map(|edge| edge.at.0).collect::<Vec<_>>())
    };
    assert_eq!(stamps(None), stamps(Some(scene.seed)));
    assert_ne!(stamps(None), stamps(Some(scene.seed + 1)));
    insta::assert_debug_snapshot!(stamps(None));
}

#[test]
fn a_full_buffer_drops_the_oldest_and_shows_a_gap_of_the_line() {
    let mut pins = SimPins::new(&with("[events]\nbuffer = 1"), None);
    pins.drive(Drives::CHARGE).unwrap();
    pins.sleep_until(Nanos(20 * MS)).unwrap();
    pins.drive(Drives::NONE).unwrap();
    pins.arm().unwrap();
    pins.drive(Drives::C1).unwrap();
    pins.sleep_until(Nanos(40 * MS)).unwrap();
    let edge = pins.edge(Nanos(40 * MS)).unwrap().unwrap();
    assert_eq!((edge.node, edge.seqno, edge.line_seqno), (Node::B, 2, 1));
    assert_eq!(pins.edge(Nanos(41 * MS)).unwrap(), None);
    assert_eq!(pins.arm().unwrap().line_seqno, [1, 1]);
}

#[test]
fn a_coalesced_edge_is_late_and_shows_a_gap_of_the_request_only() {
    let (_, edges) = discharge(
        &mut SimPins::new(&with("[events]\ncoalesced = 1.0\nbounce = \"20 us\""), None),
        Drives::C1,
    );
    let (_, punctual) = discharge(&mut ideal(), Drives::C1);
    assert_eq!(edges.iter().map(|edge| edge.seqno).collect::<Vec<_>>(), [2, 4]);
    assert_eq!(edges.iter().map(|edge| edge.line_seqno).collect::<Vec<_>>(), [1, 1]);
    assert!(edges[0].at > punctual[0].at);
}

#[test]
fn a_lost_edge_leaves_no_trace_but_the_level() {
    let mut pins = SimPins::new(&with("[events]\nlost = 1.0"), None);
    let (_, edges) = discharge(&mut pins, Drives::C1);
    assert!(edges.is_empty());
    assert_eq!(pins.levels().unwrap(), Levels { a: false, b: false });
    assert_eq!(pins.arm().unwrap().seqno, 0);
}

#[test]
fn edges_come_only_once_armed_and_arming_forgets_them() {
    let mut pins = ideal();
    pins.drive(Drives::CHARGE).unwrap();
    pins.sleep_until(Nanos(20 * MS)).unwrap();
    pins.drive(Drives::NONE).unwrap();
    pins.drive(Drives::C1).unwrap();
    assert_eq!(pins.edge(Nanos(40 * MS)).unwrap(), None);
    pins.drive(Drives::NONE).unwrap();
    assert_eq!(pins.arm().unwrap().levels, Levels { a: false, b: false });
    let (_, edges) = discharge(&mut pins, Drives::C1);
    assert_eq!(edges.len(), 2);
}

#[test]
fn a_conflict_is_refused_and_counted() {
    let mut pins = ideal();
    pins.drive(Drives::CHARGE_A).unwrap();
    let both = Drives::CHARGE_A.and(Drives::C2);
    assert!(matches!(pins.drive(both), Err(PinsError::Conflict(on)) if on == both));
    assert_eq!(pins.driving(), Drives::CHARGE_A);
    assert_eq!(pins.conflicts(), 1);
    // Charger to sink directly: released before driven.
    pins.drive(Drives::C2).unwrap();
    assert_eq!(pins.conflicts(), 1);
}

#[test]
fn paced_stamps_are_the_virtual_ones_after_the_epoch() {
    let scene = Scene::builtin("pi4").unwrap();
    let epoch = Nanos(81_234_567_890);
    let started = Instant::now();
    let mut paced = SimPins::new(&scene, None).paced(epoch);
    let (start, edges) = discharge(&mut paced, Drives::C1);
    let passed = started.elapsed();
    let (virtual_start, virtual_edges) = discharge(&mut SimPins::new(&scene, None), Drives::C1);
    assert_eq!(start.before, virtual_start.before + epoch);
    for (edge, virtual_edge) in edges.iter().zip(&virtual_edges) {
        assert_eq!(edge.at, virtual_edge.at + epoch);
    }
    assert!(passed.as_nanos() as i64 >= (edges[1].at - epoch).0, "the wall clock is never behind");
}

#[test]
fn a_common_clock_quantises_everything() {
    let mut pins = SimPins::new(&Scene::builtin("fpga-paper").unwrap(), None);
    pins.sleep_until(Nanos(7)).unwrap();
    let (start, edges) = discharge(&mut pins, Drives::C1);
    assert_eq!(start.width(), Nanos::ZERO);
    for at in edges.iter().map(|edge| edge.at).chain([start.before]) {
        assert_eq!(at.0 % 20, 0);
    }
    // T_L of the paper, 616 cycles at 681 ohm, within the trigger noise of a cycle and rounding up.
    pins.connect(0, Sensor::Constant(Ohm(681.0)));
    let (start, edges) = discharge(&mut pins, Drives::x(0));
    let cycles = (edges[0].at - start.after).0 / 20;
    assert!((615..=618).contains(&cycles), "{cycles}");
}

#[test]
fn a_node_becomes_high_only_above_its_rising_threshold() {
    let mut pins = SimPins::new(&Scene::builtin("pi4").unwrap(), None);
    let mut low_between = 0;
    pins.drive(Drives::CHARGE).unwrap();
    loop {
        let levels = pins.levels().unwrap();
        let [v_a, _] = pins.analog.voltages(pins.now_ns);
        assert_eq!(levels.a, v_a >= 1.3, "{v_a} V");
        if levels.a {
            break;
        }
        low_between += i32::from(v_a > 1.1);
        let next = pins.now() + Nanos(500);
        pins.sleep_until(next).unwrap();
    }
    assert!(low_between > 0);
}

/// A ramp cut into 50 us is the ramp: progress is the integral of dt / (R + Ro), a logarithm.
#[test]
fn a_ramp_is_integrated() {
    let scene = with("").with_sensors(vec![Sensor::Ramp {
        from: Ohm(1000.0),
        to: Ohm(101_000.0),
        start: Seconds(0.0),
        duration: Seconds(1.0),
    }]);
    let mut pins = SimPins::new(&scene.unwrap(), None);
    let (start, edges) = discharge(&mut pins, Drives::x(0));
    let g_a = 2.2e-6 * 680e-9 / 2.88e-6 * (3.3f64 / 1.3).ln();
    let at_start = 1040.0 + 1e5 * start.before.as_seconds();
    let exact = at_start * (1e5 * g_a).exp_m1() / 1e5;
    let measured = (edges[0].at - start.before).as_seconds();
    assert!((measured / exact - 1.0).abs() < 1e-4, "{measured} s, exact {exact} s");
    assert!((pins.r_x(0, start.before).unwrap() + 40.0 - at_start).abs() < 1e-6);
}

#[test]
fn one_scene_serves_every_kind_of_circuit() {
    for kind in [Kind::OneCapacitor, Kind::SeriesCalibration] {
        let scene = Scene::builtin("ideal").unwrap().with_kind(kind).unwrap();
        let mut pins = SimPins::new(&scene, None);
        let (start, edges) = discharge(&mut pins, Drives::C2);
        let r = if kind == Kind::OneCapacitor { 12_740.0 } else { 13_210.0 };
        let exact = r * 470e-9 * (3.3f64 / 1.3).ln() * 1e9;
        assert_eq!(edges.len(), 1);
        assert!(((edges[0].at - start.before).as_ns() - exact).abs() < 0.51);
    }
}

/// The paper's largest error of TPCM: 13.1 ohm at 16.2 kohm in 500 cycles of c1, c2, x. The noise of the scene was
/// fitted to it through eq. (7), and rounded to 0.01 mV; here the whole simulation gives it back.
#[test]
fn the_noise_of_the_fpga_is_that_of_the_paper() {
    let scene = Scene::builtin("fpga-paper").unwrap().with_kind(Kind::OneCapacitor).unwrap();
    let mut pins = SimPins::new(&scene, Some(seed(1)));
    pins.connect(0, Sensor::Constant(Ohm(16_200.0)));
    pins.arm().unwrap();
    let mut time = |on| {
        let charged = pins.drive(Drives::CHARGE).unwrap().after + Nanos(163_840);
        pins.sleep_until(charged).unwrap();
        let start = pins.drive(on).unwrap().after;
        (pins.edge(Nanos::MAX).unwrap().unwrap().at - start).as_ns()
    };
    let mut largest_error = || {
        let errors = (0..500).map(|_| {
            let [c1, c2, x] = [Drives::C1, Drives::C2, Drives::x(0)].map(&mut time);
            ((x - c1) / (c2 - c1) * (12_700.0 - 2320.0) + 2320.0 - 16_200.0).abs()
        });
        errors.fold(0.0, f64::max)
    };
    let mean = mean_of(&(0..40).map(|_| largest_error()).collect::<Vec<_>>());
    assert!(mean.is(13.1, 13.1 * 0.005 / 0.22), "{mean} ohm");
}
