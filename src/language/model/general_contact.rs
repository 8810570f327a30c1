//! General contact: `*CONTACT`, `*CONTACT INCLUSIONS`, `*CONTACT EXCLUSIONS` and the assignment cards.

use super::context::Context;
use super::families::StepReader;
use super::names::upper;
use super::types::{AssignedInteraction, ContactDomain, ContactDomains, DetachedNodes, GeneralContact, InteractionLaw};
use super::{clearance, contact, surface_contact};
use crate::deck::read::FromValue;
use crate::deck::{Card, DataLine, Word};

/// Reads `*CONTACT` (ABAQUS Keywords Reference Guide): OP=MOD, the default, extends the definition in force; NEW
/// replaces it.
pub fn read_contact(steps: &mut StepReader, card: &Card) {
    let in_force = &mut steps.state().general_contact;
    if card.read("OP") || in_force.is_none() {
        *in_force = Some(GeneralContact { span: card.span, ..GeneralContact::default() });
    }
}

/// Reads a card that follows `*CONTACT`.
pub fn read_general_contact_option(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    if steps.state().general_contact.is_none() {
        return context.misplaced(card, format!("*{} must follow a *CONTACT", card.keyword.name), "CONTACT");
    }
    if card.has("NODAL EROSION") {
        steps.note_value(context, card, "NODAL EROSION".into(), card.span);
    }
    let Some(general) = &mut steps.state().general_contact else { return };
    general.all |= card.has("ALL EXTERIOR");
    // NODAL EROSION=NO, the default, keeps the nodes of completely eroded elements in contact as point masses; YES
    // removes them (ABAQUS Keywords Reference Guide, *CONTACT CONTROLS ASSIGNMENT). MERGE is an extension.
    if card.has("NODAL EROSION") {
        let choices = [DetachedNodes::InContact, DetachedNodes::Excluded, DetachedNodes::Merged];
        general.detached_nodes = choices[card.read::<usize>("NODAL EROSION")];
    }
    for (at, line) in card.lines.iter().enumerate() {
        let Some(domains) = domains(context, line) else { continue };
        if !matches!(card.keyword.name, "CONTACT INCLUSIONS" | "CONTACT EXCLUSIONS") {
            steps.note_value(context, card, names_of_pair(line), line.span);
        }
        let Some(general) = &mut steps.state().general_contact else { return };
        let third_field = || card.given_field(at, 2);
        match (card.keyword.name, line.field(2)) {
            ("CONTACT INCLUSIONS", _) if domains.sides.iter().all(|d| matches!(d, ContactDomain::Analytical(_))) => {
                let message = "contact of analytical surfaces with each other is not supported";
                context.unsupported(line.span, message, "one of the surfaces must have elements");
            }
            ("CONTACT INCLUSIONS", _) => general.included.push(domains),
            ("CONTACT EXCLUSIONS", _) => general.excluded.push(domains),
            ("CONTACT CONTROLS ASSIGNMENT", _) => general.penalties.push((domains, f64::from_value(third_field()))),
            ("CONTACT FORMULATION", _) => general.roles.push((domains, usize::from_value(third_field()) < 2)),
            (_, None) => {}
            ("CONTACT PROPERTY ASSIGNMENT", Some(word)) => {
                let interaction = contact::interaction(context, word);
                general.assigned.push(AssignedInteraction { domains, interaction, law: InteractionLaw::default() });
            }
            (_, Some(word)) => {
                let clearance = clearance::clearance(context, word);
                general.clearances.extend(clearance.map(|clearance| (domains, clearance)));
            }
        }
    }
}

/// Returns the names of the two surfaces of a data line, in any order, for a message.
fn names_of_pair(line: &DataLine) -> String {
    let mut names = [0, 1].map(|at| line.field(at).map_or(String::new(), |word| upper(&word.text)));
    if names[1].is_empty() {
        names[1] = names[0].clone();
    }
    names.sort();
    match &names {
        [_, second] if second.is_empty() => "ALL EXTERIOR".into(),
        [first, second] => format!("`{first}` and `{second}`"),
    }
}

/// Returns the pair of surfaces of a data line. An empty first field is the whole exterior, an empty second field
/// the first.
fn domains(context: &mut Context<'_>, line: &DataLine) -> Option<ContactDomains> {
    let first = domain(context, line.field(0))?;
    let second = match line.field(1).filter(|w| !w.text.is_empty()) {
        None if line.field(0).is_none_or(|w| w.text.is_empty()) => ContactDomain::All,
        None => first.clone(),
        some => domain(context, some)?,
    };
    Some(ContactDomains { sides: [first, second], span: line.span })
}

fn domain(context: &mut Context<'_>, word: Option<&Word>) -> Option<ContactDomain> {
    let Some(word) = word.filter(|w| !w.text.is_empty()) else { return Some(ContactDomain::All) };
    match contact::analytical_id(context, word) {
        Some(surface) => Some(ContactDomain::Analytical(surface)),
        None => surface_contact::contact_sides(context, word).map(ContactDomain::Surface),
    }
}
