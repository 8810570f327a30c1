//! Cards of materials whose strength depends on pressure, porosity or direction: soil, rock, concrete, porous metals, sheet.

use super::card;
use crate::deck::keywords::Keyword;
use crate::deck::value::{NOT_NEGATIVE, NUMBER, POSITIVE, ValueSpec, variant};

/// An angle of friction or dilation in degrees.
const ANGLE: ValueSpec = NOT_NEGATIVE.below(90.0);
/// A share from 0 to 1.
const SHARE: ValueSpec = NOT_NEGATIVE.to(1.0);

card!(DruckerPrager: "DRUCKER PRAGER", "Drucker-Prager plasticity: soil, rock, polymers", (once below "MATERIAL"), {
    form: usize = "SHEAR CRITERION" (variant(&["LINEAR", "HYPERBOLIC", "EXPONENT FORM"]).or(0.0)),
    eccentricity: Option<f64> = "ECCENTRICITY" (NOT_NEGATIVE) "Rounding of the flow potential at its apex, 0.1 by default; no effect with LINEAR",
    "TEST DATA" refused "give the constants of the exponent form",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, row: [f64; 3] = [
    (when "SHEAR CRITERION" = "HYPERBOLIC" lines [
        "friction angle" (ANGLE.above(0.0).required()) "beta, degrees",
        "hydrostatic tension strength" (NOT_NEGATIVE.required()),
        "dilation angle" (ANGLE.or(0.0)) "psi, degrees, at most the friction angle",
        "temperature" inert "the constants do not depend on temperature",
    ]),
    (when "SHEAR CRITERION" = "EXPONENT FORM" lines [
        "a" (POSITIVE.required()) "Factor of q^b; its unit is a stress to the power 1 - b",
        "b" (NUMBER.from(1.0).required()) "Exponent",
        "dilation angle" (ANGLE.or(0.0)) "psi, degrees",
        "temperature" inert "the constants do not depend on temperature",
    ]),
    (lines [
        "friction angle" (ANGLE.above(0.0).required()) "beta, degrees",
        "K" (SHARE.or(1.0)) "Ratio of the flow stresses in triaxial tension and compression, 0.778 to 1; 0 and the default mean 1",
        "dilation angle" (ANGLE.or(0.0)) "psi, degrees, at most the friction angle",
        "temperature" inert "the constants do not depend on temperature",
    ]),
]);

card!(DruckerPragerHardening: "DRUCKER PRAGER HARDENING", "Yield stress of Drucker-Prager plasticity over plastic strain", (once below "MATERIAL"), {
    test: usize = "TYPE" (variant(&["COMPRESSION", "TENSION", "SHEAR"]).or(0.0)) "Test that gives the table: uniaxial compression, uniaxial tension or pure shear",
    "RATE" refused "give one table and *RATE DEPENDENT, TYPE=YIELD RATIO",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, rows: Vec<[f64; 2]> = [(rows [
    "yield stress" (POSITIVE.required()), "plastic strain" (NOT_NEGATIVE.or(0.0).ascending()),
    "temperature" refused "the table does not depend on temperature",
])]);

card!(CapPlasticity: "CAP PLASTICITY", "Drucker-Prager plasticity with a cap: compaction of soil and powder", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, row: [f64; 5] = [(lines [
    "cohesion" (NOT_NEGATIVE.required()) "d, stress",
    "friction angle" (ANGLE.above(0.0).required()) "beta, degrees",
    "cap eccentricity" (NUMBER.from(0.0001).to(1000.0).required()) "R, ratio of the axes of the cap",
    "initial compaction" (NOT_NEGATIVE.or(0.0)) "Volumetric plastic strain at the start",
    "transition radius" (SHARE.or(0.0)) "alpha, of the surface between failure and cap; 0.01 to 0.05 is usual",
    "K" inert "the surface is circular in explicit analyses",
    "temperature" inert "the constants do not depend on temperature",
])]);

card!(CapHardening: "CAP HARDENING", "Hydrostatic yield pressure of the cap over compaction", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, rows: Vec<[f64; 2]> = [(rows [
    "hydrostatic yield pressure" (POSITIVE.required().ascending()),
    "compaction" (NOT_NEGATIVE.or(0.0).ascending()) "Absolute volumetric plastic strain",
    "temperature" refused "the table does not depend on temperature",
])]);

card!(ConcreteDamagedPlasticity: "CONCRETE DAMAGED PLASTICITY", "Damaged plasticity of concrete", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, row: [f64; 4] = [(lines [
    "dilation angle" (ANGLE.above(0.0).required()) "psi, degrees",
    "eccentricity" (NOT_NEGATIVE.or(0.1)) "Rounding of the flow potential at its apex",
    "biaxial strength ratio" (NUMBER.from(1.0).or(1.16)) "Yield stress in equibiaxial over that in uniaxial compression",
    "Kc" (NUMBER.above(0.5).to(1.0).or(2.0 / 3.0)) "Ratio of the second stress invariants on the tensile and compressive meridian",
    "viscosity" inert "it regularises implicit analyses only",
    "temperature" inert "the constants do not depend on temperature",
])]);

card!(ConcreteCompressionHardening: "CONCRETE COMPRESSION HARDENING", "Compressive stress of concrete over inelastic strain", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, rows: Vec<[f64; 3]> = [(rows [
    "compressive stress" (NOT_NEGATIVE.required()),
    "inelastic strain" (NOT_NEGATIVE.or(0.0)) "Strain minus stress over Young's modulus",
    "strain rate" (NOT_NEGATIVE.or(0.0)) "Rate of the inelastic strain; the rows of one rate follow each other",
    "temperature" refused "the table does not depend on temperature",
])]);

card!(ConcreteTensionStiffening: "CONCRETE TENSION STIFFENING", "Tensile stress of concrete after cracking", (once below "MATERIAL"), {
    kind: usize = "TYPE" (variant(&["STRAIN", "DISPLACEMENT", "GFI"]).or(0.0)) "DISPLACEMENT: over the cracking strain times the element length; GFI: linear softening with a fracture energy",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, rows: Vec<[f64; 3]> = [
    (when "TYPE" = "GFI" rows [
        "failure stress" (POSITIVE.required()), "fracture energy" (POSITIVE.required()) "Energy per crack area",
        "strain rate" (NOT_NEGATIVE.or(0.0)) "Rate of the cracking strain",
        "temperature" refused "the table does not depend on temperature",
    ]),
    (when "TYPE" = "DISPLACEMENT" rows [
        "tensile stress" (NOT_NEGATIVE.required()), "cracking displacement" (NOT_NEGATIVE.or(0.0)),
        "strain rate" (NOT_NEGATIVE.or(0.0)) "Rate of the cracking strain",
        "temperature" refused "the table does not depend on temperature",
    ]),
    (rows [
        "tensile stress" (NOT_NEGATIVE.required()),
        "cracking strain" (NOT_NEGATIVE.or(0.0)) "Strain minus stress over Young's modulus",
        "strain rate" (NOT_NEGATIVE.or(0.0)) "Rate of the cracking strain",
        "temperature" refused "the table does not depend on temperature",
    ]),
]);

card!(ConcreteCompressionDamage: "CONCRETE COMPRESSION DAMAGE", "Loss of stiffness of concrete in compression", (once below "MATERIAL"), {
    recovery: f64 = "TENSION RECOVERY" (SHARE.or(0.0)) "Share of the stiffness that returns in tension",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, rows: Vec<[f64; 2]> = [(rows [
    "damage" (SHARE.required()), "inelastic strain" (NOT_NEGATIVE.or(0.0).ascending()),
    "temperature" refused "the table does not depend on temperature",
])]);

card!(ConcreteTensionDamage: "CONCRETE TENSION DAMAGE", "Loss of stiffness of concrete in tension", (once below "MATERIAL"), {
    recovery: f64 = "COMPRESSION RECOVERY" (SHARE.or(1.0)) "Share of the stiffness that returns in compression",
    by_displacement: bool = "TYPE" (variant(&["STRAIN", "DISPLACEMENT"]).or(0.0)) "DISPLACEMENT: over the cracking strain times the element length",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, rows: Vec<[f64; 2]> = [
    (when "TYPE" = "DISPLACEMENT" rows [
        "damage" (SHARE.required()), "cracking displacement" (NOT_NEGATIVE.or(0.0).ascending()),
        "temperature" refused "the table does not depend on temperature",
    ]),
    (rows [
        "damage" (SHARE.required()), "cracking strain" (NOT_NEGATIVE.or(0.0).ascending()),
        "temperature" refused "the table does not depend on temperature",
    ]),
]);

card!(HolmquistJohnsonCook: extension "HOLMQUIST JOHNSON COOK", "Concrete under impact, with the constants of LS-DYNA *MAT_111 after the density", (once below "MATERIAL"), {}, rows: Vec<[f64; 8]> = [(lines
    [
        "G" (POSITIVE.required()) "Shear modulus", "A" (NOT_NEGATIVE.required()) "Cohesive strength over fc",
        "B" (NOT_NEGATIVE.required()) "Pressure factor", "C" (NOT_NEGATIVE.required()) "Rate factor",
        "N" (POSITIVE.required()) "Pressure exponent", "fc" (POSITIVE.required()) "Uniaxial compressive strength",
        "T" (POSITIVE.required()) "Largest hydrostatic tension", "reference rate" (POSITIVE.required()),
    ] [
        "EFMIN" (NOT_NEGATIVE.required()) "Smallest plastic strain to fracture",
        "SMAX" (POSITIVE.required()) "Largest strength over fc", "PC" (POSITIVE.required()) "Pressure at which compaction begins",
        "UC" (POSITIVE.required()) "Compression there", "PL" (POSITIVE.required()) "Pressure at which compaction ends",
        "UL" (POSITIVE.required()) "Compression of the material without pores at pressure zero",
        "D1" (NOT_NEGATIVE.required()), "D2" (NUMBER.required()),
    ] [
        "K1" (POSITIVE.required()), "K2" (NUMBER.required()), "K3" (NUMBER.required()),
        "FS" (NOT_NEGATIVE.required()) "Plastic strain at which the element is deleted; 0 for none",
    ]
)]);

card!(Potential: "POTENTIAL", "Hill's anisotropic yield, below *PLASTIC; 1, 2, 3 are r, z, hoop at the start", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, ratios: [f64; 6] = [(lines [
    "R11" (POSITIVE.or(1.0)) "Yield stress along r over that of *PLASTIC", "R22" (POSITIVE.or(1.0)) "Along z",
    "R33" (POSITIVE.or(1.0)) "Along the hoop", "R12" (POSITIVE.or(1.0)) "Shear in the r-z plane, over that of *PLASTIC by sqrt(3)",
    "R13" inert "there is no shear out of the r-z plane", "R23" inert "there is no shear out of the r-z plane",
    "temperature" inert "the ratios do not depend on temperature",
])]);

card!(PorousMetalPlasticity: "POROUS METAL PLASTICITY", "Gurson's plasticity of metals with voids, in addition to *PLASTIC", (once below "MATERIAL"), {
    relative_density: f64 = "RELATIVE DENSITY" (NUMBER.above(0.0).to(1.0).or(1.0)) "1 minus the initial void volume fraction",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, row: [f64; 3] = [(lines [
    "q1" (POSITIVE.or(1.0)), "q2" (POSITIVE.or(1.0)), "q3" (NOT_NEGATIVE.or(1.0)),
    "temperature" inert "the constants do not depend on temperature",
])]);

card!(VoidNucleation: "VOID NUCLEATION", "Nucleation of voids, below *POROUS METAL PLASTICITY", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, row: [f64; 3] = [(lines [
    "mean strain" (NOT_NEGATIVE.required()) "eN of the normal distribution", "standard deviation" (POSITIVE.required()) "sN",
    "volume fraction" (SHARE.required()) "fN of the nucleated voids",
    "temperature" inert "the constants do not depend on temperature",
])]);

card!(PorousFailureCriteria: "POROUS FAILURE CRITERIA", "Coalescence and failure of a porous metal", (once below "MATERIAL"), {
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, row: [f64; 2] = [(lines [
    "void fraction at failure" (NUMBER.above(0.0).to(1.0).required()) "fF: the element is deleted",
    "critical void fraction" (SHARE.required()) "fc: coalescence begins",
    "temperature" inert "the criteria do not depend on temperature",
])]);

card!(ConcreteFailure: "CONCRETE FAILURE", "Deletion of elements of damaged concrete", (once below "MATERIAL"), {
    by_displacement: bool = "TYPE" (variant(&["STRAIN", "DISPLACEMENT"]).or(0.0)) "DISPLACEMENT: the first limit is the cracking strain times the element length",
    "DEPENDENCIES" refused "only *ELASTIC and *PLASTIC may depend on field variables",
}, limits: [f64; 4] = [(lines [
    "cracking strain or displacement" (POSITIVE) "In tension; an empty field is no limit",
    "inelastic strain" (POSITIVE) "In compression",
    "tensile damage" (POSITIVE.to(1.0)), "compressive damage" (POSITIVE.to(1.0)),
    "temperature" inert "the limits do not depend on temperature",
])]);

/// Keywords of this file, in the order of the manual.
pub static CARDS: &[Keyword] = &[
    DruckerPrager::ROW,
    DruckerPragerHardening::ROW,
    CapPlasticity::ROW,
    CapHardening::ROW,
    ConcreteDamagedPlasticity::ROW,
    ConcreteCompressionHardening::ROW,
    ConcreteTensionStiffening::ROW,
    ConcreteCompressionDamage::ROW,
    ConcreteTensionDamage::ROW,
    ConcreteFailure::ROW,
    HolmquistJohnsonCook::ROW,
    Potential::ROW,
    PorousMetalPlasticity::ROW,
    VoidNucleation::ROW,
    PorousFailureCriteria::ROW,
];
