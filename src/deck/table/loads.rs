//! Cards of loads and of prescribed motions.
//! Never here: procedures.

use super::row;
use crate::deck::keywords::Keyword;

/// The rows.
pub const CARDS: &[Keyword] = &[
    row!("BOUNDARY", "Prescribed motion", (), {
        "OP" read "MOD (default) or NEW",
        "AMPLITUDE" read "Amplitude of the values",
        "TYPE" read "DISPLACEMENT (default), VELOCITY or ACCELERATION",
        "REGION TYPE" refused "meshes are not adaptive",
        "FIXED" refused "of implicit analyses",
        "LOAD CASE" inert "of implicit analyses",
        "BASE NAME" refused "of modal analyses",
        "USER" read "The user's routine (VDISP) gives the values",
        "SUBMODEL" refused "results of another job are not read",
        "STEP" refused "of SUBMODEL",
        "INC" refused "of SUBMODEL",
        "TIMESCALE" refused "of SUBMODEL",
        "PHANTOM" refused "of enriched elements",
    }, [(rows ["node or set", "first degree of freedom" read "Or ENCASTRE, PINNED, XSYMM, YSYMM ...", "last degree of freedom", "value"])]),
    row!("CLOAD", "Forces on nodes", (step), {
        "OP" read "MOD (default) or NEW",
        "AMPLITUDE" read "Amplitude of the values",
        "FOLLOWER" refused "forces keep their direction",
        "LOAD CASE" inert "of implicit analyses",
        "REGION TYPE" refused "meshes are not adaptive",
        "REAL" inert "of harmonic analyses",
        "IMAGINARY" refused "of harmonic analyses",
        "CYCLIC MODE" refused "of modal analyses",
        "SUBMODEL" refused "results of another job are not read",
    }, [(rows ["node or set", "degree of freedom", "force"])]),
    row!("DLOAD", "Loads on elements: gravity, pressure, user pressure", (step), {
        "OP" read "MOD (default) or NEW",
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
        "FRICTION" extension "Coulomb coefficient of CAVITY loads",
    }, [(rows [
        "element or set",
        "label" read "GRAV, P, P1 ... P4, PNU, P1NU ... P4NU, BRNU, BZNU, CAVITY",
        "magnitude",
        "direction along r" read "Of GRAV",
        "direction along z" read "Of GRAV",
        "third direction" only ["0"] "gravity acts in the r-z plane",
    ])]),
    row!("DSLOAD", "Loads on surfaces: pressure, user pressure, cavity expansion", (step), {
        "OP" read "MOD (default) or NEW",
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
        "FRICTION" extension "Coulomb coefficient of CAVITY loads",
    }, [(rows ["surface", "label" read "P, PNU or CAVITY", "magnitude"])]),
];
