//! Facets: straight meridian segments, which are conical frusta in space. Area, normal, clipping by planes z = const,
//! pressure forces.

use super::lanes::InlineMap;
use crate::platform::PortableMath as _;
use std::f64::consts::PI;

/// A facet with its outward unit normal. Coordinates are `[r, z]`, lengths in the unit of the deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// End with the smaller z (the first end if both are equal).
    pub low: [f64; 2],
    /// End with the larger z.
    pub high: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
    /// Area of the frustum, π (r1 + r2) L.
    pub area: f64,
}

/// Part of a facet, also a frustum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetPart {
    pub area: f64,
    /// Midpoint of its meridian, `[r, z]`.
    pub middle: [f64; 2],
}

impl Facet {
    /// Creates the facet between two nodes. Its positive normal is the direction from the first to the second node
    /// rotated 90 degrees counter-clockwise in (r, z); `positive` selects this side as outward, otherwise the other
    /// side. `None` if the nodes coincide. Equation (1.3).
    pub fn new(first: [f64; 2], second: [f64; 2], positive: bool) -> Option<Facet> {
        let along = [second[0] - first[0], second[1] - first[1]];
        let length = along[0].portable_hypot(along[1]);
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let sign = if positive { 1.0 } else { -1.0 };
        let normal = [-sign * along[1] / length, sign * along[0] / length];
        let (low, high) = if first[1] <= second[1] { (first, second) } else { (second, first) };
        Some(Facet { low, high, normal, area: PI * (first[0] + second[0]) * length })
    }

    /// Returns the midpoint of the segment: the integration point of loads, where 2π r L is the facet's area.
    pub fn middle(&self) -> [f64; 2] {
        [0.5 * (self.low[0] + self.high[0]), 0.5 * (self.low[1] + self.high[1])]
    }

    pub fn length(&self) -> f64 {
        (self.high[0] - self.low[0]).portable_hypot(self.height())
    }

    /// Returns the extent along z.
    pub fn height(&self) -> f64 {
        self.high[1] - self.low[1]
    }

    /// Returns the area of the part with `from <= z <= to`, for a facet that is not horizontal. Exact: the part is a
    /// frustum too. Equation (1.3).
    pub fn area_between(&self, from: f64, to: f64) -> f64 {
        if from <= self.low[1] && to >= self.high[1] {
            // The whole facet, with the arithmetic of an uncut part: the same bits without its divisions.
            let radii = self.low[0] + (self.low[0] + (self.high[0] - self.low[0]));
            return self.area * radii / (self.low[0] + self.high[0]);
        }
        let height = self.height();
        let start = ((from - self.low[1]) / height).clamp(0.0, 1.0);
        let end = ((to - self.low[1]) / height).clamp(0.0, 1.0);
        if end <= start {
            return 0.0;
        }
        let radius = |s: f64| self.low[0] + s * (self.high[0] - self.low[0]);
        self.area * (end - start) * (radius(start) + radius(end)) / (self.low[0] + self.high[0])
    }

    /// Returns the part with `from <= z <= to` and r <= `within`; a horizontal facet counts as between any planes.
    /// `None` if the part is empty.
    pub fn part(&self, [from, to]: [f64; 2], within: f64) -> Option<FacetPart> {
        let (height, widening) = (self.height(), self.high[0] - self.low[0]);
        let [mut start, mut end] = if height > 0.0 {
            [from, to].inline_map(|z| ((z - self.low[1]) / height).clamp(0.0, 1.0))
        } else {
            [0.0, 1.0]
        };
        let edge = (within - self.low[0]) / widening;
        if widening > 0.0 {
            end = end.min(edge);
        } else if widening < 0.0 {
            start = start.max(edge);
        } else if self.low[0] > within {
            return None;
        }
        if start.is_nan() || end.is_nan() || end <= start {
            return None;
        }
        let point = |s: f64| [self.low[0] + s * widening, self.low[1] + s * height];
        let (low, high) = (point(start), point(end));
        let area = self.area * (end - start) * (low[0] + high[0]) / (self.low[0] + self.high[0]);
        Some(FacetPart { area, middle: point(0.5 * (start + end)) })
    }

    /// Returns the parts into which a facet is divided, of equal length, from its low end on.
    pub fn equal_parts(self, count: usize) -> impl Iterator<Item = Facet> {
        let end = move |i: usize| {
            let s = i as f64 / count as f64;
            [0, 1]
                .inline_map(|k| if i == count { self.high[k] } else { self.low[k] + s * (self.high[k] - self.low[k]) })
        };
        (0..count).map(move |i| {
            let (low, high) = (end(i), end(i + 1));
            let radii = (low[0] + high[0]) / (self.low[0] + self.high[0]);
            let area = if count == 1 { self.area } else { self.area * radii / count as f64 };
            Facet { low, high, area, ..self }
        })
    }

    /// Returns the facet displaced by `shift` along z.
    pub fn shifted(&self, shift: f64) -> Facet {
        let moved = |[r, z]: [f64; 2]| [r, z + shift];
        Facet { low: moved(self.low), high: moved(self.high), ..*self }
    }

    /// Returns the masses of a shell with this thickness and density, lumped by row sums, at the low and the high end:
    /// ρ t 2πL (2 r1 + r2)/6 and ρ t 2πL (r1 + 2 r2)/6. Equation (1.4).
    pub fn lumped_mass(&self, density: f64, thickness: f64) -> [f64; 2] {
        let (low, high) = (self.low[0], self.high[0]);
        let length = (high - low).portable_hypot(self.height());
        let factor = density * thickness * PI * length / 3.0;
        [factor * (2.0 * low + high), factor * (low + 2.0 * high)]
    }
}

/// Returns the force on each of the two nodes by a pressure on the plane section of a facet, per unit depth, with the
/// sign of [`ring_pressure`]: -p n L/2.
#[inline]
pub fn section_pressure([a, b]: [[f64; 2]; 2], pressure: f64) -> [f64; 2] {
    [-0.5 * pressure * (b[1] - a[1]), 0.5 * pressure * (b[0] - a[0])]
}

/// Returns the forces on the two nodes of a facet by a pressure, positive against the outward normal, which points to
/// the right of the direction from the first to the second node: the consistent forces of a uniform pressure,
/// -p n 2πL (2 r1 + r2)/6 on the first node.
#[inline]
pub fn ring_pressure([a, b]: [[f64; 2]; 2], pressure: f64) -> [[f64; 2]; 2] {
    let third = PI / 3.0 * pressure;
    // The outward normal times the length is (dz, -dr).
    let (n_r, n_z) = (third * (b[1] - a[1]), -third * (b[0] - a[0]));
    [2.0 * a[0] + b[0], a[0] + 2.0 * b[0]].inline_map(|weight| [-n_r * weight, -n_z * weight])
}

/// Returns the forces of a pressure on a shell: each node receives that of its half of the meridian,
/// -p n 2πL/2 (3 r1 + r2)/4 on the first node. The stress of one-point shells is in equilibrium with the load between
/// midpoints of adjacent elements, so that these forces leave no residual on the axis.
#[inline]
pub fn shell_pressure([a, b]: [[f64; 2]; 2], pressure: f64) -> [[f64; 2]; 2] {
    let quarter = 0.25 * PI * pressure;
    let (n_r, n_z) = (quarter * (b[1] - a[1]), -quarter * (b[0] - a[0]));
    [3.0 * a[0] + b[0], a[0] + 3.0 * b[0]].inline_map(|weight| [-n_r * weight, -n_z * weight])
}

/// Returns the areas of a facet that the two nodes carry, for the consistent forces of a uniform traction:
/// 2πL (2 r1 + r2)/6 for the first node. Equation (16.1).
#[inline]
pub fn ring_areas([a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    let third = PI / 3.0 * length(a, b);
    [2.0 * a[0] + b[0], a[0] + 2.0 * b[0]].inline_map(|weight| third * weight)
}

/// Returns the areas of the two halves of a facet of a shell, with the weights of [`shell_pressure`].
#[inline]
pub fn shell_areas([a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    let quarter = 0.25 * PI * length(a, b);
    [3.0 * a[0] + b[0], a[0] + 3.0 * b[0]].inline_map(|weight| quarter * weight)
}

/// Returns the areas of the two halves of a facet in the plane section, per unit depth.
#[inline]
pub fn section_areas([a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    [0.5 * length(a, b); 2]
}

#[inline]
fn length(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).portable_hypot(b[1] - a[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_positive_normal_is_the_direction_turned_counter_clockwise() {
        let facet = Facet::new([1.0, 0.0], [2.0, 0.0], true).expect("a facet");
        assert_eq!(facet.normal, [0.0, 1.0]);
        assert!(Facet::new([1.0, 1.0], [1.0, 1.0], true).is_none());
    }

    #[test]
    fn areas_of_parts_sum_to_the_whole() {
        let facet = Facet::new([0.5, 1.0], [2.0, 4.0], true).expect("a facet");
        let parts = facet.area_between(-9.0, 1.7) + facet.area_between(1.7, 3.1) + facet.area_between(3.1, 9.0);
        assert!((parts - facet.area).abs() < 1e-14 * facet.area);
        assert!((facet.lumped_mass(3.0, 0.1).iter().sum::<f64>() - 0.3 * facet.area).abs() < 1e-14);
    }

    #[test]
    fn parts_within_a_radius_are_those_between_planes() {
        let facet = Facet::new([0.5, 1.0], [2.0, 4.0], true).expect("a facet");
        let part = facet.part([1.7, 3.1], 9.0).expect("a part");
        assert!((part.area - facet.area_between(1.7, 3.1)).abs() < 1e-14 * facet.area);
        // r = 1.25 is at z = 2.5.
        let inner = facet.part([-9.0, 9.0], 1.25).expect("a part");
        assert!((inner.area - facet.area_between(-9.0, 2.5)).abs() < 1e-14 * facet.area);
        assert!((inner.middle[0] - 0.875).abs() < 1e-15 && (inner.middle[1] - 1.75).abs() < 1e-15);
        assert_eq!(facet.part([-9.0, 9.0], 0.5), None);
        let level = Facet::new([0.0, 1.0], [2.0, 1.0], true).expect("a facet");
        let disc = level.part([0.0, 2.0], 1.0).expect("a part");
        assert!((disc.area - PI).abs() < 1e-15 && disc.middle == [0.5, 1.0]);
        let upward = Facet::new([2.0, 1.0], [0.5, 4.0], true).expect("a facet");
        assert!((upward.part([-9.0, 9.0], 1.25).expect("a part").area - inner.area).abs() < 1e-14);
        assert_eq!(upward.shifted(1.0).low, [2.0, 2.0]);
    }

    #[test]
    fn a_sphere_in_equal_angles_has_n2_one_half_for_any_count() {
        for count in [1, 2, 3, 7, 20, 400] {
            let node = |i: usize| {
                let angle = 0.5 * PI * i as f64 / count as f64;
                [angle.sin(), -angle.cos()]
            };
            let n2: f64 = (0..count)
                .filter_map(|i| Facet::new(node(i), node(i + 1), false))
                .map(|f| f.area * f.normal[1].abs().powi(3) / PI)
                .sum();
            assert!((n2 - 0.5).abs() < 4e-15 * count as f64, "{count} facets: {n2}");
        }
    }
}
