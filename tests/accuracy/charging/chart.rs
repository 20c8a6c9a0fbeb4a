//! Error over u against the length of a charge.

use super::bench::{Board, LONG_TAUS, NEIGHBOUR_OHM};
use cermd::circuit::Chargers;
use cermd::reading::Method;
use cermd::report::axis::{Axis, plain, seconds};
use cermd::report::mark::{Filling, Ink, Mark};
use cermd::report::plot::{Plot, Point, Series};

const CHART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/charging.svg");
const R_OHM: f64 = 5000.0;
/// Parts of the automatic time.
const PARTS: [f64; 7] = [0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0];
/// An error that is not seen is drawn here, in u.
const UNSEEN: f64 = 0.01;

/// A name, and the error over u by the length of the whole charge in ms.
pub type Curve = (String, Vec<(f64, f64)>);

pub fn curves() -> Vec<Curve> {
    if std::env::var_os("UPDATE_DOCS").is_none() {
        return Vec::new();
    }
    let of = |method: Method, chargers: Chargers| {
        let board = Board { method, r_ohm: R_OHM };
        let long = board.measure(NEIGHBOUR_OHM, (chargers, LONG_TAUS));
        let then = if chargers == Chargers::OfA { board.automatic().together.as_seconds() } else { 0.0 };
        let point = |part: f64| {
            let taus = part * board.automatic_taus(chargers);
            let error = board.measure(NEIGHBOUR_OHM, (chargers, taus)).error_beyond(&long);
            (1e3 * (taus * board.tau(chargers).0 + then), error.value.abs().max(UNSEEN))
        };
        let by = if chargers == Chargers::OfA { "A alone" } else { "all chargers" };
        (format!("{}, {by}", method.as_str()), PARTS.map(point).to_vec())
    };
    let both = |method| [Chargers::OfA, Chargers::All].map(|chargers| of(method, chargers));
    [Method::Tpcm, Method::Tcdic].map(both).into_iter().flatten().collect()
}

pub fn write(curves: &[Curve]) {
    let line = |name: &str, (ink, stroke): (Ink, &'static str), points: &[(f64, f64)]| Series {
        name: name.to_owned(),
        ink,
        stroke: Some(stroke),
        mark: None,
        points: points.iter().map(|(ms, error)| Point::new(1e-3 * ms, *error, String::new())).collect(),
        is_stairs: false,
    };
    let allowed = [(0.3, super::SHARE), (12.0, super::SHARE)];
    let mut series = vec![line("allowed", (Ink::NEUTRAL, "thin dots0"), &allowed)];
    for (((name, points), ink), mark) in curves.iter().zip([3, 0, 4, 2].map(Ink)).zip(Mark::ROUND) {
        series.push(Series { mark: Some((mark, Filling::Full)), ..line(name, (ink, "series"), points) });
    }
    let title = "What a charge remembers: 5 kohm after a short circuit, board pi4, simulated".to_owned();
    let x = Axis { label: "length of a charge".to_owned(), from: 0.3e-3, to: 12e-3, write: seconds };
    let y = Axis { label: "error / u".to_owned(), from: UNSEEN, to: 30.0, write: plain };
    std::fs::write(CHART, Plot { title, x, y, series }.alone()).unwrap();
}
