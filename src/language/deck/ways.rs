//! Alternatives to unsupported keywords, for error messages and the list of ABAQUS keywords.

/// Returns the supported alternative to an unsupported keyword; empty if there is none.
pub fn alternative(name: &str) -> &'static str {
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
        "SHELL GENERAL SECTION" | "MEMBRANE SECTION" | "BEAM SECTION" | "BEAM GENERAL SECTION" => {
            "the supported section is *SOLID SECTION: mesh the thickness with CAX4R"
        }
        "RESTART" => "to continue a halted run, use `revolve run --resume`",
        "KINEMATIC COUPLING" => "use *COUPLING and below it *KINEMATIC",
        "DISTRIBUTING COUPLING" => "use *COUPLING and below it *DISTRIBUTING",
        "SUBMODEL" | "IMPORT" | "MAP SOLUTION" => "initial states are given by *INITIAL CONDITIONS",
        _ if begins(&["INCIDENT WAVE", "UNDEX"]) => {
            "blasts in air are given by *INCIDENT WAVE INTERACTION, CONWEP; for others give the pressure history as *DSLOAD, P with *AMPLITUDE, or as PNU with a VDLOAD user subroutine"
        }
        "WIND" | "WAVE" => "other distributed loads can be written as VDLOAD user subroutines (PNU)",
        "EXTREME VALUE" | "EXTREME ELEMENT VALUE" | "EXTREME NODE VALUE" => {
            "a VUMAT or VDLOAD user subroutine can end a run with xplb_exit"
        }
        "DISTRIBUTION" | "DISTRIBUTION TABLE" => "define a section for each element set",
        "PARAMETER DEPENDENCE" | "PARAMETER SHAPE VARIATION" | "DESIGN PARAMETER" => {
            "parameters are varied with `revolve sweep`"
        }
        "PARAMETER TABLE" | "TABLE COLLECTION" | "PROPERTY TABLE" => "give the constants on *USER MATERIAL",
        "DISPLAY BODY" => "remove it: it only affects the display",
        "MODEL CHANGE" => {
            "elements are deleted by *SHEAR FAILURE, *DAMAGE INITIATION, *EROSION, or the state variable of *DEPVAR, DELETE= of a VUMAT"
        }
        _ if begins(MATERIALS) => "other material models can be written as VUMAT user subroutines (*USER MATERIAL)",
        _ => "",
    }
}

/// Beginnings of keywords that define material behaviour.
const MATERIALS: &[&str] = &[
    "BRITTLE",
    "CAP ",
    "CAST IRON",
    "CLAY",
    "CONCRETE",
    "CREEP",
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
    "VISCOUS",
    "VOID NUCLEATION",
];

/// Returns the supported alternative, or the advice to remove the keyword.
pub fn alternative_or_removal(name: &str) -> &'static str {
    match alternative(name) {
        "" => "remove it if the analysis does not need it",
        way => way,
    }
}
