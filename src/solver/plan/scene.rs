//! The products that most passes need.

use std::rc::Rc;

use indexmap::{IndexMap, IndexSet};

use crate::deck::Span;
use crate::element::solid_groups::Connectivity;
use crate::load::user_amplitude::SubroutineAmplitude;
use crate::mesh::surface::SurfaceGeometry;
use crate::model::{AmplitudeId, MaterialDefinition, Model, SolidSection, SurfaceContact};
use crate::plan::{Bodies, Links, SolidPlaces, State};
use crate::state::nodes::Node;
use crate::user::LoadProperties;

/// The model with its rigid bodies, and the solver indices of its deformable nodes and elements.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    pub model: &'a Model,
    pub bodies: &'a Bodies,
    pub places: &'a SolidPlaces,
}

impl<'a> Scene<'a> {
    /// Returns the name of an element of a group; empty if it does not exist.
    pub fn element_name(self, place: (usize, usize)) -> &'a str {
        self.places.element_at(place).map_or("", |e| &self.model.mesh.elements[e].name)
    }
}

/// A step of the model, and the products on which its constraints depend.
#[derive(Clone, Copy)]
pub struct StepInput<'a, 's> {
    pub scene: Scene<'a>,
    pub links: &'s Links,
    pub pairs: &'s Pairs,
    pub state: &'s State,
    /// Index of the step.
    pub index: usize,
}

/// A section of elements, and what its element group depends on.
pub struct GroupInput<'a, S = SolidSection, C = Connectivity> {
    pub model: &'a Model,
    pub places: &'a SolidPlaces,
    pub section: &'a S,
    pub material: &'a MaterialDefinition,
    pub elements: &'a [usize],
    /// Solver nodes of solid elements; `()` for elements whose nodes are taken from the mesh.
    pub connectivity: &'a C,
    pub nodes: &'a [Node],
}

/// Contact pairs of each step, and the names of all pairs for histories.
#[derive(Default)]
pub struct Pairs {
    pub by_step: Vec<Rc<Vec<SurfaceContact>>>,
    pub names: IndexSet<String>,
}

/// User amplitudes and surfaces of loads, which are created on first use and shared by effects.
#[derive(Default)]
pub struct Shared {
    pub amplitudes: Vec<SubroutineAmplitude>,
    /// Index of the value of each user amplitude in the list of the state.
    pub amplitude_index: IndexMap<AmplitudeId, usize>,
    /// Number of values that user amplitudes and user motions compute.
    pub amplitude_count: usize,
    /// Surfaces of loads in models without deformable elements, by the line of the load; revisions use them again.
    pub surfaces: IndexMap<Span, SurfaceGeometry>,
    /// Properties of the user load, once a load has requested them.
    pub load_properties: Option<LoadProperties>,
}
