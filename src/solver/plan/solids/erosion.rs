//! `*EROSION` of the plan: selects the elements and checks the criteria.

use crate::deck::Diagnostic;
use crate::element::criteria::DeletionCriteria;
use crate::element::erosion::ErosionControl;
use crate::model::ErosionCriteria as Card;
use crate::plan::{Report, Scene, SolidPlaces, State};
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// The state before its effects are known, with the criteria of `*EROSION`. The output depends on them.
pub struct ErodingState(State);

impl ErodingState {
    pub fn into_state(self) -> State {
        self.0
    }
}

/// Applies the criteria of `*EROSION` to the elements of the state.
pub fn plan(scene: Scene, mut state: State, report: &mut Report) -> ErodingState {
    let mut erosion = ErosionControl::default();
    for card in &scene.model.erosions {
        let Some(elements) = eroding_elements(scene.places, card, &state, report) else { continue };
        let Card { distortion, plastic, strain, increment, .. } = *card;
        let criteria = DeletionCriteria { distortion, plastic, strain, increment };
        check_start(scene, card, &criteria, &elements, &state, report);
        let id = report.ledger_row(card.span, "erosion", elements.len(), "elements", detail(card));
        erosion.watch(id, criteria, elements);
    }
    if !erosion.groups().is_empty() {
        state.elements.watch(erosion, &state.dofs.nodes);
    }
    ErodingState(state)
}

fn eroding_elements(
    places: &SolidPlaces,
    card: &Card,
    state: &State,
    report: &mut Report,
) -> Option<Vec<(usize, usize)>> {
    let places = &places.elements;
    let elements: Vec<(usize, usize)> = match &card.elements {
        None => places.values().copied().collect(),
        Some(list) => list.iter().filter_map(|e| places.get(e).copied()).collect(),
    };
    if elements.is_empty() {
        report.add_unused_card(card.span, "erosion", "none of its elements is deformable");
        return None;
    }
    let groups = &state.elements.groups;
    let flows = |&(g, e): &(usize, usize)| groups[g].value(e, Variable::PlasticStrain.into()).is_some();
    let refusal = if card.plastic.is_some() && !elements.iter().any(flows) {
        Some((
            "PLASTIC STRAIN is given, but no element has a plastic strain",
            "give PRINCIPAL STRAIN, which all elements have",
        ))
    } else if card.distortion.is_some() && !elements.iter().any(|(g, _)| groups[*g].is_solid()) {
        Some(("DISTORTION does not apply to shells", "give DISTORTION for solid elements"))
    } else {
        None
    };
    if let Some((message, help)) = refusal {
        return report.refuse(Diagnostic::error("P070", message).at(card.span, "this card").help(help));
    }
    Some(elements)
}

/// Reports an element that meets a criterion at the start.
fn check_start(
    scene: Scene,
    card: &Card,
    criteria: &DeletionCriteria,
    elements: &[(usize, usize)],
    state: &State,
    report: &mut Report,
) {
    let nodes: &Nodes = &state.dofs.nodes;
    let at_start = |&&(g, e): &&(usize, usize)| criteria.are_met(&*state.elements.groups[g], e, nodes);
    let Some(&place) = elements.iter().find(at_start) else { return };
    let message = format!("element {} meets an erosion criterion at the start", scene.element_name(place));
    let finding = Diagnostic::error("P070", message).at(card.span, "this card");
    report.push(finding.help("give another limit, or an ELSET without this element"));
}

fn detail(card: &Card) -> String {
    let Card { distortion, plastic, strain, increment, .. } = card;
    let limits = [
        distortion.map(|d| format!("scaled Jacobian down to {d}")),
        plastic.map(|p| format!("plastic strain up to {p}")),
        strain.map(|s| format!("principal strain up to {s}")),
        increment.map(|dt| format!("stable increment down to {dt}")),
    ];
    limits.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
