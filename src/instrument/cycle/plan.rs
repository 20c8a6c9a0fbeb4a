//! What the next discharge is planned to do: full or switched, and when; which calibration discharge pays.

use super::{Branch, CalibrationKind, Cycle, Estimator, Fault, Plan, Record, Status, Through};
use crate::estimate::Predicted;
use crate::estimate::law::{R_O, State};
use crate::estimate::limits::{LEAK_HELD_AT, LEAK_HOLD, SPLIT_FRACTION};
use crate::estimate::method::Switching;
use crate::estimate::motion::Motion;
use crate::estimate::scatter::expected_ns;
use crate::instrument::limits::{
    CALIBRATION_SHARE, HYSTERESIS, LONGEST_IDLE, OFFSET_SHARE, OUTLIERS_OF_DOUBT, SWITCH_FRACTIONS,
};
use crate::record::Switch;
use crate::sensor::Channel;
use crate::units::Nanos;

/// What is remembered of a channel for the plan of its next discharge.
#[derive(Debug, Clone, Copy, Default)]
pub struct Memory {
    /// The last resistance as it was measured, zero included; `None` after anything but a number.
    r_ohm: Option<f64>,
    inferred: bool,
    u_switch_ns: f64,
    /// Outliers in a row: the crossings contradict each other, or the calibration does them.
    outliers: u32,
    /// The last two readings in a row that were switched alike, ohm.
    switched_ohm: [Option<f64>; 2],
    /// How the sensor has changed lately.
    pub(super) motion: Motion,
    /// How the last estimate depends on the tracked state, and its variance but for that, ohm².
    dependence: Option<(State, f64)>,
}

impl Memory {
    /// Learns from a reading.
    pub fn take(
        &mut self,
        status: &Status,
        record: Option<Record>,
        sensor: &Channel,
        estimator: &mut Estimator,
    ) {
        if let Some(record) = record {
            self.u_switch_ns = expected_ns(&record);
        }
        if !matches!(status, Status::Ok { .. }) {
            self.switched_ohm = [None; 2];
        }
        let is_outlier = matches!(status, Status::Fault(Fault::LatencyOutlier | Fault::Unsettled));
        self.outliers = if is_outlier { self.outliers.saturating_add(1) } else { 0 };
        match status {
            Status::Ok { branch, r_ohm, is_moving, .. } => {
                self.inferred = *branch == Branch::Inferred;
                let as_read_ohm = sensor.as_read(r_ohm.value);
                self.r_ohm = Some(as_read_ohm);
                let switch = record.and_then(|record| record.switch).filter(|_| self.inferred);
                let predicted = estimator.predict_tracked(as_read_ohm, switch, self.u_switch_ns);
                self.dependence = predicted.zip(estimator.tracker()).map(|(predicted, tracker)| {
                    let part = tracker.variance(&predicted.by_state);
                    (predicted.by_state, (predicted.variance - part).max(0.0))
                });
                let is_steady = switch.is_some() && !is_moving;
                let switched = predicted.filter(|_| is_steady).map(|predicted| {
                    let steady = predicted.bound / predicted.by_switch.powi(2);
                    let u_ns = estimator.offset().scatter.u_ns(self.u_switch_ns);
                    (predicted.by_switch, (steady - u_ns * u_ns).max(0.0))
                });
                self.steadiness(r_ohm.value, switched, estimator);
            }
            // Where it is by now is known well enough for a plan.
            Status::Fault(Fault::Unsettled) => {
                self.r_ohm = self.motion.last_ohm().map(|r_ohm| r_ohm - estimator.offset().r_o());
            }
            // One spike says nothing about the sensor.
            Status::Fault(Fault::LatencyOutlier | Fault::WideBracket) => {}
            Status::Short { .. } | Status::Open { .. } | Status::Fault(_) => {
                (self.r_ohm, self.dependence) = (None, None);
            }
        }
    }
}

impl Memory {
    /// Lets the estimator know by how much the reading before this one was beside its neighbours; `switched`: what the instant
    /// of the switch does to it, ohm/ns, and its variance but for that, as a time, ns².
    fn steadiness(&mut self, r_ohm: f64, switched: Option<(f64, f64)>, estimator: &mut Estimator) {
        if let (Some((by_switch, steady)), [Some(first), Some(second)]) = (switched, self.switched_ohm) {
            // Its variance is 6 times that of a reading; a steady change is not in it.
            estimator.add_reading((first - 2.0 * second + r_ohm) / 6f64.sqrt() / by_switch, steady);
        }
        self.switched_ohm = [self.switched_ohm[1], switched.map(|_| r_ohm)];
    }
}

impl Cycle {
    pub(super) fn calibration_plan(&self, kind: CalibrationKind) -> Plan {
        let second = self.settings.second();
        let (through, switch) = match kind {
            CalibrationKind::First => (Through::C1, None),
            CalibrationKind::Second => (second, None),
            CalibrationKind::Split => (Through::C1, self.split_time().map(|after| (after, second))),
        };
        Plan { expected: self.expected(kind), ..self.plan(through, switch, None) }
    }

    /// When a plain calibration discharge crosses: as the last one did.
    fn expected(&self, kind: CalibrationKind) -> [Option<Nanos>; 2] {
        let of_kind = |(c1, c2)| match kind {
            CalibrationKind::First => Some(c1),
            CalibrationKind::Second => Some(c2),
            CalibrationKind::Split => None,
        };
        let crossings: Option<[f64; 2]> = self.estimator.calibration().and_then(of_kind);
        crossings.map_or([None; 2], |crossings| crossings.map(|ns| Some(Nanos(ns as i64))))
    }

    /// R_2 with a pause on the way, in which a leak would show.
    pub(super) fn held_plan(&self) -> Plan {
        let at = self.estimator.calibration().map(|(_, c2)| Nanos((LEAK_HELD_AT * c2[0]) as i64));
        let second = self.settings.second();
        Plan { hold: LEAK_HOLD, ..self.plan(second, at.map(|at| (at, second)), None) }
    }

    pub(super) fn sensor_plan(&self, channel: usize) -> Plan {
        let settings = &self.settings;
        let rules = settings.method.rules();
        let switch = match rules.switching {
            Switching::Never => None,
            Switching::AtFraction => self.switch_time(channel),
            Switching::WhereBest => self.best_switch(channel),
        };
        // A switch must not make a discharge longer than the deadline does.
        let switch = switch.filter(|after| *after < settings.deadline);
        let is_limited = rules.switching == Switching::WhereBest && self.estimator.tracker().is_some();
        let limit = is_limited.then_some(Through::C1);
        self.plan(rules.sensor(channel), switch.map(|after| (after, settings.second())), limit)
    }

    fn plan(&self, through: Through, switch: Option<(Nanos, Through)>, limit: Option<Through>) -> Plan {
        let settings = &self.settings;
        Plan {
            through,
            switch,
            hold: Nanos::ZERO,
            limit,
            chargers: settings.chargers(),
            last: settings.last(),
            drain: if self.ended_early { settings.drain } else { Nanos::ZERO },
            charge: settings.charge,
            settle: settings.settle,
            expected: [None; 2],
            timeout: settings.deadline,
            widest_bracket: self.calls.widest(through.drives().count()),
            single_call: self.calls.single(),
        }
    }

    /// Before A crosses, however large d is: by the difference of crossings, in which d cancels, and without Ro, which would
    /// make it later.
    fn split_time(&self) -> Option<Nanos> {
        let (c1, c2) = self.estimator.calibration()?;
        let [r1, r2] = self.settings.r_ohm();
        Some(Nanos((SPLIT_FRACTION * (c2[0] - c1[0]) / (r2 - r1) * r1) as i64))
    }

    /// When to switch from the sensor to R_2, if the next x discharge of a channel is to be switched at all.
    fn switch_time(&self, channel: usize) -> Option<Nanos> {
        if !self.offset_is_known() {
            return None;
        }
        let (settings, memory) = (&self.settings, &self.memory[channel]);
        let (x_ns, predicted) = self.predicted(channel)?;
        let d_ns = self.estimator.offset().d_ns;
        let wanted = match settings.t_l {
            Some(t_l) => x_ns - d_ns < t_l.as_ns(),
            None => predicted.is_some_and(|Predicted { direct, inferred, .. }| {
                prefers_inferred(memory.inferred, direct, inferred)
            }),
        };
        let after = settings.switch_fraction * (self.estimator.x_discharge_ns(x_ns, 0)? - d_ns);
        (wanted && after >= 1.0).then_some(Nanos(after as i64))
    }

    /// When A is expected to cross in the next x discharge of a channel, and how well either branch would tell R_x.
    fn predicted(&self, channel: usize) -> Option<(f64, Option<Predicted>)> {
        let memory = &self.memory[channel];
        let [r1, r2] = self.settings.r_ohm();
        let ratio = (memory.r_ohm? - r1) / (r2 - r1);
        let (c1, c2) = self.estimator.calibration()?;
        let x_ns = c1[0] + ratio * (c2[0] - c1[0]);
        Some((x_ns, self.estimator.predict(ratio, self.settings.switch_fraction, memory.u_switch_ns)))
    }

    /// Whether a reading that is switched, or would be if the offset were known exactly, owes more than a set share of its
    /// variance to the offset.
    pub(super) fn offset_is_poor(&self) -> bool {
        let d_ns = self.estimator.offset().d_ns;
        (0..self.memory.len()).filter_map(|channel| self.predicted(channel)).any(|(x_ns, predicted)| {
            let Some(Predicted { direct, inferred, by_offset }) = predicted else { return false };
            let wanted = match self.settings.t_l {
                Some(t_l) => x_ns - d_ns < t_l.as_ns(),
                None => inferred - by_offset < direct,
            };
            wanted && by_offset > OFFSET_SHARE * inferred
        })
    }

    /// The switch that promises the least variance; `None` if a full discharge does.
    fn best_switch(&self, channel: usize) -> Option<Nanos> {
        let memory = &self.memory[channel];
        let (r_ohm, tracker) = (memory.r_ohm?, self.estimator.tracker()?);
        let last = self.settings.nodes() - 1;
        let full_ns = tracker.state()[last] * (r_ohm + tracker.state()[R_O]);
        let deadline_ns = self.settings.deadline.as_ns();
        let limit = Switch { at_ns: deadline_ns, on_ns: deadline_ns, to: Through::C1 };
        let limit = (full_ns > deadline_ns).then_some(limit);
        let full = self.estimator.predict_tracked(r_ohm, limit, memory.u_switch_ns)?.variance;
        let at = |fraction: f64| {
            let at_ns = fraction * full_ns.min(deadline_ns);
            let switch = Switch { at_ns, on_ns: at_ns, to: self.settings.second() };
            Some((at_ns, self.estimator.predict_tracked(r_ohm, Some(switch), memory.u_switch_ns)?.variance))
        };
        let (at_ns, inferred) =
            SWITCH_FRACTIONS.into_iter().filter_map(at).min_by(|a, b| a.1.total_cmp(&b.1))?;
        (prefers_inferred(memory.inferred, full, inferred) && at_ns >= 1.0).then_some(Nanos(at_ns as i64))
    }

    /// The calibration discharge that lowers the variance most for its time, if any pays.
    pub(super) fn wanted(&self) -> Option<CalibrationKind> {
        let tracker = self.estimator.tracker()?;
        let share = |(by_state, rest): &(State, f64)| {
            let part = tracker.variance(by_state);
            part / (part + rest)
        };
        let worst = self
            .memory
            .iter()
            .filter_map(|memory| memory.dependence)
            .max_by(|a, b| share(a).total_cmp(&share(b)));
        let (by_state, is_due) = match worst {
            Some(worst) => (worst.0, share(&worst) > CALIBRATION_SHARE),
            None => (self.estimator.predict_tracked(self.settings.r_ohm()[0], None, 0.0)?.by_state, false),
        };
        let is_doubted =
            tracker.is_doubted() || self.memory.iter().any(|memory| memory.outliers >= OUTLIERS_OF_DOUBT);
        if !is_due && !is_doubted && self.idle_cycles < LONGEST_IDLE {
            return None;
        }
        let value = |kind: CalibrationKind| {
            let route = tracker.planned(kind);
            let discharge_ns = route.crossing(tracker.state(), self.settings.nodes() - 1).ns;
            let cost_ns = (self.settings.charge + self.settings.settle).as_ns() + discharge_ns;
            tracker.benefit(kind, &by_state).unwrap_or(0.0) / cost_ns
        };
        CalibrationKind::ALL.into_iter().max_by(|a, b| value(*a).total_cmp(&value(*b)))
    }
}

fn prefers_inferred(in_use: bool, direct: f64, inferred: f64) -> bool {
    if in_use { HYSTERESIS * inferred < direct } else { inferred < HYSTERESIS * direct }
}
