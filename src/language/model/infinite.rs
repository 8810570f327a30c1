//! Infinite elements (CINAX4): absorbing tractions on the faces of the mesh to which they are attached.
//!
//! In a dynamic analysis an infinite element is a quiet boundary: it has no stiffness, and its traction `-rho c_p v_n`
//! along the normal and `-rho c_s v_t` along the face absorbs plane waves that arrive along the normal (J. Lysmer and
//! R. L. Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859; ABAQUS Analysis User's Guide 28.3.1, "Infinite elements").

use std::collections::{HashMap, HashSet};

use super::context::Context;
use super::types::{
    ElementKind, ElementSide, InfiniteSection, Load, LoadKind, MaterialDefinition, Mesh, SideSelection, SurfaceTraction,
};
use crate::deck::Diagnostic;

/// Impedances of a material: density times the speed of pressure waves, and the ratio of the speeds of shear and
/// pressure waves. `None` without density or moduli.
fn impedances(material: &MaterialDefinition) -> Option<[f64; 2]> {
    let density = material.density?;
    let [bulk, shear] = match (material.elastic, material.shear_modulus) {
        (Some([modulus, ratio]), _) => [modulus / (3.0 * (1.0 - 2.0 * ratio)), modulus / (2.0 * (1.0 + ratio))],
        (None, shear) => [material.bulk_modulus(None)?, shear.unwrap_or(0.0)],
    };
    let longitudinal = bulk + 4.0 / 3.0 * shear;
    Some([(density * longitudinal).sqrt(), (shear / longitudinal).sqrt()])
}

/// An exposed face of a solid element with its nodes.
#[derive(Clone, Copy)]
struct ExposedFace {
    element: usize,
    side: ElementSide,
    nodes: [usize; 2],
}

/// Returns the faces of solid elements that belong to one element only.
fn exposed_faces(mesh: &Mesh) -> Vec<ExposedFace> {
    let mut faces: HashMap<[usize; 2], Option<ExposedFace>> = HashMap::new();
    for (element, solid) in mesh.elements.iter().enumerate().filter(|(_, element)| element.kind.is_solid()) {
        for (at, first) in solid.nodes.iter().enumerate() {
            let nodes = [*first, solid.nodes[(at + 1) % solid.nodes.len()]];
            let face = ExposedFace { element, side: ElementSide::Face(at as u8 + 1), nodes };
            let [a, b] = nodes;
            faces.entry([a.min(b), a.max(b)]).and_modify(|known| *known = None).or_insert(Some(face));
        }
    }
    let mut list: Vec<ExposedFace> = faces.into_values().flatten().collect();
    list.sort_by_key(|face| (face.element, face.nodes));
    list
}

/// Returns whether a point is on a segment.
fn is_on_segment(point: [f64; 2], [from, to]: [[f64; 2]; 2]) -> bool {
    const TOLERANCE: f64 = 1e-6;
    let (along, offset) = ([to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = (along[0] * offset[0] + along[1] * offset[1]) / square;
    let distance = (along[0] * offset[1] - along[1] * offset[0]) / square;
    distance.abs() < TOLERANCE && (-TOLERANCE..=1.0 + TOLERANCE).contains(&share)
}

/// Adds absorbing tractions to all steps, one load for each section of infinite elements.
pub fn add_absorbing_loads(context: &mut Context<'_>) {
    let sections = std::mem::take(&mut context.model.discrete.infinite);
    if context.missing.bodies || context.missing.nodes {
        return;
    }
    let in_section: HashSet<usize> = sections.iter().flat_map(|section| section.elements.iter().copied()).collect();
    let elements = context.model.mesh.elements.iter().enumerate();
    let mut infinite = elements.filter(|(_, element)| element.kind == ElementKind::Cinax4);
    if let Some((_, element)) = infinite.find(|(index, _)| !in_section.contains(index)) {
        let message = format!("the infinite element {} has no section", element.name);
        let finding = Diagnostic::error("M195", message).at(element.span, "this element");
        return context.diagnostics.push(finding.help("give its element set on *SOLID SECTION"));
    }
    if sections.is_empty() {
        return;
    }
    let mut taken = HashSet::new();
    let faces = exposed_faces(&context.model.mesh);
    for section in &sections {
        if let Some(load) = absorbing_load(context, section, &faces, &mut taken) {
            context.model.steps.iter_mut().for_each(|step| step.loads.push(load.clone()));
        }
    }
}

/// Returns the load of a section of infinite elements. `taken` are the faces that have an infinite element.
fn absorbing_load(
    context: &mut Context<'_>,
    section: &InfiniteSection,
    faces: &[ExposedFace],
    taken: &mut HashSet<(usize, ElementSide)>,
) -> Option<Load> {
    let material = &context.model.materials[section.material];
    let Some([magnitude, shear_ratio]) = impedances(material) else {
        let message = format!("the infinite elements need density and elastic moduli of `{}`", material.name);
        let finding = Diagnostic::error("M195", message).at(section.span, "this section");
        return context.diagnostics.refuse(finding.help("give *DENSITY and *ELASTIC in the material"));
    };
    let mesh = &context.model.mesh;
    let refined = context.scaling.refined.is_some();
    let by_nodes: HashMap<[usize; 2], &ExposedFace> =
        faces.iter().map(|face| ([face.nodes[0].min(face.nodes[1]), face.nodes[0].max(face.nodes[1])], face)).collect();
    let mut selected = Vec::new();
    for &element in &section.elements {
        let [a, b] = [mesh.elements[element].nodes[0], mesh.elements[element].nodes[1]];
        let ends = [mesh.points[a], mesh.points[b]];
        let before = selected.len();
        if let Some(face) = by_nodes.get(&[a.min(b), a.max(b)]) {
            selected.push((face.element, face.side));
        } else if refined {
            let is_part = |face: &&ExposedFace| face.nodes.iter().all(|n| is_on_segment(mesh.points[*n], ends));
            selected.extend(faces.iter().filter(is_part).map(|face| (face.element, face.side)));
        }
        if selected.len() == before {
            let message = format!(
                "no free face of a solid element has the first two nodes of the infinite element {}",
                mesh.elements[element].name
            );
            let finding = Diagnostic::error("M195", message).at(mesh.elements[element].span, "this element");
            let help =
                "the first two nodes of CINAX4 are on the boundary of the mesh of CAX4R or CAX3, the other two outside";
            return context.diagnostics.refuse(finding.help(help));
        }
    }
    if let Some((element, _)) = selected.iter().find(|face| !taken.insert(**face)) {
        let message = format!("a face of element {} has two infinite elements", mesh.elements[*element].name);
        let finding = Diagnostic::error("M195", message).at(section.span, "in this section");
        return context.diagnostics.refuse(finding.help("remove one of them"));
    }
    let kind = ElementKind::Cinax4.name();
    let name = format!("{} {kind}", section.elements.len());
    let sides = SideSelection { name, surface: true, faces: selected, free_face_elements: Vec::new() };
    let law = SurfaceTraction::Absorbing { shear_ratio };
    Some(Load { kind: LoadKind::Traction { sides, law }, magnitude, amplitude: None, span: section.span })
}
