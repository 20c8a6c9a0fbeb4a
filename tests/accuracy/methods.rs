//! Speed against accuracy: every method on the same simulated board.
//!
//! Writes `docs/methods.md` with `UPDATE_DOCS=1 cargo test --test accuracy methods`, and fails when it is out of date.

use crate::common::{Bench, Errors, check_page, kind_of, read, rms, settle};
use cermd::pins::Pins;
use cermd::pins::sim::Kind;
use cermd::reading::Method;
use cermd::units::Nanos;
use plotters::prelude::*;
use std::fmt::Write;

const CHART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/methods.svg");
const INSTRUMENTS: u64 = 40;
const READINGS: usize = 100;
/// Before the first reading that counts: noise is known, and calibration discharges are taken only as they pay.
const BEFORE: Nanos = Nanos(4_000_000_000);

const HEAD: &str = "# Methods, speed against accuracy

Every figure on this page is **simulated**: scene `pi4` (2.2 uF / 680 nF, or one capacitor of 470 nF;
Rc 470 / 12700 ohm; latencies, noise and thresholds as `hw/scenes/pi4.toml` says, some of them assumed), no sensor but a
constant resistor, 40 instruments with 100 readings each, from 4 s after the start on. The page is written by
`UPDATE_DOCS=1 cargo test --test accuracy methods`, and the same test fails when it is out of date.

`error` is the root mean square of all errors, `u` that of the stated uncertainties (both 1 sigma), `within 2u` the share
of readings that are off by less than two of their own sigma (95 % is honest). `time` is a whole cycle: charges,
calibration discharges, the reading; the look for a leak, one discharge in 5 s, is not in it. `error x sqrt(time)`
compares methods at equal time. It is the error of a mean only as far as readings have nothing in common; those of `tracked` share a
state. What means over a time are worth is measured: [averages.md](averages.md).

![Error of a reading times the root of its time against resistance, by method](methods.svg)

| method | R_x / ohm | error / ohm | u / ohm | within 2u | time / ms | readings/s | error x sqrt(time) / ohm sqrt(s) |
|---|--:|--:|--:|--:|--:|--:|--:|
";

struct Row {
    errors: Errors,
    seconds: f64,
}

/// A method on its usual circuit, or on another one.
type Way = (&'static str, Method, Option<Kind>);

const WAYS: [Way; 6] = [
    ("tpcm", Method::Tpcm, None),
    ("qerm", Method::Qerm, None),
    ("tcdic", Method::Tcdic, None),
    ("cerm", Method::Cerm, None),
    ("tracked", Method::Tracked, None),
    ("tracked, one capacitor", Method::Tracked, Some(Kind::OneCapacitor)),
];

fn measure((_, method, kind): Way, r_ohm: f64) -> Row {
    let kind = kind.unwrap_or(kind_of(method));
    let (mut errors, mut seconds) = (Errors::default(), 0.0);
    for seed in 0..INSTRUMENTS {
        errors.next_board();
        let mut instrument = Bench::with_kind("pi4", kind, method, r_ohm, seed, "").instrument();
        settle(&mut instrument);
        while instrument.pins().now() < BEFORE {
            instrument.step(&mut |_| {}).unwrap();
        }
        read(&mut instrument, READINGS, |reading| {
            errors.add(reading, r_ohm);
            seconds += reading.duration.as_seconds() / (INSTRUMENTS as f64 * READINGS as f64);
        });
    }
    // A late stamp of a single stretch says that the sensor moves.
    Row { errors: errors.at_rest(), seconds }
}

/// On a background of its own, so that it is legible on a dark page, too.
fn chart(rows: &[(&str, f64, f64)]) -> String {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (760, 420)).into_drawing_area();
    area.fill(&WHITE).unwrap();
    let mut chart = ChartBuilder::on(&area)
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .caption("Error of a reading x sqrt(time) (1 sigma, simulated, board pi4)", ("sans-serif", 17))
        .build_cartesian_2d((80.0..20_000.0).log_scale(), (0.01..6.0).log_scale())
        .unwrap();
    let (x_label, y_label) = (|x: &f64| format!("{x}"), |y: &f64| format!("{y}"));
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("R_x / ohm")
        .y_desc("error x sqrt(time) / ohm sqrt(s)")
        .x_label_formatter(&x_label)
        .y_label_formatter(&y_label);
    mesh.axis_desc_style(("sans-serif", 15)).label_style(("sans-serif", 13)).draw().unwrap();
    let colours = [
        RGBColor(120, 120, 120),
        RGBColor(214, 126, 0),
        RGBColor(0, 114, 178),
        RGBColor(0, 140, 90),
        RED,
        RGBColor(150, 70, 160),
    ];
    for ((method, ..), colour) in WAYS.into_iter().zip(colours) {
        let points: Vec<(f64, f64)> =
            rows.iter().filter(|row| row.0 == method).map(|row| (row.1, row.2)).collect();
        let line = LineSeries::new(points.clone(), colour.stroke_width(2)).point_size(3);
        let name = chart.draw_series(line).unwrap().label(method);
        name.legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], colour.stroke_width(3)));
    }
    let mut legend = chart.configure_series_labels();
    legend.position(SeriesLabelPosition::LowerRight).background_style(WHITE).border_style(BLACK.mix(0.3));
    legend.label_font(("sans-serif", 14)).draw().unwrap();
    drop(chart);
    drop(area);
    svg
}

#[test]
fn the_page_is_up_to_date_and_tracking_pays() {
    let mut page = HEAD.to_owned();
    let (mut at_equal_time, mut figures) = (Vec::new(), Vec::new());
    for way in WAYS {
        for r_ohm in [100.0, 1000.0, 5000.0, 16_200.0] {
            let method = way.0;
            let Row { errors, seconds } = measure(way, r_ohm);
            let error = rms(&errors.errors);
            at_equal_time.push((method, r_ohm, error * seconds.sqrt()));
            figures.push((method, r_ohm, errors.rms_ratio(1.0).times(seconds.sqrt())));
            writeln!(
                page,
                "| {method} | {r_ohm} | {error:.2} | {:.2} | {:.1} % | {:.1} | {:.0} | {:.3} |",
                rms(&errors.us),
                100.0 * errors.coverage(),
                1e3 * seconds,
                1.0 / seconds,
                error * seconds.sqrt()
            )
            .unwrap();
        }
    }
    let of = |method: &str, r_ohm: f64| {
        figures.iter().find(|row| row.0 == method && row.1 == r_ohm).map(|row| row.2).unwrap()
    };
    for (r_ohm, factor) in [(100.0, 8.0), (1000.0, 4.0), (16_200.0, 2.0)] {
        let gain = of("cerm", r_ohm).over(of("tracked", r_ohm));
        assert!(
            gain.is_in(factor..=5.0 * factor),
            "{r_ohm} ohm: tracked is {gain:.2} times better, seeds 0..{INSTRUMENTS}"
        );
    }
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(CHART, chart(&at_equal_time)).unwrap();
    }
    check_page("accuracy methods", "methods.md", &page);
}
