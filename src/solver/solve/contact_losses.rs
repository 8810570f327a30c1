//! Energy that contact absorbs: its parts by the kind of the impact, and the advice for the large parts.

use super::outcome::ContactLosses;
use super::run_state::RunState;
use crate::constraint::Constraint as _;
use crate::state::energies::ImpactLosses;

/// Fraction of the absorbed energy above which a kind of impact is a cause, with its own advice.
const NOTABLE: f64 = 0.25;

/// Advice for faces that have been exposed since the start.
const ADVICE_FOR_FIRST_TOUCH: &str =
    "smaller elements at the surfaces that hit reduce the loss of first touch in proportion to their size";
/// Advice for nodes without elements, which hit several bodies by turns.
const ADVICE_FOR_POINTS: &str = "smaller elements do not reduce the loss of nodes without elements; NODAL EROSION=MERGE on \
                                 *CONTACT CONTROLS ASSIGNMENT adds their mass to the rest of their body, YES takes them out of \
                                 contact";
/// Advice for nodes without elements that merge.
const ADVICE_FOR_MERGING: &str = "NODAL EROSION=YES on *CONTACT CONTROLS ASSIGNMENT takes nodes without elements out of contact \
                                  and does not merge them; the momentum of their mass then leaves the bodies";

/// Describes the parts of the energy that contact has absorbed, in percent of the energy put in; `None` if no elements have
/// been deleted, because all impacts are then those of faces that exist since the start.
pub(super) fn describe_losses(run: &RunState<'_>) -> Option<String> {
    let put_in = run.balance.put_in();
    let ImpactLosses { first_touch, closing_gaps, free_points, merged_points } = run.state.dofs.energies.impacts;
    if run.state.elements.deletions.count() == 0 || put_in <= 0.0 {
        return None;
    }
    let percent = |loss: f64| 100.0 * loss / put_in;
    let merged = if run.step.merges_detached_nodes {
        format!(", merged nodes {:.2} %", percent(merged_points))
    } else {
        String::new()
    };
    Some(format!(
        "first touch {:.2} %, gaps closing after deletion {:.2} %, nodes without elements {:.2} %{merged}",
        percent(first_touch),
        percent(closing_gaps),
        percent(free_points)
    ))
}

/// Returns the losses with the ledger row of the contact; `None` without deleted elements or without contact.
pub(super) fn losses_of(run: &RunState<'_>) -> Option<ContactLosses> {
    let text = format!("absorbed: {}", describe_losses(run)?);
    let row = run.contacts().next()?.effect();
    Some(ContactLosses { row, text, parts: run.state.dofs.energies.impacts })
}

/// Returns how much energy contact has absorbed in which impacts, and what reduces the large parts; `share` is the fraction
/// of the energy put in.
pub(super) fn name_absorbed_energy(run: &RunState<'_>, share: f64) -> String {
    let losses = run.state.dofs.energies.impacts;
    let for_later_impacts = [
        (losses.closing_gaps, advice_for_gaps(run)),
        (losses.free_points, ADVICE_FOR_POINTS),
        (losses.merged_points, ADVICE_FOR_MERGING),
    ];
    let is_notable = |part: f64| part > NOTABLE * losses.sum();
    let mut fitting: Vec<&str> =
        for_later_impacts.into_iter().filter(|(part, _)| is_notable(*part)).map(|(_, text)| text).collect();
    if fitting.is_empty() || is_notable(losses.first_touch) {
        fitting.insert(0, ADVICE_FOR_FIRST_TOUCH);
    }
    format!(
        "contact has absorbed {:.1} % of the energy put in (ALLCW{}): masses are lumped at nodes, and a node that touches a \
         surface loses its relative velocity at once. The energy is missing in the bodies: {}",
        100.0 * share,
        describe_losses(run).map_or_else(String::new, |parts| format!("; {parts}")),
        fitting.join(". ")
    )
}

/// Returns the advice for faces that element deletion has exposed: each deleted layer opens a gap, and the velocity with
/// which it closes does not depend on the size of the elements.
fn advice_for_gaps(run: &RunState<'_>) -> &'static str {
    if run.plan.remesh.is_some() {
        "smaller elements do not reduce the loss of closing gaps; failed material that is kept (*FAILED MATERIAL) opens none"
    } else {
        "smaller elements do not reduce the loss of closing gaps; failed material that is kept (*FAILED MATERIAL) in a body \
         with *REMESH opens none, and its loss falls with the size of the elements"
    }
}
