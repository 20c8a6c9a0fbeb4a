//! What the readings of a channel come to: how often they came, how well they are known, and what else they were.

use super::{ReadingLine, StatusName, Unit};
use crate::reading::{Reading, Status};
use crate::stream::line::{is_unknown, time, uncertainty};
use serde::{Deserialize, Serialize};

/// What the readings of a channel came to, over the last seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ChannelStats {
    /// From the first of them to the last, s.
    #[serde(serialize_with = "time")]
    pub span_s: f64,
    /// Of every status.
    pub readings: u64,
    /// In a second; absent: there are not two.
    #[serde(serialize_with = "time", skip_serializing_if = "is_unknown")]
    pub rate_hz: Option<f64>,
    /// Root mean square of `r_u_ohm` of the numbers that are neither moving nor settling, ohm.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub r_u_ohm: Option<f64>,
    /// The same of `f_u_n`, newton.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub f_u_n: Option<f64>,
    /// The same of `value_u` of a channel with a law, in its unit.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub value_u: Option<f64>,
    /// Numbers.
    pub ok: u64,
    /// Those of a sensor that changed while it was read.
    pub moving: u64,
    /// Those whose uncertainty was still a prior.
    pub settling: u64,
    /// Above what the deadline resolves.
    pub open: u64,
    /// Not to be told from a short circuit.
    pub short: u64,
    /// Without a number for another reason.
    pub faults: u64,
}

/// Counts readings of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadingTally {
    counts: ChannelStats,
    /// The first and the last instant, ns.
    span_ns: Option<[i64; 2]>,
    /// Of ohm, newton and what a law gives.
    squares: [SquareSum; 3],
}

/// A sum of squares, and of how many.
#[derive(Debug, Clone, Copy, Default)]
struct SquareSum(f64, u64);

impl SquareSum {
    fn add(&mut self, value: Option<f64>) {
        if let Some(value) = value {
            *self = SquareSum(self.0 + value * value, self.1 + 1);
        }
    }

    fn rms(self) -> Option<f64> {
        (self.1 > 0).then(|| (self.0 / self.1 as f64).sqrt())
    }
}

impl ReadingTally {
    /// One more, as the instrument says it, of a channel that measures in this unit.
    pub fn add(&mut self, reading: &Reading, unit: &Unit) {
        match reading.status {
            Status::Ok { r_ohm, shown, is_moving, is_settling, .. } => {
                let u = shown.and_then(|shown| shown.u);
                let (f_u_n, value_u) = if *unit == Unit::Newton { (u, None) } else { (None, u) };
                self.number([r_ohm.u, f_u_n, value_u], is_moving, is_settling);
            }
            Status::Open { .. } => self.counts.open += 1,
            Status::Short { .. } => self.counts.short += 1,
            Status::Fault(_) => self.counts.faults += 1,
        }
        self.stamp(reading.at.0);
    }

    /// One more, as a line of the stream says it.
    pub fn add_line(&mut self, reading: &ReadingLine) {
        let state = &reading.state;
        match state.status {
            StatusName::Ok => {
                // What is no law's is one of the other two.
                let of_law = state.value_u.filter(|_| !matches!(state.unit.as_deref(), Some("N" | "ohm")));
                self.number([state.r_u_ohm, state.f_u_n, of_law], state.moving, state.settling);
            }
            StatusName::Open => self.counts.open += 1,
            StatusName::Short => self.counts.short += 1,
            StatusName::Fault => self.counts.faults += 1,
        }
        self.stamp(reading.t_mono_ns);
    }

    fn number(&mut self, u: [Option<f64>; 3], is_moving: bool, is_settling: bool) {
        self.counts.ok += 1;
        self.counts.moving += u64::from(is_moving);
        self.counts.settling += u64::from(is_settling);
        if !is_moving && !is_settling {
            self.squares.iter_mut().zip(u).for_each(|(squares, u)| squares.add(u));
        }
    }

    fn stamp(&mut self, at_ns: i64) {
        self.counts.readings += 1;
        self.span_ns.get_or_insert([at_ns; 2])[1] = at_ns;
    }

    /// From the first to the last, s.
    pub fn span_s(&self) -> f64 {
        self.span_ns.map_or(0.0, |[first, last]| last.saturating_sub(first) as f64 * 1e-9)
    }

    /// What they come to.
    pub fn stats(&self) -> ChannelStats {
        let (span_s, intervals) = (self.span_s(), self.counts.readings.saturating_sub(1));
        let [r_u_ohm, f_u_n, value_u] = self.squares.map(SquareSum::rms);
        let rate_hz = (span_s > 0.0).then(|| intervals as f64 / span_s);
        ChannelStats { span_s, rate_hz, r_u_ohm, f_u_n, value_u, ..self.counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::{Branch, Fault, Measured, Method};
    use crate::units::Nanos;

    #[test]
    fn a_line_counts_as_its_reading_does() {
        [Unit::Newton, Unit::named("degC")].into_iter().for_each(counts_alike);
    }

    fn counts_alike(unit: Unit) {
        let ok = |u, is_moving| Status::Ok {
            branch: Branch::Direct,
            r_ohm: Measured { value: 1000.0, u: Some(u) },
            shown: Some(Measured { value: 13.0, u: Some(u / 100.0) }.into()),
            is_moving,
            is_settling: false,
        };
        let open = Status::Open { r_min_ohm: 6e4, shown: None };
        let statuses = [ok(3.0, false), ok(4.0, false), ok(90.0, true), open, Status::Fault(Fault::Pins)];
        let (mut own, mut of_lines) = (ReadingTally::default(), ReadingTally::default());
        for (at, status) in (0..).zip(statuses) {
            let reading = Reading {
                channel: 0,
                seq: 1,
                at: Nanos(at * 250_000_000),
                status,
                suspect: None,
                method: Method::Tracked,
                duration: Nanos::ZERO,
            };
            own.add(&reading, &unit);
            of_lines.add_line(&ReadingLine::new(&reading, "thumb", &unit, String::new()));
        }
        let rms = (12.5f64).sqrt();
        let (f_u_n, value_u) = match unit {
            Unit::Newton => (Some(rms / 100.0), None),
            _ => (None, Some(rms / 100.0)),
        };
        let wanted = ChannelStats {
            span_s: 1.0,
            readings: 5,
            rate_hz: Some(4.0),
            r_u_ohm: Some(rms),
            f_u_n,
            value_u,
            ok: 3,
            moving: 1,
            open: 1,
            faults: 1,
            ..ChannelStats::default()
        };
        let close = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() < 1e-12,
            (a, b) => a == b,
        };
        for stats in [own.stats(), of_lines.stats()] {
            assert!(close(stats.r_u_ohm, wanted.r_u_ohm), "{stats:?}");
            assert!(close(stats.f_u_n, wanted.f_u_n) && close(stats.value_u, wanted.value_u), "{stats:?}");
            assert_eq!(ChannelStats { r_u_ohm: wanted.r_u_ohm, f_u_n, value_u, ..stats }, wanted);
        }
        assert_eq!(ReadingTally::default().stats(), ChannelStats::default());
    }
}
