//! Carries the actions of a discharge out on real or simulated pins; no line is left driving when anything goes wrong.

use super::{Action, Calls, Discharge, Event, Lead, Plan};
use crate::pins::{Drives, Levels, Pins, PinsError};
use crate::reading::Fault;
use crate::record::Record;

/// Releases every line when it goes out of scope, also on an error or a panic.
struct Release<'a, P: Pins + ?Sized>(&'a mut P);

impl<P: Pins + ?Sized> Drop for Release<'_, P> {
    fn drop(&mut self) {
        // There is nobody left to tell: the error that brought us here is on its way already.
        let _ = self.0.drive(Drives::NONE);
    }
}

/// What [`run`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The record or the fault.
    pub result: Result<Record, Fault>,
    /// [`Discharge::calls`].
    pub calls: Calls,
    /// [`Discharge::charged`].
    pub charged: Option<Levels>,
}

/// Carries one discharge out. All lines are inputs when it returns, whatever happened.
///
/// # Errors
/// Only if the pins cannot be used; what the circuit did is in the [`Outcome`].
pub fn run<P: Pins + ?Sized>(pins: &mut P, plan: Plan) -> Result<Outcome, PinsError> {
    let pins = Release(pins);
    let outcome = run_on(pins.0, plan, &mut Lead::default())?;
    // If that fails, it is tried once more.
    pins.0.drive(Drives::NONE)?;
    std::mem::forget(pins);
    Ok(outcome)
}

/// The same for one of many: the resistor goes on sinking after a discharge that gave a record, as the next charge releases
/// it in the same call. Who does not charge at once has to release it. `lead` learns from it.
///
/// # Errors
/// As [`run`]; all lines are inputs then.
pub fn run_on<P: Pins + ?Sized>(pins: &mut P, plan: Plan, lead: &mut Lead) -> Result<Outcome, PinsError> {
    let tick = pins.particulars().tick;
    let (mut discharge, mut action) = Discharge::new(plan, lead.get(), tick);
    let pins = Release(pins);
    loop {
        let event = match action {
            Action::Drive(on) => Event::Drove(pins.0.drive(on)?),
            Action::Sleep(at) => {
                pins.0.sleep_until(at)?;
                Event::Slept
            }
            Action::Rest(at) => {
                pins.0.rest_until(at)?;
                Event::Slept
            }
            Action::Arm => {
                let armed = pins.0.arm()?;
                Event::Armed(armed, tick.map(|_| pins.0.now()))
            }
            Action::WaitEdge { expected, until } => {
                if let Some(at) = expected {
                    pins.0.rest_before_edge(at)?;
                }
                Event::Edge(pins.0.edge(until)?)
            }
            Action::ReadLevels => {
                let begin = pins.0.now();
                let levels = pins.0.levels()?;
                lead.learn(pins.0.now() - begin);
                Event::Levels(levels)
            }
            Action::Done => {
                let result = discharge.result();
                if result.is_err() {
                    pins.0.drive(Drives::NONE)?;
                }
                std::mem::forget(pins);
                return Ok(Outcome { result, calls: *discharge.calls(), charged: discharge.charged() });
            }
        };
        action = discharge.handle(event);
    }
}
