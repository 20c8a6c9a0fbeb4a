//! Whether the values of a scene make sense.
//!
//! For: naming the key and the remedy before anything is simulated. Must not know: TOML.

use super::{DelayScene, Kind, NodeScene, Scene, SceneError, Threshold, line_named};
use crate::pins::MAX_CHANNELS;
use crate::pins::sim::sensor::Sensor;
use crate::units::Seconds;
use std::path::Path;

/// (key, what is wrong and what to do)
type Problem = (String, String);

fn problem(key: &str, text: impl Into<String>) -> Problem {
    (key.to_owned(), text.into())
}

fn positive(key: &str, value: f64) -> Result<(), Problem> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(problem(key, "has to be above 0")) }
}

fn not_negative(key: &str, value: f64) -> Result<(), Problem> {
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(problem(key, "must not be negative")) }
}

fn probability(key: &str, value: f64) -> Result<(), Problem> {
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(problem(key, "is a probability: write a number from 0 to 1"))
    }
}

fn tail(key: &str, probability_of: Option<f64>, mean: Option<Seconds>) -> Result<(), Problem> {
    match (probability_of, mean) {
        (None, None) => Ok(()),
        (Some(p), Some(mean)) => {
            probability(&format!("{key}.tail-probability"), p)?;
            positive(&format!("{key}.tail-mean"), mean.0)
        }
        _ => Err(problem(key, "tail-probability and tail-mean belong together: name both or neither")),
    }
}

impl Scene {
    /// Itself, if every value makes sense.
    pub(super) fn checked(self, origin: &Path) -> Result<Scene, SceneError> {
        match self.problem() {
            Ok(()) => Ok(self),
            Err((key, problem)) => Err(SceneError::Value { origin: origin.to_owned(), key, problem }),
        }
    }

    fn problem(&self) -> Result<(), Problem> {
        self.check_circuit()?;
        if self.sensors.len() > MAX_CHANNELS {
            return Err(problem("sensor", format!("there can be at most {MAX_CHANNELS}")));
        }
        for (channel, sensor) in self.sensors.iter().enumerate() {
            check_sensor(&format!("sensor {channel}"), sensor)?;
        }
        positive("sample-interval", self.sample_interval.0 - 0.5e-9)?;
        if let Some(period) = self.clock_period {
            let ns = period.0 * 1e9;
            if ns < 0.999 || (ns - ns.round()).abs() > 1e-6 {
                return Err(problem("clock-period", "has to be a whole number of nanoseconds, at least 1"));
            }
            if self.calls.is_some() || self.stamps.is_some() || self.wake.is_some() || self.sleep.is_some() {
                return Err(problem(
                    "clock-period",
                    "excludes calls, stamps, wake and sleep: with a common clock nothing else is late",
                ));
            }
        }
        if let Some(drift) = &self.drift {
            let rates = [
                Some(drift.c_per_minute),
                drift.v_th_per_minute.map(|v| v.0),
                drift.v_dd_per_minute.map(|v| v.0),
            ];
            if rates.into_iter().flatten().any(|rate| !rate.is_finite()) {
                return Err(problem("drift", "has to be finite"));
            }
        }
        self.check_latencies()?;
        self.check_events()
    }

    fn check_circuit(&self) -> Result<(), Problem> {
        let circuit = &self.circuit;
        let wanted = match circuit.kind {
            Kind::TwoCapacitor => vec![("circuit.c-a", circuit.c_a), ("circuit.c-b", circuit.c_b)],
            Kind::OneCapacitor | Kind::SeriesCalibration => vec![("circuit.c", circuit.c)],
        };
        for (key, capacitor) in wanted {
            let farad = capacitor.ok_or_else(|| problem(key, "is missing: this kind of circuit has it"))?;
            positive(key, farad.0)?;
        }
        positive("circuit.v-dd", circuit.v_dd.0)?;
        positive("circuit.r-c1", circuit.r_c1.0)?;
        positive("circuit.r-c2", circuit.r_c2.0)?;
        positive("circuit.r-o", circuit.r_o.0)?;
        not_negative("circuit.r-p", circuit.r_p.map_or(0.0, |r| r.0))?;
        for (name, value) in &circuit.r_o_of {
            let key = format!("circuit.r-o-of.{name}");
            line_named(name)
                .ok_or_else(|| problem(&key, "is no line: charge-a, charge-b, c1, c2, x0 .. x15"))?;
            positive(&key, value.0)?;
        }
        self.check_threshold("circuit.threshold", circuit.threshold)?;
        self.check_node("circuit.node-a", &circuit.node_a)?;
        self.check_node("circuit.node-b", &circuit.node_b)
    }

    fn check_threshold(&self, key: &str, threshold: Threshold) -> Result<(), Problem> {
        let falling = threshold.falling.0;
        let rising = threshold.rising.unwrap_or(threshold.falling).0;
        positive(&format!("{key}.falling"), falling)?;
        if rising < falling {
            return Err(problem(&format!("{key}.rising"), "must not be below falling"));
        }
        if rising >= self.circuit.v_dd.0 {
            return Err(problem(key, "has to be below v-dd: no input could ever read high"));
        }
        Ok(())
    }

    fn check_node(&self, key: &str, node: &NodeScene) -> Result<(), Problem> {
        if let Some(threshold) = node.threshold {
            self.check_threshold(&format!("{key}.threshold"), threshold)?;
        }
        for (name, r) in [
            ("leakage-resistance", node.leakage_resistance),
            ("pull-up", node.pull_up),
            ("pull-down", node.pull_down),
        ] {
            if let Some(r) = r {
                positive(&format!("{key}.{name}"), r.0)?;
            }
        }
        Ok(())
    }

    fn check_latencies(&self) -> Result<(), Problem> {
        for (key, delay) in [("stamps", &self.stamps), ("wake", &self.wake), ("sleep", &self.sleep)] {
            if let Some(DelayScene { mean, jitter, tail_probability, tail_mean }) = delay {
                not_negative(&format!("{key}.mean"), mean.0)?;
                not_negative(&format!("{key}.jitter"), jitter.map_or(0.0, |s| s.0))?;
                tail(key, *tail_probability, *tail_mean)?;
            }
        }
        if let Some(calls) = &self.calls {
            not_negative("calls.fixed", calls.fixed.0)?;
            not_negative("calls.per-line", calls.per_line.0)?;
            not_negative("calls.jitter", calls.jitter.unwrap_or(0.0))?;
            tail("calls", calls.tail_probability, calls.tail_mean)?;
            let [from, to] = calls.moves_at.unwrap_or([0.5; 2]);
            if !(0.0 <= from && from <= to && to <= 1.0) {
                return Err(problem("calls.moves-at", "is [from, to] with 0 <= from <= to <= 1"));
            }
        }
        if let Some(reads) = &self.reads {
            for (key, cost) in
                [("reads.clock", reads.clock), ("reads.levels", reads.levels), ("reads.arm", reads.arm)]
            {
                not_negative(key, cost.map_or(0.0, |s| s.0))?;
            }
        }
        Ok(())
    }

    fn check_events(&self) -> Result<(), Problem> {
        if let Some(events) = &self.events {
            if !(1..=1024).contains(&events.buffer.unwrap_or(16)) {
                return Err(problem("events.buffer", "the kernel allows 1 to 1024 events"));
            }
            probability("events.lost", events.lost.unwrap_or(0.0))?;
            probability("events.coalesced", events.coalesced.unwrap_or(0.0))?;
            match (events.coalesced, events.bounce) {
                (None, None) => {}
                (Some(_), Some(bounce)) => positive("events.bounce", bounce.0)?,
                _ => {
                    return Err(problem(
                        "events.bounce",
                        "and coalesced belong together: name both or neither",
                    ));
                }
            }
        }
        if let Some(noise) = &self.noise {
            positive("noise.voltage", noise.voltage.0)?;
            if let Some(bandwidth) = noise.bandwidth {
                positive("noise.bandwidth", bandwidth.0)?;
            }
        }
        Ok(())
    }
}

fn check_sensor(key: &str, sensor: &Sensor) -> Result<(), Problem> {
    match sensor {
        Sensor::Constant(r) => not_negative(key, r.0),
        Sensor::Step { before, after, at } => {
            not_negative(&format!("{key}.before"), before.0)?;
            not_negative(&format!("{key}.after"), after.0)?;
            not_negative(&format!("{key}.at"), at.0)
        }
        Sensor::Ramp { from, to, start, duration } => {
            not_negative(&format!("{key}.from"), from.0)?;
            not_negative(&format!("{key}.to"), to.0)?;
            not_negative(&format!("{key}.start"), start.0)?;
            positive(&format!("{key}.duration"), duration.0)
        }
        Sensor::Sine { mean, amplitude, frequency } => {
            positive(&format!("{key}.frequency"), frequency.0)?;
            not_negative(&format!("{key}.amplitude"), amplitude.0)?;
            if mean.0.is_finite() && mean.0 >= amplitude.0 {
                Ok(())
            } else {
                Err(problem(&format!("{key}.amplitude"), "must not be above the mean: R would be negative"))
            }
        }
        Sensor::File { points, .. } => {
            if points.is_empty() {
                return Err(problem(key, "the file has no rows time_s,ohm"));
            }
            Ok(())
        }
        Sensor::Hand { alpha, peak, period } => {
            positive(&format!("{key}.alpha"), alpha.0)?;
            positive(&format!("{key}.peak"), peak.0)?;
            positive(&format!("{key}.period"), period.0)
        }
    }
}
