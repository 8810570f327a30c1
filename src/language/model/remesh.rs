//! A model with a new mesh of a body: sets, surfaces, loads and all other lists of nodes, elements and faces follow it.

use rustc_hash::FxHashSet;

use super::name::NewLabels;
use super::types::{
    ContactDomain, Element, ElementKind, ElementSide, GeneralContact, LoadKind, LoadRegionMut, MemberSet, Mesh, Model,
    NodeConstraints, NodeSetId, OutputKind, OutputRegion, OutputRequest, SideSelection, Step, SurfaceTraction,
};
use crate::kernel::lists::sorted_unique;
use crate::kernel::quad;
use crate::kernel::shape::is_triangle;
use crate::remesh::interpolation::TracerPoint;
use crate::remesh::outline::{BoundaryEdge, loops};
use crate::remesh::{BodyMesh, INSIDE, MeshRevision};
use crate::variables::request::VariableRequest;

/// A list of the model that refers to nodes, elements or faces.
enum MemberList<'a> {
    Node(&'a mut usize),
    Nodes(&'a mut Vec<usize>),
    Elements(&'a mut Vec<usize>),
    Faces(&'a mut Vec<(usize, ElementSide)>),
}

/// A body of the model that can be remeshed, in its own numbering.
pub struct ModelBody {
    /// Index of its `*REMESH` card.
    pub index: usize,
    /// Nodes of the model, ascending.
    pub nodes: Vec<usize>,
    /// Nodes of the body at the corners of its elements.
    pub quads: Vec<[u32; 4]>,
}

impl ModelBody {
    /// Returns the body of a `*REMESH` card.
    pub fn new(model: &Model, body: usize) -> ModelBody {
        ModelBody::of_elements(&model.mesh, body, &model.remeshings[body].elements)
    }

    /// Returns the body with the given elements, in ascending order.
    pub fn of_elements(mesh: &Mesh, index: usize, elements: &[usize]) -> ModelBody {
        let nodes: Vec<usize> = sorted_unique(elements.iter().flat_map(|e| mesh.elements[*e].nodes.iter().copied()));
        let local = |node: usize| nodes.binary_search(&node).unwrap_or_default() as u32;
        let quads = elements.iter().flat_map(|e| mesh.cells(*e)).map(|cell| cell.map(local)).collect();
        ModelBody { index, nodes, quads }
    }

    /// Returns the own number of a node; `None` for nodes of other bodies.
    pub fn position(&self, node: usize) -> Option<u32> {
        self.nodes.binary_search(&node).ok().map(|at| at as u32)
    }

    /// Returns the nodes that elements outside the body use, in its own numbering and ascending order. New meshes keep them.
    pub fn shared_nodes(&self, model: &Model) -> Vec<u32> {
        let elements = &model.remeshings[self.index].elements;
        sorted_unique(elements_at_body(&model.mesh, self, elements).map(|(_, node)| node))
    }

    /// Returns the square roots of the areas of the elements at the start.
    pub fn sizes(&self, mesh: &Mesh) -> Vec<f64> {
        let corners = |quad: &[u32; 4]| quad.map(|n| mesh.points[self.nodes[n as usize]]);
        let area = |corners: [[f64; 2]; 4]| quad::section(corners.map(|p| p[0]), corners.map(|p| p[1]));
        self.quads.iter().map(|quad| area(corners(quad)).sqrt()).collect()
    }

    /// Returns which nodes of the body must remain in a new mesh: nodes that the model names one by one, ends of sets
    /// and surfaces along the boundary, and nodes where the boundary leaves the axis.
    pub fn kept(&self, model: &Model) -> Vec<bool> {
        let mut is_kept = vec![false; self.nodes.len()];
        let mesh = BodyMesh { points: Vec::new(), quads: self.quads.clone(), sizes: Vec::new() };
        let outlines = loops(&mesh).unwrap_or_default();
        let edges: Vec<[&BoundaryEdge; 2]> = outlines
            .iter()
            .flat_map(|list| (0..list.len()).map(move |at| [&list[(at + list.len() - 1) % list.len()], &list[at]]))
            .collect();
        let elements = &model.remeshings[self.index].elements;
        let face = |edge: &BoundaryEdge| {
            let (e, side) = edge.side;
            (elements[e as usize], face_of(&self.quads[e as usize], side))
        };
        let on_axis = |n: u32| model.mesh.points[self.nodes[n as usize]][0] == 0.0;
        let mut keep_ends = |is_in: &dyn Fn(&BoundaryEdge) -> bool, has: &dyn Fn(u32) -> bool| {
            for [before, after] in &edges {
                let (node, both) = (after.ends[0], [is_in(before), is_in(after)]);
                if both[0] != both[1] || has(node) && !both[0] {
                    is_kept[node as usize] = true;
                }
            }
        };
        keep_ends(&|edge| edge.ends.iter().all(|n| on_axis(*n)), &on_axis);
        let mut copy = model.clone();
        // Initial conditions have no effect after the start, and sets of nodes only on the output for all their members.
        copy.initial_conditions.clear();
        let shown = sets_shown_as_a_whole(model);
        let unused = copy.node_sets.values_mut().enumerate().filter(|(index, _)| !shown.contains(index));
        unused.for_each(|(_, set)| set.members.clear());
        let mut single = Vec::new();
        visit_lists(&mut copy, &mut |list| match list {
            MemberList::Node(node) => single.extend(self.position(*node)),
            MemberList::Nodes(list) => {
                let mut has = vec![false; self.nodes.len()];
                list.iter().filter_map(|n| self.position(*n)).for_each(|at| has[at as usize] = true);
                if has.contains(&true) {
                    keep_ends(&|edge| edge.ends.iter().all(|n| has[*n as usize]), &|n| has[n as usize]);
                }
            }
            MemberList::Faces(list) => {
                let named: FxHashSet<(usize, ElementSide)> = list.iter().copied().collect();
                keep_ends(&|edge| named.contains(&face(edge)), &|_| false);
            }
            MemberList::Elements(_) => {}
        });
        single.extend(required_nodes(model).filter_map(|node| self.position(node)));
        single.into_iter().for_each(|at| is_kept[at as usize] = true);
        is_kept
    }
}

/// Returns the requests of histories of single nodes, with their node sets.
fn histories_of_nodes(model: &Model) -> impl Iterator<Item = (&OutputRequest, NodeSetId)> {
    let requests = model.steps.iter().flat_map(|step| &step.outputs);
    let single = requests.filter(|request| request.kind == OutputKind::History && request.statistics.is_empty());
    single.filter_map(|request| match request.region {
        OutputRegion::Nodes(id) => Some((request, id)),
        _ => None,
    })
}

/// Returns whether points between nodes have all variables of a request.
fn is_of_points(request: &OutputRequest) -> bool {
    let is_continuous = |selection: &VariableRequest| {
        let variables = selection.variables();
        !variables.is_empty() && variables.iter().all(|variable| variable.is_continuous())
    };
    request.sensor.is_none() && request.variables.iter().all(is_continuous)
}

/// Returns the nodes of histories that must remain, because points between nodes do not have the variables.
pub fn kept_nodes_of_histories(model: &Model) -> impl Iterator<Item = usize> {
    let kept = histories_of_nodes(model).filter(|(request, _)| !is_of_points(request));
    kept.flat_map(|(_, id)| model.node_sets[id].members.iter().copied())
}

/// Returns the nodes that a new mesh must keep one by one: those of histories that show single nodes, and [`single_nodes`].
pub fn required_nodes(model: &Model) -> impl Iterator<Item = usize> {
    kept_nodes_of_histories(model).chain(single_nodes(model))
}

/// Returns the nodes of equations and links.
pub fn linked_nodes(model: &Model) -> impl Iterator<Item = usize> {
    let NodeConstraints { equations, links, .. } = &model.constraints;
    let terms = equations.iter().flat_map(|equation| equation.terms.iter().map(|term| term.0));
    let linked = links.iter().flat_map(|link| link.nodes.iter().chain([&link.reference]).copied());
    terms.chain(linked)
}

/// Returns the nodes of springs, dashpots and point masses, and those with concentrated loads.
pub fn single_nodes(model: &Model) -> impl Iterator<Item = usize> {
    let connectors = model.discrete.connectors.iter().flat_map(|property| &property.elements);
    let ends = connectors.flat_map(|e| model.mesh.elements[*e].nodes.iter().copied());
    let loads = model.steps.iter().flat_map(|step| &step.loads).filter_map(|load| match &load.kind {
        LoadKind::Concentrated { nodes, .. } | LoadKind::NodalHeat { nodes, .. } => Some(nodes),
        _ => None,
    });
    let masses = model.discrete.masses.iter().map(|mass| mass.node);
    ends.chain(masses).chain(loads.flatten().copied())
}

/// Returns the nodes of histories that [points](TracerPoint) between nodes can replace, in ascending order.
pub fn movable_nodes_of_histories(model: &Model) -> Vec<usize> {
    let movable = histories_of_nodes(model).filter(|(request, _)| is_of_points(request));
    let nodes = sorted_unique(movable.flat_map(|(_, id)| model.node_sets[id].members.iter().copied()));
    let kept = sorted_unique(kept_nodes_of_histories(model));
    nodes.into_iter().filter(|node| kept.binary_search(node).is_err()).collect()
}

/// Returns the indices of node sets whose extent output shows: those of frames and of statistics.
fn sets_shown_as_a_whole(model: &Model) -> FxHashSet<usize> {
    let requests = model.steps.iter().flat_map(|step| &step.outputs);
    let whole = requests.filter(|request| request.kind == OutputKind::Field || !request.statistics.is_empty());
    let sets = whole.filter_map(|request| match request.region {
        OutputRegion::Nodes(id) => Some(id.index()),
        _ => None,
    });
    sets.collect()
}

/// Returns the model with a new mesh of a body. Nodes and elements of other bodies keep their names and their order, and
/// those of the new mesh follow.
pub fn revised(model: &Model, revision: &MeshRevision) -> Model {
    let body = ModelBody::new(model, revision.body);
    let relation = MeshRelation::new(model, &body, revision);
    let mut new = model.clone();
    let shared = body.shared_nodes(model);
    new.mesh = relation.mesh(model, (&body, &shared), revision).into();
    visit_lists(&mut new, &mut |list| match list {
        MemberList::Node(node) => *node = relation.node(*node),
        MemberList::Nodes(list) => relation.follow_nodes(list, &body, revision),
        MemberList::Elements(list) => relation.follow_elements(list, model, revision),
        MemberList::Faces(list) => relation.follow_faces(list, model, (&body, revision)),
    });
    // Nodes of a condition without a node in the new mesh would be taken for those of a rigid body.
    new.initial_conditions.retain(|condition| !condition.members.is_empty());
    new.output.tracers = relation.tracers(model, revision);
    new.constraints.tie_places = relation.places(&body, revision);
    keep_history_nodes(&mut new, model, &relation);
    new.remeshings[revision.body].shared = relation.shared_places(&shared, revision);
    new
}

/// Returns the model with all nodes where they are at the last new mesh, to find the nodes of ties; `None` without a new mesh.
pub fn placed_for_ties(model: &Model) -> Option<Model> {
    let places = &model.constraints.tie_places;
    if places.is_empty() {
        return None;
    }
    let mut placed = model.clone();
    places.iter().enumerate().for_each(|(node, place)| placed.mesh.points[node] = *place);
    Some(placed)
}

/// Returns the face of a side of an element; the third side of a triangle is that from its last corner, its fourth one.
fn face_of(quad: &[u32; 4], side: u8) -> ElementSide {
    ElementSide::Face(if is_triangle(quad) { side.min(2) + 1 } else { side + 1 })
}

/// Added to the name of a node set for the nodes of its histories.
const OF_HISTORIES: &str = " (histories)";

/// Returns the name in the deck of a set that a new mesh may have renamed.
pub fn name_in_deck(set: &str) -> &str {
    set.strip_suffix(OF_HISTORIES).unwrap_or(set)
}

/// Gives histories of single nodes the nodes that they had before; their sets may also have new nodes.
fn keep_history_nodes(new: &mut Model, old: &Model, relation: &MeshRelation) {
    let Model { steps, node_sets, .. } = new;
    for request in steps.iter_mut().flat_map(|step| &mut step.outputs) {
        let OutputRegion::Nodes(id) = &mut request.region else { continue };
        if request.kind != OutputKind::History || !request.statistics.is_empty() {
            continue;
        }
        let Some((name, MemberSet { members, span })) = old.node_sets.get_index(id.index()) else { continue };
        let members = sorted_unique(members.iter().map(|node| relation.node(*node)));
        if node_sets[id.index()].members == members {
            continue;
        }
        let name = format!("{}{OF_HISTORIES}", name_in_deck(name));
        *id = NodeSetId::new(node_sets.insert_full(name, MemberSet { members, span: *span }).0);
    }
}

/// New indices of the nodes and elements of other bodies, and the first ones of the new mesh.
struct MeshRelation {
    nodes: Vec<usize>,
    elements: Vec<usize>,
    first_node: usize,
    first_element: usize,
}

/// Returns the points that take the places of nodes of a body. They are the last nodes of the revised model.
fn replaced_nodes<'a>(body: &'a ModelBody, revision: &'a MeshRevision) -> impl Iterator<Item = &'a TracerPoint> {
    revision.tracers.iter().filter(|point| body.position(point.node).is_some())
}

/// Marks what the new mesh does not have.
const GONE: usize = usize::MAX;

impl MeshRelation {
    fn new(model: &Model, body: &ModelBody, revision: &MeshRevision) -> MeshRelation {
        let mut nodes = vec![0; model.mesh.points.len()];
        let mut elements = vec![0; model.mesh.elements.len()];
        body.nodes.iter().for_each(|node| nodes[*node] = GONE);
        model.remeshings[revision.body].elements.iter().for_each(|e| elements[*e] = GONE);
        let number = |list: &mut [usize]| {
            list.iter_mut().filter(|place| **place != GONE).zip(0..).map(|(place, next)| *place = next).count()
        };
        let (first_node, first_element) = (number(&mut nodes), number(&mut elements));
        // Nodes at the places of old ones.
        for (new, parents) in revision.parents.iter().enumerate().filter(|(_, [a, b])| a == b && *a != INSIDE) {
            nodes[body.nodes[parents[0] as usize]] = first_node + new;
        }
        let after_mesh = first_node + revision.mesh.points.len();
        (after_mesh..).zip(replaced_nodes(body, revision)).for_each(|(new, point)| nodes[point.node] = new);
        MeshRelation { nodes, elements, first_node, first_element }
    }

    /// Returns the places of all nodes in the new model; empty if the revision has none.
    fn places(&self, body: &ModelBody, revision: &MeshRevision) -> Vec<[f64; 2]> {
        if revision.places.is_empty() {
            return Vec::new();
        }
        let others = (0..revision.places.len()).filter(|node| body.position(*node).is_none());
        let mut places: Vec<[f64; 2]> = others.map(|node| revision.places[node]).collect();
        places.extend(&revision.mesh.points);
        places.extend(replaced_nodes(body, revision).map(|point| point.start));
        places
    }

    /// Returns the nodes that other elements use, with their places in the new mesh.
    fn shared_places(&self, shared: &[u32], revision: &MeshRevision) -> Vec<(usize, [f64; 2])> {
        let new = revision.parents.iter().zip(&revision.mesh.points).enumerate();
        let kept = new.filter(|(_, ([a, b], _))| a == b && shared.binary_search(a).is_ok());
        kept.map(|(new, (_, place))| (self.first_node + new, *place)).collect()
    }

    fn node(&self, node: usize) -> usize {
        if self.nodes[node] == GONE { self.first_node } else { self.nodes[node] }
    }

    fn follow_nodes(&self, list: &mut Vec<usize>, body: &ModelBody, revision: &MeshRevision) {
        let mut has = vec![false; body.nodes.len()];
        list.iter().filter_map(|n| body.position(*n)).for_each(|at| has[at as usize] = true);
        let whole = !has.contains(&false);
        let others = list.iter().filter(|n| body.position(**n).is_none()).map(|n| self.nodes[*n]);
        let is_member = |parents: &[u32; 2]| {
            if parents[0] == INSIDE { whole } else { parents.iter().all(|p| has[*p as usize]) }
        };
        let new = revision.parents.iter().enumerate().filter(|(_, parents)| is_member(parents));
        *list = others.chain(new.map(|(new, _)| self.first_node + new)).collect();
    }

    /// Returns the points of histories: those between nodes of other bodies, and those of the new mesh.
    fn tracers(&self, model: &Model, revision: &MeshRevision) -> Vec<TracerPoint> {
        let is_other = |point: &&TracerPoint| TracerPoint::index_in(&revision.tracers, point.node).is_none();
        let others = model.output.tracers.iter().filter(is_other);
        let others = others.map(|point| point.renumbered(self.node(point.node), |node| self.node(node)));
        let own = revision.tracers.iter();
        let own = own.map(|point| point.renumbered(self.node(point.node), |node| self.first_node + node));
        let mut tracers: Vec<TracerPoint> = others.chain(own).collect();
        tracers.sort_unstable_by_key(|point| point.node);
        tracers
    }

    fn follow_elements(&self, list: &mut Vec<usize>, model: &Model, revision: &MeshRevision) {
        let elements = &model.remeshings[revision.body].elements;
        let mut has = vec![false; elements.len()];
        list.iter().filter_map(|e| elements.binary_search(e).ok()).for_each(|at| has[at] = true);
        let others = list.iter().map(|e| self.elements[*e]).filter(|e| *e != GONE);
        let new = revision.origins.iter().enumerate().filter(|(_, origin)| has[**origin as usize]);
        *list = others.chain(new.map(|(new, _)| self.first_element + new)).collect();
    }

    fn follow_faces(
        &self,
        list: &mut Vec<(usize, ElementSide)>,
        model: &Model,
        (body, revision): (&ModelBody, &MeshRevision),
    ) {
        let elements = &model.remeshings[revision.body].elements;
        let has: FxHashSet<(usize, ElementSide)> = list.iter().copied().collect();
        let others = list.iter().map(|(e, side)| (self.elements[*e], *side)).filter(|(e, _)| *e != GONE);
        let old = |(e, side): (u32, u8)| (elements[e as usize], face_of(&body.quads[e as usize], side));
        let new = revision.sides.iter().filter(|side| has.contains(&old(side.old)));
        let new = new.map(|side| {
            let (e, side_index) = (side.new.0 as usize, side.new.1);
            (self.first_element + e, face_of(&revision.mesh.quads[e], side_index))
        });
        *list = others.chain(new).collect();
    }

    /// Returns the mesh of the model with the new mesh of a body, whose `shared` nodes stay where they are at the start.
    fn mesh(&self, model: &Model, (body, shared): (&ModelBody, &[u32]), revision: &MeshRevision) -> Mesh {
        let old = &*model.mesh;
        let elements = &model.remeshings[revision.body].elements;
        let like = &old.elements[elements[0]];
        let mut node_labels = NewLabels::above(old.node_names.iter());
        let mut element_labels = NewLabels::above(old.elements.iter().map(|e| &e.name));
        let mut mesh = Mesh::default();
        for node in (0..old.points.len()).filter(|node| body.position(*node).is_none()) {
            mesh.points.push(old.points[node]);
            mesh.node_names.push(old.node_names[node].clone());
        }
        for (place, parents) in revision.mesh.points.iter().zip(&revision.parents) {
            let kept = (parents[0] == parents[1] && parents[0] != INSIDE).then(|| body.nodes[parents[0] as usize]);
            let is_shared = kept.is_some() && shared.binary_search(&parents[0]).is_ok();
            mesh.points.push(kept.filter(|_| is_shared).map_or(*place, |node| old.points[node]));
            mesh.node_names.push(match kept {
                Some(node) => old.node_names[node].clone(),
                None => node_labels.next(&old.node_names[body.nodes[0]]),
            });
        }
        for point in replaced_nodes(body, revision) {
            mesh.points.push(point.start);
            mesh.node_names.push(old.node_names[point.node].clone());
        }
        for (_, element) in old.elements.iter().enumerate().filter(|(e, _)| self.elements[*e] != GONE) {
            let nodes: Vec<usize> = element.nodes.iter().map(|node| self.nodes[*node]).collect();
            mesh.elements.push(Element { nodes: nodes[..].into(), ..element.clone() });
        }
        for (i, quad) in revision.mesh.quads.iter().enumerate() {
            let nodes = quad.map(|n| self.first_node + n as usize);
            let name = if i < revision.unchanged {
                old.elements[elements[revision.origins[i] as usize]].name.clone()
            } else {
                element_labels.next(&like.name)
            };
            let (kind, count) = match (is_triangle(quad), like.kind.is_thermal()) {
                (false, false) => (ElementKind::Cax4r, 4),
                (false, true) => (ElementKind::Cax4rt, 4),
                (true, false) => (ElementKind::Cax3, 3),
                (true, true) => (ElementKind::Cax3t, 3),
            };
            mesh.elements.push(Element { name, kind, nodes: nodes[..count].into(), span: like.span });
        }
        mesh
    }
}

/// Passes all lists of nodes, elements and faces to `visit`, except the elements of the mesh.
fn visit_lists(model: &mut Model, visit: &mut dyn FnMut(MemberList<'_>)) {
    let Model { node_sets, element_sets, surfaces, sections, shell_sections, cohesive_sections, erosions, .. } = model;
    node_sets.values_mut().for_each(|set| visit(MemberList::Nodes(&mut set.members)));
    element_sets.values_mut().for_each(|set| visit(MemberList::Elements(&mut set.members)));
    for surface in surfaces.faces.values_mut() {
        visit(MemberList::Faces(&mut surface.faces));
        visit(MemberList::Elements(&mut surface.free_face_elements));
    }
    surfaces.parts.iter_mut().flatten().for_each(|part| visit(MemberList::Elements(part)));
    surfaces.nodes.values_mut().for_each(|nodes| visit(MemberList::Nodes(nodes)));
    let references = surfaces.analytical.values_mut().filter_map(|surface| surface.reference.as_mut());
    references.for_each(|node| visit(MemberList::Node(node)));
    sections.iter_mut().for_each(|section| visit(MemberList::Elements(&mut section.elements)));
    shell_sections.iter_mut().for_each(|section| visit(MemberList::Elements(&mut section.elements)));
    cohesive_sections.iter_mut().for_each(|section| visit(MemberList::Elements(&mut section.elements)));
    erosions.iter_mut().filter_map(|e| e.elements.as_mut()).for_each(|list| visit(MemberList::Elements(list)));
    let Model { remeshings, rigid_bodies, attitudes, discrete, constraints, initial_conditions, steps, .. } = model;
    for remeshing in remeshings {
        visit(MemberList::Elements(&mut remeshing.elements));
        remeshing.shared.iter_mut().for_each(|(node, _)| visit(MemberList::Node(node)));
    }
    for body in rigid_bodies {
        visit(MemberList::Node(&mut body.reference));
        visit(MemberList::Elements(&mut body.elements));
        visit(MemberList::Nodes(&mut body.nodes));
    }
    attitudes.iter_mut().for_each(|attitude| visit(MemberList::Node(&mut attitude.reference)));
    discrete.masses.iter_mut().for_each(|mass| visit(MemberList::Node(&mut mass.node)));
    discrete.inertias.iter_mut().for_each(|inertia| visit(MemberList::Node(&mut inertia.node)));
    discrete.connectors.iter_mut().for_each(|connector| visit(MemberList::Elements(&mut connector.elements)));
    let terms = constraints.equations.iter_mut().flat_map(|equation| &mut equation.terms);
    terms.for_each(|term| visit(MemberList::Node(&mut term.0)));
    for link in &mut constraints.links {
        visit(MemberList::Node(&mut link.reference));
        link.nodes.iter_mut().for_each(|node| visit(MemberList::Node(node)));
    }
    for tie in &mut constraints.ties {
        visit(MemberList::Nodes(&mut tie.slaves));
        visit(MemberList::Faces(&mut tie.slave_faces));
        visit(MemberList::Faces(&mut tie.masters));
        tie.chosen.iter_mut().for_each(|nodes| visit(MemberList::Nodes(nodes)));
    }
    for condition in initial_conditions {
        visit(if condition.kind.applies_to_elements() {
            MemberList::Elements(&mut condition.members)
        } else {
            MemberList::Nodes(&mut condition.members)
        });
    }
    steps.iter_mut().for_each(|step| visit_step(step, visit));
}

fn visit_step(step: &mut Step, visit: &mut dyn FnMut(MemberList<'_>)) {
    step.boundaries.iter_mut().for_each(|boundary| visit(MemberList::Nodes(&mut boundary.nodes)));
    step.loads.iter_mut().for_each(|load| visit_load(&mut load.kind, visit));
    step.fields.iter_mut().for_each(|field| visit(MemberList::Nodes(&mut field.nodes)));
    for contact in &mut step.surface_contacts {
        contact.sides.iter_mut().for_each(|sides| visit_sides(sides, visit));
        contact.analytical.iter_mut().for_each(|side| visit(MemberList::Nodes(&mut side.nodes)));
    }
    step.general_contact.iter_mut().for_each(|general| visit_general(general, visit));
    let scaled = step.mass_scalings.iter_mut().filter_map(|scaling| scaling.elements.as_mut());
    scaled.for_each(|list| visit(MemberList::Elements(list)));
    step.adaptive.iter_mut().for_each(|mesh| visit(MemberList::Elements(&mut mesh.elements)));
    step.adaptive_fixed.iter_mut().for_each(|(_, nodes)| visit(MemberList::Nodes(nodes)));
    step.mesh_motions.iter_mut().for_each(|motion| visit(MemberList::Nodes(&mut motion.nodes)));
    for region in &mut step.adaptive_regions {
        visit(MemberList::Faces(&mut region.faces));
        visit(MemberList::Nodes(&mut region.nodes));
    }
}

fn visit_sides(sides: &mut SideSelection, visit: &mut dyn FnMut(MemberList<'_>)) {
    visit(MemberList::Faces(&mut sides.faces));
    visit(MemberList::Elements(&mut sides.free_face_elements));
}

fn visit_general(general: &mut GeneralContact, visit: &mut dyn FnMut(MemberList<'_>)) {
    let GeneralContact { included, excluded, assigned, clearances, penalties, roles, .. } = general;
    let domains = included.iter_mut().chain(excluded).chain(assigned.iter_mut().map(|a| &mut a.domains));
    let more = clearances.iter_mut().map(|c| &mut c.0).chain(penalties.iter_mut().map(|p| &mut p.0));
    let all = domains.chain(more).chain(roles.iter_mut().map(|role| &mut role.0));
    for domain in all.flat_map(|domains| &mut domains.sides) {
        if let ContactDomain::Surface(sides) = domain {
            visit_sides(sides, visit);
        }
    }
}

fn visit_load(kind: &mut LoadKind, visit: &mut dyn FnMut(MemberList<'_>)) {
    match kind.region_mut() {
        // Each node has the whole load: new nodes between two loaded nodes have none.
        LoadRegionMut::Nodes(nodes) => nodes.iter_mut().for_each(|node| visit(MemberList::Node(node))),
        LoadRegionMut::Elements(elements) => visit(MemberList::Elements(elements)),
        LoadRegionMut::Sides(sides) => visit_sides(sides, visit),
        LoadRegionMut::Whole => {}
    }
    if let LoadKind::Traction { law: SurfaceTraction::Viscous { reference: Some(node) }, .. } = kind {
        visit(MemberList::Node(node));
    }
}

/// Returns the pairs of an element outside a body and a node that it shares with the body, in the numbering of the body, without
/// point masses, springs and dashpots. `elements` are those of the body, in ascending order.
pub fn elements_at_body<'a>(
    mesh: &'a Mesh,
    body: &'a ModelBody,
    elements: &'a [usize],
) -> impl Iterator<Item = (usize, u32)> + 'a {
    let is_discrete = |e: usize| {
        let kind = mesh.elements[e].kind;
        kind.is_connector() || kind == ElementKind::Mass
    };
    let others = (0..mesh.elements.len()).filter(move |e| elements.binary_search(e).is_err() && !is_discrete(*e));
    others.flat_map(move |e| mesh.elements[e].nodes.iter().filter_map(move |node| Some((e, body.position(*node)?))))
}
