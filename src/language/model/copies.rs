//! Copies and coordinate mappings of meshes: `*NCOPY`, `*ELCOPY`, `*NMAP`, `*SYSTEM`, `*TRANSFORM`.

use std::collections::HashMap;

use super::budget::BudgetedItem;
use super::context::Context;
use super::families::{LocalSystem, MeshReader};
use super::names::SetKind;
use super::placement::read_placement;
use super::refinement::curves::{AffineMap, polar_point};
use super::{elements, nodes, sets};
use crate::deck::{Card, DataLine, Diagnostic, Span};

/// An affine map of the r-z plane: fixed point, and images of the unit vectors along r and z.
#[derive(Clone, Copy, Debug)]
struct PlaneMapping {
    fixed: [f64; 2],
    along: [[f64; 2]; 2],
}

impl PlaneMapping {
    /// Returns the reflection across the line through a point along a direction; `None` for a zero direction.
    fn mirror(point: [f64; 2], direction: [f64; 2]) -> Option<PlaneMapping> {
        let square = direction[0] * direction[0] + direction[1] * direction[1];
        let [r, z] = direction;
        let (cosine, sine) = ((r * r - z * z) / square, 2.0 * r * z / square);
        (square > 0.0).then_some(PlaneMapping { fixed: point, along: [[cosine, sine], [sine, -cosine]] })
    }

    /// Returns the reflection through a point.
    fn point_reflection(point: [f64; 2]) -> PlaneMapping {
        PlaneMapping { fixed: point, along: [[-1.0, 0.0], [0.0, -1.0]] }
    }

    fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        let d = [p[0] - self.fixed[0], p[1] - self.fixed[1]];
        [0, 1].map(|i| self.fixed[i] + d[0] * self.along[0][i] + d[1] * self.along[1][i])
    }
}

/// Copies nodes with shifted labels (ABAQUS Keywords Reference Guide, *NCOPY). SHIFT translates and rotates them as
/// `*INSTANCE` does; REFLECT reflects them through a point or across a line or plane.
pub fn read_ncopy(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let Some(change) = label_shift(context, card, "CHANGE NUMBER") else { return };
    let Some(old) = context.required(card, "OLD SET").and_then(|w| nodes::nodes_in_order(context, mesh, w)) else {
        return;
    };
    let Some(place) = copy_transform(context, card) else { return };
    if !context.fits_budget(BudgetedItem::Nodes, old.len() as u128, card.span) {
        return;
    }
    // Nodes of a part have the coordinates of its instance, but the copy is defined in the coordinates of the part.
    let placement = mesh.placement.clone();
    let image = |point| match &placement {
        Some(placement) => placement.apply(place(placement.undo(point))),
        None => place(point),
    };
    let mut made = Vec::with_capacity(old.len());
    let mut images = HashMap::new();
    for node in old {
        let Some(label) = nodes::label_of_index(context, node) else { continue };
        let copy = image(context.model.mesh.points[node]);
        made.push(nodes::place_generated(context, mesh, label.saturating_add(change), copy, card.span));
        images.insert(node, made[made.len() - 1]);
    }
    if context.deck.mesh_scaling.is_some() {
        let map = AffineMap::of(image);
        context.scaling.curves.record_images(&images, &map);
    }
    sets::collect(context, SetKind::Nodes, card, "NEW SET", made);
}

fn label_shift(context: &mut Context<'_>, card: &Card, name: &str) -> Option<i64> {
    let word = context.required(card, name)?;
    let change = word.integer(&mut context.diagnostics)?;
    if change == 0 {
        context.out_of_range(word.span, format!("{name} must not be zero, because the copies need their own labels"));
    }
    (change != 0).then_some(change)
}

/// Returns the coordinate transformation of a `*NCOPY` card.
#[allow(clippy::type_complexity)] // The function depends on the card.
fn copy_transform(context: &mut Context<'_>, card: &Card) -> Option<Box<dyn Fn([f64; 2]) -> [f64; 2]>> {
    if card.has("SHIFT") {
        let placement = if card.lines.is_empty() { None } else { Some(read_placement(context, card)?) };
        return Some(Box::new(move |p| placement.as_ref().map_or(p, |placement| placement.apply(p))));
    }
    let Some(kind) = card.read::<Option<usize>>("REFLECT") else {
        let diagnostic = Diagnostic::error("M101", "*NCOPY requires SHIFT or REFLECT=");
        return context.diagnostics.refuse(diagnostic.at(card.span, "no transformation given"));
    };
    let mapping = reflection(context, card, kind)?;
    Some(Box::new(move |p| mapping.apply(p)))
}

fn reflection(context: &mut Context<'_>, card: &Card, kind: usize) -> Option<PlaneMapping> {
    let line = context.first_line(card)?;
    let [a, b] = [space_point(context, line, 0)?, space_point(context, line, 3)?];
    let way = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let (flat, leaves) = ([a[0], a[1]], "this reflection maps points out of the r-z plane");
    let mapping = if kind == 0 {
        (a[2] == 0.0).then(|| PlaneMapping::point_reflection(flat))
    } else if kind == 1 {
        match (way[2] == 0.0, way[0] == 0.0 && way[1] == 0.0) {
            (true, _) if a[2] == 0.0 => PlaneMapping::mirror(flat, [way[0], way[1]]),
            (false, true) => Some(PlaneMapping::point_reflection(flat)),
            _ => None,
        }
    } else {
        let second = card.lines.get(1).unwrap_or(line);
        let c = space_point(context, second, 0)?;
        let other = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
        // The plane is perpendicular to the r-z plane if its normal is in the r-z plane.
        let normal = [
            way[1] * other[2] - way[2] * other[1],
            way[2] * other[0] - way[0] * other[2],
            way[0] * other[1] - way[1] * other[0],
        ];
        let upright = normal[2].abs() <= 1e-9 * normal[0].abs().max(normal[1].abs());
        if upright { PlaneMapping::mirror(flat, [-normal[1], normal[0]]) } else { None }
    };
    if mapping.is_none() {
        context.error("M126", leaves, line.span, "these points");
    }
    mapping
}

/// Reads three coordinates, starting at a field; empty fields are zero.
fn space_point(context: &mut Context<'_>, line: &DataLine, first: usize) -> Option<[f64; 3]> {
    context.numbers_or(line, first, 0.0)
}

/// Reads the points a and b of a local system, and c on the second line; `c_of` gives its default.
fn system_points(
    context: &mut Context<'_>,
    card: &Card,
    line: &DataLine,
    c_of: impl Fn([f64; 3], [f64; 3]) -> [f64; 3],
) -> Option<SystemPoints> {
    let (a, b) = (space_point(context, line, 0), space_point(context, line, 3));
    let (a, b) = (a?, b?);
    let c = card.lines.get(1).map_or(Some(c_of(a, b)), |second| space_point(context, second, 0))?;
    Some(SystemPoints { points: [a, b, c], is_alone: line.fields.len() <= 3 })
}

/// Points that define a local system.
struct SystemPoints {
    /// Origin, and the points that define the axes.
    points: [[f64; 3]; 3],
    /// Whether only the origin is given.
    is_alone: bool,
}

/// Copies elements with shifted element and node labels (ABAQUS Keywords Reference Guide, *ELCOPY). REFLECT
/// reverses the node order, for copies of reflected nodes.
pub fn read_elcopy(context: &mut Context<'_>, card: &Card) {
    let shift_of_nodes = context.required(card, "SHIFT NODES").and_then(|w| w.integer(&mut context.diagnostics));
    let (Some(change), Some(shift)) = (label_shift(context, card, "ELEMENT SHIFT"), shift_of_nodes) else {
        return;
    };
    let Some(old) = context.required(card, "OLD SET").and_then(|w| context.element_members(w)) else { return };
    if !context.fits_budget(BudgetedItem::Elements, old.len() as u128, card.span) {
        return;
    }
    let mut made = Vec::with_capacity(old.len());
    for element in old {
        let (kind, nodes) = {
            let e = &context.model.mesh.elements[element];
            (e.kind, e.nodes.clone())
        };
        let label = context.model.mesh.elements[element].name.rsplit('.').next().and_then(|l| l.parse::<i64>().ok());
        let labels: Vec<i64> = nodes.iter().filter_map(|&n| nodes::label_of_index(context, n)).collect();
        let Some(label) = label.map(|l| l.saturating_add(change)) else { continue };
        let Some(mut nodes) = elements::shifted(context, &labels, shift, label, card.span) else { return };
        if card.has("REFLECT") && nodes.len() > 2 {
            nodes[1..].reverse();
        }
        made.extend(elements::add_element(context, label, kind, nodes[..].into(), card.span));
    }
    sets::collect(context, SetKind::Elements, card, "NEW SET", made);
}

/// Maps nodes from coordinates of a local system (ABAQUS Keywords Reference Guide, *NMAP): RECTANGULAR, or
/// CYLINDRICAL about an axis perpendicular to the r-z plane, with angles in degrees.
pub fn read_nmap(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let Some(nodes) = context.required(card, "NSET").and_then(|w| context.node_members(w)) else { return };
    let Some(line) = context.first_line(card) else { return };
    let Some(system) = system_points(context, card, line, |a, _| [a[0], a[1] + 1.0, a[2]]) else { return };
    let polar = card.read("TYPE");
    let axes = if polar { system.cylindrical_axes() } else { system.plane_axes() };
    let [a, ..] = system.points;
    let Some([e1, e2]) = axes else {
        let message = "this local system is not in the r-z plane";
        let diagnostic = Diagnostic::error("M126", message).at(line.span, "these points");
        return context.diagnostics.push(diagnostic.help(
            "the axis a-b of CYLINDRICAL must be perpendicular to the r-z \
                          plane, for example a = 0, 0, 0 and b = 0, 0, 1",
        ));
    };
    let factors = card.lines.get(2).map_or(Some([1.0; 2]), |third| context.numbers_or(third, 0, 1.0));
    let Some(factors) = factors else { return };
    let scale = factors.map(|factor| if factor == 0.0 { 1.0 } else { factor });
    let placement = mesh.placement.as_ref();
    let local = |p: [f64; 2]| {
        let p = placement.map_or(p, |placement| placement.undo(p));
        [scale[0] * p[0], scale[1] * p[1]]
    };
    let global = |local: [f64; 2]| {
        let position = [0, 1].map(|i| a[i] + local[0] * e1[i] + local[1] * e2[i]);
        placement.map_or(position, |placement| placement.apply(position))
    };
    let points = &mut context.model.mesh.points;
    let mut is_straightened = false;
    if context.deck.mesh_scaling.is_some() && polar {
        let places = nodes.iter().map(|&node| (node, local(points[node])));
        context.scaling.curves.record_polar(places, AffineMap::of(global));
    } else if context.deck.mesh_scaling.is_some() {
        let same = nodes.iter().map(|&node| (node, node)).collect();
        is_straightened = context.scaling.curves.record_images(&same, &AffineMap::of(|p| global(local(p))));
    }
    for node in nodes {
        let [first, second] = local(points[node]);
        points[node] = global(if polar { polar_point(first, second) } else { [first, second] });
    }
    if is_straightened {
        let message = "unequal scale factors change arcs into ellipses, whose edges are straight in the refined mesh";
        let help = "use equal factors, or fit the boundary with --curved";
        context.warning("M193", message, card.span, "these nodes are on arcs", help);
    }
}

/// Reports nodes that were generated again at other coordinates: an error if elements become degenerate, else a
/// warning.
pub fn report_regenerated_nodes(context: &mut Context<'_>, mesh: &mut MeshReader) {
    let bad = mesh.shapeless_elements.len();
    context.missing.bodies |= bad > 0;
    let mut again: Vec<(Span, (i64, usize))> = std::mem::take(&mut mesh.regenerated_by_card).into_iter().collect();
    again.sort_unstable_by_key(|(span, _)| (span.file, span.start));
    for (span, (label, count)) in again {
        let more = if count > 1 { format!(" and {} more nodes are", count - 1) } else { " is".into() };
        let message = format!("node {label}{more} generated again at other coordinates");
        let diagnostic =
            if bad > 0 { Diagnostic::error("M164", message) } else { Diagnostic::warning("M164", message) };
        let help = "choose increments so that all generated nodes have different labels";
        let label = match bad {
            0 => "the last coordinates are used".to_owned(),
            _ => format!("the last coordinates are used, and {bad} elements with these nodes are degenerate"),
        };
        context.diagnostics.push(diagnostic.at(span, label).help(help));
    }
}

impl SystemPoints {
    /// Returns the axes of a rectangular system in the r-z plane: from a to b, and perpendicular to it towards c.
    fn plane_axes(&self) -> Option<[[f64; 2]; 2]> {
        if self.is_alone {
            return Some([[1.0, 0.0], [0.0, 1.0]]);
        }
        let [a, b, c] = self.points;
        let (way, side) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let turn = way[0] * side[1] - way[1] * side[0];
        let is_in_plane = turn != 0.0 && self.points.iter().all(|p| p[2] == 0.0);
        is_in_plane.then(|| axes_along(way, turn)).flatten()
    }

    /// Returns the directions at 0 and 90 degrees of a cylindrical system. Its axis from a to b is perpendicular to the
    /// r-z plane, and c is at 0 degrees.
    fn cylindrical_axes(&self) -> Option<[[f64; 2]; 2]> {
        let [a, b, c] = self.points;
        let up = b[2] - a[2];
        let is_normal = b[0] == a[0] && b[1] == a[1] && up != 0.0;
        is_normal.then(|| axes_along([c[0] - a[0], c[1] - a[1]], up)).flatten()
    }
}

/// Returns the unit vector along a direction, and the one that is rotated from it by 90 degrees in the sense of `turn`.
fn axes_along(direction: [f64; 2], turn: f64) -> Option<[[f64; 2]; 2]> {
    let length = libm::hypot(direction[0], direction[1]);
    let first = direction.map(|component| component / length);
    (length != 0.0).then(|| [first, [-turn.signum() * first[1], turn.signum() * first[0]]])
}

/// Sets the local system of the following `*NODE` cards (ABAQUS Keywords Reference Guide, *SYSTEM). Without data
/// lines the coordinates are r and z again.
pub fn read_system(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let Some(line) = card.lines.first() else {
        mesh.system = None;
        return;
    };
    // Without c the local z axis is normal to the plane, as the global one.
    let c_of = |a: [f64; 3], b: [f64; 3]| [a[0] - (b[1] - a[1]), a[1] + (b[0] - a[0]), 0.0];
    let Some(system) = system_points(context, card, line, c_of) else { return };
    let [a, ..] = system.points;
    match system.plane_axes().filter(|_| a[2] == 0.0) {
        Some(axes) => mesh.system = Some(LocalSystem { origin: [a[0], a[1]], axes }),
        None => {
            let message = "this local system is not in the r-z plane, or its points are collinear";
            context.error("M126", message, line.span, "these points");
        }
    }
}

/// Reads transformed directions at nodes (ABAQUS Keywords Reference Guide, *TRANSFORM). Directions along r and z
/// have no effect; others are reported by [`check_transforms`] if the nodes have a condition or force.
pub fn read_transform(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    let Some(set) = context.required(card, "NSET") else { return };
    let Some(nodes) = context.node_members(set) else { return };
    let Some(line) = context.first_line(card) else { return };
    let (Some(a), Some(b)) = (space_point(context, line, 0), space_point(context, line, 3)) else { return };
    let rectangular = card.value("TYPE").is_none_or(|w| w.is("R"));
    let as_they_are = rectangular && a[0] > 0.0 && a[1] == 0.0 && a[2] == 0.0 && b[1] > 0.0 && b[2] == 0.0;
    if as_they_are {
        context.inert(card, "its directions are r and z");
    } else {
        mesh.transforms.push((nodes, card.span));
        context.inert(card, "no condition or force uses its directions");
    }
}

/// Reports conditions and forces on nodes with transformed directions, which are not supported.
pub fn check_transforms(context: &mut Context<'_>, mesh: &mut MeshReader) {
    for (nodes, span) in std::mem::take(&mut mesh.transforms) {
        let steps = &context.model.steps;
        let meant = |list: &[usize]| list.iter().any(|n| nodes.contains(n));
        let conditions = || steps.iter().flat_map(|s| &s.boundaries);
        // A node that is fixed along r and z is fixed in all directions.
        let whole = |b: &&super::types::BoundaryCondition| {
            b.value == 0.0 && conditions().any(|o| o.dof + b.dof == 3 && o.nodes == b.nodes && o.value == 0.0)
        };
        let fixed = conditions().find(|b| b.dof < 3 && meant(&b.nodes) && !whole(b)).map(|b| b.span);
        let pushed = steps.iter().flat_map(|s| &s.loads).find_map(|l| match &l.kind {
            super::types::LoadKind::Concentrated { nodes, .. } if meant(nodes) => Some(l.span),
            _ => None,
        });
        let Some(given) = fixed.or(pushed) else { continue };
        let message = "conditions in transformed directions are not supported";
        let diagnostic =
            Diagnostic::error("M104", message).at(given, "on nodes of a *TRANSFORM").at(span, "transformed here");
        context.diagnostics.push(diagnostic.help("give them along r and z, or write the direction as an *EQUATION"));
        context.model.origin.inert.retain(|i| i.span != span);
    }
}
