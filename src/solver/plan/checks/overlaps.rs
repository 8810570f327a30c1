//! Overlaps of bodies: a warning for overlaps at the start of bodies without contact, and a check of all bodies during
//! the run.

use std::rc::Rc;

use rustc_hash::FxHashMap;

use crate::constraint::Constraint;
use crate::constraint::contact::curve::PointCarrier;
use crate::constraint::overlaps::{BodyOutline, ContactsOfBodies, OverlapMonitor, distance};
use crate::deck::{Diagnostic, Span};
use crate::kernel::lists::{sorted_pair, sorted_unique};
use crate::kernel::sorted_boxes::{SortedBoxes, is_within_body};
use crate::model::{ElementKind, ElementSide, Mesh, Model};
use crate::plan::constraints::links::tied_nodes;
use crate::plan::contact::general::name_of_piece;
use crate::plan::meshes::pieces::{SetsOfParts, exterior_faces_of, part_of_elements, pieces};
use crate::plan::{Bodies, Links, Pairs, Report, Scene, State, StepInput};

/// Accepted penetration of a node, as a fraction of the face length: meshes of matching curved surfaces overlap
/// slightly.
const FIT: f64 = 0.05;

/// Connected elements with their bounding box.
pub(super) struct ConnectedPart {
    pub(super) elements: Vec<usize>,
    low: [f64; 2],
    high: [f64; 2],
}

impl ConnectedPart {
    fn meets(&self, other: &ConnectedPart) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }
}

/// Returns the nodes of exterior faces off the axis, which is no surface of a body.
fn ends_off_axis(mesh: &Mesh, faces: &[(usize, ElementSide)]) -> impl Iterator<Item = [usize; 2]> {
    let ends = faces.iter().filter_map(|&(element, side)| mesh.side_nodes(element, side));
    ends.filter(|ends| ends.iter().any(|&n| mesh.points[n][0] != 0.0))
}

/// Warns of overlapping parts, once per pair.
pub(super) fn report_overlaps(
    scene: Scene,
    parts: &[ConnectedPart],
    (links, pairs): (&Links, &Pairs),
    report: &mut Report,
) {
    let mut close_parts = pairs_that_meet(parts);
    if close_parts.is_empty() {
        return;
    }
    let contacts = contacts_of(scene.model, links, pairs, parts);
    close_parts.retain(|pair| !contacts.connect(*pair) && !contacts.are_tied(*pair));
    if close_parts.is_empty() {
        return;
    }
    let faces = exterior_faces_of(&scene.model.mesh, elements_of(parts));
    for [a, b] in close_parts {
        let inside = [[a, b], [b, a]].map(|[a, b]| nodes_inside(scene.model, &parts[a], &parts[b], &faces[b]));
        let count = inside.iter().map(|f| f.0).sum::<usize>();
        let depth = inside.iter().map(|f| f.1).fold(0.0, f64::max);
        if count > 0 {
            report_overlap(scene.model, [&parts[a], &parts[b]], count, depth, report);
        }
    }
}

fn report_overlap(model: &Model, pieces: [&ConnectedPart; 2], count: usize, depth: f64, report: &mut Report) {
    let mesh = &model.mesh;
    let [a, b] = pieces.map(|p| &mesh.elements[p.elements[0]].name);
    let message = format!(
        "the bodies of elements {a} and {b} overlap at the start without contact between them: {count} nodes, up to {depth:.3e} deep"
    );
    let [first, second] = pieces.map(|p| section_of(model, p.elements[0]));
    let finding = Diagnostic::warning("P112", message).at(first, "of this body");
    let finding = if second == first { finding } else { finding.at(second, "and of this one") };
    report.push(finding.help("move them apart, use common nodes, or define contact (*CONTACT)"));
}

fn section_of(model: &Model, element: usize) -> Span {
    let section = model.sections.iter().find(|s| s.elements.contains(&element));
    section.map_or(model.mesh.elements[element].span, |s| s.span)
}

/// Returns whether an element belongs to a rigid body with six degrees of freedom.
fn is_spatial(bodies: &Bodies, element: usize) -> bool {
    bodies.of_element.get(&element).is_some_and(|&b| bodies.list[b].spatial)
}

/// Returns the connected parts of solid elements, in the order of their first elements.
pub(super) fn solid_parts(scene: Scene) -> Vec<ConnectedPart> {
    connected_parts(scene, ElementKind::is_solid)
}

/// Creates the check of bodies for overlaps; `None` if there are fewer than two.
pub fn overlapping_bodies(input: StepInput, report: &mut Report) -> Option<Box<dyn Constraint>> {
    let StepInput { scene, links, pairs, state, .. } = input;
    let lines = connected_parts(scene, |kind| kind == ElementKind::Rax2);
    let solids = solid_parts(scene);
    let count = solids.len();
    let parts: Vec<ConnectedPart> = solids.into_iter().chain(lines).collect();
    let deforms = |piece: &ConnectedPart| scene.places.elements.contains_key(&piece.elements[0]);
    let step = scene.model.steps.first().filter(|_| parts.len() > 1 && parts.iter().any(deforms))?;
    let faces = exterior_faces_of(&scene.model.mesh, elements_of(&parts));
    let sets = SetsOfParts::new(scene.model, elements_of(&parts));
    let outline = |(index, piece): (usize, &ConnectedPart)| BodyOutline {
        name: name_of_piece(scene.model, &piece.elements, &sets, |_| false),
        deforms: deforms(piece),
        is_solid: index < count,
        ..body_outline(scene, piece, &faces[index], state)
    };
    let outlines: Vec<BodyOutline> = parts.iter().enumerate().map(outline).collect();
    let count_of_pairs = OverlapMonitor::count_pairs(&outlines);
    if count_of_pairs == 0 {
        return None;
    }
    let detail = "check for overlap of bodies";
    let id = report.ledger_row(step.span, "look at bodies", count_of_pairs, "pairs", detail.into());
    Some(Box::new(OverlapMonitor::new(id, outlines, contacts_of(scene.model, links, pairs, &parts))))
}

/// Returns the contact pairs of all steps, by the parts on their sides, and the tied parts.
pub(super) fn contacts_of(model: &Model, links: &Links, pairs: &Pairs, parts: &[ConnectedPart]) -> ContactsOfBodies {
    let part_of = part_of_elements(&model.mesh, elements_of(parts));
    let of_sides = [(); 2].map(|()| vec![Vec::new(); parts.len()]);
    let mut contacts = ContactsOfBodies { pairs: of_sides, tied: tied_parts(model, links, &part_of) };
    let is_new = |step: &usize| *step == 0 || !Rc::ptr_eq(&pairs.by_step[*step], &pairs.by_step[*step - 1]);
    let pairs = (0..pairs.by_step.len()).filter(is_new).flat_map(|step| pairs.by_step[step].iter());
    for (contact, index) in pairs.zip(0..) {
        for (side, lists) in contact.sides.iter().zip(&mut contacts.pairs) {
            let mut previous = None;
            // Most sides belong to one part.
            let parts = side.faces.iter().filter_map(|face| part_of[face.0]);
            let on_side: Vec<u32> = sorted_unique(parts.filter(|&part| previous.replace(part) != Some(part)));
            on_side.into_iter().for_each(|part| lists[part as usize].push(index));
        }
    }
    contacts
}

/// Returns the pairs of tied parts, without a part that is tied to itself; `part_of` is the part of each element.
fn tied_parts(model: &Model, links: &Links, part_of: &[Option<u32>]) -> Vec<[u32; 2]> {
    let tied: FxHashMap<usize, usize> = tied_nodes(&links.surface_ties).map(|tied| (tied.node, tied.element)).collect();
    if tied.is_empty() {
        return Vec::new();
    }
    let pairs = model.mesh.elements.iter().zip(part_of).flat_map(|(element, part)| {
        let masters = element.nodes.iter().filter_map(|node| part_of[*tied.get(node)?]);
        masters.filter_map(move |master| Some(sorted_pair([(*part)?, master])))
    });
    sorted_unique(pairs.filter(|[a, b]| a != b))
}

/// Returns the outline of a part. If its elements can be deleted, the outline changes, and only its points are
/// checked.
fn body_outline(scene: Scene, piece: &ConnectedPart, outside: &[(usize, ElementSide)], state: &State) -> BodyOutline {
    let mesh: &Mesh = &scene.model.mesh;
    let group = scene.places.elements.get(&piece.elements[0]).map(|place| place.0);
    let encloses = mesh.elements[piece.elements[0]].kind.is_solid()
        && group.is_none_or(|_| {
            let groups = piece.elements.iter().filter_map(|e| scene.places.elements.get(e));
            groups.map(|place| &state.elements.groups[place.0]).all(|group| !group.properties().deletable)
        });
    let (mut points, mut known, mut faces) = (Vec::new(), FxHashMap::default(), Vec::new());
    let mut add = |node: usize| {
        *known.entry(node).or_insert_with(|| {
            points.push(match scene.places.free_node(node) {
                Some(solver_node) => PointCarrier::Node(solver_node),
                None => {
                    let body = scene.places.tied.get(&node).or_else(|| scene.bodies.of_node.get(&node));
                    PointCarrier::Body(body.copied().unwrap_or(0), mesh.points[node])
                }
            });
            points.len() as u32 - 1
        })
    };
    ends_off_axis(mesh, outside).for_each(|ends| faces.push(ends.map(&mut add)));
    if !mesh.elements[piece.elements[0]].kind.is_solid() {
        piece.elements.iter().flat_map(|&e| &mesh.elements[e].nodes).for_each(|&n| {
            add(n);
        });
    }
    if !encloses {
        faces.clear();
    }
    BodyOutline { points, faces, ..BodyOutline::default() }
}

fn connected_parts(scene: Scene, is: impl Fn(ElementKind) -> bool) -> Vec<ConnectedPart> {
    let mesh = &scene.model.mesh;
    let solids: Vec<usize> =
        (0..mesh.elements.len()).filter(|&e| is(mesh.elements[e].kind) && !is_spatial(scene.bodies, e)).collect();
    let piece = |elements: Vec<usize>| {
        let places = || elements.iter().flat_map(|&e| &mesh.elements[e].nodes).map(|&n| mesh.points[n]);
        let extreme = |f: fn(f64, f64) -> f64| [0, 1].map(|i| places().map(|p| p[i]).reduce(f).unwrap_or(0.0));
        ConnectedPart { low: extreme(f64::min), high: extreme(f64::max), elements }
    };
    pieces(mesh, &solids).into_iter().map(piece).collect()
}

/// Returns the number of nodes of a part inside another one with these exterior faces, beyond the accepted
/// penetration, and their maximum depth.
fn nodes_inside(
    model: &Model,
    piece: &ConnectedPart,
    other: &ConnectedPart,
    faces: &[(usize, ElementSide)],
) -> (usize, f64) {
    let mesh = &model.mesh;
    let mut nodes: Vec<usize> =
        sorted_unique(piece.elements.iter().flat_map(|&e| mesh.elements[e].nodes.iter().copied()));
    nodes.retain(|&n| is_within_body([other.low, other.high], mesh.points[n]));
    if nodes.is_empty() {
        return (0, 0.0);
    }
    let skin: Vec<[[f64; 2]; 2]> = ends_off_axis(mesh, faces).map(|ends| ends.map(|n| mesh.points[n])).collect();
    let (mut count, mut deepest) = (0, 0.0_f64);
    for n in nodes {
        let p = mesh.points[n];
        // Even-odd rule along r.
        let crosses = |[a, b]: &&[[f64; 2]; 2]| {
            (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        if skin.iter().filter(crosses).count() % 2 == 0 {
            continue;
        }
        let near = skin.iter().map(|face| distance(p, *face)).min_by(|x, y| x.0.total_cmp(&y.0));
        if let Some((depth, _)) = near.filter(|(depth, length)| *depth > FIT * length) {
            count += 1;
            deepest = deepest.max(depth);
        }
    }
    (count, deepest)
}

pub(super) fn elements_of(parts: &[ConnectedPart]) -> impl Iterator<Item = &[usize]> + Clone {
    parts.iter().map(|part| &part.elements[..])
}

/// Returns the pairs of parts whose boxes overlap, in ascending order.
fn pairs_that_meet(parts: &[ConnectedPart]) -> Vec<[usize; 2]> {
    let mut boxes = SortedBoxes::with_capacity(parts.len());
    boxes.sort(parts.iter().map(|part| [part.low, part.high]).zip(0..));
    let mut pairs = Vec::new();
    for (a, part) in parts.iter().enumerate() {
        boxes.near([part.low, part.high], 0.0, |b| pairs.push([a, b as usize]));
    }
    pairs.retain(|&[a, b]| a < b && parts[a].meets(&parts[b]));
    pairs.sort_unstable();
    pairs
}
