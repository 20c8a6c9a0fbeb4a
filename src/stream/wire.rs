//! The messages of the stream: one JSON object a line, each with a `class`.
//!
//! For: both ends of the socket; what a line means, how it is written, how it is read. Must not know: sockets,
//! clients, or how a reading came to be.
//!
//! - [`Object`] writes a line. It has no way to write null, NaN or infinity: absent means unknown.
//! - [`Request`] is what a client may ask; parsing is strict and refuses with a [`Refusal`].
//! - [`ServerMessage`] is what a server says; parsing is tolerant of fields it does not know (a later minor
//!   protocol adds some) and strict in types.
//! - [`LineSplitter`] cuts a byte stream into lines, wherever the kernel cut it into chunks.
//! - [`UnixTime`] is wall-clock time, written as RFC 3339 with nanoseconds.

mod lines;
mod message;
mod object;
mod request;
mod time;

pub use lines::{Line, LineSplitter};
pub use message::{
    ReadingLine, ServerMessage, StatusName, UnreadableLine, VersionLine, write_reading, write_version,
};
pub(crate) use message::{begin_reading, end_reading};
pub use object::Object;
pub(crate) use request::excerpt;
pub use request::{ErrorCode, Instrument, Refusal, Request, Watch};
pub use time::UnixTime;

use serde::Deserialize;

/// Changes when old clients can no longer understand the stream.
pub const PROTO_MAJOR: u32 = 1;
/// Changes when fields or classes are added.
pub const PROTO_MINOR: u32 = 0;
/// The longest line either side may send, in bytes, its newline included.
pub const MAX_LINE_BYTES: usize = 64 * 1024;

/// What the values of a channel are measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum Unit {
    /// The channel has a force calibration.
    #[serde(rename = "N")]
    Newton,
    /// The channel is read as a resistance.
    #[serde(rename = "ohm")]
    Ohm,
}

impl Unit {
    /// The name in the stream.
    pub fn as_str(self) -> &'static str {
        match self {
            Unit::Newton => "N",
            Unit::Ohm => "ohm",
        }
    }
}

/// A channel as VERSION announces it.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct ChannelInfo {
    /// The name in configuration and stream.
    pub id: String,
    /// What it measures.
    pub unit: Unit,
}
