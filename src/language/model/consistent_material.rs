//! Validation of the material data of composed models: ranges of the keyword table, and the checks of the readers of
//! cards. The plan checks the combination of laws.

use super::cohesive::{check_coupling, check_softening};
use super::consistency::{ConsistencyCheck, FieldRules, fields};
use super::faults::{ValueCheck, is_non_negative, is_positive, require};
use super::materials::check_elastic_table;
use super::rubber::check_foam_hardening;
use super::types::{
    DamageEvolution, EosKind, FoamYieldSurface, HyperelasticLaw, MaterialDefinition, RateDependence, StateVariables,
};
use crate::deck::table::materials as cards;

impl ConsistencyCheck<'_> {
    pub fn material(&mut self, material: &MaterialDefinition) {
        self.elasticity(material);
        self.compressible(material);
        self.heat(material);
        self.flow(material);
        self.failure(material);
        self.interface(material);
        for range in &material.ranges {
            let name = range.quantity.name();
            let message = format!("*MATERIAL RANGE: the {name} needs a limit, and a lower limit below the upper one");
            let is_limited = range.low.is_finite() || range.high.is_finite();
            self.check_of(material, require(is_limited && range.low < range.high, message));
        }
        let user = &material.user;
        let of_fields = user.fields.iter().chain(&user.lengths).flat_map(|f| &f.0);
        let is_finite = user.material.iter().flatten().chain(of_fields).all(|constant| constant.is_finite());
        self.check_of(material, require(is_finite, "the constants of user subroutines must be finite"));
        let StateVariables { count, delete } = user.state;
        let is_valid = count <= 10_000 && delete.is_none_or(|d| d < count);
        self.check_of(material, require(is_valid, format!("state variables out of range: {count}, DELETE {delete:?}")));
    }

    /// Reports the fault that a check has found.
    fn check_of(&mut self, material: &MaterialDefinition, check: ValueCheck) {
        self.accept(&owner(material), material.span, check);
    }

    /// Checks rows of values against the rules of their fields. Temperatures may be absent (NaN).
    fn rows<const N: usize>(&mut self, material: &MaterialDefinition, fields: FieldRules<N>, rows: &[[f64; N]]) {
        let (keyword, rules) = fields;
        for row in rows {
            let is_given = |at: usize| rules[at].name != "temperature" || !row[at].is_nan();
            let values = std::array::from_fn(|at| Some(row[at]).filter(|_| is_given(at)));
            self.ranges(material.span, &owner(material), fields, values);
        }
        for (rule, column) in rules.into_iter().zip(0..) {
            let descends = |w: &&[[f64; N]]| rule.value.ascends && w[1][column] <= w[0][column];
            if let Some([before, after]) = rows.windows(2).find(descends) {
                let (previous, next) = (before[column], after[column]);
                let message =
                    format!("{} of *{keyword} must increase from row to row, found {next} after {previous}", rule.name);
                self.check_of(material, require(false, message));
            }
        }
    }

    fn elasticity(&mut self, material: &MaterialDefinition) {
        self.rows(material, fields!(cards::Density: "density"), material.density.map(|density| [density]).as_slice());
        let moduli: Vec<[f64; 2]> =
            material.elastic_table.iter().filter_map(|row| row.first_chunk().copied()).collect();
        for moduli in [material.elastic.as_slice(), &moduli] {
            self.rows(material, fields!(cards::Elastic: "Young's modulus", "Poisson's ratio"), moduli);
        }
        self.check_of(material, check_elastic_table(&material.elastic_table));
        self.rows(material, fields!(cards::Elastic: "shear modulus"), material.shear_modulus.map(|g| [g]).as_slice());
        self.rows(material, fields!(cards::Viscosity: "viscosity"), material.viscosity.map(|v| [v.0]).as_slice());
        self.rows(
            material,
            fields!(cards::Damping: "ALPHA", "BETA"),
            material.damping.map(|d| [d.alpha, d.beta]).as_slice(),
        );
        self.check_of(material, material.hyperelastic.as_ref().map_or(Ok(()), HyperelasticLaw::check));
    }

    /// Checks equation of state and crushable foam.
    fn compressible(&mut self, material: &MaterialDefinition) {
        match material.eos.as_ref().map(|eos| &eos.kind) {
            Some(EosKind::IdealGas(values)) => {
                self.rows(material, fields!(cards::Eos: "gas constant", "ambient pressure"), &[*values]);
            }
            Some(EosKind::UsUp(values)) => self.rows(material, fields!(cards::Eos: "c0", "s", "Gamma0"), &[*values]),
            Some(EosKind::Jwl(values)) => {
                let fields = fields!(cards::Eos: "detonation wave speed", "A", "B", "omega", "R1", "R2", "detonation energy",
                    "pre-detonation bulk modulus");
                self.rows(material, fields, &[*values]);
            }
            Some(kind @ EosKind::Tabular(_)) => self.check_of(material, kind.check()),
            Some(EosKind::Law(..)) | None => {}
        }
        match material.foam.shape {
            Some((FoamYieldSurface::Volumetric(values), _)) => {
                let fields =
                    fields!(cards::CrushableFoam: "compression yield stress ratio", "hydrostatic yield stress ratio");
                self.rows(material, fields, &[values]);
                let message = format!("the compression yield stress ratio must be positive, found {}", values[0]);
                self.check_of(material, require(values[0] > 0.0, message));
            }
            Some((FoamYieldSurface::Isotropic(values), _)) => {
                let fields = fields!(cards::CrushableFoam: "compression yield stress ratio", "plastic Poisson's ratio");
                self.rows(material, fields, &[values]);
            }
            None => {}
        }
        let fields = fields!(cards::CrushableFoamHardening: "yield stress in uniaxial compression", "plastic strain in compression");
        self.rows(material, fields, &material.foam.hardening);
        self.check_of(material, check_foam_hardening(&material.foam.hardening));
    }

    fn heat(&mut self, material: &MaterialDefinition) {
        let thermal = &material.thermal;
        let fraction = thermal.inelastic_heat_fraction.map(|fraction| [fraction]);
        self.rows(material, fields!(cards::InelasticHeatFraction: "fraction"), fraction.as_slice());
        let capacity = thermal.specific_heat.as_deref().unwrap_or_default();
        self.rows(material, fields!(cards::SpecificHeat: "specific heat", "temperature"), capacity);
        let conductivity = thermal.conductivity.as_ref().map_or(&[][..], |(rows, _)| rows);
        self.rows(material, fields!(cards::Conductivity: "conductivity", "temperature"), conductivity);
        let expansion = thermal.expansion.as_ref().map_or(&[][..], |e| &e.rows);
        self.rows(material, fields!(cards::Expansion: "coefficient", "temperature"), expansion);
        self.rows(material, fields!(cards::Expansion: "ZERO"), thermal.expansion.as_ref().map(|e| [e.zero]).as_slice());
    }

    fn flow(&mut self, material: &MaterialDefinition) {
        self.check_of(material, material.plastic.as_ref().map_or(Ok(()), |plastic| plastic.check()));
        match &material.rate {
            Some(RateDependence::PowerLaw(rows)) => {
                self.rows(material, fields!(cards::RateDependent: "D", "n", "temperature"), rows);
            }
            Some(RateDependence::JohnsonCook(values)) => {
                self.rows(material, fields!(cards::RateDependent: "C", "reference strain rate"), &[*values]);
            }
            Some(rate @ RateDependence::YieldRatio(_)) => self.check_of(material, rate.check()),
            None => {}
        }
        let resistance = material.cavity.map(|law| [law.yield_stress, law.a, law.b, law.c]);
        self.rows(material, fields!(cards::CavityExpansion: "YIELD", "A", "B", "C"), resistance.as_slice());
    }

    /// Checks the traction-separation law of cohesive elements.
    fn interface(&mut self, material: &MaterialDefinition) {
        let interface = &material.interface;
        self.rows(material, fields!(cards::Elastic: "Enn", "Ess"), interface.elastic.as_slice());
        let begins = interface.initiation.is_none_or(|i| i.limits.iter().all(|limit| is_positive(*limit)));
        self.check_of(material, require(begins, "values of damage initiation must be positive"));
        self.check_of(material, interface.evolution.as_ref().map_or(Ok(()), |e| check_softening(&e.softening)));
        self.check_of(material, interface.elastic.map_or(Ok(()), |e| check_coupling(e, interface.coupling)));
        let viscosity = interface.viscosity.map_or(0.0, |v| v.0);
        let message = format!("the viscosity of damage must not be negative, found {viscosity}");
        self.check_of(material, require(is_non_negative(viscosity), message));
        let is_complete = interface.evolution.is_none() || interface.initiation.is_some();
        self.check_of(
            material,
            require(is_complete, "damage evolution of cohesive elements requires damage initiation"),
        );
    }

    fn failure(&mut self, material: &MaterialDefinition) {
        let cutoff = material.tensile_failure.map(|t| [t.cutoff]);
        self.rows(material, fields!(cards::TensileFailure: "mean stress, tension"), cutoff.as_slice());
        let failed = material.failed.map(|f| [f.residual, f.crossings]);
        self.rows(material, fields!(cards::FailedMaterial: "residual strength", "crossings"), failed.as_slice());
        for criterion in &material.failures {
            self.check_of(material, criterion.strain.check());
            if let DamageEvolution::Displacement(value) | DamageEvolution::Energy(value) = criterion.evolution {
                let message = format!("the value of damage evolution must not be negative, found {value}");
                self.check_of(material, require(is_non_negative(value), message));
            }
            if let DamageEvolution::Strain(critical, length) = criterion.evolution {
                self.rows(material, fields!(cards::CoupledDamage: "critical damage"), &[[critical]]);
                let length = length.map(|length| [length]);
                self.rows(material, fields!(cards::CoupledDamage: "length"), length.as_slice());
            }
        }
    }
}

/// Returns the begin of messages about a material.
fn owner(material: &MaterialDefinition) -> String {
    format!("material `{}`: ", material.name)
}
