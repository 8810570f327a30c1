//! Checks that judge a complete plan, and warn of input that is probably a mistake.

pub mod amplitudes;
pub mod blasts;
pub mod contact_pairs;
pub mod equations_of_state;
pub mod expected_action;
pub mod finding;
pub mod methods;
pub mod missing_contact;
pub mod overlaps;
pub mod plausibility;
pub mod strengths;
pub mod targets;
pub mod unit_systems;
pub mod values;

use crate::deck::Diagnostic;
use crate::model::Model;
use crate::plan::{Links, Pairs, Report, Scene, State};

/// Judges a complete plan, and lists cards and user subroutines that it does not use.
pub fn check_plan(scene: Scene, links: &Links, pairs: &Pairs, state: &State, report: &mut Report) {
    check_complete(scene.model, !state.dofs.nodes.is_empty(), report);
    let parts = overlaps::solid_parts(scene);
    overlaps::report_overlaps(scene, &parts, (links, pairs), report);
    missing_contact::check_missing_contact(scene, report);
    missing_contact::check_unjoined_faces(scene, &parts, (links, pairs), report);
    for inert in &scene.model.origin.inert {
        report.add_unused_card(inert.span, format!("*{}", inert.keyword), inert.why.clone());
    }
    plausibility::check_plausibility(scene, state, report);
    report.add_events_row();
    report.note_uncalled_routines();
}

fn check_complete(model: &Model, has_nodes: bool, report: &mut Report) {
    if report.diagnostics.has_errors() {
        return;
    }
    if model.rigid_bodies.is_empty() && !has_nodes || model.steps.is_empty() {
        let missing = if model.steps.is_empty() {
            "step with *DYNAMIC, EXPLICIT"
        } else {
            "rigid or deformable body, and no mass or spring"
        };
        let what = if model.origin.last_card.is_some() { "deck" } else { "model" };
        let mut finding = Diagnostic::error("P006", format!("nothing to simulate: the {what} has no {missing}"));
        if let Some(card) = model.origin.last_card {
            finding = finding.at(card, "the deck ends after this card");
        }
        report.push(
            finding.help("a run needs a *RIGID BODY, a *SOLID SECTION or a *MASS, and a *STEP with *DYNAMIC, EXPLICIT"),
        );
    }
}
