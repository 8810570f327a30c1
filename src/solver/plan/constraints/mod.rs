//! Constraints of the plan: links, ties, equations, springs and dashpots, prescribed motions.

pub mod connectors;
pub mod equations;
pub mod link_set;
pub mod links;
pub mod motions;
pub mod surface_ties;
pub mod tie_equations;
pub mod tie_integration;
