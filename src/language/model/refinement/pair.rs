//! A pair of nodes that `*MPC` links.

use crate::deck::Span;

/// A `*MPC` that links one node to a reference node.
#[derive(Clone, Debug)]
pub struct NodePair {
    /// Name used in messages.
    pub name: String,
    /// Linked node, and its reference node.
    pub nodes: [usize; 2],
    /// Source position of the data line.
    pub span: Span,
}
