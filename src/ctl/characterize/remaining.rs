//! How far a sweep is, and how long it still takes, in words.

use crate::ctl::limits::PROGRESS_COLUMNS;
use std::time::{Duration, Instant};

/// What is done and what is left.
pub struct Remaining {
    began: Instant,
    /// Cells that were there before, and what each of the others costs, whatever the unit.
    before: usize,
    costs: Vec<f64>,
    done: usize,
    done_cost: f64,
}

impl Remaining {
    /// Nothing is done yet.
    pub fn new(before: usize, costs: Vec<f64>) -> Remaining {
        Remaining { began: Instant::now(), before, costs, done: 0, done_cost: 0.0 }
    }

    /// One more is done: that of this place in the list.
    pub fn done(&mut self, index: usize) {
        self.done += 1;
        self.done_cost += self.costs[index];
    }

    /// A bar, counts, and the time that is left.
    pub fn in_words(&self) -> String {
        let share = self.done_cost / self.costs.iter().sum::<f64>();
        // The sums are rounded: what is done may come to more than all.
        let left = self.began.elapsed().mul_f64(((1.0 - share) / share).max(0.0));
        let full = ((share * PROGRESS_COLUMNS as f64) as usize).min(PROGRESS_COLUMNS);
        let bar = "=".repeat(full) + &" ".repeat(PROGRESS_COLUMNS - full);
        let (at, all) = (self.before + self.done, self.before + self.costs.len());
        format!("[{bar}] {at} of {all}, {} left", rough(left))
    }
}

fn rough(left: Duration) -> String {
    match left.as_secs() {
        seconds if seconds < 100 => format!("{seconds} s"),
        seconds => format!("{} min", seconds.div_ceil(60)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_goes_by_what_it_costs() {
        let mut remaining = Remaining::new(2, vec![1.0, 3.0]);
        remaining.began -= Duration::from_secs(100);
        remaining.done(1);
        assert_eq!(remaining.in_words(), "[==================      ] 3 of 4, 33 s left");
        remaining.done(0);
        assert_eq!(remaining.in_words(), "[========================] 4 of 4, 0 s left");
        assert_eq!(rough(Duration::from_secs(200)), "4 min");
        // 0.1 + 0.2 + 0.3 is more than 0.3 + 0.2 + 0.1.
        let mut backwards = Remaining::new(0, vec![0.3, 0.2, 0.1]);
        (0..3).rev().for_each(|index| backwards.done(index));
        assert!(backwards.in_words().ends_with("0 s left"), "{}", backwards.in_words());
    }
}
