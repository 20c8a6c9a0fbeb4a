//! A line as it is published: made once, shared by every client that waits for it.

use crate::stream::wire::{ReadingLine, to_line};
use serde::Serialize;
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
    pub fn new(content: Content, message: &impl Serialize) -> Arc<Published> {
        Arc::new(Published { content, line: to_line(message) })
    }

    pub fn reading(reading: ReadingLine) -> Arc<Published> {
        let line = to_line(&reading);
        Arc::new(Published { content: Content::Reading(Box::new(reading)), line })
    }
}
