//! Quantization error reduction method: one capacitor, Rc1 and Rc2 in series (Fig. 1(b)).
//!
//! The third discharge runs through the sensor and Rs = Rc1 + Rc2 at once; after the time s the sensor is released.
//! With g the progress (time over resistance) at the threshold, and everything counted from when the sensor was sunk,
//! Rs a little later, at `beside`, by the same call:
//!
//! ```text
//! s/(Rx+Ro) + (T3 - beside)/(Rs+Ro) = g,   T_c2 = (Rs+Ro) g
//! =>  T_x* = (Rx+Ro) g = s T_c2 / (T_c2 - (T3 - beside))
//! ```
//!
//! the time that R_x alone would have taken; two-point calibration follows. If the threshold was reached before the
//! release, s is T3 itself. Here `c2` is the discharge through Rs, and the ratio's R_2 is Rs.

use super::{Evidence, Kind, Node, Number, Rules, Switching, Times};
use crate::estimate::limits::COVERAGE;
use crate::reading::Branch;

/// What it decides.
pub(super) const RULES: Rules = Rules {
    circuits: &[Kind::SeriesCalibration],
    switching: Switching::AtFraction,
    sinks_beside: true,
    ratio,
    evidence: |times, branch, _| through_x(times, branch).map(|end| Evidence::over(end.value)),
    certain_ns,
    ..Rules::usual('Q')
};

fn certain_ns(crossing_ns: f64, c2_ns: f64, late_ns2: f64) -> Option<f64> {
    let doubt_ns = COVERAGE * (2.0 * late_ns2).sqrt();
    let is_alike = (crossing_ns - c2_ns).abs() <= 2.0 * doubt_ns;
    is_alike.then(|| crossing_ns.min(c2_ns) - doubt_ns)
}

/// The time s through the sensor: until the crossing, or until the sensor was released before it.
fn through_x<T: Number>(times: &Times<T>, branch: Branch) -> Option<T> {
    match branch {
        Branch::Direct => times.x_end(Node::A),
        Branch::Inferred => times.switch.map(|switch| switch.at),
    }
}

/// The ratio.
pub fn ratio<T: Number>(times: &Times<T>, branch: Branch) -> Option<T> {
    let [c1, c2, x] = times.of(Node::A)?;
    let (t_c1, t_c2, t3) = (c1 - times.d, c2 - times.d, x - times.d);
    let beside = times.beside.map_or(t3, |beside| t3 - beside);
    let t_x = through_x(times, branch)? * t_c2 / (t_c2 - beside);
    Some((t_x - t_c1) / (t_c2 - t_c1))
}
