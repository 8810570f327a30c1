//! Cards of materials and of the sections that give elements their material.
//! Never here: what a material does.

use super::row;
use crate::deck::keywords::Keyword;

/// The rows.
pub const CARDS: &[Keyword] = &[
    row!("MATERIAL", "Begins a material", (unique "NAME"), {
        "NAME" read "Name of the material",
        "RTOL" inert "tables are used as they are given: none is regularised",
        "SRATE FACTOR" only ["1"] "strain rates are not smoothed",
        "STRAIN RATE REGULARIZATION" inert "tables are used as they are given: none is regularised",
        "INTERNAL" inert "written by CAE; no meaning",
    }, []),
    row!("DENSITY", "Mass per volume", (once below "MATERIAL"), {
        "DEPENDENCIES" refused "nothing here depends on field variables",
        "PORE FLUID" refused "pores are not simulated",
    }, [(rows ["density", "temperature"])]),
    row!("ELASTIC", "Linear elasticity", (once below "MATERIAL"), {
        "TYPE" read "ISOTROPIC (default), or SHEAR beside an equation of state",
        "DEPENDENCIES" refused "nothing here depends on field variables",
        "MODULI" inert "without viscoelasticity the moduli are those of all times",
        "COMPRESSION FACTOR" refused "elasticity is the same in tension and compression",
    }, [
        (when "TYPE" = "SHEAR" lines ["shear modulus", "temperature" inert "one modulus holds at every temperature"]),
        (lines ["Young's modulus", "Poisson's ratio", "temperature" inert "one modulus holds at every temperature"]),
    ]),
    row!("EOS", "Equation of state", (once below "MATERIAL"), {
        "TYPE" read "IDEAL GAS, USUP, TABULAR or JWL",
        "DETONATION ENERGY" refused "explosives that ignite and grow are not simulated",
        "PROPERTIES" refused "equations of state of the user are not called",
    }, [
        (when "TYPE" = "IDEAL GAS" lines ["gas constant", "ambient pressure"]),
        (when "TYPE" = "TABULAR" rows ["f1", "f2", "volumetric strain" read "ln(rho0/rho); descends"]),
        (when "TYPE" = "JWL" lines [
            "detonation wave speed", "A", "B", "omega", "R1", "R2",
            "detonation energy" read "Energy a mass of the explosive",
            "pre-detonation bulk modulus",
        ]),
        (lines ["c0", "s", "Gamma0"]),
    ]),
    row!("DETONATION POINT", "Where the detonation of an explosive begins", (once below "MATERIAL"), {}, [
        (rows [
            "r", "z", "third coordinate" inert "a point of the plane (r, z) is a ring",
            "delay" read "Total time at which the point is lit",
        ]),
    ]),
    row!("HYPERELASTIC", "Rubber elasticity", (once below "MATERIAL"), {
        "NEO HOOKE" read "C10 and D1",
        "MODULI" inert "without viscoelasticity the moduli are those of all times",
        "MOONEY-RIVLIN" read "C10, C01 and D1",
        "YEOH" read "C10, C20, C30, D1, D2, D3",
        "OGDEN" read "mu1, alpha1, mu2, ... and then D1, ..., N of each",
        "POLYNOMIAL" read "The default: C10, C01, C20, C11, C02, ... and then D1, ... up to the order N",
        "REDUCED POLYNOMIAL" read "C10, C20, ... and then D1, ... up to the order N",
        "N" read "Order of OGDEN, POLYNOMIAL or REDUCED POLYNOMIAL (1), at most 6",
        "ARRUDA-BOYCE" refused "POLYNOMIAL and OGDEN are supported, and what they hold",
        "MARLOW" refused "POLYNOMIAL and OGDEN are supported, and what they hold",
        "VAN DER WAALS" refused "POLYNOMIAL and OGDEN are supported, and what they hold",
        "USER" refused "POLYNOMIAL and OGDEN are supported, and what they hold",
        "POISSON" refused "give D1",
        "TEST DATA INPUT" refused "constants are not fitted to tests: fit them elsewhere and give them on the data lines",
        "BETA" refused "of VAN DER WAALS",
        "PROPERTIES" refused "of energies of the user",
    }, [
        (when "NEO HOOKE" = "" lines ["C10", "D1", "temperature" inert "one row holds at every temperature"]),
        (list "constant" read "Eight a line; with D1 = 0 the bulk modulus is 20 times the shear modulus"),
    ]),
    row!("CRUSHABLE FOAM", "Plasticity of foam that is crushed", (once below "MATERIAL"), {
        "HARDENING" read "VOLUMETRIC (default) or ISOTROPIC",
        "DEPENDENCIES" refused "nothing here depends on field variables",
    }, [
        (when "HARDENING" = "ISOTROPIC" lines [
            "compression yield stress ratio", "plastic Poisson's ratio",
            "temperature" inert "one row holds at every temperature",
        ]),
        (lines [
            "compression yield stress ratio", "hydrostatic yield stress ratio",
            "temperature" inert "one row holds at every temperature",
        ]),
    ]),
    row!("CRUSHABLE FOAM HARDENING", "Yield stress of foam in uniaxial compression", (once below "MATERIAL"), {
        "DEPENDENCIES" refused "nothing here depends on field variables",
    }, [
        (rows ["yield stress in uniaxial compression", "plastic strain in compression", "temperature" refused "one table holds at every temperature"]),
    ]),
    row!("DAMPING", "Rayleigh damping of a material", (once below "MATERIAL"), {
        "ALPHA" read "Mass proportional damping, 1/time",
        "BETA" only ["0"] "stiffness proportional damping is not done; ALPHA and *BULK VISCOSITY are",
        "COMPOSITE" inert "of modal procedures",
        "STRUCTURAL" inert "of steady-state procedures",
    }, []),
    row!("SHEAR FAILURE", "Failure by plastic strain", (once below "MATERIAL"), {
        "TYPE" read "TABULAR (default) or JOHNSON COOK",
        "ELEMENT DELETION" only ["YES"] "elements that fail are deleted",
        "DEPENDENCIES" refused "nothing here depends on field variables",
    }, [
        (when "TYPE" = "JOHNSON COOK" lines ["d1", "d2", "d3", "d4", "d5"]),
        (rows [
            "plastic strain at failure", "rate of the plastic strain", "pressure over von Mises stress", "temperature",
            "field variable" refused "nothing here depends on field variables",
        ]),
    ]),
    row!("TENSILE FAILURE", "Cutoff of tension, spall", (once below "MATERIAL"), {
        "ELEMENT DELETION" read "YES (default); NO keeps the mean stress at the cutoff",
        "PRESSURE" only ["DUCTILE"] "brittle failure without deletion is not simulated",
        "SHEAR" only ["DUCTILE"] "brittle failure without deletion is not simulated",
        "DEPENDENCIES" refused "nothing here depends on field variables",
    }, [(lines ["mean stress, tension", "temperature" inert "one cutoff holds at every temperature"])]),
    row!("DAMAGE INITIATION", "When damage begins", (below "MATERIAL"), {
        "CRITERION" read "JOHNSON COOK or DUCTILE",
        "DEPENDENCIES" refused "nothing here depends on field variables",
        "NUMBER IMPERFECTIONS" refused "of MSFLD",
        "OMEGA" refused "of MSFLD",
        "ACCUMULATION POWER" refused "the sum is that of the strains over the strain at failure",
        "ALPHA" refused "of HASHIN",
        "DEFINITION" refused "of MSFLD",
        "FEQ" refused "of MSFLD",
        "FNN" refused "of MSFLD",
        "FNT" refused "of MSFLD",
        "FREQUENCY" refused "of MSFLD",
        "KS" refused "of SHEAR",
        "LODE DEPENDENT" refused "the strain at failure depends on the triaxiality alone",
        "PEINC" refused "of MSFLD",
        "POSITION" refused "of enriched elements",
        "PROPERTIES" refused "of criteria of the user",
        "FAILURE MECHANISMS" refused "of criteria of the user",
        "NORMAL DIRECTION" refused "of enriched elements",
        "TOLERANCE" refused "of enriched elements",
        "INSTABILITY" refused "of FLD",
    }, [
        (when "CRITERION" = "JOHNSON COOK" lines [
            "d1", "d2", "d3", "d4", "d5", "melting temperature", "transition temperature", "reference rate",
        ]),
        (rows [
            "plastic strain", "triaxiality", "rate of the plastic strain", "temperature",
            "field variable" refused "nothing here depends on field variables",
        ]),
    ]),
    row!("DAMAGE EVOLUTION", "How damage grows", (below "MATERIAL"), {
        "TYPE" read "DISPLACEMENT or ENERGY",
        "SOFTENING" only ["LINEAR"] "damage grows linearly",
        "DEGRADATION" only ["MAXIMUM"] "the largest damage counts",
        "DEPENDENCIES" refused "nothing here depends on field variables",
        "MIXED MODE BEHAVIOR" refused "of cohesive elements",
        "MODE MIX RATIO" refused "of cohesive elements",
        "POWER" refused "of mixed modes",
        "FAILURE INDEX" refused "of criteria of the user",
    }, [(lines ["displacement or energy at failure", "temperature" inert "one value holds at every temperature"])]),
    row!("PHYSICAL CONSTANTS", "Absolute zero and other constants", (once), {
        "ABSOLUTE ZERO" read "Absolute zero on the scale of temperature that the deck uses",
        "STEFAN BOLTZMANN" inert "nothing here radiates",
        "UNIVERSAL GAS CONSTANT" inert "*EOS gives the constant of its gas",
    }, []),
    row!("PLASTIC", "Metal plasticity", (once below "MATERIAL"), {
        "HARDENING" read "ISOTROPIC (default), KINEMATIC (two rows, at each temperature) or JOHNSON COOK",
        "RATE" refused "give *RATE DEPENDENT",
        "DEPENDENCIES" refused "nothing here depends on field variables",
        "DATA TYPE" refused "of cyclic hardening",
        "EXTRAPOLATION" read "Beyond the last plastic strain of a table: CONSTANT (default) or LINEAR",
        "NUMBER BACKSTRESSES" refused "of combined hardening",
        "PROPERTIES" refused "hardening of the user is not called",
        "SCALESTRESS" refused "give the yield stresses scaled",
        "STATIC RECOVERY" refused "of combined hardening",
        "USER" refused "hardening of the user is not called",
    }, [
        (when "HARDENING" = "JOHNSON COOK" lines ["A", "B", "n", "m", "melting temperature", "transition temperature"]),
        (rows ["yield stress", "plastic strain", "temperature"]),
    ]),
    row!("RATE DEPENDENT", "Rate dependence of yield", (once below "MATERIAL"), {
        "TYPE" read "POWER LAW (default), YIELD RATIO or JOHNSON COOK",
        "DEPENDENCIES" refused "nothing here depends on field variables",
    }, [
        (when "TYPE" = "JOHNSON COOK" lines ["C", "reference strain rate"]),
        (when "TYPE" = "YIELD RATIO" rows ["yield ratio", "strain rate", "temperature"]),
        (rows ["D", "n", "temperature"]),
    ]),
    row!("INELASTIC HEAT FRACTION", "Fraction of plastic work turned into heat", (once below "MATERIAL"), {}, [
        (lines ["fraction" read "0.9 without it"]),
    ]),
    row!("SPECIFIC HEAT", "Heat per mass and temperature", (once below "MATERIAL"), {
        "CONSTANT PRESSURE" refused "of gases in fluid cavities",
        "CONSTANTVOLUME" refused "of gases in fluid cavities",
        "DEPENDENCIES" refused "nothing here depends on field variables",
    }, [(rows ["specific heat", "temperature"])]),
    row!("USER MATERIAL", "Material of a user routine", (once below "MATERIAL"), {
        "CONSTANTS" read "Number of constants",
        "TYPE" only ["MECHANICAL"] "temperatures come from plastic work alone",
        "UNSYMM" inert "of implicit analyses",
        "EFFMOD" refused "moduli come from the call at time zero",
        "HYBRID FORMULATION" refused "of implicit analyses",
    }, [(list "constant" read "Eight a line")]),
    row!("DEPVAR", "Number of state variables of a user material", (once below "MATERIAL"), {
        "DELETE" read "State variable that deletes the element",
        "CONVERT" refused "elements do not turn into particles",
    }, [(rows ["number of state variables"] ["number" inert "for people", "name" inert "for people", "description" inert "for people"])]),
    row!(extension "CAVITY EXPANSION", "Resistance of a target material: Y (A + B x + C x^2), x = v_n sqrt(rho/Y)", (once below "MATERIAL"), {
        "YIELD" read "Y, the strength that the law is scaled by",
    }, [(lines ["A", "B", "C"])]),
    row!(inert "nothing here conducts heat", "CONDUCTIVITY", "Heat conduction"),
    row!(inert "nothing here is anisotropic", "ORIENTATION", "A local coordinate system"),
    row!("EXPANSION", "Thermal expansion; inert, with a warning in an adiabatic step", (once below "MATERIAL"), {
        "TYPE" inert "thermal strain is not simulated",
        "ZERO" inert "thermal strain is not simulated",
        "DEPENDENCIES" inert "thermal strain is not simulated",
        "USER" refused "expansion of the user is not called",
        "PORE FLUID" refused "pores are not simulated",
        "FIELD" refused "nothing here depends on field variables",
    }, [(rows ["coefficient" inert "thermal strain is not simulated", "temperature" inert "thermal strain is not simulated"])]),
    row!("SOLID SECTION", "Gives solid elements their material; an element has one section", (), {
        "ELSET" read "Elements",
        "MATERIAL" read "Material",
        "CONTROLS" read "Section controls",
        "ORIENTATION" refused "nothing here is anisotropic",
        "COMPOSITE" refused "a section has one material",
        "LAYUP" refused "a section has one material",
        "ORDER" refused "a section has one material",
        "REF NODE" refused "generalised plane strain is not axisymmetric",
        "STACK DIRECTION" refused "a section has one material",
        "SYMMETRIC" refused "a section has one material",
        "SECTION NAME" inert "written by CAE; no meaning",
    }, [(lines ["attribute" inert "axisymmetric solids have no thickness"])]),
    row!("SECTION CONTROLS", "Hourglass, distortion and viscosity controls of elements", (unique "NAME"), {
        "NAME" read "Name of the controls",
        "HOURGLASS" read "ENHANCED, RELAX STIFFNESS, STIFFNESS, VISCOUS or COMBINED",
        "DISTORTION CONTROL" read "YES or NO",
        "LENGTH RATIO" read "Of distortion control (0.1): distance from the line between its neighbours, over that at the start, below which a corner is pushed",
        "ELEMENT DELETION" read "YES; NO is refused where a material fails, for what fails is deleted",
        "MAX DEGRADATION" read "Damage at which an element is deleted (1)",
        "SECOND ORDER ACCURACY" only ["NO"] "rotations are followed to first order",
        "KINEMATIC SPLIT" only ["AVERAGE STRAIN"] "strains are means over the element",
        "DRILL STIFFNESS" inert "of shells",
        "RAMP INITIAL STRESS" inert "of membranes",
        "VISCOSITY" refused "damage is not regularised",
        "WEIGHT FACTOR" read "Of hourglass stiffness and viscosity",
        "WEIGHTING" extension "VOLUME (default) or AREA: the equation of motion integrated over the plane section",
        "CONVERSION CRITERION" refused "elements do not turn into particles",
        "CONVERSION" refused "elements do not turn into particles",
        "KERNEL" refused "elements do not turn into particles",
        "PARTICLE" refused "elements do not turn into particles",
        "PERTURBATION" refused "of implicit analyses",
        "VISCOUS" refused "of cohesive elements",
        "INITIAL GAP OPENING" refused "of cohesive elements",
    }, [(lines [
        "hourglass factor",
        "rotational factor" inert "of shells",
        "out-of-plane factor" inert "of shells",
        "factor on linear bulk viscosity" only ["1"] "give *BULK VISCOSITY in the step",
        "factor on quadratic bulk viscosity" only ["1"] "give *BULK VISCOSITY in the step",
    ])]),
];
