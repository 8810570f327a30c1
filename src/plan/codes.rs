//! Diagnostic codes of the plan (`P…`) and of the run (`R…`), for `revolve explain`.
//! Never here: the checks.

use crate::deck::Code;

/// All codes of this room.
pub const CODES: &[Code] = &[
    Code {
        code: "P001",
        title: "elements that nothing moves",
        text: "Solid elements deform if a *SOLID SECTION gives them a material, and move with a *RIGID BODY that names them. These do neither.",
    },
    Code {
        code: "P002",
        title: "rigid body without mass",
        text: "A body that is free to move needs mass: give *RIGID BODY a DENSITY and a thickness on its data line (RAX2 elements then carry mass), or put an element of TYPE=MASS with *MASS on its reference node. A body whose motion along z is prescribed needs none.",
    },
    Code {
        code: "P003",
        title: "load on what belongs to no body",
        text: "Loads act on rigid bodies and on what deforms; these nodes or elements belong to neither.",
    },
    Code {
        code: "P004",
        title: "user's routine is missing",
        text: "PNU, as in ABAQUS/Explicit, calls the user's load routine (vdload), DEFINITION=USER on *AMPLITUDE calls vuamp, *BOUNDARY, USER calls vdisp, and *USER MATERIAL calls vumat. Give a Fortran or C file with `--user FILE`, or link a routine through the library (`revolve::user::Routines`).",
    },
    Code {
        code: "P005",
        title: "mass on a node of no rigid body",
        text: "A point mass moves only as part of a rigid body: put it on the reference node.",
    },
    Code {
        code: "P006",
        title: "nothing to simulate",
        text: "A run needs at least one body, rigid or deformable, and one step with *DYNAMIC, EXPLICIT.",
    },
    Code {
        code: "P007",
        title: "prescribed motion on a dependent node",
        text: "The nodes of a rigid body follow its reference node; prescribe the motion there.",
    },
    Code {
        code: "P008",
        title: "two prescribed motions on one body",
        text: "The same degree of freedom is prescribed twice with different values.",
    },
    Code {
        code: "P009",
        title: "node or element in two rigid bodies",
        text: "A node or element can follow one reference node only.",
    },
    Code {
        code: "P010",
        title: "sensor without one value",
        text: "A sensor is one number for a user amplitude: *OUTPUT, HISTORY, SENSOR, NAME=… followed by *NODE OUTPUT with a node set of one node and U2, V2 or A2.",
    },
    Code {
        code: "P011",
        title: "node that follows a rigid body",
        text: "Nodes that a rigid body shares with deformable elements follow it along z and stay where they are along r: nothing else can constrain them.",
    },
    Code {
        code: "P012",
        title: "element without volume",
        text: "The nodes of a solid must run counter-clockwise in the (r, z) plane, with r not below zero. A negative volume means clockwise; zero means that corners coincide or lie on one line.",
    },
    Code {
        code: "P013",
        title: "material without density or elasticity",
        text: "What deforms needs *DENSITY and *ELASTIC, or *DENSITY and *EOS; with *EOS a shear modulus comes from *ELASTIC, TYPE=SHEAR. An ideal gas needs *SPECIFIC HEAT.",
    },
    Code {
        code: "P014",
        title: "yield stress that cannot be used",
        text: "Rows of *PLASTIC give yield stress and plastic strain; the first strain is 0 and they ascend. With temperatures, rows of one temperature follow each other, and the temperatures ascend. Two rows make a line of kinematic hardening, at each temperature; it is not simulated with failure, for what damage leaves of the work against the back stress is not defined.",
    },
    Code {
        code: "P015",
        title: "not on deformable bodies yet",
        text: "Read, but not simulated on deformable bodies yet: the message says what, and what would be right.",
    },
    Code {
        code: "P016",
        title: "hourglass stiffness without shear modulus",
        text: "The hourglass spring is a fraction of the shear modulus, which a fluid lacks: HOURGLASS=VISCOUS, its default, controls it. Subzonal pressures in turn are of what has *EOS and no shear modulus.",
    },
    Code {
        code: "P017",
        title: "initial state that the material does not have",
        text: "An energy a mass is a state of materials with *EOS; their pressure follows from density and energy, so an initial stress would be lost.",
    },
    Code {
        code: "P018",
        title: "equation that cannot be kept",
        text: "An *EQUATION follows from others, contradicts them, or has no degree of freedom that could move to keep it, because all of them are given.",
    },
    Code {
        code: "P019",
        title: "failure that cannot be simulated",
        text: "Criteria over the plastic strain need *PLASTIC; d4 and d5 of *SHEAR FAILURE, TYPE=JOHNSON COOK take the reference rate and the temperatures from *RATE DEPENDENT and *PLASTIC; a cutoff of tension without deletion needs *EOS.",
    },
    Code {
        code: "P041",
        title: "user material beside another",
        text: "A *USER MATERIAL gives all of the stress: *ELASTIC and *PLASTIC of the same material would be read and ignored. Hand their values over as constants.",
    },
    Code {
        code: "P020",
        title: "spring or dashpot that cannot be",
        text: "A spring or dashpot element needs its property (*SPRING, *DASHPOT), ends on nodes of deformable elements (a rigid body can share them), and for SPRINGA and DASHPOTA ends that do not coincide.",
    },
    Code {
        code: "P021",
        title: "contact that cannot be",
        text: "A *CONTACT PAIR joins two surfaces of element faces, of which one at least deforms, or one with itself; or a surface of deformable nodes, all on one side, with an analytical surface of lines and arcs (*SURFACE, TYPE=SEGMENTS) of a *RIGID BODY, which may be held, moved by *BOUNDARY, or free. Nodes that follow others (*EQUATION, *MPC, *COUPLING, *TIE) cannot be in contact.",
    },
    Code {
        code: "P022",
        title: "mass scaling that cannot be",
        text: "Masses are scaled of deformable elements with *ELASTIC or a *USER MATERIAL. Where pressure follows from density or energy (*EOS) and of rubber the mass is part of the state; gravity on an element set takes masses once and would not follow. Nodes that a rigid body carries, and nodes of *EQUATION, *MPC, *COUPLING and *TIE, keep their mass.",
    },
    Code {
        code: "P023",
        title: "material that shells cannot have",
        text: "Shells are in plane stress: they take *ELASTIC, and *PLASTIC with isotropic hardening (tables, Johnson-Cook), rates and temperatures. Equations of state, rubber, kinematic hardening, failure and user materials are of solids.",
    },
    Code {
        code: "P050",
        title: "area weighting that cannot be",
        text: "WEIGHTING=AREA of *SECTION CONTROLS takes elastic materials that may flow and fail, none of the user, in all sections of the model, with linear bulk viscosity: without it some modes grow. Rigid bodies that share nodes and mass scaling work on rings and are refused.",
    },
    Code {
        code: "P060",
        title: "nodes that cannot follow",
        text: "*MPC, *COUPLING and *TIE let nodes of deformable bodies follow a node or a surface. A node of a rigid body follows that body already: move or load its REF NODE, or make it the one that is followed. None of the nodes of a slave surface that lies away from its master can be tied.",
    },
    Code {
        code: "P061",
        title: "nodes of a slave surface that are not tied",
        text: "*TIE ties nodes that lie within POSITION TOLERANCE of the master surface, by default 5 % of the mean length of its facets; the message names the others, with their distances.",
    },
    Code {
        code: "P062",
        title: "force on a node without mass",
        text: "A reference node has no mass of its own; what hangs on it takes the force. Along this degree of freedom nothing does.",
    },
    Code {
        code: "P070",
        title: "erosion that cannot be",
        text: "*EROSION deletes elements that come to its limits. PLASTIC STRAIN is of materials that flow, DISTORTION of solid elements, and at the start no element may be beyond a limit.",
    },
    Code {
        code: "P075",
        title: "history expression",
        text: "An *OUTPUT EXPRESSION is arithmetic over history columns that the deck asks for, `time` and expressions above it; the message says which name or sign is not understood.",
    },
    Code {
        code: "P076",
        title: "history column twice",
        text: "The name of an *OUTPUT EXPRESSION is that of another history column, or means something in expressions.",
    },
    Code {
        code: "P101",
        title: "held by axial symmetry already",
        text: "A rigid body of revolution moves along z only; holding r or rotation changes nothing.",
    },
    Code {
        code: "P065",
        title: "no element has temperatures",
        text: "*DYNAMIC TEMPERATURE-DISPLACEMENT solves for the temperatures of nodes of CAX4RT and CAX3T elements, and the deck has none that deforms.",
    },
    Code {
        code: "P066",
        title: "a section cannot conduct",
        text: "Elements with temperatures at their nodes need a material with *CONDUCTIVITY, *SPECIFIC HEAT and *DENSITY, and a section of their own; the temperature of an ideal gas is that of its energy.",
    },
    Code {
        code: "P063",
        title: "heat where nothing has a temperature",
        text: "A flux, a body flux or a film acts on nodes, faces or elements that have no temperature: CAX4RT and CAX3T have, in a step that solves for temperatures.",
    },
    Code {
        code: "P064",
        title: "expansion of rubber",
        text: "*EXPANSION is a strain taken off the strain that a bulk modulus answers to; rubber answers to the whole deformation.",
    },
    Code { code: "P102", title: "a load of zero", text: "Its magnitude is zero, so nothing is constructed for it." },
    Code {
        code: "P103",
        title: "prescribed value that cannot happen",
        text: "Radial motion or rotation of a rigid body would break axial symmetry.",
    },
    Code {
        code: "P104",
        title: "initial condition without effect",
        text: "It is given for nodes that do not move on their own; the velocity of a rigid body is that of its reference node.",
    },
    Code {
        code: "P105",
        title: "faster than sound",
        text: "An initial velocity is several times the speed of sound of the material. Units that do not fit are the usual reason: a density in kg/m3 in a deck of mm and MPa, a modulus in MPa in a deck of metres.",
    },
    Code {
        code: "P106",
        title: "given increment that is not stable",
        text: "With DIRECT USER CONTROL the increment is the user's; this one is longer than a wave needs to cross the smallest element.",
    },
    Code {
        code: "P109",
        title: "nothing acts",
        text: "What deforms has one velocity, and no boundary, load or contact acts on it.",
    },
    Code {
        code: "P110",
        title: "surface that faces away",
        text: "An analytical surface is met from its front only, which is to the left of the way from START on (each direction turned 90 degrees counter-clockwise). Where all nodes of the pair lie behind it, contact is taken on their side and this is said; where they lie on it and the body behind it, nothing will ever meet it, as in ABAQUS. Two surfaces of elements meet where facets have each other in front of them: of two sides that face the same way, or lie back to back, none has.",
    },
    Code {
        code: "P111",
        title: "nodes begin behind a surface",
        text: "By no more than a thousandth of the smaller of both surfaces, as chords of a mesh or digits of a deck make it: they are stopped where they are and not thrown back.",
    },
    Code {
        code: "P112",
        title: "bodies lie in each other",
        text: "Elements that have no node in common lie in each other at the start, and nothing acts between bodies that deform: they would move through each other. A twentieth of a face is taken for the chords of curved surfaces that fit.",
    },
    Code {
        code: "P113",
        title: "a step without end",
        text: "By the time that a wave needs to cross its smallest element the step has more than 1e12 updates of elements before it, which takes hours to days. A time in another unit than density and moduli, or a step meant for a static analysis, is the usual reason.",
    },
    Code {
        code: "P117",
        title: "a rigid body lighter than what it meets",
        text: "Masses are lumped at nodes. A free rigid body that weighs less than the nodes in front of it takes on their velocity when it hits them, and nearly all that it had is lost at once, whatever the increment: first order in the size of the elements.",
    },
    Code {
        code: "P119",
        title: "units of no solid",
        text: "Density and Young's modulus say how fast sound is. In none of the usual consistent systems (m, kg, s; mm, t, s; mm, kg, ms; mm, g, ms; mm, kg, s; cm, g, us; cm, g, s; in, lbf s2/in, s), or not in that of *UNITS, are both those of a solid: 20 m/s to 25 km/s, in what is denser than 3000 kg/m3 above 500 m/s. Nothing is said of a density of one digit near 1 without *UNITS: such decks have no units. A density in kg/m3 beside a modulus in MPa is the usual case.",
    },
    Code {
        code: "P118",
        title: "a rigid surface finer than what meets it",
        text: "What deforms meets a surface with gaps weighted over its faces. A rounding of a rigid surface within one face is seen as a corner, and late by up to a third of the face.",
    },
    Code {
        code: "P120",
        title: "nothing is in single precision",
        text: "`--precision single` is of solid elements with *ELASTIC, which may flow, heat and fail. What has an equation of state, rubber, foam, routines of the user, shells, HOURGLASS=ENHANCED and WEIGHTING=AREA stay in double precision, and rigid bodies have no other; beside elements in single precision the ledger lists those that stay.",
    },
    Code {
        code: "P130",
        title: "attitude of what is no body",
        text: "*ATTITUDE turns a rigid body: it names the REF NODE of a *RIGID BODY, and each body has one.",
    },
    Code {
        code: "P131",
        title: "oblique body without inertia",
        text: "A body whose impact is oblique turns, so that it needs moments of inertia about its axis and across it. They follow from solids with a density and from RAX2 elements with DENSITY and thickness; from *ROTARY INERTIA on an element of TYPE=ROTARYI; or from *ATTITUDE, INERTIA=UNIFORM, which spreads the mass evenly over what the meridian encloses. A mass on the reference node alone has none. About its axis no body has more than twice what it has across.",
    },
    Code {
        code: "P132",
        title: "what an oblique body cannot have",
        text: "A rigid body that is turned (*ATTITUDE), meets a tilted target (*TARGET, OBLIQUITY) or starts across its axis has six degrees of freedom. It takes the resistance of targets, pressures (P, PNU), gravity, *CLOAD, and hard contact with an analytical surface whose rigid body is held. Prescribed motions, other contact, body forces of a user routine, springs, equations and deformable elements on it are unsupported: deformable bodies are bodies of revolution, which a turned body would not leave them. A deformable body cannot meet a tilted target for the same reason.",
    },
    Code {
        code: "R201",
        title: "the user's routine failed",
        text: "It returned an error, ended the analysis (STOP, xplb_exit), or gave a value that is not a finite number. The message names what it was called for, step, increment and time; the last good state is in the last frame.",
    },
    Code {
        code: "R202",
        title: "resistance not finite",
        text: "The law of a layer gave a non-finite stress at the velocity named; check YIELD, density and A, B, C.",
    },
    Code {
        code: "R203",
        title: "motion not finite",
        text: "Acceleration or velocity of a body is not finite. The last good state is in the last frame.",
    },
    Code {
        code: "R204",
        title: "increment too small",
        text: "The increment no longer advances the clock. The last good state is in the last frame.",
    },
    Code {
        code: "R209",
        title: "an element collapsed",
        text: "An element is so small that the step would need more than 1e10 increments. The message names it; the last good state is in the last frame. DISTORTION CONTROL=YES on *SECTION CONTROLS, a coarser mesh there, or *SHEAR FAILURE help.",
    },
    Code {
        code: "R208",
        title: "an energy limit was passed",
        text: "The drift of ETOTAL is above 20 % of the largest energy for ten increments, or was at two of an analysis of less than 500, which halts every run whose deck gives no *ENERGY LIMIT, ERROR; or it, or the share of ALLAE in ALLIE, is above what *ENERGY LIMIT, ACTION=HALT allows. The message says since when, where the mesh is folded most, the likely cause and the card that cures it. The last good state is in the last frame.",
    },
    Code {
        code: "R205",
        title: "output could not be written",
        text: "A result file could not be written: the folder vanished, is read-only, or the disk is full. No file is half written. With a checkpoint `revolve run --resume` goes on once there is room.",
    },
    Code {
        code: "R207",
        title: "interrupted",
        text: "SIGINT (Ctrl-C) or SIGTERM ended the run behind the increment it was in. Its state is in `<job>.checkpoint`, from which `revolve run --resume` goes on to the same bits; the last frame, the histories and the summary are written, too. A signal that comes half a second later or more ends the program at once; one that comes sooner is the same one, as `timeout` and terminals send it twice.",
    },
    Code {
        code: "R206",
        title: "an element failed",
        text: "An element turned inside out, or its stress, velocity or volume is not a finite number. The message names it; the last frame is that of the last good instant (with routines of the user, which would be called twice on the way back to it, the last frame that was due). Where DIRECT USER CONTROL gives increments it says by how much they exceed the stable one. A finer mesh, a smaller SCALE FACTOR on *DYNAMIC or more hourglass control may help.",
    },
];
