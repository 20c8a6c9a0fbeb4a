//! cermd
pub mod pins;
pub mod reading;
pub mod realtime;
pub mod record;
pub mod units;
