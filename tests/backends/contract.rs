//! The contract of `Pins`, on the simulated circuit. `examples/contract.rs` holds real kernels to the same one.

use crate::clauses::{Bench, check};
use cermd::pins::sim::{Kind, Scene, SimPins};
use cermd::units::Nanos;

const MS: i64 = 1_000_000;

fn holds(name: &str, scene: &Scene, node_b: bool) {
    let bench = Bench { charge: Nanos(20 * MS), discharge: Nanos(100 * MS), node_b };
    let mut pins = SimPins::new(scene, None);
    for (clause, outcome) in check(&mut pins, &bench) {
        assert_eq!(outcome, Ok(()), "{name}: {clause}");
    }
    assert!(pins.driving().is_none(), "{name}");
}

#[test]
fn every_simulated_board_keeps_the_contract() {
    for name in Scene::builtin_names() {
        holds(name, &Scene::builtin(name).unwrap(), true);
    }
}

#[test]
fn a_circuit_without_node_b_keeps_the_contract() {
    holds("ideal", &Scene::builtin("ideal").unwrap().with_kind(Kind::OneCapacitor).unwrap(), false);
}
