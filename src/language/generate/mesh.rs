//! Mesh of a projectile: nose, shank, case and fill, with sets and surfaces.

use std::collections::HashMap;

use super::nose;
use super::picture;
use super::profile::ProfilePiece;
use super::shape::{NoseShape, ProjectileOutline, positive};
use super::sheet::QuadMesh;
use super::spacing::{graded, rows};
use crate::deck::Diagnostic;
use crate::output::drawing::Drawing;

/// Parameters of a projectile mesh. All lengths have the length unit of the deck.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshRequest {
    /// Shape of the nose, with its dimensions.
    pub nose: NoseShape,
    /// Radius of the shank; ignored for a polyline, which defines it.
    pub radius: f64,
    /// Length of the whole projectile; ignored for a polyline, which defines it.
    pub length: f64,
    /// Element size at the nose.
    pub size: f64,
    /// Ratio of the element lengths at the base and at the shoulder.
    pub along: f64,
    /// Ratio of the element widths at the axis and at the surface.
    pub across: f64,
    /// Cavity of a hollow projectile.
    pub cavity: Option<CaseCavity>,
}

/// A cylindrical cavity about the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CaseCavity {
    /// Thickness of the lateral wall between cavity and outer surface.
    pub wall: f64,
    /// Number of elements through the wall; by default from the element size, at least two.
    pub through: Option<usize>,
    /// Distance of the front of the cavity from the tip.
    pub front: f64,
    /// Thickness of the base; 0 leaves the cavity open.
    pub base: f64,
    /// Contents of the cavity.
    pub fill: CavityFill,
}

/// Contents of a cavity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum CavityFill {
    /// Empty cavity.
    None,
    /// Fill that shares nodes with the case.
    Bonded,
    /// Fill with separate nodes, for contact.
    Apart,
}

/// Labels and names in the generated deck.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckLabels {
    /// First node and element label.
    pub first: usize,
    /// Prefix of the names of sets and surfaces.
    pub prefix: String,
    /// Material of the projectile or of its case.
    pub material: String,
    /// Name of the fill's material.
    pub fill: String,
}

/// Part of the projectile to which an element belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshPart {
    /// The projectile, or its case.
    Case,
    /// The fill of the cavity.
    Fill,
}

/// Part of the surface, for loads and contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfacePart {
    /// From the tip to the shoulder.
    Nose,
    /// From the shoulder to the base.
    Shank,
    /// The rear face.
    Base,
    /// The wall of the cavity.
    Inner,
    /// Surface of a separate fill.
    Fill,
}

/// A free side of an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeSide {
    pub element: usize,
    /// Number of the side, from 1 to 4.
    pub side: usize,
    pub part: SurfacePart,
}

/// A projectile mesh with its parts and surfaces.
#[derive(Clone, Debug)]
pub struct ProjectileMesh {
    /// Nodes and elements.
    pub(super) sheet: QuadMesh,
    /// Part to which each element belongs.
    pub(super) parts: Vec<MeshPart>,
    /// Number of nose elements, which come first.
    pub(super) in_nose: usize,
    /// Free sides off the axis.
    pub(super) walls: Vec<FreeSide>,
    /// Nodes at the front centre, at the surface of the shoulder, at the base nearest to the axis, and at the rim of
    /// the base.
    pub(super) corners: [usize; 4],
    pub(super) outline: ProjectileOutline,
    pub(super) request: MeshRequest,
}

/// Largest number of elements.
pub(super) const MAX_ELEMENTS: f64 = 1e7;

impl ProjectileMesh {
    /// Generates the mesh.
    ///
    /// # Errors
    /// G001 to G006 for invalid parameters.
    pub fn new(request: &MeshRequest) -> Result<ProjectileMesh, Diagnostic> {
        let outline = ProjectileOutline::new(&request.nose, request.radius, request.length)?;
        check_sizes(request, &outline)?;
        if let Some(cavity) = &request.cavity {
            check_cavity(cavity, &outline)?;
        }
        let columns = ColumnShares::of(request, &outline);
        let mesh = MeshBuilder::new(request, &outline, &columns).mesh();
        let worst = mesh.sheet.quality().jacobian;
        if worst.0 > 1e-6 {
            return Ok(mesh);
        }
        let [r, z] = worst.1;
        let message = format!("an element near r = {r:.4}, z = {z:.4} would be folded");
        Err(Diagnostic::error("G006", message).help("give more points of the profile there, or a smaller --size"))
    }

    /// Draws the meridian section, mirrored about the axis.
    pub fn drawing(&self, title: &str) -> Drawing {
        let colour = |element: usize| match (self.parts[element], element < self.in_nose) {
            (MeshPart::Fill, _) => 0xf2_d9_b0,
            (MeshPart::Case, true) => 0xb8_d4_ea,
            (MeshPart::Case, false) => 0xdf_e7_ee,
        };
        picture::drawing(&self.sheet, colour, title)
    }
}

fn check_sizes(request: &MeshRequest, outline: &ProjectileOutline) -> Result<(), Diagnostic> {
    positive("element size", request.size)?;
    positive("growth along the shank", request.along)?;
    positive("growth towards the axis", request.across)?;
    let radius = outline.widest();
    if request.size > radius * (1.0 + 1e-12) {
        let message = format!("elements of {} are larger than the radius of {radius}", request.size);
        return Err(Diagnostic::error("G001", message).help("use about two to eight elements over the radius"));
    }
    let [_, end] = outline.rim();
    if radius * end / (request.size * request.size) > MAX_ELEMENTS {
        let message = format!("element size {} gives more than {MAX_ELEMENTS:.0} elements", request.size);
        return Err(Diagnostic::error("G001", message).help("element size and radius must have the same unit"));
    }
    Ok(())
}

fn check_cavity(cavity: &CaseCavity, outline: &ProjectileOutline) -> Result<(), Diagnostic> {
    let refuse = |message: String, help: &str| Err(Diagnostic::error("G005", message).help(help));
    let ([radius, height], [_, end]) = (outline.shoulder(), outline.rim());
    positive("wall", cavity.wall)?;
    if cavity.wall >= radius {
        return refuse(
            format!("the wall thickness {} must be less than the radius {radius}", cavity.wall),
            "give a thinner wall",
        );
    }
    if cavity.front.is_nan() || cavity.front <= height {
        let message =
            format!("the cavity starts at {}, in front of the shoulder of the nose at {height}", cavity.front);
        return refuse(message, "the nose is solid: the cavity must start after the shoulder");
    }
    if !(cavity.base >= 0.0 && end - cavity.base > cavity.front) {
        let message =
            format!("the cavity starts at {} and ends {} before the base at {end}", cavity.front, cavity.base);
        return refuse(message, "front + base must be less than the length");
    }
    let touches = |piece: &&ProfilePiece| piece.ends()[1][1] > cavity.front && piece.ends()[0][1] < end - cavity.base;
    if outline.body.iter().filter(touches).any(|piece| piece.ends().iter().any(|p| p[0] != radius)) {
        return refuse(
            "the radius changes along the cavity".into(),
            "a wall of constant thickness requires a straight shank",
        );
    }
    Ok(())
}

/// Radial division at the shoulder: fractions of the radius, and the number of columns inside the cavity.
struct ColumnShares {
    shares: Vec<f64>,
    within: usize,
}

impl ColumnShares {
    fn of(request: &MeshRequest, outline: &ProjectileOutline) -> ColumnShares {
        let ([radius, _], pointed) = (outline.shoulder(), !outline.nose.is_empty());
        let count = |length: f64, least: usize| ((length / request.size).round() as usize).max(least);
        let Some(cavity) = &request.cavity else {
            // The nose mesh requires as many columns next to the axis as next to the flank, so an even number.
            let even = if pointed { 2 * count(radius / 2.0, 1) } else { count(outline.widest(), 1) };
            let shares = graded(even, request.across);
            return ColumnShares { shares, within: 0 };
        };
        let hollow = radius - cavity.wall;
        let within = count(hollow, 1);
        let through = cavity.through.unwrap_or_else(|| count(cavity.wall, 2)).max(1);
        let mut shares: Vec<f64> = graded(within, request.across).iter().map(|s| s * hollow / radius).collect();
        let wall = cavity.wall / radius;
        shares.extend((1..=through).map(|n| 1.0 - wall * (through - n) as f64 / through as f64));
        ColumnShares { shares, within }
    }
}

/// A mesh under construction.
struct MeshBuilder<'a> {
    request: &'a MeshRequest,
    outline: &'a ProjectileOutline,
    columns: &'a ColumnShares,
    sheet: QuadMesh,
    parts: Vec<MeshPart>,
    in_nose: usize,
    /// Marks of outer nodes: on the nose, the shank or the base.
    outer: HashMap<usize, u8>,
}

const NOSE: u8 = 1;
const SHANK: u8 = 2;
const BASE: u8 = 4;

impl<'a> MeshBuilder<'a> {
    fn new(request: &'a MeshRequest, outline: &'a ProjectileOutline, columns: &'a ColumnShares) -> Self {
        let (sheet, parts, outer) = (QuadMesh::default(), Vec::new(), HashMap::new());
        MeshBuilder { request, outline, columns, sheet, parts, in_nose: 0, outer }
    }

    fn mark(&mut self, nodes: impl IntoIterator<Item = usize>, with: u8) {
        nodes.into_iter().for_each(|n| *self.outer.entry(n).or_default() |= with);
    }

    fn mesh(mut self) -> ProjectileMesh {
        let [radius, height] = self.outline.shoulder();
        let (front, shoulder) = if self.outline.nose.is_empty() {
            let columns = self.columns.shares.clone();
            let front: Vec<usize> = columns.iter().map(|s| self.sheet.node([s * radius, height])).collect();
            self.mark(front.iter().copied(), NOSE);
            (front[0], front)
        } else {
            let nose = nose::mesh(&mut self.sheet, &self.outline.nose, &self.columns.shares, self.request.size);
            self.in_nose = self.sheet.elements.len();
            self.parts = vec![MeshPart::Case; self.in_nose];
            self.mark(nose.flank.iter().copied(), NOSE);
            (nose.axis[0], nose.shoulder)
        };
        let surface = shoulder[shoulder.len() - 1];
        let base = self.body(shoulder);
        self.mark(base.iter().copied(), BASE);
        let corners = [front, surface, base[0], base[base.len() - 1]];
        let walls = self.walls();
        let MeshBuilder { sheet, parts, in_nose, outline, request, .. } = self;
        ProjectileMesh { sheet, parts, in_nose, walls, corners, outline: outline.clone(), request: request.clone() }
    }

    /// Meshes the body after the shoulder row by row, and returns the nodes of the base.
    fn body(&mut self, shoulder: Vec<usize>) -> Vec<usize> {
        let heights = self.heights();
        let hollow = |z: f64| self.request.cavity.is_some_and(|c| z >= c.front && z < self.outline.rim()[1] - c.base);
        let fill = self.request.cavity.map_or(CavityFill::None, |c| c.fill);
        let mut surface = vec![shoulder[shoulder.len() - 1]];
        let mut row: Vec<Option<usize>> = shoulder.into_iter().map(Some).collect();
        let mut last_fill: Option<Vec<usize>> = None;
        for (n, z) in heights.iter().enumerate().skip(1) {
            let in_cavity = hollow(heights[n - 1]);
            // Inside a cavity there are no case nodes, except at its back wall.
            let open = in_cavity && fill != CavityFill::Bonded && (n + 1 == heights.len() || hollow(*z));
            let next = self.row(*z, if open { self.columns.within } else { 0 });
            let from = if in_cavity && fill != CavityFill::Bonded { self.columns.within } else { 0 };
            self.between(&row, &next, from, in_cavity && fill == CavityFill::Bonded);
            if in_cavity && fill == CavityFill::Apart {
                last_fill = Some(self.separate_fill_row(last_fill.take(), [heights[n - 1], *z]));
                if n + 1 == heights.len() {
                    self.mark(last_fill.iter().flatten().copied(), BASE);
                }
            }
            surface.extend(next.last().copied().flatten());
            row = next;
        }
        if surface.len() > 1 {
            self.mark(surface, SHANK);
        }
        row.into_iter().flatten().collect()
    }

    /// Returns the z coordinates of the rows from the shoulder to the base.
    fn heights(&self) -> Vec<f64> {
        let ([_, from], [_, end]) = (self.outline.shoulder(), self.outline.rim());
        if self.outline.body.is_empty() {
            return vec![from];
        }
        let mut breaks: Vec<f64> = self.outline.body.iter().map(|piece| piece.ends()[1][1]).collect();
        breaks.push(from);
        if let Some(cavity) = self.request.cavity {
            breaks.extend([cavity.front, end - cavity.base]);
        }
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        rows(&breaks, self.request.size, self.request.along)
    }

    /// Returns the outer radius at a height after the shoulder.
    fn radius(&self, z: f64) -> f64 {
        let piece = self.outline.body.iter().find(|piece| z <= piece.ends()[1][1]);
        piece.map_or(self.outline.rim()[0], |piece| {
            let [[r, low], [_, high]] = piece.ends();
            let share = (z - low) / (high - low);
            if piece.ends()[1][0] == r { r } else { piece.at(share)[0] }
        })
    }

    /// Adds the nodes of a row, starting with column `from`.
    fn row(&mut self, z: f64, from: usize) -> Vec<Option<usize>> {
        let radius = self.radius(z);
        let columns = self.columns;
        let node = |(n, share): (usize, &f64)| (n >= from).then(|| self.sheet.node([share * radius, z]));
        columns.shares.iter().enumerate().map(node).collect()
    }

    /// Adds the elements between two rows, starting with column `from`. If `filled`, those inside the cavity belong to
    /// the fill.
    fn between(&mut self, low: &[Option<usize>], high: &[Option<usize>], from: usize, filled: bool) {
        let columns = low.windows(2).zip(high.windows(2)).enumerate().skip(from);
        for (n, (low, high)) in columns {
            if let ([Some(a), Some(b)], [Some(d), Some(c)]) = (low, high) {
                self.sheet.elements.push([*a, *b, *c, *d]);
                let fill = filled && n < self.columns.within;
                self.parts.push(if fill { MeshPart::Fill } else { MeshPart::Case });
            }
        }
    }

    /// Adds a row of a separate fill between two heights, and returns its upper nodes.
    fn separate_fill_row(&mut self, last: Option<Vec<usize>>, [low, high]: [f64; 2]) -> Vec<usize> {
        let radius = self.radius(high);
        let columns = self.columns;
        let shares = &columns.shares[..=columns.within];
        let mut nodes = |z: f64| -> Vec<usize> { shares.iter().map(|s| self.sheet.node([s * radius, z])).collect() };
        let below = last.unwrap_or_else(|| nodes(low));
        let above = nodes(high);
        for (a, b) in below.windows(2).zip(above.windows(2)) {
            self.sheet.elements.push([a[0], a[1], b[1], b[0]]);
            self.parts.push(MeshPart::Fill);
        }
        above
    }

    /// Returns the free sides off the axis.
    fn walls(&self) -> Vec<FreeSide> {
        let mut sides: HashMap<[usize; 2], u32> = HashMap::new();
        let each = || {
            let corners = self.sheet.elements.iter().enumerate();
            corners.flat_map(|(e, corners)| (0..4).map(move |k| (e, k, [corners[k], corners[(k + 1) % 4]])))
        };
        let key = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
        each().for_each(|(_, _, side)| *sides.entry(key(side)).or_default() += 1);
        let on_axis = |n: usize| self.sheet.points[n][0] == 0.0;
        let free = each().filter(|(_, _, side)| sides[&key(*side)] == 1 && !side.iter().all(|&n| on_axis(n)));
        free.map(|(element, k, side)| FreeSide { element, side: k + 1, part: self.wall(element, side) }).collect()
    }

    fn wall(&self, element: usize, side: [usize; 2]) -> SurfacePart {
        let marks = side.map(|n| self.outer.get(&n).copied().unwrap_or(0));
        match marks[0] & marks[1] {
            m if m & NOSE != 0 => SurfacePart::Nose,
            m if m & BASE != 0 => SurfacePart::Base,
            m if m & SHANK != 0 => SurfacePart::Shank,
            _ if self.parts[element] == MeshPart::Fill => SurfacePart::Fill,
            _ => SurfacePart::Inner,
        }
    }
}

impl ProjectileMesh {
    /// Returns the exact volumes of case and fill.
    pub(super) fn exact(&self) -> [f64; 2] {
        let hollow = self.request.cavity.map_or(0.0, |c| {
            let inner = self.outline.shoulder()[0] - c.wall;
            std::f64::consts::PI * inner * inner * (self.outline.rim()[1] - c.base - c.front)
        });
        let filled = self.request.cavity.is_some_and(|c| c.fill != CavityFill::None);
        [self.outline.volume() - hollow, if filled { hollow } else { 0.0 }]
    }
}
