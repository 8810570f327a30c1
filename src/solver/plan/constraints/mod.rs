//! Constraints of the plan: links, ties, equations, springs and dashpots, prescribed motions.

pub mod connectors;
pub mod equations;
pub mod link_set;
pub mod links;
pub mod motions;
pub mod surface_ties;
pub mod tie_equations;
pub mod tie_integration;

use crate::plan::constraints::connectors::connect;
use crate::plan::constraints::links::collect_links;
use crate::plan::solids::cohesive::bound_cohesive_elements;
use crate::plan::state::SolidState;
use crate::plan::{Links, Report, Scene};

/// Adds the links of a model, which are active in all steps, to the `links` of its ties, and the springs and dashpots to the
/// state. The masses of linked nodes bound the increment of cohesive elements.
pub fn plan(scene: Scene, mut links: Links, state: &mut SolidState, report: &mut Report) -> Links {
    collect_links(scene, &mut links, state, report);
    connect(scene, &links, state, report);
    bound_cohesive_elements(scene, &links, state, report);
    links
}
