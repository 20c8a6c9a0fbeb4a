//! The simulated circuit: a [`Pins`] whose lines end in a network of resistors and capacitors, with the latencies of a real
//! kernel, in virtual time.
//!
//! Time only moves inside calls: a call that costs nothing takes none. [`SimPins::paced`] makes the calling thread
//! sleep so that the wall clock keeps step; the stamps stay those of virtual time, so that readings do not depend
//! on the load of the host.
//!
//! [`network`] solves the voltages, [`waveform`] inverts them, [`scene`] describes a board, [`sensor`] what is
//! connected to it. With the estimators it shares constants, units and the list of capacitors, and nothing else: an error in
//! the physics of either shows.

use super::limits::ONE_VALUE;
use super::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use crate::units::{Nanos, Seconds};
use analog::{Analog, Fall};
use kernel::{Events, next_edge};
use latency::whole_ns;
use rand_chacha::ChaCha8Rng;
use scene::{CallsScene, DelayScene};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

mod analog;
mod build;
mod kernel;
mod latency;
pub mod network;
mod noise;
pub mod scene;
pub mod sensor;
mod truth;
pub mod waveform;

pub use crate::circuit::Kind;
pub use network::SimCircuit;
pub use scene::{Scene, SceneError};
pub use sensor::Sensor;
pub use truth::Truth;

/// Keeps the wall clock in step.
#[derive(Debug, Clone, Copy)]
struct WallClock {
    started: Instant,
    started_ns: i64,
}

/// A simulated board. Inside, instants are virtual ns since its construction; those that are handed out are later by the
/// epoch.
#[derive(Debug, Clone)]
pub struct SimPins {
    now_ns: i64,
    epoch: Nanos,
    pace: Option<WallClock>,
    analog: Analog,
    events: Events,
    scene: Scene,
    /// Moves that are on their way, each with the lines that drive from then on, in the order of writing.
    posted: VecDeque<(i64, Drives)>,
    /// When somebody last read or moved a line.
    touched_ns: i64,
    armed: bool,
    conflicts: u64,
    truth: Truth,
    rng: ChaCha8Rng,
}

impl SimPins {
    /// The same board with stamps that start at `epoch` (now on `CLOCK_MONOTONIC`), the thread that calls it
    /// sleeping whenever virtual time is ahead of the wall clock.
    pub fn paced(mut self, epoch: Nanos) -> SimPins {
        self.epoch = epoch - Nanos(self.now_ns);
        self.pace = Some(WallClock { started: Instant::now(), started_ns: self.now_ns });
        self
    }

    /// The lines that drive, as they have been written: none after every proper end.
    pub fn driving(&self) -> Drives {
        self.posted.back().map_or(self.analog.on(), |(_, on)| *on)
    }

    /// How often a charger and a sink drove or were asked to drive against each other. Tests assert 0.
    pub fn conflicts(&self) -> u64 {
        self.conflicts
    }

    /// What really happened since the last [`Pins::arm`].
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// The network as it is, with the sensors' present values.
    pub fn circuit(&self) -> &SimCircuit {
        &self.analog.circuit
    }

    /// R_x of a channel at an instant, ohm; `None` without such a channel in the scene.
    pub fn r_x(&self, channel: usize, at: Nanos) -> Option<f64> {
        self.analog.r_x(channel, (at - self.epoch).0)
    }

    /// The same if it is one value from `half` before to `half` after: if it changes by less than a tenth.
    pub fn one_r_x(&self, channel: usize, at: Nanos, half: Nanos) -> Option<f64> {
        let [before, r_x, after] = [at - half, at, at + half].map(|at| self.r_x(channel, at));
        let (before, r_x, after) = (before?, r_x?, after?);
        ((after - before).abs().max((r_x - before).abs()) < ONE_VALUE * r_x).then_some(r_x)
    }

    /// Moves virtual time on, never back.
    fn go_on_to(&mut self, ns: i64) {
        self.now_ns = self.now_ns.max(ns);
        if let Some(pace) = self.pace {
            let ahead = Duration::from_nanos((self.now_ns - pace.started_ns).max(0) as u64);
            if let Some(rest) = ahead.checked_sub(pace.started.elapsed()) {
                std::thread::sleep(rest);
            }
        }
    }

    /// Lets a call take its time.
    fn spend(&mut self, cost: Option<Seconds>) {
        let end_ns = self.now_ns.saturating_add(whole_ns(cost));
        self.go_on_to(end_ns.saturating_add(self.tick_goes_on_ns()(end_ns)));
    }

    /// When a wait ends that was to end at an instant.
    fn late_ns(&mut self, at_ns: i64, late: Option<DelayScene>) -> i64 {
        let late_ns = late.map_or(0.0, |late| late.draw_ns(&mut self.rng));
        let at_ns = at_ns.saturating_add(late_ns.round() as i64);
        at_ns.saturating_add(self.tick_goes_on_ns()(at_ns))
    }

    /// For how long a tick keeps the processor from what comes at an instant, ns.
    fn tick_goes_on_ns(&self) -> impl Fn(i64) -> i64 + use<> {
        let (ticks, epoch_ns) = (self.scene.ticks, self.epoch.0);
        move |at_ns| ticks.map_or(0, |ticks| ticks.remaining_ns(at_ns.saturating_add(epoch_ns)))
    }

    /// Takes account of every fall and every move up to an instant.
    fn catch_up(&mut self, to_ns: i64) {
        while let Some(fall) = self.next_fall(to_ns) {
            self.fell(fall);
        }
    }

    /// The next fall up to an instant, going on through the moves of lines before it.
    fn next_fall(&mut self, by_ns: i64) -> Option<Fall> {
        while let Some((at_ns, on)) = self.posted.front().copied().filter(|(at_ns, _)| *at_ns <= by_ns) {
            if let Some(fall) = self.analog.next_fall(at_ns) {
                return Some(fall);
            }
            self.posted.pop_front();
            self.switch(on, at_ns);
        }
        self.analog.next_fall(by_ns)
    }

    /// A read arrives behind all writes, and waits for them.
    fn flush(&mut self) {
        if let Some((last_ns, _)) = self.posted.back() {
            self.go_on_to(*last_ns);
        }
        self.catch_up(self.now_ns);
    }

    fn fell(&mut self, fall: Fall) {
        self.truth.crossed(fall.node, fall.since_ns, fall.crossed);
        if self.armed {
            // Time goes on when a wait is over: until then it is the instant at which the wait began.
            let tick_goes_on_ns = self.tick_goes_on_ns();
            self.events.fell(fall.node, fall.since_ns, fall.seen, self.now_ns, tick_goes_on_ns);
        }
    }

    fn switch(&mut self, on: Drives, at_ns: i64) {
        self.analog.switch(on, at_ns);
        self.truth.switched(on, at_ns);
        if on.conflicts() {
            self.conflicts += 1;
        }
    }

    /// Switches line by line, as long as that takes.
    fn switch_slowly(&mut self, calls: CallsScene, on: Drives) {
        let old = self.driving();
        let (releases, drives) = (old.without(on), on.without(old));
        let lines = (releases.count() + drives.count()) as usize;
        let begin_ns = self.now_ns;
        let tick_ns = self.scene.ticks.map(|ticks| ticks.next_ns(begin_ns.saturating_add(self.epoch.0)));
        let call = calls.begin(lines, begin_ns - self.touched_ns, tick_ns, &mut self.rng);
        let mut state = old;
        let moves = releases.lines().map(|line| (line, false)).chain(drives.lines().map(|line| (line, true)));
        for (position, (line, driven)) in moves.enumerate() {
            let after_ns = call.moves_ns(position, &mut self.rng).round() as i64;
            state = if driven { state.and(line) } else { state.without(line) };
            let before_ns = self.posted.back().map_or(begin_ns, |(at_ns, _)| *at_ns);
            self.touched_ns = before_ns.max(begin_ns + after_ns);
            self.posted.push_back((self.touched_ns, state));
        }
        self.go_on_to(begin_ns + call.duration_ns().round() as i64);
        self.catch_up(self.now_ns);
    }
}

impl Pins for SimPins {
    fn now(&mut self) -> Nanos {
        let now = Nanos(self.now_ns) + self.epoch;
        self.spend(self.scene.reads.clock);
        now
    }

    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        if on.conflicts() {
            self.conflicts += 1;
            return Err(PinsError::Conflict(on));
        }
        if let Some(period) = self.scene.clock_period {
            self.go_on_to(next_edge(self.now_ns, whole_ns(period)));
        }
        let before = self.now();
        match self.scene.calls {
            Some(calls) => self.switch_slowly(calls, on),
            None => {
                self.catch_up(self.now_ns);
                self.switch(on, self.now_ns);
            }
        }
        Ok(Bracket { before, after: self.now() })
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.spend(self.scene.reads.arm);
        self.flush();
        self.touched_ns = self.now_ns;
        self.armed = true;
        self.truth.clear();
        let (seqno, line_seqno) = self.events.drain();
        Ok(Armed { levels: self.analog.levels(self.now_ns), seqno, line_seqno })
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        let until_ns = (until - self.epoch).0;
        self.catch_up(self.now_ns);
        loop {
            // An edge that is stamped while this waits wakes the program; one that was there before does not.
            if let Some(stamp_ns) = self.events.next_stamp_ns().filter(|ns| *ns <= until_ns.max(self.now_ns))
            {
                if stamp_ns > self.now_ns {
                    let woken_ns = self.late_ns(stamp_ns, self.scene.wake);
                    self.go_on_to(woken_ns);
                    // What comes meanwhile may push it out of the buffer.
                    self.catch_up(self.now_ns);
                    if self.events.next_stamp_ns().is_some_and(|ns| ns > self.now_ns) {
                        continue;
                    }
                }
                let edge = self.events.take();
                return Ok(edge.map(|edge| Edge { at: edge.at + self.epoch, ..edge }));
            }
            match self.next_fall(until_ns) {
                Some(fall) => self.fell(fall),
                None => break,
            }
        }
        self.sleep_until(until)?;
        Ok(None)
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let at_ns = (at - self.epoch).0;
        if at_ns > self.now_ns {
            let woken_ns = self.late_ns(at_ns, self.scene.sleep);
            self.catch_up(woken_ns);
            self.go_on_to(woken_ns);
        }
        Ok(())
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.spend(self.scene.reads.levels);
        self.flush();
        self.touched_ns = self.now_ns;
        Ok(self.analog.levels(self.now_ns))
    }

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }

    fn rest_before_edge(&mut self, _at: Nanos) -> Result<(), PinsError> {
        Ok(())
    }

    fn particulars(&self) -> Particulars<'_> {
        let tick = self.scene.ticks.map(|ticks| Nanos(whole_ns(ticks.every)));
        Particulars { tick, ..Particulars::default() }
    }
}

#[cfg(test)]
mod tests;
