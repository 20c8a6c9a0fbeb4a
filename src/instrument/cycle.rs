//! Which discharges a reading needs, in which order, and what each of them is planned to do.
//!
//! All channels share one pair of capacitors and one calibration. With a calibration of its own for each reading, a cycle
//! is
//!
//! ```text
//! R_1, R_2, [R_1 then R_2: split], x of channel 0, x of channel 1, ...
//! ```
//!
//! With `offset = "auto"`, readings flow from the first cycle on, by full discharges (in whose equations d cancels);
//! switched ones begin when the offset is known. Split discharges go on in each cycle until what is not known of the
//! offset is a small part of a reading's variance; then one now and then keeps following it. With a tracked calibration,
//! cycles begin like that, too; once the state is known, a cycle has only those calibration discharges that pay.

mod calls;
mod plan;

use crate::estimate::Estimator;
use crate::estimate::leak::LeakTest;
use crate::estimate::limits::UNKNOWN_JITTER_NS;
use crate::estimate::offset::{Offset, SplitCalibration};
use crate::instrument::diagnosis::Diagnosis;
use crate::instrument::discharge::{Outcome, Plan};
use crate::instrument::limits::{
    CALIBRATIONS_PER_CYCLE, FOLLOW_EVERY, MOST_CALIBRATIONS, MOST_OF_SENSOR, RETRIES, ROUNDS, WINDOW,
};
use crate::instrument::settings::Settings;
use crate::instrument::stats::Stats;
use crate::reading::{Branch, Fault, Reading, Status};
use crate::record::CalibrationKind;
use crate::record::{Record, Through};
use crate::units::Nanos;
use calls::CallGate;
use plan::Memory;

/// The longest that the share of one reading in a cycle can take, whatever is connected: every discharge taken as often as it
/// may be, each of them drained, charged, waited for until its deadline, and finished through R_1 until another. What the
/// system takes beyond what was asked for, such as a preemption, is not in it.
pub fn longest_reading(settings: &Settings) -> Nanos {
    let Settings { drain, charge, settle, deadline, .. } = *settings;
    let discharge = drain + charge + settle + deadline + deadline;
    Nanos(discharge.0 * i64::from(MOST_CALIBRATIONS + MOST_OF_SENSOR))
}

/// What is to be done next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Next {
    /// Take this discharge and hand its outcome to [`Cycle::done`].
    Discharge(Plan),
    /// This reading is known without a discharge.
    Report(Reading),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Start,
    Calibrate(CalibrationKind),
    /// R_2, held on its way: looks for a leak.
    Hold,
    Sensor(usize),
}

/// The order of discharges, and all that is learned from them.
#[derive(Debug, Clone)]
pub struct Cycle {
    settings: Settings,
    estimator: Estimator,
    split: Option<SplitCalibration>,
    memory: Vec<Memory>,
    calls: CallGate,
    leak: LeakTest,
    diagnosis: Diagnosis,
    step: Step,
    retries: u32,
    /// Calibration discharges of this cycle, and cycles since the last one.
    calibrations: u32,
    idle_cycles: u32,
    /// The last discharge ended before its time.
    ended_early: bool,
    /// Why this cycle has no calibration.
    failed: Option<Fault>,
    /// When the share of the next reading began.
    began: Nanos,
    stats: Stats,
}

impl Cycle {
    /// A cycle that has learned nothing yet.
    pub fn new(settings: Settings) -> Cycle {
        let ([r1, r2], nodes, method) = (settings.r_ohm(), settings.nodes(), settings.method);
        let estimator = if settings.tracked {
            Estimator::tracked(method, r1, r2, nodes)
        } else {
            Estimator::new(method, r1, r2, nodes, Offset::given(settings.offset_ns.unwrap_or(0.0)))
        };
        let (leak, mut estimator) =
            (LeakTest::default(), estimator.with_resolution(settings.resolution.as_ns()));
        estimator.set_leak(&leak);
        let finds_offset = !settings.tracked && settings.offset_ns.is_none();
        let split = finds_offset.then(|| SplitCalibration::new(r1, r2, nodes, WINDOW));
        Cycle {
            estimator,
            split,
            memory: vec![Memory::default(); settings.channels.len()],
            calls: CallGate::default(),
            leak,
            diagnosis: Diagnosis::new(settings.board()),
            step: Step::Start,
            retries: 0,
            calibrations: 0,
            idle_cycles: 0,
            ended_early: false,
            failed: None,
            began: Nanos::ZERO,
            stats: Stats::default(),
            settings,
        }
    }

    /// What has been learned and counted so far.
    pub fn stats(&self) -> Stats {
        let mut stats = self.stats;
        stats.offset = self.estimator.offset();
        stats.offset_is_known = self.offset_is_known();
        stats.leak_siemens = self.leak.siemens();
        stats.tracking = self.estimator.tracker().map(|tracker| tracker.counts());
        stats
    }

    /// The estimator, with the calibration in force.
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Whether switched readings have what they need: the offset, or the tracked state.
    pub fn offset_is_known(&self) -> bool {
        if self.settings.tracked {
            return self.estimator.tracker().is_some();
        }
        self.split.as_ref().is_none_or(|split| split.taken() >= ROUNDS)
    }

    /// Whether a cycle is about to begin.
    pub fn is_at_start(&self) -> bool {
        self.step == Step::Start
    }

    /// Whether the next discharge is held back, to look for a leak.
    pub fn is_holding(&self) -> bool {
        self.step == Step::Hold
    }

    /// Ends the cycle: every channel that has not been read gets this fault.
    pub fn fail(&mut self, fault: Fault) {
        self.failed = Some(fault);
        self.ended_early |= fault == Fault::Pins;
        if !matches!(self.step, Step::Sensor(_)) {
            self.step = Step::Sensor(0);
        }
    }

    /// What to do next, `now` being the time.
    pub fn next(&mut self, now: Nanos) -> Next {
        if self.step == Step::Start {
            self.began = now;
            self.calibrations = 0;
            self.estimator.advance(now);
            self.step = self.next_calibration(None);
        }
        match self.step {
            Step::Sensor(channel) => match self.failed {
                Some(fault) => Next::Report(self.report(channel, Status::Fault(fault), now, now)),
                None => Next::Discharge(self.sensor_plan(channel)),
            },
            Step::Calibrate(kind) => Next::Discharge(self.calibration_plan(kind)),
            Step::Hold => Next::Discharge(self.held_plan()),
            Step::Start => Next::Discharge(self.calibration_plan(CalibrationKind::First)),
        }
    }

    /// Takes a discharge as a tape has it, whatever would be next here; answers a reading when it was a sensor's. One whose
    /// start is not known has nothing to do with those before it.
    pub fn replay(&mut self, record: &Record, is_timed: bool, is_held: bool) -> Option<Reading> {
        self.step = match (record.through.channel(), record.calibration_kind()) {
            (Some(channel), _) => Step::Sensor(channel),
            (None, _) if is_held => Step::Hold,
            (None, Some(kind)) => Step::Calibrate(kind),
            (None, None) => return None,
        };
        match record.through.channel() {
            _ if is_timed => self.estimator.advance(record.start),
            Some(channel) => self.memory[channel].motion.forget(),
            None => {}
        }
        self.failed = None;
        self.done(&Outcome { result: Ok(*record), start_call: None, charged: None }, record.start)
    }

    /// Leaves leaks out of what is said, until a discharge that was held tells of them: for tapes that have none.
    pub fn ignore_leaks(&mut self) {
        self.estimator.ignore_leaks();
    }

    /// Puts another offset in force, one that is known from elsewhere.
    pub fn set_offset(&mut self, offset: Offset) {
        self.estimator.set_offset(offset);
    }

    /// Puts the offset in force, however few split discharges have told it; whether there is one.
    pub fn settle_offset(&mut self) -> bool {
        let found = self.split.as_mut().and_then(SplitCalibration::result);
        if let Some(offset) = found {
            self.estimator.set_offset(offset);
        }
        found.is_some()
    }

    /// The calibration discharge that follows `last` in this cycle, or the first sensor.
    fn next_calibration(&self, last: Option<CalibrationKind>) -> Step {
        let next = if self.estimator.tracker().is_some() {
            let may = self.calibrations < CALIBRATIONS_PER_CYCLE;
            self.wanted().filter(|_| may)
        } else {
            match last {
                None => Some(CalibrationKind::First),
                Some(CalibrationKind::First) => Some(CalibrationKind::Second),
                Some(CalibrationKind::Second) if self.is_split_due() => Some(CalibrationKind::Split),
                Some(CalibrationKind::Second | CalibrationKind::Split) => None,
            }
        };
        next.map_or(Step::Sensor(0), Step::Calibrate)
    }

    /// The next cycle, or before it, from time to time, the look for a leak: where no reading waits for it.
    fn after_sensors(&mut self, now: Nanos) -> Step {
        let may = self.failed.is_none() && self.estimator.calibration().is_some();
        if may && self.leak.is_due(now) { Step::Hold } else { Step::Start }
    }

    fn is_split_due(&self) -> bool {
        if self.settings.tracked {
            return true;
        }
        let Some(split) = &self.split else { return false };
        let may_improve = split.taken() < WINDOW;
        may_improve && (!self.offset_is_known() || self.offset_is_poor())
            || self.stats.cycles % FOLLOW_EVERY == 0
    }

    /// Takes the outcome of the discharge that [`Cycle::next`] asked for, `now` being the time; answers a reading when
    /// it was a sensor's.
    pub fn done(&mut self, outcome: &Outcome, now: Nanos) -> Option<Reading> {
        self.ended_early = outcome.result.map_or(true, |record| record.waited_ns.is_some());
        let is_plain = matches!(self.step, Step::Calibrate(CalibrationKind::First | CalibrationKind::Second));
        if let (true, Some(call)) = (is_plain, outcome.start_call) {
            self.calls.add(call);
        }
        match self.step {
            Step::Calibrate(CalibrationKind::Split) if !self.settings.tracked => self.split_done(outcome),
            Step::Calibrate(kind) => self.calibrated(kind, outcome),
            Step::Sensor(_) if outcome.result == Err(Fault::WideBracket) && self.retries < RETRIES => {
                // It says nothing about the sensor, and has cost little more than its charge.
                self.retries += 1;
                self.stats.retried += 1;
            }
            Step::Hold => self.held_done(outcome, now),
            Step::Sensor(channel) => return Some(self.sensor_done(channel, outcome, now)),
            Step::Start => {}
        }
        None
    }

    fn calibrated(&mut self, kind: CalibrationKind, outcome: &Outcome) {
        self.diagnosis.take(kind, outcome);
        if self.failed.is_none() {
            self.calibrate(kind, outcome);
        }
        // Lost already; the plain discharges tell whether it is a resistor's wire or a node.
        self.step = match (self.failed, kind) {
            (Some(Fault::NoCalibration), CalibrationKind::Split) => Step::Calibrate(CalibrationKind::First),
            (Some(Fault::NoCalibration), CalibrationKind::First) => Step::Calibrate(CalibrationKind::Second),
            (Some(_), _) => Step::Sensor(0),
            (None, _) => self.step,
        };
    }

    fn calibrate(&mut self, kind: CalibrationKind, outcome: &Outcome) {
        let tracks = self.estimator.tracker().is_some();
        let result = outcome.result.and_then(|record| self.estimator.calibrate(&record));
        let is_spike = result == Err(Fault::LatencyOutlier);
        // A tracked calibration can do without one of its discharges, and knows what it does not know.
        // After a step there is no tracked calibration any more: this cycle's readings have none at all.
        let is_step = result == Err(Fault::CalibrationStep);
        if is_step {
            self.fail(Fault::CalibrationStep);
            return;
        }
        if result.is_ok() || (is_spike && tracks) || (kind == CalibrationKind::Split && !tracks) {
            self.retries = 0;
            self.calibrations += 1;
            self.idle_cycles = 0;
            self.step = self.next_calibration(Some(kind));
            return;
        }
        self.stats.retried += 1;
        self.retries += 1;
        if self.retries > RETRIES {
            self.fail(result.err().unwrap_or(Fault::NoCalibration));
        }
    }

    /// A split discharge that came to nothing costs one round, not the cycle.
    fn split_done(&mut self, outcome: &Outcome) {
        self.step = Step::Sensor(0);
        let (Some(split), Some((c1, c2))) = (&mut self.split, self.estimator.calibration()) else { return };
        let Ok(record) = &outcome.result else { return };
        let before = split.taken();
        split.add(c1, c2, record, self.estimator.noise());
        if split.taken() != before && split.taken() >= ROUNDS {
            if let Some(offset) = split.result() {
                self.estimator.set_offset(offset);
            }
        }
    }

    /// Shorter than an ordinary discharge through R_2 by what has leaked away meanwhile. One that came to nothing tells
    /// nothing.
    fn held_done(&mut self, outcome: &Outcome, now: Nanos) {
        self.step = Step::Start;
        let usual = self.estimator.calibration().map(|(_, c2)| c2);
        let lost = outcome.result.ok().zip(usual).and_then(|(record, usual)| {
            let switch = record.switch?;
            let held_ns = switch.on_ns - switch.at_ns;
            // The two discharges have their own noise each.
            let noise = self.estimator.noise().covariance(usual);
            let variance = 2.0 * noise.map_or(UNKNOWN_JITTER_NS * UNKNOWN_JITTER_NS, |noise| noise.aa);
            Some((usual[0] + held_ns - record.a_ns?, variance))
        });
        self.leak.add(lost, self.settings.r_ohm()[1], now);
        self.estimator.set_leak(&self.leak);
        if self.leak.has_changed() {
            self.estimator.begin_anew();
        }
    }

    fn sensor_done(&mut self, channel: usize, outcome: &Outcome, now: Nanos) -> Reading {
        self.diagnosis.take_sensor(outcome);
        let (sensor, memory) = (&self.settings.channels[channel], &mut self.memory[channel]);
        let (status, at) = match &outcome.result {
            Ok(record) => {
                let (status, at_ns) = self.estimator.status_in_motion(record, sensor, &mut memory.motion);
                (status, record.start + Nanos(at_ns as i64))
            }
            Err(fault) => (Status::Fault(*fault), now),
        };
        memory.take(&status, outcome.result.ok(), sensor, &mut self.estimator);
        self.report(channel, status, at, now)
    }

    fn report(&mut self, channel: usize, status: Status, at: Nanos, now: Nanos) -> Reading {
        self.stats.count(&status);
        let suspect = match status {
            Status::Fault(fault) => self.diagnosis.suspect(fault),
            _ => None,
        };
        if suspect.is_some() || !matches!(status, Status::Fault(_)) {
            self.stats.suspect = suspect;
        }
        let reading = Reading {
            channel,
            seq: self.stats.readings,
            at,
            status,
            suspect,
            method: self.settings.method,
            duration: now - self.began,
        };
        self.began = now;
        self.step = Step::Sensor(channel + 1);
        self.retries = 0;
        if channel + 1 == self.settings.channels.len() {
            self.step = self.after_sensors(now);
            self.failed = None;
            self.stats.cycles += 1;
            self.idle_cycles = self.idle_cycles.saturating_add(1);
        }
        reading
    }
}

#[cfg(test)]
mod tests;
