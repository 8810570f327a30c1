//! Cards of loads, prescribed motions and predefined fields.

use super::row;
use crate::deck::keywords::Keyword;
use crate::deck::value::{FLAG, INTEGER, NOT_NEGATIVE, NUMBER, POSITIVE, TEXT, YES_NO, ZERO, variant, word};

/// Builds a row with the parameters of all loads, followed by those of the card.
macro_rules! load {
    ($name:literal, $summary:literal, ($($often:ident)?), { $($parameters:tt)* } $(refused $refused:tt)?, $data:tt) => {
        row!($name, $summary, ($($often)?), {
            "OP" (word(&["MOD", "NEW"]).or(0.0)),
            "AMPLITUDE" read "Amplitude of the values",
            "REGION TYPE" (word(&["LAGRANGIAN", "SLIDING", "EULERIAN"]).or(0.0)),
            $($parameters)*
        } $(refused $refused)?, $data)
    };
}

/// Builds a row with the parameters of all loads on faces, followed by those of the card.
macro_rules! pressure {
    ($name:literal, $summary:literal, (step), { $($parameters:tt)* }, $data:tt) => {
        load!($name, $summary, (step), {
            "REF NODE" read "Node to whose velocity VP refers",
            "LOAD CASE" inert "applies only to implicit analyses",
            "ORIENTATION" refused "pressures act along normals",
            "FOLLOWER" (YES_NO.or(1.0)) "NO: the direction of TRVEC is fixed; YES: it rotates with the surface",
            "REAL" inert "applies only to harmonic analyses",
            "IMAGINARY" refused "applies only to harmonic analyses",
            "CONSTANT RESULTANT" only ["NO"] "pressures and tractions act on current areas",
            "CYCLIC MODE" refused "applies only to modal analyses",
            "TARGET" extension "Target of CAVITY loads",
            "FRICTION" extension (NOT_NEGATIVE.or(0.0)) "Coulomb friction coefficient of CAVITY loads",
            $($parameters)*
        }, $data)
    };
}

/// Keywords of loads, prescribed motions and predefined fields.
pub const CARDS: &[Keyword] = &[
    load!("BOUNDARY", "Prescribed motion", (), {
        "TYPE" (variant(&["DISPLACEMENT", "VELOCITY", "ACCELERATION"]).or(0.0)),
        "FIXED" refused "applies only to implicit analyses",
        "LOAD CASE" inert "applies only to implicit analyses",
        "BASE NAME" refused "applies only to modal analyses",
        "USER" (FLAG) "Values from user subroutine VDISP",
        "SUBMODEL" refused "results of another job cannot be read",
        "PHANTOM" refused "applies only to enriched elements",
    } refused {
        "applies only to SUBMODEL": "STEP", "INC", "TIMESCALE";
    }, [(rows ["node or set", "first degree of freedom" read "Or ENCASTRE, PINNED, XSYMM, YSYMM ...; 11 is the temperature", "last degree of freedom", "value"])]),
    load!("CLOAD", "Forces on nodes", (step), {
        "FOLLOWER" refused "forces keep their direction",
        "LOAD CASE" inert "applies only to implicit analyses",
        "REAL" inert "applies only to harmonic analyses",
        "IMAGINARY" refused "applies only to harmonic analyses",
        "CYCLIC MODE" refused "applies only to modal analyses",
        "SUBMODEL" refused "results of another job cannot be read",
    }, [(rows ["node or set" (TEXT.required()), "degree of freedom" (INTEGER.from(1.0).to(6.0).required()), "force" (NUMBER.required())])]),
    pressure!("DLOAD", "Loads on elements: gravity, body forces, pressures, tractions, user-defined pressures", (step), {}, [(rows [
        "element or set",
        "label" read "GRAV, BR, BZ, CENTRIF, P, P1 ... P4, VP ..., TRVEC ..., TRSHR ..., PNU, P1NU ... P4NU, BRNU, BZNU, CAVITY",
        "magnitude" read "Acceleration, force per volume, squared angular velocity (CENTRIF), pressure, pressure per velocity (VP) or traction",
        "direction along r" read "For GRAV, TRVEC and TRSHR; for CENTRIF r of a point of the axis, 0",
        "direction along z" read "For GRAV, TRVEC and TRSHR; for CENTRIF z of this point",
        "third direction" read "For GRAV on bodies with six degrees of freedom; otherwise 0",
        "axis along r" read "For CENTRIF, 0",
        "axis along z" read "For CENTRIF",
        "third component of the axis" read "For CENTRIF, 0",
    ])]),
    pressure!("DSLOAD", "Loads on surfaces: pressures, tractions, user-defined pressures, cavity expansion", (step), {
        "SUBMODEL" refused "results of another job cannot be read",
        "STEP" refused "applies only to SUBMODEL",
    }, [(rows [
        "surface",
        "label" read "P, VP, TRVEC, TRSHR, PNU or CAVITY",
        "magnitude" read "Pressure, pressure per velocity (VP) or traction",
        "direction along r" read "For TRVEC and TRSHR",
        "direction along z" read "For TRVEC and TRSHR",
        "third direction" only ["0"] "tractions act in the r-z plane",
    ])]),
    row!("INCIDENT WAVE INTERACTION PROPERTY", "Blast wave in air", (unique "NAME"), {
        "NAME" (TEXT.required()) "Name",
        "TYPE" (variant(&["AIR BLAST", "SURFACE BLAST"]).required()) "AIR BLAST: spherical wave of a charge in free air; SURFACE BLAST: hemispherical wave of a charge on the ground",
    }, []),
    row!("CONWEP CHARGE PROPERTY", "Charge of a blast wave", (once below "INCIDENT WAVE INTERACTION PROPERTY"), {}, [
        (lines
            ["mass of TNT" (POSITIVE.required()), "factor to kilograms" (POSITIVE.or(1.0))]
            ["factor to metres" (POSITIVE.or(1.0)) "From the unit of length of the model", "factor to seconds" (POSITIVE.or(1.0)), "factor to pascals" (POSITIVE.or(1.0))]),
    ]),
    row!("INCIDENT WAVE INTERACTION", "Pressure of a blast wave on surfaces", (step), {
        "PROPERTY" read "Blast wave",
        "CONWEP" (FLAG) "Pressure history of *CONWEP CHARGE PROPERTY; required",
        "PRESSURE AMPLITUDE" refused "applies only to waves in fluids: give the pressure as *DSLOAD, P with *AMPLITUDE",
        "ACCELERATION AMPLITUDE" refused "applies only to waves in fluids",
        "UNDEX" refused "applies only to waves in fluids",
    } refused {
        "applies only to harmonic analyses": "REAL", "IMAGINARY";
    }, [(rows ["surface", "source node" read "On the axis of symmetry, or a set of one node", "total time of detonation" (ZERO), "factor on the pressure" (NUMBER.or(1.0))])]),
    row!("FIELD", "Field variables at nodes over time, for material tables and user subroutines", (step), {
        "VARIABLE" (INTEGER.from(1.0).to(100.0).or(1.0)) "Number of the field variable",
        "OP" (word(&["MOD", "NEW"]).or(0.0)) "NEW: fields of earlier steps return to their initial values",
        "AMPLITUDE" read "Amplitude of the values; without it they apply at once",
        "INPUT" read "File with the data lines",
        "USER" (FLAG) "User subroutine VUFIELD sets the values",
        "NUMBER" (INTEGER.from(1.0).to(100.0)) "With USER: number of variables that the subroutine sets together, from VARIABLE on; default 1",
        "BLOCKING" inert "VUFIELD is called for at most 128 nodes",
        "FILE" refused "results of another job cannot be read",
    } refused {
        "applies only to FILE": "BSTEP", "BINC", "ESTEP", "EINC", "INTERPOLATE", "MIDSIDE", "OUTPUT VARIABLE", "DRIVING ELSETS",
            "ABSOLUTE EXTERIOR TOLERANCE", "EXTERIOR TOLERANCE";
    }, [
        (when "USER" rows ["node or set", "field variable" inert "VUFIELD sets the values"]),
        (rows ["node or set", "field variable" (NUMBER.required())]),
    ]),
    row!("TEMPERATURE", "Temperatures at nodes over time, for steps that do not solve for them", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)) "NEW: temperatures of earlier steps return to their initial values",
        "AMPLITUDE" read "Amplitude of the temperatures; without it they apply at once",
        "INPUT" read "File with the data lines",
        "USER" refused "user-defined temperatures are unsupported; give an amplitude",
        "FILE" refused "results of another job cannot be read",
    } refused {
        "applies only to FILE": "BSTEP", "BINC", "ESTEP", "EINC", "INTERPOLATE", "MIDSIDE", "DRIVING ELSETS", "ABSOLUTE EXTERIOR TOLERANCE",
            "EXTERIOR TOLERANCE", "INSTANCE";
    }, [(rows ["node or set", "temperature" (NUMBER.required())])]),
    load!("CFLUX", "Concentrated heat fluxes at nodes", (step), {}, [(rows ["node or set", "degree of freedom" only ["11"] "11 is the temperature", "heat per time" (NUMBER.required())])]),
    load!("DFLUX", "Heat fluxes into elements: S1 ... S4 through faces, BF per volume", (step), {}, [(rows ["element or set", "label" read "S1 ... S4, BF", "heat flux" (NUMBER.required()) "Heat per time and area, or per time and volume"])]),
    load!("DSFLUX", "Heat fluxes through surfaces", (step), {}, [(rows ["surface", "label" only ["S"] "only uniform fluxes are supported", "heat flux" (NUMBER.required())])]),
    row!("FILM", "Film conditions on element faces", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the fluid temperature",
        "FILM AMPLITUDE" read "Amplitude of the film coefficient",
        "REGION TYPE" (word(&["LAGRANGIAN", "SLIDING", "EULERIAN"]).or(0.0)),
    }, [(rows ["element or set", "label" read "F1 ... F4", "temperature of the fluid" (NUMBER.required()), "film coefficient" (NOT_NEGATIVE.required())])]),
    row!("SFILM", "Film conditions on surfaces", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the fluid temperature",
        "FILM AMPLITUDE" read "Amplitude of the film coefficient",
        "REGION TYPE" (word(&["LAGRANGIAN", "SLIDING", "EULERIAN"]).or(0.0)),
    }, [(rows ["surface", "label" only ["F"] "only uniform film conditions are supported", "temperature of the fluid" (NUMBER.required()), "film coefficient" (NOT_NEGATIVE.required())])]),
];
