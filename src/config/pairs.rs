//! Pairs of force and resistance as people write them: `1.20,11122`, `1.2 N, 11.122 kohm`, `120 g` alone; and of any other value
//! and resistance: `25,10000`, `25, 10 kohm`.

use super::limits::{LIKE_GRAMS, UNDER_WEIGHTS_OHM, WEIGHTS_N};
use crate::estimate::fit::Weighing;
use crate::files;
use crate::sensor::Table;
use crate::sensor::table::Pairs;
use crate::units::{GRAVITY, Newton, Ohm};
use csv::{ReaderBuilder, StringRecord, Trim};
use std::path::Path;

const EXAMPLE: &str = "write \"force_n,r_ohm\", such as \"1.20,11122\"";

/// The table that the pairs of a file make: see [`of_csv`].
///
/// # Errors
/// What is wrong with the file, with the line and the remedy.
pub fn load_table(path: &Path) -> Result<Table, String> {
    let pairs = of_csv(&read(path, "the force table")?, &path.display().to_string())?;
    let pairs: Vec<_> = pairs.iter().map(|pair| (pair.r_ohm, pair.f_n)).collect();
    Table::try_from(pairs).map_err(|error| error.to_string())
}

/// The table that the lines `value,r_ohm` of a file make.
///
/// # Errors
/// As [`load_table`].
pub fn load_values(path: &Path) -> Result<Pairs, String> {
    let origin = path.display().to_string();
    let pairs = lines(&read(path, "the table")?, &origin, |line| {
        let wrong = || {
            format!("{line:?} is not a value and a resistance: write \"value,r_ohm\", such as \"25,10000\"")
        };
        let (value, right) = line.split_once(',').ok_or_else(wrong)?;
        let value: Option<f64> = value.trim().parse().ok();
        value.zip(ohm(right.trim())).map(|(value, r_ohm)| (r_ohm, value)).ok_or_else(wrong)
    })?;
    Pairs::try_from(pairs).map_err(|error| format!("{origin}: {error}"))
}

fn read(path: &Path, what: &str) -> Result<String, String> {
    let unread = |error| format!("cannot read {what} {}: {error}; {}", path.display(), files::hint(&error));
    files::read_text(path, files::TABLE_BYTES).map_err(unread)
}

/// The pairs of a CSV file. Empty lines, lines that begin with `#` and a line of names before the first pair are passed
/// over.
///
/// # Errors
/// Which line is wrong, what of it, and how it is written.
pub fn of_csv(text: &str, origin: &str) -> Result<Vec<Weighing>, String> {
    lines(text, origin, |line| {
        parse(line).and_then(|(f_n, r_ohm)| match r_ohm {
            Some(r_ohm) => Ok(Weighing { f_n, r_ohm }),
            None => Err(format!("{line:?} has no resistance: {EXAMPLE}")),
        })
    })
}

/// Whether force and resistance of pairs are in the order and the unit that are read. R = alpha / F fits as well with its sides changed
/// or in gram, and only numbers without units can be taken for each other; those of a force sensor are ohms that are many more than
/// newtons.
///
/// # Errors
/// Why they look swapped, or like grams, and what to do.
pub fn in_order(text: &str) -> Result<(), String> {
    let written = || text.lines().filter(|line| !is_blank(line));
    if let Some(names) = written().next().filter(|line| is_names(line)) {
        let names = cells(&names.to_ascii_lowercase());
        let is_of_ohms = |name: &str| ["r_", "ohm", "resist"].iter().any(|part| name.contains(part));
        if names.len() == 2 && is_of_ohms(&names[0]) && !is_of_ohms(&names[1]) {
            return Err(format!(
                "the columns are swapped: {:?} comes first, and has to be the force; {EXAMPLE}",
                &names[0]
            ));
        }
    }
    let of_pair = |row: StringRecord| match row.len() {
        2 => Some((row[0].parse().ok()?, row[1].parse().ok()?)),
        _ => None,
    };
    let bare: Vec<(f64, f64)> = written().map(cells).filter_map(of_pair).collect();
    let greatest_n = bare.iter().map(|(f_n, _)| *f_n).fold(0.0, f64::max);
    let alpha_n_ohm = bare.iter().map(|(f_n, r_ohm)| (f_n * r_ohm).ln()).sum::<f64>() / bare.len() as f64;
    let is_like_grams = greatest_n >= LIKE_GRAMS.0 && alpha_n_ohm.exp() >= LIKE_GRAMS.1;
    let over: f64 = bare.iter().map(|(f_n, r_ohm)| (f_n / r_ohm).ln()).sum();
    match bare.first() {
        Some((f_n, r_ohm)) if over > 0.0 => Err(format!(
            "the columns look swapped: forces of {f_n} N with resistances of {r_ohm} ohm. Force comes first; if they are right, write \
             their units: \"{f_n} N, {r_ohm} ohm\""
        )),
        _ if is_like_grams => Err(format!(
            "{greatest_n} without a unit is newton, what {:.0} kg weigh, and looks like gram. Write the unit: \"{greatest_n} g\", or \
             \"{greatest_n} N\" if it is",
            greatest_n / GRAVITY
        )),
        _ => Ok(()),
    }
}

/// What the lines of a file say, but for comments and names.
fn lines<T>(text: &str, origin: &str, parse: impl Fn(&str) -> Result<T, String>) -> Result<Vec<T>, String> {
    let mut pairs = Vec::new();
    // Line by line: the reader of a whole file does not count those that it passes over.
    for (index, line) in text.lines().enumerate() {
        if is_blank(line) || pairs.is_empty() && is_names(line) {
            continue;
        }
        pairs.push(parse(line).map_err(|reason| format!("{origin}, line {}: {reason}", index + 1))?);
    }
    Ok(pairs)
}

/// Whether a line is empty or a comment.
fn is_blank(line: &str) -> bool {
    line.trim().is_empty() || line.trim().starts_with('#')
}

/// Whether it has the names of columns.
fn is_names(line: &str) -> bool {
    line.trim_start_matches(|c| " \t\"".contains(c)).starts_with(char::is_alphabetic)
}

/// What stands between its commas.
fn cells(line: &str) -> StringRecord {
    let reader = ReaderBuilder::new().has_headers(false).trim(Trim::All).from_reader(line.as_bytes());
    reader.into_records().next().and_then(Result::ok).unwrap_or_default()
}

/// One line: newton, and ohm if it is there.
///
/// # Errors
/// What is wrong with it, and how it is written.
pub fn parse(line: &str) -> Result<(f64, Option<f64>), String> {
    let cells = cells(line);
    let mut cells = cells.iter();
    let left = cells.next().unwrap_or_default();
    let f_n = force(left)
        .ok_or_else(|| format!("{left:?} is no weight: write \"1.2 N\", \"120 g\" or \"0.12 kg\""))?;
    match (cells.next(), cells.next()) {
        (None, _) => Ok((f_n, None)),
        (Some(right), None) => match ohm(right) {
            Some(r_ohm) => Ok((f_n, Some(r_ohm))),
            None => Err(format!("{right:?} is no resistance: {EXAMPLE}")),
        },
        (Some(_), Some(_)) => Err(format!("{line:?} has more than two numbers: {EXAMPLE}")),
    }
}

/// Newton; a number alone is in newton.
fn force(text: &str) -> Option<f64> {
    let f_n = text.parse().ok().or_else(|| text.parse::<Newton>().ok().map(|newton| newton.0));
    f_n.filter(|f_n| WEIGHTS_N.contains(f_n))
}

/// A number alone is in ohm.
fn ohm(text: &str) -> Option<f64> {
    let r_ohm = text.parse().ok().or_else(|| text.parse::<Ohm>().ok().map(|ohm| ohm.0));
    r_ohm.filter(|r_ohm| UNDER_WEIGHTS_OHM.contains(r_ohm))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_forces() {
        let force = |text: &str| match parse(text).unwrap() {
            (f_n, None) => f_n,
            other => panic!("{other:?}"),
        };
        assert_eq!((force("1.2 N"), force("1.2"), force("1200 mN")), (1.2, 1.2, 1.2));
        assert!((force("500 g") - 4.903325).abs() < 1e-12 && force("0.5kg") == force("500g"));
        let pair = (1.2, Some(11_122.0));
        assert_eq!((parse("1.20,11122"), parse("1.2 N, 11.122 kohm")), (Ok(pair), Ok(pair)));
        for wrong in
            ["", "heavy", "-1", "0", "NaN", "inf", "1 ohm", "1,", "1,0", "1,-5", "1,2,3", "1,NaN", "g"]
        {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_table_of_values_has_a_number_and_a_resistance_on_each_line() {
        let folder = tempfile::tempdir().unwrap();
        let load = |text: &str| {
            let path = folder.path().join("t.csv");
            std::fs::write(&path, text).unwrap();
            load_values(&path).map(Vec::from)
        };
        let pairs = load("degc,r_ohm\n# warm\n25, 10 kohm\n\n-10,55.3 kohm\n").unwrap();
        assert_eq!(pairs, [(10_000.0, 25.0), (55_300.0, -10.0)]);
        for (text, wanted) in [
            ("25,10000\n30\n", "line 2: \"30\" is not a value and a resistance"),
            ("25,10000\n30,5 degC\n", "line 2: "),
            ("25,10000\n30,8000,1\n", "line 2: "),
            ("25,10000\ninf,8000\n", "no number"),
            ("25,10000\n", "1 pair(s)"),
            ("25,10000\n30,11000\n35,9000\n", "not monotone: at 11000 ohm"),
        ] {
            let error = load(text).unwrap_err();
            assert!(error.contains("t.csv") && error.contains(wanted), "{text:?}: {error}");
        }
    }

    #[test]
    fn swapped_columns_are_told_by_names_and_magnitudes() {
        for good in [
            "",
            "1.20,11122\n6.06,2200\n",
            "force_n,r_ohm\n1.20,11122\n",
            "1.2 N\n6.06, 2200\n",
            // Of a mat under somebody's feet, on purpose.
            "700 N, 20 ohm\n",
            "# 11122,1.2\n1.2,11122",
            // An FSR 402 as hard as it may be pressed, and harder.
            "20,667\n100,133\n130,103\n",
        ] {
            assert_eq!(in_order(good), Ok(()), "{good}");
        }
        for (swapped, says) in [
            ("11122,1.20\n2200,6.06\n", "write their units: \"11122 N, 1.2 ohm\""),
            ("# mine\n\n11122, 1.20\n", "look swapped"),
            ("r_ohm,force_n\n1.2,11122\n", "\"r_ohm\" comes first"),
            ("Resistance (ohm), Weight (N)\n1.2,11122\n", "comes first"),
            ("\"r_ohm\",\"force_n\"\n1.2,11122\n", "comes first"),
            ("\"11122\",\"1.20\"\n", "look swapped"),
        ] {
            assert!(in_order(swapped).unwrap_err().contains(says), "{swapped}: {:?}", in_order(swapped));
        }
    }

    #[test]
    fn grams_without_a_unit_are_told() {
        for grams in [
            "50,27200\n500,2720\n",
            "weight,r_ohm\n1000,1360\n",
            "100, 13.6 kohm\n200, 6.8 kohm\n20,60000\n100,13000\n",
        ] {
            let error = in_order(grams).unwrap_err();
            assert!(error.contains("looks like gram. Write the unit: \""), "{grams}: {error}");
        }
        for good in ["50 g,27200\n500 g,2720\n", "0.5,27200\n5,2720\n", "500 N,27200\n", "50,27200\n"] {
            assert_eq!(in_order(good), Ok(()), "{good}");
        }
    }

    #[test]
    fn a_wrong_line_is_named() {
        let good = of_csv("force_n,r_ohm\n# light\n1.20,11122\n\n6.06,2200\n", "w.csv").unwrap();
        assert_eq!(good.len(), 2);
        for (text, line) in [("1,2\nforce_n,r_ohm\n", 2), ("# a\n\n1.2\n", 3), ("1,2\n1,x\n", 2)] {
            let error = of_csv(text, "w.csv").unwrap_err().to_string();
            assert!(error.starts_with(&format!("w.csv, line {line}: ")), "{error}");
        }
    }
}
