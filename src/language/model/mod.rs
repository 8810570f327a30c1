//! The model: a deck with resolved names, flattened parts and instances, and checked values.

mod adaptive;
mod amplitudes;
mod blast;
mod bodies;
mod boundary;
mod budget;
mod builder;
mod check;
mod check_values;
mod clearance;
mod coarsening;
pub mod codes;
mod cohesive;
mod cohesive_contact;
mod completion;
mod compose;
mod concrete_law;
mod connectors;
mod consistency;
mod consistent_material;
mod contact;
mod context;
mod controls;
mod copies;
pub mod derive;
mod element_nodes;
mod element_words;
mod elements;
mod eos;
mod eos_law;
mod equations;
mod erosion;
mod expressions;
mod failure;
mod families;
mod faults;
mod fields;
mod general_contact;
mod gmsh_file;
mod heading;
mod heat_loads;
mod history;
mod infinite;
mod inp_file;
mod interactions;
mod links;
mod load_history;
mod loads;
mod lost;
mod mass_scaling;
mod materials;
mod mates;
mod mesh_data;
mod mesh_file;
mod name;
mod named_clearances;
mod names;
mod nodes;
mod ogden_fit;
mod order;
mod orientations;
mod outputs;
mod parts;
mod placement;
pub mod rates;
mod readers;
mod refinement;
pub mod relisting;
pub mod remesh;
pub mod revise;
mod rubber;
mod rubber_fit;
pub mod scene;
mod sets;
mod shared;
mod shells;
mod steps;
pub mod strength_law;
mod surface_contact;
mod surfaces;
mod targets;
pub mod types;
mod units;
mod unused;
mod user_material;
#[cfg(feature = "mesh-files")]
pub mod vtk_file;
#[cfg(not(feature = "mesh-files"))]
#[path = "no_vtk_file.rs"]
mod vtk_file;
pub mod vtk_mesh;
#[cfg(feature = "mesh-files")]
mod xml_array;
#[cfg(feature = "mesh-files")]
mod xml_mesh;

pub use element_nodes::NodeIndices;
pub use name::EntityName;
pub use shared::CopyOnWrite;
pub use steps::DEFAULT_ACCURACY;
pub use types::*;
pub use units::{DeckUnits, SYSTEMS, UnitSystem, is_without_units, within};
pub use vtk_file::silence_caught_panics;

use crate::deck::{Deck, Diagnostics, MeshScaling};

/// Builds the model of a deck. A model is always returned; it can be run only if the diagnostics have no error. The mesh
/// is refined or coarsened as [`Deck::mesh_scaling`] requests, if the deck has no error.
pub fn build(deck: &Deck) -> (Model, Diagnostics) {
    let mut builder = builder::ModelBuilder::checked(deck);
    builder.read_cards();
    let (model, mut diagnostics) = builder.finish();
    match deck.mesh_scaling.filter(|_| !diagnostics.has_errors()) {
        Some(MeshScaling::Refine(factor)) if factor > 1 => {
            return refinement::apply::read(deck, factor, &model, false).finish();
        }
        Some(MeshScaling::Coarsen(factor)) => {
            let builder = coarsening::apply::read(deck, factor, &model, false);
            return coarsening::apply::finish(builder, &model);
        }
        _ => {}
    }
    lost::drop_consequential_diagnostics(&mut diagnostics);
    (model, diagnostics)
}
