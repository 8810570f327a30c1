//! Infinite elements (CINAX4): absorbing tractions on the faces of the mesh to which they are attached.
//!
//! In a dynamic analysis an infinite element is a quiet boundary: it has no stiffness, and its traction `-rho c_p v_n`
//! along the normal and `-rho c_s v_t` along the face absorbs plane waves that arrive along the normal (J. Lysmer and
//! R. L. Kuhlemeyer, J. Eng. Mech. Div. ASCE 95 (1969) 859; ABAQUS Analysis User's Guide 28.3.1, "Infinite elements").

use std::collections::HashSet;

use indexmap::IndexMap;

use super::context::Context;
use super::types::{
    ElementKind, ElementSide, InfiniteSection, Load, LoadKind, MaterialDefinition, Mesh, SideSelection, SurfaceTraction,
};
use crate::deck::Diagnostic;
use crate::kernel::lists::sorted_pair;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::shape::{distance, share_between};

/// Impedances of a material: density times the speed of pressure waves, and the ratio of the speeds of shear and
/// pressure waves. `None` for rubber, and without density or moduli.
fn impedances(material: &MaterialDefinition) -> Option<[f64; 2]> {
    if material.hyperelastic.is_some() {
        return None;
    }
    let (density, ElasticModuli { bulk, shear }) = (material.density?, material.small_strain_moduli(None)?);
    let longitudinal = bulk + 4.0 / 3.0 * shear;
    Some([(density * longitudinal).sqrt(), (shear / longitudinal).sqrt()])
}

/// Exterior faces of solid elements, by their nodes in ascending order.
type ExteriorFaces = IndexMap<[usize; 2], (usize, ElementSide)>;

fn exterior_faces(mesh: &Mesh) -> ExteriorFaces {
    let with_nodes = |face: (usize, ElementSide)| Some((sorted_pair(mesh.side_nodes(face.0, face.1)?), face));
    mesh.exterior_faces().into_iter().filter_map(with_nodes).collect()
}

/// Returns whether a point is on a segment.
fn is_on_segment(point: [f64; 2], ends: [[f64; 2]; 2]) -> bool {
    const TOLERANCE: f64 = 1e-6;
    let ([from, to], share) = (ends, share_between(ends, point));
    let nearest = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
    distance(nearest, point) < TOLERANCE * distance(from, to)
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
    let faces = exterior_faces(&context.model.mesh);
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
    faces: &ExteriorFaces,
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
    let mut selected = Vec::new();
    for &element in &section.elements {
        let attached = [0, 1].map(|at| mesh.elements[element].nodes[at]);
        let before = selected.len();
        if let Some(face) = faces.get(&sorted_pair(attached)) {
            selected.push(*face);
        } else if refined {
            let ends = attached.map(|node| mesh.points[node]);
            let is_part = |nodes: &[usize; 2]| nodes.iter().all(|node| is_on_segment(mesh.points[*node], ends));
            selected.extend(faces.iter().filter(|(nodes, _)| is_part(nodes)).map(|(_, face)| *face));
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
        return context.diagnostics.refuse(finding.help("remove one of the two infinite elements"));
    }
    let kind = ElementKind::Cinax4.name();
    let name = format!("{} {kind}", section.elements.len());
    let sides = SideSelection { name, surface: true, faces: selected, free_face_elements: Vec::new() };
    let law = SurfaceTraction::Absorbing { shear_ratio };
    Some(Load { kind: LoadKind::Traction { sides, law }, magnitude, amplitude: None, span: section.span })
}
