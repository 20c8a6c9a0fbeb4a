//! cermd
pub mod pins;
pub mod reading;
pub mod record;
pub mod units;
pub mod wire;
