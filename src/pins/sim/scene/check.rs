//! Whether the values of a scene make sense: the key and the remedy, before anything is simulated.

use super::{
    AbsorptionScene, BranchScene, CircuitScene, Kind, NodeScene, NoiseScene, ReadsScene, Scene, Threshold,
    TicksScene, line_named,
};
use crate::pins::MAX_CHANNELS;
use crate::pins::limits::{LATEST, LATEST_MOVE, MOST_BRANCHES, MOST_EVENTS};
use crate::pins::sim::sensor::Sensor;
use crate::units::{Quantity, Seconds, Volt};
use std::fmt::Display;

/// Where a value may lie, and what is said of one that does not.
struct Range(fn(f64) -> bool, &'static str);

const POSITIVE: Range = Range(|value| value > 0.0 && value.is_finite(), "has to be above 0");
const NOT_NEGATIVE: Range = Range(|value| value >= 0.0 && value.is_finite(), "must not be negative");
/// Seconds.
const LATE: Range = Range(|value| (0.0..=LATEST).contains(&value), "has to be from 0 s to 1 s");
const SHARE: Range =
    Range(|value| (0.0..=1.0).contains(&value), "is a part of a call's time: write a number from 0 to 1");
const PROBABILITY: Range =
    Range(|value| (0.0..=1.0).contains(&value), "is a probability: write a number from 0 to 1");

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
type KeyedValue<'a> = (&'a str, &'a dyn Value);

/// The key, and what is wrong and what to do, unless `holds`.
fn demand(holds: bool, key: impl Display, otherwise: impl Display) -> Result<(), String> {
    if holds { Ok(()) } else { Err(format!("{key}: {otherwise}")) }
}

fn all(range: Range, table: &str, rows: &[KeyedValue]) -> Result<(), String> {
    rows.iter().try_for_each(|(key, value)| {
        demand(value.si().is_none_or(range.0), format!("{table}.{key}"), range.1)
    })
}

/// Two keys of a table that mean nothing without each other.
fn together<A, B>(table: &str, keys: &str, one: Option<A>, other: Option<B>) -> Result<(), String> {
    demand(one.is_some() == other.is_some(), table, format!("{keys} belong together: name both or neither"))
}

fn tail(table: &str, probability: Option<f64>, mean: Option<Seconds>) -> Result<(), String> {
    together(table, "tail-probability and tail-mean", probability, mean)?;
    all(PROBABILITY, table, &[("tail-probability", &probability)])?;
    all(POSITIVE, table, &[("tail-mean", &mean)])?;
    all(LATE, table, &[("tail-mean", &mean)])
}

impl Threshold {
    fn check(&self, key: &str, v_dd: Volt) -> Result<(), String> {
        let rising = self.rising.unwrap_or(self.falling);
        all(POSITIVE, key, &[("falling", &self.falling)])?;
        demand(rising >= self.falling, format!("{key}.rising"), "must not be below falling")?;
        demand(rising < v_dd, key, "has to be below v-dd: no input could ever read high")
    }
}

impl NodeScene {
    fn check(&self, key: &str, v_dd: Volt) -> Result<(), String> {
        if let Some(threshold) = self.threshold {
            threshold.check(&format!("{key}.threshold"), v_dd)?;
        }
        let resistances: &[KeyedValue] = &[
            ("leakage-resistance", &self.leakage_resistance),
            ("pull-up", &self.pull_up),
            ("pull-down", &self.pull_down),
        ];
        all(POSITIVE, key, resistances)
    }
}

impl AbsorptionScene {
    fn check(&self) -> Result<(), String> {
        for (capacitor, branches) in [("c-a", &self.c_a), ("c-b", &self.c_b), ("c", &self.c)] {
            let key = format!("circuit.absorption.{capacitor}");
            let otherwise = format!("can have at most {MOST_BRANCHES} branches");
            demand(branches.len() <= MOST_BRANCHES, &key, otherwise)?;
            for BranchScene { share, tau } in branches {
                all(POSITIVE, &key, &[("share", share), ("tau", tau)])?;
                let otherwise = "is of the capacitor: write 0.0025 for 0.25 %, at most 1";
                demand(*share <= 1.0, format!("{key}.share"), otherwise)?;
            }
        }
        Ok(())
    }
}

impl Sensor {
    fn check(&self, key: &str) -> Result<(), String> {
        match self {
            Sensor::Constant(r) => demand((NOT_NEGATIVE.0)(r.0), key, NOT_NEGATIVE.1),
            Sensor::Step { before, after, at } => {
                all(NOT_NEGATIVE, key, &[("before", before), ("after", after), ("at", at)])
            }
            Sensor::Ramp { from, to, start, duration } => {
                all(NOT_NEGATIVE, key, &[("from", from), ("to", to), ("start", start)])?;
                all(POSITIVE, key, &[("duration", duration)])
            }
            Sensor::Sine { mean, amplitude, frequency } => {
                all(POSITIVE, key, &[("frequency", frequency)])?;
                all(NOT_NEGATIVE, key, &[("amplitude", amplitude)])?;
                let is_sound = mean.0.is_finite() && mean >= amplitude;
                let otherwise = "must not be above the mean: R would be negative";
                demand(is_sound, format!("{key}.amplitude"), otherwise)
            }
            Sensor::File { points, .. } => demand(!points.is_empty(), key, "the file has no rows time_s,ohm"),
            Sensor::Hand { alpha, peak, period } => {
                all(POSITIVE, key, &[("alpha", alpha), ("peak", peak), ("period", period)])
            }
        }
    }
}

impl CircuitScene {
    fn check(&self) -> Result<(), String> {
        let capacitors: &[KeyedValue] = &[("c-a", &self.c_a), ("c-b", &self.c_b), ("c", &self.c)];
        all(POSITIVE, "circuit", capacitors)?;
        let wanted = if self.kind == Kind::TwoCapacitor { "c-a and c-b" } else { "c" };
        let missing = format!("has to have {wanted}: {} is its kind", self.kind);
        demand(self.network().is_some(), "circuit", missing)?;
        let values: &[KeyedValue] =
            &[("v-dd", &self.v_dd), ("r-c1", &self.r_c1), ("r-c2", &self.r_c2), ("r-o", &self.r_o)];
        all(POSITIVE, "circuit", values)?;
        all(NOT_NEGATIVE, "circuit", &[("r-p", &self.r_p)])?;
        for (name, value) in &self.r_o_of {
            let otherwise = "is no line: charge-a, charge-b, c1, c2, x0 .. x15";
            demand(line_named(name).is_some(), format!("circuit.r-o-of.{name}"), otherwise)?;
            all(POSITIVE, "circuit.r-o-of", &[(name, value)])?;
        }
        self.absorption.check()?;
        self.threshold.check("circuit.threshold", self.v_dd)?;
        self.node_a.check("circuit.node-a", self.v_dd)?;
        self.node_b.check("circuit.node-b", self.v_dd)
    }
}

impl Scene {
    /// The first problem: its key, what is wrong, and what to do.
    pub(super) fn check(&self) -> Result<(), String> {
        self.circuit.check()?;
        let most = format!("there can be at most {MAX_CHANNELS}");
        demand(self.sensors.len() <= MAX_CHANNELS, "sensor", most)?;
        for (channel, sensor) in self.sensors.iter().enumerate() {
            sensor.check(&format!("sensor {channel}"))?;
        }
        self.check_clock()?;
        self.check_latencies()?;
        self.check_effects()
    }

    fn check_clock(&self) -> Result<(), String> {
        let Some(period) = self.clock_period else { return Ok(()) };
        let ns = period.0 * 1e9;
        let is_whole = (0.999..=LATEST * 1e9).contains(&ns) && (ns - ns.round()).abs() <= 1e-6;
        demand(is_whole, "clock-period", "has to be a whole number of nanoseconds, from 1 ns to 1 s")?;
        let is_alone =
            (self.calls.is_none() && self.stamps.is_none()) && (self.wake.is_none() && self.sleep.is_none());
        let otherwise = "excludes calls, stamps, wake and sleep: with a common clock nothing else is late";
        demand(is_alone, "clock-period", otherwise)
    }

    fn check_latencies(&self) -> Result<(), String> {
        for (key, delay) in [("stamps", self.stamps), ("wake", self.wake), ("sleep", self.sleep)] {
            if let Some(delay) = delay {
                all(LATE, key, &[("mean", &delay.mean), ("jitter", &delay.jitter)])?;
                tail(key, delay.tail_probability, delay.tail_mean)?;
            }
        }
        if let Some(calls) = &self.calls {
            all(LATE, "calls", &[("fixed", &calls.fixed), ("per-line", &calls.per_line)])?;
            all(SHARE, "calls", &[("jitter", &calls.jitter)])?;
            tail("calls", calls.tail_probability, calls.tail_mean)?;
            together("calls", "asleep-after and wakes-in", calls.asleep_after, calls.wakes_in)?;
            let values: &[KeyedValue] =
                &[("asleep-after", &calls.asleep_after), ("wakes-in", &calls.wakes_in)];
            all(POSITIVE, "calls", values)?;
            all(LATE, "calls", &values[1..])?;
            let is_ordered =
                calls.moves_at.is_none_or(|[from, to]| 0.0 <= from && from <= to && to <= LATEST_MOVE);
            let otherwise = format!("is [from, to] in slots, with 0 <= from <= to <= {LATEST_MOVE}");
            demand(is_ordered, "calls.moves-at", otherwise)?;
        }
        if let Some(TicksScene { every, takes }) = &self.ticks {
            all(POSITIVE, "ticks", &[("every", every), ("takes", takes)])?;
            all(LATE, "ticks", &[("every", every)])?;
            demand(every.0 >= 2.0 * takes.0, "ticks.takes", "has to be at most half of every")?;
        }
        let ReadsScene { clock, levels, arm } = &self.reads;
        all(LATE, "reads", &[("clock", clock), ("levels", levels), ("arm", arm)])
    }

    fn check_effects(&self) -> Result<(), String> {
        let events = self.events.unwrap_or_default();
        let is_kept = events.buffer.is_none_or(|buffer| (1..=MOST_EVENTS).contains(&buffer));
        demand(is_kept, "events.buffer", format!("the kernel allows 1 to {MOST_EVENTS} events"))?;
        all(PROBABILITY, "events", &[("lost", &events.lost), ("coalesced", &events.coalesced)])?;
        together("events", "coalesced and bounce", events.coalesced, events.bounce)?;
        all(POSITIVE, "events", &[("bounce", &events.bounce)])?;
        all(LATE, "events", &[("bounce", &events.bounce), ("b-later", &events.b_later)])?;
        let keys = "deep-sleep-after and deep-sleep-late";
        together("events", keys, events.deep_sleep_after, events.deep_sleep_late)?;
        let sleeps: &[KeyedValue] =
            &[("deep-sleep-after", &events.deep_sleep_after), ("deep-sleep-late", &events.deep_sleep_late)];
        all(POSITIVE, "events", sleeps)?;
        all(LATE, "events", &sleeps[1..])?;
        if let Some(NoiseScene { voltage, bandwidth }) = &self.noise {
            all(POSITIVE, "noise", &[("voltage", voltage), ("bandwidth", bandwidth)])?;
        }
        // Quantities are finite as they are read.
        let is_finite = self.drift.is_none_or(|drift| drift.c_per_minute.is_finite());
        demand(is_finite, "drift.c-per-minute", "has to be finite")?;
        all(POSITIVE, "walk", &[("r-o", &self.walk.map(|walk| walk.r_o))])
    }
}
