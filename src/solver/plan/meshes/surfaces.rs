//! Surfaces of loads: element sides as facets of rigid bodies and faces of deformable bodies.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::deck::{Diagnostic, Span};
use crate::kernel::facet::Facet;
use crate::mesh::hidden::InteriorFaces;
use crate::mesh::surface::{DeformableFaces, RigidFacets, SurfaceGeometry};
use crate::model::{ElementSide, Model, SideSelection};
use crate::plan::solids::user_material::deletes;
use crate::plan::{Report, Scene};

/// Returns the surface of element sides for the load at `span`. Elements that belong to no body are an error.
pub fn load_surface(scene: Scene, sides: &SideSelection, span: Span, report: &mut Report) -> SurfaceGeometry {
    if let Some(known) = report.shared.surfaces.get(&span) {
        return known.clone();
    }
    let surface = make_surface(scene, sides, span, report);
    if scene.places.elements.is_empty() {
        report.shared.surfaces.insert(span, surface.clone());
    }
    surface
}

fn make_surface(scene: Scene, sides: &SideSelection, span: Span, report: &mut Report) -> SurfaceGeometry {
    let mut by_body: BTreeMap<usize, Vec<(usize, Facet)>> = BTreeMap::new();
    let (mut faces, mut face_elements, mut shells) = (Vec::new(), Vec::new(), Vec::new());
    let mut stray = None;
    for &(element, side) in &sides.faces {
        if scene.places.elements.contains_key(&element) {
            if let Some(mut ends) = scene.model.mesh.side_nodes(element, side) {
                // The body is to the left of a face. On the positive side of a shell the direction is reversed.
                if side == ElementSide::Positive {
                    ends.reverse();
                }
                faces.push(ends.map(|n| scene.places.nodes[&n]));
                face_elements.push(element);
                shells.push(scene.model.mesh.elements[element].kind.is_shell());
            }
            continue;
        }
        match (scene.bodies.of_element.get(&element), rigid_facet(scene.model, element, side)) {
            (Some(&body), Some(facet)) => by_body.entry(body).or_default().push((element, facet)),
            (None, _) => stray = stray.or(Some(element)),
            _ => {}
        }
    }
    if let Some(element) = stray {
        let name = &scene.model.mesh.elements[element].name;
        let message = format!("`{}` contains element {name}, which belongs to no body", sides.name);
        report.push(Diagnostic::error("P003", message).at(span, "this load needs faces of a body"));
    }
    let patches = by_body.into_iter().map(|(body, facets)| RigidFacets { body, facets }).collect();
    let mut skin = DeformableFaces::new(faces, face_elements);
    if shells.contains(&true) {
        skin.shells = shells;
    }
    SurfaceGeometry { patches, skin: skin.with_hidden(hidden_faces(scene, sides)) }
}

/// Returns the interior faces that are loaded once they are exposed by element deletion: those of elements that are
/// given without a side. Empty if no element can be deleted.
fn hidden_faces(scene: Scene, sides: &SideSelection) -> InteriorFaces {
    if sides.free_face_elements.is_empty() || !deletes(scene) {
        return InteriorFaces::default();
    }
    let mesh = &scene.model.mesh;
    let faces_of = |element: usize| {
        let count = if mesh.elements[element].kind.is_solid() { mesh.elements[element].nodes.len() as u8 } else { 0 };
        let deforms = scene.places.elements.contains_key(&element);
        let sides = (1..=count).filter(move |_| deforms).map(ElementSide::Face);
        sides.filter_map(move |s| Some(mesh.side_nodes(element, s)?.map(|n| scene.places.nodes[&n])))
    };
    let deformable_faces: FxHashSet<[usize; 2]> = scene.places.elements.keys().flat_map(|e| faces_of(e)).collect();
    let free_faces = sides.free_face_elements.iter().flat_map(|&e| faces_of(e).map(move |face| (face, e)));
    // A face that is also given by its side is loaded from the start.
    let named: FxHashSet<(usize, ElementSide)> = sides.faces.iter().copied().collect();
    let is_named = |element: usize, [a, b]: [usize; 2]| {
        let ends =
            |&s: &ElementSide| mesh.side_nodes(element, s).map(|e| e.map(|n| scene.places.nodes[&n])) == Some([a, b]);
        (1..=mesh.elements[element].nodes.len() as u8)
            .map(ElementSide::Face)
            .filter(ends)
            .any(|s| named.contains(&(element, s)))
    };
    InteriorFaces::new(
        free_faces.filter(|&([a, b], e)| deformable_faces.contains(&[b, a]) && !is_named(e, [a, b])).collect(),
    )
}

/// Returns the rigid facet of a side. Faces of solids run counter-clockwise, so that the outward normal is the
/// negative side.
pub fn rigid_facet(model: &Model, element: usize, side: ElementSide) -> Option<Facet> {
    let mesh = &model.mesh;
    let [from, to] = mesh.side_nodes(element, side)?.map(|n| mesh.points[n]);
    Facet::new(from, to, side == ElementSide::Positive)
}
