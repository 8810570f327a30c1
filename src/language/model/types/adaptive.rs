//! Adaptive meshes.

use super::mesh::ElementSide;
use crate::deck::Span;
use crate::remesh::sizes::SizeLimits;

/// Domain of an adaptive mesh (`*ADAPTIVE MESH`).
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveMesh {
    /// Source position of the keyword line.
    pub span: Span,
    /// Name of the element set, in capitals.
    pub set: String,
    /// Element indices.
    pub elements: Vec<usize>,
    /// Number of increments between two changes of the mesh; `None` for the default.
    pub frequency: Option<u64>,
    /// Number of sweeps in each change.
    pub sweeps: usize,
    /// Number of sweeps at the start of the first step of the domain.
    pub initial_sweeps: usize,
    /// Smoothing and transport.
    pub controls: AdaptiveControls,
}

/// Smoothing and transport of an adaptive mesh (`*ADAPTIVE MESH CONTROLS`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveControls {
    /// Weights of volume, Laplacian and equipotential smoothing; they sum to 1.
    pub weights: [f64; 3],
    /// Whether the grading of the mesh at the start is kept; then the weights have no effect.
    pub graded: bool,
    /// Angle between the edges of the boundary from which on a node is at a corner, radians.
    pub corner_angle: f64,
    /// Whether the transport is of second order.
    pub second_order: bool,
    /// Whether sweeps start from the places after the previous change; `None` for the default.
    pub previous: Option<bool>,
}

impl Default for AdaptiveControls {
    /// Returns the values without a card (ABAQUS Analysis User's Guide, "ALE adaptive meshing and remapping in
    /// Abaqus/Explicit").
    fn default() -> Self {
        AdaptiveControls {
            weights: [1.0, 0.0, 0.0],
            graded: false,
            corner_angle: 30f64.to_radians(),
            second_order: true,
            previous: None,
        }
    }
}

/// Mesh and material at a part of the boundary of adaptive meshes (`REGION TYPE`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionType {
    /// The ends of the part move with the material.
    Lagrangian,
    /// The mesh slides along the surface of the material, also at the ends of the part.
    Sliding,
    /// Material flows through the boundary.
    Eulerian,
}

/// A part of the boundary of adaptive meshes with another region type than the default of its card: `SLIDING` for
/// surfaces, `LAGRANGIAN` for loads and boundary conditions.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveRegion {
    /// Source position of the keyword line.
    pub span: Span,
    /// Keyword of the card.
    pub keyword: &'static str,
    /// Region type.
    pub kind: RegionType,
    /// Faces of the part.
    pub faces: Vec<(usize, ElementSide)>,
    /// Nodes of the part, for conditions at nodes.
    pub nodes: Vec<usize>,
}

/// A body that is remeshed during the run (`*REMESH`).
#[derive(Clone, Debug, PartialEq)]
pub struct Remeshing {
    /// Source position of the keyword line.
    pub span: Span,
    /// Name of the element set, in capitals.
    pub set: String,
    /// Element indices in ascending order.
    pub elements: Vec<usize>,
    /// Smallest angle of the elements, radians.
    pub angle: f64,
    /// Fraction of the stable time increment after the last mesh; 0 for no limit.
    pub increment: f64,
    /// Increments between two checks.
    pub frequency: u64,
    /// Thickness below which sheets are left out of new meshes, as a fraction of the edge length of new elements.
    pub thickness: f64,
    /// Edge length of new elements; `None` for that of the mesh at the start.
    pub size: Option<f64>,
    /// Limits of the edge length by curvature and strain.
    pub limits: SizeLimits,
    /// Whether the plan has added the body: no card names it, and it keeps its mesh until that collapses.
    pub automatic: bool,
    /// Nodes that elements of other sections use, with their places `[r, z]` at the last new mesh of the body. The mesh of the model has
    /// the places at the start, which belong to the other elements. Empty before the first new mesh.
    pub shared: Vec<(usize, [f64; 2])>,
}
