//! Two-point calibration method: one node, eq. (3). The offset d cancels in the differences.

use super::{Number, Times};

/// The ratio by eq. (3), from the crossings of node `node` (0 for A, 1 for B) alone.
pub fn ratio<T: Number>(times: &Times<T>, node: usize) -> T {
    let Times { c1, c2, x, .. } = times;
    (x[node] - c1[node]) / (c2[node] - c1[node])
}
