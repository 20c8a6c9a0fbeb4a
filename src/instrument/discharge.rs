//! One discharge, without input or output: \[drain\], charge, arm, settle, start, [planned switch], crossings.
//!
//! Calls whose times count are made alike: a chip that was left alone for some microseconds, or the way to it, sleeps, and
//! then a line moves later in its call. So levels are read shortly before a planned instant, which wakes whatever sleeps, and
//! the rest of the time is spun away.
//!
//! A [`Plan`] becomes a [`Record`] or a named [`Fault`]; each wait is bounded, lines are broken before made. [`Discharge`]
//! answers each event with the next [`Action`]; [`run()`] is the few lines that carry the actions out on real or simulated
//! [`Pins`].

mod action;
mod calls;
mod clear;
mod lead;
mod plan;
mod run;

use crate::circuit::Node;
use crate::instrument::limits::LONGEST_PAUSE;
#[cfg(doc)]
use crate::pins::Pins;
use crate::pins::{Armed, Bracket, Drives, Edge, Levels, later};
use crate::reading::Fault;
use crate::record::{Record, Switch, Through};
use crate::units::Nanos;
pub use action::{Action, Event};
pub use calls::{Call, Calls, UsualCall};
use clear::clear_start;
pub use lead::Lead;
pub use plan::{Charge, Falls, Plan};
pub use run::{Outcome, run, run_on};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Draining,
    Drained,
    /// Through A alone, then through all chargers.
    ChargingA,
    ChargedA,
    Charging,
    Charged,
    Floating,
    Arming(Nanos),
    /// Until shortly before a call that is timed.
    Napping(Nanos, Timed),
    /// Reading levels, so that whatever sleeps is awake.
    Waking(Nanos, Timed),
    Awake(Timed),
    Starting,
    Releasing(Through),
    Sinking(Through),
    Crossing,
    TimedOut,
}

/// A call whose instant counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Timed {
    Start,
    Switch(Through),
    /// The end of a hold.
    Sink(Through),
}

/// A switch that was made, by two calls for one line each: one that releases, one that sinks.
#[derive(Debug, Clone, Copy)]
struct SwitchMade {
    released: Nanos,
    sunk: Nanos,
    to: Through,
}

/// The state of one discharge.
#[derive(Debug, Clone)]
pub struct Discharge {
    plan: Plan,
    /// How long before a timed call levels are read.
    lead: Nanos,
    /// How often the kernel interrupts whatever runs, if that is known.
    tick: Option<Nanos>,
    phase: Phase,
    /// When the chargers let go.
    floating: Nanos,
    start: Bracket,
    calls: Calls,
    switch: Option<SwitchMade>,
    wait_until: Nanos,
    crossings: [Option<Nanos>; 2],
    /// The last number before it, the highest since, and how many edges have come.
    armed_seqno: u32,
    highest_seqno: u32,
    edges: u32,
    line_seqno: [u32; 2],
    waited: Option<Nanos>,
    charged: Option<Levels>,
    fault: Option<Fault>,
}

impl Discharge {
    /// A discharge to be done; the first action is to drain or to charge.
    pub fn new(plan: Plan, lead: Nanos, tick: Option<Nanos>) -> (Discharge, Action) {
        let mut discharge = Discharge {
            plan,
            lead,
            tick,
            phase: Phase::Draining,
            floating: Nanos::ZERO,
            start: Bracket::default(),
            calls: [None; 3],
            switch: None,
            wait_until: Nanos::ZERO,
            crossings: [None; 2],
            armed_seqno: 0,
            highest_seqno: 0,
            edges: 0,
            line_seqno: [0; 2],
            waited: None,
            charged: None,
            fault: None,
        };
        let drains = plan.drain > Nanos::ZERO;
        let first = if drains { Action::Drive(Drives::C1) } else { discharge.charge() };
        (discharge, first)
    }

    fn charge(&mut self) -> Action {
        if self.plan.charge.alone > Nanos::ZERO {
            self.phase = Phase::ChargingA;
            return Action::Drive(Drives::CHARGE_A);
        }
        self.phase = Phase::Charging;
        Action::Drive(self.plan.chargers)
    }

    /// Takes what came of the last action, and answers the next one.
    ///
    /// An event that does not belong to the last action is a mistake of the caller; it stops the discharge with
    /// [`Fault::Pins`].
    pub fn handle(&mut self, event: Event) -> Action {
        match (self.phase, event) {
            (Phase::Draining, Event::Drove(bracket)) => {
                self.phase = Phase::Drained;
                Action::Rest(bracket.after + self.plan.drain)
            }
            (Phase::Drained, Event::Slept) => self.charge(),
            (Phase::ChargingA, Event::Drove(bracket)) => {
                self.phase = Phase::ChargedA;
                Action::Rest(bracket.after + self.plan.charge.alone)
            }
            (Phase::ChargedA, Event::Slept) if self.plan.charge.together > Nanos::ZERO => {
                self.phase = Phase::Charging;
                Action::Drive(self.plan.chargers)
            }
            (Phase::Charging, Event::Drove(bracket)) => {
                self.phase = Phase::Charged;
                Action::Rest(bracket.after + self.plan.charge.together)
            }
            (Phase::ChargedA | Phase::Charged, Event::Slept) => {
                self.phase = Phase::Floating;
                Action::Drive(Drives::NONE)
            }
            (Phase::Floating, Event::Drove(bracket)) => self.floating(bracket),
            (Phase::Arming(settled), Event::Armed(armed, now)) => self.armed(armed, now, settled),
            (Phase::Napping(at, call), Event::Slept) => {
                self.phase = Phase::Waking(at, call);
                Action::ReadLevels
            }
            (Phase::Waking(_, Timed::Start), Event::Levels(levels)) if !self.is_charged(levels) => {
                self.stop(Some(Fault::NoCharge))
            }
            (Phase::Waking(at, call), Event::Levels(_)) => {
                self.phase = Phase::Awake(call);
                Action::Sleep(at)
            }
            (Phase::Awake(Timed::Start), Event::Slept) => self.start(),
            (Phase::Awake(Timed::Switch(to)), Event::Slept) => self.switch_to(to),
            (Phase::Awake(Timed::Sink(to)), Event::Slept) => self.sink(to),
            (Phase::Starting, Event::Drove(bracket)) => self.started(bracket),
            (Phase::Releasing(to), Event::Drove(bracket)) => self.released(bracket, to),
            (Phase::Sinking(to), Event::Drove(bracket)) => self.sunk(bracket, to),
            (Phase::Crossing, Event::Edge(Some(edge))) => self.crossed(edge),
            (Phase::Crossing, Event::Edge(None)) => self.waited_long(),
            (Phase::TimedOut, Event::Levels(levels)) => self.timed_out(levels),
            _ => self.stop(Some(Fault::Pins)),
        }
    }

    /// The record, once the action is [`Action::Done`].
    ///
    /// # Errors
    /// The fault that ended the discharge.
    pub fn result(&self) -> Result<Record, Fault> {
        match self.fault {
            Some(fault) => Err(fault),
            None => Ok(self.record()),
        }
    }

    /// How long the calls took that switched one line each.
    pub fn calls(&self) -> &Calls {
        &self.calls
    }

    /// The levels after the charge; `None` if it never came to its end.
    pub fn charged(&self) -> Option<Levels> {
        self.charged
    }

    fn floating(&mut self, bracket: Bracket) -> Action {
        self.floating = bracket.before;
        self.phase = Phase::Arming(bracket.after + self.plan.settle);
        Action::Arm
    }

    fn armed(&mut self, armed: Armed, now: Option<Nanos>, settled: Nanos) -> Action {
        self.charged = Some(armed.levels);
        if !self.is_charged(armed.levels) {
            return self.stop(Some(Fault::NoCharge));
        }
        (self.armed_seqno, self.highest_seqno) = (armed.seqno, armed.seqno);
        self.line_seqno = armed.line_seqno;
        let soon = now.map_or(settled, |now| settled.max(now));
        let is_clear = clear_start(&self.plan, soon, self.tick) == soon;
        if !is_clear {
            return self.time(clear_start(&self.plan, soon + self.lead, self.tick), Timed::Start);
        }
        // Arming has read the levels just now.
        if self.plan.settle <= Nanos::ZERO { self.start() } else { self.time(settled, Timed::Start) }
    }

    fn is_charged(&self, levels: Levels) -> bool {
        levels.a && (levels.b || self.plan.last == Node::A)
    }

    fn time(&mut self, at: Nanos, call: Timed) -> Action {
        self.phase = Phase::Napping(at, call);
        Action::Sleep(at - self.lead)
    }

    fn start(&mut self) -> Action {
        self.phase = Phase::Starting;
        Action::Drive(self.plan.through.drives())
    }

    fn started(&mut self, bracket: Bracket) -> Action {
        self.start = bracket;
        self.wait_until = bracket.before + self.plan.timeout;
        let pause = bracket.before - self.floating - self.plan.settle;
        if self.took_too_long(Call::Start, bracket) || pause > LONGEST_PAUSE {
            return self.stop(Some(Fault::WideBracket));
        }
        match self.plan.switch {
            Some((after, to)) => self.time(bracket.before + after, Timed::Switch(to)),
            None => self.wait(),
        }
    }

    /// By one call for each line, so that each line moves as long after the entry of its call as that which started the
    /// discharge: in a call for several lines it would be another time, and unknown.
    fn switch_to(&mut self, to: Through) -> Action {
        self.phase = Phase::Releasing(to);
        let goes_on = if self.is_held() { Drives::NONE } else { to.drives() };
        Action::Drive(self.plan.through.drives().only(goes_on))
    }

    fn released(&mut self, bracket: Bracket, to: Through) -> Action {
        self.switch = Some(SwitchMade { released: bracket.before, sunk: bracket.before, to });
        if to == self.plan.through && !self.is_held() {
            // No line was touched.
            return self.wait_on(bracket);
        }
        if self.took_too_long(Call::Release, bracket) {
            return self.stop(Some(Fault::WideBracket));
        }
        if self.is_held() {
            return self.time(bracket.before + self.plan.hold, Timed::Sink(to));
        }
        match self.plan.through.drives().contains(to.drives()) {
            true => self.wait_on(bracket),
            false => self.sink(to),
        }
    }

    fn sink(&mut self, to: Through) -> Action {
        self.phase = Phase::Sinking(to);
        Action::Drive(to.drives())
    }

    fn is_held(&self) -> bool {
        self.plan.hold > Nanos::ZERO
    }

    fn sunk(&mut self, bracket: Bracket, to: Through) -> Action {
        self.switch = self.switch.map(|switch| SwitchMade { sunk: bracket.before, to, ..switch });
        if self.took_too_long(Call::Sink, bracket) {
            return self.stop(Some(Fault::WideBracket));
        }
        self.wait_on(bracket)
    }

    /// After the last call.
    fn wait_on(&mut self, bracket: Bracket) -> Action {
        self.wait_until = bracket.after + self.plan.timeout;
        self.wait()
    }

    /// Notes how long a call took; whether that was so long that a line may have moved anywhere.
    fn took_too_long(&mut self, call: Call, bracket: Bracket) -> bool {
        let is_for_one = call != Call::Start || !self.is_pair();
        self.calls[call as usize] = is_for_one.then(|| bracket.width());
        bracket.width() > self.plan.widest_bracket
    }

    fn is_pair(&self) -> bool {
        self.plan.through.drives().count() > 1
    }

    fn wait(&mut self) -> Action {
        self.phase = Phase::Crossing;
        let next = usize::from(self.crossings[0].is_some());
        let expected = self.plan.expected[next].map(|after| self.start.before + after);
        Action::WaitEdge { expected, until: self.wait_until }
    }

    fn waited_long(&mut self) -> Action {
        match self.plan.limit {
            Some(to) if self.switch.is_none() => self.time(self.wait_until, Timed::Switch(to)),
            _ => {
                self.phase = Phase::TimedOut;
                Action::ReadLevels
            }
        }
    }

    /// The numbers of a line follow on or something was lost. A second edge of one node is chatter at the threshold: the
    /// first counts.
    fn crossed(&mut self, edge: Edge) -> Action {
        let node = edge.node.index();
        self.edges = self.edges.wrapping_add(1);
        self.highest_seqno = later(self.highest_seqno, edge.seqno);
        self.line_seqno[node] = self.line_seqno[node].wrapping_add(1);
        if edge.line_seqno != self.line_seqno[node] {
            return self.stop(Some(Fault::LostEvent));
        }
        let is_chatter = self.crossings[node].is_some();
        if edge.at >= self.start.before && !is_chatter {
            self.crossings[node] = Some(edge.at);
        }
        let complete =
            self.crossings[0].is_some() && (self.plan.last == Node::A || self.crossings[1].is_some());
        match complete {
            true => self.stop(self.coalesced()),
            // A node that chatters for ever must not make the wait last for ever.
            false if is_chatter && edge.at > self.wait_until => self.waited_long(),
            false => self.wait(),
        }
    }

    /// A number of the whole request is drawn by the interrupt (`edge_irq_handler` of drivers/gpio/gpiolib-cdev.c), the edge
    /// queued by a thread of its line (`edge_irq_thread`): that of B may come before that of A, but there are as many edges as
    /// numbers, or a second interrupt has overwritten the stamp of a first.
    fn coalesced(&self) -> Option<Fault> {
        let numbers = self.highest_seqno.wrapping_sub(self.armed_seqno);
        (numbers != self.edges).then_some(Fault::CoalescedEdge)
    }

    fn timed_out(&mut self, levels: Levels) -> Action {
        self.waited = Some(self.wait_until);
        let missed = |node: Node| self.crossings[node.index()].is_none() && !levels.of(node);
        // Of two edges that should have come, the last one alone may do.
        let any = missed(self.plan.last) || (missed(Node::A) && self.crossings[1].is_none());
        self.stop(any.then_some(Fault::MissedEdge).or(self.coalesced()))
    }

    fn stop(&mut self, fault: Option<Fault>) -> Action {
        self.fault = self.fault.or(fault);
        Action::Done
    }

    /// A line moves somewhere within the call that switches it, always in the same place: then the time between two
    /// moves, each by a call for one line, is the difference of the entries of the calls, whatever that place is. Crossings
    /// are counted from the middle of such a call. Two lines that one call sinks (QERM) move one after the other; the
    /// second takes as much longer as the call does.
    fn record(&self) -> Record {
        let usual = self.plan.calls[Call::Start as usize];
        let single_ns = usual.map_or(self.start.width(), |usual| usual.length).as_ns();
        let since_entry = |at: Nanos| (at - self.start.before).as_ns();
        let since_start = |at: Nanos| since_entry(at) - single_ns / 2.0;
        let [a_ns, b_ns] = self.crossings.map(|crossing| crossing.map(since_start));
        Record {
            through: self.plan.through,
            start: self.start.before,
            second_ns: self.is_pair().then(|| (self.start.width().as_ns() - single_ns).max(0.0)),
            switch: self.switch.map(|switch| Switch {
                at_ns: since_entry(switch.released),
                on_ns: since_entry(switch.sunk),
                to: switch.to,
            }),
            a_ns,
            b_ns,
            // Anywhere in its call, each of two lines.
            u_switch_ns: Some(single_ns / 6f64.sqrt()),
            later_ns: calls::later_ns(&self.calls, &self.plan.calls),
            waited_ns: self.waited.map(since_start),
        }
    }
}

#[cfg(test)]
mod exhaustive;
#[cfg(test)]
mod tests;
