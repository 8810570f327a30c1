//! General contact as pairs of surfaces: the outside of each body, which of them may meet and how they interact.
//! Never here: curves, the contact itself.

use std::collections::HashSet;
use std::rc::Rc;

use super::Compiler;
use super::pieces::pieces;
use crate::model::{ContactDomain, ElementKind, GeneralContact, Side, Sides, Step, SurfaceContact};

type Face = (usize, Side);

/// Two surfaces that may meet, or twice the same, while exclusions and assignments take them apart.
#[derive(Clone)]
struct Meeting {
    sides: [Sides; 2],
    /// Which of the interactions, of the clearances and of the factors on penalty springs it is given.
    given: [Option<usize>; 3],
    span: crate::deck::Span,
}

impl Meeting {
    fn is_of_one(&self) -> bool {
        self.sides[0].name == self.sides[1].name
    }
}

impl Compiler<'_> {
    /// Finds all pairs of surfaces of elements in force in each step: those that the deck names, and those of general contact.
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
        meetings = give(meetings, 0, general.assigned.iter().map(|a| &a.domains));
        meetings = give(meetings, 1, general.clearances.iter().map(|c| &c.0));
        meetings = give(meetings, 2, general.penalties.iter().map(|p| &p.0));
        meetings.retain(|m| m.sides.iter().any(|s| self.is_deforming(s)));
        let contact = |m: Meeting| {
            let [interaction, clearance, penalty] = m.given;
            let assigned = interaction.map(|index| &general.assigned[index]);
            SurfaceContact {
                law: assigned.map(|a| a.law.clone()).unwrap_or_default(),
                interaction: assigned.and_then(|a| a.interaction),
                sides: m.sides,
                analytical: None,
                general: true,
                thin: false,
                clearance: clearance.map(|index| general.clearances[index].1),
                penalty: penalty.map(|index| general.penalties[index].1),
                cpset: None,
                span: m.span,
            }
        };
        meetings.into_iter().map(contact).collect()
    }

    /// The meetings of all inclusions. Faces that several inclusions pair, or one that a later step repeats, meet once.
    fn included_meetings(&self, general: &GeneralContact) -> Vec<Meeting> {
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
                    vec![Meeting { sides: [a.clone(), b.clone()], given: [None; 3], span: *span }]
                }
                [_, ContactDomain::Surface(one)] | [ContactDomain::Surface(one), _] => {
                    let others = all.iter().filter(|o| one.faces.iter().all(|f| !o.faces.contains(f)));
                    let with = |o: &Sides| Meeting { sides: [one.clone(), o.clone()], given: [None; 3], span: *span };
                    others.map(with).collect()
                }
                [ContactDomain::All, ContactDomain::All] => Vec::new(),
            };
            let earlier = general.included[..index].iter().filter(|(earlier, _)| {
                // With all surfaces one does not meet the body that it is part of.
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

    fn is_deforming(&self, sides: &Sides) -> bool {
        sides.faces.iter().any(|f| self.places.elements.contains_key(&f.0))
    }

    /// The outside of each body, by elements that hang together by nodes; of shells both sides, one after the other.
    fn outsides(&self) -> Vec<Sides> {
        let mesh = &self.model.mesh;
        let known = |e: &usize| self.places.elements.contains_key(e) || self.body_of_element.contains_key(e);
        let elements: Vec<usize> =
            (0..mesh.elements.len()).filter(|e| !mesh.elements[*e].kind.is_discrete()).filter(known).collect();
        let outside = mesh.outside();
        let mut surfaces: Vec<Sides> = Vec::new();
        for piece in pieces(mesh, &elements) {
            let name = self.name_of_piece(&piece, &surfaces);
            let solid = outside.iter().filter(|f| piece.binary_search(&f.0).is_ok()).copied().collect();
            let shells =
                piece.iter().filter(|&&e| matches!(mesh.elements[e].kind, ElementKind::Rax2 | ElementKind::Sax1));
            let both = |side: Side| shells.clone().map(move |&e| (e, side)).collect::<Vec<Face>>();
            let parts = [("", solid), ("_SPOS", both(Side::Positive)), ("_SNEG", both(Side::Negative))];
            let parts = parts.into_iter().filter(|p| !p.1.is_empty());
            surfaces.extend(parts.map(|(end, faces)| Sides {
                name: format!("{name}{end}"),
                surface: true,
                faces,
                whole: Vec::new(),
            }));
        }
        surfaces
    }

    /// The name of the instance, or of the smallest set that holds all of it, with a number where it is taken.
    pub(super) fn name_of_piece(&self, piece: &[usize], taken: &[Sides]) -> String {
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

/// `A_B`, or `A` of a surface that may meet itself.
pub(super) fn pair_name(contact: &SurfaceContact) -> String {
    let [a, b] = [0, 1].map(|i| contact.sides[i].name.to_uppercase());
    if a == b { a } else { format!("{a}_{b}") }
}

/// Every two surfaces, and each with itself, but not both sides of one shell.
fn add_all(all: &[Sides], span: crate::deck::Span, meetings: &mut Vec<Meeting>) {
    for (i, a) in all.iter().enumerate() {
        for b in &all[i..] {
            let sides_of_one = a.name != b.name && a.faces[0].0 == b.faces[0].0;
            if sides_of_one {
                continue;
            }
            meetings.push(Meeting { sides: [a.clone(), b.clone()], given: [None; 3], span });
        }
    }
}

/// Gives what each of some domains covers its number, the last counts: `what` of those that a meeting may have.
fn give<'a>(
    mut meetings: Vec<Meeting>,
    what: usize,
    domains: impl Iterator<Item = &'a [ContactDomain; 2]>,
) -> Vec<Meeting> {
    for (index, domains) in domains.enumerate() {
        let take = |(mut m, covered): (Meeting, bool)| {
            m.given[what] = if covered { Some(index) } else { m.given[what] };
            m
        };
        meetings = meetings.into_iter().flat_map(|m| apart(m, domains)).map(take).collect();
    }
    meetings
}

/// The parts of meetings that two domains do not cover.
fn uncovered(meetings: Vec<Meeting>, domains: &[ContactDomain; 2]) -> Vec<Meeting> {
    meetings.into_iter().flat_map(|m| apart(m, domains)).filter(|m| !m.1).map(|m| m.0).collect()
}

/// Takes a meeting apart into what two domains cover and what they do not.
fn apart(meeting: Meeting, domains: &[ContactDomain; 2]) -> Vec<(Meeting, bool)> {
    if let [ContactDomain::All, ContactDomain::All] = domains {
        return vec![(meeting, true)];
    }
    let way = |m: Meeting, [first, second]: [&ContactDomain; 2]| -> Vec<(Meeting, bool)> {
        if m.is_of_one() {
            let whole = [first, second].map(|d| split(&m.sides[0], d).1.faces.is_empty());
            return vec![(m, whole == [true; 2])];
        }
        let (a, rest_a) = split(&m.sides[0], first);
        let (b, rest_b) = split(&m.sides[1], second);
        if a.faces.is_empty() || b.faces.is_empty() {
            return vec![(m, false)];
        }
        let of = |sides: [Sides; 2], covered: bool| (Meeting { sides, ..m.clone() }, covered);
        let parts = [of([a.clone(), b], true), of([a, rest_b], false), of([rest_a, m.sides[1].clone()], false)];
        parts.into_iter().filter(|p| p.0.sides.iter().all(|s| !s.faces.is_empty())).collect()
    };
    let [first, second] = domains;
    let parts = way(meeting, [first, second]);
    parts.into_iter().flat_map(|(m, covered)| if covered { vec![(m, true)] } else { way(m, [second, first]) }).collect()
}

/// What of a surface is in a domain, and what is not. A part has a name of its own.
fn split(sides: &Sides, domain: &ContactDomain) -> (Sides, Sides) {
    let part = |end: &str, faces: Vec<Face>| {
        let name = if faces.len() == sides.faces.len() { sides.name.clone() } else { format!("{}{end}", sides.name) };
        Sides { name, surface: true, faces, whole: Vec::new() }
    };
    match domain {
        ContactDomain::All => (sides.clone(), part("", Vec::new())),
        ContactDomain::Surface(surface) => {
            let known: HashSet<Face> = surface.faces.iter().copied().collect();
            let (within, without) = sides.faces.iter().partition(|f| known.contains(*f));
            (part(&format!(".{}", surface.name), within), part(&format!(".NOT.{}", surface.name), without))
        }
    }
}
