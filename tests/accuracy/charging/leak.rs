//! What a leak at B does, where B has its charger for a part of each charge only.

use super::circuit::{ideal, nominal, two};
use cermd::circuit::{Chargers, Node};
use cermd::instrument::discharge::{Charge, Plan, run};
use cermd::pins::Drives;
use cermd::pins::sim::{Kind, Scene, SimPins};
use cermd::record::{Record, Through};
use cermd::units::Nanos;

const C_A: f64 = 2.2e-6;
const C_B: f64 = 680e-9;
const V_TH: f64 = 1.1;
/// Discharges until B is where it stays.
const UNTIL_STEADY: usize = 40;

fn board() -> cermd::circuit::Circuit {
    nominal(two(C_A, C_B), V_TH)
}

/// The last two of many discharges through Rc2 with such charges.
fn steady(leak_ohm: f64, charge: Charge) -> [Record; 2] {
    let scene = Scene::builtin("ideal").unwrap().with_kind(Kind::TwoCapacitor).unwrap();
    let mut pins = SimPins::new(&scene, None);
    pins.alter(|circuit| {
        circuit.sense = [ideal(V_TH); 2];
        circuit.sense[1].to_ground = 1.0 / leak_ohm;
    });
    let plan = Plan::full(Through::C2, Node::B, charge, Nanos(50_000_000));
    let mut take = || run(&mut pins, plan).unwrap().result.unwrap();
    (0..UNTIL_STEADY).for_each(|_| assert!(take().b_ns.is_some()));
    [take(), take()]
}

/// The charge that a B has lost after one charge of all chargers for so long, of one that it had lost before it; and what is
/// beside V_DD at A and at B then, in volts for a coulomb of the latter.
fn after_together(together: f64) -> (f64, [f64; 2]) {
    let mut circuit = Scene::builtin("ideal").unwrap().network();
    circuit.network = two(C_A, C_B);
    let lost = C_A + C_B;
    let full = circuit.v_dd;
    let [a, b] = circuit.flow([full, full - 1.0], Drives::CHARGE).after(together).map(|v| full - v);
    ((C_B * b + C_A * (b - a)) / lost, [a / lost, b / lost])
}

/// By how much, relative, the leak moves B's crossing more than with complete charges through all chargers: found, and predicted.
pub fn shift(leak_ohm: f64, charge: Charge) -> [f64; 2] {
    let circuit = board();
    let whole = Charge::together(Nanos::from_seconds(12.0 * circuit.charge_tau(Chargers::All).0));
    let [before, last] = steady(leak_ohm, charge);
    let crossing = |leak_ohm, charge| steady(leak_ohm, charge)[1].b_ns.unwrap();
    let beyond = |leak_ohm| crossing(leak_ohm, charge) / crossing(leak_ohm, whole);
    // What such a charge remembers is the same with and without.
    let found = beyond(leak_ohm) - beyond(f64::INFINITY);

    let (v_dd, k, c_t) = (circuit.v_dd.0, C_A / (C_A + C_B), circuit.c_total().0);
    let e = circuit.left_at_crossing(Node::B).unwrap();
    let ohm = circuit.r_c2.0 + circuit.r_o.0;
    let together = charge.together.as_seconds();
    // B falls by k times what A does, and comes back with it.
    let discharge = last.b_ns.unwrap() * 1e-9;
    let period = (last.start - before.start).as_seconds();
    let on_the_way = v_dd * (1.0 - k) * discharge + v_dd * k * ohm * c_t * (1.0 - e);
    let volt_seconds =
        on_the_way + v_dd * (period - discharge) - (v_dd - V_TH) * circuit.charge_tau(Chargers::OfA).0;
    // What goes in the last part of the charge is the same with all chargers, and little.
    let lost = (volt_seconds - v_dd * together) / leak_ohm;
    let (kept, beside) = after_together(together);
    let [a, b] = beside.map(|volt| v_dd - volt * lost / (1.0 - kept));
    let crossing = |a: f64, b: f64| -c_t * (1.0 - (b - V_TH) / (k * a)).ln();
    [found, crossing(a, b) / crossing(v_dd, v_dd) - 1.0]
}

/// What B keeps of what is missing, in one charge.
pub fn kept(charge: Charge) -> f64 {
    after_together(charge.together.as_seconds()).0
}
