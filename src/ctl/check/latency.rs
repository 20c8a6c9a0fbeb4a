//! How late things come on this machine: wake-ups, and the stamps of crossings, as histograms.

use crate::circuit::Node;
use crate::config::Config;
use crate::ctl::limits::{DISCHARGES, SLEEP, WAKE_UPS};
use crate::instrument::discharge::{self, Plan};
use crate::pins::{Pins, PinsError};
use crate::record::Through;
use std::fmt;
use std::thread;
use std::time::Instant;

/// Upper ends of the columns; the last one has none.
const UPTO_US: [f64; 9] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];
const COLUMNS: usize = UPTO_US.len() + 1;
/// The longest bar, in characters.
const WIDTH: usize = 40;

/// Latencies, in columns from 1 us to 500 us and beyond.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Histogram {
    counts: [usize; COLUMNS],
}

impl Histogram {
    /// Counts one latency.
    pub fn add(&mut self, late_us: f64) {
        let column = UPTO_US.iter().position(|upto| late_us < *upto).unwrap_or(COLUMNS - 1);
        self.counts[column] += 1;
    }
}

impl fmt::Display for Histogram {
    /// A line for each column from the first to the last that is not empty.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let most = self.counts.iter().max().copied().unwrap_or(0);
        if most == 0 {
            return writeln!(f, "  none was seen");
        }
        let first = self.counts.iter().position(|count| *count > 0).unwrap_or(0);
        let last = self.counts.iter().rposition(|count| *count > 0).unwrap_or(0);
        for column in first..=last {
            let count = self.counts[column];
            match UPTO_US.get(column) {
                Some(upto) => write!(f, "  below {upto:>4} us ")?,
                None => write!(f, "     and later ")?,
            }
            let bar = "#".repeat((count * WIDTH).div_ceil(most));
            writeln!(f, "{count:>5} {bar}")?;
        }
        Ok(())
    }
}

/// How late the calling thread wakes up.
pub fn wake_ups() -> Histogram {
    let mut histogram = Histogram::default();
    for _ in 0..WAKE_UPS {
        let due = Instant::now() + SLEEP;
        thread::sleep(SLEEP);
        histogram.add(due.elapsed().as_secs_f64() * 1e6);
    }
    histogram
}

/// How much later than the earliest one the last crossings of equal discharges (through Rc1) are stamped: jitter, not
/// the constant part, which calibration finds.
///
/// # Errors
/// If the pins cannot be used.
pub fn stamps<P: Pins + ?Sized>(pins: &mut P, config: &Config) -> Result<Histogram, PinsError> {
    let plan = Plan {
        settle: config.settle_time(),
        ..Plan::full(Through::C1, config.last_node(), config.charge_time(), config.deadline())
    };
    let mut times_us = Vec::with_capacity(DISCHARGES);
    for _ in 0..DISCHARGES {
        if let Ok(record) = discharge::run(pins, plan)?.result {
            let last = if plan.last == Node::A { record.a_ns } else { record.b_ns };
            times_us.extend(last.map(|ns| ns * 1e-3));
        }
    }
    let earliest = times_us.iter().copied().fold(f64::INFINITY, f64::min);
    let mut histogram = Histogram::default();
    times_us.iter().for_each(|time| histogram.add(time - earliest));
    Ok(histogram)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pins::sim::{Scene, SimPins};

    #[test]
    fn columns_are_shown_from_the_first_to_the_last_in_use() {
        let mut histogram = Histogram::default();
        [1.5, 3.0, 3.0, 4.9, 30.0, 1e6].into_iter().for_each(|late| histogram.add(late));
        let text = histogram.to_string();
        assert_eq!(text.lines().count(), 9, "{text}");
        assert!(text.lines().nth(1).unwrap().ends_with(&"#".repeat(WIDTH)), "{text}");
        assert!(text.contains("below   10 us     0 \n"), "{text}");
        assert_eq!(Histogram::default().to_string(), "  none was seen\n");
    }

    #[test]
    fn stamps_show_the_jitter_of_a_board_and_none_without() {
        let config = "[circuit]\nkind = \"two-capacitor\"\nc-a = \"2.2 uF\"\nc-b = \"680 nF\"\nr-c1 = \"2.32 kohm\"\n\
                      r-c2 = \"12.7 kohm\"\n[[channel]]\nid = \"thumb\"\n";
        let config = Config::parse(config, "test").unwrap();
        let of = |name| {
            stamps(&mut SimPins::new(&Scene::builtin(name).unwrap(), Some(crate::seed::seed(1))), &config)
                .unwrap()
        };
        assert_eq!(of("ideal").counts[0], DISCHARGES);
        assert!(of("pi4").counts[0] < DISCHARGES / 2);
    }
}
