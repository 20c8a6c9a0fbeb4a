//! Leakage at node A, from a defect to nothing: from where on it is told, and what it does to a reading where it is not.

use crate::common::{Bench, Errors, read, settle};
use cermd::reading::{Fault, Method, Reading, Status};
use std::fmt::Write;

const SEED: u64 = 1;
/// 100 s of readings and more, so that every held discharge that is remembered has been made with the leak.
const BEFORE: usize = 4000;
const READINGS: usize = 500;
const SENSORS: [f64; 3] = [100.0, 1000.0, 16_200.0];
/// Leaks, ohm; the last one is none.
const LEAKS: [f64; 8] = [150e3, 300e3, 1e6, 3e6, 10e6, 30e6, 100e6, f64::INFINITY];

/// 95 % of so many readings, and three sigma less: there are 48 cells.
const LEAST_COVERAGE: f64 = 0.95 - 3.0 * 0.0097;

struct Seen {
    leak_ohm: Option<f64>,
    refused: usize,
    errors: Errors,
}

fn measure(method: Method, r_ohm: f64, leak_ohm: f64) -> Seen {
    let mut instrument = Bench::new("pi4", method, r_ohm, SEED, "deadline = \"60 ms\"").instrument();
    settle(&mut instrument);
    instrument.pins().alter(|circuit| circuit.sense[0].to_ground = 1.0 / leak_ohm);
    read(&mut instrument, BEFORE, |_| {});
    let (mut errors, mut refused) = (Errors::default(), 0);
    read(&mut instrument, READINGS, |reading: &Reading| {
        refused += usize::from(reading.status == Status::Fault(Fault::Leakage));
        errors.add(reading, r_ohm);
    });
    Seen { leak_ohm: instrument.stats().leak_siemens.map(|siemens| 1.0 / siemens), refused, errors }
}

/// One method's and sensor's cell, and what is wrong with it.
fn examine(method: Method, r_ohm: f64, leak_ohm: f64) -> (String, String) {
    let seen = measure(method, r_ohm, leak_ohm);
    let place = format!("{}, {r_ohm} ohm, leak {leak_ohm}, seed {SEED}", method.as_str());
    let mut wrong = String::new();
    if leak_ohm < 200e3 {
        // One spike or interrupted call in a hundred has a name of its own.
        if seen.refused < READINGS * 99 / 100 || seen.errors.count() > 0 {
            writeln!(wrong, "{place}: {} of {READINGS} refused", seen.refused).unwrap();
        }
        return ("leakage".to_owned(), wrong);
    }
    let found = seen.leak_ohm.map(|found| found / leak_ohm);
    let is_right = match found {
        // A leak that only just shows is known to a quarter.
        Some(ratio) => leak_ohm <= 30e6 && (0.4..1.6).contains(&ratio),
        None => leak_ohm >= 10e6,
    };
    let shorts = seen.errors.not_ok.iter().filter(|status| **status == "short").count();
    if !is_right || seen.refused > 0 || seen.errors.count() + shorts < READINGS * 9 / 10 {
        writeln!(wrong, "{place}: found {found:?} of it, {} refused", seen.refused).unwrap();
    }
    if shorts > READINGS / 2 {
        return ("short".to_owned(), wrong);
    }
    let (mean, u) = (seen.errors.mean(), seen.errors.mean_u());
    if found.is_some() && seen.errors.coverage() < LEAST_COVERAGE {
        writeln!(wrong, "{place}: coverage {}", seen.errors.coverage()).unwrap();
    }
    let mark = if found.is_some() { "" } else { " (not told)" };
    (format!("{mean:+.1}, u {u:.1}{mark}"), wrong)
}

/// A section of the page, and what is not as it should be.
pub fn report() -> (String, String) {
    let (mut table, mut wrong) = (HEAD.to_owned(), String::new());
    for leak_ohm in LEAKS {
        let name = match leak_ohm {
            leak if leak >= 1e9 => "none".to_owned(),
            leak if leak >= 1e6 => format!("{} Mohm", leak / 1e6),
            leak => format!("{} kohm", leak / 1e3),
        };
        write!(table, "| {name} |").unwrap();
        for method in [Method::Tcdic, Method::Tracked] {
            for r_ohm in SENSORS {
                let (cell, failure) = examine(method, r_ohm, leak_ohm);
                write!(table, " {cell} |").unwrap();
                wrong += &failure;
            }
        }
        table.push('\n');
    }
    (table, wrong)
}

const HEAD: &str = "
## Leakage at node A

Discharges through two known resistors cannot tell a leak from other capacitors, unless it is so large that a discharge through 0 \
ohm would take longer than a pin explains. So every 5 s one discharge through Rc1 is held back for 20 ms, in which charge \
leaks away and nothing else happens; it is shorter by what is lost. A leak below 200 kohm makes each reading a `leakage` fault. A \
weaker one is told by the log and by `leak_ohm` in STATS, and readings have what it may do to them in their uncertainty. What \
remains is one that is not told. Mean error and stated 1 sigma of 500 readings, ohm; before them 4000 with the leak:

| leak | tcdic, 100 ohm | 1 kohm | 16.2 kohm | tracked, 100 ohm | 1 kohm | 16.2 kohm |
|---|---|---|---|---|---|---|
";
