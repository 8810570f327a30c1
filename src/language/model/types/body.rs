//! Rigid bodies, point masses, rotary inertias, springs, dashpots and infinite elements.

use super::handle::MaterialId;
use crate::deck::Span;

/// Properties of point masses, rotary inertias, springs, dashpots and infinite elements.
#[derive(Clone, Debug, Default)]
pub struct DiscreteElements {
    /// Masses of nodes (`*MASS`).
    pub masses: Vec<PointMass>,
    /// Rotary inertias of nodes (`*ROTARY INERTIA`).
    pub inertias: Vec<RotaryInertia>,
    /// Properties of springs and dashpots (`*SPRING`, `*DASHPOT`).
    pub connectors: Vec<ConnectorProperty>,
    /// Sections of infinite elements, until their loads are part of all steps.
    pub infinite: Vec<InfiniteSection>,
}

/// Infinite elements and their material (`*SOLID SECTION`).
#[derive(Clone, Debug)]
pub struct InfiniteSection {
    /// Indices of the elements.
    pub elements: Vec<usize>,
    /// Material that fills the space outside the mesh.
    pub material: MaterialId,
    /// Source position of the keyword line.
    pub span: Span,
}

/// A rigid body, defined by `*RIGID BODY`: reference node, elements and analytical surface.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// Name of the element set, used in messages.
    pub name: String,
    /// Index of the reference node.
    pub reference: usize,
    /// Indices of the elements of the body.
    pub elements: Vec<usize>,
    /// Indices of the nodes added by `PIN NSET` and `TIE NSET`.
    pub nodes: Vec<usize>,
    /// Thickness of the RAX2 elements, length; 0 if not given.
    pub thickness: f64,
    /// Mass per volume of the RAX2 elements; 0 if not given.
    pub density: f64,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Initial attitude of a rigid body, and settings of its motion in oblique impact (`*ATTITUDE`, extension).
#[derive(Clone, Debug)]
pub struct InitialAttitude {
    /// Index of the reference node of the body.
    pub reference: usize,
    /// Rotation angles about the reference node, in degrees: first about direction 3 (in the plane in which targets are
    /// inclined), then about direction 1 (out of that plane).
    pub angles: [f64; 2],
    /// Number of circumferential stations at which the target resistance is evaluated.
    pub stations: usize,
    /// Whether centre of mass and inertia are those of a homogeneous body that fills the meridian outline.
    pub uniform: bool,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Default number of circumferential stations ([`InitialAttitude::stations`]).
pub const STATIONS: usize = 64;

/// The rotary inertia of a node (`*ROTARY INERTIA`).
#[derive(Clone, Copy, Debug)]
pub struct RotaryInertia {
    /// Index of the node.
    pub node: usize,
    /// Moments of inertia I11, I22, I33 about axes through the node; direction 2 is the axis of symmetry.
    pub moments: [f64; 3],
    /// Source position of the keyword line.
    pub span: Span,
}

/// The point mass of a node (`*MASS`).
#[derive(Clone, Copy, Debug)]
pub struct PointMass {
    /// Index of the node.
    pub node: usize,
    /// Mass of the whole ring or point, in the mass unit of the deck.
    pub mass: f64,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Force law of the springs or dashpots of an element set.
#[derive(Clone, Debug)]
pub struct ConnectorProperty {
    /// Indices of the elements with this property.
    pub elements: Vec<usize>,
    /// Degree of freedom (1 = r, 2 = z) of springs and dashpots to ground.
    pub dof: u8,
    /// Force as a function of the relative displacement or velocity.
    pub law: ConnectorLaw,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Force law of a spring or a dashpot.
#[derive(Clone, Debug, PartialEq)]
pub enum ConnectorLaw {
    /// Linear spring: stiffness, force per length.
    Spring(f64),
    /// Nonlinear spring: rows of relative displacement and force.
    Table(Vec<[f64; 2]>),
    /// Linear dashpot: damping coefficient, force per velocity.
    Dashpot(f64),
    /// Nonlinear dashpot: rows of relative velocity and force.
    DashpotTable(Vec<[f64; 2]>),
}
