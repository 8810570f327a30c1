//! Constraints of the plan: links, ties, equations, springs and dashpots, prescribed motions.

pub(crate) mod connectors;
pub(crate) mod equations;
pub(crate) mod link_set;
pub(crate) mod links;
pub(crate) mod motions;
pub(crate) mod surface_ties;
pub(crate) mod tie_equations;
pub(crate) mod tie_integration;
