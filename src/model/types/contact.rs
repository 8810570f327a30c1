//! Contact: pairs of surfaces, general contact and interactions.
//! Never here: what contact does.

use indexmap::IndexMap;

use super::handle::{InteractionId, RigidSurfaceId, SurfaceId};
use super::{Sides, Surface};
use crate::deck::Span;
use crate::kernel::interaction::Law;
use crate::kernel::profile::Profile;

/// Surfaces by upper-case name.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    /// Surfaces of element faces.
    pub faces: IndexMap<String, Surface>,
    /// Analytical surfaces.
    pub analytical: IndexMap<String, RigidSurface>,
    /// Surfaces of nodes: their nodes.
    pub nodes: IndexMap<String, Vec<usize>>,
}

impl Surfaces {
    /// Name of a surface of element faces, upper case.
    pub fn name(&self, id: SurfaceId) -> &str {
        self.faces.get_index(id.index()).map_or("", |(name, _)| name)
    }
}

/// An analytical rigid surface of lines and arcs.
#[derive(Clone, Debug)]
pub struct RigidSurface {
    /// Its segments in order; the front is to the left of the way along them.
    pub profile: Profile,
    /// Reference node of the rigid body that carries it.
    pub reference: Option<usize>,
    /// The card.
    pub span: Span,
}

/// How surfaces interact.
#[derive(Clone, Debug)]
pub struct Interaction {
    /// Upper-case name.
    pub name: String,
    /// What it does.
    pub law: Law,
    /// Its cards of heat.
    pub heat_cards: Vec<(&'static str, Span)>,
}

/// Contact of two surfaces of elements, of one with itself, or of one with an analytical surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceContact {
    /// Both surfaces; the same twice where one meets itself.
    pub sides: [Sides; 2],
    /// Of an analytical surface and what meets it; `None` of surfaces of elements.
    pub analytical: Option<AnalyticalSide>,
    /// Whether it is one of general contact.
    pub general: bool,
    /// Whether shells meet at their middle surface (`NO THICKNESS`).
    pub thin: bool,
    /// What gaps at the start are taken as; `None` as they are.
    pub clearance: Option<Clearance>,
    /// Factor on the stiffness of penalty springs; `None` where surfaces do not give way.
    pub penalty: Option<f64>,
    /// Name of the set of pairs that it belongs to (`CPSET`), upper case.
    pub cpset: Option<String>,
    /// Its surface interaction.
    pub interaction: Option<InteractionId>,
    /// The law of that interaction.
    pub law: Law,
    /// The data line.
    pub span: Span,
}

impl SurfaceContact {
    /// Whether it is a surface that may meet itself.
    pub fn is_of_one(&self) -> bool {
        self.sides[0].name == self.sides[1].name
    }
}

/// Which side of a pair is an analytical surface, and what meets it.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalyticalSide {
    /// The side; it has the upper-case name of the surface and no faces.
    pub side: usize,
    /// The analytical surface.
    pub surface: RigidSurfaceId,
    /// Nodes of the other surface, ascending; that has no faces either where it is one of nodes.
    pub nodes: Vec<usize>,
}

/// What gaps at the start are taken as: no node is moved, and nothing is strained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// The gap, length.
    pub gap: f64,
    /// Gaps up to this are, length; `None` is a tenth of the elements.
    pub above: Option<f64>,
    /// Overlaps up to this are, length; `None` is a tenth of the elements.
    pub below: Option<f64>,
}

/// What a word of general contact means.
#[derive(Clone, Debug, PartialEq)]
pub enum ContactDomain {
    /// All that is outside.
    All,
    /// A surface.
    Surface(Sides),
}

/// General contact (`*CONTACT`): which surfaces may meet is found from the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeneralContact {
    /// The card.
    pub span: Span,
    /// Whether all that is outside may meet everything (`ALL EXTERIOR`).
    pub all: bool,
    /// What may meet beside that, with its data line.
    pub included: Vec<([ContactDomain; 2], Span)>,
    /// What may not.
    pub excluded: Vec<[ContactDomain; 2]>,
    /// How they interact; the last that covers a pair counts.
    pub assigned: Vec<AssignedInteraction>,
    /// What gaps at the start are taken as; the last that covers a pair counts.
    pub clearances: Vec<([ContactDomain; 2], Clearance)>,
    /// Factors on penalty springs, which what they cover has; the last that covers a pair counts.
    pub penalties: Vec<([ContactDomain; 2], f64)>,
    /// Whether nodes that no element has any more meet nothing (`NODAL EROSION=YES`).
    pub drops_points: bool,
}

/// An interaction of general contact.
#[derive(Clone, Debug, PartialEq)]
pub struct AssignedInteraction {
    /// The surfaces that it is given to.
    pub domains: [ContactDomain; 2],
    /// The surface interaction.
    pub interaction: Option<InteractionId>,
    /// The law of that interaction.
    pub law: Law,
}
