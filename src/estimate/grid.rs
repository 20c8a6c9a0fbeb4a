//! The period of the clock that stamps crossings, by the stamps: one that is coarse makes all of them multiples of its period, whether
//! anybody has said so or not.

use crate::record::{RESOLUTIONS, Record};

/// Stamps that are remembered: so many that differ tell a period of 4 ns from chance.
const REMEMBERED: usize = 16;
/// Stamps of a fine clock are all multiples of a period by chance once in about period^(n - 1) for n of them: once in so many
/// is not to be expected of any board.
const NOT_BY_CHANCE: f64 = 1e9;
/// Below this a time has a tenth of a nanosecond on a tape, and is halved by the middle of a call; longer ones have fewer digits, and are
/// left out, ns.
const TENTHS_BELOW_NS: f64 = 1e9;

/// The greatest period that all crossings so far are multiples of.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// The period that was told, and the one in force, ns: the longer one.
    said_ns: f64,
    in_force_ns: f64,
    /// In tenths of a nanosecond; 0 before the first.
    tenths: u64,
    /// The first ones that differ: the same one again tells nothing.
    stamps: [u64; REMEMBERED],
    count: usize,
}

impl Grid {
    /// Of a clock of which this period is told, ns.
    pub fn new(said_ns: f64) -> Grid {
        Grid { said_ns, in_force_ns: said_ns, tenths: 0, stamps: [0; REMEMBERED], count: 0 }
    }

    /// Takes a discharge; the period of the clock where it has turned out to be another one.
    pub fn take(&mut self, record: &Record) -> Option<f64> {
        self.add(record);
        let found_ns = self.period_ns().unwrap_or(self.said_ns).max(self.said_ns);
        let before_ns = std::mem::replace(&mut self.in_force_ns, found_ns);
        (found_ns != before_ns).then_some(found_ns)
    }

    fn add(&mut self, record: &Record) {
        for ns in record.crossings().into_iter().flatten().filter(|ns| *ns < TENTHS_BELOW_NS) {
            let stamp = (10.0 * ns).round() as u64;
            self.tenths = greatest_common_divisor(self.tenths, stamp);
            if self.count < REMEMBERED && !self.stamps[..self.count].contains(&stamp) {
                self.stamps[self.count] = stamp;
                self.count += 1;
            }
        }
    }

    /// The period, ns, once that is no chance; never longer than a clock may have.
    fn period_ns(&self) -> Option<f64> {
        let period_ns = self.tenths as f64 / 10.0;
        let others = self.count.saturating_sub(1) as i32;
        let is_certain = period_ns > 1.0 && period_ns.powi(others) > NOT_BY_CHANCE;
        (is_certain && period_ns <= RESOLUTIONS.end().as_ns()).then_some(period_ns)
    }
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Through;
    use crate::units::Nanos;

    fn record(a_ns: Option<f64>) -> Record {
        Record {
            through: Through::C1,
            start: Nanos::ZERO,
            second_ns: None,
            switch: None,
            a_ns,
            b_ns: None,
            u_switch_ns: None,
            waited_ns: None,
            later_ns: None,
        }
    }

    fn of(stamps: &[f64]) -> Option<f64> {
        let mut grid = Grid::new(1.0);
        stamps.iter().for_each(|a_ns| grid.add(&record(Some(*a_ns))));
        grid.period_ns()
    }

    #[test]
    fn it_is_told_when_it_changes_and_never_finer_than_was_said() {
        let mut grid = Grid::new(20.0);
        let stamps = [1_440_000.0, 2_595_000.0, 7_755_000.0, 650_000.0, 1_440_000.0, 650_001.0];
        let told = stamps.map(|a_ns| grid.take(&record(Some(a_ns))));
        assert_eq!(told, [None, None, None, Some(5000.0), None, Some(20.0)]);
    }

    #[test]
    fn a_period_shows_by_stamps_that_differ_and_each_can_only_make_it_finer() {
        let coarse = [1_440_000.0, 2_595_000.0, 7_755_000.0, 650_000.0];
        assert_eq!(of(&coarse), Some(5000.0));
        assert_eq!(of(&coarse[..2]), None, "too few");
        assert_eq!(of(&[1_440_000.0; 20]), None, "one and the same");
        assert_eq!(of(&[&coarse[..], &[652_500.0]].concat()), Some(2500.0));
        assert_eq!(of(&[&coarse[..], &[650_000.5]].concat()), None);
        // Of a long time there are not enough digits.
        assert_eq!(of(&[&coarse[..], &[1_234_567_891.0]].concat()), Some(5000.0));
        let even: Vec<f64> = (1..40).map(|index| 1e6 + 2.0 * f64::from(index)).collect();
        assert_eq!(of(&even), None, "nobody can tell");
    }
}
