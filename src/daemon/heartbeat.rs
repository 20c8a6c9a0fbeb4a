//! When to tell the service manager that all is well: never while the measuring thread is stuck.

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
    /// What the measuring thread had counted at the last one.
    beat: Option<u64>,
}

impl Heartbeat {
    /// Half as long as the service manager waits for its watchdog, as sd_watchdog_enabled(3) recommends; `None`: it
    /// does not wait.
    pub fn new(watchdog: Option<Duration>) -> Heartbeat {
        let every = watchdog.map_or(STATUS_EVERY, |timeout| timeout / 2);
        let every = Nanos(i64::try_from(every.as_nanos()).unwrap_or(i64::MAX));
        Heartbeat { every, due: Nanos::ZERO, beat: None }
    }

    /// Whether to give a sign now, `beat` being what the measuring thread has counted: not before it is due, and not
    /// if the thread has not moved since the last one.
    pub fn is_due(&mut self, now: Nanos, beat: u64) -> bool {
        let is_due = now >= self.due && self.beat != Some(beat);
        if is_due {
            self.beat = Some(beat);
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
        let signs: Vec<i64> = (100..120).filter(|s| heartbeat.is_due(Nanos(s * S), *s as u64)).collect();
        assert_eq!(signs, [100, 105, 110, 115]);
    }

    #[test]
    fn a_stuck_thread_gives_no_sign_and_costs_no_spinning() {
        let mut heartbeat = Heartbeat::new(Some(Duration::from_secs(10)));
        assert!(heartbeat.is_due(Nanos(100 * S), 7));
        for s in 100..200 {
            assert!(!heartbeat.is_due(Nanos(s * S), 7), "{s} s");
            assert!(heartbeat.patience(Nanos(s * S)) >= Duration::from_secs(1));
        }
        assert!(heartbeat.is_due(Nanos(200 * S), 8), "it moves again");
    }

    #[test]
    fn sleeps_end_when_a_sign_is_due() {
        let mut heartbeat = Heartbeat::new(Some(Duration::from_millis(200)));
        assert!(heartbeat.is_due(Nanos(S), 0));
        assert_eq!(heartbeat.patience(Nanos(S + 40_000_000)), Duration::from_millis(60));
    }
}
