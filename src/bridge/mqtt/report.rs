//! When a reading is news: its state changed, its resistance changed beyond what its uncertainty explains, or nothing was
//! told for long.

use crate::stream::wire::{StateLine, StatusName};
use crate::units::Nanos;

/// When to speak.
#[derive(Debug, Clone, Copy)]
pub struct Pacing {
    /// Changes from here on are told, in units of the uncertainty.
    pub change: f64,
    pub every: Nanos,
    pub at_least: Nanos,
}

/// What was told last of one channel.
#[derive(Debug, Default)]
pub struct Reporter(Option<Told>);

#[derive(Debug)]
struct Told {
    at: Nanos,
    kind: Condition,
    r_ohm: Option<f64>,
    r_u_ohm: f64,
    is_moving: bool,
}

/// What makes two readings different things, not different numbers.
type Condition = (StatusName, Option<String>, bool, bool);

impl Reporter {
    /// Whether a reading taken at this instant is to be told; if so, it counts as told.
    pub fn is_news(&mut self, state: &StateLine, at: Nanos, rules: &Pacing) -> bool {
        let told = Told {
            at,
            kind: (state.status, state.fault.clone(), state.settling, state.extrapolated),
            is_moving: state.moving,
            r_ohm: state.r_ohm,
            // The force follows from the resistance; the uncertainty of its characteristic does not move from reading to
            // reading, and would hide what does.
            r_u_ohm: state.r_u_ohm.unwrap_or(0.0),
        };
        let is_news = self.0.as_ref().is_none_or(|before| {
            let elapsed = at - before.at;
            let has_moved = match (told.r_ohm, before.r_ohm) {
                (Some(r), Some(r_before)) => {
                    (r - r_before).abs() > rules.change * told.r_u_ohm.max(before.r_u_ohm)
                }
                _ => false,
            };
            // What it was while it moved is no answer to where it came to rest, however wide its uncertainty was.
            let has_moved = has_moved || (before.is_moving && !told.is_moving);
            told.kind != before.kind || elapsed >= rules.every || (has_moved && elapsed >= rules.at_least)
        });
        if is_news {
            self.0 = Some(told);
        }
        is_news
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bridge::latest::tests::ok;

    const RULES: Pacing = Pacing { change: 3.0, every: Nanos(10_000), at_least: Nanos(200) };

    #[test]
    fn noise_is_no_news_and_a_change_is() {
        let mut reporter = Reporter::default();
        let mut is_news = |r_ohm, at| reporter.is_news(&ok(r_ohm), Nanos(at), &RULES);
        assert!(is_news(100.0, 0));
        // u is 1.2 ohm.
        assert!(!is_news(103.5, 1_000));
        assert!(is_news(103.7, 2_000));
        assert!(!is_news(110.0, 2_199), "too soon");
        assert!(is_news(110.0, 2_200));
        assert!(!is_news(110.0, 12_199));
        assert!(is_news(110.0, 12_200), "silent for too long");
    }

    #[test]
    fn where_it_came_to_rest_is_news() {
        let mut reporter = Reporter::default();
        let moving = StateLine { moving: true, r_u_ohm: Some(500.0), ..ok(2000.0) };
        assert!(reporter.is_news(&moving, Nanos(0), &RULES));
        assert!(!reporter.is_news(&moving, Nanos(300), &RULES));
        assert!(!reporter.is_news(&ok(1000.0), Nanos(100), &RULES), "too soon");
        assert!(reporter.is_news(&ok(1000.0), Nanos(400), &RULES));
        assert!(!reporter.is_news(&ok(1000.0), Nanos(800), &RULES));
    }

    #[test]
    fn a_state_is_told_at_once_and_once() {
        let mut reporter = Reporter::default();
        let fault = |name: &str| StateLine { fault: Some(name.to_owned()), ..StateLine::default() };
        let open = StateLine { status: StatusName::Open, r_min_ohm: Some(1e6), ..StateLine::default() };
        let states =
            [ok(100.0), fault("missed-edge"), fault("missed-edge"), fault("no-charge"), open.clone(), open];
        let told: Vec<_> = states
            .iter()
            .enumerate()
            .map(|(at, state)| reporter.is_news(state, Nanos(at as i64), &RULES))
            .collect();
        assert_eq!(told, [true, true, false, true, true, false]);
    }
}
