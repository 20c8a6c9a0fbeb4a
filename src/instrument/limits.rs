//! Constants of judgement: what is still a usual call, a usual board, a reading worth its discharge.

/// A node that falls in less than this part of its predicted time has nothing but wires at it. Wires have some 20 pF, and the
/// smallest capacitors in use 10 nF; printed values are within 20 %.
pub const MISSING: f64 = 0.05;
