//! Copies and maps of a mesh: `*NCOPY`, `*ELCOPY`, `*NMAP`.
//! Never here: nodes and elements that are given one by one.

use super::budget::Good;
use super::builder::Builder;
use crate::deck::{Card, DataLine, Diagnostic, Span};

/// A motion of points in the r-z plane: origin, and what the unit vectors along r and z become.
#[derive(Clone, Copy, Debug)]
struct Mapping {
    fixed: [f64; 2],
    along: [[f64; 2]; 2],
}

impl Mapping {
    /// Reflection across the line through a point along a direction.
    fn mirror(point: [f64; 2], direction: [f64; 2]) -> Option<Mapping> {
        let square = direction[0] * direction[0] + direction[1] * direction[1];
        let [r, z] = direction;
        let (cosine, sine) = ((r * r - z * z) / square, 2.0 * r * z / square);
        (square > 0.0).then_some(Mapping { fixed: point, along: [[cosine, sine], [sine, -cosine]] })
    }

    /// Reflection at a point.
    fn through(point: [f64; 2]) -> Mapping {
        Mapping { fixed: point, along: [[-1.0, 0.0], [0.0, -1.0]] }
    }

    fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        let d = [p[0] - self.fixed[0], p[1] - self.fixed[1]];
        [0, 1].map(|i| self.fixed[i] + d[0] * self.along[0][i] + d[1] * self.along[1][i])
    }
}

impl Builder<'_> {
    /// Nodes copied with a shift of their numbers (ABAQUS Keywords Reference Guide, *NCOPY): SHIFT moves, then turns them as
    /// `*INSTANCE` does; REFLECT mirrors them at a point, a line or a plane.
    pub(super) fn ncopy(&mut self, card: &Card) {
        let Some(change) = self.change_of_labels(card, "CHANGE NUMBER") else { return };
        let Some(old) = self.required(card, "OLD SET").and_then(|w| self.nodes_in_order(w)) else { return };
        let Some(place) = self.copy_of_places(card) else { return };
        if !self.affords(Good::Nodes, old.len() as u128, card.span) {
            return;
        }
        let mut made = Vec::with_capacity(old.len());
        for node in old {
            let Some(label) = self.label_of_index(node) else { continue };
            let point = self.model.mesh.points[node];
            // A part's nodes stand where its instance puts them: the copy is made in the part.
            let copy = match &self.instance {
                Some(placement) => placement.apply(place(self, placement.undo(point))),
                None => place(self, point),
            };
            made.push(self.place_generated(label.saturating_add(change), copy, card.span));
        }
        if let Some(name) = card.value("NEW SET") {
            self.add_node_set(&name.text, made, card.span);
        }
    }

    fn change_of_labels(&mut self, card: &Card, name: &str) -> Option<i64> {
        let word = self.required(card, name)?;
        let change = word.integer(&mut self.diagnostics)?;
        if change == 0 {
            self.out_of_range(word.span, format!("{name} must not be zero: the copies would be the originals"));
        }
        (change != 0).then_some(change)
    }

    /// What a copy does to a point.
    #[allow(clippy::type_complexity)] // A function made of the card.
    fn copy_of_places(&mut self, card: &Card) -> Option<Box<dyn Fn(&Self, [f64; 2]) -> [f64; 2]>> {
        if card.has("SHIFT") {
            let placement = if card.lines.is_empty() { None } else { Some(self.placement(card)?) };
            return Some(Box::new(move |_, p| placement.as_ref().map_or(p, |placement| placement.apply(p))));
        }
        let Some(kind) = card.read::<Option<usize>>("REFLECT") else {
            let finding = Diagnostic::error("M101", "*NCOPY needs SHIFT or REFLECT=");
            return self.diagnostics.refuse(finding.at(card.span, "where do the copies stand?"));
        };
        let mapping = self.reflection(card, kind)?;
        Some(Box::new(move |_, p| mapping.apply(p)))
    }

    fn reflection(&mut self, card: &Card, kind: usize) -> Option<Mapping> {
        let line = self.first_line(card)?;
        let [a, b] = [self.space_point(line, 0)?, self.space_point(line, 3)?];
        let way = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let (flat, leaves) = ([a[0], a[1]], "this reflection leaves the r-z plane");
        let found = if kind == 0 {
            (a[2] == 0.0).then(|| Mapping::through(flat))
        } else if kind == 1 {
            match (way[2] == 0.0, way[0] == 0.0 && way[1] == 0.0) {
                (true, _) if a[2] == 0.0 => Mapping::mirror(flat, [way[0], way[1]]),
                (false, true) => Some(Mapping::through(flat)),
                _ => None,
            }
        } else {
            let second = card.lines.get(1).unwrap_or(line);
            let c = self.space_point(second, 0)?;
            let other = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
            // The plane stands on the r-z plane where its normal lies in it.
            let normal = [
                way[1] * other[2] - way[2] * other[1],
                way[2] * other[0] - way[0] * other[2],
                way[0] * other[1] - way[1] * other[0],
            ];
            let upright = normal[2].abs() <= 1e-9 * normal[0].abs().max(normal[1].abs());
            if upright { Mapping::mirror(flat, [-normal[1], normal[0]]) } else { None }
        };
        if found.is_none() {
            self.diagnostics.push(Diagnostic::error("M126", leaves).at(line.span, "these points"));
        }
        found
    }

    /// Three coordinates from a field on; those that are not given are zero.
    pub(super) fn space_point(&mut self, line: &DataLine, first: usize) -> Option<[f64; 3]> {
        let mut point = [0.0; 3];
        for (i, value) in point.iter_mut().enumerate() {
            *value = self.number_or(line, first + i, 0.0)?;
        }
        Some(point)
    }

    /// Elements copied with shifts of their numbers and of those of their nodes (ABAQUS Keywords Reference Guide, *ELCOPY).
    /// REFLECT runs through the nodes the other way round, for copies of reflected nodes.
    pub(super) fn elcopy(&mut self, card: &Card) {
        let shift_of_nodes = self.required(card, "SHIFT NODES").and_then(|w| w.integer(&mut self.diagnostics));
        let (Some(change), Some(shift)) = (self.change_of_labels(card, "ELEMENT SHIFT"), shift_of_nodes) else {
            return;
        };
        let Some(old) = self.required(card, "OLD SET").and_then(|w| self.element_members(w)) else { return };
        if !self.affords(Good::Elements, old.len() as u128, card.span) {
            return;
        }
        let mut made = Vec::with_capacity(old.len());
        for element in old {
            let (kind, nodes) = {
                let e = &self.model.mesh.elements[element];
                (e.kind, e.nodes.clone())
            };
            let label = self.model.mesh.elements[element].name.rsplit('.').next().and_then(|l| l.parse::<i64>().ok());
            let labels: Vec<i64> = nodes.iter().filter_map(|&n| self.label_of_index(n)).collect();
            let Some(label) = label.map(|l| l.saturating_add(change)) else { continue };
            let Some(mut nodes) = self.shifted(&labels, shift, label, card.span) else { return };
            if card.has("REFLECT") && nodes.len() > 2 {
                nodes[1..].reverse();
            }
            made.extend(self.add_element(label, kind, nodes[..].into(), card.span));
        }
        if let Some(name) = card.value("NEW SET") {
            self.add_element_set(&name.text, made, card.span);
        }
    }

    /// Nodes taken from coordinates of a local system (ABAQUS Keywords Reference Guide, *NMAP): RECTANGULAR, or CYLINDRICAL
    /// about an axis that stands on the r-z plane, with angles in degrees.
    pub(super) fn nmap(&mut self, card: &Card) {
        let Some(nodes) = self.required(card, "NSET").and_then(|w| self.node_members(w)) else { return };
        let Some(line) = self.first_line(card) else { return };
        let (Some(a), Some(b)) = (self.space_point(line, 0), self.space_point(line, 3)) else { return };
        let polar = card.read("TYPE");
        let alone = line.fields.len() <= 3;
        let c = match card.lines.get(1) {
            Some(second) => self.space_point(second, 0),
            None => Some([a[0], a[1] + 1.0, a[2]]),
        };
        let Some(c) = c else { return };
        let axes = if polar { axis_system(a, b, c) } else { plane_system(a, b, c, alone) };
        let Some([e1, e2]) = axes else {
            let message = "this local system leaves the r-z plane";
            let finding = Diagnostic::error("M126", message).at(line.span, "these points");
            return self.diagnostics.push(
                finding.help("b of CYLINDRICAL lies above a, as in a = 0, 0, 0 and b = 0, 0, 1; all else in the plane"),
            );
        };
        let mut scale = [1.0; 2];
        if let Some(third) = card.lines.get(2) {
            for (i, value) in scale.iter_mut().enumerate() {
                let Some(given) = self.number_or(third, i, 1.0) else { return };
                *value = if given == 0.0 { 1.0 } else { given };
            }
        }
        for node in nodes {
            let p = self.model.mesh.points[node];
            let p = self.instance.as_ref().map_or(p, |placement| placement.undo(p));
            let (first, second) = (scale[0] * p[0], scale[1] * p[1]);
            let local = if polar { polar_point(first, second) } else { [first, second] };
            let place = [0, 1].map(|i| a[i] + local[0] * e1[i] + local[1] * e2[i]);
            self.model.mesh.points[node] = self.instance.as_ref().map_or(place, |placement| placement.apply(place));
        }
    }

    /// Notes a node that was generated although it was there already, elsewhere.
    pub(super) fn note_generated_again(&mut self, node: usize, label: i64, span: Span) {
        let entry = self.again.entry(span).or_insert((label, 0));
        entry.1 += 1;
        self.regenerated.insert(node);
    }

    /// Says which nodes were generated although they were there already: an error where elements are none because of it.
    pub(super) fn tell_generated_again(&mut self) {
        let bad = self.spoilt.len();
        self.lost.bodies |= bad > 0;
        let mut again: Vec<(Span, (i64, usize))> = std::mem::take(&mut self.again).into_iter().collect();
        again.sort_unstable_by_key(|(span, _)| (span.file, span.start));
        for (span, (label, count)) in again {
            let more = if count > 1 { format!(" and {} more nodes are", count - 1) } else { " is".into() };
            let message = format!("node {label}{more} generated again in another place");
            let finding =
                if bad > 0 { Diagnostic::error("M164", message) } else { Diagnostic::warning("M164", message) };
            let help = "choose increments of node numbers that leave no two nodes with one number";
            let label = match bad {
                0 => "the last place counts".to_owned(),
                _ => format!("the last place counts, and {bad} elements with such nodes have no shape"),
            };
            self.diagnostics.push(finding.at(span, label).help(help));
        }
    }
}

/// A point at a radius and an angle in degrees.
pub(super) fn polar_point(radius: f64, degrees: f64) -> [f64; 2] {
    let (sine, cosine) = match degrees.rem_euclid(360.0) {
        // Quarters are exact: nodes on the axis stay there.
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => libm::sincos(other.to_radians()),
    };
    [radius * cosine, radius * sine]
}

/// Directions of a rectangular system in the r-z plane: from a to b, and to the side where c is.
pub(super) fn plane_system(a: [f64; 3], b: [f64; 3], c: [f64; 3], alone: bool) -> Option<[[f64; 2]; 2]> {
    if alone {
        return Some([[1.0, 0.0], [0.0, 1.0]]);
    }
    let (way, side) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let length = libm::hypot(way[0], way[1]);
    let turn = way[0] * side[1] - way[1] * side[0];
    if length == 0.0 || turn == 0.0 || [a, b, c].iter().any(|p| p[2] != 0.0) {
        return None;
    }
    let e1 = [way[0] / length, way[1] / length];
    Some([e1, [-turn.signum() * e1[1], turn.signum() * e1[0]]])
}

/// Directions at the angles 0 and 90 degrees of a cylindrical system whose axis from a to b stands on the r-z plane; c is at 0.
fn axis_system(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Option<[[f64; 2]; 2]> {
    let (up, side) = (b[2] - a[2], [c[0] - a[0], c[1] - a[1]]);
    let length = libm::hypot(side[0], side[1]);
    if b[0] != a[0] || b[1] != a[1] || up == 0.0 || length == 0.0 {
        return None;
    }
    let e1 = [side[0] / length, side[1] / length];
    Some([e1, [-up.signum() * e1[1], up.signum() * e1[0]]])
}

impl Builder<'_> {
    /// Coordinates of the `*NODE` cards that follow are those of a local system (ABAQUS Keywords Reference Guide, *SYSTEM);
    /// without data lines they are r and z again.
    pub(super) fn system(&mut self, card: &Card) {
        let Some(line) = card.lines.first() else {
            self.system = None;
            return;
        };
        let (Some(a), Some(b)) = (self.space_point(line, 0), self.space_point(line, 3)) else { return };
        let alone = line.fields.len() <= 3;
        // Without c the local z axis is normal to the plane, as the global one.
        let c = match card.lines.get(1) {
            Some(second) => self.space_point(second, 0),
            None => Some([a[0] - (b[1] - a[1]), a[1] + (b[0] - a[0]), 0.0]),
        };
        let Some(c) = c else { return };
        match plane_system(a, b, c, alone).filter(|_| a[2] == 0.0) {
            Some(axes) => self.system = Some(([a[0], a[1]], axes)),
            None => {
                let message = "this local system leaves the r-z plane, or its points lie on a line";
                self.diagnostics.push(Diagnostic::error("M126", message).at(line.span, "these points"));
            }
        }
    }

    /// Turned directions at nodes (ABAQUS Keywords Reference Guide, *TRANSFORM). Those along r and z are the directions there
    /// are; others matter where a condition or a force is given on the nodes, which [`Builder::check_transforms`] refuses.
    pub(super) fn transform(&mut self, card: &Card) {
        let Some(set) = self.required(card, "NSET") else { return };
        let Some(nodes) = self.node_members(set) else { return };
        let Some(line) = self.first_line(card) else { return };
        let (Some(a), Some(b)) = (self.space_point(line, 0), self.space_point(line, 3)) else { return };
        let rectangular = card.value("TYPE").is_none_or(|w| w.is("R"));
        let as_they_are = rectangular && a[0] > 0.0 && a[1] == 0.0 && a[2] == 0.0 && b[1] > 0.0 && b[2] == 0.0;
        if as_they_are {
            self.inert(card, "its directions are r and z".into());
        } else {
            self.transforms.push((nodes, card.span));
            self.inert(card, "no condition or force is given in its directions".into());
        }
    }

    /// Refuses conditions and forces that were meant in turned directions.
    pub(super) fn check_transforms(&mut self) {
        for (nodes, span) in std::mem::take(&mut self.transforms) {
            let steps = &self.model.steps;
            let meant = |list: &[usize]| list.iter().any(|n| nodes.contains(n));
            let conditions = || steps.iter().flat_map(|s| &s.boundaries);
            // What is held along r and z is held in every direction.
            let whole = |b: &&super::types::Boundary| {
                b.value == 0.0 && conditions().any(|o| o.dof + b.dof == 3 && o.nodes == b.nodes && o.value == 0.0)
            };
            let held = conditions().find(|b| b.dof < 3 && meant(&b.nodes) && !whole(b)).map(|b| b.span);
            let pushed = steps.iter().flat_map(|s| &s.loads).find_map(|l| match &l.kind {
                super::types::LoadKind::Concentrated { nodes, .. } if meant(nodes) => Some(l.span),
                _ => None,
            });
            let Some(given) = held.or(pushed) else { continue };
            let message = "conditions in turned directions are not supported";
            let finding =
                Diagnostic::error("M104", message).at(given, "given on nodes of a *TRANSFORM").at(span, "turned here");
            self.diagnostics.push(finding.help("give them along r and z, or write the direction as an *EQUATION"));
            self.model.origin.inert.retain(|i| i.span != span);
        }
    }

    /// A point of the system that `*SYSTEM` has set, in r and z.
    pub(super) fn in_system(&self, p: [f64; 2]) -> [f64; 2] {
        match &self.system {
            Some((origin, [e1, e2])) => [0, 1].map(|i| origin[i] + p[0] * e1[i] + p[1] * e2[i]),
            None => p,
        }
    }
}
