//! Cards of bodies, masses, springs, targets, constraints, contact, and of the state at the start.
//! Never here: loads.

use super::{card, row};
use crate::deck::keywords::Keyword;
use crate::deck::value::{INTEGER, NOT_NEGATIVE, NUMBER, POSITIVE, TEXT, YES_NO, ZERO, variant, word};

card!(Mass: "MASS", "Mass of MASS elements; an element has one", (), {
    "ELSET" read "Elements",
    "TYPE" only ["ISOTROPIC"] "a mass is the same along r and z",
    "ALPHA" only ["0"] "masses are not damped",
    "COMPOSITE" refused "of modal analyses",
    "ORIENTATION" refused "a mass is the same along r and z",
}, mass: [f64; 1] = [(lines ["mass" (NOT_NEGATIVE.required())])]);

card!(RotaryInertia: "ROTARY INERTIA", "Rotary inertia of ROTARYI elements, for bodies whose impact is oblique; an element has one", (), {
    "ELSET" read "Elements",
    "ALPHA" only ["0"] "inertias are not damped",
    "COMPOSITE" refused "of modal analyses",
    "ORIENTATION" refused "direction 2 is the axis of symmetry",
}, moments: [f64; 3] = [(lines [
    "I11" (NOT_NEGATIVE.required()) "About an axis across the body, through the node",
    "I22" (NOT_NEGATIVE) "About the axis of symmetry (I11)",
    "I33" (NOT_NEGATIVE) "As I11",
    "I12" only ["0"] "axes 1, 2, 3 of a body of revolution are principal",
    "I13" only ["0"] "axes 1, 2, 3 of a body of revolution are principal",
    "I23" only ["0"] "axes 1, 2, 3 of a body of revolution are principal",
])]);

card!(Attitude: extension "ATTITUDE", "Attitude of a rigid body at the start; where it is oblique the body has six degrees of freedom", (), {
    "REF NODE" read "Reference node of the body, about which it is turned, or a set of it",
    stations: usize = "STATIONS" (INTEGER.from(4.0).to(4096.0).or(64.0)) "Stations around the axis at which resistance is taken ",
    inertia: Option<usize> = "INERTIA" (variant(&["UNIFORM"])) "UNIFORM spreads the mass evenly over what the meridian encloses; without it masses lie where the deck has them",
}, angles: [f64; 2] = [(lines ["angle about 3" (ZERO) "Degrees, in the plane in which targets are tilted", "angle about 1" (ZERO) "Degrees, out of that plane, after the other"])]);

card!(GapConductance: "GAP CONDUCTANCE", "Heat that flows from surface to surface", (below "SURFACE INTERACTION"), {
    over_pressure: bool = "PRESSURE" read "Over the pressure, of surfaces that press; without it over the clearance",
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    "USER" refused "of implicit analyses",
}, rows: Vec<[f64; 2]> = [
    (when "PRESSURE" = "" rows ["conductance" (NOT_NEGATIVE.required()), "pressure" (NOT_NEGATIVE.or(0.0).ascending()), "temperature" refused "the conductance is the same at every temperature"]),
    (rows ["conductance" (NOT_NEGATIVE.required()), "clearance" (NOT_NEGATIVE.or(0.0).ascending()) "Nothing flows where it is above the last", "temperature" refused "the conductance is the same at every temperature"]),
]);

card!(GapHeatGeneration: "GAP HEAT GENERATION", "Heat of friction; without the card all of its work, half of it to each surface", (once below "SURFACE INTERACTION"), {
}, values: [f64; 2] = [(lines ["fraction of the work" (NOT_NEGATIVE.or(1.0)), "weight of the first surface" (NUMBER.from(0.0).to(1.0).or(0.5))])]);

card!(SurfaceBehavior: "SURFACE BEHAVIOR", "Pressure against closure", (once below "SURFACE INTERACTION"), {
    kind: usize = "PRESSURE-OVERCLOSURE" (variant(&["HARD", "LINEAR", "EXPONENTIAL", "TABULAR"]).or(0.0)),
    "NO SEPARATION" refused "surfaces part freely",
    "FACTOR" refused "of SCALE FACTOR",
} refused {
    "of implicit analyses": "AUGMENTED LAGRANGE", "PENALTY", "DIRECT";
}, [
    (when "PRESSURE-OVERCLOSURE" = "LINEAR" lines ["pressure a length" (POSITIVE.required())]),
    (when "PRESSURE-OVERCLOSURE" = "EXPONENTIAL" lines ["clearance at which pressure begins" (POSITIVE.required()), "pressure without clearance" (POSITIVE.required())]),
    (when "PRESSURE-OVERCLOSURE" = "TABULAR" rows ["pressure" (NOT_NEGATIVE.required()), "overclosure" (ZERO.ascending())]),
    (lines []),
]);

card!(Friction: "FRICTION", "Friction between surfaces", (once below "SURFACE INTERACTION"), {
    largest: Option<f64> = "TAUMAX" (POSITIVE) "The largest shear stress",
    rough: bool = "ROUGH" read "Nothing slips",
    decays: bool = "EXPONENTIAL DECAY" read "The coefficient falls with the rate of slip",
    "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
    "TEST DATA" refused "of EXPONENTIAL DECAY",
} refused {
    "of implicit analyses": "SLIP TOLERANCE", "ELASTIC SLIP", "LAGRANGE";
    "friction is one coefficient": "ANISOTROPIC", "SHEAR TRACTION SLOPE";
    "friction of the user is not called": "USER", "DEPVAR", "PROPERTIES";
}, values: [f64; 3] = [
    (when "EXPONENTIAL DECAY" = "" lines ["coefficient at rest" (NOT_NEGATIVE.or(0.0)), "coefficient at great rates of slip" (NOT_NEGATIVE.required()),
        "decay, time a length" (NOT_NEGATIVE.required())]),
    (lines [
    "coefficient" (NOT_NEGATIVE.or(0.0)),
    "slip rate" refused "friction is one coefficient",
    "pressure" refused "friction is one coefficient",
    "temperature" refused "friction is one coefficient",
])]);

card!(Target: extension "TARGET", "A layered target that is not meshed; CAVITY loads meet it", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name of the target",
    front: f64 = "FRONT" (ZERO) "Height z of the impact face",
    obliquity: f64 = "OBLIQUITY" (NUMBER.above(-90.0).below(90.0).or(0.0)) "Angle in degrees by which its planes are turned about direction 3; bodies that it resists then have six degrees of freedom",
    direction: f64 = "DIRECTION" (NUMBER.from(-1.0).to(1.0).or(-1.0)) "The way along z the layers follow each other",
    free_surface: usize = "FREE SURFACE" (word(&["OFF", "ON", "LAYERS"]).or(0.0)) "ON: faces that border on nothing weaken the resistance; LAYERS: those of every layer",
    radius: Option<f64> = "RADIUS" (POSITIVE) "Radius of the lateral face of its layers; without it they have no end",
    crater: Option<f64> = "CRATER" (POSITIVE) "Depth of the crater, over which the resistance grows in proportion to the depth",
    shear_strength: Option<f64> = "SHEAR STRENGTH" (POSITIVE) "Plates fail by plugging where to shear a plug out takes less force than to open the cavity",
    separation: bool = "SEPARATION" (word(&["OFF", "ON"]).or(0.0).bare(1.0)) "The tunnel's wall stays where the body has pushed it; what moves inside it bears nothing until it meets it",
}, [(rows [
    "material" read "None in a gap between two plates",
    "thickness" (POSITIVE) "The last layer may have none: it has no end",
    "radius" (POSITIVE) "That of the card where it is left out",
])]);

card!(ContactClearance: "CONTACT CLEARANCE", "What gaps of general contact at the start may be taken as; *CONTACT CLEARANCE ASSIGNMENT says where", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name",
    gap: f64 = "CLEARANCE" (NOT_NEGATIVE.or(0.0)) "The gap",
    above: Option<f64> = "SEARCH ABOVE" (NOT_NEGATIVE) "Gaps up to this are taken as it (a tenth of the elements)",
    below: Option<f64> = "SEARCH BELOW" (NOT_NEGATIVE) "Overlaps up to this are taken as it (a tenth of the elements)",
    "ADJUST" inert "no node is moved: what gaps have too much or too little is taken off for good, without strain",
    "SEARCH NSET" refused "a clearance is one of surfaces: SEARCH ABOVE and SEARCH BELOW say how far",
}, []);

card!(ContactInitializationData: "CONTACT INITIALIZATION DATA", "How general contact may start; *CONTACT INITIALIZATION ASSIGNMENT says where", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name",
    gap: Option<f64> = "INITIAL CLEARANCE" (NOT_NEGATIVE) "The gap that gaps and overlaps are taken as; without it overlaps are taken as none",
    above: Option<f64> = "SEARCH ABOVE" (NOT_NEGATIVE) "Gaps up to this are taken as it (a tenth of the elements, 0 without INITIAL CLEARANCE)",
    below: Option<f64> = "SEARCH BELOW" (NOT_NEGATIVE) "Overlaps up to this are taken as it (a tenth of the elements)",
    "ADJUST" inert "no node is moved: what gaps have too much or too little is taken off for good, without strain",
    "INTERFERENCE FIT" refused "an overlap is not worked off: warm one body, or move its surface over a step",
    "SEARCH NSET" refused "a start is one of surfaces: SEARCH ABOVE and SEARCH BELOW say how far",
    "MINIMUM DISTANCE" refused "of implicit analyses",
}, []);

card!(Clearance: "CLEARANCE", "What gaps of contact pairs at the start are taken as", (each step), {
    "CPSET" read "The set of pairs",
    gap: f64 = "VALUE" (NOT_NEGATIVE.required()) "The gap",
    "TABULAR" refused "a pair has one clearance",
    "INPUT" refused "of TABULAR",
    "BOLT" refused "of threads in space",
} refused {
    "of implicit analyses: give CPSET": "MASTER", "SLAVE";
}, []);

card!(ContactControls: "CONTACT CONTROLS", "Controls of sets of contact pairs", (each step), {
    "CPSET" read "The set of pairs",
    penalty: Option<f64> = "SCALE PENALTY" (POSITIVE) "Factor on the stiffness of penalty springs",
    reset: bool = "RESET" read "The factor is 1 again",
    "FASTLOCALTRK" inert "lists of what may meet are made anew before anything is missed",
    "GLOBTRKINC" inert "lists of what may meet are made anew before anything is missed",
    "WARP CHECK PERIOD" inert "lines do not warp",
    "WARP CUT OFF" inert "lines do not warp",
    "STIFFNESS SCALE FACTOR" refused "of implicit analyses: SCALE PENALTY is the factor",
} refused {
    "of implicit analyses": "ABSOLUTE PENETRATION TOLERANCE", "APPROACH", "AUTOMATIC TOLERANCES", "FRICTION ONSET",
        "LAGRANGE MULTIPLIER", "MAXCHP", "PERRMX", "PERTURBATION TANGENT SCALE FACTOR", "RELATIVE PENETRATION TOLERANCE",
        "SLIDE DISTANCE", "STABILIZE", "TANGENT FRACTION", "UERRMX";
    "of implicit analyses: give CPSET": "MASTER", "SLAVE";
}, []);

/// The rows.
pub const CARDS: &[Keyword] = &[
    Mass::ROW,
    RotaryInertia::ROW,
    Attitude::ROW,
    row!("SPRING", "Springs of SPRINGA and SPRING1 elements; an element has one", (), {
        "ELSET" read "Elements",
        "NONLINEAR" read "Rows of force and relative displacement",
        "COMPLEX STIFFNESS" refused "of harmonic analyses",
        "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
        "ORIENTATION" refused "springs act along r, z or the line between their nodes",
        "RTOL" refused "tables are used as they are given: none is regularised",
    }, [
        (when "NONLINEAR" = "" rows ["degree of freedom or force", "relative displacement",
            "temperature" refused "springs are the same at every temperature"]),
        (rows ["degree of freedom or stiffness", "frequency" refused "of harmonic analyses",
            "temperature" refused "springs are the same at every temperature"]),
    ]),
    row!("DASHPOT", "Dashpots of DASHPOTA and DASHPOT1 elements; an element has one", (), {
        "ELSET" read "Elements",
        "NONLINEAR" read "Rows of force and relative velocity",
        "DEPENDENCIES" refused "*ELASTIC and *PLASTIC alone depend on field variables",
        "ORIENTATION" refused "dashpots act along r, z or the line between their nodes",
        "RTOL" refused "tables are used as they are given: none is regularised",
    }, [
        (when "NONLINEAR" = "" rows ["degree of freedom or force", "relative velocity",
            "temperature" refused "dashpots are the same at every temperature"]),
        (rows ["degree of freedom or coefficient", "frequency" refused "of harmonic analyses",
            "temperature" refused "dashpots are the same at every temperature"]),
    ]),
    row!("RIGID BODY", "Makes a set of elements or nodes a rigid body", (), {
        "REF NODE" read "Reference node or a set of one",
        "ELSET" read "Elements",
        "PIN NSET" read "Nodes pinned to it",
        "TIE NSET" read "Nodes tied to it",
        "ANALYTICAL SURFACE" read "Analytical surface that it carries",
        "POSITION" only ["INPUT"] "a body of revolution moves along z only: the place of its reference node does not matter",
        "DENSITY" (NOT_NEGATIVE.or(0.0)) "Mass per volume",
        "ISOTHERMAL" inert "nothing here conducts heat",
        "NODAL THICKNESS" refused "give one thickness",
        "OFFSET" only ["0"] "facets lie in the middle of their thickness",
    }, [(lines ["thickness" (NOT_NEGATIVE.or(0.0))])]),
    row!("INITIAL CONDITIONS", "Initial values", (), {
        "TYPE" (variant(&["VELOCITY", "TEMPERATURE", "STRESS", "SPECIFIC ENERGY", "HARDENING", "FIELD", "SOLUTION"]).required()),
        "INPUT" read "File with the data lines",
        "FILE" refused "results of another job are not read",
        "UNBALANCED STRESS" refused "of implicit analyses: initial stresses act at once",
        "USER" refused "initial values of the user are not called",
        "GEOSTATIC" refused "of soils",
        "VARIABLE" (INTEGER.from(1.0).to(100.0).or(1.0)) "Number of the field variable of TYPE=FIELD",
        "SECTION POINTS" refused "of shells and beams",
        "REBAR" refused "of reinforcement",
        "CENTROID COORDINATES" refused "of fluid cavities",
    } refused {
        "of FILE": "STEP", "INC", "INTERPOLATE", "ABSOLUTE EXTERIOR TOLERANCE", "EXTERIOR TOLERANCE", "DRIVING ELSETS",
            "MIDSIDE", "INSTANCE", "OUTPUT VARIABLE";
        "of backstresses": "FULL TENSOR", "NUMBER BACKSTRESSES";
        "of rotating bodies": "DEFINITION", "NORMAL";
    }, [
        (when "TYPE" = "TEMPERATURE" rows ["node or set", "temperature" (NUMBER.required())]),
        (when "TYPE" = "STRESS" rows [
            "element or set", "S11" (ZERO), "S22" (ZERO), "S33" (ZERO), "S12" (ZERO),
            "S13" only ["0"] "nothing twists about the axis",
            "S23" only ["0"] "nothing twists about the axis",
        ]),
        (when "TYPE" = "SPECIFIC ENERGY" rows ["element or set", "energy a mass" (NUMBER.required())]),
        (when "TYPE" = "HARDENING" rows ["element or set", "equivalent plastic strain" (NOT_NEGATIVE.required())]),
        (when "TYPE" = "SOLUTION" list "element or set, and its state variables" read "Seven on the first line, eight on each that goes on"),
        (when "TYPE" = "FIELD" rows ["node or set", "field variable" (NUMBER.required())]),
        (rows ["node or set", "degree of freedom" (INTEGER.from(1.0).to(6.0).required()), "velocity" (ZERO)]),
    ]),
    row!("EQUATION", "Linear constraints between degrees of freedom", (), {
        "INPUT" read "File with the data lines",
    }, [(stream ["number of terms, then for each: node or set, degree of freedom, coefficient" read "Four terms a line"])]),
    row!("MPC", "Nodes that move as others do", (), {
        "INPUT" read "File with the data lines",
        "MODE" refused "of constraints by the user's routine, which is not called",
        "USER" refused "constraints of the user are not called",
    }, [(rows ["type" read "BEAM, TIE or PIN", "node or set", "reference node or set" read "One node, or as many as the first set has"])]),
    row!("COUPLING", "Couples a surface to a reference node; *KINEMATIC or *DISTRIBUTING follows", (unique "CONSTRAINT NAME"), {
        "CONSTRAINT NAME" read "Name",
        "REF NODE" read "Reference node or a set of one",
        "SURFACE" read "Surface whose nodes are coupled",
        "INFLUENCE RADIUS" (NUMBER) "Distance from the reference node within which nodes are coupled",
        "ORIENTATION" refused "the directions are r and z",
        "ALPHA" only ["0"] "a coupling does not expand",
        "FRAME" inert "of output databases",
    }, []),
    row!("KINEMATIC", "The nodes of a *COUPLING move as its reference node does", (), {
    }, [(rows ["first degree of freedom" (INTEGER.from(1.0).to(6.0)), "last degree of freedom" (INTEGER.from(1.0).to(6.0))])]),
    row!("DISTRIBUTING", "The reference node of a *COUPLING moves as its nodes do in the mean", (), {
        "COUPLING" only ["CONTINUUM"] "nodes of solids have no rotation",
        "WEIGHTING METHOD" (variant(&["UNIFORM", "LINEAR", "QUADRATIC", "CUBIC"]).or(0.0)),
        "ROTATIONAL COUPLING" inert "symmetry holds the rotation",
    }, [(rows ["first degree of freedom" inert "translations are coupled all the same, and symmetry holds the rotation",
        "last degree of freedom" inert "translations are coupled all the same, and symmetry holds the rotation"])]),
    row!("TIE", "Ties the nodes of one surface to another surface", (unique "NAME"), {
        "NAME" read "Name",
        "ADJUST" (YES_NO.or(1.0)) "Whether tied nodes are first put on the master surface",
        "POSITION TOLERANCE" (NOT_NEGATIVE) "Distance within which nodes are tied (5 % of the mean length of the master's facets)",
        "TIED NSET" read "The nodes that are tied",
        "TYPE" inert "each node follows the point of the master surface that is nearest to it, the default of ABAQUS/Explicit",
        "NO ROTATION" inert "nodes of solids have no rotation",
        "NO THICKNESS" inert "of shells",
        "CONSTRAINT RATIO" inert "of shells",
        "CYCLIC SYMMETRY" refused "of implicit analyses",
        "NO THERMAL" inert "of nodes with a temperature",
        "INTERNAL" inert "written by CAE; no meaning",
    }, [(rows ["slave surface", "master surface", "orientation" refused "of cyclic symmetry"])]),
    row!("CONTACT PAIR", "Contact of two surfaces, or of one with itself", (), {
        "INTERACTION" read "Surface interaction",
        "TYPE" inert "points meet analytical surfaces, facets meet others",
        "MECHANICAL CONSTRAINT" (word(&["KINEMATIC", "PENALTY"]).or(0.0)) "KINEMATIC: surfaces do not give way; PENALTY: springs as stiff as the elements behind them, which limit no increment",
        "CPSET" read "Name of a set of pairs, for *CONTACT CONTROLS, *CLEARANCE and *CONTACT OUTPUT",
        "WEIGHT" inert "the finer surface carries the pressures, a rigid one never does",
        "SMALL SLIDING" inert "surfaces slide as far as they go, which covers small sliding",
        "OP" (word(&["DELETE", "ADD"]).or(1.0)),
        "ADJUST" read "Gaps at the start up to this are taken as none",
        "NO THICKNESS" read "Shells meet at their middle surface and not in front of it by half their thickness",
        "GEOMETRIC CORRECTION" refused "the analytical surface is exact",
        "TIED" refused "surfaces are not tied",
    } refused {
        "of implicit analyses": "EXTENSION ZONE", "HCRIT", "SMOOTH", "TRACKING", "SUPPLEMENTARY CONSTRAINTS",
            "SLIDING TRANSITION", "MINIMUM DISTANCE";
    }, [(rows ["first surface", "second surface", "orientation" refused "friction is the same in every direction",
        "second orientation" refused "friction is the same in every direction"])]),
    row!("CONTACT", "General contact; *CONTACT INCLUSIONS says of what", (), {
        "OP" (word(&["MOD", "NEW"]).or(0.0)) "MOD goes on with what is in force, NEW begins anew",
    }, []),
    row!("CONTACT INCLUSIONS", "What may meet in general contact", (), {
        "ALL EXTERIOR" read "All that is outside may meet everything, itself too",
    }, [(rows ["first surface" read "All that is outside where it is left out", "second surface" read "The first where it is left out"])]),
    row!("CONTACT EXCLUSIONS", "What does not meet in general contact", (), {
    }, [(rows ["first surface" read "All that is outside where it is left out", "second surface" read "The first where it is left out"])]),
    row!("CONTACT PROPERTY ASSIGNMENT", "Interactions of general contact; the last that covers two surfaces counts", (), {
    }, [(rows ["first surface" read "All that is outside where it is left out", "second surface" read "The first where it is left out", "interaction"])]),
    ContactControls::ROW,
    row!("CONTACT CONTROLS ASSIGNMENT", "Controls of general contact; the last that covers two surfaces counts", (), {
        "NODAL EROSION" (YES_NO.or(0.0)) "NO: nodes whose elements were all deleted go on to meet others as points; YES: they meet nothing",
        "TYPE" only ["SCALE PENALTY"] "what meets needs no other controls: every facet is looked at in every increment",
        "AUTOMATIC OVERCLOSURE RESOLUTION" refused "overlaps at the start stay: *CONTACT INITIALIZATION DATA takes them off",
        "CONTACT THICKNESS REDUCTION" refused "shells keep their thickness in contact",
        "BEAM CROSS SECTION" refused "there are no beams",
        "ROTATIONAL TERMS" only ["NONE"] "friction of shells acts in their middle surface",
    }, [(rows ["first surface" read "All that is outside where it is left out", "second surface" read "The first where it is left out",
        "factor on the penalty stiffness" (POSITIVE.required()) "What it covers has penalty springs in place of surfaces that do not give way"])]),
    Clearance::ROW,
    ContactClearance::ROW,
    row!("CONTACT CLEARANCE ASSIGNMENT", "Clearances of general contact; the last that covers two surfaces counts", (), {
    }, [(rows ["first surface" read "All that is outside where it is left out", "second surface" read "The first where it is left out",
        "clearance", "which surface is adjusted" inert "no node is moved"])]),
    ContactInitializationData::ROW,
    row!("CONTACT INITIALIZATION ASSIGNMENT", "How general contact starts; the last that covers two surfaces counts", (), {
    }, [(rows ["first surface" read "All that is outside where it is left out", "second surface" read "The first where it is left out",
        "start", "which surface is adjusted" inert "no node is moved"])]),
    row!("SURFACE INTERACTION", "Begins an interaction of surfaces", (unique "NAME"), {
        "NAME" read "Name",
        "PAD THICKNESS" refused "nothing lies between surfaces",
        "INTERNAL" inert "written by CAE; no meaning",
    } refused {
        "interactions of the user are not called": "USER", "PROPERTIES", "DEPVAR";
        "of implicit analyses": "UNSYMM", "TRACKING THICKNESS";
    }, [(lines ["out-of-plane thickness" inert "of plane models"])]),
    SurfaceBehavior::ROW,
    Friction::ROW,
    GapConductance::ROW,
    GapHeatGeneration::ROW,
    Target::ROW,
];
