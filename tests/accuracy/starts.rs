//! The first readings after a start: what says of its uncertainty that it is a prior.

use crate::common::{Bench, read};
use cermd::reading::{Method, Status};

const READINGS: usize = 60;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Whether the first readings are true is a row of `hostile`.
#[test]
fn from_the_first_reading_on_there_is_an_uncertainty_that_says_how_long_it_is_a_prior() {
    for method in Method::ALL {
        for seed in 0..20 {
            let mut us = Vec::new();
            read(&mut Bench::new("pi4", method, 1000.0, seed, "").instrument(), READINGS, |reading| {
                if let Status::Ok { r_ohm, is_settling, .. } = reading.status {
                    us.push((r_ohm.u.unwrap(), is_settling));
                }
            });
            let settled = us.iter().position(|(_, is_settling)| !is_settling).unwrap();
            assert!((8..=24).contains(&settled), "{method} seed {seed}: {us:?}");
            let (first, rest) = us.split_at(settled);
            assert!(rest.iter().all(|(_, is_settling)| !is_settling), "{method} seed {seed}: {us:?}");
            let [first, rest] = [first, &rest[..10]].map(|of| median(of.iter().map(|(u, _)| *u).collect()));
            assert!((2.0..100.0).contains(&(first / rest)), "{method} seed {seed}: {us:?}");
        }
    }
}

/// The reciprocal of a resistance that may be 0 is anything, in a mean as in a reading.
#[test]
fn while_a_resistance_may_be_zero_no_force_is_made_up_of_it() {
    for measure in ["", "rate-hz = 20"] {
        let mut unresolved = 0;
        for seed in 0..20 {
            let mut bench = Bench::new("pi4", Method::Tracked, 10.0, seed, measure);
            bench.config.lines("channel.x", "force = { alpha = \"13346 N ohm\" }");
            read(&mut bench.instrument(), READINGS, |reading| {
                if let Status::Ok { r_ohm, shown, .. } = reading.status {
                    let is_resolved = r_ohm.value > 2.0 * r_ohm.u.unwrap();
                    assert_eq!(shown.is_some(), is_resolved, "seed {seed}: {reading:?}");
                    unresolved += usize::from(!is_resolved);
                }
            });
        }
        assert!(unresolved > 0, "{measure}: every one is known well, so that nothing was tested");
    }
}
