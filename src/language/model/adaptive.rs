//! Reads adaptive meshes: `*ADAPTIVE MESH`, `*ADAPTIVE MESH CONTROLS`, `*ADAPTIVE MESH CONSTRAINT`, `*REMESH`
//! and the region types of boundaries.

use super::amplitudes;
use super::budget::BudgetedItem;
use super::context::Context;
use super::families::StepReader;
use super::faults::{ValueCheck, require};
use super::names::upper;
use super::types::{
    AdaptiveControls, AdaptiveMesh, AdaptiveRegion, BoundaryCondition, ElementSide, Load, LoadRegion, MotionKind,
    RegionType, Remeshing,
};
use crate::deck::table::adaptive as cards;
use crate::deck::{Card, DataLine, Diagnostic, Span};
use crate::kernel::lists::sorted_unique;
use crate::kernel::shape::quad_area;
use crate::remesh::MOST_NEW_ELEMENTS;
use crate::remesh::sizes::SizeLimits;

/// Reads the controls of adaptive meshes. Weights are normalised to the sum 1.
pub fn read_adaptive_controls(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let values: cards::AdaptiveMeshControls = card.values();
    let sum: f64 = values.weights.iter().sum();
    if sum <= 0.0 {
        return context.out_of_range(card.span, "at least one smoothing method requires a weight above 0");
    }
    let controls = AdaptiveControls {
        weights: values.weights.map(|weight| weight / sum),
        graded: values.graded,
        corner_angle: values.transition_angle.to_radians(),
        second_order: values.second_order,
        previous: values.previous,
    };
    steps.adaptive_controls.entry(upper(&values.name)).or_insert(controls);
}

/// Reads a domain. It replaces a domain of an earlier step with the same set.
pub fn read_adaptive_mesh(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Some(word) = card.value("ELSET") else { return };
    let Some(elements) = context.element_members(word) else { return };
    let cards::AdaptiveMesh { frequency, sweeps, initial_sweeps } = card.values();
    let named = card.value("CONTROLS").cloned();
    if steps.operation(card, "ADAPTIVE MESH") {
        steps.state().adaptive.clear();
    }
    let set = upper(&word.text);
    steps.note_value(context, card, format!("`{set}`"), card.span);
    let state = steps.state();
    state.adaptive.retain(|domain| domain.set != set);
    if let Some(word) = named {
        state.adaptive_controls_used.push((set.clone(), word));
    }
    let (span, controls) = (card.span, AdaptiveControls::default());
    let frequency = frequency.map(|count| count as u64);
    state.adaptive.push(AdaptiveMesh { span, set, elements, frequency, sweeps, initial_sweeps, controls });
}

/// Returns whether a body has an acceptable number of elements of a size, or reports it.
fn fits_size(context: &mut Context<'_>, elements: &[usize], size: f64, span: Span) -> bool {
    let mesh = &context.model.mesh;
    let solids = elements.iter().filter(|e| mesh.elements[**e].kind.is_solid());
    let areas = solids.flat_map(|e| mesh.initial_cells(*e)).map(|corners| quad_area(corners).abs());
    let count = areas.sum::<f64>() / (size * size);
    if count > MOST_NEW_ELEMENTS {
        let message =
            format!("elements of the size {size} would be {count:.1e}; at most {MOST_NEW_ELEMENTS:.0e} are allowed");
        context.error("M125", message, span, "limit exceeded here");
        return false;
    }
    context.fits_budget(BudgetedItem::Elements, count as u128, span)
}

/// Reads a body that is remeshed.
pub fn read_remesh(context: &mut Context<'_>, card: &Card) {
    let cards::Remesh { keeps_mesh, .. } = card.values();
    if keeps_mesh {
        return read_kept_mesh(context, card);
    }
    let Some(word) = context.required(card, "ELSET") else { return };
    let Some(elements) = context.element_members(word) else { return };
    let cards::Remesh {
        keeps_mesh: _,
        angle,
        increment,
        frequency,
        thickness,
        mut size,
        mut curvature_angle,
        mut strain_change,
        mut minimum_size,
    } = card.values();
    // Lengths of edges, and what they are computed from, follow a refined or coarsened mesh.
    if let Some(scaling) = context.deck.uniform_scaling() {
        let lengths = [("SIZE", &mut size), ("MINIMUM SIZE", &mut minimum_size)];
        let ratios = [("CURVATURE ANGLE", &mut curvature_angle), ("STRAIN CHANGE", &mut strain_change)];
        for (key, value) in lengths.into_iter().chain(ratios) {
            if let (Some(value), Some(word)) = (value, card.value(key)) {
                *value *= scaling.edge_factor();
                context.edit_number(word, *value);
            }
        }
    }
    let (span, set, angle, frequency) = (card.span, upper(&word.text), angle.to_radians(), frequency as u64);
    let elements = sorted_unique(elements);
    let shares = |card: &&Remeshing| card.elements.iter().any(|e| elements.binary_search(e).is_ok());
    if let Some(first) = context.model.remeshings.iter().find(shares) {
        let (message, first) = (format!("elements of `{set}` have two *REMESH cards"), first.span);
        return context.refuse_second(message, [first, span]);
    }
    if let (Some(size), Some(word)) = (size, card.value("SIZE"))
        && !fits_size(context, &elements, size, word.span)
    {
        return;
    }
    let curvature_angle = curvature_angle.map(f64::to_radians);
    let limits = SizeLimits { curvature_angle, strain_change, smallest: minimum_size };
    context.accepts(card, check_size_limits(&limits));
    context.model.remeshings.push(Remeshing {
        span,
        set,
        elements,
        angle,
        increment,
        frequency,
        thickness,
        size,
        limits,
        automatic: false,
        shared: Vec::new(),
    });
}

/// Reads bodies that keep their mesh even if it collapses.
fn read_kept_mesh(context: &mut Context<'_>, card: &Card) {
    let elements = match card.value("ELSET") {
        Some(word) => context.element_members(word).unwrap_or_default(),
        None => (0..context.model.mesh.elements.len()).collect(),
    };
    let kept_meshes = &mut context.model.kept_meshes;
    *kept_meshes = sorted_unique(kept_meshes.drain(..).chain(elements));
}

pub fn check_size_limits(limits: &SizeLimits) -> ValueCheck {
    let varies = limits.curvature_angle.is_some() || limits.strain_change.is_some();
    require(varies || limits.smallest.is_none(), "MINIMUM SIZE requires CURVATURE ANGLE or STRAIN CHANGE")
}

/// Reads nodes that move with the material, and motions of the mesh that are prescribed in space.
pub fn read_adaptive_constraint(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let cards::AdaptiveMeshConstraint { in_space, velocity } = card.values();
    let Ok(amplitude) = amplitudes::amplitude_of(context, card, "AMPLITUDE") else { return };
    if steps.operation(card, "ADAPTIVE MESH CONSTRAINT") {
        steps.state().adaptive_fixed.clear();
        steps.state().mesh_history.boundaries.clear();
    }
    let kind = if velocity { MotionKind::Velocity } else { MotionKind::Displacement };
    let mut fixed = Vec::new();
    for line in &card.lines {
        let Some(set) = line.field(0) else { continue };
        let Some(nodes) = context.node_members(set) else { continue };
        if !in_space {
            fixed.extend(nodes);
            continue;
        }
        let Some(([first, last], value)) = mesh_dofs(context, line) else { continue };
        if value != 0.0 && amplitude.is_none() && !velocity {
            let message = format!(
                "the displacement {value} of the mesh without AMPLITUDE would be a jump: the nodes stay where they are"
            );
            let diagnostic = Diagnostic::warning("M140", message).at(line.span, "as ABAQUS/Explicit does");
            context.diagnostics.push(diagnostic.help("give AMPLITUDE=, or prescribe a velocity"));
        }
        let (value, span, user) = (amplitudes::scaled(context, value, amplitude), line.span, false);
        for dof in first..=last {
            let (nodes, set) = (nodes.clone(), set.text.clone());
            let motion = BoundaryCondition { nodes, set, dof, kind, user, value, amplitude, span };
            steps.state().mesh_motions.push(motion);
        }
    }
    if !in_space {
        steps.state().adaptive_fixed.push((card.span, fixed));
    }
}

/// Returns the degrees of freedom along which a data line prescribes the motion of the mesh, and the value.
fn mesh_dofs(context: &mut Context<'_>, line: &DataLine) -> Option<([u8; 2], f64)> {
    let first = context.integer(line, 1, "the degree of freedom")?;
    let last = line.field(2).map_or(Some(first), |word| word.integer(&mut context.diagnostics))?;
    if !(1..=2).contains(&first) || !(first..=2).contains(&last) {
        let message = format!("invalid degrees of freedom {first} to {last} of a mesh: 1 is r, 2 is z");
        return context.refuse_value(line.span, message);
    }
    Some(([first as u8, last as u8], context.number_or(line, 3, 0.0)?))
}

/// Reads `REGION TYPE` of loads that have been added to the list of the step from `first` on.
pub fn region_of_loads(steps: &mut StepReader, card: &Card, first: usize) {
    let of_load = |load: &Load| match load.kind.region() {
        LoadRegion::Nodes(nodes) => (Vec::new(), nodes.to_vec()),
        LoadRegion::Sides(sides) => (sides.faces.clone(), Vec::new()),
        LoadRegion::Elements(_) | LoadRegion::Whole => (Vec::new(), Vec::new()),
    };
    let (faces, nodes): (Vec<_>, Vec<_>) = steps.state().loads[first..].iter().map(of_load).unzip();
    adaptive_region(steps, card, faces.concat(), nodes.concat());
}

/// Reads `REGION TYPE` of a card that acts on these faces and nodes. OP=NEW ends the regions of earlier steps.
pub fn adaptive_region(steps: &mut StepReader, card: &Card, faces: Vec<(usize, ElementSide)>, nodes: Vec<usize>) {
    let (keyword, of_surface) = (card.keyword.name, card.keyword.name == "SURFACE");
    if !of_surface && card.read::<bool>("OP") {
        let state = steps.state();
        let start = state.span.start;
        state.adaptive_regions.retain(|region| region.keyword != keyword || region.span.start > start);
    }
    let kinds = [RegionType::Lagrangian, RegionType::Sliding, RegionType::Eulerian];
    let kind = card.read::<Option<usize>>("REGION TYPE").map_or(RegionType::Sliding, |at| kinds[at]);
    let default = if of_surface { RegionType::Sliding } else { RegionType::Lagrangian };
    if card.has("REGION TYPE") && kind != default {
        steps.state().adaptive_regions.push(AdaptiveRegion { span: card.span, keyword, kind, faces, nodes });
    }
}

/// Assigns controls to the domains of the step.
pub fn apply_adaptive_controls(context: &mut Context<'_>, steps: &mut StepReader) {
    let used = steps.current.iter_mut().flat_map(|state| std::mem::take(&mut state.adaptive_controls_used));
    for (set, word) in used.collect::<Vec<_>>() {
        let Some(controls) = steps.adaptive_controls.get(&upper(&word.text)).copied() else {
            context.unknown("M116", "adaptive mesh controls", &word, |_| {
                steps.adaptive_controls.keys().cloned().collect()
            });
            continue;
        };
        let domains = steps.current.iter_mut().flat_map(|state| &mut state.adaptive);
        domains.filter(|domain| domain.set == set).for_each(|domain| domain.controls = controls);
    }
}
