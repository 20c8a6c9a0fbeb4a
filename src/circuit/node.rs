//! The nodes of the circuit.

/// A node whose threshold crossing is timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Node {
    /// Node A: where the resistors are.
    A,
    /// Node B: between the two capacitors. Absent from one-capacitor circuits.
    B,
}

impl Node {
    /// Both nodes, in the order in which a discharge crosses them.
    pub const BOTH: [Node; 2] = [Node::A, Node::B];

    /// 0 for A, 1 for B.
    pub fn index(self) -> usize {
        self as usize
    }
}
