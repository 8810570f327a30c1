//! Whether the values of a material are such as its cards could have.
//! Never here: which laws can stand beside each other, which the plan says.

use super::consistency::{Check, above_zero, not_below};
use super::eos::{is_explosive, stiffens};
use super::rubber::ORDER;
use super::types::{
    DamageEvolution, EosKind, Expansion, FailureCriterion, FoamShape, Hyperelastic, Material, Plastic, RateDependence,
    RubberShape, StrainAtFailure,
};
use crate::kernel::levels::NestedTable;

/// Whether temperatures ascend in rows; one row needs none.
fn by_temperature(rows: &[[f64; 3]]) -> bool {
    !rows.is_empty() && (rows.len() == 1 || rows.windows(2).all(|w| w[0][2] < w[1][2]))
}

impl Check<'_> {
    pub(super) fn material(&mut self, material: &Material) {
        let (name, span) = (&material.name, material.span);
        let mut need = |good: bool, what: &str| self.value(good, span, || format!("material `{name}`: {what}"));
        need(material.density.is_none_or(above_zero), "the density must be above zero");
        need(
            material.elastic.is_none_or(|[e, nu]| above_zero(e) && nu > -1.0 && nu < 0.5),
            "Young's modulus must be above 0, Poisson's ratio between -1 and 0.5",
        );
        need(is_elastic_table(&material.elastic_table), "rows of the moduli out of range");
        need(material.shear_modulus.is_none_or(above_zero), "the shear modulus must be above zero");
        need(material.hyperelastic.as_ref().is_none_or(is_rubber), "constants of the rubber out of range");
        need(is_foam(material), "constants of the foam out of range");
        need(material.damping.is_none_or(|d| above_zero(d.0)), "mass proportional damping must be above zero");
        let heat = |rows: &Vec<[f64; 2]>| !rows.is_empty() && rows.iter().all(|r| above_zero(r[0]));
        need(material.thermal.specific_heat.as_ref().is_none_or(heat), "the specific heat must be above zero");
        let conducts = material.thermal.conductivity.as_ref().is_none_or(|(rows, _)| heat(rows));
        need(conducts, "the conductivity must be above zero");
        let expands =
            |e: &Expansion| !e.rows.is_empty() && e.rows.iter().all(|r| r[0].is_finite()) && e.zero.is_finite();
        need(material.thermal.expansion.as_ref().is_none_or(expands), "coefficients of the expansion must be finite");
        let fraction = material.thermal.inelastic_heat_fraction.is_none_or(f64::is_finite);
        need(fraction, "the inelastic heat fraction must be finite");
        need(
            material.eos.as_ref().is_none_or(|eos| is_equation(&eos.kind)),
            "constants of the equation of state out of range",
        );
        need(material.plastic.as_ref().is_none_or(yields), "rows of the yield stress out of range");
        need(material.rate.as_ref().is_none_or(is_rate), "rows of the rate dependence out of range");
        need(material.failures.iter().all(fails), "strain at failure or damage out of range");
        need(material.tensile_failure.is_none_or(|t| above_zero(t.cutoff)), "the cutoff must be above zero (tension)");
        let resists =
            material.cavity.is_none_or(|c| above_zero(c.yield_stress) && [c.a, c.b, c.c].map(not_below) == [true; 3]);
        need(resists, "a resistance needs YIELD above zero and A, B, C not below zero");
        let of_fields = material.user.fields.iter().chain(&material.user.lengths).flat_map(|f| &f.0);
        let constants = material.user.material.iter().flatten().chain(of_fields);
        need(constants.into_iter().all(|c| c.is_finite()), "constants of the user must be finite");
        let state = material.user.state;
        need(state.count <= 10_000 && state.delete.is_none_or(|d| d < state.count), "state variables out of range");
    }
}

fn is_elastic_table(rows: &[Vec<f64>]) -> bool {
    let good = |r: &Vec<f64>| r.len() > 2 && above_zero(r[0]) && r[1] > -1.0 && r[1] < 0.5;
    let over = || NestedTable::new(&rows.iter().map(|r| &r[1..]).collect::<Vec<_>>());
    rows.is_empty() || rows.iter().all(good) && over().is_some()
}

fn is_rubber(rubber: &Hyperelastic) -> bool {
    let [first, more @ ..] = &rubber.compressibility[..] else { return false };
    let alike = above_zero(*first) || more.iter().all(|d| *d == 0.0);
    let shape = match &rubber.shape {
        RubberShape::NeoHooke(_) => true,
        RubberShape::Polynomial(terms) => {
            terms.iter().all(|&(c, i, j)| c.is_finite() && i <= ORDER && j <= ORDER && i + j > 0)
        }
        RubberShape::Ogden(terms) => terms.iter().all(|t| t[0].is_finite() && t[1].is_finite() && t[1] != 0.0),
    };
    above_zero(rubber.shape.shear()) && rubber.compressibility.iter().all(|d| not_below(*d)) && alike && shape
}

/// The plan says what is missing.
fn is_foam(material: &Material) -> bool {
    let shape = match material.foam.shape {
        None => true,
        Some((FoamShape::Volumetric([k, kt]), _)) => k > 0.0 && k < 3.0 && not_below(kt),
        Some((FoamShape::Isotropic([k, ratio]), _)) => (0.0..3.0).contains(&k) && ratio > -1.0 && ratio < 0.5,
    };
    let rows = &material.foam.hardening;
    let starts = rows.first().is_none_or(|r| r[1] == 0.0);
    shape && starts && rows.iter().all(|r| above_zero(r[0])) && rows.windows(2).all(|w| w[0][1] < w[1][1])
}

fn is_equation(kind: &EosKind) -> bool {
    match kind {
        EosKind::IdealGas([gas_constant, ambient]) => above_zero(*gas_constant) && not_below(*ambient),
        EosKind::UsUp([c0, s, gamma0]) => above_zero(*c0) && not_below(*s) && not_below(*gamma0),
        EosKind::Tabular(rows) => stiffens(rows) && rows.windows(2).all(|w| w[0][2] > w[1][2]),
        EosKind::Jwl(values) => is_explosive(values),
    }
}

/// The plan says more of tables.
fn yields(plastic: &Plastic) -> bool {
    match plastic {
        Plastic::JohnsonCook(values) => values.iter().all(|v| v.is_finite()),
        Plastic::Tabular(rows) => rows.iter().all(|r| r[0].is_finite() && r[1].is_finite()),
        Plastic::OverFields(rows) => rows.iter().flatten().all(|v| v.is_finite()) && NestedTable::new(rows).is_some(),
        Plastic::User(constants) => constants.iter().all(|c| c.is_finite()),
        Plastic::Kinematic(lines) => by_temperature(lines) && lines.iter().all(|l| above_zero(l[0]) && not_below(l[1])),
    }
}

fn is_rate(rate: &RateDependence) -> bool {
    match rate {
        RateDependence::JohnsonCook(values) => values.iter().all(|v| v.is_finite()),
        RateDependence::PowerLaw(rows) => {
            by_temperature(rows) && rows.iter().all(|r| above_zero(r[0]) && above_zero(r[1]))
        }
        RateDependence::YieldRatio(rows) => {
            let follows = |w: &[[f64; 3]]| w[0][1] < w[1][1] || w[0][2] < w[1][2];
            !rows.is_empty()
                && rows.windows(2).all(follows)
                && rows.iter().all(|r| r[0].is_finite() && r[1].is_finite())
        }
    }
}

fn fails(criterion: &FailureCriterion) -> bool {
    let table = |rows: &Vec<[f64; 4]>| rows.iter().all(|r| r[0] > 0.0) && NestedTable::new(rows).is_some();
    let strain = match &criterion.strain {
        StrainAtFailure::Constant(strain) => *strain > 0.0,
        StrainAtFailure::JohnsonCook(d, _) => d.iter().all(|v| v.is_finite()),
        StrainAtFailure::Ductile(rows) | StrainAtFailure::Shear(rows) => table(rows),
    };
    strain
        && match criterion.evolution {
            DamageEvolution::Sudden | DamageEvolution::Absent => true,
            DamageEvolution::Displacement(value) | DamageEvolution::Energy(value) => not_below(value),
        }
}
