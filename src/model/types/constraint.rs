//! Equations, couplings and ties.
//! Never here: the systems that are solved.

use super::Side;
use crate::deck::Span;

/// Constraints between nodes that hold in all steps.
#[derive(Clone, Debug, Default)]
pub struct Constraints {
    /// `*EQUATION`s, one node a term.
    pub equations: Vec<Equation>,
    /// `*MPC`s and `*COUPLING`s.
    pub links: Vec<Link>,
    /// `*TIE`s.
    pub ties: Vec<SurfaceTie>,
}

/// A linear equation, sum of coefficient times displacement or temperature = 0.
#[derive(Clone, Debug)]
pub struct Equation {
    /// Node index, degree of freedom (1 = r, 2 = z, 11 = temperature, in all terms or in none) and coefficient of each term.
    pub terms: Vec<(usize, u8, f64)>,
    /// The data line that begins it.
    pub span: Span,
}

impl Equation {
    /// Whether it is one between temperatures.
    pub fn is_thermal(&self) -> bool {
        self.terms.iter().any(|t| t.1 == 11)
    }
}

/// Nodes whose motion is that of a reference node (`*MPC`, `*COUPLING`).
#[derive(Clone, Debug)]
pub struct Link {
    /// What the deck calls it, for messages.
    pub name: String,
    /// How they are joined.
    pub kind: LinkKind,
    /// Reference node.
    pub reference: usize,
    /// The others.
    pub nodes: Vec<usize>,
    /// The data line or card.
    pub span: Span,
}

/// How nodes are joined to a reference node.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkKind {
    /// They move as it does, along r, along z, or both.
    Rigid([bool; 2]),
    /// It moves along z as they do in the mean with these weights, one for each, and hands its loads on by them.
    Distributing(Vec<f64>),
}

/// A surface whose nodes follow another surface (`*TIE`).
#[derive(Clone, Debug)]
pub struct SurfaceTie {
    /// Upper-case name.
    pub name: String,
    /// Nodes of the slave surface, ascending.
    pub slaves: Vec<usize>,
    /// Sides of the master surface.
    pub masters: Vec<(usize, Side)>,
    /// Whether tied nodes are first put on the master surface.
    pub adjust: bool,
    /// How far from the master surface a node may lie; 5 % of its facets' mean length if not given.
    pub tolerance: Option<f64>,
    /// The nodes that are tied whatever their distance, and no others (`TIED NSET`), ascending.
    pub chosen: Option<Vec<usize>>,
    /// The data line.
    pub span: Span,
}
