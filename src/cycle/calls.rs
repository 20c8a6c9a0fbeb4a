//! How long the calls take that switch lines.
//!
//! For: telling an interrupted call from a usual one. Must not know: what is switched.

use crate::units::Nanos;

/// Follows how long a call takes that switches one line, to tell an interrupted one from a usual one, and to place the
/// moment at which the line moves.
#[derive(Debug, Clone, Copy, Default)]
pub struct CallGate {
    /// The median, ns.
    single_ns: Option<f64>,
}

impl CallGate {
    /// How long a call for one line usually takes.
    pub fn single(&self) -> Option<Nanos> {
        self.single_ns.map(|single| Nanos(single as i64))
    }

    /// A call longer than this was interrupted: the line may have moved anywhere in it. A call for two lines takes less
    /// than two calls.
    pub fn widest(&self) -> Nanos {
        self.single_ns.map_or(Nanos::MAX, |single| Nanos((4.0 * single + 2000.0) as i64))
    }

    /// Steps towards each value, not by it: a long call moves the median no more than a short one. The steps are small
    /// beside the calls, and so are they beside the jitter of crossings.
    pub fn add(&mut self, call: Nanos) {
        let call = call.as_ns();
        self.single_ns = Some(match self.single_ns {
            None => call,
            Some(single) if (call - single).abs() <= 0.01 * single => single,
            Some(single) if call > single => (single * 1.01).max(1.0),
            Some(single) => single / 1.01,
        });
    }
}
