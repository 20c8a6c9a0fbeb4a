//! The programs, the stream between them and their manual, as users, scripts and the service manager meet them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod bridges;
mod calibrate;
mod cermctl;
#[path = "../common/mod.rs"]
mod common;
mod daemon;
mod laws;
mod manual;
mod pages;
mod processes;
mod protocol;
mod schema;
mod setup;
mod size;
mod triggers;
mod waiting;
