//! Contact of surfaces of elements: which curves there are, which of a pair carries the pressures, what is told of how they start.
//! Never here: how analytical surfaces lie, the contact itself.

use std::collections::{HashMap, HashSet};

use super::analytical::friction_of;
use super::contact_doubts::Met;
use super::general_contact::pair_name;
use super::pieces::pieces;
use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::contact::analytical::Analytical;
use crate::constraint::contact::curve::{Carrier, Curve, Point};
use crate::constraint::contact::{Begins, Contact, Overlap, Pair};
use crate::deck::Diagnostic;
use crate::kernel::interaction::{GapHeat, Law, Overclosure};
use crate::model::{AnalyticalSide, GeneralContact, Side, Sides, SurfaceContact};

/// A facet is met from behind no deeper than this many of its lengths.
const DEEPEST: f64 = 2.0;
/// The same of a shell at least.
const LEAST_DEPTH: f64 = 0.1;
/// Overlaps at the start up to this part of a facet are chords of curved surfaces that fit.
const FIT: f64 = 0.05;
/// Gaps and overlaps up to this part of a facet are taken as the clearance that a card gives (ABAQUS Keywords Reference Guide,
/// *CONTACT CLEARANCE: approximately one-tenth of the element size).
const SEARCHED: f64 = 0.1;

/// Points and curves as they are found.
#[derive(Default)]
pub(super) struct Found {
    points: Vec<Point>,
    places: Vec<[f64; 2]>,
    point_of_node: HashMap<usize, u32>,
    curves: Vec<Curve>,
    /// The element and the nodes of each facet that lies bare.
    behind: Vec<Vec<(usize, [usize; 2])>>,
    /// The longest facet and the mean length of each, and whether what carries it deforms.
    lengths: Vec<[f64; 2]>,
    deforms: Vec<bool>,
    by_name: HashMap<(String, bool), usize>,
    pub(super) analyticals: Vec<Analytical>,
}

/// What points and facets are judged by.
pub(super) struct Around<'a> {
    /// Degrees of freedom whose motion is prescribed, and that follow others.
    pub(super) prescribed: &'a HashSet<(usize, usize)>,
    kept: &'a HashSet<(usize, usize)>,
    /// The outside of what is solid.
    skin: &'a Skin,
}

/// An edge between two places.
type Edge = [[f64; 2]; 2];

/// The outside of what is solid, but for the axis, and which piece of elements that hang together each edge and element is of.
#[derive(Default)]
pub(super) struct Skin {
    edges: Vec<(Edge, usize)>,
    piece_of: HashMap<usize, usize>,
}

impl Skin {
    /// What may end the body behind a facet of an element: its own piece, or where it is none of a solid all.
    fn behind(&self, element: usize) -> impl Iterator<Item = Edge> + '_ {
        let own = self.piece_of.get(&element).copied();
        self.edges.iter().filter(move |e| own.is_none_or(|own| own == e.1)).map(|e| e.0)
    }
}

fn is_off_axis(edge: &Edge) -> bool {
    edge.iter().any(|p| p[0] != 0.0)
}

impl Compiler<'_> {
    /// All contact of a step.
    pub(super) fn contact(
        &mut self,
        step: usize,
        prescribed: &HashSet<(usize, usize)>,
        state: &State,
    ) -> Option<Box<dyn Constraint>> {
        let (mut found, mut pairs, mut laws) = (Found::default(), Vec::new(), Vec::<Law>::new());
        let mut springs: Vec<Law> = Vec::new();
        let mut spans = Vec::new();
        let wanted = self.pairs[step].clone();
        if wanted.is_empty() {
            return None;
        }
        let general = self.model.steps[step].general_contact.as_ref();
        let around = Around { prescribed, kept: &self.kept.concerned(), skin: &self.solid_skin() };
        for contact in &wanted {
            if let Some(side) = &contact.analytical {
                let Some((at, id)) = self.analytical((contact, side), &around, &mut found, state) else { continue };
                let law = (&mut laws, &mut springs);
                let Some(pair) = self.analytical_pair((contact, side), (at, id), law, &found, state) else { continue };
                pairs.push(pair);
                spans.push(None);
                continue;
            }
            let curves = [0, 1].map(|i| self.curve(contact, i, &around, &mut found));
            let [Some(first), Some(second)] = curves else { continue };
            if !found.deforms[first] && !found.deforms[second] {
                let message = "both surfaces of this pair are rigid";
                let finding = Diagnostic::error("P021", message).at(contact.span, "nothing of it deforms");
                self.diagnostics.push(finding.help("one of them must belong to what deforms"));
                continue;
            }
            if contact.general && general.is_some_and(|g| g.drops_points) {
                [first, second].into_iter().for_each(|curve| found.curves[curve].drop_orphans());
            }
            let curves = found.order(first, second);
            let others = Some(curves[1]);
            let law = self.law(contact, [Some(curves[0]), others], (&mut laws, &mut springs), &found, state);
            let Some([law, of_points]) = law else { continue };
            let length = found.lengths[first][0].min(found.lengths[second][0]);
            let id = match general {
                Some(general) if contact.general => self.general_row(general, &wanted),
                _ => self.contact_row(contact, &found, curves[0]),
            };
            if state.thermal.as_ref().is_some_and(|t| t.heat.is_some()) {
                self.heat_row(contact);
            }
            let met = Met {
                curves: curves.map(|c| &found.curves[c]),
                points: &found.points,
                places: &found.places,
                length: found.lengths[curves[0]][1],
            };
            self.doubt_pair(contact, step, met, state);
            let mut pair = Pair::new(id, self.pair_number(contact), curves, law, length);
            (pair.of_points, pair.springs, pair.first) = (of_points, has_springs(contact), curves[0] == first);
            pair.begins = begins(contact, length);
            pairs.push(pair);
            spans.push(Some((contact, length)));
        }
        if pairs.is_empty() {
            return None;
        }
        let Found { points, places, curves, analyticals, .. } = found;
        let first = laws.len();
        pairs.iter_mut().filter(|p| p.springs).for_each(|p| p.law += first);
        let any = !springs.is_empty();
        laws.extend(springs);
        let mut contact = Contact::new(points, curves, analyticals, pairs, laws);
        if any {
            contact = contact.with_springs(first);
        }
        if let Some(heat) = state.thermal.as_ref().and_then(|t| t.heat.as_ref()) {
            contact = contact.with_heat(|node| heat.temperature(node).is_finite());
        }
        let overlaps = contact.start(&places);
        for ((contact, length), overlap) in spans.into_iter().zip(overlaps).filter_map(|(s, o)| Some((s?, o))) {
            self.tell_start(contact, length, overlap);
        }
        Some(Box::new(contact))
    }

    /// The pair of a curve with an analytical surface.
    fn analytical_pair(
        &mut self,
        (contact, side): (&SurfaceContact, &AnalyticalSide),
        ([curve, analytical], id): ([usize; 2], usize),
        laws: (&mut Vec<Law>, &mut Vec<Law>),
        found: &Found,
        state: &State,
    ) -> Option<Pair> {
        let [law, of_points] = self.law(contact, [Some(curve), None], laws, found, state)?;
        let length = found.lengths[curve][0];
        let number = self.pair_number(contact);
        let mut pair = Pair::in_front_of(id, number, curve, analytical, law, length);
        (pair.of_points, pair.springs, pair.first) = (of_points, has_springs(contact), side.side == 1);
        pair.begins = begins(contact, length);
        if state.thermal.as_ref().is_some_and(|t| t.heat.is_some()) {
            self.heat_row(contact);
        }
        Some(pair)
    }

    /// The law of a pair of curves, of which the second may be rigid, among all laws or those of penalty springs; and that of points
    /// that meet by themselves.
    fn law(
        &mut self,
        contact: &SurfaceContact,
        [own, other]: [Option<usize>; 2],
        (laws, springs): (&mut Vec<Law>, &mut Vec<Law>),
        found: &Found,
        state: &State,
    ) -> Option<[usize; 2]> {
        let law = match contact.penalty.filter(|_| has_springs(contact)).zip(own) {
            None => place_of(laws, contact.law.clone()),
            Some((factor, own)) => {
                let all = self.springs(contact, factor, (own, other), found, state)?;
                springs.extend(all);
                springs.len() - found.curves[own].own.len()
            }
        };
        // What acts on a point by itself is no pressure: it does not give way.
        let hard = Law { overclosure: Overclosure::Hard, ..contact.law.clone() };
        Some([law, place_of(laws, hard)])
    }

    fn pair_number(&self, contact: &SurfaceContact) -> usize {
        let name = pair_name(contact);
        self.pair_names.iter().position(|n| *n == name).unwrap_or_default()
    }

    fn contact_row(&mut self, contact: &SurfaceContact, found: &Found, own: usize) -> usize {
        let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
        let between = if contact.is_of_one() { format!("{a} with itself") } else { format!("{a} and {b}") };
        // A pressure-overclosure relationship takes the place of penalty springs.
        let kind = match (&contact.law.overclosure, contact.penalty) {
            (Overclosure::Hard, Some(factor)) => format!("penalty springs {factor} times as stiff as the elements"),
            (Overclosure::Hard, None) => "hard".into(),
            (Overclosure::Linear(_) | Overclosure::Spring(_), _) => "linear".into(),
            (Overclosure::Exponential(_), _) => "exponential".into(),
            (Overclosure::Table(_), _) => "tabular".into(),
        };
        let friction = friction_of(contact);
        let count = found.curves[own].facets.len();
        let clearance = match contact.clearance {
            Some(clearance) if clearance.gap > 0.0 => format!(", clearance {:e}", clearance.gap),
            _ => String::new(),
        };
        self.cause(contact.span, "contact", count, "facets", format!("{between}, {kind}{friction}{clearance}"))
    }

    /// The row of the heat that crosses between two surfaces, where temperatures are solved for.
    fn heat_row(&mut self, contact: &SurfaceContact) {
        let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
        let GapHeat { over_clearance, over_pressure, fraction, to_first } = &contact.law.heat;
        let mut parts = Vec::new();
        if contact.law.friction.is_there() {
            parts.push(format!("{fraction} of the work of friction, {to_first} of it to {a}"));
        }
        for (rows, over) in [(over_clearance, "clearance"), (over_pressure, "pressure")] {
            if !rows.is_empty() {
                parts.push(format!("conductance over {} rows of {over}", rows.len()));
            }
        }
        if !parts.is_empty() {
            let detail = format!("{a} and {b}: {}", parts.join(", "));
            self.cause(contact.span, "contact heat", 1, "pair", detail);
        }
    }

    /// Laws of the penalty springs of each point of a curve in front of another: twice one over the sum of the ways that both
    /// surfaces give under a unit of pressure, so that of two like bodies springs are as stiff as one layer of elements.
    fn springs(
        &mut self,
        contact: &SurfaceContact,
        factor: f64,
        (own, other): (usize, Option<usize>),
        found: &Found,
        state: &State,
    ) -> Option<Vec<Law>> {
        let softness = |curve: usize| {
            let of = found.behind[curve].iter().map(|&(e, nodes)| self.softness(e, nodes, state));
            of.collect::<Option<Vec<f64>>>()
        };
        let others = other.map_or(Some(Vec::new()), softness);
        let (Some(own_ways), Some(others)) = (softness(own).filter(|ways| !ways.is_empty()), others) else {
            let message = "penalty springs are as stiff as the elements behind them, and that cannot be told of these";
            let finding = Diagnostic::error("P021", message).at(contact.span, "this pair");
            self.diagnostics
                .push(finding.help("give *SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR, or leave PENALTY out"));
            return None;
        };
        // An analytical surface does not give.
        let beside = others.iter().sum::<f64>() / others.len().max(1) as f64;
        let curve = &found.curves[own];
        let stiffness = |index: usize| {
            let around = curve.around_own(index).iter().filter_map(|f| own_ways.get(f.0 as usize));
            let (sum, count) = around.fold((0.0, 0), |(sum, count), way| (sum + way, count + 1));
            // Points that come to lie bare have springs as those that do in the mean.
            let way = match count {
                0 => own_ways.iter().sum::<f64>() / own_ways.len() as f64,
                _ => sum / f64::from(count),
            };
            factor * 2.0 / (way + beside)
        };
        let law = |index| Law { overclosure: Overclosure::Spring(stiffness(index)), ..contact.law.clone() };
        Some((0..curve.own.len()).map(law).collect())
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
    pub(super) fn curve(
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
        let (mut facets, mut behind) = (Vec::new(), Vec::new());
        for &(element, side) in &sides.faces {
            let Some(mut ends) = self.model.mesh.ends(element, side) else { continue };
            // The body lies to the left of the way; seen from the side of its normal a shell lies to the right.
            if side == Side::Positive {
                ends.reverse();
            }
            let mut facet = [0; 2];
            for (point, node) in facet.iter_mut().zip(ends) {
                *point = match self.point_of(node, around, found) {
                    Ok(point) => point,
                    Err(why) => {
                        self.diagnostics.push(Diagnostic::error("P021", why).at(contact.span, "this pair"));
                        return None;
                    }
                };
            }
            facets.push((facet, element));
            behind.push((element, ends));
        }
        // What lies on the axis is the inside of a body.
        facets.retain(|(f, _)| f.iter().any(|&p| found.places[p as usize][0] != 0.0));
        behind.retain(|(_, ends)| ends.iter().any(|&n| self.model.mesh.points[n][0] != 0.0));
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
        let curve = found.add_curve(&facets, lift, bare, (around.skin, &self.shells_of(sides)));
        found.behind.push(behind);
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

    /// The point of a node.
    pub(super) fn point_of(&self, node: usize, around: &Around<'_>, found: &mut Found) -> Result<u32, String> {
        match found.point_of_node.get(&node) {
            Some(&known) => Ok(known),
            None => Ok(found.add(node, self.contact_point(node, around)?, self.model.mesh.points[node])),
        }
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
    fn solid_skin(&self) -> Skin {
        let mesh = &self.model.mesh;
        let solids: Vec<usize> = (0..mesh.elements.len()).filter(|e| mesh.elements[*e].kind.is_solid()).collect();
        let mut skin = Skin::default();
        for (piece, elements) in pieces(mesh, &solids).into_iter().enumerate() {
            skin.piece_of.extend(elements.into_iter().map(|e| (e, piece)));
        }
        for (element, side) in mesh.outside() {
            let (Some(ends), Some(&piece)) = (mesh.ends(element, side), skin.piece_of.get(&element)) else { continue };
            let edge = ends.map(|n| mesh.points[n]);
            skin.edges.extend(is_off_axis(&edge).then_some((edge, piece)));
        }
        skin
    }

    /// Shells of a surface.
    fn shells_of(&self, sides: &Sides) -> Vec<Edge> {
        let mesh = &self.model.mesh;
        let shells = sides.faces.iter().filter(|f| matches!(f.1, Side::Positive | Side::Negative));
        let shells = shells.filter_map(|&(e, side)| mesh.ends(e, side)).map(|e| e.map(|n| mesh.points[n]));
        shells.filter(is_off_axis).collect()
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

    /// A point that a body carries at the origin.
    pub(super) fn add_carried(&mut self, body: usize) -> u32 {
        self.points.push(Point { carrier: Carrier::Body(body, [0.0; 2]), free: [false, true] });
        self.places.push([0.0; 2]);
        self.points.len() as u32 - 1
    }

    /// How deep in an analytical surface the points of a curve may be where it gives way.
    pub(super) fn deepest(&self, curve: usize) -> f64 {
        DEEPEST * self.lengths[curve][0]
    }

    /// A curve of points without facets.
    pub(super) fn add_points(&mut self, curve: Curve) -> usize {
        self.deforms.push(true);
        // They have no length that gaps could be held against.
        self.lengths.push([f64::INFINITY; 2]);
        self.behind.push(Vec::new());
        self.curves.push(curve);
        self.curves.len() - 1
    }

    fn add_curve(
        &mut self,
        facets: &[([u32; 2], usize)],
        lift: Vec<f64>,
        bare: usize,
        (solids, shells): (&Skin, &[Edge]),
    ) -> usize {
        let ends = |f: &[u32; 2]| f.map(|p| self.places[p as usize]);
        let lengths: Vec<f64> = facets.iter().map(|(f, _)| length(ends(f))).collect();
        let mut depths: Vec<f64> = facets[..bare]
            .iter()
            .zip(&lengths)
            .map(|((f, element), l)| depth(ends(f), *l, solids.behind(*element).chain(shells.iter().copied())))
            .collect();
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

/// Whether penalty springs stand between the surfaces of a pair: a pressure-overclosure relationship takes their place.
fn has_springs(contact: &SurfaceContact) -> bool {
    contact.penalty.is_some() && contact.law.overclosure == Overclosure::Hard
}

/// What gaps of a pair at the start are taken as.
fn begins(contact: &SurfaceContact, length: f64) -> Option<Begins> {
    contact.clearance.map(|clearance| {
        let searched = SEARCHED * length;
        let range = [-clearance.below.unwrap_or(searched), clearance.above.unwrap_or(searched)];
        Begins { gap: clearance.gap, range }
    })
}

/// Where a law is among others; it is added where it is not.
fn place_of(laws: &mut Vec<Law>, law: Law) -> usize {
    laws.iter().position(|l| *l == law).unwrap_or_else(|| {
        laws.push(law);
        laws.len() - 1
    })
}

fn length([a, b]: [[f64; 2]; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

/// How deep behind a facet something is still in contact with it: half the way to the next skin of its body behind it, and no more than
/// [`DEEPEST`] lengths.
fn depth([a, b]: Edge, length: f64, skin: impl Iterator<Item = Edge>) -> f64 {
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let inward = [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
    let mut nearest = 2.0 * DEEPEST * length;
    for [p, q] in skin {
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
