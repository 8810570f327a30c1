//! Laws whose strength depends on pressure, porosity or direction: builds the law of a material from its cards.

use super::concrete_law::concrete_law;
use super::rates::rate_factor;
use super::types::{
    DruckerPrager as DruckerPragerCard, DruckerPragerHardening, MaterialDefinition, PlasticityModel, RateDependence,
    tangent,
};
use crate::deck::Span;
use crate::kernel::hardening::{LinearTable, RateFactor};
use crate::kernel::moduli::ElasticModuli;
use crate::material::returns::cap::CapPlasticity;
use crate::material::returns::drucker_prager::{DruckerPrager, DruckerPragerShape, YieldTest};
use crate::material::returns::hill::HillPotential;
use crate::material::returns::holmquist_johnson_cook::HolmquistJohnsonCook;
use crate::material::returns::johnson_holmquist::JohnsonHolmquist;
use crate::material::returns::law::StressReturn;
use crate::material::returns::porous_metal::{PorousMetal, VoidFailure, VoidNucleation};

/// A law from the cards of a material.
pub struct StrengthLaw {
    /// The law of a point.
    pub law: Box<dyn StressReturn>,
    /// Warning about the law in a mesh.
    pub warning: Option<StrengthWarning>,
}

/// Warning about a law in a mesh.
pub struct StrengthWarning {
    /// Code of the diagnostic.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub help: String,
}

/// A law, or the reason why the cards do not give one, with the place.
pub type LawOrFault = Result<StrengthLaw, StrengthFault>;

/// Reason why the cards of a material do not give a law.
pub struct StrengthFault {
    /// What is wrong.
    pub message: String,
    /// Place of the card.
    pub span: Span,
    /// What would be right; empty if the message says it.
    pub help: &'static str,
}

/// Creates a fault at a card.
pub fn fault<T>(span: Span, message: impl Into<String>, help: &'static str) -> Result<T, StrengthFault> {
    Err(StrengthFault { message: message.into(), span, help })
}

/// Builds the law of a material with cards of strength, for elements with lengths up to `longest`.
///
/// # Errors
/// If cards are missing or their values do not give a law.
pub fn strength_law(material: &MaterialDefinition, longest: f64) -> LawOrFault {
    let cards = &material.strength;
    let law: Box<dyn StressReturn> = if let Some((constants, span)) = &cards.johnson_holmquist {
        Box::new(johnson_holmquist(constants, *span)?)
    } else if let Some((card, span)) = &cards.holmquist_johnson_cook {
        Box::new(holmquist_johnson_cook(&card.rows, *span)?)
    } else if cards.drucker_prager.is_some() || cards.drucker_prager_hardening.is_some() {
        let warning = cards.drucker_prager.as_ref().and_then(|(card, _)| unused_eccentricity(card));
        return Ok(StrengthLaw { law: Box::new(drucker_prager(material)?), warning });
    } else if cards.cap.is_some() || cards.cap_hardening.is_some() {
        return cap(material);
    } else if cards.porous_metal.is_some() || cards.void_nucleation.is_some() || cards.porous_failure.is_some() {
        Box::new(porous_metal(material)?)
    } else if let Some((card, span)) = &cards.potential {
        let [rr, zz, hoop, shear, ..] = card.ratios;
        let (hardening, moduli) = (yield_table(material, *span)?, elasticity(material, *span)?);
        match HillPotential::new([rr, zz, hoop, shear], hardening, moduli) {
            Some(law) => Box::new(law),
            None => return fault(*span, "the ratios give a yield surface that is not closed", ""),
        }
    } else {
        return concrete_law(material, longest);
    };
    Ok(StrengthLaw { law, warning: None })
}

/// Returns the moduli of `*ELASTIC`, which the law needs.
pub fn elasticity(material: &MaterialDefinition, span: Span) -> Result<ElasticModuli, StrengthFault> {
    match material.elastic {
        Some([young, ratio]) if material.elastic_table.is_empty() => Ok(ElasticModuli::from_young(young, ratio)),
        _ => fault(span, "the law needs *ELASTIC with one row", ""),
    }
}

fn johnson_holmquist(constants: &[f64], span: Span) -> Result<JohnsonHolmquist, StrengthFault> {
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
    if let Some((value, name)) = positive.iter().find(|(value, _)| *value <= 0.0 || value.is_nan()) {
        return fault(span, format!("{name} of ABQ_JH2 must be positive, found {value}"), "");
    }
    if !(0.0..=1.0).contains(&bulking) || tension < 0.0 {
        return fault(span, format!("beta must be 0 to 1 and T not negative, found {bulking} and {tension}"), "");
    }
    Ok(JohnsonHolmquist {
        shear,
        intact: [a, n, limit(most_intact)],
        fractured: [b, m, limit(most_fractured)],
        rate: RateFactor::JohnsonCook { c, reference: rate },
        tension,
        elastic_limit: [hel, phel],
        bulking,
        fracture: [d1, d2],
        fracture_range: [least_strain, limit(most_strain)],
        compression: [k1, k2, k3],
        deletion,
    })
}

fn holmquist_johnson_cook(rows: &[[f64; 8]], span: Span) -> Result<HolmquistJohnsonCook, StrengthFault> {
    let [first, second, third] = rows else {
        return fault(span, format!("*HOLMQUIST JOHNSON COOK has three data lines, found {}", rows.len()), "");
    };
    let [shear, a, b, c, n, compressive, tension, rate] = *first;
    let [least_strain, largest_strength, crush_pressure, crush, lock_pressure, lock, d1, d2] = *second;
    let [k1, k2, k3, deletion, ..] = *third;
    let compacted = HolmquistJohnsonCook::compacted([lock_pressure, lock], [k1, k2, k3]);
    let Some(compacted) =
        compacted.filter(|compacted| lock_pressure > crush_pressure && *compacted > crush && lock >= crush)
    else {
        return fault(
            span,
            "compaction must end at a larger pressure and compression than it begins",
            "check PC, UC, PL, UL, K1",
        );
    };
    Ok(HolmquistJohnsonCook {
        shear,
        strength: [a, b, n],
        largest_strength,
        compressive,
        rate: RateFactor::JohnsonCook { c, reference: rate },
        tension,
        fracture: [d1, d2, least_strain],
        crush: [crush_pressure, crush],
        lock: [lock_pressure, lock],
        compression: [k1, k2, k3],
        deletion,
        compacted,
    })
}

fn cap(material: &MaterialDefinition) -> LawOrFault {
    let cards = &material.strength;
    let Some((card, span)) = &cards.cap else {
        return fault(material.span, "*CAP HARDENING without *CAP PLASTICITY", "");
    };
    let Some((hardening, hardening_span)) = &cards.cap_hardening else {
        return fault(*span, "*CAP PLASTICITY without *CAP HARDENING", "");
    };
    let [cohesion, angle, eccentricity, compaction, transition] = card.row;
    if hardening.rows.len() > 1
        && hardening.rows.iter().all(|row| row[0] < 1.0)
        && hardening.rows[hardening.rows.len() - 1][1] > 1.0
    {
        let help = "exchange the columns: pressure first, then compaction";
        return fault(*hardening_span, "pressures look like strains, and strains like pressures", help);
    }
    let friction = tangent(angle);
    let hardening = LinearTable { rows: hardening.rows.clone() };
    let moduli = elasticity(material, *span)?;
    let centre = (hardening.value(compaction) - eccentricity * cohesion) / (1.0 + eccentricity * friction);
    // The published flow potential dissipates q²/m² - p (pa - p) tan²(beta), for all p up to pa.
    let warning = (cohesion < DISSIPATING_COHESION * centre * friction).then(|| StrengthWarning {
        code: "P150",
        message: format!("a cohesion of {cohesion} lets plastic flow at low pressure create energy"),
        help: format!("give at least {:.3e}", DISSIPATING_COHESION * centre * friction),
    });
    let law = CapPlasticity { cohesion, friction, eccentricity, transition, compaction, hardening, moduli };
    Ok(StrengthLaw { law: Box::new(law), warning })
}

/// Cohesion over the strength pa tan(beta) from which flow on the failure surface dissipates at all pressures, (sqrt(2) - 1)/2.
const DISSIPATING_COHESION: f64 = 0.2071;

fn porous_metal(material: &MaterialDefinition) -> Result<PorousMetal, StrengthFault> {
    let cards = &material.strength;
    let Some((card, span)) = &cards.porous_metal else {
        let (keyword, span) = cards.cards().next().unwrap_or(("VOID NUCLEATION", material.span));
        return fault(span, format!("*{keyword} without *POROUS METAL PLASTICITY"), "");
    };
    let failure = match &cards.porous_failure {
        Some((criteria, failure_span)) => {
            let [failure, critical] = criteria.row;
            if critical >= failure || card.row[2] <= 0.0 {
                let message = "the void fraction at failure must exceed the critical one, and q3 must be positive";
                return fault(*failure_span, message, "the fraction at failure is the first value");
            }
            Some(VoidFailure { critical, failure })
        }
        None => None,
    };
    let nucleation = cards.void_nucleation.as_ref().map(|(card, _)| {
        let [mean, deviation, fraction] = card.row;
        VoidNucleation { mean, deviation, fraction }
    });
    Ok(PorousMetal {
        constants: card.row,
        voids: 1.0 - card.relative_density,
        hardening: yield_table(material, *span)?,
        nucleation,
        failure,
        moduli: elasticity(material, *span)?,
    })
}

/// Returns the yield stress over plastic strain of `*PLASTIC`, which the law needs.
pub fn yield_table(material: &MaterialDefinition, span: Span) -> Result<LinearTable, StrengthFault> {
    match &material.plastic {
        Some(PlasticityModel::Tabular(rows)) if rows.iter().all(|row| row[2].is_nan()) => {
            let rows = rows.iter().map(|row| [row[0], row[1]]).collect();
            Ok(LinearTable { rows })
        }
        Some(_) => {
            fault(span, "the law needs *PLASTIC with isotropic hardening that does not depend on temperature", "")
        }
        None => fault(span, "the law needs *PLASTIC", ""),
    }
}

/// Returns the warning that the flow potential of the linear form has no rounding.
fn unused_eccentricity(card: &DruckerPragerCard) -> Option<StrengthWarning> {
    let eccentricity = card.eccentricity.filter(|_| card.form == 0)?;
    let message = format!("ECCENTRICITY={eccentricity} has no effect with SHEAR CRITERION=LINEAR");
    let help = "remove it, or give SHEAR CRITERION=HYPERBOLIC or EXPONENT FORM".into();
    Some(StrengthWarning { code: "P140", message, help })
}

fn drucker_prager(material: &MaterialDefinition) -> Result<DruckerPrager, StrengthFault> {
    let cards = &material.strength;
    let Some((card, span)) = &cards.drucker_prager else {
        return fault(material.span, "*DRUCKER PRAGER HARDENING without *DRUCKER PRAGER", "");
    };
    let Some((DruckerPragerHardening { test, rows }, hardening_span)) = &cards.drucker_prager_hardening else {
        return fault(*span, "*DRUCKER PRAGER without *DRUCKER PRAGER HARDENING", "");
    };
    if rows[0][1] != 0.0 {
        return fault(*hardening_span, format!("plastic strains must start at 0, found {}", rows[0][1]), "");
    }
    let hardening = LinearTable { rows: rows.clone() };
    let (test, yield_stress) = (YieldTest::ALL[*test], hardening.value(0.0));
    let moduli = elasticity(material, *span)?;
    let [first, second, dilation] = card.row;
    let (friction, dilatancy) = (tangent(first), tangent(dilation));
    let shape = match card.form {
        0 => DruckerPragerShape::Linear { friction, ratio: card.ratio() },
        1 => match DruckerPrager::apex(friction, second, test, yield_stress) {
            Some(apex) => DruckerPragerShape::Hyperbolic { friction, apex },
            None => return fault(*span, "no hyperbola has this tension strength and the first yield stress", ""),
        },
        _ => DruckerPragerShape::Exponent { factor: first, exponent: second },
    };
    if card.form < 2 && dilation > first {
        return fault(
            *span,
            format!("the dilation angle {dilation} exceeds the friction angle {first}: flow would create energy"),
            "",
        );
    }
    if let DruckerPragerShape::Linear { ratio, .. } = shape
        && ratio < 0.778
    {
        return fault(*span, format!("K must be 0.778 to 1, found {ratio}: the yield surface would not be convex"), "");
    }
    if matches!(material.rate, Some(RateDependence::JohnsonCook(_))) {
        return fault(*span, "the law supports *RATE DEPENDENT with POWER LAW or YIELD RATIO only", "");
    }
    let rate = rate_factor(material.rate.as_ref());
    let eccentricity = card.eccentricity.unwrap_or(0.1);
    let law = DruckerPrager { shape, dilatancy, eccentricity, hardening, test, rate, moduli };
    if law.strength(0.0, 0.0) <= 0.0 {
        return fault(*span, "the cohesion is negative: tan(beta) is too large for this test", "");
    }
    Ok(law)
}
