//! Which discharges a reading needs, in which order, and what each of them is planned to do.
//!
//! All channels share one pair of capacitors and one calibration. With a calibration of its own for each reading, a cycle
//! is
//!
//! ```text
//! R_1, R_2, [R_1 then R_2: split], x of channel 0, x of channel 1, ...
//! ```
//!
//! and in the very first one R_2 is held before x: is there a leak that is a defect? If it seems so, all this is done once more.
//!
//! With `offset = "auto"`, readings flow from the first cycle on, by full discharges (in whose equations d cancels);
//! switched ones begin when the offset is known. Split discharges go on in each cycle until what is not known of the
//! offset is a small part of a reading's variance; then one now and then keeps following it. With a tracked calibration,
//! cycles begin like that, too; once the state is known, a cycle has only those calibration discharges that pay, that ask
//! again what the last one contradicted, or whose kind has not been seen for long; each x discharge is the one that lowers
//! the variance of what is published most for its time (`choice`).

mod calibration;
mod calls;
mod choice;
mod falls;
mod look;
mod plan;
mod publish;
mod window;

use crate::circuit::Node;
use crate::estimate::Estimator;
use crate::estimate::absorption::AbsorptionTest;
use crate::estimate::estimator::Judged;
use crate::estimate::grid::Grid;
use crate::estimate::leak::LeakTest;
use crate::estimate::offset::{Offset, SplitCalibration};
use crate::instrument::diagnosis::Diagnosis;
use crate::instrument::discharge::{Outcome, Plan};
use crate::instrument::limits::{
    LEAKS_OF_A_LOOK, MOST_CALIBRATIONS, MOST_LONGER, MOST_OF_SENSOR, OVERHEAD_STEP, RETRIES, ROUNDS, WINDOW,
};
use crate::instrument::settings::Settings;
use crate::instrument::stats::Stats;
use crate::reading::{Branch, Fault, Measured, Reading, Status};
use crate::record::CalibrationKind;
use crate::record::{Record, Through};
use crate::units::Nanos;
use calls::CallGate;
use look::Look;
use plan::Memory;

/// The longest that the share of one reading in a cycle can take, whatever is connected: every discharge taken as often as it
/// may be, each of them drained, charged, waited for until its deadline, and finished through R_1 until another. What the
/// system takes beyond what was asked for, such as a preemption, is not in it, nor are the looks before the first one.
pub fn longest_reading(settings: &Settings) -> Nanos {
    let Settings { drain, charge, settle, deadline, .. } = *settings;
    let charge = charge.times(1.0 + MOST_LONGER);
    let discharge = drain + charge.anew.time().max(charge.to_a.time()) + settle + deadline + deadline;
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
    Calibrate(CalibrationKind, Node),
    /// R_2, held on its way or before it: looks for what is wrong with the circuit.
    Hold(Look),
    Sensor(usize),
}

/// Cycles of which the mean is published, where a period is longer than what means are taken over.
#[derive(Debug, Clone, Copy)]
struct Burst {
    began: Nanos,
    /// The cycle that has begun is the last one.
    is_ending: bool,
}

/// The order of discharges, and all that is learned from them.
#[derive(Debug, Clone)]
pub struct Cycle {
    settings: Settings,
    estimator: Estimator,
    split: Option<SplitCalibration>,
    memory: Vec<Memory>,
    calls: CallGate,
    /// What stamps tell of their clock.
    grid: Grid,
    leak: LeakTest,
    absorption: AbsorptionTest,
    diagnosis: Diagnosis,
    step: Step,
    retries: u32,
    /// Calibration discharges of this cycle, when the last one of each kind was, and the last one if it contradicted the state.
    calibrations: u32,
    calibrated_at: [Option<Nanos>; 3],
    doubted: Option<(CalibrationKind, Node)>,
    /// Readings since, and calibration discharges that the tracked state has had, as long as they are few.
    since_calibration: u32,
    young: u32,
    /// What the last discharge has told of a sensor.
    as_read_ohm: Option<Measured>,
    /// So many readings in a row show that something leaks.
    leaks_in_row: u32,
    /// When the last discharge was asked for, and what discharges take beside what is planned of them, ns.
    asked: Nanos,
    overhead_ns: f64,
    /// What goes before the last discharge by its plan.
    planned: Nanos,
    /// When B had its charger last, and whether that was before the last discharge.
    b_charged: Option<Nanos>,
    b_is_kept: bool,
    /// The last discharge ended before its time.
    ended_early: bool,
    /// Why this cycle has no calibration.
    failed: Option<Fault>,
    /// When the share of the next reading began, the cycle, and how long cycles take, ns.
    began: Nanos,
    cycle_began: Nanos,
    cycle_ns: f64,
    burst: Option<Burst>,
    /// Counts cycles or bursts of them, those included in which no channel was due.
    turn: u64,
    stats: Stats,
}

impl Cycle {
    /// A cycle that has learned nothing yet.
    pub fn new(settings: Settings) -> Cycle {
        let ([r1, r2], nodes, method) = (settings.r_ohm(), settings.nodes(), settings.method);
        let mut estimator = if settings.tracked {
            Estimator::tracked(method, r1, r2, nodes)
        } else {
            let offset = settings.offset_ns.map_or_else(Offset::unknown, Offset::given);
            Estimator::new(method, r1, r2, nodes, offset)
        };
        let leak = LeakTest::new(nodes, r2);
        estimator.set_resolution(settings.resolution.as_ns());
        estimator.set_leak(&leak);
        let finds_offset = !settings.tracked && settings.offset_ns.is_none();
        let split = finds_offset.then(|| SplitCalibration::new(r1, r2, nodes, WINDOW));
        Cycle {
            estimator,
            split,
            memory: vec![Memory::default(); settings.channels.len()],
            calls: CallGate::default(),
            grid: Grid::new(settings.resolution.as_ns()),
            leak,
            absorption: AbsorptionTest::default(),
            diagnosis: Diagnosis::new(settings.board()),
            step: Step::Start,
            retries: 0,
            calibrations: 0,
            calibrated_at: [None; 3],
            doubted: None,
            since_calibration: 0,
            young: 0,
            as_read_ohm: None,
            leaks_in_row: 0,
            asked: Nanos::ZERO,
            overhead_ns: 0.0,
            planned: Nanos::ZERO,
            b_charged: None,
            b_is_kept: false,
            ended_early: false,
            failed: None,
            began: Nanos::ZERO,
            cycle_began: Nanos::ZERO,
            cycle_ns: 1.0,
            burst: None,
            turn: 0,
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
        stats.absorbed = self.absorption.share();
        stats.late_after_waits_ns = self.estimator.awake().late_ns();
        stats.unlike_calls_ns = self.calls.unlike_ns();
        stats
    }

    /// What the last discharge has told of a sensor, with its sign, before zero and scale, ohm, with 1 sigma of what other readings
    /// share with it.
    pub fn as_read_ohm(&self) -> Option<Measured> {
        self.as_read_ohm
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

    /// Whether what is published is complete, so that there may be a rest before the next cycle.
    pub fn may_rest(&self) -> bool {
        self.is_at_start() && self.burst.is_none()
    }

    /// Whether the next discharge is held back, to look for what is wrong with the circuit.
    pub fn is_holding(&self) -> bool {
        matches!(self.step, Step::Hold(_))
    }

    /// Ends the cycle: every channel that has not been read gets this fault.
    pub fn fail(&mut self, fault: Fault) {
        self.failed = Some(fault);
        if fault == Fault::Pins {
            (self.ended_early, self.burst) = (true, None);
        }
        if !matches!(self.step, Step::Sensor(_)) {
            self.step = self.first_sensor();
        }
    }

    /// What to do next, `now` being the time.
    pub fn next(&mut self, now: Nanos) -> Next {
        self.asked = now;
        if self.step == Step::Start {
            (self.began, self.cycle_began) = (now, now);
            self.burst = self.goes_on(now);
            while self.next_sensor(0).is_none() {
                self.turn += 1;
            }
            self.calibrations = 0;
            self.estimator.advance(now);
            self.step = self.next_calibration(None);
        }
        let plan = match self.step {
            Step::Sensor(channel) => match self.failed {
                Some(fault) => match self.failing(channel, fault, now) {
                    Some(reading) => return Next::Report(reading),
                    None => return self.next(now),
                },
                None => self.sensor_plan(channel),
            },
            Step::Calibrate(kind, last) => self.calibration_plan(kind, last),
            Step::Hold(look) => self.held_plan(look),
            Step::Start => self.calibration_plan(CalibrationKind::First, self.settings.last()),
        };
        self.b_is_kept = plan.charge.together > Nanos::ZERO;
        if self.b_is_kept {
            self.b_charged = Some(now);
        }
        self.planned = plan.drain + plan.charge.time() + plan.settle;
        Next::Discharge(plan)
    }

    /// The burst that the cycle which begins now belongs to: this is its last one if it ends no earlier than the burst.
    fn goes_on(&self, now: Nanos) -> Option<Burst> {
        let (Some(average), Some(_)) = (self.settings.average, self.settings.period) else { return None };
        let began = self.burst.map_or(now, |burst| burst.began);
        Some(Burst { began, is_ending: now + Nanos(self.cycle_ns as i64) - began >= average })
    }

    /// Takes a discharge as a tape has it, whatever would be next here; answers a reading when it was a sensor's. One whose
    /// start is not known has nothing to do with those before it.
    pub fn replay(&mut self, record: &Record, is_timed: bool, is_held: bool) -> Option<Reading> {
        self.step = match (record.through.channel(), record.calibration_kind()) {
            (Some(channel), _) => Step::Sensor(channel),
            (None, kind) if is_held => Step::Hold(Look::of(record, kind)),
            (None, Some(kind)) => Step::Calibrate(kind, self.settings.last()),
            (None, None) => return None,
        };
        self.replay_as(record, is_timed, Ok(*record))
    }

    /// The same of a sensor's discharge that has come to nothing.
    pub fn replay_failed(&mut self, record: &Record, is_timed: bool, fault: Fault) -> Option<Reading> {
        self.step = Step::Sensor(record.through.channel()?);
        self.replay_as(record, is_timed, Err(fault))
    }

    fn replay_as(
        &mut self,
        record: &Record,
        is_timed: bool,
        result: Result<Record, Fault>,
    ) -> Option<Reading> {
        match record.through.channel() {
            _ if is_timed => self.estimator.advance(record.start),
            Some(channel) => self.memory[channel].motion.forget(),
            None => {}
        }
        self.failed = None;
        self.done(&Outcome { result, calls: [None; 3], charged: None }, record.start)
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

    /// The first sensor, but nothing is said of any before there has been a look for leaks.
    fn before_sensors(&self) -> Step {
        if self.may_look() && self.leak.is_wanting() { Step::Hold(Look::First) } else { self.first_sensor() }
    }

    fn may_look(&self) -> bool {
        self.failed.is_none() && self.estimator.calibration().is_some()
    }

    /// The next cycle, or before it, from time to time, a look for what is wrong: where no reading waits for it.
    fn after_sensors(&self, now: Nanos) -> Step {
        match self.may_look() {
            true if self.leaks_in_row >= LEAKS_OF_A_LOOK || self.leak.is_due(now) => Step::Hold(Look::Leak),
            true if self.absorption.is_due(now) => Step::Hold(Look::Absorption),
            _ => self.before_start(now),
        }
    }

    /// The next cycle, or before it a discharge in which the program wakes; a calibration that is followed has such ones of its own.
    fn before_start(&self, now: Nanos) -> Step {
        let may_wake = self.may_look() && self.estimator.tracker().is_none();
        let due = if may_wake { self.estimator.awake().due(now) } else { None };
        due.map_or(Step::Start, |resistor| Step::Hold(Look::Awake(resistor)))
    }

    /// Takes the outcome of the discharge that [`Cycle::next`] asked for, `now` being the time; answers a reading when
    /// it was a sensor's.
    pub fn done(&mut self, outcome: &Outcome, now: Nanos) -> Option<Reading> {
        self.learn_overhead(outcome, now);
        if let Some(resolution_ns) = outcome.result.as_ref().ok().and_then(|record| self.grid.take(record)) {
            self.estimator.set_resolution(resolution_ns);
        }
        let outcome = &self.without_leak(outcome);
        self.as_read_ohm = None;
        self.ended_early = outcome.result.map_or(true, |record| record.waited_ns.is_some());
        self.calls.add(&outcome.calls);
        match self.step {
            Step::Calibrate(CalibrationKind::Split, _) if !self.settings.tracked => self.split_done(outcome),
            Step::Calibrate(kind, last) => self.calibrated(kind, last, outcome),
            Step::Sensor(_) if outcome.result == Err(Fault::WideBracket) && self.retries < RETRIES => {
                // It says nothing about the sensor, and has cost little more than its charge.
                self.retries += 1;
                self.stats.retried += 1;
            }
            Step::Hold(look) => self.held_done(look, outcome, now),
            Step::Sensor(channel) => return self.sensor_done(channel, outcome, now),
            Step::Start => {}
        }
        None
    }

    /// What has become of a discharge, without what a leak that shows has done to it; looks for leaks have to see that.
    fn without_leak(&mut self, outcome: &Outcome) -> Outcome {
        let result = match self.step {
            Step::Hold(Look::Leak | Look::First) => outcome.result,
            _ => outcome.result.map(|record| self.estimator.without_leak(&record)),
        };
        Outcome { result, ..*outcome }
    }

    /// What a discharge takes beside what is planned of it: calls, waking, and the charge's own delays.
    fn learn_overhead(&mut self, outcome: &Outcome, now: Nanos) {
        let Ok(record) = outcome.result else { return };
        let Some(ended_ns) = record.crossings().into_iter().flatten().reduce(f64::max) else { return };
        let beside_ns = (now - self.asked - self.planned).as_ns() - ended_ns;
        self.overhead_ns += OVERHEAD_STEP * (beside_ns.max(0.0) - self.overhead_ns);
    }
}

#[cfg(test)]
mod tests;
