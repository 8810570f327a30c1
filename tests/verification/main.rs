//! Verification: answers of the solver against answers from outside the code. One file a subject; the rows of
//! `docs/verification.md` name them.

#[path = "../common/mod.rs"]
mod common;

mod alike;
mod area;
mod bars;
mod cavities;
mod conduction;
mod contact;
mod contact_analytical;
mod contact_cards;
mod contact_curved;
mod contact_friction;
mod contact_heat;
mod contact_hertz;
mod contact_scenes;
mod deformable;
mod element_output;
mod erosion;
mod erosion_criteria;
mod erosion_loads;
mod erosion_rod;
mod fidelity;
mod finite_targets;
mod hourglass;
mod large_motion;
mod links;
mod loads;
mod mass_scaling;
mod materials;
mod oblique;
mod over_temperature;
mod precision;
mod properties;
mod rates;
mod reference_nodes;
mod resistance;
mod rigid;
mod rigid_wall;
mod rings;
mod scene;
mod shells;
mod shock;
mod shock_meshes;
mod soft;
mod solid;
mod steps;
mod surfaces;
mod taylor;
mod thermal_stress;
mod triangles;
mod tubes;
mod vessels;
mod walls;
mod waves;
