//! The four-node axisymmetric cohesive element (COHAX4): separations of its faces, nodal forces, areas and masses.
//!
//! The nodes 1 and 2 are the bottom face, 4 and 3 the top face. The mid-surface goes from the middle of nodes 1 and 4
//! to that of nodes 2 and 3; its direction t and the normal n, t rotated counter-clockwise in (r, z), turn with the
//! element. The two integration points are the ends of the mid-surface. Each has the consistent ring area of a uniform
//! traction in the initial configuration, so that the weights sum to the area of the mid-surface. With points at the
//! ends, the tractions of a stiff interface do not oscillate (Schellekens and de Borst 1993,
//! doi:10.1002/nme.1620360104).

use super::facet::ring_areas;
use super::lanes::InlineMap;
use crate::platform::PortableMath as _;

/// Bottom and top node of each integration point.
pub const PAIRS: [[usize; 2]; 2] = [[0, 3], [1, 2]];

/// Direction of the mid-surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MidSurface {
    /// Unit vector along the mid-surface.
    pub t: [f64; 2],
    /// Length in the (r, z) plane.
    pub length: f64,
}

/// Returns the ends of the mid-surface.
fn middles(corners: [[f64; 2]; 4]) -> [[f64; 2]; 2] {
    PAIRS.inline_map(|[bottom, top]: [usize; 2]| {
        [0, 1].inline_map(|i: usize| 0.5 * (corners[bottom][i] + corners[top][i]))
    })
}

/// Returns the areas of both integration points. Equation (17.2).
pub fn areas(corners: [[f64; 2]; 4]) -> [f64; 2] {
    ring_areas(middles(corners))
}

/// Returns the mean distance between the faces along the normal.
pub fn geometric_thickness(corners: [[f64; 2]; 4]) -> f64 {
    let [[a, _], [b, _]] = MidSurface::new(corners).jumps(corners);
    0.5 * (a + b)
}

impl MidSurface {
    pub fn new(corners: [[f64; 2]; 4]) -> MidSurface {
        let [a, b] = middles(corners);
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0].portable_hypot(along[1]);
        MidSurface { t: along.inline_map(|x| x / length), length }
    }

    /// Returns the unit normal, from the bottom to the top face.
    pub fn n(&self) -> [f64; 2] {
        [-self.t[1], self.t[0]]
    }

    /// Returns the vectors from the bottom to the top face at both points, along n and t. Equation (17.1).
    pub fn jumps(&self, corners: [[f64; 2]; 4]) -> [[f64; 2]; 2] {
        let n = self.n();
        PAIRS.inline_map(|[bottom, top]: [usize; 2]| {
            let across = [0, 1].inline_map(|i: usize| corners[top][i] - corners[bottom][i]);
            [n, self.t].inline_map(|axis| axis[0] * across[0] + axis[1] * across[1])
        })
    }

    /// Returns the forces on the nodes of forces (traction times area) along n and t between the faces, for the vectors
    /// between the faces. They are minus the gradient of the energy: as the normal turns with the mid-surface, tractions
    /// between distant faces have a moment, which a couple at both ends balances. Equation (17.3).
    pub fn forces(&self, between: [[f64; 2]; 2], jumps: [[f64; 2]; 2]) -> [[f64; 2]; 4] {
        let n = self.n();
        let mut forces = [[0.0; 2]; 4];
        let mut moment = 0.0;
        for point in 0..2 {
            let ([normal, shear], [bottom, top]) = (between[point], PAIRS[point]);
            moment += shear * jumps[point][0] - normal * jumps[point][1];
            for i in 0..2 {
                let force = normal * n[i] + shear * self.t[i];
                forces[top][i] -= force;
                forces[bottom][i] += force;
            }
        }
        let couple = 0.5 * moment / self.length;
        for (nodes, sign) in PAIRS.into_iter().zip([1.0, -1.0]) {
            for node in nodes {
                for i in 0..2 {
                    forces[node][i] += sign * couple * n[i];
                }
            }
        }
        forces
    }
}

#[cfg(test)]
mod tests {
    use super::{MidSurface, areas, geometric_thickness};
    use std::f64::consts::PI;

    const CORNERS: [[f64; 2]; 4] = [[1.0, 0.0], [2.0, 0.5], [1.9, 0.9], [0.8, 0.3]];

    #[test]
    fn areas_sum_to_the_ring_area_of_the_mid_surface() {
        let [a, b] = [[0.9, 0.15], [1.95, 0.7]];
        let area = PI * (a[0] + b[0]) * f64::hypot(b[0] - a[0], b[1] - a[1]);
        let [first, second] = areas(CORNERS);
        assert!((first + second - area).abs() < 1e-14 * area && first < second);
    }

    #[test]
    fn thickness_is_the_distance_of_the_faces() {
        let corners = [[1.0, 0.0], [3.0, 0.0], [3.0, 0.25], [1.0, 0.25]];
        assert_eq!(geometric_thickness(corners), 0.25);
        assert_eq!(geometric_thickness([corners[0], corners[1], corners[1], corners[0]]), 0.0);
    }

    #[test]
    fn separations_do_not_depend_on_a_rotation() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let turned = CORNERS.map(|[r, z]| [3.0 + cos * r - sin * z, sin * r + cos * z]);
        let jumps_at_start = MidSurface::new(CORNERS).jumps(CORNERS);
        let after = MidSurface::new(turned).jumps(turned);
        for (a, b) in jumps_at_start.as_flattened().iter().zip(after.as_flattened()) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    /// Energy of springs of unit stiffness, with different weights of both points and modes.
    fn energy(corners: [[f64; 2]; 4]) -> f64 {
        let [[a, b], [c, d]] = MidSurface::new(corners).jumps(corners);
        0.5 * (3.0 * a * a + 2.0 * b * b + 5.0 * c * c + d * d)
    }

    #[test]
    fn forces_are_minus_the_gradient_of_the_energy() {
        let surface = MidSurface::new(CORNERS);
        let jumps = surface.jumps(CORNERS);
        let [[a, b], [c, d]] = jumps;
        let forces = surface.forces([[3.0 * a, 2.0 * b], [5.0 * c, d]], jumps);
        for node in 0..4 {
            for axis in 0..2 {
                let moved = |by: f64| {
                    let mut corners = CORNERS;
                    corners[node][axis] += by;
                    energy(corners)
                };
                let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((forces[node][axis] + slope).abs() < 1e-9, "{node} {axis}");
            }
        }
    }
}
