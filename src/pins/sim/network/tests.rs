use super::*;
use proptest::prelude::*;

mod absorption;

/// How the capacitors were filled before a discharge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Charge {
    /// Until nothing moved any more, with nothing else at the nodes: both nodes at V_DD.
    Full,
    /// From empty, through both chargers, for so many seconds.
    For(f64),
}

/// When the nodes fell through their thresholds, in seconds since the start of the discharge; `None`: never.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Crossings {
    /// Node A.
    pub a: Option<f64>,
    /// Node B.
    pub b: Option<f64>,
}

/// One discharge without clock, latency or rounding: `through` sinks, and from `switch.0` seconds on `switch.1`
/// instead. Node B of a circuit without it never crosses.
pub fn exact_discharge(
    circuit: &SimCircuit,
    charge: Charge,
    through: Drives,
    switch: Option<(f64, Drives)>,
) -> Crossings {
    let start = match charge {
        Charge::Full => [circuit.v_dd; 2],
        Charge::For(seconds) => circuit.flow([0.0, 0.0], Drives::CHARGE).after(seconds),
    };
    let first = circuit.flow(start, through);
    let (until, second) = match switch {
        Some((at, on)) => (at, Some(circuit.flow(first.after(at), on))),
        None => (f64::INFINITY, None),
    };
    let crossing = |node: Node| {
        let threshold = circuit.sense[node.index()].falling;
        if node == Node::B && !circuit.has_b() {
            return None;
        }
        first.waveform(node).falls_after(0.0, threshold, until).or_else(|| {
            let rest = second.as_ref()?.waveform(node).falls_after(0.0, threshold, f64::INFINITY)?;
            Some(until + rest)
        })
    };
    Crossings { a: crossing(Node::A), b: crossing(Node::B) }
}

const X: Drives = Drives::x(0);

/// A node with one threshold and nothing else.
fn ideal(v_th: f64) -> Sense {
    Sense { falling: v_th, rising: v_th, ..Default::default() }
}

fn circuit(network: Network) -> SimCircuit {
    SimCircuit {
        network,
        absorption: Default::default(),
        v_dd: 3.3,
        r_c1: 2320.0,
        r_c2: 12_700.0,
        r_p: 180.0,
        r_o: [40.0; LINES],
        r_x: [1000.0; MAX_CHANNELS],
        sense: [ideal(1.3); 2],
    }
}

fn two(c_a: f64, c_b: f64) -> SimCircuit {
    circuit(Network::TwoCapacitor { c_a: Farad(c_a), c_b: Farad(c_b) })
}

fn assert_close(found: f64, wanted: f64, relative: f64) {
    assert!((found - wanted).abs() <= relative * wanted.abs(), "found {found:e}, wanted {wanted:e}");
}

/// Everything that a scene can name at once, from the numbers of proptest.
#[derive(Debug, Clone)]
struct Anything {
    circuit: SimCircuit,
    start: [f64; 2],
    on: Drives,
}

fn anything() -> impl Strategy<Value = Anything> {
    let farad = || (-9.0..-5.0f64).prop_map(|e| Farad(10f64.powf(e)));
    let ohm = || (1.0..6.0f64).prop_map(|e| 10f64.powf(e));
    let siemens = || prop_oneof![Just(0.0), (-7.0..-3.0f64).prop_map(|e| 10f64.powf(e))];
    let sense = move || {
        (siemens(), siemens(), prop_oneof![Just(0.0), -1e-5..1e-5f64]).prop_map(
            |(to_ground, to_v_dd, leakage)| Sense { falling: 1.1, rising: 1.3, leakage, to_ground, to_v_dd },
        )
    };
    let capacitors = prop_oneof![
        (farad(), farad()).prop_map(|(c_a, c_b)| Network::TwoCapacitor { c_a, c_b }),
        farad().prop_map(|c| Network::OneCapacitor { c }),
        farad().prop_map(|c| Network::SeriesCalibration { c }),
    ];
    let lines = prop::collection::vec(any::<bool>(), 6);
    let state = (0.0..3.3f64, 0.0..3.3f64);
    (capacitors, ohm(), ohm(), ohm(), 1.0..100.0f64, sense(), sense(), lines, state).prop_map(
        |(capacitors, r_c1, r_c2, r_x, r_o, a, b, lines, (v_a, v_b))| {
            let mut circuit = circuit(capacitors);
            (circuit.r_c1, circuit.r_c2, circuit.r_x, circuit.r_o) = (r_c1, r_c2, [r_x; 16], [r_o; LINES]);
            circuit.sense = [a, b];
            let all = [Drives::CHARGE_A, Drives::CHARGE_B, Drives::C1, Drives::C2, X, Drives::x(1)];
            let on = all
                .iter()
                .zip(lines)
                .filter(|(_, on)| *on)
                .fold(Drives::NONE, |set, (line, _)| set.and(*line));
            Anything { circuit, start: [v_a, v_b], on }
        },
    )
}

/// The current that everything but the capacitors pushes into nodes A and B: Ohm's law, resistor by resistor.
fn currents(circuit: &SimCircuit, on: Drives, [v_a, v_b]: [f64; 2]) -> [f64; 2] {
    let mut into = [v_a, v_b];
    for node in Node::BOTH {
        let (sense, v) = (&circuit.sense[node.index()], [v_a, v_b][node.index()]);
        into[node.index()] = (circuit.v_dd - v) * sense.to_v_dd - v * sense.to_ground - sense.leakage;
    }
    let r_o = circuit.r_o[0];
    if on.contains(Drives::CHARGE_A) {
        into[0] += (circuit.v_dd - v_a) / (circuit.r_p + r_o);
    }
    if on.contains(Drives::CHARGE_B) {
        into[1] += (circuit.v_dd - v_b) / (circuit.r_p + r_o);
    }
    for x in [X, Drives::x(1)] {
        if on.contains(x) {
            into[0] -= v_a / (circuit.r_x[0] + r_o);
        }
    }
    let (c1, c2) = (on.contains(Drives::C1), on.contains(Drives::C2));
    if let Network::SeriesCalibration { .. } = circuit.network {
        // The voltage between Rc1 and Rc2 by nodal analysis.
        let (g1, g_near) = (1.0 / circuit.r_c1, if c1 { 1.0 / r_o } else { 0.0 });
        let g_far = if c2 { 1.0 / (circuit.r_c2 + r_o) } else { 0.0 };
        let v_between = v_a * g1 / (g1 + g_near + g_far);
        into[0] -= v_between * (g_near + g_far);
    } else {
        into[0] -= if c1 { v_a / (circuit.r_c1 + r_o) } else { 0.0 };
        into[0] -= if c2 { v_a / (circuit.r_c2 + r_o) } else { 0.0 };
    }
    into
}

/// Charge that has left the nodes, by the capacitors' voltages, between two states.
fn charge_gained(circuit: &SimCircuit, from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    match circuit.network {
        Network::TwoCapacitor { c_a, c_b } => {
            let across_c_a = c_a.0 * ((to[0] - to[1]) - (from[0] - from[1]));
            [across_c_a, c_b.0 * (to[1] - from[1]) - across_c_a]
        }
        Network::OneCapacitor { c } | Network::SeriesCalibration { c } => [c.0 * (to[0] - from[0]), 0.0],
    }
}

/// 1/s, at least 1.
fn fastest(flow: &Flow) -> f64 {
    Node::BOTH
        .iter()
        .flat_map(|node| flow.waveform(*node).modes().next())
        .map(|mode| mode.0)
        .fold(1.0, f64::max)
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    /// Kirchhoff in integral form: the charge that resistors bring is the charge that the capacitors gain. The
    /// integral is by Gauss-Legendre with five points, exact to far below the tolerance over half a time constant.
    #[test]
    fn charge_is_conserved(any in anything(), decades in -3.0..1.5f64) {
        let Anything { circuit, start, on } = any;
        let flow = circuit.flow(start, on);
        let end = 10f64.powf(decades) / fastest(&flow);
        let steps = 100;
        let h = end / f64::from(steps);
        const NODES: [(f64, f64); 5] = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
            (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let (mut brought, mut moved) = ([0.0; 2], 0.0);
        for step in 0..steps {
            for (x, weight) in NODES {
                let t = h * (f64::from(step) + 0.5 + 0.5 * x);
                let current = currents(&circuit, on, flow.after(t));
                for i in 0..2 {
                    brought[i] += 0.5 * h * weight * current[i];
                    moved += 0.5 * h * weight * current[i].abs();
                }
            }
        }
        let gained = charge_gained(&circuit, start, flow.after(end));
        let farad = match circuit.network {
            Network::TwoCapacitor { c_a, c_b } => c_a.0 + c_b.0,
            Network::OneCapacitor { c } | Network::SeriesCalibration { c } => c.0,
        };
        let nodes = if circuit.has_b() { 2 } else { 1 };
        for i in 0..nodes {
            let residual = (brought[i] - gained[i]).abs();
            prop_assert!(residual <= 1e-9 * moved + 1e-14 * farad, "{} of {} C at node {}: brought {:?}, gained {:?}, {:?}", residual, moved, i, brought, gained, flow);
        }
    }

    /// Going on from the middle is going on from the start.
    #[test]
    fn a_stretch_may_be_cut(any in anything(), first in -4.0..1.0f64, second in -4.0..1.0f64) {
        let Anything { circuit, start, on } = any;
        let flow = circuit.flow(start, on);
        let scale = 1.0 / fastest(&flow);
        let (s, t) = (scale * 10f64.powf(first), scale * 10f64.powf(second));
        let at_once = flow.after(s + t);
        let in_two = circuit.flow(flow.after(s), on).after(t);
        for i in 0..2 {
            prop_assert!((at_once[i] - in_two[i]).abs() < 1e-10 * at_once[i].abs().max(1.0));
        }
    }

    /// Wherever a crossing is found the voltage is the threshold, to what f64 can tell.
    #[test]
    fn a_crossing_is_at_the_threshold_and_the_first(any in anything(), threshold in 0.05..3.2f64) {
        let Anything { circuit, start, on } = any;
        let flow = circuit.flow(start, on);
        for node in Node::BOTH {
            let waveform = flow.waveform(node);
            let Some(t) = waveform.falls_after(0.0, threshold, f64::INFINITY) else {
                let seen = (-60..60).map(|e| waveform.at(1.2f64.powi(e) / fastest(&flow)));
                prop_assert!(seen.into_iter().all(|v| v >= threshold - 1e-9));
                continue;
            };
            if t == 0.0 {
                prop_assert!(waveform.start <= threshold);
                continue;
            }
            let rounding = 1e-14 * (1.0 + waveform.modes().map(|(_, slope)| slope.abs() * t).sum::<f64>());
            let error = (waveform.at(t) - threshold).abs();
            prop_assert!(error <= 8.0 * f64::EPSILON * t * waveform.slope(t).abs() + rounding, "{} V at {} s, slope {}, {:?}", error, t, waveform.slope(t), waveform);
            for share in [0.01, 0.3, 0.7, 0.99] {
                prop_assert!(waveform.at(t * share) >= threshold - rounding);
            }
        }
    }

    /// Eq. (2): T = (R + Ro) C ln(V_DD / V_Th), and eq. (6) on the way.
    #[test]
    fn one_capacitor_is_eq_2(r in 10.0..1e6f64, c in 1e-9..1e-5f64, v_th in 0.1..3.2f64, r_o in 1.0..100.0f64) {
        let mut circuit = circuit(Network::OneCapacitor { c: Farad(c) });
        (circuit.r_x[0], circuit.r_o, circuit.sense[0]) = (r, [r_o; LINES], ideal(v_th));
        let found = exact_discharge(&circuit, Charge::Full, X, None);
        let wanted = (r + r_o) * c * (3.3 / v_th).ln();
        assert_close(found.a.unwrap(), wanted, 1e-13);
        prop_assert_eq!(found.b, None);
        let v = circuit.flow([circuit.v_dd; 2], X).after(wanted / 3.0)[0];
        assert_close(v, 3.3 * (-wanted / 3.0 / ((r + r_o) * c)).exp(), 1e-13);
    }

    /// Eq. (9) and (10).
    #[test]
    fn two_capacitors_are_eq_9_and_10(
        r in 10.0..1e6f64, c_a in 1e-8..1e-5f64, ratio in 0.01..10.0f64, v_th in 0.1..3.2f64, r_o in 1.0..100.0f64,
    ) {
        let c_b = c_a * ratio;
        let mut circuit = two(c_a, c_b);
        (circuit.r_x[0], circuit.r_o, circuit.sense) = (r, [r_o; LINES], [ideal(v_th); 2]);
        let c_t = c_a * c_b / (c_a + c_b);
        let found = exact_discharge(&circuit, Charge::Full, X, None);
        assert_close(found.a.unwrap(), (r + r_o) * c_t * (3.3 / v_th).ln(), 1e-12);
        let denominator = v_th * (c_a + c_b) - 3.3 * c_b;
        if denominator > 1e-6 * 3.3 * c_b {
            let wanted = (r + r_o) * c_t * (3.3 * c_a / denominator).ln();
            assert_close(found.b.unwrap(), wanted, 1e-8);
        } else if denominator < 0.0 {
            prop_assert_eq!(found.b, None);
        }
        let t = r * c_t;
        let [v_a, v_b] = circuit.flow([circuit.v_dd; 2], X).after(t);
        assert_close(v_a, 3.3 * (-t / ((r + r_o) * c_t)).exp(), 1e-12);
        assert_close(v_b, (v_a * c_a + 3.3 * c_b) / (c_a + c_b), 1e-12);
    }

    /// Two sinks at once are their parallel resistance, Ro of each included; a switch is two stretches.
    #[test]
    fn sinks_add_and_switches_follow(r in 10.0..1e5f64, share in 0.05..0.95f64) {
        let mut circuit = two(2.2e-6, 680e-9);
        circuit.r_x[0] = r;
        let c_t = 2.2e-6 * 680e-9 / 2.88e-6;
        let g_a = c_t * (3.3f64 / 1.3).ln();
        let both = exact_discharge(&circuit, Charge::Full, X.and(Drives::C2), None).a.unwrap();
        assert_close(both, g_a / (1.0 / (r + 40.0) + 1.0 / 12_740.0), 1e-13);
        let at = share * g_a * (r + 40.0);
        let split = exact_discharge(&circuit, Charge::Full, X, Some((at, Drives::C2))).a.unwrap();
        assert_close(split, at + (g_a - at / (r + 40.0)) * 12_740.0, 1e-12);
    }
}

#[test]
fn series_calibration_goes_through_both_resistors() {
    let circuit = circuit(Network::SeriesCalibration { c: Farad(470e-9) });
    let g = 470e-9 * (3.3f64 / 1.3).ln();
    let time = |on| exact_discharge(&circuit, Charge::Full, on, None).a.unwrap();
    assert_close(time(Drives::C1), g * (2320.0 + 40.0), 1e-13);
    assert_close(time(Drives::C2), g * (2320.0 + 12_700.0 + 40.0), 1e-13);
    let far = 1.0 / (1.0 / 40.0 + 1.0 / 12_740.0);
    assert_close(time(Drives::C1.and(Drives::C2)), g * (2320.0 + far), 1e-13);
    assert_close(time(X.and(Drives::C2)), g / (1.0 / 1040.0 + 1.0 / 15_060.0), 1e-13);
}

#[test]
fn a_short_charge_starts_lower() {
    // While C_B fills, charger A puts charge into C_A, which then lifts A above V_DD: it leaves through both chargers.
    let mut circuit = two(2.2e-6, 680e-9);
    let full = exact_discharge(&circuit, Charge::Full, Drives::C1, None);
    let long = exact_discharge(&circuit, Charge::For(1.0), Drives::C1, None);
    let short = exact_discharge(&circuit, Charge::For(1e-3), Drives::C1, None);
    assert_close(long.a.unwrap(), full.a.unwrap(), 1e-12);
    assert!(circuit.flow([0.0; 2], Drives::CHARGE).after(1e-3)[0] > 3.3);
    assert!(short.a.unwrap() > full.a.unwrap() && short.b.unwrap() < full.b.unwrap());
    // In the one-capacitor circuit the start is known in closed form.
    circuit.network = Network::OneCapacitor { c: Farad(470e-9) };
    let charged = 3.3 * -(-1e-4f64 / (220.0 * 470e-9)).exp_m1();
    let wanted = 2360.0 * 470e-9 * (charged / 1.3).ln();
    assert_close(exact_discharge(&circuit, Charge::For(1e-4), Drives::C1, None).a.unwrap(), wanted, 1e-12);
}

#[test]
fn what_floats_stays_and_what_leaks_falls_linearly() {
    let mut circuit = two(1e-6, 1e-6);
    assert_eq!(circuit.flow([2.0, 1.0], Drives::NONE).after(1e3), [2.0, 1.0]);
    assert_eq!(exact_discharge(&circuit, Charge::Full, Drives::NONE, None), Crossings::default());
    circuit.sense[1].leakage = 1e-6;
    let found = exact_discharge(&circuit, Charge::Full, Drives::NONE, None);
    // C_A floats with node B: 2 V at 1 uA out of 1 uF.
    assert_close(found.a.unwrap(), 2.0, 1e-13);
    assert_close(found.b.unwrap(), 2.0, 1e-13);
}
