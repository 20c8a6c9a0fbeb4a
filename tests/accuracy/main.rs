//! What is measured against what is true: the equations, each method, and the uncertainty that is stated.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot be set up fails")]

mod averages;
mod charging;
#[path = "../common/mod.rs"]
mod common;
mod coverage;
mod drawn;
mod dynamic;
mod equations;
mod exact;
mod front;
mod hostile;
mod methods;
mod offset;
mod paper;
mod regression;
mod starts;
mod tracked;
mod wanted;
