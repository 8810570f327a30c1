//! Laws whose strength depends on pressure, porosity or direction: builds the law of a material from its cards.

use crate::deck::{Diagnostic, Span};
use crate::element::solid_groups::SolidMaterial;
use crate::kernel::hardening::LinearTable;
use crate::kernel::moduli::ElasticModuli;
use crate::material::returns::ReturnMaterial;
use crate::material::returns::drucker_prager::{DruckerPrager, DruckerPragerShape, YieldTest};
use crate::material::returns::holmquist_johnson_cook::HolmquistJohnsonCook;
use crate::material::returns::johnson_holmquist::JohnsonHolmquist;
use crate::material::returns::law::StressReturn;
use crate::model::{DruckerPragerHardening, MaterialDefinition, RateDependence, StrengthCards};
use crate::plan::Report;
use crate::plan::solids::solid_material::{SolidProperties, rate_factor};

/// A law, or the reason why the cards do not give one, with the place.
type LawOrFault = Result<Box<dyn StressReturn>, StrengthFault>;

/// Reason why the cards of a material do not give a law.
struct StrengthFault {
    message: String,
    span: Span,
    help: &'static str,
}

/// Creates a fault at a card.
fn fault<T>(span: Span, message: impl Into<String>, help: &'static str) -> Result<T, StrengthFault> {
    Err(StrengthFault { message: message.into(), span, help })
}

/// Selects the law of a material with cards of strength.
pub fn strength_law(solid: &SolidProperties, report: &mut Report) -> Option<SolidMaterial> {
    let SolidProperties { material, .. } = *solid;
    let (keyword, span) = material.strength.cards().next()?;
    match law(material).and_then(|law| check_other_cards(material).map(|()| law)) {
        Ok(law) => {
            report.ledger_row(span, "strength", 1, "material", law.describe());
            Some(SolidMaterial::Return(ReturnMaterial(law)))
        }
        Err(StrengthFault { message, span, help }) => {
            let message = format!("material `{}`: {message}", material.name);
            let finding = Diagnostic::error("P013", message).at(span, format!("in the cards of *{keyword}"));
            report.refuse(if help.is_empty() { finding } else { finding.help(help) })
        }
    }
}

/// Returns the moduli of a material whose law has its own constants of elasticity; `None` for others.
pub fn moduli_of_law(material: &MaterialDefinition) -> Option<ElasticModuli> {
    let StrengthCards { johnson_holmquist, holmquist_johnson_cook, .. } = &material.strength;
    if johnson_holmquist.is_none() && holmquist_johnson_cook.is_none() {
        return None;
    }
    law(material).ok().map(|law| law.moduli())
}

fn law(material: &MaterialDefinition) -> LawOrFault {
    let cards = &material.strength;
    if let Some((constants, span)) = &cards.johnson_holmquist {
        return johnson_holmquist(constants, *span);
    }
    if let Some((card, span)) = &cards.holmquist_johnson_cook {
        return holmquist_johnson_cook(&card.rows, *span);
    }
    if cards.drucker_prager.is_some() || cards.drucker_prager_hardening.is_some() {
        return drucker_prager(material);
    }
    let (_, span) = cards.cards().next().ok_or_else(|| StrengthFault {
        message: "no law".into(),
        span: material.span,
        help: "",
    })?;
    fault(span, "the card belongs to another card that is missing", "")
}

/// Refuses cards of other laws, which would have no effect.
fn check_other_cards(material: &MaterialDefinition) -> Result<(), StrengthFault> {
    let cards = &material.strength;
    let has_moduli = cards.johnson_holmquist.is_some() || cards.holmquist_johnson_cook.is_some();
    let takes_plastic = cards.potential.is_some() || cards.porous_metal.is_some();
    let others = [
        (has_moduli && material.elastic.is_some(), "*ELASTIC"),
        (material.shear_modulus.is_some(), "*ELASTIC, TYPE=SHEAR"),
        (material.eos.is_some(), "*EOS"),
        (material.hyperelastic.is_some(), "*HYPERELASTIC"),
        (material.foam.shape.is_some(), "*CRUSHABLE FOAM"),
        (!takes_plastic && material.plastic.is_some(), "*PLASTIC"),
        (cards.drucker_prager.is_none() && material.rate.is_some(), "*RATE DEPENDENT"),
        (!material.failures.is_empty(), "*DAMAGE INITIATION or *SHEAR FAILURE"),
        (material.tensile_failure.is_some(), "*TENSILE FAILURE"),
        (material.failed.is_some(), "*FAILED MATERIAL"),
        (material.thermal.expansion.is_some(), "*EXPANSION"),
    ];
    match others.iter().find(|(is_present, _)| *is_present) {
        Some((_, other)) => {
            let (keyword, span) = cards.cards().next().unwrap_or(("MATERIAL", material.span));
            fault(span, format!("*{keyword} together with {other} is not supported"), "remove one of the two cards")
        }
        None => Ok(()),
    }
}

/// Returns the moduli of `*ELASTIC`, which the law needs.
fn elasticity(material: &MaterialDefinition, span: Span) -> Result<ElasticModuli, StrengthFault> {
    match material.elastic {
        Some([young, ratio]) if material.elastic_table.is_empty() => Ok(ElasticModuli::from_young(young, ratio)),
        _ => fault(span, "the law needs *ELASTIC with one row", ""),
    }
}

fn johnson_holmquist(constants: &[f64], span: Span) -> LawOrFault {
    let &[_density, shear, a, n, b, m, c, rate, tension, most_intact, most_fractured, hel, phel, bulking, d1, d2, ..] =
        constants
    else {
        return fault(span, format!("ABQ_JH2 has 24 constants, found {}", constants.len()), "");
    };
    let &[most_strain, least_strain, deletion, _unused, k1, k2, k3] = &constants[16..constants.len().min(23)] else {
        return fault(span, format!("ABQ_JH2 has 24 constants, found {}", constants.len()), "");
    };
    // The scripts that write the card leave limits empty that do not apply.
    let limit = |value: f64| if value > 0.0 { value } else { f64::INFINITY };
    let positive = [(shear, "G"), (phel, "PHEL"), (hel - phel, "HEL - PHEL"), (k1, "K1"), (rate, "reference rate")];
    if let Some((value, name)) = positive.iter().find(|(value, _)| !(*value > 0.0)) {
        return fault(span, format!("{name} of ABQ_JH2 must be positive, found {value}"), "");
    }
    if !(0.0..=1.0).contains(&bulking) || tension < 0.0 {
        return fault(span, format!("beta must be 0 to 1 and T not negative, found {bulking} and {tension}"), "");
    }
    Ok(Box::new(JohnsonHolmquist {
        shear,
        intact: [a, n, limit(most_intact)],
        fractured: [b, m, limit(most_fractured)],
        rate: [c, rate],
        tension,
        elastic_limit: [hel, phel],
        bulking,
        fracture: [d1, d2],
        fracture_range: [least_strain, limit(most_strain)],
        compression: [k1, k2, k3],
        deletion,
    }))
}

fn holmquist_johnson_cook(rows: &[[f64; 8]], span: Span) -> LawOrFault {
    let [first, second, third] = rows else {
        return fault(span, format!("*HOLMQUIST JOHNSON COOK has three data lines, found {}", rows.len()), "");
    };
    let [shear, a, b, c, n, compressive, tension, rate] = *first;
    let [least_strain, largest_strength, crush_pressure, crush, lock_pressure, lock, d1, d2] = *second;
    let [k1, k2, k3, deletion, ..] = *third;
    let compacted = HolmquistJohnsonCook::compacted([lock_pressure, lock], [k1, k2, k3]);
    let Some(compacted) = compacted.filter(|compacted| lock_pressure > crush_pressure && *compacted > crush) else {
        return fault(span, "compaction must end at a larger pressure and compression than it begins", "check PC, UC, PL, UL, K1");
    };
    Ok(Box::new(HolmquistJohnsonCook {
        shear,
        strength: [a, b, n],
        largest_strength,
        compressive,
        rate: [c, rate],
        tension,
        fracture: [d1, d2, least_strain],
        crush: [crush_pressure, crush],
        lock: [lock_pressure, lock],
        compression: [k1, k2, k3],
        deletion,
        compacted,
    }))
}

fn drucker_prager(material: &MaterialDefinition) -> LawOrFault {
    let cards = &material.strength;
    let Some((card, span)) = &cards.drucker_prager else {
        return fault(material.span, "*DRUCKER PRAGER HARDENING without *DRUCKER PRAGER", "");
    };
    let Some((DruckerPragerHardening { test, rows }, _)) = &cards.drucker_prager_hardening else {
        return fault(*span, "*DRUCKER PRAGER without *DRUCKER PRAGER HARDENING", "");
    };
    let hardening = LinearTable { rows: rows.clone() };
    let (test, yield_stress) = (YieldTest::ALL[*test], hardening.value(0.0));
    let moduli = elasticity(material, *span)?;
    let [first, second, dilation] = card.row;
    let tangent = |degrees: f64| libm::tan(degrees.to_radians());
    let (friction, dilatancy) = (tangent(first), tangent(dilation));
    let shape = match card.form {
        0 => DruckerPragerShape::Linear { friction, ratio: if second == 0.0 { 1.0 } else { second } },
        1 => match DruckerPrager::apex(friction, second, test, yield_stress) {
            Some(apex) => DruckerPragerShape::Hyperbolic { friction, apex },
            None => return fault(*span, "no hyperbola has this tension strength and the first yield stress", ""),
        },
        _ => DruckerPragerShape::Exponent { factor: first, exponent: second },
    };
    if card.form < 2 && dilation > first {
        return fault(*span, format!("the dilation angle {dilation} exceeds the friction angle {first}: flow would create energy"), "");
    }
    if let DruckerPragerShape::Linear { ratio, .. } = shape && ratio < 0.778 {
        return fault(*span, format!("K must be 0.778 to 1, found {ratio}: the yield surface would not be convex"), "");
    }
    if matches!(material.rate, Some(RateDependence::JohnsonCook(_))) {
        return fault(*span, "the law supports *RATE DEPENDENT with POWER LAW or YIELD RATIO only", "");
    }
    let rate = rate_factor(material.rate.as_ref());
    let eccentricity = card.eccentricity;
    let law = DruckerPrager { shape, dilatancy, eccentricity, hardening, test, rate, moduli };
    if law.strength(0.0, 0.0) <= 0.0 {
        return fault(*span, "the cohesion is negative: tan(beta) is too large for this test", "");
    }
    Ok(Box::new(law))
}
