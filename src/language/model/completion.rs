//! Checks and values that need the whole deck: densities at the initial temperature, element deletion controls,
//! conditions on degrees of freedom that do not exist.

use super::context::Context;
use super::families::{ConditionReader, MaterialReader, RotationalCondition};
use super::rubber_fit::fit_rubber;
use super::types::{DamageEvolution, InitialKind, LoadKind};
use super::{derive, orientations, targets};
use crate::deck::{Diagnostic, Span};
use crate::kernel::hardening::LinearTable;
use crate::kernel::lists::sorted_unique;

/// Completes the model after all cards are read.
pub fn complete(context: &mut Context<'_>, materials: &mut MaterialReader, conditions: &mut ConditionReader) {
    if !context.missing.bodies {
        initial_densities(context);
    }
    for material in &mut context.model.materials {
        // *DENSITY is that of the solid; the elements contain its pores.
        if let (Some(density), Some(compaction)) = (&mut material.density, &mut material.compaction) {
            compaction.solid_density = *density;
            *density *= 1.0 - compaction.porosity;
        }
    }
    derive::derive_resistances(context, materials);
    fit_rubber(context, materials);
    targets::check_free_surfaces(context);
    orientations::check_fibres(context);
    check_element_deletion(context);
    report_missing_dofs(context, conditions);
}

/// Reports conditions on degrees of freedom that do not exist. Nodes of an axisymmetric body have 1 (r) and 2 (z);
/// the reference node of a rigid body also has 6 (rotation), which symmetry fixes (ABAQUS Analysis User's Guide
/// 1.2.2, "Conventions").
fn report_missing_dofs(context: &mut Context<'_>, conditions: &mut ConditionReader) {
    let oblique = has_oblique_impact(context);
    // A rigid body with *ATTITUDE may have six degrees of freedom.
    let in_space = |nodes: &[usize]| context.model.attitudes.iter().any(|a| nodes.contains(&a.reference));
    let velocities = context.model.initial_conditions.iter().filter_map(|c| match c.kind {
        InitialKind::Velocity(dof, value) if dof > 2 && value != 0.0 && !in_space(&c.members) => {
            let set = context.model.origin.sources.text(c.span).split(',').next().unwrap_or("").trim().into();
            let nodes = c.members.clone();
            Some(RotationalCondition { span: c.span, set, dofs: [dof; 2], nodes, lost: "moves", value })
        }
        _ => None,
    });
    let forces = context.model.steps.iter().flat_map(|s| &s.loads).filter_map(|l| match &l.kind {
        LoadKind::Concentrated { nodes, dof, set } if *dof > 2 && l.magnitude != 0.0 && !oblique => {
            let (span, set, dofs, nodes) = (l.span, set.clone(), [*dof; 2], nodes.clone());
            Some(RotationalCondition { span, set, dofs, nodes, lost: "is loaded", value: l.magnitude })
        }
        _ => None,
    });
    let mut rotational: Vec<RotationalCondition> = velocities.chain(forces).collect();
    rotational.append(&mut conditions.rotational);
    let mut reported = Vec::new();
    let shells = context.model.mesh.elements.iter().filter(|e| e.kind.is_shell());
    let turning = sorted_unique(shells.flat_map(|e| e.nodes.iter().copied()));
    for condition in rotational {
        let links = &context.model.constraints.links;
        let references = |n: &usize| {
            context.model.rigid_bodies.iter().any(|b| b.reference == *n) || links.iter().any(|l| l.reference == *n)
        };
        let shells = |n: &usize| turning.binary_search(n).is_ok();
        let turns =
            condition.dofs[1] == 6 && (condition.nodes.iter().all(references) || condition.nodes.iter().any(shells));
        if turns || reported.contains(&condition.span) {
            continue;
        }
        reported.push(condition.span);
        context.diagnostics.push(missing(&condition));
    }
}

/// Returns whether rigid bodies may have six degrees of freedom.
pub fn has_oblique_impact(context: &Context<'_>) -> bool {
    !context.model.attitudes.is_empty() || context.model.targets.iter().any(|target| target.obliquity != 0.0)
}

/// Sets a temperature-dependent density to its value at the initial temperature, because mass is constant (ABAQUS
/// Analysis User's Guide 21.2.1, "Density").
fn initial_densities(context: &mut Context<'_>) {
    for index in 0..context.model.materials.len() {
        if context.model.materials[index].densities.len() < 2 {
            continue;
        }
        let span = context.model.materials[index].span;
        match initial_temperature(context, index) {
            Ok(temperature) => {
                let material = &mut context.model.materials[index];
                let table = LinearTable { rows: material.densities.clone() };
                material.density = Some(table.value(temperature));
            }
            Err(message) => context.unsupported(span, message, "give one row, or one material per temperature"),
        }
    }
}

/// Returns the uniform initial temperature of the elements of a material.
fn initial_temperature(context: &Context<'_>, material: usize) -> Result<f64, &'static str> {
    let mut nodes = vec![0.0; context.model.mesh.node_names.len()];
    for condition in &context.model.initial_conditions {
        if let Some(value) = condition.kind.temperature() {
            condition.members.iter().for_each(|&n| nodes[n] = value);
        }
    }
    let elements = context.model.layer_regions().filter(|s| s.0.index() == material).flat_map(|s| s.1);
    let elements = elements.flat_map(|&e| &context.model.mesh.elements[e].nodes);
    let mut temperatures = elements.map(|&n| nodes[n]);
    let first =
        temperatures.next().ok_or("a temperature-dependent density requires elements with an initial temperature")?;
    if temperatures.any(|t| t != first) {
        return Err("a temperature-dependent density is not supported for \
                    elements with different initial temperatures");
    }
    Ok(first)
}

/// Reports `ELEMENT DELETION=NO` for materials whose failure deletes elements immediately.
fn check_element_deletion(context: &mut Context<'_>) {
    let deletes = |section: &super::SolidSection| {
        let material = context.model.materials.get(section.material.index())?;
        let sudden = material.failures.iter().any(|f| f.evolution == DamageEvolution::Sudden);
        let fails = sudden || material.tensile_failure.is_some_and(|t| t.deletes);
        section.controls.keep_failed_elements.filter(|_| fails && material.failed.is_none())
    };
    let spans: Vec<Span> = context.model.sections.iter().filter_map(deletes).collect();
    for span in spans {
        let message = "ELEMENT DELETION=NO requires *DAMAGE EVOLUTION; *SHEAR \
                       FAILURE and *TENSILE FAILURE delete elements, unless *FAILED MATERIAL keeps them";
        context.error("M104", message, span, "not supported");
    }
}

fn missing(condition: &RotationalCondition) -> Diagnostic {
    let [first, last] = condition.dofs;
    let dofs = if first == last { format!("{first}") } else { format!("{first} to {last}") };
    let nodes = if condition.set.is_empty() { "here".into() } else { format!("of `{}`", condition.set) };
    let message = format!("no node {nodes} has degree of freedom {dofs}; nothing {} by this line", condition.lost);
    let help = "1 is r, 2 is z; symmetry about a plane z = constant is YSYMM";
    let severity = if condition.value == 0.0 { Diagnostic::warning } else { Diagnostic::error };
    severity("M149", message).at(condition.span, "here").help(help)
}
