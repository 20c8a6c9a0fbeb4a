//! Quantization error reduction method: one capacitor, Rc1 and Rc2 in series (Fig. 1(b)).
//!
//! The third discharge runs through the sensor and Rs = Rc1 + Rc2 at once; after the time s the sensor is released.
//! With g the progress (time over resistance) at the threshold, and everything counted from when the sensor was sunk,
//! Rs a little later, at `on`, by the same call:
//!
//! ```text
//! s/(Rx+Ro) + (T3 - on)/(Rs+Ro) = g,   T_c2 = (Rs+Ro) g
//! =>  T_x* = (Rx+Ro) g = s T_c2 / (T_c2 - (T3 - on))
//! ```
//!
//! the time that R_x alone would have taken; two-point calibration follows. If the threshold was reached before the
//! release, s is T3 itself. Here `c2` is the discharge through Rs, and the ratio's R_2 is Rs.

use super::{Number, Times};

/// The ratio when the sensor was released at `at`, before the crossing.
pub fn ratio<T: Number>(times: &Times<T>) -> T {
    from_time_through_x(times, times.at)
}

/// The ratio when the crossing came first.
pub fn ratio_direct<T: Number>(times: &Times<T>) -> T {
    from_time_through_x(times, times.x[0] - times.d)
}

fn from_time_through_x<T: Number>(times: &Times<T>, s: T) -> T {
    let Times { c1, c2, x, on, d, .. } = *times;
    let (t_c1, t_c2, t3) = (c1[0] - d, c2[0] - d, x[0] - d);
    let t_x = s * t_c2 / (t_c2 - (t3 - on));
    (t_x - t_c1) / (t_c2 - t_c1)
}
