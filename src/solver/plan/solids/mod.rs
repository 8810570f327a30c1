//! Deformable solids of the plan: element groups from sections, nodal masses, initial conditions.

pub(crate) mod averaging;
pub(crate) mod cohesive;
pub(crate) mod erosion;
pub(crate) mod mass_scaling;
pub(crate) mod shells;
pub(crate) mod soft_material;
pub(crate) mod solid_material;
pub(crate) mod ties;
pub(crate) mod user_material;

use std::collections::HashMap;

use crate::deck::{Diagnostic, Span};
use crate::element::damping::{RayleighDamping, RayleighFactors};
use crate::element::distortion::DistortionControl;
use crate::element::elements::Elements;
use crate::element::frequency::HighestFrequency;
use crate::element::group::ElementGroup;
use crate::element::lengths::UserLengthElements;
use crate::element::rings::RingFactors;
use crate::element::solid_groups::Connectivity;
use crate::kernel::quad;
use crate::kernel::topology::ElementTopology;
use crate::mesh::gather::NodalAssembly;
use crate::model::{
    EosKind, FailureCriterion, IncrementControl, InitialCondition, InitialKind, MaterialDefinition,
    RayleighCoefficients, SolidSection, Step,
};
use crate::plan::meshes::numbering;
use crate::plan::solids::user_material::calls_routines_at_points;
use crate::plan::{Compiler, MeshIndexMap, State};
use crate::state::EffectId;
use crate::state::dofs::Dofs;
use crate::state::nodes::{Node, Nodes};
use crate::variables::Variable;

/// Solver indices of the deformable nodes and elements of the mesh.
#[derive(Clone, Debug, Default)]
pub struct SolidPlaces {
    /// Solver node of each mesh node.
    pub nodes: MeshIndexMap<usize>,
    /// Group and index in the group of each mesh element.
    pub elements: MeshIndexMap<(usize, usize)>,
    /// Rigid body of the mesh nodes that are tied to one.
    pub tied: MeshIndexMap<usize>,
    /// Index of the rotation in the list of solver nodes, for mesh nodes of shells.
    pub rotations: MeshIndexMap<usize>,
}

impl SolidPlaces {
    /// Returns the heap size in bytes.
    pub fn bytes(&self) -> usize {
        self.nodes.bytes() + self.elements.bytes() + self.tied.bytes() + self.rotations.bytes()
    }

    /// Returns whether a mesh node belongs to a deformable body and is not tied to a rigid body.
    pub fn has_node(&self, node: usize) -> bool {
        self.free_node(node).is_some()
    }

    /// Returns the solver node of a mesh node; `None` if it is tied to a rigid body or not deformable.
    pub fn free_node(&self, node: usize) -> Option<usize> {
        self.nodes.get(&node).copied().filter(|_| !self.tied.contains_key(&node))
    }
}

impl Compiler<'_> {
    /// Sets the places of the elements of a group, and returns its ledger row.
    fn place_elements(&mut self, elements: &[usize], group: usize, row: (Span, &'static str)) -> EffectId {
        for (i, &e) in elements.iter().enumerate() {
            self.places.elements.insert(e, (group, i));
        }
        self.ledger_rows.get(&row).copied().unwrap_or_default()
    }

    /// Creates the nodes and element groups of all deformable bodies; empty if there are none.
    pub(crate) fn solids(&mut self) -> State {
        let model = self.model;
        let of_section = |s| self.by_topology(self.ordered(s)).into_iter().map(move |elements| (s, elements));
        let sections: Vec<(&SolidSection, Vec<usize>)> = model.sections.iter().flat_map(of_section).collect();
        let (shells, interfaces) = (self.free_shells(), self.cohesive_sections());
        if sections.is_empty() && shells.is_empty() && interfaces.is_empty() {
            return State::default();
        }
        let lists = sections.iter().map(|s| &s.1).chain(shells.iter().map(|s| &s.1));
        let mut nodes = self.place_nodes(lists.chain(interfaces.iter().map(|s| &s.1)));
        self.place_rotations(&shells, &mut nodes);
        let count = sections.iter().map(|s| s.1.len()).chain(shells.iter().map(|s| s.1.len())).sum();
        self.places.elements = MeshIndexMap::with_capacity(count);
        let mut mass = vec![0.0; nodes.len()];
        let (mut groups, mut ids): (Vec<Box<dyn ElementGroup>>, Vec<_>) = Default::default();
        let (mut controlled, mut damped, mut averagings, mut lengths) = <(Vec<_>, Vec<_>, Vec<_>, Vec<_>)>::default();
        for (section, elements) in &sections {
            let Some(list) = self.connectivity(elements, &nodes) else { continue };
            let Some(group) = self.group(section, elements, &list, &nodes, &mut mass) else { continue };
            ids.push(self.place_elements(elements, groups.len(), (section.span, "deformable elements")));
            controlled.extend(self.distortion_control(section, elements.len()).map(|ratio| (groups.len(), ratio)));
            damped.push(self.damping(section, elements.len()));
            averagings.push(self.averaging(section, list.quadrilaterals()));
            lengths.extend(self.lengths_at_start(section, elements, groups.len()));
            groups.push(group);
        }
        for (section, elements) in &shells {
            let Some(group) = self.shells(section, elements, &nodes, &mut mass) else { continue };
            ids.push(self.place_elements(elements, groups.len(), (section.span, "shells")));
            groups.push(group);
        }
        for (section, elements) in &interfaces {
            let Some(group) = self.cohesive_group(section, elements, &nodes, &mut mass) else { continue };
            ids.push(self.place_elements(elements, groups.len(), (section.span, "cohesive elements")));
            groups.push(group);
        }
        self.check_steps_alike();
        self.point_masses(&mut mass);
        self.tie(&mut mass);
        let listed = groups.iter().map(|g| (g.topology().force_blocks(), (0..g.len()).map(|e| g.nodes(e))));
        let gather = NodalAssembly::new(nodes.len(), &listed.collect::<Vec<_>>());
        let mut elements = Elements::new(groups, ids, gather, nodes.len());
        elements.lengths = lengths;
        let nodes = Nodes::new(nodes, mass);
        for (group, ratio) in controlled {
            let control = elements.distortion.get_or_insert_with(Box::<DistortionControl>::default);
            let controlled = &elements.groups[group];
            let cells = (0..controlled.len()).flat_map(|e| controlled.cells(e).map(move |cell| (e, cell)));
            control.add(group, cells, &nodes, ratio);
        }
        if averagings.iter().any(Option::is_some) {
            elements.averagings = averagings;
        }
        if damped.iter().any(|factors: &RayleighFactors| factors.mass > 0.0 || factors.stiffness > 0.0) {
            let linear = self.model.steps.iter().map(|s| s.bulk_viscosity.linear).fold(0.0, f64::max);
            elements.damping = Some(Box::new(RayleighDamping::new(damped, linear, &elements.groups, nodes.len())));
        }
        if sections.iter().any(|(s, _)| s.controls.by_area) {
            elements.rings = Some(Box::new(RingFactors::new(&elements.groups, nodes.len())));
        }
        let mut state = State { dofs: Dofs { nodes, ..Dofs::default() }, elements, ..State::default() };
        self.start_solid(&mut state);
        self.start_temperatures(&mut state.elements.groups);
        self.start_fields(&mut state);
        self.note_unused_rate_dependence();
        state
    }

    /// Lists `*RATE DEPENDENT` of materials without a yield stress as unused.
    fn note_unused_rate_dependence(&mut self) {
        let model = self.model;
        let yields = |m: &MaterialDefinition| m.plastic.is_some() || m.foam.shape.is_some();
        for material in model.materials.iter().filter(|m| m.rate.is_some() && !yields(m) && m.user.material.is_none()) {
            self.add_unused_card(material.span, "*RATE DEPENDENT", "the material has no *PLASTIC");
        }
    }

    /// Creates the solver nodes of deformable elements, including those shared with rigid bodies.
    fn place_nodes<'e>(&mut self, sections: impl Iterator<Item = &'e Vec<usize>>) -> Vec<Node> {
        let mesh = &self.model.mesh;
        self.places.nodes = numbering::nodes(sections.flatten().copied(), self.linked_nodes(), mesh);
        self.places.tied = self.places.nodes.keys().filter_map(|n| Some((n, *self.body_of_node.get(&n)?))).collect();
        let mut nodes = vec![Node::default(); self.places.nodes.len()];
        for (n, &place) in self.places.nodes.iter() {
            nodes[place] = Node { r: mesh.points[n][0], z: mesh.points[n][1], ..Node::default() };
        }
        nodes
    }

    /// Returns the damping factors of a section; zeros without damping.
    fn damping(&mut self, section: &SolidSection, count: usize) -> RayleighFactors {
        let material = &self.model.materials[section.material];
        let Some(RayleighCoefficients { alpha, beta, span }) = material.damping else {
            return RayleighFactors::default();
        };
        if section.controls.by_area {
            let message = "WEIGHTING=AREA with *DAMPING is not supported";
            self.diagnostics.push(Diagnostic::error("P050", message).at(section.span, "this section"));
        }
        let moduli = match material.elastic {
            Some([young, poisson]) => [young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))],
            None => [0.0; 2],
        };
        if beta > 0.0 && material.elastic.is_none() {
            let message = format!("BETA of *DAMPING requires *ELASTIC, and material {} has none", material.name);
            let help = "use ALPHA, or *BULK VISCOSITY";
            self.diagnostics.push(Diagnostic::error("P051", message).at(span, "here").help(help));
        }
        if alpha > 0.0 {
            self.ledger_row(span, "mass proportional damping", count, "elements", format!("alpha = {alpha}"));
        }
        if beta > 0.0 {
            self.ledger_row(span, "stiffness proportional damping", count, "elements", format!("beta = {beta}"));
        }
        RayleighFactors { mass: alpha, stiffness: beta, moduli }
    }

    /// Returns the elements of built-in materials whose characteristic length is user-defined (VUCHARLENGTH).
    fn lengths_at_start(&self, section: &SolidSection, elements: &[usize], group: usize) -> Option<UserLengthElements> {
        let material = &self.model.materials[section.material];
        let (properties, _) = material.user.lengths.as_ref()?;
        let evolves = material.failures.iter().any(FailureCriterion::takes_length);
        (evolves && !calls_routines_at_points(material)).then(|| UserLengthElements {
            group,
            name: material.name.clone(),
            properties: properties.clone(),
            elements: elements.iter().map(|&e| self.model.mesh.elements[e].name.to_string()).collect(),
        })
    }

    /// Returns LENGTH RATIO of a section with distortion control.
    fn distortion_control(&mut self, section: &SolidSection, count: usize) -> Option<f64> {
        let ratio = section.controls.distortion?;
        self.ledger_row(section.span, "distortion control", count, "elements", format!("length ratio {ratio}"));
        Some(ratio)
    }

    /// Returns whether the analysis is adiabatic. All steps have the same setting as the first one.
    pub(crate) fn adiabatic(&self) -> bool {
        self.model.steps.first().is_some_and(|s| s.adiabatic)
    }

    /// Returns whether a section solves for nodal temperatures.
    pub(crate) fn conducts(&self, section: &SolidSection) -> bool {
        let thermal = |e: &usize| self.model.mesh.elements[*e].kind.is_thermal();
        self.model.steps.first().is_some_and(|s| s.coupled) && section.elements.iter().any(thermal)
    }

    /// Creates the global estimate of the stable time increment, unless all steps use ELEMENT BY ELEMENT.
    pub(crate) fn highest_frequency(&mut self, state: &mut State) {
        let asks = |s: &&Step| matches!(s.increment, IncrementControl::Automatic { element_by_element: false, .. });
        let Some(step) = self.model.steps.iter().find(asks) else { return };
        if self.model.steps.iter().any(|s| !s.mass_scalings.is_empty()) {
            self.add_unused_card(
                step.span,
                "global estimate of the stable increment",
                "with mass scaling the estimate is element by element",
            );
            return;
        }
        if self.model.steps.iter().any(|s| !s.adaptive.is_empty()) {
            self.add_unused_card(
                step.span,
                "global estimate of the stable increment",
                "with adaptive meshes the estimate is element by element",
            );
            return;
        }
        let Some(mut frequency) = HighestFrequency::new(&state.elements.groups, &state.dofs.nodes) else {
            let why = if !self.model.cohesive_sections.is_empty() {
                "with cohesive elements the estimate is element by element"
            } else if self.places.rotations.is_empty() {
                "a material is not linear elastic at small strains; the estimate is element by element"
            } else {
                "with shells the estimate is element by element"
            };
            self.add_unused_card(step.span, "global estimate of the stable increment", why);
            return;
        };
        let detail = "highest frequency by the Lanczos method, if below the element estimate";
        let count = state.dofs.nodes.len();
        frequency.id = self.ledger_row(step.span, "global estimate", count, "nodes", detail.into());
        state.elements.frequency = Some(Box::new(frequency));
    }

    /// Checks that step settings that elements take from the first step do not change.
    fn check_steps_alike(&mut self) {
        let Some(first) = self.model.steps.first() else { return };
        for step in &self.model.steps {
            let heat = (step.adiabatic, step.coupled) != (first.adiabatic, first.coupled);
            if step.bulk_viscosity != first.bulk_viscosity || heat {
                let message =
                    "bulk viscosity, ADIABATIC and the solution for temperatures must be the same in all steps";
                let finding = Diagnostic::error("P015", message).at(step.span, "this step differs from the first");
                self.diagnostics.push(finding.help("a change between steps is not supported"));
            }
        }
    }

    /// Returns the deformable elements of a section in solver order. For user subroutines this is the order of the
    /// deck.
    fn ordered(&self, section: &SolidSection) -> Vec<usize> {
        let elements = self.free_elements(section);
        let shown = calls_routines_at_points(&self.model.materials[section.material]);
        if shown { elements } else { numbering::in_order(elements, &self.model.mesh) }
    }

    fn free_elements(&self, section: &SolidSection) -> Vec<usize> {
        section.elements.iter().copied().filter(|e| !self.body_of_element.contains_key(e)).collect()
    }

    /// Splits elements into lists of one topology.
    fn by_topology(&self, elements: Vec<usize>) -> Vec<Vec<usize>> {
        let is_triangle =
            |e: &usize| self.model.mesh.elements[*e].kind.topology() == Some(ElementTopology::SixNodeTriangle);
        let (triangles, others): (Vec<usize>, Vec<usize>) = elements.into_iter().partition(is_triangle);
        [others, triangles].into_iter().filter(|list| !list.is_empty()).collect()
    }

    /// Returns the solver nodes of elements of one topology. An element without positive volume is an error.
    fn connectivity(&mut self, elements: &[usize], nodes: &[Node]) -> Option<Connectivity> {
        let mesh = &self.model.mesh;
        let node = |n: usize| self.places.nodes[&n] as u32;
        for &e in elements {
            let element = &mesh.elements[e];
            let volumes = mesh.cells(e).map(|cell| quad::volume(cell.map(|n| nodes[node(n) as usize].place())));
            let volume = volumes.fold(f64::INFINITY, |least, v| if v > least { least } else { v });
            if volume.is_nan() || volume <= 0.0 {
                let message = format!("element {} has volume {volume:e}", element.name);
                let finding = Diagnostic::error("P012", message).at(element.span, "this element");
                self.diagnostics.push(finding.help("number its nodes counter-clockwise in the r-z plane, with r >= 0"));
                return None;
            }
        }
        let kind = mesh.elements[*elements.first()?].kind;
        Some(if kind.topology() == Some(ElementTopology::SixNodeTriangle) {
            let around = |&e: &usize| Some(mesh.elements[e].nodes.first_chunk::<6>()?.map(node));
            Connectivity::SixNodeTriangles(elements.iter().filter_map(around).collect())
        } else {
            let mut cells = Vec::with_capacity(elements.len());
            cells.extend(elements.iter().flat_map(|&e| mesh.cells(e)).map(|cell| cell.map(node)));
            Connectivity::Quadrilaterals(cells)
        })
    }

    fn point_masses(&mut self, mass: &mut [f64]) {
        for point in &self.model.discrete.masses {
            if let Some(n) = self.places.free_node(point.node) {
                mass[n] += point.mass;
            }
        }
    }

    /// Warns of elements of an ideal gas with an initial energy and an initial temperature.
    fn check_gas_states(&mut self) {
        let model = self.model;
        let conditions = || model.initial_conditions.iter();
        let is_gas = |section: &SolidSection| matches!(&model.materials[section.material].eos, Some(eos) if matches!(eos.kind, EosKind::IdealGas(_)));
        let gas: Vec<usize> = model.sections.iter().filter(|s| is_gas(s)).flat_map(|s| s.elements.clone()).collect();
        for energy in conditions().filter(|c| matches!(c.kind, InitialKind::Energy(_)) && !gas.is_empty()) {
            let both = |heat: &&InitialCondition| {
                let warm =
                    |e: &usize| model.mesh.elements[*e].nodes.iter().all(|n| heat.members.binary_search(n).is_ok());
                matches!(heat.kind, InitialKind::Temperature(_))
                    && gas.iter().any(|e| energy.members.binary_search(e).is_ok() && warm(e))
            };
            if let Some(heat) = conditions().find(both) {
                let message = "an ideal gas has an initial specific energy and an initial temperature, of which one \
                               follows from the other; the later condition replaces the earlier one";
                let finding = Diagnostic::warning("P017", message).at(energy.span, "the energy");
                self.diagnostics.push(finding.at(heat.span, "the temperature").help("remove one of the conditions"));
                return;
            }
        }
    }

    /// Sets the initial temperatures of elements to the means of their nodes. An element without a temperature at all
    /// nodes keeps its default.
    fn start_temperatures(&self, groups: &mut [Box<dyn ElementGroup>]) {
        let mut nodal: HashMap<usize, f64> = HashMap::new();
        for condition in &self.model.initial_conditions {
            if let InitialKind::Temperature(value) = condition.kind {
                nodal.extend(condition.members.iter().map(|n| (*n, value)));
            }
        }
        if nodal.is_empty() {
            return;
        }
        let mut values = Vec::new();
        for (e, &(group, i)) in self.places.elements.iter() {
            let nodes = &self.model.mesh.elements[e].nodes;
            values.clear();
            values.extend(nodes.iter().filter_map(|n| nodal.get(n)));
            if values.len() == nodes.len() {
                // The mean of equal values has their bits.
                let is_uniform = values.iter().all(|v| *v == values[0]);
                let mean = if is_uniform { values[0] } else { values.iter().sum::<f64>() / values.len() as f64 };
                groups[group].extensions().initial_state().set(i, None, Some(mean));
            }
        }
    }

    /// Sets the initial velocities, stresses, energies and state variables.
    fn start_solid(&mut self, state: &mut State) {
        self.check_gas_states();
        let (nodes, groups) = (&mut state.dofs.nodes, &mut state.elements.groups);
        for condition in &self.model.initial_conditions {
            match &condition.kind {
                InitialKind::Velocity(dof, value) if *dof <= 2 => {
                    for n in condition.members.iter().filter_map(|n| self.places.free_node(*n)) {
                        *nodes[n].velocity(usize::from(*dof) - 1) = *value;
                    }
                }
                InitialKind::Velocity(6, value) => {
                    for n in condition.members.iter().filter_map(|n| self.places.rotations.get(n)) {
                        *nodes[*n].velocity(0) = *value;
                    }
                }
                InitialKind::Velocity(..) => {}
                // Set in `start_temperatures`: elements have the mean values of their nodes.
                InitialKind::Temperature(_) => {}
                InitialKind::Energy(value) => {
                    for (group, i) in condition.members.iter().filter_map(|e| self.places.elements.get(e)) {
                        if groups[*group].value(*i, Variable::SpecificEnergy.into()).is_none() {
                            let message = "TYPE=SPECIFIC ENERGY needs a material with *EOS";
                            self.diagnostics.push(Diagnostic::error("P017", message).at(condition.span, "here"));
                            break;
                        }
                        groups[*group].extensions().initial_state().set_energy(*i, *value);
                    }
                }
                InitialKind::Hardening(value) => {
                    let mut elements = condition.members.iter().filter_map(|e| self.places.elements.get(e));
                    let set = |(group, i): &(usize, usize)| {
                        groups[*group].extensions().initial_state().set_plastic_strain(*i, *value)
                    };
                    if !elements.all(set) {
                        let message = "TYPE=HARDENING needs solid elements with *PLASTIC and isotropic hardening";
                        self.diagnostics.push(Diagnostic::error("P017", message).at(condition.span, "here"));
                    }
                }
                InitialKind::State(values) => {
                    for (group, i) in condition.members.iter().filter_map(|e| self.places.elements.get(e)) {
                        let state = groups[*group].extensions().initial_state();
                        let mut kept = values.iter().enumerate().map(|(v, x)| state.set_state(*i, v, *x) || *x == 0.0);
                        if !kept.all(|kept| kept) {
                            let message = format!(
                                "{} state variables are given, but the material of some elements has fewer \
                                 (*DEPVAR)",
                                values.len()
                            );
                            self.diagnostics.push(Diagnostic::error("P017", message).at(condition.span, "here"));
                            break;
                        }
                    }
                }
                // Set in `start_fields`: elements have the mean values of their nodes.
                InitialKind::Field(..) => {}
                InitialKind::Stress(values) => {
                    let eos = |&&(group, _): &&(usize, usize)| groups[group].properties().holds_pressure;
                    if condition.members.iter().filter_map(|e| self.places.elements.get(e)).find(eos).is_some() {
                        let message = "an initial stress cannot be prescribed: the stress follows from density and energy, or from the deformation";
                        let finding = Diagnostic::error("P017", message).at(condition.span, "this initial stress");
                        self.diagnostics
                            .push(finding.help("give TYPE=SPECIFIC ENERGY, or a temperature of an ideal gas"));
                        continue;
                    }
                    let stress = [0, 1, 2, 3].map(|i| values.get(i).copied().unwrap_or(0.0));
                    for (group, i) in condition.members.iter().filter_map(|e| self.places.elements.get(e)) {
                        groups[*group].extensions().initial_state().set(*i, Some(stress), None);
                    }
                }
            }
        }
    }
}
