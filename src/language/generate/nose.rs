//! Mesh of a pointed nose. The meridian section, a triangle of axis, flank and shoulder, is divided into three
//! quadrilateral blocks that meet in one node. No element degenerates at the tip, and not all columns of the shank
//! continue to the tip.

use super::profile::{MeridianPoint, ProfilePiece, distance};
use super::shape::length;
use super::sheet::{QuadBlock, QuadMesh};

/// Boundary nodes of a nose mesh.
pub struct NoseMesh {
    /// Nodes along the flank from the tip to the shoulder.
    pub flank: Vec<usize>,
    /// Nodes along the axis from the tip to the shoulder.
    pub axis: Vec<usize>,
    /// Nodes at the shoulder from the axis to the flank.
    pub shoulder: Vec<usize>,
}

/// Meshes a nose. `columns` are at least three fractions of the shoulder radius, from 0 to 1.
pub fn mesh(sheet: &mut QuadMesh, pieces: &[ProfilePiece], columns: &[f64], size: f64) -> NoseMesh {
    let [_, [radius, height]] = pieces[pieces.len() - 1].ends();
    let across = columns.len() - 1;
    // Columns next to the flank, and next to the axis.
    let outer = across / 2;
    let inner = across - outer;
    let points = flank(pieces, inner, size, height);
    let rear = points.len() - 1 - inner;
    let flank: Vec<usize> = points.into_iter().map(|p| sheet.node(p)).collect();
    let (tip, end) = (flank[0], flank[flank.len() - 1]);
    let along = outer + rear;
    let mut axis = vec![tip];
    axis.extend((1..=along).map(|n| sheet.node([0.0, height * n as f64 / along as f64])));
    let mut shoulder = vec![axis[along]];
    shoulder.extend(columns[1..across].iter().map(|share| sheet.node([share * radius, height])));
    shoulder.push(end);

    let middle = sheet.node([0.0; 2]);
    let mut inside = |count: usize| -> Vec<usize> { (1..count).map(|_| sheet.node([0.0; 2])).collect() };
    let (on_axis, on_flank, on_shoulder) = (axis[outer], flank[inner], shoulder[inner]);
    let to_axis = [&[middle][..], &inside(inner), &[on_axis]].concat();
    let to_flank = [&[middle][..], &inside(outer), &[on_flank]].concat();
    let to_shoulder = [&[middle][..], &inside(rear), &[on_shoulder]].concat();
    let backwards = |edge: &[usize]| -> Vec<usize> { edge.iter().rev().copied().collect() };
    let from_axis = backwards(&to_axis);
    let from_flank = backwards(&to_flank);
    let blocks = [
        sheet.block([&flank[..=inner], &from_axis], [&axis[..=outer], &from_flank]),
        sheet.block([&from_axis, &shoulder[..=inner]], [&axis[outer..], &to_shoulder]),
        sheet.block([&to_flank, &shoulder[inner..]], [&to_shoulder, &flank[inner..]]),
    ];
    let shares = |part: &[f64]| -> Vec<f64> {
        let (first, last) = (part[0], part[part.len() - 1]);
        part.iter().map(|x| (x - first) / (last - first)).collect()
    };
    let at_axis: Vec<f64> = shares(&columns[..=inner]).into_iter().rev().map(|x| 1.0 - x).collect();
    let at_flank = shares(&columns[inner..]);
    let even: Vec<f64> = (0..=rear).map(|n| n as f64 / rear as f64).collect();
    let edges = [(to_axis, at_axis), (to_flank, at_flank), (to_shoulder, even)];
    let nose = NoseBlocks {
        blocks,
        edges,
        middle,
        axis: &axis,
        flank: &flank,
        piece: pieces.first().filter(|_| pieces.len() == 1),
    };
    nose.optimize(&mut sheet.points, [outer, inner], on_shoulder);
    nose.blocks.iter().for_each(|block| sheet.fill(block));
    NoseMesh { flank, axis, shoulder }
}

/// Returns points along the flank, which include the ends of its pieces. The block at the tip has `inner` divisions,
/// the rest at least one. The number of divisions follows from the mean length of flank and axis, because both have
/// equally many.
fn flank(pieces: &[ProfilePiece], inner: usize, size: f64, height: f64) -> Vec<MeridianPoint> {
    let whole = length(pieces);
    let per_length = 0.5 * (whole + height) / whole / size;
    let mut counts: Vec<usize> = pieces.iter().map(|p| ((p.length() * per_length).round() as usize).max(1)).collect();
    while counts.iter().sum::<usize>() < inner + 1 {
        let widest = |k: &usize| pieces[*k].length() / counts[*k] as f64;
        let coarsest = (0..counts.len()).max_by(|a, b| widest(a).total_cmp(&widest(b))).unwrap_or(0);
        counts[coarsest] += 1;
    }
    let mut points = vec![pieces[0].ends()[0]];
    for (piece, count) in pieces.iter().zip(counts) {
        points.extend((1..=count).map(|n| piece.at(n as f64 / count as f64)));
    }
    points
}

/// Three blocks that meet in a common node. Each inner edge starts there, with the fractions of its length.
struct NoseBlocks<'a> {
    blocks: [QuadBlock; 3],
    edges: [(Vec<usize>, Vec<f64>); 3],
    middle: usize,
    axis: &'a [usize],
    flank: &'a [usize],
    /// The flank if it is a single piece; its nodes can then be moved along it.
    piece: Option<&'a ProfilePiece>,
}

/// Positions of the block corners: fractions of axis and flank at which the tip block ends, and the common node.
#[derive(Clone, Copy)]
struct BlockCorners {
    ends: [f64; 2],
    middle: MeridianPoint,
}

impl BlockCorners {
    /// Returns a trial position: shifted by `step` in the four coordinates (lengths in units of `length`).
    fn shifted(mut self, [axis, flank, r, z]: [f64; 4], step: f64, length: f64) -> BlockCorners {
        self.ends = [self.ends[0] + axis * step, self.ends[1] + flank * step].map(|share| share.clamp(0.02, 0.98));
        self.middle = [self.middle[0] + r * step * length, self.middle[1] + z * step * length];
        self
    }
}

/// Directions of the trial steps.
const TRIALS: [[f64; 4]; 14] = [
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
    [0.0, 0.0, 0.0, -1.0],
    [0.0, 0.0, 0.3, 1.0],
    [0.0, 0.0, -0.3, -1.0],
    [1.0, 0.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0],
    [-1.0, -1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 1.0],
    [-1.0, -1.0, 0.0, -1.0],
];

impl NoseBlocks<'_> {
    /// Optimizes the block corners: maximizes the product of smallest scaled Jacobian and smallest height, which are
    /// measures of distortion and of the stable time increment. A pattern search with halved steps starts from three
    /// positions of the common node: a rhombus at the tip, a kite, and one nearer to the shoulder.
    fn optimize(&self, points: &mut [MeridianPoint], [outer, inner]: [usize; 2], on_shoulder: usize) {
        let [axis, flank, shoulder] = [self.axis[outer], self.flank[inner], on_shoulder].map(|n| points[n]);
        let ends = [outer as f64 / (self.axis.len() - 1) as f64, inner as f64 / (self.flank.len() - 1) as f64];
        let mixed = |a: f64, b: f64, c: f64| [0, 1].map(|k| a * axis[k] + b * flank[k] + c * shoulder[k]);
        let length = distance(points[self.axis[0]], shoulder);
        let starts = [mixed(1.0, 1.0, 0.0), mixed(0.55, 0.55, 0.0), mixed(0.4, 0.4, 0.2)];
        let search = |points: &mut [MeridianPoint], middle: MeridianPoint| {
            let mut places = BlockCorners { ends, middle };
            let (mut best, mut step) = (self.quality(points, places), 0.125);
            let mut trials = self.trials();
            while step > 2e-4 && trials > 0 {
                trials -= 1;
                let tried = TRIALS.map(|trial| places.shifted(trial, step, length));
                let best_trial =
                    tried.into_iter().map(|p| (self.quality(points, p), p)).max_by(|a, b| a.0.total_cmp(&b.0));
                match best_trial {
                    Some((worth, p)) if worth > best => (best, places) = (worth, p),
                    _ => step *= 0.5,
                }
            }
            (best, places)
        };
        let candidates = starts.map(|middle| search(points, middle));
        if let Some((_, places)) = candidates.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) {
            self.place(points, places);
        }
    }

    /// Returns the number of search steps; fine meshes use fewer.
    fn trials(&self) -> usize {
        let [outer, inner, rear] = [1, 0, 2].map(|k| self.edges[k].0.len() - 1);
        let elements = outer * inner + (outer + inner) * rear;
        (60_000 / elements).clamp(12, 200)
    }

    /// Places all inner nodes, and the nodes along axis and flank.
    fn place(&self, points: &mut [MeridianPoint], places: BlockCorners) {
        let [outer, inner] = [&self.edges[1], &self.edges[0]].map(|edge| edge.0.len() - 1);
        let height = points[self.axis[self.axis.len() - 1]][1];
        for (n, share) in split(self.axis.len() - 1, outer, places.ends[0]) {
            points[self.axis[n]] = [0.0, height * share];
        }
        if let Some(piece) = self.piece {
            for (n, share) in split(self.flank.len() - 1, inner, places.ends[1]) {
                points[self.flank[n]] = piece.at(share);
            }
        }
        points[self.middle] = places.middle;
        for (edge, shares) in &self.edges {
            let end = points[edge[edge.len() - 1]];
            for (&n, share) in edge.iter().zip(shares).skip(1).take(edge.len() - 2) {
                points[n] = [0, 1].map(|k| places.middle[k] + share * (end[k] - places.middle[k]));
            }
        }
        self.blocks.iter().for_each(|block| block.spread(points));
    }

    fn quality(&self, points: &mut [MeridianPoint], places: BlockCorners) -> f64 {
        self.place(points, places);
        let each = self.blocks.iter().map(|block| block.worst(points));
        let [jacobian, height] = each.fold([f64::INFINITY; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])]);
        if jacobian > 0.0 { jacobian * height } else { jacobian }
    }
}

/// Returns index and position (as a fraction of the length) of the inner points of a line. Point `at` is at `share`,
/// and the spacing is uniform on either side of this point.
fn split(count: usize, at: usize, share: f64) -> impl Iterator<Item = (usize, f64)> {
    let rear = (count - at) as f64;
    (1..count).map(move |n| {
        let near = share * n as f64 / at as f64;
        (n, if n <= at { near } else { share + (1.0 - share) * (n - at) as f64 / rear })
    })
}
