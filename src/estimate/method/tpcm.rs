//! Two-point calibration method: one node, eq. (3). The offset d cancels in the differences.

use super::{Dual, Evidence, Kind, Node, Number, Rules, Scale, Switching, Times};
use crate::reading::Branch;

/// The method.
#[derive(Debug)]
pub struct Tpcm;

impl Rules for Tpcm {
    fn circuits(&self) -> &'static [Kind] {
        &Kind::ALL
    }

    fn last(&self, _: Kind) -> Node {
        Node::A
    }

    fn switching(&self) -> Switching {
        Switching::Never
    }

    fn ratio(&self, times: &Times<Dual>, _: Branch) -> Option<Dual> {
        ratio(times, Node::A)
    }

    fn evidence(&self, times: &Times<Dual>, _: Branch, _: &Scale<'_>) -> Option<Evidence> {
        times.x_end(Node::A).map(|end| Evidence::over(end.value))
    }
}

/// The ratio by eq. (3), from the crossings of one node alone.
pub fn ratio<T: Number>(times: &Times<T>, node: Node) -> Option<T> {
    let [c1, c2, x] = times.of(node)?;
    Some((x - c1) / (c2 - c1))
}
