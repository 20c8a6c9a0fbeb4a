//! The wiring test: what a person with a multimeter would look for, done by the pins themselves.
//!
//! For: charges, discharges and their times against what the configuration promises, each difference with what to look
//! at on the board. Must not know: which backend the pins belong to.

use crate::circuit::Node;
use crate::config::{Config, Finding};
use crate::estimate::leak;
use crate::instrument::diagnosis::{LEAKS, MISSING};
use crate::instrument::discharge::{self, Plan};
use crate::pins::{Drives, Levels, Pins, PinsError};
use crate::reading::Fault;
use crate::record::{Record, Through};
use crate::units::{Nanos, Ohm, Seconds};

/// A charged node that holds its level as long as a discharge through this resistance takes has no pull beside it: those
/// of processors are 30 to 100 kohm.
const NO_PULL: Ohm = Ohm(200e3);
/// Printed capacitors are within 20 %, thresholds between a quarter and a half of the supply: times beyond this factor
/// have another cause.
const PLAUSIBLE: f64 = 2.0;
/// Resistors are known better than capacitors: the ratio of their times may differ by this factor.
const PLAUSIBLE_RATIO: f64 = 1.2;
/// Pairs of discharges that look for a leak, and the smallest one that is told, siemens.
const HELD: usize = 8;
const SMALLEST_LEAK: f64 = 1e-7;
/// How many predicted discharges to wait for the real one.
const PATIENCE: f64 = 5.0;

/// Tests every line of the circuit; all are inputs afterwards. What cannot be told after a failure is left out.
///
/// # Errors
/// If the pins cannot be used.
pub fn test<P: Pins>(pins: &mut P, config: &Config) -> Result<Vec<Finding>, PinsError> {
    let mut bench = Bench { pins, config, findings: Vec::new() };
    bench.run()?;
    bench.pins.drive(Drives::NONE)?;
    Ok(bench.findings)
}

fn error(key: impl Into<String>, reason: impl Into<String>, remedy: impl Into<String>) -> Finding {
    Finding::error(key, reason).try_this(remedy)
}

fn warning(key: impl Into<String>, reason: impl Into<String>, remedy: impl Into<String>) -> Finding {
    Finding::warning(key, reason).try_this(remedy)
}

struct Bench<'a, P> {
    pins: &'a mut P,
    config: &'a Config,
    findings: Vec<Finding>,
}

impl<P: Pins> Bench<'_, P> {
    fn run(&mut self) -> Result<(), PinsError> {
        self.drain()?;
        if !self.charges()? || !self.holds(true)? {
            return Ok(());
        }
        let c1 = self.calibration(Through::C1)?;
        if c1.is_some() && !self.stays_discharged()? {
            return Ok(());
        }
        let second = match self.config.circuit.network {
            crate::circuit::Network::SeriesCalibration { .. } => Through::C12,
            _ => Through::C2,
        };
        // After a failure, the other resistor tells whether it is the resistor's wire or a node.
        let c2 = if c1.is_some() || self.findings.iter().any(|finding| finding.key == "gpio.sink-c1") {
            self.calibration(second)?
        } else {
            None
        };
        let (Some(c1), Some(c2)) = (c1, c2) else { return Ok(()) };
        if !self.resistors(&c1, &c2) {
            return Ok(());
        }
        self.times(&c1, "Rc1", self.config.circuit.r_c1);
        self.times(&c2, second_name(second), self.config.circuit.r_second());
        self.leak()?;
        for channel in 0..self.config.channels.len() {
            self.sensor(channel, &c1, &c2)?;
        }
        Ok(())
    }

    /// The nodes of the circuit, each with the letter that its keys end in.
    fn nodes(&self) -> impl Iterator<Item = (Node, &'static str)> + use<P> {
        let count = 1 + usize::from(self.has_node_b());
        [(Node::A, "a"), (Node::B, "b")].into_iter().take(count)
    }

    fn has_node_b(&self) -> bool {
        matches!(self.config.circuit.network, crate::circuit::Network::TwoCapacitor { .. })
    }

    fn charge(&mut self) -> Result<Levels, PinsError> {
        let charging = self.pins.drive(Drives::CHARGE)?;
        self.pins.sleep_until(charging.after + self.config.charge_time())?;
        self.pins.drive(Drives::NONE)?;
        Ok(self.pins.arm()?.levels)
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
        let levels = self.charge()?;
        let time = Seconds::from(self.config.charge_time());
        let mut all = true;
        for (node, letter) in self.nodes().filter(|(node, _)| !levels.of(*node)) {
            all = false;
            self.findings.push(error(
                format!("gpio.charge-{letter}"),
                format!("node {node:?} is low after a charge of {time:.3}"),
                format!("the wires from the charger through its resistor to node {node:?} and on to sense-{letter}, and \
                         look for a short to ground"),
            ));
        }
        Ok(all)
    }

    /// Whether every node keeps its level, `high` or low, while nothing drives.
    fn holds(&mut self, high: bool) -> Result<bool, PinsError> {
        let (moves, remedy) = if high {
            (
                "falls",
                "no pull-down on any line, no leaking capacitor, and the sensor behind its sink, not to ground",
            )
        } else {
            ("rises", "no pull-up on any line, and each charger through its resistor to its own node")
        };
        let time = self.config.circuit.crossing(Node::A, NO_PULL).unwrap_or_default();
        let until = self.pins.now() + Nanos::from_seconds(time.0);
        self.pins.sleep_until(until)?;
        let levels = self.pins.levels()?;
        let moved: Vec<_> = self.nodes().filter(|(node, _)| levels.of(*node) != high).collect();
        for (node, letter) in &moved {
            let reason = format!("node {node:?} {moves} by itself within {time:.3} while nothing drives");
            self.findings.push(error(format!("gpio.sense-{letter}"), reason, remedy));
        }
        Ok(moved.is_empty())
    }

    /// The same after a discharge that goes on well beyond the thresholds.
    fn stays_discharged(&mut self) -> Result<bool, PinsError> {
        let more = self.config.discharge(self.config.circuit.r_c1);
        let driven = self.pins.drive(Drives::C1)?;
        self.pins.sleep_until(driven.after + Nanos::from_seconds(more.0))?;
        self.pins.drive(Drives::NONE)?;
        self.holds(false)
    }

    /// Whether discharges that are held back are shorter than those that begin at once.
    fn leak(&mut self) -> Result<(), PinsError> {
        let circuit = &self.config.circuit;
        let (r, timeout) = (circuit.r_c1, PATIENCE * self.config.discharge(circuit.r_c1).0);
        let mut siemens = Vec::with_capacity(HELD);
        for _ in 0..HELD {
            let mut fall = |hold| {
                let record = self.held_discharge(Through::C1, Nanos::from_seconds(timeout), hold)?;
                Ok(record.ok().and_then(|record| record.a_ns))
            };
            if let (Some(usual), Some(held)) = (fall(Nanos::ZERO)?, fall(leak::HOLD)?) {
                siemens.push(leak::siemens_by(usual - held, r.0));
            }
        }
        siemens.sort_unstable_by(f64::total_cmp);
        // Every pair agrees that there is one: the jitter of stamps is of either sign.
        let is_leak = siemens.first().is_some_and(|least| *least > 0.0);
        if let Some(median) =
            siemens.get(siemens.len() / 2).filter(|median| is_leak && **median > SMALLEST_LEAK)
        {
            let leak = Ohm(1.0 / median);
            let reason = format!("charge leaks away as through {leak:.2} beside the resistors");
            self.findings.push(warning("wiring", reason, format!("another look at the board: {LEAKS}")));
        }
        Ok(())
    }

    fn discharge(&mut self, through: Through, timeout: Nanos) -> Result<Result<Record, Fault>, PinsError> {
        self.held_discharge(through, timeout, Nanos::ZERO)
    }

    fn held_discharge(
        &mut self,
        through: Through,
        timeout: Nanos,
        hold: Nanos,
    ) -> Result<Result<Record, Fault>, PinsError> {
        let last = if self.has_node_b() { Node::B } else { Node::A };
        let plan = Plan {
            settle: self.config.settle_time() + hold,
            ..Plan::full(through, last, self.config.charge_time(), timeout)
        };
        Ok(discharge::run(self.pins, plan)?.result)
    }

    /// The crossings through a calibration resistor, compared with what the capacitors promise.
    fn calibration(&mut self, through: Through) -> Result<Option<Record>, PinsError> {
        let circuit = &self.config.circuit;
        let (key, name, r) = match through {
            Through::C1 => ("gpio.sink-c1", "Rc1", circuit.r_c1),
            second => ("gpio.sink-c2", second_name(second), circuit.r_second()),
        };
        let timeout = PATIENCE * self.config.discharge(circuit.r_second()).0;
        let record = match self.discharge(through, Nanos::from_seconds(timeout))? {
            Ok(record) => record,
            Err(fault) => {
                self.findings.push(error(
                    key,
                    fault_reason(fault, name),
                    "the same again; the kernel's log (dmesg)",
                ));
                return Ok(None);
            }
        };
        let (first, last) = (record.a_ns, record.b_ns);
        if first.is_none() && last.is_none() {
            self.findings.push(error(
                key,
                format!("nothing falls within {:.3} of a discharge through {name}", Seconds(timeout)),
                format!("the wire from the sink through {name} to node A"),
            ));
            return Ok(None);
        }
        if self.lacks_capacitor(&record, name, r) || !self.order(&record, name) {
            return Ok(None);
        }
        Ok(Some(record))
    }

    /// Whether node A falls so early that there is nothing but wire. B follows it at once without C_B, and not at all
    /// without C_A.
    fn lacks_capacitor(&mut self, record: &Record, name: &str, r: Ohm) -> bool {
        let predicted = self.config.circuit.crossing(Node::A, r).unwrap_or_default();
        let Some(a) = record.a_ns.map(|ns| Seconds(ns * 1e-9)).filter(|a| a.0 < MISSING * predicted.0) else {
            return false;
        };
        let (key, part) = match (self.has_node_b(), record.b_ns) {
            (false, _) => ("circuit.c", "the capacitor"),
            (true, None) => ("circuit.c-a", "C_A"),
            (true, Some(_)) => ("circuit.c-b", "C_B"),
        };
        self.findings.push(error(
            key,
            format!("node A falls {a:.3} into a discharge through {name}; {predicted:.3} was predicted"),
            format!("another look at the board: {part} is missing or has no contact"),
        ));
        true
    }

    /// Whether both nodes have crossed, A before B.
    fn order(&mut self, record: &Record, name: &str) -> bool {
        if !self.has_node_b() {
            return true;
        }
        match (record.a_ns, record.b_ns) {
            (Some(a), Some(b)) if a < b => return true,
            (Some(_), Some(_)) => self.findings.push(error(
                "gpio.sense-b",
                format!("node B falls before node A in a discharge through {name}"),
                "sense-a at the resistors and sense-b between the capacitors: they, or C_A and C_B, look swapped",
            )),
            (a, _) => {
                let letter = if a.is_none() { "a" } else { "b" };
                self.findings.push(error(
                    format!("gpio.sense-{letter}"),
                    format!("node {} stays high in a discharge through {name}, the other falls", letter.to_uppercase()),
                    format!("the wire of sense-{letter}, and both capacitors: C_A from node A to node B, C_B from there to \
                             ground"),
                ));
            }
        }
        false
    }

    fn times(&mut self, record: &Record, name: &str, r: Ohm) {
        for (node, letter) in self.nodes() {
            let measured = if node == Node::A { record.a_ns } else { record.b_ns };
            let predicted = self.config.circuit.crossing(node, r);
            if let (Some(ns), Some(predicted)) = (measured, predicted) {
                self.time(node, letter, name, Seconds(ns * 1e-9), predicted);
            }
        }
    }

    /// A crossing has to come about when the capacitors promise it.
    fn time(&mut self, node: Node, letter: &str, name: &str, measured: Seconds, predicted: Seconds) {
        let factor = measured.0 / predicted.0;
        let reason = format!(
            "node {node:?} falls {measured:.3} into a discharge through {name}; {predicted:.3} was predicted"
        );
        let key = if self.has_node_b() { format!("circuit.c-{letter}") } else { "circuit.c".to_owned() };
        if !(1.0 / PLAUSIBLE..=PLAUSIBLE).contains(&factor) {
            let remedy =
                format!("{name}, the capacitors (printed value, unit), v-th; or another path to ground");
            self.findings.push(warning(key, reason, remedy));
        }
    }

    /// Whether the two calibration resistors look like themselves.
    fn resistors(&mut self, c1: &Record, c2: &Record) -> bool {
        let circuit = &self.config.circuit;
        let (Some(t1), Some(t2)) = (c1.a_ns, c2.a_ns) else { return false };
        let expected = circuit.r_second().0 / circuit.r_c1.0;
        let ratio = t2 / t1;
        if ratio <= 1.0 {
            self.findings.push(error(
                "circuit.r-c1",
                format!("the discharge through Rc2 takes {ratio:.3} times as long as that through Rc1; {expected:.2} times \
                         was expected"),
                "sink-c1 and sink-c2 the other way round: Rc1 and Rc2 look swapped",
            ));
            return false;
        }
        if !(1.0 / PLAUSIBLE_RATIO..=PLAUSIBLE_RATIO).contains(&(ratio / expected)) {
            self.findings.push(warning(
                "circuit.r-c2",
                format!("the discharges through Rc2 and Rc1 differ by a factor of {ratio:.2}; {expected:.2} was expected"),
                "Rc1 and Rc2 measured again; another path to ground",
            ));
        }
        let ms = |record: &Record| {
            let crossings = [record.a_ns, record.b_ns].into_iter().flatten();
            crossings.map(|ns| format!("{:.3} ms", ns * 1e-6)).collect::<Vec<_>>().join(", ")
        };
        self.findings.push(Finding::info(
            "wiring",
            format!(
                "the nodes charge, hold, and fall in order: {} through Rc1, {} through Rc2",
                ms(c1),
                ms(c2)
            ),
        ));
        true
    }

    /// What a sensor reads, roughly: eq. (3).
    fn sensor(&mut self, channel: usize, c1: &Record, c2: &Record) -> Result<(), PinsError> {
        let id = &self.config.channels[channel].id;
        let key = format!("channel.{id}.sink");
        let deadline = self.config.deadline();
        let result = self.discharge(Through::X(channel), deadline)?;
        let circuit = &self.config.circuit;
        let crossings = (c1.a_ns, c2.a_ns, result.as_ref().ok().and_then(|record| record.a_ns));
        self.findings.push(match (result, crossings) {
            (Err(fault), _) => {
                error(key, fault_reason(fault, "the sensor"), "the same again; the kernel's log (dmesg)")
            }
            (Ok(_), (Some(t1), Some(t2), Some(x))) => {
                let span = circuit.r_second().0 - circuit.r_c1.0;
                let r = Ohm((circuit.r_c1.0 + span * (x - t1) / (t2 - t1)).max(0.0));
                Finding::info(key, format!("the sensor is there and reads about {r:.3}"))
            }
            _ => warning(
                key,
                format!("no discharge through the sensor within {:.3}", Seconds::from(deadline)),
                "to press it while this runs; else the wire from the sink through the sensor to node A",
            ),
        });
        Ok(())
    }
}

fn second_name(through: Through) -> &'static str {
    if through == Through::C12 { "Rc1 + Rc2" } else { "Rc2" }
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
