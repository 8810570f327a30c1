//! `*CAVITY EXPANSION, DERIVE`: cavity expansion constants from `*ELASTIC`, `*DENSITY`, `*PLASTIC` and `*RATE
//! DEPENDENT` of the same material. The computation is in `resistance`.

use super::context::Context;
use super::eos_law::eos_law;
use super::families::{DerivationRequest, MaterialReader};
use super::strength_law::{StrengthFault, strength_law};
use super::types::{
    CavityExpansion, MaterialDefinition, PlasticityModel, RateDependence, ResistanceDerivation, StrengthCards, tangent,
};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};
use crate::kernel::hardening::LinearTable;
use crate::material::returns::drucker_prager::{DruckerPragerShape, YieldTest};
use crate::material::returns::law::StressReturn;
use crate::resistance::fit::FitWeight;
use crate::resistance::rate::{StrainRateEffect, StrainRateFactor};
use crate::resistance::{
    CavityShape, DerivedResistance, ExpansionTarget, FitRequest, LawTarget, ResistanceError, ScaledTarget,
    TargetMaterial, TargetScale, TargetSizes, YieldCurve, derive,
};

/// Number of rows with which a yield curve is tabulated, and their range of plastic strain in addition to 0. The
/// strains form a geometric series with steps of about 1/9; interpolation errors are below 0.1 %.
const ROWS: i32 = 140;
const STRAINS: [f64; 2] = [1e-5, 30.0];

/// Stores the request until the other cards of the material are read.
pub(super) fn derivation(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    let values: cards::CavityExpansion = card.values();
    // A target checks that its materials have a resistance; the constants follow after all cards are read.
    context.last_material().cavity =
        Some(CavityExpansion { yield_stress: 0.0, a: 0.0, b: 0.0, c: 0.0, derived: None, span: card.span });
    if let Some(word) = card.value("YIELD") {
        let message = "DERIVE takes Y from the first row of *PLASTIC, not from YIELD";
        return context.out_of_range(word.span, message);
    }
    let [from, to, points] = values.values;
    let weight = [FitWeight::Even, FitWeight::Relative, FitWeight::Velocity][values.weight];
    // Invalid numbers of points become 0, which the fit reports.
    let points = (!points.is_nan()).then_some(if points.fract() == 0.0 { points as usize } else { 0 });
    let request = FitRequest { range: [from, to], points, linear: values.linear, pinned: values.pinned, weight };
    let material = context.model.materials.len() - 1;
    let shape = [CavityShape::Spherical, CavityShape::Cylindrical][values.shape];
    let sizes = TargetSizes { shape, radius: values.radius, tension: values.tension, length: values.length };
    materials.derivations.push(DerivationRequest { material, request, sizes, span: card.span });
}

/// Derives the requested constants after all cards are read.
pub(super) fn derive_resistances(context: &mut Context<'_>, materials: &mut MaterialReader) {
    for requested in std::mem::take(&mut materials.derivations) {
        match derived(context, &requested) {
            Ok(resistance) => context.model.materials[requested.material].cavity = Some(resistance),
            Err(diagnostic) => context.diagnostics.push(diagnostic),
        }
    }
}

fn derived(context: &mut Context<'_>, requested: &DerivationRequest) -> Result<CavityExpansion, Diagnostic> {
    let material = &context.model.materials[requested.material];
    if depends_on_rate(material) && requested.sizes.radius.is_none() {
        let message = format!("the resistance of material {} is derived without its strain rates", material.name);
        let diagnostic = Diagnostic::warning("M185", message).at(requested.span, "cavity radius missing");
        context.diagnostics.push(diagnostic.help("give RADIUS=, the radius of the projectile shank"));
    }
    let target =
        expansion_target(material, &requested.sizes).map_err(|error| error.at(requested.span, "derived here"))?;
    let derived = derive(&*target, &requested.request).map_err(|fault| {
        let message = format!("material {}: {fault}", material.name);
        Diagnostic::error(fault.code(), message).at(requested.span, "derived here")
    })?;
    Ok(card_of(target.scale(), requested, &derived))
}

fn card_of(target: TargetScale, requested: &DerivationRequest, derived: &DerivedResistance) -> CavityExpansion {
    let [a, b, c] = derived.constants;
    let derivation = ResistanceDerivation {
        shape: target.shape,
        range: requested.request.range,
        residual: derived.fit.residual,
        worst: derived.worst,
        still: derived.static_pressure,
    };
    CavityExpansion { yield_stress: target.yield_stress, a, b, c, derived: Some(derivation), span: requested.span }
}

/// Target of a material: by its stress-strain curve, or by its law if it has cards of strength.
///
/// # Errors
/// `M101` if a card is missing, `M104` if a law is not supported, and the codes of cavity expansion.
pub fn expansion_target(
    material: &MaterialDefinition,
    sizes: &TargetSizes,
) -> Result<Box<dyn ExpansionTarget>, Diagnostic> {
    if has_law(material) {
        return law_target(material, sizes).map(|target| Box::new(target) as Box<dyn ExpansionTarget>);
    }
    let target = TargetMaterial { shape: sizes.shape, ..target_of(material, sizes.radius, sizes.tension)? };
    let target = ScaledTarget::new(&target).map_err(|fault| of_material(material, &fault))?;
    Ok(Box::new(target))
}

fn of_material(material: &MaterialDefinition, fault: &ResistanceError) -> Diagnostic {
    let message = format!("material {}: {fault}", material.name);
    Diagnostic::error(fault.code(), message).at(material.span, "the material")
}

/// Returns whether the resistance follows from the law of the cards of strength or of an equation of state.
pub fn has_law(material: &MaterialDefinition) -> bool {
    material.eos.is_some() || material.has_strength_law() && strength_over_pressure(material).is_none()
}

/// Returns whether the strength depends on the strain rate.
pub fn depends_on_rate(material: &MaterialDefinition) -> bool {
    material.rate.is_some() || material.strength.depends_on_rate()
}

fn law_target(material: &MaterialDefinition, sizes: &TargetSizes) -> Result<LawTarget, Diagnostic> {
    let TargetSizes { shape, radius, tension, length } = *sizes;
    let needs_length = material.strength.takes_length();
    let refusals = [
        (
            shape == CavityShape::Spherical && is_anisotropic(material),
            "*POTENTIAL around a sphere: the axes r, z and hoop are not radial there, so that the stress depends on the direction. \
             Derive the resistance of a hole along the axis of the target (TYPE=CYLINDRICAL), or mesh the target",
        ),
        (tension.is_some(), "its law together with a tensile strength: the law has its own"),
        (
            radius.is_some() && !depends_on_rate(material),
            "its law with a radius: it does not depend on the strain rate",
        ),
        (needs_length && length.is_none(), "softening over displacements without a length of elements (LENGTH)"),
        (!needs_length && length.is_some(), "its law with a length: it does not depend on the elements"),
    ];
    if let Some((_, what)) = refusals.iter().find(|(is_refused, _)| *is_refused) {
        return Err(unsupported(material, what));
    }
    let Some(density) = material.density else { return Err(missing(material, "DENSITY")) };
    let length = length.unwrap_or(1.0);
    let (law, yield_stress) = if material.eos.is_some() {
        let (law, yield_stress) = eos_target(material)?;
        (law, Some(yield_stress))
    } else {
        let law = strength_law(material, length).map_err(|fault| of_card(material, fault))?;
        (law.law, linear_strength(material).map(|strength| strength.cohesion))
    };
    let strength = |law: &dyn StressReturn| {
        LawTarget::compressive_strength(law, length).map_err(|fault| of_material(material, &fault))
    };
    let yield_stress = yield_stress.map_or_else(|| strength(&*law), Ok)?;
    Ok(LawTarget { law, shape, density, radius, length, yield_stress })
}

/// Returns the law of a solid with an equation of state, and its first yield stress.
fn eos_target(material: &MaterialDefinition) -> Result<(Box<dyn StressReturn>, f64), Diagnostic> {
    let plastic = material.plastic.as_ref().ok_or_else(|| missing(material, "PLASTIC"))?;
    let YieldCurve::Table { mut rows, extrapolates } = curve(plastic, material)? else {
        return Err(unsupported(material, "a yield stress without a table"));
    };
    let yield_stress = rows[0][0];
    if let ([.., a, b], true) = (&rows[..], extrapolates) {
        let slope = (b[0] - a[0]) / (b[1] - a[1]);
        rows.push([b[0] + slope * STRAINS[1], b[1] + STRAINS[1]]);
    }
    let law = eos_law(material, LinearTable { rows }).map_err(|fault| of_card(material, fault))?;
    Ok((Box::new(law), yield_stress))
}

fn of_card(material: &MaterialDefinition, StrengthFault { message, span, .. }: StrengthFault) -> Diagnostic {
    Diagnostic::error("M104", format!("material {}: {message}", material.name)).at(span, "this card")
}

/// Returns whether the yield stress depends on the direction.
fn is_anisotropic(material: &MaterialDefinition) -> bool {
    let ratios = material.strength.potential.as_ref().map(|(card, _)| card.ratios);
    ratios.is_some_and(|[first, rest @ ..]| rest[..3].iter().any(|ratio| *ratio != first))
}

fn missing(material: &MaterialDefinition, card: &str) -> Diagnostic {
    let message = format!("the resistance of material {} cannot be derived without *{card}", material.name);
    Diagnostic::error("M101", message).at(material.span, "the material")
}

/// Converts a material of the model to a target material with a spherical cavity. With a cavity radius strain rates are
/// included.
///
/// # Errors
/// `M101` if a card is missing, `M104` if a law is not supported by the cavity expansion.
pub fn target_of(
    material: &MaterialDefinition,
    radius: Option<f64>,
    tension: Option<f64>,
) -> Result<TargetMaterial, Diagnostic> {
    let missing = |card: &str| missing(material, card);
    let [young, poisson] = material.elastic.ok_or_else(|| missing("ELASTIC"))?;
    let density = material.density.ok_or_else(|| missing("DENSITY"))?;
    if let Some(StrengthOverPressure { cohesion, slope, .. }) = strength_over_pressure(material) {
        return Ok(TargetMaterial {
            shape: CavityShape::Spherical,
            young,
            poisson,
            density,
            yield_stress: cohesion,
            curve: YieldCurve::Perfect,
            pressure_slope: slope,
            tension,
            rate: None,
        });
    }
    let curve = curve(material.plastic.as_ref().ok_or_else(|| missing("PLASTIC"))?, material)?;
    let yield_stress = match &curve {
        YieldCurve::Table { rows, .. } => rows.first().map_or(0.0, |r| r[0]),
        YieldCurve::Perfect | YieldCurve::Power(_) => 0.0,
    };
    let rate = match (&material.rate, radius) {
        (None, Some(_)) => return Err(missing("RATE DEPENDENT").help("RADIUS is used with *RATE DEPENDENT only")),
        (Some(law), Some(radius)) => Some(StrainRateEffect { factor: factor(law, material)?, radius }),
        (_, None) => None,
    };
    let (shape, pressure_slope) = (CavityShape::Spherical, 0.0);
    Ok(TargetMaterial { shape, young, poisson, density, yield_stress, curve, pressure_slope, tension, rate })
}

/// Yield stress that increases linearly with pressure.
struct StrengthOverPressure {
    /// Von Mises stress without pressure.
    cohesion: f64,
    slope: f64,
    /// Whether flow changes the volume.
    dilates: bool,
}

/// Returns the yield stress over pressure of a linear `*DRUCKER PRAGER` without hardening; `None` for other materials. A
/// cavity compresses the material along the radius, so that K has no effect.
fn linear_strength(material: &MaterialDefinition) -> Option<StrengthOverPressure> {
    let StrengthCards { drucker_prager, drucker_prager_hardening, .. } = &material.strength;
    let ((card, _), (hardening, _)) = (drucker_prager.as_ref()?, drucker_prager_hardening.as_ref()?);
    let &[[yield_stress, _]] = hardening.rows.as_slice() else { return None };
    let [angle, _, dilation] = card.row;
    if card.form != 0 {
        return None;
    }
    let slope = tangent(angle);
    let shape = DruckerPragerShape::Linear { friction: slope, ratio: card.ratio() };
    let cohesion = shape.strength(YieldTest::ALL[hardening.test], yield_stress);
    Some(StrengthOverPressure { cohesion, slope, dilates: dilation != 0.0 })
}

/// Returns the yield stress over pressure of a material whose resistance has a similarity solution: neither dilation nor rates.
fn strength_over_pressure(material: &MaterialDefinition) -> Option<StrengthOverPressure> {
    linear_strength(material).filter(|strength| !strength.dilates && material.rate.is_none())
}

fn unsupported(material: &MaterialDefinition, what: &str) -> Diagnostic {
    let message = format!("the resistance of material {} cannot be derived from {what}", material.name);
    Diagnostic::error("M104", message).at(material.span, "the material")
}

/// Returns the yield curve at the reference temperature.
fn curve(plastic: &PlasticityModel, material: &MaterialDefinition) -> Result<YieldCurve, Diagnostic> {
    let at_strains = |stress: &dyn Fn(f64) -> f64| {
        let ratio = STRAINS[1] / STRAINS[0];
        let strain = |i: i32| STRAINS[0] * libm::pow(ratio, f64::from(i) / f64::from(ROWS));
        std::iter::once(0.0).chain((0..=ROWS).map(strain)).map(|e| [stress(e), e]).collect()
    };
    match plastic {
        PlasticityModel::Tabular(rows) if rows.iter().all(|r| r[2].is_nan() || r[2] == rows[0][2]) => {
            let rows = rows.iter().map(|r| [r[0], r[1]]).collect();
            Ok(YieldCurve::Table { rows, extrapolates: material.extrapolates })
        }
        PlasticityModel::JohnsonCook([a, b, n, ..]) => {
            let stress = |e: f64| if e > 0.0 { a + b * libm::pow(e, *n) } else { *a };
            Ok(YieldCurve::Table { rows: at_strains(&stress), extrapolates: false })
        }
        PlasticityModel::Kinematic(lines) if lines.len() == 1 => {
            let [stress, slope, _] = lines[0];
            Ok(YieldCurve::Table { rows: vec![[stress, 0.0], [stress + slope, 1.0]], extrapolates: true })
        }
        PlasticityModel::Tabular(_) | PlasticityModel::Kinematic(_) => {
            Err(unsupported(material, "yield stresses at several temperatures"))
        }
        PlasticityModel::OverFields(_) => Err(unsupported(material, "a yield stress over field variables")),
        PlasticityModel::User(_) => Err(unsupported(material, "a yield stress of a user subroutine")),
    }
}

fn factor(law: &RateDependence, material: &MaterialDefinition) -> Result<StrainRateFactor, Diagnostic> {
    match law {
        RateDependence::JohnsonCook([c, reference]) => {
            Ok(StrainRateFactor::JohnsonCook { c: *c, reference: *reference })
        }
        RateDependence::PowerLaw(rows) if rows.len() == 1 => {
            Ok(StrainRateFactor::Power { reference: rows[0][0], exponent: 1.0 / rows[0][1] })
        }
        RateDependence::PowerLaw(_) => Err(unsupported(material, "a rate dependence at several temperatures")),
        RateDependence::YieldRatio(_) => Err(unsupported(material, "a table of yield stress ratios")),
    }
}
