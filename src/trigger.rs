//! When readings become an event: thresholds with a hysteresis, a time that they must hold for, and what becomes of it when
//! nothing is known any more.
//!
//! For: one channel's state, pressed, released or unknown, from its readings. Must not know: where readings come from, who is
//! told, what is switched. Time is an argument.
//!
//! Three rules. A number decides by where the truth is with 95 % (two of its sigma), so one that is not known well enough
//! decides nothing. Pressed and released need a number; what is unknown comes from the lack of one alone. And a number is good
//! for so long: readings without one do no harm until then.

use crate::reading::{Bound, Fault, Measured, MeasuredValue, Reading, Status};
use crate::units::Nanos;

/// How many sigma a number must be beyond a threshold: 95 % of truths are within two.
const SIGMAS: f64 = 2.0;

/// What is compared. The one place that knows where it stands in a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compared {
    /// What the channel shows, in its unit: a force, or what its law says. The uncertainty is that of the readout: what the sensor
    /// is off its law by is the same each time.
    Shown,
    /// Ohm.
    Resistance,
}

impl Compared {
    /// From where to where the truth is, as far as a reading knows; an end may be infinite. `None`: nothing is known.
    fn span(self, status: &Status) -> Option<[f64; 2]> {
        let around = |value: f64, u: Option<f64>| u.map(|u| [value - SIGMAS * u, value + SIGMAS * u]);
        match (self, *status) {
            (_, Status::Fault(_)) => None,
            (Compared::Shown, Status::Ok { shown, .. }) => {
                shown.and_then(|MeasuredValue { value, repeat_u, .. }| around(value, repeat_u))
            }
            (Compared::Shown, Status::Open { shown, .. } | Status::Short { shown, .. }) => {
                shown.map(|bound| match bound {
                    Bound::AtMost(most) => [f64::NEG_INFINITY, most],
                    Bound::AtLeast(least) => [least, f64::INFINITY],
                })
            }
            (Compared::Resistance, Status::Ok { r_ohm: Measured { value, u }, .. }) => around(value, u),
            (Compared::Resistance, Status::Open { r_min_ohm, .. }) => Some([r_min_ohm, f64::INFINITY]),
            (Compared::Resistance, Status::Short { r_max_ohm, .. }) => Some([0.0, r_max_ohm]),
        }
    }
}

/// What makes a channel pressed or released.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriggerRules {
    /// What is compared.
    pub quantity: Compared,
    /// Pressed from here on, upwards or downwards: away from `off`. In the unit of the quantity.
    pub on: f64,
    /// Released from here on, the other way.
    pub off: f64,
    /// How long all numbers must say so.
    pub hold: Nanos,
    /// How long the last number is good for.
    pub stale: Nanos,
}

impl TriggerRules {
    /// What a number says by itself. Between the thresholds everything stays as it is; where nothing is known yet, what is
    /// surely below `on` is released.
    fn state_at(&self, [low, high]: [f64; 2], before: State) -> State {
        // As if `on` were the upper one.
        let (on, off, [low, high]) = match self.on > self.off {
            true => (self.on, self.off, [low, high]),
            false => (-self.on, -self.off, [-high, -low]),
        };
        match before {
            _ if low >= on => State::Pressed,
            _ if high <= off => State::Released,
            State::Unknown(_) if high < on => State::Released,
            before => before,
        }
    }
}

/// What is known of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It is beyond `on`, or was and is not yet beyond `off`.
    Pressed,
    /// The other way round.
    Released,
    /// Not known, and why.
    Unknown(Why),
}

/// Why a state is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// Readings come, without a number.
    Fault,
    /// No readings come.
    Stale,
}

/// What is known has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// To what.
    pub state: State,
    /// When the reading was taken that says so; of what is unknown: when that was noticed. `CLOCK_MONOTONIC`.
    pub at: Nanos,
}

/// The state of one channel.
#[derive(Debug, Clone)]
pub struct Trigger {
    rules: TriggerRules,
    state: State,
    /// When the last number was taken.
    known_at: Option<Nanos>,
    /// Whether readings without a number came since.
    is_fault: bool,
    /// The state that numbers ask for, and since when without a break.
    asked: Option<(State, Nanos)>,
}

impl Trigger {
    /// Nothing is known yet.
    pub fn new(rules: TriggerRules) -> Trigger {
        let state = State::Unknown(Why::Stale);
        Trigger { rules, state, known_at: None, is_fault: false, asked: None }
    }

    /// What is known now.
    pub fn state(&self) -> State {
        self.state
    }

    /// Takes the next reading of the channel.
    pub fn take(&mut self, reading: &Reading) -> Option<Event> {
        let at = reading.at;
        let Some(span) = self.rules.quantity.span(&reading.status) else {
            self.is_fault = true;
            // The lines are away: nothing comes before they are opened again.
            let is_away = reading.status == Status::Fault(Fault::Pins);
            return if is_away { self.forget(at) } else { None };
        };
        if self.is_stale(at) {
            // What was asked for before the gap has not held through it.
            self.asked = None;
        }
        (self.known_at, self.is_fault) = (Some(at), false);
        let wanted = self.rules.state_at(span, self.state);
        if wanted == self.state {
            self.asked = None;
            return None;
        }
        let since = match self.asked {
            Some((asked, since)) if asked == wanted => since,
            _ => at,
        };
        self.asked = Some((wanted, since));
        if at - since < self.rules.hold {
            return None;
        }
        self.asked = None;
        self.change_to(wanted, at)
    }

    /// Looks whether what is known has become too old by `now`.
    pub fn look(&mut self, now: Nanos) -> Option<Event> {
        if self.is_stale(now) { self.forget(now) } else { None }
    }

    /// When to look; `None`: nothing is known that could become too old.
    pub fn look_at(&self) -> Option<Nanos> {
        let is_known = !matches!(self.state, State::Unknown(_));
        self.known_at.filter(|_| is_known).map(|at| at + self.rules.stale)
    }

    fn is_stale(&self, now: Nanos) -> bool {
        self.known_at.is_none_or(|at| now - at >= self.rules.stale)
    }

    /// From `at` on nothing is known any more.
    pub fn forget(&mut self, at: Nanos) -> Option<Event> {
        self.asked = None;
        let why = if self.is_fault { Why::Fault } else { Why::Stale };
        match self.state {
            // One event for one loss.
            State::Unknown(_) => None,
            _ => self.change_to(State::Unknown(why), at),
        }
    }

    fn change_to(&mut self, state: State, at: Nanos) -> Option<Event> {
        self.state = state;
        Some(Event { state, at })
    }
}

#[cfg(test)]
mod tests;
