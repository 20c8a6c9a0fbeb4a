//! Edges that never arrive.

use crate::by_hand::ByHand;
use crate::common::chance::{Figure, mean_of};
use crate::common::{Errors, settle};
use crate::paper::{Parts, R_O};
use crate::scenario::{Board, Scenario, is_true, percent, truth};
use crate::switching::{HALF_CALL, STAMP};
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
            found += usize::from(!(0..10).all(|_| all_edges_come(&mut by_hand, nodes)));
        }
        let in_ten = 1.0 - (1.0 - LOST).powi(10 * edges);
        let what = format!("{} as printed: waits for ever within ten cycles", method.as_str());
        it.expect_share(what, found, 200, in_ten..=in_ten);
        it.published(
            method,
            format!("waits for ever within 100 cycles, {:.0} %", 100.0 * hangs),
            hangs < 0.01,
            false,
        );
    }
    for method in Method::ALL {
        let errors = board.errors(method, 1000.0, 20, 200);
        // A where it ends the discharge; A and B where both are needed.
        let predicted = match method {
            Method::Tpcm | Method::Qerm | Method::Tracked => LOST,
            Method::Tcdic | Method::Cerm => 1.0 - (1.0 - LOST) * (1.0 - LOST),
        };
        let without = errors.not_ok.len() + errors.without_u;
        // Besides, the gates of 5 sigma close for one reading in a thousand or less.
        it.expect_share(
            format!("{}: readings without a number", method.as_str()),
            without,
            without + errors.count(),
            predicted..=predicted + 0.001,
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
    // What comes first is taken for A. The line moves in the middle of its call, on average.
    let found = mean_of(&first_stamps(r_ohm));
    it.expect("the first edge is B's: its time, s", found, g_b * (r_ohm + R_O) + HALF_CALL, 0.2 * HALF_CALL);
    let above = mean_of(&first_stamps(2.0 * bound));
    let of_a = g_a * (2.0 * bound + R_O) + HALF_CALL;
    it.expect("at four times 33 ohm it is A's: its time, s", above, of_a, 0.2 * HALF_CALL);
    // Eq. (3) makes 1/g_A ohm of a second.
    let off = Figure { value: found.value - g_a * (r_ohm + R_O), ..found }.times(1.0 / g_a);
    it.published(
        Method::Tpcm,
        format!("{} off", percent(off.value / r_ohm)),
        off.within(0.01 * r_ohm),
        false,
    );
    for method in Method::ALL {
        let mut all = Errors::default();
        let mut named = 0;
        for seed in 0..20 {
            all.next_board();
            let mut instrument = board.bench(method, r_ohm, seed).instrument();
            settle(&mut instrument);
            crate::common::read(&mut instrument, 60, |_| {});
            let before = instrument.stats().faults;
            crate::common::read(&mut instrument, 100, |reading| all.add(reading, r_ohm));
            let after = instrument.stats().faults;
            let count = |fault: Fault| after[fault as usize] - before[fault as usize];
            named += count(Fault::LostEvent) + count(Fault::CoalescedEdge) + count(Fault::MissedEdge);
        }
        let is_sound = match all.count() {
            0 => true.into(),
            _ => all.within_2u().times(-1.0).below(-0.9),
        };
        let figure = format!("{}, {named} of them named", truth(&all, r_ohm));
        it.cell(method, figure, is_sound & (named as usize == all.not_ok.len()).into(), true);
        if all.count() == 0 {
            it.only_told(method);
        }
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
