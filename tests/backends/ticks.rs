//! The kernel's tick interrupts calls, and makes stamps late: discharges keep clear of it where it is known when it comes.

use crate::common::chance::share_is_in;
use crate::common::decorated::Decorated;
use crate::common::{Bench, quiet};
use cermd::circuit::Node;
use cermd::instrument::settings::Settings;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::sim::scene::TicksScene;
use cermd::pins::sim::{Scene, SimPins};
use cermd::reading::Method;
use cermd::units::{Nanos, Seconds};

/// A kernel of CONFIG_HZ = 1000, whose ticks have much to do.
const EVERY: Seconds = Seconds(1e-3);
const TAKES: Seconds = Seconds(30e-6);
const DISCHARGES: usize = 4000;

/// Of so many discharges from the second second on: those with a call that a tick made longer, and those in which a node that is
/// timed falls while there is one.
fn met<P: Pins>(pins: P, settings: Settings, simulated: impl Fn(&P) -> &SimPins) -> [usize; 2] {
    let (mut instrument, mut met, mut seen) = (Instrument::new(pins, settings), [0; 2], 0);
    while seen < DISCHARGES {
        let (retried, mut taken) = (instrument.stats().retried, None);
        let mut take = |message| {
            if let Message::Discharge { record, .. } = message {
                taken = Some(record);
            }
        };
        instrument.step(&mut take).unwrap();
        if instrument.pins().now() < Nanos(1_000_000_000) {
            continue;
        }
        // One that a tick makes longer is refused, and the discharge taken again.
        met[0] += (instrument.stats().retried - retried) as usize;
        let Some(record) = taken else { continue };
        seen += 1;
        let truth = simulated(instrument.pins()).truth();
        // Since the line moved that began it, within a microsecond of the entry of its call.
        let falls_ns = |node: Node| record.crossings()[node.index()].and(truth.crossing_ns(node));
        let meets = |ns: f64| (record.start.as_ns() + ns).rem_euclid(1e9 * EVERY.0) < 1e9 * TAKES.0;
        met[1] += usize::from(Node::BOTH.into_iter().filter_map(falls_ns).any(meets));
    }
    met
}

#[test]
fn discharges_keep_clear_of_the_tick() {
    // At 100 ohm a discharge is finished through R_2, from so shortly before B falls on that nobody knows when it will.
    for (r_ohm, most) in [(100.0, 0.02), (1000.0, 0.005), (5000.0, 0.005), (16_200.0, 0.005)] {
        let mut bench = Bench::new("pi4", Method::Tracked, r_ohm, 0, "");
        let ticks = Some(TicksScene { every: EVERY, takes: TAKES });
        bench.scene = Scene { ticks, ..quiet(bench.scene) };
        let (pins, settings) = bench.parts();
        let told = met(pins, settings, |pins| pins);
        let (pins, settings) = bench.parts();
        let unknowing = met(Decorated::without_tick(pins), settings, |pins| &pins.pins);
        println!("{r_ohm} ohm: {told:?} of {DISCHARGES}, {unknowing:?} where nobody knows when it comes");
        assert!(share_is_in(told[0], DISCHARGES, 0.0..=0.0), "{r_ohm} ohm: {told:?}");
        assert!(share_is_in(told[1], DISCHARGES, 0.0..=most), "{r_ohm} ohm: {told:?}");
        assert!(!share_is_in(unknowing[0], DISCHARGES, 0.0..=0.0), "{r_ohm} ohm: {unknowing:?}");
        assert!(!share_is_in(unknowing[1], DISCHARGES, 0.0..=most), "{r_ohm} ohm: {unknowing:?}");
    }
}
