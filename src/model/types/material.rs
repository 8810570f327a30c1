//! Materials as their cards describe them.
//! Never here: which laws go together, which the plan says.

use crate::deck::Span;

/// A material.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Upper-case name.
    pub name: String,
    /// `*MATERIAL` card.
    pub span: Span,
    /// Mass per volume, at the initial temperature.
    pub density: Option<f64>,
    /// Rows of the mass per volume and temperature; empty where there is no temperature.
    pub densities: Vec<[f64; 2]>,
    /// Young's modulus and Poisson's ratio; of a table the stiffest row.
    pub elastic: Option<[f64; 2]>,
    /// Rows of Young's modulus, Poisson's ratio, temperature and field variables, as many in each, the temperature varying
    /// fastest; empty where the moduli are constant.
    pub elastic_table: Vec<Vec<f64>>,
    /// Shear modulus, of an `*ELASTIC, TYPE=SHEAR`.
    pub shear_modulus: Option<f64>,
    /// `*HYPERELASTIC`.
    pub hyperelastic: Option<Hyperelastic>,
    /// Equation of state.
    pub eos: Option<EquationOfState>,
    /// `*DETONATION POINT`: `[r, z]` and total time of each.
    pub detonation: Vec<[f64; 3]>,
    /// Yield description.
    pub plastic: Option<Plastic>,
    /// `*CRUSHABLE FOAM` and its hardening.
    pub foam: Foam,
    /// `*DAMPING, ALPHA`, 1/time, and the card; `None` where it is zero.
    pub damping: Option<(f64, Span)>,
    /// Whether the yield stress goes on beyond the last plastic strain of a table as between its last two rows
    /// (`EXTRAPOLATION=LINEAR`).
    pub extrapolates: bool,
    /// Rate dependence.
    pub rate: Option<RateDependence>,
    /// Heat: capacity, conduction, expansion.
    pub thermal: Thermal,
    /// Failure by the plastic strain, in the order of the deck.
    pub failures: Vec<FailureCriterion>,
    /// `*TENSILE FAILURE`.
    pub tensile_failure: Option<TensileFailure>,
    /// `*CAVITY EXPANSION` (extension).
    pub cavity: Option<CavityExpansion>,
    /// What user subroutines are asked for.
    pub user: UserDefinitions,
}

/// Thermal properties.
#[derive(Clone, Debug, Default)]
pub struct Thermal {
    /// Fraction of plastic work turned into heat.
    pub inelastic_heat_fraction: Option<f64>,
    /// Rows of the heat per mass and temperature, and the temperature (NaN where absent).
    pub specific_heat: Option<Vec<[f64; 2]>>,
    /// Rows of the heat a time, length and temperature, and the temperature (NaN where absent), with the card.
    pub conductivity: Option<(Vec<[f64; 2]>, Span)>,
    /// `*EXPANSION`.
    pub expansion: Option<Expansion>,
}

/// `*CRUSHABLE FOAM` and `*CRUSHABLE FOAM HARDENING`.
#[derive(Clone, Debug, Default)]
pub struct Foam {
    /// The yield surface and the card.
    pub shape: Option<(FoamShape, Span)>,
    /// Rows of the yield stress in uniaxial compression and the plastic strain.
    pub hardening: Vec<[f64; 2]>,
}

/// What user subroutines are asked for at the points of a material.
#[derive(Clone, Debug, Default)]
pub struct UserDefinitions {
    /// `*USER MATERIAL`: its constants.
    pub material: Option<Vec<f64>>,
    /// `*USER DEFINED FIELD`: constants of its routine, and the card.
    pub fields: Option<(Vec<f64>, Span)>,
    /// `*CHARACTERISTIC LENGTH, DEFINITION=USER`: constants of its routine, and the card.
    pub lengths: Option<(Vec<f64>, Span)>,
    /// `*DEPVAR`.
    pub state: StateVariables,
    /// Names that `*DEPVAR` gives variables, which are counted from 0.
    pub state_names: Vec<(usize, String)>,
}

/// `*EXPANSION`: thermal strain from a reference temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    /// Rows of the coefficient and the temperature (NaN where absent).
    pub rows: Vec<[f64; 2]>,
    /// Reference temperature (`ZERO`).
    pub zero: f64,
    /// The card.
    pub span: Span,
}

/// `*DEPVAR`: what the user's routines keep at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateVariables {
    /// How many variables.
    pub count: usize,
    /// The one, counted from 0, that deletes an element when it becomes zero (`DELETE`).
    pub delete: Option<usize>,
}

/// `*HYPERELASTIC`.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperelastic {
    /// Energy of a change of shape.
    pub shape: RubberShape,
    /// D1, D2, ... of the energy of a change of volume; all zero where the card gives no compressibility.
    pub compressibility: Vec<f64>,
    /// The card.
    pub span: Span,
}

/// Form of the energy of rubber and its constants.
#[derive(Clone, Debug, PartialEq)]
pub enum RubberShape {
    /// C10.
    NeoHooke(f64),
    /// Each C_ij with i and j.
    Polynomial(Vec<(f64, usize, usize)>),
    /// Each mu and alpha.
    Ogden(Vec<[f64; 2]>),
}

impl RubberShape {
    /// Initial shear modulus.
    pub fn shear(&self) -> f64 {
        match self {
            RubberShape::NeoHooke(c10) => 2.0 * c10,
            RubberShape::Polynomial(terms) => 2.0 * terms.iter().filter(|t| t.1 + t.2 == 1).map(|t| t.0).sum::<f64>(),
            RubberShape::Ogden(terms) => terms.iter().map(|t| t[0]).sum(),
        }
    }
}

/// How the yield surface of foam grows, and its shape at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FoamShape {
    /// By compaction: strength in uniaxial compression, and in hydrostatic tension, over that in hydrostatic compression.
    Volumetric([f64; 2]),
    /// Alike in all directions: strength in uniaxial over that in hydrostatic compression, plastic Poisson's ratio.
    Isotropic([f64; 2]),
}

/// `*EOS`.
#[derive(Clone, Debug, PartialEq)]
pub struct EquationOfState {
    /// Form and constants.
    pub kind: EosKind,
    /// The card.
    pub span: Span,
}

/// Form of an equation of state.
#[derive(Clone, Debug, PartialEq)]
pub enum EosKind {
    /// Ideal gas: gas constant (energy a mass and temperature) and ambient pressure.
    IdealGas([f64; 2]),
    /// Linear shock speed: c0, s, Grueneisen coefficient.
    UsUp([f64; 3]),
    /// Rows of f1, f2 and the volumetric strain, which descends.
    Tabular(Vec<[f64; 3]>),
    /// Explosive: speed of the detonation, A, B, omega, R1, R2, energy a mass, bulk modulus before the detonation.
    Jwl([f64; 8]),
}

/// `*SHEAR FAILURE`, or `*DAMAGE INITIATION` with its `*DAMAGE EVOLUTION`.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureCriterion {
    /// Plastic strain at which the element fails or its damage begins.
    pub strain: StrainAtFailure,
    /// What follows.
    pub evolution: DamageEvolution,
    /// The card.
    pub span: Span,
}

impl FailureCriterion {
    /// Whether what follows depends on the length of an element.
    pub fn takes_length(&self) -> bool {
        matches!(self.evolution, DamageEvolution::Displacement(_) | DamageEvolution::Energy(_))
    }
}

/// Plastic strain at failure.
#[derive(Clone, Debug, PartialEq)]
pub enum StrainAtFailure {
    /// A constant.
    Constant(f64),
    /// d1 to d5; melting temperature, transition temperature and reference rate, which `*SHEAR FAILURE` takes from
    /// `*PLASTIC` and `*RATE DEPENDENT`.
    JohnsonCook([f64; 5], Option<[f64; 3]>),
    /// Rows of strain, triaxiality, rate and temperature; the first variable varies fastest.
    Ductile(Vec<[f64; 4]>),
    /// Rows of strain, rate, pressure over von Mises stress, and temperature, likewise.
    Shear(Vec<[f64; 4]>),
}

/// How damage grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DamageEvolution {
    /// The element is deleted at once.
    Sudden,
    /// Not at all: no `*DAMAGE EVOLUTION`.
    Absent,
    /// Linear in the displacement; its value at failure.
    Displacement(f64),
    /// Linear, by the energy an area.
    Energy(f64),
}

/// `*TENSILE FAILURE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensileFailure {
    /// Mean stress that is not exceeded.
    pub cutoff: f64,
    /// Whether the element that reaches it is deleted.
    pub deletes: bool,
    /// The card.
    pub span: Span,
}

/// `*PLASTIC`.
#[derive(Clone, Debug)]
pub enum Plastic {
    /// Rows of yield stress, plastic strain, temperature (NaN where absent).
    Tabular(Vec<[f64; 3]>),
    /// A, B, n, m, melting temperature, transition temperature.
    JohnsonCook([f64; 6]),
    /// Linear kinematic: yield stress without plastic strain, slope of the stress over it, temperature (NaN where absent).
    Kinematic(Vec<[f64; 3]>),
    /// The routine of the user gives the yield stress, with these constants.
    User(Vec<f64>),
    /// Rows of yield stress, plastic strain, temperature and field variables, as many in each, the plastic strain varying
    /// fastest.
    OverFields(Vec<Vec<f64>>),
}

/// `*RATE DEPENDENT`.
#[derive(Clone, Debug)]
pub enum RateDependence {
    /// C and the reference strain rate.
    JohnsonCook([f64; 2]),
    /// Rows of D, n and temperature (NaN where absent).
    PowerLaw(Vec<[f64; 3]>),
    /// Rows of yield stress ratio, strain rate and temperature, likewise.
    YieldRatio(Vec<[f64; 3]>),
}

/// Resistance of a material to an expanding cavity: `sigma_n = Y (A + B x + C x^2)`, `x = v_n sqrt(rho / Y)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CavityExpansion {
    /// Y, stress.
    pub yield_stress: f64,
    /// A, dimensionless.
    pub a: f64,
    /// B, dimensionless.
    pub b: f64,
    /// C, dimensionless.
    pub c: f64,
    /// Where A, B and C come from, if the card derives them.
    pub derived: Option<Derivation>,
    /// The card.
    pub span: Span,
}

/// How constants were derived from a material's own curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivation {
    /// Range of velocities of the fit.
    pub range: [f64; 2],
    /// Root of the weighted mean square of what the fit leaves over, over Y.
    pub residual: f64,
    /// The largest relative difference of the law from the pressure, and the velocity there.
    pub worst: [f64; 2],
    /// Pressure at rest over Y.
    pub still: f64,
}
