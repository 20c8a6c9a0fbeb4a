//! The last lines that were published, formatted once for everybody.
//!
//! For: a bound on what slow clients can cost: they hold a position in here and nothing else. Must not know:
//! clients.

use crate::units::Nanos;

/// A channel, for as long as the server lives: ids keep their key over reloads of the configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ChannelKey(pub u32);

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A READING, without its end (the field `lost` differs from client to client).
    Reading(ChannelKey),
    /// A whole line of a tape; of one channel, or of all (calibration).
    Raw(Option<ChannelKey>),
}

/// A published line.
#[derive(Debug)]
pub(super) struct Entry {
    pub kind: Kind,
    /// When it was measured, `CLOCK_MONOTONIC`.
    pub at: Nanos,
    pub line: Vec<u8>,
}

/// The last lines, by position: the first line ever published has position 0.
#[derive(Debug)]
pub(super) struct Ring {
    slots: Vec<Entry>,
    capacity: usize,
    next: u64,
}

impl Ring {
    pub fn new(capacity: usize) -> Ring {
        Ring { slots: Vec::with_capacity(capacity), capacity: capacity.max(1), next: 0 }
    }

    /// The position of the line that will be published next.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// The position of the oldest line that is still there.
    pub fn oldest(&self) -> u64 {
        self.next.saturating_sub(self.slots.len() as u64)
    }

    /// The line at a position; `None` before it is published and after it was overwritten.
    pub fn get(&self, position: u64) -> Option<&Entry> {
        let in_reach = position < self.next && self.next - position <= self.slots.len() as u64;
        if in_reach { self.slots.get(self.slot(position)) } else { None }
    }

    /// The line that the next [`push`](Ring::push) overwrites: whoever has not got it yet will never.
    pub fn oldest_to_go(&self) -> Option<(u64, &Entry)> {
        let position = self.next.checked_sub(self.capacity as u64)?;
        self.get(position).map(|entry| (position, entry))
    }

    /// Publishes what `write` appends to an empty buffer. The buffers are used again and again.
    pub fn push(&mut self, kind: Kind, at: Nanos, write: impl FnOnce(&mut Vec<u8>)) {
        let slot = self.slot(self.next);
        if slot == self.slots.len() {
            self.slots.push(Entry { kind, at, line: Vec::new() });
        }
        if let Some(entry) = self.slots.get_mut(slot) {
            entry.kind = kind;
            entry.at = at;
            entry.line.clear();
            write(&mut entry.line);
        }
        self.next += 1;
    }

    fn slot(&self, position: u64) -> usize {
        (position % self.capacity as u64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_the_last_lines_and_names_the_one_that_goes() {
        let mut ring = Ring::new(3);
        for position in 0..10u64 {
            let goes = ring.oldest_to_go().map(|(oldest, entry)| (oldest, entry.at.0));
            assert_eq!(goes, position.checked_sub(3).map(|oldest| (oldest, oldest as i64)));
            ring.push(Kind::Raw(None), Nanos(position as i64), |line| line.push(b'0' + position as u8));
            assert_eq!(ring.next(), position + 1);
            for other in 0..12 {
                let expected = (other <= position && other + 3 > position).then(|| vec![b'0' + other as u8]);
                assert_eq!(ring.get(other).map(|entry| entry.line.clone()), expected);
            }
        }
    }
}
