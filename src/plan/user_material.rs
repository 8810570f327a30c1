//! Elements of a user material: `*USER MATERIAL` with its state variables, as a group that calls the routine.
//! Never here: calling it.

use super::Compiler;
use super::solid::add_masses;
use super::solid_material::{Moduli, heating};
use crate::deck::Diagnostic;
use crate::element::constants::Constants;
use crate::element::group::ElementGroup;
use crate::element::user_quads::{Description, UserQuads};
use crate::kernel::heating::Heating;
use crate::model::{Hourglass, Material, SolidSection, StateVariables};
use crate::state::nodes::Node;

impl Compiler<'_> {
    /// The group of a section whose material is the user's.
    #[allow(clippy::too_many_arguments)] // What a group is made of.
    pub(super) fn user_group(
        &mut self,
        section: &SolidSection,
        material: &Material,
        properties: &[f64],
        elements: &[usize],
        corners: &[[u32; 4]],
        nodes: &[Node],
        mass: &mut [f64],
    ) -> Option<Box<dyn ElementGroup>> {
        let density = self.user_density(section, material)?;
        if self.routines.material.is_none() {
            let asks = format!("the material `{}` is the user's (*USER MATERIAL)", material.name);
            self.no_routine(section.span, "section", &asks, "vumat");
            return None;
        }
        add_masses(corners, nodes, density, mass);
        self.tell_of_heat(material);
        let enhanced = self.is_enhanced(section);
        // Fractions of a shear modulus that the routine's first call tells, as it does Poisson's ratio.
        let unit = Moduli { bulk: 1.0, shear: 1.0, ratio: 0.0 };
        let hourglass = self.hourglass(section, unit)?;
        let bulk_viscosity = self.model.steps.first().map_or([0.06, 1.2], |s| s.bulk_viscosity);
        // The moduli come from the routine.
        let constants = Constants { bulk: 0.0, shear: 0.0, hourglass, bulk_viscosity };
        let StateVariables { count, delete } = material.state;
        let detail = format!("material {}, by the user, Jaumann rate", material.name);
        self.cause(section.span, "deformable elements", elements.len(), "CAX4R", detail);
        let ratio = if enhanced { ", hourglass stiffness times 1 + Poisson's ratio" } else { "" };
        let detail = format!("vumat: {} constants, {count} state variables{ratio}", properties.len());
        self.cause(section.span, "user material", elements.len(), "points", detail);
        self.control_rows(section, elements.len(), &constants);
        let (name, properties) = (material.name.clone(), properties.to_vec());
        let heating = if self.conducts(section) { heating(material, 1.0) } else { Heating::None };
        let description = Description { name, properties, variables: count, delete, heating, enhanced };
        let names = elements.iter().map(|&e| self.model.mesh.elements[e].name.clone()).collect();
        Some(Box::new(UserQuads::new(description, constants, density, corners, nodes, names)))
    }

    /// Density of a user material; `None` if it lacks one or stands beside what it cannot (reported).
    fn user_density(&mut self, section: &SolidSection, material: &Material) -> Option<f64> {
        let (code, message) = if material.density.is_none() {
            ("P013", format!("material `{}` has no *DENSITY", material.name))
        } else if material.elastic.is_some() || material.plastic.is_some() {
            ("P041", format!("material `{}` has *ELASTIC or *PLASTIC beside *USER MATERIAL", material.name))
        } else {
            return material.density;
        };
        self.diagnostics.push(Diagnostic::error(code, message).at(section.span, "these elements deform"));
        None
    }

    /// A routine stores temperatures and integrates them itself, as state variables (ABAQUS User Subroutines Reference Manual,
    /// VUMAT, "Overview").
    fn tell_of_heat(&mut self, material: &Material) {
        let Some(step) = self.model.steps.first().filter(|s| s.adiabatic) else { return };
        if material.inelastic_heat_fraction.is_some() {
            let what = format!("heating of material `{}`", material.name);
            self.unused(step.span, what, "its routine integrates the temperature itself, as a state variable");
        }
    }

    fn is_enhanced(&self, section: &SolidSection) -> bool {
        let named =
            |name: &String| self.model.controls.iter().any(|c| c.name == *name && c.hourglass == Hourglass::Enhanced);
        section.controls.as_ref().is_some_and(named)
    }

    /// Materials that elements of the scene have.
    fn materials_present(&self) -> impl Iterator<Item = &Material> {
        let deforms = |s: &&SolidSection| s.elements.iter().any(|e| self.places.elements.contains_key(e));
        self.model.sections.iter().filter(deforms).map(|s| &self.model.materials[s.material])
    }

    /// The most variables that a user material of this scene keeps.
    pub(super) fn state_variables(&self) -> usize {
        self.materials_present().filter(|m| m.user.is_some()).map(|m| m.state.count).max().unwrap_or(0)
    }

    /// Whether elements of the scene can be deleted.
    pub(super) fn deletes(&self) -> bool {
        self.materials_present()
            .any(|m| m.state.delete.is_some() || !m.failures.is_empty() || m.tensile_failure.is_some())
    }
}
