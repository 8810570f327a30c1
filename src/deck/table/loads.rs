//! Cards of loads and of prescribed motions.
//! Never here: procedures.

use super::row;
use crate::deck::keywords::Keyword;
use crate::deck::value::{INTEGER, NOT_NEGATIVE, NUMBER, TEXT, variant, word};

/// The rows.
pub const CARDS: &[Keyword] = &[
    row!("BOUNDARY", "Prescribed motion", (), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "TYPE" (variant(&["DISPLACEMENT", "VELOCITY", "ACCELERATION"]).or(0.0)),
        "REGION TYPE" refused "meshes are not adaptive",
        "FIXED" refused "of implicit analyses",
        "LOAD CASE" inert "of implicit analyses",
        "BASE NAME" refused "of modal analyses",
        "USER" read "The user's routine (VDISP) gives the values",
        "SUBMODEL" refused "results of another job are not read",
        "PHANTOM" refused "of enriched elements",
    } refused {
        "of SUBMODEL": "STEP", "INC", "TIMESCALE";
    }, [(rows ["node or set", "first degree of freedom" read "Or ENCASTRE, PINNED, XSYMM, YSYMM ...; 11 is the temperature", "last degree of freedom", "value"])]),
    row!("CLOAD", "Forces on nodes", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "FOLLOWER" refused "forces keep their direction",
        "LOAD CASE" inert "of implicit analyses",
        "REGION TYPE" refused "meshes are not adaptive",
        "REAL" inert "of harmonic analyses",
        "IMAGINARY" refused "of harmonic analyses",
        "CYCLIC MODE" refused "of modal analyses",
        "SUBMODEL" refused "results of another job are not read",
    }, [(rows ["node or set" (TEXT.required()), "degree of freedom" (INTEGER.from(1.0).to(6.0).required()), "force" (NUMBER.required())])]),
    row!("DLOAD", "Loads on elements: gravity, pressure, user pressure", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "meshes are not adaptive",
        "REF NODE" refused "of fluid pressures",
        "LOAD CASE" inert "of implicit analyses",
        "ORIENTATION" refused "pressures act along normals",
        "FOLLOWER" refused "pressures follow their faces",
        "REAL" inert "of harmonic analyses",
        "IMAGINARY" refused "of harmonic analyses",
        "CONSTANT RESULTANT" refused "pressures act on present areas",
        "CYCLIC MODE" refused "of modal analyses",
        "TARGET" extension "Target whose resistance CAVITY loads meet",
        "FRICTION" extension (NOT_NEGATIVE.or(0.0)) "Coulomb coefficient of CAVITY loads",
    }, [(rows [
        "element or set",
        "label" read "GRAV, P, P1 ... P4, PNU, P1NU ... P4NU, BRNU, BZNU, CAVITY",
        "magnitude",
        "direction along r" read "Of GRAV",
        "direction along z" read "Of GRAV",
        "third direction" only ["0"] "gravity acts in the r-z plane",
    ])]),
    row!("DSLOAD", "Loads on surfaces: pressure, user pressure, cavity expansion", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "meshes are not adaptive",
        "REF NODE" refused "of fluid pressures",
        "LOAD CASE" inert "of implicit analyses",
        "ORIENTATION" refused "pressures act along normals",
        "FOLLOWER" refused "pressures follow their faces",
        "REAL" inert "of harmonic analyses",
        "IMAGINARY" refused "of harmonic analyses",
        "CONSTANT RESULTANT" refused "pressures act on present areas",
        "CYCLIC MODE" refused "of modal analyses",
        "SUBMODEL" refused "results of another job are not read",
        "STEP" refused "of SUBMODEL",
        "TARGET" extension "Target whose resistance CAVITY loads meet",
        "FRICTION" extension (NOT_NEGATIVE.or(0.0)) "Coulomb coefficient of CAVITY loads",
    }, [(rows ["surface", "label" read "P, PNU or CAVITY", "magnitude"])]),
    row!("FIELD", "Field variables at nodes over time, which tables of materials and routines of the user depend on", (step), {
        "VARIABLE" (INTEGER.from(1.0).to(100.0).or(1.0)) "Number of the field variable",
        "OP" (word(&["MOD", "NEW"]).or(0.0)) "NEW: fields of earlier steps are what they were at the start",
        "AMPLITUDE" read "Amplitude of the values; without it they are there at once",
        "INPUT" read "File with the data lines",
        "USER" refused "subroutine vufield is not called; vusdfld is",
        "FILE" refused "results of another job are not read",
    } refused {
        "of FILE": "BSTEP", "BINC", "ESTEP", "EINC", "INTERPOLATE", "MIDSIDE", "OUTPUT VARIABLE", "DRIVING ELSETS",
            "ABSOLUTE EXTERIOR TOLERANCE", "EXTERIOR TOLERANCE";
        "of USER": "NUMBER", "BLOCKING";
    }, [(rows ["node or set", "field variable" (NUMBER.required())])]),
    row!("CFLUX", "Heat into nodes", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "meshes are not adaptive",
    }, [(rows ["node or set", "degree of freedom" only ["11"] "11 is the temperature", "heat a time" (NUMBER.required())])]),
    row!("DFLUX", "Heat into elements: S1 ... S4 through their faces, BF into their volume", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "meshes are not adaptive",
    }, [(rows ["element or set", "label" read "S1 ... S4, BF", "heat flux" (NUMBER.required()) "A time and area, or a time and volume"])]),
    row!("DSFLUX", "Heat through surfaces", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the values",
        "REGION TYPE" refused "meshes are not adaptive",
    }, [(rows ["surface", "label" only ["S"] "uniform fluxes are", "heat flux" (NUMBER.required())])]),
    row!("FILM", "Exchange of heat between faces of elements and a fluid", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the temperature of the fluid",
        "FILM AMPLITUDE" read "Amplitude of the film coefficient",
        "REGION TYPE" refused "meshes are not adaptive",
    }, [(rows ["element or set", "label" read "F1 ... F4", "temperature of the fluid" (NUMBER.required()), "film coefficient" (NOT_NEGATIVE.required())])]),
    row!("SFILM", "Exchange of heat between surfaces and a fluid", (step), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)),
        "AMPLITUDE" read "Amplitude of the temperature of the fluid",
        "FILM AMPLITUDE" read "Amplitude of the film coefficient",
        "REGION TYPE" refused "meshes are not adaptive",
    }, [(rows ["surface", "label" only ["F"] "uniform films are", "temperature of the fluid" (NUMBER.required()), "film coefficient" (NOT_NEGATIVE.required())])]),
];
