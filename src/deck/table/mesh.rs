//! Cards of the mesh: nodes, elements, sets, surfaces, parts and instances, and those of the text itself.
//! Never here: what the mesh is made of.

use super::row;
use crate::deck::keywords::Keyword;
use crate::deck::value::{COUNT, INTEGER, NUMBER, POSITIVE, Value, ZERO, variant, word};

/// A number that must be there.
const GIVEN: Value = NUMBER.required();
/// A number of elements, rows or layers.
const ONE: Value = COUNT.or(1.0);
/// An increment of labels.
const STEP: Value = INTEGER.or(1.0);

/// The rows.
pub const CARDS: &[Keyword] = &[
    row!("HEADING", "Title of the analysis", (), {}, [(text "title" read "Any number of lines")]),
    row!(extension "UNITS", "Names the units in reports, pictures and tables; nothing is converted", (once), {}, [
        (lines ["length" read "As m, mm or cm", "mass" read "As kg, t or g", "time" read "As s, ms or us", "temperature" read "K if not given"]),
    ]),
    row!("INCLUDE", "Reads another file in place of this line", (), {
        "INPUT" read "File, relative to the file that includes it",
        "PASSWORD" refused "encrypted input cannot be read",
    }, []),
    row!("PARAMETER", "Defines parameters for use as <name>", (), {
        "INDEPENDENT" refused "parameter studies are made with `revolve sweep`",
    } refused {
        "define parameters as `name = expression`": "DEPENDENT", "TABLE";
    }, [(text "name = expression" read "Names are case-sensitive; + - * / // % **, functions, text in quotes, # comments; / is true division")]),
    row!("NODE", "Defines nodes; of a node given more than once the last place counts, with a warning", (), {
        "NSET" read "Node set to put them in",
        "INPUT" read "File with the data lines",
        "SYSTEM" read "R (default), or C for a radius and an angle in degrees in the r-z plane",
        "INTERNAL" inert "written by CAE; no meaning",
        "UNSORTED" refused "give *NSET, UNSORTED",
    }, [(rows [
        "node number", "r", "z",
        "third coordinate" only ["0"] "an axisymmetric model lies in the r-z plane",
        "first cosine" refused "normals of shells are those of their elements",
        "second cosine" refused "normals of shells are those of their elements",
        "third cosine" refused "normals of shells are those of their elements",
    ])]),
    row!("NGEN", "Generates nodes between two nodes", (), {
        "NSET" read "Node set to put them in",
        "LINE" read "C for a circular arc; absent for a straight line",
        "SYSTEM" only ["RC"] "the centre is given as r and z",
    }, [
        (when "LINE" = "C" rows [
            "first node", "last node", "increment", "centre node", "r of the centre", "z of the centre",
            "third coordinate of the centre" only ["0"] "an axisymmetric model lies in the r-z plane",
            "r of the normal" only ["0"] "the arc lies in the r-z plane",
            "z of the normal" only ["0"] "the arc lies in the r-z plane",
            "normal" read "Above zero the arc runs counter-clockwise from the first node, below zero clockwise; the shorter way without it",
        ]),
        (rows ["first node", "last node", "increment"]),
    ]),
    row!("NFILL", "Fills the space between two lines of nodes with nodes", (), {
        "NSET" read "Node set to put them in",
        "BIAS" (POSITIVE.or(1.0)) "Length of each interval over that of the next",
        "SINGULAR" (INTEGER.from(0.0).to(2.0)) "1 or 2: the node next to the first or second line stands at a quarter of its two intervals",
        "TWO STEP" read "BIAS holds between pairs of intervals; the two of a pair are equally long",
    }, [(rows ["first set", "second set", "number of intervals", "increment"])]),
    row!("NCOPY", "Copies nodes to other numbers and places", (), {
        "OLD SET" read "Nodes to copy",
        "CHANGE NUMBER" read "Added to their numbers",
        "NEW SET" read "Node set to put the copies in",
        "SHIFT" read "Data lines move, then turn them, as those of *INSTANCE do; without data lines they stay",
        "REFLECT" (word(&["POINT", "LINE", "MIRROR"])) "The data lines give points of it",
        "MULTIPLE" only ["1"] "give a *NCOPY for each turn",
        "POLE" refused "of infinite elements",
    }, [
        (when "SHIFT" = "" lines
            ["translation along r" (ZERO), "translation along z" (ZERO), "third translation" only ["0"] "an axisymmetric model lies in the r-z plane"]
            ["r of the first point" (GIVEN), "z of the first point" (GIVEN), "third coordinate of the first point" (GIVEN),
             "r of the second point" (GIVEN), "z of the second point" (GIVEN), "third coordinate of the second point" (GIVEN),
             "angle in degrees" (GIVEN)]),
        (lines
            ["r of a", "z of a", "third coordinate of a", "r of b", "z of b", "third coordinate of b"]
            ["r of c", "z of c", "third coordinate of c"]),
    ]),
    row!("NMAP", "Takes the coordinates of nodes as those of a local system", (), {
        "NSET" read "Nodes",
        "TYPE" (variant(&["RECTANGULAR", "CYLINDRICAL"]).required()) "CYLINDRICAL about an axis that stands on the r-z plane (radius, angle in degrees)",
        "DEFINITION" only ["COORDINATES"] "give coordinates",
    }, [(lines
        ["r of a", "z of a", "third coordinate of a", "r of b", "z of b", "third coordinate of b"]
        ["r of c", "z of c", "third coordinate of c"]
        ["scale of the first coordinate", "scale of the second coordinate",
         "scale of the third coordinate" inert "an axisymmetric model lies in the r-z plane"])]),
    row!("SYSTEM", "Local system of the *NODE cards that follow; without data lines r and z again", (), {}, [(lines
        ["r of a", "z of a", "third coordinate of a" only ["0"] "an axisymmetric model lies in the r-z plane",
         "r of b", "z of b", "third coordinate of b" only ["0"] "an axisymmetric model lies in the r-z plane"]
        ["r of c", "z of c", "third coordinate of c" only ["0"] "an axisymmetric model lies in the r-z plane"])]),
    row!("TRANSFORM", "Turned directions at nodes; refused where a condition or a force is given in others than r and z", (), {
        "NSET" read "Nodes",
        "TYPE" read "R (default); C and S are others than r and z",
        "DEFINITION" only ["COORDINATES"] "give coordinates",
    }, [(lines
        ["r of a", "z of a", "third coordinate of a", "r of b", "z of b", "third coordinate of b"])]),
    row!("ELEMENT", "Defines elements", (), {
        "TYPE" read "RAX2, SAX1, CAX3, CAX4R, CAX6M, CAX3T, CAX4RT, MASS, SPRINGA, SPRING1, DASHPOTA, DASHPOT1",
        "ELSET" read "Element set to put them in",
        "INPUT" read "File with the data lines",
        "OFFSET" refused "it numbers the further nodes of CAXA and SAXA elements",
        "FILE" refused "files of another job are not read",
        "INTERNAL" inert "written by CAE; no meaning",
        "SOLID ELEMENT NUMBERING" refused "it is of gasket elements",
    }, [
        (when "TYPE" = "CAX4R" wrapped 5 ["element number", "node"]),
        (when "TYPE" = "CAX3" wrapped 4 ["element number", "node"]),
        (when "TYPE" = "CAX6M" wrapped 7 ["element number", "node"]),
        (when "TYPE" = "CAX4RT" wrapped 5 ["element number", "node"]),
        (when "TYPE" = "CAX3T" wrapped 4 ["element number", "node"]),
        (when "TYPE" = "RAX2" wrapped 3 ["element number", "node"]),
        (when "TYPE" = "SAX1" wrapped 3 ["element number", "node"]),
        (when "TYPE" = "SPRINGA" wrapped 3 ["element number", "node"]),
        (when "TYPE" = "DASHPOTA" wrapped 3 ["element number", "node"]),
        (when "TYPE" = "MASS" wrapped 2 ["element number", "node"]),
        (when "TYPE" = "SPRING1" wrapped 2 ["element number", "node"]),
        (when "TYPE" = "DASHPOT1" wrapped 2 ["element number", "node"]),
        (stream ["element number"]),
    ]),
    row!("ELGEN", "Generates elements from a master element", (), {
        "ELSET" read "Element set to put them in",
        "ALL NODES" inert "the numbers of all nodes are incremented anyway: the elements here have none that is left out",
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
        "NEW SET" read "Element set to put the copies in",
        "REFLECT" read "The nodes run the other way round, for copies of reflected nodes",
    }, []),
    row!("NSET", "Defines or extends a node set", (), {
        "NSET" read "Name of the set",
        "GENERATE" read "Data lines give first, last and increment",
        "INSTANCE" read "Instance whose nodes are meant",
        "ELSET" read "All nodes of these elements",
        "INTERNAL" inert "written by CAE; no meaning",
        "UNSORTED" read "*NFILL and *EQUATION take the nodes in the order given",
    }, [
        (when "GENERATE" = "" rows ["first node", "last node", "increment"]),
        (list "node or set"),
    ]),
    row!("ELSET", "Defines or extends an element set", (), {
        "ELSET" read "Name of the set",
        "GENERATE" read "Data lines give first, last and increment",
        "INSTANCE" read "Instance whose elements are meant",
        "INTERNAL" inert "written by CAE; no meaning",
        "UNSORTED" inert "no card here takes elements in the order of a set",
    }, [
        (when "GENERATE" = "" rows ["first element", "last element", "increment"]),
        (list "element or set"),
    ]),
    row!("SURFACE", "Defines a surface. A line with elements and no side means all of them that lies bare: contact, pressures, the user's pressures, CAVITY, fluxes and films go over to what comes to lie bare of these elements as others are deleted. A load on a side that is named ends with its element", (unique "NAME"), {
        "NAME" read "Name of the surface",
        "TYPE" read "ELEMENT (default), NODE, or SEGMENTS for lines and arcs",
        "INTERNAL" inert "written by CAE; no meaning",
        "DEFINITION" refused "coordinates on analytical surfaces are r and z",
        "FILLET RADIUS" read "Rounds the corners between segments",
        "NO OFFSET" inert "of shells",
        "NO THICK" inert "of shells",
        "REGION TYPE" refused "meshes are not adaptive",
        "TRIM" refused "surfaces are not trimmed: give their faces",
        "DISCRETIZATION" inert "written by some preprocessors; no meaning",
    } refused {
        "give the faces of the surface": "COMBINE", "CROP";
        "of the contact of shells": "MAX RATIO", "PROPERTY", "SCALE THICK";
    }, [
        (when "TYPE" = "NODE" rows ["node or set", "area" inert "areas serve contact stresses, which nothing here computes"]),
        (when "TYPE" = "SEGMENTS" rows ["segment" read "START, then LINE or CIRCL; the front is to the left of the way along them",
            "r", "z", "r of the centre" read "Of CIRCL", "z of the centre" read "Of CIRCL"]),
        (rows ["element or set", "face" read "S1 ... S4, SPOS, SNEG; the free faces of solids without it"]),
    ]),
    row!("RIGID SURFACE", "An analytical rigid surface of an older form, with its reference node", (), {
        "NAME" read "Name of the surface",
        "ELSET" read "Name of the surface, where NAME is not given",
        "TYPE" only ["SEGMENTS"] "surfaces of revolution lie in the r-z plane",
        "REF NODE" read "Reference node or a set of one; with it this is a rigid body",
        "FILLET RADIUS" read "Rounds the corners between segments",
    }, [(rows ["segment" read "START, then LINE or CIRCL; the front is to the left of the way along them",
        "r", "z", "r of the centre" read "Of CIRCL", "z of the centre" read "Of CIRCL"])]),
    row!("PART", "Begins a part", (unique "NAME"), {
        "NAME" read "Name of the part",
        "INTERNAL" inert "written by CAE; no meaning",
    }, []),
    row!("END PART", "Ends a part", (), {}, []),
    row!("ASSEMBLY", "Begins the assembly", (once), { "NAME" inert "nothing refers to it" }, []),
    row!("END ASSEMBLY", "Ends the assembly", (), {}, []),
    row!("INSTANCE", "Places a part in the assembly", (unique "NAME"), {
        "NAME" read "Name of the instance",
        "PART" read "Part to place",
        "INTERNAL" inert "written by CAE; no meaning",
    } refused {
        "states of another job are not imported": "LIBRARY", "INSTANCE";
    }, [(lines
        ["translation along r" (ZERO), "translation along z" (ZERO), "third translation" only ["0"] "an axisymmetric model lies in the r-z plane"]
        ["r of the first point" (GIVEN), "z of the first point" (GIVEN), "third coordinate of the first point" (GIVEN),
         "r of the second point" (GIVEN), "z of the second point" (GIVEN), "third coordinate of the second point" (GIVEN),
         "angle in degrees" (GIVEN)])]),
    row!("END INSTANCE", "Ends an instance", (), {}, []),
    row!(extension "MESH", "Reads nodes and elements from a mesh file: of VTK, of Gmsh (.msh) or a deck's mesh (.inp)", (), {
        "INPUT" read "File, relative to the deck",
        "TYPE" read "Element type to make of its cells",
    }, []),
];
