//! Cards of materials and of the sections that give elements their material.
//! Never here: what a material does.

use super::{card, row};
use crate::deck::keywords::Keyword;
use crate::deck::value::{
    COUNT, INTEGER, NOT_NEGATIVE, NUMBER, POSITIVE, TEMPERATURE, TEXT, YES_NO, ZERO, variant, word,
};

card!(Density: "DENSITY", "Mass per volume", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    "PORE FLUID" refused "pores are not simulated",
}, rows: Vec<[f64; 2]> = [(rows ["density" (POSITIVE.required()), "temperature" (TEMPERATURE)])]);

card!(Elastic: "ELASTIC", "Linear elasticity", (once below "MATERIAL"), {
    shear: bool = "TYPE" (variant(&["ISOTROPIC", "SHEAR"]).or(0.0)) "SHEAR beside an equation of state",
    fields: usize = "DEPENDENCIES" (INTEGER.from(0.0).to(5.0)) "Number of field variables that the moduli depend on",
    "MODULI" inert "without viscoelasticity the moduli are those of all times",
    "COMPRESSION FACTOR" refused "elasticity is the same in tension and compression",
}, [
    (when "TYPE" = "SHEAR" lines ["shear modulus" (POSITIVE.required()), "temperature" inert "one modulus holds at every temperature"]),
    (when "DEPENDENCIES" = "" rows [
        "Young's modulus" (POSITIVE.required()),
        "Poisson's ratio" (NUMBER.above(-1.0).below(0.5).or(0.0)) "0.5 has no stable increment: give 0.49 or less",
        "temperature" (NUMBER),
        "field variable", "field variable", "field variable", "field variable", "field variable",
    ]),
    (rows ["Young's modulus" (POSITIVE.required()),
        "Poisson's ratio" (NUMBER.above(-1.0).below(0.5).or(0.0)) "0.5 has no stable increment: give 0.49 or less",
        "temperature" (TEMPERATURE),
    ]),
]);

card!(Eos: "EOS", "Equation of state", (once below "MATERIAL"), {
    kind: usize = "TYPE" (variant(&["IDEAL GAS", "USUP", "TABULAR", "JWL"]).required()),
    "DETONATION ENERGY" refused "explosives that ignite and grow are not simulated",
    "PROPERTIES" refused "equations of state of the user are not called",
}, [
    (when "TYPE" = "IDEAL GAS" lines ["gas constant" (POSITIVE.required()), "ambient pressure" (NOT_NEGATIVE.or(0.0))]),
    (when "TYPE" = "TABULAR" rows ["f1" (ZERO), "f2" (ZERO), "volumetric strain" (ZERO) "ln(rho0/rho); descends"]),
    (when "TYPE" = "JWL" lines [
        "detonation wave speed" (POSITIVE.required()), "A" (POSITIVE.required()), "B" (NOT_NEGATIVE.required()),
        "omega" (POSITIVE.required()), "R1" (POSITIVE.required()), "R2" (POSITIVE.required()),
        "detonation energy" (NOT_NEGATIVE.required()) "Energy a mass of the explosive",
        "pre-detonation bulk modulus" (NOT_NEGATIVE.or(0.0)),
    ]),
    (lines ["c0" (POSITIVE.required()), "s" (NOT_NEGATIVE.or(0.0)), "Gamma0" (NOT_NEGATIVE.or(0.0))]),
]);

card!(DetonationPoint: "DETONATION POINT", "Where the detonation of an explosive begins", (once below "MATERIAL"), {}, points: Vec<[f64; 4]> = [
    (rows [
        "r" (ZERO), "z" (ZERO), "third coordinate" inert "a point of the plane (r, z) is a ring",
        "delay" (ZERO) "Total time at which the point is lit",
    ]),
]);

card!(Hyperelastic: "HYPERELASTIC", "Rubber elasticity", (once below "MATERIAL"), {
    "NEO HOOKE" read "C10 and D1",
    "MODULI" inert "without viscoelasticity the moduli are those of all times",
    "MOONEY-RIVLIN" read "C10, C01 and D1",
    "YEOH" read "C10, C20, C30, D1, D2, D3",
    "OGDEN" read "mu1, alpha1, mu2, ... and then D1, ..., N of each",
    "POLYNOMIAL" read "The default: C10, C01, C20, C11, C02, ... and then D1, ... up to the order N",
    "REDUCED POLYNOMIAL" read "C10, C20, ... and then D1, ... up to the order N",
    order: Option<usize> = "N" (INTEGER.from(1.0).to(6.0)) "Order of OGDEN, POLYNOMIAL or REDUCED POLYNOMIAL (1)",
    "POISSON" refused "give D1",
    "TEST DATA INPUT" refused "constants are not fitted to tests: fit them elsewhere and give them on the data lines",
    "BETA" refused "of VAN DER WAALS",
    "PROPERTIES" refused "of energies of the user",
} refused {
    "POLYNOMIAL and OGDEN are supported, and what they hold": "ARRUDA-BOYCE", "MARLOW", "VAN DER WAALS", "USER";
}, [
    (when "NEO HOOKE" = "" lines ["C10" (NUMBER.required()), "D1" (NOT_NEGATIVE.or(0.0)), "temperature" inert "one row holds at every temperature"]),
    (list "constant" (NUMBER) "Eight a line; with D1 = 0 the bulk modulus is 20 times the shear modulus"),
]);

card!(CrushableFoam: "CRUSHABLE FOAM", "Plasticity of foam that is crushed", (once below "MATERIAL"), {
    isotropic: bool = "HARDENING" (word(&["VOLUMETRIC", "ISOTROPIC"]).or(0.0)),
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
}, ratios: [f64; 2] = [
    (when "HARDENING" = "ISOTROPIC" lines [
        "compression yield stress ratio" (NUMBER.from(0.0).below(3.0).required()),
        "plastic Poisson's ratio" (NUMBER.above(-1.0).below(0.5).or(0.0)),
        "temperature" inert "one row holds at every temperature",
    ]),
    (lines [
        "compression yield stress ratio" (POSITIVE.below(3.0).required()),
        "hydrostatic yield stress ratio" (NOT_NEGATIVE.or(1.0)),
        "temperature" inert "one row holds at every temperature",
    ]),
]);

card!(CrushableFoamHardening: "CRUSHABLE FOAM HARDENING", "Yield stress of foam in uniaxial compression", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
}, rows: Vec<[f64; 2]> = [
    (rows ["yield stress in uniaxial compression" (POSITIVE.required()),
    "plastic strain in compression" (NOT_NEGATIVE.or(0.0).ascending()), "temperature" refused "one table holds at every temperature"]),
]);

card!(Damping: "DAMPING", "Rayleigh damping of a material", (once below "MATERIAL"), {
    alpha: Option<f64> = "ALPHA" (NOT_NEGATIVE) "Mass proportional damping, 1/time",
    "BETA" only ["0"] "stiffness proportional damping is not done; ALPHA and *BULK VISCOSITY are",
    "COMPOSITE" inert "of modal procedures",
    "STRUCTURAL" inert "of steady-state procedures",
}, []);

card!(ShearFailure: "SHEAR FAILURE", "Failure by plastic strain", (once below "MATERIAL"), {
    johnson_cook: bool = "TYPE" (variant(&["TABULAR", "JOHNSON COOK"]).or(0.0)),
    "ELEMENT DELETION" only ["YES"] "elements that fail are deleted",
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
}, [
    (when "TYPE" = "JOHNSON COOK" lines ["d1" (ZERO), "d2" (ZERO), "d3" (ZERO), "d4" (ZERO), "d5" (ZERO)]),
    (rows [
        "plastic strain at failure" (POSITIVE.required()), "rate of the plastic strain" (ZERO),
        "pressure over von Mises stress" (ZERO), "temperature" (ZERO),
        "field variable" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    ]),
]);

card!(TensileFailure: "TENSILE FAILURE", "Cutoff of tension, spall", (once below "MATERIAL"), {
    deletes: bool = "ELEMENT DELETION" (YES_NO.or(1.0)) "NO keeps the mean stress at the cutoff",
    "PRESSURE" only ["DUCTILE"] "brittle failure without deletion is not simulated",
    "SHEAR" only ["DUCTILE"] "brittle failure without deletion is not simulated",
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
}, cutoff: [f64; 1] = [(lines ["mean stress, tension" (POSITIVE.required()), "temperature" inert "one cutoff holds at every temperature"])]);

card!(DamageInitiation: "DAMAGE INITIATION", "When damage begins", (below "MATERIAL"), {
    ductile: bool = "CRITERION" (variant(&["JOHNSON COOK", "DUCTILE"]).required()),
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    "ACCUMULATION POWER" refused "the sum is that of the strains over the strain at failure",
    "ALPHA" refused "of HASHIN",
    "KS" refused "of SHEAR",
    "LODE DEPENDENT" refused "the strain at failure depends on the triaxiality alone",
    "INSTABILITY" refused "of FLD",
} refused {
    "of MSFLD": "NUMBER IMPERFECTIONS", "OMEGA", "DEFINITION", "FEQ", "FNN", "FNT", "FREQUENCY", "PEINC";
    "of enriched elements": "POSITION", "NORMAL DIRECTION", "TOLERANCE";
    "of criteria of the user": "PROPERTIES", "FAILURE MECHANISMS";
}, [
    (when "CRITERION" = "JOHNSON COOK" lines [
        "d1" (ZERO), "d2" (ZERO), "d3" (ZERO), "d4" (ZERO), "d5" (ZERO), "melting temperature" (ZERO),
        "transition temperature" (ZERO), "reference rate" (ZERO),
    ]),
    (rows [
        "plastic strain" (POSITIVE.required()), "triaxiality" (ZERO), "rate of the plastic strain" (ZERO),
        "temperature" (ZERO),
        "field variable" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    ]),
]);

card!(DamageEvolution: "DAMAGE EVOLUTION", "How damage grows", (below "MATERIAL"), {
    energy: bool = "TYPE" (variant(&["DISPLACEMENT", "ENERGY"]).required()),
    "SOFTENING" only ["LINEAR"] "damage grows linearly",
    "DEGRADATION" only ["MAXIMUM"] "the largest damage counts",
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    "POWER" refused "of mixed modes",
    "FAILURE INDEX" refused "of criteria of the user",
} refused {
    "of cohesive elements": "MIXED MODE BEHAVIOR", "MODE MIX RATIO";
}, value: [f64; 1] = [(lines ["displacement or energy at failure" (NOT_NEGATIVE.required()), "temperature" inert "one value holds at every temperature"])]);

card!(PhysicalConstants: "PHYSICAL CONSTANTS", "Absolute zero and other constants", (once), {
    absolute_zero: Option<f64> = "ABSOLUTE ZERO" (NUMBER) "Absolute zero on the scale of temperature that the deck uses",
    "STEFAN BOLTZMANN" inert "nothing here radiates",
    "UNIVERSAL GAS CONSTANT" inert "*EOS gives the constant of its gas",
}, []);

card!(Plastic: "PLASTIC", "Metal plasticity", (once below "MATERIAL"), {
    hardening: usize = "HARDENING" (variant(&["ISOTROPIC", "KINEMATIC", "JOHNSON COOK", "USER"]).or(0.0)) "KINEMATIC takes two rows, at each temperature; USER is subroutine vuhard",
    "RATE" refused "give *RATE DEPENDENT",
    fields: usize = "DEPENDENCIES" (INTEGER.from(0.0).to(5.0)) "Number of field variables that a table depends on",
    "DATA TYPE" refused "of cyclic hardening",
    extrapolates: Option<bool> = "EXTRAPOLATION" (word(&["CONSTANT", "LINEAR"])) "Beyond the last plastic strain of a table: CONSTANT without it",
    "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants of HARDENING=USER",
    "SCALESTRESS" refused "give the yield stresses scaled",
    "USER" refused "give HARDENING=USER",
} refused {
    "of combined hardening": "NUMBER BACKSTRESSES", "STATIC RECOVERY";
}, [
    (when "HARDENING" = "USER" list "constant of the hardening" read "Eight a line"),
    (when "HARDENING" = "JOHNSON COOK" lines ["A" (ZERO), "B" (ZERO), "n" (ZERO), "m" (ZERO), "melting temperature" (ZERO), "transition temperature" (ZERO)]),
    (when "DEPENDENCIES" = "" rows [
        "yield stress" (ZERO), "plastic strain" (ZERO), "temperature" (NUMBER),
        "field variable", "field variable", "field variable", "field variable", "field variable",
    ]),
    (rows ["yield stress" (ZERO), "plastic strain" (ZERO), "temperature" (NUMBER)]),
]);

card!(RateDependent: "RATE DEPENDENT", "Rate dependence of yield", (once below "MATERIAL"), {
    kind: usize = "TYPE" (variant(&["POWER LAW", "YIELD RATIO", "JOHNSON COOK"]).or(0.0)),
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
}, [
    (when "TYPE" = "JOHNSON COOK" lines ["C" (ZERO), "reference strain rate" (NUMBER.or(1.0))]),
    (when "TYPE" = "YIELD RATIO" rows ["yield ratio" (ZERO), "strain rate" (NUMBER.or(1.0)), "temperature" (NUMBER)]),
    (rows ["D" (POSITIVE.required()), "n" (POSITIVE.or(1.0)), "temperature" (TEMPERATURE)]),
]);

card!(InelasticHeatFraction: "INELASTIC HEAT FRACTION", "Fraction of plastic work turned into heat", (once below "MATERIAL"), {}, fraction: [f64; 1] = [
    (lines ["fraction" (NUMBER.or(0.9))]),
]);

card!(SpecificHeat: "SPECIFIC HEAT", "Heat per mass and temperature", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
} refused {
    "of gases in fluid cavities": "CONSTANT PRESSURE", "CONSTANTVOLUME";
}, rows: Vec<[f64; 2]> = [(rows ["specific heat" (POSITIVE.required()), "temperature" (TEMPERATURE)])]);

card!(Conductivity: "CONDUCTIVITY", "Heat conduction, in steps that solve for temperatures", (once below "MATERIAL"), {
    "TYPE" only ["ISO"] "nothing here is anisotropic",
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    "PORE FLUID" refused "pores are not simulated",
}, rows: Vec<[f64; 2]> = [(rows ["conductivity" (POSITIVE.required()), "temperature" (TEMPERATURE)])]);

card!(Expansion: "EXPANSION", "Thermal expansion, where temperatures change", (once below "MATERIAL"), {
    "TYPE" only ["ISO"] "nothing here is anisotropic",
    zero: f64 = "ZERO" (ZERO) "Reference temperature of the coefficients",
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    "DEFINITION" only ["SECANT"] "coefficients are those from the reference temperature",
    "PORE FLUID" refused "pores are not simulated",
    "FIELD" refused "fields do not expand",
} refused {
    "expansion of the user is not called": "USER", "PROPERTIES";
}, rows: Vec<[f64; 2]> = [(rows ["coefficient" (ZERO), "temperature" (TEMPERATURE)])]);

card!(UserMaterial: "USER MATERIAL", "Material of a user routine", (once below "MATERIAL"), {
    count: usize = "CONSTANTS" (INTEGER.from(0.0).required()) "Number of constants",
    "TYPE" only ["MECHANICAL"] "temperatures come from inelastic work alone",
    "UNSYMM" inert "of implicit analyses",
    "EFFMOD" refused "moduli come from the call at time zero",
    "HYBRID FORMULATION" refused "of implicit analyses",
}, [(list "constant" (NUMBER) "Eight a line")]);

card!(CavityExpansion: extension "CAVITY EXPANSION", "Resistance of a target material: Y (A + B x + C x^2), x = v_n sqrt(rho/Y)", (once below "MATERIAL"), {
    yield_stress: Option<f64> = "YIELD" (POSITIVE) "Y, the strength that the law is scaled by",
    derives: bool = "DERIVE" read "Y, A, B and C from the material's own *ELASTIC, *DENSITY and *PLASTIC: expansion of a spherical cavity, fitted over a range of velocities",
    linear: bool = "TERMS" (word(&["2", "3"]).or(1.0)) "Of DERIVE: 3 (default), or 2 for a law with B = 0",
    pinned: bool = "STATIC" read "Of DERIVE: A is the pressure at rest instead of being fitted",
    weight: usize = "WEIGHT" (word(&["EVEN", "RELATIVE", "VELOCITY"]).or(0.0)) "Of DERIVE: EVEN (default: differences of pressures), RELATIVE (relative differences) or VELOCITY (by the velocity)",
    radius: Option<f64> = "RADIUS" (POSITIVE) "Of DERIVE: radius of the cavity, with which *RATE DEPENDENT counts",
    tension: Option<f64> = "TENSION" (POSITIVE) "Of DERIVE: tension beyond which the target cracks along rays",
}, values: [f64; 3] = [
    (when "DERIVE" = "" lines ["lowest velocity" (NUMBER.required()), "highest velocity" (NUMBER.required()), "number of velocities" (NUMBER.or(41.0))]),
    (lines ["A" (NOT_NEGATIVE.required()), "B" (NOT_NEGATIVE.required()), "C" (NOT_NEGATIVE.required())]),
]);

card!(ShellSection: "SHELL SECTION", "Gives shells their thickness and material; an element has one section", (), {
    "ELSET" read "Elements",
    "MATERIAL" read "Material",
    per_area: f64 = "DENSITY" (NOT_NEGATIVE.or(0.0)) "Mass per area beside that of the material",
    "POISSON" read "How shells thin: MATERIAL (default), ELASTIC, or a ratio; 0 keeps the thickness",
    "SECTION INTEGRATION" only ["SIMPSON"] "points through the thickness are those of Simpson's rule",
    "OFFSET" only ["0", "0."] "nodes of shells lie on the middle surface",
    "CONTROLS" inert "shells of one point have no hourglass modes",
    "ORIENTATION" refused "nothing here is anisotropic",
    "TEMPERATURE" inert "temperatures of shells start uniform over the thickness",
    "SECTION NAME" inert "written by CAE; no meaning",
} refused {
    "a section has one material": "COMPOSITE", "LAYUP", "SYMMETRIC";
    "give the thickness of the section on its data line": "NODAL THICKNESS", "SHELL THICKNESS";
    "of continuum shells": "STACK DIRECTION", "THICKNESS MODULUS";
}, thickness_points: [f64; 2] = [(lines ["thickness" (POSITIVE.required()), "points" (INTEGER.from(3.0).to(1001.0).or(5.0)) "Of Simpson's rule through the thickness; odd"])]);

card!(Erosion: extension "EROSION", "Deletes elements that come to one of its limits, whatever their material", (), {
    "ELSET" read "Elements; all that deform if absent",
    distortion: Option<f64> = "DISTORTION" (NUMBER.from(0.0).below(1.0).bare(0.01)) "Least sine of the angles at the corners over that of a square, of a triangle over the equilateral one (scaled Jacobian); 0 where the element is folded, 0.01 without a value",
    plastic: Option<f64> = "PLASTIC STRAIN" (POSITIVE) "Equivalent plastic strain; of shells in the middle",
    strain: Option<f64> = "PRINCIPAL STRAIN" (POSITIVE) "Largest principal logarithmic strain, in the plane or along the hoop",
    increment: Option<f64> = "INCREMENT" (POSITIVE) "Stable increment of the element, time",
}, []);

card!(SectionControls: "SECTION CONTROLS", "Hourglass, distortion and viscosity controls of elements", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name of the controls",
    hourglass: Option<usize> = "HOURGLASS" (variant(&["RELAX STIFFNESS", "STIFFNESS", "VISCOUS", "COMBINED", "ENHANCED"])) "RELAX STIFFNESS without a word: a spring whose force returns with the stress where the material flows; VISCOUS without shear modulus; ENHANCED of *HYPERELASTIC: assumed strains by direction",
    distortion: bool = "DISTORTION CONTROL" (YES_NO.or(0.0).bare(1.0)),
    length_ratio: Option<f64> = "LENGTH RATIO" (POSITIVE.below(1.0)) "Of distortion control (0.1): distance from the line between its neighbours, over that at the start, below which a corner is pushed",
    deletes: bool = "ELEMENT DELETION" (YES_NO.or(1.0)) "With NO what *DAMAGE EVOLUTION ruins stays with 1 less MAX DEGRADATION of its stiffness. Refused with *SHEAR FAILURE and *TENSILE FAILURE, which delete",
    most_damage: Option<f64> = "MAX DEGRADATION" (POSITIVE.to(1.0)) "Damage at which an element is deleted (1), or beyond which it does not go where it stays (0.99)",
    "SECOND ORDER ACCURACY" only ["NO"] "rotations are followed to first order",
    "KINEMATIC SPLIT" only ["AVERAGE STRAIN"] "strains are means over the element",
    "DRILL STIFFNESS" inert "of shells",
    "RAMP INITIAL STRESS" inert "of membranes",
    "VISCOSITY" refused "damage is not regularised",
    weight: f64 = "WEIGHT FACTOR" (NUMBER.from(0.0).to(1.0).or(0.5)) "Of hourglass stiffness and viscosity",
    by_area: bool = "WEIGHTING" extension (word(&["VOLUME", "AREA"]).or(0.0)) "AREA: the equation of motion integrated over the plane section",
    averaged: Option<bool> = "AVERAGED PRESSURE" extension (YES_NO) "YES or NO, of triangles of linear elasticity or rubber: whether their dilation is averaged over nodes; YES without it where they flow, are rubber or have a Poisson's ratio above 0.45",
    subzonal: Option<bool> = "SUBZONAL" extension (YES_NO) "YES (default where *EOS has no shear modulus) or NO: quarters of elements that are denser than the whole push back",
    "PERTURBATION" refused "of implicit analyses",
} refused {
    "elements do not turn into particles": "CONVERSION CRITERION", "CONVERSION", "KERNEL", "PARTICLE";
    "of cohesive elements": "VISCOUS", "INITIAL GAP OPENING";
}, factor: [f64; 1] = [(lines [
    "hourglass factor" (NOT_NEGATIVE.or(1.0)),
    "rotational factor" inert "of shells",
    "out-of-plane factor" inert "of shells",
    "factor on linear bulk viscosity" only ["1"] "give *BULK VISCOSITY in the step",
    "factor on quadratic bulk viscosity" only ["1"] "give *BULK VISCOSITY in the step",
])]);

/// The rows.
pub const CARDS: &[Keyword] = &[
    row!("MATERIAL", "Begins a material", (unique "NAME"), {
        "NAME" read "Name of the material",
        "RTOL" inert "tables are used as they are given: none is regularised",
        "SRATE FACTOR" only ["1"] "strain rates are not smoothed",
        "STRAIN RATE REGULARIZATION" inert "tables are used as they are given: none is regularised",
        "INTERNAL" inert "written by CAE; no meaning",
    }, []),
    Density::ROW,
    Elastic::ROW,
    Eos::ROW,
    DetonationPoint::ROW,
    Hyperelastic::ROW,
    CrushableFoam::ROW,
    CrushableFoamHardening::ROW,
    Damping::ROW,
    ShearFailure::ROW,
    TensileFailure::ROW,
    DamageInitiation::ROW,
    DamageEvolution::ROW,
    PhysicalConstants::ROW,
    Plastic::ROW,
    RateDependent::ROW,
    InelasticHeatFraction::ROW,
    SpecificHeat::ROW,
    UserMaterial::ROW,
    row!("USER DEFINED FIELD", "Fields of a user routine (subroutine vusdfld)", (once below "MATERIAL"), {
        "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants",
    }, [(list "constant of the fields" (NUMBER) "Eight a line")]),
    row!("CHARACTERISTIC LENGTH", "Length of an element that damage evolution and routines of the user take", (once below "MATERIAL"), {
        "DEFINITION" (word(&["GEOMETRIC MEAN", "USER"]).or(0.0)) "The root of the element's area in the (r, z) plane, or subroutine vucharlength",
        "COMPONENTS" only ["1"] "a length has one component",
        "PROPERTIES" (INTEGER.from(0.0).or(0.0)) "Number of constants of DEFINITION=USER",
    }, [(list "constant of the length" (NUMBER) "Eight a line")]),
    row!("DEPVAR", "Number of state variables that the user's routines keep at a point", (once below "MATERIAL"), {
        "DELETE" (COUNT) "State variable that deletes the element",
        "CONVERT" refused "elements do not turn into particles",
    }, [(rows ["number of state variables" (INTEGER.from(0.0).to(10_000.0).required())] ["number" read "Of the variable that is named", "name" read "Frames show the variable as SDV_name", "description" inert "for people"])]),
    CavityExpansion::ROW,
    Conductivity::ROW,
    row!(inert "nothing here is anisotropic", "ORIENTATION", "A local coordinate system"),
    Expansion::ROW,
    row!("SOLID SECTION", "Gives solid elements their material; an element has one section", (), {
        "ELSET" read "Elements",
        "MATERIAL" read "Material",
        "CONTROLS" read "Section controls",
        "ORIENTATION" inert "the laws here are the same in all directions; a *USER MATERIAL is given r, z and hoop",
        "REF NODE" refused "generalised plane strain is not axisymmetric",
        "SECTION NAME" inert "written by CAE; no meaning",
    } refused {
        "a section has one material": "COMPOSITE", "LAYUP", "ORDER", "STACK DIRECTION", "SYMMETRIC";
    }, [(lines ["attribute" inert "axisymmetric solids have no thickness"])]),
    ShellSection::ROW,
    Erosion::ROW,
    SectionControls::ROW,
];
