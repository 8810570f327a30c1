//! Surfaces, surface interactions, contact pairs and general contact.

use indexmap::IndexMap;

use super::handle::{InteractionId, RigidSurfaceId, SurfaceId};
use super::material::{InterfaceEvolution, InterfaceInitiation};
use super::{ElementSurface, SideSelection};
use crate::deck::Span;
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::profile::SurfaceProfile;

/// Surface definitions by upper-case name.
#[derive(Clone, Debug, Default)]
pub struct SurfaceDefinitions {
    /// Element-based surfaces by name.
    pub faces: IndexMap<String, ElementSurface>,
    /// Analytical rigid surfaces by name.
    pub analytical: IndexMap<String, RigidSurface>,
    /// Node-based surfaces: node indices.
    pub nodes: IndexMap<String, Vec<usize>>,
    /// Fronts of analytical surfaces that were determined at the start of a run, in a model with new meshes; `None` in the
    /// model of a deck.
    pub fronts: Option<Vec<AnalyticalFront>>,
    /// Elements of each connected part before new meshes separated any, ascending; they name the surfaces of general contact.
    pub parts: Option<Vec<Vec<usize>>>,
}

/// Front of an analytical surface in contact.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalyticalFront {
    /// Handle of the analytical surface.
    pub surface: RigidSurfaceId,
    /// Name of the contact pair; `None` in general contact.
    pub pair: Option<String>,
    /// Whether the front is to the right of the direction of the surface.
    pub is_reversed: bool,
}

impl SurfaceDefinitions {
    /// Returns the upper-case name of an element-based surface.
    pub fn name(&self, id: SurfaceId) -> &str {
        self.faces.get_index(id.index()).map_or("", |(name, _)| name)
    }

    /// Returns the upper-case name of an analytical surface.
    pub fn analytical_name(&self, id: RigidSurfaceId) -> &str {
        self.analytical.get_index(id.index()).map_or("", |(name, _)| name)
    }
}

/// An analytical rigid surface, a chain of lines and arcs.
#[derive(Clone, Debug)]
pub struct RigidSurface {
    /// Segments in order; the contact side is on the left in the direction of the chain.
    pub profile: SurfaceProfile,
    /// Reference node of the rigid body to which the surface belongs.
    pub reference: Option<usize>,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Contact properties under a name (`*SURFACE INTERACTION`).
#[derive(Clone, Debug)]
pub struct SurfaceInteraction {
    /// Upper-case name.
    pub name: String,
    /// Friction, pressure-overclosure relationship and heat conduction.
    pub law: InteractionLaw,
    /// Keyword and source position of the thermal cards of the interaction.
    pub heat_cards: Vec<(&'static str, Span)>,
    /// Bond of the surfaces; `None` without `*COHESIVE BEHAVIOR`.
    pub cohesion: Option<CohesiveBehavior>,
}

/// Bond of two contact surfaces with a traction-separation law (`*COHESIVE BEHAVIOR`).
#[derive(Clone, Debug, PartialEq)]
pub struct CohesiveBehavior {
    /// Normal and shear stiffness, traction per separation; `None` is that of a layer of the underlying
    /// elements.
    pub stiffness: Option<[f64; 2]>,
    /// Normal traction per shear separation, and shear traction per normal separation; 0 for uncoupled tractions.
    pub coupling: f64,
    /// Viscosity of the damage (`*DAMAGE STABILIZATION`), time; 0 without viscosity.
    pub viscosity: f64,
    /// Whether only points in contact when the pair comes into force are bonded (`ELIGIBILITY=ORIGINAL CONTACTS`).
    pub original_only: bool,
    /// Whether points are bonded again after complete damage and separation (`REPEATED CONTACTS`).
    pub repeated: bool,
    /// Damage initiation; `None` for an elastic bond.
    pub initiation: Option<InterfaceInitiation>,
    /// Damage evolution; without it damage does not begin.
    pub evolution: Option<InterfaceEvolution>,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Contact of two element-based surfaces, self-contact of one, or contact with an analytical surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceContact {
    /// Both surfaces; the same surface twice for self-contact.
    pub sides: [SideSelection; 2],
    /// Analytical surface of the pair; `None` if both surfaces are element-based.
    pub analytical: Option<AnalyticalSide>,
    /// Whether the pair belongs to general contact.
    pub general: bool,
    /// Whether shell thickness is ignored (`NO THICKNESS`).
    pub no_thickness: bool,
    /// Prescribed initial clearance; `None` uses the geometric gaps.
    pub clearance: Option<PrescribedClearance>,
    /// Scale factor of the penalty stiffness; `None` for kinematic contact, which allows no penetration.
    pub penalty: Option<f64>,
    /// Index (0 or 1) of the surface that carries the contact pressures, the secondary surface (`WEIGHT`,
    /// `*CONTACT FORMULATION`); `None` for an automatic choice.
    pub secondary: Option<usize>,
    /// Upper-case name of the contact pair set (`CPSET`).
    pub cpset: Option<String>,
    /// Surface interaction of the pair, if one is given.
    pub interaction: Option<InteractionId>,
    /// Normal behaviour, friction and heat exchange of the interaction.
    pub law: InteractionLaw,
    /// Source position of the data line.
    pub span: Span,
}

impl SurfaceContact {
    /// Returns whether the pair is self-contact of one surface.
    pub fn is_self_contact(&self) -> bool {
        self.sides[0].name == self.sides[1].name
    }
}

/// Analytical surface of a contact pair, and the nodes on the opposite side.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalyticalSide {
    /// Index (0 or 1) of the analytical surface in [`SurfaceContact::sides`]; that entry has no faces.
    pub side: usize,
    /// Handle of the analytical surface.
    pub surface: RigidSurfaceId,
    /// Node indices of the opposite surface, ascending. A node-based surface has no faces in [`SurfaceContact::sides`].
    pub nodes: Vec<usize>,
}

/// Prescribed initial clearance of a contact pair. Nodes are not moved and no strain results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescribedClearance {
    /// Clearance, length.
    pub gap: f64,
    /// Largest geometric gap that is replaced, length; `None` is a tenth of the element length.
    pub above: Option<f64>,
    /// Largest initial overclosure that is replaced, length; `None` is a tenth of the element length.
    pub below: Option<f64>,
}

/// Surface named by a card of general contact.
#[derive(Clone, Debug, PartialEq)]
pub enum ContactDomain {
    /// All exterior faces and all analytical rigid surfaces of the model.
    All,
    /// An element-based surface.
    Surface(SideSelection),
    /// An analytical rigid surface.
    Analytical(RigidSurfaceId),
}

/// The two sides of pairs in general contact, as a data line gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactDomains {
    /// Both sides.
    pub sides: [ContactDomain; 2],
    /// Source position of the data line.
    pub span: Span,
}

/// General contact (`*CONTACT`): contacting pairs are found from the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeneralContact {
    /// Source position of the `*CONTACT` card.
    pub span: Span,
    /// Whether all exterior faces may contact each other and all analytical surfaces (`ALL EXTERIOR`).
    pub all: bool,
    /// Included pairs of `*CONTACT INCLUSIONS`.
    pub included: Vec<ContactDomains>,
    /// Excluded pairs of `*CONTACT EXCLUSIONS`.
    pub excluded: Vec<ContactDomains>,
    /// Assigned interactions; for a pair that several assignments cover, the last one applies.
    pub assigned: Vec<AssignedInteraction>,
    /// Assigned initial clearances; for a pair that several assignments cover, the last one applies.
    pub clearances: Vec<(ContactDomains, PrescribedClearance)>,
    /// Scale factors of the penalty stiffness of the covered pairs, which use penalty contact; the last assignment
    /// applies.
    pub penalties: Vec<(ContactDomains, f64)>,
    /// Pairs with a given secondary surface: whether it is the first one; the last assignment applies.
    pub roles: Vec<(ContactDomains, bool)>,
    /// What happens to nodes whose elements are all deleted (`NODAL EROSION`).
    pub detached_nodes: DetachedNodes,
}

impl GeneralContact {
    /// Returns whether nodes without elements are taken out of contact.
    pub fn excludes_detached_nodes(&self) -> bool {
        self.detached_nodes != DetachedNodes::InContact
    }
}

/// What happens to nodes whose elements are all deleted (`NODAL EROSION`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DetachedNodes {
    /// They remain in contact as point masses.
    #[default]
    InContact,
    /// They leave the contact.
    Excluded,
    /// Their mass joins the nodes of their last elements that still have elements; the others leave the contact.
    Merged,
}

/// An assignment of a surface interaction in general contact.
#[derive(Clone, Debug, PartialEq)]
pub struct AssignedInteraction {
    /// Both sides of the pair: surfaces, or the whole exterior.
    pub domains: ContactDomains,
    /// Surface interaction that is assigned, if one is given.
    pub interaction: Option<InteractionId>,
    /// Normal behaviour, friction and heat exchange of the interaction.
    pub law: InteractionLaw,
}
