//! What on the board makes a reading a fault.
//!
//! For: naming the part to look at, from what the last discharges through known resistors showed. Must not know: how
//! discharges are taken, or who is told.

use crate::circuit::Node;
use crate::instrument::discharge::Outcome;
use crate::pins::Levels;
use crate::reading::{Fault, Suspect};
use crate::record::CalibrationKind;
use crate::record::{Record, Through};

/// Where current leaks.
pub const LEAKS: &str = "pull-downs, leaking capacitors, moisture, a sensor wired to ground";
/// A node that falls in less than this part of its predicted time has nothing but wires at it.
pub const MISSING: f64 = 0.05;

/// The last discharges, as far as they tell about the board.
#[derive(Debug, Clone, Default)]
pub struct Diagnosis {
    /// Through R_1 and R_2 alone.
    known: [Option<Record>; 2],
    /// A sensor's.
    sensor: Option<Record>,
    /// The levels after the last charge.
    charged: Option<Levels>,
    r_ohm: [f64; 2],
    is_series: bool,
    nodes: usize,
    /// When node A should cross in a discharge through R_1, by nominal values, ns.
    nominal_ns: f64,
}

impl Diagnosis {
    /// For R_1 < R_2 (`is_series`: Rc1 and Rc1 + Rc2), one or two nodes, and the nominal time of node A through R_1.
    pub fn new(r_ohm: [f64; 2], is_series: bool, nodes: usize, nominal_ns: f64) -> Diagnosis {
        Diagnosis { r_ohm, is_series, nodes, nominal_ns, ..Diagnosis::default() }
    }

    /// Remembers a calibration discharge.
    pub fn take(&mut self, kind: CalibrationKind, outcome: &Outcome) {
        self.charged = outcome.charged;
        if outcome.result == Err(Fault::WideBracket) {
            // The system was slow; the board is as it was.
            return;
        }
        match kind {
            CalibrationKind::First => self.known[0] = outcome.result.ok(),
            CalibrationKind::Second => self.known[1] = outcome.result.ok(),
            CalibrationKind::Split => {}
        }
    }

    /// Remembers a sensor's discharge.
    pub fn take_sensor(&mut self, outcome: &Outcome) {
        self.charged = outcome.charged;
        self.sensor = outcome.result.ok();
    }

    /// What a fault looks like, if the last discharges tell.
    pub fn suspect(&self, fault: Fault) -> Option<Suspect> {
        match fault {
            Fault::NoCharge => self.uncharged(),
            Fault::Leakage => self.shape().or(Some(Suspect::Leak)),
            Fault::PullUp => self.shape().or(Some(Suspect::Pull)),
            Fault::NoCalibration | Fault::Implausible | Fault::LatencyOutlier => {
                self.shape().or_else(|| self.unfinished())
            }
            _ => None,
        }
    }

    fn uncharged(&self) -> Option<Suspect> {
        let levels = self.charged?;
        let nodes = &Node::BOTH[..self.nodes];
        nodes.iter().find(|node| !levels.of(**node)).map(|node| Suspect::Uncharged(*node))
    }

    /// By which nodes fall in the discharges through known resistors, and when.
    fn shape(&self) -> Option<Suspect> {
        let [first, second] = self.known;
        let falls = |record: &Record| record.a_ns.is_some() || (self.nodes == 2 && record.b_ns.is_some());
        match (first, second) {
            (Some(first), Some(second)) if !falls(&first) && !falls(&second) => Some(Suspect::BothOpen),
            (Some(first), _) if !falls(&first) => Some(Suspect::FirstOpen),
            (_, Some(second)) if !falls(&second) => Some(Suspect::SecondOpen),
            _ => {
                let mut known = self.known.iter().flatten();
                known.find_map(|record| self.order(record)).or_else(|| self.are_swapped(&first?, &second?))
            }
        }
    }

    /// A sensor's discharge that a known resistor was to finish, and has not.
    fn unfinished(&self) -> Option<Suspect> {
        let record = self.sensor?;
        let is_unfinished = if self.nodes == 2 { record.b_ns.is_none() } else { record.a_ns.is_none() };
        let to = record.switch.filter(|_| is_unfinished)?.to;
        Some(if to == Through::C1 { Suspect::FirstOpen } else { Suspect::SecondOpen })
    }

    fn order(&self, record: &Record) -> Option<Suspect> {
        // A stamp may be late, none is early.
        let first_a = self.known.iter().flatten().filter_map(|record| record.a_ns).reduce(f64::min);
        let at_once = first_a.is_some_and(|a| a < MISSING * self.nominal_ns);
        match (record.a_ns, record.b_ns) {
            (Some(_), _) if self.nodes == 1 => at_once.then_some(Suspect::NoCapacitor),
            (Some(_), None) => Some(if at_once { Suspect::NoCA } else { Suspect::StaysHigh(Node::B) }),
            (None, Some(_)) => Some(Suspect::StaysHigh(Node::A)),
            (Some(_), Some(_)) if at_once => Some(Suspect::NoCB),
            (Some(a), Some(b)) => (b < a).then_some(Suspect::NodesSwapped),
            (None, None) => None,
        }
    }

    /// Whether the times have the ratio that swapped resistors would give, rather than that which they should have.
    fn are_swapped(&self, first: &Record, second: &Record) -> Option<Suspect> {
        let [r1, r2] = self.r_ohm;
        let swapped = if self.is_series { r2 / (r2 - r1) } else { r1 / r2 };
        let ratio = second.a_ns? / first.a_ns?;
        let away_from = |expected: f64| (ratio / expected).ln().abs();
        (away_from(swapped) < away_from(r2 / r1)).then_some(Suspect::ResistorsSwapped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_suspect_says_what_was_seen_and_what_to_look_at() {
        let texts: Vec<String> = Suspect::ALL.iter().map(ToString::to_string).collect();
        for (index, text) in texts.iter().enumerate() {
            assert!(text.len() < 200 && text.is_ascii() && !texts[..index].contains(text), "{text}");
            assert!(text.contains("; look "), "{text}");
        }
    }
}
