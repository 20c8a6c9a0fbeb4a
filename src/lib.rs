//! cermd
pub mod client;
pub mod pins;
pub mod reading;
pub mod record;
pub mod server;
pub mod units;
pub mod wire;
