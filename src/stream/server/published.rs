//! A line as it is published: made once, shared by every client that waits for it.

use crate::stream::tape::{DischargeLine, Header};
use crate::stream::wire::{ChannelInfo, ReadingLine, VersionLine, to_line};
use std::sync::Arc;

/// A whole line, and what it is.
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
    /// Of the sensor of a channel, or of all: a calibration.
    Discharge(Option<String>),
}

impl Published {
    pub fn version(channels: &[ChannelInfo]) -> Arc<Published> {
        Arc::new(Published { content: Content::Version, line: to_line(&VersionLine::new(channels)) })
    }

    pub fn tape(header: &Header) -> Arc<Published> {
        Arc::new(Published { content: Content::Tape, line: to_line(header) })
    }

    pub fn reading(reading: ReadingLine) -> Arc<Published> {
        let line = to_line(&reading);
        Arc::new(Published { content: Content::Reading(Box::new(reading)), line })
    }

    pub fn discharge(discharge: DischargeLine) -> Arc<Published> {
        let line = to_line(&discharge);
        Arc::new(Published { content: Content::Discharge(discharge.channel), line })
    }
}
