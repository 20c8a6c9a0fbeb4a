//! The published method on a board, by hand: discharges and their crossings, for the equations of `paper`.

use crate::paper::Times;
use crate::scenario::Board;
use cermd::circuit::Node;
use cermd::instrument::discharge::{Charge, Plan, UsualCall, run};
use cermd::pins::sim::SimPins;
use cermd::pins::{Bracket, Drives, Pins};
use cermd::reading::Method;
use cermd::record::Through;
use cermd::units::Nanos;

/// How long the calls of `pi4` take that switch one line.
const SINGLE_CALL: Nanos = Nanos(1200);

/// Between charge and start.
const SETTLE: Nanos = Nanos(20_000);

/// The published method, by hand: discharges without any of our rules.
pub struct ByHand<P = SimPins> {
    pub pins: P,
    charge: Nanos,
    /// Subtracted from every crossing, s.
    pub offset: f64,
    /// Between charge and start of the sensor's discharge.
    pub pause: Nanos,
}

impl ByHand {
    /// On a board with the circuit of Fig. 1(c).
    pub fn new(board: &Board, r_ohm: f64, seed: u64) -> ByHand {
        ByHand::with(board, r_ohm, seed, |pins| pins)
    }
}

impl<P: Pins> ByHand<P> {
    /// The same with something around the pins.
    pub fn with(board: &Board, r_ohm: f64, seed: u64, around: impl FnOnce(SimPins) -> P) -> ByHand<P> {
        let (pins, settings) = board.bench(Method::Tcdic, r_ohm, seed).parts();
        ByHand { pins: around(pins), charge: settings.charge.anew.together, offset: 0.0, pause: SETTLE }
    }

    /// Crossings of one discharge, with a switch to Rc2 after so many seconds, and when that really came; `None` if one is
    /// missing.
    pub fn discharge(&mut self, through: Through, switch: Option<f64>) -> Option<([f64; 2], f64)> {
        let plan = Plan {
            switch: switch.map(|s| (Nanos::from_seconds(s), Through::C2)),
            settle: if through.channel().is_some() { self.pause } else { SETTLE },
            calls: [Some(UsualCall { length: SINGLE_CALL, longest: Nanos::MAX }); 3],
            ..Plan::full(through, Node::B, Charge::together(self.charge), Nanos(400_000_000))
        };
        let record = run(&mut self.pins, plan).unwrap().result.ok()?;
        // The equations know a single instant of the switch; between release and sink nothing moves.
        let (at, on) = record.switch.map_or((0.0, f64::INFINITY), |switch| (switch.at_ns, switch.on_ns));
        let crossing = |ns: f64| (if ns > on { ns - (on - at) } else { ns }) * 1e-9 - self.offset;
        let at = at * 1e-9;
        Some(([crossing(record.a_ns?), crossing(record.b_ns?)], at))
    }

    /// One cycle: c1, c2, x.
    pub fn cycle(&mut self, switch: Option<f64>) -> Option<Times> {
        let (c1, _) = self.discharge(Through::C1, None)?;
        let (c2, _) = self.discharge(Through::C2, None)?;
        let (x, switch) = self.discharge(Through::X(0), switch)?;
        Some(Times { c1, c2, x, switch })
    }

    /// Many cycles, one after another.
    pub fn cycles(&mut self, count: usize, switch: Option<f64>) -> Vec<Times> {
        (0..count).filter_map(|_| self.cycle(switch)).collect()
    }

    /// Length of a charge, s.
    pub fn charge_s(&self) -> f64 {
        self.charge.as_seconds()
    }

    /// Charges, arms, and starts a discharge through the lines `on`, whose edges are left to the caller.
    pub fn start(&mut self, on: Drives) -> Bracket {
        let pins = &mut self.pins;
        pins.drive(Drives::CHARGE).unwrap();
        let charged = pins.now() + self.charge;
        pins.sleep_until(charged).unwrap();
        pins.drive(Drives::NONE).unwrap();
        pins.arm().unwrap();
        pins.drive(on).unwrap()
    }

    /// When B crosses in a discharge through the sensor that has so many seconds, s.
    pub fn wait_for(&mut self, seconds: f64) -> f64 {
        let start = self.start(Drives::x(0)).after;
        let until = start + Nanos::from_seconds(seconds);
        let mut last = start;
        while let Some(edge) = self.pins.edge(until).unwrap() {
            last = edge.at;
        }
        self.pins.drive(Drives::NONE).unwrap();
        (last - start).as_seconds()
    }
}
