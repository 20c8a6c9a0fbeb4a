//! Which discharges a reading needs, in which order, and what each of them is planned to do.
//!
//! For: the calibration discharges, the split one while the offset is being found, one x discharge per channel, and
//! the choice between a full and a switched one. Must not know: pins, clocks, clients.
//!
//! All channels share one pair of calibration discharges per cycle:
//!
//! ```text
//! R_1, R_2, [R_1 then R_2: split], x of channel 0, x of channel 1, ...
//! ```
//!
//! With `offset = "auto"`, readings flow from the first cycle on, by full discharges (in whose equations d cancels);
//! switched ones begin when the offset is known. From then on, a split discharge now and then keeps following it.

use crate::discharge::{Forecast, Outcome, Plan};
use crate::estimate::Estimator;
use crate::offset::{Offset, SplitCalibration};
use crate::reading::{Branch, Fault, Method, Reading, Status};
use crate::record::{Record, Through};
use crate::settings::{OffsetSource, Settings};
use crate::stats::Stats;
use crate::units::Nanos;

/// A calibration discharge that came to nothing is taken again so many times.
const RETRIES: u32 = 2;
/// Rounds of split calibration after which the offset is put in force, and again after each so many further ones.
const ROUNDS: usize = 64;
/// Rounds that the offset is the mean of, when there have been that many.
const WINDOW: usize = 8 * ROUNDS;
/// Once the offset is known, one cycle in so many has a split discharge.
const FOLLOW_EVERY: u64 = 8;
/// A switched discharge must promise so much less variance than the branch in use, or the branch stays: no chatter.
const HYSTERESIS: f64 = 0.8;

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
    First,
    Second,
    Split,
    Sensor(usize),
}

/// What is remembered of a channel for the plan of its next discharge.
#[derive(Debug, Clone, Copy, Default)]
struct Memory {
    /// The last ratio; `None` after anything but a number.
    ratio: Option<f64>,
    inferred: bool,
    u_switch_ns: f64,
}

/// The order of discharges, and all that is learned from them.
#[derive(Debug, Clone)]
pub struct Cycle {
    settings: Settings,
    estimator: Estimator,
    split: Option<SplitCalibration>,
    memory: Vec<Memory>,
    calls: CallGate,
    step: Step,
    retries: u32,
    /// Why this cycle has no calibration.
    failed: Option<Fault>,
    /// When the share of the next reading began.
    began: Nanos,
    stats: Stats,
}

impl Cycle {
    /// A cycle that has learned nothing yet.
    pub fn new(settings: Settings) -> Cycle {
        let [r1, r2] = settings.r_ohm;
        let (offset, split) = match settings.offset {
            OffsetSource::Given(d_ns) => (Offset::given(d_ns), None),
            OffsetSource::Auto => {
                (Offset::default(), Some(SplitCalibration::new(r1, r2, settings.nodes(), WINDOW)))
            }
        };
        Cycle {
            estimator: Estimator::new(settings.method, r1, r2, settings.nodes(), offset),
            split,
            memory: vec![Memory::default(); settings.channels.len()],
            calls: CallGate::default(),
            step: Step::First,
            retries: 0,
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
        stats
    }

    /// The estimator, with the calibration in force.
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    fn offset_is_known(&self) -> bool {
        self.split.as_ref().is_none_or(|split| split.taken() >= ROUNDS)
    }

    /// Whether a cycle is about to begin.
    pub fn is_at_start(&self) -> bool {
        self.step == Step::First && self.retries == 0
    }

    /// Ends the cycle: every channel that has not been read gets this fault.
    pub fn fail(&mut self, fault: Fault) {
        self.failed = Some(fault);
        if !matches!(self.step, Step::Sensor(_)) {
            self.step = Step::Sensor(0);
        }
    }

    /// What to do next, `now` being the time.
    pub fn next(&mut self, now: Nanos) -> Next {
        if self.is_at_start() {
            self.began = now;
        }
        if let (Step::Sensor(channel), Some(fault)) = (self.step, self.failed) {
            return Next::Report(self.report(channel, Status::Fault(fault), now, now));
        }
        Next::Discharge(self.plan())
    }

    fn plan(&self) -> Plan {
        let settings = &self.settings;
        let (through, switch) = match self.step {
            Step::First => (Through::C1, None),
            Step::Second => (settings.second(), None),
            Step::Split => (Through::C1, self.split_time().map(|after| (after, settings.second()))),
            Step::Sensor(channel) => {
                (settings.sensor(channel), self.switch_time(channel).map(|after| (after, settings.second())))
            }
        };
        Plan {
            through,
            switch,
            chargers: settings.chargers,
            last: settings.last,
            charge: settings.charge,
            settle: settings.settle,
            forecast: self.forecast(),
            timeout: settings.deadline,
            widest_bracket: self.calls.widest(),
            single_call: self.calls.single(),
        }
    }

    fn forecast(&self) -> Option<Forecast> {
        let ratio = match self.step {
            Step::First | Step::Split => 0.0,
            Step::Second => 1.0,
            Step::Sensor(channel) => self.memory[channel].ratio?,
        };
        let (c1, c2) = self.estimator.calibration()?;
        let mut first_ns = [0, 1].map(|node| c1[node] + ratio * (c2[node] - c1[node]));
        if matches!((self.settings.method, self.step), (Method::Qerm, Step::Sensor(_))) {
            first_ns[0] = self.estimator.parallel_ns(first_ns[0])?;
        }
        Some(Forecast { first_ns, next_ns: c2, d_ns: self.estimator.offset().d_ns })
    }

    fn split_time(&self) -> Option<Nanos> {
        let (c1, _) = self.estimator.calibration()?;
        Some(Nanos((SplitCalibration::FRACTION * c1[0]) as i64))
    }

    /// When to switch from the sensor to R_2, if the next x discharge of a channel is to be switched at all.
    fn switch_time(&self, channel: usize) -> Option<Nanos> {
        let settings = &self.settings;
        if !matches!(settings.method, Method::Cerm | Method::Qerm) || !self.offset_is_known() {
            return None;
        }
        let memory = &self.memory[channel];
        let ratio = memory.ratio?;
        let (c1, c2) = self.estimator.calibration()?;
        let x_ns = c1[0] + ratio * (c2[0] - c1[0]);
        let d_ns = self.estimator.offset().d_ns;
        let wanted = match settings.t_l {
            Some(t_l) => x_ns - d_ns < t_l.as_ns(),
            None => self.is_switch_better(ratio, memory),
        };
        let a_ns = if settings.method == Method::Qerm { self.estimator.parallel_ns(x_ns)? } else { x_ns };
        let after = settings.switch_fraction * (a_ns - d_ns);
        (wanted && after >= 1.0).then_some(Nanos(after as i64))
    }

    fn is_switch_better(&self, ratio: f64, memory: &Memory) -> bool {
        let predicted = self.estimator.predict(ratio, self.settings.switch_fraction, memory.u_switch_ns);
        predicted.is_some_and(|[direct, inferred]| {
            let (of_inferred, of_direct) =
                if memory.inferred { (HYSTERESIS, 1.0) } else { (1.0, HYSTERESIS) };
            inferred * of_inferred < direct * of_direct
        })
    }

    /// Takes the outcome of the discharge that [`Cycle::next`] asked for, `now` being the time; answers a reading when
    /// it was a sensor's.
    pub fn done(&mut self, outcome: &Outcome, now: Nanos) -> Option<Reading> {
        if let (Step::First, Some(call)) = (self.step, outcome.start_call) {
            self.calls.add(call);
        }
        match self.step {
            Step::First => self.calibrated(outcome, Step::Second),
            Step::Second => {
                let due = !self.offset_is_known() || self.stats.cycles % FOLLOW_EVERY == 0;
                let after = if self.split.is_some() && due { Step::Split } else { Step::Sensor(0) };
                self.calibrated(outcome, after);
            }
            Step::Split => self.split_done(outcome),
            Step::Sensor(channel) => return Some(self.sensor_done(channel, outcome, now)),
        }
        None
    }

    fn calibrated(&mut self, outcome: &Outcome, next: Step) {
        let result = outcome.result.and_then(|record| self.estimator.calibrate(&record));
        let Err(fault) = result else {
            self.retries = 0;
            self.step = next;
            return;
        };
        self.stats.retried += 1;
        self.retries += 1;
        if self.retries > RETRIES {
            self.fail(if fault == Fault::LatencyOutlier { fault } else { Fault::NoCalibration });
        }
    }

    /// A split discharge that came to nothing costs one round, not the cycle.
    fn split_done(&mut self, outcome: &Outcome) {
        self.step = Step::Sensor(0);
        let (Some(split), Some((c1, c2))) = (&mut self.split, self.estimator.calibration()) else { return };
        let Ok(record) = &outcome.result else { return };
        let before = split.taken();
        split.add(c1, c2, record, self.estimator.noise());
        if split.taken() != before && split.taken() % ROUNDS == 0 {
            if let Some(offset) = split.result() {
                self.estimator.set_offset(offset);
            }
        }
    }

    fn sensor_done(&mut self, channel: usize, outcome: &Outcome, now: Nanos) -> Reading {
        let settings = &self.settings.channels[channel];
        let (status, middle) = match &outcome.result {
            Ok(record) => {
                let status = self.estimator.status(record, settings.zero_ohm, settings.force.as_ref());
                (status, middle_of(record))
            }
            Err(fault) => (Status::Fault(*fault), now),
        };
        let [r1, r2] = self.settings.r_ohm;
        let zero_ohm = settings.zero_ohm;
        let memory = &mut self.memory[channel];
        match status {
            Status::Ok { branch, r_ohm, .. } => {
                memory.ratio = Some((r_ohm.value + zero_ohm - r1) / (r2 - r1));
                memory.inferred = branch == Branch::Inferred;
            }
            // One spike says nothing about the sensor.
            Status::Fault(Fault::LatencyOutlier | Fault::WideBracket) => {}
            Status::Short { .. } | Status::Open { .. } | Status::Fault(_) => memory.ratio = None,
        }
        if let Ok(record) = &outcome.result {
            memory.u_switch_ns = record.u_switch_ns;
        }
        self.report(channel, status, middle, now)
    }

    fn report(&mut self, channel: usize, status: Status, at: Nanos, now: Nanos) -> Reading {
        self.stats.count(&status);
        let reading = Reading {
            channel,
            seq: self.stats.readings,
            at,
            status,
            method: self.settings.method,
            duration: now - self.began,
        };
        self.began = now;
        self.step = Step::Sensor(channel + 1);
        if channel + 1 == self.settings.channels.len() {
            self.step = Step::First;
            self.retries = 0;
            self.failed = None;
            self.stats.cycles += 1;
        }
        reading
    }
}

/// The middle of a discharge.
fn middle_of(record: &Record) -> Nanos {
    let end = record.b_ns.or(record.a_ns).unwrap_or(record.waited_ns);
    record.start + Nanos((end / 2.0) as i64)
}

/// Follows how long a call takes that switches one line, to tell an interrupted one from a usual one, and to place the
/// moment at which the line moves.
#[derive(Debug, Clone, Copy, Default)]
struct CallGate {
    /// The median, ns.
    single_ns: Option<f64>,
    /// How many calls have been seen.
    seen: u32,
}

impl CallGate {
    fn single(&self) -> Option<Nanos> {
        self.single_ns.map(|single| Nanos(single as i64))
    }

    /// A call longer than this was interrupted: the line may have moved anywhere in it. A call for two lines takes less
    /// than two calls.
    fn widest(&self) -> Nanos {
        self.single_ns.map_or(Nanos::MAX, |single| Nanos((4.0 * single + 2000.0) as i64))
    }

    /// Steps towards each value, not by it: a long call moves the median no more than a short one. The steps are small
    /// beside the calls, and so are they beside the jitter of crossings; but for the first ones, as the first call of all
    /// often takes long, and what it moved would be taken for a change of the latency offset.
    fn add(&mut self, call: Nanos) {
        let call = call.as_ns();
        self.seen = self.seen.saturating_add(1);
        let step = (1.0 / f64::from(self.seen)).max(0.01);
        self.single_ns = Some(match self.single_ns {
            None => call,
            Some(single) if (call - single).abs() <= 0.01 * single => single,
            Some(single) if call > single => (single * (1.0 + step)).max(1.0),
            Some(single) => single / (1.0 + step),
        });
    }
}
