//! The simulated circuit.
//!
//! For: a [`Pins`](super::Pins) whose lines end in a network of resistors and capacitors, with the latencies of a
//! real kernel. Must not know: any estimator.
