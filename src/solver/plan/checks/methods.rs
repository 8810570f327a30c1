//! Warnings of methods with unusual settings: friction coefficients, factors of the hourglass stiffness, bulk viscosity.

use super::finding::warn_about;
use crate::deck::Span;
use crate::model::{EosKind, HourglassMethod, MaterialDefinition, Model, SolidSection, Step};
use crate::plan::Report;

/// Friction coefficient above which a mistake is assumed: rubber has up to 1.2, clean metals in air up to 1.5.
pub const LARGEST_FRICTION: f64 = 1.5;
/// Usual factors on the hourglass stiffness (ABAQUS Keywords Reference Guide, *SECTION CONTROLS).
const HOURGLASS_FACTORS: [f64; 2] = [0.2, 3.0];

/// Warns of friction coefficients that no pair of materials has, and of hourglass factors and bulk viscosities outside their
/// usual range.
pub fn check_methods(model: &Model, report: &mut Report) {
    let mut pairs = model.steps.iter().flat_map(|step| &step.surface_contacts);
    let large = |friction: f64| friction > LARGEST_FRICTION && friction.is_finite();
    if let Some(pair) = pairs.find(|pair| large(pair.law.friction.at_rest)) {
        report_friction(pair.law.friction.at_rest, (pair.span, "this pair"), report);
    }
    let assigned = |step: &Step| {
        let laws = step.general_contact.iter().flat_map(|general| &general.assigned);
        laws.map(|assigned| assigned.law.friction.at_rest).find(|friction| large(*friction))
    };
    if let Some((step, friction)) = model.steps.iter().find_map(|step| Some((step, assigned(step)?))) {
        report_friction(friction, (step.span, "general contact of this step"), report);
    }
    let [least, most] = HOURGLASS_FACTORS;
    let is_stiffness =
        |method: Option<HourglassMethod>| !matches!(method, Some(HourglassMethod::Enhanced | HourglassMethod::Viscous));
    let tuned = |section: &&SolidSection| {
        let factor = section.controls.factor;
        factor != 0.0 && is_stiffness(section.controls.hourglass) && !(least..=most).contains(&factor)
    };
    if let Some(section) = model.sections.iter().find(tuned) {
        let message = format!(
            "the hourglass factor {} is outside {least} to {most}: hourglass control stiffens the elements, or does not hold them",
            section.controls.factor
        );
        let help = "leave out the factor on *SECTION CONTROLS, and use a finer mesh";
        warn_about("P143", message, (section.span, "this section"), help, report);
    }
    check_shock_viscosity(model, report);
}

/// Warns of a friction coefficient above [`LARGEST_FRICTION`].
pub fn report_friction(friction: f64, place: (Span, &str), report: &mut Report) {
    let message =
        format!("the friction coefficient {friction} is above {LARGEST_FRICTION}, which no pair of materials reaches");
    let help = "metals have 0.05 to 0.8, rubber up to 1.2; *FRICTION, ROUGH allows no slip";
    warn_about("P143", message, place, help, report);
}

/// Warns of a step without linear or quadratic bulk viscosity in a model with shocks, that is, with a Hugoniot.
fn check_shock_viscosity(model: &Model, report: &mut Report) {
    let is_shocked =
        |material: &&MaterialDefinition| matches!(material.eos.as_ref().map(|eos| &eos.kind), Some(EosKind::UsUp(_)));
    let mut used = model.sections.iter().filter_map(|section| model.materials.get(section.material.index()));
    let Some(material) = used.find(is_shocked) else { return };
    let missing = |linear: f64, quadratic: f64| match [linear == 0.0, quadratic == 0.0] {
        [true, true] => Some("no"),
        [true, false] => Some("no linear"),
        [false, true] => Some("no quadratic"),
        [false, false] => None,
    };
    for step in &model.steps {
        let Some(missing) = missing(step.bulk_viscosity.linear, step.bulk_viscosity.quadratic) else { continue };
        let message = format!(
            "step `{}` has {missing} bulk viscosity, and `{}` has an equation of state: shocks oscillate from element to element",
            step.name, material.name
        );
        let help = "use the default coefficients of *BULK VISCOSITY, 0.06 and 1.2";
        return warn_about("P143", message, (step.span, "this step"), help, report);
    }
}
