//! Compact error reduction method: eq. (16)-(19).
//!
//! The upper line of (19) for a discharge that was switched to Rc2; the lower line is
//! [`tcdic::ratio`](super::tcdic::ratio). T_xA of (16) and (18) is the time that the discharge really ran through
//! R_x: from the start to the *switch*, an instant that our own call sets, so d is not subtracted from it. T_c2,x
//! runs from the switch to the crossing of B.

use super::{Number, Times};

/// The inferred crossings T_i,xA (16) and T_i,xB (18), d subtracted.
pub fn inferred<T: Number>(times: &Times<T>) -> [T; 2] {
    let Times { c2, x, at, on, d, .. } = *times;
    let (t_c2a, t_c2b) = (c2[0] - d, c2[1] - d);
    let t_c2x = x[1] - d - on;
    let scale = at / (t_c2b - t_c2x);
    [scale * t_c2a, scale * t_c2b]
}

/// The ratio by the upper line of eq. (19).
pub fn ratio<T: Number>(times: &Times<T>) -> T {
    let Times { c1, c2, d, .. } = *times;
    let [xa, xb] = inferred(times);
    let sum_c1 = (c1[0] - d) + (c1[1] - d);
    let sum_c2 = (c2[0] - d) + (c2[1] - d);
    (xa + xb - sum_c1) / (sum_c2 - sum_c1)
}

/// By how much the measured crossing of A misses the one that [`inferred`] predicts, for a switch before that crossing: a
/// check of the switched discharge that (16)-(19) leave unused. Zero but for noise.
///
/// The part 1 - T_xA/T_i,xA of the way to A's threshold remains at the switch, and Rc2 goes it in that part of T_c2A.
pub fn residual_a<T: Number>(times: &Times<T>) -> T {
    let Times { c2, x, at, on, d, .. } = *times;
    let t_c2a = c2[0] - d;
    let [t_ixa, _] = inferred(times);
    (x[0] - d - on) - (t_c2a - at / t_ixa * t_c2a)
}

/// The same for a switch after A's crossing, which then ran through R_x alone.
pub fn residual_a_before_switch<T: Number>(times: &Times<T>) -> T {
    times.x[0] - times.d - inferred(times)[0]
}
