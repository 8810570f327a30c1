//! Cards of loads, prescribed motions and predefined fields.

use super::row;
use crate::deck::keywords::Keyword;
use crate::deck::value::{INTEGER, NOT_NEGATIVE, NUMBER, TEXT, variant, word};

/// Keywords of loads, prescribed motions and predefined fields.
pub const CARDS: &[Keyword] = &[
    row!("BOUNDARY", "Prescribed motion", (), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "TYPE" (variant(&["DISPLACEMENT", "VELOCITY", "ACCELERATION"]).or(0.0)),
        "REGION TYPE" refused "adaptive meshing is unsupported",
        "FIXED" refused "applies only to implicit analyses",
        "LOAD CASE" inert "applies only to implicit analyses",
        "BASE NAME" refused "applies only to modal analyses",
        "USER" read "Values from user subroutine VDISP",
        "SUBMODEL" refused "results of another job cannot be read",
        "PHANTOM" refused "applies only to enriched elements",
    } refused {
        "applies only to SUBMODEL": "STEP", "INC", "TIMESCALE";
    }, [(rows ["node or set", "first degree of freedom" read "Or ENCASTRE, PINNED, XSYMM, YSYMM ...; 11 is the temperature", "last degree of freedom", "value"])]),
    row!("CLOAD", "Forces on nodes", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "FOLLOWER" refused "forces keep their direction",
        "LOAD CASE" inert "applies only to implicit analyses",
        "REGION TYPE" refused "adaptive meshing is unsupported",
        "REAL" inert "applies only to harmonic analyses",
        "IMAGINARY" refused "applies only to harmonic analyses",
        "CYCLIC MODE" refused "applies only to modal analyses",
        "SUBMODEL" refused "results of another job cannot be read",
    }, [(rows ["node or set" (TEXT.required()), "degree of freedom" (INTEGER.from(1.0).to(6.0).required()), "force" (NUMBER.required())])]),
    row!("DLOAD", "Loads on elements: gravity, pressure, user-defined pressure", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "adaptive meshing is unsupported",
        "REF NODE" refused "applies only to fluid pressures",
        "LOAD CASE" inert "applies only to implicit analyses",
        "ORIENTATION" refused "pressures act along normals",
        "FOLLOWER" only ["YES"] "pressures follow their faces",
        "REAL" inert "applies only to harmonic analyses",
        "IMAGINARY" refused "applies only to harmonic analyses",
        "CONSTANT RESULTANT" refused "pressures act on current areas",
        "CYCLIC MODE" refused "applies only to modal analyses",
        "TARGET" extension "Target of CAVITY loads",
        "FRICTION" extension (NOT_NEGATIVE.or(0.0)) "Coulomb friction coefficient of CAVITY loads",
    }, [(rows [
        "element or set",
        "label" read "GRAV, P, P1 ... P4, PNU, P1NU ... P4NU, BRNU, BZNU, CAVITY",
        "magnitude",
        "direction along r" read "For GRAV",
        "direction along z" read "For GRAV",
        "third direction" read "For GRAV on bodies with six degrees of freedom",
    ])]),
    row!("DSLOAD", "Loads on surfaces: pressure, user-defined pressure, cavity expansion", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "adaptive meshing is unsupported",
        "REF NODE" refused "applies only to fluid pressures",
        "LOAD CASE" inert "applies only to implicit analyses",
        "ORIENTATION" refused "pressures act along normals",
        "FOLLOWER" only ["YES"] "pressures follow their faces",
        "REAL" inert "applies only to harmonic analyses",
        "IMAGINARY" refused "applies only to harmonic analyses",
        "CONSTANT RESULTANT" refused "pressures act on current areas",
        "CYCLIC MODE" refused "applies only to modal analyses",
        "SUBMODEL" refused "results of another job cannot be read",
        "STEP" refused "applies only to SUBMODEL",
        "TARGET" extension "Target of CAVITY loads",
        "FRICTION" extension (NOT_NEGATIVE.or(0.0)) "Coulomb friction coefficient of CAVITY loads",
    }, [(rows ["surface", "label" read "P, PNU or CAVITY", "magnitude"])]),
    row!("FIELD", "Field variables at nodes over time, for material tables and user subroutines", (step), {
        "VARIABLE" (INTEGER.from(1.0).to(100.0).or(1.0)) "Number of the field variable",
        "OP" (word(&["MOD", "NEW"]).or(0.0)) "NEW: fields of earlier steps return to their initial values",
        "AMPLITUDE" read "Amplitude of the values; without it they apply at once",
        "INPUT" read "File with the data lines",
        "USER" refused "subroutine VUFIELD is unsupported; use VUSDFLD",
        "FILE" refused "results of another job cannot be read",
    } refused {
        "applies only to FILE": "BSTEP", "BINC", "ESTEP", "EINC", "INTERPOLATE", "MIDSIDE", "OUTPUT VARIABLE", "DRIVING ELSETS",
            "ABSOLUTE EXTERIOR TOLERANCE", "EXTERIOR TOLERANCE";
        "applies only to USER": "NUMBER", "BLOCKING";
    }, [(rows ["node or set", "field variable" (NUMBER.required())])]),
    row!("CFLUX", "Concentrated heat fluxes at nodes", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "adaptive meshing is unsupported",
    }, [(rows ["node or set", "degree of freedom" only ["11"] "11 is the temperature", "heat per time" (NUMBER.required())])]),
    row!("DFLUX", "Heat fluxes into elements: S1 ... S4 through faces, BF per volume", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "adaptive meshing is unsupported",
    }, [(rows ["element or set", "label" read "S1 ... S4, BF", "heat flux" (NUMBER.required()) "Heat per time and area, or per time and volume"])]),
    row!("DSFLUX", "Heat fluxes through surfaces", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "adaptive meshing is unsupported",
    }, [(rows ["surface", "label" only ["S"] "only uniform fluxes are supported", "heat flux" (NUMBER.required())])]),
    row!("FILM", "Film conditions on element faces", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the fluid temperature",
        "FILM AMPLITUDE" read "Amplitude of the film coefficient",
        "REGION TYPE" refused "adaptive meshing is unsupported",
    }, [(rows ["element or set", "label" read "F1 ... F4", "temperature of the fluid" (NUMBER.required()), "film coefficient" (NOT_NEGATIVE.required())])]),
    row!("SFILM", "Film conditions on surfaces", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the fluid temperature",
        "FILM AMPLITUDE" read "Amplitude of the film coefficient",
        "REGION TYPE" refused "adaptive meshing is unsupported",
    }, [(rows ["surface", "label" only ["F"] "only uniform film conditions are supported", "temperature of the fluid" (NUMBER.required()), "film coefficient" (NOT_NEGATIVE.required())])]),
];
