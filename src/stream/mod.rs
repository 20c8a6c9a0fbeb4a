//! What passes between the daemon, its clients and files.
//!
//! For: the lines of the protocol and of a tape, the server and the client. Must not know: equations, or the configuration.

pub mod client;
pub mod server;
pub mod tape;
pub mod wire;
