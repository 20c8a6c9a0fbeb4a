//! The bridges as their peers meet them: the real program and a real daemon on a simulated circuit, with peers made up here.
//! The real peers are those of tests/peers.

pub mod bench;
mod iio;
mod mqtt;
mod prometheus;
mod web;
