//! Cards of adaptive meshes.

use super::card;
use crate::deck::keywords::Keyword;
use crate::deck::value::{COUNT, INTEGER, NOT_NEGATIVE, NUMBER, POSITIVE, TEXT, variant, word};

card!(AdaptiveMesh: "ADAPTIVE MESH", "Moves the nodes of a set of elements to better places during the step, and transports material through the mesh", (step), {
    "ELSET" (TEXT.required()) "Elements of the domain: CAX4R, CAX4RT, CAX3 and CAX3T of one section",
    "CONTROLS" read "Name of *ADAPTIVE MESH CONTROLS",
    frequency: Option<usize> = "FREQUENCY" (COUNT) "Increments between two changes of the mesh; default 10, or 1 with Eulerian boundaries or constraints in space",
    sweeps: usize = "MESH SWEEPS" (COUNT.to(1000.0).or(1.0)) "Sweeps in each change",
    initial_sweeps: usize = "INITIAL MESH SWEEPS" (INTEGER.from(0.0).to(1000.0).or(5.0)) "Sweeps at the start of the first step in which the domain is active",
    "OP" (word(&["MOD", "NEW"]).or(0.0)) "NEW ends all domains of earlier steps",
}, []);

card!(AdaptiveMeshControls: "ADAPTIVE MESH CONTROLS", "Smoothing and transport of adaptive meshes", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name of the controls",
    second_order: bool = "ADVECTION" (variant(&["FIRST ORDER", "SECOND ORDER"]).or(1.0)) "Order of the transport",
    transition_angle: f64 = "TRANSITION FEATURE ANGLE" (NUMBER.from(0.0).to(180.0).or(30.0)) "Angle in degrees between the edges of the boundary from which on a node is at a corner, and does not move along the boundary",
    "INITIAL FEATURE ANGLE" only ["30"] "corners are found by TRANSITION FEATURE ANGLE during the whole step",
    graded: bool = "SMOOTHING OBJECTIVE" (word(&["UNIFORM", "GRADED"]).or(0.0)) "UNIFORM: elements become equal; GRADED: the mesh keeps its grading at the start, and the weights have no effect",
    "CURVATURE REFINEMENT" only ["1", "0"] "meshes are smoothed towards equal elements, also at curved boundaries",
    previous: Option<bool> = "MESHING PREDICTOR" (word(&["CURRENT", "PREVIOUS"])) "Places from which sweeps start: those that the material has reached, or those after the previous change of the mesh (default with Eulerian boundaries)",
    "GEOMETRIC ENHANCEMENT" inert "a sweep never flattens the corner of an element, with YES and with NO",
    "MESH CONSTRAINT ANGLE" inert "at boundaries that material does not cross, a constraint in space moves nodes along the boundary only",
    "MOMENTUM ADVECTION" inert "momentum moves with the masses that pass between nodes, in all methods",
}, weights: [f64; 3] = [
    (lines ["weight of volume smoothing" (NOT_NEGATIVE.or(1.0)), "weight of Laplacian smoothing" (NOT_NEGATIVE.or(0.0)), "weight of equipotential smoothing" (NOT_NEGATIVE.or(0.0))]),
]);

card!(AdaptiveMeshConstraint: "ADAPTIVE MESH CONSTRAINT", "Motion of nodes of an adaptive mesh that is prescribed in space, or that of the material", (step), {
    in_space: bool = "CONSTRAINT TYPE" (word(&["LAGRANGIAN", "SPATIAL"]).or(1.0)) "SPATIAL: the motion of the mesh is prescribed; LAGRANGIAN: the nodes move with the material",
    "AMPLITUDE" read "Amplitude of the values. A displacement without amplitude is ignored: the nodes stay where they are",
    velocity: bool = "TYPE" (word(&["DISPLACEMENT", "VELOCITY"]).or(0.0)) "Quantity that is prescribed: the displacement of the mesh since the constraint began, or its velocity",
    "OP" (word(&["MOD", "NEW"]).or(0.0)) "NEW ends all constraints of earlier steps",
} refused {
    "applies only to implicit analyses": "USER", "UNCOUPLED";
}, [(rows ["node or set" read "Nodes of the domain; those of the boundary stay on the surface of the material, except at Eulerian boundaries", "first degree of freedom" read "1 is r, 2 is z", "last degree of freedom", "value"])]);

card!(Remesh: extension "REMESH", "Remeshes a body during the run whenever its elements become too distorted, and transports material to the new mesh", (), {
    "ELSET" read "All elements of the body: CAX4R and CAX3 of one section, without common nodes with other elements. Optional with AUTOMATIC=NO: all bodies",
    keeps_mesh: bool = "AUTOMATIC" (word(&["YES", "NO"]).or(0.0)) "NO: the body keeps its mesh, even if plastic flow squashes elements until the time increment collapses; without this card, such a body is remeshed from then on",
    angle: f64 = "ANGLE" (POSITIVE.below(60.0).or(15.0)) "Smallest angle of the elements in degrees below which the body is remeshed, unless the last mesh had a similar one",
    increment: f64 = "INCREMENT" (NUMBER.from(0.0).below(1.0).or(0.3)) "Fraction of the stable time increment after the last mesh below which the body is remeshed; 0 does not limit it",
    frequency: usize = "FREQUENCY" (COUNT.or(10.0)) "Increments between two checks of the mesh",
    thickness: f64 = "THICKNESS" (NUMBER.from(0.0).below(1.0).or(0.1)) "Fraction of the edge length of new elements: sheets and webs of the body that are thinner, and failed elements of *FAILED MATERIAL of less than half the density, are left out of a new mesh, and the body parts; their mass is reported (R321); 0 keeps them",
    size: Option<f64> = "SIZE" (POSITIVE) "Edge length of new elements; default: the square root of the area that the elements had at the start at the same material",
    curvature_angle: Option<f64> = "CURVATURE ANGLE" (POSITIVE.below(90.0)) "Largest angle in degrees that an edge of a curved outline spans; default: curvature has no effect",
    strain_change: Option<f64> = "STRAIN CHANGE" (POSITIVE) "Largest change of the equivalent plastic strain across an element, for materials with this strain; default: the strain has no effect",
    minimum_size: Option<f64> = "MINIMUM SIZE" (POSITIVE) "Smallest edge length by CURVATURE ANGLE and STRAIN CHANGE; default: a quarter of the size without them",
}, []);

/// Keywords of adaptive meshes.
pub const CARDS: &[Keyword] = &[AdaptiveMesh::ROW, AdaptiveMeshControls::ROW, AdaptiveMeshConstraint::ROW, Remesh::ROW];
