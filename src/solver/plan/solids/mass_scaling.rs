//! Mass scaling requests of the plan, and checks for elements that cannot be scaled.

use std::collections::HashSet;

use crate::deck::{Diagnostic, Span};
use crate::element::mass_scaling::{ScalingInterval, ScalingRequest, ScalingTarget, StepMassScaling, VariableScaling};
use crate::kernel::topology::ElementTopology;
use crate::model::{LoadKind, MassScaling, Model, ScalingSchedule, ScalingType, SolidSection, Step};
use crate::plan::{Links, Report, StepInput};

/// Creates the mass scaling of a step. Fixed mass scaling that continues from the previous step is not applied
/// again.
pub fn mass_scaling(input: StepInput, report: &mut Report) -> Option<StepMassScaling> {
    let StepInput { scene, state, index, .. } = input;
    let model = scene.model;
    let step = &model.steps[index];
    let first = step.mass_scalings.first()?;
    if state.elements.is_empty() {
        report.add_unused_card(first.span, "mass scaling", "the model has no deformable elements");
        return None;
    }
    check_scalable_step(step, report);
    let (mut fixed, mut variable) = (Vec::new(), Vec::new());
    for scaling in &step.mass_scalings {
        let Some(request) = scaling_request(input, scaling, report) else { continue };
        match scaling.schedule {
            None => fixed.push(request),
            Some(rhythm) => variable.push(VariableScaling::new(request, in_step(rhythm, step))),
        }
    }
    let previous = index.checked_sub(1).and_then(|i| model.steps[i].mass_scalings.first());
    let continues = previous.is_some_and(|b| b.span == first.span);
    Some(StepMassScaling::new((!continues).then_some(fixed), variable))
}

fn scaling_request(input: StepInput, scaling: &MassScaling, report: &mut Report) -> Option<ScalingRequest> {
    let StepInput { scene, links, state, .. } = input;
    let places = &scene.places.elements;
    let elements: Vec<(usize, usize)> = match &scaling.elements {
        None => places.values().copied().collect(),
        Some(list) => list.iter().filter_map(|e| places.get(e).copied()).collect(),
    };
    // The increment of cohesive elements follows from the masses of the bodies that they join.
    let is_body = |at: &(usize, usize)| state.elements.groups[at.0].topology() != ElementTopology::Cohesive;
    let elements: Vec<(usize, usize)> = elements.into_iter().filter(is_body).collect();
    if elements.is_empty() {
        report.add_unused_card(scaling.span, "mass scaling", "none of its elements is a deformable solid or shell");
        return None;
    }
    let mut refusal = None;
    for &(g, e) in &elements {
        let group = &state.elements.groups[g];
        let name = || scene.element_name((g, e));
        if group.stable_rate(e, Some(&group.masses(e)), state.dofs.nodes.as_slice()).is_none() {
            refusal = Some(format!(
                "element {} cannot be scaled: explosives, materials with *EOS COMPACTION and elements with WEIGHTING=AREA keep their mass",
                name()
            ));
            break;
        }
    }
    if let Some(message) = refusal {
        refuse_scaling(scaling.span, message, "give an ELSET without these elements", report);
        return None;
    }
    let constrained = constrained_nodes(links, state.dofs.nodes.len());
    let is_constrained = |&(g, e): &(usize, usize)| {
        state.elements.groups[g].nodes(e).into_iter().any(|n| constrained.get(n as usize) == Some(&true))
    };
    let touched = elements.iter().filter(|at| is_constrained(at)).count();
    let at_links = if touched > 0 {
        format!("; {touched} elements have nodes with equations, links or rigid bodies, which take the added mass")
    } else {
        String::new()
    };
    report.ledger_row(scaling.span, "mass scaling", elements.len(), "elements", detail(scaling) + &at_links);
    let aim = scaling.target.map(|(kind, dt)| (aim(kind), dt));
    Some(ScalingRequest { elements, factor: scaling.factor, aim, budget: scaling.budget })
}

/// Returns whether mass scaling acts on an element of a list (ascending) whose material has an equation of state.
pub fn scales_equation_of_state(model: &Model, elements: &[usize]) -> bool {
    let has_eos = |section: &&SolidSection| model.materials[section.material].eos.is_some();
    let of_eos = model.sections.iter().filter(has_eos).flat_map(|section| &section.elements);
    let listed: HashSet<usize> = of_eos.filter(|e| elements.binary_search(e).is_ok()).copied().collect();
    let mut scalings = model.steps.iter().flat_map(|step| &step.mass_scalings);
    !listed.is_empty()
        && scalings.any(|s| s.elements.as_ref().is_none_or(|list| list.iter().any(|e| listed.contains(e))))
}

/// Returns whether each node belongs to a rigid body, an equation or a link. Empty if there are none.
pub fn constrained_nodes(links: &Links, count: usize) -> Vec<bool> {
    let carried = links.rigid_ties.iter().flat_map(|t| t.nodes.iter().copied());
    marked_nodes(count, carried.chain(nodes_of_links(links)))
}

/// Returns the nodes with equations and links.
pub fn nodes_of_links(links: &Links) -> impl Iterator<Item = usize> {
    links.involved_dofs().into_iter().map(|dof| dof.0)
}

/// Returns whether each node belongs to a list. Empty if the list is.
pub fn marked_nodes(count: usize, nodes: impl Iterator<Item = usize>) -> Vec<bool> {
    let nodes: Vec<usize> = nodes.collect();
    let mut marked = vec![false; if nodes.is_empty() { 0 } else { count }];
    nodes.into_iter().for_each(|n| marked[n] = true);
    marked
}

/// Reports loads that use the initial masses and do not support mass scaling.
pub fn check_scalable_step(step: &Step, report: &mut Report) {
    for load in &step.loads {
        if matches!(load.kind, LoadKind::Gravity { elements: Some(_), .. }) {
            let help = "leave the element set of GRAV empty, so that it acts on all masses";
            let message = "gravity on an element set is not supported with mass scaling".into();
            refuse_scaling(load.span, message, help, report);
        }
    }
}

/// Reports mass scaling and loads of a step that do not follow the mass that nodes of deleted elements pass on
/// (`NODAL EROSION=MERGE`).
pub fn check_merging_step(model: &Model, step: &Step, report: &mut Report) {
    if !step.merges_detached_nodes() {
        return;
    }
    let help = "use NODAL EROSION=YES";
    if let Some(scaling) = model.steps.iter().flat_map(|step| &step.mass_scalings).next() {
        let message =
            "mass scaling is not supported with NODAL EROSION=MERGE, which changes the masses of nodes".into();
        refuse_scaling(scaling.span, message, help, report);
    }
    for load in &step.loads {
        if matches!(load.kind, LoadKind::Gravity { elements: Some(_), .. }) {
            let message = "gravity on an element set is not supported with NODAL EROSION=MERGE".into();
            refuse_scaling(load.span, message, help, report);
        }
    }
}

fn refuse_scaling(span: Span, message: String, help: &str, report: &mut Report) {
    report.push(Diagnostic::error("P022", message).at(span, "here").help(help));
}

fn aim(kind: ScalingType) -> ScalingTarget {
    match kind {
        ScalingType::BelowMin => ScalingTarget::BelowMin,
        ScalingType::Uniform => ScalingTarget::Uniform,
        ScalingType::SetEqual => ScalingTarget::SetEqual,
    }
}

fn in_step(rhythm: ScalingSchedule, step: &Step) -> ScalingInterval {
    match rhythm {
        ScalingSchedule::Increments(every) => ScalingInterval::Increments(every),
        ScalingSchedule::Intervals(count) => ScalingInterval::Time(step.duration / count as f64),
    }
}

fn detail(scaling: &MassScaling) -> String {
    let mut parts = Vec::new();
    if scaling.factor != 1.0 || scaling.target.is_none() {
        parts.push(format!("factor {}", scaling.factor));
    }
    if let Some((kind, dt)) = scaling.target {
        parts.push(format!("{kind:?} {dt:e}"));
        parts.extend(scaling.budget.map(|budget| format!("at most {} % of the mass is added", 100.0 * budget)));
    }
    parts.push(match scaling.schedule {
        None => "at the start of the step".into(),
        Some(ScalingSchedule::Increments(n)) => format!("every {n} increments"),
        Some(ScalingSchedule::Intervals(n)) => format!("{n} times in the step"),
    });
    parts.join(", ")
}
