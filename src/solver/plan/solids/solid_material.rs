//! Materials of deformable solids: selects the material laws of an element group from the cards of its material.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::deck::{Diagnostic, Span};
use crate::element::constants::{ElementConstants, HourglassControl};
use crate::element::group::ElementGroup;
use crate::element::solid_groups::{Connectivity, GroupOptions, HardeningLaw, SolidMaterial, create_group};
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::kernel::hardening::{FlowStress, JohnsonCook, LinearTable, StaticYield, TableOverTemperature};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::levels::NestedTable;
use crate::kernel::moduli::ElasticModuli;
use crate::material::compaction::PorousCompaction;
use crate::material::eos::{IdealGas, Tabulated, UsUp};
use crate::material::equation_of_state::EquationOfState;
use crate::material::failed::KeptFailure;
use crate::material::failure::{
    CRITERIA, EvolutionLaw, FailureStrain, MaterialFailure, StrainCriterion, TensionCutoff,
};
use crate::material::kinematic::KinematicHardening;
use crate::material::kinematic_rate::RateKinematicHardening;
use crate::material::plasticity::{PiecewiseLinearHardening, RateDependentHardening};
use crate::material::user_eos::{EOS_TYPES, UserEos};
use crate::model::rates::{blocks, rate_factor};
use crate::model::{
    DamageEvolution, EosKind, FailedMaterial, FailureCriterion, HourglassMethod, MaterialDefinition, Model,
    PlasticityModel, PoreCompaction, RateDependence, SectionControls, SolidSection, StrainAtFailure,
};
use crate::plan::solids::soft_material::{explosive_law, foam_law, rubber_law};
use crate::plan::solids::solid_properties::SolidProperties;
use crate::plan::solids::strength::{moduli_of_law, spalling_law, spalls, strength_law};
use crate::plan::solids::user_material::{calls_routines_at_points, law_group, require_length_routine, user_group};
use crate::plan::{GroupInput, Report};

/// Default hourglass stiffness over the shear modulus (ABAQUS Analysis User's Guide, "Section controls": factor 0.005).
const HOURGLASS_STIFFNESS: f64 = 0.005;
/// Default hourglass viscosity, as a fraction of critical damping at the highest frequency of the element.
const HOURGLASS_VISCOSITY: f64 = 0.05;
/// Default hourglass viscosity of materials without shear modulus. With 0.05 the density of Noh's spherical implosion
/// overshoots after the shock (docs/verification.md).
const FLUID_VISCOSITY: f64 = 0.15;

/// Function that selects the law of a material; `None` if an error was reported.
type LawSelection = fn(&SolidProperties, &mut Report) -> Option<SolidMaterial>;

/// A family of materials: the condition under which it applies, and the selection of its law.
struct MaterialRow {
    applies: fn(&MaterialDefinition) -> bool,
    law: LawSelection,
}

/// Material families; the first row that applies is used. Laws of strength come first, since they refuse the cards of other
/// families. A new material is a file in `material`, a variant of [`SolidMaterial`] and a row here.
const MATERIALS: &[MaterialRow] = &[
    MaterialRow { applies: MaterialDefinition::has_strength_law, law: strength_law },
    MaterialRow { applies: |m| m.hyperelastic.is_some(), law: rubber_law },
    MaterialRow { applies: |m| m.foam.shape.is_some() || !m.foam.hardening.is_empty(), law: foam_law },
    MaterialRow { applies: spalls, law: spalling_law },
    MaterialRow { applies: |m| m.eos.is_some(), law: law_with_equation_of_state },
    MaterialRow { applies: |_| true, law: |solid, report| von_mises_law(solid, None, report) },
];

pub fn solid_group(input: &GroupInput, report: &mut Report) -> Option<Box<dyn ElementGroup>> {
    let GroupInput { model, section, material, connectivity, nodes, .. } = *input;
    let shear_viscosity = shear_viscosity(input, report)?;
    if let Some(constants) = &material.user.material
        && let Some(law) = report.routines.law(&material.name)
    {
        let law = Arc::clone(law);
        return law_group(input, constants, law, report);
    }
    if calls_routines_at_points(material) {
        if section.controls.by_area {
            let message = "WEIGHTING=AREA with user subroutines is not supported";
            return report.refuse(Diagnostic::error("P050", message).at(section.span, "this section"));
        }
        return user_group(input, report);
    }
    check_compaction(material, report)?;
    let evolves = material.failures.iter().any(FailureCriterion::takes_length);
    require_length_routine(input, evolves, report)?;
    let moduli = elastic_moduli(material, section.span, report)?;
    let density = material.density.unwrap_or(0.0);
    let hourglass = hourglass_control(input, moduli, report)?;
    let by_area = section.controls.by_area;
    let bulk_viscosity = bulk_viscosity(model, material.eos.is_some() || by_area);
    let ElasticModuli { bulk, shear } = moduli;
    let constants = ElementConstants { bulk, shear, hourglass, bulk_viscosity, shear_viscosity, by_area };
    let heats = model.is_adiabatic() || model.conducts_heat(section);
    solid_rows(input, &constants, heats, report);
    let (deletion_margin, keep_elements) = damage_limits(section, material, report);
    let subzonal = subzonal(input, report)?;
    let absolute_zero = model.settings.absolute_zero;
    let span = section.span;
    let solid = SolidProperties {
        material,
        span,
        constants,
        connectivity,
        nodes,
        density,
        heats,
        deletion_margin,
        keep_elements,
        absolute_zero,
    };
    let law = if by_area {
        check_by_area(input, report)?;
        von_mises_law(&solid, None, report)?
    } else {
        solid_law(&solid, report)?
    };
    Some(create_group(law, GroupOptions { constants, density, subzonal }, connectivity, nodes))
}

/// Selects the law of a material.
fn solid_law(solid: &SolidProperties, report: &mut Report) -> Option<SolidMaterial> {
    let material = solid.material;
    if !material.is_explosive() && !material.detonation.is_empty() {
        report.add_unused_card(material.span, "*DETONATION POINT", "it applies only to *EOS, TYPE=JWL");
    }
    let row = MATERIALS.iter().find(|row| (row.applies)(material))?;
    (row.law)(solid, report)
}

fn refuse_six_nodes(section: &SolidSection, with: &str, report: &mut Report) {
    let finding = Diagnostic::error("P024", format!("CAX6M with {with} is not supported"));
    report.push(finding.at(section.span, "this section").help("give CAX3 or CAX4R"));
}

/// Returns the hourglass control of a group. Six-node triangles have none, but need a shear modulus.
pub fn hourglass_control(input: &GroupInput, moduli: ElasticModuli, report: &mut Report) -> Option<HourglassControl> {
    let section = input.section;
    if let Connectivity::Quadrilaterals(_) = input.connectivity {
        return quad_hourglass(input, moduli, report);
    }
    if moduli.shear == 0.0 {
        refuse_six_nodes(section, "a material without a shear modulus", report);
    } else if section.controls.hourglass.is_some() {
        refuse_six_nodes(section, "HOURGLASS of *SECTION CONTROLS (the element has no hourglass modes)", report);
    } else {
        return Some(HourglassControl::NONE);
    }
    None
}

/// Returns the elastic moduli of a material. Missing or contradictory cards are errors.
pub fn elastic_moduli(material: &MaterialDefinition, span: Span, report: &mut Report) -> Option<ElasticModuli> {
    if material.density.is_some()
        && let Some(moduli) = moduli_of_law(material)
    {
        return Some(moduli);
    }
    let refusal = match material {
        MaterialDefinition { density: None, .. } => format!("material `{}` has no *DENSITY", material.name),
        MaterialDefinition {
            hyperelastic: Some(rubber),
            elastic: None,
            shear_modulus: None,
            eos: None,
            plastic,
            foam,
            ..
        } => {
            if plastic.is_none()
                && foam.shape.is_none()
                && material.failures.is_empty()
                && material.tensile_failure.is_none()
            {
                return Some(ElasticModuli { bulk: 0.0, shear: rubber.shape.shear() });
            }
            format!("material `{}` is rubber with plasticity or failure, which is not supported", material.name)
        }
        MaterialDefinition { hyperelastic: Some(_), .. } => {
            format!("material `{}` has *HYPERELASTIC and another elastic model", material.name)
        }
        MaterialDefinition { eos: Some(_), elastic: None, shear_modulus, plastic, .. } => {
            let shear = shear_modulus.unwrap_or(0.0);
            if plastic.is_none() || shear > 0.0 {
                return Some(ElasticModuli { bulk: 0.0, shear });
            }
            format!("material `{}` has *PLASTIC but no *ELASTIC, TYPE=SHEAR", material.name)
        }
        MaterialDefinition { eos: Some(_), .. } => {
            format!("material `{}` has both *EOS and a bulk modulus from *ELASTIC", material.name)
        }
        MaterialDefinition { elastic: Some(_), elastic_table, .. } if !elastic_table.is_empty() => {
            return Some(stiffest(elastic_table));
        }
        MaterialDefinition { elastic: Some([young, ratio]), .. } => {
            return Some(ElasticModuli::from_young(*young, *ratio));
        }
        MaterialDefinition { shear_modulus: Some(_), .. } => {
            format!("material `{}` has only a shear modulus: *EOS is missing", material.name)
        }
        MaterialDefinition { interface, .. } if interface.elastic.is_some() => {
            format!("material `{}` has *ELASTIC, TYPE=TRACTION, which is for cohesive elements", material.name)
        }
        MaterialDefinition { lamina: Some(_), .. } => {
            format!("material `{}` has *ELASTIC, TYPE=LAMINA, which is for shells", material.name)
        }
        _ => format!("material `{}` has no *ELASTIC", material.name),
    };
    report.refuse(Diagnostic::error("P013", refusal).at(span, "these elements are deformable"))
}

/// Returns the shear viscosity of a section, zero without `*VISCOSITY`, which requires a fluid: an equation of state
/// without shear modulus.
fn shear_viscosity(input: &GroupInput, report: &mut Report) -> Option<f64> {
    let GroupInput { section, material, .. } = *input;
    let Some((viscosity, span)) = material.viscosity else { return Some(0.0) };
    let is_fluid = material.eos.is_some() && material.shear_modulus.is_none() && material.plastic.is_none();
    if !is_fluid || calls_routines_at_points(material) || material.user.material.is_some() {
        let message = format!("*VISCOSITY of material `{}` requires *EOS and no shear strength", material.name);
        let finding = Diagnostic::error("P013", message).at(span, "this viscosity");
        let help = "for a solid use *RATE DEPENDENT, *DAMPING or *BULK VISCOSITY";
        return report.refuse(finding.at(section.span, "these elements").help(help));
    }
    report.ledger_row(span, "shear viscosity", 1, "material", format!("Newtonian fluid, {viscosity:e}"));
    Some(viscosity)
}

/// Refuses a compaction without the equation of state of the solid, or that does not fit it.
fn check_compaction(material: &MaterialDefinition, report: &mut Report) -> Option<()> {
    let Some(compaction) = &material.compaction else { return Some(()) };
    let PoreCompaction { speed, pressures: [begin, end], span, .. } = *compaction;
    let fault = match material.eos.as_ref().map(|eos| &eos.kind) {
        Some(EosKind::UsUp([c0, ..])) if speed > *c0 => {
            format!("the sound speed {speed} of the porous material exceeds that of the solid, {c0}")
        }
        Some(EosKind::UsUp(_)) if end <= begin => {
            format!("the compaction pressure {end} must exceed the elastic limit {begin}")
        }
        Some(EosKind::UsUp(_)) => return Some(()),
        _ => "*EOS COMPACTION needs *EOS, TYPE=USUP for the solid".to_owned(),
    };
    let message = format!("material `{}`: {fault}", material.name);
    report.refuse(Diagnostic::error("P013", message).at(span, "this compaction"))
}

/// Selects the law of a material with an equation of state.
fn law_with_equation_of_state(solid: &SolidProperties, report: &mut Report) -> Option<SolidMaterial> {
    let SolidProperties { material, span, density, .. } = *solid;
    let eos = material.eos.as_ref()?;
    let mut row = |detail| report.ledger_row(eos.span, "equation of state", 1, "material", detail);
    match (eos.kind.clone(), material.thermal.specific_heat.as_deref()) {
        (EosKind::IdealGas([gas_constant, ambient]), Some(&[[specific_heat, _]])) => {
            row(format!("ideal gas, gamma = {}", 1.0 + gas_constant / specific_heat));
            let absolute_zero = solid.absolute_zero;
            let law = IdealGas { gas_constant, specific_heat, ambient, absolute_zero };
            von_mises_law(solid, Some(EquationOfState::IdealGas(law)), report)
        }
        (EosKind::IdealGas(_), rows) => {
            let why = if rows.is_none() { "without *SPECIFIC HEAT" } else { "whose specific heat is not constant" };
            let message = format!("material `{}` is an ideal gas {why}", material.name);
            report.refuse(Diagnostic::error("P013", message).at(span, "these elements are deformable"))
        }
        (EosKind::UsUp([c0, s, gamma0]), _) if material.compaction.is_some() => {
            let PoreCompaction { speed, porosity, pressures, solid_density, .. } = material.compaction?;
            row(format!("Us = {c0} + {s} Up, Gamma0 = {gamma0}, porosity {porosity}"));
            let dense = UsUp { density: solid_density, c0, s, gamma0 };
            let law = PorousCompaction::new(dense, speed, porosity, pressures);
            von_mises_law(solid, Some(EquationOfState::Compacting(law)), report)
        }
        (EosKind::UsUp([c0, s, gamma0]), _) => {
            row(format!("Us = {c0} + {s} Up, Gamma0 = {gamma0}"));
            von_mises_law(solid, Some(EquationOfState::UsUp(UsUp { density, c0, s, gamma0 })), report)
        }
        (EosKind::Tabular(rows), _) => {
            row(format!("table of {} rows", rows.len()));
            von_mises_law(solid, Some(EquationOfState::Tabulated(Tabulated::new(density, &rows))), report)
        }
        (EosKind::Law(index, constants), _) => {
            let (name, law) = EOS_TYPES[index];
            row(format!("{name}, {} constants", constants.len()));
            let registered = || report.routines.equation_of_state(&material.name).cloned();
            let Some(law) = law.map_or_else(registered, |create| Some(create())) else {
                let message =
                    format!("material `{}` has *EOS, TYPE=USER, but no law in Rust is registered", material.name);
                let finding = Diagnostic::error("P041", message).at(eos.span, "this equation of state");
                return report.refuse(finding.help("register it with Routines::with_eos in a Rust program"));
            };
            if let Err(failure) = law.check(&constants) {
                let message =
                    format!("the law of material `{}` does not accept its constants: {failure}", material.name);
                return report.refuse(Diagnostic::error("P041", message).at(eos.span, "this equation of state"));
            }
            let law = UserEos::new(law, constants, density);
            von_mises_law(solid, Some(EquationOfState::User(law)), report)
        }
        (EosKind::Jwl(values), _) => {
            let law = explosive_law(solid, eos.span, &values, report)?;
            von_mises_law(solid, Some(EquationOfState::Explosive(law)), report)
        }
    }
}

/// Selects the plasticity and failure of a material with a constant bulk modulus or an equation of state.
fn von_mises_law(solid: &SolidProperties, eos: Option<EquationOfState>, report: &mut Report) -> Option<SolidMaterial> {
    Some(SolidMaterial::VonMises(hardening_law(solid, report)?, eos))
}

fn hardening_law(solid: &SolidProperties, report: &mut Report) -> Option<HardeningLaw> {
    let SolidProperties { material, span, .. } = *solid;
    let heating = if solid.heats { heating(material, solid.density) } else { PlasticHeating::None };
    let failing = material_failure(material, report)?.map(|failing| MaterialFailure {
        deletion_margin: solid.deletion_margin,
        keep_elements: solid.keep_elements,
        ..failing
    });
    let failed = failed_material(material, failing.as_ref(), report);
    let Some(plastic) = &material.plastic else {
        if let Some(failed) = failed {
            return no_failure(
                failed.span,
                "*FAILED MATERIAL keeps a fraction of the yield stress and needs *PLASTIC",
                report,
            );
        }
        return Some(HardeningLaw::Elastic(failing));
    };
    if let PlasticityModel::Kinematic(lines) = plastic {
        if failing.is_some() {
            // The dissipation of a damaged back stress is not defined.
            let message = "kinematic hardening with failure is not supported";
            return report.refuse(Diagnostic::error("P014", message).at(span, "the material of this section"));
        }
        if let ([[yield_stress, slope, _]], None, PlasticHeating::None) = (&lines[..], &material.rate, &heating) {
            let law = KinematicHardening { yield_stress: *yield_stress, slope: *slope };
            return Some(HardeningLaw::Kinematic(law));
        }
        let law = kinematic_hardening(lines, material.rate.as_ref(), heating);
        return Some(HardeningLaw::RateKinematic(law));
    }
    let law = yield_stress(plastic, material, span, report)?;
    if let Some(failure) = failing {
        let law = RateDependentHardening { law, heating };
        return Some(match failed {
            Some(failed) => HardeningLaw::Failing(law, kept_failure(failure, failed, solid, report)),
            None => HardeningLaw::RateDependent(law, Some(failure)),
        });
    }
    let cold = |rows: &[[f64; 3]]| rows.iter().all(|r| r[2].is_nan());
    if let (PlasticityModel::Tabular(rows), None, PlasticHeating::None) = (plastic, &material.rate, &heating)
        && cold(rows)
    {
        let mut rows: Vec<[f64; 2]> = rows.iter().map(|r| [r[0], r[1]]).collect();
        extrapolate(&mut rows, material);
        if let Some(lines) = PiecewiseLinearHardening::new(&rows, solid.constants.shear) {
            return Some(HardeningLaw::PiecewiseLinear(lines));
        }
    }
    Some(HardeningLaw::RateDependent(RateDependentHardening { law, heating }, None))
}

/// Returns 1 - MAX DEGRADATION, and whether elements that reach this damage are kept.
fn damage_limits(section: &SolidSection, material: &MaterialDefinition, report: &mut Report) -> (f64, bool) {
    let max_degradation = section.controls.max_degradation;
    let (deletion_margin, keep_elements) = (1.0 - max_degradation, section.controls.keep_failed_elements.is_some());
    let grows = material.failures.iter().any(|f| f.evolution != DamageEvolution::Absent);
    if grows && keep_elements {
        let detail = format!("MAX DEGRADATION {max_degradation}: the remaining stiffness is kept");
        report.ledger_row(section.span, "failed elements stay", section.elements.len(), "elements", detail);
    }
    if deletion_margin > 0.0 && !keep_elements && !grows {
        let why = format!("material {} has no damage evolution", material.name);
        report.add_unused_card(section.span, "MAX DEGRADATION", why);
    }
    if section.controls.viscosity != 0.0 {
        report.add_unused_card(section.span, "VISCOSITY", "only the damage of cohesive elements is delayed");
    }
    (deletion_margin, keep_elements)
}

/// Returns whether a card of the deck changes the mesh of a section.
fn has_changing_mesh(model: &Model, section: &SolidSection) -> bool {
    let elements: BTreeSet<usize> = section.elements.iter().copied().collect();
    let remeshed = model.remeshings.iter().filter(|card| !card.automatic).map(|card| &card.elements);
    let adaptive = model.steps.iter().flat_map(|step| &step.adaptive).map(|domain| &domain.elements);
    remeshed.chain(adaptive).flatten().any(|element| elements.contains(element))
}

/// Returns whether the elements of a section have subzonal pressures: by default with an equation of state and
/// without shear modulus, if their mesh follows the material.
fn subzonal(input: &GroupInput, report: &mut Report) -> Option<bool> {
    let GroupInput { model, section, material, .. } = *input;
    let requested = section.controls.subzonal;
    let fluid = material.eos.is_some() && material.shear_modulus.is_none_or(|shear| shear == 0.0);
    if requested == Some(true) && !fluid {
        let message = "SUBZONAL=YES needs *EOS and no shear modulus";
        return report.refuse(Diagnostic::error("P016", message).at(section.span, "the controls of this section"));
    }
    let subzonal = fluid && requested.unwrap_or_else(|| !has_changing_mesh(model, section));
    if subzonal {
        let detail = "pressures from the density of the element quarters";
        report.ledger_row(section.span, "subzonal pressures", input.elements.len(), "elements", detail.into());
    }
    Some(subzonal)
}

/// Checks that a section supports WEIGHTING=AREA; `None` if an error was reported.
fn check_by_area(input: &GroupInput, report: &mut Report) -> Option<()> {
    let GroupInput { model, places, section, material, connectivity, .. } = *input;
    let triangles = matches!(connectivity, Connectivity::SixNodeTriangles(_));
    let refusal = if triangles {
        Some("WEIGHTING=AREA of CAX6M is not supported")
    } else if material.eos.is_some()
        || material.hyperelastic.is_some()
        || material.foam.shape.is_some()
        || material.has_strength_law()
    {
        Some("WEIGHTING=AREA needs *ELASTIC, and neither foam nor a yield surface that depends on pressure")
    } else if material.failed.is_some() {
        Some("WEIGHTING=AREA with *FAILED MATERIAL is not supported")
    } else if model.steps.iter().any(|s| s.bulk_viscosity.linear <= 0.0) {
        Some("WEIGHTING=AREA needs linear bulk viscosity: without it some modes are unstable")
    } else if model.sections.iter().any(|s| !s.controls.by_area) {
        Some("WEIGHTING=AREA in one section needs it in all")
    } else if !model.shell_sections.is_empty() {
        Some("WEIGHTING=AREA together with shells is not supported")
    } else if !model.cohesive_sections.is_empty() {
        Some("WEIGHTING=AREA together with cohesive elements is not supported")
    } else if !places.tied.is_empty() || model.scales_masses() {
        Some("WEIGHTING=AREA with tied rigid bodies or scaled masses is not supported")
    } else {
        None
    };
    if let Some(message) = refusal {
        return report.refuse(Diagnostic::error("P050", message).at(section.span, "this section"));
    }
    let detail = "equations of motion over the plane section; energy is conserved approximately";
    report.ledger_row(section.span, "area weighting", connectivity.count(), "elements", detail.into());
    Some(())
}

/// Returns the hourglass control of a section. The default is VISCOUS without a shear modulus, ENHANCED for rubber,
/// and RELAX STIFFNESS otherwise (ABAQUS Analysis User's Guide, "Section controls"; Keywords Guide, "SECTION
/// CONTROLS").
fn quad_hourglass(input: &GroupInput, moduli: ElasticModuli, report: &mut Report) -> Option<HourglassControl> {
    let GroupInput { section, material, .. } = *input;
    let fluid = moduli.shear == 0.0;
    let unsaid = match material.hyperelastic {
        _ if fluid => HourglassMethod::Viscous,
        Some(_) => HourglassMethod::Enhanced,
        None => HourglassMethod::RelaxStiffness,
    };
    let SectionControls { hourglass, factor, .. } = section.controls;
    let kind = hourglass.unwrap_or(unsaid);
    if fluid && kind != HourglassMethod::Viscous {
        let message = "hourglass control by stiffness needs a shear modulus";
        let finding = Diagnostic::error("P016", message).at(section.span, "the controls of this section");
        return report.refuse(finding.help("give HOURGLASS=VISCOUS, or no controls"));
    }
    let viscosity = factor * if fluid { FLUID_VISCOSITY } else { HOURGLASS_VISCOSITY };
    let stiffness = HOURGLASS_STIFFNESS * factor;
    let [stiffness, viscosity, enhanced] = match kind {
        HourglassMethod::RelaxStiffness | HourglassMethod::Stiffness => [stiffness, 0.0, 0.0],
        HourglassMethod::Viscous => [0.0, viscosity, 0.0],
        HourglassMethod::Combined(weight) => [weight * stiffness, (1.0 - weight) * viscosity, 0.0],
        HourglassMethod::Enhanced => [0.0, 0.0, factor],
    };
    let relaxes = matches!(kind, HourglassMethod::RelaxStiffness | HourglassMethod::Enhanced);
    Some(HourglassControl { stiffness, viscosity, relaxes, enhanced })
}

/// Returns the bulk viscosity, which all steps share; `whole_rate` if the linear term needs the whole rate.
pub fn bulk_viscosity(model: &Model, whole_rate: bool) -> BulkViscosity {
    let viscosity = model.steps.first().map(|s| s.bulk_viscosity).unwrap_or_default();
    if whole_rate { viscosity.unfiltered() } else { viscosity }
}

fn solid_rows(input: &GroupInput, constants: &ElementConstants, heats: bool, report: &mut Report) {
    let GroupInput { section, material, connectivity, elements, .. } = *input;
    let (count, kind) = (elements.len(), connectivity.element_type());
    let elasticity = match (&material.eos, constants.shear > 0.0) {
        _ if material.hyperelastic.is_some() => "rubber, total deformation",
        (Some(_), false) => "fluid",
        (Some(_), true) => "equation of state and shear modulus, Jaumann rate",
        (None, _) => "elastic, Jaumann rate",
    };
    let detail = format!("material {}, {elasticity}", material.name);
    report.ledger_row(section.span, "deformable elements", count, kind, detail);
    if let Some(plastic) = &material.plastic {
        let law = match plastic {
            PlasticityModel::Tabular(_) => "tabular isotropic",
            PlasticityModel::JohnsonCook(_) => "Johnson-Cook",
            PlasticityModel::Kinematic(_) => "linear kinematic",
            PlasticityModel::User(_) => "user-defined",
            PlasticityModel::OverFields(_) => "over field variables",
        };
        let rate = if material.rate.is_some() { ", rate dependent" } else { "" };
        let heat = if heats && !heating(material, 1.0).is_none() { ", heated by plastic work" } else { "" };
        report.ledger_row(section.span, "plasticity", count, "elements", format!("{law}{rate}{heat}"));
    }
    control_rows(section, (count, kind), constants, report);
}

/// Creates the ledger rows of hourglass control and bulk viscosity.
pub fn control_rows(
    section: &SolidSection,
    (count, element_type): (usize, &str),
    constants: &ElementConstants,
    report: &mut Report,
) {
    if element_type != "CAX6M" {
        let HourglassControl { stiffness, viscosity, relaxes, enhanced } = constants.hourglass;
        let kind = if relaxes { "relax stiffness" } else { "stiffness" };
        let detail = if enhanced > 0.0 {
            format!("enhanced: assumed strains by direction, factor {enhanced}")
        } else {
            format!("{kind} {stiffness} G, viscosity {viscosity}")
        };
        report.ledger_row(section.span, "hourglass control", count, "elements", detail);
    }
    if !constants.bulk_viscosity.is_none() {
        report.ledger_row(section.span, "bulk viscosity", count, "elements", constants.bulk_viscosity.detail());
    }
}

/// Returns the failure model of a material: `Some(None)` without failure, `None` if an error was reported.
fn material_failure(material: &MaterialDefinition, report: &mut Report) -> Option<Option<MaterialFailure>> {
    let mut failing = MaterialFailure::default();
    for criterion in &material.failures {
        let evolution = match criterion.evolution {
            DamageEvolution::Sudden => EvolutionLaw::Sudden,
            DamageEvolution::Displacement(value) => EvolutionLaw::Displacement(value),
            DamageEvolution::Energy(value) => EvolutionLaw::Energy(value),
            DamageEvolution::Strain(critical, length) => EvolutionLaw::Strain(critical, length),
            // Other plasticity models do not evaluate the criterion, and it has no effect on the stress.
            DamageEvolution::Absent
                if !matches!(material.plastic, Some(PlasticityModel::Tabular(_) | PlasticityModel::JohnsonCook(_))) =>
            {
                let why = "without *DAMAGE EVOLUTION it does not affect the stress";
                report.add_unused_card(criterion.span, "*DAMAGE INITIATION", why);
                continue;
            }
            DamageEvolution::Absent => EvolutionLaw::Absent,
        };
        if material.plastic.is_none() {
            return no_failure(criterion.span, "failure criteria based on plastic strain need *PLASTIC", report);
        }
        let strain = failure_strain(material, criterion, report)?;
        let detail = match criterion.evolution {
            DamageEvolution::Displacement(value) => format!("damage over a displacement of {value}"),
            DamageEvolution::Energy(value) => format!("damage over an energy of {value} per area"),
            DamageEvolution::Strain(critical, None) => format!("damage from the start up to {critical}"),
            DamageEvolution::Strain(critical, Some(length)) => {
                format!("damage from the start up to {critical}, for elements of length {length}")
            }
            DamageEvolution::Absent => "evaluated without damage (DMICRT)".into(),
            DamageEvolution::Sudden => "immediate".into(),
        };
        let effect = if evolution == EvolutionLaw::Absent { "damage initiation" } else { "failure" };
        report.ledger_row(criterion.span, effect, 1, "criterion", detail);
        failing.criteria.push(StrainCriterion { strain, evolution });
    }
    if failing.criteria.len() > CRITERIA {
        return no_failure(material.span, "more than three failure criteria are not supported", report);
    }
    if let Some(tensile) = material.tensile_failure {
        if !tensile.deletes && material.eos.is_none() {
            return no_failure(tensile.span, "WEIGHTING=AREA with a tensile cutoff without deletion", report);
        }
        if !tensile.deletes && (tensile.loses_shear || tensile.loses_tension) {
            return no_failure(
                tensile.span,
                "BRITTLE failure without deletion needs *ELASTIC in place of *EOS",
                report,
            );
        }
        if tensile.deletes && (tensile.loses_shear || tensile.loses_tension) {
            report.add_unused_card(tensile.span, "*TENSILE FAILURE, BRITTLE", "failed elements are deleted");
        }
        let end = if tensile.deletes { "deletion" } else { "cutoff" };
        report.ledger_row(tensile.span, "tensile failure", 1, "criterion", format!("{end} at {}", tensile.cutoff));
        failing.cutoff = Some(TensionCutoff { stress: tensile.cutoff, deletes: tensile.deletes });
    }
    failing.keeps_pressure = failing.criteria.iter().any(StrainCriterion::is_coupled);
    Some((!failing.criteria.is_empty() || failing.cutoff.is_some()).then_some(failing))
}

/// Returns what remains of failed elements, if the material fails.
fn failed_material(
    material: &MaterialDefinition,
    failing: Option<&MaterialFailure>,
    report: &mut Report,
) -> Option<FailedMaterial> {
    let failed = material.failed?;
    if failing.is_some_and(MaterialFailure::can_fail) {
        return Some(failed);
    }
    report.add_unused_card(failed.span, "*FAILED MATERIAL", "the material does not fail");
    None
}

/// Returns the failure of a material whose failed elements stay.
fn kept_failure(
    failure: MaterialFailure,
    failed: FailedMaterial,
    solid: &SolidProperties,
    report: &mut Report,
) -> KeptFailure {
    let FailedMaterial { residual, crossings, span } = failed;
    let detail = format!("pressure, {residual} of the shear strength after {crossings} crossings of a wave");
    report.ledger_row(span, "failed elements stay", 1, "material", detail);
    let ElementConstants { bulk, shear, .. } = solid.constants;
    let speed = ((bulk + 4.0 / 3.0 * shear) / solid.density).sqrt() / crossings;
    KeptFailure { failure, residual, speed }
}

fn no_failure<T>(span: Span, message: &str, report: &mut Report) -> Option<T> {
    report.refuse(Diagnostic::error("P019", message).at(span, "here"))
}

fn failure_strain(
    material: &MaterialDefinition,
    criterion: &FailureCriterion,
    report: &mut Report,
) -> Option<FailureStrain> {
    Some(match &criterion.strain {
        StrainAtFailure::Constant(strain) => FailureStrain::Constant(*strain),
        // The model has checked the tables.
        StrainAtFailure::Ductile(rows) => FailureStrain::Ductile(NestedTable::new(rows)?),
        StrainAtFailure::Shear(rows) => FailureStrain::Shear(NestedTable::new(rows)?),
        StrainAtFailure::JohnsonCook(d, Some([melt, transition, reference])) => {
            FailureStrain::JohnsonCook { d: *d, melt: *melt, transition: *transition, reference: *reference }
        }
        StrainAtFailure::JohnsonCook(d, None) => {
            let (melt, transition) = match material.plastic {
                Some(PlasticityModel::JohnsonCook([.., melt, transition])) => (melt, transition),
                _ if d[4] != 0.0 => {
                    return no_failure(criterion.span, "d5 needs *PLASTIC, HARDENING=JOHNSON COOK", report);
                }
                _ => (0.0, 0.0),
            };
            let reference = match material.rate {
                Some(RateDependence::JohnsonCook([_, reference])) => reference,
                _ if d[3] != 0.0 => {
                    return no_failure(criterion.span, "d4 needs *RATE DEPENDENT, TYPE=JOHNSON COOK", report);
                }
                _ => 1.0,
            };
            FailureStrain::JohnsonCook { d: *d, melt, transition, reference }
        }
    })
}

pub fn yield_stress(
    plastic: &PlasticityModel,
    material: &MaterialDefinition,
    span: Span,
    report: &mut Report,
) -> Option<FlowStress> {
    let base = match plastic {
        // These types have other laws.
        PlasticityModel::Kinematic(_) | PlasticityModel::User(_) | PlasticityModel::OverFields(_) => return None,
        PlasticityModel::JohnsonCook([a, b, n, m, melt, transition]) => {
            let law = JohnsonCook { a: *a, b: *b, n: *n, m: *m, melt: *melt, transition: *transition };
            StaticYield::JohnsonCook(law)
        }
        PlasticityModel::Tabular(rows) => {
            let mut tables = match tables(rows) {
                Ok(tables) => tables,
                Err(message) => {
                    return report.refuse(Diagnostic::error("P014", message).at(span, "the material of this section"));
                }
            };
            tables.iter_mut().for_each(|(_, table)| extrapolate(&mut table.rows, material));
            StaticYield::Tables(TableOverTemperature { tables })
        }
    };
    Some(FlowStress { base, factor: rate_factor(material.rate.as_ref()) })
}

/// Returns the largest moduli of a table. The linear interpolation between its rows does not exceed them.
fn stiffest(rows: &[Vec<f64>]) -> ElasticModuli {
    let moduli = rows.iter().map(|row| ElasticModuli::from_young(row[0], row[1]));
    moduli.fold(ElasticModuli::default(), |largest, next| ElasticModuli {
        bulk: largest.bulk.max(next.bulk),
        shear: largest.shear.max(next.shear),
    })
}

/// Creates kinematic hardening from rows of yield stress, hardening modulus and temperature.
fn kinematic_hardening(
    lines: &[[f64; 3]],
    rate: Option<&RateDependence>,
    heating: PlasticHeating,
) -> RateKinematicHardening {
    let size = |line: &[f64; 3]| (line[2], LinearTable { rows: vec![[line[0], 0.0]] });
    let slope = LinearTable { rows: lines.iter().map(|l| [l[1], l[2]]).collect() };
    let base = StaticYield::Tables(TableOverTemperature { tables: lines.iter().map(size).collect() });
    RateKinematicHardening { size: FlowStress { base, factor: rate_factor(rate) }, slope, heating }
}

/// Splits rows of yield stress, plastic strain and temperature (NaN if absent) into one table per temperature.
fn tables(rows: &[[f64; 3]]) -> Result<Vec<(f64, LinearTable)>, &'static str> {
    if rows.iter().any(|r| r[2].is_nan()) && !rows.iter().all(|r| r[2].is_nan()) {
        return Err("either all rows of a table must have a temperature, or none");
    }
    let tables = blocks(rows);
    if tables.windows(2).any(|w| w[0].0 > w[1].0) {
        return Err("temperatures must ascend");
    }
    let starts = |t: &LinearTable| t.rows.first().is_some_and(|r| r[1] == 0.0);
    let ascends = |t: &LinearTable| t.rows.windows(2).all(|w| w[1][1] > w[0][1]);
    if tables.is_empty() || !tables.iter().all(|(_, t)| starts(t) && ascends(t)) {
        return Err("plastic strains must start at 0 and ascend");
    }
    Ok(tables)
}

/// Plastic strain up to which a yield stress is extrapolated; beyond any strain of a simulation.
const FAR: f64 = 1e3;

/// Applies `EXTRAPOLATION=LINEAR`: continues the slope of the last two rows; a negative slope ends at zero stress.
fn extrapolate(rows: &mut Vec<[f64; 2]>, material: &MaterialDefinition) {
    let [.., before, last] = rows[..] else { return };
    if !material.extrapolates {
        return;
    }
    let slope = (last[0] - before[0]) / (last[1] - before[1]);
    if slope < 0.0 {
        rows.push([0.0, last[1] - last[0] / slope]);
    } else {
        rows.push([last[0] + slope * FAR, last[1] + FAR]);
    }
}

/// Returns the temperature increase per plastic work per volume; `None` variant if a card for it is missing.
pub fn heating(material: &MaterialDefinition, density: f64) -> PlasticHeating {
    match (material.thermal.inelastic_heat_fraction, material.thermal.specific_heat.as_deref()) {
        (Some(fraction), Some(&[[heat, _]])) if fraction != 0.0 => {
            PlasticHeating::Constant(fraction / (density * heat))
        }
        (Some(fraction), Some(rows)) if fraction != 0.0 => {
            PlasticHeating::Over { heat: fraction / density, capacity: LinearTable { rows: rows.to_vec() } }
        }
        _ => PlasticHeating::None,
    }
}
