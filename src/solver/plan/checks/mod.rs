//! Checks that judge a complete plan, and warn of input that is probably a mistake.

pub(crate) mod contact_pairs;
pub(crate) mod overlaps;
pub(crate) mod plausibility;
pub(crate) mod values;

use crate::deck::Diagnostic;
use crate::model::Model;
use crate::plan::constraints::link_set::Links;
use crate::plan::report::Report;
use crate::plan::scene::{Pairs, Scene};
use crate::plan::state::State;

/// Judges a complete plan, and lists cards and user subroutines that it does not use.
pub(crate) fn check_plan(scene: Scene<'_>, links: &Links, pairs: &Pairs, state: &State, report: &mut Report<'_>) {
    check_complete(scene.model, !state.elements.is_empty(), report);
    overlaps::report_overlaps(scene, links, pairs, report);
    for inert in &scene.model.origin.inert {
        report.add_unused_card(inert.span, format!("*{}", inert.keyword), inert.why.clone());
    }
    plausibility::check_plausibility(scene, state, report);
    report.events_row();
    report.note_uncalled();
}

fn check_complete(model: &Model, deforms: bool, report: &mut Report<'_>) {
    if report.diagnostics.has_errors() {
        return;
    }
    if model.rigid_bodies.is_empty() && !deforms || model.steps.is_empty() {
        let missing = if model.steps.is_empty() { "step with *DYNAMIC, EXPLICIT" } else { "rigid or deformable body" };
        let what = if model.origin.last_card.is_some() { "deck" } else { "model" };
        let mut finding = Diagnostic::error("P006", format!("nothing to simulate: the {what} has no {missing}"));
        if let Some(card) = model.origin.last_card {
            finding = finding.at(card, "the deck ends after this card");
        }
        report
            .diagnostics
            .push(finding.help("a run needs a *RIGID BODY or a *SOLID SECTION, and a *STEP with *DYNAMIC, EXPLICIT"));
    }
}
