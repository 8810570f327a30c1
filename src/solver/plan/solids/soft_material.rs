//! Laws of rubber, crushable foam and explosives.

use crate::deck::{Diagnostic, Span};
use crate::element::constants::ElementConstants;
use crate::element::solid_groups::SolidMaterial;
use crate::kernel::hardening::LinearTable;
use crate::material::explosive::{DetonationPoint, HighExplosive, JwlProducts};
use crate::material::foam::{FoamHardening, FoamMaterial};
use crate::material::hyperelastic::{HyperelasticMaterial, NeoHooke};
use crate::material::strain_energy::{OgdenEnergy, PolynomialEnergy, VolumetricEnergy};
use crate::model::rates::{depends_on_temperature, rate_factor};
use crate::model::{DeviatoricEnergy, FoamYieldSurface, HyperelasticLaw, RateDependence};
use crate::plan::Report;
use crate::plan::solids::solid_properties::SolidProperties;

/// Initial bulk modulus over the shear modulus of rubber whose card gives no compressibility: Poisson's ratio 0.475
/// (ABAQUS Analysis User's Guide, "Hyperelastic behavior of rubberlike materials", compressibility in ABAQUS/Explicit).
const BULK_OVER_SHEAR: f64 = 20.0;

pub fn rubber_law(solid: &SolidProperties, report: &mut Report) -> Option<SolidMaterial> {
    let HyperelasticLaw { shape, compressibility, span, .. } = solid.material.hyperelastic.as_ref()?;
    let shear = shape.shear();
    let is_compressible = compressibility.first().is_some_and(|d1| *d1 > 0.0);
    let standard = vec![0.5 * BULK_OVER_SHEAR * shear];
    let inverse: Vec<f64> = compressibility.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 0.0 }).collect();
    let volume = VolumetricEnergy { inverse: if is_compressible { inverse } else { standard } };
    let name = match shape {
        DeviatoricEnergy::NeoHooke(_) => "neo-Hooke".into(),
        DeviatoricEnergy::Polynomial(terms) => format!("polynomial of {} constants", terms.len()),
        DeviatoricEnergy::Ogden(terms) => format!("Ogden of order {}", terms.len()),
    };
    let how = if is_compressible { "" } else { ", by default 20 times the shear modulus" };
    let detail = format!("{name}, shear modulus {shear}, bulk modulus {}{how}", volume.initial());
    report.ledger_row(*span, "rubber elasticity", 1, "material", detail);
    Some(match shape {
        DeviatoricEnergy::NeoHooke(c10) => {
            let d1 = if is_compressible { compressibility[0] } else { 2.0 / (BULK_OVER_SHEAR * shear) };
            SolidMaterial::NeoHooke(NeoHooke { c10: *c10, d1 })
        }
        DeviatoricEnergy::Polynomial(terms) => {
            let terms = terms.iter().copied().filter(|t| t.0 != 0.0).collect();
            SolidMaterial::Polynomial(HyperelasticMaterial { shape: PolynomialEnergy { terms }, volume, shear })
        }
        DeviatoricEnergy::Ogden(terms) => {
            let terms = terms.iter().copied().filter(|t| t[0] != 0.0).collect();
            SolidMaterial::Ogden(HyperelasticMaterial { shape: OgdenEnergy { terms }, volume, shear })
        }
    })
}

pub fn foam_law(solid: &SolidProperties, report: &mut Report) -> Option<SolidMaterial> {
    let SolidProperties { material, span, .. } = *solid;
    let name = &material.name;
    let Some((shape, card)) = material.foam.shape else {
        let message = format!("material `{name}` has *CRUSHABLE FOAM HARDENING without *CRUSHABLE FOAM");
        return no_material(span, message, report);
    };
    if material.foam.hardening.is_empty() {
        return no_material(span, format!("material `{name}` has no *CRUSHABLE FOAM HARDENING"), report);
    }
    if material.elastic.is_none() || material.eos.is_some() {
        return no_material(span, format!("material `{name}`: foam needs *ELASTIC"), report);
    }
    if material.plastic.is_some() || material.has_failure() {
        let message = format!("material `{name}` has foam with *PLASTIC or failure, which is not supported");
        return no_material(span, message, report);
    }
    let rate = match &material.rate {
        Some(RateDependence::JohnsonCook(_)) => {
            let message =
                format!("material `{name}`: foam supports *RATE DEPENDENT with POWER LAW or YIELD RATIO only");
            return no_material(span, message, report);
        }
        Some(rate) if depends_on_temperature(rate) => {
            let message = format!("material `{name}`: the rate dependence of foam does not depend on temperature");
            return no_material(span, message, report);
        }
        rate => rate_factor(rate.as_ref()),
    };
    let growth = match shape {
        FoamYieldSurface::Volumetric([compression, tension]) => FoamHardening::Volumetric { compression, tension },
        FoamYieldSurface::Isotropic([compression, ratio]) => FoamHardening::Isotropic { compression, ratio },
    };
    let how = match growth {
        FoamHardening::Volumetric { .. } => "volumetric hardening",
        FoamHardening::Isotropic { .. } => "isotropic hardening",
    };
    let rates = if rate.is_some() { ", rate dependent" } else { "" };
    report.ledger_row(card, "crushable foam", 1, "material", format!("{how}{rates}"));
    let hardening = LinearTable { rows: material.foam.hardening.clone() };
    let ElementConstants { bulk, shear, .. } = solid.constants;
    Some(SolidMaterial::Foam(FoamMaterial { growth, hardening, rate, moduli: [bulk, shear] }))
}

pub fn explosive_law(
    solid: &SolidProperties,
    card: Span,
    values: &[f64; 8],
    report: &mut Report,
) -> Option<HighExplosive> {
    let SolidProperties { material, span, .. } = *solid;
    let [speed, a, b, omega, r1, r2, energy, unburnt] = *values;
    if material.detonation.is_empty() {
        let message = format!("material `{}` is an explosive without *DETONATION POINT", material.name);
        return no_material(span, message, report);
    }
    let detail = format!(
        "JWL, energy {energy:e} per mass, {} detonation points, detonation speed {speed}",
        material.detonation.len()
    );
    report.ledger_row(card, "equation of state", 1, "material", detail);
    let density = material.density.unwrap_or(0.0);
    let products = JwlProducts { density, pressures: [a, b], exponents: [r1, r2], omega };
    let points =
        material.detonation.iter().map(|[r, z, time]| DetonationPoint { place: [*r, *z], time: *time }).collect();
    Some(HighExplosive { products, speed, energy, unburnt, points })
}

fn no_material<T>(span: Span, message: String, report: &mut Report) -> Option<T> {
    report.refuse(Diagnostic::error("P013", message).at(span, "these elements deform"))
}
