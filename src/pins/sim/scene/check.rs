//! Whether the values of a scene make sense: the key and the remedy, before anything is simulated.

use super::{Kind, NodeScene, Scene, SceneError, Threshold, line_named};
use crate::pins::MAX_CHANNELS;
use crate::pins::limits::MOST_EVENTS;
use crate::pins::sim::sensor::Sensor;
use crate::units::{Quantity, Seconds};
use std::path::Path;

/// Where a value may lie, and what is said of one that does not.
struct Range(fn(f64) -> bool, &'static str);

const POSITIVE: Range = Range(|value| value > 0.0 && value.is_finite(), "has to be above 0");
const NOT_NEGATIVE: Range = Range(|value| value >= 0.0 && value.is_finite(), "must not be negative");
const PROBABILITY: Range =
    Range(|value| (0.0..=1.0).contains(&value), "is a probability: write a number from 0 to 1");
const FINITE: Range = Range(f64::is_finite, "has to be finite");

/// What a range is for.
trait Value {
    /// In SI units; `None`: it is absent, and that is in order.
    fn si(&self) -> Option<f64>;
}

impl<Q: Quantity> Value for Q {
    fn si(&self) -> Option<f64> {
        Some(Quantity::si(*self))
    }
}

impl Value for f64 {
    fn si(&self) -> Option<f64> {
        Some(*self)
    }
}

impl<V: Value> Value for Option<V> {
    fn si(&self) -> Option<f64> {
        self.as_ref().and_then(V::si)
    }
}

/// A value with its key in a table.
type Row<'a> = (&'a str, &'a dyn Value);

/// Keeps the first problem: its key, and what is wrong and what to do.
#[derive(Default)]
struct Check(Option<(String, String)>);

impl Check {
    fn demand(&mut self, holds: bool, key: impl Into<String>, otherwise: impl Into<String>) {
        if !holds && self.0.is_none() {
            self.0 = Some((key.into(), otherwise.into()));
        }
    }

    fn all(&mut self, range: Range, table: &str, rows: &[Row]) {
        for (key, value) in rows {
            self.demand(value.si().is_none_or(range.0), format!("{table}.{key}"), range.1);
        }
    }

    fn tail(&mut self, table: &str, probability: Option<f64>, mean: Option<Seconds>) {
        const APART: &str = "tail-probability and tail-mean belong together: name both or neither";
        self.demand(probability.is_some() == mean.is_some(), table, APART);
        self.all(PROBABILITY, table, &[("tail-probability", &probability)]);
        self.all(POSITIVE, table, &[("tail-mean", &mean)]);
    }

    fn threshold(&mut self, key: &str, threshold: Threshold, v_dd: f64) {
        let rising = threshold.rising.unwrap_or(threshold.falling);
        self.all(POSITIVE, key, &[("falling", &threshold.falling)]);
        self.demand(rising >= threshold.falling, format!("{key}.rising"), "must not be below falling");
        self.demand(rising.0 < v_dd, key, "has to be below v-dd: no input could ever read high");
    }

    fn node(&mut self, key: &str, node: &NodeScene, v_dd: f64) {
        if let Some(threshold) = node.threshold {
            self.threshold(&format!("{key}.threshold"), threshold, v_dd);
        }
        let resistances: &[Row] = &[
            ("leakage-resistance", &node.leakage_resistance),
            ("pull-up", &node.pull_up),
            ("pull-down", &node.pull_down),
        ];
        self.all(POSITIVE, key, resistances);
    }

    fn sensor(&mut self, key: &str, sensor: &Sensor) {
        match sensor {
            Sensor::Constant(r) => self.demand((NOT_NEGATIVE.0)(r.0), key, NOT_NEGATIVE.1),
            Sensor::Step { before, after, at } => {
                let values: &[Row] = &[("before", before), ("after", after), ("at", at)];
                self.all(NOT_NEGATIVE, key, values);
            }
            Sensor::Ramp { from, to, start, duration } => {
                self.all(NOT_NEGATIVE, key, &[("from", from), ("to", to), ("start", start)]);
                self.all(POSITIVE, key, &[("duration", duration)]);
            }
            Sensor::Sine { mean, amplitude, frequency } => {
                self.all(POSITIVE, key, &[("frequency", frequency)]);
                self.all(NOT_NEGATIVE, key, &[("amplitude", amplitude)]);
                let is_sound = mean.0.is_finite() && mean >= amplitude;
                let otherwise = "must not be above the mean: R would be negative";
                self.demand(is_sound, format!("{key}.amplitude"), otherwise);
            }
            Sensor::File { points, .. } => {
                self.demand(!points.is_empty(), key, "the file has no rows time_s,ohm");
            }
            Sensor::Hand { alpha, peak, period } => {
                self.all(POSITIVE, key, &[("alpha", alpha), ("peak", peak), ("period", period)]);
            }
        }
    }
}

impl Scene {
    /// Itself, if every value makes sense.
    pub(super) fn checked(self, origin: &Path) -> Result<Scene, SceneError> {
        let mut check = Check::default();
        self.check_circuit(&mut check);
        let most = format!("there can be at most {MAX_CHANNELS}");
        check.demand(self.sensors.len() <= MAX_CHANNELS, "sensor", most);
        for (channel, sensor) in self.sensors.iter().enumerate() {
            check.sensor(&format!("sensor {channel}"), sensor);
        }
        // At least half a nanosecond, so that it rounds to one.
        let is_long_enough = (POSITIVE.0)(self.sample_interval.0 - 0.5e-9);
        check.demand(is_long_enough, "sample-interval", POSITIVE.1);
        self.check_clock(&mut check);
        self.check_latencies(&mut check);
        self.check_effects(&mut check);
        match check.0 {
            None => Ok(self),
            Some((key, problem)) => Err(SceneError::Value { origin: origin.to_owned(), key, problem }),
        }
    }

    fn check_circuit(&self, check: &mut Check) {
        let circuit = &self.circuit;
        let wanted = match circuit.kind {
            Kind::TwoCapacitor => &[("c-a", circuit.c_a), ("c-b", circuit.c_b)][..],
            Kind::OneCapacitor | Kind::SeriesCalibration => &[("c", circuit.c)],
        };
        for (key, capacitor) in wanted {
            let otherwise = "is missing: this kind of circuit has it";
            check.demand(capacitor.is_some(), format!("circuit.{key}"), otherwise);
            check.all(POSITIVE, "circuit", &[(key, capacitor)]);
        }
        let values: &[Row] = &[
            ("v-dd", &circuit.v_dd),
            ("r-c1", &circuit.r_c1),
            ("r-c2", &circuit.r_c2),
            ("r-o", &circuit.r_o),
        ];
        check.all(POSITIVE, "circuit", values);
        check.all(NOT_NEGATIVE, "circuit", &[("r-p", &circuit.r_p)]);
        for (name, value) in &circuit.r_o_of {
            let otherwise = "is no line: charge-a, charge-b, c1, c2, x0 .. x15";
            check.demand(line_named(name).is_some(), format!("circuit.r-o-of.{name}"), otherwise);
            check.all(POSITIVE, "circuit.r-o-of", &[(name, value)]);
        }
        check.threshold("circuit.threshold", circuit.threshold, circuit.v_dd.0);
        check.node("circuit.node-a", &circuit.node_a, circuit.v_dd.0);
        check.node("circuit.node-b", &circuit.node_b, circuit.v_dd.0);
    }

    fn check_clock(&self, check: &mut Check) {
        let Some(period) = self.clock_period else { return };
        let ns = period.0 * 1e9;
        let is_whole = ns >= 0.999 && (ns - ns.round()).abs() <= 1e-6;
        check.demand(is_whole, "clock-period", "has to be a whole number of nanoseconds, at least 1");
        let is_alone =
            (self.calls.is_none() && self.stamps.is_none()) && (self.wake.is_none() && self.sleep.is_none());
        let otherwise = "excludes calls, stamps, wake and sleep: with a common clock nothing else is late";
        check.demand(is_alone, "clock-period", otherwise);
    }

    fn check_latencies(&self, check: &mut Check) {
        for (key, delay) in [("stamps", self.stamps), ("wake", self.wake), ("sleep", self.sleep)] {
            if let Some(delay) = delay {
                check.all(NOT_NEGATIVE, key, &[("mean", &delay.mean), ("jitter", &delay.jitter)]);
                check.tail(key, delay.tail_probability, delay.tail_mean);
            }
        }
        if let Some(calls) = &self.calls {
            let values: &[Row] =
                &[("fixed", &calls.fixed), ("per-line", &calls.per_line), ("jitter", &calls.jitter)];
            check.all(NOT_NEGATIVE, "calls", values);
            check.tail("calls", calls.tail_probability, calls.tail_mean);
            let is_ordered = calls.moves_at.is_none_or(|[from, to]| 0.0 <= from && from <= to && to <= 1.0);
            check.demand(is_ordered, "calls.moves-at", "is [from, to] with 0 <= from <= to <= 1");
        }
        let reads = self.reads.unwrap_or_default();
        let costs: &[Row] = &[("clock", &reads.clock), ("levels", &reads.levels), ("arm", &reads.arm)];
        check.all(NOT_NEGATIVE, "reads", costs);
    }

    fn check_effects(&self, check: &mut Check) {
        let events = self.events.unwrap_or_default();
        let is_kept = events.buffer.is_none_or(|buffer| (1..=MOST_EVENTS).contains(&buffer));
        check.demand(is_kept, "events.buffer", format!("the kernel allows 1 to {MOST_EVENTS} events"));
        check.all(PROBABILITY, "events", &[("lost", &events.lost), ("coalesced", &events.coalesced)]);
        let is_whole = events.coalesced.is_some() == events.bounce.is_some();
        check.demand(is_whole, "events.bounce", "and coalesced belong together: name both or neither");
        check.all(POSITIVE, "events", &[("bounce", &events.bounce)]);
        if let Some(noise) = &self.noise {
            let values: &[Row] = &[("voltage", &noise.voltage), ("bandwidth", &noise.bandwidth)];
            check.all(POSITIVE, "noise", values);
        }
        let drift = self.drift.unwrap_or_default();
        let rates: &[Row] = &[
            ("c-per-minute", &drift.c_per_minute),
            ("v-th-per-minute", &drift.v_th_per_minute),
            ("v-dd-per-minute", &drift.v_dd_per_minute),
        ];
        check.all(FINITE, "drift", rates);
    }
}
