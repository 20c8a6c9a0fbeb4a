//! What an error is made of, where the time goes, how it settles, how honest it is: over resistance, method and effect.

use super::axis::{Axis, digits, ohms, percent, seconds};
use super::heat::{Grid, Heat, Ramp, Tile, cells};
use super::mark::Filling;
use super::plot::{Plot, Point, Series};
use super::setting::{Setting, resistances};
use super::{Drawing, Figure};
use crate::characterize::table::{Row, Vary};

/// Single readings of the scene as it is.
fn plain(rows: &[Row]) -> impl Iterator<Item = &Row> + Clone {
    rows.iter().filter(|row| row.vary.is_none() && row.average_s.is_none())
}

/// What part of the variance is gone when one effect is switched off.
pub fn budget(rows: &[Row], board: &str) -> Option<Figure> {
    let without: Vec<&Row> = rows.iter().filter(|row| row.vary == Some(Vary::Without)).collect();
    let settings = Setting::all(without.iter().copied().map(Setting::nominal));
    let columns = resistances(without.iter().copied());
    let mut effects: Vec<&str> = Vec::new();
    for name in without.iter().filter_map(|row| row.vary_name.as_deref()) {
        if !effects.contains(&name) {
            effects.push(name);
        }
    }
    let cell = |setting: &Setting, effect: &str, r_ohm: f64| {
        let is_own = |row: &&Row| row.r_ohm == r_ohm && Setting::nominal(row) == *setting;
        let is_without = |row: &&Row| is_own(row) && row.vary_name.as_deref() == Some(effect);
        let all = plain(rows).find(is_own)?.rms_ohm?;
        let less = without.iter().copied().find(is_without)?.rms_ohm?;
        Some(part_of(&format!("{}, {}", setting.name(&settings), ohms(r_ohm)), effect, [all, less]))
    };
    let grid = |setting: &Setting| Grid {
        name: format!("{}, %", setting.name(&settings)),
        ramp: Ramp::Amount,
        cells: cells(&effects, &columns, |effect, r_ohm| cell(setting, effect, *r_ohm)),
    };
    let heat = Heat {
        title: format!("Error budget: part of the variance that goes with an effect, board {board}"),
        axes: ["the effect that is switched off", "resistance"].map(str::to_owned),
        rows: effects.iter().map(|effect| (*effect).to_owned()).collect(),
        columns: columns.iter().map(|r_ohm| ohms(*r_ohm)).collect(),
        grids: settings.iter().map(grid).collect(),
        abreast: 2,
    };
    let text = "Measured by switching one effect of the scene off at a time. The parts need not add up to 100 %: a program that sees less \
                noise decides otherwise, and small parts scatter about zero.";
    (!without.is_empty()).then(|| heat.figure("error-budget", text))
}

/// Errors with all effects and without one, ohm.
fn part_of(name: &str, effect: &str, [all, less]: [f64; 2]) -> Tile {
    let part = 1.0 - (less / all).powi(2);
    let (with_all, without, percent) = (ohms(all), ohms(less), percent(part));
    Tile {
        // Without the sign of a zero.
        text: format!("{:.0}", (100.0 * part).round() + 0.0),
        says: format!("{name}: {with_all} with all, {without} without {effect}: {percent} of the variance"),
        share: Some(part),
        failed: None,
    }
}

/// The parts of the time of a reading.
type Part = (&'static str, fn(&Row) -> Option<f64>);

const PARTS: [Part; 4] = [
    ("charge", |row| row.charge_s),
    ("discharge", |row| row.discharge_s),
    ("calibration", |row| row.calibration_s),
    ("overhead", |row| row.overhead_s),
];

/// Where the time of a reading goes.
pub fn times(rows: &[Row], board: &str) -> Option<Figure> {
    let split: Vec<&Row> =
        plain(rows).filter(|row| row.charge_s.is_some() && row.published_s.is_some()).collect();
    let settings = Setting::all(split.iter().copied().map(Setting::nominal));
    let all = resistances(split.iter().copied());
    // Few are enough: the lowest, the highest, and two between.
    let picked: Vec<f64> = if all.len() > 4 {
        [0, all.len() / 3, 2 * all.len() / 3, all.len() - 1].map(|at| all[at]).to_vec()
    } else {
        all
    };
    let cell = |setting: &Setting, r_ohm: f64, (name, part): &Part| {
        let row = split.iter().find(|row| row.r_ohm == r_ohm && Setting::nominal(row) == *setting)?;
        let (time, all) = (part(row)?, row.published_s?);
        let of = format!(
            "{}, {}: {name} {} of {}",
            setting.name(&settings),
            ohms(r_ohm),
            seconds(time),
            seconds(all)
        );
        Some(Tile { text: digits(1e3 * time, 2), says: of, share: Some(time / all), failed: None })
    };
    let grid = |r_ohm: &f64| Grid {
        name: format!("{}, ms", ohms(*r_ohm)),
        ramp: Ramp::Amount,
        cells: cells(&settings, &PARTS, |setting, part| cell(setting, *r_ohm, part)),
    };
    let heat = Heat {
        title: format!("Where the time of a reading goes, board {board}"),
        axes: ["method and circuit", "part of the time"].map(str::to_owned),
        rows: settings.iter().map(|setting| setting.name(&settings)).collect(),
        columns: PARTS.iter().map(|(name, _)| (*name).to_owned()).collect(),
        grids: picked.iter().map(grid).collect(),
        abreast: 2,
    };
    let text = "Milliseconds of a single reading; the brighter, the larger a part of its time. Calibration includes its charges and looks for a leak; \
                overhead is what is left: calls, waking, computing.";
    (!split.is_empty()).then(|| heat.figure("times", text))
}

/// Error and stated uncertainty against the time since the start, a figure for each resistance.
pub fn settling(rows: &[Row], board: &str) -> Vec<Figure> {
    let since = rows.iter().filter(|row| row.vary == Some(Vary::SinceStart));
    let known = resistances(since.clone()).into_iter();
    let own = |r_ohm: f64| since.clone().filter(move |row| row.r_ohm == r_ohm).collect::<Vec<_>>();
    known.filter_map(|r_ohm| settling_at(r_ohm, &own(r_ohm), board)).collect()
}

fn settling_at(r_ohm: f64, own: &[&Row], board: &str) -> Option<Figure> {
    let settings = Setting::all(own.iter().copied().map(Setting::nominal));
    let line = |setting: &Setting, what: &str, of: fn(&Row) -> Option<f64>, stroke: &'static str| {
        let name = setting.name(&settings);
        let mut points: Vec<Point> = own
            .iter()
            .filter(|row| Setting::nominal(row) == *setting)
            .filter_map(|row| row.vary_value.zip(of(row)))
            .map(|(x, y)| {
                Point::new(x, y, format!("{name}, up to {} after the start: {what} {}", seconds(x), ohms(y)))
            })
            .collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let is_u = what == "u";
        let (mark, filling) = setting.mark(&settings);
        let filling = if is_u { Filling::Hollow } else { filling };
        let name = if is_u { String::new() } else { name };
        Series {
            name,
            ink: setting.ink(),
            stroke: Some(stroke),
            mark: Some((mark, filling)),
            points,
            is_stairs: false,
        }
    };
    let mut series = Vec::new();
    for setting in &settings {
        series.push(line(setting, "u", |row| row.u_ohm, "thin dash"));
        series.push(line(setting, "error", |row| row.rms_ohm, "series"));
    }
    let points = || series.iter().flat_map(|series| &series.points);
    let x = Axis::decades("time since the start", seconds, points().map(|point| point.x))?;
    let y = Axis::decades("error, and stated u (dashed), 1 sigma", ohms, points().map(|point| point.y))?;
    let title = format!("Settling after the start at {}, board {board}", ohms(r_ohm));
    let text = "Each point is of the readings since the one before. Full: root mean square error. Hollow, dashed: what is stated, a wide prior until \
                the circuit has shown its noise."
        .to_owned();
    let name = format!("settling-{r_ohm}-ohm");
    Some(Figure { name, drawing: Drawing::Plot(Plot { title, x, y, series }), text })
}

/// The share of readings within 2u, by method and by what is not as it should be.
pub fn coverage(rows: &[Row], board: &str) -> Option<Figure> {
    let known: Vec<&Row> =
        rows.iter().filter(|row| row.coverage.is_some() && row.vary != Some(Vary::Without)).collect();
    let settings = Setting::all(known.iter().copied().map(Setting::nominal));
    let mut columns: Vec<Option<Vary>> = vec![None];
    columns.extend(Vary::ALL.into_iter().map(Some).filter(|vary| known.iter().any(|row| row.vary == *vary)));
    let cell = |setting: &Setting, vary: &Option<Vary>| {
        let own = known.iter().filter(|row| Setting::nominal(row) == *setting && row.vary == *vary);
        let (mut readings, mut within, mut least) = (0.0, 0.0, f64::INFINITY);
        for (count, coverage) in
            own.filter_map(|row| Some((row.readings as f64 * (1.0 - row.no_number), row.coverage?)))
        {
            (readings, within, least) = (readings + count, within + count * coverage, coverage.min(least));
        }
        let share = within / readings;
        let name = vary.map_or("as it is", Vary::as_str);
        let says = format!(
            "{}, {name}: {} of all within 2u, in the worst cell {}",
            setting.name(&settings),
            percent(share),
            percent(least)
        );
        let text = format!("{:.1}", 100.0 * share);
        // From all within, blue, over 95.4 % to 85 %, red.
        (readings > 0.0).then(|| Tile { text, says, share: Some(0.5 + (0.954 - share) / 0.2), failed: None })
    };
    let heat = Heat {
        title: format!("Readings within twice their own uncertainty, %, board {board}"),
        axes: ["method and circuit", "what is varied"].map(str::to_owned),
        rows: settings.iter().map(|setting| setting.name(&settings)).collect(),
        columns: columns.iter().map(|vary| vary.map_or("as it is", Vary::as_str).to_owned()).collect(),
        grids: vec![Grid {
            name: "within 2u, %".to_owned(),
            ramp: Ramp::Ratio,
            cells: cells(&settings, &columns, cell),
        }],
        abreast: 1,
    };
    let text = "95.4 % is honest. Each number is of all resistances and amounts together; hovering tells the worst cell.";
    (!known.is_empty()).then(|| heat.figure("coverage", text))
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    fn cells(figure: &Figure) -> Vec<Tile> {
        let Drawing::Heat(heat) = &figure.drawing else { panic!("a plot") };
        heat.grids.iter().flat_map(|grid| grid.cells.iter().flatten().flatten().cloned()).collect()
    }

    #[test]
    fn an_effect_that_halves_the_error_is_three_quarters_of_the_variance() {
        let rows = fixture::rows();
        let cells = cells(&budget(&rows, "pi4").unwrap());
        assert!(!cells.is_empty() && cells.iter().all(|cell| cell.text == "75"), "{cells:?}");
    }

    #[test]
    fn the_parts_of_a_time_are_those_of_its_row() {
        let rows = fixture::rows();
        let cells = cells(&times(&rows, "pi4").unwrap());
        let shares: f64 = cells.iter().take(PARTS.len()).filter_map(|cell| cell.share).sum();
        assert!((shares - 1.0).abs() < 1e-9, "{shares}");
    }

    #[test]
    fn settling_is_shown_at_every_resistance_where_it_was_looked_at() {
        let figures = settling(&fixture::rows(), "pi4");
        let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
        assert_eq!(names, ["settling-100-ohm", "settling-1000-ohm", "settling-16200-ohm"]);
    }

    #[test]
    fn coverage_is_of_readings_not_of_cells() {
        let few =
            Row { readings: 100, coverage: Some(0.5), ..fixture::row(crate::reading::Method::Cerm, 100.0) };
        let many = Row { readings: 900, coverage: Some(1.0), r_ohm: 1000.0, ..few.clone() };
        let cells = cells(&coverage(&[few, many], "pi4").unwrap());
        assert_eq!(cells[0].text, "95.0");
        assert!(cells[0].says.ends_with("in the worst cell 50 %"), "{}", cells[0].says);
    }
}
