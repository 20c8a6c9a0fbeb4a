//! The pins: the contract of every backend, and what becomes of their failures.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod clauses;
#[path = "../common/mod.rs"]
mod common;
mod contract;
mod faults;
mod flaws;
mod injections;
mod sleeping;
mod ticks;
