//! The closed form against the simulated network, which knows neither progress nor modes; and discharges that end early.

use cermd::circuit::{Chargers, Circuit, NOMINAL_R_CHARGE, Network, Node};
use cermd::instrument::discharge::{Charge, Plan, run};
use cermd::pins::Drives;
use cermd::pins::sim::{Kind, Scene, Sensor, SimPins, network};
use cermd::record::{Record, Through};
use cermd::units::{Farad, Nanos, Ohm, Volt};

const BOTH: [(f64, f64, f64); 4] =
    [(2.2e-6, 680e-9, 1.1), (10e-6, 680e-9, 1.3), (330e-9, 22e-9, 1.441), (1e-6, 600e-9, 1.6)];

/// A node with one threshold and nothing else.
pub fn ideal(v_th: f64) -> network::Sense {
    network::Sense { falling: v_th, rising: v_th, ..Default::default() }
}

pub fn two(c_a: f64, c_b: f64) -> Network {
    Network::TwoCapacitor { c_a: Farad(c_a), c_b: Farad(c_b) }
}

pub fn nominal(network: Network, v_th: f64) -> Circuit {
    let (r_c1, r_c2) = (Ohm(470.0), Ohm(12_700.0));
    let (v_dd, r_charge, r_o) = (Volt(3.3), NOMINAL_R_CHARGE, Ohm(40.0));
    Circuit { network, r_c1, r_c2, v_dd, v_th: Volt(v_th), r_charge, r_o }
}

/// The crossing of a node through Rc2 after a charge of so many seconds from a depth, s.
fn crossing(circuit: &network::SimCircuit, chargers: Chargers, node: Node, depth: f64, seconds: f64) -> f64 {
    let k = match circuit.network {
        Network::TwoCapacitor { c_a, c_b } => c_a.0 / (c_a.0 + c_b.0),
        _ => 0.0,
    };
    let start = [1.0 - depth, 1.0 - k * depth].map(|share| share * circuit.v_dd);
    let on = if chargers == Chargers::OfA { Drives::CHARGE_A } else { Drives::CHARGE };
    let charged = circuit.flow(start, on).after(seconds);
    let falls = circuit.flow(charged, Drives::C2).waveform(node);
    falls.falls_after(0.0, circuit.sense[node.index()].falling, f64::INFINITY).unwrap()
}

#[test]
fn what_a_charge_remembers_is_what_the_network_does() {
    let two = BOTH.map(|(c_a, c_b, v_th)| (two(c_a, c_b), v_th));
    let boards = two.into_iter().chain([(Network::OneCapacitor { c: Farad(470e-9) }, 1.1)]);
    for (wiring, v_th) in boards {
        let nominal = nominal(wiring, v_th);
        let mut circuit = Scene::builtin("ideal").unwrap().network();
        circuit.network = wiring;
        circuit.sense = [ideal(v_th); 2];
        let nodes = if circuit.has_b() { &Node::BOTH[..] } else { &[Node::A] };
        for (node, chargers) in
            nodes.iter().flat_map(|node| [Chargers::OfA, Chargers::All].map(|chargers| (*node, chargers)))
        {
            for (taus, tolerance) in [(4.0, 0.05), (7.0, 0.005), (10.0, 0.001)] {
                let seconds = taus * nominal.charge_tau(chargers).0;
                let [shallow, deep] =
                    [0.8, 1.0].map(|depth| crossing(&circuit, chargers, node, depth, seconds));
                let predicted = 0.2 * nominal.charge_memory(node, chargers).unwrap() * (-taus).exp();
                let full = nominal.crossing(node, nominal.r_c2).unwrap().0;
                let found = (deep - shallow) / full;
                assert!(
                    (found / predicted - 1.0).abs() < tolerance,
                    "{wiring:?} {chargers:?} {node:?} {taus} tau: {found:e}, predicted {predicted:e}"
                );
            }
        }
    }
}

/// Node B's crossing through Rc2 after a discharge that timed out, against that after another through Rc2.
#[test]
fn a_discharge_that_timed_out_is_drained_before_the_charge() {
    let scene = Scene::builtin("ideal").unwrap().with_kind(Kind::TwoCapacitor).unwrap();
    let scene = scene.with_sensors(vec![Sensor::Constant(Ohm(10e6))]).unwrap();
    let mut pins = SimPins::new(&scene, Some(crate::common::seed::seed(1)));
    let nominal = nominal(two(2.2e-6, 680e-9), 1.3);
    let taus = 6.0;
    let charge = Nanos::from_seconds(taus * nominal.charge_tau(Chargers::All).0);
    let mut take = |through, drain_s: f64| -> Record {
        let plan = Plan {
            drain: Nanos::from_seconds(drain_s),
            settle: Nanos(20_000),
            ..Plan::full(through, Node::B, Charge::together(charge), Nanos(50_000_000))
        };
        run(&mut pins, plan).unwrap().result.unwrap()
    };
    // The first one has found the capacitors empty.
    (0..3).for_each(|_| assert!(take(Through::C2, 0.0).b_ns.is_some()));
    let usual = take(Through::C2, 0.0).b_ns.unwrap();
    let mut after_none = |drain_s: f64| {
        assert!(take(Through::X(0), 0.0).b_ns.is_none());
        let found = take(Through::C2, drain_s).b_ns.unwrap();
        take(Through::C2, 0.0);
        (found - usual) / usual
    };
    // The open discharge has taken 50 ms / 10 Mohm of progress from full capacitors.
    let depth = 1.0 - (-0.05 / (10e6 + 40.0) / nominal.c_total().0).exp();
    let left = nominal.left_at_crossing(Node::B).unwrap();
    let predicted = |depth: f64| {
        nominal.charge_memory(Node::B, Chargers::All).unwrap() * (depth - (1.0 - left)) * (-taus).exp()
    };
    let (undrained, drained) =
        (after_none(0.0), after_none(1.2 * nominal.crossing(Node::B, nominal.r_c1).unwrap().0));
    println!("relative change of B: {undrained:e} undrained, {drained:e} drained");
    assert!(
        (undrained / predicted(depth) - 1.0).abs() < 0.02,
        "{undrained:e}, predicted {:e}",
        predicted(depth)
    );
    // Within the depths from which charges are planned for: those of discharges that have come to their end, left to 0.
    let within = predicted(1.0 - (1.0 - depth) * left.powf(1.2));
    assert!(
        (drained / within - 1.0).abs() < 0.02 && drained < predicted(1.0),
        "{drained:e}, predicted {within:e}"
    );
}
