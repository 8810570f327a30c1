//! Rigid bodies, masses, springs and dashpots.
//! Never here: motion.

use crate::deck::Span;

/// What single elements of one or two nodes are given.
#[derive(Clone, Debug, Default)]
pub struct DiscreteElements {
    /// `*MASS` on nodes.
    pub masses: Vec<PointMass>,
    /// `*ROTARY INERTIA` on nodes.
    pub inertias: Vec<RotaryInertia>,
    /// `*SPRING` and `*DASHPOT`.
    pub connectors: Vec<ConnectorProperty>,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// Name of the element set that makes it, for messages.
    pub name: String,
    /// Reference node.
    pub reference: usize,
    /// Its elements.
    pub elements: Vec<usize>,
    /// Nodes tied or pinned in addition to the elements' own.
    pub nodes: Vec<usize>,
    /// Thickness of its RAX2 elements (0 if not given), length.
    pub thickness: f64,
    /// Mass per volume of its RAX2 elements (0 if not given).
    pub density: f64,
    /// The card.
    pub span: Span,
}

/// Attitude of a rigid body at the start, and how it is followed if its impact is oblique (extension).
#[derive(Clone, Debug)]
pub struct Attitude {
    /// Reference node of the body.
    pub reference: usize,
    /// Angles in degrees by which it is turned about its reference node: about direction 3, in the plane in which targets are
    /// tilted, and then about direction 1, out of it.
    pub angles: [f64; 2],
    /// Stations around the axis at which resistance is taken.
    pub stations: usize,
    /// Whether its mass is spread evenly over the volume that its meridian encloses, for its centre and its inertia.
    pub uniform: bool,
    /// The card.
    pub span: Span,
}

/// Stations around the axis unless `*ATTITUDE` says how many.
pub const STATIONS: usize = 64;

/// A rotary inertia on a node.
#[derive(Clone, Copy, Debug)]
pub struct RotaryInertia {
    /// Node index.
    pub node: usize,
    /// Moment of inertia about the axis of symmetry, and about any axis across it through the node.
    pub axial_transverse: [f64; 2],
    /// The card.
    pub span: Span,
}

/// A mass on a node.
#[derive(Clone, Copy, Debug)]
pub struct PointMass {
    /// Node index.
    pub node: usize,
    /// Mass.
    pub mass: f64,
    /// The card.
    pub span: Span,
}

/// What springs or dashpots of a set do.
#[derive(Clone, Debug)]
pub struct ConnectorProperty {
    /// Element indices.
    pub elements: Vec<usize>,
    /// 1 = r, 2 = z, for those between a node and the ground.
    pub dof: u8,
    /// Law.
    pub law: ConnectorLaw,
    /// The card.
    pub span: Span,
}

/// Law of a spring or a dashpot.
#[derive(Clone, Debug, PartialEq)]
pub enum ConnectorLaw {
    /// Force a length.
    Spring(f64),
    /// Rows of relative displacement and force.
    Table(Vec<[f64; 2]>),
    /// Force a velocity.
    Dashpot(f64),
    /// Rows of relative velocity and force.
    DashpotTable(Vec<[f64; 2]>),
}
