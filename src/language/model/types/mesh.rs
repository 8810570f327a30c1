//! Nodes, elements, sets and element-based surfaces.

use rustc_hash::FxHashMap;

use crate::deck::Span;
use crate::kernel::lists::{heap_bytes, sorted_pair};
use crate::kernel::topology::ElementTopology;
use crate::model::element_nodes::NodeIndices;
use crate::model::name::EntityName;
use crate::platform::PortableMath as _;

/// Nodes and elements of the model.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Node names: the label, or `INSTANCE.label` for a node of an instance.
    pub node_names: Vec<EntityName>,
    /// Initial node coordinates `[r, z]` in the length unit of the deck.
    pub points: Vec<[f64; 2]>,
    /// Elements in deck order.
    pub elements: Vec<Element>,
}

impl Mesh {
    /// Returns the heap memory of the node and element lists in bytes.
    pub fn bytes(&self) -> usize {
        let names: usize = self.node_names.iter().map(EntityName::bytes_elsewhere).sum();
        let element = |e: &Element| e.name.bytes_elsewhere() + e.nodes.bytes_elsewhere();
        names
            + heap_bytes(&self.node_names)
            + heap_bytes(&self.points)
            + heap_bytes(&self.elements)
            + self.elements.iter().map(element).sum::<usize>()
    }

    /// Returns the quadrilateral cells of a solid element, each as four node indices counter-clockwise. A triangle is a
    /// quadrilateral whose last two corners coincide: the polygon formulas remain valid, and hourglass forces vanish
    /// because the motion of three nodes is linear.
    pub fn cells(&self, element: usize) -> impl Iterator<Item = [usize; 4]> {
        let Element { kind, nodes, .. } = &self.elements[element];
        let cells = kind.topology().map_or(&[][..], ElementTopology::cells);
        cells.iter().map(move |cell| cell.map(|i| nodes[i.min(nodes.len() - 1)]))
    }

    /// Returns the initial corner coordinates of the cells of an element (see [`Mesh::cells`]).
    pub fn initial_cells(&self, element: usize) -> impl Iterator<Item = [[f64; 2]; 4]> {
        self.cells(element).map(|cell| cell.map(|n| self.points[n]))
    }

    /// Returns the lengths of the shortest and of the longest side of an element; sides of zero length are left out.
    pub fn side_lengths(&self, element: usize) -> [f64; 2] {
        let nodes = &self.elements[element].nodes;
        let side = |i: usize| {
            let [a, b] = [nodes[i], nodes[(i + 1) % nodes.len()]].map(|n| self.points[n]);
            (b[0] - a[0]).portable_hypot(b[1] - a[1])
        };
        let lengths = (0..nodes.len()).map(side).filter(|length| *length > 0.0);
        lengths.fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], l| [least.min(l), most.max(l)])
    }

    /// Returns the two nodes of an element side in counter-clockwise order; `None` if the element has no such side.
    pub fn side_nodes(&self, element: usize, side: ElementSide) -> Option<[usize; 2]> {
        let nodes = &self.elements[element].nodes;
        let (first, second) = match side {
            ElementSide::Positive | ElementSide::Negative => (0, 1),
            ElementSide::Face(n) => (usize::from(n).checked_sub(1)?, usize::from(n) % nodes.len()),
        };
        Some([*nodes.get(first)?, *nodes.get(second)?])
    }

    /// Returns the exterior faces of solid elements, that is, the faces that belong to one element only.
    pub fn exterior_faces(&self) -> Vec<(usize, ElementSide)> {
        let faces = |e: usize| {
            let Element { kind, nodes, .. } = &self.elements[e];
            let count = if kind.is_solid() { nodes.len() } else { 0 };
            (0..count).map(move |i| (i, [nodes[i], nodes[(i + 1) % count]])).filter(|(_, [a, b])| a != b)
        };
        let element_faces = || (0..self.elements.len()).flat_map(move |e| faces(e).map(move |(i, edge)| (e, i, edge)));
        let mut shared: FxHashMap<[usize; 2], usize> = FxHashMap::default();
        shared.reserve(2 * self.elements.len());
        for (.., edge) in element_faces() {
            *shared.entry(sorted_pair(edge)).or_default() += 1;
        }
        let exterior = element_faces().filter(|&(.., edge)| shared[&sorted_pair(edge)] == 1);
        exterior.map(|(e, i, _)| (e, ElementSide::Face(i as u8 + 1))).collect()
    }
}

/// Defines the types of elements, each with its name in ABAQUS, number of nodes, topology and description.
macro_rules! element_kinds {
    ($($name:literal $kind:ident $nodes:literal $topology:expr, $words:literal;)+) => {
        /// Type of an element, with its number of nodes and integration.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum ElementKind {
            $(#[doc = $words] $kind),+
        }

        impl ElementKind {
            /// All types.
            pub const ALL: &[ElementKind] = &[$(ElementKind::$kind),+];

            /// Returns the name of the type in ABAQUS.
            pub fn name(self) -> &'static str {
                match self {
                    $(ElementKind::$kind => $name,)+
                }
            }

            /// Returns the number of nodes.
            pub fn node_count(self) -> usize {
                match self {
                    $(ElementKind::$kind => $nodes,)+
                }
            }

            /// Returns the topology of a deformable type; `None` for other types. A three-node triangle is a degenerate
            /// quadrilateral.
            pub fn topology(self) -> Option<ElementTopology> {
                match self {
                    $(ElementKind::$kind => $topology,)+
                }
            }
        }
    };
}

element_kinds! {
    "RAX2" Rax2 2 None, "Two-node axisymmetric rigid surface element.";
    "SAX1" Sax1 2 Some(ElementTopology::Shell), "Two-node axisymmetric shell.";
    "CAX3" Cax3 3 Some(ElementTopology::Quadrilateral), "Three-node axisymmetric triangle.";
    "CAX4R" Cax4r 4 Some(ElementTopology::Quadrilateral), "Four-node axisymmetric quadrilateral, one integration point.";
    "CAX6M" Cax6m 6 Some(ElementTopology::SixNodeTriangle), "Six-node axisymmetric triangle, modified, three integration points.";
    "CAX3T" Cax3t 3 Some(ElementTopology::Quadrilateral), "The triangle with temperatures at its nodes.";
    "CAX4RT" Cax4rt 4 Some(ElementTopology::Quadrilateral), "The quadrilateral with temperatures at its nodes.";
    "COHAX4" Cohax4 4 Some(ElementTopology::Cohesive), "Cohesive element: nodes 1 and 2 are the bottom face, 3 and 4 the top face.";
    "MASS" Mass 1 None, "One-node point mass.";
    "ROTARYI" RotaryInertia 1 None, "One-node rotary inertia.";
    "SPRINGA" SpringA 2 None, "Spring along the line between two nodes.";
    "SPRING1" Spring1 1 None, "Spring between a node and the ground.";
    "DASHPOTA" DashpotA 2 None, "Dashpot along the line between two nodes.";
    "DASHPOT1" Dashpot1 1 None, "Dashpot between a node and the ground.";
    "CINAX4" Cinax4 4 None, "Infinite element: absorbs waves on the face of the mesh that has its first two nodes.";
}

/// An element of the mesh: type, label and nodes.
#[derive(Clone, Debug)]
pub struct Element {
    /// Element name: the label, or `INSTANCE.label` for an element of an instance.
    pub name: EntityName,
    /// Type, for example CAX4R.
    pub kind: ElementKind,
    /// Indices into [`Mesh::points`], as many as the type requires. Nodes of solids are listed around the boundary
    /// ([`ElementKind::around`]).
    pub nodes: NodeIndices,
    /// Source position of the data line, or of the `*MESH` card.
    pub span: Span,
}

/// A named set of node or element indices.
#[derive(Clone, Debug, Default)]
pub struct MemberSet {
    /// Indices in ascending order, without repetition.
    pub members: Vec<usize>,
    /// Source position of the first definition.
    pub span: Span,
}

/// A side of an element; its normal points outward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ElementSide {
    /// Positive side of a RAX2 or SAX1 element. Its normal is the direction from the first to the second node, rotated
    /// by 90 degrees counter-clockwise in the (r, z) plane.
    Positive,
    /// Negative side of a RAX2 or SAX1 element.
    Negative,
    /// One-based number of a boundary segment between two consecutive nodes of a solid. Face S1 of CAX3 and CAX4R is
    /// segment 1; face S1 of CAX6M is segments 1 and 2.
    Face(u8),
}

/// Faces of elements under a name (`*SURFACE, TYPE=ELEMENT`).
#[derive(Clone, Debug, Default)]
pub struct ElementSurface {
    /// Name as written in the deck.
    pub name: String,
    /// Faces `(element index, side)` in deck order.
    pub faces: Vec<(usize, ElementSide)>,
    /// Elements that were listed without a side: all their exposed faces belong to the surface, including faces that
    /// are exposed later by element deletion.
    pub free_face_elements: Vec<usize>,
    /// Source position of the first definition.
    pub span: Span,
}

/// The element sides on which a distributed load or a contact acts.
#[derive(Clone, Debug, PartialEq)]
pub struct SideSelection {
    /// Name of the surface or element set as written in the deck.
    pub name: String,
    /// Whether the selection is a surface (`*DSLOAD`) and not an element set (`*DLOAD`).
    pub surface: bool,
    /// Faces `(element index, side)`.
    pub faces: Vec<(usize, ElementSide)>,
    /// Elements whose exposed faces are all selected, including faces that are exposed later by element deletion.
    pub free_face_elements: Vec<usize>,
}
