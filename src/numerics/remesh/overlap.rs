//! Common parts of old and new elements of a body: the ring that each pair of elements shares.

use super::BodyMesh;
use crate::kernel::box_grid::BoxGrid;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shape::{distance, halves, middle, twice_area};
use crate::kernel::sorted_boxes::box_of;

/// The part of an old element that is in a new one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CommonPart {
    /// Index of the old element.
    pub old: u32,
    /// Index of the new element.
    pub new: u32,
    /// Share of the old element; the shares of each old element add up to 1.
    pub share: f64,
    /// Centre of volume `[r, z]`.
    pub centre: [f64; 2],
}

/// Parts below this fraction of the volume of an old element are rounding errors of its boundary.
const SLIVER: f64 = 1e-12;

/// Returns the common parts of two meshes of a body, by old element. Outlines may differ a little: what is outside the
/// new one is distributed over the parts of its element. `unchanged` are the old elements that are the first new ones, in
/// ascending order; each is one part.
pub fn common_parts(old: &BodyMesh, new: &BodyMesh, unchanged: &[u32]) -> Vec<CommonPart> {
    let cells: Vec<[[f64; 2]; 4]> = new.quads.iter().map(|quad| new.corners(quad)).collect();
    let boxes = BoxGrid::new(cells.iter().map(|cell| box_of(cell)).zip(0..).skip(unchanged.len()));
    let mut parts: Vec<CommonPart> = Vec::new();
    let (mut near, mut polygon, mut work) = (Vec::new(), Vec::new(), Vec::new());
    for (e, quad) in (0..).zip(&old.quads) {
        let (own_corners, first) = (old.corners(quad), parts.len());
        if let Ok(new) = unchanged.binary_search(&e) {
            parts.push(CommonPart { old: e, new: new as u32, share: 1.0, centre: ring(&own_corners).1 });
            continue;
        }
        near.clear();
        boxes.near(box_of(&own_corners), 0.0, |n| near.push(n));
        near.sort_unstable();
        let mut whole = 0.0;
        for triangle in triangles_of(own_corners) {
            whole += ring(&triangle).0;
        }
        for &n in &near {
            let (mut volume, mut moment) = (0.0, [0.0; 2]);
            for a in triangles_of(own_corners) {
                for b in triangles_of(cells[n as usize]) {
                    clip(&a, &b, &mut polygon, &mut work);
                    let (part, centre) = ring(&polygon);
                    if part > 0.0 {
                        volume += part;
                        moment = [0, 1].inline_map(|i: usize| moment[i] + part * centre[i]);
                    }
                }
            }
            if volume > SLIVER * whole {
                parts.push(CommonPart { old: e, new: n, share: volume, centre: moment.inline_map(|x| x / volume) });
            }
        }
        if parts.len() == first {
            let centre = middle(own_corners);
            parts.push(CommonPart { old: e, new: nearest(&cells, unchanged.len(), centre), share: 1.0, centre });
        }
        let sum: f64 = parts[first..].iter().map(|part| part.share).sum();
        parts[first..].iter_mut().for_each(|part| part.share /= sum);
    }
    parts
}

/// Returns the element from `first` on whose middle is nearest to a place.
fn nearest(cells: &[[[f64; 2]; 4]], first: usize, place: [f64; 2]) -> u32 {
    let apart = |cell: &[[f64; 2]; 4]| distance(middle(*cell), place);
    let closest = (0..).zip(cells).skip(first).min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)));
    closest.map_or(0, |(index, _)| index)
}

/// Returns two triangles that make up an element.
fn triangles_of(at: [[f64; 2]; 4]) -> [[[f64; 2]; 3]; 2] {
    halves(at).inline_map(|list| list.inline_map(|i| at[i]))
}

/// Cuts a triangle with another one (Sutherland and Hodgman 1974); both are counter-clockwise.
fn clip(triangle: &[[f64; 2]; 3], other: &[[f64; 2]; 3], polygon: &mut Vec<[f64; 2]>, work: &mut Vec<[f64; 2]>) {
    polygon.clear();
    polygon.extend(triangle);
    for i in 0..3 {
        let ([a, b], count) = ([other[i], other[(i + 1) % 3]], polygon.len());
        let inside = |p: [f64; 2]| twice_area([a, b, p]);
        work.clear();
        for k in 0..count {
            let (p, q) = (polygon[k], polygon[(k + 1) % count]);
            let (own_side, next) = (inside(p), inside(q));
            if own_side >= 0.0 {
                work.push(p);
            }
            if own_side * next < 0.0 {
                let share = own_side / (own_side - next);
                work.push([0, 1].inline_map(|i: usize| p[i] + share * (q[i] - p[i])));
            }
        }
        std::mem::swap(polygon, work);
        if polygon.len() < 3 {
            polygon.clear();
            return;
        }
    }
}

/// Returns volume over 2π and centre of volume of the ring with a polygon as its section.
pub(super) fn ring(polygon: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let Some(&base) = polygon.first() else { return (0.0, [0.0; 2]) };
    let (mut volume, mut along_r, mut along_z) = (0.0, 0.0, 0.0);
    for i in 1..polygon.len() - 1 {
        // Integrals over the triangle from the first corner: r, r², r z with z from the base.
        let [a, b, c] = [base, polygon[i], polygon[i + 1]];
        let twice = twice_area([a, b, c]);
        let sum = a[0] + b[0] + c[0];
        let [y, w] = [b[1] - a[1], c[1] - a[1]];
        volume += twice * sum / 6.0;
        along_r += twice * (sum * sum + a[0] * a[0] + b[0] * b[0] + c[0] * c[0]) / 24.0;
        along_z += twice * (sum * (y + w) + b[0] * y + c[0] * w) / 24.0;
    }
    if volume > 0.0 { (volume, [along_r / volume, base[1] + along_z / volume]) } else { (0.0, base) }
}

#[cfg(test)]
mod tests {
    use super::{clip, ring};

    /// Reference: a rectangle with the centre 2 (r² + r s + s²) / (3 (r + s)).
    #[test]
    fn ring_of_a_rectangle() {
        let (volume, [r, z]) = ring(&[[1.0, 5.0], [2.0, 5.0], [2.0, 9.0], [1.0, 9.0]]);
        assert!((volume - 6.0).abs() < 1e-14 && (r - 14.0 / 9.0).abs() < 1e-14 && (z - 7.0).abs() < 1e-14);
    }

    #[test]
    fn cut_of_two_triangles_is_symmetric() {
        let (a, b) = ([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]], [[1.0, -1.0], [3.0, 3.0], [-1.0, 2.0]]);
        let (mut first, mut second, mut work) = (Vec::new(), Vec::new(), Vec::new());
        clip(&a, &b, &mut first, &mut work);
        clip(&b, &a, &mut second, &mut work);
        let (first, second) = (ring(&first), ring(&second));
        assert!((first.0 - second.0).abs() < 1e-13 && first.0 > 0.0);
        assert!((first.1[0] - second.1[0]).abs() < 1e-13 && (first.1[1] - second.1[1]).abs() < 1e-13);
    }
}
