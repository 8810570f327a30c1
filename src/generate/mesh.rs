//! The mesh of a projectile: nose, shank, case and fill, with their sets and surfaces.

use std::collections::HashMap;

use super::nose;
use super::profile::{Piece, Point};
use super::shape::{Nose, Outline, positive};
use super::sheet::QuadMesh;
use super::spacing::{graded, rows};
use crate::deck::Diagnostic;

/// What a mesh is made of. Lengths are in one unit, the deck's.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshRequest {
    /// The form of the nose.
    pub nose: Nose,
    /// Radius of the shank; a polyline brings its own.
    pub radius: f64,
    /// Length of the whole projectile; a polyline brings its own.
    pub length: f64,
    /// Length of the sides of elements at the nose.
    pub size: f64,
    /// How many times longer elements are at the base than at the shoulder.
    pub along: f64,
    /// How many times wider elements are at the axis than at the surface.
    pub across: f64,
    /// What is hollow.
    pub cavity: Option<Cavity>,
}

/// The hollow of a case: a cylinder about the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cavity {
    /// Thickness of the wall around it.
    pub wall: f64,
    /// Elements through the wall; by the size of elements, and two at least, if not given.
    pub through: Option<usize>,
    /// Where it begins, from the tip.
    pub front: f64,
    /// Thickness of the base behind it; 0 leaves it open.
    pub base: f64,
    /// What it holds.
    pub fill: Fill,
}

/// What a cavity holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Fill {
    /// Nothing.
    None,
    /// A fill that shares the nodes of the case.
    Bonded,
    /// A fill with nodes of its own, for contact.
    Apart,
}

/// Numbers and names in the deck.
#[derive(Clone, Debug, PartialEq)]
pub struct DeckLabels {
    /// The first number of nodes and of elements.
    pub first: usize,
    /// What the names of sets and surfaces begin with.
    pub prefix: String,
    /// Material of the projectile or of its case.
    pub material: String,
    /// Material of the fill.
    pub fill: String,
}

/// What an element is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshPart {
    /// The projectile, or its case.
    Case,
    /// The fill.
    Fill,
}

/// Sides that a load or contact may act on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfacePart {
    /// From the tip to the shoulder.
    Nose,
    /// From the shoulder to the base.
    Shank,
    /// The base.
    Base,
    /// The wall of the cavity.
    Inner,
    /// The surface of a fill apart.
    Fill,
}

/// A mesh with what belongs to it.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Nodes and elements.
    pub(super) sheet: QuadMesh,
    /// What each element is part of.
    pub(super) belongs: Vec<MeshPart>,
    /// How many elements, from the first, form the nose.
    pub(super) in_nose: usize,
    /// Free sides off the axis: element, side from 1 to 4, wall.
    pub(super) walls: Vec<(usize, usize, SurfacePart)>,
    /// The node at the middle of the front, at the shoulder's surface, nearest to the axis at the base, at the base's rim.
    pub(super) corners: [usize; 4],
    pub(super) outline: Outline,
    pub(super) wanted: MeshRequest,
}

/// The most elements of a mesh.
const MOST: f64 = 1e7;

impl Mesh {
    /// Makes the mesh.
    ///
    /// # Errors
    /// G001 to G006: what cannot be meshed, in words.
    pub fn new(wanted: &MeshRequest) -> Result<Mesh, Diagnostic> {
        let outline = Outline::new(&wanted.nose, wanted.radius, wanted.length)?;
        check_sizes(wanted, &outline)?;
        if let Some(cavity) = &wanted.cavity {
            check_cavity(cavity, &outline)?;
        }
        let columns = ColumnShares::of(wanted, &outline);
        let mesh = MeshBuilder::new(wanted, &outline, &columns).mesh();
        let worst = mesh.measure().jacobian;
        if worst.0 > 1e-6 {
            return Ok(mesh);
        }
        let [r, z] = worst.1;
        let message = format!("near r = {r:.4}, z = {z:.4} an element would fold");
        Err(Diagnostic::error("G006", message).help("give more points of the profile there, or a smaller --size"))
    }
}

fn check_sizes(wanted: &MeshRequest, outline: &Outline) -> Result<(), Diagnostic> {
    positive("element size", wanted.size)?;
    positive("growth along the shank", wanted.along)?;
    positive("growth towards the axis", wanted.across)?;
    let radius = outline.widest();
    if wanted.size > radius * (1.0 + 1e-12) {
        let message = format!("elements of {} are larger than the radius of {radius}", wanted.size);
        return Err(Diagnostic::error("G001", message).help("two elements over the radius are few, eight are many"));
    }
    let [_, end] = outline.rim();
    if radius * end / (wanted.size * wanted.size) > MOST {
        let message = format!("elements of {} would be more than {MOST:.0}", wanted.size);
        return Err(Diagnostic::error("G001", message).help("is the size in the unit of the radius?"));
    }
    Ok(())
}

fn check_cavity(cavity: &Cavity, outline: &Outline) -> Result<(), Diagnostic> {
    let refuse = |message: String, help: &str| Err(Diagnostic::error("G005", message).help(help));
    let ([radius, height], [_, end]) = (outline.shoulder(), outline.rim());
    positive("wall", cavity.wall)?;
    if cavity.wall >= radius {
        return refuse(format!("a wall of {} leaves no cavity in a radius of {radius}", cavity.wall), "it is thinner");
    }
    if cavity.front.is_nan() || cavity.front <= height {
        let message = format!("the cavity begins at {}, the shoulder of the nose is at {height}", cavity.front);
        return refuse(message, "noses are solid: the cavity begins behind the shoulder");
    }
    if !(cavity.base >= 0.0 && end - cavity.base > cavity.front) {
        let message =
            format!("the cavity begins at {} and ends {} in front of the base at {end}", cavity.front, cavity.base);
        return refuse(message, "front + base are less than the length");
    }
    let touches = |piece: &&Piece| piece.ends()[1][1] > cavity.front && piece.ends()[0][1] < end - cavity.base;
    if outline.body.iter().filter(touches).any(|piece| piece.ends().iter().any(|p| p[0] != radius)) {
        return refuse("the radius changes along the cavity".into(), "a wall of one thickness needs a straight shank");
    }
    Ok(())
}

/// Columns at the shoulder: shares of the radius, and how many lie within the cavity.
struct ColumnShares {
    shares: Vec<f64>,
    within: usize,
}

impl ColumnShares {
    fn of(wanted: &MeshRequest, outline: &Outline) -> ColumnShares {
        let ([radius, _], pointed) = (outline.shoulder(), !outline.nose.is_empty());
        let count = |length: f64, least: usize| ((length / wanted.size).round() as usize).max(least);
        let Some(cavity) = &wanted.cavity else {
            // As many beside the axis as beside the flank: a nose is best with an even number.
            let even = if pointed { 2 * count(radius / 2.0, 1) } else { count(outline.widest(), 1) };
            let shares = graded(even, wanted.across);
            return ColumnShares { shares, within: 0 };
        };
        let hollow = radius - cavity.wall;
        let within = count(hollow, 1);
        let through = cavity.through.unwrap_or_else(|| count(cavity.wall, 2)).max(1);
        let mut shares: Vec<f64> = graded(within, wanted.across).iter().map(|s| s * hollow / radius).collect();
        let wall = cavity.wall / radius;
        shares.extend((1..=through).map(|n| 1.0 - wall * (through - n) as f64 / through as f64));
        ColumnShares { shares, within }
    }
}

/// A mesh in the making.
struct MeshBuilder<'a> {
    wanted: &'a MeshRequest,
    outline: &'a Outline,
    columns: &'a ColumnShares,
    sheet: QuadMesh,
    belongs: Vec<MeshPart>,
    in_nose: usize,
    /// By node: whether it lies on the nose, the shank, the base.
    outer: HashMap<usize, u8>,
}

const NOSE: u8 = 1;
const SHANK: u8 = 2;
const BASE: u8 = 4;

impl<'a> MeshBuilder<'a> {
    fn new(wanted: &'a MeshRequest, outline: &'a Outline, columns: &'a ColumnShares) -> Self {
        let (sheet, belongs, outer) = (QuadMesh::default(), Vec::new(), HashMap::new());
        MeshBuilder { wanted, outline, columns, sheet, belongs, in_nose: 0, outer }
    }

    fn mark(&mut self, nodes: impl IntoIterator<Item = usize>, with: u8) {
        nodes.into_iter().for_each(|n| *self.outer.entry(n).or_default() |= with);
    }

    fn mesh(mut self) -> Mesh {
        let [radius, height] = self.outline.shoulder();
        let (front, shoulder) = if self.outline.nose.is_empty() {
            let columns = self.columns.shares.clone();
            let front: Vec<usize> = columns.iter().map(|s| self.sheet.node([s * radius, height])).collect();
            self.mark(front.iter().copied(), NOSE);
            (front[0], front)
        } else {
            let nose = nose::mesh(&mut self.sheet, &self.outline.nose, &self.columns.shares, self.wanted.size);
            self.in_nose = self.sheet.elements.len();
            self.belongs = vec![MeshPart::Case; self.in_nose];
            self.mark(nose.flank.iter().copied(), NOSE);
            (nose.axis[0], nose.shoulder)
        };
        let surface = shoulder[shoulder.len() - 1];
        let base = self.body(shoulder);
        self.mark(base.iter().copied(), BASE);
        let corners = [front, surface, base[0], base[base.len() - 1]];
        let walls = self.walls();
        let MeshBuilder { sheet, belongs, in_nose, outline, wanted, .. } = self;
        Mesh { sheet, belongs, in_nose, walls, corners, outline: outline.clone(), wanted: wanted.clone() }
    }

    /// What lies behind the shoulder, row by row; the nodes of the base.
    fn body(&mut self, shoulder: Vec<usize>) -> Vec<usize> {
        let heights = self.heights();
        let hollow = |z: f64| self.wanted.cavity.is_some_and(|c| z >= c.front && z < self.outline.rim()[1] - c.base);
        let holds = self.wanted.cavity.map_or(Fill::None, |c| c.fill);
        let mut surface = vec![shoulder[shoulder.len() - 1]];
        let mut row: Vec<Option<usize>> = shoulder.into_iter().map(Some).collect();
        let mut last_fill: Option<Vec<usize>> = None;
        for (n, z) in heights.iter().enumerate().skip(1) {
            let in_cavity = hollow(heights[n - 1]);
            // Nodes within the case: none in the cavity, but for its back wall.
            let open = in_cavity && holds != Fill::Bonded && (n + 1 == heights.len() || hollow(*z));
            let next = self.row(*z, if open { self.columns.within } else { 0 });
            let from = if in_cavity && holds != Fill::Bonded { self.columns.within } else { 0 };
            self.between(&row, &next, from, in_cavity && holds == Fill::Bonded);
            if in_cavity && holds == Fill::Apart {
                last_fill = Some(self.apart(last_fill.take(), [heights[n - 1], *z]));
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

    /// Heights of rows from the shoulder to the base.
    fn heights(&self) -> Vec<f64> {
        let ([_, from], [_, end]) = (self.outline.shoulder(), self.outline.rim());
        if self.outline.body.is_empty() {
            return vec![from];
        }
        let mut breaks: Vec<f64> = self.outline.body.iter().map(|piece| piece.ends()[1][1]).collect();
        breaks.push(from);
        if let Some(cavity) = self.wanted.cavity {
            breaks.extend([cavity.front, end - cavity.base]);
        }
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        rows(&breaks, self.wanted.size, self.wanted.along)
    }

    /// The outer radius at a height behind the shoulder.
    fn radius(&self, z: f64) -> f64 {
        let piece = self.outline.body.iter().find(|piece| z <= piece.ends()[1][1]);
        piece.map_or(self.outline.rim()[0], |piece| {
            let [[r, low], [_, high]] = piece.ends();
            let share = (z - low) / (high - low);
            if piece.ends()[1][0] == r { r } else { piece.at(share)[0] }
        })
    }

    /// Nodes of a row from a column on.
    fn row(&mut self, z: f64, from: usize) -> Vec<Option<usize>> {
        let radius = self.radius(z);
        let columns = self.columns;
        let node = |(n, share): (usize, &f64)| (n >= from).then(|| self.sheet.node([share * radius, z]));
        columns.shares.iter().enumerate().map(node).collect()
    }

    /// Elements between two rows from a column on; what lies within the cavity belongs to the fill if that is bonded.
    fn between(&mut self, low: &[Option<usize>], high: &[Option<usize>], from: usize, filled: bool) {
        let columns = low.windows(2).zip(high.windows(2)).enumerate().skip(from);
        for (n, (low, high)) in columns {
            if let ([Some(a), Some(b)], [Some(d), Some(c)]) = (low, high) {
                self.sheet.elements.push([*a, *b, *c, *d]);
                let fill = filled && n < self.columns.within;
                self.belongs.push(if fill { MeshPart::Fill } else { MeshPart::Case });
            }
        }
    }

    /// A row of a fill apart, between two heights; its last nodes.
    fn apart(&mut self, last: Option<Vec<usize>>, [low, high]: [f64; 2]) -> Vec<usize> {
        let radius = self.radius(high);
        let columns = self.columns;
        let shares = &columns.shares[..=columns.within];
        let mut nodes = |z: f64| -> Vec<usize> { shares.iter().map(|s| self.sheet.node([s * radius, z])).collect() };
        let below = last.unwrap_or_else(|| nodes(low));
        let above = nodes(high);
        for (a, b) in below.windows(2).zip(above.windows(2)) {
            self.sheet.elements.push([a[0], a[1], b[1], b[0]]);
            self.belongs.push(MeshPart::Fill);
        }
        above
    }

    /// Free sides that do not lie on the axis.
    fn walls(&self) -> Vec<(usize, usize, SurfacePart)> {
        let mut sides: HashMap<[usize; 2], u32> = HashMap::new();
        let each = || {
            let corners = self.sheet.elements.iter().enumerate();
            corners.flat_map(|(e, corners)| (0..4).map(move |k| (e, k, [corners[k], corners[(k + 1) % 4]])))
        };
        let key = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
        each().for_each(|(_, _, side)| *sides.entry(key(side)).or_default() += 1);
        let on_axis = |n: usize| self.sheet.points[n][0] == 0.0;
        let free = each().filter(|(_, _, side)| sides[&key(*side)] == 1 && !side.iter().all(|&n| on_axis(n)));
        free.map(|(e, k, side)| (e, k + 1, self.wall(e, side))).collect()
    }

    fn wall(&self, element: usize, side: [usize; 2]) -> SurfacePart {
        let marks = side.map(|n| self.outer.get(&n).copied().unwrap_or(0));
        match marks[0] & marks[1] {
            m if m & NOSE != 0 => SurfacePart::Nose,
            m if m & BASE != 0 => SurfacePart::Base,
            m if m & SHANK != 0 => SurfacePart::Shank,
            _ if self.belongs[element] == MeshPart::Fill => SurfacePart::Fill,
            _ => SurfacePart::Inner,
        }
    }
}

impl Mesh {
    /// The exact volumes of case and fill.
    pub(super) fn exact(&self) -> [f64; 2] {
        let hollow = self.wanted.cavity.map_or(0.0, |c| {
            let inner = self.outline.shoulder()[0] - c.wall;
            std::f64::consts::PI * inner * inner * (self.outline.rim()[1] - c.base - c.front)
        });
        let filled = self.wanted.cavity.is_some_and(|c| c.fill != Fill::None);
        [self.outline.volume() - hollow, if filled { hollow } else { 0.0 }]
    }

    pub(super) fn corners_of(&self, element: usize) -> [Point; 4] {
        self.sheet.corners(element)
    }
}
