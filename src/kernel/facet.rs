//! Facets: straight meridian segments, which are frusta of cones in space. Area, normal, clipping by planes z = const.
//! Never here: what acts on a facet.

use super::lanes::InlineMap;
use crate::platform::PortableMath as _;
use std::f64::consts::PI;

/// One facet with its outward unit normal. Coordinates are `[r, z]`, lengths in the deck's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// The end with the smaller z (the first end where both are level).
    pub low: [f64; 2],
    /// The end with the larger z.
    pub high: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
    /// Area of the frustum, pi (r1 + r2) L.
    pub area: f64,
}

/// A piece of a facet, a frustum too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    pub area: f64,
    /// Middle of its meridian, `[r, z]`.
    pub middle: [f64; 2],
}

impl Facet {
    /// The facet between two nodes. Its positive normal is the direction from the first to the second node turned 90
    /// degrees counter-clockwise in (r, z); `positive` chooses that side as the outward one, otherwise the other.
    /// `None` if the nodes coincide.
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

    /// Midpoint of the segment: the load integration point, where 2 pi r L is the facet's area.
    pub fn middle(&self) -> [f64; 2] {
        [0.5 * (self.low[0] + self.high[0]), 0.5 * (self.low[1] + self.high[1])]
    }

    pub fn length(&self) -> f64 {
        (self.high[0] - self.low[0]).portable_hypot(self.height())
    }

    /// Extent along z.
    pub fn height(&self) -> f64 {
        self.high[1] - self.low[1]
    }

    /// Area of the part with `from <= z <= to`, for a facet that is not level. Exact: the part is a frustum too.
    pub fn area_between(&self, from: f64, to: f64) -> f64 {
        if from <= self.low[1] && to >= self.high[1] {
            // All of it, in the arithmetic of parts with nothing cut off: the same bits without their divisions.
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

    /// The part with `from <= z <= to` and r <= `within`; a level facet lies between any planes.
    pub fn part(&self, [from, to]: [f64; 2], within: f64) -> Option<Part> {
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
        let at = |s: f64| [self.low[0] + s * widening, self.low[1] + s * height];
        let (low, high) = (at(start), at(end));
        let area = self.area * (end - start) * (low[0] + high[0]) / (self.low[0] + self.high[0]);
        Some(Part { area, middle: at(0.5 * (start + end)) })
    }

    /// The same facet a way along z further.
    pub fn shifted(&self, shift: f64) -> Facet {
        let at = |[r, z]: [f64; 2]| [r, z + shift];
        Facet { low: at(self.low), high: at(self.high), ..*self }
    }

    /// Consistent mass of a shell of this thickness and density, lumped by row sums on the first (low) and second
    /// (high) end: rho t 2 pi L (2 r1 + r2) / 6 and rho t 2 pi L (r1 + 2 r2) / 6.
    pub fn lumped_mass(&self, density: f64, thickness: f64) -> [f64; 2] {
        let (low, high) = (self.low[0], self.high[0]);
        let length = (high - low).portable_hypot(self.height());
        let factor = density * thickness * PI * length / 3.0;
        [factor * (2.0 * low + high), factor * (low + 2.0 * high)]
    }
}

/// Force on each of the two nodes by a pressure on the plane section of a facet, a length 1 out of it, with the sign of
/// [`ring_pressure`]: -p n L/2.
#[inline]
pub fn section_pressure([a, b]: [[f64; 2]; 2], pressure: f64) -> [f64; 2] {
    [-0.5 * pressure * (b[1] - a[1]), 0.5 * pressure * (b[0] - a[0])]
}

/// Forces on the two nodes of a facet by a pressure, positive against the outward normal, which lies to the right of the way
/// from the first to the second: the consistent forces of a uniform pressure, -p n 2 pi L (2 r1 + r2)/6 on the first node.
#[inline]
pub fn ring_pressure([a, b]: [[f64; 2]; 2], pressure: f64) -> [[f64; 2]; 2] {
    let third = PI / 3.0 * pressure;
    // The outward normal times the length is (dz, -dr).
    let (n_r, n_z) = (third * (b[1] - a[1]), -third * (b[0] - a[0]));
    [2.0 * a[0] + b[0], a[0] + 2.0 * b[0]].inline_map(|weight| [-n_r * weight, -n_z * weight])
}

/// The same on a shell: each node takes its half of the meridian, -p n 2 pi L/2 (3 r1 + r2)/4 on the first. Shells of one point
/// hold what lies between the middles of elements, so that these forces leave nothing over on the axis.
#[inline]
pub fn shell_pressure([a, b]: [[f64; 2]; 2], pressure: f64) -> [[f64; 2]; 2] {
    let quarter = 0.25 * PI * pressure;
    let (n_r, n_z) = (quarter * (b[1] - a[1]), -quarter * (b[0] - a[0]));
    [3.0 * a[0] + b[0], a[0] + 3.0 * b[0]].inline_map(|weight| [-n_r * weight, -n_z * weight])
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
    fn parts_add_up_to_the_whole() {
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
