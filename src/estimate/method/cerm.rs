//! Compact error reduction method: eq. (16)-(19).
//!
//! The upper line of (19) for a discharge that was switched to Rc2; the lower line is
//! [`tcdic::ratio`]. T_xA of (16) and (18) is the time that the discharge really ran through
//! R_x: from the start to the *switch*, an instant that our own call sets, so d is not subtracted from it. T_c2,x
//! runs from the switch to the crossing of B.

use super::{Dual, Evidence, Node, Number, Rules, Scale, Switching, Times, tcdic, tpcm};
use crate::estimate::limits::BEYOND_NOISE;
use crate::reading::Branch;

/// What it decides.
pub(super) const RULES: Rules = Rules {
    switching: Switching::AtFraction,
    has_time_limit: true,
    ratio: |times, branch| match branch {
        Branch::Direct => tcdic::ratio(times),
        Branch::Inferred => ratio(times),
    },
    evidence: |times, branch, scale| match branch {
        Branch::Direct => tcdic::evidence(times, scale),
        Branch::Inferred => evidence(times, scale),
    },
    ..Rules::usual('C')
};

/// The inferred crossings T_i,xA (16) and T_i,xB (18), d subtracted.
pub fn inferred<T: Number>(times: &Times<T>) -> Option<[T; 2]> {
    let (t_c2a, t_c2b) = (times.c2[0]? - times.d, times.c2[1]? - times.d);
    let switch = times.switch?;
    let t_c2x = times.x_end(Node::B)? - switch.on;
    let scale = switch.at / (t_c2b - t_c2x);
    Some([scale * t_c2a, scale * t_c2b])
}

/// The ratio by the upper line of eq. (19).
pub fn ratio<T: Number>(times: &Times<T>) -> Option<T> {
    let [xa, xb] = inferred(times)?;
    let sum = |[a, b]: [Option<T>; 2]| Some((a? - times.d) + (b? - times.d));
    let (sum_c1, sum_c2) = (sum(times.c1)?, sum(times.c2)?);
    Some((xa + xb - sum_c1) / (sum_c2 - sum_c1))
}

/// By how much the measured crossing of A misses the one that [`inferred`] predicts, for a switch before that crossing: a
/// check of the switched discharge that (16)-(19) leave unused. Zero but for noise.
///
/// The part 1 - T_xA/T_i,xA of the way to A's threshold remains at the switch, and Rc2 goes it in that part of T_c2A.
pub fn residual_a<T: Number>(times: &Times<T>) -> Option<T> {
    let switch = times.switch?;
    let t_c2a = times.c2[0]? - times.d;
    let [t_ixa, _] = inferred(times)?;
    Some((times.x_end(Node::A)? - switch.on) - (t_c2a - switch.at / t_ixa * t_c2a))
}

/// The part until the switch, and until A crossed if that came first; A's crossing is not needed otherwise.
fn evidence(times: &Times<Dual>, scale: &Scale<'_>) -> Option<Evidence> {
    let at_ns = times.switch?.at.value;
    let Some(a) = times.x_end(Node::A) else { return Some(Evidence::over(at_ns)) };
    // On which side of the switch A crossed is told by the times that do not hold its own jitter.
    if inferred(times)?[0].value > at_ns {
        let residual = residual_a(times)?;
        // Not `>`: what cannot be compared is no agreement.
        let agrees = (scale.u)(&residual).is_none_or(|u| residual.value.abs() <= BEYOND_NOISE * u);
        return Some(Evidence::over(at_ns).contradicting(!agrees));
    }
    Some(scale.over_two([a.value, at_ns], [0.0, 1.0], [tpcm::ratio(times, Node::A)?, ratio(times)?]))
}
