//! Cards of materials, sections and element controls.

use super::{card, row};
use crate::deck::keywords::Keyword;
use crate::deck::value::{
    COUNT, FLAG, INTEGER, NOT_NEGATIVE, NUMBER, POSITIVE, TEMPERATURE, TEXT, YES_NO, ZERO, variant, word,
};

card!(Density: "DENSITY", "Mass per volume", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
    "PORE FLUID" refused "porous media are unsupported",
}, rows: Vec<[f64; 2]> = [(rows ["density" (POSITIVE.required()), "temperature" (TEMPERATURE)])]);

card!(Elastic: "ELASTIC", "Linear elasticity", (once below "MATERIAL"), {
    kind: usize = "TYPE" (variant(&["ISOTROPIC", "SHEAR", "TRACTION", "COUPLED TRACTION", "LAMINA"]).or(0.0)) "SHEAR: shear modulus for use with *EOS; TRACTION: uncoupled tractions of cohesive elements; COUPLED TRACTION: each traction depends on both separations; LAMINA: orthotropic in the plane of shells",
    fields: usize = "DEPENDENCIES" (INTEGER.from(0.0).to(5.0)) "Number of field variables",
    "MODULI" inert "without viscoelasticity instantaneous and long-term moduli are equal",
    "COMPRESSION FACTOR" refused "elasticity is equal in tension and compression",
}, [
    (when "TYPE" = "TRACTION" lines [
        "Enn" (POSITIVE.required()) "Normal traction per nominal strain, the separation over the constitutive thickness",
        "Ess" (POSITIVE.required()) "Shear traction per nominal strain",
        "Ett" inert "the faces do not move along the second shear direction, the hoop direction",
        "temperature" inert "the stiffness does not depend on temperature",
    ]),
    (when "TYPE" = "COUPLED TRACTION" lines [
        "Enn" (POSITIVE.required()) "Normal traction per nominal strain, the separation over the constitutive thickness",
        "Ess" (POSITIVE.required()) "Shear traction per nominal strain",
        "Ett" inert "the faces do not move along the second shear direction, the hoop direction",
        "Ens" (ZERO) "Normal traction per nominal shear strain, and shear traction per nominal normal strain; its square must be less than Enn Ess",
        "Ent" inert "the faces do not move along the second shear direction, the hoop direction",
        "Est" inert "the faces do not move along the second shear direction, the hoop direction",
        "temperature" inert "the stiffness does not depend on temperature",
    ]),
    (when "TYPE" = "LAMINA" lines [
        "E1" (POSITIVE.required()) "Young's modulus along direction 1 of the layer",
        "E2" (POSITIVE.required()),
        "nu12" (NUMBER.or(0.0)) "Poisson's ratio: strain along 2 over strain along 1 for stress along 1; its square must be less than E1/E2",
        "G12" (POSITIVE.required()) "Shear modulus in the plane",
        "G13" (POSITIVE.required()) "Transverse shear modulus of direction 1",
        "G23" (POSITIVE.required()) "Transverse shear modulus of direction 2",
        "temperature" inert "the moduli do not depend on temperature",
    ]),
    (when "TYPE" = "SHEAR" lines ["shear modulus" (POSITIVE.required()), "temperature" inert "the modulus does not depend on temperature"]),
    (when "DEPENDENCIES" rows [
        "Young's modulus" (POSITIVE.required()),
        "Poisson's ratio" (NUMBER.above(-1.0).below(0.5).or(0.0)) "0.5 has no stable time increment: give 0.49 or less",
        "temperature" (NUMBER),
        "field variable", "field variable", "field variable", "field variable", "field variable",
    ]),
    (rows ["Young's modulus" (POSITIVE.required()),
        "Poisson's ratio" (NUMBER.above(-1.0).below(0.5).or(0.0)) "0.5 has no stable time increment: give 0.49 or less",
        "temperature" (TEMPERATURE),
    ]),
]);

card!(Eos: "EOS", "Equation of state", (once below "MATERIAL"), {
    kind: usize = "TYPE" (variant(&["IDEAL GAS", "USUP", "TABULAR", "JWL", "USER"]).required()) "USER: equation of state in Rust",
    "DETONATION ENERGY" refused "ignition and growth is unsupported",
    "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants of TYPE=USER",
}, [
    (when "TYPE" = "IDEAL GAS" lines ["gas constant" (POSITIVE.required()), "ambient pressure" (NOT_NEGATIVE.or(0.0))]),
    (when "TYPE" = "USER" list "constant of the equation of state" (NUMBER) "Eight values per line"),
    (when "TYPE" = "TABULAR" rows ["f1" (ZERO), "f2" (ZERO), "volumetric strain" (ZERO) "ln(rho0/rho), in descending order"]),
    (when "TYPE" = "JWL" lines [
        "detonation wave speed" (POSITIVE.required()), "A" (POSITIVE.required()), "B" (NOT_NEGATIVE.required()),
        "omega" (POSITIVE.required()), "R1" (POSITIVE.required()), "R2" (POSITIVE.required()),
        "detonation energy" (NOT_NEGATIVE.required()) "Energy per mass of the explosive",
        "pre-detonation bulk modulus" (NOT_NEGATIVE.or(0.0)),
    ]),
    (lines ["c0" (POSITIVE.required()), "s" (NOT_NEGATIVE.or(0.0)), "Gamma0" (NOT_NEGATIVE.or(0.0))]),
]);

card!(EosCompaction: "EOS COMPACTION", "Compaction of a porous material (P-alpha), below *EOS, TYPE=USUP of the solid; *DENSITY is that of the solid", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, values: [f64; 4] = [(lines [
    "sound speed" (POSITIVE.required()) "Of the porous material at the start", "porosity" (NUMBER.above(0.0).below(1.0).required()) "Volume of the pores over the volume",
    "elastic limit" (POSITIVE.required()) "Pressure at which compaction begins", "compaction pressure" (POSITIVE.required()) "Pressure at which all pores are closed",
])]);

card!(Viscosity: "VISCOSITY", "Shear viscosity of a Newtonian fluid with *EOS: the deviatoric stress is twice the viscosity times the deviatoric strain rate", (once below "MATERIAL"), {
    "DEFINITION" only ["NEWTONIAN"] "the viscosity does not depend on the shear rate",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, viscosity: [f64; 1] = [(lines ["viscosity" (POSITIVE.required()) "Dynamic viscosity, stress times time", "temperature" inert "the viscosity does not depend on temperature"])]);

card!(DetonationPoint: "DETONATION POINT", "Points at which detonation begins", (once below "MATERIAL"), {}, points: Vec<[f64; 4]> = [
    (rows [
        "r" (ZERO), "z" (ZERO), "third coordinate" inert "a point in the r-z plane is a ring",
        "delay" (ZERO) "Total time of detonation at the point",
    ]),
]);

card!(Hyperelastic: "HYPERELASTIC", "Rubber elasticity", (once below "MATERIAL"), {
    "NEO HOOKE" (FLAG) "C10 and D1",
    "MODULI" inert "without viscoelasticity instantaneous and long-term moduli are equal",
    "MOONEY-RIVLIN" (FLAG) "C10, C01 and D1",
    "YEOH" (FLAG) "C10, C20, C30, D1, D2, D3",
    "OGDEN" (FLAG) "mu1, alpha1, mu2, alpha2, ..., then D1, ...; N of each",
    "POLYNOMIAL" (FLAG) "Default: C10, C01, C20, C11, C02, ..., then D1, ... up to order N",
    "REDUCED POLYNOMIAL" (FLAG) "C10, C20, ..., then D1, ... up to order N",
    order: Option<usize> = "N" (INTEGER.from(1.0).to(6.0)) "Order of OGDEN, POLYNOMIAL or REDUCED POLYNOMIAL; default 1",
    "POISSON" refused "give D1",
    "TEST DATA INPUT" (FLAG) "The constants are fitted to the test data cards that follow",
    "BETA" refused "applies only to VAN DER WAALS",
    "PROPERTIES" refused "applies only to user-defined strain energies",
} refused {
    "use POLYNOMIAL, OGDEN or their special cases": "ARRUDA-BOYCE", "MARLOW", "VAN DER WAALS", "USER";
}, [
    (when "TEST DATA INPUT" rows ["constant of a fit" refused "the constants are fitted to test data"]),
    (when "NEO HOOKE" lines ["C10" (NUMBER.required()), "D1" (NOT_NEGATIVE.or(0.0)), "temperature" inert "the constants do not depend on temperature"]),
    (list "constant" (NUMBER) "Eight values per line; with D1 = 0 the bulk modulus is 20 times the shear modulus"),
]);

card!(AnisotropicHyperelastic: "ANISOTROPIC HYPERELASTIC", "Rubber and tissue with fibres", (once below "MATERIAL"), {
    "HOLZAPFEL" (FLAG) "Energy of Holzapfel, Gasser and Ogden",
    is_user: bool = "USER" (FLAG) "User subroutine VUANISOHYPER_INV computes the energy",
    "FORMULATION" only ["INVARIANT"] "VUANISOHYPER_STRAIN is not called",
    families: usize = "LOCAL DIRECTIONS" (INTEGER.from(0.0).to(8.0).or(0.0)) "Number of families of fibres; their directions are on the *ORIENTATION of the section",
    "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants of USER",
    "TYPE" inert "applies only to implicit analyses",
    "MODULI" inert "without viscoelasticity instantaneous and long-term moduli are equal",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
} refused {
    "use HOLZAPFEL, or write the energy as VUANISOHYPER_INV or VUMAT user subroutine": "FUNG-ANISOTROPIC", "FUNG-ORTHOTROPIC";
}, [
    (when "USER" list "constant of the energy" (NUMBER) "Eight values per line"),
    (lines [
        "C10" (POSITIVE.required()) "Half the shear modulus of the matrix",
        "D" (NOT_NEGATIVE.or(0.0)) "Two over the bulk modulus; with 0 the bulk modulus is 20 times the shear modulus of the matrix",
        "k1" (NOT_NEGATIVE.or(0.0)), "k2" (NOT_NEGATIVE.or(0.0)),
        "kappa" (NOT_NEGATIVE.to(1.0 / 3.0).or(0.0)) "Dispersion of the fibres: 0 aligned, 1/3 isotropic",
        "temperature" inert "the constants do not depend on temperature",
    ]),
]);

/// Defines the card of the test data of a mode of deformation.
macro_rules! test_data {
    ($type:ident, $keyword:literal, $summary:literal, $stress:literal, $strain:literal) => {
        card!($type: $keyword, $summary, (once below "MATERIAL"), {
            "SMOOTH" refused "smooth the data before",
            "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
        }, rows: Vec<[f64; 2]> = [
            (rows [$stress (NUMBER.required()), $strain (NUMBER.above(-1.0).required()),
                "lateral strain" inert "rubber is fitted as incompressible", "temperature" inert "the constants do not depend on temperature"]),
        ]);
    };
}

test_data!(
    UniaxialTestData,
    "UNIAXIAL TEST DATA",
    "Measured tension or compression of rubber, for *HYPERELASTIC, TEST DATA INPUT",
    "nominal stress",
    "nominal strain"
);
test_data!(
    BiaxialTestData,
    "BIAXIAL TEST DATA",
    "Measured equibiaxial tension of rubber, for *HYPERELASTIC, TEST DATA INPUT",
    "nominal stress",
    "nominal strain"
);
test_data!(
    PlanarTestData,
    "PLANAR TEST DATA",
    "Measured planar tension (pure shear) of rubber, for *HYPERELASTIC, TEST DATA INPUT",
    "nominal stress",
    "nominal strain"
);
test_data!(
    VolumetricTestData,
    "VOLUMETRIC TEST DATA",
    "Measured compression of rubber in volume, for *HYPERELASTIC, TEST DATA INPUT",
    "pressure",
    "volume ratio"
);

card!(CrushableFoam: "CRUSHABLE FOAM", "Crushable foam plasticity", (once below "MATERIAL"), {
    isotropic: bool = "HARDENING" (word(&["VOLUMETRIC", "ISOTROPIC"]).or(0.0)),
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, ratios: [f64; 2] = [
    (when "HARDENING" = "ISOTROPIC" lines [
        "compression yield stress ratio" (NUMBER.from(0.0).below(3.0).required()),
        "plastic Poisson's ratio" (NUMBER.above(-1.0).below(0.5).or(0.0)),
        "temperature" inert "the constants do not depend on temperature",
    ]),
    (lines [
        "compression yield stress ratio" (POSITIVE.below(3.0).required()),
        "hydrostatic yield stress ratio" (NOT_NEGATIVE.or(1.0)),
        "temperature" inert "the constants do not depend on temperature",
    ]),
]);

card!(CrushableFoamHardening: "CRUSHABLE FOAM HARDENING", "Hardening of crushable foam in uniaxial compression", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, rows: Vec<[f64; 2]> = [
    (rows ["yield stress in uniaxial compression" (POSITIVE.required()),
    "plastic strain in compression" (NOT_NEGATIVE.or(0.0).ascending()), "temperature" refused "the table does not depend on temperature"]),
]);

card!(Damping: "DAMPING", "Rayleigh damping of a material", (once below "MATERIAL"), {
    alpha: f64 = "ALPHA" (NOT_NEGATIVE.or(0.0)) "Mass proportional damping, 1/time",
    beta: f64 = "BETA" (NOT_NEGATIVE.or(0.0)) "Stiffness proportional damping, time; reduces the stable time increment",
    "COMPOSITE" inert "applies only to modal procedures",
    "STRUCTURAL" inert "applies only to steady-state procedures",
}, []);

card!(ShearFailure: "SHEAR FAILURE", "Failure by plastic strain", (once below "MATERIAL"), {
    johnson_cook: bool = "TYPE" (variant(&["TABULAR", "JOHNSON COOK"]).or(0.0)),
    deletes: bool = "ELEMENT DELETION" (YES_NO.or(1.0)) "NO: failed elements stay without shear strength and tension; *FAILED MATERIAL leaves a residual strength",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, [
    (when "TYPE" = "JOHNSON COOK" lines ["d1" (ZERO), "d2" (ZERO), "d3" (ZERO), "d4" (ZERO), "d5" (ZERO)]),
    (rows [
        "plastic strain at failure" (POSITIVE.required()), "rate of the plastic strain" (ZERO),
        "pressure over von Mises stress" (ZERO), "temperature" (ZERO),
        "field variable" refused "only *ELASTIC and *PLASTIC may depend on field variables",
    ]),
]);

card!(TensileFailure: "TENSILE FAILURE", "Tensile cutoff, spall", (once below "MATERIAL"), {
    deletes: bool = "ELEMENT DELETION" (YES_NO.or(1.0)) "NO: the mean stress is limited to the cutoff",
    loses_tension: bool = "PRESSURE" (variant(&["DUCTILE", "BRITTLE"]).or(0.0)) "Without deletion: DUCTILE limits the tension by the cutoff, BRITTLE removes it",
    loses_shear: bool = "SHEAR" (variant(&["DUCTILE", "BRITTLE"]).or(0.0)) "Without deletion: DUCTILE keeps the deviatoric stress, BRITTLE removes it",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, cutoff: [f64; 1] = [(lines ["mean stress, tension" (POSITIVE.required()), "temperature" inert "the cutoff does not depend on temperature"])]);

card!(DamageInitiation: "DAMAGE INITIATION", "Damage initiation criterion", (below "MATERIAL" | "SURFACE INTERACTION"), {
    criterion: usize = "CRITERION" (variant(&["JOHNSON COOK", "DUCTILE", "MAXS", "QUADS", "MAXE", "QUADE", "MAXU", "QUADU"]).required()) "MAXS, QUADS: largest component or quadratic sum of the nominal stress, for cohesive elements and surfaces; MAXE, QUADE: of the nominal strain, for cohesive elements; MAXU, QUADU: of the separation, for cohesive surfaces",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
    "ACCUMULATION POWER" refused "the sum of plastic strain increments over the failure strain is used",
    "ALPHA" refused "applies only to HASHIN",
    "KS" refused "applies only to SHEAR",
    "LODE DEPENDENT" refused "the failure strain depends on triaxiality, not on the Lode angle",
    "INSTABILITY" refused "applies only to FLD",
} refused {
    "applies only to MSFLD": "NUMBER IMPERFECTIONS", "OMEGA", "DEFINITION", "FEQ", "FNN", "FNT", "FREQUENCY", "PEINC";
    "applies only to enriched elements": "POSITION", "NORMAL DIRECTION", "TOLERANCE";
    "applies only to user-defined criteria": "PROPERTIES", "FAILURE MECHANISMS";
}, [
    (when "CRITERION" = "JOHNSON COOK" lines [
        "d1" (ZERO), "d2" (ZERO), "d3" (ZERO), "d4" (ZERO), "d5" (ZERO), "melting temperature" (ZERO),
        "transition temperature" (ZERO), "reference rate" (ZERO),
    ]),
    (when "CRITERION" = "MAXS" | "QUADS" lines [
        "normal stress" (POSITIVE.required()), "shear stress" (POSITIVE.required()),
        "second shear stress" inert "the faces do not move along the second shear direction",
        "temperature" inert "the values do not depend on temperature",
    ]),
    (when "CRITERION" = "MAXE" | "QUADE" lines [
        "normal strain" (POSITIVE.required()), "shear strain" (POSITIVE.required()),
        "second shear strain" inert "the faces do not move along the second shear direction",
        "temperature" inert "the values do not depend on temperature",
    ]),
    (when "CRITERION" = "MAXU" | "QUADU" lines [
        "normal separation" (POSITIVE.required()), "shear separation" (POSITIVE.required()),
        "second shear separation" inert "the surfaces do not move along the second shear direction",
        "temperature" inert "the values do not depend on temperature",
    ]),
    (rows [
        "plastic strain" (POSITIVE.required()), "triaxiality" (ZERO), "rate of the plastic strain" (ZERO),
        "temperature" (ZERO),
        "field variable" refused "only *ELASTIC and *PLASTIC may depend on field variables",
    ]),
]);

card!(DamageEvolution: "DAMAGE EVOLUTION", "Damage evolution", (below "MATERIAL" | "SURFACE INTERACTION"), {
    energy: bool = "TYPE" (variant(&["DISPLACEMENT", "ENERGY"]).required()),
    softening: usize = "SOFTENING" (word(&["LINEAR", "EXPONENTIAL", "TABULAR"]).or(0.0)) "EXPONENTIAL and TABULAR: for cohesive elements and surfaces only",
    "DEGRADATION" only ["MAXIMUM"] "the largest damage is used",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
    mixed_mode: usize = "MIXED MODE BEHAVIOR" (word(&["TABULAR", "MODE INDEPENDENT", "POWER LAW", "BK"]).or(0.0)) "For cohesive elements and surfaces: TABULAR (default; without MODE MIX RATIO the values do not depend on the mode), POWER LAW or BK (Benzeggagh-Kenane) with TYPE=ENERGY",
    ratio: Option<usize> = "MODE MIX RATIO" (word(&["ENERGY", "TRACTION"])) "For cohesive elements and surfaces with TABULAR mixed modes: measure of the mode mix in the table",
    power: Option<f64> = "POWER" (POSITIVE) "Exponent of POWER LAW or BK",
    "FAILURE INDEX" refused "applies only to user-defined criteria",
}, rows: Vec<[f64; 3]> = [
    (when "MIXED MODE BEHAVIOR" = "POWER LAW" | "BK" lines [
        "normal fracture energy" (POSITIVE.required()), "shear fracture energy" (POSITIVE.required()),
        "second shear fracture energy" inert "the faces do not move along the second shear direction",
        "temperature" inert "the values do not depend on temperature",
    ]),
    (when "SOFTENING" = "TABULAR" rows [
        "damage" (NUMBER.from(0.0).to(1.0).required()), "displacement after initiation" (NOT_NEGATIVE.required()),
        "mode mix" refused "with SOFTENING=TABULAR the table does not depend on the mode mix",
    ]),
    (when "SOFTENING" = "EXPONENTIAL" rows [
        "displacement or energy at failure" (NOT_NEGATIVE.required()),
        "exponent or mode mix" (NOT_NEGATIVE) "Exponent with TYPE=DISPLACEMENT, mode mix with TYPE=ENERGY",
        "mode mix" (NUMBER.from(0.0).to(1.0)),
    ]),
    (when "MODE MIX RATIO" = "ENERGY" | "TRACTION" rows [
        "displacement or energy at failure" (NOT_NEGATIVE.required()), "mode mix" (NUMBER.from(0.0).to(1.0).required()),
        "second mode mix" inert "the faces do not move along the second shear direction",
        "temperature" inert "the values do not depend on temperature",
    ]),
    (lines ["displacement or energy at failure" (NOT_NEGATIVE.required()), "temperature" inert "the value does not depend on temperature"]),
]);

card!(CoupledDamage: extension "COUPLED DAMAGE", "Damage that reduces the flow stress from the start: the critical damage times the sum of the plastic strain over the failure strain of *DAMAGE INITIATION. At a sum of 1 the material fails", (below "MATERIAL"), {},
values: [f64; 2] = [
    (lines [
        "critical damage" (NUMBER.from(0.0).below(1.0).required()) "Damage at failure, e.g. 0.3 for Weldox 460 E (Borvik and others 2001)",
        "length" (POSITIVE) "Element length for which the failure strain holds. In elements of another length, the strain to failure is inversely proportional to it: the width of a shear band is that of an element. Default: no dependence on the length",
    ]),
]);

card!(FailedMaterial: extension "FAILED MATERIAL", "Failed elements stay: they keep the pressure in compression and a fraction of the shear strength, and have no tension", (once below "MATERIAL"), {},
values: [f64; 2] = [
    (lines [
        "residual strength" (NUMBER.from(0.0).below(1.0).or(0.1)) "Fraction of the deviatoric stress that remains",
        "crossings" (NOT_NEGATIVE.or(1.0)) "Time of the loss of strength, in crossings of the element by a pressure wave",
    ]),
]);

/// Words of the quantities of `*MATERIAL RANGE`, in the order of `RangedQuantity`.
const RANGED: &[&str] = &["STRAIN RATE", "TEMPERATURE", "PRESSURE", "PLASTIC STRAIN"];

card!(MaterialRange: extension "MATERIAL RANGE", "Range in which the constants of the material hold, from their source. It does not change the results: the ledger lists the share of mass and time beyond it. The verdict is `suspect` if the flow stress is extrapolated by more than 5 % on average, or if 5 % are beyond a range of pressure or plastic strain", (once below "MATERIAL"), {
}, rows: Vec<[f64; 3]> = [(rows [
    "quantity" (word(RANGED).required()) "STRAIN RATE: rate of the plastic strain, weighted by the plastic strain in place of time; TEMPERATURE; PRESSURE, positive in compression; PLASTIC STRAIN",
    "lower limit" (NUMBER) "Default: none",
    "upper limit" (NUMBER) "Default: none",
])]);

card!(DamageStabilization: "DAMAGE STABILIZATION", "Viscosity of the damage of cohesive elements and surfaces: the damage that acts follows that of the law with a delay", (below "MATERIAL" | "SURFACE INTERACTION"), {
}, viscosity: [f64; 1] = [(lines ["viscosity" (NOT_NEGATIVE.required()) "Time in which the damage follows; 0: no delay"])]);

card!(PhysicalConstants: "PHYSICAL CONSTANTS", "Absolute zero and other constants", (once), {
    absolute_zero: Option<f64> = "ABSOLUTE ZERO" (NUMBER) "Absolute zero on the temperature scale of the deck",
    "STEFAN BOLTZMANN" inert "radiation is unsupported",
    "UNIVERSAL GAS CONSTANT" inert "the gas constant is given on *EOS",
}, []);

card!(Plastic: "PLASTIC", "Metal plasticity", (once below "MATERIAL"), {
    hardening: usize = "HARDENING" (variant(&["ISOTROPIC", "KINEMATIC", "JOHNSON COOK", "USER"]).or(0.0)) "KINEMATIC: two rows per temperature; USER: subroutine VUHARD",
    "RATE" refused "give *RATE DEPENDENT",
    fields: usize = "DEPENDENCIES" (INTEGER.from(0.0).to(5.0)) "Number of field variables",
    "DATA TYPE" refused "applies only to cyclic hardening",
    extrapolates: Option<bool> = "EXTRAPOLATION" (word(&["CONSTANT", "LINEAR"])) "Extrapolation beyond the last plastic strain; default CONSTANT",
    "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants of HARDENING=USER",
    "SCALESTRESS" refused "give scaled yield stresses",
    "USER" refused "give HARDENING=USER",
} refused {
    "applies only to combined hardening": "NUMBER BACKSTRESSES", "STATIC RECOVERY";
}, [
    (when "HARDENING" = "USER" list "constant of the hardening" read "Eight values per line"),
    (when "HARDENING" = "JOHNSON COOK" lines ["A" (ZERO), "B" (ZERO), "n" (NOT_NEGATIVE.or(0.0)), "m" (ZERO), "melting temperature" (ZERO), "transition temperature" (ZERO)]),
    (when "DEPENDENCIES" rows [
        "yield stress" (ZERO), "plastic strain" (ZERO), "temperature" (NUMBER),
        "field variable", "field variable", "field variable", "field variable", "field variable",
    ]),
    (rows ["yield stress" (ZERO), "plastic strain" (ZERO), "temperature" (NUMBER)]),
]);

card!(RateDependent: "RATE DEPENDENT", "Rate dependence of the yield stress", (once below "MATERIAL"), {
    kind: usize = "TYPE" (variant(&["POWER LAW", "YIELD RATIO", "JOHNSON COOK"]).or(0.0)),
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, [
    (when "TYPE" = "JOHNSON COOK" lines ["C" (ZERO), "reference strain rate" (POSITIVE.or(1.0))]),
    (when "TYPE" = "YIELD RATIO" rows ["yield ratio" (ZERO), "strain rate" (NUMBER.or(1.0)), "temperature" (NUMBER)]),
    (rows ["D" (POSITIVE.required()), "n" (POSITIVE.or(1.0)), "temperature" (TEMPERATURE)]),
]);

card!(InelasticHeatFraction: "INELASTIC HEAT FRACTION", "Fraction of plastic work converted to heat", (once below "MATERIAL"), {}, fraction: [f64; 1] = [
    (lines ["fraction" (NUMBER.or(0.9))]),
]);

card!(SpecificHeat: "SPECIFIC HEAT", "Specific heat, energy per mass and temperature", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
} refused {
    "applies only to gases in fluid cavities": "CONSTANT PRESSURE", "CONSTANTVOLUME";
}, rows: Vec<[f64; 2]> = [(rows ["specific heat" (POSITIVE.required()), "temperature" (TEMPERATURE)])]);

card!(Conductivity: "CONDUCTIVITY", "Thermal conductivity, for *DYNAMIC TEMPERATURE-DISPLACEMENT", (once below "MATERIAL"), {
    "TYPE" only ["ISO"] "anisotropic materials are unsupported",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
    "PORE FLUID" refused "porous media are unsupported",
}, rows: Vec<[f64; 2]> = [(rows ["conductivity" (POSITIVE.required()), "temperature" (TEMPERATURE)])]);

card!(Expansion: "EXPANSION", "Thermal expansion", (once below "MATERIAL"), {
    "TYPE" only ["ISO"] "anisotropic materials are unsupported",
    zero: f64 = "ZERO" (ZERO) "Reference temperature of the coefficients",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
    "DEFINITION" only ["SECANT"] "coefficients are secant values from the reference temperature",
    "PORE FLUID" refused "porous media are unsupported",
    "FIELD" refused "expansion by field variables is unsupported",
} refused {
    "user-defined expansion is unsupported": "USER", "PROPERTIES";
}, rows: Vec<[f64; 2]> = [(rows ["coefficient" (ZERO), "temperature" (TEMPERATURE)])]);

card!(UserMaterial: "USER MATERIAL", "Material model of user subroutine VUMAT", (once below "MATERIAL"), {
    count: usize = "CONSTANTS" (INTEGER.from(0.0).required()) "Number of constants",
    "TYPE" only ["MECHANICAL"] "thermal user materials are unsupported",
    "UNSYMM" inert "applies only to implicit analyses",
    "EFFMOD" refused "initial moduli are taken from the call at time zero",
    "HYBRID FORMULATION" refused "applies only to implicit analyses",
}, [(list "constant" (NUMBER) "Eight values per line")]);

card!(CavityExpansion: extension "CAVITY EXPANSION", "Resistance of a target material: Y (A + B x + C x^2), x = v_n sqrt(rho/Y)", (once below "MATERIAL"), {
    yield_stress: Option<f64> = "YIELD" (POSITIVE) "Y, the reference strength",
    derives: bool = "DERIVE" (FLAG) "Computes Y, A, B and C from the cards of strength of the material, or from *ELASTIC, *DENSITY and *PLASTIC: cavity expansion, fitted over a range of velocities",
    shape: usize = "TYPE" (word(&["SPHERICAL", "CYLINDRICAL"]).or(0.0)) "With DERIVE: shape of the cavity, SPHERICAL (default, deep penetration) or CYLINDRICAL (hole expansion in plates)",
    linear: bool = "TERMS" (word(&["2", "3"]).or(1.0)) "With DERIVE: number of terms, 3 (default) or 2 (B = 0)",
    pinned: bool = "STATIC" (FLAG) "With DERIVE: A is the quasi-static cavity pressure and is not fitted",
    weight: usize = "WEIGHT" (word(&["EVEN", "RELATIVE", "VELOCITY"]).or(0.0)) "With DERIVE: weights of the fit, EVEN (absolute pressure differences, default), RELATIVE (relative differences) or VELOCITY (weighted by velocity)",
    radius: Option<f64> = "RADIUS" (POSITIVE) "With DERIVE: cavity radius, for the strain rates of *RATE DEPENDENT or of the law",
    tension: Option<f64> = "TENSION" (POSITIVE) "With DERIVE: tensile strength, above which radial cracks form",
    length: Option<f64> = "LENGTH" (POSITIVE) "With DERIVE: length of the elements whose softening over displacements the target has (*CONCRETE TENSION STIFFENING)",
}, values: [f64; 3] = [
    (when "DERIVE" lines ["lowest velocity" (NUMBER.required()), "highest velocity" (NUMBER.required()), "number of velocities" (NUMBER) "Default: 41, or 9 for the law of cards of strength"]),
    (lines ["A" (NOT_NEGATIVE.required()), "B" (NOT_NEGATIVE.required()), "C" (NOT_NEGATIVE.required())]),
]);

card!(Orientation: "ORIENTATION", "Material directions of shell sections and of their layers, and of fibres in solids", (), {
    "NAME" read "Name",
    system: usize = "SYSTEM" (word(&["RECTANGULAR", "CYLINDRICAL", "SPHERICAL", "Z RECTANGULAR", "USER"]).or(0.0)) "RECTANGULAR (default); no other is supported",
    definition: usize = "DEFINITION" (word(&["COORDINATES", "NODES", "OFFSET TO NODES"]).or(0.0)) "COORDINATES (default); no other is supported",
    families: usize = "LOCAL DIRECTIONS" (INTEGER.from(0.0).to(8.0).or(0.0)) "Number of directions of fibres of *ANISOTROPIC HYPERELASTIC, on the third and the next lines",
}, [(rows [
    "first value" read "First line: r, z and 0 of a point in the local direction 1; then of a point in the plane of the local directions 1 and 2; then of the origin (default 0). Second line: the local direction closest to the normal of the shell (default 1), for solids the one about which the directions are rotated, and the angle of rotation in degrees. A line for each direction of fibres: its components along the local directions 1, 2 and 3",
    "second value", "third value", "fourth value", "fifth value", "sixth value", "seventh value", "eighth value", "ninth value",
])]);

card!(ShellSection: "SHELL SECTION", "Thickness and material of shell elements", (), {
    "ELSET" read "Elements",
    "MATERIAL" read "Material; not with COMPOSITE",
    composite: bool = "COMPOSITE" (FLAG) "The section has layers: one data line for each, from the side SNEG to the side SPOS",
    symmetric: bool = "SYMMETRIC" (FLAG) "With COMPOSITE: the same layers follow in reverse order",
    per_area: f64 = "DENSITY" (NOT_NEGATIVE.or(0.0)) "Additional mass per area",
    "POISSON" read "Thickness change: MATERIAL (default), ELASTIC, or an effective Poisson's ratio; 0 keeps the thickness constant",
    "SECTION INTEGRATION" only ["SIMPSON"] "Simpson's rule is used through the thickness",
    "OFFSET" read "Distance from the middle surface to the nodes along the normal, over the thickness: -0.5 to 0.5, SPOS (0.5) or SNEG (-0.5); default 0",
    "LAYUP" inert "name of the layup, written by ABAQUS/CAE",
    "CONTROLS" inert "shell elements with one point have no hourglass modes",
    "ORIENTATION" read "*ORIENTATION whose direction 1 replaces the meridian as origin of the angles of layers",
    "TEMPERATURE" inert "initial temperatures of shells are uniform over the thickness",
    "SECTION NAME" inert "written by ABAQUS/CAE; has no effect",
} refused {
    "give the thickness of the section on its data line": "NODAL THICKNESS", "SHELL THICKNESS";
    "applies only to continuum shells": "STACK DIRECTION", "THICKNESS MODULUS";
}, layers: Vec<[f64; 2]> = [
    (when "COMPOSITE" rows [
        "layer thickness" (POSITIVE.required()),
        "points" (INTEGER.from(3.0).to(1001.0).or(3.0)) "Odd number of points of Simpson's rule through the layer",
        "material" (TEXT.required()),
        "angle or orientation" read "Angle in degrees from the meridian, or from direction 1 of ORIENTATION, to direction 1 of the layer, counter-clockwise about the normal; or the name of an *ORIENTATION",
        "ply name" inert "has no effect",
    ]),
    (lines ["thickness" (POSITIVE.required()), "points" (INTEGER.from(3.0).to(1001.0).or(5.0)) "Odd number of points of Simpson's rule through the thickness"]),
]);

card!(CohesiveSection: "COHESIVE SECTION", "Material and constitutive thickness of cohesive elements", (), {
    "ELSET" read "Elements",
    "MATERIAL" read "Material",
    "RESPONSE" only ["TRACTION SEPARATION"] "tractions follow from separations: give *ELASTIC, TYPE=TRACTION",
    geometric: bool = "THICKNESS" (word(&["SPECIFIED", "GEOMETRY"]).or(0.0)) "Constitutive thickness: SPECIFIED (default) on the data line, GEOMETRY: initial distance of the faces",
    "CONTROLS" read "Section controls: ELEMENT DELETION, MAX DEGRADATION, VISCOSITY",
    "STACK DIRECTION" only ["2"] "the nodes 1 and 2 are the bottom face, 3 and 4 the top face",
    "ORIENTATION" refused "the thickness direction is the normal of the mid-surface",
    "SECTION NAME" inert "written by ABAQUS/CAE; has no effect",
} refused {
    "applies only to implicit analyses": "SYMMETRIC", "HALF";
}, values: [f64; 1] = [(lines [
    "thickness" (POSITIVE.or(1.0)) "Constitutive thickness; default 1: nominal strains are separations",
    "out-of-plane thickness" inert "the elements are rings",
])]);

card!(Erosion: extension "EROSION", "Deletes elements that reach one of these limits, independent of their material", (), {
    "ELSET" read "Elements; default: all deformable elements",
    distortion: Option<f64> = "DISTORTION" (NUMBER.from(0.0).below(1.0).bare(0.01)) "Minimum scaled Jacobian: sine of the corner angles relative to a square or an equilateral triangle; 0 for a folded element; 0.01 if no value is given",
    plastic: Option<f64> = "PLASTIC STRAIN" (POSITIVE) "Equivalent plastic strain; for shells at the middle surface",
    strain: Option<f64> = "PRINCIPAL STRAIN" (POSITIVE) "Maximum principal logarithmic strain, in the plane or in the hoop direction",
    increment: Option<f64> = "INCREMENT" (POSITIVE) "Minimum stable time increment of the element",
}, []);

card!(SectionControls: "SECTION CONTROLS", "Hourglass, distortion and viscosity controls of elements", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name of the controls",
    hourglass: Option<usize> = "HOURGLASS" (variant(&["RELAX STIFFNESS", "STIFFNESS", "VISCOUS", "COMBINED", "ENHANCED"])) "Default: RELAX STIFFNESS (stiffness whose force relaxes with plastic flow); VISCOUS for materials without shear modulus; ENHANCED (assumed strains) for *HYPERELASTIC",
    distortion: bool = "DISTORTION CONTROL" (YES_NO.or(0.0).bare(1.0)),
    length_ratio: Option<f64> = "LENGTH RATIO" (POSITIVE.below(1.0)) "For distortion control: a corner is pushed back if its distance from the line between its neighbours, relative to the initial one, is below this ratio; default 0.1",
    deletes: bool = "ELEMENT DELETION" (YES_NO.or(1.0)) "NO: elements failed by *DAMAGE EVOLUTION remain with the fraction (1 - MAX DEGRADATION) of their stiffness; an error with *SHEAR FAILURE and *TENSILE FAILURE, which delete elements, unless *FAILED MATERIAL keeps them",
    most_damage: Option<f64> = "MAX DEGRADATION" (POSITIVE.to(1.0)) "Damage at which an element is deleted (default 1), or the maximum damage if elements are not deleted (default 0.99)",
    "SECOND ORDER ACCURACY" inert "rotations within a stable time increment are small, and a body of revolution cannot spin in the r-z plane",
    "KINEMATIC SPLIT" only ["AVERAGE STRAIN"] "strains are averaged over the element",
    "DRILL STIFFNESS" inert "applies only to shells",
    "RAMP INITIAL STRESS" inert "applies only to membranes",
    viscosity: f64 = "VISCOSITY" (NOT_NEGATIVE.or(0.0)) "For cohesive elements: viscosity of the damage, a time; see *DAMAGE STABILIZATION",
    weight: f64 = "WEIGHT FACTOR" (NUMBER.from(0.0).to(1.0).or(0.5)) "For COMBINED: weight of the stiffness relative to the viscosity",
    by_area: bool = "WEIGHTING" extension (word(&["VOLUME", "AREA"]).or(0.0)) "AREA: equations of motion integrated over the plane section",
    averaged: Option<bool> = "AVERAGED PRESSURE" extension (YES_NO) "For triangles of linear elasticity or rubber: YES averages the dilation over nodes; default YES for plastic materials, rubber and Poisson's ratio above 0.45",
    subzonal: Option<bool> = "SUBZONAL" extension (YES_NO) "YES: subzonal pressures from the density of the element quarters; default YES for *EOS without shear modulus on a mesh that follows the material",
    "PERTURBATION" refused "applies only to implicit analyses",
} refused {
    "conversion to particles is unsupported": "CONVERSION CRITERION", "CONVERSION", "KERNEL", "PARTICLE";
    "applies only to cohesive elements": "VISCOUS", "INITIAL GAP OPENING";
}, factor: [f64; 1] = [(lines [
    "hourglass factor" (NOT_NEGATIVE.or(1.0)),
    "rotational factor" inert "applies only to shells",
    "out-of-plane factor" inert "applies only to shells",
    "factor on linear bulk viscosity" only ["1"] "give *BULK VISCOSITY in the step",
    "factor on quadratic bulk viscosity" only ["1"] "give *BULK VISCOSITY in the step",
])]);

/// Keywords of materials, sections and element controls.
pub const CARDS: &[Keyword] = &[
    row!("MATERIAL", "Begins a material", (unique "NAME"), {
        "NAME" read "Name of the material",
        "RTOL" inert "tables are used as given, without regularisation",
        "SRATE FACTOR" only ["1"] "strain rates are not smoothed",
        "STRAIN RATE REGULARIZATION" inert "tables are used as given, without regularisation",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
    }, []),
    Density::ROW,
    Elastic::ROW,
    Eos::ROW,
    EosCompaction::ROW,
    Viscosity::ROW,
    DetonationPoint::ROW,
    Hyperelastic::ROW,
    AnisotropicHyperelastic::ROW,
    UniaxialTestData::ROW,
    BiaxialTestData::ROW,
    PlanarTestData::ROW,
    VolumetricTestData::ROW,
    CrushableFoam::ROW,
    CrushableFoamHardening::ROW,
    Damping::ROW,
    ShearFailure::ROW,
    TensileFailure::ROW,
    DamageInitiation::ROW,
    DamageEvolution::ROW,
    CoupledDamage::ROW,
    FailedMaterial::ROW,
    MaterialRange::ROW,
    DamageStabilization::ROW,
    PhysicalConstants::ROW,
    Plastic::ROW,
    RateDependent::ROW,
    InelasticHeatFraction::ROW,
    SpecificHeat::ROW,
    UserMaterial::ROW,
    row!("USER DEFINED FIELD", "Field variables of user subroutine VUSDFLD", (once below "MATERIAL"), {
        "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants",
    }, [(list "constant of the fields" (NUMBER) "Eight values per line")]),
    row!("CHARACTERISTIC LENGTH", "Characteristic element length for damage evolution and user subroutines", (once below "MATERIAL"), {
        "DEFINITION" (word(&["GEOMETRIC MEAN", "USER"]).or(0.0)) "GEOMETRIC MEAN: square root of the element area in the r-z plane; USER: subroutine VUCHARLENGTH",
        "COMPONENTS" only ["1"] "the length has one component",
        "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants of DEFINITION=USER",
    }, [(list "constant of the length" (NUMBER) "Eight values per line")]),
    row!("DEPVAR", "State variables of user subroutines", (once below "MATERIAL"), {
        "DELETE" (COUNT) "Number of the state variable that deletes the element",
        "CONVERT" refused "conversion to particles is unsupported",
    }, [(rows ["number of state variables" (INTEGER.from(0.0).to(10_000.0).required())] ["number" read "Number of the named variable", "name" read "Name; frames show the variable as SDV_name", "description" inert "description only"])]),
    CavityExpansion::ROW,
    Conductivity::ROW,
    Orientation::ROW,
    Expansion::ROW,
    row!("SOLID SECTION", "Material of solid elements", (), {
        "ELSET" read "Elements",
        "MATERIAL" read "Material",
        "CONTROLS" read "Section controls",
        "ORIENTATION" read "Directions of fibres of *ANISOTROPIC HYPERELASTIC; other built-in materials are isotropic, and a *USER MATERIAL receives components along r, z and hoop",
        "REF NODE" refused "generalised plane strain is not axisymmetric",
        "SECTION NAME" inert "written by ABAQUS/CAE; has no effect",
    } refused {
        "a section has one material": "COMPOSITE", "LAYUP", "ORDER", "STACK DIRECTION", "SYMMETRIC";
    }, [(lines ["attribute" inert "axisymmetric solids have no thickness"])]),
    ShellSection::ROW,
    CohesiveSection::ROW,
    Erosion::ROW,
    SectionControls::ROW,
];
