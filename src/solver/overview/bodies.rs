//! Parts at the start: elements, mass, position, velocity.

use indexmap::IndexMap;
use serde::Serialize;

use crate::model::Model;
use crate::plan::{Plan, State};
use crate::platform::PortableMath as _;
use crate::state::BodyState;

/// A section of deformable elements, or a rigid body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartOverview {
    /// Material of the section, or name of the rigid body.
    pub name: String,
    /// Whether the body is rigid.
    pub rigid: bool,
    /// Number of elements by type.
    pub elements: IndexMap<String, usize>,
    /// Mass of the full ring.
    pub mass: f64,
    /// Smallest and largest r, smallest and largest z.
    pub extent: [[f64; 2]; 2],
    /// z of the centre of mass; absent for zero mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre: Option<f64>,
    /// Mass-weighted mean velocity along z, and the largest nodal speed.
    pub velocity: [f64; 2],
    /// Smallest stable time increment of single elements at the start, without scale factor and without the estimate of
    /// the whole model; absent for rigid bodies, and for materials whose stiffness is known only during a run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stable_increment: Option<f64>,
}

/// Returns all parts in the order of the deck.
pub(super) fn parts(model: &Model, plan: &Plan, state: &State) -> Vec<PartOverview> {
    let sections = model.material_regions().filter_map(|(material, elements)| {
        let name = model.materials.get(material.index()).map_or(String::new(), |m| m.name.clone());
        deformable(name, elements, model, plan, state)
    });
    sections.chain(plan.bodies.iter().map(|body| rigid(body, model))).collect()
}

/// Sums over the nodes of a part.
struct PartSums {
    mass: f64,
    moment: f64,
    momentum: f64,
    fastest: f64,
    extent: [[f64; 2]; 2],
}

impl PartSums {
    fn new() -> PartSums {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        PartSums { mass: 0.0, moment: 0.0, momentum: 0.0, fastest: 0.0, extent: [none; 2] }
    }

    fn add(&mut self, mass: f64, place: [f64; 2], velocity: [f64; 2]) {
        self.mass += mass;
        self.moment += mass * place[1];
        self.momentum += mass * velocity[1];
        self.fastest = self.fastest.max(velocity[0].portable_hypot(velocity[1]));
        for (range, x) in self.extent.iter_mut().zip(place) {
            *range = [range[0].min(x), range[1].max(x)];
        }
    }

    fn part(self, name: String, rigid: bool, elements: IndexMap<String, usize>) -> PartOverview {
        let per = |sum: f64| (self.mass > 0.0).then(|| sum / self.mass);
        let (centre, mean) = (per(self.moment), per(self.momentum).unwrap_or(0.0));
        PartOverview {
            name,
            rigid,
            elements,
            mass: self.mass,
            extent: self.extent,
            centre,
            velocity: [mean, self.fastest],
            stable_increment: None,
        }
    }
}

fn types<'a>(elements: impl Iterator<Item = &'a usize>, model: &Model) -> IndexMap<String, usize> {
    let mut counts = IndexMap::new();
    for &element in elements {
        *counts.entry(model.mesh.elements[element].kind.name().to_owned()).or_insert(0) += 1;
    }
    counts
}

/// Returns the part of the deformable elements of a section; `None` if all elements belong to rigid bodies.
fn deformable(name: String, elements: &[usize], model: &Model, plan: &Plan, state: &State) -> Option<PartOverview> {
    let free: Vec<usize> = elements.iter().copied().filter(|e| plan.places.elements.contains_key(e)).collect();
    let mut sums = PartSums::new();
    let nodes = state.dofs.nodes.as_slice();
    let mut rates = [f64::INFINITY, 0.0_f64];
    for element in &free {
        let (group, index) = plan.places.elements[element];
        let group = &state.elements.groups[group];
        let rate = group.stable_rate(index, None, nodes).unwrap_or(0.0);
        rates = [rates[0].min(rate), rates[1].max(rate)];
        for (corner, mass) in group.boundary(index).iter().zip(group.masses(index)) {
            let node = &nodes[*corner as usize];
            sums.add(mass, node.place(), [node.v_r, node.v_z]);
        }
    }
    let [lowest, highest] = rates;
    let stable_increment = (lowest > 0.0 && highest.is_finite()).then(|| 1.0 / highest);
    let part = |sums: PartSums| PartOverview { stable_increment, ..sums.part(name, false, types(free.iter(), model)) };
    (!free.is_empty()).then(|| part(sums))
}

fn rigid(body: &crate::plan::PlannedRigidBody, model: &Model) -> PartOverview {
    let mut sums = PartSums::new();
    for &node in &body.nodes {
        sums.add(0.0, model.mesh.points[node], [0.0, body.initial_velocity]);
    }
    for &(node, mass) in &body.lumped_mass {
        sums.add(mass, model.mesh.points[node], [0.0, body.initial_velocity]);
    }
    sums.part(body.name.clone(), true, types(body.elements.iter(), model))
}

/// Returns the total mass of deformable elements, point masses and rigid bodies.
pub(super) fn mass(plan: &Plan, state: &State) -> f64 {
    let turning = plan.places.rotations.values().map(|&n| state.dofs.nodes.mass[n]).sum::<f64>();
    let bodies: f64 = plan.bodies.iter().map(crate::plan::PlannedRigidBody::mass).sum();
    state.dofs.nodes.mass.iter().sum::<f64>() - turning + bodies
}

/// Returns the initial kinetic energy.
pub(super) fn kinetic_energy(state: &State) -> f64 {
    let nodes = state.dofs.nodes.as_slice().iter().zip(&state.dofs.nodes.mass);
    let of_nodes: f64 = nodes.map(|(node, mass)| 0.5 * mass * (node.v_r * node.v_r + node.v_z * node.v_z)).sum();
    of_nodes + state.dofs.bodies.iter().map(BodyState::kinetic).sum::<f64>()
}
