//! Circumferential stations: the facets of a rigid body with six degrees of freedom, divided into parts along the
//! meridian and into equal parts around the axis.

use crate::kernel::lanes::InlineMap;
use std::f64::consts::PI;

use crate::kernel::attitude::{SpatialVector, cross, dot, plus};
use crate::kernel::facet::Facet;
use crate::mesh::surface::RigidFacets;
use crate::platform::PortableMath as _;
use crate::state::rigid_body_3d::{RigidBody3d, Wrench};

/// Longest part of a facet, as a fraction of the largest distance of a node from the centre of mass. The moment of a
/// pressure on a part of a ring acts at the centroid of the ring, so its relative error is of second order in this
/// fraction.
const LONGEST: f64 = 1.0 / 6.0;
/// Largest difference of the radii of a part, as a fraction of the largest radius of the surface.
const WIDEST: f64 = 0.3;

/// One station: position and outward normal in the body frame.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceStation {
    /// Mesh index of the element to which the station belongs.
    pub element: usize,
    /// Position relative to the centre of mass.
    pub arm: SpatialVector,
    /// Outward unit normal.
    pub normal: SpatialVector,
    pub area: f64,
}

/// A station projected onto the plane through axis 2 that contains its normal. It corresponds to a point in the (r, z)
/// plane of a body that is not rotated.
#[derive(Clone, Copy, Debug)]
pub struct PlanarPoint {
    /// Distance from axis 2, and position along it.
    pub place: [f64; 2],
    /// Initial position, in the same coordinates.
    pub start: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
    /// Velocity for the evaluation of loads.
    pub velocity: [f64; 2],
    pub acceleration: [f64; 2],
}

impl SurfaceStation {
    /// Returns the current position and motion. The horizontal direction is that of the normal, away from axis 2, so
    /// the normal velocity equals that in three dimensions.
    pub fn in_plane(&self, body: &RigidBody3d) -> PlanarPoint {
        let arm = body.attitude.to_world(self.arm);
        let [x, y, z] = plus(body.centre, 1.0, arm);
        let normal = body.attitude.to_world(self.normal);
        let level = normal[0].portable_hypot(normal[2]);
        let outwards = if normal[0] * x + normal[2] * z < 0.0 { -1.0 } else { 1.0 };
        let across =
            if level > 0.0 { [outwards * normal[0] / level, outwards * normal[2] / level] } else { [1.0, 0.0] };
        let flat = |v: SpatialVector| [v[0] * across[0] + v[2] * across[1], v[1]];
        let velocity = plus(body.shown.velocity, 1.0, cross(body.shown.turning, arm));
        let start = plus(body.start.centre, 1.0, body.start.attitude.to_world(self.arm));
        PlanarPoint {
            place: [x.portable_hypot(z), y],
            start: [start[0].portable_hypot(start[2]), start[1]],
            normal: flat(normal),
            velocity: flat(velocity),
            acceleration: flat(body.acceleration_at(arm)),
        }
    }

    /// Returns the force and moment of a pressure on the station.
    pub fn pressure_wrench(&self, body: &RigidBody3d, pressure: f64) -> Wrench {
        let force = body.attitude.to_world(self.normal).inline_map(|n| -pressure * self.area * n);
        Wrench::at(body.attitude.to_world(self.arm), force)
    }

    pub fn normal_velocity(&self, body: &RigidBody3d) -> f64 {
        dot(body.velocity_at(body.attitude.to_world(self.arm)), body.attitude.to_world(self.normal))
    }
}

/// Returns radius and height of the circle through the centroids of a facet's stations.
pub fn centroid(facet: &Facet) -> [f64; 2] {
    let (low, high) = (facet.low, facet.high);
    let (a, b) = (low[0], high[0]);
    let share = if a + b > 0.0 { (a + 2.0 * b) / (3.0 * (a + b)) } else { 0.5 };
    [0, 1].inline_map(|i| low[i] + share * (high[i] - low[i]))
}

/// Returns the facets of a surface, each divided into equal lengths no longer than `longest` and than a fraction of the
/// body, with the element of each. A facet that is short enough is returned unchanged.
pub fn divided_facets(patch: &RigidFacets, body: &RigidBody3d, longest: f64) -> Vec<(usize, Facet)> {
    let longest = longest.min(LONGEST * body.size);
    let radius = largest_radius(patch);
    let mut parts = Vec::with_capacity(patch.facets.len());
    for &(element, facet) in &patch.facets {
        let widening = (facet.high[0] - facet.low[0]).abs();
        let count = (facet.length() / longest).max(widening / (WIDEST * radius));
        parts.extend(facet.equal_parts((count - 1e-9).ceil().max(1.0) as usize).map(|part| (element, part)));
    }
    parts
}

/// Returns the largest radius of a surface.
pub fn largest_radius(patch: &RigidFacets) -> f64 {
    patch.facets.iter().map(|(_, facet)| facet.low[0].max(facet.high[0])).fold(0.0, f64::max)
}

/// Returns the stations of a body's facets, facet by facet, in the order of the angle.
pub fn stations(patch: &RigidFacets, body: &RigidBody3d) -> Vec<SurfaceStation> {
    let count = body.stations;
    let around = |k: usize| libm::sincos(2.0 * PI * (k as f64 + 0.5) / count as f64);
    let parts = divided_facets(patch, body, f64::INFINITY);
    let mut list = Vec::with_capacity(count * parts.len());
    for (element, facet) in parts {
        let [r, z] = centroid(&facet);
        let [n_r, n_z] = facet.normal;
        list.extend((0..count).map(around).map(|(sine, cosine)| SurfaceStation {
            element,
            arm: [r * cosine, z - body.heights[0], r * sine],
            normal: [n_r * cosine, n_z, n_r * sine],
            area: facet.area / count as f64,
        }));
    }
    list
}
