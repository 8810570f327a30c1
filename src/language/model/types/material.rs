//! Materials as defined by their cards. The plan combines the material laws.

use super::strength::StrengthCards;
use crate::deck::Span;
use crate::kernel::laminate::Lamina;
pub use crate::kernel::traction_separation::{InterfaceSoftening, ModeDependence, ModeMixRatio};
use crate::resistance::CavityShape;

/// A material: the `*MATERIAL` card and the cards that follow it.
#[derive(Clone, Debug, Default)]
pub struct MaterialDefinition {
    /// Upper-case name.
    pub name: String,
    /// Source position of the `*MATERIAL` card.
    pub span: Span,
    /// Mass per volume at the initial temperature.
    pub density: Option<f64>,
    /// Rows of mass per volume and temperature; empty for a constant density.
    pub densities: Vec<[f64; 2]>,
    /// Young's modulus and Poisson's ratio; for a table, those of the stiffest row.
    pub elastic: Option<[f64; 2]>,
    /// Rows of Young's modulus, Poisson's ratio, temperature and field variables, with the temperature varying fastest;
    /// all rows have the same length. Empty for constant moduli.
    pub elastic_table: Vec<Vec<f64>>,
    /// Constants of a lamina (`*ELASTIC, TYPE=LAMINA`).
    pub lamina: Option<Lamina>,
    /// Shear modulus of `*ELASTIC, TYPE=SHEAR`.
    pub shear_modulus: Option<f64>,
    /// Rubber elasticity (`*HYPERELASTIC`).
    pub hyperelastic: Option<HyperelasticLaw>,
    /// Relation of pressure, density and internal energy (`*EOS`).
    pub eos: Option<EquationOfState>,
    /// Compaction of pores (`*EOS COMPACTION`); the density of the material is then that with pores.
    pub compaction: Option<PoreCompaction>,
    /// Dynamic shear viscosity, stress times time (`*VISCOSITY`), and its source position.
    pub viscosity: Option<(f64, Span)>,
    /// Detonation points (`*DETONATION POINT`): `[r, z, total time]` of each.
    pub detonation: Vec<[f64; 3]>,
    /// Yield stress and hardening (`*PLASTIC`).
    pub plastic: Option<PlasticityModel>,
    /// Crushable foam (`*CRUSHABLE FOAM` and its hardening).
    pub foam: FoamDefinition,
    /// Strength that depends on pressure, porosity or direction.
    pub strength: StrengthCards,
    /// Rayleigh damping (`*DAMPING`); `None` if both coefficients are zero.
    pub damping: Option<RayleighCoefficients>,
    /// Whether the yield stress is extrapolated linearly beyond the last row of the table (`EXTRAPOLATION=LINEAR`).
    pub extrapolates: bool,
    /// Strain rate dependence of the yield stress.
    pub rate: Option<RateDependence>,
    /// Properties for heat generation, heat conduction and thermal expansion.
    pub thermal: ThermalProperties,
    /// Failure criteria based on plastic strain, in deck order.
    pub failures: Vec<FailureCriterion>,
    /// Failure at a limit of the tensile hydrostatic stress (`*TENSILE FAILURE`).
    pub tensile_failure: Option<TensileFailure>,
    /// What remains of failed elements that stay (`*FAILED MATERIAL`, `*SHEAR FAILURE, ELEMENT DELETION=NO`).
    pub failed: Option<FailedMaterial>,
    /// Ranges in which the constants hold (`*MATERIAL RANGE`, extension).
    pub ranges: Vec<ValidityRange>,
    /// Traction-separation law of cohesive elements.
    pub interface: InterfaceDefinition,
    /// Resistance to cavity expansion (`*CAVITY EXPANSION`, extension).
    pub cavity: Option<CavityExpansion>,
    /// User subroutines of the material.
    pub user: UserDefinitions,
}

impl MaterialDefinition {
    /// Returns whether the material can be damaged or fail by its own criteria.
    pub fn has_failure(&self) -> bool {
        !self.failures.is_empty() || self.tensile_failure.is_some() || self.failed.is_some()
    }

    /// Returns whether damage or deletion by the material can take elastic energy.
    pub fn loses_elastic_energy(&self) -> bool {
        let StrengthCards { concrete, johnson_holmquist, holmquist_johnson_cook, porous_failure, .. } = &self.strength;
        let fractures = johnson_holmquist.is_some() || holmquist_johnson_cook.is_some();
        self.has_failure() || concrete.is_some() || porous_failure.is_some() || fractures
    }

    /// Returns whether the strength depends on pressure, porosity or direction.
    pub fn has_strength_law(&self) -> bool {
        self.strength.cards().next().is_some()
    }

    /// Returns whether the equation of state is that of an ideal gas.
    pub fn is_ideal_gas(&self) -> bool {
        matches!(self.eos, Some(EquationOfState { kind: EosKind::IdealGas(_), .. }))
    }

    /// Returns whether the equation of state is that of an explosive.
    pub fn is_explosive(&self) -> bool {
        matches!(self.eos, Some(EquationOfState { kind: EosKind::Jwl(_), .. }))
    }

    /// Returns whether a user subroutine gives the yield stress.
    pub fn has_user_hardening(&self) -> bool {
        matches!(self.plastic, Some(PlasticityModel::User(_)))
    }
}

/// Properties of a material for heat generation, heat conduction and thermal expansion.
#[derive(Clone, Debug, Default)]
pub struct ThermalProperties {
    /// Inelastic heat fraction: the fraction of plastic work that is converted to heat.
    pub inelastic_heat_fraction: Option<f64>,
    /// Rows of specific heat (energy per mass and temperature) and temperature (NaN where absent).
    pub specific_heat: Option<Vec<[f64; 2]>>,
    /// Rows of conductivity (power per length and temperature) and temperature (NaN where absent), with the source
    /// position.
    pub conductivity: Option<(Vec<[f64; 2]>, Span)>,
    /// Expansion coefficients and their reference temperature (`*EXPANSION`).
    pub expansion: Option<ThermalExpansion>,
}

/// Crushable foam: `*CRUSHABLE FOAM` and `*CRUSHABLE FOAM HARDENING`.
#[derive(Clone, Debug, Default)]
pub struct FoamDefinition {
    /// Yield surface and its source position.
    pub shape: Option<(FoamYieldSurface, Span)>,
    /// Rows of yield stress in uniaxial compression and plastic strain.
    pub hardening: Vec<[f64; 2]>,
}

/// User subroutines called at the material points of a material.
#[derive(Clone, Debug, Default)]
pub struct UserDefinitions {
    /// Properties of `*USER MATERIAL`, or of `*ANISOTROPIC HYPERELASTIC`.
    pub material: Option<Vec<f64>>,
    /// Strain energy of `*ANISOTROPIC HYPERELASTIC`.
    pub energy: Option<AnisotropicEnergyCard>,
    /// Properties of `*USER DEFINED FIELD` and the source position.
    pub fields: Option<(Vec<f64>, Span)>,
    /// Properties of `*CHARACTERISTIC LENGTH, DEFINITION=USER` and the source position.
    pub lengths: Option<(Vec<f64>, Span)>,
    /// Solution-dependent state variables (`*DEPVAR`).
    pub state: StateVariables,
    /// Names of state variables given by `*DEPVAR`; variables are counted from 0.
    pub state_names: Vec<(usize, String)>,
}

/// Strain energy of the invariants of a fibre-reinforced material (`*ANISOTROPIC HYPERELASTIC`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnisotropicEnergyCard {
    /// Whether VUANISOHYPER_INV computes the energy (`USER`); otherwise it is that of Holzapfel, Gasser and Ogden, with the
    /// constants C10, D, k1, k2 and kappa.
    pub is_user: bool,
    /// Families of fibres (`LOCAL DIRECTIONS`).
    pub families: usize,
}

/// Thermal expansion (`*EXPANSION`): thermal strain relative to a reference temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalExpansion {
    /// Rows of expansion coefficient and temperature (NaN where absent).
    pub rows: Vec<[f64; 2]>,
    /// Reference temperature of zero thermal strain (`ZERO`).
    pub zero: f64,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Solution-dependent state variables of user subroutines (`*DEPVAR`), per material point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateVariables {
    /// Number of variables.
    pub count: usize,
    /// Index from 0 of the variable that deletes the element when it becomes zero (`DELETE`).
    pub delete: Option<usize>,
}

/// Rubber elasticity (`*HYPERELASTIC`).
#[derive(Clone, Debug, PartialEq)]
pub struct HyperelasticLaw {
    /// Deviatoric part of the strain energy.
    pub shape: DeviatoricEnergy,
    /// Coefficients D1, D2, ... of the volumetric strain energy; all zero if the card gives no compressibility.
    pub compressibility: Vec<f64>,
    /// Measured values to which the constants are fitted (`TEST DATA INPUT`); empty for constants of the deck.
    pub test_data: Vec<RubberMeasurement>,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Kind of a test of rubber.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RubberTest {
    /// Tension or compression along one direction.
    Uniaxial,
    /// Equal tension along two directions.
    Equibiaxial,
    /// Tension of a wide sheet, whose width does not change (pure shear).
    Planar,
    /// Compression in volume.
    Volumetric,
}

/// A measured value of a test of rubber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RubberMeasurement {
    /// Kind of the test.
    pub test: RubberTest,
    /// Nominal stress, or pressure of a volumetric test.
    pub stress: f64,
    /// Stretch along the tension, or volume ratio of a volumetric test.
    pub stretch: f64,
}

/// Deviatoric strain energy of rubber, with its constants.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviatoricEnergy {
    /// Neo-Hooke form with the constant C10, stress.
    NeoHooke(f64),
    /// Polynomial: each C_ij with i and j.
    Polynomial(Vec<(f64, usize, usize)>),
    /// Ogden: each mu and alpha.
    Ogden(Vec<[f64; 2]>),
}

impl DeviatoricEnergy {
    /// Returns the initial shear modulus.
    pub fn shear(&self) -> f64 {
        match self {
            DeviatoricEnergy::NeoHooke(c10) => 2.0 * c10,
            DeviatoricEnergy::Polynomial(terms) => {
                2.0 * terms.iter().filter(|t| t.1 + t.2 == 1).map(|t| t.0).sum::<f64>()
            }
            DeviatoricEnergy::Ogden(terms) => terms.iter().map(|t| t[0]).sum(),
        }
    }
}

/// Yield surface of crushable foam: kind of hardening and initial shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FoamYieldSurface {
    /// Volumetric hardening: ratios of the initial yield stresses in uniaxial compression and in hydrostatic tension to
    /// the one in hydrostatic compression.
    Volumetric([f64; 2]),
    /// Isotropic hardening: ratio of the initial yield stress in uniaxial to hydrostatic compression, and plastic
    /// Poisson's ratio.
    Isotropic([f64; 2]),
}

/// Compaction of a porous material (`*EOS COMPACTION`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoreCompaction {
    /// Sound speed of the porous material at the start.
    pub speed: f64,
    /// Initial porosity, volume of the pores over the volume.
    pub porosity: f64,
    /// Pressures at which compaction begins and ends.
    pub pressures: [f64; 2],
    /// Density of the solid without pores (`*DENSITY`).
    pub solid_density: f64,
    /// Source position of the card.
    pub span: Span,
}

/// Equation of state (`*EOS`).
#[derive(Clone, Debug, PartialEq)]
pub struct EquationOfState {
    /// Form and constants.
    pub kind: EosKind,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Form of an equation of state, with its constants.
#[derive(Clone, Debug, PartialEq)]
pub enum EosKind {
    /// Ideal gas: specific gas constant (energy per mass and temperature) and ambient pressure.
    IdealGas([f64; 2]),
    /// Linear Us-Up Hugoniot: c0, s, Grueneisen coefficient.
    UsUp([f64; 3]),
    /// Tabulated: rows of f1, f2 and volumetric strain, in descending order of the strain.
    Tabular(Vec<[f64; 3]>),
    /// JWL explosive: detonation wave speed, A, B, omega, R1, R2, detonation energy per mass, bulk modulus before
    /// detonation.
    Jwl([f64; 8]),
    /// Law in Rust: its index in `EOS_TYPES` of the crate `numerics`, 0 for a registered one, and its constants.
    Law(usize, Vec<f64>),
}

/// A failure criterion: `*SHEAR FAILURE`, or `*DAMAGE INITIATION` with `*DAMAGE EVOLUTION`.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureCriterion {
    /// Plastic strain at which the element fails or damage initiates.
    pub strain: StrainAtFailure,
    /// Damage evolution after initiation.
    pub evolution: DamageEvolution,
    /// Source position of the keyword line.
    pub span: Span,
}

impl FailureCriterion {
    /// Returns whether the damage evolution depends on the element length.
    pub fn takes_length(&self) -> bool {
        use DamageEvolution::{Displacement, Energy, Strain};
        matches!(self.evolution, Displacement(_) | Energy(_) | Strain(_, Some(_)))
    }
}

/// Plastic strain at failure.
#[derive(Clone, Debug, PartialEq)]
pub enum StrainAtFailure {
    /// Failure strain that does not depend on the state.
    Constant(f64),
    /// Johnson-Cook: d1 to d5; then melting temperature, transition temperature and reference strain rate. `*SHEAR
    /// FAILURE` takes these three from `*PLASTIC` and `*RATE DEPENDENT` (`None`).
    JohnsonCook([f64; 5], Option<[f64; 3]>),
    /// Ductile damage: rows of strain, stress triaxiality, strain rate and temperature; the triaxiality varies fastest.
    Ductile(Vec<[f64; 4]>),
    /// Shear criterion: rows of strain, strain rate, ratio of pressure to Mises stress, and temperature; the rate
    /// varies fastest.
    Shear(Vec<[f64; 4]>),
}

/// Damage evolution after initiation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DamageEvolution {
    /// The element is deleted immediately.
    Sudden,
    /// No damage evolution: the criterion is evaluated but the stiffness is not reduced.
    Absent,
    /// Linear softening with plastic displacement; displacement at failure, length.
    Displacement(f64),
    /// Linear softening; fracture energy per area.
    Energy(f64),
    /// Proportional to the sum of the plastic strain over the failure strain (`*COUPLED DAMAGE`): critical damage, at which
    /// the material fails, and the element length for which the failure strain holds.
    Strain(f64, Option<f64>),
}

/// Traction-separation law of cohesive elements: `*ELASTIC, TYPE=TRACTION` or `COUPLED TRACTION`, `*DAMAGE INITIATION`
/// and `*DAMAGE EVOLUTION` with the criteria of cohesive elements, and `*DAMAGE STABILIZATION`.
#[derive(Clone, Debug, Default)]
pub struct InterfaceDefinition {
    /// Enn and Ess, traction per nominal strain.
    pub elastic: Option<[f64; 2]>,
    /// Ens, traction of one mode per nominal strain of the other; 0 for uncoupled tractions.
    pub coupling: f64,
    /// Viscosity of the damage (`*DAMAGE STABILIZATION`) with the source position of the card, time.
    pub viscosity: Option<(f64, Span)>,
    /// Damage initiation.
    pub initiation: Option<InterfaceInitiation>,
    /// Damage evolution.
    pub evolution: Option<InterfaceEvolution>,
}

/// Quantity that a criterion of damage initiation limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitiationMeasure {
    /// Nominal stress (MAXS, QUADS).
    Stress,
    /// Nominal strain of cohesive elements (MAXE, QUADE).
    Strain,
    /// Separation of cohesive surfaces (MAXU, QUADU).
    Separation,
}

/// Damage initiation of cohesive elements or cohesive surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceInitiation {
    /// Quantity that the values limit.
    pub measure: InitiationMeasure,
    /// Whether the components are combined by the sum of their squares (QUADS, QUADE, QUADU) and not by the largest.
    pub quadratic: bool,
    /// Values of the normal and the shear mode at initiation.
    pub limits: [f64; 2],
    /// Source position of the keyword line.
    pub span: Span,
}

/// Damage evolution of cohesive elements or cohesive surfaces. Displacements are effective separations after initiation.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceEvolution {
    /// Form of the softening.
    pub softening: InterfaceSoftening,
    /// Source position of the keyword line.
    pub span: Span,
}

/// What remains of failed elements that stay (`*FAILED MATERIAL`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailedMaterial {
    /// Fraction of the deviatoric stress that remains.
    pub residual: f64,
    /// Time of the loss of strength, in crossings of the element by a pressure wave; 0 for a sudden loss.
    pub crossings: f64,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Quantity with a range in which the constants of a material hold, in the order of the words of `*MATERIAL RANGE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangedQuantity {
    /// Rate of the equivalent plastic strain.
    StrainRate,
    /// Temperature.
    Temperature,
    /// Pressure, positive in compression.
    Pressure,
    /// Equivalent plastic strain.
    PlasticStrain,
}

impl RangedQuantity {
    /// All quantities.
    pub const ALL: [RangedQuantity; 4] = [
        RangedQuantity::StrainRate,
        RangedQuantity::Temperature,
        RangedQuantity::Pressure,
        RangedQuantity::PlasticStrain,
    ];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            RangedQuantity::StrainRate => "plastic strain rate",
            RangedQuantity::Temperature => "temperature",
            RangedQuantity::Pressure => "pressure",
            RangedQuantity::PlasticStrain => "plastic strain",
        }
    }

    /// Returns whether the flow stress of a metal is a function of the quantity that is known beyond the range.
    pub fn is_argument_of_flow_stress(self) -> bool {
        matches!(self, RangedQuantity::StrainRate | RangedQuantity::Temperature)
    }

    /// Returns the name of the quantity over which shares are weighted.
    pub fn basis(self) -> &'static str {
        if self == RangedQuantity::StrainRate { "mass and plastic strain" } else { "mass and time" }
    }
}

/// Range of a quantity in which the constants of a material hold (`*MATERIAL RANGE`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValidityRange {
    /// The quantity.
    pub quantity: RangedQuantity,
    /// Lower limit; minus infinity without one.
    pub low: f64,
    /// Upper limit; infinity without one.
    pub high: f64,
    /// Source position of the keyword line.
    pub span: Span,
}

impl ValidityRange {
    /// Returns the limits in words.
    pub fn limits(&self) -> String {
        let text = |limit: f64| {
            let is_short = limit == 0.0 || (1e-3..1e5).contains(&limit.abs());
            if is_short { limit.to_string() } else { format!("{limit:e}") }
        };
        match (self.low.is_finite(), self.high.is_finite()) {
            (true, true) => format!("{} to {}", text(self.low), text(self.high)),
            (true, false) => format!("from {}", text(self.low)),
            _ => format!("to {}", text(self.high)),
        }
    }
}

/// Failure at a tensile hydrostatic stress, and its effect on the stress (`*TENSILE FAILURE`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensileFailure {
    /// Hydrostatic cutoff stress: largest tensile mean stress.
    pub cutoff: f64,
    /// Whether the element is deleted when the cutoff is reached.
    pub deletes: bool,
    /// Whether a failed element that stays loses its deviatoric stress.
    pub loses_shear: bool,
    /// Whether a failed element that stays loses its tension.
    pub loses_tension: bool,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Yield stress and hardening (`*PLASTIC`).
#[derive(Clone, Debug)]
pub enum PlasticityModel {
    /// Isotropic hardening: rows of yield stress, plastic strain and temperature (NaN where absent).
    Tabular(Vec<[f64; 3]>),
    /// Johnson-Cook: A, B, n, m, melting temperature, transition temperature.
    JohnsonCook([f64; 6]),
    /// Linear kinematic hardening: initial yield stress, hardening slope and temperature (NaN where absent).
    Kinematic(Vec<[f64; 3]>),
    /// User subroutine VUHARD, with its properties.
    User(Vec<f64>),
    /// Rows of yield stress, plastic strain, temperature and field variables, with the plastic strain varying fastest;
    /// all rows have the same length.
    OverFields(Vec<Vec<f64>>),
}

impl PlasticityModel {
    /// Returns the yield stress without plastic strain of isotropic hardening: of the first row, or A of the Johnson-Cook law;
    /// `None` for the other laws.
    pub fn initial_yield_stress(&self) -> Option<f64> {
        match self {
            PlasticityModel::JohnsonCook([stress, ..]) => Some(*stress),
            PlasticityModel::Tabular(rows) => rows.first().map(|row| row[0]),
            _ => None,
        }
    }
}

/// Strain rate dependence of the yield stress (`*RATE DEPENDENT`).
#[derive(Clone, Debug)]
pub enum RateDependence {
    /// Johnson-Cook: C and the reference strain rate.
    JohnsonCook([f64; 2]),
    /// Cowper-Symonds power law: rows of D, n and temperature (NaN where absent).
    PowerLaw(Vec<[f64; 3]>),
    /// Rows of yield stress ratio, strain rate and temperature (NaN where absent).
    YieldRatio(Vec<[f64; 3]>),
}

/// Resistance of a material to the expansion of a cavity: `σ_n = Y (A + B x + C x²)` with `x = v_n √(ρ / Y)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CavityExpansion {
    /// Yield stress Y by which pressures are scaled, stress.
    pub yield_stress: f64,
    /// Constant A of the resistance law, dimensionless.
    pub a: f64,
    /// Constant B of the resistance law, dimensionless.
    pub b: f64,
    /// Constant C of the resistance law, dimensionless.
    pub c: f64,
    /// Data of the fit if the constants were derived from the material (`DERIVE`); `None` if given.
    pub derived: Option<ResistanceDerivation>,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Quality of the constants A, B, C that were fitted to the computed expansion pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResistanceDerivation {
    /// Shape of the cavity.
    pub shape: CavityShape,
    /// Velocity range of the fit.
    pub range: [f64; 2],
    /// Weighted root mean square of the residuals of the fit, divided by Y.
    pub residual: f64,
    /// Largest relative difference of the fitted law from the computed pressure, and the velocity at which it occurs.
    pub worst: [f64; 2],
    /// Quasi-static expansion pressure divided by Y.
    pub still: f64,
}

/// Coefficients of Rayleigh damping (`*DAMPING`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayleighCoefficients {
    /// Mass proportional damping, 1/time.
    pub alpha: f64,
    /// Stiffness proportional damping, time.
    pub beta: f64,
    /// Source position of the card.
    pub span: Span,
}
