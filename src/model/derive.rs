//! `*CAVITY EXPANSION, DERIVE`: the resistance of a material from its own `*ELASTIC`, `*DENSITY`, `*PLASTIC` and
//! `*RATE DEPENDENT`.
//! Never here: the expansion of the cavity (`resistance`).

use super::builder::Builder;
use super::derivation::Asked;
use super::types::{CavityExpansion, Derivation, Material, Plastic, RateDependence};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};
use crate::resistance::fit::Weight;
use crate::resistance::rate::{Factor, Rate};
use crate::resistance::{self, Curve, Derived, Request, Target, derive};

/// Rows by which a curve without rows is followed, and the plastic strains between which they lie, beside 0: in geometric steps of
/// a ninth, within 0.1 % of the curve.
const ROWS: i32 = 140;
const STRAINS: [f64; 2] = [1e-5, 30.0];

impl Builder<'_> {
    /// Notes the request; the other cards of the material may follow.
    pub(super) fn derivation(&mut self, card: &Card, values: &cards::CavityExpansion) {
        // A target finds the material resisting; the constants come when all cards are read.
        self.last_material().cavity =
            Some(CavityExpansion { yield_stress: 0.0, a: 0.0, b: 0.0, c: 0.0, derived: None, span: card.span });
        if let Some(word) = card.value("YIELD") {
            let message = "DERIVE takes Y from the first row of *PLASTIC, not from YIELD";
            return self.out_of_range(word.span, message);
        }
        let [from, to, points] = values.values;
        let weight = [Weight::Even, Weight::Relative, Weight::Velocity][values.weight];
        // Beyond the fit's own limits any number is told there.
        let points = if points.fract() == 0.0 { points as usize } else { 0 };
        let request = Request { range: [from, to], points, linear: values.linear, pinned: values.pinned, weight };
        let material = self.model.materials.len() - 1;
        self.derivations.push(Asked {
            material,
            request,
            radius: values.radius,
            tension: values.tension,
            span: card.span,
        });
    }

    /// Once all cards are read.
    pub(super) fn derive_resistances(&mut self) {
        for asked in std::mem::take(&mut self.derivations) {
            match self.derived(&asked) {
                Ok(resistance) => self.model.materials[asked.material].cavity = Some(resistance),
                Err(finding) => self.diagnostics.push(finding),
            }
        }
    }

    fn derived(&mut self, asked: &Asked) -> Result<CavityExpansion, Diagnostic> {
        let material = &self.model.materials[asked.material];
        if material.rate.is_some() && asked.radius.is_none() {
            let message =
                format!("the resistance of material {} is derived without its *RATE DEPENDENT", material.name);
            let finding = Diagnostic::warning("M185", message).at(asked.span, "no radius of the cavity");
            self.diagnostics.push(finding.help("RADIUS=r gives it: that of the projectile's shank"));
        }
        let target =
            target_of(material, asked.radius, asked.tension).map_err(|error| error.at(asked.span, "derived here"))?;
        let told = |fault: resistance::ResistanceError| {
            let message = format!("material {}: {fault}", material.name);
            Diagnostic::error(fault.code(), message).at(asked.span, "derived here")
        };
        let target = Target::new(&target).map_err(told)?;
        let derived = derive(&target, &asked.request).map_err(told)?;
        Ok(card_of(&target, asked, &derived))
    }
}

fn card_of(target: &Target, asked: &Asked, derived: &Derived) -> CavityExpansion {
    let [a, b, c] = derived.constants;
    let derivation = Derivation {
        range: asked.request.range,
        residual: derived.fit.residual,
        worst: derived.worst,
        still: derived.still,
    };
    CavityExpansion { yield_stress: target.yield_stress, a, b, c, derived: Some(derivation), span: asked.span }
}

/// A material of a deck as a target; strain rates count with a radius of the cavity.
///
/// # Errors
/// `M101` where a card is missing, `M104` where one says more than a target can be.
pub fn target_of(
    material: &Material,
    radius: Option<f64>,
    tension: Option<f64>,
) -> Result<resistance::Material, Diagnostic> {
    let missing = |card: &str| {
        let message = format!("the resistance of material {} cannot be derived without *{card}", material.name);
        Diagnostic::error("M101", message).at(material.span, "the material")
    };
    let [young, poisson] = material.elastic.ok_or_else(|| missing("ELASTIC"))?;
    let density = material.density.ok_or_else(|| missing("DENSITY"))?;
    let curve = curve(material.plastic.as_ref().ok_or_else(|| missing("PLASTIC"))?, material)?;
    let yield_stress = match &curve {
        Curve::Table { rows, .. } => rows.first().map_or(0.0, |r| r[0]),
        Curve::Perfect | Curve::Power(_) => 0.0,
    };
    let rate = match (&material.rate, radius) {
        (None, Some(_)) => return Err(missing("RATE DEPENDENT").help("RADIUS is of a rate term")),
        (Some(law), Some(radius)) => Some(Rate { factor: factor(law, material)?, radius }),
        (_, None) => None,
    };
    Ok(resistance::Material { young, poisson, density, yield_stress, curve, pressure_slope: 0.0, tension, rate })
}

fn unsupported(material: &Material, what: &str) -> Diagnostic {
    let message = format!("the resistance of material {} cannot be derived from {what}", material.name);
    Diagnostic::error("M104", message).at(material.span, "the material")
}

/// The curve at the temperature at which nothing softens.
fn curve(plastic: &Plastic, material: &Material) -> Result<Curve, Diagnostic> {
    let at_strains = |stress: &dyn Fn(f64) -> f64| {
        let ratio = STRAINS[1] / STRAINS[0];
        let strain = |i: i32| STRAINS[0] * libm::pow(ratio, f64::from(i) / f64::from(ROWS));
        std::iter::once(0.0).chain((0..=ROWS).map(strain)).map(|e| [stress(e), e]).collect()
    };
    match plastic {
        Plastic::Tabular(rows) if rows.iter().all(|r| r[2].is_nan() || r[2] == rows[0][2]) => {
            let rows = rows.iter().map(|r| [r[0], r[1]]).collect();
            Ok(Curve::Table { rows, extrapolates: material.extrapolates })
        }
        Plastic::JohnsonCook([a, b, n, ..]) => {
            let stress = |e: f64| if e > 0.0 { a + b * libm::pow(e, *n) } else { *a };
            Ok(Curve::Table { rows: at_strains(&stress), extrapolates: false })
        }
        Plastic::Kinematic(lines) if lines.len() == 1 => {
            let [stress, slope, _] = lines[0];
            Ok(Curve::Table { rows: vec![[stress, 0.0], [stress + slope, 1.0]], extrapolates: true })
        }
        Plastic::Tabular(_) | Plastic::Kinematic(_) => {
            Err(unsupported(material, "yield stresses at several temperatures"))
        }
        Plastic::OverFields(_) => Err(unsupported(material, "a yield stress over field variables")),
        Plastic::User(_) => Err(unsupported(material, "a yield stress of the user's routine")),
    }
}

fn factor(law: &RateDependence, material: &Material) -> Result<Factor, Diagnostic> {
    match law {
        RateDependence::JohnsonCook([c, reference]) => Ok(Factor::JohnsonCook { c: *c, reference: *reference }),
        RateDependence::PowerLaw(rows) if rows.len() == 1 => {
            Ok(Factor::Power { reference: rows[0][0], exponent: 1.0 / rows[0][1] })
        }
        RateDependence::PowerLaw(_) => Err(unsupported(material, "a rate dependence at several temperatures")),
        RateDependence::YieldRatio(_) => Err(unsupported(material, "a table of yield stress ratios")),
    }
}
