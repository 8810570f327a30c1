//! Concrete damaged plasticity (Lubliner, Oliver, Oller, Onate 1989, Int. J. Solids Structures 25, 299; Lee and Fenves 1998,
//! J. Eng. Mech. 124, 892; ABAQUS Analysis User's Guide, "Concrete damaged plasticity").

use super::concrete_return::{ConcreteConstants, ConcretePath, ConcreteSurface, tension_share};
use super::concrete_tables::{ConcreteStrength, ConcreteTable, LARGEST_DAMAGE};
use super::law::{ReturnPoint, StressReturn, TrialStress, contraction};
use crate::kernel::lanes::InlineMap;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::stress::principal;
use crate::variables::{Variable, VariableComponent};

/// Limits that delete an element; the first one that is reached counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConcreteFailure {
    /// Tensile cracking strain.
    pub cracking_strain: Option<f64>,
    /// Tensile cracking strain times the length of the element.
    pub cracking_displacement: Option<f64>,
    /// Compressive inelastic strain.
    pub inelastic_strain: Option<f64>,
    /// Tensile damage.
    pub tension_damage: Option<f64>,
    /// Compressive damage.
    pub compression_damage: Option<f64>,
}

/// Concrete that yields by cracking and crushing, with a loss of stiffness that closing cracks recover.
#[derive(Clone, Debug)]
pub struct ConcreteDamagedPlasticity {
    /// Tangent of the dilation angle psi; values below [`SMALLEST_DILATANCY`] are raised to it.
    pub dilatancy: f64,
    /// Eccentricity of the hyperbolic flow potential.
    pub eccentricity: f64,
    /// Yield surface.
    pub surface: ConcreteSurface,
    /// Elastic moduli without damage, stress.
    pub moduli: ElasticModuli,
    /// Stress and damage in compression.
    pub compression: ConcreteTable,
    /// Stress and damage in tension.
    pub tension: ConcreteTable,
    /// Stiffness recovery under a change to tension (wt) and to compression (wc).
    pub recovery: [f64; 2],
    /// Deletion of the element.
    pub failure: Option<ConcreteFailure>,
}

/// Smallest tangent of the dilation angle: without dilation, no flow returns a hydrostatic tension.
const SMALLEST_DILATANCY: f64 = 0.01;

/// Smallest rounding of the flow potential over the tensile strength.
const SMALLEST_ROUNDING: f64 = 1e-3;

/// States: equivalent plastic strains in compression and tension, damages, degradation of the current stress.
pub(super) const COMPRESSION_STRAIN: usize = 0;
pub(super) const TENSION_STRAIN: usize = 1;
pub(super) const COMPRESSION_DAMAGE: usize = 2;
pub(super) const TENSION_DAMAGE: usize = 3;
pub(super) const DEGRADATION: usize = 4;

impl ConcreteDamagedPlasticity {
    /// Returns the degradation d of principal stresses under damages in compression and tension (Lee and Fenves 1998).
    /// Equation (20.18).
    #[inline(always)] // Into the return of each point.
    pub(super) fn degradation(&self, principal: [f64; 3], [compression, tension]: [f64; 2]) -> f64 {
        let [to_tension, to_compression] = self.recovery;
        let share = tension_share(principal);
        1.0 - (1.0 - (1.0 - to_tension * share) * compression)
            * (1.0 - (1.0 - to_compression * (1.0 - share)) * tension)
    }

    /// Returns the energy that a change of the degradation removes, from the effective stress before, the trial, and the share
    /// of its deviator and the pressure that remain. Trapezoidal work of the nominal stress on the elastic strain, minus the
    /// change of (1 - d) W: half the change of d times the product of both effective stresses over the moduli.
    #[inline(always)] // Into the return of each point.
    pub(super) fn lost_energy(
        &self,
        old: TrialStress,
        trial: TrialStress,
        [share, pressure]: [f64; 2],
        change: f64,
    ) -> f64 {
        let product = contraction(old.deviator, trial.deviator) * share / (2.0 * self.moduli.shear)
            + old.pressure * pressure / self.moduli.bulk;
        0.5 * change * product
    }

    /// Returns the constants of returns.
    pub(super) fn constants(&self) -> ConcreteConstants {
        let dilatancy = self.dilatancy.max(SMALLEST_DILATANCY);
        ConcreteConstants {
            bulk: self.moduli.bulk,
            per_shear: 1.0 / self.moduli.shear,
            surface: self.surface,
            dilatancy,
            rounding: self.tension.first() * (self.eccentricity * dilatancy).max(SMALLEST_ROUNDING),
        }
    }

    /// Returns whether a limit is reached.
    pub(super) fn fails(&self, strengths: [ConcreteStrength; 2], length: f64) -> bool {
        let Some(failure) = self.failure else { return false };
        let [compression, tension] = strengths;
        let reached = |limit: Option<f64>, value: f64| limit.is_some_and(|limit| value >= limit);
        let damaged =
            |limit: Option<f64>, value: f64| reached(limit.map(|limit| limit.min(LARGEST_DAMAGE) - 1e-9), value);
        reached(failure.cracking_strain, tension.inelastic)
            || reached(failure.cracking_displacement, tension.inelastic * length)
            || reached(failure.inelastic_strain, compression.inelastic)
            || damaged(failure.tension_damage, tension.damage)
            || damaged(failure.compression_damage, compression.damage)
    }
}

impl StressReturn for ConcreteDamagedPlasticity {
    fn describe(&self) -> String {
        let deletion = if self.failure.is_some() { ", with deletion" } else { "" };
        format!("concrete damaged plasticity{deletion}")
    }

    fn moduli(&self) -> ElasticModuli {
        self.moduli
    }

    fn initial_state(&self) -> Vec<f64> {
        vec![0.0; 5]
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        match part.variable {
            Variable::PlasticStrain => Some(COMPRESSION_STRAIN),
            Variable::TensionPlasticStrain => Some(TENSION_STRAIN),
            Variable::CompressionDamage => Some(COMPRESSION_DAMAGE),
            Variable::TensionDamage => Some(TENSION_DAMAGE),
            Variable::Degradation => Some(DEGRADATION),
            _ => None,
        }
    }

    fn deletes(&self) -> bool {
        self.failure.is_some()
    }

    fn recoverable_energy(&self, stress: [f64; 4], state: &[f64]) -> f64 {
        self.moduli.energy(stress) / (1.0 - state[DEGRADATION])
    }

    /// Equation (20.19).
    fn update(&self, point: &mut ReturnPoint<'_>) {
        let old_degradation = point.state[DEGRADATION];
        let effective =
            if old_degradation > 0.0 { scaled(point.carried, 1.0 / (1.0 - old_degradation)) } else { point.carried };
        if old_degradation > 0.0 {
            point.trial = TrialStress::elastic(effective, point.strain, self.moduli);
        }
        let trial = point.trial;
        let deviator = principal(trial.deviator);
        let start = [point.state[COMPRESSION_STRAIN], point.state[TENSION_STRAIN]];
        let sides = [&self.compression, &self.tension];
        let tables = [0, 1].inline_map(|side: usize| sides[side].line(start[side], sides[side].scale(point.length)));
        let start_strengths = [tables[0].effective, tables[1].effective];
        let outside = self.surface.value([trial.pressure, trial.mises, deviator[2] - trial.pressure], start_strengths);
        let mut stresses = deviator.inline_map(|value| value - trial.pressure);
        let [mut pressure, mut share] = [trial.pressure, 1.0];
        // A NaN is not returned, so that the run halts.
        if outside > 1e-11 * start_strengths[0] {
            let per_dt = if point.dt > 0.0 { 1.0 / point.dt } else { 0.0 };
            let (of, first_share) = (self.constants(), f64::NAN);
            let mut path = ConcretePath { tables, of, trial, deviator, start, start_strengths, per_dt, first_share };
            if !path.has_one_share(effective) {
                path.first_share = path.share_at_contact(effective, outside);
            }
            let end = path.end(outside);
            let strengths = [0, 1].inline_map(|side| path.strength::<false>(&end, side));
            point.state[COMPRESSION_STRAIN] += end.strains[0];
            point.state[TENSION_STRAIN] += end.strains[1];
            point.state[COMPRESSION_DAMAGE] = strengths[0].damage;
            point.state[TENSION_DAMAGE] = strengths[1].damage;
            point.deleted = self.fails(strengths, point.length);
            (stresses, pressure, share) = (end.principal, end.pressure, end.share);
        }
        let degradation = self.degradation(stresses, [point.state[COMPRESSION_DAMAGE], point.state[TENSION_DAMAGE]]);
        point.state[DEGRADATION] = degradation;
        point.return_to(pressure, share * trial.mises, (pressure - trial.pressure) / self.moduli.bulk);
        if degradation != old_degradation {
            let change = degradation - old_degradation;
            point.lost = self.lost_energy(TrialStress::of(effective), trial, [share, pressure], change);
        }
        point.stress = scaled(point.stress, 1.0 - degradation);
    }
}

/// Returns a stress times a factor.
#[inline(always)] // Into the return of each point.
pub(super) fn scaled(stress: [f64; 4], factor: f64) -> [f64; 4] {
    stress.inline_map(|component| factor * component)
}
