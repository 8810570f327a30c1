//! Cards of the mesh: nodes, elements, sets, surfaces, parts and instances; also title, units, includes and parameters.

use super::row;
use crate::deck::keywords::Keyword;
use crate::deck::value::{COUNT, FLAG, INTEGER, NUMBER, POSITIVE, ValueSpec, ZERO, variant, word};

/// A mandatory number.
const GIVEN: ValueSpec = NUMBER.required();
/// Number of elements, rows or layers; 1 by default.
const ONE: ValueSpec = COUNT.or(1.0);
/// Increment of node or element numbers; 1 by default.
const STEP: ValueSpec = INTEGER.or(1.0);

/// Keywords of the mesh, sets and surfaces, and of title, units, includes and parameters.
pub const CARDS: &[Keyword] = &[
    row!("HEADING", "Title of the analysis", (), {}, [(text "title" read "Any number of lines")]),
    row!(extension "UNITS", "Units shown in reports, pictures and tables; values are not converted", (once), {}, [
        (lines ["length" read "For example m, mm or cm", "mass" read "For example kg, t or g", "time" read "For example s, ms or us", "temperature" read "Default: K"]),
    ]),
    row!("INCLUDE", "Reads another file at this place", (), {
        "INPUT" read "File, relative to the folder of the including file",
        "PASSWORD" refused "encrypted input cannot be read",
    }, []),
    row!("PARAMETER", "Defines parameters for use as <name>", (), {
        "INDEPENDENT" refused "use `revolve sweep` for parameter studies",
    } refused {
        "define parameters as `name = expression`": "DEPENDENT", "TABLE";
    }, [(text "name = expression" read "Names are case-sensitive; + - * / // % **, functions, text in quotes, # comments; / is true division")]),
    row!("NODE", "Defines nodes; if a node is defined more than once, the last coordinates are used, with a warning", (), {
        "NSET" read "Node set to which they are added",
        "INPUT" read "File with the data lines",
        "SYSTEM" (variant(&["R", "C"]).or(0.0)) "R (default), or C for a radius and an angle in degrees in the r-z plane",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
        "UNSORTED" refused "give *NSET, UNSORTED",
    }, [(rows [
        "node number", "r", "z",
        "third coordinate" only ["0"] "an axisymmetric model is in the r-z plane",
        "first cosine" refused "shell normals are computed from the elements",
        "second cosine" refused "shell normals are computed from the elements",
        "third cosine" refused "shell normals are computed from the elements",
    ])]),
    row!("NGEN", "Generates nodes between two nodes", (), {
        "NSET" read "Node set to which they are added",
        "LINE" read "C for a circular arc; default: straight line",
        "SYSTEM" only ["RC"] "the centre is given as r and z",
    }, [
        (when "LINE" = "C" rows [
            "first node", "last node", "increment", "centre node", "r of the centre", "z of the centre",
            "third coordinate of the centre" only ["0"] "an axisymmetric model is in the r-z plane",
            "r of the normal" only ["0"] "the arc is in the r-z plane",
            "z of the normal" only ["0"] "the arc is in the r-z plane",
            "normal" read "Positive: counter-clockwise from the first node; negative: clockwise; default: the shorter arc",
        ]),
        (rows ["first node", "last node", "increment"]),
    ]),
    row!("NFILL", "Fills the space between two lines of nodes with nodes", (), {
        "NSET" read "Node set to which they are added",
        "BIAS" (POSITIVE.or(1.0)) "Ratio of the lengths of consecutive intervals",
        "SINGULAR" (INTEGER.from(0.0).to(2.0)) "1 or 2: nodes next to the first or second line are moved to the quarter points",
        "TWO STEP" (FLAG) "BIAS applies to pairs of intervals of equal length",
    }, [(rows ["first set", "second set", "number of intervals", "increment"])]),
    row!("NCOPY", "Copies nodes with new numbers and coordinates", (), {
        "OLD SET" read "Nodes to copy",
        "CHANGE NUMBER" read "Added to their numbers",
        "NEW SET" read "Node set of the copies",
        "SHIFT" (FLAG) "The data lines give a translation and then a rotation, as for *INSTANCE",
        "REFLECT" (word(&["POINT", "LINE", "MIRROR"])) "The data lines give points of the reflection centre, line or plane",
        "MULTIPLE" only ["1"] "give one *NCOPY per copy",
        "POLE" refused "applies only to infinite elements",
    }, [
        (when "SHIFT" lines
            ["translation along r" (ZERO), "translation along z" (ZERO), "third translation" only ["0"] "an axisymmetric model is in the r-z plane"]
            ["r of the first point" (GIVEN), "z of the first point" (GIVEN), "third coordinate of the first point" (GIVEN),
             "r of the second point" (GIVEN), "z of the second point" (GIVEN), "third coordinate of the second point" (GIVEN),
             "angle in degrees" (GIVEN)]),
        (lines
            ["r of a", "z of a", "third coordinate of a", "r of b", "z of b", "third coordinate of b"]
            ["r of c", "z of c", "third coordinate of c"]),
    ]),
    row!("NMAP", "Interprets the coordinates of nodes in a local system", (), {
        "NSET" read "Nodes",
        "TYPE" (variant(&["RECTANGULAR", "CYLINDRICAL"]).required()) "CYLINDRICAL: radius and angle in degrees about an axis normal to the r-z plane",
        "DEFINITION" only ["COORDINATES"] "give coordinates",
    }, [(lines
        ["r of a", "z of a", "third coordinate of a", "r of b", "z of b", "third coordinate of b"]
        ["r of c", "z of c", "third coordinate of c"]
        ["scale of the first coordinate", "scale of the second coordinate",
         "scale of the third coordinate" inert "an axisymmetric model is in the r-z plane"])]),
    row!("SYSTEM", "Local system of the following *NODE cards; without data lines the global system", (), {}, [(lines
        ["r of a", "z of a", "third coordinate of a" only ["0"] "an axisymmetric model is in the r-z plane",
         "r of b", "z of b", "third coordinate of b" only ["0"] "an axisymmetric model is in the r-z plane"]
        ["r of c", "z of c", "third coordinate of c" only ["0"] "an axisymmetric model is in the r-z plane"])]),
    row!("TRANSFORM", "Local directions at nodes; an error if a condition or force is given in directions other than r and z", (), {
        "NSET" read "Nodes",
        "TYPE" read "R (default), C or S",
        "DEFINITION" only ["COORDINATES"] "give coordinates",
    }, [(lines
        ["r of a", "z of a", "third coordinate of a", "r of b", "z of b", "third coordinate of b"])]),
    row!("ELEMENT", "Defines elements", (), {
        "TYPE" read "RAX2, SAX1, CAX3, CAX4R, CAX6M, CAX3T, CAX4RT, COHAX4, MASS, SPRINGA, SPRING1, DASHPOTA, DASHPOT1, CINAX4",
        "ELSET" read "Element set to which they are added",
        "INPUT" read "File with the data lines",
        "OFFSET" refused "give all nodes of each element",
        "FILE" refused "files of another job cannot be read",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
        "SOLID ELEMENT NUMBERING" refused "gasket elements are unsupported",
    }, [
        (when "TYPE" = "CAX4R" | "CAX4RT" | "COHAX4" wrapped 5 ["element number", "node"]),
        (when "TYPE" = "CAX3" | "CAX3T" wrapped 4 ["element number", "node"]),
        (when "TYPE" = "CAX6M" wrapped 7 ["element number", "node"]),
        (when "TYPE" = "RAX2" | "SAX1" | "SPRINGA" | "DASHPOTA" wrapped 3 ["element number", "node"]),
        (when "TYPE" = "MASS" | "SPRING1" | "DASHPOT1" wrapped 2 ["element number", "node"]),
        (stream ["element number"]),
    ]),
    row!("ELGEN", "Generates elements from a master element", (), {
        "ELSET" read "Element set to which they are added",
        "ALL NODES" inert "all node numbers are always incremented",
    }, [(rows [
        "master element" (INTEGER.required()),
        "elements in a row" (ONE), "node increment" (STEP), "element increment" (STEP),
        "rows" (ONE), "node increment of rows" (STEP), "element increment of rows" (STEP),
        "layers" (ONE), "node increment of layers" (STEP), "element increment of layers" (STEP),
    ])]),
    row!("ELCOPY", "Copies elements to other numbers and nodes", (), {
        "OLD SET" read "Elements to copy",
        "ELEMENT SHIFT" read "Added to their numbers",
        "SHIFT NODES" read "Added to the numbers of their nodes",
        "NEW SET" read "Element set of the copies",
        "REFLECT" (FLAG) "Reverses the order of the nodes, for reflected nodes",
    }, []),
    row!("NSET", "Defines or extends a node set", (), {
        "NSET" read "Name of the set",
        "GENERATE" (FLAG) "Data lines give first, last and increment",
        "INSTANCE" read "Instance of the nodes",
        "ELSET" read "All nodes of these elements",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
        "UNSORTED" (FLAG) "Keeps the given order of nodes, for *NFILL and *EQUATION",
    }, [
        (when "GENERATE" rows ["first node", "last node", "increment"]),
        (list "node or set"),
    ]),
    row!("ELSET", "Defines or extends an element set", (), {
        "ELSET" read "Name of the set",
        "GENERATE" (FLAG) "Data lines give first, last and increment",
        "INSTANCE" read "Instance of the elements",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
        "UNSORTED" inert "no supported card depends on the order of elements",
    }, [
        (when "GENERATE" rows ["first element", "last element", "increment"]),
        (list "element or set"),
    ]),
    row!("SURFACE", "Defines a surface. A line with elements and no side means all exposed faces of these elements; as elements are deleted, contact and loads (pressures, user-defined pressures, CAVITY, fluxes, films) transfer to the newly exposed faces. A load on a named side ends when its element is deleted", (unique "NAME"), {
        "NAME" read "Name of the surface",
        "TYPE" read "ELEMENT (default), NODE, or SEGMENTS for lines and arcs",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
        "DEFINITION" refused "analytical surfaces are defined in r and z",
        "FILLET RADIUS" read "Rounds the corners between segments",
        "NO OFFSET" inert "applies only to shells",
        "NO THICK" inert "applies only to shells",
        "REGION TYPE" (word(&["LAGRANGIAN", "SLIDING", "EULERIAN"]).or(1.0)) "On the boundary of an adaptive mesh: the ends of the surface move with the material, slide along it, or material flows through the surface",
        "TRIM" refused "surfaces are not trimmed: give the faces",
        "DISCRETIZATION" inert "written by some preprocessors; has no effect",
        "COMBINE" only ["UNION"] "give the faces of the surface",
    } refused {
        "give the faces of the surface": "CROP";
        "applies only to shell contact": "MAX RATIO", "PROPERTY", "SCALE THICK";
    }, [
        (when "COMBINE" list "surface" read "Element surface; the new surface has the faces of all"),
        (when "TYPE" = "NODE" rows ["node or set", "area" inert "areas are used only for contact stresses of nodes, which are not computed"]),
        (when "TYPE" = "SEGMENTS" rows ["segment" read "START, then LINE or CIRCL; the outward normal is to the left of the direction from START",
            "r", "z", "r of the centre" read "For CIRCL", "z of the centre" read "For CIRCL"]),
        (rows ["element or set", "face" read "S1 ... S4, SPOS, SNEG; default: the exposed faces of solids"]),
    ]),
    row!("RIGID SURFACE", "Analytical rigid surface (older form), with its reference node", (), {
        "NAME" read "Name of the surface",
        "ELSET" read "Name of the surface if NAME is not given",
        "TYPE" only ["SEGMENTS"] "surfaces of revolution are defined in the r-z plane",
        "REF NODE" read "Reference node, or a set of one node; makes the surface a rigid body",
        "FILLET RADIUS" read "Rounds the corners between segments",
    }, [(rows ["segment" read "START, then LINE or CIRCL; the outward normal is to the left of the direction from START",
        "r", "z", "r of the centre" read "For CIRCL", "z of the centre" read "For CIRCL"])]),
    row!("PART", "Begins a part", (unique "NAME"), {
        "NAME" read "Name of the part",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
    }, []),
    row!("END PART", "Ends a part", (), {}, []),
    row!("ASSEMBLY", "Begins the assembly", (once), { "NAME" inert "no card refers to it" }, []),
    row!("END ASSEMBLY", "Ends the assembly", (), {}, []),
    row!("INSTANCE", "Places a part in the assembly", (unique "NAME"), {
        "NAME" read "Name of the instance",
        "PART" read "Part to place",
        "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
    } refused {
        "states of another job cannot be imported": "LIBRARY", "INSTANCE";
    }, [(lines
        ["translation along r" (ZERO), "translation along z" (ZERO), "third translation" only ["0"] "an axisymmetric model is in the r-z plane"]
        ["r of the first point" (GIVEN), "z of the first point" (GIVEN), "third coordinate of the first point" (GIVEN),
         "r of the second point" (GIVEN), "z of the second point" (GIVEN), "third coordinate of the second point" (GIVEN),
         "angle in degrees" (GIVEN)])]),
    row!("END INSTANCE", "Ends an instance", (), {}, []),
    row!(extension "MESH", "Reads nodes and elements from a mesh file: VTK, Gmsh (.msh) or the mesh of a deck (.inp)", (), {
        "INPUT" read "File, relative to the deck",
        "TYPE" read "Element type of the cells",
    }, []),
];
