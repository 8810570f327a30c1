//! Rings of a rigid body with six degrees of freedom, divided into stations, and their distances from an analytical
//! surface of revolution.

use std::f64::consts::PI;

use crate::kernel::attitude::{SpatialVector, plus};
use crate::kernel::lists::Memory;
use crate::kernel::profile::SurfaceProfile;
use crate::platform::PortableMath as _;
use crate::state::rigid_body_3d::Pose;

/// Iterations for the deepest point of a ring; on a plane the first one is exact.
const DEEPEST: usize = 3;

/// A ring of meridian points around the axis of a body.
#[derive(Clone, Copy, Debug)]
pub struct WallRing {
    /// Meridian point `[r, z]`, relative to the centre of mass.
    pub place: [f64; 2],
    /// Unit normal of its facet; not used in hard contact.
    pub normal: [f64; 2],
    /// Integral of its hat function over its facet; 1 in hard contact, so that pressures are forces.
    pub area: f64,
    /// Index of its contact law.
    pub law: usize,
}

/// Position of a body point relative to the wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallDistance {
    /// Signed distance from the wall.
    pub(super) gap: f64,
    pub(super) normal: SpatialVector,
    /// Vector from the centre of mass.
    pub(super) arm: SpatialVector,
}

/// Position of a body and displacement of the wall along 2 at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallPose {
    pub(super) body: Pose,
    pub(super) lift: f64,
}

/// A wall and the rings of the body that may touch it.
#[derive(Clone, Debug, Memory)]
#[memory(uncounted: profile)]
pub struct WallSurfaces {
    /// Profile of the wall; its contact side is to the left.
    pub profile: SurfaceProfile,
    pub rings: Vec<WallRing>,
    /// Cosines and sines of the angles of the stations.
    stations: Vec<[f64; 2]>,
}

impl WallSurfaces {
    /// Creates the surfaces with a number of stations around the axis.
    pub fn new(profile: SurfaceProfile, rings: Vec<WallRing>, stations: usize) -> WallSurfaces {
        let around = |k: usize| libm::sincos(2.0 * PI * k as f64 / stations as f64);
        let stations = (0..stations).map(around).map(|(sine, cosine)| [cosine, sine]).collect();
        WallSurfaces { profile, rings, stations }
    }

    /// Returns the largest number of points, including the deepest point of each ring.
    pub(super) fn most_points(&self) -> usize {
        self.rings.len() * (self.stations.len() + 1)
    }

    /// Returns signed distance and wall normal at a position in space; `None` beyond the edges of the wall.
    fn gap(&self, [x, y, z]: SpatialVector, lift: f64) -> Option<(f64, SpatialVector)> {
        let r = x.portable_hypot(z);
        let nearest = self.profile.nearest([r, y], lift);
        let [n_r, n_z] = self.profile.segments[nearest.segment].normal([r, y], lift);
        let [c, s] = if r > 0.0 { [x / r, z / r] } else { [1.0, 0.0] };
        (!nearest.beyond).then_some((nearest.gap, [n_r * c, n_z, n_r * s]))
    }

    /// Returns the wall distance of a point given in the frame of the body.
    fn touch(&self, pose: &WallPose, own: SpatialVector) -> Option<WallDistance> {
        let arm = pose.body.attitude.to_world(own);
        let (gap, normal) = self.gap(plus(pose.body.centre, 1.0, arm), pose.lift)?;
        Some(WallDistance { gap, normal, arm })
    }

    fn station(&self, ring: usize, k: usize) -> SpatialVector {
        let ([r, z], [c, s]) = (self.rings[ring].place, self.stations[k]);
        [r * c, z, r * s]
    }

    /// Returns the normal of the facet at a station in the frame of the body, and the area of the station. On the axis
    /// it is the mean normal around the axis.
    pub(super) fn facet(&self, ring: usize, k: usize) -> (SpatialVector, f64) {
        let (WallRing { place, normal: [n_r, n_z], area, .. }, [c, s]) = (self.rings[ring], self.stations[k]);
        let n_r = if place[0] == 0.0 { 0.0 } else { n_r };
        ([n_r * c, n_z, n_r * s], area / self.count(ring) as f64)
    }

    /// Returns the number of different stations of a ring.
    pub(super) fn count(&self, ring: usize) -> usize {
        if self.rings[ring].place[0] == 0.0 { 1 } else { self.stations.len() }
    }

    /// Returns whether a ring is in front of the wall by more than a distance.
    pub(super) fn is_far(&self, ring: usize, pose: &WallPose, distance: f64) -> bool {
        let [radius, z] = self.rings[ring].place;
        let [x, y, third] = plus(pose.body.centre, z, pose.body.attitude.axis());
        self.profile.nearest([x.portable_hypot(third), y], pose.lift).gap > distance + radius
    }

    /// Returns the wall distance of a station, or of the deepest point of a ring (`station` is `None`).
    pub(super) fn measure(&self, ring: usize, station: Option<usize>, pose: &WallPose) -> Option<WallDistance> {
        match station {
            Some(k) => self.touch(pose, self.station(ring, k)),
            None => self.deepest(pose, ring),
        }
    }

    /// Returns the deepest point of a ring, starting from its deepest station. Each iteration takes the deepest point
    /// in front of the tangent plane of the wall.
    fn deepest(&self, pose: &WallPose, ring: usize) -> Option<WallDistance> {
        let stations = (0..self.count(ring)).filter_map(|k| self.touch(pose, self.station(ring, k)));
        let mut best = stations.min_by(|a, b| a.gap.total_cmp(&b.gap))?;
        let [r, z] = self.rings[ring].place;
        for _ in 0..DEEPEST {
            let normal = pose.body.attitude.to_body(best.normal);
            let across = normal[0].portable_hypot(normal[2]);
            let deeper_place = [-r * normal[0] / across, z, -r * normal[2] / across];
            match self.touch(pose, deeper_place).filter(|_| across > 0.0).filter(|touch| touch.gap < best.gap) {
                Some(deeper) => best = deeper,
                None => break,
            }
        }
        Some(best)
    }

    /// Returns the distance of the centre of mass from the wall.
    pub(super) fn distance(&self, [x, y, z]: SpatialVector, lift: f64) -> f64 {
        self.profile.nearest([x.portable_hypot(z), y], lift).gap.abs()
    }
}
