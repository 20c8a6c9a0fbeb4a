//! Edges between the kernel's buffer and the caller, and the numbers of the last ones.

use super::wiring::Lines;
use crate::pins::limits::EDGES_A_READ;
use crate::pins::{Edge, later};
use crate::units::Nanos;
use gpiocdev_uapi::v2::LineEdgeEvent;
use std::collections::VecDeque;

/// The length of `struct gpio_v2_line_event` in words.
const WORDS: usize = size_of::<LineEdgeEvent>() / size_of::<u64>();

/// The edges of one read, handed out one by one. Nothing allocates after construction.
#[derive(Debug)]
pub(super) struct EdgeBuffer {
    words: [u64; EDGES_A_READ * WORDS],
    edges: VecDeque<Edge>,
    /// The highest of the edges that were read.
    pub seqno: u32,
    /// The last of the edges of each node that were read.
    pub line_seqno: [u32; 2],
}

impl Default for EdgeBuffer {
    fn default() -> EdgeBuffer {
        let edges = VecDeque::with_capacity(EDGES_A_READ);
        EdgeBuffer { words: [0; EDGES_A_READ * WORDS], edges, seqno: 0, line_seqno: [0; 2] }
    }
}

impl EdgeBuffer {
    /// Where a read may put events; those not yet taken are lost.
    pub fn room(&mut self) -> &mut [u64] {
        self.forget();
        &mut self.words
    }

    /// Notes that a read has put so many words of events into the room; whether it was any.
    pub fn filled(&mut self, words: usize, lines: &Lines) -> bool {
        let count = words / WORDS;
        let events = self.words.chunks_exact(WORDS).take(count);
        for event in events.filter_map(|words| LineEdgeEvent::from_slice(words).ok()) {
            let Some(node) = lines.node_at(event.offset) else { continue };
            let LineEdgeEvent { timestamp_ns, seqno, line_seqno, .. } = *event;
            self.seqno = later(self.seqno, seqno);
            self.line_seqno[node.index()] = line_seqno;
            self.edges.push_back(Edge { node, at: Nanos(timestamp_ns as i64), seqno, line_seqno });
        }
        count > 0
    }

    /// The next edge.
    pub fn take(&mut self) -> Option<Edge> {
        self.edges.pop_front()
    }

    /// Drops the edges that have not been taken; their numbers stay known.
    pub fn forget(&mut self) {
        self.edges.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::super::wiring::tests::{lines, wiring};
    use super::*;
    use crate::circuit::Node;

    /// An event as the kernel writes it: stamp, then id, offset, seqno and line_seqno as 32 bit each, then padding.
    fn event(at: u64, offset: u32, seqno: u32, line_seqno: u32) -> [u64; WORDS] {
        let pair = |low: u32, high: u32| {
            let mut bytes = [0; 8];
            bytes[..4].copy_from_slice(&low.to_ne_bytes());
            bytes[4..].copy_from_slice(&high.to_ne_bytes());
            u64::from_ne_bytes(bytes)
        };
        [at, pair(2, offset), pair(seqno, line_seqno), 0, 0, 0]
    }

    fn fill(buffer: &mut EdgeBuffer, events: &[[u64; WORDS]]) -> bool {
        let words = events.concat();
        buffer.room()[..words.len()].copy_from_slice(&words);
        buffer.filled(words.len(), &lines(&wiring()))
    }

    #[test]
    fn edges_come_out_one_by_one_with_their_nodes() {
        let mut buffer = EdgeBuffer::default();
        assert!(fill(&mut buffer, &[event(1_000, 5, 7, 4), event(2_000, 6, 8, 4)]));
        let a = Edge { node: Node::A, at: Nanos(1_000), seqno: 7, line_seqno: 4 };
        let b = Edge { node: Node::B, at: Nanos(2_000), seqno: 8, line_seqno: 4 };
        assert_eq!([buffer.take(), buffer.take(), buffer.take()], [Some(a), Some(b), None]);
    }

    #[test]
    fn forgotten_edges_leave_their_numbers() {
        let mut buffer = EdgeBuffer::default();
        fill(&mut buffer, &[event(1, 5, u32::MAX, 30), event(2, 5, 0, 31), event(3, 6, 1, 12)]);
        buffer.forget();
        assert_eq!(buffer.take(), None);
        assert_eq!((buffer.seqno, buffer.line_seqno), (1, [31, 12]), "numbers wrap");
    }

    #[test]
    fn an_edge_that_was_queued_late_has_not_the_highest_number() {
        let mut buffer = EdgeBuffer::default();
        fill(&mut buffer, &[event(2, 6, u32::MAX - 1, 4), event(1, 5, u32::MAX - 2, 4)]);
        assert_eq!((buffer.seqno, buffer.line_seqno), (0, [4, 4]), "as if the numbers had gone round before");
        fill(&mut buffer, &[event(2, 6, 2, 5), event(1, 5, 1, 5)]);
        assert_eq!((buffer.seqno, buffer.line_seqno), (2, [5, 5]));
    }

    #[test]
    fn an_empty_read_has_no_edges() {
        let mut buffer = EdgeBuffer::default();
        fill(&mut buffer, &[event(1, 5, 1, 1)]);
        assert!(!fill(&mut buffer, &[]));
        assert_eq!(buffer.take(), None);
        assert_eq!((buffer.seqno, buffer.line_seqno), (1, [1, 0]));
    }
}
