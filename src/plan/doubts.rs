//! What a deck says and can hardly mean: units that do not fit, a wall that faces away, bodies that overlap, a body that nothing
//! acts on. Warnings; the run does what the deck says.
//! Never here: what cannot be simulated.

use std::collections::HashSet;

use super::{Compiler, State};
use crate::deck::Diagnostic;
use crate::model::{Element, ElementKind, IncrementControl, InitialCondition, InitialKind, SolidSection};

/// Velocities above so many times the speed of sound are taken for a slip in the units.
const TOO_FAST: f64 = 3.0;
/// How deep a node lies in an element of another body, as a fraction of the element's size, before they overlap.
const DEEP: f64 = 1e-3;
/// Bodies of more elements than this are not searched for overlaps.
const MOST: usize = 200_000;

impl Compiler<'_> {
    /// Tells of all of them.
    pub(super) fn doubts(&mut self, state: &State) {
        if state.elements.is_empty() {
            return;
        }
        self.too_fast();
        self.given_increments();
        self.walls_that_face_away();
        self.overlaps();
        self.nothing_acts();
    }

    fn warn(&mut self, finding: Diagnostic) {
        self.diagnostics.push(finding);
    }

    /// Speed of longitudinal waves of an elastic material.
    fn sound(&self, section: &SolidSection) -> Option<f64> {
        let material = self.model.materials.get(section.material)?;
        let ([e, nu], density) = (material.elastic?, material.density?);
        Some((e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu) * density)).sqrt())
    }

    fn velocities(&self) -> impl Iterator<Item = (&InitialCondition, u8, f64)> {
        self.model.initial_conditions.iter().filter_map(|c| match c.kind {
            InitialKind::Velocity(dof, value) => Some((c, dof, value)),
            _ => None,
        })
    }

    fn too_fast(&mut self) {
        let mut found = None;
        for section in &self.model.sections {
            let Some(sound) = self.sound(section) else { continue };
            let mut nodes: Vec<usize> = self.nodes_of(&section.elements);
            nodes.sort_unstable();
            nodes.dedup();
            let meets = |c: &InitialCondition| c.members.iter().any(|n| nodes.binary_search(n).is_ok());
            let fast = self.velocities().find(|(c, dof, v)| *dof <= 2 && v.abs() > TOO_FAST * sound && meets(c));
            if let Some((condition, _, velocity)) = fast {
                found = Some((condition.span, velocity, sound, &self.model.materials[section.material]));
                break;
            }
        }
        let Some((span, velocity, sound, material)) = found else { return };
        let message = format!(
            "the initial velocity {velocity:e} is {:.0} times the speed of sound in `{}`, {sound:.3e}: do the units of density, \
             moduli, lengths and time fit?",
            velocity.abs() / sound,
            material.name
        );
        let finding = Diagnostic::warning("P105", message).at(span, "this velocity");
        let finding = finding.at(material.span, "this material");
        self.warn(finding.help("m, kg, s with Pa; or mm, t, s with MPa (steel: 7.85e-9 t/mm3, 210e3 MPa)"));
    }

    fn nodes_of(&self, elements: &[usize]) -> Vec<usize> {
        elements.iter().flat_map(|&e| self.model.mesh.elements[e].nodes.iter().copied()).collect()
    }

    /// A given increment that a wave needs less than to cross an element is not stable.
    fn given_increments(&mut self) {
        let points = &self.model.mesh.points;
        let mut smallest: Option<(f64, &Element)> = None;
        for section in &self.model.sections {
            let Some(sound) = self.sound(section) else { continue };
            for element in section.elements.iter().map(|&e| &self.model.mesh.elements[e]) {
                let time = size(&corners(element, points)) / sound;
                if smallest.is_none_or(|s| time < s.0) {
                    smallest = Some((time, element));
                }
            }
        }
        let Some((time, element)) = smallest else { return };
        let scaled = self.model.steps.iter().any(|s| !s.mass_scalings.is_empty());
        let given = self.model.steps.iter().filter_map(|s| match s.increment {
            IncrementControl::Fixed(dt) => Some((s.span, dt)),
            IncrementControl::Automatic { .. } => None,
        });
        let Some((span, dt)) = given.into_iter().find(|(_, dt)| *dt > time && !scaled) else { return };
        let message =
            format!("the given increment {dt:e} is not stable: a wave crosses element {} in {time:.2e}", element.name);
        let finding = Diagnostic::warning("P106", message).at(span, "DIRECT USER CONTROL");
        self.warn(finding.help("leave the increment to the program, or give a smaller one"));
    }

    /// Nodes that begin on an analytical plane stand in front of it where their body is.
    fn walls_that_face_away(&mut self) {
        let mut findings = Vec::new();
        let mut told = Vec::new();
        for contact in self.model.steps.iter().flat_map(|s| &s.contacts) {
            let Some(plane) = self.model.planes.get(&contact.plane) else { continue };
            let mesh = &self.model.mesh;
            let gap = |n: &usize| mesh.points[*n][1] - plane.height;
            let size = plane.height.abs().max((plane.to - plane.from).abs());
            let on_it = contact.nodes.iter().all(|n| gap(n).abs() <= 1e-9 * size);
            let touches =
                |e: &&Element| e.nodes.len() > 2 && e.nodes.iter().any(|n| contact.nodes.binary_search(n).is_ok());
            let body: Vec<f64> = mesh.elements.iter().filter(touches).flat_map(|e| &e.nodes).map(gap).collect();
            let mean = body.iter().sum::<f64>() / body.len().max(1) as f64;
            let front = (plane.to - plane.from).signum();
            if !on_it || mean * front >= 0.0 || told.contains(&contact.plane) {
                continue;
            }
            told.push(contact.plane.clone());
            let [here, there] = if front > 0.0 { ["above", "below"] } else { ["below", "above"] };
            let message = format!(
                "the plane `{}` faces away: its front is {here}, and `{}` is {there}",
                contact.plane, contact.set
            );
            let finding =
                Diagnostic::warning("P107", message).at(plane.span, "the front is left of the way from START to LINE");
            findings.push(finding.at(contact.span, "this pair").help("swap the points of START and LINE"));
        }
        findings.into_iter().for_each(|f| self.warn(f));
    }

    /// Bodies that share no node and lie in each other pass through each other.
    fn overlaps(&mut self) {
        let mesh = &self.model.mesh;
        let solids: Vec<usize> = self.places.elements.keys().copied().collect();
        if solids.len() > MOST {
            return;
        }
        let bodies = separate(&solids, &mesh.elements, mesh.points.len());
        let mut findings = Vec::new();
        for (i, a) in bodies.iter().enumerate() {
            for b in &bodies[i + 1..] {
                let found =
                    lies_in(a, b, &mesh.elements, &mesh.points).or_else(|| lies_in(b, a, &mesh.elements, &mesh.points));
                let Some((node, element)) = found else { continue };
                let element = &mesh.elements[element];
                let message = format!(
                    "two bodies overlap: node {} lies in element {}, and nothing keeps them apart",
                    mesh.node_names[node], element.name
                );
                let finding = Diagnostic::warning("P108", message).at(element.span, "in this element");
                findings.push(finding.help("let them share nodes, or move one of them"));
            }
        }
        findings.into_iter().take(3).for_each(|f| self.warn(f));
    }

    /// A body of one velocity that nothing holds, pushes or meets flies on as it is.
    fn nothing_acts(&mut self) {
        let model = self.model;
        let free = model.rigid_bodies.is_empty()
            && model.targets.is_empty()
            && model.equations.is_empty()
            && model.materials.iter().all(|m| m.eos.is_none())
            && model.mesh.elements.iter().all(|e| matches!(e.kind, ElementKind::Cax3 | ElementKind::Cax4r))
            && model.steps.iter().all(|s| s.boundaries.is_empty() && s.loads.is_empty() && s.contacts.is_empty());
        let plain = |c: &InitialCondition| matches!(c.kind, InitialKind::Velocity(..) | InitialKind::Temperature(_));
        let everywhere = |c: &InitialCondition| {
            let members: HashSet<usize> = c.members.iter().copied().collect();
            self.places.nodes.keys().all(|n| members.contains(n))
        };
        if !free || !model.initial_conditions.iter().all(plain) {
            return;
        }
        let (mut moving, mut whole) = (None, true);
        for (condition, dof, _) in self.velocities().filter(|v| v.1 <= 2 && v.2 != 0.0) {
            whole &= dof == 2 && condition.members.len() >= self.places.nodes.len() && everywhere(condition);
            moving = Some(condition.span);
        }
        let Some(span) = moving.filter(|_| whole) else { return };
        let message = "nothing holds, pushes or meets what deforms: it flies on as it is";
        let finding = Diagnostic::warning("P109", message).at(span, "this velocity stays");
        self.warn(finding.help("is a *BOUNDARY, a load or a *CONTACT PAIR missing?"));
    }
}

fn corners(element: &Element, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    element.nodes.iter().map(|&n| points[n]).collect()
}

/// Twice the area.
fn doubled_area(corners: &[[f64; 2]]) -> f64 {
    (0..corners.len()).map(|i| cross([0.0; 2], corners[i], corners[(i + 1) % corners.len()])).sum()
}

fn cross(o: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

/// The shortest side.
fn size(corners: &[[f64; 2]]) -> f64 {
    let side = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        (b[0] - a[0]).hypot(b[1] - a[1])
    };
    (0..corners.len()).map(side).filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min)
}

/// Elements by the bodies they make: those that share nodes, directly or over others.
fn separate(solids: &[usize], elements: &[Element], nodes: usize) -> Vec<Vec<usize>> {
    let mut root: Vec<usize> = (0..nodes).collect();
    fn find(root: &mut [usize], mut n: usize) -> usize {
        while root[n] != n {
            root[n] = root[root[n]];
            n = root[n];
        }
        n
    }
    for element in solids.iter().map(|&e| &elements[e]) {
        let first = find(&mut root, element.nodes[0]);
        for &node in &element.nodes[1..] {
            let other = find(&mut root, node);
            root[other] = first;
        }
    }
    let mut bodies: indexmap::IndexMap<usize, Vec<usize>> = indexmap::IndexMap::new();
    for &e in solids {
        bodies.entry(find(&mut root, elements[e].nodes[0])).or_default().push(e);
    }
    bodies.into_values().collect()
}

/// Lowest and highest coordinates of some elements.
fn bounds(body: &[usize], elements: &[Element], points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for point in body.iter().flat_map(|&e| &elements[e].nodes).map(|&n| points[n]) {
        for axis in 0..2 {
            bounds[0][axis] = bounds[0][axis].min(point[axis]);
            bounds[1][axis] = bounds[1][axis].max(point[axis]);
        }
    }
    bounds
}

/// A node of one body that lies in an element of another.
fn lies_in(a: &[usize], b: &[usize], elements: &[Element], points: &[[f64; 2]]) -> Option<(usize, usize)> {
    let (of_a, of_b) = (bounds(a, elements, points), bounds(b, elements, points));
    let inside = |p: [f64; 2], [low, high]: [[f64; 2]; 2]| (0..2).all(|i| low[i] < p[i] && p[i] < high[i]);
    let meet = (0..2).all(|i| of_a[0][i] < of_b[1][i] && of_b[0][i] < of_a[1][i]);
    if !meet {
        return None;
    }
    let mut nodes: Vec<usize> = a.iter().flat_map(|&e| elements[e].nodes.iter().copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.retain(|&n| inside(points[n], of_b));
    nodes.sort_by(|&m, &n| points[m][1].total_cmp(&points[n][1]));
    for &e in b {
        let [low, high] = bounds(&[e], elements, points);
        let from = nodes.partition_point(|&n| points[n][1] <= low[1]);
        let candidates = nodes[from..].iter().take_while(|&&n| points[n][1] < high[1]);
        let corners = corners(&elements[e], points);
        let depth = DEEP * doubled_area(&corners);
        let within = |n: &&usize| {
            (0..corners.len()).all(|i| cross(corners[i], corners[(i + 1) % corners.len()], points[**n]) > depth)
        };
        if let Some(&node) = candidates.into_iter().find(within) {
            return Some((node, e));
        }
    }
    None
}
