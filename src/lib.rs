//! cermd
pub mod circuit;
pub mod config;
pub mod cycle;
pub mod discharge;
pub mod estimate;
pub mod force;
pub mod instrument;
pub mod method;
pub mod noise;
pub mod offset;
pub mod pins;
pub mod reading;
pub mod record;
pub mod settings;
pub mod stats;
pub mod units;
