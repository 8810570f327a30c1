//! Adaptive meshes of the plan: domains, the nodes that they do not move, and combinations that are not supported.

use std::collections::HashSet;

use super::{Compiler, State};
use crate::adaptive::smoothing::SmoothingWeights;
use crate::adaptive::transport::TransportOrder;
use crate::adaptive::{AdaptiveDomain, AdaptiveSettings};
use crate::deck::{Diagnostic, Span};
use crate::kernel::topology::ElementTopology;
use crate::model::{AdaptiveMesh, LoadKind, MotionKind, Step};

impl<'a> Compiler<'a> {
    /// Creates the domains of a step; `None` if those of the previous step continue.
    pub(super) fn adaptive_change(&mut self, index: usize, state: &mut State) -> Option<Vec<AdaptiveDomain>> {
        let step = &self.model.steps[index];
        let before = index.checked_sub(1).map(|i| &self.model.steps[i]);
        // Loaded and bonded nodes follow the material.
        let heated = |step: &'a Step| heated_nodes(step).collect::<Vec<usize>>();
        let causes = |step: &'a Step| (&step.adaptive, &step.adaptive_fixed, &step.loads, heated(step));
        let unchanged = before.is_some_and(|before| {
            causes(before) == causes(step) && self.cohesive_nodes(index - 1).eq(self.cohesive_nodes(index))
        });
        let absent = step.adaptive.is_empty() && before.is_none_or(|before| before.adaptive.is_empty());
        if unchanged || absent {
            return None;
        }
        // A domain of the same set continues that of the previous step.
        for mesh in &step.adaptive {
            let continued = before.and_then(|before| before.adaptive.iter().find(|domain| domain.set == mesh.set));
            if let Some(domain) = continued {
                self.share_ledger_rows(domain.span, mesh.span);
            }
        }
        let mut taken = HashSet::new();
        Some(step.adaptive.iter().filter_map(|mesh| self.adaptive_domain(mesh, index, state, &mut taken)).collect())
    }

    fn adaptive_domain(
        &mut self,
        mesh: &AdaptiveMesh,
        step: usize,
        state: &mut State,
        taken: &mut HashSet<usize>,
    ) -> Option<AdaptiveDomain> {
        let places: Vec<(usize, usize)> =
            mesh.elements.iter().filter_map(|e| self.places.elements.get(e).copied()).collect();
        let Some(&(group, _)) = places.first() else {
            self.add_unused_card(mesh.span, "adaptive mesh", "none of its elements is deformable");
            return None;
        };
        if let Some((message, help)) = self.unsupported_domain(mesh, &places, state, taken) {
            self.refuse_domain(mesh.span, message, help);
            return None;
        }
        let mut elements: Vec<u32> = places.iter().map(|(_, e)| *e as u32).collect();
        elements.sort_unstable();
        elements.dedup();
        let fixed = self.nodes_fixed_in(group, &elements, step, state);
        let detail = self.adaptive_detail(mesh);
        let id = self.ledger_row(mesh.span, "adaptive mesh", elements.len(), "elements", detail);
        let of_group = &mut *state.elements.groups[group];
        let domain = AdaptiveDomain::new(id, settings(mesh), (group, of_group), elements, (&state.dofs.nodes, &fixed));
        if domain.is_none() {
            let message = "moduli that depend on field variables, WEIGHTING=AREA and SUBZONAL=YES are not supported in \
                           adaptive meshes";
            self.refuse_domain(
                mesh.span,
                message.into(),
                "use another material or other section controls, or no adaptive mesh",
            );
        }
        let heat = state.thermal.as_ref().and_then(|thermal| thermal.heat.as_ref());
        let conducts = heat.is_some_and(|heat| heat.conducts(group));
        domain.map(|domain| if conducts { domain.with_temperatures() } else { domain })
    }

    /// Returns why a domain is not supported, and what would be.
    fn unsupported_domain(
        &self,
        mesh: &AdaptiveMesh,
        places: &[(usize, usize)],
        state: &State,
        taken: &mut HashSet<usize>,
    ) -> Option<(String, &'static str)> {
        let group = places[0].0;
        if places.iter().any(|(g, _)| *g != group) {
            let message = format!("the elements of `{}` belong to several sections", mesh.set);
            return Some((message, "give one *ADAPTIVE MESH for the elements of each section"));
        }
        let is_supported =
            |&(g, _): &(usize, usize)| state.elements.groups[g].topology() == ElementTopology::Quadrilateral;
        if !places.iter().all(is_supported) {
            let message = format!("`{}` contains elements other than CAX4R, CAX4RT, CAX3 and CAX3T", mesh.set);
            return Some((message, "give a set of CAX4R, CAX4RT, CAX3 or CAX3T elements"));
        }
        if mesh.elements.iter().any(|e| !taken.insert(*e)) {
            let message = format!("elements of `{}` belong to two adaptive meshes", mesh.set);
            return Some((message, "give each element to one domain"));
        }
        if self.model.steps.iter().any(|step| !step.mass_scalings.is_empty()) {
            let message = "adaptive meshes cannot be combined with mass scaling".into();
            return Some((message, "remove one of the two"));
        }
        if state.elements.distortion.is_some() {
            let message = "adaptive meshes cannot be combined with DISTORTION CONTROL".into();
            return Some((message, "remove DISTORTION CONTROL from *SECTION CONTROLS; the mesh stays undistorted"));
        }
        if state.elements.fields.is_some() {
            let message = "adaptive meshes cannot be combined with prescribed field variables".into();
            return Some((message, "remove *FIELD: field variables of nodes do not follow a mesh that moves"));
        }
        None
    }

    fn refuse_domain(&mut self, span: Span, message: String, help: &str) {
        self.diagnostics.push(Diagnostic::error("P071", message).at(span, "this domain").help(help));
    }

    /// Returns whether each node moves with the material: nodes of other elements, linked, loaded and bonded nodes,
    /// those of `*ADAPTIVE MESH CONSTRAINT`, and nodes of elements at linked nodes, whose masses must not change.
    fn nodes_fixed_in(&self, group: usize, elements: &[u32], step: usize, state: &State) -> Vec<bool> {
        let count = state.dofs.nodes.len();
        let mut fixed = vec![false; count];
        let own: HashSet<u32> = elements.iter().copied().collect();
        let groups = &state.elements.groups;
        for (g, other) in groups.iter().enumerate() {
            for e in (0..other.len()).filter(|e| g != group || !own.contains(&(*e as u32))) {
                other.nodes(e).into_iter().for_each(|n| fixed[n as usize] = true);
            }
        }
        let linked = self.unscaled_nodes(count);
        for e in elements {
            let nodes = groups[group].nodes(*e as usize);
            if nodes.into_iter().any(|n| linked.get(n as usize) == Some(&true)) {
                nodes.into_iter().for_each(|n| fixed[n as usize] = true);
            }
        }
        for node in self.nodes_with_loads(&self.model.steps[step]).into_iter().chain(self.cohesive_nodes(step)) {
            if let Some(place) = self.places.nodes.get(&node) {
                fixed[*place] = true;
            }
        }
        fixed
    }

    /// Returns the nodes of the model with concentrated loads, temperatures and masses, those at the ends of loaded surfaces, and those of
    /// `*ADAPTIVE MESH CONSTRAINT`.
    fn nodes_with_loads(&self, step: &Step) -> Vec<usize> {
        let mut nodes: Vec<usize> = step.adaptive_fixed.iter().flat_map(|(_, nodes)| nodes).copied().collect();
        for load in &step.loads {
            if let LoadKind::Concentrated { nodes: loaded, .. } = &load.kind {
                nodes.extend(loaded);
            }
            let faces = load.kind.sides().into_iter().flat_map(|sides| &sides.faces);
            let mut ends: HashSet<usize> = HashSet::new();
            for node in faces.filter_map(|(e, side)| self.model.mesh.side_nodes(*e, *side)).flatten() {
                if !ends.remove(&node) {
                    ends.insert(node);
                }
            }
            nodes.extend(ends);
        }
        nodes.extend(heated_nodes(step));
        nodes.extend(self.model.discrete.masses.iter().map(|mass| mass.node));
        nodes
    }

    fn adaptive_detail(&self, mesh: &AdaptiveMesh) -> String {
        let [volumetric, laplacian, equipotential] = mesh.controls.weights;
        let methods = [("volume", volumetric), ("Laplacian", laplacian), ("equipotential", equipotential)];
        let used: Vec<&str> = methods.iter().filter(|m| m.1 > 0.0).map(|m| m.0).collect();
        let order = if mesh.controls.second_order { "second" } else { "first" };
        format!(
            "every {} increments, {} sweeps of {} smoothing, transport of {order} order",
            mesh.frequency,
            mesh.sweeps,
            if mesh.controls.graded { "graded".into() } else { used.join(" and ") }
        )
    }
}

/// Iterates over the nodes with prescribed temperatures and nodal heat sources.
fn heated_nodes(step: &Step) -> impl Iterator<Item = usize> {
    let held = step.boundaries.iter().filter(|boundary| boundary.kind == MotionKind::Temperature);
    let sources = step.loads.iter().filter_map(|load| match &load.kind {
        LoadKind::NodalHeat { nodes, .. } => Some(nodes),
        _ => None,
    });
    held.flat_map(|boundary| &boundary.nodes).chain(sources.flatten()).copied()
}

fn settings(mesh: &AdaptiveMesh) -> AdaptiveSettings {
    let [volumetric, laplacian, equipotential] = mesh.controls.weights;
    AdaptiveSettings {
        frequency: mesh.frequency,
        sweeps: mesh.sweeps,
        initial_sweeps: mesh.initial_sweeps,
        weights: SmoothingWeights { volumetric, laplacian, equipotential },
        graded: mesh.controls.graded,
        corner_angle: mesh.controls.corner_angle,
        order: if mesh.controls.second_order { TransportOrder::Second } else { TransportOrder::First },
    }
}
