//! Which calibration discharge comes next, and what is learned from one.

use super::{Cycle, Step};
use crate::circuit::Node;
use crate::instrument::discharge::Outcome;
use crate::instrument::limits::{FOLLOW_EVERY, RETRIES, ROUNDS_AT_FIRST, WINDOW, YOUNG};
use crate::reading::Fault;
use crate::record::CalibrationKind;

impl Cycle {
    /// The calibration discharge that follows `last` in this cycle, or the first sensor.
    pub(super) fn next_calibration(&self, last: Option<CalibrationKind>) -> Step {
        let next = if self.estimator.tracker().is_some() {
            // More would take longer than the readings that they improve.
            let may = (self.calibrations as usize) < self.settings.channels.len();
            may.then(|| self.wanted()).flatten()
        } else {
            let kind = match last {
                None => Some(CalibrationKind::First),
                Some(CalibrationKind::First) => Some(CalibrationKind::Second),
                Some(CalibrationKind::Second) if self.is_split_due() => Some(CalibrationKind::Split),
                Some(CalibrationKind::Second | CalibrationKind::Split) => None,
            };
            kind.map(|kind| (kind, self.settings.last()))
        };
        next.map_or_else(|| self.before_sensors(), |(kind, last)| Step::Calibrate(kind, last))
    }

    pub(super) fn is_split_due(&self) -> bool {
        if self.settings.tracked {
            return true;
        }
        let Some(split) = &self.split else { return false };
        let may_improve = split.tried() < WINDOW;
        may_improve && (!self.offset_is_known() || self.offset_is_poor())
            || self.stats.cycles % FOLLOW_EVERY == 0
    }

    pub(super) fn calibrated(&mut self, kind: CalibrationKind, last: Node, outcome: &Outcome) {
        self.diagnosis.take(kind, outcome);
        if self.failed.is_none() {
            self.calibrate(kind, last, outcome);
        }
        // Lost already; the plain discharges tell whether it is a resistor's wire or a node.
        self.step = match (self.failed, kind) {
            (Some(Fault::NoCalibration), CalibrationKind::Split) => {
                Step::Calibrate(CalibrationKind::First, last)
            }
            (Some(Fault::NoCalibration), CalibrationKind::First) => {
                Step::Calibrate(CalibrationKind::Second, last)
            }
            (Some(_), _) => self.first_sensor(),
            (None, _) => self.step,
        };
    }

    fn calibrate(&mut self, kind: CalibrationKind, last: Node, outcome: &Outcome) {
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
        if let (Ok(()), Some(tracker)) = (result, self.estimator.tracker()) {
            self.memory.iter_mut().for_each(|memory| memory.window.calibrated(tracker));
        }
        if result.is_ok() || (is_spike && tracks) || (kind == CalibrationKind::Split && !tracks) {
            self.retries = 0;
            self.calibrations += 1;
            self.calibrated_at[kind as usize] = Some(self.asked);
            self.doubted = is_spike.then_some((kind, last));
            self.since_calibration = 0;
            self.memory.iter_mut().for_each(|memory| memory.is_startled = false);
            self.young = if tracks { (self.young + 1).min(YOUNG) } else { 0 };
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
    pub(super) fn split_done(&mut self, outcome: &Outcome) {
        self.step = self.before_sensors();
        let (Some(split), Some((c1, c2))) = (&mut self.split, self.estimator.calibration()) else { return };
        let Ok(record) = &outcome.result else { return };
        // What leaks is taken for an offset.
        if self.leak.is_defect() {
            return;
        }
        let before = split.taken();
        split.add(c1, c2, record, self.estimator.noise());
        if split.taken() != before && split.taken() >= ROUNDS_AT_FIRST {
            if let Some(offset) = split.result() {
                self.estimator.set_offset(offset);
            }
        }
    }
}
