//! One client's part of the conversation, without its socket: which line it gets next.

use super::StatsSource;
use super::hub::{Content, Hub, Published};
use super::subscription::Subscription;
use crate::stream::limits::serving::{KEPT_OUTPUT_BYTES, KEPT_QUEUE_LINES};
use crate::stream::wire::{ErrorLine, LineSplitter, LineTooLong, ReadingLine, Request, Watch, to_line};
use std::collections::VecDeque;
use std::sync::Arc;

/// A queue of lines that are shared with other clients, a subscription, and at most one answer that was not read yet.
///
/// A client whose output is not empty is neither answered nor sent anything new. So it costs at most one answer, one
/// unfinished request of [`MAX_LINE_BYTES`](crate::stream::wire::MAX_LINE_BYTES), and a pointer for each line of its queue;
/// what is in the queues of all clients are the last lines that were published, each once.
#[derive(Debug)]
pub(super) struct Session {
    input: LineSplitter,
    /// Whole lines; the first `sent` bytes are with the kernel.
    output: Vec<u8>,
    sent: usize,
    /// What was published and not yet written, wanted or not.
    queue: VecDeque<Arc<Published>>,
    /// The lines that the queue holds at most.
    queue_lines: usize,
    /// The VERSION that the first reading in the queue belongs to, until it is written.
    version_due: Option<Arc<Published>>,
    /// The TAPE that the first discharge in the queue belongs to, until it is written.
    tape_due: Option<Arc<Published>>,
    /// The last event of each channel before the first line in the queue, until it is written.
    events_due: Vec<Arc<Published>>,
    /// Wanted lines that were lost between the last one it got and the first in the queue.
    lost: u64,
    subscription: Subscription,
}

impl Session {
    pub fn new(hub: &Hub, queue_lines: usize) -> Session {
        Session {
            input: LineSplitter::default(),
            output: Vec::new(),
            sent: 0,
            queue: VecDeque::new(),
            queue_lines: queue_lines.max(1),
            version_due: Some(Arc::clone(&hub.version)),
            tape_due: None,
            events_due: hub.last_events().cloned().collect(),
            lost: 0,
            subscription: Subscription::default(),
        }
    }

    /// Bytes from the client. Only while [`is_listening`](Session::is_listening).
    pub fn receive(&mut self, chunk: &[u8]) {
        self.input.feed(chunk);
    }

    /// The client has closed its side. It may go on reading.
    ///
    /// A last line without a newline is taken as ended: a truncated JSON object is never a valid one.
    pub fn receive_end(&mut self) {
        if self.input.is_amid_line() {
            self.input.feed(b"\n");
        }
    }

    /// Whether there is room for more requests.
    pub fn is_listening(&self) -> bool {
        self.output.is_empty() && !self.input.has_line()
    }

    pub fn watches(&self) -> bool {
        self.subscription.watch.enable
    }

    pub fn wants_raw(&self) -> bool {
        self.watches() && self.subscription.watch.raw
    }

    pub fn wants_readings(&self) -> bool {
        self.watches() && !self.subscription.watch.raw
    }

    /// Takes what was published into the queue. Returns how many wanted lines are lost: had to go for it, or never came.
    pub fn queue(&mut self, published: &Arc<Published>) -> u64 {
        if !self.subscription.is_of(&published.content) {
            return 0;
        }
        // Nothing was said under the one before.
        let is_version = |line: &Arc<Published>| matches!(line.content, Content::Version);
        if is_version(published) && self.queue.back().is_some_and(is_version) {
            self.queue.pop_back();
        }
        let lost = if self.queue.len() < self.queue_lines { 0 } else { self.drop_oldest() };
        self.queue.push_back(Arc::clone(published));
        self.lost += lost;
        lost + self.subscription.missed(&published.content)
    }

    /// Drops the oldest reading or discharge; what was announced around it is still due to those after it, and the last event of
    /// each channel. Returns 1 if it was wanted, else 0.
    fn drop_oldest(&mut self) -> u64 {
        let mut lost = None;
        while let Some(oldest) = self.queue.front() {
            match oldest.content {
                Content::Version => {
                    // Those were of the channels before.
                    self.events_due.clear();
                    self.version_due = self.queue.pop_front();
                }
                Content::Event(_) if lost.is_some() => break,
                Content::Event(_) => {
                    if let Some(event) = self.queue.pop_front() {
                        self.events_due.retain(|before| !is_of_same_channel(before, &event));
                        self.events_due.push(event);
                    }
                }
                Content::Tape => self.tape_due = self.queue.pop_front(),
                Content::Lost { .. } => {
                    self.lost += self.subscription.missed(&oldest.content);
                    self.queue.pop_front();
                }
                Content::Reading(_) | Content::Discharge(_) if lost.is_some() => break,
                Content::Reading(_) | Content::Discharge(_) => {
                    lost = Some(u64::from(self.subscription.wants(&oldest.content)));
                    self.queue.pop_front();
                }
            }
        }
        lost.unwrap_or(0)
    }

    /// The bytes to be sent next: to the end of one line. Empty when there is nothing to say.
    ///
    /// One line at a time, because the kernel takes a short write whole or not at all: a client sees no half
    /// line even when the daemon is killed.
    pub fn next_output(&mut self, hub: &Hub, stats: &StatsSource<'_>) -> &[u8] {
        while self.output.is_empty() && self.compose(hub, stats) {}
        let rest = &self.output[self.sent..];
        let end = rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |newline| newline + 1);
        &rest[..end]
    }

    /// The kernel has taken so many bytes of [`next_output`](Session::next_output).
    pub fn sent(&mut self, bytes: usize) {
        self.sent += bytes;
        if self.sent >= self.output.len() {
            self.sent = 0;
            self.output.clear();
            self.output.shrink_to(KEPT_OUTPUT_BYTES);
        }
    }

    /// Does one thing that is due. Returns false when nothing is.
    fn compose(&mut self, hub: &Hub, stats: &StatsSource<'_>) -> bool {
        if let Some(announced) = self.version_due.take().or_else(|| self.tape_due.take()) {
            self.output.extend_from_slice(&announced.line);
        } else if !self.events_due.is_empty() {
            let event = self.events_due.remove(0);
            if self.subscription.wants(&event.content) {
                self.output.extend_from_slice(&event.line);
            }
        } else if let Some(line) = self.input.next_line() {
            let line = line.as_deref().map_err(|too_long| *too_long);
            if line != Ok(b"") {
                self.answer(line, hub, stats);
            }
        } else if let Some(next) = self.queue.pop_front() {
            if self.subscription.wants(&next.content) {
                self.write_published(&next);
            }
            if self.queue.is_empty() {
                self.queue.shrink_to(KEPT_QUEUE_LINES);
            }
        } else {
            return false;
        }
        true
    }

    fn write_published(&mut self, published: &Published) {
        match &published.content {
            Content::Reading(reading) if self.lost > 0 => {
                let reading = ReadingLine { lost: self.lost, ..(**reading).clone() };
                self.output.extend(to_line(&reading));
                self.lost = 0;
                return;
            }
            Content::Discharge(_) if self.lost > 0 => {
                self.output.extend(to_line(&ErrorLine::lost(self.lost)));
                self.lost = 0;
            }
            _ => self.lost += self.subscription.missed(&published.content),
        }
        self.output.extend_from_slice(&published.line);
    }

    fn answer(&mut self, line: Result<&[u8], LineTooLong>, hub: &Hub, stats: &StatsSource<'_>) {
        let outcome = Request::parse(line).and_then(|request| match request {
            Request::Watch(watch) => self.watch(watch, hub),
            Request::Poll => {
                hub.write_last_readings(&mut self.output);
                Ok(())
            }
            Request::Stats => {
                self.output.extend(to_line(&hub.stats(stats())));
                Ok(())
            }
        });
        if let Err(refusal) = outcome {
            self.output.extend(to_line(&refusal));
        }
    }

    fn watch(&mut self, watch: Watch, hub: &Hub) -> Result<(), ErrorLine> {
        hub.knows(watch.channels.as_deref().unwrap_or_default())?;
        let was_raw = self.wants_raw();
        if !self.watches() || watch.raw != self.wants_raw() {
            // Another stream begins: it has no past, and nothing of it was lost. Otherwise what is still to be
            // sent goes through the new filter.
            let mut versions = self.queue.drain(..).filter(|line| matches!(line.content, Content::Version));
            self.version_due = versions.next_back().or(self.version_due.take());
            self.lost = 0;
            self.events_due = hub.last_events().cloned().collect();
        }
        self.subscription = Subscription::new(watch);
        if !was_raw || !self.wants_raw() {
            self.tape_due = if self.wants_raw() { hub.tape_beginning() } else { None };
        }
        Ok(())
    }
}

fn is_of_same_channel(one: &Published, other: &Published) -> bool {
    matches!((&one.content, &other.content), (Content::Event(one), Content::Event(other)) if one == other)
}

#[cfg(test)]
mod tests;
