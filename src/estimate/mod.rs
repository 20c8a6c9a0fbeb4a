//! From the timings of discharges to what is known about the sensor.
//!
//! For: the law, the equations of the methods, noise, offset and the followed calibration, motion and leaks, fits; all of it
//! pure. Must not know: pins, clocks, or in which order discharges are taken.

pub mod absorption;
pub mod awake;
pub mod estimator;
pub mod fit;
pub mod grid;
pub mod law;
pub mod leak;
pub mod limits;
pub mod look;
pub mod mean;
pub mod method;
pub mod motion;
pub mod noise;
pub mod offset;
pub mod scatter;
pub mod tracker;

pub use estimator::{Estimate, Estimator, Predicted};
