//! Cohesive behaviour of contact pairs: traction-separation laws, contact laws of points without damage, ledger rows,
//! warnings and combinations that are not supported.

use crate::constraint::contact::cohesion::CohesivePair;
use crate::constraint::contact::{ContactConstraint, ContactPair};
use crate::deck::Diagnostic;
use crate::kernel::interaction::{InteractionLaw, PressureOverclosure};
use crate::kernel::traction_separation::TractionSeparationLaw;
use crate::model::{CohesiveBehavior, InitiationMeasure, InterfaceInitiation, Model, SurfaceContact};
use crate::plan::contact::curves::ContactGeometry;
use crate::plan::contact::general::pair_name;
use crate::plan::contact::penalty::spring_laws;
use crate::plan::contact::place_of;
use crate::plan::solids::cohesive::{InterfacePart, check_energies, criterion, initiation_law, softening};
use crate::plan::{Pairs, Report, StepInput};
use crate::variables::Variable;

/// Cohesive behaviour of the contact of a step.
#[derive(Default)]
pub struct CohesionList<'a> {
    laws: Vec<TractionSeparationLaw>,
    pairs: Vec<CohesivePair>,
    origins: Vec<(&'a SurfaceContact, CohesiveBehavior)>,
}

impl CohesionList<'_> {
    /// Adds to the contact the cohesive behaviour of its pairs.
    pub fn add_to(&mut self, contact: ContactConstraint) -> ContactConstraint {
        if self.pairs.is_empty() {
            return contact;
        }
        contact.with_cohesion(std::mem::take(&mut self.laws), self.pairs.clone())
    }
}

/// Returns the cohesive behaviour of a pair; `None` without one.
pub fn cohesion_of<'a>(model: &'a Model, contact: &SurfaceContact) -> Option<&'a CohesiveBehavior> {
    model.interactions.get(contact.interaction?.index())?.cohesion.as_ref()
}

/// Iterates over the cohesive behaviours of all pairs of all steps.
pub fn cohesive_behaviors<'a>(model: &'a Model, pairs: &'a Pairs) -> impl Iterator<Item = &'a CohesiveBehavior> {
    pairs.by_step.iter().flat_map(|pairs| pairs.iter()).filter_map(|contact| cohesion_of(model, contact))
}

/// Returns whether a pair has cohesive surfaces with a variable at nodes.
pub fn has_cohesive_variable(model: &Model, pairs: &Pairs, variable_of_output: Variable) -> bool {
    cohesive_behaviors(model, pairs).any(|cohesion| {
        variable_of_output == Variable::SurfaceDamage
            || cohesion.initiation.as_ref().map(variable) == Some(variable_of_output)
    })
}

/// Returns the nodes of the mesh on cohesive surfaces of a step.
pub fn cohesive_nodes(model: &Model, pairs: &Pairs, step: usize) -> impl Iterator<Item = usize> {
    let pairs = pairs.by_step[step].iter().filter(|contact| cohesion_of(model, contact).is_some());
    let faces = pairs.flat_map(|contact| &contact.sides).flat_map(|side| &side.faces);
    faces.filter_map(|&(element, side)| model.mesh.side_nodes(element, side)).flatten()
}

/// A contact pair whose law is set, with its index and the pair of the model that it comes from.
pub struct CohesionOrigin<'c, 'p> {
    pub contact: &'c SurfaceContact,
    pub index: usize,
    pub pair: &'p ContactPair,
}

/// Adds the cohesive behaviour of a pair, if its interaction has one.
pub fn add_cohesion<'c>(
    input: StepInput,
    CohesionOrigin { contact, index, pair }: CohesionOrigin<'c, '_>,
    laws: &mut Vec<InteractionLaw>,
    geometry: &ContactGeometry,
    list: &mut CohesionList<'c>,
    report: &mut Report,
) -> Option<()> {
    let Some(cohesion) = cohesion_of(input.scene.model, contact) else { return Some(()) };
    if pair.analytical.is_some() {
        return refuse_analytical(contact, cohesion, report);
    }
    let count = geometry.curves[pair.secondary].points.len();
    let stiffnesses = match cohesion.stiffness {
        Some(stiffness) => vec![stiffness],
        None => {
            let springs = spring_laws(input, contact, contact.penalty.unwrap_or(1.0), pair, geometry, report)?;
            springs.iter().map(|law| [spring_stiffness(law); 2]).collect()
        }
    };
    let (law, varies) = (list.laws.len(), cohesion.stiffness.is_none());
    list.laws.extend(stiffnesses.into_iter().map(|stiffness| law_of(cohesion, stiffness)));
    let first = &list.laws[law];
    let name = contact.interaction.map_or("", |id| &input.scene.model.interactions[id].name);
    let origin = cohesion.initiation.as_ref().zip(cohesion.evolution.as_ref());
    let part = InterfacePart { code: "P027", name: &format!("surface interaction `{name}`"), card: STIFFNESS_CARD };
    check_energies(origin, first, &part, report)?;
    let intact = if pair.springs {
        let springs: Vec<InteractionLaw> =
            laws[pair.law..pair.law + count].iter().map(InteractionLaw::without_friction).collect();
        laws.extend(springs);
        laws.len() - count
    } else {
        place_of(laws, laws[pair.law].without_friction())
    };
    list.pairs.push(CohesivePair {
        pair: index,
        law,
        has_law_of_points: varies,
        intact_law: intact,
        bonds_later: !cohesion.original_only,
        bonds_again: cohesion.repeated,
        criterion: cohesion.initiation.as_ref().map(variable),
        ..CohesivePair::default()
    });
    list.origins.push((contact, cohesion.clone()));
    Some(())
}

/// Reports that a pair with an analytical surface cannot be cohesive.
pub fn refuse_analytical<T>(contact: &SurfaceContact, cohesion: &CohesiveBehavior, report: &mut Report) -> Option<T> {
    let message = format!("the pair {} cannot be cohesive: it has an analytical surface", pair_name(contact));
    let finding = Diagnostic::error("P027", message).at(contact.span, "this pair");
    let help = "use a rigid body of elements (RAX2) in place of the analytical surface, or an interaction without \
                *COHESIVE BEHAVIOR";
    report.refuse(finding.at(cohesion.span, "the cohesive behaviour of its interaction").help(help))
}

/// Creates the ledger rows of cohesive pairs, with the number of points that are bonded at the start, and warns of pairs
/// without any and of damage that cannot begin. The pairs of general contact with one interaction share a row.
pub fn report_cohesion(list: &CohesionList, contact: &ContactConstraint, step: usize, report: &mut Report) {
    let mut groups: Vec<CohesiveGroup> = Vec::new();
    for (cohesive, (origin, cohesion)) in list.pairs.iter().zip(&list.origins) {
        let Some([bonded, all]) = contact.bonded_points(cohesive.pair) else { continue };
        let is_of =
            |group: &&mut CohesiveGroup| (group.origin.span, group.cohesion.span) == (origin.span, cohesion.span);
        match groups.iter_mut().find(is_of) {
            Some(group) => group.add(origin, [bonded, all]),
            None => groups.push(CohesiveGroup::new(origin, cohesion, [bonded, all])),
        }
    }
    for group in &groups {
        let CohesiveGroup { origin, cohesion, names, points: [bonded, all] } = group;
        let mut parts = vec![names.join(", "), stiffness_text(cohesion)];
        parts.extend((step == 0).then(|| format!("{bonded} of {all} points bonded at the start")));
        parts.extend((!cohesion.original_only).then(|| "bonds on later contact".into()));
        parts.extend(cohesion.repeated.then(|| "bonds again after failure".into()));
        parts.extend(cohesion.initiation.as_ref().map(|i| format!("damage by {}", criterion(i))));
        parts.extend(cohesion.evolution.as_ref().map(|e| softening(&e.softening)));
        parts.extend((cohesion.viscosity > 0.0).then(|| format!("viscosity {:e}", cohesion.viscosity)));
        report.ledger_row(origin.span, "cohesive contact", *all, "points", parts.join(", "));
        warn_of_cohesion(group, step, report);
    }
}

fn warn_of_cohesion(group: &CohesiveGroup, step: usize, report: &mut Report) {
    let CohesiveGroup { origin, cohesion, names, points: [bonded, _] } = group;
    let pairs = names.join(", ");
    if let (Some(initiation), None) = (cohesion.initiation, &cohesion.evolution) {
        let message = format!("the cohesive surfaces of {pairs} are never damaged");
        let finding = Diagnostic::warning("P147", message).at(initiation.span, "no *DAMAGE EVOLUTION after it");
        report.push(finding.help("add *DAMAGE EVOLUTION; without it the criterion is output only"));
    }
    if step == 0 && *bonded == 0 && cohesion.original_only {
        let message = format!("no point of {pairs} is bonded: the surfaces are apart at the start");
        let finding = Diagnostic::warning("P148", message).at(origin.span, "this contact");
        let help = "close the gap with ADJUST on *CONTACT PAIR or *CONTACT CLEARANCE, or give \
                    ELIGIBILITY=CURRENT CONTACTS on *COHESIVE BEHAVIOR";
        report.push(finding.at(cohesion.span, "ELIGIBILITY=ORIGINAL CONTACTS").help(help));
    }
}

/// Cohesive pairs of one card with one interaction.
struct CohesiveGroup<'a> {
    origin: &'a SurfaceContact,
    cohesion: &'a CohesiveBehavior,
    /// Names of the pairs with bonded points; of the first pair if none has any.
    names: Vec<String>,
    /// Numbers of bonded points and of all points.
    points: [usize; 2],
}

impl<'a> CohesiveGroup<'a> {
    fn new(origin: &'a SurfaceContact, cohesion: &'a CohesiveBehavior, points: [usize; 2]) -> CohesiveGroup<'a> {
        CohesiveGroup { origin, cohesion, names: vec![pair_text(origin)], points }
    }

    fn add(&mut self, origin: &SurfaceContact, [bonded, all]: [usize; 2]) {
        if bonded > 0 {
            if self.points[0] == 0 {
                self.names.clear();
            }
            self.names.push(pair_text(origin));
        }
        self.points = [self.points[0] + bonded, self.points[1] + all];
    }
}

fn pair_text(contact: &SurfaceContact) -> String {
    let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
    if contact.is_self_contact() { format!("{a} with itself") } else { format!("{a} and {b}") }
}

fn stiffness_text(cohesion: &CohesiveBehavior) -> String {
    match cohesion.stiffness {
        Some([normal, shear]) if cohesion.coupling != 0.0 => {
            format!("stiffness {normal:e} and {shear:e}, coupled by {:e}", cohesion.coupling)
        }
        Some([normal, shear]) => format!("stiffness {normal:e} and {shear:e}"),
        None => "stiffness of the elements".into(),
    }
}

/// Card that gives the stiffness of cohesive surfaces.
const STIFFNESS_CARD: &str = "*COHESIVE BEHAVIOR";

fn spring_stiffness(law: &InteractionLaw) -> f64 {
    match law.overclosure {
        PressureOverclosure::Spring(stiffness) => stiffness,
        _ => 0.0,
    }
}

fn law_of(cohesion: &CohesiveBehavior, stiffness: [f64; 2]) -> TractionSeparationLaw {
    TractionSeparationLaw {
        stiffness,
        // Shear separations of contact are positive along the facet, those of the deck against it (theory manual,
        // cohesive surfaces).
        coupling: -cohesion.coupling,
        viscosity: cohesion.viscosity,
        initiation: cohesion.initiation.as_ref().map(|initiation| initiation_law(initiation, stiffness, 1.0)),
        softening: cohesion.evolution.as_ref().map(|evolution| evolution.softening.clone()),
        largest_damage: 1.0,
    }
}

/// Returns the output variable of a criterion of cohesive surfaces.
fn variable(initiation: &InterfaceInitiation) -> Variable {
    match (initiation.measure == InitiationMeasure::Stress, initiation.quadratic) {
        (true, false) => Variable::LargestTractionInitiation,
        (true, true) => Variable::QuadraticTractionInitiation,
        (false, false) => Variable::LargestSeparationInitiation,
        (false, true) => Variable::QuadraticSeparationInitiation,
    }
}
