//! Linear equations, couplings and ties.

use super::ElementSide;
use crate::deck::Span;

/// Constraints between nodes, in force in all steps.
#[derive(Clone, Debug, Default)]
pub struct NodeConstraints {
    /// `*EQUATION` cards, expanded to single nodes.
    pub equations: Vec<LinearEquation>,
    /// `*MPC` and `*COUPLING` cards.
    pub links: Vec<NodeLink>,
    /// Ties of two surfaces (`*TIE`).
    pub ties: Vec<SurfaceTie>,
    /// Places `[r, z]` of all nodes at the last new mesh, at which the nodes of ties are found; empty before.
    pub tie_places: Vec<[f64; 2]>,
}

/// A homogeneous linear equation `Σ c_i u_i = 0` in displacements or temperatures.
#[derive(Clone, Debug)]
pub struct LinearEquation {
    /// Node index, degree of freedom (1 = r, 2 = z, 11 = temperature in all terms) and coefficient of each term.
    pub terms: Vec<(usize, u8, f64)>,
    /// Source position of the first data line.
    pub span: Span,
}

impl LinearEquation {
    /// Returns whether the equation relates temperatures.
    pub fn is_thermal(&self) -> bool {
        self.terms.iter().any(|t| t.1 == 11)
    }
}

/// Nodes linked to a reference node (`*MPC`, `*COUPLING`).
#[derive(Clone, Debug)]
pub struct NodeLink {
    /// Name used in messages.
    pub name: String,
    /// Degrees of freedom that the link couples.
    pub kind: LinkKind,
    /// Index of the reference node.
    pub reference: usize,
    /// Indices of the linked nodes.
    pub nodes: Vec<usize>,
    /// Source position of the data line or card.
    pub span: Span,
}

/// Kind of a link to a reference node.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkKind {
    /// The nodes have the displacement of the reference node along r, along z, or both.
    Rigid([bool; 2]),
    /// The reference node has the weighted mean displacement of the nodes along z; its forces are distributed with the
    /// same weights, one per node.
    Distributing(Vec<f64>),
}

/// A tie of a slave surface to a master surface (`*TIE`).
#[derive(Clone, Debug)]
pub struct SurfaceTie {
    /// Upper-case name.
    pub name: String,
    /// Indices of the nodes of the slave surface, ascending.
    pub slaves: Vec<usize>,
    /// Faces of the slave surface over which the tie is integrated (`TYPE=SURFACE TO SURFACE`); empty if each node follows a
    /// point of the master surface.
    pub slave_faces: Vec<(usize, ElementSide)>,
    /// Faces of the master surface.
    pub masters: Vec<(usize, ElementSide)>,
    /// Whether tied nodes are moved onto the master surface initially (`ADJUST`).
    pub adjust: bool,
    /// Largest distance at which a node is tied, length; `None` is 5 % of the mean facet length of the master surface.
    pub tolerance: Option<f64>,
    /// Nodes that are tied at any distance, ascending (`TIED NSET`); no other node is tied.
    pub chosen: Option<Vec<usize>>,
    /// Source position of the data line.
    pub span: Span,
}
