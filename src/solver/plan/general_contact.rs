//! General contact as pairs of surfaces: exterior surfaces of the bodies, inclusions, exclusions and property
//! assignments.

use std::collections::HashSet;
use std::rc::Rc;

use super::Compiler;
use super::pieces::pieces;
use crate::model::{ContactDomain, ElementKind, ElementSide, GeneralContact, SideSelection, Step, SurfaceContact};

type ElementFace = (usize, ElementSide);

/// Two surfaces in general contact, or one with itself. Exclusions and assignments split it into parts.
#[derive(Clone)]
struct SurfacePairing {
    sides: [SideSelection; 2],
    /// Indices of the assigned interaction, clearance, penalty factor and role.
    given: [Option<usize>; 4],
    span: crate::deck::Span,
}

impl SurfacePairing {
    fn is_of_one(&self) -> bool {
        self.sides[0].name == self.sides[1].name
    }
}

impl Compiler<'_> {
    /// Finds the contact pairs of each step: those of `*CONTACT PAIR` and those of general contact.
    pub(super) fn find_pairs(&mut self) {
        let steps = &self.model.steps;
        for (index, step) in steps.iter().enumerate() {
            let before = index.checked_sub(1).map(|i| &steps[i]);
            let goes_on =
                |b: &Step| b.surface_contacts == step.surface_contacts && b.general_contact == step.general_contact;
            if before.is_some_and(goes_on) {
                self.pairs.extend(self.pairs.last().cloned());
                continue;
            }
            let general = step.general_contact.iter().flat_map(|general| self.general_pairs(general));
            let pairs: Vec<SurfaceContact> = step.surface_contacts.iter().cloned().chain(general).collect();
            for name in pairs.iter().map(pair_name) {
                if !self.pair_names.contains(&name) {
                    self.pair_names.push(name);
                }
            }
            self.pairs.push(Rc::new(pairs));
        }
    }

    fn general_pairs(&self, general: &GeneralContact) -> Vec<SurfaceContact> {
        let mut meetings = self.included_meetings(general);
        for domains in &general.excluded {
            meetings = uncovered(meetings, domains);
        }
        meetings = assign_domains(meetings, 0, general.assigned.iter().map(|a| &a.domains));
        meetings = assign_domains(meetings, 1, general.clearances.iter().map(|c| &c.0));
        meetings = assign_domains(meetings, 2, general.penalties.iter().map(|p| &p.0));
        meetings = assign_domains(meetings, 3, general.roles.iter().map(|r| &r.0));
        meetings.retain(|m| m.sides.iter().any(|s| self.is_deforming(s)));
        let contact = |m: SurfacePairing| {
            let [interaction, clearance, penalty, role] = m.given;
            let assigned = interaction.map(|index| &general.assigned[index]);
            SurfaceContact {
                law: assigned.map(|a| a.law.clone()).unwrap_or_default(),
                interaction: assigned.and_then(|a| a.interaction),
                analytical: None,
                general: true,
                no_thickness: false,
                clearance: clearance.map(|index| general.clearances[index].1),
                penalty: penalty.map(|index| general.penalties[index].1),
                secondary: role.map(|index| secondary_of(&m.sides, &general.roles[index])),
                cpset: None,
                sides: m.sides,
                span: m.span,
            }
        };
        meetings.into_iter().map(contact).collect()
    }

    /// Returns the surface pairs of all inclusions. Faces that several inclusions pair are included once.
    fn included_meetings(&self, general: &GeneralContact) -> Vec<SurfacePairing> {
        let all = self.outsides();
        let mut meetings = Vec::new();
        let of_all = general.included.iter().find(|i| matches!(i.0, [ContactDomain::All, ContactDomain::All]));
        if general.all || of_all.is_some() {
            add_all(&all, of_all.map_or(general.span, |i| i.1), &mut meetings);
            return meetings;
        }
        for (index, (domains, span)) in general.included.iter().enumerate() {
            let mut own = match domains {
                [ContactDomain::Surface(a), ContactDomain::Surface(b)] => {
                    vec![SurfacePairing { sides: [a.clone(), b.clone()], given: [None; 4], span: *span }]
                }
                [_, ContactDomain::Surface(one)] | [ContactDomain::Surface(one), _] => {
                    let others = all.iter().filter(|o| one.faces.iter().all(|f| !o.faces.contains(f)));
                    let with = |o: &SideSelection| SurfacePairing {
                        sides: [one.clone(), o.clone()],
                        given: [None; 4],
                        span: *span,
                    };
                    others.map(with).collect()
                }
                [ContactDomain::All, ContactDomain::All] => Vec::new(),
            };
            let earlier = general.included[..index].iter().filter(|(earlier, _)| {
                // An inclusion with all surfaces does not contain the surface's own body.
                let is_of_two = !earlier.contains(&ContactDomain::All);
                is_of_two || earlier == domains || earlier.iter().rev().eq(domains)
            });
            for (earlier, _) in earlier {
                own = uncovered(own, earlier);
            }
            meetings.extend(own);
        }
        meetings
    }

    fn is_deforming(&self, sides: &SideSelection) -> bool {
        sides.faces.iter().any(|f| self.places.elements.contains_key(&f.0))
    }

    /// Returns the exterior surface of each connected part; for shells the positive and the negative side.
    fn outsides(&self) -> Vec<SideSelection> {
        let mesh = &self.model.mesh;
        let known = |e: &usize| self.places.elements.contains_key(e) || self.body_of_element.contains_key(e);
        let elements: Vec<usize> =
            (0..mesh.elements.len()).filter(|e| !mesh.elements[*e].kind.is_discrete()).filter(known).collect();
        let outside = mesh.exterior_faces();
        let mut surfaces: Vec<SideSelection> = Vec::new();
        for piece in pieces(mesh, &elements) {
            let name = self.name_of_piece(&piece, &surfaces);
            let solid = outside.iter().filter(|f| piece.binary_search(&f.0).is_ok()).copied().collect();
            let shells =
                piece.iter().filter(|&&e| matches!(mesh.elements[e].kind, ElementKind::Rax2 | ElementKind::Sax1));
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
    pub(super) fn name_of_piece(&self, piece: &[usize], taken: &[SideSelection]) -> String {
        let model = self.model;
        let instance = model.mesh.elements[piece[0]].name.rsplit_once('.').map(|(i, _)| i.to_uppercase());
        let holds = |members: &[usize]| piece.iter().all(|e| members.binary_search(e).is_ok());
        let sets = model.element_sets.iter().filter(|s| holds(&s.1.members));
        let set = sets.min_by_key(|s| s.1.members.len()).map(|s| s.0.clone());
        let base = instance.or(set).unwrap_or_else(|| format!("ELEMENT{}", model.mesh.elements[piece[0]].name));
        let is_taken =
            |name: &str| taken.iter().any(|t| t.name.trim_end_matches("_SPOS").trim_end_matches("_SNEG") == name);
        let numbered = |n: usize| if n == 1 { base.clone() } else { format!("{base}{n}") };
        (1..).map(numbered).find(|name| !is_taken(name)).unwrap_or(base.clone())
    }
}

/// Returns the index of the surface of a pair that carries the contact pressures. `is_first` is whether the surface of the
/// first domain does.
fn secondary_of(sides: &[SideSelection; 2], (domains, is_first): &([ContactDomain; 2], bool)) -> usize {
    let within = |side: &SideSelection, domain: &ContactDomain| split(side, domain).1.faces.is_empty();
    let first_is_first = within(&sides[0], &domains[0]) && within(&sides[1], &domains[1]);
    usize::from(first_is_first != *is_first)
}

/// Returns the name of a pair: `A_B`, or `A` for self-contact.
pub(super) fn pair_name(contact: &SurfaceContact) -> String {
    let [a, b] = [0, 1].map(|i| contact.sides[i].name.to_uppercase());
    if a == b { a } else { format!("{a}_{b}") }
}

/// Adds all pairs of surfaces and self-contact of each, except for the two sides of one shell.
fn add_all(all: &[SideSelection], span: crate::deck::Span, meetings: &mut Vec<SurfacePairing>) {
    for (i, a) in all.iter().enumerate() {
        for b in &all[i..] {
            let sides_of_one = a.name != b.name && a.faces[0].0 == b.faces[0].0;
            if sides_of_one {
                continue;
            }
            meetings.push(SurfacePairing { sides: [a.clone(), b.clone()], given: [None; 4], span });
        }
    }
}

/// Assigns to each surface pair the index of the last domain that covers it, as its property `what` (interaction,
/// clearance or penalty factor).
fn assign_domains<'a>(
    mut meetings: Vec<SurfacePairing>,
    what: usize,
    domains: impl Iterator<Item = &'a [ContactDomain; 2]>,
) -> Vec<SurfacePairing> {
    for (index, domains) in domains.enumerate() {
        let take = |(mut m, covered): (SurfacePairing, bool)| {
            m.given[what] = if covered { Some(index) } else { m.given[what] };
            m
        };
        meetings = meetings.into_iter().flat_map(|m| split_by_domains(m, domains)).map(take).collect();
    }
    meetings
}

/// Returns the parts of surface pairs that two domains do not cover.
fn uncovered(meetings: Vec<SurfacePairing>, domains: &[ContactDomain; 2]) -> Vec<SurfacePairing> {
    meetings.into_iter().flat_map(|m| split_by_domains(m, domains)).filter(|m| !m.1).map(|m| m.0).collect()
}

/// Splits a surface pair into the parts that two domains cover (`true`) and the others.
fn split_by_domains(meeting: SurfacePairing, domains: &[ContactDomain; 2]) -> Vec<(SurfacePairing, bool)> {
    if let [ContactDomain::All, ContactDomain::All] = domains {
        return vec![(meeting, true)];
    }
    let way = |m: SurfacePairing, [first, second]: [&ContactDomain; 2]| -> Vec<(SurfacePairing, bool)> {
        if m.is_of_one() {
            let whole = [first, second].map(|d| split(&m.sides[0], d).1.faces.is_empty());
            return vec![(m, whole == [true; 2])];
        }
        let (a, rest_a) = split(&m.sides[0], first);
        let (b, rest_b) = split(&m.sides[1], second);
        if a.faces.is_empty() || b.faces.is_empty() {
            return vec![(m, false)];
        }
        let of = |sides: [SideSelection; 2], covered: bool| (SurfacePairing { sides, ..m.clone() }, covered);
        let parts = [of([a.clone(), b], true), of([a, rest_b], false), of([rest_a, m.sides[1].clone()], false)];
        parts.into_iter().filter(|p| p.0.sides.iter().all(|s| !s.faces.is_empty())).collect()
    };
    let [first, second] = domains;
    let parts = way(meeting, [first, second]);
    parts.into_iter().flat_map(|(m, covered)| if covered { vec![(m, true)] } else { way(m, [second, first]) }).collect()
}

/// Splits a surface into the parts inside and outside of a domain, with names of their parts.
fn split(sides: &SideSelection, domain: &ContactDomain) -> (SideSelection, SideSelection) {
    let part = |end: &str, faces: Vec<ElementFace>| {
        let name = if faces.len() == sides.faces.len() { sides.name.clone() } else { format!("{}{end}", sides.name) };
        SideSelection { name, surface: true, faces, free_face_elements: Vec::new() }
    };
    match domain {
        ContactDomain::All => (sides.clone(), part("", Vec::new())),
        ContactDomain::Surface(surface) => {
            let known: HashSet<ElementFace> = surface.faces.iter().copied().collect();
            let (within, without) = sides.faces.iter().partition(|f| known.contains(*f));
            (part(&format!(".{}", surface.name), within), part(&format!(".NOT.{}", surface.name), without))
        }
    }
}
