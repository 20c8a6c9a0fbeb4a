//! Keeps the conversation with a [`Pins`]: each call with its answer.
//!
//! For: seeing afterwards what was asked of the hardware and what it said. Must not know: what the calls are for.

use super::{Armed, Bracket, Drives, Edge, Levels, Pins, PinsError};
use crate::units::Nanos;
use std::collections::VecDeque;
use std::fmt;

/// Any [`Pins`] with the last calls made to it. Nothing is allocated after construction.
#[derive(Debug)]
pub struct Trace<P> {
    inner: P,
    calls: VecDeque<Call>,
    capacity: usize,
    forgotten: u64,
}

/// A call failed; the error itself went to the caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failed {
    /// [`PinsError::Conflict`].
    Conflict,
    /// [`PinsError::Unwired`].
    Unwired,
    /// [`PinsError::Gone`].
    Gone,
    /// [`PinsError::Stopped`].
    Stopped,
    /// [`PinsError::Call`].
    Call,
}

impl From<&PinsError> for Failed {
    fn from(error: &PinsError) -> Failed {
        match error {
            PinsError::Conflict(_) => Failed::Conflict,
            PinsError::Unwired(_) => Failed::Unwired,
            PinsError::Gone { .. } => Failed::Gone,
            PinsError::Stopped => Failed::Stopped,
            PinsError::Call { .. } => Failed::Call,
        }
    }
}

/// One call and its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Call {
    /// [`Pins::now`].
    Now(Nanos),
    /// [`Pins::drive`].
    Drive(Drives, Result<Bracket, Failed>),
    /// [`Pins::arm`].
    Arm(Result<Armed, Failed>),
    /// [`Pins::edge`], with the end of the wait.
    Edge(Nanos, Result<Option<Edge>, Failed>),
    /// [`Pins::sleep_until`].
    SleepUntil(Nanos, Result<(), Failed>),
    /// [`Pins::levels`].
    Levels(Result<Levels, Failed>),
}

impl<P: Pins> Trace<P> {
    /// Keeps the last `capacity` calls.
    pub fn new(inner: P, capacity: usize) -> Trace<P> {
        Trace { inner, calls: VecDeque::with_capacity(capacity), capacity, forgotten: 0 }
    }

    /// The calls kept, oldest first.
    pub fn calls(&self) -> impl Iterator<Item = &Call> {
        self.calls.iter()
    }

    /// How many older calls are no longer kept.
    pub fn forgotten(&self) -> u64 {
        self.forgotten
    }

    /// Forgets the calls kept.
    pub fn clear(&mut self) {
        self.calls.clear();
        self.forgotten = 0;
    }

    /// The pins themselves.
    pub fn inner(&mut self) -> &mut P {
        &mut self.inner
    }

    fn keep<T>(
        &mut self,
        answer: Result<T, PinsError>,
        call: impl FnOnce(Result<&T, Failed>) -> Call,
    ) -> Result<T, PinsError> {
        self.push(call(answer.as_ref().map_err(Failed::from)));
        answer
    }

    fn push(&mut self, call: Call) {
        if self.calls.len() >= self.capacity {
            self.forgotten += 1;
            if self.calls.pop_front().is_none() {
                return;
            }
        }
        self.calls.push_back(call);
    }
}

impl<P: Pins> Pins for Trace<P> {
    fn now(&mut self) -> Nanos {
        let now = self.inner.now();
        self.push(Call::Now(now));
        now
    }

    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        let answer = self.inner.drive(on);
        self.keep(answer, |answer| Call::Drive(on, answer.copied()))
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        let answer = self.inner.arm();
        self.keep(answer, |answer| Call::Arm(answer.copied()))
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        let answer = self.inner.edge(until);
        self.keep(answer, |answer| Call::Edge(until, answer.copied()))
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let answer = self.inner.sleep_until(at);
        self.keep(answer, |answer| Call::SleepUntil(at, answer.copied()))
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        let answer = self.inner.levels();
        self.keep(answer, |answer| Call::Levels(answer.copied()))
    }
}

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Failed::Conflict => "refused: conflict",
            Failed::Call => "failed",
            Failed::Unwired => "unwired",
            Failed::Gone => "gone",
            Failed::Stopped => "stopped",
        })
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Call::Now(now) => write!(f, "now: {now}"),
            Call::Drive(on, Ok(Bracket { before, after })) => {
                write!(f, "drive {on}: {} .. {after}", before.0)
            }
            Call::Drive(on, Err(failed)) => write!(f, "drive {on}: {failed}"),
            Call::Arm(Ok(armed)) => {
                write!(f, "arm: seqno {}, levels {}", armed.seqno, ShowLevels(armed.levels))
            }
            Call::Arm(Err(failed)) => write!(f, "arm: {failed}"),
            Call::Edge(_, Ok(Some(edge))) => {
                let Edge { node, at, seqno, line_seqno } = edge;
                write!(f, "edge: {node:?} at {at}, seqno {seqno}, line {line_seqno}")
            }
            Call::Edge(until, Ok(None)) => write!(f, "edge: none until {until}"),
            Call::Edge(until, Err(failed)) => write!(f, "edge until {until}: {failed}"),
            Call::SleepUntil(at, Ok(())) => write!(f, "sleep until {at}"),
            Call::SleepUntil(at, Err(failed)) => write!(f, "sleep until {at}: {failed}"),
            Call::Levels(Ok(levels)) => write!(f, "levels: {}", ShowLevels(*levels)),
            Call::Levels(Err(failed)) => write!(f, "levels: {failed}"),
        }
    }
}

struct ShowLevels(Levels);

impl fmt::Display for ShowLevels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |high: bool| if high { "high" } else { "low" };
        write!(f, "A {}, B {}", name(self.0.a), name(self.0.b))
    }
}

/// The calls kept, a line each.
impl<P> fmt::Display for Trace<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.forgotten > 0 {
            writeln!(f, "... {} earlier calls", self.forgotten)?;
        }
        self.calls.iter().try_for_each(|call| writeln!(f, "{call}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pins::sim::{Scene, SimPins};

    fn pins(capacity: usize) -> Trace<SimPins> {
        Trace::new(SimPins::new(&Scene::builtin("ideal").unwrap(), None), capacity)
    }

    #[test]
    fn shows_each_call_with_its_answer() {
        let mut pins = pins(100);
        pins.drive(Drives::CHARGE).unwrap();
        pins.sleep_until(Nanos(20_000_000)).unwrap();
        pins.drive(Drives::NONE).unwrap();
        pins.arm().unwrap();
        pins.drive(Drives::C1).unwrap();
        pins.edge(Nanos(20_000_001)).unwrap();
        pins.edge(Nanos::MAX).unwrap();
        pins.drive(Drives::CHARGE.and(Drives::C1)).unwrap_err();
        pins.levels().unwrap();
        pins.now();
        insta::assert_snapshot!(pins.to_string());
    }

    #[test]
    fn keeps_the_last_calls() {
        let mut pins = pins(2);
        for at in 1..=5 {
            pins.sleep_until(Nanos(at)).unwrap();
        }
        assert_eq!(pins.forgotten(), 3);
        let kept: Vec<_> = pins.calls().copied().collect();
        assert_eq!(kept, [Call::SleepUntil(Nanos(4), Ok(())), Call::SleepUntil(Nanos(5), Ok(()))]);
    }
}
