//! Where each method holds and where it fails, in simulated circuits and virtual time.
//!
//! A scenario is the board `pi4` with something changed; each is checked from both sides, and every seed is fixed.
//! `docs/stability.md` is what comes out of it; `UPDATE_DOCS=1 cargo test --test stability` writes it anew.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot be set up fails")]

mod common;
#[path = "stability/failures.rs"]
mod failures;
#[path = "stability/leaks.rs"]
mod leaks;
#[path = "stability/states.rs"]
mod states;

#[test]
fn every_defect_is_told_or_known_not_to_be() {
    let (mut report, mut wrong) = states::report();
    let (leaks, unseen) = leaks::report();
    report += &leaks;
    wrong += &unseen;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/stability.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(path, &report).unwrap();
    }
    println!("{report}");
    assert!(wrong.is_empty(), "{wrong}");
    let on_disk = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        on_disk == report,
        "{path} is out of date; write it with UPDATE_DOCS=1 cargo test --test stability"
    );
}
