//! Error over u against the length of a charge.

use super::bench::{Board, LONG_TAUS, NEIGHBOUR_OHM};
use cermd::circuit::Chargers;
use cermd::reading::Method;
use plotters::prelude::*;

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

/// On a background of its own, so that it is legible on a dark page, too.
pub fn write(curves: &[Curve]) {
    let area = SVGBackend::new(CHART, (760, 420)).into_drawing_area();
    area.fill(&WHITE).unwrap();
    let mut chart = ChartBuilder::on(&area)
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .caption(
            "What a charge remembers: 5 kohm after a short circuit (simulated, board pi4)",
            ("sans-serif", 17),
        )
        .build_cartesian_2d((0.3..12.0).log_scale(), (UNSEEN..30.0).log_scale())
        .unwrap();
    let label = |value: &f64| format!("{value}");
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("length of a charge / ms")
        .y_desc("error / u")
        .x_label_formatter(&label)
        .y_label_formatter(&label);
    mesh.axis_desc_style(("sans-serif", 15)).label_style(("sans-serif", 13)).draw().unwrap();
    chart.draw_series(LineSeries::new([(0.3, super::SHARE), (12.0, super::SHARE)], BLACK.mix(0.5))).unwrap();
    let colours = [RGBColor(0, 140, 90), RGBColor(120, 120, 120), RED, RGBColor(0, 114, 178)];
    for ((name, points), colour) in curves.iter().zip(colours) {
        let line = LineSeries::new(points.clone(), colour.stroke_width(2)).point_size(3);
        let drawn = chart.draw_series(line).unwrap().label(name);
        drawn.legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], colour.stroke_width(3)));
    }
    let mut legend = chart.configure_series_labels();
    legend.position(SeriesLabelPosition::UpperRight).background_style(WHITE).border_style(BLACK.mix(0.3));
    legend.label_font(("sans-serif", 14)).draw().unwrap();
}
