//! See tests/fuzz/targets.rs.
#![no_main]

#[path = "../../tests/fuzz/hostile.rs"]
mod hostile;
#[path = "../../tests/fuzz/targets.rs"]
#[allow(dead_code, reason = "one of them runs here")]
mod targets;

libfuzzer_sys::fuzz_target!(|data: &[u8]| targets::scene(data));
