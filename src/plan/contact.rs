//! Contact of surfaces of elements: which curves there are, which of a pair carries the pressures, what is told of how they start.
//! Never here: analytical surfaces, the contact itself.

use std::collections::{HashMap, HashSet};

use super::Compiler;
use super::general_contact::pair_name;
use super::pieces::pieces;
use crate::constraint::Constraint;
use crate::constraint::contact::curve::{Carrier, Curve, Point};
use crate::constraint::contact::{Contact, Overlap, Pair};
use crate::deck::Diagnostic;
use crate::kernel::interaction::{Law, Overclosure};
use crate::model::{GeneralContact, Side, Sides, SurfaceContact};

/// A facet is met from behind no deeper than this many of its lengths.
const DEEPEST: f64 = 2.0;
/// The same of a shell at least.
const LEAST_DEPTH: f64 = 0.1;
/// Overlaps at the start up to this part of a facet are chords of curved surfaces that fit.
const FIT: f64 = 0.05;

/// Points and curves as they are found.
#[derive(Default)]
struct Found {
    points: Vec<Point>,
    places: Vec<[f64; 2]>,
    point_of_node: HashMap<usize, u32>,
    curves: Vec<Curve>,
    /// The longest facet and the mean length of each, and whether what carries it deforms.
    lengths: Vec<[f64; 2]>,
    deforms: Vec<bool>,
    by_name: HashMap<(String, bool), usize>,
}

/// What points and facets are judged by.
struct Around<'a> {
    /// Degrees of freedom whose motion is prescribed, and that follow others.
    prescribed: &'a HashSet<(usize, usize)>,
    kept: &'a HashSet<(usize, usize)>,
    /// The outside of what is solid.
    skin: &'a [[[f64; 2]; 2]],
}

fn is_off_axis(edge: &[[f64; 2]; 2]) -> bool {
    edge.iter().any(|p| p[0] != 0.0)
}

impl Compiler<'_> {
    /// All contact of surfaces of elements in a step.
    pub(super) fn contact(&mut self, step: usize, prescribed: &HashSet<(usize, usize)>) -> Option<Box<dyn Constraint>> {
        let (mut found, mut pairs, mut laws) = (Found::default(), Vec::new(), Vec::<Law>::new());
        let mut spans = Vec::new();
        let wanted = self.pairs[step].clone();
        if wanted.is_empty() {
            return None;
        }
        let general = self.model.steps[step].general_contact.as_ref();
        let around = Around { prescribed, kept: &self.kept.concerned(), skin: &self.solid_skin() };
        for contact in &wanted {
            let curves = [0, 1].map(|i| self.curve(contact, i, &around, &mut found));
            let [Some(first), Some(second)] = curves else { continue };
            if !found.deforms[first] && !found.deforms[second] {
                let message = "both surfaces of this pair are rigid";
                let finding = Diagnostic::error("P021", message).at(contact.span, "nothing of it deforms");
                self.diagnostics.push(finding.help("one of them must belong to what deforms"));
                continue;
            }
            let law = laws.iter().position(|l| *l == contact.law).unwrap_or_else(|| {
                laws.push(contact.law.clone());
                laws.len() - 1
            });
            if contact.general && general.is_some_and(|g| g.drops_points) {
                [first, second].into_iter().for_each(|curve| found.curves[curve].drop_orphans());
            }
            let curves = found.order(first, second);
            let length = found.lengths[first][0].min(found.lengths[second][0]);
            let id = match general {
                Some(general) if contact.general => self.general_row(general, &wanted),
                _ => self.contact_row(contact, &found, curves[0]),
            };
            let name = pair_name(contact);
            let number = self.pair_names.iter().position(|n| *n == name).unwrap_or_default();
            let mut pair = Pair::new(id, number, curves, law, length);
            (pair.fits, pair.first) = (contact.fits, curves[0] == first);
            pairs.push(pair);
            spans.push((contact, length));
        }
        if pairs.is_empty() {
            return None;
        }
        let Found { points, places, curves, .. } = found;
        let mut contact = Contact::new(points, curves, pairs, laws);
        let overlaps = contact.start(&places);
        for ((contact, length), overlap) in spans.into_iter().zip(overlaps) {
            self.tell_start(contact, length, overlap);
        }
        Some(Box::new(contact))
    }

    fn contact_row(&mut self, contact: &SurfaceContact, found: &Found, own: usize) -> usize {
        let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
        let between = if contact.is_of_one() { format!("{a} with itself") } else { format!("{a} and {b}") };
        let kind = match &contact.law.overclosure {
            Overclosure::Hard => "hard",
            Overclosure::Linear(_) => "linear",
            Overclosure::Exponential(_) => "exponential",
            Overclosure::Table(_) => "tabular",
        };
        let friction = match contact.law.friction.at_rest {
            _ if !contact.law.friction.is_there() => String::new(),
            f64::INFINITY => ", rough".into(),
            coefficient => format!(", friction {coefficient}"),
        };
        let count = found.curves[own].facets.len();
        self.cause(contact.span, "contact", count, "facets", format!("{between}, {kind}{friction}"))
    }

    /// One row for all pairs of general contact.
    fn general_row(&mut self, general: &GeneralContact, pairs: &[SurfaceContact]) -> usize {
        let own: Vec<String> = pairs.iter().filter(|p| p.general).map(pair_name).collect();
        let mut detail = own.iter().take(6).cloned().collect::<Vec<_>>().join(" ");
        if own.len() > 6 {
            detail += " …";
        }
        if general.drops_points {
            detail += ", without points of deleted elements";
        }
        self.cause(general.span, "general contact", own.len(), "pairs", detail)
    }

    /// One surface of a pair; `None` where it cannot be in contact, which is told.
    fn curve(
        &mut self,
        contact: &SurfaceContact,
        which: usize,
        around: &Around<'_>,
        found: &mut Found,
    ) -> Option<usize> {
        let sides = &contact.sides[which];
        let key = (sides.name.clone(), contact.thin);
        if let Some(&known) = found.by_name.get(&key) {
            return Some(known);
        }
        let mut facets = Vec::new();
        for &(element, side) in &sides.faces {
            let Some(mut ends) = self.model.mesh.ends(element, side) else { continue };
            // The body lies to the left of the way; seen from the side of its normal a shell lies to the right.
            if side == Side::Positive {
                ends.reverse();
            }
            let mut facet = [0; 2];
            for (point, node) in facet.iter_mut().zip(ends) {
                *point = match found.point_of_node.get(&node) {
                    Some(&known) => known,
                    None => match self.contact_point(node, around) {
                        Ok(at) => found.add(node, at, self.model.mesh.points[node]),
                        Err(why) => {
                            let finding = Diagnostic::error("P021", why).at(contact.span, "this pair");
                            self.diagnostics.push(finding);
                            return None;
                        }
                    },
                };
            }
            facets.push((facet, element));
        }
        // What lies on the axis is the inside of a body.
        facets.retain(|(f, _)| f.iter().any(|&p| found.places[p as usize][0] != 0.0));
        if facets.is_empty() {
            let message = format!("surface `{}` has no facets that could meet anything", sides.name);
            self.diagnostics.push(Diagnostic::error("P021", message).at(contact.span, "this pair"));
            return None;
        }
        let bare = facets.len();
        if self.deletes() {
            self.hidden_facets(around, found, &mut facets);
        }
        let lift = facets.iter().map(|f| if contact.thin { 0.0 } else { 0.5 * self.thickness_of(f.1) }).collect();
        let curve = found.add_curve(&facets, lift, bare, self.skin_of(sides, around.skin));
        found.by_name.insert(key, curve);
        Some(curve)
    }

    /// Adds the faces between elements of the bodies that bare facets belong to, one for each side: they lie bare when the element
    /// in front is deleted.
    fn hidden_facets(&self, around: &Around<'_>, found: &mut Found, facets: &mut Vec<([u32; 2], usize)>) {
        let mesh = &self.model.mesh;
        let own: HashSet<usize> = facets.iter().map(|f| f.1).collect();
        let solids: Vec<usize> =
            self.places.elements.keys().copied().filter(|e| mesh.elements[*e].kind.is_solid()).collect();
        for piece in pieces(mesh, &solids).iter().filter(|p| p.iter().any(|e| own.contains(e))) {
            let edges = |e: usize| {
                let nodes = &mesh.elements[e].nodes;
                (0..nodes.len()).map(move |i| [nodes[i], nodes[(i + 1) % nodes.len()]])
            };
            let all: HashSet<[usize; 2]> = piece.iter().flat_map(|&e| edges(e)).collect();
            for &e in piece {
                for edge in edges(e).filter(|[a, b]| all.contains(&[*b, *a])) {
                    let points = edge.map(|node| match found.point_of_node.get(&node) {
                        Some(&known) => Some(known),
                        None => {
                            let point = self.contact_point(node, around).ok()?;
                            Some(found.add(node, point, mesh.points[node]))
                        }
                    });
                    // What follows other nodes is left out: it never lies bare to contact.
                    if let [Some(a), Some(b)] = points {
                        facets.push(([a, b], e));
                    }
                }
            }
        }
    }

    /// Thickness of a shell at the start; 0 of other elements.
    fn thickness_of(&self, element: usize) -> f64 {
        let section = self.model.shell_sections.iter().find(|s| s.elements.contains(&element));
        section.map_or(0.0, |s| s.thickness)
    }

    /// What carries a point of a surface in contact, and along which axes it moves freely.
    fn contact_point(&self, node: usize, Around { prescribed, kept, .. }: &Around<'_>) -> Result<Point, String> {
        let mesh = &self.model.mesh;
        if let Some(place) = self.places.free_node(node) {
            if kept.contains(&(place, 0)) || kept.contains(&(place, 1)) {
                let name = &mesh.node_names[node];
                let why = "follows others (*EQUATION, *MPC, *COUPLING, *TIE): leave it out of the surface";
                return Err(format!("node {name} is in contact and {why}"));
            }
            let free = [0, 1].map(|axis| !prescribed.contains(&(place, axis)));
            return Ok(Point { carrier: Carrier::Node(place), free });
        }
        let body = self.places.tied.get(&node).or_else(|| self.body_of_node.get(&node));
        match body {
            Some(&body) => Ok(Point { carrier: Carrier::Body(body, mesh.points[node]), free: [false, true] }),
            None => Err(format!("node {} belongs to no body", mesh.node_names[node])),
        }
    }

    /// The outside of all solids, but for the axis.
    fn solid_skin(&self) -> Vec<[[f64; 2]; 2]> {
        let mesh = &self.model.mesh;
        let edges = mesh.outside().into_iter().filter_map(|(e, side)| mesh.ends(e, side));
        edges.map(|edge| edge.map(|n| mesh.points[n])).filter(is_off_axis).collect()
    }

    /// The same, and the shells of a surface.
    fn skin_of(&self, sides: &Sides, solids: &[[[f64; 2]; 2]]) -> Vec<[[f64; 2]; 2]> {
        let mesh = &self.model.mesh;
        let shells = sides.faces.iter().filter(|f| matches!(f.1, Side::Positive | Side::Negative));
        let shells = shells.filter_map(|&(e, side)| mesh.ends(e, side)).map(|e| e.map(|n| mesh.points[n]));
        solids.iter().copied().chain(shells.filter(is_off_axis)).collect()
    }

    /// Says where the surfaces of a pair lie in each other.
    fn tell_start(&mut self, contact: &SurfaceContact, length: f64, overlap: Option<Overlap>) {
        let Some(Overlap { depth, place: [r, z] }) = overlap.filter(|o| o.depth > FIT * length) else { return };
        let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
        let message = format!("`{a}` and `{b}` lie in each other at the start, up to {depth:.3e} deep");
        let label = format!("deepest near ({r:.4e}, {z:.4e}); the overlap stays and grows no deeper");
        let finding = Diagnostic::warning("P111", message).at(contact.span, label);
        self.diagnostics.push(finding.help("move the bodies apart"));
    }
}

impl Found {
    fn add(&mut self, node: usize, point: Point, place: [f64; 2]) -> u32 {
        let index = self.points.len() as u32;
        self.points.push(point);
        self.places.push(place);
        self.point_of_node.insert(node, index);
        index
    }

    fn add_curve(
        &mut self,
        facets: &[([u32; 2], usize)],
        lift: Vec<f64>,
        bare: usize,
        skin: Vec<[[f64; 2]; 2]>,
    ) -> usize {
        let ends = |f: &[u32; 2]| f.map(|p| self.places[p as usize]);
        let lengths: Vec<f64> = facets.iter().map(|(f, _)| length(ends(f))).collect();
        let mut depths: Vec<f64> =
            facets[..bare].iter().zip(&lengths).map(|((f, _), l)| depth(ends(f), *l, &skin)).collect();
        // Behind a facet that comes to lie bare there may be no more than one element.
        depths.extend(lengths[bare..].iter().map(|l| 0.5 * l));
        // What lies behind the middle surface of a shell is on its other side.
        for (depth, (half, length)) in depths.iter_mut().zip(lift.iter().zip(&lengths)).filter(|d| *d.1.0 > 0.0) {
            *depth = half.max(LEAST_DEPTH * length);
        }
        let lengths = &lengths[..bare];
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let node = |p: u32| matches!(self.points[p as usize].carrier, Carrier::Node(_));
        self.deforms.push(facets[..bare].iter().any(|(f, _)| f.iter().any(|p| node(*p))));
        self.lengths.push([longest, lengths.iter().sum::<f64>() / lengths.len() as f64]);
        self.curves.push(Curve::new(facets.iter().map(|f| f.0).collect(), depths, bare, &self.places).lifted(lift));
        self.curves.len() - 1
    }

    /// Which of two curves carries the pressures, and the other: the finer of two that deform, never a rigid one.
    fn order(&self, first: usize, second: usize) -> [usize; 2] {
        let swaps = match (self.deforms[first], self.deforms[second]) {
            (true, true) => self.lengths[second][1] < self.lengths[first][1],
            (deforms, _) => !deforms,
        };
        if swaps { [second, first] } else { [first, second] }
    }
}

fn length([a, b]: [[f64; 2]; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

/// How deep behind a facet something is still in contact with it: half the way to the next skin behind it, and no more than
/// [`DEEPEST`] lengths.
fn depth([a, b]: [[f64; 2]; 2], length: f64, skin: &[[[f64; 2]; 2]]) -> f64 {
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let inward = [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
    let mut nearest = 2.0 * DEEPEST * length;
    for &[p, q] in skin {
        let (d, e) = ([p[0] - middle[0], p[1] - middle[1]], [q[0] - p[0], q[1] - p[1]]);
        let cross = inward[0] * e[1] - inward[1] * e[0];
        let way = (d[0] * e[1] - d[1] * e[0]) / cross;
        let part = (d[0] * inward[1] - d[1] * inward[0]) / cross;
        if (0.0..=1.0).contains(&part) && way > 1e-6 * length && way < nearest {
            nearest = way;
        }
    }
    0.5 * nearest
}
