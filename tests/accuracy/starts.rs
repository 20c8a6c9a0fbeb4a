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
