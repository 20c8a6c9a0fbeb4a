//! The triggering thread: what readings come to for each channel that has a trigger, and the lines that follow them.
//!
//! A thread of its own, because each of the others may wait: the measuring thread for the pins, whose silence has to be noticed,
//! and the main thread for a crowd of clients; and because the line of a slow chip would delay a discharge. Readings come
//! through a ring, events leave through another; an event descriptor wakes who reads.

use super::ending;
use super::limits::{EVENT_RING, NAP, OUTPUT_AGAIN, RING};
use crate::config::{TriggerSettings, When};
use crate::pins::chardev::ChardevError;
use crate::pins::monotonic;
use crate::pins::output::{Output, OutputLine, Way};
use crate::pins::realtime::{Realtime, Wishes};
use crate::reading::Reading;
use crate::trigger::{Event, State, Trigger};
use crate::units::Nanos;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::eventfd::{EfdFlags, EventFd};
use rtrb::{Consumer, Producer, RingBuffer};
use std::io;
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// An event, and the index of its channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChannelEvent {
    /// In the configuration.
    pub channel: usize,
    /// What has changed.
    pub event: Event,
}

/// Where the measuring thread leaves readings for this one. Never waits; what has no room is lost.
#[derive(Debug)]
pub struct Tap {
    readings: Producer<Reading>,
    /// Whether each channel has a trigger.
    wanted: Vec<bool>,
    shared: Arc<TriggerControl>,
}

impl Tap {
    /// Takes a reading, if it is of a channel with a trigger.
    pub fn give(&mut self, reading: &Reading) {
        if self.wanted.get(reading.channel) == Some(&true) && self.readings.push(*reading).is_ok() {
            // It fails only when the counter would overflow: then it is readable anyway.
            let _ = self.shared.heard.write(1);
        }
    }
}

#[derive(Debug)]
struct TriggerControl {
    stop: AtomicBool,
    beat: AtomicU64,
    /// There are readings.
    heard: EventFd,
    /// There are events.
    told: EventFd,
}

/// A running thread. Dropping it makes every output inactive, then an input.
#[derive(Debug)]
pub struct Triggering {
    shared: Arc<TriggerControl>,
    events: Consumer<ChannelEvent>,
    thread: Option<JoinHandle<()>>,
}

impl Triggering {
    /// Starts, with every output inactive until something is known. `opened`: from [`open`], in the order of `triggers`.
    ///
    /// # Errors
    /// The system has no descriptor or thread left.
    pub fn start(
        triggers: Vec<TriggerSettings>,
        opened: Vec<Option<Output>>,
        way: Way,
        wishes: &Wishes,
    ) -> io::Result<(Triggering, Tap)> {
        let (readings, from) = RingBuffer::new(RING);
        let (to, events) = RingBuffer::new(EVENT_RING);
        let wake =
            || Ok::<_, io::Error>(EventFd::from_flags(EfdFlags::EFD_CLOEXEC | EfdFlags::EFD_NONBLOCK)?);
        let shared = Arc::new(TriggerControl {
            stop: AtomicBool::new(false),
            beat: AtomicU64::new(0),
            heard: wake()?,
            told: wake()?,
        });
        let channels = triggers.iter().map(|trigger| trigger.channel + 1).max().unwrap_or(0);
        let has_trigger = |channel| triggers.iter().any(|trigger| trigger.channel == channel);
        let wanted = (0..channels).map(has_trigger).collect();
        let armed = triggers
            .into_iter()
            .zip(opened)
            .map(|(settings, output)| ArmedTrigger::new(settings, output, way));
        let worker = Worker { shared: Arc::clone(&shared), from, to, armed: armed.collect() };
        // Late enough to matter where it runs; not worth a processor of its own.
        let wishes = Wishes { fifo_priority: wishes.fifo_priority, ..Wishes::default() };
        let thread = thread::Builder::new().name("cermd-trigger".to_owned()).spawn(move || {
            let _rights = Realtime::request(&wishes);
            worker.run();
        })?;
        let tap = Tap { readings, wanted, shared: Arc::clone(&shared) };
        Ok((Triggering { shared, events, thread: Some(thread) }, tap))
    }

    /// Readable when there are events.
    pub fn wake(&self) -> &EventFd {
        &self.shared.told
    }

    /// What has happened since the last call.
    pub fn take(&mut self) -> Vec<ChannelEvent> {
        // Empty when nothing was written since: that is no error.
        let _ = self.shared.told.read();
        std::iter::from_fn(|| self.events.pop().ok()).collect()
    }

    /// Changes while the thread is alive and not stuck.
    pub fn beat(&self) -> u64 {
        self.shared.beat.load(Ordering::Relaxed)
    }

    /// Whether the thread has ended by itself, which it never should.
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Stops the thread and waits for its end: every output is inactive, then an input. That nothing is known any more can still
    /// be taken.
    pub fn stop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        let _ = self.shared.heard.write(1);
        if ending::end(&mut self.thread).is_err() {
            log::error!("the triggering thread hangs in a call for its outputs: they stay as they are");
        }
    }
}

impl Drop for Triggering {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Takes the lines of the outputs, inactive.
///
/// # Errors
/// The first one that cannot be had.
pub fn open(triggers: &[TriggerSettings], way: Way) -> Result<Vec<Option<Output>>, ChardevError> {
    let lines = triggers.iter().map(|trigger| trigger.output.as_ref());
    lines.map(|output| output.map(|(line, _)| Output::open(line, way)).transpose()).collect()
}

/// A trigger and its output.
struct ArmedTrigger {
    channel: usize,
    id: String,
    trigger: Trigger,
    output: Option<Following>,
}

/// An output that follows a trigger.
struct Following {
    line: OutputLine,
    when: When,
    way: Way,
    /// `None`: it has failed.
    held: Option<Output>,
    /// When it is tried again.
    again_at: Nanos,
    /// Whether the log knows that it has failed.
    is_said: bool,
}

impl ArmedTrigger {
    fn new(settings: TriggerSettings, held: Option<Output>, way: Way) -> ArmedTrigger {
        let TriggerSettings { channel, id, rules, output } = settings;
        let following =
            |(line, when)| Following { line, when, way, held, again_at: Nanos::ZERO, is_said: false };
        ArmedTrigger { channel, id, trigger: Trigger::new(rules), output: output.map(following) }
    }

    /// The line first: who listens can wait.
    fn follow(&mut self, event: Event) -> ChannelEvent {
        if let Some(output) = &mut self.output {
            output.set(event.state, &self.id);
        }
        ChannelEvent { channel: self.channel, event }
    }
}

impl Following {
    fn set(&mut self, state: State, id: &str) {
        let Some(output) = &mut self.held else { return };
        if let Err(error) = output.set(self.when.is_active(state)) {
            self.held = None;
            self.again_at = monotonic() + OUTPUT_AGAIN;
            self.complain(&error, id);
        }
    }

    fn complain(&mut self, error: &dyn std::error::Error, id: &str) {
        if !self.is_said {
            self.is_said = true;
            log::error!("channel {id}: {error}; the output is tried again every second");
        }
    }

    /// Takes a line that has failed again, and sets it as it has to be.
    fn mend(&mut self, state: State, id: &str, now: Nanos) {
        if self.held.is_none() && now >= self.again_at {
            self.again_at = now + OUTPUT_AGAIN;
            match Output::open(&self.line, self.way) {
                Ok(output) => {
                    self.held = Some(output);
                    if std::mem::take(&mut self.is_said) {
                        log::info!("channel {id}: the output works again");
                    }
                    self.set(state, id);
                }
                Err(error) => self.complain(&error, id),
            }
        }
    }
}

struct Worker {
    shared: Arc<TriggerControl>,
    from: Consumer<Reading>,
    to: Producer<ChannelEvent>,
    armed: Vec<ArmedTrigger>,
}

impl Worker {
    fn run(mut self) {
        while !self.shared.stop.load(Ordering::Relaxed) {
            self.shared.beat.fetch_add(1, Ordering::Relaxed);
            self.wait();
            // Empty when nothing was written since: that is no error.
            let _ = self.shared.heard.read();
            while let Ok(reading) = self.from.pop() {
                self.take(&reading);
            }
            self.look(monotonic());
        }
        let now = monotonic();
        self.each_armed(|trigger| trigger.forget(now));
    }

    /// Until there are readings, or something known gets too old; a nap at most.
    fn wait(&self) {
        let now = monotonic();
        let due = self.armed.iter().filter_map(|armed| armed.trigger.look_at()).min().unwrap_or(Nanos::MAX);
        let patience = (due - now).max(Nanos::ZERO).min(NAP);
        // Rounded up: a look too early would only be made again.
        let timeout = Duration::from_nanos(patience.0.unsigned_abs()) + Duration::from_micros(999);
        let mut descriptors = [PollFd::new(self.shared.heard.as_fd(), PollFlags::POLLIN)];
        // A signal, or a kernel without memory: the next look is only sooner.
        let _ = poll(&mut descriptors, PollTimeout::try_from(timeout).unwrap_or(PollTimeout::MAX));
    }

    fn take(&mut self, reading: &Reading) {
        let told: Option<ChannelEvent> =
            self.armed.iter_mut().find(|armed| armed.channel == reading.channel).and_then(|armed| {
                let event = armed.trigger.take(reading)?;
                Some(armed.follow(event))
            });
        self.tell(told);
    }

    fn look(&mut self, now: Nanos) {
        self.each_armed(|trigger| trigger.look(now));
        for armed in &mut self.armed {
            if let Some(output) = &mut armed.output {
                output.mend(armed.trigger.state(), &armed.id, now);
            }
        }
    }

    /// Tells what becomes of each trigger.
    fn each_armed(&mut self, mut change: impl FnMut(&mut Trigger) -> Option<Event>) {
        for index in 0..self.armed.len() {
            let armed = &mut self.armed[index];
            let told = change(&mut armed.trigger).map(|event| armed.follow(event));
            self.tell(told);
        }
    }

    fn tell(&mut self, told: Option<ChannelEvent>) {
        if let Some(told) = told {
            // Only where the main thread has had no time for a thousand events.
            if self.to.push(told).is_err() {
                log::warn!("an event was lost: this process gets too little time");
            }
            let _ = self.shared.told.write(1);
        }
    }
}

#[cfg(test)]
mod tests;
