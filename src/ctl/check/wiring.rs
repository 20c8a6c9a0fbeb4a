//! The wiring test: what a person with a multimeter would look for, done by the pins themselves.
//!
//! What the discharges through known resistors say of the board is judged by the rules of the running instrument,
//! [`Nominal`]; only here a node is watched while nothing drives, and times are held against the printed values.

use crate::circuit::{Kind, Node};
use crate::config::{Config, Findings, Severity};
use crate::ctl::check::full_plan;
use crate::ctl::limits::{NO_PULL, PATIENCE, PLAUSIBLE, PLAUSIBLE_RATIO, SMALLEST_LEAK};
use crate::estimate::leak::{self, LeakTest, Lost};
use crate::estimate::limits::LEAK_FIRST;
use crate::estimate::scatter;
use crate::instrument::diagnosis::Nominal;
use crate::instrument::discharge::{self, Plan};
use crate::pins::{Drives, Pins, PinsError};
use crate::reading::{Fault, Suspect};
use crate::record::{Record, Through};
use crate::units::{Nanos, Ohm, Seconds};

/// What to try after a fault of a discharge.
const AGAIN: &str = "the same again; the kernel's log (dmesg)";

/// Tests every line of the circuit; all are inputs afterwards. What cannot be told after a failure is left out.
///
/// # Errors
/// If the pins cannot be used.
pub fn test(pins: &mut dyn Pins, config: &Config, findings: &mut Findings) -> Result<(), PinsError> {
    let circuit = &config.circuit;
    let nominal = Nominal {
        kind: circuit.kind(),
        nodes: circuit.kind().nodes(),
        r_ohm: [circuit.r_c1.0, circuit.r_second().0],
        nominal_ns: circuit.crossing(Node::A, circuit.r_c1).unwrap_or_default().0 * 1e9,
    };
    let mut inspection = Inspection { pins, config, nominal, findings };
    inspection.run()?;
    inspection.pins.drive(Drives::NONE).map(drop)
}

struct Inspection<'a> {
    pins: &'a mut dyn Pins,
    config: &'a Config,
    nominal: Nominal,
    findings: &'a mut Findings,
}

impl Inspection<'_> {
    fn run(&mut self) -> Result<(), PinsError> {
        self.drain()?;
        if !self.charges()? || !self.holds(true)? {
            return Ok(());
        }
        let is_series = self.nominal.kind == Kind::SeriesCalibration;
        let second = if is_series { Through::C12 } else { Through::C2 };
        let c1 = self.calibration(Through::C1)?;
        // If nothing fell, the other resistor tells whether it is the resistor's wire or a node.
        let falls = c1.is_some_and(|record| record.crossings().iter().any(Option::is_some));
        if falls && (self.is_suspect(c1, None) || !self.stays_discharged()?) {
            return Ok(());
        }
        let c2 = self.calibration(second)?;
        if self.is_suspect(c1, c2) {
            return Ok(());
        }
        let (Some(c1), Some(c2)) = (c1, c2) else { return Ok(()) };
        self.resistors(&c1, &c2);
        self.times(&c1, "Rc1", self.config.circuit.r_c1);
        self.times(&c2, self.nominal.kind.second(), self.config.circuit.r_second());
        self.leak(&c2)?;
        for channel in 0..self.config.channels.len() {
            self.sensor(channel, &c1, &c2)?;
        }
        Ok(())
    }

    /// Whether the discharges through known resistors show what is wrong with the board.
    fn is_suspect(&mut self, c1: Option<Record>, c2: Option<Record>) -> bool {
        let known = [c1, c2].map(|record| record.map(|record| record.crossings()));
        let Some(suspect) = self.nominal.suspect(known) else { return false };
        let names = ["Rc1", self.nominal.kind.second()].into_iter().zip([c1, c2]);
        let taken = names.filter_map(|(name, record)| Some(format!("{} through {name}", times(&record?))));
        let taken = taken.collect::<Vec<_>>().join("; ");
        self.suspect(Severity::Error, suspect, suspect, &format!("{} ({taken})", suspect.seen()));
        true
    }

    /// What was seen at the place of `at`, and looks like `like`.
    fn suspect(&mut self, severity: Severity, at: Suspect, like: Suspect, reason: &str) {
        self.findings.add(severity, key(at), reason, Some(&format!("another {}", like.look())));
    }

    /// Takes out what an earlier charge has left, or chargers without wires would seem to work. Through both resistors:
    /// the wire of one may be cut.
    fn drain(&mut self) -> Result<(), PinsError> {
        let time = Nanos::from_seconds(self.config.discharge(self.config.circuit.r_second()).0);
        for sink in [Drives::C1, Drives::C2] {
            let driven = self.pins.drive(sink)?;
            self.pins.sleep_until(driven.after + time)?;
        }
        self.pins.drive(Drives::NONE).map(drop)
    }

    /// Whether every node is high after a charge.
    fn charges(&mut self) -> Result<bool, PinsError> {
        let time = self.config.charges().anew.time();
        let charging = self.pins.drive(Drives::CHARGE)?;
        self.pins.sleep_until(charging.after + time)?;
        self.pins.drive(Drives::NONE)?;
        let levels = self.pins.arm()?.levels;
        let suspects: Vec<Suspect> = self.nominal.uncharged(levels).collect();
        for suspect in &suspects {
            let reason = format!("{} of {:.3}", suspect.seen(), Seconds::from(time));
            self.suspect(Severity::Error, *suspect, *suspect, &reason);
        }
        Ok(suspects.is_empty())
    }

    /// Whether every node keeps its level, `high` or low, while nothing drives.
    fn holds(&mut self, high: bool) -> Result<bool, PinsError> {
        let (moves, like) = if high { ("falls", Suspect::Leak) } else { ("rises", Suspect::Pull) };
        let time = self.config.circuit.crossing(Node::A, NO_PULL).unwrap_or_default();
        let until = self.pins.now() + Nanos::from_seconds(time.0);
        self.pins.sleep_until(until)?;
        let levels = self.pins.levels()?;
        let moved = || self.nominal.nodes.iter().filter(|node| levels.of(**node) != high);
        let all_hold = moved().count() == 0;
        for &node in moved() {
            let reason = format!("node {node:?} {moves} by itself within {time:.3} while nothing drives");
            self.suspect(Severity::Error, Suspect::StaysHigh(node), like, &reason);
        }
        Ok(all_hold)
    }

    /// The same after a discharge that goes on well beyond the thresholds.
    fn stays_discharged(&mut self) -> Result<bool, PinsError> {
        let more = self.config.discharge(self.config.circuit.r_c1);
        let driven = self.pins.drive(Drives::C1)?;
        self.pins.sleep_until(driven.after + Nanos::from_seconds(more.0))?;
        self.pins.drive(Drives::NONE)?;
        self.holds(false)
    }

    /// The instrument's own test: discharges through R_2 that are held on their way, against some that are not.
    fn leak(&mut self, c2: &Record) -> Result<(), PinsError> {
        let Some(a_ns) = c2.a_ns else { return Ok(()) };
        let usual = self.calibration_plan(c2.through);
        let r2_ohm = self.nominal.r_ohm[1];
        // What a usual one takes, what a held one does beside that, and how long it was held.
        let mut seen_ns: Vec<[f64; 3]> = Vec::with_capacity(LEAK_FIRST);
        let hold = leak::hold(a_ns, r2_ohm);
        let in_turn = |seen_ns: &[[f64; 3]], variance: f64| {
            let mut test = LeakTest::default();
            for &[usual, left, held_ns] in seen_ns {
                let to_a = [usual - left, variance];
                test.add(Some(Lost { to_a, more_to_b: None, held_ns, r_ohm: r2_ohm }), Nanos::ZERO);
            }
            test
        };
        // Some may come to nothing.
        for _ in 0..2 * LEAK_FIRST {
            if seen_ns.len() == LEAK_FIRST {
                break;
            }
            let held_at = in_turn(&seen_ns, 0.0).held_at();
            let switch = Some((Nanos((held_at * a_ns) as i64), c2.through));
            let held = Plan { hold, switch, ..usual };
            let [usual, held] = [usual, held].map(|plan| self.discharge(plan));
            if let (Ok(usual), Ok(Record { a_ns, switch: Some(switch), .. })) = (usual?, held?) {
                let held_ns = switch.on_ns - switch.at_ns;
                seen_ns.extend(usual.a_ns.zip(a_ns).map(|(usual, a_ns)| [usual, a_ns - held_ns, held_ns]));
            }
        }
        // Of the usual ones, which nothing but noise tells apart; each is compared with one more that has as much.
        let u_ns = scatter::mean(seen_ns.iter().map(|[usual, ..]| *usual))
            .and_then(|mean| mean.u)
            .unwrap_or_default();
        let test = in_turn(&seen_ns, 2.0 * seen_ns.len() as f64 * u_ns.powi(2));
        if let Some(siemens) = test.siemens().filter(|siemens| siemens.abs() > SMALLEST_LEAK) {
            let (like, what) = match siemens > 0.0 {
                true => (Suspect::Leak, "charge leaks away"),
                false => (Suspect::Pull, "charge comes in"),
            };
            let reason = format!("{what} as through {:.2} beside the resistors", Ohm(1.0 / siemens.abs()));
            self.suspect(Severity::Warning, like, like, &reason);
        }
        Ok(())
    }

    /// A discharge through a calibration resistor, with patience for its end.
    fn calibration_plan(&self, through: Through) -> Plan {
        let patience = PATIENCE * self.config.discharge(self.config.circuit.r_second()).0;
        full_plan(self.config, through, Nanos::from_seconds(patience))
    }

    /// A discharge, or the fault that it ended with.
    fn discharge(&mut self, plan: Plan) -> Result<Result<Record, Fault>, PinsError> {
        Ok(discharge::run(self.pins, plan)?.result)
    }

    /// A discharge through a calibration resistor, whether anything falls in it or not; `None` after a fault.
    fn calibration(&mut self, through: Through) -> Result<Option<Record>, PinsError> {
        let (suspect, name) = match through {
            Through::C1 => (Suspect::FirstOpen, "Rc1"),
            _ => (Suspect::SecondOpen, self.nominal.kind.second()),
        };
        let result = self.discharge(self.calibration_plan(through))?;
        if let Err(fault) = result {
            self.findings.error(key(suspect), fault_reason(fault, name), AGAIN);
        }
        Ok(result.ok())
    }

    /// Crossings have to come about when the capacitors promise them.
    fn times(&mut self, record: &Record, name: &str, r: Ohm) {
        for &node in self.nominal.nodes {
            let predicted = self.config.circuit.crossing(node, r);
            let Some((measured_ns, predicted)) = record.crossing(node).zip(predicted) else { continue };
            let measured = Seconds(measured_ns * 1e-9);
            if (1.0 / PLAUSIBLE..=PLAUSIBLE).contains(&(measured.0 / predicted.0)) {
                continue;
            }
            let capacitor = match (self.nominal.kind, node) {
                (Kind::TwoCapacitor, Node::A) => Suspect::NoCA,
                (Kind::TwoCapacitor, Node::B) => Suspect::NoCB,
                _ => Suspect::NoCapacitor,
            };
            self.findings.warning(
                key(capacitor),
                format!(
                    "node {node:?} falls {measured:.3} into a discharge through {name}; {predicted:.3} was predicted"
                ),
                format!("{name}, the capacitors (printed value, unit), v-th; or another path to ground"),
            );
        }
    }

    /// Whether the two calibration resistors are as the configuration says.
    fn resistors(&mut self, c1: &Record, c2: &Record) {
        let expected = self.nominal.r_ohm[1] / self.nominal.r_ohm[0];
        let ratio = c1.a_ns.zip(c2.a_ns).map_or(expected, |(t1, t2)| t2 / t1);
        if !(1.0 / PLAUSIBLE_RATIO..=PLAUSIBLE_RATIO).contains(&(ratio / expected)) {
            self.findings.warning(
                "circuit.r-c2",
                format!("the discharges through Rc2 and Rc1 differ by a factor of {ratio:.2}; {expected:.2} was expected"),
                "Rc1 and Rc2 measured again; another path to ground",
            );
        }
        let [first, second] = [c1, c2].map(times);
        self.findings.info(
            "wiring",
            format!("the nodes charge, hold, and fall in order: {first} through Rc1, {second} through Rc2"),
        );
    }

    /// What a sensor reads, roughly: eq. (3).
    fn sensor(&mut self, channel: usize, c1: &Record, c2: &Record) -> Result<(), PinsError> {
        let key = format!("channel.{}.sink", self.config.channels[channel].id);
        let deadline = self.config.deadline();
        let record = match self.discharge(full_plan(self.config, Through::X(channel), deadline))? {
            Ok(record) => record,
            Err(fault) => {
                self.findings.error(key, fault_reason(fault, "the sensor"), AGAIN);
                return Ok(());
            }
        };
        if let (Some(t1), Some(t2), Some(x)) = (c1.a_ns, c2.a_ns, record.a_ns) {
            let [r1, r2] = self.nominal.r_ohm;
            let r = Ohm((r1 + (r2 - r1) * (x - t1) / (t2 - t1)).max(0.0));
            self.findings.info(key, format!("the sensor is there and reads about {r:.3}"));
        } else {
            self.findings.warning(
                key,
                format!("no discharge through the sensor within {:.3}", Seconds::from(deadline)),
                "to press it while this runs; else the wire from the sink through the sensor to node A",
            );
        }
        Ok(())
    }
}

/// The key of the configuration that a suspect is about.
fn key(suspect: Suspect) -> &'static str {
    match suspect {
        Suspect::Uncharged(Node::A) => "gpio.charge-a",
        Suspect::Uncharged(Node::B) => "gpio.charge-b",
        Suspect::FirstOpen => "gpio.sink-c1",
        Suspect::SecondOpen => "gpio.sink-c2",
        Suspect::BothOpen | Suspect::StaysHigh(Node::A) => "gpio.sense-a",
        Suspect::StaysHigh(Node::B) | Suspect::NodesSwapped => "gpio.sense-b",
        Suspect::ResistorsSwapped => "circuit.r-c1",
        Suspect::NoCA => "circuit.c-a",
        Suspect::NoCB => "circuit.c-b",
        Suspect::NoCapacitor => "circuit.c",
        Suspect::Leak | Suspect::Pull => "wiring",
    }
}

/// The crossings of a discharge.
fn times(record: &Record) -> String {
    let crossings = record.crossings().into_iter().flatten();
    let times: Vec<String> = crossings.map(|ns| format!("{:.3}", Seconds(ns * 1e-9))).collect();
    if times.is_empty() { "nothing".to_owned() } else { times.join(", ") }
}

fn fault_reason(fault: Fault, name: &str) -> String {
    match fault {
        Fault::MissedEdge => {
            format!("a node falls in a discharge through {name}, but the kernel reports no edge")
        }
        other => format!("a discharge through {name} ends with the fault {}", other.as_str()),
    }
}

#[cfg(test)]
mod tests;
