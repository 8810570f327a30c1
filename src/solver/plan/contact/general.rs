//! General contact as pairs of surfaces: exterior surfaces of the bodies, inclusions, exclusions and property
//! assignments.

use std::collections::BTreeSet;
use std::rc::Rc;

use rustc_hash::FxHashSet;

use crate::deck::Span;
use crate::kernel::lists::sorted_unique;
use crate::model::{
    AnalyticalSide, ContactDomain, ContactDomains, DetachedNodes, ElementSide, GeneralContact, Model, RigidSurfaceId,
    SideSelection, Step, SurfaceContact,
};
use crate::plan::contact::curves::CurveContext;
use crate::plan::meshes::pieces::{SetsOfParts, exterior_faces_of, parts_in_contact};
use crate::plan::{Pairs, Report, Scene};

type ElementFace = (usize, ElementSide);

/// A surface in general contact: faces of elements, or an analytical surface, which has no faces.
#[derive(Clone)]
struct PairedSurface {
    sides: SideSelection,
    analytical: Option<RigidSurfaceId>,
}

impl PairedSurface {
    fn of_faces(name: &str, faces: &[ElementFace]) -> PairedSurface {
        PairedSurface { sides: SideSelection::new(name, faces), analytical: None }
    }

    fn is_empty(&self) -> bool {
        self.sides.faces.is_empty() && self.analytical.is_none()
    }

    fn has_common_faces(&self, other: &PairedSurface) -> bool {
        self.sides.faces.iter().any(|f| other.sides.faces.contains(f))
    }
}

/// Two surfaces in general contact, or one with itself. Exclusions and assignments split it into parts.
#[derive(Clone)]
struct SurfacePairing {
    sides: [PairedSurface; 2],
    /// Indices of the assigned interaction, clearance and penalty factor and role.
    given: [Option<usize>; 4],
    span: Span,
}

impl SurfacePairing {
    fn new(sides: [&PairedSurface; 2], span: Span) -> SurfacePairing {
        SurfacePairing { sides: sides.map(PairedSurface::clone), given: [None; 4], span }
    }

    fn is_of_one(&self) -> bool {
        self.sides[0].sides.name == self.sides[1].sides.name
    }
}

/// Finds the contact pairs of each step: those of `*CONTACT PAIR` and those of general contact.
pub fn find_pairs(scene: Scene, report: &mut Report) -> Pairs {
    let mut pairs = Pairs::default();
    let steps = &scene.model.steps;
    for (index, step) in steps.iter().enumerate() {
        let previous = index.checked_sub(1).map(|i| &steps[i]);
        let continues =
            |b: &Step| b.surface_contacts == step.surface_contacts && b.general_contact == step.general_contact;
        if previous.is_some_and(continues) {
            pairs.by_step.extend(pairs.by_step.last().cloned());
            continue;
        }
        let general = step.general_contact.as_ref().map(|general| general_pairs(scene, general, report));
        let of_general = general.into_iter().flatten();
        let of_step: Vec<SurfaceContact> = step.surface_contacts.iter().cloned().chain(of_general).collect();
        pairs.names.reserve(of_step.len());
        pairs.names.extend(of_step.iter().map(pair_name));
        pairs.by_step.push(Rc::new(of_step));
    }
    note_unused_analytical_surfaces(scene.model, &pairs, report);
    pairs
}

/// Lists analytical surfaces that no contact pair includes.
fn note_unused_analytical_surfaces(model: &Model, pairs: &Pairs, report: &mut Report) {
    let in_contact: FxHashSet<usize> = pairs
        .by_step
        .iter()
        .flat_map(|of_step| of_step.iter().filter_map(|pair| Some(pair.analytical.as_ref()?.surface.index())))
        .collect();
    for (index, (name, surface)) in model.surfaces.analytical.iter().enumerate() {
        if !in_contact.contains(&index) {
            report.add_unused_card(surface.span, format!("analytical surface {name}"), "it is in no contact pair");
        }
    }
}

/// Returns the pairs of general contact, and lists assignments that cover no pair.
fn general_pairs(scene: Scene, general: &GeneralContact, report: &mut Report) -> Vec<SurfaceContact> {
    let mut meetings = included_meetings(scene, general);
    let mut note_unused = |card: &str, span: Span| {
        report.add_unused_card(span, card, "general contact includes no such pair");
    };
    for domains in &general.excluded {
        let is_covered =
            |meeting: &SurfacePairing| split_by_domains(meeting.clone(), domains).iter().any(|part| part.1);
        if !meetings.iter().any(is_covered) {
            note_unused("*CONTACT EXCLUSIONS", domains.span);
        }
        meetings = uncovered(meetings, domains);
    }
    let assignments: [(&str, Vec<&ContactDomains>); 4] = [
        ("*CONTACT PROPERTY ASSIGNMENT", general.assigned.iter().map(|a| &a.domains).collect()),
        ("initial clearance", general.clearances.iter().map(|c| &c.0).collect()),
        ("*CONTACT CONTROLS ASSIGNMENT", general.penalties.iter().map(|p| &p.0).collect()),
        ("*CONTACT FORMULATION", general.roles.iter().map(|r| &r.0).collect()),
    ];
    for (what, (card, domains)) in assignments.into_iter().enumerate() {
        let unused = assign_domains(&mut meetings, what, &domains);
        unused.into_iter().for_each(|span| note_unused(card, span));
    }
    meetings.retain_mut(|m| is_of_bodies(scene, m));
    let contact = |m: SurfacePairing| {
        let analytical = analytical_side(scene, &m);
        let [interaction, clearance, penalty, role] = m.given;
        let assigned = interaction.map(|index| &general.assigned[index]);
        SurfaceContact {
            law: assigned.map(|a| a.law.clone()).unwrap_or_default(),
            interaction: assigned.and_then(|a| a.interaction),
            analytical,
            general: true,
            no_thickness: false,
            clearance: clearance.map(|index| general.clearances[index].1),
            penalty: penalty.map(|index| general.penalties[index].1),
            secondary: role.map(|index| secondary_of(&m.sides, &general.roles[index])),
            cpset: None,
            sides: m.sides.map(|s| s.sides),
            span: m.span,
        }
    };
    meetings.into_iter().map(contact).collect()
}

/// Returns the surface pairs of all inclusions. Faces that several inclusions pair are included once.
fn included_meetings(scene: Scene, general: &GeneralContact) -> Vec<SurfacePairing> {
    let surfaces = all_surfaces(scene);
    let mut meetings = Vec::new();
    let of_all = general.included.iter().find(|i| matches!(i.sides, [ContactDomain::All, ContactDomain::All]));
    if general.all || of_all.is_some() {
        add_all(&surfaces, of_all.map_or(general.span, |i| i.span), &mut meetings);
        return meetings;
    }
    for (index, ContactDomains { sides: domains, span }) in general.included.iter().enumerate() {
        let [first, second] = [&domains[0], &domains[1]].map(|domain| named_surfaces(scene.model, domain));
        let mut included = Vec::new();
        match (first, second) {
            (Some(first), Some(_)) if domains[0] == domains[1] => add_all(&first, *span, &mut included),
            (Some(first), Some(second)) => add_product([&first, &second], *span, &mut included),
            (Some(named), None) | (None, Some(named)) => {
                let is_other = |o: &&PairedSurface| !named.iter().any(|one| one.has_common_faces(o));
                let others: Vec<PairedSurface> = surfaces.iter().filter(is_other).cloned().collect();
                add_product([&named, &others], *span, &mut included);
            }
            (None, None) => {}
        }
        let earlier = general.included[..index].iter().filter(|included| {
            let earlier = &included.sides;
            // An inclusion with all surfaces does not contain the surface's own body.
            let is_of_two = !earlier.contains(&ContactDomain::All);
            is_of_two || earlier == domains || earlier.iter().rev().eq(domains)
        });
        for earlier in earlier {
            included = uncovered(included, earlier);
        }
        meetings.extend(included);
    }
    meetings
}

/// Returns the surfaces of a domain, one for each side of shells; `None` for all surfaces.
fn named_surfaces(model: &Model, domain: &ContactDomain) -> Option<Vec<PairedSurface>> {
    match domain {
        ContactDomain::All => None,
        ContactDomain::Surface(sides) => {
            Some(sides.one_sided().into_iter().map(|sides| PairedSurface { sides, analytical: None }).collect())
        }
        ContactDomain::Analytical(id) => Some(vec![analytical_surface_of(model, *id)]),
    }
}

fn analytical_surface_of(model: &Model, id: RigidSurfaceId) -> PairedSurface {
    let sides = SideSelection::new(model.surfaces.analytical_name(id), &[]);
    PairedSurface { sides, analytical: Some(id) }
}

/// Returns the exterior surfaces of all connected parts, and the analytical surfaces of rigid bodies.
fn all_surfaces(scene: Scene) -> Vec<PairedSurface> {
    let mut surfaces: Vec<PairedSurface> =
        outsides(scene).into_iter().map(|sides| PairedSurface { sides, analytical: None }).collect();
    let ids = (0..scene.model.surfaces.analytical.len()).map(RigidSurfaceId::new);
    surfaces.extend(
        ids.filter(|id| body_of_analytical(scene, *id).is_some()).map(|id| analytical_surface_of(scene.model, id)),
    );
    surfaces
}

/// Returns the rigid body of an analytical surface.
pub fn body_of_analytical(scene: Scene, id: RigidSurfaceId) -> Option<usize> {
    let reference = scene.model.surfaces.analytical[id].reference?;
    scene.bodies.of_node.get(&reference).copied()
}

/// Returns whether bodies of this pair can be in contact: one body deforms, or an oblique rigid body faces an
/// analytical surface of another body. Faces on rigid bodies cannot contact analytical surfaces and are removed.
fn is_of_bodies(scene: Scene, pairing: &mut SurfacePairing) -> bool {
    let Some(id) = pairing.sides[1].analytical else {
        let mut faces = pairing.sides.iter().flat_map(|surface| &surface.sides.faces);
        return faces.any(|face| scene.places.elements.contains_key(&face.0));
    };
    let faces = &mut pairing.sides[0].sides.faces;
    let spatial = |f: &ElementFace| scene.bodies.of_element.get(&f.0).filter(|&&body| scene.bodies.list[body].spatial);
    if let Some(body) = faces.iter().find_map(spatial) {
        return body_of_analytical(scene, id) != Some(*body);
    }
    let mesh = &scene.model.mesh;
    let is_free = |n: &usize| scene.places.free_node(*n).is_some();
    faces.retain(|&(e, side)| mesh.side_nodes(e, side).is_some_and(|ends| ends.iter().any(is_free)));
    !faces.is_empty()
}

/// Returns the analytical surface of a pair with the nodes of the opposite surface; the free ones, unless they
/// belong to an oblique rigid body.
fn analytical_side(scene: Scene, pairing: &SurfacePairing) -> Option<AnalyticalSide> {
    let surface = pairing.sides[1].analytical?;
    let mesh = &scene.model.mesh;
    let faces = pairing.sides[0].sides.faces.iter();
    let nodes = faces.filter_map(|&(e, side)| mesh.side_nodes(e, side)).flatten();
    let mut nodes: Vec<usize> = sorted_unique(nodes);
    let is_rigid = nodes.iter().all(|n| scene.places.free_node(*n).is_none());
    nodes.retain(|n| is_rigid || scene.places.free_node(*n).is_some());
    Some(AnalyticalSide { side: 1, surface, nodes })
}

/// Returns the exterior surface of each connected part; for shells the positive and the negative side.
fn outsides(scene: Scene) -> Vec<SideSelection> {
    let mesh = &scene.model.mesh;
    let mut pieces = scene.model.surfaces.parts.clone().unwrap_or_else(|| parts_in_contact(scene));
    pieces.retain(|piece| !piece.is_empty());
    let outside = exterior_faces_of(mesh, pieces.iter().map(Vec::as_slice));
    let mut surfaces: Vec<SideSelection> = Vec::new();
    let sets = SetsOfParts::new(scene.model, pieces.iter().map(Vec::as_slice));
    let mut taken = FxHashSet::default();
    for (piece, solid) in pieces.into_iter().zip(outside) {
        let name = name_of_piece(scene.model, &piece, &sets, |name| taken.contains(name));
        taken.insert(name.clone());
        let shells = piece.iter().filter(|&&e| mesh.elements[e].kind.is_line());
        let both = |side: ElementSide| shells.clone().map(move |&e| (e, side)).collect::<Vec<ElementFace>>();
        let parts = [("", solid), ("_SPOS", both(ElementSide::Positive)), ("_SNEG", both(ElementSide::Negative))];
        let parts = parts.into_iter().filter(|p| !p.1.is_empty());
        surfaces.extend(parts.map(|(end, faces)| SideSelection {
            name: format!("{name}{end}"),
            surface: true,
            faces,
            free_face_elements: Vec::new(),
        }));
    }
    surfaces
}

/// Returns the name of a connected part: its instance, or the smallest element set that contains it, with a number
/// if the name is already used.
pub fn name_of_piece(model: &Model, piece: &[usize], sets: &SetsOfParts, is_taken: impl Fn(&str) -> bool) -> String {
    let instance = model.mesh.elements[piece[0]].name.rsplit_once('.').map(|(i, _)| i.to_uppercase());
    let base = instance.or_else(|| sets.smallest_around(piece).map(str::to_owned));
    let base = base.unwrap_or_else(|| format!("ELEMENT{}", model.mesh.elements[piece[0]].name));
    let numbered = |n: usize| if n == 1 { base.clone() } else { format!("{base}{n}") };
    (1..).map(numbered).find(|name| !is_taken(name)).unwrap_or(base.clone())
}

/// Returns the index of the surface of a pair that carries the contact pressures. `is_first` is whether the surface of the
/// first domain does.
fn secondary_of(sides: &[PairedSurface; 2], (domains, is_first): &(ContactDomains, bool)) -> usize {
    let within = |side: &PairedSurface, domain: &ContactDomain| split(side, domain).1.is_empty();
    let first_is_first = within(&sides[0], &domains.sides[0]) && within(&sides[1], &domains.sides[1]);
    usize::from(first_is_first != *is_first)
}

/// Returns the name of a pair: `A_B`, or `A` for self-contact.
pub fn pair_name(contact: &SurfaceContact) -> String {
    let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
    let mut name = String::with_capacity(a.len() + 1 + b.len());
    name.push_str(a);
    if !a.eq_ignore_ascii_case(b) {
        name.push('_');
        name.push_str(b);
    }
    if name.is_ascii() {
        name.make_ascii_uppercase();
        return name;
    }
    name.to_uppercase()
}

/// Adds all pairs of surfaces and self-contact of each, except for the two sides of one shell.
fn add_all(all: &[PairedSurface], span: Span, meetings: &mut Vec<SurfacePairing>) {
    for (i, a) in all.iter().enumerate() {
        let others = all[i..].iter().filter(|b| !are_opposite(a, b));
        meetings.extend(others.filter_map(|b| paired([a, b], [all, all], span)));
    }
}

/// Adds the pairs of each surface of one list with each surface of another.
fn add_product([first, second]: [&[PairedSurface]; 2], span: Span, meetings: &mut Vec<SurfacePairing>) {
    for a in first {
        meetings.extend(second.iter().filter_map(|b| paired([a, b], [first, second], span)));
    }
}

/// Returns the pair of two surfaces, with an analytical surface as the second one. There is none of two analytical
/// surfaces, and none with the negative side of a shell whose positive side is in the same list: nodes contact an
/// analytical surface on either side.
fn paired([a, b]: [&PairedSurface; 2], lists: [&[PairedSurface]; 2], span: Span) -> Option<SurfacePairing> {
    let is_second_side = |one: &PairedSurface, list: &[PairedSurface]| list.iter().any(|o| is_opposite(one, o));
    match (a.analytical, b.analytical) {
        (Some(_), Some(_)) => None,
        (None, Some(_)) => (!is_second_side(a, lists[0])).then(|| SurfacePairing::new([a, b], span)),
        (Some(_), None) => (!is_second_side(b, lists[1])).then(|| SurfacePairing::new([b, a], span)),
        (None, None) => Some(SurfacePairing::new([a, b], span)),
    }
}

/// Returns whether a surface is the negative side of the shell whose positive side is another surface.
fn is_opposite(one: &PairedSurface, other: &PairedSurface) -> bool {
    one.sides.faces.first().is_some_and(|&(element, side)| {
        side == ElementSide::Negative && other.sides.faces.contains(&(element, ElementSide::Positive))
    })
}

fn are_opposite(a: &PairedSurface, b: &PairedSurface) -> bool {
    is_opposite(a, b) || is_opposite(b, a)
}

/// Assigns to each surface pair the index of the last domains that cover it, as its property `what` (interaction,
/// clearance, penalty factor or role). Returns the places of domains that cover no pair.
fn assign_domains(meetings: &mut Vec<SurfacePairing>, what: usize, domains: &[&ContactDomains]) -> Vec<Span> {
    let mut unused = Vec::new();
    for (index, domains) in domains.iter().enumerate() {
        let mut is_used = false;
        let take = |(mut m, covered): (SurfacePairing, bool)| {
            m.given[what] = if covered { Some(index) } else { m.given[what] };
            is_used |= covered;
            m
        };
        let parts = std::mem::take(meetings).into_iter().flat_map(|m| split_by_domains(m, domains));
        *meetings = parts.map(take).collect();
        unused.extend((!is_used).then_some(domains.span));
    }
    unused
}

/// Returns the parts of surface pairs that two domains do not cover.
fn uncovered(meetings: Vec<SurfacePairing>, domains: &ContactDomains) -> Vec<SurfacePairing> {
    meetings.into_iter().flat_map(|m| split_by_domains(m, domains)).filter(|m| !m.1).map(|m| m.0).collect()
}

/// Splits a surface pair into the parts that two domains cover (`true`) and the others.
fn split_by_domains(meeting: SurfacePairing, domains: &ContactDomains) -> Vec<(SurfacePairing, bool)> {
    if let [ContactDomain::All, ContactDomain::All] = &domains.sides {
        return vec![(meeting, true)];
    }
    let way = |m: SurfacePairing, [first, second]: [&ContactDomain; 2]| -> Vec<(SurfacePairing, bool)> {
        if m.is_of_one() {
            let whole = [first, second].map(|d| split(&m.sides[0], d).1.is_empty());
            return vec![(m, whole == [true; 2])];
        }
        let (a, rest_a) = split(&m.sides[0], first);
        let (b, rest_b) = split(&m.sides[1], second);
        if a.is_empty() || b.is_empty() {
            return vec![(m, false)];
        }
        let part_of = |sides: [PairedSurface; 2], covered: bool| (SurfacePairing { sides, ..m.clone() }, covered);
        let parts =
            [part_of([a.clone(), b], true), part_of([a, rest_b], false), part_of([rest_a, m.sides[1].clone()], false)];
        parts.into_iter().filter(|p| p.0.sides.iter().all(|s| !s.is_empty())).collect()
    };
    let [first, second] = &domains.sides;
    let parts = way(meeting, [first, second]);
    parts.into_iter().flat_map(|(m, covered)| if covered { vec![(m, true)] } else { way(m, [second, first]) }).collect()
}

/// Splits a surface into the parts inside and outside of a domain, with names of their parts.
fn split(surface: &PairedSurface, domain: &ContactDomain) -> (PairedSurface, PairedSurface) {
    let PairedSurface { sides, analytical } = surface;
    let part = |end: &str, faces: Vec<ElementFace>| {
        let name = if faces.len() == sides.faces.len() { sides.name.clone() } else { format!("{}{end}", sides.name) };
        PairedSurface::of_faces(&name, &faces)
    };
    let none = || PairedSurface::of_faces(&sides.name, &[]);
    match domain {
        ContactDomain::All => (surface.clone(), none()),
        ContactDomain::Analytical(id) if *analytical == Some(*id) => (surface.clone(), none()),
        ContactDomain::Surface(within) if analytical.is_none() => {
            let known: FxHashSet<ElementFace> = within.faces.iter().copied().collect();
            let (inside, outside) = sides.faces.iter().partition(|f| known.contains(*f));
            (part(&format!(".{}", within.name), inside), part(&format!(".NOT.{}", within.name), outside))
        }
        ContactDomain::Analytical(_) | ContactDomain::Surface(_) => (none(), surface.clone()),
    }
}

/// Returns the ledger row of general contact, which lists all surfaces of the contact domain.
pub fn general_row(general: &GeneralContact, context: &CurveContext, report: &mut Report) -> usize {
    *context.general_row.get_or_init(|| add_general_row(general, context.pairs, report))
}

fn add_general_row(general: &GeneralContact, pairs: &[SurfaceContact], report: &mut Report) -> usize {
    let general_pairs = || pairs.iter().filter(|p| p.general);
    let (mut surfaces, mut names, mut previous) = (BTreeSet::new(), Vec::new(), None);
    for pair in general_pairs() {
        for (at, side) in pair.sides.iter().enumerate() {
            let is_analytical = pair.analytical.as_ref().is_some_and(|a| a.side == at);
            let surface = (&side.name, if is_analytical { " (analytical)" } else { "" });
            // The first surface of a pair is mostly that of the pair before.
            if previous != Some(surface) && surfaces.insert(surface) {
                names.push(format!("{}{}", surface.0, surface.1));
            }
            previous = if at == 0 { Some(surface) } else { previous };
        }
    }
    let mut detail = format!("surfaces {}", names.join(", "));
    detail += match general.detached_nodes {
        DetachedNodes::InContact => "",
        DetachedNodes::Excluded => "; without nodes of deleted elements",
        DetachedNodes::Merged => "; the mass of nodes of deleted elements joins their body",
    };
    report.ledger_row(general.span, "general contact", general_pairs().count(), "pairs", detail)
}
