//! Where methods fail: error and honesty over resistance and one thing that is not as it should be.

use super::Figure;
use super::axis::{Writer, digits, ohms, percent, plain, seconds};
use super::heat::{Grid, Heat, Ramp, Tile, cells};
use super::limits::{COARSE, HONEST, SILENT};
use super::setting::{Setting, resistances};
use crate::characterize::table::{Row, Vary};

/// What is varied, what it is called, and how its amount is written.
type Map = (Vary, &'static str, Writer);

const MAPS: [Map; 5] = [
    (Vary::Jitter, "jitter of stamps", seconds),
    (Vary::OffsetError, "error of a given offset", seconds),
    (Vary::Capacitor, "size of capacitors", times),
    (Vary::Leakage, "leakage from each sense node to ground", ohms),
    (Vary::Speed, "speed of a moving sensor", a_second),
];

fn times(value: f64) -> String {
    format!("x {}", plain(value))
}

fn a_second(value: f64) -> String {
    format!("{}/s", percent(value))
}

/// One figure for each thing that was varied.
pub fn figures(rows: &[Row], board: &str) -> Vec<Figure> {
    MAPS.iter().filter_map(|map| figure(rows, board, map)).collect()
}

fn figure(rows: &[Row], board: &str, (vary, what, write): &Map) -> Option<Figure> {
    let own: Vec<&Row> =
        rows.iter().filter(|row| row.vary == Some(*vary) && row.vary_value.is_some()).collect();
    let settings = Setting::all(own.iter().copied().map(Setting::nominal));
    let columns = resistances(own.iter().copied());
    let mut amounts: Vec<f64> = own.iter().filter_map(|row| row.vary_value).collect();
    amounts.sort_by(f64::total_cmp);
    amounts.dedup();
    let mut grids = Vec::new();
    for setting in &settings {
        let name = setting.name(&settings);
        let find = |amount: f64, r_ohm: f64| {
            let is_it = |row: &&&Row| {
                row.vary_value == Some(amount) && row.r_ohm == r_ohm && Setting::nominal(row) == *setting
            };
            own.iter().find(is_it).copied()
        };
        let all = |cell: fn(&Row, &str) -> Tile| {
            cells(&amounts, &columns, |amount, r_ohm| {
                find(*amount, *r_ohm)
                    .map(|row| cell(row, &format!("{name}, {}, {what} {}", ohms(*r_ohm), write(*amount))))
            })
        };
        grids.push(Grid { name: format!("{name}: error, %"), ramp: Ramp::Amount, cells: all(error) });
        grids.push(Grid { name: format!("{name}: error / u"), ramp: Ramp::Ratio, cells: all(honesty) });
    }
    let heat = Heat {
        title: format!("Where it fails: resistance and {what}, board {board}"),
        axes: [(*what).to_owned(), "resistance".to_owned()],
        rows: amounts.iter().map(|amount| write(*amount)).collect(),
        columns: columns.iter().map(|r_ohm| ohms(*r_ohm)).collect(),
        grids,
        abreast: 2,
    };
    let text = "Left: root mean square error in percent of the resistance. Right: that error over the stated uncertainty; above 1, red, it says \
                too little, below, blue, it is cautious. Framed cells fail, by the cause in the list.";
    (!own.is_empty()).then(|| heat.figure(format!("map-{vary}"), text))
}

/// Why a cell counts as failed.
pub fn failure(row: &Row) -> Option<String> {
    if row.readings == 0 {
        return Some("no reading at all".to_owned());
    }
    if row.no_number >= SILENT {
        return Some(format!("no number: {}", row.reason.as_deref().unwrap_or("for reasons not told")));
    }
    if row.vary != Some(Vary::Speed) && row.no_number + row.moving >= SILENT {
        return Some("says that the sensor moves".to_owned());
    }
    if row.coverage.is_some_and(|coverage| coverage < HONEST) {
        let is_bias = row.bias_ohm.zip(row.sd_ohm).is_some_and(|(bias, sd)| bias.abs() > sd);
        let cause = if is_bias { "a bias that it does not know" } else { "scatter that it does not know" };
        return Some(format!("u is too small: {cause}"));
    }
    let is_coarse = row.rms_ohm.is_some_and(|error| error > COARSE * row.r_ohm);
    is_coarse.then(|| format!("the error is above {}", percent(COARSE)))
}

fn error(row: &Row, name: &str) -> Tile {
    let part = row.rms_ohm.map(|error| error / row.r_ohm);
    Tile {
        text: part.map_or(String::new(), |part| digits(100.0 * part, 2)),
        says: says(row, name),
        // From 0.01 % to 10 %.
        share: part.map(|part| (part / 1e-4).log10() / 3.0),
        failed: failure(row),
    }
}

fn honesty(row: &Row, name: &str) -> Tile {
    let ratio = row.rms_ohm.zip(row.u_ohm).filter(|(_, u)| *u > 0.0).map(|(error, u)| error / u);
    Tile {
        text: ratio.map_or(String::new(), |ratio| digits(ratio, 2)),
        says: says(row, name),
        // From a quarter to four times.
        share: ratio.map(|ratio| 0.5 + ratio.log2() / 4.0),
        failed: failure(row),
    }
}

fn says(row: &Row, name: &str) -> String {
    let said = |what: &str, value: Option<f64>, write: Writer| {
        value.map_or(String::new(), |value| format!(", {what} {}", write(value)))
    };
    let parts = [
        said("error", row.rms_ohm, ohms),
        said("bias", row.bias_ohm, ohms),
        said("stated", row.u_ohm, ohms),
        said("within 2u", row.coverage, percent),
        said("without a number", Some(row.no_number).filter(|share| *share > 0.0), percent),
        said("told as moving", Some(row.moving).filter(|share| *share > 0.0), percent),
        failure(row).map_or(String::new(), |why| format!("; {why}")),
    ];
    format!("{name}{}", parts.concat())
}

#[cfg(test)]
mod tests {
    use super::super::{Drawing, fixture};
    use super::*;

    #[test]
    fn what_fails_is_named_by_its_cause() {
        let row = fixture::row(crate::reading::Method::Cerm, 1000.0);
        assert_eq!(failure(&row), None);
        let silent = Row { no_number: 0.8, reason: Some("leakage".to_owned()), ..row.clone() };
        assert_eq!(failure(&silent).unwrap(), "no number: leakage");
        let at_rest = Row { no_number: 0.2, moving: 0.4, ..row.clone() };
        assert_eq!(failure(&at_rest).unwrap(), "says that the sensor moves");
        assert!(says(&at_rest, "").contains("told as moving 40 %"), "{}", says(&at_rest, ""));
        assert_eq!(failure(&Row { vary: Some(Vary::Speed), ..at_rest }), None, "it does move");
        let biased = Row { coverage: Some(0.2), bias_ohm: Some(-9.0), sd_ohm: Some(2.0), ..row.clone() };
        assert!(failure(&biased).unwrap().ends_with("a bias that it does not know"));
        let coarse = Row { rms_ohm: Some(200.0), ..row };
        assert_eq!(failure(&coarse).unwrap(), "the error is above 10 %");
    }

    #[test]
    fn each_thing_varied_has_a_map_and_no_other() {
        let figures = figures(&fixture::rows(), "pi4");
        let Drawing::Heat(sizes) = &figures[1].drawing else { panic!("a plot") };
        assert_eq!(sizes.grids.len(), 2 * 4, "sizes of capacitors are rows of one grid");
        let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
        assert_eq!(names, ["map-jitter", "map-capacitor", "map-leakage"]);
    }
}
