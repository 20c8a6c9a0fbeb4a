//! Figures 4 to 8 of the paper, ours beside what it prints; the table of its numbers is in [`numbers`].

pub mod numbers;

use super::axis::{Axis, Writer, ohms, percent, plain};
use super::mark::{Filling, Ink, Mark};
use super::plot::{Plot, Point, Series};
use super::setting::ink;
use super::{Drawing, Figure};
use crate::characterize::limits::PAPER_READINGS;
use crate::characterize::table::{Row, Source, Vary};
use crate::circuit::Kind;
use crate::reading::Method;
use crate::sensor::FSR_402;
use crate::units::sample::rms;

/// The name of the scene of section IV.
const SCENE: &str = "fpga-paper";
/// Up to there inferred times are as good as (21) and (23) say, in section V; its T_L.
const PRINTED_LIMIT_OHM: f64 = 681.0;
/// The paper's three, in its order.
const METHODS: [Method; 3] = [Method::Tpcm, Method::Tcdic, Method::Cerm];

/// Single readings of the paper's board on its own circuits, of each resistance about as many as in the paper.
pub fn rows(rows: &[Row]) -> Vec<&Row> {
    varied(rows, None)
}

/// The same with a change.
fn varied(rows: &[Row], vary: Option<Vary>) -> Vec<&Row> {
    let own = |row: &&Row| {
        let kind = if row.method == Method::Tpcm { Kind::OneCapacitor } else { Kind::TwoCapacitor };
        let is_plain = row.vary == vary && row.average_s.is_none();
        let each = row.readings as f64 / row.instruments.max(1) as f64;
        // The largest error depends on how many there are.
        let readings = PAPER_READINGS as f64;
        let is_long = (0.5 * readings..=2.0 * readings).contains(&each);
        let is_papers = row.source == Source::Simulated && row.scene == SCENE;
        is_papers && is_plain && is_long && METHODS.contains(&row.method) && row.circuit == kind
    };
    rows.iter().filter(own).collect()
}

/// What the paper prints of a method: resistance, ohm, and the value.
type Printed = &'static [(Method, f64, f64)];

/// Eq. (28), ohm: all that section V prints.
const MAE: Printed = &[
    (Method::Tpcm, 100.0, 5.23),
    (Method::Tcdic, 100.0, 1.94),
    (Method::Cerm, 100.0, 0.88),
    (Method::Cerm, 15_010.0, 6.2),
    (Method::Tpcm, 16_200.0, 13.1),
];

/// Ours, in the colour and shape of a method.
fn simulated(
    rows: &[&Row],
    (name, method): (&str, Method),
    value: impl Fn(&Row) -> Option<[f64; 2]>,
    write: Writer,
) -> Series {
    let mut points: Vec<Point> = rows
        .iter()
        .filter_map(|row| value(row).map(|at| (row, at)))
        .map(|(row, [x, y])| Point::new(x, y, format!("{name}, {}: ours {}", ohms(row.r_ohm), write(y))))
        .collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    let shape = Mark::ROUND[METHODS.iter().position(|other| *other == method).unwrap_or(METHODS.len())];
    let (name, mark) = (format!("{name}, simulated"), Some((shape, Filling::Full)));
    Series { name, ink: ink(method), stroke: Some("series"), mark, points, is_stairs: false }
}

fn measured(
    rows: &[&Row],
    method: Method,
    value: impl Fn(&Row) -> Option<[f64; 2]>,
    write: Writer,
) -> Series {
    let own: Vec<&Row> = rows.iter().filter(|row| row.method == method).copied().collect();
    simulated(&own, (method.as_str(), method), value, write)
}

fn printed(method: Method, points: &[[f64; 2]], write: Writer) -> Series {
    let point = |at: &[f64; 2]| Point::new(at[0], at[1], format!("{method}, printed: {}", write(at[1])));
    Series {
        name: format!("{method}, printed"),
        ink: ink(method),
        stroke: None,
        mark: Some((Mark::Cross, Filling::Hollow)),
        points: points.iter().map(point).collect(),
        is_stairs: false,
    }
}

/// What a figure of the paper shows over resistance.
struct Over {
    name: &'static str,
    title: &'static str,
    label: &'static str,
    methods: &'static [Method],
    value: fn(&Row) -> Option<f64>,
    /// Of a resistance and its printed MAE, ohm; `None` where the paper prints nothing.
    printed: Option<fn(f64, f64) -> f64>,
    write: Writer,
    highest_ohm: f64,
    text: &'static str,
}

const FIG_5B: &str = "paper-fig-5b";
/// The first line of (19), forced. It has the colour of a method that the paper has not.
const INFERRED: &str = "cerm, always inferred";

const OVER: [Over; 4] = [
    Over {
        name: "paper-fig-4",
        title: "Fig. 4: largest of the errors (28), low resistances",
        label: "MAE",
        methods: &METHODS,
        value: |row| row.mae_ohm,
        printed: Some(|_, mae| mae),
        write: ohms,
        highest_ohm: 1500.0,
        text: "Crosses: all values that the paper prints; its curves have no numbers.",
    },
    Over {
        name: FIG_5B,
        title: "Fig. 5(b): uncertainty of a reading",
        label: "standard deviation of readings",
        methods: &METHODS,
        value: |row| row.sd_ohm,
        printed: None,
        write: ohms,
        highest_ohm: f64::INFINITY,
        text: "The paper's CERM infers at all resistances here, by the first line of (19), and so does ours where it says so, with the \
               switch after T_L at the latest; beside it CERM with T_L. The paper's curves have no numbers.",
    },
    Over {
        name: "paper-fig-6a",
        title: "Fig. 6(a): largest of the errors (28), full range",
        label: "MAE",
        methods: &[Method::Tpcm, Method::Cerm],
        value: |row| row.mae_ohm,
        printed: Some(|_, mae| mae),
        write: ohms,
        highest_ohm: f64::INFINITY,
        text: "Crosses: all values that the paper prints.",
    },
    Over {
        name: "paper-fig-6b",
        title: "Fig. 6(b): largest relative error (29)",
        label: "MRE",
        methods: &METHODS,
        value: |row| row.mre_percent.map(|mre| 0.01 * mre),
        printed: Some(|r_ohm, mae| mae / r_ohm),
        write: percent,
        highest_ohm: f64::INFINITY,
        text: "Crosses: the printed MAE over the resistance.",
    },
];

fn over(over: &Over, rows: &[&Row], inferred: &[&Row]) -> Option<Figure> {
    let value = |row: &Row| {
        (over.value)(row).filter(|_| row.r_ohm <= over.highest_ohm).map(|value| [row.r_ohm, value])
    };
    let mut series: Vec<Series> =
        over.methods.iter().map(|method| measured(rows, *method, value, over.write)).collect();
    if over.name == FIG_5B {
        series.push(simulated(&by_limit(inferred), (INFERRED, Method::Tracked), value, over.write));
    }
    for method in over.methods {
        let own = MAE.iter().filter(|(of, r_ohm, _)| of == method && *r_ohm <= over.highest_ohm);
        let points: Vec<[f64; 2]> =
            own.filter_map(|(_, r_ohm, mae)| Some([*r_ohm, (over.printed?)(*r_ohm, *mae)])).collect();
        series.push(printed(*method, &points, over.write));
    }
    series.retain(|series| !series.points.is_empty());
    figure(over.name, over.title, ["resistance", over.label], [ohms, over.write], series, over.text)
}

/// Those with the switch at T_L at the latest, as only then Fig. 5 is what the paper has.
fn by_limit<'a>(inferred: &[&'a Row]) -> Vec<&'a Row> {
    let is_early = |row: &Row| row.vary_value < Some(1.0);
    let has_early = |row: &Row| inferred.iter().any(|other| other.r_ohm == row.r_ohm && is_early(other));
    inferred.iter().filter(|row| is_early(row) || !has_early(row)).copied().collect()
}

/// What inferred times scatter by: with the switch where A crosses, and by T_L.
fn inferred_times(inferred: &[&Row]) -> Vec<Series> {
    let whole: Vec<&Row> = inferred.iter().filter(|row| row.vary_value == Some(1.0)).copied().collect();
    let by_limit = by_limit(inferred);
    let of = |name: &str, method: Method, rows: &[&Row], rsd: fn(&Row) -> Option<f64>| {
        simulated(rows, (name, method), |row| Some([row.r_ohm, rsd(row)?]), percent)
    };
    let hollow = |series: Series| Series {
        stroke: Some("series dash"),
        mark: series.mark.map(|(mark, _)| (mark, Filling::Hollow)),
        ..series
    };
    vec![
        hollow(of("T_i,xA, switch where A crosses", Method::Cerm, &whole, |row| row.t_ixa_rsd)),
        hollow(of("T_i,xB, switch where A crosses", Method::Tcdic, &whole, |row| row.t_ixb_rsd)),
        of("T_i,xA, switch by T_L", Method::Cerm, &by_limit, |row| row.t_ixa_rsd),
        of("T_i,xB, switch by T_L", Method::Tcdic, &by_limit, |row| row.t_ixb_rsd),
    ]
}

/// Fig. 5(a): how relative uncertainties of inferred times leave what (21) and (23) say of them.
fn fig_5a(inferred: &[&Row]) -> Option<Figure> {
    let ours = inferred_times(inferred);
    let ends = |of: fn(&Point) -> f64| {
        let values = || ours.iter().flat_map(|series| &series.points).map(of);
        [values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max)]
    };
    let [x, y] = [ends(|point| point.x), ends(|point| point.y)];
    let line = |name: &str, ink: Ink, ends: [[f64; 2]; 2]| Series {
        name: name.to_owned(),
        ink,
        stroke: Some("dots0 series"),
        mark: None,
        points: ends.map(|[x, y]| Point::new(x, y, String::new())).to_vec(),
        is_stairs: false,
    };
    let second = rms(inferred.iter().filter_map(|row| row.t_c2a_rsd))?;
    let level =
        |name: &str, method: Method, times: f64| line(name, ink(method), x.map(|x| [x, times * second]));
    let printed = [
        level("(21): sqrt(3) u(T_c2A) / T_c2A", Method::Cerm, 3f64.sqrt()),
        level("(23): u(T_c2A) / T_c2A", Method::Tcdic, 1.0),
        line("T_L, printed: 681 ohm", Ink::NEUTRAL, y.map(|y| [PRINTED_LIMIT_OHM, y])),
    ];
    let text = "Standard deviations as parts of their means, CERM inferring at all resistances. Dotted, level: (21) and (23), from the simulated \
                T_c2A. The paper prints no number but the resistance up to which its curves follow these. Ours do so everywhere where the switch \
                comes where A crosses, by factors of 330 nF / 22 nF in the place of sqrt(3) and 1, and only up to there where it comes after T_L \
                at the latest.";
    let labels = ["resistance", "standard deviation, relative"];
    let series = printed.into_iter().chain(ours).collect();
    figure("paper-fig-5a", "Fig. 5(a): uncertainty of inferred times", labels, [ohms, percent], series, text)
}

/// Over two logarithmic axes, as all of the paper's are drawn here.
fn figure(
    name: &str,
    title: &str,
    labels: [&str; 2],
    write: [Writer; 2],
    series: Vec<Series>,
    text: &str,
) -> Option<Figure> {
    let points = || series.iter().flat_map(|series| &series.points);
    let mut x = Axis::decades(labels[0], write[0], points().map(|point| point.x))?;
    let y = Axis::decades(labels[1], write[1], points().map(|point| point.y))?;
    // The paper's resistances end short of two decades.
    let most = points().map(|point| point.x).fold(0.0, f64::max);
    x.to = x.to.min(most * 1.3);
    let plot = Plot { title: title.to_owned(), x, y, series };
    Some(Figure { name: name.to_owned(), drawing: Drawing::Plot(plot), text: text.to_owned() })
}

fn newtons(value: f64) -> String {
    format!("{} N", plain(value))
}

/// Fig. 7 and 8: forces by eq. (1) with the paper's own fit.
fn forces(rows: &[&Row]) -> Vec<Option<Figure>> {
    let curve = |r_ohm: f64| {
        Point::new(FSR_402.0 / r_ohm, r_ohm, format!("{}: {}", newtons(FSR_402.0 / r_ohm), ohms(r_ohm)))
    };
    let fit = Series {
        name: "13346.46 N ohm / F".to_owned(),
        ink: Ink(2),
        stroke: Some("series"),
        mark: None,
        points: [FSR_402.0, 445.0].map(curve).to_vec(),
        is_stairs: false,
    };
    let pair = |(f, r_ohm): (f64, f64)| {
        Point::new(f, r_ohm, format!("measured in the paper: {} at {}", ohms(r_ohm), newtons(f)))
    };
    let pairs = Series {
        name: "printed pairs".to_owned(),
        ink: Ink(4),
        stroke: None,
        mark: Some((Mark::Cross, Filling::Hollow)),
        points: [(1.20, 11_122.0), (6.06, 2200.0)].map(pair).to_vec(),
        is_stairs: false,
    };
    let of_force = |row: &Row| row.mre_percent.map(|mre| [FSR_402.0 / row.r_ohm, 0.01 * mre]);
    let mut errors: Vec<Series> =
        [Method::Cerm, Method::Tcdic].map(|method| measured(rows, method, of_force, percent)).to_vec();
    let largest = [FSR_402.0 / 100.0, 0.0088];
    errors.push(printed(Method::Cerm, &[largest], percent));
    errors.retain(|series| !series.points.is_empty());
    vec![
        figure(
            "paper-fig-7",
            "Fig. 7: resistance of the FSR 402 against force",
            ["force", "resistance"],
            [newtons, ohms],
            vec![fit, pairs],
            "The paper prints two of its 17 pairs of force and resistance; nothing of ours is in this figure.",
        ),
        figure(
            "paper-fig-8",
            "Fig. 8: largest relative error of a force",
            ["force", "MRE"],
            [newtons, percent],
            errors,
            "Ours are the errors of resistances, as forces by eq. (1): a small relative error is the same for both.",
        ),
    ]
}

/// All of them, where the table has the paper's board.
pub fn figures(all: &[Row]) -> Vec<Figure> {
    let rows = rows(all);
    if rows.is_empty() {
        return Vec::new();
    }
    let inferred = varied(all, Some(Vary::SwitchFraction));
    let [low, rest @ ..] = OVER.each_ref().map(|one| over(one, &rows, &inferred));
    [low, fig_5a(&inferred)].into_iter().chain(rest).chain(forces(&rows)).flatten().collect()
}
