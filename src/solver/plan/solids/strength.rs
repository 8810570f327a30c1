//! Laws whose strength depends on pressure, porosity or direction: builds the law of a material from its cards.

use crate::deck::Diagnostic;
use crate::element::solid_groups::SolidMaterial;
use crate::kernel::hardening::LinearTable;
use crate::kernel::moduli::ElasticModuli;
use crate::material::returns::ReturnMaterial;
use crate::material::returns::law::StressReturn;
use crate::material::returns::spall::SpallingSolid;
use crate::model::rates::depends_on_temperature;
use crate::model::strength_law::{self, StrengthFault, StrengthLaw, StrengthWarning, elasticity, fault, yield_table};
use crate::model::{MaterialDefinition, StrengthCards, TensileFailure};
use crate::plan::Report;
use crate::plan::solids::solid_properties::SolidProperties;

/// Reports the reason why the cards of a material do not give a law.
fn refuse<T>(fault: StrengthFault, material: &MaterialDefinition, keyword: &str, report: &mut Report) -> Option<T> {
    let StrengthFault { message, span, help } = fault;
    let message = format!("material `{}`: {message}", material.name);
    let finding = Diagnostic::error("P013", message).at(span, format!("in the cards of *{keyword}"));
    report.refuse(if help.is_empty() { finding } else { finding.help(help) })
}

/// Selects the law of a material with cards of strength.
pub fn strength_law(solid: &SolidProperties, report: &mut Report) -> Option<SolidMaterial> {
    let material = solid.material;
    let (keyword, span) = material.strength.cards().next()?;
    match strength_law::strength_law(material, solid.longest_element())
        .and_then(|law| check_other_cards(solid).map(|()| law))
    {
        Ok(StrengthLaw { law, warning }) => {
            report.ledger_row(span, "strength", 1, "material", law.describe());
            if let Some(StrengthWarning { code, message, help }) = warning {
                let message = format!("material `{}`: {message}", material.name);
                report.push(Diagnostic::warning(code, message).at(span, "this law").help(help));
            }
            let keeps_elements = solid.keep_elements && law.deletes();
            Some(SolidMaterial::Return(ReturnMaterial { law, keeps_elements }))
        }
        Err(fault) => refuse(fault, material, keyword, report),
    }
}

/// Returns whether failed elements stay and have no equation of state.
pub fn spalls(material: &MaterialDefinition) -> bool {
    material.tensile_failure.is_some_and(|failure| !failure.deletes) && material.eos.is_none()
}

/// Selects the law of a material with `*TENSILE FAILURE, ELEMENT DELETION=NO`.
pub fn spalling_law(solid: &SolidProperties, report: &mut Report) -> Option<SolidMaterial> {
    let SolidProperties { material, .. } = *solid;
    let TensileFailure { cutoff, loses_shear, loses_tension, span, .. } = material.tensile_failure?;
    let is_combined = !material.failures.is_empty() || material.failed.is_some() || material.rate.is_some();
    let parts = if is_combined {
        fault(span, "*TENSILE FAILURE without deletion and without *EOS needs *ELASTIC and *PLASTIC only", "")
    } else {
        elasticity(material, span).and_then(|moduli| {
            let hardening = match material.plastic {
                Some(_) => yield_table(material, span)?,
                None => LinearTable { rows: Vec::new() },
            };
            Ok(SpallingSolid { cutoff, loses_shear, loses_tension, hardening, moduli })
        })
    };
    match parts {
        Ok(law) => {
            report.ledger_row(span, "tensile failure", 1, "criterion", law.describe());
            Some(SolidMaterial::Return(ReturnMaterial { law: Box::new(law), keeps_elements: false }))
        }
        Err(fault) => refuse(fault, material, "TENSILE FAILURE", report),
    }
}

/// Returns the moduli of a material whose law has its own constants of elasticity; `None` for others.
pub fn moduli_of_law(material: &MaterialDefinition) -> Option<ElasticModuli> {
    let StrengthCards { johnson_holmquist, holmquist_johnson_cook, .. } = &material.strength;
    // An error of the constants is reported when the law is selected.
    let unknown = ElasticModuli { bulk: 1.0, shear: 1.0 };
    let has_moduli = johnson_holmquist.is_some() || holmquist_johnson_cook.is_some();
    has_moduli.then(|| material.small_strain_moduli(None).unwrap_or(unknown))
}

/// Returns the first card of the law to which a card belongs.
fn family(keyword: &'static str) -> &'static str {
    match keyword {
        "DRUCKER PRAGER HARDENING" => "DRUCKER PRAGER",
        "CAP HARDENING" => "CAP PLASTICITY",
        "VOID NUCLEATION" | "POROUS FAILURE CRITERIA" => "POROUS METAL PLASTICITY",
        _ if keyword.starts_with("CONCRETE ") => "CONCRETE DAMAGED PLASTICITY",
        _ => keyword,
    }
}

/// Refuses cards of other laws, which would have no effect.
fn check_other_cards(solid: &SolidProperties) -> Result<(), StrengthFault> {
    let material = solid.material;
    let cards = &material.strength;
    let has_moduli = cards.johnson_holmquist.is_some() || cards.holmquist_johnson_cook.is_some();
    let takes_plastic = cards.potential.is_some() || cards.porous_metal.is_some();
    let first = cards.cards().next().map_or("", |(keyword, _)| family(keyword));
    if let Some((keyword, span)) = cards.cards().find(|(keyword, _)| family(keyword) != first) {
        return fault(span, format!("*{keyword} belongs to another law than *{first}"), "a material has one law");
    }
    let others = [
        (has_moduli && material.elastic.is_some(), "*ELASTIC"),
        (material.shear_modulus.is_some(), "*ELASTIC, TYPE=SHEAR"),
        (material.eos.is_some(), "*EOS"),
        (material.hyperelastic.is_some(), "*HYPERELASTIC"),
        (material.foam.shape.is_some() || !material.foam.hardening.is_empty(), "*CRUSHABLE FOAM"),
        (!takes_plastic && material.plastic.is_some(), "*PLASTIC"),
        (cards.drucker_prager.is_none() && material.rate.is_some(), "*RATE DEPENDENT"),
        (material.rate.as_ref().is_some_and(depends_on_temperature), "*RATE DEPENDENT over temperature"),
        (!material.failures.is_empty(), "*DAMAGE INITIATION or *SHEAR FAILURE"),
        (material.tensile_failure.is_some(), "*TENSILE FAILURE"),
        (material.failed.is_some(), "*FAILED MATERIAL"),
        (material.thermal.expansion.is_some(), "*EXPANSION"),
        (
            solid.heats && material.thermal.inelastic_heat_fraction.is_some(),
            "*INELASTIC HEAT FRACTION in an analysis that heats the material",
        ),
    ];
    match others.iter().find(|(is_present, _)| *is_present) {
        Some((_, other)) => {
            let (keyword, span) = cards.cards().next().unwrap_or(("MATERIAL", material.span));
            fault(span, format!("*{keyword} together with {other} is not supported"), "remove one of the two cards")
        }
        None => Ok(()),
    }
}
