//! What really happened in a discharge, to hold what was measured against.

use crate::circuit::Node;
use crate::pins::Drives;
use crate::pins::limits::CHANGES_KEPT;

/// True instants since the last [`Pins::arm`](crate::pins::Pins::arm), as f64 ns since the first line moved after
/// it: the true start of the discharge.
#[derive(Debug, Clone, Default)]
pub struct Truth {
    start_ns: Option<i64>,
    crossings_ns: [Option<f64>; 2],
    changes: [(f64, Drives); CHANGES_KEPT],
    count: usize,
}

impl Truth {
    /// When a node's voltage passed its threshold, without noise, latency and rounding.
    pub fn crossing_ns(&self, node: Node) -> Option<f64> {
        self.crossings_ns[node.index()]
    }

    /// Each change of lines: when, and what drove afterwards.
    pub fn changes(&self) -> &[(f64, Drives)] {
        &self.changes[..self.count]
    }

    pub(super) fn clear(&mut self) {
        *self = Truth::default();
    }

    pub(super) fn crossed(&mut self, node: Node, since_ns: i64, seconds: f64) {
        let start_ns = self.start_ns.unwrap_or(since_ns);
        self.crossings_ns[node.index()] = Some((since_ns - start_ns) as f64 + seconds * 1e9);
    }

    pub(super) fn switched(&mut self, on: Drives, at_ns: i64) {
        let start_ns = *self.start_ns.get_or_insert(at_ns);
        if let Some(place) = self.changes.get_mut(self.count) {
            *place = ((at_ns - start_ns) as f64, on);
            self.count += 1;
        }
    }
}
