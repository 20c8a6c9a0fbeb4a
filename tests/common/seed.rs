//! Families of seeds: `CERMD_SEED=n` shifts every seed of every test, so that no seed is a lucky one.
//!
//! Shared by the tests of the crate (tests/common) and those of its modules (src/lib.rs).

use proptest::test_runner::{Config, RngSeed};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::cell::Cell;

/// Between the same seed of two families: more than any test counts up to.
const APART: u64 = 1_000_003;

/// The family of this run, 0 if none is chosen. A test that has asked for it prints it when it fails.
pub fn family() -> u64 {
    thread_local!(static IS_TOLD: Cell<bool> = const { Cell::new(false) });
    let family = std::env::var("CERMD_SEED").map_or(0, |text| text.parse().expect("CERMD_SEED is a number"));
    if !IS_TOLD.replace(true) {
        println!("CERMD_SEED={family}");
    }
    family
}

/// A seed of this family.
pub fn seed(of: u64) -> u64 {
    of.wrapping_add(family().wrapping_mul(APART))
}

/// Random numbers of this family.
pub fn rng(of: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed(of))
}

/// So many cases of a property; a failing one prints itself and is kept nowhere.
pub fn cases(count: u32) -> Config {
    Config { rng_seed: RngSeed::Fixed(seed(0)), failure_persistence: None, ..Config::with_cases(count) }
}
