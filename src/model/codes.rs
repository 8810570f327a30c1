//! Diagnostic codes of the model room (`M…`) with their explanations.
//! Never here: the checks.

use crate::deck::Code;

const fn code(code: &'static str, title: &'static str, text: &'static str) -> Code {
    Code { code, title, text }
}

/// All codes of this room.
pub const CODES: &[Code] = &[
    code("M101", "a needed parameter is missing", "The keyword line needs this parameter."),
    code("M102", "a needed value is missing", "The data line has fewer fields than the card needs."),
    code("M103", "value out of range", "The value cannot be what the card asks for; the message says why."),
    code("M104", "option not supported", "The card asks for a variant that is known and not simulated."),
    code(
        "M105",
        "card out of place",
        "Blocks open and close: *PART … *END PART, *STEP … *END STEP. The card stands outside the block it belongs to.",
    ),
    code("M107", "card without data", "The card needs at least one data line."),
    code(
        "M110",
        "unknown set, node or element",
        "Nothing has this name or label. Inside parts names are as written; from outside write INSTANCE.NAME.",
    ),
    code("M111", "unknown material", "No *MATERIAL has this name."),
    code("M112", "unknown amplitude", "No *AMPLITUDE has this name."),
    code("M113", "unknown target", "No *TARGET has this name."),
    code("M114", "unknown surface", "No *SURFACE has this name."),
    code("M115", "unknown part", "No *PART has this name."),
    code("M116", "unknown section controls", "No *SECTION CONTROLS has this name."),
    code("M117", "unknown time points", "No *TIME POINTS has this name."),
    code("M120", "unknown element type", "No element type of ABAQUS has this name."),
    code(
        "M121",
        "element type not supported",
        "The type is known, but this code is axisymmetric and supports RAX2, SAX1, CAX3, CAX4R, MASS, SPRINGA, SPRING1, DASHPOTA and DASHPOT1.",
    ),
    code(
        "M122",
        "element with a missing node",
        "The element refers to a node that is not defined (nodes must come before their elements).",
    ),
    code(
        "M123",
        "degenerate element",
        "Its nodes coincide, it has no area, it runs clockwise, it is concave, or it reaches across the axis.",
    ),
    code("M124", "label used twice", "Two elements have the same label."),
    code(
        "M125",
        "too many",
        "All cards together may ask for 20 million nodes, 20 million elements, and 20 million places in sets and lists with 40 more for each node and element; and for no more memory than the machine has. The card named is the one with which that is too much; nothing has been made of it.",
    ),
    code("M126", "node off the plane or beyond the axis", "An axisymmetric model lies in the r-z plane with r >= 0."),
    code("M130", "side of a surface is missing", "RAX2 and SAX1 elements have two sides: write SPOS or SNEG."),
    code("M131", "no such side", "RAX2 and SAX1 have SPOS and SNEG, solids have S1 to S3 or S4."),
    code("M132", "unknown load", "The load label is not one of those that this code knows."),
    code(
        "M140",
        "displacement ignored",
        "As in ABAQUS/Explicit, a displacement without AMPLITUDE would be a jump; its value is ignored and the motion is held.",
    ),
    code(
        "M141",
        "unknown output variable",
        "No output variable that Revolve knows has this name; it is left out. `revolve explain variables` lists those there are.",
    ),
    code(
        "M142",
        "time marks",
        "Frames are written at the first increment at or past the mark; looking does not change the increments.",
    ),
    code(
        "M143",
        "arrays of a mesh file not read",
        "Sets are arrays named NSET_name (points) or ELSET_name (cells), not zero on members; labels are NODE_LABEL and ELEMENT_LABEL.",
    ),
    code(
        "M144",
        "loads that add",
        "Two lines of one step give a load of the same kind at the same place: they add. A load of an earlier step is replaced instead.",
    ),
    code(
        "M145",
        "boundary given twice",
        "Two lines of one step say different things of a degree of freedom of a node: the later acts.",
    ),
    code(
        "M146",
        "jump in a displacement",
        "A prescribed displacement does not begin where its nodes are. As in ABAQUS/Explicit no displacement jumps: the motion goes on from where they are, by the changes of the amplitude.",
    ),
    code(
        "M147",
        "displacement after another motion",
        "The nodes were free or followed a velocity before, so a displacement cannot be compared with where they are; it counts from there.",
    ),
    code(
        "M148",
        "output ends",
        "The first *OUTPUT of a step with OP=NEW, which is the default, ends all output requests of earlier steps, fields and histories.",
    ),
    code(
        "M149",
        "degree of freedom that nodes do not have",
        "Nodes of an axisymmetric body move along r (1) and z (2); the reference node of a rigid body turns as well (6), which symmetry holds. A condition on another one holds, moves or loads nothing.",
    ),
    code(
        "M153",
        "position of element output",
        "Elements have one integration point, in their middle. With POSITION=NODES or AVERAGED AT NODES frames show variables of integration points on nodes, as the mean over the elements around that are not deleted; variables of whole elements (STATUS, EVOL) and histories stay with elements.",
    ),
    code("M152", "gravity along r", "A body of revolution has no weight along r; only the part of GRAV along z acts."),
    code(
        "M160",
        "given twice",
        "A card that may be given once in its place (in a material, in a step, in the deck), or once for each name, is given again. Which of the two is meant cannot be known.",
    ),
    code(
        "M161",
        "too many values on a data line",
        "The line holds more values than the card reads. A comma in place of a decimal point makes two values of one; tables take one row a line.",
    ),
    code("M162", "too many data lines", "The card takes fewer data lines than stand below it."),
    code(
        "M163",
        "decimal comma suspected",
        "A value that changes nothing stands close behind a comma after a whole number, as the decimals of a number would.",
    ),
    code("M164", "node defined again", "A node is given more than once; as in ABAQUS the last place counts."),
    code("M165", "two properties on an element", "An element has one section, one mass, one spring or dashpot."),
    code(
        "M166",
        "set that is not whole",
        "Some of the labels that GENERATE counts are not defined, or the last one is not reached in the increments given; the set holds those that are there.",
    ),
    code(
        "M168",
        "element set in place of a node set",
        "The card asks for nodes and is given an element set: the nodes of its elements are taken.",
    ),
    code(
        "M169",
        "energy of an explosive",
        "The detonation energy of *EOS, TYPE=JWL is an energy a mass; one above the square of the detonation wave speed is likely \
         an energy a volume, which the density divides.",
    ),
    code(
        "M170",
        "arc that does not close",
        "The ends of an arc are not equally far from its centre. Up to a millionth of the radius this is rounding; up to a hundredth the nearest centre is taken that they are equally far from, with a warning; beyond, the arc is refused.",
    ),
    code(
        "M171",
        "history expression without a name",
        "A line of *OUTPUT EXPRESSION is `name = expression`; the name has letters, digits and `_`.",
    ),
    code(
        "M181",
        "free surface without stiffness",
        "How much a free surface weakens a target follows from 2E/3Y: E of *ELASTIC, Y of *CAVITY EXPANSION, above 1.",
    ),
    code(
        "M185",
        "resistance without strain rates",
        "A strain rate needs a length: the radius of the cavity. Without RADIUS on *CAVITY EXPANSION, DERIVE the constants are those of slow straining, below what *RATE DEPENDENT gives.",
    ),
    code("M180", "section of other elements", "*SOLID SECTION is of CAX3 and CAX4R, *SHELL SECTION of SAX1."),
    code(
        "M150",
        "mesh file cannot be read",
        "The file is missing, damaged, or in a form that is not read; the message says how to save it again.",
    ),
];
