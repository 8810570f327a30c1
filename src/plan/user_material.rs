//! Elements that ask the user's routines at their points: `*USER MATERIAL`, `*PLASTIC, HARDENING=USER` and `*USER DEFINED FIELD`,
//! with state and field variables, as a group that calls them.
//! Never here: calling them.

use std::sync::Arc;

use super::Compiler;
use super::solid::{Connectivity, add_masses};
use super::solid_material::{GroupBuilder, heating};
use crate::deck::Diagnostic;
use crate::element::constants::Constants;
use crate::element::group::{ElementGroup, Quads};
use crate::kernel::heating::Heating;
use crate::kernel::moduli::Moduli;
use crate::material::point_law::PointLaw;
use crate::material::user::UserMaterial;
use crate::material::user::description::{Description, Flow, Yield};
use crate::model::{Material, Plastic, SolidSection, StateVariables};
use crate::state::nodes::Node;
use crate::user::MaterialLaw;

/// Whether elements of a material ask routines of the user at their points.
pub(super) fn asks_at_points(material: &Material) -> bool {
    let varies = !material.elastic_table.is_empty();
    varies || material.user.material.is_some() || material.user.fields.is_some() || flows_at_points(material)
}

/// Whether the yield stress is one of points: of the user's, or over field variables.
fn flows_at_points(material: &Material) -> bool {
    matches!(material.plastic, Some(Plastic::User(_) | Plastic::OverFields(_)))
}

/// What the user's routines give of a law.
enum UserLaw<'m> {
    /// The stress, with these constants, and who gives it.
    Stress(&'m [f64], &'static str),
    /// The yield stress, or nothing of it.
    Flow(Yield),
}

impl Compiler<'_> {
    /// The group of a section whose material asks routines of the user.
    pub(super) fn user_group(
        &mut self,
        section: &SolidSection,
        material: &Material,
        elements: &[usize],
        connectivity: &Connectivity,
        nodes: &[Node],
        mass: &mut [f64],
    ) -> Option<Box<dyn ElementGroup>> {
        let (law, moduli) = match &material.user.material {
            Some(properties) => (UserLaw::Stress(properties, "vumat"), self.user_moduli(section, material)?),
            None => self.user_flow(section, material)?,
        };
        let density = material.density?;
        self.stays_double(section.span, elements.len(), "routines of the user");
        self.ask_fields(section, material)?;
        let takes_lengths = material.user.material.is_some() || material.user.fields.is_some();
        self.asks_lengths(section, material, takes_lengths)?;
        add_masses(connectivity, nodes, density, mass);
        let hourglass = self.hourglass(section, material, moduli)?;
        let bulk_viscosity = self.model.steps.first().map_or([0.06, 1.2], |s| s.bulk_viscosity);
        // The moduli of a routine's stress come from its first answer.
        let told = matches!(law, UserLaw::Stress(..));
        let [bulk, shear] = if told { [0.0; 2] } else { [moduli.bulk, moduli.shear] };
        let constants = Constants { bulk, shear, hourglass, bulk_viscosity };
        let heating =
            if self.adiabatic() || self.conducts(section) { heating(material, density) } else { Heating::None };
        self.user_rows(section, material, &law, (elements.len(), "CAX4R", &constants), &heating);
        let StateVariables { count, delete } = material.user.state;
        let (properties, flow) = match law {
            UserLaw::Stress(properties, _) => (properties.to_vec(), None),
            UserLaw::Flow(yields) => {
                let elasticity = self.elasticity(section, material, elements.len());
                (Vec::new(), Some(Flow { bulk, shear, elasticity, yields }))
            }
        };
        let description = Description {
            name: material.name.clone(),
            properties,
            variables: count,
            delete,
            fields: self.field_variables(material),
            asks_fields: material.user.fields.as_ref().map(|f| f.0.clone()),
            asks_lengths: material.user.lengths.as_ref().filter(|_| takes_lengths).map(|l| l.0.clone()),
            flow,
            heating,
            density,
        };
        let names = elements.iter().map(|&e| self.model.mesh.elements[e].name.to_string()).collect();
        let corners = connectivity.quadrilaterals();
        let triangles = corners.iter().all(|c| c[2] == c[3]);
        let mut group: Box<dyn ElementGroup> = if description.flow.is_some() {
            let law = UserMaterial::<true> { description, names, triangles };
            Box::new(Quads::new(law, constants, density, corners, nodes))
        } else {
            let law = UserMaterial::<false> { description, names, triangles };
            Box::new(Quads::new(law, constants, density, corners, nodes))
        };
        if material.user.fields.is_some() {
            // The routine may ask for strains.
            group.extensions().settings().follow();
        }
        Some(group)
    }

    /// The group of a section whose material has a law in Rust; `None` if a card is missing or the law does not take its
    /// constants (reported).
    pub(super) fn law_group(
        &mut self,
        section: &SolidSection,
        (material, constants, law): (&Material, &[f64], Arc<dyn MaterialLaw>),
        (connectivity, nodes): (&Connectivity, &[Node]),
        mass: &mut [f64],
    ) -> Option<Box<dyn ElementGroup>> {
        let StateVariables { count: variables, delete } = material.user.state;
        let name = &material.name;
        let refusal = match (material.density, law.moduli(constants)) {
            (None, _) => format!("material `{name}` has no *DENSITY"),
            _ if material.elastic.is_some() || material.plastic.is_some() || section.controls.by_area => {
                format!("material `{name}` has *ELASTIC, *PLASTIC or WEIGHTING=AREA beside *USER MATERIAL")
            }
            (_, Err(failure)) => format!("the law of material `{name}` does not take its constants: {failure}"),
            _ if variables < law.state_variables() => {
                let least = law.state_variables();
                format!("the law of material `{name}` needs {least} state variables, *DEPVAR gives {variables}")
            }
            (Some(density), Ok(moduli)) => {
                let (count, kind) = (connectivity.count(), connectivity.element_type());
                self.stays_double(section.span, count, "routines of the user");
                add_masses(connectivity, nodes, density, mass);
                let hourglass = self.control(section, material, moduli, connectivity)?;
                let bulk_viscosity = self.model.steps.first().map_or([0.06, 1.2], |s| s.bulk_viscosity);
                let group = Constants { bulk: moduli.bulk, shear: moduli.shear, hourglass, bulk_viscosity };
                let stress = UserLaw::Stress(constants, "in Rust");
                self.user_rows(section, material, &stress, (count, kind, &group), &Heating::None);
                let law = PointLaw { law, constants: constants.to_vec(), variables, delete };
                return Some(GroupBuilder::new(group, density, connectivity, nodes).group(law));
            }
        };
        self.diagnostics.refuse(Diagnostic::error("P041", refusal).at(section.span, "these elements deform"))
    }

    /// The moduli that stand for those of a routine's stress until it tells them; `None` if the material lacks a card or has
    /// one too many (reported), or if there is no routine.
    fn user_moduli(&mut self, section: &SolidSection, material: &Material) -> Option<Moduli> {
        let (code, message) = if material.density.is_none() {
            ("P013", format!("material `{}` has no *DENSITY", material.name))
        } else if material.elastic.is_some() || material.plastic.is_some() {
            ("P041", format!("material `{}` has *ELASTIC or *PLASTIC beside *USER MATERIAL", material.name))
        } else if self.routines.material.is_none() {
            let asks = format!("the material `{}` is the user's (*USER MATERIAL)", material.name);
            self.no_routine(section.span, "section", &asks, "vumat");
            return None;
        } else {
            self.called.push("vumat");
            // Fractions of a shear modulus that the routine's first call tells.
            return Some(Moduli { bulk: 1.0, shear: 1.0 });
        };
        self.diagnostics.refuse(Diagnostic::error(code, message).at(section.span, "these elements deform"))
    }

    /// Elasticity and yield stress of a material whose yield stress or fields are the user's; `None` if it lacks something or
    /// has what does not go with that (reported).
    fn user_flow<'m>(&mut self, section: &SolidSection, material: &'m Material) -> Option<(UserLaw<'m>, Moduli)> {
        let moduli = self.moduli(material, section.span)?;
        let cause = if material.user.fields.is_some() {
            "*USER DEFINED FIELD"
        } else if flows_at_points(material) {
            "*PLASTIC, HARDENING=USER or DEPENDENCIES="
        } else {
            "a table of *ELASTIC"
        };
        let beside = [
            (material.eos.is_some(), "*EOS"),
            (material.hyperelastic.is_some(), "*HYPERELASTIC"),
            (material.foam.shape.is_some(), "*CRUSHABLE FOAM"),
            (!material.failures.is_empty(), "*DAMAGE INITIATION or *SHEAR FAILURE"),
            (material.tensile_failure.is_some(), "*TENSILE FAILURE"),
            (matches!(material.plastic, Some(Plastic::Kinematic(_))), "HARDENING=KINEMATIC"),
            (material.rate.is_some() && matches!(material.plastic, Some(Plastic::User(_))), "*RATE DEPENDENT"),
        ];
        if let Some((_, other)) = beside.iter().find(|(there, _)| *there) {
            let message = format!("material `{}` has {cause} beside {other}, which is not supported", material.name);
            return self.diagnostics.refuse(Diagnostic::error("P041", message).at(material.span, "this material"));
        }
        let yields = match &material.plastic {
            None => Yield::Never,
            Some(Plastic::User(properties)) => {
                if self.routines.hardening.is_none() {
                    let asks = format!("the hardening of `{}` is the user's (*PLASTIC, HARDENING=USER)", material.name);
                    self.no_routine(section.span, "section", &asks, "vuhard");
                    return None;
                }
                self.called.push("vuhard");
                Yield::User(properties.clone())
            }
            Some(Plastic::OverFields(rows)) => self.yield_over_fields(section, material, rows)?,
            Some(plastic) => Yield::Law(Arc::new(self.yield_stress(plastic, material, section.span)?)),
        };
        Some((UserLaw::Flow(yields), moduli))
    }

    /// Whether the routine of fields is there, where one is asked for; `None` if not (reported).
    fn ask_fields(&mut self, section: &SolidSection, material: &Material) -> Option<()> {
        let Some((properties, span)) = &material.user.fields else { return Some(()) };
        if self.routines.fields.is_none() {
            let asks = format!("fields of `{}` are the user's (*USER DEFINED FIELD)", material.name);
            self.no_routine(section.span, "section", &asks, "vusdfld");
            return None;
        }
        self.called.push("vusdfld");
        let detail = format!("vusdfld: {} constants, {} state variables", properties.len(), material.user.state.count);
        self.cause(*span, "user-defined fields", 1, "material", detail);
        Some(())
    }

    /// Whether the routine of characteristic lengths is there, where one is asked for and something takes a length; `None` if
    /// not (reported).
    pub(super) fn asks_lengths(&mut self, section: &SolidSection, material: &Material, takes: bool) -> Option<()> {
        let Some((properties, span)) = &material.user.lengths else { return Some(()) };
        if !takes {
            let why = "no damage evolves in this material, and no vumat or vusdfld is told a length";
            self.unused(*span, "*CHARACTERISTIC LENGTH", why);
            return Some(());
        }
        if self.routines.lengths.is_none() {
            let asks =
                format!("the characteristic length of `{}` is the user's (*CHARACTERISTIC LENGTH)", material.name);
            self.no_routine(section.span, "section", &asks, "vucharlength");
            return None;
        }
        self.called.push("vucharlength");
        let detail = format!("vucharlength: {} constants", properties.len());
        self.cause(*span, "characteristic length", 1, "material", detail);
        Some(())
    }

    fn user_rows(
        &mut self,
        section: &SolidSection,
        material: &Material,
        law: &UserLaw<'_>,
        (count, kind, constants): (usize, &'static str, &Constants),
        heating: &Heating,
    ) {
        let name = &material.name;
        let heated = if heating.is_none() { "" } else { ", heated by inelastic work" };
        let variables = material.user.state.count;
        let by = if matches!(law, UserLaw::Stress(..)) { "by the user" } else { "elastic" };
        self.cause(section.span, "deformable elements", count, kind, format!("material {name}, {by}, Jaumann rate"));
        match law {
            UserLaw::Stress(properties, who) => {
                let detail = format!("{who}: {} constants, {variables} state variables{heated}", properties.len());
                self.cause(section.span, "user material", count, "points", detail);
            }
            UserLaw::Flow(Yield::User(properties)) => {
                let detail = format!("vuhard: {} constants, {variables} state variables{heated}", properties.len());
                self.cause(section.span, "plasticity", count, "elements", detail);
            }
            UserLaw::Flow(Yield::OverFields(law)) => {
                let fields = law.fields;
                let rate = if law.factor.is_some() { ", rate dependent" } else { "" };
                let detail = format!("tabular isotropic over {fields} field variables{rate}{heated}");
                self.cause(section.span, "plasticity", count, "elements", detail);
            }
            UserLaw::Flow(Yield::Law(_)) => {
                let detail = format!("built-in yield stress, point by point{heated}");
                self.cause(section.span, "plasticity", count, "elements", detail);
            }
            UserLaw::Flow(Yield::Never) => {}
        }
        self.control_rows(section, (count, kind), constants);
    }

    /// Materials that elements of the scene have.
    fn materials_present(&self) -> impl Iterator<Item = &Material> {
        let deforms = |s: &&SolidSection| s.elements.iter().any(|e| self.places.elements.contains_key(e));
        self.model.sections.iter().filter(deforms).map(|s| &self.model.materials[s.material])
    }

    /// The most variables that a material of this scene keeps for the user's routines.
    pub(super) fn state_variables(&self) -> usize {
        self.materials_present().filter(|m| asks_at_points(m)).map(|m| m.user.state.count).max().unwrap_or(0)
    }

    /// The name that *DEPVAR gives a state variable; `None` where materials of the scene call it otherwise.
    pub(super) fn state_name(&self, variable: usize) -> Option<&str> {
        let keeps = self.materials_present().filter(|m| asks_at_points(m) && m.user.state.count > variable);
        let mut names =
            keeps.map(|m| m.user.state_names.iter().find(|(v, _)| *v == variable).map(|(_, name)| name.as_str()));
        let first = names.next()??;
        names.all(|name| name == Some(first)).then_some(first)
    }

    /// Whether elements of the scene can be deleted.
    pub(super) fn deletes(&self) -> bool {
        let fails =
            |m: &Material| m.user.state.delete.is_some() || !m.failures.is_empty() || m.tensile_failure.is_some();
        !self.model.erosions.is_empty() || self.materials_present().any(fails)
    }
}
