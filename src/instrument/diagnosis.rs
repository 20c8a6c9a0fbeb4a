//! What on the board makes a reading a fault: one set of rules for the running instrument and for the wiring test.

use crate::circuit::{Kind, Node};
use crate::instrument::discharge::Outcome;
use crate::instrument::limits::MISSING;
use crate::pins::Levels;
use crate::reading::{Fault, Suspect};
use crate::record::{CalibrationKind, Record, Through};

/// Crossings of A and B in the discharges through R_1 and R_2, ns; `None` for a discharge that tells nothing.
pub type SeenCrossings = [Option<[Option<f64>; 2]>; 2];

/// What is known of a board before anything is measured.
#[derive(Debug, Clone, Copy)]
pub struct Nominal {
    /// How it is wired.
    pub kind: Kind,
    /// Its nodes as far as they are timed.
    pub nodes: &'static [Node],
    /// R_1 and R_2, ohm.
    pub r_ohm: [f64; 2],
    /// When node A should cross in a discharge through R_1, by nominal values, ns.
    pub nominal_ns: f64,
}

impl Nominal {
    /// The nodes that a charge has left low.
    pub fn uncharged(&self, levels: Levels) -> impl Iterator<Item = Suspect> + use<> {
        self.nodes.iter().filter(move |node| !levels.of(**node)).map(|node| Suspect::Uncharged(*node))
    }

    /// What is wrong by which nodes fall in the discharges through known resistors, and when.
    pub fn suspect(&self, known: SeenCrossings) -> Option<Suspect> {
        let falls = known.map(|crossings| {
            crossings.map(|crossings| self.nodes.iter().any(|node| crossings[node.index()].is_some()))
        });
        match falls {
            [Some(false), Some(false)] => Some(Suspect::BothOpen),
            [Some(false), _] => Some(Suspect::FirstOpen),
            [_, Some(false)] => Some(Suspect::SecondOpen),
            _ => {
                // A stamp may be late, none is early.
                let first_a = known.iter().flatten().filter_map(|crossings| crossings[0]).reduce(f64::min);
                let at_once = first_a.is_some_and(|a_ns| a_ns < MISSING * self.nominal_ns);
                let order = |crossings: &[Option<f64>; 2]| self.order(*crossings, at_once);
                known.iter().flatten().find_map(order).or_else(|| self.swapped(known))
            }
        }
    }

    fn order(&self, [a_ns, b_ns]: [Option<f64>; 2], at_once: bool) -> Option<Suspect> {
        match (a_ns, b_ns) {
            (Some(_), _) if self.nodes.len() == 1 => at_once.then_some(Suspect::NoCapacitor),
            (Some(_), None) => Some(if at_once { Suspect::NoCA } else { Suspect::StaysHigh(Node::B) }),
            (None, Some(_)) => Some(Suspect::StaysHigh(Node::A)),
            (Some(_), Some(_)) if at_once => Some(Suspect::NoCB),
            (Some(a_ns), Some(b_ns)) => (b_ns < a_ns).then_some(Suspect::NodesSwapped),
            (None, None) => None,
        }
    }

    /// Whether the times have the ratio that swapped resistors would give, rather than that which they should have.
    fn swapped(&self, known: SeenCrossings) -> Option<Suspect> {
        let ([r1, r2], [first, second]) = (self.r_ohm, known);
        let swapped = if self.kind == Kind::SeriesCalibration { r2 / (r2 - r1) } else { r1 / r2 };
        let ratio = second?[0]? / first?[0]?;
        let away_from = |expected: f64| (ratio / expected).ln().abs();
        (away_from(swapped) < away_from(r2 / r1)).then_some(Suspect::ResistorsSwapped)
    }
}

/// The last discharges of a running instrument, as far as they tell about the board.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    nominal: Nominal,
    known: SeenCrossings,
    sensor: Option<Record>,
    /// The levels after the last charge.
    charged: Option<Levels>,
}

impl Diagnosis {
    /// Of this board; nothing has been measured yet.
    pub fn new(nominal: Nominal) -> Diagnosis {
        Diagnosis { nominal, known: [None; 2], sensor: None, charged: None }
    }

    /// Remembers a calibration discharge.
    pub fn take(&mut self, kind: CalibrationKind, outcome: &Outcome) {
        self.charged = outcome.charged;
        if outcome.result == Err(Fault::WideBracket) {
            // The system was slow; the board is as it was.
            return;
        }
        let known = match kind {
            CalibrationKind::First => &mut self.known[0],
            CalibrationKind::Second => &mut self.known[1],
            CalibrationKind::Split => return,
        };
        *known = outcome.result.ok().map(|record| match (record.crossings(), record.waited_ns, *known) {
            // Nobody waited for B.
            ([a_ns, None], None, Some([_, before])) => [a_ns, before],
            (crossings, _, _) => crossings,
        });
    }

    /// Remembers a sensor's discharge.
    pub fn take_sensor(&mut self, outcome: &Outcome) {
        self.charged = outcome.charged;
        self.sensor = outcome.result.ok();
    }

    /// What a fault looks like, if the last discharges tell.
    pub fn suspect(&self, fault: Fault) -> Option<Suspect> {
        let shape = || self.nominal.suspect(self.known);
        match fault {
            Fault::NoCharge => self.nominal.uncharged(self.charged?).next(),
            Fault::Leakage => shape().or(Some(Suspect::Leak)),
            Fault::PullUp => shape().or(Some(Suspect::Pull)),
            Fault::NoCalibration | Fault::Implausible | Fault::LatencyOutlier => {
                shape().or_else(|| self.unfinished())
            }
            _ => None,
        }
    }

    /// A sensor's discharge that a known resistor was to finish, and has not.
    fn unfinished(&self) -> Option<Suspect> {
        let record = self.sensor.filter(|record| record.ended(self.nominal.nodes.len()).is_none())?;
        Some(if record.switch?.to == Through::C1 { Suspect::FirstOpen } else { Suspect::SecondOpen })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_suspect_says_what_was_seen_and_what_to_look_at() {
        let all = [
            Suspect::Uncharged(Node::A),
            Suspect::Uncharged(Node::B),
            Suspect::FirstOpen,
            Suspect::SecondOpen,
            Suspect::BothOpen,
            Suspect::StaysHigh(Node::A),
            Suspect::StaysHigh(Node::B),
            Suspect::NodesSwapped,
            Suspect::ResistorsSwapped,
            Suspect::NoCA,
            Suspect::NoCB,
            Suspect::NoCapacitor,
            Suspect::Leak,
            Suspect::Pull,
        ];
        let texts: Vec<String> = all.iter().map(ToString::to_string).collect();
        for (index, text) in texts.iter().enumerate() {
            assert!(text.len() < 200 && text.is_ascii() && !texts[..index].contains(text), "{text}");
            assert!(text.contains("; look "), "{text}");
        }
    }
}
