//! Arithmetic without state: element operators, shells, facets, profiles, yield stress and return mapping, amplitudes,
//! conduction, SIMD lanes. Sources of formulas are cited where they are used.

pub mod amplitude;
pub mod assumed;
pub mod attitude;
pub mod blast_wave;
pub mod bulk_viscosity;
pub mod cavity;
pub mod conduction;
pub mod corners;
pub mod disjoint_sets;
pub mod facet;
pub mod free_surface;
pub mod hardening;
pub mod heating;
pub mod interaction;
pub mod lanes;
pub mod levels;
pub mod lists;
pub mod moduli;
pub mod pack;
pub mod plane_return;
pub mod plane_stress;
pub mod profile;
pub mod quad;
pub mod real;
pub mod return_mapping;
pub mod rotation;
pub mod shell;
pub mod six_node_triangle;
pub mod solid;
pub mod sorted_boxes;
pub mod stress;
pub mod topology;
pub mod transcendental;
