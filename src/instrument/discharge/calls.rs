//! The calls that switch one line each, and how much longer than usual those of a discharge took.

use crate::units::Nanos;

/// What a call for one line does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Call {
    /// Sinks the first resistor.
    Start,
    /// Releases it.
    Release,
    /// Sinks the next one.
    Sink,
}

/// How long each call took, by [`Call`]; `None` for one that was not made, or not for one line.
pub type Calls = [Option<Nanos>; 3];

/// How long a call usually takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UsualCall {
    /// The median.
    pub length: Nanos,
    /// What is longer is not usual.
    pub longest: Nanos,
}

/// How much later than usual a line may have been switched, 1 sigma, ns: before what made its call longer, or after it. `None` if
/// no call was longer.
pub fn later_ns(calls: &Calls, usual: &[Option<UsualCall>; 3]) -> Option<f64> {
    let later = |(call, usual): (&Option<Nanos>, &Option<UsualCall>)| {
        let (call, usual) = ((*call)?, (*usual)?);
        (call > usual.longest).then(|| (call - usual.length).as_ns() / 2f64.sqrt())
    };
    calls.iter().zip(usual).filter_map(later).reduce(f64::hypot)
}
