//! When to tell the service manager that all is well: never while a thread that does the work is stuck.

use super::limits::STATUS_EVERY;
use crate::units::Nanos;
use std::time::Duration;

/// Decides when the next sign of life is due.
#[derive(Debug, Clone, Copy)]
pub struct Heartbeat {
    /// From one sign to the next.
    every: Nanos,
    /// When the next one is due.
    due: Nanos,
    /// What the threads had counted at the last one.
    beats: Option<[u64; 2]>,
}

impl Heartbeat {
    /// Half as long as the service manager waits for its watchdog, as sd_watchdog_enabled(3) recommends; `None`: it
    /// does not wait.
    pub fn new(watchdog: Option<Duration>) -> Heartbeat {
        let every = watchdog.map_or(STATUS_EVERY, |timeout| timeout / 2);
        let every = Nanos(i64::try_from(every.as_nanos()).unwrap_or(i64::MAX));
        Heartbeat { every, due: Nanos::ZERO, beats: None }
    }

    /// Whether to give a sign now, `beats` being what the threads have counted that do the work: not before it is due, and not
    /// if one of them has not moved since the last one.
    pub fn is_due(&mut self, now: Nanos, beats: [u64; 2]) -> bool {
        let have_moved =
            self.beats.is_none_or(|before| beats.iter().zip(before).all(|(beat, before)| *beat != before));
        let is_due = now >= self.due && have_moved;
        if is_due {
            self.beats = Some(beats);
            self.due = now + self.every;
        }
        is_due
    }

    /// How long to sleep at most. Overdue, the thread is looked at again and again, but not without a pause.
    pub fn patience(&self, now: Nanos) -> Duration {
        let rest = if self.due > now { self.due - now } else { Nanos(self.every.0 / 4) };
        Duration::from_nanos(rest.0.unsigned_abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn signs_come_at_half_the_interval_while_the_thread_moves() {
        let mut heartbeat = Heartbeat::new(Some(Duration::from_secs(10)));
        let signs: Vec<i64> = (100..120).filter(|s| heartbeat.is_due(Nanos(s * S), [*s as u64; 2])).collect();
        assert_eq!(signs, [100, 105, 110, 115]);
    }

    #[test]
    fn a_stuck_thread_gives_no_sign_and_costs_no_spinning() {
        let mut heartbeat = Heartbeat::new(Some(Duration::from_secs(10)));
        assert!(heartbeat.is_due(Nanos(100 * S), [7, 7]));
        for s in 100..200 {
            assert!(!heartbeat.is_due(Nanos(s * S), [s as u64, 7]), "{s} s");
            assert!(heartbeat.patience(Nanos(s * S)) >= Duration::from_secs(1));
        }
        assert!(heartbeat.is_due(Nanos(200 * S), [201, 8]), "it moves again");
    }

    #[test]
    fn sleeps_end_when_a_sign_is_due() {
        let mut heartbeat = Heartbeat::new(Some(Duration::from_millis(200)));
        assert!(heartbeat.is_due(Nanos(S), [0, 0]));
        assert_eq!(heartbeat.patience(Nanos(S + 40_000_000)), Duration::from_millis(60));
    }
}
