//! Validation of the material data of composed models. The plan checks the combination of laws.

use super::consistency::{ConsistencyCheck, is_non_negative, is_positive};
use super::eos::stiffens;
use super::rubber::ORDER;
use super::types::{
    DamageEvolution, DeviatoricEnergy, EosKind, FailureCriterion, FoamYieldSurface, HyperelasticLaw,
    InterfaceSoftening, MaterialDefinition, ModeDependence, PlasticityModel, RateDependence, StateVariables,
    StrainAtFailure,
};
use crate::deck::keywords::Keyword;
use crate::deck::table::materials as cards;
use crate::kernel::levels::NestedTable;

/// Returns whether the temperatures of the rows ascend; a single row needs none.
fn by_temperature(rows: &[[f64; 3]]) -> bool {
    !rows.is_empty() && (rows.len() == 1 || rows.windows(2).all(|w| w[0][2] < w[1][2]))
}

/// Fields of a card, with their values.
type NamedValues<'a> = &'a [(&'static str, Option<f64>)];

impl ConsistencyCheck<'_> {
    pub(super) fn material(&mut self, material: &MaterialDefinition) {
        self.elasticity(material);
        self.compressible(material);
        self.heat(material);
        self.flow(material);
        self.failure(material);
        self.interface(material);
        let (name, span, user) = (&material.name, material.span, &material.user);
        let of_fields = user.fields.iter().chain(&user.lengths).flat_map(|f| &f.0);
        let mut constants = user.material.iter().flatten().chain(of_fields);
        let StateVariables { count, delete } = user.state;
        let good = constants.all(|c| c.is_finite()) && count <= 10_000 && delete.is_none_or(|d| d < count);
        self.value(good, span, || {
            format!("material `{name}`: user material properties or state variables out of range")
        });
    }

    /// Checks the values of a card against the ranges of the keyword table.
    fn card(&mut self, material: &MaterialDefinition, row: &Keyword, fields: NamedValues<'_>) {
        fields.iter().for_each(|(field, value)| self.in_range(material.span, &material.name, row, field, *value));
    }

    fn rows<const N: usize>(
        &mut self,
        material: &MaterialDefinition,
        row: &Keyword,
        names: [&'static str; N],
        rows: &[[f64; N]],
    ) {
        for values in rows {
            let given = |i: usize| (names[i], Some(values[i]).filter(|v| names[i] != "temperature" || !v.is_nan()));
            self.card(material, row, &std::array::from_fn::<_, N, _>(given));
        }
    }

    fn elasticity(&mut self, material: &MaterialDefinition) {
        self.card(material, &cards::Density::ROW, &[("density", material.density)]);
        let names = ["Young's modulus", "Poisson's ratio"];
        self.rows(material, &cards::Elastic::ROW, names, material.elastic.as_slice());
        self.card(material, &cards::Elastic::ROW, &[("shear modulus", material.shear_modulus)]);
        self.card(material, &cards::Viscosity::ROW, &[("viscosity", material.viscosity.map(|v| v.0))]);
        self.card(material, &cards::Damping::ROW, &[("ALPHA", material.damping.map(|d| d.alpha))]);
        self.card(material, &cards::Damping::ROW, &[("BETA", material.damping.map(|d| d.beta))]);
        let (name, span) = (&material.name, material.span);
        let mut need = |good: bool, what: &str| self.value(good, span, || format!("material `{name}`: {what}"));
        need(is_elastic_table(&material.elastic_table), "elastic moduli table out of range");
        need(material.hyperelastic.as_ref().is_none_or(is_rubber), "hyperelastic constants out of range");
    }

    /// Checks equation of state and crushable foam.
    fn compressible(&mut self, material: &MaterialDefinition) {
        let row = &cards::Eos::ROW;
        match material.eos.as_ref().map(|eos| &eos.kind) {
            Some(EosKind::IdealGas(values)) => {
                self.rows(material, row, ["gas constant", "ambient pressure"], &[*values]);
            }
            Some(EosKind::UsUp(values)) => self.rows(material, row, ["c0", "s", "Gamma0"], &[*values]),
            Some(EosKind::Jwl(values)) => self.rows(material, row, JWL, &[*values]),
            Some(EosKind::Tabular(rows)) => {
                let good = stiffens(rows) && rows.windows(2).all(|w| w[0][2] > w[1][2]);
                self.value(good, material.span, || "equation of state table out of range".into());
            }
            None => {}
        }
        let [first, second, third] =
            ["compression yield stress ratio", "hydrostatic yield stress ratio", "plastic Poisson's ratio"];
        match material.foam.shape {
            Some((FoamYieldSurface::Volumetric(values), _)) => {
                self.rows(material, &cards::CrushableFoam::ROW, [first, second], &[values]);
                self.value(values[0] > 0.0, material.span, || format!("{first} must be positive"));
            }
            Some((FoamYieldSurface::Isotropic(values), _)) => {
                self.rows(material, &cards::CrushableFoam::ROW, [first, third], &[values]);
            }
            None => {}
        }
        let rows = &material.foam.hardening;
        let names = ["yield stress in uniaxial compression", "plastic strain in compression"];
        self.rows(material, &cards::CrushableFoamHardening::ROW, names, rows);
        let starts = rows.first().is_none_or(|r| r[1] == 0.0) && rows.windows(2).all(|w| w[0][1] < w[1][1]);
        self.value(starts, material.span, || "plastic strains of the foam must start at 0 and ascend".into());
    }

    fn heat(&mut self, material: &MaterialDefinition) {
        let thermal = &material.thermal;
        self.card(material, &cards::InelasticHeatFraction::ROW, &[("fraction", thermal.inelastic_heat_fraction)]);
        let capacity = thermal.specific_heat.as_deref().unwrap_or_default();
        self.rows(material, &cards::SpecificHeat::ROW, ["specific heat", "temperature"], capacity);
        let conductivity = thermal.conductivity.as_ref().map_or(&[][..], |(rows, _)| rows);
        self.rows(material, &cards::Conductivity::ROW, ["conductivity", "temperature"], conductivity);
        let expansion = thermal.expansion.as_ref().map_or(&[][..], |e| &e.rows);
        self.rows(material, &cards::Expansion::ROW, ["coefficient", "temperature"], expansion);
        let zero = thermal.expansion.as_ref().map(|e| e.zero);
        self.card(material, &cards::Expansion::ROW, &[("ZERO", zero)]);
    }

    fn flow(&mut self, material: &MaterialDefinition) {
        let (name, span) = (&material.name, material.span);
        let mut need = |good: bool, what: &str| self.value(good, span, || format!("material `{name}`: {what}"));
        need(material.plastic.as_ref().is_none_or(yields), "yield stress table out of range");
        need(material.rate.as_ref().is_none_or(is_rate), "rate dependence table out of range");
        let Some(law) = material.cavity else { return };
        let row = &cards::CavityExpansion::ROW;
        let values = [("YIELD", law.yield_stress), ("A", law.a), ("B", law.b), ("C", law.c)];
        self.card(material, row, &values.map(|(field, value)| (field, Some(value))));
    }

    /// Checks the traction-separation law of cohesive elements.
    fn interface(&mut self, material: &MaterialDefinition) {
        let interface = &material.interface;
        self.rows(material, &cards::Elastic::ROW, ["Enn", "Ess"], interface.elastic.as_slice());
        let (name, span) = (&material.name, material.span);
        let mut need = |good: bool, what: &str| self.value(good, span, || format!("material `{name}`: {what}"));
        let begins = interface.initiation.is_none_or(|i| i.limits.iter().all(|limit| is_positive(*limit)));
        need(begins, "values of damage initiation must be positive");
        let good = interface.evolution.as_ref().is_none_or(|e| softens(&e.softening));
        need(good, "damage evolution of cohesive elements out of range");
        let coupled =
            interface.elastic.is_none_or(|[normal, shear]| interface.coupling * interface.coupling < normal * shear);
        need(coupled, "the coupling stiffness of cohesive elements is too large");
        need(interface.viscosity.is_none_or(|v| is_non_negative(v.0)), "the viscosity of damage must not be negative");
        let based = interface.evolution.is_none() || interface.initiation.is_some();
        need(based, "damage evolution of cohesive elements requires damage initiation");
    }

    fn failure(&mut self, material: &MaterialDefinition) {
        let cutoff = material.tensile_failure.map(|t| t.cutoff);
        self.card(material, &cards::TensileFailure::ROW, &[("mean stress, tension", cutoff)]);
        let (name, span) = (&material.name, material.span);
        let good = material.failures.iter().all(fails);
        self.value(good, span, || format!("material `{name}`: failure strain or damage evolution out of range"));
    }
}

/// Returns whether the values at failure of cohesive elements are in range.
fn is_mode_dependence(mode: &ModeDependence) -> bool {
    match mode {
        ModeDependence::Independent(value) => is_non_negative(*value),
        ModeDependence::Table(_, rows) => {
            let good = |row: &[f64; 2]| is_non_negative(row[0]) && (0.0..=1.0).contains(&row[1]);
            !rows.is_empty() && rows.iter().all(good) && rows.windows(2).all(|w| w[0][1] < w[1][1])
        }
        ModeDependence::PowerLaw(energies, power) | ModeDependence::BenzeggaghKenane(energies, power) => {
            energies.iter().chain([power]).all(|value| is_positive(*value))
        }
    }
}

fn softens(softening: &InterfaceSoftening) -> bool {
    match softening {
        InterfaceSoftening::Displacement(mode)
        | InterfaceSoftening::Energy(mode)
        | InterfaceSoftening::ExponentialEnergy(mode) => is_mode_dependence(mode),
        InterfaceSoftening::ExponentialDisplacement(mode, rate) => is_mode_dependence(mode) && is_positive(*rate),
        InterfaceSoftening::Tabular(rows) => {
            let ascends = |w: &[[f64; 2]]| w[0][1] < w[1][1] && w[0][0] <= w[1][0] && w[1][0] <= 1.0;
            rows.len() > 1 && rows[0] == [0.0; 2] && rows.windows(2).all(ascends)
        }
    }
}

/// Names of the JWL constants, in their order.
const JWL: [&str; 8] =
    ["detonation wave speed", "A", "B", "omega", "R1", "R2", "detonation energy", "pre-detonation bulk modulus"];

fn is_elastic_table(rows: &[Vec<f64>]) -> bool {
    let good = |r: &Vec<f64>| r.len() > 2 && is_positive(r[0]) && r[1] > -1.0 && r[1] < 0.5;
    let over = || NestedTable::new(&rows.iter().map(|r| &r[1..]).collect::<Vec<_>>());
    rows.is_empty() || rows.iter().all(good) && over().is_some()
}

fn is_rubber(rubber: &HyperelasticLaw) -> bool {
    let [first, more @ ..] = &rubber.compressibility[..] else { return false };
    let alike = is_positive(*first) || more.iter().all(|d| *d == 0.0);
    let shape = match &rubber.shape {
        DeviatoricEnergy::NeoHooke(_) => true,
        DeviatoricEnergy::Polynomial(terms) => {
            terms.iter().all(|&(c, i, j)| c.is_finite() && i <= ORDER && j <= ORDER && i + j > 0)
        }
        DeviatoricEnergy::Ogden(terms) => terms.iter().all(|t| t[0].is_finite() && t[1].is_finite() && t[1] != 0.0),
    };
    is_positive(rubber.shape.shear()) && rubber.compressibility.iter().all(|d| is_non_negative(*d)) && alike && shape
}

/// Returns whether the yield stress data are in range. The plan checks tables further.
fn yields(plastic: &PlasticityModel) -> bool {
    match plastic {
        PlasticityModel::JohnsonCook(values) => values.iter().all(|v| v.is_finite()),
        PlasticityModel::Tabular(rows) => rows.iter().all(|r| r[0].is_finite() && r[1].is_finite()),
        PlasticityModel::OverFields(rows) => {
            rows.iter().flatten().all(|v| v.is_finite()) && NestedTable::new(rows).is_some()
        }
        PlasticityModel::User(constants) => constants.iter().all(|c| c.is_finite()),
        PlasticityModel::Kinematic(lines) => {
            by_temperature(lines) && lines.iter().all(|l| is_positive(l[0]) && is_non_negative(l[1]))
        }
    }
}

fn is_rate(rate: &RateDependence) -> bool {
    match rate {
        RateDependence::JohnsonCook(values) => values.iter().all(|v| v.is_finite()),
        RateDependence::PowerLaw(rows) => {
            by_temperature(rows) && rows.iter().all(|r| is_positive(r[0]) && is_positive(r[1]))
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
            DamageEvolution::Displacement(value) | DamageEvolution::Energy(value) => is_non_negative(value),
        }
}
