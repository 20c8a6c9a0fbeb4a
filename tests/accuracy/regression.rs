//! What is measured on each board by each method, as a snapshot: what becomes less accurate or slower shows as a difference.
//!
//! `INSTA_UPDATE=always cargo test --test accuracy regression` takes it anew. Every seed is fixed.

use crate::common::chance::share_is_in;
use crate::common::seed::family;
use cermd::characterize::cell::Cell;
use cermd::characterize::run::run;
use cermd::characterize::sweep::Sweep;
use cermd::characterize::table::Row;
use cermd::pins::sim::Scene;
use cermd::units::{Nanos, rounded};
use std::fmt::Write;

/// Enough for a change of a fifth; docs/methods.md has more of each.
const INSTRUMENTS: u64 = 8;
const READINGS: usize = 25;

fn cells(name: &str) -> Vec<Cell> {
    let scene = Scene::builtin(name).unwrap();
    let sweep = Sweep {
        name: name.to_owned(),
        seed: scene.seed,
        scene,
        config: None,
        methods: Vec::new(),
        kinds: Vec::new(),
        r_ohm: vec![100.0, 16_200.0],
        averages: vec![Nanos::ZERO],
        instruments: Some(INSTRUMENTS),
    };
    let front = sweep.front().unwrap();
    front.into_iter().map(|cell| Cell { readings: READINGS, ..cell }).collect()
}

fn measured(cells: &[Cell]) -> Vec<Row> {
    let mut all = vec![Vec::new(); cells.len()];
    run(cells, &|| false, |index, rows| {
        all[index] = rows;
        Ok::<(), cermd::characterize::cell::CellError>(())
    })
    .unwrap();
    all.concat()
}

#[test]
fn accuracy_and_speed_are_as_they_were() {
    // A snapshot is of the first family of seeds.
    if family() != 0 {
        return;
    }
    let cells: Vec<Cell> = Scene::builtin_names().flat_map(cells).collect();
    let mut wrong = Vec::new();
    let mut text = String::from("scene circuit method R/ohm | error/ohm u/ohm time/ms, no number, moving\n");
    for row in measured(&cells) {
        let figure = |value: Option<f64>| value.map_or("-".to_owned(), |value| rounded(value, 3).to_string());
        let ms = figure(row.published_s.map(|s| 1e3 * s));
        let (error, u, name) = (figure(row.rms_ohm), figure(row.u_ohm), &row.scene);
        let (none, moving) = (rounded(row.no_number, 2), rounded(row.moving, 2));
        let what = format!("{name} {} {} {}", row.circuit, row.method, row.r_ohm);
        writeln!(text, "{what} | {error} {u} {ms}, {none}, {moving}").unwrap();
        let holds = row.rms_ohm.zip(row.u_ohm).is_some_and(|(error, u)| error < 1.5 * u);
        // Nor is rest taken for motion.
        let all = INSTRUMENTS as usize * READINGS;
        let rests = share_is_in((row.moving * all as f64).round() as usize, all, 0.0..=0.05);
        if !holds || !rests {
            wrong.push(what);
        }
    }
    assert!(wrong.is_empty(), "not sound: {wrong:#?}");
    insta::assert_snapshot!(text);
}

/// The same cells measured again give the same figures, in whatever order processors take them.
#[test]
fn a_sweep_is_reproducible() {
    let cells: Vec<Cell> = cells("pi4").into_iter().filter(|cell| cell.r_ohm == 16_200.0).collect();
    let cells: Vec<Cell> = cells.into_iter().map(|cell| Cell { instruments: 1, ..cell }).collect();
    let backwards: Vec<Cell> = cells.iter().rev().cloned().collect();
    let mut again = measured(&backwards);
    again.reverse();
    assert_eq!(measured(&cells), again);
}
