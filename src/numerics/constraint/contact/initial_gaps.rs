//! Gaps at the start of an analysis: initial clearances, and overlaps that are kept.

use super::pairs::pair_of;
use super::system::ContactSystem;

/// An overlap of two surfaces at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceOverlap {
    /// Depth, as the mean over the hat function of a point.
    pub depth: f64,
    /// Coordinates of the point.
    pub place: [f64; 2],
}

/// Gaps of a pair at the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InitialGaps {
    /// The deepest overlap that is kept.
    pub overlap: Option<SurfaceOverlap>,
    /// Points whose gaps are set to the initial clearance.
    pub adjusted: Vec<AdjustedGap>,
}

/// A gap at the start that is set to the initial clearance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdjustedGap {
    /// Index of the point.
    pub point: u32,
    /// Geometric gap; negative for an overlap.
    pub gap: f64,
}

/// Sets initial clearances, and stores the gaps of the current rows as openings. Returns the gaps of each pair.
pub(super) fn set_initial_gaps(contact: &mut ContactSystem) -> Vec<InitialGaps> {
    let ContactSystem { surfaces, pairs, keys, measured, .. } = contact;
    let mut gaps = vec![InitialGaps::default(); pairs.len()];
    let mut offsets = vec![0.0; keys.count()];
    for row in &mut measured.rows.rows {
        let index = pair_of(pairs, row.key);
        let (pair, mut gap) = (&pairs[index], row.gap / row.area);
        let point = surfaces.curves[pair.secondary].points.get((row.key - pair.first_key) as usize).copied();
        if let Some(clearance) = pair.initial_clearance.filter(|c| (c.range[0]..=c.range[1]).contains(&gap)) {
            offsets[row.key as usize] = gap - clearance.gap;
            gaps[index].adjusted.extend(point.map(|point| AdjustedGap { point, gap }));
            gap = clearance.gap;
            row.gap = gap * row.area;
        }
        let Some(point) = point else { continue };
        if gap < gaps[index].overlap.map_or(0.0, |overlap| -overlap.depth) {
            gaps[index].overlap = Some(SurfaceOverlap { depth: -gap, place: surfaces.places[point as usize] });
        }
    }
    // Also if all are zero: the length of the list must not depend on the mesh.
    if pairs.iter().any(|pair| pair.initial_clearance.is_some()) {
        keys.gap_offsets = offsets;
    }
    keys.store_openings(&measured.rows.rows);
    gaps
}
