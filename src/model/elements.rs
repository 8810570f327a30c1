//! Elements: `*ELEMENT`, `*ELGEN`, and the types there are.
//! Never here: materials.

use std::collections::HashMap;

use indexmap::IndexMap;

use super::budget::Good;
use super::builder::Builder;
use super::element_nodes::ElementNodes;
use super::name::Name;
use super::types::{Element, ElementKind};
use crate::deck::names::nearest;
use crate::deck::rows::words;
use crate::deck::syntax::Row;
use crate::deck::{Card, DataLine, Diagnostic, Span, Word};
use crate::kernel::topology::Topology;

/// Types that are simulated.
const SUPPORTED: &[(&str, ElementKind)] = &[
    ("RAX2", ElementKind::Rax2),
    ("SAX1", ElementKind::Sax1),
    ("CAX3", ElementKind::Cax3),
    ("CAX4R", ElementKind::Cax4r),
    ("CAX3T", ElementKind::Cax3t),
    ("CAX4RT", ElementKind::Cax4rt),
    ("CAX6M", ElementKind::Cax6m),
    ("MASS", ElementKind::Mass),
    ("ROTARYI", ElementKind::RotaryInertia),
    ("SPRINGA", ElementKind::SpringA),
    ("SPRING1", ElementKind::Spring1),
    ("DASHPOTA", ElementKind::DashpotA),
    ("DASHPOT1", ElementKind::Dashpot1),
];

/// Axisymmetric types of ABAQUS that are not simulated, with what to use instead.
const AXISYMMETRIC: &[(&str, &str)] = &[
    ("CAX4", "CAX4R is; it has one integration point"),
    ("CAX4H", "CAX4R is"),
    ("CAX4RH", "CAX4R is"),
    ("CAX4I", "CAX4R is"),
    ("CAX4T", "CAX4RT is; it has one integration point"),
    ("CAX3H", "CAX3 is"),
    ("CAX6MT", "temperatures at nodes are those of CAX3T and CAX4RT"),
    ("CAX6", "CAX6M is"),
    ("CAX6H", "CAX6M is; it does not lock"),
    ("CAX8", "explicit dynamics uses linear elements: CAX4R"),
    ("CAX8R", "explicit dynamics uses linear elements: CAX4R"),
    ("CAX8RT", "explicit dynamics uses linear elements: CAX4RT"),
    ("SAX2", "explicit dynamics uses linear elements: SAX1"),
    ("MAX1", "membranes are not simulated"),
    ("SFMAX1", "surface elements on solids are not simulated"),
    ("COHAX4", "cohesive elements are not simulated"),
    ("SPRING2", "SPRINGA and SPRING1 are"),
    ("DASHPOT2", "DASHPOTA and DASHPOT1 are"),
    ("CONN2D2", "connectors are not simulated"),
];

/// Beginnings of names of types for other geometries.
const OTHER_GEOMETRY: &[(&str, &str)] = &[
    ("C3D", "three-dimensional"),
    ("SC6", "three-dimensional"),
    ("SC8", "three-dimensional"),
    ("R3D", "three-dimensional"),
    ("S3", "a three-dimensional shell"),
    ("S4", "a three-dimensional shell"),
    ("S8", "a three-dimensional shell"),
    ("STRI", "a three-dimensional shell"),
    ("M3D", "a three-dimensional membrane"),
    ("SFM3D", "three-dimensional"),
    ("COH3D", "three-dimensional"),
    ("T3D", "a three-dimensional truss"),
    ("B3", "a three-dimensional beam"),
    ("CPE", "plane strain"),
    ("CPS", "plane stress"),
    ("COH2D", "plane"),
    ("R2D2", "plane"),
    ("T2D", "a plane truss"),
    ("B2", "a plane beam"),
    ("EC3D", "three-dimensional Eulerian"),
    ("PC3D", "a particle"),
    ("AC", "acoustic"),
    ("DC", "for heat transfer"),
];

impl ElementKind {
    /// How many nodes it has.
    pub fn node_count(self) -> usize {
        match self {
            ElementKind::Mass | ElementKind::RotaryInertia | ElementKind::Spring1 | ElementKind::Dashpot1 => 1,
            ElementKind::Rax2 | ElementKind::Sax1 | ElementKind::SpringA | ElementKind::DashpotA => 2,
            ElementKind::Cax3 | ElementKind::Cax3t => 3,
            ElementKind::Cax4r | ElementKind::Cax4rt => 4,
            ElementKind::Cax6m => 6,
        }
    }

    /// Shape of a type that deforms; triangles are quadrilaterals whose last corners coincide.
    pub fn topology(self) -> Option<Topology> {
        match self {
            ElementKind::Sax1 => Some(Topology::Shell),
            ElementKind::Cax3 | ElementKind::Cax3t | ElementKind::Cax4r | ElementKind::Cax4rt => {
                Some(Topology::Quadrilateral)
            }
            ElementKind::Cax6m => Some(Topology::SixNodeTriangle),
            _ => None,
        }
    }

    /// Whether it is a solid that can deform.
    pub fn is_solid(self) -> bool {
        self.topology().is_some_and(Topology::is_solid)
    }

    /// Nodes around the boundary, from those in the order of ABAQUS: the middles of the sides come after the corners there.
    pub fn around(self, nodes: &[usize]) -> ElementNodes {
        match (self, nodes) {
            (ElementKind::Cax6m, &[a, b, c, ab, bc, ca]) => [a, ab, b, bc, c, ca][..].into(),
            _ => nodes.into(),
        }
    }

    /// Parts of the boundary that a face is, by their numbers; none where the type has no such face.
    pub fn face(self, number: u8) -> std::ops::Range<u8> {
        let parts = if self == ElementKind::Cax6m { 2 } else { 1 };
        let count = self.node_count() as u8 / parts;
        if (1..=count).contains(&number) { parts * (number - 1) + 1..parts * number + 1 } else { 0..0 }
    }

    /// Whether its nodes have temperatures.
    pub fn is_thermal(self) -> bool {
        matches!(self, ElementKind::Cax3t | ElementKind::Cax4rt)
    }

    /// Whether it is a spring or a dashpot.
    pub fn is_connector(self) -> bool {
        use ElementKind::{Dashpot1, DashpotA, Spring1, SpringA};
        matches!(self, Dashpot1 | DashpotA | Spring1 | SpringA)
    }

    /// Whether it has no volume and no surface: a point mass, a rotary inertia, a spring, a dashpot.
    pub fn is_discrete(self) -> bool {
        matches!(self, ElementKind::Mass | ElementKind::RotaryInertia) || self.is_connector()
    }

    /// ABAQUS's name of the type.
    pub fn name(self) -> &'static str {
        SUPPORTED.iter().find(|s| s.1 == self).map_or("?", |s| s.0)
    }
}

impl Builder<'_> {
    pub(super) fn element(&mut self, card: &Card) {
        let Some(kind) = self.required(card, "TYPE").and_then(|w| self.element_kind(w)) else {
            self.lost.elements = true;
            return;
        };
        let listed = card.has("ELSET");
        let mut made = Vec::with_capacity(if listed { card.rows.len() } else { 0 });
        self.model.mesh.room_for_elements(card.rows.len());
        let mut at = 0;
        while at < card.rows.len() {
            let (element, next) = match self.plain_element(kind, &card.rows[at]) {
                Some(element) => (Some(element), at + 1),
                None => self.element_of_rows(kind, &card.rows, at),
            };
            made.extend(element.filter(|_| listed));
            at = next;
        }
        if let Some(name) = card.value("ELSET") {
            self.add_element_set(&name.text, made, card.span);
        }
    }

    /// The type a word names; one finding where it is none of ours.
    pub(super) fn element_kind(&mut self, word: &Word) -> Option<ElementKind> {
        let name = word.text.to_uppercase();
        if let Some(found) = SUPPORTED.iter().find(|s| s.0 == name) {
            return Some(found.1);
        }
        let supported = "supported are RAX2, SAX1, CAX3, CAX4R, CAX6M, CAX3T, CAX4RT, MASS, SPRINGA, SPRING1, DASHPOTA and DASHPOT1";
        let finding = if let Some((_, instead)) = AXISYMMETRIC.iter().find(|a| a.0 == name) {
            Diagnostic::error("M121", format!("element type {name} is not supported: {instead}")).help(supported)
        } else if let Some((_, what)) = OTHER_GEOMETRY.iter().find(|o| name.starts_with(o.0)) {
            Diagnostic::error("M121", format!("element type {name} is {what}; this code is axisymmetric"))
                .help(supported)
        } else {
            let names = SUPPORTED.iter().map(|s| s.0).chain(AXISYMMETRIC.iter().map(|a| a.0));
            let help = nearest(&name, names).map_or(supported.into(), |n| format!("did you mean {n}? {supported}"));
            Diagnostic::error("M120", format!("unknown element type {name}")).help(help)
        };
        self.diagnostics.refuse(finding.at(word.span, "this type"))
    }

    /// Most elements are a line of numbers that are all there; `None` of any other.
    fn plain_element(&mut self, kind: ElementKind, row: &Row) -> Option<usize> {
        let mut numbers = words(row.text(&self.deck.sources)?).map(|word| word.parse::<i64>().ok());
        let label = numbers.next()??;
        let (mut nodes, need) = ([0; 6], kind.node_count());
        let scope = self.nodes.scope(&self.scope)?;
        for node in &mut nodes[..need] {
            *node = scope.find(numbers.next()??)?;
        }
        self.add_element(label, kind, kind.around(&nodes[..need]), row.span())
    }

    /// An element that may go on over several lines, and the row behind it.
    fn element_of_rows(&mut self, kind: ElementKind, rows: &[Row], at: usize) -> (Option<usize>, usize) {
        let sources = &self.deck.sources;
        let mut all: Vec<Word> = Vec::new();
        let mut next = at;
        while next < rows.len() && all.len() <= kind.node_count() {
            all.extend(rows[next].line(sources).into_owned().fields.into_iter().filter(|w| !w.text.is_empty()));
            next += 1;
        }
        (self.element_line(kind, &all, rows[at].span()), next)
    }

    fn element_line(&mut self, kind: ElementKind, words: &[Word], span: Span) -> Option<usize> {
        let need = kind.node_count();
        if words.len() < need + 1 {
            let message = format!("a {} element has a label and {need} nodes", kind.name());
            return self
                .diagnostics
                .refuse(Diagnostic::error("M102", message).at(span, format!("{} given", words.len())));
        }
        let label = words[0].integer(&mut self.diagnostics)?;
        let mut nodes = Vec::with_capacity(need);
        for word in &words[1..=need] {
            match self.nodes.resolve(&self.scope, word) {
                Some(node) => nodes.push(node),
                None if self.lost.explains("node", word) => {
                    self.lost.elements = true;
                    return None;
                }
                None => {
                    let message = format!("element {label} refers to node {}, which is not defined", word.text);
                    let finding = Diagnostic::error("M122", message).at(word.span, "no such node");
                    let help = format!("there are {} nodes", self.nodes.len());
                    return self.diagnostics.refuse(finding.help(help));
                }
            }
        }
        self.add_element(label, kind, kind.around(&nodes), span)
    }

    /// Adds an element of the present scope, its nodes around the boundary.
    pub(super) fn add_element(
        &mut self,
        label: i64,
        kind: ElementKind,
        nodes: ElementNodes,
        span: Span,
    ) -> Option<usize> {
        let index = self.model.mesh.elements.len();
        if let Some(other) = self.elements.insert(&self.scope, label, index) {
            self.used_twice.push((label, span, self.model.mesh.elements[other].span));
        }
        let name = Name::of_label(&self.scope, label);
        self.model.mesh.elements.push(Element { name, kind, nodes, span });
        Some(index)
    }

    fn shape_fault(&self, kind: ElementKind, nodes: &[usize]) -> Option<ShapeFault> {
        let mut places = [[0.0; 2]; 6];
        let points = &mut places[..nodes.len()];
        points.iter_mut().zip(nodes).for_each(|(point, &n)| *point = self.model.mesh.points[n]);
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
            ElementKind::Rax2 | ElementKind::Sax1 if points[0] == points[1] => Some(ShapeFault::NoLength),
            kind if kind.is_solid() && area < 0.0 => Some(ShapeFault::Clockwise),
            kind if kind.is_solid() && area == 0.0 => Some(ShapeFault::NoArea),
            ElementKind::Cax4r | ElementKind::Cax4rt if has_inward_corner(points, area) => Some(ShapeFault::Concave),
            ElementKind::Cax6m if has_folded_cell(points) => Some(ShapeFault::Folded),
            _ => None,
        }
    }

    /// Tells of labels that several elements have.
    pub(super) fn tell_labels_used_twice(&mut self) {
        let Some(&(label, span, first)) = self.used_twice.first() else { return };
        let who = match self.used_twice.len() {
            1 => format!("element label {label} is"),
            count => format!("element label {label} and {} more are", count - 1),
        };
        let finding = Diagnostic::error("M124", format!("{who} used twice")).at(span, "again here");
        self.diagnostics.push(finding.at(first, "first here"));
        self.lost.bodies = true;
    }

    /// Tells of elements that cannot be, once all nodes stand: one finding for each fault.
    pub(super) fn tell_shape_faults(&mut self) {
        if self.lost.nodes {
            return;
        }
        let mut faults: IndexMap<ShapeFault, Vec<usize>> = IndexMap::new();
        for (index, element) in self.model.mesh.elements.iter().enumerate() {
            let Some(fault) = self.shape_fault(element.kind, &element.nodes) else { continue };
            if element.nodes.iter().any(|n| self.regenerated.contains(n)) {
                // Told once for all of them, with the card that gave nodes their numbers again.
                self.spoilt.insert(index);
            } else {
                faults.entry(fault).or_default().push(index);
            }
        }
        for (fault, elements) in faults {
            let finding = self.shape_finding(fault, &elements);
            self.diagnostics.push(finding);
            self.lost.bodies = true;
        }
    }

    fn shape_finding(&self, fault: ShapeFault, elements: &[usize]) -> Diagnostic {
        let mesh = &self.model.mesh;
        let Element { name, kind, span, .. } = &mesh.elements[elements[0]];
        let who = match elements.len() {
            1 => format!("element {name} ({})", kind.name()),
            count => format!("element {name} ({}) and {} more", kind.name(), count - 1),
        };
        let (what, help) = fault.words();
        let mut finding = Diagnostic::error("M123", format!("{who}: {what}")).at(*span, "this element").help(help);
        let nodes = || elements.iter().flat_map(|&e| &mesh.elements[e].nodes);
        if fault == ShapeFault::AcrossAxis {
            let beyond = nodes().filter(|&&n| mesh.points[n][0] < 0.0);
            let lines = self.node_lines();
            if let Some((name, line)) =
                beyond.map(|&n| &mesh.node_names[n]).find_map(|n| Some((n, lines.get(n.as_str())?)))
            {
                finding = finding.at(*line, format!("node {name} is beyond the axis"));
                finding.labels.reverse();
            }
        } else if let Some((node, at)) = nodes().find_map(|n| self.moved.get(n).map(|at| (n, at))) {
            finding.help = Some(format!("node {} is given twice: give each node once", mesh.node_names[*node]));
            finding = finding.at(*at, format!("node {} is given another place here", mesh.node_names[*node]));
        }
        finding
    }

    /// Lines of `*NODE` cards by label.
    fn node_lines(&self) -> HashMap<&str, Span> {
        let cards = self.deck.cards.iter().filter(|c| c.keyword.name == "NODE");
        let rows = cards.flat_map(|c| &c.rows);
        rows.filter_map(|row| Some((words(row.text(&self.deck.sources)?).next()?, row.span()))).collect()
    }

    /// Repeats elements in rows and rows of rows (ABAQUS Keywords Guide, *ELGEN).
    pub(super) fn elgen(&mut self, card: &Card) {
        let mut made = Vec::new();
        for (line, row) in card.lines.iter().zip(card.read_lines::<Vec<[f64; 10]>>()) {
            made.extend(self.elgen_line(line, row).unwrap_or_default());
        }
        if let Some(name) = card.value("ELSET") {
            self.add_element_set(&name.text, made, card.span);
        }
    }

    fn elgen_line(&mut self, line: &DataLine, row: [f64; 10]) -> Option<Vec<usize>> {
        if row[0].is_nan() {
            return None;
        }
        let [master, count, node_step, element_step, given @ ..] = row.map(|number| number as i64);
        let [rows, row_node_step, row_element_step, layers, layer_node, layer_element] = given;
        let Some(model) = self.elements.find(&self.scope, master) else {
            if self.lost.elements || self.lost.everything {
                return None;
            }
            let message = format!("the master element {master} is not defined");
            return self.diagnostics.refuse(Diagnostic::error("M110", message).at(line.span, "no such element"));
        };
        let total = i128::from(count) * i128::from(rows).saturating_mul(i128::from(layers));
        let same = [(count, element_step), (rows, row_element_step), (layers, layer_element)];
        if same.into_iter().any(|(times, step)| times > 1 && step == 0) {
            return self
                .refuse_value(line.span, "elements that are repeated need increments of their labels above zero");
        }
        if !self.affords(Good::Elements, total.unsigned_abs(), line.span) {
            return None;
        }
        let master_nodes = self.model.mesh.elements[model].nodes.clone();
        let kind = self.model.mesh.elements[model].kind;
        let labels: Vec<i64> = master_nodes
            .iter()
            .filter_map(|&n| self.model.mesh.node_names[n].rsplit('.').next()?.parse().ok())
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
            let nodes = self.shifted(&labels, shift, label, line.span)?;
            made.extend(self.add_element(label, kind, nodes[..].into(), line.span));
        }
        Some(made)
    }

    pub(super) fn shifted(&mut self, labels: &[i64], shift: i64, element: i64, span: Span) -> Option<Vec<usize>> {
        let mut nodes = Vec::with_capacity(labels.len());
        for label in labels {
            let label = label.saturating_add(shift);
            match self.nodes.find(&self.scope, label) {
                Some(node) => nodes.push(node),
                None if self.lost.nodes || self.lost.everything => {
                    self.lost.elements = true;
                    return None;
                }
                None => {
                    let message = format!("generated element {element} needs node {label}, which is not defined");
                    return self.diagnostics.refuse(Diagnostic::error("M122", message).at(span, "generated here"));
                }
            }
        }
        Some(nodes)
    }
}

/// Why an element cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum ShapeFault {
    AcrossAxis,
    NoLength,
    Clockwise,
    NoArea,
    Concave,
    Folded,
}

impl ShapeFault {
    /// What is wrong, and what would be right.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            ShapeFault::AcrossAxis => {
                ("across the axis: r of a node is negative", "an axisymmetric model lies at r >= 0")
            }
            ShapeFault::NoLength => ("no length: its nodes coincide", "give two places"),
            ShapeFault::Clockwise => {
                ("clockwise in the (r, z) plane", "number the nodes counter-clockwise, the other way round")
            }
            ShapeFault::NoArea => ("no area: its corners coincide or lie on one line", "check the places of its nodes"),
            ShapeFault::Concave => ("concave: a corner points inward", "check the places of its nodes and their order"),
            ShapeFault::Folded => (
                "folded: one of the four triangles between its corners and the middles of its sides has no area",
                "the nodes are three corners, then the middles of the sides 1-2, 2-3 and 3-1",
            ),
        }
    }
}

/// Whether a triangle within a six-node triangle has no positive area.
fn has_folded_cell(points: &[[f64; 2]]) -> bool {
    let area = |cell: &[usize; 4]| {
        let [a, b, c] = [0, 1, 2].map(|i| points[cell[i]]);
        (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    };
    Topology::SixNodeTriangle.cells().iter().any(|cell| area(cell) <= 0.0)
}

/// Whether a corner of a quadrilateral points inward: it would turn inside out at once. Corners on the line between their
/// neighbours pass.
fn has_inward_corner(points: &[[f64; 2]], area: f64) -> bool {
    let turn = |i: usize| {
        let [a, b, c] = [points[i], points[(i + 1) % 4], points[(i + 2) % 4]];
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    };
    (0..4).any(|i| turn(i) < -1e-9 * area)
}

/// The fields of as many lines as a card needs, and the index of the line after them.
pub(super) fn joined(card: &Card, at: usize, need: usize) -> (Vec<&Word>, usize) {
    let mut words: Vec<&Word> = card.lines[at].fields.iter().filter(|w| !w.text.is_empty()).collect();
    let mut next = at + 1;
    while words.len() < need && next < card.lines.len() {
        words.extend(card.lines[next].fields.iter().filter(|w| !w.text.is_empty()));
        next += 1;
    }
    (words, next)
}
