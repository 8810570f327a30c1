//! Area in contact. Soft contact has the area of the parts with pressure. In hard contact, facets with pressure at both
//! points count with the area that the other surface covers. On a facet with pressure at one point, contact ends where
//! the gap begins.
//!
//! Next to the edge of a smooth contact, the gap grows as `x^(3/2)` with the distance `x` (Johnson 1985, Contact
//! Mechanics, 5.1). The ratio of the gaps of two open points gives the distance of the edge. The first open point
//! is not used: its gap has the largest error of discretisation. Errors of the position are proportional to the
//! facet length, because the discrete solution at the edge has no other length.

use super::curve::{FacetCurve, FacetNeighbor};
use super::keys::KeyValues;
use super::pairs::ContactPair;
use super::surfaces::ContactSurfaces;
use crate::kernel::lanes::{InlineMap, inline_from_fn};

/// Number of bisections for the position of an edge.
const BISECTIONS: usize = 40;

/// Distances of points along the surface from the last point with pressure, and the gaps there.
type OpenPoints = [(f64, f64); 4];

/// Returns the area in contact of a pair.
pub(super) fn contact_area(surfaces: &ContactSurfaces, pair: &ContactPair, keys: &KeyValues) -> f64 {
    if !pair.is_active {
        return 0.0;
    }
    let secondary = &surfaces.curves[pair.secondary];
    let pressed = PressedSurface { pair, secondary, keys, has_two_keys: surfaces.has_two_keys(pair) };
    secondary.exposed.iter().map(|facet| pressed.area_of_facet(*facet)).sum()
}

/// The own surface of a pair, with its pressures and gaps.
struct PressedSurface<'a> {
    pair: &'a ContactPair,
    secondary: &'a FacetCurve,
    keys: &'a KeyValues,
    /// Whether each point has two keys.
    has_two_keys: bool,
}

impl PressedSurface<'_> {
    /// Returns the area of a facet that is in contact.
    fn area_of_facet(&self, facet: u32) -> f64 {
        let PressedSurface { pair, secondary, .. } = self;
        let covered = match pair.analytical {
            Some(_) => secondary.hat_areas(facet as usize),
            None => pair.facet_gaps[facet as usize].area,
        };
        if pair.measures_closed_parts() && pair.facet_gaps[facet as usize].is_closed {
            return covered[0] + covered[1];
        }
        match secondary.facets[facet as usize].inline_map(|point| self.has_pressure(point)) {
            [true, true] => covered[0] + covered[1],
            [true, false] => self.area_up_to_edge(facet, 0, covered),
            [false, true] => self.area_up_to_edge(facet, 1, covered),
            [false, false] => 0.0,
        }
    }

    fn has_pressure(&self, point: u32) -> bool {
        let (key, pressures) = (self.pair.key_of(self.secondary, point) as usize, &self.keys.pressures);
        pressures[key][0] > 0.0 || self.has_two_keys && pressures[key + self.secondary.points.len()][0] > 0.0
    }

    /// Returns the part of the `covered` area of a facet that is in contact, if only the point at `end` has pressure.
    /// Without three open points with increasing gaps beyond it, this is the area of the hat function of the point.
    fn area_up_to_edge(&self, facet: u32, end: usize, covered: [f64; 2]) -> f64 {
        let edge = self.open_points(facet, end).and_then(|open| {
            let [_, near, far, _] = open;
            (0.0 < near.1 && near.1 < far.1).then(|| distance_of_edge(open, self.pair.analytical.is_some()))
        });
        let Some(edge) = edge else { return covered[end] };
        let shape = &self.secondary.shapes[facet as usize];
        let [here, there] = inline_from_fn(|i| shape.from[0] + (if i == end { 0.0 } else { shape.along[0] }));
        let part = edge / shape.length;
        let area = std::f64::consts::TAU * edge * (here + 0.5 * part * (there - here));
        area.min(covered[0] + covered[1])
    }

    /// Returns the points from the other end of a facet on, with zero gap for the last one, which is only the end of a
    /// facet. Returns `None` if the surface ends before, or if a point has pressure or no gap.
    fn open_points(&self, facet: u32, end: usize) -> Option<OpenPoints> {
        let PressedSurface { pair, secondary, .. } = self;
        let (mut facet, mut distance, mut open) = (facet as usize, 0.0, [(0.0, 0.0); 4]);
        for at in 0..open.len() {
            distance += secondary.shapes[facet].length;
            open[at].0 = distance;
            if at == open.len() - 1 {
                break;
            }
            let point = secondary.facets[facet][1 - end];
            open[at].1 = self.keys.opening[pair.key_of(secondary, point) as usize];
            let FacetNeighbor::Facet(next) = secondary.neighbors[facet][1 - end] else { return None };
            if self.has_pressure(point) || open[at].1.is_nan() {
                return None;
            }
            facet = next as usize;
        }
        Some(open)
    }
}

impl FacetCurve {
    /// Returns the areas of the hat functions of a facet's two points, of the surface of revolution.
    fn hat_areas(&self, facet: usize) -> [f64; 2] {
        let shape = &self.shapes[facet];
        let radii = [shape.from[0], shape.from[0] + shape.along[0]];
        [0, 1].inline_map(|end| std::f64::consts::PI / 3.0 * shape.length * (2.0 * radii[end] + radii[1 - end]))
    }
}

/// Returns the distance at which the gap begins, from the ratio of the gaps of the second and third open point. `at_points`
/// states whether they are the gaps of points instead of means over hat functions. Equation (10.16).
fn distance_of_edge(open: OpenPoints, at_points: bool) -> f64 {
    let [first, near, far, last] = open;
    let law = |[left, middle, right]: [f64; 3], edge: f64| match at_points {
        true => power(middle - edge) * (middle - edge),
        false => mean_over_hat([left - edge, middle - edge, right - edge]),
    };
    let (mut low, mut high) = (0.0, first.0);
    for _ in 0..BISECTIONS {
        let edge = 0.5 * (low + high);
        let [inner, outer] =
            [[first.0, near.0, far.0], [near.0, far.0, last.0]].inline_map(|positions| law(positions, edge));
        if inner * far.1 > outer * near.1 {
            low = edge;
        } else {
            high = edge;
        }
    }
    0.5 * (low + high)
}

fn power(x: f64) -> f64 {
    x.max(0.0).sqrt()
}

/// Returns the mean of `x^(3/2)` over the hat function between positions, up to a constant factor. Equation (10.17).
fn mean_over_hat([left, middle, right]: [f64; 3]) -> f64 {
    let [l, m, r] = [left, middle, right].inline_map(|x| x * x * x * power(x));
    ((r - m) / (right - middle) - (m - l) / (middle - left)) / (right - left)
}

#[cfg(test)]
mod tests {
    use super::distance_of_edge;

    /// Means of a gap that grows as the power 3/2 from the edge give the position of the edge, on unequal facets.
    #[test]
    fn edge_of_a_smooth_contact_is_found_exactly() {
        let (positions, edge, points) = ([1.0, 2.2, 3.1, 4.5], 0.37, 4000);
        let gap = |x: f64| (x - edge).powf(1.5);
        let mean = |[left, middle, right]: [f64; 3]| {
            let sample = |i: usize| {
                let x = left + (right - left) * (i as f64 + 0.5) / points as f64;
                let hat = ((x - left) / (middle - left)).min((right - x) / (right - middle));
                [hat, hat * gap(x)]
            };
            let sums = (0..points).map(sample).fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
            sums[1] / sums[0]
        };
        let open_points = |gaps: [f64; 2]| {
            let gaps = [0.0, gaps[0], gaps[1], 0.0];
            std::array::from_fn(|i| (positions[i], gaps[i]))
        };
        let means = open_points([0, 1].map(|i| mean([positions[i], positions[i + 1], positions[i + 2]])));
        assert!((distance_of_edge(means, false) - edge).abs() < 1e-6);
        let values = open_points([positions[1], positions[2]].map(gap));
        assert!((distance_of_edge(values, true) - edge).abs() < 1e-9);
    }
}
