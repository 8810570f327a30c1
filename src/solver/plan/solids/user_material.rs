//! Element groups that call user subroutines at material points: `*USER MATERIAL`, `*PLASTIC, HARDENING=USER` and
//! `*USER DEFINED FIELD`, with state and field variables.

use std::sync::Arc;

use crate::deck::Diagnostic;
use crate::element::constants::ElementConstants;
use crate::element::group::{ElementGroup, GroupSetting};
use crate::element::solid_groups::{Connectivity, GroupOptions, SolidMaterial, create_group};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::levels::NestedTable;
use crate::kernel::moduli::ElasticModuli;
use crate::material::point_law::{PointLaw, PointLawData};
use crate::material::user::SubroutineMaterial;
use crate::material::user::description::{
    BuiltInPlasticity, FieldElasticity, MOST_DEPENDENCIES, UserMaterialData, YieldOverFields, YieldSource,
};
use crate::material::user::energy::{AnisotropicEnergy, HolzapfelEnergy};
use crate::model::rates::rate_factor;
use crate::model::{AnisotropicEnergyCard, MaterialDefinition, PlasticityModel, SolidSection, StateVariables};
use crate::plan::queries::field_variables;
use crate::plan::solids::cohesive::damaged_interfaces;
use crate::plan::solids::solid_material::{
    bulk_viscosity, control_rows, elastic_moduli, heating, hourglass_control, yield_stress,
};
use crate::plan::{GroupInput, Report, Scene};
use crate::user::{MaterialLaw, PointQuantity};

/// Returns whether a material is evaluated point by point, as for user subroutines and tables over field variables.
pub fn calls_routines_at_points(material: &MaterialDefinition) -> bool {
    let varies = !material.elastic_table.is_empty();
    varies || material.user.material.is_some() || material.user.fields.is_some() || flows_at_points(material)
}

/// Returns whether the yield stress is evaluated point by point: user-defined, or over field variables.
fn flows_at_points(material: &MaterialDefinition) -> bool {
    matches!(material.plastic, Some(PlasticityModel::User(_) | PlasticityModel::OverFields(_)))
}

/// The part of a material law that is evaluated point by point.
enum UserLaw<'m> {
    /// The stress: material constants, and the name of the subroutine.
    Stress(&'m [f64], &'static str),
    /// A strain energy, from which the stress follows: material constants, and its name.
    Energy(&'m [f64], &'static str),
    /// The yield stress only; elasticity and flow are built in.
    Flow(YieldSource),
}

/// Creates the element group of a material that is evaluated point by point.
pub fn user_group(input: &GroupInput, report: &mut Report) -> Option<Box<dyn ElementGroup>> {
    let GroupInput { model, section, material, elements, connectivity, nodes, .. } = *input;
    let (law, moduli) = match (&material.user.material, material.user.energy) {
        (Some(properties), None) => (UserLaw::Stress(properties, "vumat"), user_moduli(input, report)?),
        (Some(properties), Some(AnisotropicEnergyCard { is_user, .. })) => {
            let energy = if is_user { "vuanisohyper_inv" } else { "Holzapfel" };
            (UserLaw::Energy(properties, energy), user_moduli(input, report)?)
        }
        (None, _) => user_flow(input, report)?,
    };
    let density = material.density?;
    require_field_routine(input, report)?;
    let takes_lengths = matches!(law, UserLaw::Stress(..)) || material.user.fields.is_some();
    require_length_routine(input, takes_lengths, report)?;
    let hourglass = hourglass_control(input, moduli, report)?;
    let bulk_viscosity = bulk_viscosity(model, false);
    // The moduli of a user material or strain energy are computed from its first call.
    let [bulk, shear] = if matches!(law, UserLaw::Flow(_)) { [moduli.bulk, moduli.shear] } else { [0.0; 2] };
    let constants = ElementConstants { bulk, shear, hourglass, bulk_viscosity, shear_viscosity: 0.0, by_area: false };
    let heating = if model.is_adiabatic() || model.conducts_heat(section) {
        heating(material, density)
    } else {
        PlasticHeating::None
    };
    user_rows(input, &law, connectivity.element_type(), &constants, &heating, report);
    let StateVariables { count, delete } = material.user.state;
    let (properties, flow) = match law {
        UserLaw::Stress(properties, _) | UserLaw::Energy(properties, _) => (properties.to_vec(), None),
        UserLaw::Flow(yields) => {
            let elasticity = elasticity(input, report);
            (Vec::new(), Some(BuiltInPlasticity { bulk, shear, elasticity, yields }))
        }
    };
    let description = UserMaterialData {
        name: material.name.clone(),
        energy: strain_energy(section, material, report)?,
        properties,
        variables: count,
        delete,
        fields: field_variables(model, material),
        field_constants: material.user.fields.as_ref().map(|f| f.0.clone()),
        length_constants: material.user.lengths.as_ref().filter(|_| takes_lengths).map(|l| l.0.clone()),
        flow,
        heating,
        density,
    };
    let names = elements.iter().map(|&e| model.mesh.elements[e].name.to_string()).collect();
    let nodes_of_elements = match connectivity {
        Connectivity::SixNodeTriangles(_) => 6,
        Connectivity::Quadrilaterals(list) if list.iter().all(|c| c[2] == c[3]) => 3,
        Connectivity::Quadrilaterals(_) => 4,
    };
    let law = if description.flow.is_some() {
        SolidMaterial::UserFlow(SubroutineMaterial { description, names, nodes: nodes_of_elements })
    } else if description.energy.is_some() {
        SolidMaterial::UserEnergy(SubroutineMaterial { description, names, nodes: nodes_of_elements })
    } else {
        SolidMaterial::UserStress(SubroutineMaterial { description, names, nodes: nodes_of_elements })
    };
    let mut group = create_group(law, GroupOptions::new(constants, density), connectivity, nodes);
    if material.user.fields.is_some() {
        // VUSDFLD may request strains.
        group.configure(GroupSetting::Records);
    }
    Some(group)
}

/// Returns the strain energy of a material with the fibres of a section, if it has one. Missing constants or directions are an
/// error.
fn strain_energy(
    section: &SolidSection,
    material: &MaterialDefinition,
    report: &mut Report,
) -> Option<Option<AnisotropicEnergy>> {
    let Some(AnisotropicEnergyCard { is_user, families }) = material.user.energy else { return Some(None) };
    let built_in = match material.user.material.as_deref() {
        _ if is_user => Some(None),
        Some(&[c10, d, k1, k2, kappa]) => Some(Some(HolzapfelEnergy { c10, d, k1, k2, kappa })),
        _ => None,
    };
    let Some((built_in, fibres)) = built_in.zip(section.fibres.get(..families)) else {
        let message = format!(
            "material `{}` needs {families} directions of fibres, but its section has {}, or it lacks constants",
            material.name,
            section.fibres.len()
        );
        return report.refuse(Diagnostic::error("P041", message).at(section.span, "these elements deform"));
    };
    Some(Some(AnisotropicEnergy { fibres: fibres.to_vec(), built_in }))
}

/// Creates the element group of a user material in Rust. A missing card or constants that the law refuses are
/// errors.
pub fn law_group(
    input: &GroupInput,
    constants: &[f64],
    law: Arc<dyn MaterialLaw>,
    report: &mut Report,
) -> Option<Box<dyn ElementGroup>> {
    let GroupInput { model, section, material, connectivity, nodes, .. } = *input;
    let StateVariables { count: variables, delete } = material.user.state;
    let name = &material.name;
    let refusal = match (material.density, law.moduli(constants)) {
        (None, _) => format!("material `{name}` has no *DENSITY"),
        _ if material.elastic.is_some() || material.plastic.is_some() || section.controls.by_area => {
            format!("material `{name}` has *ELASTIC, *PLASTIC or WEIGHTING=AREA in addition to *USER MATERIAL")
        }
        (_, Err(failure)) => format!("the law of material `{name}` does not accept its constants: {failure}"),
        _ if variables < law.state_variables() => {
            let least = law.state_variables();
            format!("the law of material `{name}` needs {least} state variables, but *DEPVAR gives {variables}")
        }
        (Some(density), Ok(moduli)) => {
            let hourglass = hourglass_control(input, moduli, report)?;
            let bulk_viscosity = bulk_viscosity(model, false);
            let is_detailed = !law.uses().is_empty();
            let group = ElementConstants {
                bulk: if is_detailed { 0.0 } else { moduli.bulk },
                shear: moduli.shear,
                hourglass,
                bulk_viscosity,
                shear_viscosity: 0.0,
                by_area: false,
            };
            let stress = UserLaw::Stress(constants, "in Rust");
            let warms = model.is_adiabatic() || model.conducts_heat(section);
            let heats = warms && law.uses().contains(&PointQuantity::Temperature);
            let heating = if heats { heating(material, density) } else { PlasticHeating::None };
            user_rows(input, &stress, connectivity.element_type(), &group, &heating, report);
            let constants = constants.to_vec();
            let data = PointLawData { law, constants, variables, delete, moduli, density, heating };
            let law = if is_detailed {
                SolidMaterial::DetailedPoint(PointLaw(data))
            } else {
                SolidMaterial::Point(PointLaw(data))
            };
            return Some(create_group(law, GroupOptions::new(group, density), connectivity, nodes));
        }
    };
    report.refuse(Diagnostic::error("P041", refusal).at(section.span, "these elements deform"))
}

/// Returns the provisional moduli of a user material or strain energy, which are replaced after its first call. Missing or
/// contradictory cards, or a missing subroutine, are errors.
fn user_moduli(input: &GroupInput, report: &mut Report) -> Option<ElasticModuli> {
    let GroupInput { section, material, .. } = *input;
    let (card, routine) = match material.user.energy {
        None => ("*USER MATERIAL", Some("vumat")),
        Some(AnisotropicEnergyCard { is_user, .. }) => {
            ("*ANISOTROPIC HYPERELASTIC", is_user.then_some("vuanisohyper_inv"))
        }
    };
    let (code, message) = if material.density.is_none() {
        ("P013", format!("material `{}` has no *DENSITY", material.name))
    } else if let Some(other) = law_beside_user_material(material) {
        ("P041", format!("material `{}` has {other} in addition to {card}", material.name))
    } else {
        if let Some(routine) = routine {
            let asks = format!("material `{}` is user-defined ({card})", material.name);
            report.require_routine(section.span, "section", &asks, routine)?;
        }
        // Unit values: hourglass factors are multiplied by the moduli of the first call.
        return Some(ElasticModuli { bulk: 1.0, shear: 1.0 });
    };
    report.refuse(Diagnostic::error(code, message).at(section.span, "these elements deform"))
}

/// Returns the yield stress and moduli of a material with built-in elasticity that is evaluated point by point.
/// Missing or unsupported cards are errors.
fn user_flow<'m>(input: &GroupInput<'m>, report: &mut Report) -> Option<(UserLaw<'m>, ElasticModuli)> {
    let GroupInput { section, material, .. } = *input;
    let moduli = elastic_moduli(material, section.span, report)?;
    let reason = if material.user.fields.is_some() {
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
        (material.has_strength_law(), "a yield surface that depends on pressure, porosity or direction"),
        (!material.failures.is_empty(), "*DAMAGE INITIATION or *SHEAR FAILURE"),
        (material.tensile_failure.is_some(), "*TENSILE FAILURE"),
        (material.failed.is_some(), "*FAILED MATERIAL"),
        (matches!(material.plastic, Some(PlasticityModel::Kinematic(_))), "HARDENING=KINEMATIC"),
        (material.rate.is_some() && material.has_user_hardening(), "*RATE DEPENDENT"),
    ];
    if let Some((_, other)) = beside.iter().find(|(there, _)| *there) {
        let message =
            format!("material `{}` has {reason} together with {other}, which is not supported", material.name);
        return report.refuse(Diagnostic::error("P041", message).at(material.span, "this material"));
    }
    let yields = match &material.plastic {
        None => YieldSource::Never,
        Some(PlasticityModel::User(properties)) => {
            let asks = format!("the hardening of `{}` is user-defined (*PLASTIC, HARDENING=USER)", material.name);
            report.require_routine(section.span, "section", &asks, "vuhard")?;
            YieldSource::User(properties.clone())
        }
        Some(PlasticityModel::OverFields(rows)) => yield_over_fields(input, rows, report)?,
        Some(plastic) => YieldSource::Law(Arc::new(yield_stress(plastic, material, section.span, report)?)),
    };
    Some((UserLaw::Flow(yields), moduli))
}

/// Checks that VUSDFLD is given if the material needs it; `None` if it is missing, which is an error.
fn require_field_routine(input: &GroupInput, report: &mut Report) -> Option<()> {
    let GroupInput { section, material, .. } = *input;
    let Some((properties, span)) = &material.user.fields else { return Some(()) };
    let asks = format!("the fields of `{}` are user-defined (*USER DEFINED FIELD)", material.name);
    report.require_routine(section.span, "section", &asks, "vusdfld")?;
    let detail = format!("vusdfld: {} constants, {} state variables", properties.len(), material.user.state.count);
    report.ledger_row(*span, "user-defined fields", 1, "material", detail);
    Some(())
}

/// Checks that VUCHARLENGTH is given if the material needs it; `None` if it is missing, which is an error.
pub fn require_length_routine(input: &GroupInput, takes: bool, report: &mut Report) -> Option<()> {
    let GroupInput { section, material, .. } = *input;
    let Some((properties, span)) = &material.user.lengths else { return Some(()) };
    if !takes {
        let why = "the material has no damage evolution, and no vumat or vusdfld that uses a length";
        report.add_unused_card(*span, "*CHARACTERISTIC LENGTH", why);
        return Some(());
    }
    let asks = format!("the characteristic length of `{}` is user-defined (*CHARACTERISTIC LENGTH)", material.name);
    report.require_routine(section.span, "section", &asks, "vucharlength")?;
    let detail = format!("vucharlength: {} constants", properties.len());
    report.ledger_row(*span, "characteristic length", 1, "material", detail);
    Some(())
}

fn user_rows(
    input: &GroupInput,
    law: &UserLaw,
    element_type: &'static str,
    constants: &ElementConstants,
    heating: &PlasticHeating,
    report: &mut Report,
) {
    let (section, material, count) = (input.section, input.material, input.elements.len());
    let name = &material.name;
    let heated = if heating.is_none() { "" } else { ", heated by inelastic work" };
    let variables = material.user.state.count;
    let elasticity = match law {
        UserLaw::Stress(..) => "user-defined, Jaumann rate",
        UserLaw::Energy(..) => "rubber with fibres, total deformation",
        UserLaw::Flow(_) => "elastic, Jaumann rate",
    };
    let detail = format!("material {name}, {elasticity}");
    report.ledger_row(section.span, "deformable elements", count, element_type, detail);
    match law {
        UserLaw::Stress(properties, who) => {
            let detail = format!("{who}: {} constants, {variables} state variables{heated}", properties.len());
            report.ledger_row(section.span, "user material", count, "points", detail);
        }
        UserLaw::Energy(properties, who) => {
            let (constants, families) = (properties.len(), material.user.energy.map_or(0, |energy| energy.families));
            let detail =
                format!("{who}: {constants} constants, {variables} state variables, families of fibres: {families}");
            report.ledger_row(section.span, "strain energy of fibres", count, "points", detail);
        }
        UserLaw::Flow(YieldSource::User(properties)) => {
            let detail = format!("vuhard: {} constants, {variables} state variables{heated}", properties.len());
            report.ledger_row(section.span, "plasticity", count, "elements", detail);
        }
        UserLaw::Flow(YieldSource::OverFields(law)) => {
            let fields = law.fields;
            let rate = if law.factor.is_some() { ", rate dependent" } else { "" };
            let detail = format!("tabular isotropic over {fields} field variables{rate}{heated}");
            report.ledger_row(section.span, "plasticity", count, "elements", detail);
        }
        UserLaw::Flow(YieldSource::Law(_)) => {
            let detail = format!("built-in yield stress, point by point{heated}");
            report.ledger_row(section.span, "plasticity", count, "elements", detail);
        }
        UserLaw::Flow(YieldSource::Never) => {}
    }
    control_rows(section, (count, element_type), constants, report);
}

/// Iterates over the materials of deformable elements.
pub fn materials_present(scene: Scene<'_>) -> impl Iterator<Item = &MaterialDefinition> {
    let deforms = |s: &&SolidSection| s.elements.iter().any(|e| scene.places.elements.contains_key(e));
    scene.model.sections.iter().filter(deforms).map(|s| &scene.model.materials[s.material])
}

/// Returns the maximum number of state variables of a material in this model.
pub fn state_variables(scene: Scene) -> usize {
    materials_present(scene).filter(|m| calls_routines_at_points(m)).map(|m| m.user.state.count).max().unwrap_or(0)
}

/// Returns the name of a state variable (*DEPVAR); `None` if materials have different names for it.
pub fn state_name(scene: Scene<'_>, variable: usize) -> Option<&str> {
    let keeps = materials_present(scene).filter(|m| calls_routines_at_points(m) && m.user.state.count > variable);
    let mut names =
        keeps.map(|m| m.user.state_names.iter().find(|(v, _)| *v == variable).map(|(_, name)| name.as_str()));
    let first = names.next()??;
    names.all(|name| name == Some(first)).then_some(first)
}

/// Returns whether elements of the model can be deleted.
pub fn deletes(scene: Scene) -> bool {
    let deletes = |m: &MaterialDefinition| m.user.state.delete.is_some() || m.has_failure();
    let fragile = |s: &crate::model::CohesiveSection| s.controls.keep_failed_elements.is_none();
    !scene.model.erosions.is_empty()
        || materials_present(scene).any(deletes)
        || damaged_interfaces(scene.model).any(fragile)
}

/// Returns a card of a material whose law would be dropped in favour of `*USER MATERIAL`.
fn law_beside_user_material(material: &MaterialDefinition) -> Option<&'static str> {
    let laws = [
        (material.elastic.is_some() || material.shear_modulus.is_some(), "*ELASTIC"),
        (material.plastic.is_some(), "*PLASTIC"),
        (material.hyperelastic.is_some(), "*HYPERELASTIC"),
        (material.eos.is_some(), "*EOS"),
        (material.foam.shape.is_some(), "*CRUSHABLE FOAM"),
        (material.has_strength_law(), "a yield surface that depends on pressure, porosity or direction"),
        (material.rate.is_some(), "*RATE DEPENDENT"),
        (!material.failures.is_empty(), "*DAMAGE INITIATION or *SHEAR FAILURE"),
        (material.tensile_failure.is_some(), "*TENSILE FAILURE"),
        (material.failed.is_some(), "*FAILED MATERIAL"),
    ];
    laws.iter().find(|(there, _)| *there).map(|(_, card)| *card)
}

/// Returns tables of moduli over temperature and field variables; `None` if the moduli are constant.
fn elasticity(input: &GroupInput, report: &mut Report) -> Option<Arc<FieldElasticity>> {
    let rows = &input.material.elastic_table;
    let table_of = |value: usize| {
        let rows: Vec<Vec<f64>> = rows.iter().map(|r| [&r[value..=value], &r[2..]].concat()).collect();
        NestedTable::new(&rows)
    };
    let (young, ratio) = (table_of(0)?, table_of(1)?);
    let fields = rows.first()?.len() - 3;
    let detail = format!("{} rows over temperature and {fields} field variables", rows.len());
    report.ledger_row(input.section.span, "moduli", input.elements.len(), "elements", detail);
    Some(Arc::new(FieldElasticity { young, ratio, fields }))
}

/// Returns the table of the yield stress over field variables; an invalid table is an error.
fn yield_over_fields(input: &GroupInput, rows: &[Vec<f64>], report: &mut Report) -> Option<YieldSource> {
    let GroupInput { section, material, .. } = *input;
    let fields = rows.first().map_or(0, |r| r.len().saturating_sub(3));
    let table = NestedTable::new(rows).filter(|_| fields <= MOST_DEPENDENCIES);
    let Some(table) = table else {
        let message =
            format!("material `{}`: the rows of its table over field variables are not in order", material.name);
        return report.refuse(Diagnostic::error("P014", message).at(section.span, "the material of this section"));
    };
    Some(YieldSource::OverFields(Arc::new(YieldOverFields {
        table,
        factor: rate_factor(material.rate.as_ref()),
        fields,
    })))
}
