//! What comes of a sensor's discharge: a reading, or its part of a mean; and on to the next channel.

use super::window::Window;
use super::{Burst, Cycle, Step};
use crate::estimate::estimator::{Judged, shown};
use crate::instrument::discharge::Outcome;
use crate::instrument::limits::OVERHEAD_STEP;
use crate::reading::{Fault, Reading, Status};
use crate::units::Nanos;

impl Cycle {
    pub(super) fn sensor_done(&mut self, channel: usize, outcome: &Outcome, now: Nanos) -> Option<Reading> {
        self.diagnosis.take_sensor(outcome);
        let (sensor, memory) = (&self.settings.channels[channel], &mut self.memory[channel]);
        let (judged, began) = match &outcome.result {
            Ok(record) => (self.estimator.judge(record, sensor, &mut memory.motion), record.start),
            Err(fault) => (Judged::fault(*fault), now),
        };
        self.as_read_ohm = judged.as_read_ohm;
        let leaks = matches!(judged.status, Status::Fault(Fault::Leakage | Fault::PullUp));
        self.leaks_in_row = if leaks { self.leaks_in_row.saturating_add(1) } else { 0 };
        memory.take(&judged, outcome.result.ok(), sensor, &mut self.estimator);
        self.publish(channel, &judged, began, now)
    }

    /// What a cycle without calibration tells of a channel. That the lines cannot be used is told at once.
    pub(super) fn failing(&mut self, channel: usize, fault: Fault, now: Nanos) -> Option<Reading> {
        if fault == Fault::Pins {
            self.memory[channel].window = Window::default();
            return Some(self.report(channel, Status::Fault(fault), now, now));
        }
        self.publish(channel, &Judged::fault(fault), now, now)
    }

    /// A reading, or what it adds to a mean that is published when its time is over.
    fn publish(&mut self, channel: usize, judged: &Judged, began: Nanos, now: Nanos) -> Option<Reading> {
        let (at, share_began) = (judged.at(began), self.began);
        let Some(length) = self.settings.average else {
            return Some(self.report(channel, judged.status, at, now));
        };
        let (window, tracker) = (&mut self.memory[channel].window, self.estimator.tracker());
        window.add(judged.status, &judged.basis, [share_began, at], tracker);
        let (sensor, known) = (&self.settings.channels[channel], self.settings.r_ohm());
        let next = match self.burst {
            // All channels end together, so that all of the circuit rests until the next one.
            Some(Burst { is_ending, .. }) => is_ending.then_some(None),
            None => window.over(length, now).map(Some),
        };
        let over = next.and_then(|next| window.take(next, tracker, |r_ohm| shown(sensor, r_ohm, known)));
        let reading = over.map(|(status, [began, at])| self.told(channel, status, at, now - began));
        self.go_on(channel, now);
        reading
    }

    pub(super) fn report(&mut self, channel: usize, status: Status, at: Nanos, now: Nanos) -> Reading {
        let reading = self.told(channel, status, at, now - self.began);
        self.go_on(channel, now);
        reading
    }

    fn told(&mut self, channel: usize, status: Status, at: Nanos, duration: Nanos) -> Reading {
        self.stats.count(&status);
        let suspect = match status {
            Status::Fault(fault) => self.diagnosis.suspect(fault),
            _ => None,
        };
        if suspect.is_some() || !matches!(status, Status::Fault(_)) {
            self.stats.suspect = suspect;
        }
        Reading {
            channel,
            seq: self.stats.readings,
            at,
            status,
            suspect,
            method: self.settings.method,
            duration,
        }
    }

    /// To the next channel that this cycle reads, or to what follows the last one.
    fn go_on(&mut self, channel: usize, now: Nanos) {
        self.retries = 0;
        self.since_calibration = self.since_calibration.saturating_add(1);
        self.began = now;
        self.step = match self.next_sensor(channel + 1) {
            Some(next) => Step::Sensor(next),
            None => {
                let took_ns = (now - self.cycle_began).as_ns();
                self.cycle_ns += OVERHEAD_STEP * (took_ns - self.cycle_ns);
                self.stats.cycles += 1;
                self.burst = self.burst.filter(|burst| !burst.is_ending);
                self.turn += u64::from(self.burst.is_none());
                // Nothing is looked for on lines that cannot be used.
                match self.failed.take() {
                    Some(Fault::Pins) => Step::Start,
                    _ => self.after_sensors(now),
                }
            }
        };
    }

    /// The first channel from this one on that is read in this cycle; that lines cannot be used concerns all.
    pub(super) fn next_sensor(&self, from: usize) -> Option<usize> {
        let is_turn = |channel: usize| self.turn % u64::from(self.settings.every[channel]) == 0;
        let is_due = |channel: &usize| self.failed == Some(Fault::Pins) || is_turn(*channel);
        (from..self.settings.channels.len()).find(is_due)
    }

    pub(super) fn first_sensor(&self) -> Step {
        Step::Sensor(self.next_sensor(0).unwrap_or(0))
    }
}
