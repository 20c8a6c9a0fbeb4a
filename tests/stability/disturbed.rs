//! Pins below which the computer does something else at the worst moment, once in so many discharges.

use cermd::pins::sim::SimPins;
use cermd::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use cermd::units::Nanos;

/// What happens, and for how long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// Preempted after arming, before the call that starts.
    BeforeStart,
    /// Preempted between the first clock reading and the move of the line that starts.
    AtStart,
    /// A planned switch is slept towards for too long.
    BeforeSwitch,
    /// Preempted between the first clock reading and the release of the sensor.
    AtSwitch,
    /// The program does not get to run when an edge comes.
    Waiting,
    /// The wall clock, by which edges are stamped, is set forward after the start.
    WallClock,
    /// Suspended a third of a millisecond after the start: `CLOCK_MONOTONIC` stands still, the discharge goes on, and
    /// edges are stamped when the system resumes.
    Suspended,
    /// The same, before the charge.
    SuspendedBetween,
}

/// The pins.
pub struct Disturbed {
    inner: SimPins,
    trouble: Trouble,
    lasts: Nanos,
    /// By the number of a discharge, counted from 0.
    is_struck: Box<dyn Fn(u64) -> bool>,
    charges: u64,
    on: Drives,
    started: bool,
    /// By how much `CLOCK_MONOTONIC` is behind physical time, and when it stood still last, in physical time.
    behind: Nanos,
    stood: [Nanos; 2],
    done: bool,
    /// What becomes of the capacitors while the system is suspended.
    grown: f64,
}

impl Disturbed {
    pub fn new(
        inner: SimPins,
        trouble: Trouble,
        lasts: Nanos,
        is_struck: impl Fn(u64) -> bool + 'static,
    ) -> Disturbed {
        Disturbed {
            inner,
            trouble,
            lasts,
            is_struck: Box::new(is_struck),
            charges: 0,
            on: Drives::NONE,
            started: false,
            behind: Nanos::ZERO,
            stood: [Nanos::ZERO; 2],
            done: false,
            grown: 1.0,
        }
    }

    /// The same with capacitors that grow by a factor in each suspend.
    pub fn growing(self, grown: f64) -> Disturbed {
        Disturbed { grown, ..self }
    }

    fn is_struck(&self) -> bool {
        self.charges > 0 && (self.is_struck)(self.charges - 1)
    }

    /// Whether this is the moment, which comes once in a discharge that is struck.
    fn strikes(&mut self, trouble: Trouble) -> bool {
        let strikes = self.trouble == trouble && self.is_struck() && !self.done;
        self.done |= strikes;
        strikes
    }

    fn pass(&mut self) -> Result<(), PinsError> {
        let until = self.inner.now() + self.lasts;
        self.inner.sleep_until(until)
    }

    fn suspend(&mut self) -> Result<(), PinsError> {
        let begin = self.inner.now();
        self.inner.sleep_until(begin + self.lasts)?;
        self.stood = [begin, self.inner.now()];
        self.behind = self.behind + (self.stood[1] - self.stood[0]);
        Ok(())
    }

    /// From physical time to `CLOCK_MONOTONIC`.
    fn stamp(&self, at: Nanos) -> Nanos {
        let [from, to] = self.stood;
        let at = if at > from && at < to { to } else { at };
        let behind = if at >= to { self.behind } else { self.behind - (to - from) };
        at - behind
    }

    fn stamped(&self, bracket: Bracket) -> Bracket {
        Bracket { before: self.stamp(bracket.before), after: self.stamp(bracket.after) }
    }
}

impl Pins for Disturbed {
    fn now(&mut self) -> Nanos {
        let now = self.inner.now();
        self.stamp(now)
    }

    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        let charges = on.contains(Drives::CHARGE_A);
        if charges {
            (self.charges, self.done, self.started) = (self.charges + 1, false, false);
            if self.strikes(Trouble::SuspendedBetween) {
                self.suspend()?;
                let grown = self.grown;
                self.inner.alter(|circuit| {
                    let (first, second) = circuit.network.capacitors();
                    [first].into_iter().chain(second).for_each(|c| c.0 *= grown);
                });
            }
        }
        let starts = !charges && !self.started && !on.is_none();
        let releases = self.started && self.on.contains(on) && self.on != on;
        let before = self.inner.now();
        if starts && self.strikes(Trouble::BeforeStart) {
            self.pass()?;
            return self.drive(on);
        }
        let is_late = (starts && self.strikes(Trouble::AtStart))
            || (releases && self.on.lines().any(|x| x == Drives::x(0)) && self.strikes(Trouble::AtSwitch));
        if is_late {
            self.pass()?;
        }
        let bracket = self.inner.drive(on)?;
        (self.on, self.started) = (on, self.started || starts);
        Ok(self.stamped(if is_late { Bracket { before, ..bracket } } else { bracket }))
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.inner.arm()
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        if self.strikes(Trouble::Suspended) {
            let now = self.inner.now();
            self.inner.sleep_until(now + Nanos(300_000))?;
            self.suspend()?;
        }
        let edge = self.inner.edge(until + self.behind)?;
        if edge.is_some() && self.strikes(Trouble::Waiting) {
            self.pass()?;
        }
        let is_set = self.trouble == Trouble::WallClock && self.is_struck();
        let ahead = if is_set { self.lasts } else { Nanos::ZERO };
        Ok(edge.map(|edge| Edge { at: self.stamp(edge.at) + ahead, ..edge }))
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.inner.sleep_until(at + self.behind)?;
        if self.started && self.strikes(Trouble::BeforeSwitch) {
            self.pass()?;
        }
        Ok(())
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.inner.levels()
    }

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }

    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.inner.rest_before_edge(at + self.behind)
    }

    fn particulars(&self) -> Particulars<'_> {
        self.inner.particulars()
    }
}
