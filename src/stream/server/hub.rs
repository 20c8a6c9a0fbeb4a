//! What all clients share: the channels, the ring of lines, the last reading of each channel, the counts.
//!
//! For: formatting each reading once, and only if somebody wants it. Must not know: sockets, or who the clients are.

use super::ring::{ChannelKey, Kind, Ring};
use crate::reading::Reading;
use crate::stream::wire::{self, ChannelInfo, ErrorCode, Refusal, UnixTime};
use std::collections::VecDeque;

/// The shared state.
#[derive(Debug)]
pub(super) struct Hub {
    pub ring: Ring,
    /// Each from its position in the ring on; of old ones only those that a slow client may still be due.
    versions: VecDeque<Version>,
    /// The line that begins a tape; empty while there is none.
    pub tape_header: Vec<u8>,
    pub clients: usize,
    pub published: u64,
    /// Summed over the clients.
    pub lost: u64,
    channels: Vec<Channel>,
    /// Every id that there ever was; its index is its key.
    ids: Vec<String>,
}

/// A VERSION line, and from where on it holds.
#[derive(Debug)]
pub(super) struct Version {
    /// Counted from 1.
    pub number: u64,
    at: u64,
    pub line: Vec<u8>,
}

#[derive(Debug)]
struct Channel {
    key: ChannelKey,
    id: String,
    last: Option<(Reading, UnixTime)>,
}

impl Hub {
    pub fn new(channels: &[ChannelInfo], ring_lines: usize) -> Hub {
        let mut hub = Hub {
            ring: Ring::new(ring_lines),
            versions: VecDeque::new(),
            tape_header: Vec::new(),
            clients: 0,
            published: 0,
            lost: 0,
            channels: Vec::new(),
            ids: Vec::new(),
        };
        hub.set_channels(channels);
        hub
    }

    pub fn set_channels(&mut self, channels: &[ChannelInfo]) {
        self.channels.clear();
        for channel in channels {
            let key = self.intern(&channel.id);
            self.channels.push(Channel { key, id: channel.id.clone(), last: None });
        }
        let at = self.ring.next();
        let number = self.versions.back().map_or(1, |version| version.number + 1);
        // Nothing was published under this one.
        if self.versions.back().is_some_and(|version| version.at == at) {
            self.versions.pop_back();
        }
        let oldest = self.ring.oldest();
        while self.versions.get(1).is_some_and(|version| version.at <= oldest) {
            self.versions.pop_front();
        }
        let mut line = Vec::new();
        wire::write_version(&mut line, channels);
        self.versions.push_back(Version { number, at, line });
    }

    /// The VERSION of the line at `position`, unless it is the one of this number.
    pub fn version(&self, position: u64, known: u64) -> Option<&Version> {
        let current = self.versions.iter().rfind(|version| version.at <= position);
        current.filter(|version| version.number != known)
    }

    fn intern(&mut self, id: &str) -> ChannelKey {
        let index = self.ids.iter().position(|known| known == id).unwrap_or_else(|| {
            self.ids.push(id.to_owned());
            self.ids.len() - 1
        });
        ChannelKey(index as u32)
    }

    /// How many VERSION lines are kept.
    #[cfg(test)]
    pub fn versions(&self) -> usize {
        self.versions.len()
    }

    /// The channel of that index in the configuration.
    pub fn key(&self, index: usize) -> Option<ChannelKey> {
        self.channels.get(index).map(|channel| channel.key)
    }

    /// The keys of ids, each once.
    pub fn resolve(&self, ids: &[String]) -> Result<Box<[ChannelKey]>, Refusal> {
        let mut keys = ids.iter().map(|id| self.key_of(id)).collect::<Result<Vec<_>, _>>()?;
        keys.sort_unstable();
        keys.dedup();
        Ok(keys.into())
    }

    fn key_of(&self, id: &str) -> Result<ChannelKey, Refusal> {
        self.channels.iter().find(|channel| channel.id == id).map(|channel| channel.key).ok_or_else(|| {
            let message = format!("no channel \"{}\": VERSION lists those that there are", wire::excerpt(id));
            Refusal::new(ErrorCode::UnknownChannel, message)
        })
    }

    /// Keeps a reading as the last one of its channel. One of a channel that is no longer there is dropped: it was measured
    /// before a reload.
    pub fn keep_reading(&mut self, reading: &Reading, time: UnixTime) {
        let Some(channel) = self.channels.get_mut(reading.channel) else { return };
        channel.last = Some((*reading, time));
        self.published += 1;
    }

    /// The last reading of the channel of that index, as a line for those that watch.
    pub fn push_reading(&mut self, index: usize) {
        let Some(channel) = self.channels.get(index) else { return };
        let Some((reading, time)) = &channel.last else { return };
        self.ring.push(Kind::Reading(channel.key), reading.at, |line| {
            wire::begin_reading(line, reading, &channel.id, *time);
        });
    }

    /// Appends the last reading of each channel, and one refusal for those that have none yet.
    pub fn write_last_readings(&self, out: &mut Vec<u8>) {
        let mut missing = Vec::new();
        for channel in &self.channels {
            match &channel.last {
                Some((reading, time)) => wire::write_reading(out, reading, &channel.id, *time),
                None => missing.push(channel.id.as_str()),
            }
        }
        if !missing.is_empty() {
            let message = format!("no reading yet of {}: wait for the stream", missing.join(", "));
            Refusal::new(ErrorCode::NoReading, message).write(out);
        }
    }
}
