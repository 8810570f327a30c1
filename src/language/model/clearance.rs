//! Initial clearances of contact: `*CLEARANCE` of contact pairs, and the assignments of general contact. Penalty scale
//! factors of contact pair sets: `*CONTACT CONTROLS`.

use super::context::Context;
use super::families::StepReader;
use super::names::upper;
use super::types::{PrescribedClearance, SurfaceContact};
use crate::deck::table::constraints as cards;
use crate::deck::{Card, Word};

/// Returns the clearance with a name, or reports that it is unknown.
pub fn clearance(context: &mut Context<'_>, word: &Word) -> Option<PrescribedClearance> {
    let clearance = context.names.clearances.get(&upper(&word.text)).copied();
    if clearance.is_none() {
        context.unknown("M114", "contact clearance", word, |c| c.names.clearances.keys().cloned().collect());
    }
    clearance
}

/// Records the initial clearance of all pairs of a contact pair set (ABAQUS Keywords Reference Guide, *CLEARANCE).
pub fn read_pair_clearance(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Some(set) = context.required(card, "CPSET").cloned() else { return };
    let cards::Clearance { gap } = card.values();
    let [above, below] = [Some(f64::INFINITY); 2];
    steps.note_value(context, card, format!("`{}`", upper(&set.text)), card.span);
    steps.state().pair_clearances.push((set, PrescribedClearance { gap, above, below }));
}

/// Records the penalty scale factor of a contact pair set (ABAQUS Keywords Reference Guide, *CONTACT CONTROLS).
pub fn read_contact_controls(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Some(set) = context.required(card, "CPSET").cloned() else { return };
    let cards::ContactControls { penalty, reset } = card.values();
    if penalty.is_some() {
        steps.note_value(context, card, format!("`{}`", upper(&set.text)), card.span);
    }
    let factors = &mut steps.state().penalty_factors;
    if reset {
        factors.push((set.clone(), 1.0));
    }
    factors.extend(penalty.map(|f| (set, f)));
}

/// Applies the clearances and penalty scale factors of the step to the contact pair sets.
pub fn apply_to_sets(context: &mut Context<'_>, steps: &mut StepReader) {
    let state = steps.state();
    let (clearances, factors) =
        (std::mem::take(&mut state.pair_clearances), std::mem::take(&mut state.penalty_factors));
    let mut pairs = std::mem::take(&mut state.surface_contacts);
    let names: Vec<String> = pairs.iter().filter_map(|p| p.cpset.clone()).collect();
    for (word, _) in clearances.iter().filter(|c| !names.contains(&upper(&c.0.text))) {
        context.unknown("M114", "contact pair set", word, |_| names.clone());
    }
    for (word, _) in factors.iter().filter(|f| !names.contains(&upper(&f.0.text))) {
        context.unknown("M114", "contact pair set", word, |_| names.clone());
    }
    note_unused_penalties(context, &factors, &pairs);
    for pair in &mut pairs {
        let is_of = |word: &Word| pair.cpset.as_ref().is_some_and(|set| *set == upper(&word.text));
        let clearance = clearances.iter().rfind(|c| is_of(&c.0)).map(|c| c.1);
        let factor = factors.iter().rfind(|f| is_of(&f.0)).map(|f| f.1);
        pair.clearance = clearance.or(pair.clearance);
        pair.penalty = pair.penalty.map(|now| factor.unwrap_or(now));
    }
    steps.state().surface_contacts = pairs;
}

/// Lists penalty scale factors of sets without a penalty pair as unused.
fn note_unused_penalties(context: &mut Context<'_>, factors: &[(Word, f64)], pairs: &[SurfaceContact]) {
    for (word, _) in factors.iter().filter(|factor| factor.1 != 1.0) {
        let mut pairs_of_set =
            pairs.iter().filter(|pair| pair.cpset.as_ref().is_some_and(|set| *set == upper(&word.text)));
        if pairs_of_set.clone().next().is_some() && pairs_of_set.all(|pair| pair.penalty.is_none()) {
            let why = "kinematic contact pairs have no penalty stiffness";
            context.ignore("CONTACT CONTROLS, SCALE PENALTY", word.span, why);
        }
    }
}
