//! Constants of judgement: where an estimate stops believing.

/// What is so many sigma from what was expected is not noise, of which it is one value in two million. Crossings of one
/// discharge that disagree by more cannot both be right; a resistance so far below 0 is none; a crossing so far from the
/// running mean is a spike.
pub const BEYOND_NOISE: f64 = 5.0;
/// A resistance below so many sigma cannot be told from a short circuit; bounds are stated with the same factor (95 %, GUM).
pub const COVERAGE: f64 = 2.0;
