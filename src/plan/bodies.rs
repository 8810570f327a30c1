//! Rigid bodies of the plan: their nodes, lumped mass and initial velocity.
//! Never here: loads.

use std::collections::{HashMap, HashSet};

use super::Compiler;
use crate::deck::{Diagnostic, Span};
use crate::kernel::facet::Facet;
use crate::kernel::lists::heap_bytes;
use crate::kernel::quad::corner_masses;
use crate::model::{ElementKind, InitialCondition, InitialKind, RigidBody};

/// Velocities of an oblique body, by degree of freedom.
const ALONG: [&str; 6] = ["v_1", "v_2", "v_3", "w_1", "w_2", "w_3"];

/// A rigid body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name for messages and results.
    pub name: String,
    /// Reference node.
    pub reference: usize,
    /// Lumped mass of each node that carries some: `(node, mass)`, ascending.
    pub lumped_mass: Vec<(usize, f64)>,
    /// The part of the mass that is of deformable elements tied to it.
    pub tied_mass: f64,
    /// All nodes that move with it, ascending.
    pub nodes: Vec<usize>,
    /// Its elements.
    pub elements: Vec<usize>,
    /// Whether it has six degrees of freedom; otherwise it moves along z.
    pub spatial: bool,
    /// Velocity along z at the start.
    pub initial_velocity: f64,
    /// The card.
    pub span: Span,
}

impl Body {
    /// Total mass: the sum of the diagonal of the lumped mass matrix.
    pub fn mass(&self) -> f64 {
        self.own_mass() + self.tied_mass
    }

    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        let places = size_of::<usize>() * (self.nodes.capacity() + self.elements.capacity());
        size_of_val(self) + self.name.capacity() + places + heap_bytes(&self.lumped_mass)
    }

    /// Mass without that of deformable elements tied to it.
    pub fn own_mass(&self) -> f64 {
        self.lumped_mass.iter().map(|m| m.1).sum()
    }
}

impl Compiler<'_> {
    /// Makes all bodies and refuses what moves in other ways.
    pub(super) fn bodies(&mut self) {
        for body in &self.model.rigid_bodies {
            self.body(body);
        }
    }

    /// What concerns bodies once it is known what deforms.
    pub(super) fn finish_bodies(&mut self) {
        self.initial_velocities();
        self.refuse_strays();
        self.check_masses();
    }

    /// Masses and velocities at the start of bodies whose nodes and elements are known.
    pub(super) fn weigh_bodies(&mut self) {
        for (index, rigid) in self.model.rigid_bodies.iter().enumerate() {
            let lumped_mass = self.lumped_mass(rigid, &self.bodies[index].nodes);
            let body = &mut self.bodies[index];
            (body.lumped_mass, body.initial_velocity) = (lumped_mass, 0.0);
        }
        self.initial_velocities();
        self.check_masses();
    }

    fn body(&mut self, rigid: &RigidBody) {
        let index = self.bodies.len();
        let mesh = &self.model.mesh;
        let mut nodes: Vec<usize> =
            rigid.elements.iter().flat_map(|&e| mesh.elements[e].nodes.iter().copied()).collect();
        nodes.extend(&rigid.nodes);
        nodes.push(rigid.reference);
        self.carried_along(rigid, &mut nodes);
        nodes.sort_unstable();
        nodes.dedup();
        for &node in &nodes {
            if self.body_of_node.insert(node, index).is_some_and(|other| other != index) {
                self.shared(rigid, format!("node {}", mesh.node_names[node]));
            }
        }
        for &element in &rigid.elements {
            if self.body_of_element.insert(element, index).is_some_and(|other| other != index) {
                self.shared(rigid, format!("element {}", mesh.elements[element].name));
            }
        }
        let lumped_mass = self.lumped_mass(rigid, &nodes);
        let spatial = self.is_oblique(rigid);
        let body = Body {
            name: rigid.name.clone(),
            reference: rigid.reference,
            lumped_mass,
            tied_mass: 0.0,
            nodes,
            elements: rigid.elements.clone(),
            spatial,
            initial_velocity: 0.0,
            span: rigid.span,
        };
        let how = if spatial { "moves and turns in space" } else { "moves along z" };
        let detail = format!("reference node {}, {how}", mesh.node_names[rigid.reference]);
        self.cause(rigid.span, "rigid body", body.nodes.len(), "nodes", detail);
        let detail = format!("mass {}", body.mass());
        self.cause(rigid.span, "lumped mass", body.lumped_mass.len(), "nodes", detail);
        self.bodies.push(body);
    }

    fn shared(&mut self, rigid: &RigidBody, what: String) {
        let message = format!("{what} belongs to two rigid bodies");
        self.diagnostics.push(Diagnostic::error("P009", message).at(rigid.span, "the second of them"));
    }

    /// The diagonal of the lumped mass matrix: RAX2 shells by row sums, point masses as they are, and solids of a deformable
    /// type by the density of their section (ABAQUS Analysis User's Guide, "Rigid body definition", "Rigid body mass").
    fn lumped_mass(&self, rigid: &RigidBody, nodes: &[usize]) -> Vec<(usize, f64)> {
        let mesh = &self.model.mesh;
        let mut masses = vec![0.0; nodes.len()];
        let own: HashSet<usize> = rigid.elements.iter().copied().collect();
        let mut densities: HashMap<usize, f64> = HashMap::new();
        for section in &self.model.sections {
            let density = self.model.materials[section.material].density;
            let solids = section.elements.iter().filter(|e| own.contains(*e));
            densities.extend(solids.filter_map(|&e| Some((e, density?))));
        }
        let mut add = |node: usize, mass: f64| {
            if let Ok(at) = nodes.binary_search(&node) {
                masses[at] += mass;
            }
        };
        for &element in &rigid.elements {
            if let Some(&density) = densities.get(&element) {
                for cell in mesh.cells(element) {
                    let masses = corner_masses(cell.map(|n| mesh.points[n]), density);
                    cell.into_iter().zip(masses).for_each(|(n, mass)| add(n, mass));
                }
            }
            let element = &mesh.elements[element];
            if element.kind != ElementKind::Rax2 {
                continue;
            }
            let ends = [element.nodes[0], element.nodes[1]];
            let Some(facet) = Facet::new(mesh.points[ends[0]], mesh.points[ends[1]], true) else { continue };
            let [low, high] = facet.lumped_mass(rigid.density, rigid.thickness);
            let first_is_low = facet.low == mesh.points[ends[0]];
            add(ends[0], if first_is_low { low } else { high });
            add(ends[1], if first_is_low { high } else { low });
        }
        for point in &self.model.discrete.masses {
            add(point.node, point.mass);
        }
        nodes.iter().copied().zip(masses).filter(|m| m.1 != 0.0).collect()
    }

    fn initial_velocities(&mut self) {
        for condition in &self.model.initial_conditions {
            let of_solid = condition.members.iter().any(|m| self.places.has_node(*m)) || self.is_of_solid(condition);
            if of_solid && !self.names_reference(condition) {
                continue;
            }
            let InitialKind::Velocity(dof, value) = condition.kind else {
                self.unused(condition.span, "*INITIAL CONDITIONS", "rigid bodies have no temperature or stress");
                continue;
            };
            if dof != 2 {
                if self.starts_in_space(&condition.members) {
                    self.cause(
                        condition.span,
                        "initial velocity",
                        1,
                        "bodies",
                        format!("{} = {value}", ALONG[usize::from(dof) - 1]),
                    );
                } else {
                    self.radial_velocity(condition.span, value);
                }
                continue;
            }
            let moved: Vec<usize> =
                (0..self.bodies.len()).filter(|&b| condition.members.contains(&self.bodies[b].reference)).collect();
            if moved.is_empty() {
                let message = "this initial velocity is given for no reference node, so nothing starts with it";
                let finding = Diagnostic::warning("P104", message).at(condition.span, "no reference node among these");
                self.diagnostics.push(finding.help("give the velocity of a rigid body on its REF NODE"));
                continue;
            }
            if value != 0.0 {
                self.cause(condition.span, "initial velocity", moved.len(), "bodies", format!("v_z = {value}"));
            }
            for body in moved {
                self.bodies[body].initial_velocity = value;
            }
        }
    }

    /// Whether a reference node is among those that start with a velocity along z.
    fn names_reference(&self, condition: &InitialCondition) -> bool {
        matches!(condition.kind, InitialKind::Velocity(2, _))
            && self.bodies.iter().any(|b| condition.members.contains(&b.reference))
    }

    fn is_of_solid(&self, condition: &InitialCondition) -> bool {
        let kinds = |kind: &InitialKind| match kind {
            InitialKind::Stress(_) | InitialKind::Energy(_) | InitialKind::Hardening(_) | InitialKind::State(_) => true,
            InitialKind::Velocity(..) | InitialKind::Temperature(_) | InitialKind::Field(..) => false,
        };
        kinds(&condition.kind) && condition.members.iter().any(|e| self.places.elements.contains_key(e))
    }

    fn radial_velocity(&mut self, span: Span, value: f64) {
        if value == 0.0 {
            self.unused(span, "*INITIAL CONDITIONS", "a rigid body of revolution moves along z only");
        } else {
            let message = "a rigid body of revolution cannot start with a radial velocity or a rotation";
            let finding = Diagnostic::error("P103", message).at(span, "only degree of freedom 2 (z) can move");
            self.diagnostics.push(finding.help("*ATTITUDE gives a body that starts so six degrees of freedom"));
        }
    }

    /// Refuses what neither moves with a rigid body nor deforms.
    pub(super) fn refuse_strays(&mut self) {
        self.refuse_stray_elements();
        self.refuse_free_masses();
    }

    fn refuse_stray_elements(&mut self) {
        // Elements of a section that was refused have a section.
        let in_section: HashSet<usize> = self.model.made_of().flat_map(|s| s.1).copied().collect();
        let free = |e: &usize| !self.body_of_element.contains_key(e) && !in_section.contains(e);
        let mesh = &self.model.mesh;
        let first = (0..mesh.elements.len()).find(|e| !mesh.elements[*e].kind.is_discrete() && free(e));
        let Some(first) = first else { return };
        let element = &mesh.elements[first];
        let (message, help) = if element.kind == ElementKind::Rax2 {
            ("RAX2 elements belong to no rigid body", "name their element set on *RIGID BODY, ELSET=")
        } else if element.kind == ElementKind::Sax1 {
            ("shells have no section", "name their element set on *SHELL SECTION, or on *RIGID BODY")
        } else {
            ("solid elements have no section", "name their element set on *SOLID SECTION, or on *RIGID BODY")
        };
        let label = format!("element {} and others", element.name);
        self.diagnostics.push(Diagnostic::error("P001", message).at(element.span, label).help(help));
    }

    fn refuse_free_masses(&mut self) {
        for point in &self.model.discrete.masses {
            if !self.body_of_node.contains_key(&point.node) && !self.places.has_node(point.node) {
                let name = &self.model.mesh.node_names[point.node];
                let message = format!("the mass on node {name} belongs to no rigid body");
                let finding = Diagnostic::error("P005", message).at(point.span, "here");
                self.diagnostics.push(finding.help("put it on the reference node of a *RIGID BODY"));
            }
        }
    }

    /// A free body needs mass; one whose axial motion is prescribed in every step needs none.
    fn check_masses(&mut self) {
        for body in &self.bodies {
            let held = |b: &crate::model::Boundary| b.dof == 2 && b.nodes.contains(&body.reference);
            let free = self.model.steps.iter().any(|s| !s.boundaries.iter().any(held));
            let mass = body.mass();
            if free && !(mass > 0.0 && mass.is_finite()) {
                let message = format!("rigid body `{}` has no mass", body.name);
                let finding = Diagnostic::error("P002", message).at(body.span, format!("its mass is {mass}"));
                let help = "give DENSITY= and a thickness on the data line, *SOLID SECTION to solids, or *MASS on the reference node";
                self.diagnostics.push(finding.help(help));
            }
        }
    }
}
