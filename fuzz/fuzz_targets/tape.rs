//! See tests/fuzz/targets.rs.
#![no_main]

#[path = "../../tests/fuzz/hostile.rs"]
mod hostile;
#[path = "../../tests/fuzz/targets.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|data: &[u8]| targets::tape(data));
