//! The front: error against time for each published reading, beside the bound of each circuit and what one would take instead.

use super::axis::{Axis, ohms, percent, seconds};
use super::limits::{SHOWN, TIMES};
use super::mark::{Filling, Ink, Mark};
use super::plot::{Plot, Point, Series};
use super::rivals::RIVALS;
use super::setting::{Setting, resistances};
use super::{Drawing, Figure};
use crate::characterize::table::{Row, Vary};

/// The strokes of bounds.
const DOTS: [&str; 4] = ["thin dots0", "thin dots1", "thin dots2", "thin dots3"];

/// A row with what a front needs: seconds for each reading that it counts, and ohm.
#[derive(Debug, Clone, Copy)]
pub struct Priced<'a> {
    pub row: &'a Row,
    pub seconds: f64,
    pub error: f64,
}

/// Of rows with numbers on a scene that is as it should be; with other capacitors, where there are the scene's own to compare.
pub fn priced(rows: &[Row]) -> Vec<Priced<'_>> {
    let with = |row: &'_ Row| Some((row.counted_s()?, row.rms_ohm?));
    let known = resistances(rows.iter().filter(|row| row.vary.is_none()));
    let is_other = |row: &Row| is_resized(row) && row.vary_value != Some(1.0) && known.contains(&row.r_ohm);
    let is_own = |row: &&Row| row.vary.is_none() || is_other(row);
    rows.iter()
        .filter(|row| row.counted() > 0.5)
        .filter(is_own)
        .filter_map(|row| with(row).map(|(seconds, error)| Priced { row, seconds, error }))
        .filter(|priced| priced.seconds > 0.0 && priced.error > 0.0)
        .collect()
}

fn is_resized(row: &Row) -> bool {
    row.vary == Some(Vary::Capacitor)
}

/// Those that no other one beats in both, from the fastest on.
pub fn front<'a>(all: &[Priced<'a>]) -> Vec<Priced<'a>> {
    let mut sorted = all.to_vec();
    sorted.sort_by(|a, b| a.seconds.total_cmp(&b.seconds).then(a.error.total_cmp(&b.error)));
    let mut best = f64::INFINITY;
    sorted.retain(|priced| {
        let is_better = priced.error < best;
        best = best.min(priced.error);
        is_better
    });
    sorted
}

/// One figure for each resistance that is shown.
pub fn figures(rows: &[Row], board: &str) -> Vec<Figure> {
    let all = priced(rows);
    let known = resistances(all.iter().map(|priced| priced.row));
    let near = |wanted: f64| {
        let distance = |r_ohm: &f64| (r_ohm / wanted).ln().abs();
        known.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let mut shown: Vec<f64> = SHOWN.into_iter().filter_map(near).collect();
    shown.dedup();
    shown.into_iter().filter_map(|r_ohm| figure(&all, r_ohm, board)).collect()
}

fn figure(all: &[Priced], r_ohm: f64, board: &str) -> Option<Figure> {
    let here: Vec<Priced> = all.iter().filter(|priced| priced.row.r_ohm == r_ohm).copied().collect();
    let (resized, plain): (Vec<Priced>, Vec<Priced>) = here.iter().partition(|priced| is_resized(priced.row));
    let settings = Setting::all(plain.iter().map(|priced| Setting::of(priced.row)));
    let best = front(&here);
    let last = here.iter().map(|priced| priced.seconds).fold(TIMES[1], f64::max);
    let mut series = vec![stairs(&best, last)];
    let rivals = RIVALS.iter().map(|rival| of_rival(rival, r_ohm, last));
    series.extend(rivals.filter(|it| !it.points.is_empty()));
    let ours = series.len();
    series.extend(bounds(&here, last));
    series.extend(settings.iter().filter_map(|setting| sizes(setting, &settings, &resized)));
    series.extend(settings.iter().map(|setting| measured(setting, &settings, &plain)));
    // What a rival's averages come to may leave the figure, its single sample may not.
    let single = series[1..ours].iter().map(|rival| &rival.points[0]);
    let all = series[..1].iter().chain(&series[ours..]).flat_map(|series| &series.points);
    let errors = all.chain(single).map(|point| point.y);
    let times = here.iter().map(|priced| priced.seconds).chain(TIMES);
    let x = Axis::decades("time per published reading", seconds, times)?;
    let y = Axis::decades("error of a published reading, 1 sigma", ohms, errors)?;
    let title = format!("Error against time at {}, board {board}", ohms(r_ohm));
    Some(Figure {
        name: format!("front-{r_ohm}-ohm"),
        drawing: Drawing::Plot(Plot { title, x, y, series }),
        text: beside_rivals(&best, r_ohm, last),
    })
}

/// The Pareto front, to the right edge.
fn stairs(best: &[Priced], last: f64) -> Series {
    let point = |seconds, error| Point::new(seconds, error, String::new());
    let mut points: Vec<Point> = best.iter().map(|priced| point(priced.seconds, priced.error)).collect();
    points.extend(best.last().map(|priced| point(last, priced.error)));
    Series { name: String::new(), ink: Ink::BEST, stroke: Some("band"), mark: None, points, is_stairs: true }
}

fn of_rival(rival: &super::rivals::Rival, r_ohm: f64, last: f64) -> Series {
    let says = |[time, error]: [f64; 2]| {
        format!("{}: error {}, {} (computed)", rival.name, ohms(error), seconds(time))
    };
    let point = |at: [f64; 2]| Point::new(at[0], at[1], says(at));
    let index = RIVALS.iter().position(|other| other.name == rival.name).unwrap_or(0);
    let mark = Mark::ROUND[index % Mark::ROUND.len()];
    Series {
        name: rival.name.to_owned(),
        ink: Ink::RIVAL,
        stroke: Some("thin dash"),
        mark: Some((mark, Filling::Hollow)),
        points: rival.points(r_ohm, last).into_iter().map(point).collect(),
        is_stairs: false,
    }
}

/// For each circuit: no mean of discharges is better (Cramer-Rao) if all time goes into charges and discharges of the sensor.
fn bounds<'a>(here: &'a [Priced<'a>], last: f64) -> impl Iterator<Item = Series> + 'a {
    let mut circuits: Vec<(String, f64, f64)> = Vec::new();
    for priced in here.iter().filter(|priced| priced.row.average_s.is_none() && !is_resized(priced.row)) {
        let Some((bound, charge, discharge)) = bound_of(priced.row) else { continue };
        let (name, seconds) = (Setting::of(priced.row).circuit(), charge + discharge);
        // Ohm times the root of a second.
        let product = bound * seconds.sqrt();
        match circuits.iter_mut().find(|(other, ..)| *other == name) {
            Some(known) if product < known.1 => (known.1, known.2) = (product, seconds),
            Some(_) => {}
            None => circuits.push((name, product, seconds)),
        }
    }
    circuits.into_iter().enumerate().map(move |(index, (name, product, first))| {
        let point = |x: f64| Point::new(x, product / x.sqrt(), String::new());
        Series {
            name: format!("bound, {name}"),
            ink: Ink::NEUTRAL,
            stroke: Some(DOTS[index % DOTS.len()]),
            mark: None,
            points: [first, last].map(point).to_vec(),
            is_stairs: false,
        }
    })
}

fn bound_of(row: &Row) -> Option<(f64, f64, f64)> {
    Some((row.bound_ohm?, row.charge_s?, row.discharge_s?)).filter(|(bound, ..)| *bound > 0.0)
}

fn measured(setting: &Setting, all: &[Setting], here: &[Priced]) -> Series {
    let name = setting.name(all);
    let mut own: Vec<&Priced> = here.iter().filter(|priced| Setting::of(priced.row) == *setting).collect();
    own.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let point = |priced: &&Priced| Point {
        scatter: scatter(priced.row),
        ..Point::new(priced.seconds, priced.error, says(&name, priced))
    };
    Series {
        points: own.iter().map(point).collect(),
        ink: setting.ink(),
        stroke: Some("series"),
        mark: Some(setting.mark(all)),
        name,
        is_stairs: false,
    }
}

/// A setting's circuit with capacitors of other sizes: one line, whose points tell theirs.
fn sizes(setting: &Setting, all: &[Setting], resized: &[Priced]) -> Option<Series> {
    let mut own: Vec<&Priced> =
        resized.iter().filter(|priced| Setting::nominal(priced.row) == *setting).collect();
    own.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let point = |priced: &&Priced| {
        let says = says(&Setting::of(priced.row).name(&[]), priced);
        Point { scatter: scatter(priced.row), ..Point::new(priced.seconds, priced.error, says) }
    };
    (!own.is_empty()).then(|| Series {
        // Its colour and its shape name it; at its end there is no room.
        name: String::new(),
        ink: setting.ink(),
        stroke: Some("thin dash"),
        mark: Some((setting.mark(all).0, Filling::Hollow)),
        points: own.iter().map(point).collect(),
        is_stairs: false,
    })
}

/// Of a root mean square of so many errors, if they have nothing in common; `None` where it is smaller than a mark.
fn scatter(row: &Row) -> Option<f64> {
    let count = row.readings as f64 * row.counted();
    Some((0.5 / count).sqrt()).filter(|part| *part > 0.05 && *part < 1.0)
}

fn says(name: &str, priced: &Priced) -> String {
    let average = priced
        .row
        .average_s
        .map_or("single readings".to_owned(), |time| format!("means over {}", seconds(time)));
    let u = priced.row.u_ohm.map_or(String::new(), |u| format!(", stated {}", ohms(u)));
    let (error, each) = (ohms(priced.error), seconds(priced.seconds));
    let lost = 1.0 - priced.row.counted();
    let lost = if lost > 0.0 { format!(", {} of them lost", percent(lost)) } else { String::new() };
    format!(
        "{name}, {average}: error {error}{u}, one in {each}; {} readings{lost}, {}",
        priced.row.readings, priced.row.source
    )
}

/// When a rival is better than all of ours at the same time, and by how much at first.
fn beside_rivals(best: &[Priced], r_ohm: f64, last: f64) -> String {
    let ours = |time: f64| best.iter().rev().find(|priced| priced.seconds <= time);
    let mut better = Vec::new();
    for rival in &RIVALS {
        let points = rival.points(r_ohm, last);
        let is_ahead =
            |[time, error]: &[f64; 2]| ours(time.max(TIMES[0])).is_none_or(|ours| *error < ours.error);
        let runs = points.chunk_by(|one, next| is_ahead(one) == is_ahead(next));
        let ahead: Vec<&[[f64; 2]]> = runs.filter(|run| is_ahead(&run[0])).collect();
        if let Some([time, error]) = ahead.first().map(|run| run[0]) {
            let against = ours(time)
                .map_or("nothing of ours is as fast".to_owned(), |ours| format!("ours {}", ohms(ours.error)));
            let when = ahead.iter().map(|run| span(run)).collect::<Vec<_>>().join(" and ");
            better.push(format!("{} ({when}; first {}, {against})", rival.name, ohms(error)));
        }
    }
    let named = if better.is_empty() { "none of them".to_owned() } else { better.join(", ") };
    format!("Better than the front at {} at the same time per reading: {named}.", ohms(r_ohm))
}

/// From the first to the last of these points.
fn span(run: &[[f64; 2]]) -> String {
    match run {
        [[first, _], .., [last, _]] => format!("from {} to {}", seconds(*first), seconds(*last)),
        _ => run.iter().map(|[at, _]| format!("at {}", seconds(*at))).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    #[test]
    fn nothing_beats_the_front_and_it_falls() {
        let rows = fixture::rows();
        let all: Vec<Priced> =
            priced(&rows).into_iter().filter(|priced| priced.row.r_ohm == 1000.0).collect();
        let best = front(&all);
        assert!(best.len() > 1 && best.windows(2).all(|pair| pair[0].error > pair[1].error), "{best:?}");
        for one in &all {
            let is_beaten = |other: &Priced| other.seconds <= one.seconds && other.error <= one.error;
            assert!(best.iter().any(is_beaten), "{one:?}");
        }
    }

    #[test]
    fn a_bound_falls_with_the_root_of_time_and_is_there_for_each_circuit() {
        let rows = fixture::rows();
        let all: Vec<Priced> =
            priced(&rows).into_iter().filter(|priced| priced.row.r_ohm == 1000.0).collect();
        let bounds: Vec<Series> = bounds(&all, 10.0).collect();
        assert_eq!(bounds.len(), 2, "{bounds:?}");
        for bound in bounds {
            let [first, last] = [&bound.points[0], &bound.points[1]];
            assert!(((first.y / last.y) / (last.x / first.x).sqrt() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn other_sizes_are_points_of_their_own_and_the_scenes_own_size_is_there_once() {
        let rows = fixture::rows();
        let all: Vec<Priced> =
            priced(&rows).into_iter().filter(|priced| priced.row.r_ohm == 1000.0).collect();
        let resized: Vec<Priced> = all.iter().filter(|priced| is_resized(priced.row)).copied().collect();
        assert!(resized.iter().all(|priced| priced.row.vary_value == Some(0.1)), "{resized:?}");
        let settings =
            Setting::all([Setting::of(&fixture::row(crate::reading::Method::Cerm, 1000.0))].into_iter());
        let series = sizes(&settings[0], &settings, &resized).unwrap();
        assert!(series.points[0].says.starts_with("cerm, 220 nF / 68 nF, "), "{}", series.points[0].says);
    }

    #[test]
    fn what_is_no_use_costs_time() {
        let row = Row {
            no_number: 0.2,
            moving: 0.05,
            published_s: Some(0.75),
            ..fixture::row(crate::reading::Method::Cerm, 1000.0)
        };
        let rows = [row];
        let priced = priced(&rows);
        assert!((priced[0].seconds - 1.0).abs() < 1e-9, "{priced:?}");
        let said = says("cerm", &priced[0]);
        assert!(said.contains("one in 1 s; 400 readings, 25 % of them lost"), "{said}");
    }

    #[test]
    fn a_better_rival_is_named() {
        let rows = fixture::rows();
        let figures = figures(&rows, "pi4");
        assert_eq!(figures.len(), 3);
        assert!(
            figures[1].text.contains("ADS1115") && figures[1].text.contains("HX711"),
            "{}",
            figures[1].text
        );
        assert!(!figures[1].text.contains("RCtime"), "{}", figures[1].text);
        // A reading that is soon better than any mean of it.
        let good = Row { published_s: Some(0.01), rms_ohm: Some(0.001), ..rows[0].clone() };
        let all = [Priced { row: &good, seconds: 0.01, error: 0.001 }];
        let text = beside_rivals(&all, good.r_ohm, 10.0);
        assert!(text.contains("ADS1115, 860/s (from 1.16 ms to 3.49 ms; first "), "{text}");
    }
}
