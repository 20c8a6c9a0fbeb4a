use super::*;
use crate::pins::Node;
use quantity::Ohm;

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
