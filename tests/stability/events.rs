//! Edges that never arrive.

use crate::common::{Errors, settle};
use crate::paper::{self, Parts, R_O, Times};
use crate::scenario::{Board, ByHand, Scenario, is_true, moments, percent, truth, without_number};
use crate::switching::STAMP;
use cermd::circuit::Node;
use cermd::pins::sim::scene::EventsScene;
use cermd::pins::{Drives, Pins};
use cermd::reading::{Fault, Method};
use cermd::units::Nanos;

pub fn lost_edges() -> Scenario {
    const LOST: f64 = 0.02;
    let mut board = Board::quiet(Parts::PI4);
    board.scene.events = Some(EventsScene { lost: Some(LOST), ..EventsScene::default() });
    let mut it = Scenario::new(
        "2 % of edges lost in hardware (BCM283x), 1 kohm",
        "the numbers are true; no more readings without one than sensor edges are lost",
        "0..20",
    );
    // A program that waits for the edge waits for ever: the chance of that within a hundred cycles.
    for (method, edges) in [(Method::Tpcm, 3), (Method::Tcdic, 6), (Method::Cerm, 6)] {
        let hangs = 1.0 - (1.0 - LOST).powi(100 * edges);
        let mut found = 0;
        for seed in 0..200 {
            let mut by_hand = ByHand::new(&board, 1000.0, seed);
            let nodes = if method == Method::Tpcm { &[Node::A][..] } else { &Node::BOTH };
            // With a probability so close to one, ten cycles say more.
            found += i32::from(!(0..10).all(|_| all_edges_come(&mut by_hand, nodes)));
        }
        let in_ten = 1.0 - (1.0 - LOST).powi(10 * edges);
        it.expect(
            format!(
                "{} as printed: waits for ever within ten cycles, predicted {in_ten:.2}",
                method.as_str()
            ),
            f64::from(found) / 200.0,
            in_ten - 0.14..=(in_ten + 0.14).min(1.0),
        );
        it.cell(
            method,
            format!("as printed: waits for ever within 100 cycles, {:.0} %", 100.0 * hangs),
            hangs < 0.01,
            false,
        );
    }
    for method in Method::ALL {
        let errors = board.errors(method, 1000.0, 20, 200);
        let missing = without_number(&errors);
        // A where it ends the discharge; A and B where both are needed.
        let predicted = match method {
            Method::Tpcm | Method::Qerm | Method::Tracked => LOST,
            Method::Tcdic | Method::Cerm => 1.0 - (1.0 - LOST) * (1.0 - LOST),
        };
        it.expect(
            format!("{}: readings without a number, predicted {predicted:.3}", method.as_str()),
            missing,
            0.5 * predicted..=1.6 * predicted,
        );
        it.cell(method, truth(&errors, 1000.0), is_true(&errors), true);
    }
    it.why = "an edge that is lost leaves no trace. Each wait has an end, and the level then tells a missed edge from a node that is \
              still high; a calibration discharge is taken again, and a switched discharge does without A."
        .to_owned();
    it
}

/// Whether every edge of a cycle comes.
fn all_edges_come(by_hand: &mut ByHand, nodes: &[Node]) -> bool {
    [Drives::C1, Drives::C2, Drives::x(0)].into_iter().all(|on| {
        let until = by_hand.start(on).after + Nanos(60_000_000);
        let mut seen = [false; 2];
        while let Some(edge) = by_hand.pins.edge(until).unwrap() {
            seen[edge.node.index()] = true;
        }
        by_hand.pins.drive(Drives::NONE).unwrap();
        nodes.iter().all(|node| seen[node.index()])
    })
}

pub fn full_buffer() -> Scenario {
    let mut board = Board::quiet(Parts::PI4);
    board.scene.events = Some(EventsScene { buffer: Some(1), ..EventsScene::default() });
    let parts = board.parts;
    let [g_a, g_b] = parts.g();
    // The program takes A's edge when it has been woken; B's pushes it out before that.
    let bound = 53e-6 / (g_b - g_a) - R_O;
    let r_ohm = 0.5 * bound;
    let mut it = Scenario::new(
        "The event buffer overflows: B's edge pushes A's out, 33 ohm",
        "the numbers are true; what is lost is named",
        "0..20",
    );
    assert!((r_ohm - 33.0).abs() < 0.5, "{r_ohm}");
    let mut by_hand = ByHand::new(&board, r_ohm, 1);
    by_hand.offset = STAMP;
    let mut first_stamps = |r_ohm: f64| {
        by_hand.pins.connect(0, cermd::pins::sim::Sensor::Constant(cermd::units::Ohm(r_ohm)));
        (0..200).filter_map(|_| first_edge(&mut by_hand)).collect::<Vec<_>>()
    };
    // What comes first is taken for A.
    let (found, _) = moments(&first_stamps(r_ohm));
    let predicted = g_b * (r_ohm + R_O);
    it.expect("the first edge is B's: its time, of T_xB", found / predicted, 0.97..=1.03);
    let (above, _) = moments(&first_stamps(2.0 * bound));
    it.expect(
        "at four times 33 ohm it is A's: its time, of T_xA",
        above / (g_a * (2.0 * bound + R_O)),
        0.97..=1.03,
    );
    let full = Times::of(&parts, r_ohm, 0.0);
    let off = paper::tpcm(&parts, &Times { x: [found, 0.0], ..full }) - r_ohm;
    it.expect("tpcm as printed: error, predicted (g_B/g_A - 1) (R_x + Ro), ohm", off, {
        let predicted = (g_b / g_a - 1.0) * (r_ohm + R_O);
        0.95 * predicted..=1.05 * predicted
    });
    it.cell(
        Method::Tpcm,
        format!("as printed {} off", percent(off / r_ohm)),
        off.abs() < 0.01 * r_ohm,
        false,
    );
    for method in Method::ALL {
        let mut all = Errors::default();
        let mut named = 0;
        for seed in 0..20 {
            let mut instrument = board.bench(method, r_ohm, seed).instrument();
            settle(&mut instrument);
            crate::common::read(&mut instrument, 60, |_| {});
            let before = instrument.stats().faults;
            crate::common::read(&mut instrument, 100, |reading| all.add(reading, r_ohm));
            let after = instrument.stats().faults;
            let count = |fault: Fault| after[fault as usize] - before[fault as usize];
            named += count(Fault::LostEvent) + count(Fault::CoalescedEdge) + count(Fault::MissedEdge);
        }
        let is_sound = all.count() == 0 || all.coverage() > 0.9;
        let figure = format!("{}, {named} of them named", truth(&all, r_ohm));
        it.cell(method, figure, is_sound && named as usize == all.not_ok.len(), true);
    }
    it.why = format!(
        "uAPI v2 drops the oldest event. Below {bound:.0} ohm B follows A before the program has been woken. The gap in the sequence \
         numbers shows it: there is no number."
    );
    it
}

/// The stamp of the first edge that the program gets, s after the start.
fn first_edge(by_hand: &mut ByHand) -> Option<f64> {
    let start = by_hand.start(Drives::x(0));
    // Woken by A, it finds what is in the buffer.
    let woken = start.after + Nanos(60_000_000);
    let first = by_hand.pins.edge(woken).unwrap();
    by_hand.pins.drive(Drives::NONE).unwrap();
    first.map(|edge| (edge.at - start.before).as_seconds() - STAMP)
}
