//! A `*COUPLING` card before its `*KINEMATIC` or `*DISTRIBUTING` card is read.

use crate::deck::Span;

/// A `*COUPLING` card whose kind is not known yet.
pub(super) struct PendingCoupling {
    /// Upper-case name.
    pub name: String,
    /// Index of the reference node.
    pub reference: usize,
    /// Indices of the nodes of the surface, ascending.
    pub nodes: Vec<usize>,
    /// Tributary area of each node; 1 for each node of a node-based surface.
    pub areas: Vec<f64>,
    /// Source position of the card.
    pub span: Span,
}
