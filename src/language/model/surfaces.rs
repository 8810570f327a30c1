//! `*SURFACE` on element faces.

use std::collections::HashSet;

use super::context::Context;
use super::families::{MeshReader, StepReader};
use super::names::{qualified, upper};
use super::types::{ElementKind, ElementSide, ElementSurface, SideSelection};
use super::{adaptive, contact};
use crate::deck::{Card, Diagnostic, Word};

pub fn read_surface(context: &mut Context<'_>, mesh: &mut MeshReader, steps: &mut StepReader, card: &Card) {
    let Some(name) = context.required(card, "NAME") else { return };
    let key = qualified(&context.scope, &name.text);
    if mesh.derived_surfaces.remove(&key) {
        context.model.surfaces.faces.shift_remove(&key);
    }
    let of_faces = card.value("TYPE").is_none_or(|w| w.is("ELEMENT"));
    if let Some(parameter) = card.parameters.iter().find(|p| p.name == "REGION TYPE").filter(|_| !of_faces) {
        let message = "REGION TYPE applies to surfaces of element faces";
        return context.unsupported(parameter.span, message, "remove it, or give TYPE=ELEMENT");
    }
    if card.value("TYPE").is_some_and(|w| w.is("NODE")) {
        contact::node_surface(context, card, name);
        return;
    }
    if card.value("TYPE").is_some_and(|w| w.is("SEGMENTS")) {
        contact::analytical_surface(context, mesh, card, name);
        return;
    }
    if let Some(kind) = card.value("TYPE").filter(|w| !w.is("ELEMENT")) {
        let help = "supported: ELEMENT, NODE, SEGMENTS";
        return context.unsupported(kind.span, format!("TYPE={} is not supported", kind.text), help);
    }
    if card.has("COMBINE") {
        return union_of_surfaces(context, steps, card, name);
    }
    let (mut faces, mut whole, mut interior) = (Vec::new(), Vec::new(), Vec::new());
    for line in &card.lines {
        let Some(set) = line.field(0) else { continue };
        let elements = context.element_members(set).unwrap_or_default();
        match line.field(1) {
            Some(side) if side.is("INTERIOR") => interior.push((elements, side)),
            Some(side) => faces.extend(sides(context, set, &elements, side)),
            None => {
                faces.extend(free_sides(context, &elements));
                whole.extend(elements);
            }
        }
    }
    interior.iter().for_each(|(elements, side)| interior_sides(context, elements, side, &whole));
    let name = name.text.clone();
    // Merged elements of a coarser mesh are named once for each of their parts.
    let mut seen = HashSet::new();
    faces.retain(|face| seen.insert(*face));
    add_faces(context, steps, card, ElementSurface { name, faces, free_face_elements: whole, span: card.span });
}

/// Adds faces, and elements whose free faces follow element deletion, to a surface.
fn add_faces(context: &mut Context<'_>, steps: &mut StepReader, card: &Card, added: ElementSurface) {
    adaptive::adaptive_region(steps, card, added.faces.clone(), Vec::new());
    let surfaces = &mut context.model.surfaces.faces;
    match surfaces.get_mut(&qualified(&context.scope, &added.name)) {
        Some(surface) => {
            surface.faces.extend(added.faces);
            surface.free_face_elements.extend(added.free_face_elements);
        }
        None => drop(surfaces.insert(qualified(&context.scope, &added.name), added)),
    }
}

/// Reads `COMBINE=UNION`: the faces of several element surfaces, each once.
fn union_of_surfaces(context: &mut Context<'_>, steps: &mut StepReader, card: &Card, name: &Word) {
    let (mut faces, mut whole) = (Vec::new(), Vec::new());
    for word in card.lines.iter().flat_map(|line| &line.fields).filter(|word| !word.text.is_empty()) {
        let Some(id) = context.surface_id(word) else { return };
        let surface = &context.model.surfaces.faces[id];
        faces.extend(&surface.faces);
        whole.extend(&surface.free_face_elements);
    }
    let mut seen = HashSet::new();
    faces.retain(|face| seen.insert(*face));
    let mut seen = HashSet::new();
    whole.retain(|element| seen.insert(*element));
    let name = name.text.clone();
    add_faces(context, steps, card, ElementSurface { name, faces, free_face_elements: whole, span: card.span });
}

/// Reads the face identifier INTERIOR (ABAQUS Analysis User's Guide 2.3.2, "Element-based surface definition"): the
/// faces that element deletion exposes. Exterior faces of the same elements must be in the surface; they already
/// follow element deletion.
fn interior_sides(context: &mut Context<'_>, elements: &[usize], side: &Word, exterior: &[usize]) {
    let mesh = &context.model.mesh;
    let known: HashSet<&usize> = exterior.iter().collect();
    let refusal = if elements.iter().any(|&e| !mesh.elements[e].kind.is_solid()) {
        Some(("only solid elements have interior faces", "use SPOS or SNEG"))
    } else if elements.iter().any(|e| !known.contains(e)) {
        let help = "add a line with the element set and without a face identifier to the surface";
        Some(("INTERIOR requires the exterior faces of the same elements in the surface", help))
    } else {
        None
    };
    if let Some((message, help)) = refusal {
        return context.diagnostics.push(Diagnostic::error("M131", message).at(side.span, "here").help(help));
    }
    let why = "exterior faces always include the faces that element deletion exposes";
    context.ignore("SURFACE, INTERIOR", side.span, why);
}

/// Returns the faces of elements, which `set` names, on a side.
pub fn sides(context: &mut Context<'_>, set: &Word, elements: &[usize], word: &Word) -> Vec<(usize, ElementSide)> {
    let name = upper(&word.text);
    let mut faces = Vec::new();
    for &element in elements {
        let kind = context.model.mesh.elements[element].kind;
        let mut sides = sides_of(&name, kind).peekable();
        if sides.peek().is_none() {
            let message = format!("{} has no side {}", kind.name(), word.text);
            let diagnostic = Diagnostic::error("M131", message).at(word.span, "no such side");
            context.diagnostics.push(
                diagnostic
                    .help("use SPOS or SNEG for RAX2 and SAX1, S1 to S3 for CAX3 and CAX6M, S1 to S4 for CAX4R, S1 and S3 for COHAX4"),
            );
            return faces;
        }
        let refined = context.scaling.refined.as_ref();
        let is_outer = |&(element, side): &_| refined.is_none_or(|refined| refined.is_outer(element, side));
        faces.extend(sides.map(|side| (element, side)).filter(is_outer));
    }
    context.edit_sides(set, word, &faces);
    faces
}

/// Returns the exterior faces of solids and both sides of shells.
fn free_sides(context: &Context<'_>, elements: &[usize]) -> Vec<(usize, ElementSide)> {
    let mesh = &context.model.mesh;
    let outside = mesh.exterior_faces();
    let faces_of = |&e: &usize| {
        let first = outside.partition_point(|f| f.0 < e);
        let faces = outside[first..].iter().take_while(move |f| f.0 == e).copied();
        let is_shell = mesh.elements[e].kind.is_line();
        let both = [ElementSide::Positive, ElementSide::Negative].into_iter().filter(move |_| is_shell);
        faces.chain(both.map(move |side| (e, side)))
    };
    elements.iter().flat_map(faces_of).collect()
}

/// Returns the faces of a surface on which a load acts. A surface with both sides of a shell is an error: the load
/// has no direction.
pub fn loaded_sides(context: &mut Context<'_>, word: &Word) -> Option<SideSelection> {
    let id = context.surface_id(word)?;
    let sides = context.model.surfaces.faces[id].sides(&word.text);
    let Some(element) = sides.two_sided_element() else { return Some(sides) };
    let element = &context.model.mesh.elements[element];
    let message = format!("a load requires one side of {} elements, SPOS or SNEG", element.kind.name());
    let label = format!("both sides of element {}", element.name);
    let help = "the normal of SPOS is the direction from the first to the second node, \
                rotated by 90 degrees counter-clockwise in (r, z)";
    let finding = Diagnostic::error("M130", message).at(word.span, label);
    context.diagnostics.refuse(finding.at(context.model.surfaces.faces[id].span, "surface without sides").help(help))
}

impl ElementSurface {
    /// Returns the faces of the surface under the name used by a card.
    pub fn sides(&self, name: &str) -> SideSelection {
        SideSelection {
            name: name.into(),
            surface: true,
            faces: self.faces.clone(),
            free_face_elements: self.free_face_elements.clone(),
        }
    }
}

impl SideSelection {
    /// Returns an element that has both of its sides in this surface.
    pub fn two_sided_element(&self) -> Option<usize> {
        let first: HashSet<_> = self.first_sides().into_iter().collect();
        self.faces.iter().find(|f| !first.contains(f)).map(|f| f.0)
    }

    /// Returns the faces without the negative sides of shells whose positive sides are also in the surface.
    pub fn first_sides(&self) -> Vec<(usize, ElementSide)> {
        let positive: HashSet<usize> =
            self.faces.iter().filter(|f| f.1 == ElementSide::Positive).map(|f| f.0).collect();
        self.faces.iter().filter(|f| f.1 != ElementSide::Negative || !positive.contains(&f.0)).copied().collect()
    }

    /// Returns the surface as parts: faces of solids, positive sides and negative sides of shells. A
    /// surface without two sides of one shell is returned whole.
    pub fn one_sided(&self) -> Vec<SideSelection> {
        if self.first_sides().len() == self.faces.len() {
            return vec![self.clone()];
        }
        let parts = [("", None), ("_SPOS", Some(ElementSide::Positive)), ("_SNEG", Some(ElementSide::Negative))];
        let shell_side = |side: ElementSide| Some(side).filter(|s| !matches!(s, ElementSide::Face(_)));
        let part = |(end, side): (&str, Option<ElementSide>)| {
            let faces: Vec<_> = self.faces.iter().filter(|f| shell_side(f.1) == side).copied().collect();
            SideSelection::new(&format!("{}{end}", self.name), &faces)
        };
        parts.into_iter().map(part).filter(|part| !part.faces.is_empty()).collect()
    }
}

/// Returns the sides that a label denotes for an element type; none if the type has no such side.
pub fn sides_of(name: &str, kind: ElementKind) -> impl Iterator<Item = ElementSide> {
    let of_shell = match name {
        "SPOS" if kind.is_line() => Some(ElementSide::Positive),
        "SNEG" if kind.is_line() => Some(ElementSide::Negative),
        _ => None,
    };
    let number = name.strip_prefix('S').filter(|_| kind.is_solid() || kind.is_cohesive());
    let number = number.and_then(|n| n.parse().ok());
    of_shell.into_iter().chain(number.map_or(0..0, |n| kind.face(n)).map(ElementSide::Face))
}
