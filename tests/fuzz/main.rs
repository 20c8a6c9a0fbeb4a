//! Hostile inputs on a stable compiler: the seeds of fuzz/corpus and what chance makes of them. More of them, and cleverer ones,
//! libFuzzer makes: fuzz/run.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod hostile;
#[path = "../common/seed.rs"]
#[allow(dead_code, reason = "shared with all other tests")]
mod seed;
mod targets;

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

const SEED: u64 = 14;
/// An input that takes longer hangs; a busy machine is slow.
const LONGEST: Duration = Duration::from_secs(20);
/// What numbers are replaced by.
const NUMBERS: [&str; 14] = [
    "0",
    "-0.0",
    "-1",
    "1",
    "65",
    "1e-30",
    "1e30",
    "1e308",
    "1e999",
    "nan",
    "inf",
    "9223372036854775807",
    "0.1",
    "",
];

/// Every file below a folder, by its path, so that their order is always the same.
fn files(folder: &Path) -> Vec<Vec<u8>> {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().filter(|path| path.is_file()).map(|path| fs::read(path).unwrap()).collect()
}

/// The seeds of a target: its corpus, and what the project ships.
fn seeds(name: &str) -> Vec<Vec<u8>> {
    let mut seeds = files(&Path::new("fuzz/corpus").join(name));
    match name {
        "configuration" => {
            seeds.push(fs::read("hw/cermd.toml").unwrap());
            seeds.push(fs::read("src/config/tests_full.toml").unwrap());
        }
        "scene" => seeds.extend(files(Path::new("hw/scenes"))),
        _ => {}
    }
    seeds
}

/// Somewhere in the bytes, from .. to, mostly short.
fn part(rng: &mut ChaCha8Rng, length: usize) -> std::ops::Range<usize> {
    let from = rng.random_range(0..=length);
    let most = if rng.random() { 8 } else { length };
    from..(from + rng.random_range(0..=most)).min(length)
}

/// One of the seeds, changed in one to five places.
fn mutated(rng: &mut ChaCha8Rng, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds.choose(rng).unwrap().clone();
    for _ in 0..rng.random_range(1..=5) {
        let place = part(rng, bytes.len());
        match rng.random_range(0..6) {
            0 => place.for_each(|at| bytes[at] ^= 1 << rng.random_range(0..8)),
            1 => drop(bytes.splice(place, [rng.random()])),
            2 => drop(bytes.drain(place)),
            3 => {
                let again = bytes[place.clone()].to_vec();
                bytes.splice(place.end..place.end, again);
            }
            4 => {
                let other = seeds.choose(rng).unwrap();
                let graft = other[part(rng, other.len())].to_vec();
                bytes.splice(place, graft);
            }
            _ => {
                let is_part = |byte: &u8| byte.is_ascii_digit() || b".-".contains(byte);
                let from =
                    place.start + bytes[place.start..].iter().take_while(|byte| !is_part(byte)).count();
                let end = from + bytes[from..].iter().take_while(|byte| is_part(byte)).count();
                bytes.splice(from..end, NUMBERS.choose(rng).unwrap().bytes());
            }
        }
    }
    bytes
}

/// How many inputs each target gets beside its seeds.
const INPUTS: [(&str, usize); 6] = [
    ("configuration", 10_000),
    ("scene", 10_000),
    ("force-table", 20_000),
    ("tape", 4000),
    ("requests", 20_000),
    ("events", 10_000),
];

fn hammer(name: &str) {
    let (_, target) = targets::ALL.into_iter().find(|(known, _)| *known == name).unwrap();
    let (_, inputs) = INPUTS.into_iter().find(|(known, _)| *known == name).unwrap();
    let (seeds, mut rng) = (seeds(name), seed::rng(SEED));
    assert!(!seeds.is_empty(), "no seeds of {name}");
    let (began, mut longest) = (Instant::now(), Duration::ZERO);
    let changed: Vec<Vec<u8>> = (0..inputs).map(|_| mutated(&mut rng, &seeds)).collect();
    for input in seeds.iter().chain(&changed) {
        let began = Instant::now();
        if std::panic::catch_unwind(|| target(input)).is_err() {
            panic!("{name}: {}", input.escape_ascii());
        }
        longest = longest.max(began.elapsed());
        assert!(longest < LONGEST, "{name} takes {longest:.1?}: {}", input.escape_ascii());
    }
    let (seeds, all) = (seeds.len(), began.elapsed());
    println!("{name}: {seeds} seeds, {inputs} inputs made of them, in {all:.1?}, at most {longest:.1?} each");
}

#[test]
fn any_configuration() {
    hammer("configuration");
}

#[test]
fn any_scene() {
    hammer("scene");
}

#[test]
fn any_force_table() {
    hammer("force-table");
}

#[test]
fn any_tape() {
    hammer("tape");
}

#[test]
fn any_requests() {
    hammer("requests");
}

#[test]
fn any_events() {
    hammer("events");
}

/// What docs/robustness.md says of seeds and inputs.
#[test]
fn the_page_has_these_numbers() {
    let folders = INPUTS.map(|(name, _)| files(&Path::new("fuzz/corpus").join(name)).len());
    let (seeds, inputs) =
        (folders.iter().sum::<usize>(), INPUTS.iter().map(|(_, inputs)| inputs).sum::<usize>());
    let said = format!("{seeds} seeds and what the project ships, and {} 000 inputs", inputs / 1000);
    let page = fs::read_to_string("docs/robustness.md").unwrap();
    assert!(inputs % 1000 == 0 && page.contains(&said), "the page does not say: {said}");
}

/// Or they would try the first lines of everything and no more.
#[test]
fn the_seeds_of_events_come_to_numbers() {
    let numbers: usize = seeds("events").iter().map(|seed| targets::numbers(seed)).sum();
    assert!(numbers > 0);
}

/// Where the order of discharges has changed: `cargo test --test fuzz -- --ignored seeds_of_events_anew`.
#[test]
#[ignore = "writes fuzz/corpus/events"]
fn seeds_of_events_anew() {
    // Edges of both nodes and quick calls, above all.
    let usual = [
        0x05u8, 0x05, 0x05, 0x05, 0x0d, 0x0d, 0x15, 0x25, 0x35, 0x45, 0x85, 0x93, 0x98, 0x00, 0x01, 0x08,
        0xf3,
    ];
    let mut rng = seed::rng(SEED);
    for first in 0..6u8 {
        let tries = (0..20_000).map(|_| {
            let rest = (0..600).map(|_| *usual.choose(&mut rng).unwrap());
            std::iter::once(first).chain(rest.collect::<Vec<_>>()).collect::<Vec<u8>>()
        });
        let found = tries.max_by_key(|bytes| targets::numbers(bytes)).unwrap();
        fs::write(format!("fuzz/corpus/events/{first}"), found).unwrap();
    }
}
