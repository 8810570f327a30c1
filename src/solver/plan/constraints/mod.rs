//! Constraints of the plan: links, ties, equations, springs and dashpots, prescribed motions.

pub mod connectors;
pub mod equations;
pub mod link_set;
pub mod links;
pub mod motions;
pub mod surface_ties;
pub mod tie_equations;
pub mod tie_integration;

use crate::constraint::tie::TiedNodes;
use crate::plan::constraints::connectors::connect;
use crate::plan::constraints::links::collect_links;
use crate::plan::constraints::tie_equations::TieEquations;
use crate::plan::solids::cohesive::bound_cohesive_elements;
use crate::plan::state::SolidState;
use crate::plan::{Links, Report, Scene};

/// Creates the links of a model, which are active in all steps, and the springs and dashpots of the state. The masses of
/// linked nodes bound the increment of cohesive elements.
pub fn plan(
    scene: Scene,
    surface_ties: Vec<TieEquations>,
    rigid_ties: Vec<TiedNodes>,
    state: &mut SolidState,
    report: &mut Report,
) -> Links {
    let links = collect_links(scene, surface_ties, rigid_ties, state, report);
    connect(scene, &links, state, report);
    bound_cohesive_elements(scene, &links, state, report);
    links
}
