//! What passes between the daemon, its clients and files.
//!
//! For: the lines of the protocol and of a tape, the server and the client. Must not know: equations, or the configuration.
//!
//! Each message is one type that serde writes and reads: [`wire`] has those of the socket, [`tape`] those of a recording.

pub mod client;
mod limits;
mod line;
#[cfg(feature = "programs")]
pub mod server;
pub mod tape;
pub mod wire;
