//! One discharge: \[drain\], charge, arm, settle, start, [planned switch], crossings.
//!
//! A [`Plan`] becomes a [`Record`] or a named [`Fault`]; each wait is bounded, lines are broken before made, and no line is
//! left driving when anything goes wrong.

mod plan;

use crate::circuit::Node;
use crate::instrument::limits::LONGEST_PAUSE;
use crate::pins::{Armed, Bracket, Drives, Edge, Levels, Pins, PinsError, later};
use crate::reading::Fault;
use crate::record::{Record, Switch, Through};
use crate::units::Nanos;
pub use plan::Plan;

/// What [`run`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The record, or the fault that ended the discharge.
    pub result: Result<Record, Fault>,
    /// How long the call took that started it; `None` if it never started.
    pub start_call: Option<Nanos>,
    /// The levels after the charge; `None` if it never came to its end.
    pub charged: Option<Levels>,
}

/// Carries one discharge out. All lines are inputs when it returns, whatever happened.
///
/// # Errors
/// Only if the pins cannot be used; what the circuit did is in the [`Outcome`].
pub fn run<P: Pins>(pins: &mut P, plan: Plan) -> Result<Outcome, PinsError> {
    let outcome = run_on(pins, plan)?;
    pins.drive(Drives::NONE)?;
    Ok(outcome)
}

/// The same for one of many: the resistor goes on sinking after a discharge that gave a record, as the next charge releases
/// it in the same call. Who does not charge at once has to release it.
///
/// # Errors
/// As [`run`]; all lines are inputs then.
pub fn run_on<P: Pins>(pins: &mut P, plan: Plan) -> Result<Outcome, PinsError> {
    let pins = Release(pins);
    let (mut start_call, mut charged) = (None, None);
    let result = match take(pins.0, &plan, &mut charged, &mut start_call) {
        Ok(record) => Ok(record),
        Err(End::Fault(fault)) => {
            pins.0.drive(Drives::NONE)?;
            Err(fault)
        }
        Err(End::Pins(error)) => return Err(error),
    };
    std::mem::forget(pins);
    Ok(Outcome { result, start_call, charged })
}

/// Releases every line when it goes out of scope, also on an error or a panic.
struct Release<'a, P: Pins>(&'a mut P);

impl<P: Pins> Drop for Release<'_, P> {
    fn drop(&mut self) {
        // There is nobody left to tell: the error that brought us here is on its way already.
        let _ = self.0.drive(Drives::NONE);
    }
}

/// Why a discharge ended without a record.
enum End {
    Fault(Fault),
    Pins(PinsError),
}

impl From<Fault> for End {
    fn from(fault: Fault) -> End {
        End::Fault(fault)
    }
}

impl From<PinsError> for End {
    fn from(error: PinsError) -> End {
        End::Pins(error)
    }
}

/// From the charge to the last crossing; tells what [`Outcome`] has of a discharge without a record, too.
fn take<P: Pins>(
    pins: &mut P,
    plan: &Plan,
    charged: &mut Option<Levels>,
    start_call: &mut Option<Nanos>,
) -> Result<Record, End> {
    if plan.drain > Nanos::ZERO {
        let draining = pins.drive(Drives::C1)?;
        pins.rest_until(draining.after + plan.drain)?;
    }
    let charging = pins.drive(plan.chargers)?;
    pins.rest_until(charging.after + plan.charge)?;
    let floating = pins.drive(Drives::NONE)?;
    let armed = pins.arm()?;
    *charged = Some(armed.levels);
    if !(armed.levels.a && (armed.levels.b || plan.last == Node::A)) {
        return Err(Fault::NoCharge.into());
    }
    if plan.settle > Nanos::ZERO {
        pins.sleep_until(floating.after + plan.settle)?;
    }
    let start = pins.drive(plan.through.drives())?;
    *start_call = Some(start.width());
    if start.before - floating.before - plan.settle > LONGEST_PAUSE {
        return Err(Fault::WideBracket.into());
    }
    let start = narrow(start, plan)?;
    let mut fall = Fall {
        pins,
        plan,
        start,
        switch: None,
        wait_until: start.before + plan.timeout,
        crossings: [None; 2],
        waited: None,
        edges: Edges { armed, highest_seqno: armed.seqno, count: 0, line_seqno: armed.line_seqno },
    };
    if let Some((after, to)) = plan.switch {
        fall.pins.sleep_until(start.before + after)?;
        fall.switch_to(to)?;
    }
    fall.watch()?;
    Ok(fall.record())
}

/// A call in which a line has moved nobody knows when is none to measure by.
fn narrow(bracket: Bracket, plan: &Plan) -> Result<Bracket, Fault> {
    if bracket.width() > plan.widest_bracket { Err(Fault::WideBracket) } else { Ok(bracket) }
}

/// The edges of one discharge by their numbers, which follow on or something was lost.
struct Edges {
    armed: Armed,
    highest_seqno: u32,
    count: u32,
    line_seqno: [u32; 2],
}

impl Edges {
    fn take(&mut self, edge: &Edge) -> Result<(), Fault> {
        let line_seqno = &mut self.line_seqno[edge.node.index()];
        self.count = self.count.wrapping_add(1);
        self.highest_seqno = later(self.highest_seqno, edge.seqno);
        *line_seqno = line_seqno.wrapping_add(1);
        if edge.line_seqno == *line_seqno { Ok(()) } else { Err(Fault::LostEvent) }
    }

    /// A number of the whole request is drawn by the interrupt (`edge_irq_handler` of drivers/gpio/gpiolib-cdev.c), the edge
    /// queued by a thread of its line (`edge_irq_thread`): that of B may come before that of A, but there are as many edges as
    /// numbers, or a second interrupt has overwritten the stamp of a first.
    fn complete(&self) -> Result<(), Fault> {
        let numbers = self.highest_seqno.wrapping_sub(self.armed.seqno);
        if numbers == self.count { Ok(()) } else { Err(Fault::CoalescedEdge) }
    }
}

/// A discharge from its start on.
struct Fall<'a, P> {
    pins: &'a mut P,
    plan: &'a Plan,
    start: Bracket,
    switch: Option<Switch>,
    wait_until: Nanos,
    crossings: [Option<Nanos>; 2],
    waited: Option<Nanos>,
    edges: Edges,
}

impl<P: Pins> Fall<'_, P> {
    /// By one call for each line, so that each line moves as long after the entry of its call as that which started the
    /// discharge: in a call for several lines it would be another time, and unknown.
    fn switch_to(&mut self, to: Through) -> Result<(), End> {
        let first = self.plan.through.drives();
        let released = narrow(self.pins.drive(first.only(to.drives()))?, self.plan)?;
        let sinks_already = first.contains(to.drives());
        let sunk = if sinks_already { released } else { narrow(self.pins.drive(to.drives())?, self.plan)? };
        let since_entry = |bracket: Bracket| (bracket.before - self.start.before).as_ns();
        self.switch = Some(Switch { at_ns: since_entry(released), on_ns: since_entry(sunk), to });
        self.wait_until = sunk.after + self.plan.timeout;
        Ok(())
    }

    /// Waits for the crossings. A discharge that does not end in time is finished through another resistor if that is
    /// planned, and given up otherwise.
    fn watch(&mut self) -> Result<(), End> {
        while !self.is_complete() {
            let next = usize::from(self.crossings[0].is_some());
            if let Some(after) = self.plan.expected[next] {
                self.pins.rest_before_edge(self.start.before + after)?;
            }
            let may_go_on = match self.pins.edge(self.wait_until)? {
                Some(edge) => self.crossed(edge)?,
                None => false,
            };
            if may_go_on || self.is_complete() {
                continue;
            }
            match self.plan.limit {
                Some(to) if self.switch.is_none() => self.switch_to(to)?,
                _ => {
                    self.waited = Some(self.wait_until);
                    self.check_missed()?;
                    break;
                }
            }
        }
        Ok(self.edges.complete()?)
    }

    fn is_complete(&self) -> bool {
        self.crossings[0].is_some() && (self.plan.last == Node::A || self.crossings[1].is_some())
    }

    /// A second edge of one node is chatter at the threshold: the first counts. Whether the wait may go on: for a node that
    /// chatters for ever it must not last for ever.
    fn crossed(&mut self, edge: Edge) -> Result<bool, Fault> {
        self.edges.take(&edge)?;
        let crossing = &mut self.crossings[edge.node.index()];
        let is_chatter = crossing.is_some();
        if edge.at >= self.start.before && !is_chatter {
            *crossing = Some(edge.at);
        }
        Ok(!(is_chatter && edge.at > self.wait_until))
    }

    /// Of two edges that should have come, the last one alone may do.
    fn check_missed(&mut self) -> Result<(), End> {
        let levels = self.pins.levels()?;
        let missed = |node: Node| self.crossings[node.index()].is_none() && !levels.of(node);
        let any = missed(self.plan.last) || (missed(Node::A) && self.crossings[1].is_none());
        if any { Err(Fault::MissedEdge.into()) } else { Ok(()) }
    }

    /// A line moves somewhere within the call that switches it, always in the same place: then the time between two
    /// moves, each by a call for one line, is the difference of the entries of the calls, whatever that place is. Crossings
    /// are counted from the middle of such a call. Two lines that one call sinks (QERM) move one after the other; the
    /// second takes as much longer as the call does.
    fn record(&self) -> Record {
        let call_ns = self.start.width().as_ns();
        let single_ns = self.plan.single_call.map_or(call_ns, Nanos::as_ns);
        let since_start = |at: Nanos| (at - self.start.before).as_ns() - single_ns / 2.0;
        let [a_ns, b_ns] = self.crossings.map(|crossing| crossing.map(since_start));
        let is_pair = self.plan.through.drives().count() > 1;
        Record {
            through: self.plan.through,
            start: self.start.before,
            second_ns: is_pair.then(|| (call_ns - single_ns).max(0.0)),
            switch: self.switch,
            a_ns,
            b_ns,
            // Anywhere in the middle half of its call, each of two lines.
            u_switch_ns: Some(single_ns / 2.0 / 6f64.sqrt()),
            waited_ns: self.waited.map(since_start),
        }
    }
}

#[cfg(test)]
mod tests;
