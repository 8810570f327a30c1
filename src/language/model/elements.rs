//! Element types, and the cards `*ELEMENT` and `*ELGEN`.

use std::collections::HashMap;

use indexmap::IndexMap;

use super::budget::BudgetedItem;
use super::context::Context;
use super::element_nodes::NodeIndices;
use super::element_words::element_shape;
use super::families::MeshReader;
use super::name::EntityName;
use super::names::{DuplicateLabel, SetKind};
use super::types::{Element, ElementKind};
use super::{cohesive, sets};
use crate::deck::names::nearest;
use crate::deck::rows::words;
use crate::deck::syntax::ListingRow;
use crate::deck::{Card, DataLine, Diagnostic, Span, Word};
use crate::kernel::topology::ElementTopology;

/// Axisymmetric element types of ABAQUS that are not supported, with the alternative or the reason.
const AXISYMMETRIC: &[(&str, &str)] = &[
    ("CAX4", "use CAX4R, which has one integration point"),
    ("CAX4H", "use CAX4R"),
    ("CAX4RH", "use CAX4R"),
    ("CAX4I", "use CAX4R"),
    ("CAX4T", "use CAX4RT, which has one integration point"),
    ("CAX3H", "use CAX3"),
    ("CAX6MT", "use CAX3T or CAX4RT for nodal temperatures"),
    ("CAX6", "use CAX6M"),
    ("CAX6H", "use CAX6M, which does not lock"),
    ("CAX8", "use CAX4R; explicit dynamics requires linear elements"),
    ("CAX8R", "use CAX4R; explicit dynamics requires linear elements"),
    ("CAX8RT", "use CAX4RT; explicit dynamics requires linear elements"),
    ("SAX2", "use SAX1; explicit dynamics requires linear elements"),
    ("MAX1", "membranes are not simulated"),
    ("SPRING2", "use SPRINGA or SPRING1"),
    ("DASHPOT2", "use DASHPOTA or DASHPOT1"),
];

/// Reason of elements of porous media.
const PORE_PRESSURE: &str = "pore pressures are not simulated; use CAX3, CAX4R or CAX6M";
/// Families of element types that ABAQUS knows for the r-z plane and that are not supported: prefix, and the reason.
const FAMILIES: &[(&str, &str)] = &[
    ("CGAX", "it has twist about the axis; use CAX3 or CAX4R, which have none"),
    ("MGAX", "membranes are not simulated"),
    ("SFM", "surface elements are not simulated"),
    ("CAXA", "its deformation is not axisymmetric"),
    ("SAXA", "its deformation is not axisymmetric"),
    ("CINAX", "use CINAX4; explicit dynamics requires linear elements"),
    ("CAX3P", PORE_PRESSURE),
    ("CAX4P", PORE_PRESSURE),
    ("CAX4RP", PORE_PRESSURE),
    ("CAX6MP", PORE_PRESSURE),
    ("CAX8P", PORE_PRESSURE),
    ("CAX8RP", PORE_PRESSURE),
    ("CAX4HT", "use CAX4RT"),
    ("CAX4RHT", "use CAX4RT"),
    ("CAX4IH", "use CAX4R"),
    ("CAX6MH", "use CAX6M, which does not lock"),
    ("CAX8", "use CAX4R or CAX4RT; explicit dynamics requires linear elements"),
    ("ACAX", "acoustic elements are not simulated; model the fluid as CAX4R with *EOS"),
    ("DCAX", "use CAX3T or CAX4RT, which also conduct heat"),
    ("DSAX", "shells do not conduct heat; use CAX4RT"),
    ("COHAX", "use COHAX4"),
    ("GAP", "use *CONTACT PAIR or general contact"),
    ("ITS", "use *CONTACT PAIR or general contact"),
    ("CONN2D", "connectors are not simulated"),
    ("HEATCAP", "heat capacities at nodes are not simulated"),
    ("DCOUP", "distributing couplings are not simulated; use *COUPLING with *KINEMATIC"),
];

/// Other geometries, with the prefixes of the names of their element types.
const OTHER_GEOMETRY: &[(&str, &[&str])] = &[
    ("three-dimensional", &["C3D", "SC6", "SC8", "R3D", "COH3D"]),
    ("a three-dimensional shell", &["S3", "S4", "S8", "STRI"]),
    ("a three-dimensional membrane", &["M3D"]),
    ("a three-dimensional truss", &["T3D"]),
    ("a three-dimensional beam", &["B3"]),
    ("plane strain", &["CPE"]),
    ("plane stress", &["CPS"]),
    ("plane", &["COH2D", "R2D2"]),
    ("a plane truss", &["T2D"]),
    ("a plane beam", &["B2"]),
    ("three-dimensional Eulerian", &["EC3D"]),
    ("a particle", &["PC3D"]),
    ("acoustic", &["AC"]),
    ("for heat transfer", &["DC"]),
];

impl ElementKind {
    /// Returns whether the type is a deformable solid.
    pub fn is_solid(self) -> bool {
        self.topology().is_some_and(ElementTopology::is_solid)
    }

    /// Converts nodes from the order of ABAQUS (corners, then midside nodes) to the order around the boundary.
    pub fn around(self, nodes: &[usize]) -> NodeIndices {
        match (self, nodes) {
            (ElementKind::Cax6m, &[a, b, c, ab, bc, ca]) => [a, ab, b, bc, c, ca][..].into(),
            _ => nodes.into(),
        }
    }

    /// Returns the one-based boundary segments of an ABAQUS face; empty if the type has no such face. A cohesive element
    /// has the faces 1 (bottom) and 3 (top).
    pub fn face(self, number: u8) -> std::ops::Range<u8> {
        let parts = if self == ElementKind::Cax6m { 2 } else { 1 };
        if self.is_cohesive() && number.is_multiple_of(2) {
            return 0..0;
        }
        let count = self.node_count() as u8 / parts;
        if (1..=count).contains(&number) { parts * (number - 1) + 1..parts * number + 1 } else { 0..0 }
    }

    /// Returns whether the type is a line with two sides: a shell, or a rigid surface element.
    pub fn is_line(self) -> bool {
        matches!(self, ElementKind::Rax2 | ElementKind::Sax1)
    }

    /// Returns whether the type is cohesive.
    pub fn is_cohesive(self) -> bool {
        self == ElementKind::Cohax4
    }

    /// Returns whether the type is a deformable shell.
    pub fn is_shell(self) -> bool {
        self == ElementKind::Sax1
    }

    /// Returns whether the nodes have temperatures.
    pub fn is_thermal(self) -> bool {
        matches!(self, ElementKind::Cax3t | ElementKind::Cax4rt)
    }

    /// Returns whether the type is a spring or a dashpot.
    pub fn is_connector(self) -> bool {
        use ElementKind::{Dashpot1, DashpotA, Spring1, SpringA};
        matches!(self, Dashpot1 | DashpotA | Spring1 | SpringA)
    }

    /// Returns whether the type is no part of the mesh of a body: point mass, rotary inertia, spring, dashpot or infinite
    /// element.
    pub fn is_discrete(self) -> bool {
        matches!(self, ElementKind::Mass | ElementKind::RotaryInertia | ElementKind::Cinax4) || self.is_connector()
    }
}

/// Returns the advice for an element type that mesh generators write for a mesh in the r-z plane: edges and faces.
fn replacement(name: &str) -> Option<String> {
    const READ: &str = "read the file of a mesh generator with *MESH, INPUT=FILE";
    let counterpart = match element_shape(name).ok()? {
        (2, 1) => return Some(format!("{READ}, which makes sets and surfaces of its edges, or delete these lines")),
        (3, 2) => "CAX3",
        (4, 2) => "CAX4R",
        (6, 2) => "CAX6M",
        _ => return None,
    };
    Some(format!("{READ}, or write TYPE={counterpart}"))
}

pub fn read_elements(context: &mut Context<'_>, card: &Card) {
    let Some(kind) = context.required(card, "TYPE").and_then(|w| element_kind(context, w)) else {
        context.missing.elements = true;
        return;
    };
    let listed = card.has("ELSET");
    let mut made = Vec::with_capacity(if listed { card.rows.len() } else { 0 });
    context.model.mesh.elements.reserve(card.rows.len());
    let mut index = 0;
    while index < card.rows.len() {
        let (element, next) = match plain_element(context, kind, &card.rows[index]) {
            Some(element) => (Some(element), index + 1),
            None => element_of_rows(context, kind, &card.rows, index),
        };
        made.extend(element.filter(|_| listed));
        index = next;
    }
    sets::collect(context, SetKind::Elements, card, "ELSET", made);
}

/// Returns the element type with a name, or reports that it is unknown or unsupported.
pub fn element_kind(context: &mut Context<'_>, word: &Word) -> Option<ElementKind> {
    let name = word.text.to_uppercase();
    let supported_names: Vec<&str> = ElementKind::ALL.iter().map(|kind| kind.name()).collect();
    if let Some(index) = supported_names.iter().position(|supported| *supported == name) {
        return Some(ElementKind::ALL[index]);
    }
    let supported = format!("supported: {}", supported_names.join(", "));
    let diagnostic = if let Some((_, instead)) = AXISYMMETRIC.iter().find(|a| a.0 == name) {
        Diagnostic::error("M121", format!("element type {name} is not supported: {instead}")).help(supported)
    } else if let Some((_, reason)) = FAMILIES.iter().find(|family| name.starts_with(family.0)) {
        let instead = replacement(&name).map_or_else(String::new, |help| format!("{help}; "));
        Diagnostic::error("M121", format!("element type {name} is not supported: {reason}"))
            .help(format!("{instead}{supported}"))
    } else if let Some((what, _)) =
        OTHER_GEOMETRY.iter().find(|(_, heads)| heads.iter().any(|head| name.starts_with(head)))
    {
        let instead = replacement(&name).map_or_else(String::new, |help| format!("{help}; "));
        Diagnostic::error("M121", format!("element type {name} is {what}; this code is axisymmetric"))
            .help(format!("{instead}{supported}"))
    } else {
        let names = supported_names.iter().copied().chain(AXISYMMETRIC.iter().map(|a| a.0));
        let nearest_name = nearest(&name, names).map(|n| format!("did you mean {n}? ")).unwrap_or_default();
        let help = format!("{nearest_name}{supported}");
        Diagnostic::error("M120", format!("unknown element type {name}")).help(help)
    };
    context.diagnostics.refuse(diagnostic.at(word.span, "this type"))
}

/// Reads an element from one line of labels, the most frequent form; `None` for any other form.
fn plain_element(context: &mut Context<'_>, kind: ElementKind, row: &ListingRow) -> Option<usize> {
    let mut numbers = words(row.text(&context.deck.sources)?).map(|word| word.parse::<i64>().ok());
    let label = numbers.next()??;
    let (mut nodes, need) = ([0; 6], kind.node_count());
    let scope = context.nodes.scope(&context.scope)?;
    for node in &mut nodes[..need] {
        *node = scope.find(numbers.next()??)?;
    }
    add_element(context, label, kind, kind.around(&nodes[..need]), row.span())
}

/// Reads an element that may continue over several lines; returns its index and the index of the next row.
fn element_of_rows(
    context: &mut Context<'_>,
    kind: ElementKind,
    rows: &[ListingRow],
    at: usize,
) -> (Option<usize>, usize) {
    let sources = &context.deck.sources;
    let mut words: Vec<Word> = Vec::new();
    let mut next = at;
    while next < rows.len() && words.len() <= kind.node_count() {
        words.extend(rows[next].line(sources).into_owned().fields.into_iter().filter(|w| !w.text.is_empty()));
        next += 1;
    }
    (element_line(context, kind, &words, rows[at].span()), next)
}

fn element_line(context: &mut Context<'_>, kind: ElementKind, words: &[Word], span: Span) -> Option<usize> {
    let need = kind.node_count();
    if words.len() < need + 1 {
        let message = format!("a {} element requires a label and {need} nodes", kind.name());
        return context
            .diagnostics
            .refuse(Diagnostic::error("M102", message).at(span, format!("found {} values", words.len())));
    }
    let label = words[0].integer(&mut context.diagnostics)?;
    let mut nodes = Vec::with_capacity(need);
    for word in &words[1..=need] {
        match context.nodes.resolve(&context.scope, word) {
            Some(node) => nodes.push(node),
            None if context.missing.explains("node", word) => {
                context.missing.elements = true;
                return None;
            }
            None => {
                let message = format!("element {label} refers to node {}, which is not defined", word.text);
                let diagnostic = Diagnostic::error("M122", message).at(word.span, "no such node");
                let help = format!("{} nodes are defined so far", context.nodes.len());
                return context.diagnostics.refuse(diagnostic.help(help));
            }
        }
    }
    add_element(context, label, kind, kind.around(&nodes), span)
}

/// Adds an element in the current scope; its nodes are in order around the boundary.
pub fn add_element(
    context: &mut Context<'_>,
    label: i64,
    kind: ElementKind,
    nodes: NodeIndices,
    span: Span,
) -> Option<usize> {
    let index = context.model.mesh.elements.len();
    if let Some(other) = context.elements.insert(&context.scope, label, index) {
        let first = context.model.mesh.elements[other].span;
        context.elements.duplicates.push(DuplicateLabel { label, first, second: span });
    }
    let name = EntityName::of_label(&context.scope, label);
    context.model.mesh.elements.push(Element { name, kind, nodes, span });
    Some(index)
}

fn shape_fault(context: &Context<'_>, kind: ElementKind, nodes: &[usize]) -> Option<ShapeFault> {
    let mut places = [[0.0; 2]; 6];
    let points = &mut places[..nodes.len()];
    points.iter_mut().zip(nodes).for_each(|(point, &n)| *point = context.model.mesh.points[n]);
    if kind.is_discrete() {
        return None;
    }
    let extent = points.iter().fold(0.0, |m: f64, p| m.max(p[0].abs()));
    if points.iter().any(|p| p[0] < -1e-9 * extent) {
        return Some(ShapeFault::AcrossAxis);
    }
    let area: f64 = (0..points.len())
        .map(|i| (points[i], points[(i + 1) % points.len()]))
        .map(|(p, q)| 0.5 * (p[0] * q[1] - q[0] * p[1]))
        .sum();
    match kind {
        kind if kind.is_line() && points[0] == points[1] => Some(ShapeFault::NoLength),
        ElementKind::Cohax4 => cohesive_fault(points),
        kind if kind.is_solid() && area < 0.0 => Some(ShapeFault::Clockwise),
        kind if kind.is_solid() && area == 0.0 => Some(ShapeFault::NoArea),
        ElementKind::Cax4r | ElementKind::Cax4rt if has_inward_corner(points, area) => Some(ShapeFault::Concave),
        ElementKind::Cax6m if has_folded_cell(points) => Some(ShapeFault::Folded),
        _ => None,
    }
}

/// Reports duplicate element labels.
pub fn report_duplicate_labels(context: &mut Context<'_>) {
    let Some(&DuplicateLabel { label, first, second }) = context.elements.duplicates.first() else { return };
    let who = match context.elements.duplicates.len() {
        1 => format!("element label {label} is"),
        count => format!("element label {label} and {} more are", count - 1),
    };
    let diagnostic = Diagnostic::error("M124", format!("{who} defined twice")).at(second, "second definition");
    context.diagnostics.push(diagnostic.at(first, "first definition"));
    context.missing.bodies = true;
}

/// Reports elements with an invalid shape after all nodes are read, one error per kind of fault.
pub fn report_shape_faults(context: &mut Context<'_>, mesh: &mut MeshReader) {
    if context.missing.nodes {
        return;
    }
    let mut faults: IndexMap<ShapeFault, Vec<usize>> = IndexMap::new();
    for (index, element) in context.model.mesh.elements.iter().enumerate() {
        let Some(fault) = shape_fault(context, element.kind, &element.nodes) else { continue };
        if element.nodes.iter().any(|n| mesh.regenerated.contains(n)) {
            // Reported once for all, at the card that generated the nodes again.
            mesh.shapeless_elements.insert(index);
        } else {
            faults.entry(fault).or_default().push(index);
        }
    }
    for (fault, elements) in faults {
        let diagnostic = shape_diagnostic(context, &mesh.moved, fault, &elements);
        context.diagnostics.push(diagnostic);
        context.missing.bodies = true;
    }
    cohesive::report_exchanged_faces(context);
}

fn shape_diagnostic(
    context: &Context<'_>,
    moved: &HashMap<usize, Span>,
    fault: ShapeFault,
    elements: &[usize],
) -> Diagnostic {
    let mesh = &context.model.mesh;
    let Element { name, kind, span, .. } = &mesh.elements[elements[0]];
    let who = match elements.len() {
        1 => format!("element {name} ({})", kind.name()),
        count => format!("element {name} ({}) and {} more", kind.name(), count - 1),
    };
    let (what, help) = fault.words();
    let mut diagnostic = Diagnostic::error("M123", format!("{who}: {what}"));
    diagnostic = match is_generated(context, *span) {
        _ if context.scaling.refined.is_some() && context.deck.mesh_curves.is_some() => diagnostic.at(*span, "part of this element").help(
            "the smooth boundary crosses the element, which is thin: use more elements along the boundary, decrease the \
             corner angle of --curved, or omit it",
        ),
        true => diagnostic.at(*span, "generated by this line").help(
            "check the increments of node and element numbers: each row, and each layer, begins at the node of the first element \
             plus the increment",
        ),
        false => diagnostic.at(*span, "this element").help(help),
    };
    let nodes = || elements.iter().flat_map(|&e| &mesh.elements[e].nodes);
    if fault == ShapeFault::AcrossAxis {
        let beyond = nodes().filter(|&&n| mesh.points[n][0] < 0.0);
        let lines = node_lines(context);
        if let Some((name, line)) = beyond.map(|&n| &mesh.node_names[n]).find_map(|n| Some((n, lines.get(n.as_str())?)))
        {
            diagnostic = diagnostic.at(*line, format!("node {name} is beyond the axis"));
            diagnostic.labels.reverse();
        }
    } else if let Some((node, at)) = nodes().find_map(|n| moved.get(n).map(|at| (n, at))) {
        diagnostic.help = Some(format!("node {} is defined twice; define each node once", mesh.node_names[*node]));
        diagnostic = diagnostic.at(*at, format!("node {} is redefined here", mesh.node_names[*node]));
    }
    diagnostic
}

/// Returns whether an element with this source position was generated by `*ELGEN`.
fn is_generated(context: &Context<'_>, span: Span) -> bool {
    let mut cards = context.deck.cards.iter().filter(|c| c.keyword.name == "ELGEN");
    cards.any(|card| card.lines.iter().any(|line| line.span == span))
}

/// Returns the data lines of `*NODE` cards by node label.
fn node_lines<'c>(context: &'c Context<'_>) -> HashMap<&'c str, Span> {
    let cards = context.deck.cards.iter().filter(|c| c.keyword.name == "NODE");
    let rows = cards.flat_map(|c| &c.rows);
    rows.filter_map(|row| Some((words(row.text(&context.deck.sources)?).next()?, row.span()))).collect()
}

/// Generates elements in rows, layers and groups of layers (ABAQUS Keywords Guide, *ELGEN).
pub fn read_elgen(context: &mut Context<'_>, card: &Card) {
    let rows = card.lines.iter().zip(card.read_lines::<Vec<[f64; 10]>>());
    let made = rows.filter_map(|(line, row)| elgen_line(context, line, row)).flatten().collect();
    sets::collect(context, SetKind::Elements, card, "ELSET", made);
}

fn elgen_line(context: &mut Context<'_>, line: &DataLine, row: [f64; 10]) -> Option<Vec<usize>> {
    if row[0].is_nan() {
        return None;
    }
    let [master, count, node_step, element_step, given @ ..] = row.map(|number| number as i64);
    let [rows, row_node_step, row_element_step, layers, layer_node, layer_element] = given;
    let Some(model) = context.elements.find(&context.scope, master) else {
        if context.missing.elements || context.missing.everything {
            return None;
        }
        let message = format!("the master element {master} is not defined");
        return context.diagnostics.refuse(Diagnostic::error("M110", message).at(line.span, "no such element"));
    };
    let total = i128::from(count) * i128::from(rows).saturating_mul(i128::from(layers));
    let same = [(count, element_step), (rows, row_element_step), (layers, layer_element)];
    if same.into_iter().any(|(times, step)| times > 1 && step == 0) {
        return context.refuse_value(line.span, "repeated elements require a nonzero increment of element labels");
    }
    if !context.fits_budget(BudgetedItem::Elements, total.unsigned_abs(), line.span) {
        return None;
    }
    let master_nodes = context.model.mesh.elements[model].nodes.clone();
    let kind = context.model.mesh.elements[model].kind;
    let labels: Vec<i64> = master_nodes
        .iter()
        .filter_map(|&n| context.model.mesh.node_names[n].rsplit('.').next()?.parse().ok())
        .collect();
    let mut made = vec![model];
    for at in 1..count * rows * layers {
        let (column, row, layer) = (at % count, at / count % rows, at / count / rows);
        let sum = |steps: [i64; 3]| {
            let parts = [(column, steps[0]), (row, steps[1]), (layer, steps[2])];
            parts.into_iter().fold(0_i64, |sum, (n, step)| sum.saturating_add(n.saturating_mul(step)))
        };
        let shift = sum([node_step, row_node_step, layer_node]);
        let label = master.saturating_add(sum([element_step, row_element_step, layer_element]));
        let nodes = shifted(context, &labels, shift, label, line.span)?;
        made.extend(add_element(context, label, kind, nodes[..].into(), line.span));
    }
    Some(made)
}

pub fn shifted(context: &mut Context<'_>, labels: &[i64], shift: i64, element: i64, span: Span) -> Option<Vec<usize>> {
    let mut nodes = Vec::with_capacity(labels.len());
    for label in labels {
        let label = label.saturating_add(shift);
        match context.nodes.find(&context.scope, label) {
            Some(node) => nodes.push(node),
            None if context.missing.nodes || context.missing.everything => {
                context.missing.elements = true;
                return None;
            }
            None => {
                let message = format!("generated element {element} refers to node {label}, which is not defined");
                return context.diagnostics.refuse(Diagnostic::error("M122", message).at(span, "generated here"));
            }
        }
    }
    Some(nodes)
}

/// Fault of the shape of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum ShapeFault {
    AcrossAxis,
    NoLength,
    Clockwise,
    NoArea,
    Concave,
    Folded,
    NoMidSurface,
    FacesCrossed,
    FacesExchanged,
}

impl ShapeFault {
    /// Returns the message and the help text.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            ShapeFault::AcrossAxis => {
                ("crosses the axis: r of a node is negative", "an axisymmetric model requires r >= 0")
            }
            ShapeFault::NoLength => ("has zero length: its nodes coincide", "give its nodes different coordinates"),
            ShapeFault::Clockwise => ("is clockwise in the (r, z) plane", "list its nodes counter-clockwise"),
            ShapeFault::NoArea => ("has no area: its corners coincide or are collinear", "check the node coordinates"),
            ShapeFault::Concave => ("is concave", "check the node coordinates and their order"),
            ShapeFault::Folded => (
                "is folded: one of the four triangles between corners and midside nodes has no area",
                "the node order is: three corners, then the midside nodes of the sides 1-2, 2-3 and 3-1",
            ),
            ShapeFault::NoMidSurface => (
                "has a mid-surface without area: its ends coincide, or both are on the axis",
                "the nodes 1 and 2 are the bottom face, 4 and 3 the nodes of the top face opposite to them",
            ),
            ShapeFault::FacesCrossed => (
                "has faces of opposite directions",
                "list the nodes around the boundary: node 4 is opposite to node 1, and node 3 to node 2",
            ),
            ShapeFault::FacesExchanged => (
                "has its top face below its bottom face",
                "list the nodes counter-clockwise in the (r, z) plane: the normal from the bottom to the top face is the \
                 direction from node 1 to node 2, rotated by 90 degrees counter-clockwise",
            ),
        }
    }
}

/// Returns the fault of the nodes of a cohesive element: bottom face 1 and 2, top face 4 and 3.
fn cohesive_fault(points: &[[f64; 2]]) -> Option<ShapeFault> {
    let [a, b, c, d] = *points.first_chunk::<4>()?;
    let along = |from: [f64; 2], to: [f64; 2]| [to[0] - from[0], to[1] - from[1]];
    let dot = |u: [f64; 2], v: [f64; 2]| u[0] * v[0] + u[1] * v[1];
    let (bottom, top) = (along(a, b), along(d, c));
    let middle = [bottom[0] + top[0], bottom[1] + top[1]];
    let lengths = dot(bottom, bottom) + dot(top, top);
    let normal = [-middle[1], middle[0]];
    let opening = dot(normal, along(a, d)) + dot(normal, along(b, c));
    if dot(bottom, top) < 0.0 {
        Some(ShapeFault::FacesCrossed)
    } else if dot(middle, middle) <= 1e-18 * lengths || lengths == 0.0 || points.iter().all(|p| p[0] == 0.0) {
        Some(ShapeFault::NoMidSurface)
    } else if opening < -1e-6 * lengths {
        Some(ShapeFault::FacesExchanged)
    } else {
        None
    }
}

/// Returns whether one of the four sub-triangles of a six-node triangle has no positive area.
fn has_folded_cell(points: &[[f64; 2]]) -> bool {
    let area = |cell: &[usize; 4]| {
        let [a, b, c] = [0, 1, 2].map(|i| points[cell[i]]);
        (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    };
    ElementTopology::SixNodeTriangle.cells().iter().any(|cell| area(cell) <= 0.0)
}

/// Returns whether a quadrilateral has a reentrant corner, at which it would invert immediately. Angles of 180 degrees
/// are allowed.
fn has_inward_corner(points: &[[f64; 2]], area: f64) -> bool {
    let turn = |i: usize| {
        let [a, b, c] = [points[i], points[(i + 1) % 4], points[(i + 2) % 4]];
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    };
    (0..4).any(|i| turn(i) < -1e-9 * area)
}

/// Returns the fields of as many lines as are needed for `need` values, and the index of the next line.
pub fn joined(card: &Card, at: usize, need: usize) -> (Vec<&Word>, usize) {
    let mut words: Vec<&Word> = card.lines[at].fields.iter().filter(|w| !w.text.is_empty()).collect();
    let mut next = at + 1;
    while words.len() < need && next < card.lines.len() {
        words.extend(card.lines[next].fields.iter().filter(|w| !w.text.is_empty()));
        next += 1;
    }
    (words, next)
}
