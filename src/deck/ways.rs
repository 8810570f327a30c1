//! What there is in place of what is not supported. The page of ABAQUS's keywords and the refusals say it.
//! Never here: what is supported.

/// The way out where a keyword is not supported; empty where there is none.
pub fn named(name: &str) -> &'static str {
    let begins = |heads: &[&str]| heads.iter().any(|h| name.starts_with(h));
    match name {
        "STATIC"
        | "VISCO"
        | "HEAT TRANSFER"
        | "COUPLED TEMPERATURE-DISPLACEMENT"
        | "FREQUENCY"
        | "BUCKLE"
        | "SOILS"
        | "GEOSTATIC"
        | "DIRECT CYCLIC"
        | "MODAL DYNAMIC"
        | "STEADY STATE DYNAMICS"
        | "STEADY STATE TRANSPORT"
        | "MASS DIFFUSION"
        | "ANNEAL" => "the supported procedure is *DYNAMIC, EXPLICIT",
        "SHELL SECTION" | "SHELL GENERAL SECTION" | "MEMBRANE SECTION" | "BEAM SECTION" | "BEAM GENERAL SECTION" => {
            "the supported section is *SOLID SECTION: mesh the thickness with CAX4R"
        }
        "RESTART" => "to go on with a halted run, use `revolve run --resume`",
        "CONTACT" => {
            "contact of what deforms with an analytical rigid surface is: *CONTACT PAIR; bodies that touch and stay can share nodes"
        }
        "TIE" => "let the two bodies share the nodes between them",
        "MPC" | "COUPLING" | "KINEMATIC" | "DISTRIBUTING" | "KINEMATIC COUPLING" | "DISTRIBUTING COUPLING" => {
            "nodes follow a reference node with *RIGID BODY, TIE NSET= or PIN NSET=; two degrees of freedom are linked by *EQUATION"
        }
        "NCOPY" | "NMAP" => "*NFILL and *NGEN make nodes; instances of a part are placed with *INSTANCE",
        "ELCOPY" => "*ELGEN makes elements; instances of a part are placed with *INSTANCE",
        "TRANSFORM" | "SYSTEM" => "give r and z; conditions act along r (1) and z (2)",
        "RIGID SURFACE" => "*SURFACE, TYPE=SEGMENTS with *RIGID BODY, ANALYTICAL SURFACE= does that",
        "TEMPERATURE" => "*INITIAL CONDITIONS, TYPE=TEMPERATURE gives temperatures at the start",
        "SUBMODEL" | "IMPORT" | "MAP SOLUTION" => "initial states are given by *INITIAL CONDITIONS",
        _ if begins(&["INCIDENT WAVE", "CONWEP", "UNDEX"]) => {
            "give the pressure over time: *DSLOAD, P with *AMPLITUDE, or PNU with a vdload"
        }
        "DLOAD" | "DSLOAD" | "WIND" | "WAVE" => "a pressure of your own is PNU with a vdload",
        "EXTREME VALUE" | "EXTREME ELEMENT VALUE" | "EXTREME NODE VALUE" => {
            "a vumat or vdload can end a run with xplb_exit"
        }
        "DISTRIBUTION" | "DISTRIBUTION TABLE" => "give a section for each set of elements",
        "PARAMETER DEPENDENCE" | "PARAMETER SHAPE VARIATION" | "DESIGN PARAMETER" => {
            "parameters are varied with `revolve sweep`"
        }
        "PARAMETER TABLE" | "TABLE COLLECTION" | "PROPERTY TABLE" => "give the constants on *USER MATERIAL",
        "DISPLAY BODY" => "remove it: it is shown only",
        "MODEL CHANGE" => "elements leave by failure: *SHEAR FAILURE, *DAMAGE INITIATION, STATUS of a vumat",
        _ if begins(MATERIALS) => "a law of your own is a *USER MATERIAL with a vumat",
        _ => "",
    }
}

/// Beginnings of keywords that are parts of a material.
const MATERIALS: &[&str] = &[
    "ANISOTROPIC HYPERELASTIC",
    "BRITTLE",
    "CAP ",
    "CAST IRON",
    "CLAY",
    "CONCRETE",
    "CREEP",
    "CRUSHABLE FOAM",
    "CRUSH STRESS",
    "CYCLED PLASTIC",
    "CYCLIC HARDENING",
    "DEFORMATION PLASTICITY",
    "DRUCKER PRAGER",
    "EOS COMPACTION",
    "FABRIC",
    "FAIL STR",
    "HYPERFOAM",
    "HYPOELASTIC",
    "HYSTERESIS",
    "JOINTED MATERIAL",
    "LOW DENSITY FOAM",
    "MOHR COULOMB",
    "MULLINS EFFECT",
    "ORNL",
    "PLASTICITY CORRECTION",
    "POROUS METAL",
    "POTENTIAL",
    "RATIOS",
    "REACTION RATE",
    "SWELLING",
    "TRS",
    "VISCOELASTIC",
    "VISCOSITY",
    "VISCOUS",
    "VOID NUCLEATION",
];

/// The way out, or the last resort.
pub fn way_out(name: &str) -> &'static str {
    match named(name) {
        "" => "remove it if the analysis does not need it",
        way => way,
    }
}
