//! How edges travel from the pin to the program in Linux: stamps, sequence numbers and the event buffer, as in
//! drivers/gpio/gpiolib-cdev.c.

use super::latency::{ns, whole_ns};
use super::scene::{DelayScene, EventsScene, Scene};
use crate::circuit::Node;
use crate::pins::Edge;
use crate::pins::limits::EVENTS_A_LINE;
use crate::units::Nanos;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::Exp1;
use std::collections::VecDeque;

/// Edges on their way from the pin to the program. Nothing allocates after construction.
#[derive(Debug, Clone)]
pub(super) struct Events {
    queue: VecDeque<Edge>,
    capacity: usize,
    sense_lines: usize,
    late: Option<DelayScene>,
    troubles: EventsScene,
    /// Crossings are seen at the edges of this clock, ns.
    clock_ns: Option<i64>,
    seqno: u32,
    line_seqno: [u32; 2],
    last_stamp_ns: i64,
    rng: ChaCha8Rng,
}

impl Events {
    pub fn new(scene: &Scene, sense_lines: usize, rng: ChaCha8Rng) -> Events {
        let troubles = scene.events.unwrap_or_default();
        let capacity = troubles.buffer.map_or(EVENTS_A_LINE * sense_lines, |events| events as usize);
        Events {
            queue: VecDeque::with_capacity(capacity),
            capacity,
            sense_lines,
            late: scene.stamps,
            troubles,
            clock_ns: scene.clock_period.map(whole_ns),
            seqno: 0,
            line_seqno: [0; 2],
            last_stamp_ns: 0,
            rng,
        }
    }

    /// An input fell, `seen` seconds after `since_ns`; the program has waited since `idle_since_ns`. `tick_goes_on_ns`: for how long a tick
    /// keeps the processor from stamping at an instant.
    pub fn fell(
        &mut self,
        node: Node,
        since_ns: i64,
        seen: f64,
        idle_since_ns: i64,
        tick_goes_on_ns: impl Fn(i64) -> i64,
    ) {
        let EventsScene { lost, coalesced, bounce, b_later, .. } = self.troubles;
        if lost.is_some_and(|probability| self.rng.random::<f64>() < probability) {
            return;
        }
        let mut late_ns = self.late.map_or(0.0, |late| late.draw_ns(&mut self.rng));
        late_ns += ns(b_later.filter(|_| node == Node::B));
        let idle_ns = (since_ns - idle_since_ns) as f64 + seen * 1e9;
        let is_asleep = self.troubles.deep_sleep_after.is_some_and(|after| idle_ns > ns(after));
        late_ns += ns(self.troubles.deep_sleep_late.filter(|_| is_asleep));
        let mut interrupts = 1;
        // A second interrupt before the first one's thread has run: the stamp is of the second.
        if let Some((probability, bounce)) = coalesced.zip(bounce) {
            if self.rng.random::<f64>() < probability {
                late_ns += ns(bounce) * self.rng.sample::<f64, _>(Exp1);
                interrupts = 2;
            }
        }
        let stamp_ns = match self.clock_ns {
            Some(period) => next_edge(since_ns.saturating_add((seen * 1e9).ceil() as i64), period),
            None => since_ns.saturating_add((seen * 1e9 + late_ns).round() as i64),
        };
        let stamp_ns = stamp_ns.saturating_add(tick_goes_on_ns(stamp_ns));
        // One handler serves the lines of a chip in turn: a later edge is never stamped earlier.
        self.last_stamp_ns = stamp_ns.max(self.last_stamp_ns);
        self.push(node, interrupts);
    }

    fn push(&mut self, node: Node, interrupts: u32) {
        let line_seqno = &mut self.line_seqno[node.index()];
        *line_seqno = line_seqno.wrapping_add(1);
        // Each interrupt counts where the request has several lines; a single line's number counts events.
        self.seqno = self.seqno.wrapping_add(if self.sense_lines > 1 { interrupts } else { 1 });
        if self.queue.len() == self.capacity {
            self.queue.pop_front();
        }
        let at = Nanos(self.last_stamp_ns);
        self.queue.push_back(Edge { node, at, seqno: self.seqno, line_seqno: *line_seqno });
    }

    /// When the oldest edge was or will be stamped, ns.
    pub fn next_stamp_ns(&self) -> Option<i64> {
        self.queue.front().map(|edge| edge.at.0)
    }

    pub fn take(&mut self) -> Option<Edge> {
        self.queue.pop_front()
    }

    /// Forgets every edge; answers with the last sequence numbers.
    pub fn drain(&mut self) -> (u32, [u32; 2]) {
        self.queue.clear();
        (self.seqno, self.line_seqno)
    }
}

/// The first edge of a clock at or after an instant; ns.
pub(super) fn next_edge(at_ns: i64, period_ns: i64) -> i64 {
    let phase = at_ns.rem_euclid(period_ns);
    if phase == 0 { at_ns } else { at_ns.saturating_add(period_ns - phase) }
}
