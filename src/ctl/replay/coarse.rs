//! Stamps at the edges of a coarse clock have its uncertainty, though their scatter need not show it and the header not say it.

use super::*;
use crate::stream::tape::Reader;
use rand::RngExt;
use rand_distr::StandardNormal;
use std::fmt::Write;

/// A quiet board whose stamps are all at the edges of a clock of 5 us, of which the header says nothing.
fn tape(seed: u64, r_x: f64) -> String {
    let mut rng = crate::seed::rng(seed);
    let g = [600.0, 1100.0].map(|g: f64| g * (1.0 + 0.1 * rng.random::<f64>()));
    let mut tape = r#"{"class":"TAPE","proto_major":1,"circuit":{"kind":"two-capacitor","r_c1_ohm":2320,"r_c2_ohm":12700},"channels":[{"id":"x","zero_ohm":0,"scale":1}]}"#.to_owned();
    let ways = [("c1", 2320.0), ("c2", 12_700.0), ("x\",\"channel\":\"x", r_x)];
    for (seq, (through, r)) in ways.iter().cycle().take(3 * 60).enumerate() {
        let [a, b] = g.map(|g| {
            let at_ns = g * (r + 40.0) + 8000.0 + 200.0 * rng.sample::<f64, _>(StandardNormal);
            5000.0 * (at_ns / 5000.0).round()
        });
        let line = format!(
            "{{\"class\":\"DISCHARGE\",\"seq\":{seq},\"through\":\"{through}\",\"a_ns\":{a},\"b_ns\":{b}}}"
        );
        write!(tape, "\n{line}").unwrap();
    }
    tape
}

#[test]
fn a_clock_that_is_coarse_without_a_word_is_in_the_uncertainty() {
    let (mut within, mut count) = (0, 0);
    for seed in 0..60 {
        let r_x = 500.0 + 100.0 * seed as f64;
        let tape = tape(seed, r_x);
        let reader = Reader::open(tape.as_bytes()).unwrap();
        let mut replay = Replay::new(reader.header(), Method::Tcdic, None).unwrap();
        let states = reader.filter_map(|entry| replay.take(&entry.unwrap())).map(|line| line.state);
        for (r_ohm, u) in states.skip(20).filter_map(|state| state.r_ohm.zip(state.r_u_ohm)) {
            within += usize::from((r_ohm - r_x).abs() < 2.0 * u);
            count += 1;
        }
    }
    assert!(count > 2000 && 10 * within > 9 * count, "{within} of {count}");
}
