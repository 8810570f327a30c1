//! User subroutines: loads, motions and materials, in Rust, Fortran and C.

#[path = "../common/mod.rs"]
mod common;

#[path = "../../examples/own_eos.rs"]
mod own_eos;
#[path = "../../examples/own_load.rs"]
mod own_load;
#[path = "../../examples/own_material.rs"]
mod own_material;

mod built_in_twin;
mod cache;
mod compilers;
mod corotational;
mod created_energy;
mod deformable;
mod examples;
mod fibres;
mod fields;
mod foundation;
mod friction;
mod hardening;
mod in_the_wild;
mod isolate;
mod law;
mod limits;
mod load;
mod manners;
mod material;
mod memory;
mod nodal_fields;
mod six_nodes;
mod subroutines;
mod written;
