//! One discharge, without input or output: charge, settle, arm, start, [planned switch], crossings, stop.
//!
//! For: turning a [`Plan`] into a [`Record`] or a named [`Fault`], each wait bounded, lines broken before made.
//! Must not know: clocks, kernels, or what the times mean. [`Discharge`] answers each event with the next
//! [`Action`]; [`run`] is the few lines that carry the actions out on real or simulated [`Pins`].

use crate::pins::{Armed, Bracket, Drives, Edge, Levels, Node, Pins, PinsError};
use crate::reading::Fault;
use crate::record::{Record, Switch, Through};
use crate::units::Nanos;

/// What one discharge is to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// What to discharge through first.
    pub through: Through,
    /// After how long to switch, and to what. Comes to nothing if the last node crosses earlier.
    pub switch: Option<(Nanos, Through)>,
    /// Chargers of the circuit.
    pub chargers: Drives,
    /// The node whose crossing ends the discharge: B, or A in circuits that have no other.
    pub last: Node,
    /// How long to charge.
    pub charge: Nanos,
    /// How long to leave everything floating between charge and start.
    pub settle: Nanos,
    /// When the nodes are expected to cross; `None`: not known.
    pub forecast: Option<Forecast>,
    /// The longest wait for the last crossing, from the start.
    pub timeout: Nanos,
    /// The longest call that still tells when a line was switched.
    pub widest_bracket: Nanos,
    /// How long a call for one line usually takes; `None`: not known yet.
    pub single_call: Option<Nanos>,
}

/// When the nodes cross if the resistors are what they last were. Times of A and B, ns, offset d included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    /// In a full discharge through what runs first.
    pub first_ns: [f64; 2],
    /// In one through what runs after the switch.
    pub next_ns: [f64; 2],
    /// The offset d, ns.
    pub d_ns: f64,
}

impl Forecast {
    /// When a node crosses after a switch at `at` that was complete at `on`: what is left of the way, at the speed of the
    /// resistor that runs then. `None` if it crossed before.
    fn after_switch_ns(&self, node: Node, at_ns: f64, on_ns: f64) -> Option<f64> {
        let [first, next] = [self.first_ns, self.next_ns].map(|times| times[node.index()] - self.d_ns);
        let left = 1.0 - at_ns / first;
        (left > 0.0).then_some(on_ns + left * next + self.d_ns)
    }
}

/// For so long before and after an expected crossing the processor is kept awake. A processor that sleeps stamps an edge
/// later, by an amount that depends on how long and how deep it slept, and a difference in lateness is a bias.
pub const AWAKE: Nanos = Nanos(10_000);

impl Through {
    /// The lines that sink for this discharge.
    pub fn drives(self) -> Drives {
        match self {
            Through::C1 => Drives::C1,
            Through::C2 | Through::C12 => Drives::C2,
            Through::X(channel) => Drives::x(channel),
            Through::XWithC12(channel) => Drives::x(channel).and(Drives::C2),
        }
    }
}

/// What is to be done next on the pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// [`Pins::drive`].
    Drive(Drives),
    /// [`Pins::sleep_until`].
    Sleep(Nanos),
    /// [`Pins::arm`].
    Arm,
    /// [`Pins::edge`].
    WaitEdge(Nanos),
    /// [`Pins::levels`].
    ReadLevels,
    /// Nothing: take the [`Discharge::result`].
    Done,
}

/// What came of an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Lines were switched.
    Drove(Bracket),
    /// The instant has come.
    Slept,
    /// Edges are watched.
    Armed(Armed),
    /// An edge, or none until the instant.
    Edge(Option<Edge>),
    /// The levels.
    Levels(Levels),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Charging,
    Charged,
    Floating,
    Settled,
    Arming,
    Starting,
    BeforeSwitch,
    Releasing,
    Switching,
    /// Asleep until shortly before this crossing.
    Expecting(Nanos),
    /// Awake until shortly after it.
    Awake,
    Crossing,
    TimedOut,
    Stopping,
}

/// The state of one discharge.
#[derive(Debug, Clone)]
pub struct Discharge {
    plan: Plan,
    phase: Phase,
    start: Bracket,
    /// The release of the first resistor; the sinking of the next one, unless it was sunk before.
    switch: Option<[Bracket; 2]>,
    crossings: [Option<Nanos>; 2],
    /// Whether its crossing has been waited for awake.
    awaited: [bool; 2],
    seqno: u32,
    line_seqno: [u32; 2],
    waited: Nanos,
    fault: Option<Fault>,
}

impl Discharge {
    /// A discharge to be done; the first action is to charge.
    pub fn new(plan: Plan) -> (Discharge, Action) {
        let discharge = Discharge {
            plan,
            phase: Phase::Charging,
            start: Bracket::default(),
            switch: None,
            crossings: [None; 2],
            awaited: [false; 2],
            seqno: 0,
            line_seqno: [0; 2],
            waited: Nanos::ZERO,
            fault: None,
        };
        (discharge, Action::Drive(plan.chargers))
    }

    /// Takes what came of the last action, and answers the next one.
    ///
    /// An event that does not belong to the last action is a mistake of the caller; it stops the discharge with
    /// [`Fault::Pins`].
    pub fn handle(&mut self, event: Event) -> Action {
        match (self.phase, event) {
            (Phase::Charging, Event::Drove(bracket)) => {
                self.phase = Phase::Charged;
                Action::Sleep(bracket.after + self.plan.charge)
            }
            (Phase::Charged, Event::Slept) => {
                self.phase = Phase::Floating;
                Action::Drive(Drives::NONE)
            }
            (Phase::Floating, Event::Drove(bracket)) if self.plan.settle > Nanos::ZERO => {
                self.phase = Phase::Settled;
                Action::Sleep(bracket.after + self.plan.settle)
            }
            (Phase::Floating, Event::Drove(_)) | (Phase::Settled, Event::Slept) => {
                self.phase = Phase::Arming;
                Action::Arm
            }
            (Phase::Arming, Event::Armed(armed)) => self.armed(armed),
            (Phase::Starting, Event::Drove(bracket)) => self.started(bracket),
            (Phase::BeforeSwitch, Event::Slept) => self.release_first(),
            (Phase::Releasing, Event::Drove(bracket)) => self.released(bracket),
            (Phase::Switching, Event::Drove(bracket)) => self.sunk(bracket),
            (Phase::Expecting(at), Event::Slept) => {
                self.phase = Phase::Awake;
                Action::Sleep(at + AWAKE)
            }
            (Phase::Awake, Event::Slept) => self.wait_for_edge(),
            (Phase::Crossing, Event::Edge(Some(edge))) => self.crossed(edge),
            (Phase::Crossing, Event::Edge(None)) => {
                self.phase = Phase::TimedOut;
                Action::ReadLevels
            }
            (Phase::TimedOut, Event::Levels(levels)) => self.timed_out(levels),
            (Phase::Stopping, Event::Drove(_)) => Action::Done,
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

    /// How long the call took that started it; `None` if it never started.
    pub fn start_call(&self) -> Option<Nanos> {
        (self.start != Bracket::default()).then(|| self.start.width())
    }

    fn armed(&mut self, armed: Armed) -> Action {
        let charged = armed.levels.a && (armed.levels.b || self.plan.last == Node::A);
        if !charged {
            return self.stop(Some(Fault::NoCharge));
        }
        self.seqno = armed.seqno;
        self.line_seqno = armed.line_seqno;
        self.phase = Phase::Starting;
        Action::Drive(self.plan.through.drives())
    }

    fn started(&mut self, bracket: Bracket) -> Action {
        self.start = bracket;
        if bracket.width() > self.plan.widest_bracket {
            return self.stop(Some(Fault::WideBracket));
        }
        match self.plan.switch {
            Some((after, _)) => {
                self.phase = Phase::BeforeSwitch;
                Action::Sleep(bracket.before + after)
            }
            None => self.wait(),
        }
    }

    /// A switch is two calls for one line each, like the start: so each line moves in the same place of its call. In one
    /// call for both, the first one moves later after the entry than the only one of a start does (0.5 us on an emulated
    /// arm64, where it made 1 ohm at 100 ohm).
    fn release_first(&mut self) -> Action {
        match self.plan.switch {
            Some((_, to)) => {
                self.phase = Phase::Releasing;
                Action::Drive(self.plan.through.drives().only(to.drives()))
            }
            None => self.stop(Some(Fault::Pins)),
        }
    }

    fn released(&mut self, bracket: Bracket) -> Action {
        self.switch = Some([bracket; 2]);
        match self.plan.switch {
            _ if bracket.width() > self.plan.widest_bracket => self.stop(Some(Fault::WideBracket)),
            Some((_, to)) if !self.plan.through.drives().contains(to.drives()) => {
                self.phase = Phase::Switching;
                Action::Drive(to.drives())
            }
            _ => self.wait(),
        }
    }

    fn sunk(&mut self, bracket: Bracket) -> Action {
        if let Some([_, sunk]) = &mut self.switch {
            *sunk = bracket;
        }
        if bracket.width() > self.plan.widest_bracket {
            return self.stop(Some(Fault::WideBracket));
        }
        self.wait()
    }

    /// Edges are kept by the kernel meanwhile, so sleeping never misses one.
    fn wait(&mut self) -> Action {
        let next = Node::BOTH.into_iter().find(|node| self.crossings[node.index()].is_none());
        let expected = next.filter(|node| !std::mem::replace(&mut self.awaited[node.index()], true));
        match expected.and_then(|node| self.expected(node)) {
            Some(at) if at < self.start.before + self.plan.timeout => {
                self.phase = Phase::Expecting(at);
                Action::Sleep(at - AWAKE)
            }
            _ => self.wait_for_edge(),
        }
    }

    fn expected(&self, node: Node) -> Option<Nanos> {
        let forecast = self.plan.forecast?;
        let full = forecast.first_ns[node.index()];
        let switched = self.switch.and_then(|[released, sunk]| {
            let [at, on] = [released, sunk].map(|call| (call.before - self.start.before).as_ns());
            forecast.after_switch_ns(node, at, on)
        });
        Some(self.start.before + Nanos((switched.unwrap_or(full) + self.single_ns() / 2.0) as i64))
    }

    /// How long a call for one line takes, ns.
    fn single_ns(&self) -> f64 {
        self.plan.single_call.unwrap_or(self.start.width()).as_ns()
    }

    fn wait_for_edge(&mut self) -> Action {
        self.phase = Phase::Crossing;
        Action::WaitEdge(self.start.before + self.plan.timeout)
    }

    /// Sequence numbers follow on or something was lost: `edge_irq_handler` and `edge_irq_thread` of
    /// drivers/gpio/gpiolib-cdev.c. A second edge of one node is chatter at the threshold: the first counts.
    fn crossed(&mut self, edge: Edge) -> Action {
        let node = edge.node.index();
        self.seqno = self.seqno.wrapping_add(1);
        self.line_seqno[node] = self.line_seqno[node].wrapping_add(1);
        if edge.line_seqno != self.line_seqno[node] {
            return self.stop(Some(Fault::LostEvent));
        }
        if edge.seqno != self.seqno {
            return self.stop(Some(Fault::CoalescedEdge));
        }
        if edge.at >= self.start.before && self.crossings[node].is_none() {
            self.crossings[node] = Some(edge.at);
        }
        let complete =
            self.crossings[0].is_some() && (self.plan.last == Node::A || self.crossings[1].is_some());
        if complete { self.stop(None) } else { self.wait() }
    }

    fn timed_out(&mut self, levels: Levels) -> Action {
        self.waited = self.start.before + self.plan.timeout;
        let missed = |node: Node| self.crossings[node.index()].is_none() && !levels.of(node);
        let any = missed(Node::A) || (self.plan.last == Node::B && missed(Node::B));
        self.stop(any.then_some(Fault::MissedEdge))
    }

    fn stop(&mut self, fault: Option<Fault>) -> Action {
        self.fault = self.fault.or(fault);
        self.phase = Phase::Stopping;
        Action::Drive(Drives::NONE)
    }

    /// A line moves somewhere within the call that switches it, always in the same place: as long after the entry
    /// of the call as in a call for one line only (half of its length), and the last of several lines as long before
    /// the exit. Then the time from start to switch is the difference of two entries, whatever that place is.
    fn record(&self) -> Record {
        let single_ns = self.single_ns();
        let since_start = |at: Nanos| (at - self.start.before).as_ns() - single_ns / 2.0;
        let between_starts = |call: Bracket| (call.before - self.start.before).as_ns();
        let [a_ns, b_ns] = self.crossings.map(|crossing| crossing.map(since_start));
        let starts_two = self.plan.through.drives().count() > 1;
        let second_ns = (self.start.width().as_ns() - single_ns).max(0.0);
        Record {
            through: self.plan.through,
            start: self.start.before,
            second_ns: if starts_two { second_ns } else { 0.0 },
            switch: self.switch.zip(self.plan.switch).map(|([released, sunk], (_, to))| Switch {
                at_ns: between_starts(released),
                on_ns: between_starts(sunk),
                to,
            }),
            a_ns,
            b_ns,
            u_switch_ns: single_ns / 12f64.sqrt(),
            waited_ns: if self.waited == Nanos::ZERO { 0.0 } else { since_start(self.waited) },
        }
    }
}

/// Releases every line when it goes out of scope, also on an error or a panic.
struct Release<'a, P: Pins>(&'a mut P);

impl<P: Pins> Drop for Release<'_, P> {
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
    /// [`Discharge::start_call`].
    pub start_call: Option<Nanos>,
}

/// Carries one discharge out. All lines are inputs when it returns, whatever happened.
///
/// # Errors
/// Only if the pins cannot be used; what the circuit did is in the [`Outcome`].
pub fn run<P: Pins>(pins: &mut P, plan: Plan) -> Result<Outcome, PinsError> {
    let (mut discharge, mut action) = Discharge::new(plan);
    let pins = Release(pins);
    loop {
        let event = match action {
            Action::Drive(on) => Event::Drove(pins.0.drive(on)?),
            Action::Sleep(at) => {
                pins.0.sleep_until(at)?;
                Event::Slept
            }
            Action::Arm => Event::Armed(pins.0.arm()?),
            Action::WaitEdge(until) => Event::Edge(pins.0.edge(until)?),
            Action::ReadLevels => Event::Levels(pins.0.levels()?),
            Action::Done => {
                // The last action has released every line already.
                std::mem::forget(pins);
                return Ok(Outcome { result: discharge.result(), start_call: discharge.start_call() });
            }
        };
        action = discharge.handle(event);
    }
}

#[cfg(test)]
mod tests;
