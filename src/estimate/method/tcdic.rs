//! Two-capacitor direct interface circuit: both nodes, eq. (11). The offset d cancels in the differences.

use super::{Dual, Evidence, Node, Number, Rules, Scale, Times, tpcm};

/// What it decides.
pub(super) const RULES: Rules = Rules::usual('D');

/// The ratio by eq. (11).
pub fn ratio<T: Number>(times: &Times<T>) -> Option<T> {
    let ([c1a, c2a, xa], [c1b, c2b, xb]) = (times.of(Node::A)?, times.of(Node::B)?);
    let sum_c1 = c1a + c1b;
    Some((xa + xb - sum_c1) / (c2a + c2b - sum_c1))
}

/// What eq. (11) rests on: T_A + T_B = (g_A + g_B) (R_x + Ro), so that each node's own estimate counts by its g.
pub fn evidence(times: &Times<Dual>, scale: &Scale<'_>) -> Option<Evidence> {
    let g = |node| times.of(node).map(|[c1, c2, _]| c2.value - c1.value);
    let (g_a, g_b) = (g(Node::A)?, g(Node::B)?);
    let ends = [times.x_end(Node::A)?.value, times.x_end(Node::B)?.value];
    let ratios = [tpcm::ratio(times, Node::A)?, tpcm::ratio(times, Node::B)?];
    Some(scale.over_two(ends, [g_a, g_b].map(|g| g / (g_a + g_b)), ratios))
}
