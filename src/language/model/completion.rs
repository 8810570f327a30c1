//! Checks and values that need the whole deck: densities at the initial temperature, element deletion controls,
//! conditions on degrees of freedom that do not exist.

use super::builder::ModelBuilder;
use super::degrees::RotationalCondition;
use super::types::{DamageEvolution, ElementKind, InitialKind, LoadKind};
use crate::deck::{Diagnostic, Span};
use crate::kernel::hardening::LinearTable;
use crate::kernel::lists::sorted_unique;

impl ModelBuilder<'_> {
    /// Completes the model after all cards are read.
    pub(super) fn complete(&mut self) {
        if !self.missing.bodies {
            self.initial_densities();
        }
        self.derive_resistances();
        self.check_free_surfaces();
        self.check_element_deletion();
        self.report_missing_dofs();
    }

    /// Reports conditions on degrees of freedom that do not exist. Nodes of an axisymmetric body have 1 (r) and 2 (z);
    /// the reference node of a rigid body also has 6 (rotation), which symmetry fixes (ABAQUS Analysis User's Guide
    /// 1.2.2, "Conventions").
    fn report_missing_dofs(&mut self) {
        let oblique = self.has_oblique_impact();
        // A rigid body with *ATTITUDE may have six degrees of freedom.
        let in_space = |nodes: &[usize]| self.model.attitudes.iter().any(|a| nodes.contains(&a.reference));
        let velocities = self.model.initial_conditions.iter().filter_map(|c| match c.kind {
            InitialKind::Velocity(dof, value) if dof > 2 && value != 0.0 && !in_space(&c.members) => {
                let (nodes, set) = (
                    c.members.clone(),
                    self.model.origin.sources.text(c.span).split(',').next().unwrap_or("").trim().into(),
                );
                Some(RotationalCondition { span: c.span, set, dofs: [dof; 2], nodes, lost: "moves", value })
            }
            _ => None,
        });
        let forces = self.model.steps.iter().flat_map(|s| &s.loads).filter_map(|l| match &l.kind {
            LoadKind::Concentrated { nodes, dof, set } if *dof > 2 && l.magnitude != 0.0 && !oblique => {
                let (dofs, nodes) = ([*dof; 2], nodes.clone());
                Some(RotationalCondition {
                    span: l.span,
                    set: set.clone(),
                    dofs,
                    nodes,
                    lost: "is loaded",
                    value: l.magnitude,
                })
            }
            _ => None,
        });
        let mut all: Vec<RotationalCondition> = velocities.chain(forces).collect();
        all.append(&mut self.rotational);
        let mut reported = Vec::new();
        let turning = self.nodes_of_shells();
        for condition in all {
            let links = &self.model.constraints.links;
            let references = |n: &usize| {
                self.model.rigid_bodies.iter().any(|b| b.reference == *n) || links.iter().any(|l| l.reference == *n)
            };
            let shells = |n: &usize| turning.binary_search(n).is_ok();
            let turns = condition.dofs[1] == 6
                && (condition.nodes.iter().all(references) || condition.nodes.iter().any(shells));
            if turns || reported.contains(&condition.span) {
                continue;
            }
            reported.push(condition.span);
            self.diagnostics.push(missing(&condition));
        }
    }

    /// Returns whether rigid bodies may have six degrees of freedom.
    pub(super) fn has_oblique_impact(&self) -> bool {
        !self.model.attitudes.is_empty() || self.model.targets.iter().any(|target| target.obliquity != 0.0)
    }

    /// Returns the nodes of shells, which have a rotation, in ascending order.
    fn nodes_of_shells(&self) -> Vec<usize> {
        let shells = self.model.mesh.elements.iter().filter(|e| e.kind == ElementKind::Sax1);
        let nodes: Vec<usize> = sorted_unique(shells.flat_map(|e| e.nodes.iter().copied()));
        nodes
    }

    /// Sets a temperature-dependent density to its value at the initial temperature, because mass is constant (ABAQUS
    /// Analysis User's Guide 21.2.1, "Density").
    fn initial_densities(&mut self) {
        for index in 0..self.model.materials.len() {
            if self.model.materials[index].densities.len() < 2 {
                continue;
            }
            let span = self.model.materials[index].span;
            match self.initial_temperature(index) {
                Ok(temperature) => {
                    let material = &mut self.model.materials[index];
                    let table = LinearTable { rows: material.densities.clone() };
                    material.density = Some(table.value(temperature));
                }
                Err(message) => self.unsupported(span, message, "give one row, or one material per temperature"),
            }
        }
    }

    /// Returns the uniform initial temperature of the elements of a material.
    fn initial_temperature(&self, material: usize) -> Result<f64, &'static str> {
        let mut nodes = vec![0.0; self.model.mesh.node_names.len()];
        for condition in &self.model.initial_conditions {
            if let InitialKind::Temperature(value) = condition.kind {
                condition.members.iter().for_each(|&n| nodes[n] = value);
            }
        }
        let elements = self.model.material_regions().filter(|s| s.0.index() == material).flat_map(|s| s.1);
        let elements = elements.flat_map(|&e| &self.model.mesh.elements[e].nodes);
        let mut temperatures = elements.map(|&n| nodes[n]);
        let first = temperatures
            .next()
            .ok_or("a temperature-dependent density requires elements with an initial temperature")?;
        if temperatures.any(|t| t != first) {
            return Err("a temperature-dependent density is not supported for \
                        elements with different initial temperatures");
        }
        Ok(first)
    }

    /// Reports `ELEMENT DELETION=NO` for materials whose failure deletes elements immediately.
    fn check_element_deletion(&mut self) {
        let kept = |section: &super::SolidSection| -> Option<(Span, bool)> {
            let span = section.controls.keep_failed_elements?;
            let material = self.model.materials.get(section.material.index())?;
            let sudden = material.failures.iter().any(|f| f.evolution == DamageEvolution::Sudden);
            Some((span, sudden || material.tensile_failure.is_some_and(|t| t.deletes)))
        };
        let kept: Vec<(Span, bool)> = self.model.sections.iter().filter_map(kept).collect();
        for (span, fails) in kept {
            if fails {
                let message = "ELEMENT DELETION=NO requires *DAMAGE EVOLUTION; *SHEAR \
                               FAILURE and *TENSILE FAILURE delete elements";
                self.diagnostics.push(Diagnostic::error("M104", message).at(span, "not supported"));
            }
        }
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
