//! What has come of a channel since it was last published, where that is the mean over a time.

use crate::estimate::mean::{Basis, Mean};
use crate::estimate::tracker::Tracker;
use crate::reading::{Measured, MeasuredValue, Status};
use crate::units::Nanos;

/// The readings of one window.
#[derive(Debug, Clone, Copy, Default)]
pub struct Window {
    began: Option<Nanos>,
    mean: Mean,
    /// Of those that do not say that the sensor moves.
    rest: Mean,
    /// The last number, and whether the u of any was a prior.
    number: Option<Status>,
    is_settling: bool,
    /// The sum of when they were, since it began, ns.
    at_ns: f64,
    /// The last state, and how many were no numbers but bounds.
    state: Option<(Status, Nanos)>,
    bounds: usize,
}

impl Window {
    /// Takes what a discharge that began at `began` has told, about the instant `at`; zero is on in `r_ohm` as in the status.
    pub fn add(&mut self, status: Status, basis: &Basis, [began, at]: [Nanos; 2], tracker: Option<&Tracker>) {
        let first = *self.began.get_or_insert(began);
        match status {
            Status::Ok { r_ohm, is_moving, is_settling, .. } => {
                self.mean.add(r_ohm, basis, tracker);
                if !is_moving {
                    self.rest.add(r_ohm, basis, tracker);
                }
                self.at_ns += (at - first).as_ns();
                self.is_settling |= is_settling;
                self.number = Some(status);
            }
            Status::Open { .. } | Status::Short { .. } => {
                self.bounds += 1;
                self.state = Some((status, at));
            }
            // A fault among numbers or bounds is one reading less.
            Status::Fault(_) if self.bounds == 0 => self.state = Some((status, at)),
            Status::Fault(_) => {}
        }
    }

    /// After a calibration discharge.
    pub fn calibrated(&mut self, tracker: &Tracker) {
        self.mean.calibrated(tracker);
        self.rest.calibrated(tracker);
    }

    /// When the next one begins, if this one has lasted for so long by now: where it was to end, if that is not long ago.
    pub fn over(&self, length: Nanos, now: Nanos) -> Option<Nanos> {
        let due = self.began? + length;
        (now >= due).then(|| if now - due < length { due } else { now })
    }

    /// What is to be published, and since when and of when it is: the mean of the numbers, or the last state where there are more
    /// bounds than numbers or no numbers at all. The next one begins at `next`, or with what it takes first.
    pub fn take(
        &mut self,
        next: Option<Nanos>,
        tracker: Option<&Tracker>,
        shown: impl Fn(Measured) -> Option<MeasuredValue>,
    ) -> Option<(Status, [Nanos; 2])> {
        let began = self.began?;
        let done = std::mem::replace(self, Window { began: next, ..Window::default() });
        // A change that came all at once in few of them, and went, has been late stamps.
        let is_moving = 2 * done.rest.count() < done.mean.count();
        let mean = if is_moving { &done.mean } else { &done.rest };
        let mean = mean.result(tracker).filter(|_| done.mean.count() >= done.bounds);
        match (mean, done.number) {
            (Some(r_ohm), Some(Status::Ok { branch, .. })) => {
                let at = began + Nanos((done.at_ns / done.mean.count() as f64) as i64);
                let shown = shown(r_ohm);
                let is_settling = done.is_settling;
                Some((Status::Ok { branch, r_ohm, shown, is_moving, is_settling }, [began, at]))
            }
            _ => done.state.map(|(status, at)| (status, [began, at])),
        }
    }
}
