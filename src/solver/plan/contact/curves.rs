//! Contact curves: the exposed facets of a surface, the interior facets that element deletion may expose, their points,
//! and the penetration depth up to which a facet is in contact.

use std::cell::OnceCell;
use std::collections::HashSet;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::constraint::contact::analytical::AnalyticalSurface;
use crate::constraint::contact::curve::{FacetCurve, PointCarrier, SurfacePoint};
use crate::deck::Diagnostic;
use crate::kernel::lists::sorted_pair;
use crate::kernel::sorted_boxes::{BoundingBox, SortedBoxes, bounding_box};
use crate::model::{
    AnalyticalFront, Element, ElementSide, GeneralContact, Mesh, Model, ShellSection, SideSelection, SurfaceContact,
};
use crate::plan::meshes::pieces::pieces;
use crate::plan::solids::user_material::deletes;
use crate::plan::{Report, Scene, StepInput};

/// Maximum penetration of a facet, in facet lengths.
const DEEPEST: f64 = 2.0;
/// Minimum penetration depth of a shell facet, in facet lengths.
const LEAST_DEPTH: f64 = 0.1;
/// Distance from the ends of a facet, as a fraction of the facet, at which the thickness of the body is measured.
const NEAR_END: f64 = 0.05;

/// Points, curves and analytical surfaces of the contact of a step.
#[derive(Default)]
pub struct ContactGeometry {
    pub points: Vec<SurfacePoint>,
    pub places: Vec<[f64; 2]>,
    pub point_of_node: FxHashMap<usize, u32>,
    pub curves: Vec<FacetCurve>,
    /// Element and nodes of each exposed facet, by curve.
    pub facet_elements: Vec<Vec<(usize, [usize; 2])>>,
    /// Smallest thickness of the elements at the facets of each curve.
    pub thicknesses: Vec<f64>,
    /// Maximum and mean facet length of each curve, and whether it has deformable nodes.
    pub lengths: Vec<[f64; 2]>,
    pub deforms: Vec<bool>,
    /// Curves of a surface: with the thickness of shells, and without it.
    by_name: FxHashMap<String, [Option<usize>; 2]>,
    pub analyticals: Vec<AnalyticalSurface>,
    /// Fronts of the analytical surfaces.
    pub fronts: Vec<AnalyticalFront>,
}

/// Data that points and facets depend on.
pub struct CurveContext<'a> {
    pub input: StepInput<'a, 'a>,
    /// Degrees of freedom (node, axis) that are prescribed, directly or by nodes with equal motion.
    pub prescribed: &'a HashSet<(usize, usize)>,
    /// Degrees of freedom in equations.
    pub in_equations: &'a HashSet<(usize, usize)>,
    /// Faces that ties join to other faces, as ascending pairs of mesh nodes.
    pub tied_faces: &'a FxHashSet<[usize; 2]>,
    /// Outline of the solid elements.
    pub skin: &'a SolidOutline,
    /// General contact of the step, and all contact pairs of the step.
    pub general: Option<&'a GeneralContact>,
    pub pairs: &'a [SurfaceContact],
    /// Ledger row of general contact.
    pub general_row: OnceCell<usize>,
}

/// Reason why a node cannot be in contact.
pub enum PointRefusal {
    /// The node is in an equation or follows one that is.
    Equation(usize),
    /// The node belongs to no body.
    NoBody(usize),
}

impl PointRefusal {
    pub fn message(&self, mesh: &Mesh) -> String {
        match *self {
            PointRefusal::Equation(node) => {
                let why = "is in an equation (*EQUATION, *TIE, *DISTRIBUTING): remove it from the surface";
                format!("node {} is in contact and {why}", mesh.node_names[node])
            }
            PointRefusal::NoBody(node) => format!("node {} belongs to no body", mesh.node_names[node]),
        }
    }
}

type MeridianEdge = [[f64; 2]; 2];

/// Outline of the solid elements without edges on the axis: each edge with its connected part, and the part of each
/// element.
#[derive(Default)]
pub struct SolidOutline {
    edges: Vec<(MeridianEdge, usize)>,
    sorted: SortedBoxes,
    piece_of: FxHashMap<usize, usize>,
}

impl SolidOutline {
    /// Returns the edges that may bound the body of an element in a box: the edges of its part, or all edges for other
    /// elements.
    fn edges_of_body(&self, element: usize, within: BoundingBox) -> Vec<MeridianEdge> {
        let body_piece = self.piece_of.get(&element).copied();
        let mut edges = Vec::new();
        self.sorted.near(within, 0.0, |index| {
            let (edge, piece) = self.edges[index as usize];
            if body_piece.is_none_or(|body_piece| body_piece == piece) {
                edges.push(edge);
            }
        });
        edges
    }
}

fn is_off_axis(edge: &MeridianEdge) -> bool {
    edge.iter().any(|p| p[0] != 0.0)
}

/// Returns whether a surface is one side of line elements, and other pairs of general contact have the other side.
fn has_both_sides(sides: &SideSelection, pairs: &[SurfaceContact]) -> bool {
    let other = |face: &(usize, ElementSide)| match face.1 {
        ElementSide::Positive => Some((face.0, ElementSide::Negative)),
        ElementSide::Negative => Some((face.0, ElementSide::Positive)),
        ElementSide::Face(_) => None,
    };
    let Some(other) = sides.faces.first().and_then(other) else { return false };
    pairs.iter().filter(|p| p.general).any(|p| p.sides.iter().any(|s| s.faces.contains(&other)))
}

/// Returns the index of the curve of one surface of a pair. Unsupported surfaces are reported as errors.
pub fn add_curve(
    contact: &SurfaceContact,
    which: usize,
    context: &CurveContext,
    geometry: &mut ContactGeometry,
    report: &mut Report,
) -> Option<usize> {
    let scene = context.input.scene;
    let sides = &contact.sides[which];
    let variant = usize::from(contact.no_thickness);
    if let Some(known) = geometry.by_name.get(&sides.name).and_then(|curves| curves[variant]) {
        return Some(known);
    }
    let (mut facets, mut lifts) = (Vec::new(), Vec::new());
    let (mut facet_elements, mut left_out) = (Vec::new(), Vec::new());
    for &(element, side) in &sides.faces {
        let Some(mut ends) = scene.model.mesh.side_nodes(element, side) else { continue };
        if contact.general && context.tied_faces.contains(&sorted_pair(ends)) {
            continue;
        }
        // The body is to the left of a facet. On the positive side of a shell the direction is reversed.
        if side == ElementSide::Positive {
            ends.reverse();
        }
        let points = ends.map(|node| point_of(node, context, geometry));
        let facet = match points {
            [Ok(a), Ok(b)] => [a, b],
            // Tied surfaces are inside a body. General contact contains them, although the deck does not name them.
            [Err(PointRefusal::Equation(node)), _] | [_, Err(PointRefusal::Equation(node))] if contact.general => {
                left_out.push(node);
                continue;
            }
            [Err(why), _] | [_, Err(why)] => {
                let finding = Diagnostic::error("P021", why.message(&scene.model.mesh));
                return report.refuse(finding.at(contact.span, "this pair"));
            }
        };
        facet_elements.push((element, ends));
        // Facets on the axis are inside a body.
        if facet.iter().any(|&p| geometry.places[p as usize][0] != 0.0) {
            facets.push((facet, element));
            lifts.push(if contact.no_thickness { 0.0 } else { distance_to_surface(scene.model, element, side) });
        }
    }
    warn_of_left_out(scene.model, contact, &sides.name, &left_out, report);
    facet_elements.retain(|(_, ends)| ends.iter().any(|&n| scene.model.mesh.points[n][0] != 0.0));
    // All faces of a body inside another one can be tied.
    if facets.is_empty() && contact.general && !context.tied_faces.is_empty() {
        return None;
    }
    if facets.is_empty() {
        let message = format!("surface `{}` has no facets off the axis", sides.name);
        return report.refuse(Diagnostic::error("P021", message).at(contact.span, "this pair"));
    }
    let exposed_count = facets.len();
    if deletes(scene) {
        hidden_facets(context, geometry, &mut facets);
    }
    lifts.resize(facets.len(), 0.0);
    let curve = geometry.add_curve(&facets, lifts, exposed_count, (context.skin, &shells_of(scene.model, sides)));
    geometry.curves[curve].is_side_of_line =
        contact.general && shell_section(scene.model, facets[0].1).is_none() && has_both_sides(sides, context.pairs);
    geometry.thicknesses.push(smallest_thickness(scene, &facet_elements));
    geometry.facet_elements.push(facet_elements);
    geometry.by_name.entry(sides.name.clone()).or_default()[variant] = Some(curve);
    Some(curve)
}

/// Returns the smallest thickness normal to the surface of the deformable solid elements of facets; infinite without
/// any.
fn smallest_thickness(scene: Scene, facets: &[(usize, [usize; 2])]) -> f64 {
    let mesh = &scene.model.mesh;
    let thickness = |&(element, nodes): &(usize, [usize; 2])| {
        let mesh_element = &mesh.elements[element];
        if !scene.places.elements.contains_key(&element) || !mesh_element.kind.is_solid() {
            return f64::INFINITY;
        }
        let [a, b] = nodes.map(|n| mesh.points[n]);
        height(mesh_element, &mesh.points, libm::hypot(b[0] - a[0], b[1] - a[1]))
    };
    facets.iter().map(thickness).fold(f64::INFINITY, f64::min)
}

/// Returns the thickness of an element normal to a side: area over side length, for triangles twice this value.
pub fn height(element: &Element, points: &[[f64; 2]], length: f64) -> f64 {
    let corner = |i: usize| points[element.nodes[i % element.nodes.len()]];
    let cross = |i: usize| corner(i)[0] * corner(i + 1)[1] - corner(i + 1)[0] * corner(i)[1];
    let area = 0.5 * (0..element.nodes.len()).map(cross).sum::<f64>();
    // A facet of a six-node triangle is half of a side.
    let share = if element.nodes.len() == 3 { 2.0 } else { 1.0 };
    share * area.abs() / length
}

/// Warns of the facets that general contact leaves out because of nodes in equations.
fn warn_of_left_out(model: &Model, contact: &SurfaceContact, surface: &str, nodes: &[usize], report: &mut Report) {
    let Some(&first) = nodes.first() else { return };
    let name = &model.mesh.node_names[first];
    let count = nodes.len();
    let message = format!("{count} facets of `{surface}` are not in contact, because their nodes are in equations");
    let finding = Diagnostic::warning("P123", message).at(contact.span, format!("for example at node {name}"));
    report.push(finding.help("no other body must reach these facets; tied faces are inside a body"));
}

/// Adds the interior faces of the bodies of the exposed facets, one per side. They are exposed when the element in
/// front is deleted.
fn hidden_facets(context: &CurveContext, geometry: &mut ContactGeometry, facets: &mut Vec<([u32; 2], usize)>) {
    let mesh = &context.input.scene.model.mesh;
    let exposed_elements: FxHashSet<usize> = facets.iter().map(|f| f.1).collect();
    let solids: Vec<usize> =
        context.input.scene.places.elements.keys().filter(|e| mesh.elements[*e].kind.is_solid()).collect();
    for piece in pieces(mesh, &solids).iter().filter(|p| p.iter().any(|e| exposed_elements.contains(e))) {
        let edges = |e: usize| {
            let nodes = &mesh.elements[e].nodes;
            (0..nodes.len()).map(move |i| [nodes[i], nodes[(i + 1) % nodes.len()]])
        };
        let piece_edges: FxHashSet<[usize; 2]> = piece.iter().flat_map(|&e| edges(e)).collect();
        for &e in piece {
            for edge in edges(e).filter(|[a, b]| piece_edges.contains(&[*b, *a])) {
                let points = edge.map(|node| match geometry.point_of_node.get(&node) {
                    Some(&known) => Some(known),
                    None => {
                        let point = contact_point(node, context).ok()?;
                        Some(geometry.add(node, point, mesh.points[node]))
                    }
                });
                // Faces with dependent nodes are left out, because these cannot be in contact.
                if let [Some(a), Some(b)] = points {
                    facets.push(([a, b], e));
                }
            }
        }
    }
}

/// Returns the shell section of an element.
fn shell_section(model: &Model, element: usize) -> Option<&ShellSection> {
    model.shell_sections.iter().find(|section| section.elements.contains(&element))
}

/// Returns the initial distance from the nodes of a shell element to its surface on a side; 0 for other elements.
fn distance_to_surface(model: &Model, element: usize, side: ElementSide) -> f64 {
    let distances = shell_section(model, element).map_or([0.0; 2], ShellSection::distances);
    distances[usize::from(side == ElementSide::Positive)]
}

pub fn point_of(node: usize, context: &CurveContext, geometry: &mut ContactGeometry) -> Result<u32, PointRefusal> {
    match geometry.point_of_node.get(&node) {
        Some(&known) => Ok(known),
        None => Ok(geometry.add(node, contact_point(node, context)?, context.input.scene.model.mesh.points[node])),
    }
}

/// Returns the node or rigid body of a contact point, and the axes along which it is free.
fn contact_point(
    node: usize,
    CurveContext { input, prescribed, in_equations, .. }: &CurveContext,
) -> Result<SurfacePoint, PointRefusal> {
    let scene = input.scene;
    let mesh = &scene.model.mesh;
    if let Some(place) = scene.places.free_node(node) {
        if in_equations.contains(&(place, 0)) || in_equations.contains(&(place, 1)) {
            return Err(PointRefusal::Equation(node));
        }
        let free = [0, 1].map(|axis| !prescribed.contains(&(place, axis)));
        return Ok(SurfacePoint { carrier: PointCarrier::Node(place), free });
    }
    let body = scene.places.tied.get(&node).or_else(|| scene.bodies.of_node.get(&node));
    match body {
        Some(&body) => Ok(SurfacePoint { carrier: PointCarrier::Body(body, mesh.points[node]), free: [false, true] }),
        None => Err(PointRefusal::NoBody(node)),
    }
}

/// Returns the outline of all solid elements, without edges on the axis.
pub fn solid_skin(model: &Model) -> SolidOutline {
    let mesh = &model.mesh;
    let solids: Vec<usize> = (0..mesh.elements.len()).filter(|e| mesh.elements[*e].kind.is_solid()).collect();
    let mut skin = SolidOutline::default();
    for (piece, elements) in pieces(mesh, &solids).into_iter().enumerate() {
        skin.piece_of.extend(elements.into_iter().map(|e| (e, piece)));
    }
    for (element, side) in mesh.exterior_faces() {
        let (Some(ends), Some(&piece)) = (mesh.side_nodes(element, side), skin.piece_of.get(&element)) else {
            continue;
        };
        let edge = ends.map(|n| mesh.points[n]);
        skin.edges.extend(is_off_axis(&edge).then_some((edge, piece)));
    }
    skin.sorted.sort(skin.edges.iter().map(|e| bounding_box(e.0)).zip(0..));
    skin
}

fn shells_of(model: &Model, sides: &SideSelection) -> Vec<MeridianEdge> {
    let mesh = &model.mesh;
    let shells = sides.faces.iter().filter(|f| matches!(f.1, ElementSide::Positive | ElementSide::Negative));
    let shells = shells.filter_map(|&(e, side)| mesh.side_nodes(e, side)).map(|e| e.map(|n| mesh.points[n]));
    shells.filter(is_off_axis).collect()
}

impl ContactGeometry {
    fn add(&mut self, node: usize, point: SurfacePoint, place: [f64; 2]) -> u32 {
        let index = self.points.len() as u32;
        self.points.push(point);
        self.places.push(place);
        self.point_of_node.insert(node, index);
        index
    }

    /// Adds a point of a rigid body at the origin.
    pub fn add_carried(&mut self, body: usize) -> u32 {
        self.points.push(SurfacePoint { carrier: PointCarrier::Body(body, [0.0; 2]), free: [false, true] });
        self.places.push([0.0; 2]);
        self.points.len() as u32 - 1
    }

    /// Returns the maximum penetration of a curve into an analytical surface in soft contact.
    pub fn deepest(&self, curve: usize) -> f64 {
        DEEPEST * self.lengths[curve][0]
    }

    /// Adds a curve of points without facets.
    pub fn add_points(&mut self, curve: FacetCurve) -> usize {
        self.deforms.push(true);
        // Without facets there is no length scale.
        self.lengths.push([f64::INFINITY; 2]);
        self.facet_elements.push(Vec::new());
        self.thicknesses.push(f64::INFINITY);
        self.curves.push(curve);
        self.curves.len() - 1
    }

    fn add_curve(
        &mut self,
        facets: &[([u32; 2], usize)],
        lift: Vec<f64>,
        exposed_count: usize,
        (solids, shells): (&SolidOutline, &[MeridianEdge]),
    ) -> usize {
        let ends = |f: &[u32; 2]| f.map(|p| self.places[p as usize]);
        let lengths: Vec<f64> = facets.iter().map(|(f, _)| length(ends(f))).collect();
        let mut depths: Vec<[f64; 3]> = facets[..exposed_count]
            .iter()
            .zip(&lengths)
            .map(|((f, element), l)| {
                let [first, middle, second] = [NEAR_END, 0.5, 1.0 - NEAR_END].map(|part| {
                    let probe = InwardNormal::new(ends(f), *l, part);
                    let around = solids.edges_of_body(*element, probe.bounds());
                    probe.depth(around.into_iter().chain(shells.iter().copied()))
                });
                // The body is thin at an acute corner.
                [first.min(middle), middle, second.min(middle)]
            })
            .collect();
        // A body may be only one element thick below an interior facet.
        depths.extend(lengths[exposed_count..].iter().map(|l| [0.5 * l; 3]));
        // Points beyond the middle surface of a shell are on its other side.
        for (depth, (half, length)) in depths.iter_mut().zip(lift.iter().zip(&lengths)).filter(|d| *d.1.0 > 0.0) {
            *depth = [half.max(LEAST_DEPTH * length); 3];
        }
        let lengths = &lengths[..exposed_count];
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let node = |p: u32| matches!(self.points[p as usize].carrier, PointCarrier::Node(_));
        self.deforms.push(facets[..exposed_count].iter().any(|(f, _)| f.iter().any(|p| node(*p))));
        self.lengths.push([longest, lengths.iter().sum::<f64>() / lengths.len() as f64]);
        let ends = facets.iter().map(|f| f.0).collect();
        let mut curve = FacetCurve::new(ends, depths, exposed_count, &self.places);
        curve.lift = lift;
        self.curves.push(curve);
        self.curves.len() - 1
    }
}

fn length([a, b]: [[f64; 2]; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

/// The inward normal at a point of a facet, along which the opposite side of its body is searched.
struct InwardNormal {
    start: [f64; 2],
    inward: [f64; 2],
    length: f64,
}

impl InwardNormal {
    /// Creates the normal at the coordinate `part` of the facet, from 0 to 1.
    fn new([a, b]: MeridianEdge, length: f64, part: f64) -> InwardNormal {
        let start = [0, 1].map(|i| (1.0 - part) * a[i] + part * b[i]);
        InwardNormal { start, inward: [-(b[1] - a[1]) / length, (b[0] - a[0]) / length], length }
    }

    /// Distance up to which the opposite side is searched.
    fn reach(&self) -> f64 {
        2.0 * DEEPEST * self.length
    }

    fn bounds(&self) -> BoundingBox {
        bounding_box([self.start, [0, 1].map(|i| self.start[i] + self.reach() * self.inward[i])])
    }

    /// Returns the penetration depth up to which the facet is in contact there: half of the distance to the opposite side of
    /// its body, at most [`DEEPEST`] facet lengths.
    fn depth(&self, skin: impl Iterator<Item = MeridianEdge>) -> f64 {
        let InwardNormal { start, inward, length } = self;
        let mut nearest = self.reach();
        for [p, q] in skin {
            let (d, e) = ([p[0] - start[0], p[1] - start[1]], [q[0] - p[0], q[1] - p[1]]);
            let cross = inward[0] * e[1] - inward[1] * e[0];
            let way = (d[0] * e[1] - d[1] * e[0]) / cross;
            let part = (d[0] * inward[1] - d[1] * inward[0]) / cross;
            if (0.0..=1.0).contains(&part) && way > 1e-6 * length && way < nearest {
                nearest = way;
            }
        }
        0.5 * nearest
    }
}
