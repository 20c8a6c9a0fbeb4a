//! The law against its definitions: the voltages at the predicted times, and the differential equations.

use super::*;
use proptest::prelude::*;

fn circuit(network: Network) -> Circuit {
    Circuit {
        network,
        r_c1: Ohm(2_320.0),
        r_c2: Ohm(12_700.0),
        v_dd: NOMINAL_V_DD,
        v_th: NOMINAL_V_TH,
        r_charge: NOMINAL_R_CHARGE,
        r_o: NOMINAL_R_O,
    }
}

fn two(c_a: f64, c_b: f64) -> Circuit {
    circuit(Network::TwoCapacitor { c_a: Farad(c_a), c_b: Farad(c_b) })
}

/// The classical fourth-order step of y' = f(y).
fn rk4(f: impl Fn([f64; 2]) -> [f64; 2], y: [f64; 2], h: f64) -> [f64; 2] {
    let along = |k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    let k1 = f(y);
    let k2 = f(along(k1, h / 2.0));
    let k3 = f(along(k2, h / 2.0));
    let k4 = f(along(k3, h));
    let slope = |i: usize| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
    along([slope(0), slope(1)], h)
}

/// A step far below the fastest time constant of the network, seconds.
fn step(r: f64, c_a: f64, c_b: f64) -> f64 {
    0.02 * r * c_a.min(c_b) / 2.0
}

/// Random circuits whose B crossing exists with a margin: (c_a, c_b, v_dd, v_th, r).
fn valid() -> impl Strategy<Value = (Circuit, Ohm)> {
    (-8.0..-4.0f64, 0.01..0.95f64, 1.5..5.5f64, 0.2..0.8f64, 1.0..6.0f64, 0.0..100.0f64).prop_map(
        |(c_a, share, v_dd, threshold, r, r_o)| {
            let c_a = 10f64.powf(c_a);
            let v_th = v_dd * threshold;
            let c_b = share * c_a * v_th / (v_dd - v_th);
            let circuit = Circuit { v_dd: Volt(v_dd), v_th: Volt(v_th), r_o: Ohm(r_o), ..two(c_a, c_b) };
            (circuit, Ohm(10f64.powf(r)))
        },
    )
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    /// Eq. (10) solves eq. (9), eq. (2) solves eq. (6): at the predicted progress the voltage is V_Th.
    #[test]
    fn nodes_are_at_the_threshold_when_they_cross((circuit, _) in valid()) {
        for node in Node::BOTH {
            let volt = circuit.voltage(node, circuit.g(node).unwrap()).unwrap();
            prop_assert!((volt.0 / circuit.v_th.0 - 1.0).abs() < 1e-12, "{:?} at {}", node, volt);
        }
        let one = Circuit { network: Network::OneCapacitor { c: circuit.c_total() }, ..circuit };
        prop_assert_eq!(one.g(Node::A), circuit.g(Node::A));
        prop_assert_eq!(one.voltage(Node::A, Farad(1e-7)), circuit.voltage(Node::A, Farad(1e-7)));
        prop_assert_eq!((one.g(Node::B), one.voltage(Node::B, Farad(0.0))), (None, None));
    }

    #[test]
    fn a_crosses_before_b((circuit, r) in valid()) {
        prop_assert!(circuit.crossing(Node::A, r) < circuit.crossing(Node::B, r));
    }

    #[test]
    fn resistance_inverts_crossing((circuit, r) in valid()) {
        for node in Node::BOTH {
            let back = circuit.resistance(node, circuit.crossing(node, r).unwrap()).unwrap();
            prop_assert!((back.0 - r.0).abs() < 1e-12 * (r.0 + circuit.r_o.0));
        }
    }
}

/// Eq. (2) as the paper writes it, with numbers worked by hand.
#[test]
fn eq_2() {
    let circuit = circuit(Network::OneCapacitor { c: Farad(20e-9) });
    let expected = (2_320.0 + 40.0) * 20e-9 * (3.3f64 / 1.3).ln();
    assert_eq!(circuit.crossing(Node::A, circuit.r_c1), Some(Seconds(expected)));
    assert!((expected - 43.97e-6).abs() < 0.01e-6);
}

/// Eq. (9) against the network: C_A from A to B, C_B from B to ground, R + Ro from A to ground.
#[test]
fn eq_9_solves_the_discharge() {
    for (c_a, c_b) in [(2.2e-6, 680e-9), (330e-9, 22e-9), (1e-6, 600e-9)] {
        let circuit = two(c_a, c_b);
        let r = 2_360.0;
        let network = |[a, _]: [f64; 2]| {
            let b_falls = -a / (r * c_b);
            [b_falls - a / (r * c_a), b_falls]
        };
        let (mut volts, h) = ([3.3, 3.3], step(r, c_a, c_b));
        for i in 1..=400 {
            volts = rk4(network, volts, h);
            let theta = Farad(f64::from(i) * h / r);
            for node in Node::BOTH {
                let expected = circuit.voltage(node, theta).unwrap().0;
                assert!((volts[node.index()] - expected).abs() < 1e-7, "{node:?} at step {i}");
            }
        }
        assert!(volts[0] < 1.3, "the discharge has passed the threshold");
    }
}

/// The charge through both chargers, from the worst states that a discharge can leave.
#[test]
fn a_charge_forgets_as_fast_as_its_slowest_part() {
    for (c_a, c_b) in [(2.2e-6, 680e-9), (1e-6, 600e-9), (100e-9, 1e-6)] {
        let circuit = two(c_a, c_b);
        let r = circuit.r_charge.0;
        let network = |[a, b]: [f64; 2]| {
            let b_rises = -(a + b) / (r * c_b);
            [b_rises - a / (r * c_a), b_rises]
        };
        for start in [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0]] {
            let run = |time: f64| {
                let steps = (time / step(r, c_a, c_b)).ceil();
                (0..steps as usize).fold(start, |y, _| rk4(network, y, time / steps))
            };
            // The matrix being symmetric, the length of (a, b) shrinks at least as fast as its slowest part.
            let end = run(14.0 * circuit.charge_tau(Chargers::All).0);
            let most = start[0].hypot(start[1]) * (-14f64).exp();
            assert!(end[0].hypot(end[1]) <= most * 1.001, "{start:?} leaves {end:?}");
            // Late in the charge only the slowest part is left: it falls by e in one tau.
            let tau = circuit.charge_tau(Chargers::All).0;
            let (before, after) = (run(9.0 * tau), run(10.0 * tau));
            assert!((before[0] / after[0] - 1f64.exp()).abs() < 1e-3, "{} {}", before[0], after[0]);
        }
    }
}

#[test]
fn charge_constants() {
    let tau = two(10e-6, 1e-9).charge_tau(Chargers::All).0;
    assert!((tau / (2.0 * 220.0 * 10e-6) - 1.0).abs() < 1e-4, "2 (Rp+Ro) C_A where C_A >> C_B");
    let one = circuit(Network::OneCapacitor { c: Farad(1e-6) });
    assert_eq!(one.charge_tau(Chargers::All), Seconds(220.0 * 1e-6));
}

#[test]
fn b_exists_below_its_limit_only() {
    let limit = 2.2e-6 * 1.3 / (3.3 - 1.3);
    let (below, above) = (two(2.2e-6, limit * (1.0 - 1e-9)), two(2.2e-6, limit * (1.0 + 1e-9)));
    assert!(below.g(Node::B).unwrap().0 > 10.0 * below.g(Node::A).unwrap().0, "B is late near its limit");
    assert_eq!(above.g(Node::B), None);
}

#[test]
fn b_follows_a_where_c_a_is_large() {
    let circuit = two(1.0, 1e-6);
    let (a, b) = (circuit.g(Node::A).unwrap().0, circuit.g(Node::B).unwrap().0);
    assert!((b / a - 1.0).abs() < 1e-5);
    assert!((a / (1e-6 * (3.3f64 / 1.3).ln()) - 1.0).abs() < 1e-5);
}

#[test]
fn a_threshold_at_the_supply_is_never_crossed() {
    let high = Circuit { v_th: Volt(3.3), ..two(2.2e-6, 680e-9) };
    assert_eq!((high.g(Node::A), high.g(Node::B)), (None, None));
}

#[test]
fn resistors_in_series_add_up() {
    let series = circuit(Network::SeriesCalibration { c: Farad(1e-6) });
    assert_eq!(series.r_second(), Ohm(2_320.0 + 12_700.0));
}
