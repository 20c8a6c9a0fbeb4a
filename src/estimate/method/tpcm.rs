//! Two-point calibration method: one node, eq. (3). The offset d cancels in the differences.

use super::{Dual, Evidence, Kind, Node, Number, Rules, Times};

/// What it decides.
pub(super) const RULES: Rules = Rules {
    circuits: &Kind::ALL,
    only_a: true,
    ratio: |times, _| ratio(times, Node::A),
    evidence: |times, _, _| evidence(times),
    ..Rules::usual('P')
};

/// One stretch: until A crossed.
pub(super) fn evidence(times: &Times<Dual>) -> Option<Evidence> {
    times.x_end(Node::A).map(|end| Evidence::over(end.value))
}

/// The ratio by eq. (3), from the crossings of one node alone.
pub fn ratio<T: Number>(times: &Times<T>, node: Node) -> Option<T> {
    let [c1, c2, x] = times.of(node)?;
    Some((x - c1) / (c2 - c1))
}
