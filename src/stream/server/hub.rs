//! What all clients share: the channels with their last readings, the header of a tape, the counts.

use crate::reading::Reading;
use crate::stream::limits::serving::{ACHIEVED_OVER_S, ROUNDS};
use crate::stream::tape::DischargeLine;
use crate::stream::wire::{
    ChannelInfo, ChannelStats, ErrorCode, ErrorLine, EventLine, InstrumentStats, ReadingLine, ReadingTally,
    StatsLine, Unit, VersionLine, excerpt, to_line,
};
use jiff::Timestamp;
use serde::Serialize;
use std::collections::VecDeque;
use std::sync::Arc;

/// A whole line, made once and shared by every client that waits for it, and what it is.
#[derive(Debug)]
pub(super) struct Published {
    pub content: Content,
    /// With its newline; of a reading: as it goes to a client that has lost nothing.
    pub line: Vec<u8>,
}

/// What a line is, as far as that decides who gets it.
#[derive(Debug)]
pub(super) enum Content {
    /// The readings after it have these channels.
    Version,
    /// The discharges after it belong to this tape.
    Tape,
    Reading(Box<ReadingLine>),
    /// Of the trigger of a channel.
    Event(String),
    /// Of the sensor of a channel, or of all: a calibration.
    Discharge(Option<String>),
    /// No line: so many never came here.
    Lost {
        readings: u64,
        discharges: u64,
    },
}

impl Published {
    pub fn new(content: Content, message: &impl Serialize) -> Arc<Published> {
        Arc::new(Published { content, line: to_line(message) })
    }
}

/// The shared state.
#[derive(Debug)]
pub(super) struct Hub {
    /// The VERSION of the present channels.
    pub version: Arc<Published>,
    /// The line that begins a tape, once it is known.
    pub tape_header: Option<Arc<Published>>,
    /// The lines of the last rounds of calibration discharges, oldest first.
    pub rounds: VecDeque<Vec<u8>>,
    pub clients: usize,
    pub published: u64,
    /// Summed over the clients.
    pub lost: u64,
    channels: Vec<ChannelState>,
}

#[derive(Debug)]
struct ChannelState {
    id: String,
    unit: Unit,
    last: Option<(Reading, Timestamp)>,
    event: Option<Arc<Published>>,
    /// Of the present window and of the last one that is full.
    tallies: [ReadingTally; 2],
}

impl ChannelState {
    fn count(&mut self, reading: &Reading) {
        if self.tallies[0].span_s() > ACHIEVED_OVER_S {
            self.tallies = [ReadingTally::default(), self.tallies[0]];
        }
        self.tallies[0].add(reading, &self.unit);
    }

    fn stats(&self) -> ChannelStats {
        let [present, last] = self.tallies.map(|tally| tally.stats());
        if last.readings > 0 { last } else { present }
    }

    fn last_line(&self) -> Option<ReadingLine> {
        let (reading, time) = self.last.as_ref()?;
        Some(ReadingLine::new(reading, &self.id, &self.unit, format!("{time:.9}")))
    }
}

impl Hub {
    pub fn new(channels: &[ChannelInfo]) -> Hub {
        let version = Published::new(Content::Version, &VersionLine::new(channels));
        let new = |channel: &ChannelInfo| ChannelState {
            id: channel.id.clone(),
            unit: channel.unit.clone(),
            last: None,
            event: None,
            tallies: Default::default(),
        };
        let channels = channels.iter().map(new).collect();
        Hub {
            version,
            tape_header: None,
            rounds: VecDeque::new(),
            clients: 0,
            published: 0,
            lost: 0,
            channels,
        }
    }

    pub fn set_channels(&mut self, channels: &[ChannelInfo]) {
        let Hub { version, channels, .. } = Hub::new(channels);
        (self.version, self.channels) = (version, channels);
        // They were of the circuit before.
        self.rounds.clear();
    }

    /// Keeps the last ones.
    pub fn keep_round(&mut self, round: &[DischargeLine]) {
        if self.rounds.len() == ROUNDS {
            self.rounds.pop_front();
        }
        self.rounds.push_back(round.iter().flat_map(to_line).collect());
    }

    /// What a tape begins with: its header, and the calibration discharges by which it can be followed.
    pub fn tape_beginning(&self) -> Option<Arc<Published>> {
        let header = self.tape_header.as_ref()?;
        if self.rounds.is_empty() {
            return Some(Arc::clone(header));
        }
        let rounds = self.rounds.iter().flatten();
        let line = header.line.iter().chain(rounds).copied().collect();
        Some(Arc::new(Published { content: Content::Tape, line }))
    }

    /// STATS, with what the daemon tells.
    pub fn stats(&self, instrument: InstrumentStats) -> StatsLine {
        let channels = self.channels.iter().map(|channel| (channel.id.clone(), channel.stats())).collect();
        StatsLine {
            clients: self.clients as u64,
            published: self.published,
            lost: self.lost,
            channels,
            instrument,
        }
    }

    /// Whether there is a channel of each of these ids.
    pub fn knows(&self, ids: &[String]) -> Result<(), ErrorLine> {
        match ids.iter().find(|id| !self.channels.iter().any(|channel| channel.id == **id)) {
            None => Ok(()),
            Some(id) => {
                let message = format!("no channel \"{}\": VERSION lists those that there are", excerpt(id));
                Err(ErrorLine::new(ErrorCode::UnknownChannel, message))
            }
        }
    }

    /// Keeps a reading as the last one of its channel. One of a channel that is no longer there is dropped: it was measured
    /// before a reload.
    pub fn keep_reading(&mut self, reading: &Reading, time: Timestamp) {
        let Some(channel) = self.channels.get_mut(reading.channel) else { return };
        channel.last = Some((*reading, time));
        channel.count(reading);
        self.published += 1;
    }

    /// Keeps an event as the last one of its channel, and returns it as a line; of a channel that is no longer there: `None`.
    pub fn keep_event(&mut self, event: &EventLine) -> Option<Arc<Published>> {
        let channel = self.channels.iter_mut().find(|channel| channel.id == event.channel)?;
        let published = Published::new(Content::Event(event.channel.clone()), event);
        channel.event = Some(Arc::clone(&published));
        Some(published)
    }

    /// The last event of each channel that has had one.
    pub fn last_events(&self) -> impl Iterator<Item = &Arc<Published>> {
        self.channels.iter().filter_map(|channel| channel.event.as_ref())
    }

    /// The last reading of the channel of that index, for those that watch.
    pub fn last_reading(&self, index: usize) -> Option<Arc<Published>> {
        let reading = self.channels.get(index)?.last_line()?;
        let line = to_line(&reading);
        Some(Arc::new(Published { content: Content::Reading(Box::new(reading)), line }))
    }

    /// Appends the last reading and event of each channel, and one refusal for those that have none yet.
    pub fn write_last_readings(&self, out: &mut Vec<u8>) {
        let mut missing = Vec::new();
        for channel in &self.channels {
            match channel.last_line() {
                Some(line) => out.extend(to_line(&line)),
                None => missing.push(channel.id.as_str()),
            }
            out.extend(channel.event.iter().flat_map(|event| &event.line));
        }
        if !missing.is_empty() {
            let message = format!("no reading yet of {}: wait for the stream", missing.join(", "));
            out.extend(to_line(&ErrorLine::new(ErrorCode::NoReading, message)));
        }
    }
}
