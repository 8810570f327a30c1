//! Traction-separation law of an interface: elasticity, damage initiation, damage evolution (ABAQUS Analysis User's
//! Guide, "Defining the constitutive response of cohesive elements using a traction-separation description").
//!
//! Separations and tractions have two components: normal (positive in tension) and shear. Damage D reduces both
//! tractions, except the normal traction in compression. All laws are functions of the effective separation
//! δ = √(⟨δn⟩² + δs²) along a ray of constant ratio of its components, where the stiffness of the ray is
//! K = (Kn ⟨δn⟩² + Ks δs²)/δ².
//!
//! With a coupling stiffness Kns the energy is ½ Kn e² + ½ (Ks - Kns²/Kn) δs² with e = δn + (Kns/Kn) δs. The normal traction
//! is Kn e. Damage reduces both terms, except the first in compression, e < 0.

use super::damage_envelope::{DamageEnvelope, EnvelopeShape};
use super::hardening::interpolate;
use super::lanes::InlineMap;
use crate::platform::PortableMath as _;
use revolve_derive::Persist;

/// Largest difference of the damage from that of the envelope at which the stored separation is on the envelope.
const ON_ENVELOPE: f64 = 1e-12;
/// Share of the largest damage at which a point of a law with viscosity has failed: its damage reaches the largest only
/// after an infinite time.
const FAILED_SHARE: f64 = 0.999;
/// Leverage below which rotations are neglected in the stiffness.
const SMALL_LEVERAGE: f64 = 0.01;

/// Criterion of damage initiation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamageInitiationLaw {
    /// Whether the squares of both components are added (QUADS, QUADE) or the larger component counts (MAXS, MAXE).
    pub quadratic: bool,
    /// Whether the criterion is one of tractions: the limits are tractions over the stiffness of their mode.
    pub in_tractions: bool,
    /// Separations at which damage begins in pure normal and pure shear mode, length.
    pub limits: [f64; 2],
}

impl DamageInitiationLaw {
    /// Returns the criterion for an opening (not negative) and a shear separation, or for the tractions over the stiffness of
    /// their mode. It is homogeneous of degree one; damage begins at 1. Equation (17.5).
    fn value(&self, [open, shear]: [f64; 2]) -> f64 {
        let parts = [open / self.limits[0], shear.abs() / self.limits[1]];
        if self.quadratic { parts[0].portable_hypot(parts[1]) } else { parts[0].max(parts[1]) }
    }

    /// Returns the criterion as it is output: squared if it is quadratic.
    fn shown(&self, value: f64) -> f64 {
        if self.quadratic { value * value } else { value }
    }
}

/// Measure of the mode mix in tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeMixRatio {
    /// Energy of the shear mode over the sum of both.
    Energy,
    /// 2/π times the angle of the traction from the normal.
    Traction,
}

/// Value at failure, an effective separation after initiation or a fracture energy per area, as a function of the mode
/// mix.
#[derive(Clone, Debug, PartialEq)]
pub enum ModeDependence {
    Independent(f64),
    /// Rows of value and mode mix, ascending; constant beyond the ends.
    Table(ModeMixRatio, Vec<[f64; 2]>),
    /// (Gn/Gnc)^α + (Gs/Gsc)^α = 1: fracture energies of both modes, and α.
    PowerLaw([f64; 2], f64),
    /// Gc = Gnc + (Gsc - Gnc) (Gs/G)^η (Benzeggagh and Kenane 1996): fracture energies of both modes, and η.
    BenzeggaghKenane([f64; 2], f64),
}

/// Damage evolution after initiation.
#[derive(Clone, Debug, PartialEq)]
pub enum InterfaceSoftening {
    /// Linear softening to a separation after initiation.
    Displacement(ModeDependence),
    /// Exponential softening to a separation after initiation, with the exponent.
    ExponentialDisplacement(ModeDependence, f64),
    /// Linear softening with a fracture energy.
    Energy(ModeDependence),
    /// Exponential softening with a fracture energy.
    ExponentialEnergy(ModeDependence),
    /// Rows of damage and separation after initiation, ascending from `[0, 0]`.
    Tabular(Vec<[f64; 2]>),
}

/// Traction-separation law of an interface.
#[derive(Clone, Debug, PartialEq)]
pub struct TractionSeparationLaw {
    /// Stiffness of both modes, traction per separation.
    pub stiffness: [f64; 2],
    /// Normal traction per shear separation, and shear traction per normal separation; its square is less than the product
    /// of both stiffnesses.
    pub coupling: f64,
    /// Damage initiation; `None` for an elastic interface.
    pub initiation: Option<DamageInitiationLaw>,
    /// Damage evolution; without it damage does not begin.
    pub softening: Option<InterfaceSoftening>,
    /// Upper limit of the damage, at which a point has failed.
    pub largest_damage: f64,
    /// Viscosity of the damage, time: the damage D that acts follows the damage D∞ of the law by dD/dt = (D∞ - D)/viscosity.
    /// 0 for damage that does not depend on the rate.
    pub viscosity: f64,
}

/// History of a point of an interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct InterfaceHistory {
    /// Damage that acts on the tractions, 0 to 1.
    pub damage: f64,
    /// Damage of the law without viscosity; 0 for a law without viscosity.
    pub inviscid_damage: f64,
    /// Largest effective separation with growing damage, length.
    pub separation: f64,
    /// Largest value of the initiation criterion; at most 1 if damage evolves.
    pub criterion: f64,
}

/// Response of a point of an interface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InterfaceResponse {
    /// Normal and shear traction.
    pub traction: [f64; 2],
    /// Dissipated energy, per area.
    pub dissipated: DissipatedEnergy,
}

/// Dissipated energy of an interface, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DissipatedEnergy {
    /// Energy that the law without viscosity dissipates for the same growth of the damage.
    pub by_damage: f64,
    /// The rest, which the viscosity of the damage dissipates.
    pub by_viscosity: f64,
}

impl DissipatedEnergy {
    /// Returns both energies times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> DissipatedEnergy {
        DissipatedEnergy { by_damage: factor * self.by_damage, by_viscosity: factor * self.by_viscosity }
    }

    /// Adds both energies times a factor.
    pub fn add(&mut self, other: DissipatedEnergy, factor: f64) {
        self.by_damage += factor * other.by_damage;
        self.by_viscosity += factor * other.by_viscosity;
    }
}

/// State of a point of an interface on which the stiffness depends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InterfaceStiffness {
    pub damage: f64,
    /// Whether the point is closed, or may close in the next increment. The stiffness of a damaged point rises then from
    /// 1 - D to 1: a body that meets such a spring of the frequency ω gets back at most its energy if (ω dt)² <= 4/(1 + D).
    pub closes: bool,
    /// Vector between the faces along normal and mid-surface, over the length of the mid-surface.
    pub leverage: [f64; 2],
}

/// Ray from the origin in the plane of both separations.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SeparationRay {
    /// Effective separation.
    size: f64,
    /// Stiffness of the ray.
    stiffness: f64,
    /// Energies of both modes over their sum.
    energies: [f64; 2],
    /// 2/π times the angle of the traction from the normal.
    angle: f64,
}

impl TractionSeparationLaw {
    /// Updates the history of a point that has moved from a previous separation to another in the time `dt`, and returns its
    /// response. With viscosity, the damage is exact for a damage of the law that is linear in this time. The dissipated
    /// energy is then the work of the trapezoidal rule less the stored energy: ½ dD times the product of both separations
    /// with the stiffness.
    pub fn advance(
        &self,
        history: &mut InterfaceHistory,
        [previous, separation]: [[f64; 2]; 2],
        dt: f64,
    ) -> InterfaceResponse {
        if self.viscosity == 0.0 {
            return self.update(history, separation);
        }
        let mut inviscid = InterfaceHistory { damage: history.inviscid_damage, ..*history };
        self.update(&mut inviscid, separation);
        let growth = relaxed(dt / self.viscosity, [history.inviscid_damage, inviscid.damage], history.damage);
        let damage = history.damage + growth;
        // Without the rounding of the sum.
        let growth = damage - history.damage;
        *history = InterfaceHistory { damage, inviscid_damage: inviscid.damage, ..inviscid };
        let [before, after] = [previous, separation].inline_map(|at| self.degradable_parts(at));
        let [of_normal, of_shear] = self.degradable_stiffness();
        let work = of_normal * before[0] * after[0] + of_shear * before[1] * after[1];
        let total = (0.5 * growth * work).max(0.0);
        let by_damage = total.min(self.damage_energy([damage - growth, damage], separation));
        let dissipated = DissipatedEnergy { by_damage, by_viscosity: total - by_damage };
        InterfaceResponse { traction: self.traction(history.damage, separation), dissipated }
    }

    /// Returns the energy that the law without viscosity dissipates per area while its damage grows from one value to
    /// another along the ray of a separation.
    fn damage_energy(&self, [from, to]: [f64; 2], separation: [f64; 2]) -> f64 {
        let (Some(initiation), Some(softening)) = (&self.initiation, &self.softening) else { return 0.0 };
        let value = initiation.value(self.initiation_measures(initiation, separation));
        if to <= from || value.is_nan() || value <= 0.0 {
            return 0.0;
        }
        let ray = self.ray(separation);
        let envelope = softening.envelope(&ray, ray.size / value);
        let [from, to] = [from, to].inline_map(|damage| envelope.dissipated(envelope.separation_at(damage)));
        ray.stiffness * (to - from).max(0.0)
    }

    /// Updates the history of a point of a law without viscosity to a separation, and returns its response. The dissipated
    /// energy is the exact integral of ½ K δ² dD along the ray of this separation.
    pub fn update(&self, history: &mut InterfaceHistory, separation: [f64; 2]) -> InterfaceResponse {
        let mut dissipated = DissipatedEnergy::default();
        if let Some(initiation) = &self.initiation {
            let value = initiation.value(self.initiation_measures(initiation, separation));
            let limit = if self.softening.is_some() { 1.0 } else { f64::INFINITY };
            history.criterion = history.criterion.max(initiation.shown(value).min(limit));
            if let Some(softening) = self.softening.as_ref().filter(|_| value > 1.0) {
                let ray = self.ray(separation);
                let envelope = softening.envelope(&ray, ray.size / value);
                dissipated.by_damage = ray.stiffness * self.grow(history, &envelope, ray.size);
            }
        }
        InterfaceResponse { traction: self.traction(history.damage, separation), dissipated }
    }

    /// Returns the tractions at a separation for a damage. Equations (17.4), (17.9).
    pub fn traction(&self, damage: f64, [normal, shear]: [f64; 2]) -> [f64; 2] {
        let (undamaged, ratio) = (1.0 - damage, self.coupling_ratio());
        let (elongation, [of_normal, of_shear]) = (normal + ratio * shear, self.degradable_stiffness());
        let normal = if elongation > 0.0 { undamaged * of_normal * elongation } else { of_normal * elongation };
        [normal, ratio * normal + undamaged * of_shear * shear]
    }

    /// Returns the normal separation that has the same normal traction as a unit of shear separation.
    fn coupling_ratio(&self) -> f64 {
        self.coupling / self.stiffness[0]
    }

    /// Returns the stiffnesses of the parts of [`Self::degradable_parts`].
    fn degradable_stiffness(&self) -> [f64; 2] {
        let [normal, shear] = self.stiffness;
        [normal, shear - self.coupling * self.coupling_ratio()]
    }

    /// Returns the parts of a separation on whose energy damage acts: the elongation that causes normal tension, and the
    /// shear separation.
    fn degradable_parts(&self, [normal, shear]: [f64; 2]) -> [f64; 2] {
        [(normal + self.coupling_ratio() * shear).max(0.0), shear]
    }

    /// Returns the tractions on which damage acts, at a separation without damage.
    fn degradable_traction(&self, separation: [f64; 2]) -> [f64; 2] {
        let (parts, [of_normal, of_shear]) = (self.degradable_parts(separation), self.degradable_stiffness());
        let normal = of_normal * parts[0];
        [normal, self.coupling_ratio() * normal + of_shear * parts[1]]
    }

    /// Returns the components that a criterion compares with its limits.
    fn initiation_measures(&self, initiation: &DamageInitiationLaw, separation: [f64; 2]) -> [f64; 2] {
        if initiation.in_tractions && self.coupling != 0.0 {
            let tractions = self.degradable_traction(separation);
            return [0, 1].inline_map(|i: usize| tractions[i] / self.stiffness[i]);
        }
        [separation[0].max(0.0), separation[1]]
    }

    /// Returns the largest eigenvalue of the stiffness without damage, with a factor on the normal stiffness.
    pub fn largest_stiffness(&self, factor: f64) -> f64 {
        let (normal, shear) = (factor * self.stiffness[0], self.stiffness[1]);
        if self.coupling == 0.0 {
            return normal.max(shear);
        }
        0.5 * (normal + shear) + (0.5 * (normal - shear)).portable_hypot(self.coupling)
    }

    /// Returns the energy per area that is released if the tractions at a separation vanish. Equation (17.9).
    pub fn stored(&self, damage: f64, separation: [f64; 2]) -> f64 {
        let [normal, shear] = self.traction(damage, separation);
        0.5 * (normal * separation[0] + shear * separation[1])
    }

    /// Returns the energy per area that is dissipated if the tractions at a separation vanish. A point with viscosity fails
    /// late: its damage would hold less energy.
    pub fn released(&self, damage: f64, separation: [f64; 2]) -> DissipatedEnergy {
        let stored = self.stored(damage, separation);
        let by_damage = match self.viscosity == 0.0 {
            true => stored,
            false => stored.min(self.damage_energy([damage, 1.0], separation)),
        };
        DissipatedEnergy { by_damage, by_viscosity: stored - by_damage }
    }

    /// Returns the stiffness that limits the time increment over that without damage, for a pair of points with these
    /// states. `leverage` holds, for each point, the normal and the shear vector between the faces over the length of the
    /// mid-surface, whose rotation they turn into shear and normal separations. Damage reduces the stiffness of open
    /// points; a closed point has the full normal stiffness. Equation (17.12).
    pub fn stiffness_ratio(&self, points: [InterfaceStiffness; 2]) -> f64 {
        let largest = self.largest_stiffness(1.0);
        let [of_normal, of_shear] = self.stiffness.inline_map(|k| if self.coupling == 0.0 { k / largest } else { 1.0 });
        let (mut direct, mut turned): (f64, f64) = (1.0, 0.0);
        for InterfaceStiffness { damage, closes, leverage } in points {
            let undamaged = 1.0 - damage;
            let normal = if closes { 1.0 } else { undamaged };
            if closes {
                direct = direct.max((1.0 + damage) * of_normal);
            }
            let [across, along] = leverage;
            turned += 0.5 * (normal * of_normal * along * along + undamaged * of_shear * across * across);
        }
        if turned < SMALL_LEVERAGE * SMALL_LEVERAGE {
            return direct;
        }
        let root = direct.sqrt() + turned.sqrt();
        root * root
    }

    /// Returns whether the point of this history has failed.
    pub fn has_failed(&self, history: &InterfaceHistory) -> bool {
        let share = if self.viscosity == 0.0 { 1.0 } else { FAILED_SHARE };
        self.softening.is_some() && history.damage >= share * self.largest_damage
    }

    /// Returns elastic energy at initiation and fracture energy of a pure mode (0 normal, 1 shear); `None` if the law
    /// has no fracture energy.
    pub fn energies_of_mode(&self, mode: usize) -> Option<[f64; 2]> {
        let initiation = self.initiation?;
        let (InterfaceSoftening::Energy(energy) | InterfaceSoftening::ExponentialEnergy(energy)) =
            self.softening.as_ref()?
        else {
            return None;
        };
        // With a coupling stiffness, the energy at initiation depends on the sign of the shear separation.
        let of_sign = |sign: f64| {
            let mut direction = [0.0; 2];
            direction[mode] = if mode == 0 { 1.0 } else { sign };
            let value = initiation.value(self.initiation_measures(&initiation, direction));
            let onset = if self.coupling == 0.0 { initiation.limits[mode] } else { 1.0 / value };
            let ray = self.ray(direction);
            [0.5 * ray.stiffness * onset * onset, energy.value(&ray)]
        };
        let [one, other] = [of_sign(1.0), of_sign(-1.0)];
        Some(if one[0] < other[0] { other } else { one })
    }

    fn ray(&self, separation: [f64; 2]) -> SeparationRay {
        let open = separation[0].max(0.0);
        let size = open.portable_hypot(separation[1]);
        let (parts, [of_normal, of_shear]) = (self.degradable_parts(separation), self.degradable_stiffness());
        let energy = of_normal * parts[0] * parts[0] + of_shear * parts[1] * parts[1];
        let [normal, shear] = self.degradable_traction(separation);
        let works = [normal * open, (shear * separation[1]).max(0.0)];
        let sum = works[0] + works[1];
        SeparationRay {
            size,
            stiffness: energy / (size * size),
            energies: works.inline_map(|work| work / sum),
            angle: libm::atan2(shear.abs(), normal) * std::f64::consts::FRAC_2_PI,
        }
    }

    /// Increases the damage to that of the envelope; returns the dissipated energy over the stiffness.
    fn grow(&self, history: &mut InterfaceHistory, envelope: &DamageEnvelope<'_>, size: f64) -> f64 {
        let reached = envelope.damage(size);
        if reached <= history.damage {
            return 0.0;
        }
        let previous = history.damage;
        let from = match previous {
            0.0 => envelope.onset,
            // The ratio of the modes has changed: the same damage is at another separation.
            _ if (envelope.damage(history.separation) - previous).abs() > ON_ENVELOPE => {
                envelope.separation_at(previous)
            }
            _ => history.separation,
        };
        let (damage, separation) = if reached > self.largest_damage {
            (self.largest_damage, envelope.separation_at(self.largest_damage))
        } else {
            (reached, size)
        };
        history.damage = damage.max(previous);
        history.separation = separation;
        (envelope.dissipated(separation) - envelope.dissipated(from)).max(0.0)
    }
}

/// Returns the growth of a damage that follows another one, which changes linearly from one value to the next in this
/// time, over the viscosity. Equations (17.10), (17.11).
fn relaxed(time: f64, [before, after]: [f64; 2], damage: f64) -> f64 {
    if time <= 0.0 {
        return 0.0;
    }
    let share = -libm::expm1(-time);
    (after - before) * (1.0 - share / time) + (before - damage) * share
}

impl InterfaceSoftening {
    /// Returns the damage as a function of the effective separation along a ray on which damage begins at `onset`.
    fn envelope(&self, ray: &SeparationRay, onset: f64) -> DamageEnvelope<'_> {
        let elastic = 0.5 * onset * onset;
        let shape = match self {
            InterfaceSoftening::Displacement(end) => EnvelopeShape::Linear(onset + end.value(ray)),
            InterfaceSoftening::ExponentialDisplacement(end, rate) => {
                EnvelopeShape::Exponential(onset + end.value(ray), *rate)
            }
            InterfaceSoftening::Energy(energy) => {
                EnvelopeShape::Linear((2.0 * energy.value(ray) / (ray.stiffness * onset)).max(onset))
            }
            InterfaceSoftening::ExponentialEnergy(energy) => {
                EnvelopeShape::EnergyExponential((energy.value(ray) / ray.stiffness - elastic).max(0.0))
            }
            InterfaceSoftening::Tabular(rows) => EnvelopeShape::Tabular(rows),
        };
        DamageEnvelope { onset, shape }
    }
}

impl ModeDependence {
    /// Equation (17.6).
    fn value(&self, ray: &SeparationRay) -> f64 {
        let [normal, shear] = ray.energies;
        match self {
            ModeDependence::Independent(value) => *value,
            ModeDependence::Table(ratio, rows) => {
                interpolate(rows, if *ratio == ModeMixRatio::Energy { shear } else { ray.angle })
            }
            ModeDependence::PowerLaw(energies, power) => {
                let term = |part: f64, energy: f64| libm::pow(part / energy, *power);
                libm::pow(term(normal, energies[0]) + term(shear, energies[1]), -1.0 / power)
            }
            ModeDependence::BenzeggaghKenane(energies, power) => {
                energies[0] + (energies[1] - energies[0]) * libm::pow(shear, *power)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{
        DamageInitiationLaw, InterfaceHistory, InterfaceSoftening, ModeDependence, ModeMixRatio, TractionSeparationLaw,
    };

    const ENERGIES: [f64; 2] = [0.3, 0.9];

    fn law(softening: InterfaceSoftening) -> TractionSeparationLaw {
        TractionSeparationLaw {
            stiffness: [2000.0, 800.0],
            initiation: Some(DamageInitiationLaw { quadratic: true, in_tractions: false, limits: [0.01, 0.03] }),
            softening: Some(softening),
            largest_damage: 1.0,
            viscosity: 0.0,
            coupling: 0.0,
        }
    }

    /// Returns the dissipated energy of a straight path, and the history at its end.
    fn separate(law: &TractionSeparationLaw, end: [f64; 2], steps: usize) -> (f64, InterfaceHistory) {
        let mut history = InterfaceHistory::default();
        let mut sum = 0.0;
        for i in 0..=steps {
            let share = i as f64 / steps as f64;
            sum += law.update(&mut history, [share * end[0], share * end[1]]).dissipated.by_damage;
        }
        (sum, history)
    }

    fn laws_of_energy(mode: &ModeDependence) -> [InterfaceSoftening; 2] {
        [InterfaceSoftening::Energy(mode.clone()), InterfaceSoftening::ExponentialEnergy(mode.clone())]
    }

    #[test]
    fn dissipated_energy_is_the_fracture_energy_in_every_mode() {
        let modes = [
            ModeDependence::Independent(0.5),
            ModeDependence::PowerLaw(ENERGIES, 1.6),
            ModeDependence::BenzeggaghKenane(ENERGIES, 2.1),
            ModeDependence::Table(ModeMixRatio::Energy, vec![[0.4, 0.0], [0.7, 0.5], [0.9, 1.0]]),
        ];
        for mode in &modes {
            for softening in laws_of_energy(mode) {
                let law = law(softening);
                for [open, shear] in [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8], [0.3, 1.0]] {
                    let work = [2000.0 * open * open, 800.0 * shear * shear];
                    let part = work[1] / (work[0] + work[1]);
                    let expected = match mode {
                        ModeDependence::Independent(value) => *value,
                        ModeDependence::PowerLaw(g, a) => {
                            (((1.0 - part) / g[0]).powf(*a) + (part / g[1]).powf(*a)).powf(-1.0 / a)
                        }
                        ModeDependence::BenzeggaghKenane(g, a) => g[0] + (g[1] - g[0]) * part.powf(*a),
                        ModeDependence::Table(..) if part < 0.5 => 0.4 + 0.6 * part,
                        ModeDependence::Table(..) => 0.7 + 0.4 * (part - 0.5),
                    };
                    for steps in [7, 100, 3001] {
                        let (energy, history) = separate(&law, [open, shear], steps);
                        assert!((energy / expected - 1.0).abs() < 1e-12, "{mode:?} {energy} {expected}");
                        assert!(history.damage > 1.0 - 1e-15 && history.criterion == 1.0);
                    }
                }
            }
        }
    }

    #[test]
    fn dissipated_energy_of_displacement_laws_is_the_area_below_the_curve() {
        // ½ K δ0 δf for the triangle; the table is a triangle with a drop at its end.
        let triangle = law(InterfaceSoftening::Displacement(ModeDependence::Independent(0.09)));
        let (energy, _) = separate(&triangle, [0.2, 0.0], 12);
        assert!((energy / (0.5 * 2000.0 * 0.01 * 0.1) - 1.0).abs() < 1e-13);
        for softening in [
            InterfaceSoftening::ExponentialDisplacement(ModeDependence::Independent(0.09), 3.0),
            InterfaceSoftening::Tabular(vec![[0.0, 0.0], [0.6, 0.02], [0.9, 0.04], [1.0, 0.09]]),
        ] {
            let law = law(softening);
            let (energy, history) = separate(&law, [0.2, 0.0], 40);
            assert_eq!(history.damage, 1.0);
            let (mut state, mut area, steps) = (InterfaceHistory::default(), 0.0, 400_000);
            let mut previous = 0.0;
            for i in 1..=steps {
                let traction = law.update(&mut state, [0.2 * f64::from(i) / f64::from(steps), 0.0]).traction[0];
                area += 0.5 * (previous + traction) * 0.2 / f64::from(steps);
                previous = traction;
            }
            assert!((energy / area - 1.0).abs() < 1e-8, "{energy} {area}");
        }
    }

    #[test]
    fn traction_angle_selects_the_separation_at_failure() {
        let rows = vec![[0.02, 0.0], [0.08, 1.0]];
        let mut law = law(InterfaceSoftening::Displacement(ModeDependence::Table(ModeMixRatio::Traction, rows)));
        law.stiffness = [1000.0; 2];
        law.initiation = Some(DamageInitiationLaw { quadratic: true, in_tractions: false, limits: [0.01; 2] });
        for (direction, end) in [([1.0, 0.0], 0.03), ([0.0, 1.0], 0.09), ([0.5_f64.sqrt(); 2], 0.06)] {
            for (size, failed) in [(0.999 * end, false), (1.001 * end, true)] {
                let mut history = InterfaceHistory::default();
                law.update(&mut history, [size * direction[0], size * direction[1]]);
                assert_eq!(law.has_failed(&history), failed, "{direction:?} {size}");
            }
        }
    }

    #[test]
    fn tiny_separations_dissipate_nothing() {
        let law = law(InterfaceSoftening::Energy(ModeDependence::PowerLaw(ENERGIES, 1.6)));
        for size in [0.0, 5e-324, 1e-200, 1e-160, 1e-9] {
            let mut history = InterfaceHistory::default();
            let response = law.update(&mut history, [size, -size]);
            assert_eq!((response.dissipated.by_damage, history.damage), (0.0, 0.0));
            assert!(response.traction.iter().all(|t| t.is_finite()));
        }
    }

    #[test]
    fn unloading_is_elastic_with_the_reduced_stiffness() {
        let law = law(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)));
        let mut history = InterfaceHistory::default();
        let peak = law.update(&mut history, [0.02, 0.0]);
        assert!(peak.dissipated.by_damage > 0.0 && history.damage > 0.0 && history.damage < 1.0);
        let half = law.update(&mut history, [0.01, 0.0]);
        assert_eq!(half.dissipated.by_damage, 0.0);
        assert!((half.traction[0] / (0.5 * peak.traction[0]) - 1.0).abs() < 1e-15);
        let again = law.update(&mut history, [0.02, 0.0]);
        assert_eq!((again.traction, again.dissipated.by_damage), (peak.traction, 0.0));
    }

    #[test]
    fn compression_does_not_damage_and_keeps_the_stiffness() {
        let law = law(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)));
        let mut history = InterfaceHistory::default();
        assert_eq!(law.update(&mut history, [-5.0, 0.0]).traction, [-10_000.0, 0.0]);
        assert_eq!(history, InterfaceHistory::default());
        let (_, mut failed) = separate(&law, [1.0, 0.0], 10);
        assert_eq!(law.update(&mut failed, [-5.0, 1.0]).traction, [-10_000.0, 0.0]);
    }

    /// Moves along a path of separations over the share of the path. Returns the dissipated energy and the work.
    fn separate_along(law: &TractionSeparationLaw, path: impl Fn(f64) -> [f64; 2]) -> (f64, f64, InterfaceHistory) {
        let (mut history, mut sum, mut work, steps) = (InterfaceHistory::default(), 0.0, 0.0, 200_000);
        let (mut from, mut previous) = (path(0.0), [0.0; 2]);
        for i in 1..=steps {
            let next = path(f64::from(i) / f64::from(steps));
            let response = law.update(&mut history, next);
            for axis in 0..2 {
                work += 0.5 * (previous[axis] + response.traction[axis]) * (next[axis] - from[axis]);
            }
            (from, previous) = (next, response.traction);
            sum += response.dissipated.by_damage + response.dissipated.by_viscosity;
        }
        (sum, work, history)
    }

    #[test]
    fn dissipation_of_a_changing_mode_mix_is_work_minus_stored_energy() {
        let laws = laws_of_energy(&ModeDependence::BenzeggaghKenane(ENERGIES, 2.1));
        let exponential = InterfaceSoftening::ExponentialDisplacement(ModeDependence::Independent(0.09), 3.0);
        for softening in laws.into_iter().chain([exponential]) {
            let law = law(softening);
            let path = |share: f64| [0.036 * share * (1.0 - 0.6 * share), 0.048 * share * share];
            let (sum, work, history) = separate_along(&law, path);
            let stored = law.stored(history.damage, path(1.0));
            assert!(history.damage > 0.5 && stored > 0.0);
            assert!((sum / (work - stored) - 1.0).abs() < 1e-4, "{sum} {work} {stored}");
        }
    }

    #[test]
    fn damage_stops_at_its_largest_value() {
        let mut law = law(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)));
        law.largest_damage = 0.9;
        let (sum, history) = separate(&law, [1.0, 0.0], 100);
        assert_eq!(history.damage, 0.9);
        assert!(law.has_failed(&history));
        assert!((law.update(&mut history.clone(), [1.0, 0.0]).traction[0] - 200.0).abs() < 1e-9);
        let elastic = law.stored(0.9, [history.separation, 0.0]);
        assert!(sum > 0.0 && sum < 0.5 && elastic > 0.0);
    }

    #[test]
    fn criterion_grows_beyond_one_without_evolution() {
        let mut law = law(InterfaceSoftening::Tabular(Vec::new()));
        law.softening = None;
        let mut history = InterfaceHistory::default();
        let response = law.update(&mut history, [0.02, 0.0]);
        assert_eq!((history.criterion, history.damage, response.traction[0]), (4.0, 0.0, 40.0));
        assert!(!law.has_failed(&history));
    }

    #[test]
    fn energy_below_the_elastic_energy_breaks_at_once() {
        let law = law(InterfaceSoftening::Energy(ModeDependence::Independent(1e-3)));
        assert_eq!(law.energies_of_mode(0), Some([0.1, 1e-3]));
        let (sum, history) = separate(&law, [0.02, 0.0], 1000);
        assert_eq!(history.damage, 1.0);
        assert!((sum / 0.1 - 1.0).abs() < 1e-12);
    }

    /// Coupling stiffness of both signs: less than √(2000 · 800) = 1265.
    const COUPLINGS: [f64; 2] = [700.0, -1100.0];

    fn coupled(softening: InterfaceSoftening, coupling: f64) -> TractionSeparationLaw {
        let initiation = DamageInitiationLaw { quadratic: true, in_tractions: true, limits: [0.01, 0.03] };
        TractionSeparationLaw { coupling, initiation: Some(initiation), ..law(softening) }
    }

    #[test]
    fn coupled_tractions_are_those_of_the_stiffness_matrix() {
        let law = coupled(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)), 700.0);
        for damage in [0.0, 0.4] {
            for [open, shear] in [[0.02, 0.01], [0.02, -0.03], [-0.001, 0.01]] {
                let expected = [2000.0 * open + 700.0 * shear, 700.0 * open + 800.0 * shear];
                let traction = law.traction(damage, [open, shear]);
                for mode in 0..2 {
                    assert!(
                        (traction[mode] - (1.0 - damage) * expected[mode]).abs() < 1e-13,
                        "{traction:?} {expected:?}"
                    );
                }
            }
        }
        // No tension: the normal traction keeps its stiffness.
        let [normal, _] = law.traction(0.9, [-0.02, 0.01]);
        assert!((normal - (-40.0 + 7.0)).abs() < 1e-13);
    }

    #[test]
    fn coupled_tractions_are_the_gradient_of_the_stored_energy() {
        for coupling in COUPLINGS {
            let law = coupled(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)), coupling);
            for (damage, at) in [(0.0, [0.01, 0.02]), (0.6, [0.01, -0.02]), (0.6, [-0.03, 0.02]), (1.0, [-0.03, -0.01])]
            {
                for axis in 0..2 {
                    let moved = |by: f64| {
                        let mut separation = at;
                        separation[axis] += by;
                        law.stored(damage, separation)
                    };
                    let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                    assert!((law.traction(damage, at)[axis] - slope).abs() < 1e-8, "{coupling} {damage} {at:?} {axis}");
                }
            }
        }
    }

    #[test]
    fn coupled_law_dissipates_the_fracture_energy_on_all_rays_with_tension() {
        for coupling in COUPLINGS {
            for softening in laws_of_energy(&ModeDependence::Independent(2.0)) {
                let law = coupled(softening, coupling);
                for end in
                    [[1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.6, 0.8], [0.6, -0.8], [-0.1, 0.8 * coupling.signum()]]
                {
                    let (energy, history) = separate(&law, end, 300);
                    assert!((energy / 2.0 - 1.0).abs() < 1e-12 && history.damage > 1.0 - 1e-15, "{end:?} {energy}");
                }
            }
        }
    }

    #[test]
    fn coupled_damage_begins_at_the_given_tractions() {
        for coupling in COUPLINGS {
            let law = coupled(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)), coupling);
            let separation = [0.012, 0.016];
            let tractions = law.traction(0.0, separation);
            assert!(tractions[0] > 0.0);
            let expected = (tractions[0] / 20.0).powi(2) + (tractions[1] / 24.0).powi(2);
            let mut history = InterfaceHistory::default();
            law.update(&mut history, separation.map(|x| 0.99 * x / expected.sqrt()));
            assert!((history.criterion - 0.99 * 0.99).abs() < 1e-14 && history.damage == 0.0);
            law.update(&mut history, separation.map(|x| 1.01 * x / expected.sqrt()));
            assert!(history.damage > 0.0);
        }
    }

    #[test]
    fn coupled_compression_does_not_damage() {
        for coupling in COUPLINGS {
            let law = coupled(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)), coupling);
            let mut history = InterfaceHistory::default();
            law.update(&mut history, [-5.0, 0.0]);
            assert_eq!(history, InterfaceHistory::default());
        }
    }

    #[test]
    fn coupled_dissipation_of_a_changing_mode_mix_is_work_minus_stored_energy() {
        for coupling in COUPLINGS {
            let law = coupled(InterfaceSoftening::Energy(ModeDependence::BenzeggaghKenane(ENERGIES, 2.1)), coupling);
            // Shear of the sign of the coupling causes tension, also in the closed part of the path.
            let path = |share: f64| [0.03 * share * (1.0 - 1.2 * share), coupling.signum() * 0.06 * share * share];
            let (sum, work, history) = separate_along(&law, path);
            let stored = law.stored(history.damage, path(1.0));
            assert!(history.damage > 0.3 && path(1.0)[0] < 0.0);
            assert!((sum / (work - stored) - 1.0).abs() < 1e-4, "{coupling}: {sum} {work} {stored}");
        }
    }

    #[test]
    fn largest_stiffness_is_the_largest_eigenvalue() {
        let law = coupled(InterfaceSoftening::Energy(ModeDependence::Independent(0.5)), 700.0);
        for factor in [1.0, 2.0] {
            let largest = law.largest_stiffness(factor);
            let determinant = (factor * 2000.0 - largest) * (800.0 - largest) - 700.0 * 700.0;
            assert!(largest > factor * 2000.0 && determinant.abs() < 1e-8 * largest * largest);
        }
    }

    /// Returns the tractions, the work and the dissipated energy of an opening at a constant velocity in `steps` increments.
    fn opened_slowly(
        law: &TractionSeparationLaw,
        end: f64,
        time: f64,
        steps: usize,
    ) -> (f64, f64, f64, InterfaceHistory) {
        let (mut history, mut last, mut work, mut sum) = (InterfaceHistory::default(), 0.0, 0.0, 0.0);
        let place_of = |i: usize| [end * i as f64 / steps as f64, 0.0];
        for i in 1..=steps {
            let response = law.advance(&mut history, [place_of(i - 1), place_of(i)], time / steps as f64);
            work += 0.5 * (last + response.traction[0]) * end / steps as f64;
            sum += response.dissipated.by_damage + response.dissipated.by_viscosity;
            last = response.traction[0];
        }
        (last, work, sum, history)
    }

    #[test]
    fn viscous_damage_follows_its_differential_equation() {
        // Linear softening from 0.01 to 0.1; opened to 0.08 in the time 1, damage begins at the time 1/8.
        let softening = InterfaceSoftening::Displacement(ModeDependence::Independent(0.09));
        for viscosity in [0.02, 0.3, 5.0] {
            let law = TractionSeparationLaw { viscosity, ..law(softening.clone()) };
            let inviscid = |time: f64| {
                let separation = 0.08 * time;
                if separation > 0.01 { 0.1 * (separation - 0.01) / (separation * 0.09) } else { 0.0 }
            };
            // Reference by the rule of Runge and Kutta with many small steps.
            let (mut expected, count) = (0.0, 400_000);
            let step = 1.0 / f64::from(count);
            for i in 0..count {
                let time = f64::from(i) * step;
                let rate = |time: f64, damage: f64| (inviscid(time) - damage) / viscosity;
                let first = rate(time, expected);
                let second = rate(time + 0.5 * step, expected + 0.5 * step * first);
                let third = rate(time + 0.5 * step, expected + 0.5 * step * second);
                let fourth = rate(time + step, expected + step * third);
                expected += step * (first + 2.0 * second + 2.0 * third + fourth) / 6.0;
            }
            let error = |steps: usize| (opened_slowly(&law, 0.08, 1.0, steps).3.damage - expected).abs();
            let errors = [error(200), error(400), error(3200)];
            assert!(errors[1] < 0.3 * errors[0] && errors[2] < 1e-6, "{viscosity}: {errors:?}");
            let (traction, ..) = opened_slowly(&law, 0.08, 1.0, 3200);
            assert!((traction / (2000.0 * 0.08 * (1.0 - expected)) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn viscosity_dissipates_the_work_that_is_not_stored() {
        let softening = InterfaceSoftening::Energy(ModeDependence::Independent(0.5));
        let mut previous = 0.5;
        for viscosity in [1e-3, 0.01, 0.1] {
            let law = TractionSeparationLaw { viscosity, ..law(softening.clone()) };
            for steps in [50, 2000] {
                let (_, work, sum, history) = opened_slowly(&law, 0.06, 1.0, steps);
                let stored = law.stored(history.damage, [0.06, 0.0]);
                assert!((sum + stored) / work - 1.0 < 1e-12 && (sum + stored) / work - 1.0 > -1e-12);
            }
            // Complete separation: the fracture energy and that of the viscosity.
            let (_, work, sum, history) = opened_slowly(&law, 0.3, 3.0, 40_000);
            assert!(history.damage > 0.9999 && law.has_failed(&history));
            assert!(sum > previous && work - sum > -1e-10 * work, "{viscosity}: {sum} {previous} {work}");
            previous = sum;
        }
    }

    #[test]
    fn viscosity_of_zero_and_a_very_small_one_are_the_law_itself() {
        let softening = InterfaceSoftening::Energy(ModeDependence::Independent(0.5));
        let expected = opened_slowly(&law(softening.clone()), 0.03, 1.0, 1000);
        let zero = opened_slowly(&TractionSeparationLaw { viscosity: 0.0, ..law(softening.clone()) }, 0.03, 1.0, 1000);
        assert_eq!(zero.0, expected.0);
        let small = opened_slowly(&TractionSeparationLaw { viscosity: 1e-9, ..law(softening) }, 0.03, 1.0, 1000);
        assert!((small.0 / expected.0 - 1.0).abs() < 1e-5, "{} {}", small.0, expected.0);
        assert!((small.2 / expected.2 - 1.0).abs() < 1e-3, "{} {}", small.2, expected.2);
    }
}
