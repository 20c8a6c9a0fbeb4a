//! cermd
pub mod circuit;
pub mod config;
pub mod pins;
pub mod reading;
pub mod record;
pub mod units;
