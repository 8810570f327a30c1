//! Reads adaptive meshes: `*ADAPTIVE MESH`, `*ADAPTIVE MESH CONTROLS`, `*ADAPTIVE MESH CONSTRAINT` and `*REMESH`.

use super::builder::ModelBuilder;
use super::names::upper;
use super::types::{AdaptiveControls, AdaptiveMesh, Remeshing};
use crate::deck::Card;
use crate::deck::table::adaptive as cards;
use crate::kernel::lists::sorted_unique;
use crate::remesh::sizes::SizeLimits;

impl ModelBuilder<'_> {
    /// Reads the controls of adaptive meshes. Weights are normalised to the sum 1.
    pub(super) fn adaptive_controls(&mut self, card: &Card) {
        let values: cards::AdaptiveMeshControls = self.values(card);
        let sum: f64 = values.weights.iter().sum();
        if sum <= 0.0 {
            return self.out_of_range(card.span, "at least one smoothing method requires a weight above 0");
        }
        let controls = AdaptiveControls {
            weights: values.weights.map(|weight| weight / sum),
            graded: values.graded,
            corner_angle: values.transition_angle.to_radians(),
            second_order: values.second_order,
        };
        self.adaptive_controls.entry(upper(&values.name)).or_insert(controls);
    }

    /// Reads a domain. It replaces a domain of an earlier step with the same set.
    pub(super) fn adaptive_mesh(&mut self, card: &Card) {
        let Some(word) = card.value("ELSET") else { return };
        let Some(elements) = self.element_members(word) else { return };
        let cards::AdaptiveMesh { frequency, sweeps, initial_sweeps, new } = self.values(card);
        let named = card.value("CONTROLS").cloned();
        let state = self.state();
        if new && !state.cleared.contains(&"ADAPTIVE MESH") {
            state.cleared.push("ADAPTIVE MESH");
            state.adaptive.clear();
        }
        let set = upper(&word.text);
        state.adaptive.retain(|domain| domain.set != set);
        if let Some(word) = named {
            state.adaptive_controls_used.push((set.clone(), word));
        }
        let (span, controls, frequency) = (card.span, AdaptiveControls::default(), frequency as u64);
        state.adaptive.push(AdaptiveMesh { span, set, elements, frequency, sweeps, initial_sweeps, controls });
    }

    /// Reads a body that is remeshed.
    pub(super) fn remeshing(&mut self, card: &Card) {
        let Some(word) = card.value("ELSET") else { return };
        let Some(elements) = self.element_members(word) else { return };
        let cards::Remesh {
            angle,
            increment,
            frequency,
            mut size,
            mut curvature_angle,
            mut strain_change,
            mut minimum_size,
        } = self.values(card);
        if minimum_size.is_some() && curvature_angle.is_none() && strain_change.is_none() {
            self.out_of_range(card.span, "MINIMUM SIZE requires CURVATURE ANGLE or STRAIN CHANGE");
        }
        // Lengths of edges, and what they are computed from, follow a refined or coarsened mesh.
        if let Some(scaling) = self.deck.mesh_scaling {
            let lengths = [("SIZE", &mut size), ("MINIMUM SIZE", &mut minimum_size)];
            let ratios = [("CURVATURE ANGLE", &mut curvature_angle), ("STRAIN CHANGE", &mut strain_change)];
            for (key, value) in lengths.into_iter().chain(ratios) {
                if let (Some(value), Some(word)) = (value, card.value(key)) {
                    *value *= scaling.edge_factor();
                    self.edit_number(word, *value);
                }
            }
        }
        let (span, set, angle, frequency) = (card.span, upper(&word.text), angle.to_radians(), frequency as u64);
        let elements = sorted_unique(elements);
        let curvature_angle = curvature_angle.map(f64::to_radians);
        let limits = SizeLimits { curvature_angle, strain_change, smallest: minimum_size };
        self.model.remeshings.push(Remeshing { span, set, elements, angle, increment, frequency, size, limits });
    }

    /// Reads nodes that move with the material.
    pub(super) fn adaptive_constraint(&mut self, card: &Card) {
        let cards::AdaptiveMeshConstraint { new } = self.values(card);
        let mut nodes = Vec::new();
        for line in &card.lines {
            if let Some(word) = line.fields.first() {
                nodes.extend(self.node_members(word).into_iter().flatten());
            }
        }
        let state = self.state();
        if new && !state.cleared.contains(&"ADAPTIVE MESH CONSTRAINT") {
            state.cleared.push("ADAPTIVE MESH CONSTRAINT");
            state.adaptive_fixed.clear();
        }
        state.adaptive_fixed.push((card.span, nodes));
    }

    /// Assigns controls to the domains of the step.
    pub(super) fn apply_adaptive_controls(&mut self) {
        let used = self.step.iter_mut().flat_map(|state| std::mem::take(&mut state.adaptive_controls_used));
        for (set, word) in used.collect::<Vec<_>>() {
            let Some(controls) = self.adaptive_controls.get(&upper(&word.text)).copied() else {
                self.unknown("M116", "adaptive mesh controls", &word, |b| {
                    b.adaptive_controls.keys().cloned().collect()
                });
                continue;
            };
            let domains = self.step.iter_mut().flat_map(|state| &mut state.adaptive);
            domains.filter(|domain| domain.set == set).for_each(|domain| domain.controls = controls);
        }
    }
}
