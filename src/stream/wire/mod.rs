//! The messages of the stream: one JSON object a line, each with a `class`.
//!
//! - [`ServerMessage`] is what a server says: each class is a type that is written and read by serde. Reading is tolerant of
//!   fields and classes that are not known (a later minor protocol adds some) and strict in types. A field that is absent is
//!   unknown; null, NaN and infinity are never written.
//! - [`Request`] is what a client may ask; reading is strict and refuses with an [`ErrorLine`].
//! - [`LineSplitter`] cuts a byte stream into lines, wherever the kernel cut it into chunks.
//!
//! ```
//! use cermd::wire::{Request, ServerMessage, Watch};
//!
//! let line = br#"{"class":"READING","channel":"thumb","seq":7,"time":"2026-11-21T03:40:00.123456789Z","t_mono_ns":81,"status":"ok","r_ohm":2841.3,"r_u_ohm":1.2,"f_n":4.697,"lost":0}"#;
//! let ServerMessage::Reading(reading) = ServerMessage::parse(line)? else { panic!() };
//! assert_eq!((reading.state.r_ohm, reading.state.f_n, reading.state.f_u_n), (Some(2841.3), Some(4.697), None));
//!
//! let slowly = Request::Watch(Watch { max_hz: Some(10.0), ..Watch::default() });
//! assert_eq!(slowly.to_line(), b"{\"class\":\"WATCH\",\"enable\":true,\"max_hz\":10}\n");
//! # Ok::<(), cermd::wire::UnreadableLine>(())
//! ```

mod achieved;
mod event;
mod message;
mod request;
mod split;
mod stats;

pub use super::limits::{MAX_LINE_BYTES, PROTO_MAJOR, PROTO_MINOR};
pub(crate) use super::line::to_line;
pub use achieved::{ChannelStats, ReadingTally};
pub use event::{EventLine, EventName};
pub use message::{
    ChannelInfo, ErrorCode, ErrorLine, ReadingLine, ServerMessage, StateLine, StatusName, Unit,
    UnreadableLine, VersionLine,
};
#[cfg(feature = "programs")]
pub(crate) use request::excerpt;
pub use request::{Request, Watch};
pub use split::{LineSplitter, LineTooLong};
pub use stats::{InstrumentStats, StatsLine};
