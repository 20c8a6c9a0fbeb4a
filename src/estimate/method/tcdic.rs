//! Two-capacitor direct interface circuit: both nodes, eq. (11). The offset d cancels in the differences.

use super::{Number, Times};

/// The ratio by eq. (11).
pub fn ratio<T: Number>(times: &Times<T>) -> T {
    let Times { c1, c2, x, .. } = times;
    let sum_c1 = c1[0] + c1[1];
    (x[0] + x[1] - sum_c1) / (c2[0] + c2[1] - sum_c1)
}
