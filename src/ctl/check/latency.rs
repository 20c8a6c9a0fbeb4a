//! How late things come on this machine: wake-ups, and the stamps of crossings, as histograms.

use super::full_plan;
use crate::config::Config;
use crate::ctl::limits::{DISCHARGES, SLEEP, WAKE_UPS};
use crate::instrument::discharge;
use crate::pins::{Pins, PinsError};
use crate::record::Through;
use std::thread;
use std::time::Instant;

/// Upper ends of the columns; the last one has none.
const UPTO_US: [f64; 9] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];
const COLUMNS: usize = UPTO_US.len() + 1;
/// The longest bar, in characters.
const WIDTH: usize = 40;

/// Latencies, us, as a line for each column from the first to the last that is not empty.
pub fn histogram(late_us: &[f64]) -> String {
    let mut counts = [0; COLUMNS];
    for late_us in late_us {
        counts[column(*late_us)] += 1;
    }
    let used = || (0..COLUMNS).filter(|column| counts[*column] > 0);
    let (Some(first), Some(last)) = (used().next(), used().next_back()) else {
        return "  none was seen\n".to_owned();
    };
    let most = used().map(|column| counts[column]).max().unwrap_or(1);
    let line = |column: usize| {
        let upto = UPTO_US.get(column);
        let name = upto.map_or("     and later ".to_owned(), |upto| format!("  below {upto:>4} us "));
        let bar = "#".repeat((counts[column] * WIDTH).div_ceil(most));
        format!("{name}{:>5} {bar}\n", counts[column])
    };
    (first..=last).map(line).collect()
}

fn column(late_us: f64) -> usize {
    UPTO_US.iter().position(|upto| late_us < *upto).unwrap_or(UPTO_US.len())
}

/// How late the calling thread wakes up, us.
pub fn wake_ups() -> Vec<f64> {
    let late_us = |_| {
        let due = Instant::now() + SLEEP;
        thread::sleep(SLEEP);
        due.elapsed().as_secs_f64() * 1e6
    };
    (0..WAKE_UPS).map(late_us).collect()
}

/// How much later than the earliest one the last crossings of equal discharges (through Rc1) are stamped, us: jitter, not
/// the constant part, which calibration finds.
///
/// # Errors
/// If the pins cannot be used.
pub fn stamps<P: Pins + ?Sized>(pins: &mut P, config: &Config) -> Result<Vec<f64>, PinsError> {
    let plan = full_plan(config, Through::C1, config.deadline());
    let mut times_us = Vec::with_capacity(DISCHARGES);
    for _ in 0..DISCHARGES {
        if let Ok(record) = discharge::run(pins, plan)?.result {
            times_us.extend(record.crossing(plan.last).map(|ns| ns * 1e-3));
        }
    }
    let earliest = times_us.iter().copied().fold(f64::INFINITY, f64::min);
    Ok(times_us.iter().map(|time| time - earliest).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pins::sim::{Scene, SimPins};

    #[test]
    fn columns_are_shown_from_the_first_to_the_last_in_use() {
        let text = histogram(&[1.5, 3.0, 3.0, 4.9, 30.0, 1e6]);
        assert_eq!(text.lines().count(), 9, "{text}");
        assert!(text.lines().nth(1).unwrap().ends_with(&"#".repeat(WIDTH)), "{text}");
        assert!(text.contains("below   10 us     0 \n"), "{text}");
        assert_eq!(histogram(&[]), "  none was seen\n");
    }

    #[test]
    fn stamps_show_the_jitter_of_a_board_and_none_without() {
        let config = crate::config_file::config(|c| c.channel("thumb")).parse();
        let of = |name| {
            stamps(&mut SimPins::new(&Scene::builtin(name).unwrap(), Some(crate::seed::seed(1))), &config)
                .unwrap()
        };
        let at_once = |name| of(name).into_iter().filter(|late_us| column(*late_us) == 0).count();
        assert_eq!(at_once("ideal"), DISCHARGES);
        assert!(at_once("pi4") < DISCHARGES / 2);
    }
}
