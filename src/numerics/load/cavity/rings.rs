//! Rings: the surfaces that the facets of a meridian form around the axis, divided into stations, and the resistance of
//! a stack of inclined layers on them. All vectors are in the body frame. Loops over stations are plain arithmetic over
//! lanes, so that every instruction set gives the same bits.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use pulp::Arch;

use super::arcs::{part_of_ring, whole_ring};
use super::finite::StackBounds;
use super::stack::LayerStack;
use super::station_blocks::{LANES, LoadedStations, StationAngles, StationExtent, StationLanes, above_zero};
use crate::kernel::attitude::{SpatialVector, dot};
use crate::kernel::cavity::CavityResistance;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::{InlineMap, inline_from_fn};
use crate::kernel::lists::Memory;
use crate::load::stations::centroid;
use crate::platform::PortableMath as _;
use crate::state::rigid_body_3d::Wrench;

/// Share of the regularisation speed below which the damping of a motion does not limit the increment: its pressures are
/// smaller than this share of the full ones.
const NEGLIGIBLE: f64 = 1e-3;

/// Surface of revolution of one facet.
#[derive(Clone, Copy, Debug)]
pub struct FacetRing {
    /// Radial and axial component of the outward normal.
    normal: [f64; 2],
    /// Radius of the circle through the centroids of the stations, and its height above the centre of mass.
    pub(super) radius: f64,
    height: f64,
    /// Half the vector along the facet, `[r, z]`.
    pub(super) along: [f64; 2],
    /// Lever arm of the pressure about a transverse axis: height n_r - radius n_z.
    lever: f64,
    area: f64,
}

impl FacetRing {
    fn new(facet: &Facet, height_of_centre: f64, stations: usize) -> FacetRing {
        let (low, high, [radius, z]) = (facet.low, facet.high, centroid(facet));
        let height = z - height_of_centre;
        let normal = facet.normal;
        FacetRing {
            normal,
            radius,
            height,
            along: [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])],
            lever: height * normal[0] - radius * normal[1],
            area: facet.area / stations as f64,
        }
    }

    /// Returns the smallest extent of stations that is resolved.
    #[inline(always)]
    pub(super) fn shortest_extent(&self) -> f64 {
        1e-9 * (self.radius + self.along[0].abs() + self.along[1].abs())
    }

    /// Returns the squared change of the generalized velocity by a unit of normal velocity across the axis: `n_r²/M +
    /// lever²/I_t`.
    #[inline(always)]
    fn transverse_compliance(&self, compliance: &RigidCompliance) -> f64 {
        self.normal[0] * self.normal[0] * compliance.mass + self.lever * self.lever * compliance.transverse
    }

    /// Returns an upper bound of the squared change of the generalized velocity by a tangential force of 1.
    #[inline(always)]
    fn friction_compliance(&self, compliance: &RigidCompliance) -> f64 {
        let (r, h) = (self.radius, self.height);
        compliance.mass + (r * r + h * h) * compliance.transverse + r * r * compliance.axial
    }
}

/// Motion of a body and orientation of the stack, in the body frame.
#[derive(Clone, Copy, Debug)]
pub struct RingKinematics {
    /// Velocity of the centre of mass.
    pub velocity: SpatialVector,
    /// Angular velocity.
    pub turning: SpatialVector,
    /// Direction of increasing height in the stack, and the size of its components across the axis.
    pub up: SpatialVector,
    pub across: f64,
    /// Height of the centre of mass in the stack.
    pub height: f64,
    /// Vector from the pivot of the stack to the centre of mass.
    pub relative_to_pivot: SpatialVector,
    /// Regularisation speed: below it, pressure and friction are proportional to the speed.
    pub onset: f64,
    /// Coulomb coefficient.
    pub friction: f64,
    pub compliance: RigidCompliance,
}

/// Inverse mass and inverse moments of inertia of a body.
#[derive(Clone, Copy, Debug)]
pub struct RigidCompliance {
    pub mass: f64,
    pub transverse: f64,
    pub axial: f64,
}

/// Forces and moments on rings, and how fast they damp the motion.
#[derive(Clone, Copy, Debug, Default)]
pub struct RingForces {
    pub pressure: Wrench,
    pub friction: Wrench,
    /// Slope of the pressure over the speed in the regularised range, times area and compliance across the axis (1/s):
    /// its sum over the rings.
    transverse: RingSlope,
    /// Upper bound of the rate of damping by friction and along the axis, 1/s.
    other_damping: f64,
}

impl RingForces {
    /// Returns an upper bound of the rate (1/s) at which the regularised forces damp the motion: the largest eigenvalue
    /// over the directions across the axis, plus the other rates.
    pub fn damping(&self) -> f64 {
        let RingSlope { mean, second_harmonic: [c, s] } = self.transverse;
        0.5 * (mean + (c * c + s * s).sqrt()) + self.other_damping
    }
}

/// Slope over the normal velocity of the pressure, where the velocity is below the regularisation speed: mean over the
/// ring, and mean of its products with the cosine and the sine of twice the angle.
#[derive(Clone, Copy, Debug, Default)]
pub struct RingSlope {
    pub(super) mean: f64,
    pub(super) second_harmonic: [f64; 2],
}

/// Normal velocity and height of a ring as Fourier series in the angle: mean, cosine and sine terms.
#[derive(Clone, Copy)]
pub(super) struct RingHarmonics {
    /// Normal velocity v_n = mean + cosine cos + sine sin.
    pub(super) mean: f64,
    pub(super) cosine: f64,
    pub(super) sine: f64,
    /// Height in the stack: `height + rise[0] cos + rise[1] sin`.
    pub(super) height: f64,
    pub(super) rise: [f64; 2],
}

impl RingHarmonics {
    /// Equation (13.4).
    fn new(ring: &FacetRing, scene: &RingKinematics) -> RingHarmonics {
        let ([n_r, n_z], lever) = (ring.normal, ring.lever);
        let (v, w, up) = (scene.velocity, scene.turning, scene.up);
        RingHarmonics {
            mean: n_z * v[1],
            cosine: n_r * v[0] - lever * w[2],
            sine: n_r * v[2] + lever * w[0],
            height: scene.height + up[1] * ring.height,
            rise: [ring.radius * up[0], ring.radius * up[2]],
        }
    }

    /// Returns the amplitude of the normal velocity.
    fn swing(&self) -> f64 {
        self.cosine.portable_hypot(self.sine)
    }

    /// Returns the lowest and highest point of the ring in the stack.
    fn heights(&self, ring: &FacetRing, scene: &RingKinematics) -> [f64; 2] {
        let up = scene.up;
        let extent = scene.across * (ring.radius + ring.along[0].abs()) + up[1].abs() * ring.along[1].abs();
        [self.height - extent, self.height + extent]
    }
}

/// Rings of stations that cover the surface of one body.
#[derive(Clone, Debug, Memory)]
pub struct RingSet {
    rings: Vec<FacetRing>,
    stations: StationAngles,
    arch: Arch,
}

impl RingSet {
    /// Creates the rings of facets; `height_of_centre` is the z coordinate of the centre of mass in the mesh.
    pub fn new<'a>(facets: impl Iterator<Item = &'a Facet>, height_of_centre: f64, stations: usize) -> RingSet {
        let rings = facets.map(|f| FacetRing::new(f, height_of_centre, stations)).collect();
        RingSet { rings, stations: StationAngles::new(stations), arch: Arch::new() }
    }

    /// Returns the lowest and highest point of all rings in the stack.
    pub fn heights(&self, scene: &RingKinematics) -> [f64; 2] {
        let heights = self.rings.iter().map(|ring| RingHarmonics::new(ring, scene).heights(ring, scene));
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)])
    }

    /// Returns the resistance on all rings, in the body frame.
    pub fn resist(&self, stack: &LayerStack, scene: &RingKinematics) -> RingForces {
        self.arch.dispatch(RingForceKernel { rings: self, stack, scene })
    }

    /// Calls `each(ring, area, [pressure, normal velocity])` for all stations.
    pub fn show(&self, stack: &LayerStack, scene: &RingKinematics, mut each: impl FnMut(usize, f64, [f64; 2])) {
        for (index, ring) in self.rings.iter().enumerate() {
            let around = RingHarmonics::new(ring, scene);
            for block in 0..self.stations.weight.len() {
                let loaded = LoadedStations::new(&around, &self.stations, block, scene.onset);
                let pressure = if loaded.is_any() {
                    pressures(ring, &around, &self.stations, block, stack, None, scene, &loaded)
                } else {
                    [0.0; LANES]
                };
                let stations = self.stations.count - block * LANES;
                for l in 0..stations.min(LANES) {
                    each(index, ring.area, [pressure[l], loaded.middle[l]]);
                }
            }
        }
    }
}

/// Resistance on all rings of a body, compiled for each instruction set.
struct RingForceKernel<'a> {
    rings: &'a RingSet,
    stack: &'a LayerStack,
    scene: &'a RingKinematics,
}

impl pulp::NullaryFnOnce for RingForceKernel<'_> {
    type Output = RingForces;

    #[inline(always)]
    fn call(self) -> RingForces {
        let RingForceKernel { rings: RingSet { rings, stations, .. }, stack, scene } = self;
        let mut sum = RingForces::default();
        let (first, last) = (stack.planes[0], stack.planes[stack.planes.len() - 1]);
        let closed = scene.friction == 0.0 && stack.bounds.is_none();
        for ring in rings {
            let around = RingHarmonics::new(ring, scene);
            let [low, high] = around.heights(ring, scene);
            if high <= first || low >= last {
                continue;
            }
            let swing = around.swing();
            if around.mean + swing <= 0.0 {
                continue;
            }
            match stack.layer_around(low, high) {
                Some(layer) if closed => {
                    add_closed_form(ring, &around, swing, &stack.laws[layer], stations.count, scene, &mut sum);
                }
                layer if scene.friction > 0.0 => {
                    add_by_stations::<true>(ring, &around, stations, stack, layer, scene, &mut sum)
                }
                layer => add_by_stations::<false>(ring, &around, stations, stack, layer, scene, &mut sum),
            }
        }
        sum
    }
}

/// Adds the resistance on a ring that is inside one layer.
#[inline(always)]
fn add_closed_form(
    ring: &FacetRing,
    around: &RingHarmonics,
    swing: f64,
    law: &CavityResistance,
    stations: usize,
    scene: &RingKinematics,
    sum: &mut RingForces,
) {
    let area = ring.area * stations as f64;
    let means = if around.mean - swing >= scene.onset {
        whole_ring(around, law)
    } else {
        let (means, RingSlope { mean, second_harmonic: [c, s] }) = part_of_ring(around, swing, law, scene.onset);
        // As for stations, a slope at a negligible velocity counts in proportion to the velocity.
        let weight = area * ((around.mean + swing) / (NEGLIGIBLE * scene.onset)).min(1.0);
        add_damping(ring, scene, [weight * mean, weight * c, weight * s], sum);
        means
    };
    add_pressure(ring, &mut sum.pressure, means.inline_map(|mean| area * mean));
}

/// Adds the rate of damping by a slope of the pressure with these integrals over the ring: of the slope, and of its
/// products with the cosine and the sine of twice the angle.
#[inline(always)]
fn add_damping(ring: &FacetRing, scene: &RingKinematics, [all, cosine, sine]: [f64; 3], sum: &mut RingForces) {
    let transverse = ring.transverse_compliance(&scene.compliance);
    let RingSlope { mean, second_harmonic: [c, s] } = &mut sum.transverse;
    *mean += transverse * all;
    *c += transverse * cosine;
    *s += transverse * sine;
    sum.other_damping += ring.normal[1] * ring.normal[1] * scene.compliance.mass * all;
}

/// Adds force and moment of a pressure with these integrals over the ring: of p, p cos, p sin.
#[inline(always)]
fn add_pressure(ring: &FacetRing, sum: &mut Wrench, [all, cosine, sine]: [f64; 3]) {
    let [n_r, n_z] = ring.normal;
    sum.force[0] -= n_r * cosine;
    sum.force[1] -= n_z * all;
    sum.force[2] -= n_r * sine;
    sum.moment[0] -= ring.lever * sine;
    sum.moment[2] += ring.lever * cosine;
}

/// Returns the sum of lanes in a fixed order.
#[inline(always)]
fn total(lanes: &StationLanes) -> f64 {
    let mut half = [0.0; LANES / 2];
    for l in 0..LANES / 2 {
        half[l] = lanes[l] + lanes[l + LANES / 2];
    }
    (half[0] + half[1]) + (half[2] + half[3])
}

/// Returns the mean pressure on stations: the law at the normal velocity, times the part of the area that moves into
/// the material, summed over the layers. The bounds of the stack reduce the pressure by the position of the station's
/// midpoint.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // Ring, block of stations, position and motion.
fn pressures(
    ring: &FacetRing,
    around: &RingHarmonics,
    stations: &StationAngles,
    block: usize,
    stack: &LayerStack,
    layer: Option<usize>,
    scene: &RingKinematics,
    loaded: &LoadedStations,
) -> StationLanes {
    let weight = &stations.weight[block];
    let mut pressure = [0.0; LANES];
    if let Some(layer) = layer {
        let law = &stack.laws[layer];
        for l in 0..LANES {
            pressure[l] = weight[l] * loaded.share[l] * law.stress(loaded.speed[l]);
        }
        if let Some(finite) = &stack.bounds {
            let between = [stack.planes[layer], stack.planes[layer + 1]];
            bound(finite, (layer, between), (ring, around), (stations, block), scene, &mut pressure);
        }
        return pressure;
    }
    let extent = StationExtent::new(ring, around, stations, block, scene);
    let mut above = extent.share_above(stack.planes[0]);
    for (layer, (law, plane)) in stack.laws.iter().zip(&stack.planes[1..]).enumerate() {
        let beyond = extent.share_above(*plane);
        let mut sums = [0.0; LANES];
        for l in 0..LANES {
            let inside = weight[l] * loaded.share[l] * (above[l] - beyond[l]);
            sums[l] = inside * law.stress(loaded.speed[l]);
        }
        if let Some(finite) = &stack.bounds {
            let between = [stack.planes[layer], *plane];
            bound(finite, (layer, between), (ring, around), (stations, block), scene, &mut sums);
        }
        for l in 0..LANES {
            pressure[l] += sums[l];
        }
        above = beyond;
    }
    pressure
}

/// Reduces the pressure on stations in a layer for free faces and for the crater. The distance to a face is measured along
/// the outward normal of each station, at the height of the middle of its part inside the layer.
fn bound(
    finite: &StackBounds,
    (layer, [bottom, top]): (usize, [f64; 2]),
    (ring, around): (&FacetRing, &RingHarmonics),
    (stations, block): (&StationAngles, usize),
    scene: &RingKinematics,
    pressure: &mut StationLanes,
) {
    let (c, s) = (&stations.middle[0][block], &stations.middle[1][block]);
    let ([n_r, n_z], up) = (ring.normal, scene.up);
    for l in 0..LANES {
        if pressure[l] == 0.0 {
            continue;
        }
        let middle = around.height + (around.rise[0] * c[l] + around.rise[1] * s[l]);
        let half = (ring.along[1] * up[1] + ring.along[0] * (up[0] * c[l] + up[2] * s[l])).abs();
        let outside = [above_zero(bottom - (middle - half)), above_zero(middle + half - top)];
        let z = middle + 0.5 * (outside[0] - outside[1]);
        let normal = [n_r * c[l], n_z, n_r * s[l]];
        let radial = [ring.radius * c[l], ring.height, ring.radius * s[l]];
        let position = inline_from_fn(|i| scene.relative_to_pivot[i] + radial[i]);
        pressure[l] *= match across(position, normal, up, finite.layers[layer].radius) {
            Some(distance) => finite.share(layer, z, dot(normal, up), distance, ring.radius),
            None => 0.0,
        };
    }
}

/// Returns the distance from a point along a unit normal to a cylinder about the axis `up`; `None` outside the
/// cylinder.
fn across(position: SpatialVector, normal: SpatialVector, up: SpatialVector, radius: f64) -> Option<f64> {
    if radius == f64::INFINITY {
        return Some(radius);
    }
    let flat = |v: SpatialVector| {
        let along = dot(v, up);
        inline_from_fn(|i| v[i] - along * up[i])
    };
    let (position, normal) = (flat(position), flat(normal));
    let (a, b, c) = (dot(normal, normal), dot(position, normal), dot(position, position) - radius * radius);
    if c >= 0.0 {
        return None;
    }
    Some(if a > 0.0 { ((b * b - a * c).sqrt() - b) / a } else { f64::INFINITY })
}

/// Adds the resistance on a ring as a sum over its stations.
#[inline(always)]
fn add_by_stations<const FRICTION: bool>(
    ring: &FacetRing,
    around: &RingHarmonics,
    stations: &StationAngles,
    stack: &LayerStack,
    layer: Option<usize>,
    scene: &RingKinematics,
    sum: &mut RingForces,
) {
    let mut pressure_sums = [[0.0; LANES]; 3];
    let mut slope_sums = [[0.0; LANES]; 3];
    let mut friction_sums = [[0.0; LANES]; 7];
    let (first, last) = (stack.planes[0], stack.planes[stack.planes.len() - 1]);
    for block in 0..stations.weight.len() {
        let [slowest, fastest] = stations.range(block, [around.cosine, around.sine]).inline_map(|v| around.mean + v);
        if fastest <= 0.0 {
            continue;
        }
        let mut layer = layer;
        if layer.is_none() {
            let [low, high] = stations.heights(block, ring, around, scene);
            if high <= first || low >= last {
                continue;
            }
            layer = stack.layer_around(low, high);
        }
        let whole = slowest >= scene.onset;
        let loaded = if whole {
            LoadedStations::whole(around, stations, block)
        } else {
            LoadedStations::new(around, stations, block, scene.onset)
        };
        let pressure = pressures(ring, around, stations, block, stack, layer, scene, &loaded);
        let (c, s) = (&stations.middle[0][block], &stations.middle[1][block]);
        for l in 0..LANES {
            pressure_sums[0][l] += pressure[l];
            pressure_sums[1][l] += pressure[l] * c[l];
            pressure_sums[2][l] += pressure[l] * s[l];
        }
        if !whole {
            add_slopes(&loaded, &pressure, [c, s], &mut slope_sums);
        }
        if FRICTION {
            add_friction(ring, scene, [c, s], &loaded.middle, &pressure, &mut friction_sums);
        }
    }
    let total = |lanes: &StationLanes| ring.area * total(lanes);
    add_pressure(
        ring,
        &mut sum.pressure,
        [total(&pressure_sums[0]), total(&pressure_sums[1]), total(&pressure_sums[2])],
    );
    add_damping(ring, scene, [total(&slope_sums[0]), total(&slope_sums[1]), total(&slope_sums[2])], sum);
    if FRICTION {
        let ([f1, f2, f3], (r, h)) =
            ([0, 1, 2].inline_map(|i| scene.friction * total(&friction_sums[i])), (ring.radius, ring.height));
        let [cross, twist, along] = [3, 4, 5].inline_map(|i| scene.friction * r * total(&friction_sums[i]));
        let Wrench { force, moment } = &mut sum.friction;
        *force = [force[0] - f1, force[1] - f2, force[2] - f3];
        *moment = [moment[0] - (h * f3 - cross), moment[1] - twist, moment[2] - (along - h * f1)];
        sum.other_damping += scene.friction * total(&friction_sums[6]) * ring.friction_compliance(&scene.compliance);
    }
}

/// Adds the slope of the pressure over the speed, from the pressure without the regularisation factor, and its products
/// with the cosine and the sine of twice the angle.
#[inline(always)]
fn add_slopes(
    loaded: &LoadedStations,
    pressure: &StationLanes,
    [c, s]: [&StationLanes; 2],
    sums: &mut [StationLanes; 3],
) {
    for l in 0..LANES {
        let share = if loaded.share[l] > NEGLIGIBLE { loaded.share[l] } else { NEGLIGIBLE };
        let slope = loaded.growth[l] * pressure[l] / share;
        sums[0][l] += slope;
        sums[1][l] += slope * (c[l] * c[l] - s[l] * s[l]);
        sums[2][l] += slope * (2.0 * c[l] * s[l]);
    }
}

/// Adds to the sums the friction per area f = p v_t / max(|v_t|, c), with the velocity v_t along the surface and the
/// regularisation speed c; sin f_2, sin f_1 - cos f_3 and cos f_2, from which the moments follow; and p / max(|v_t|,
/// c).
#[inline(always)]
fn add_friction(
    ring: &FacetRing,
    scene: &RingKinematics,
    [c, s]: [&StationLanes; 2],
    into: &StationLanes,
    pressure: &StationLanes,
    sums: &mut [StationLanes; 7],
) {
    let ([n_r, n_z], r, h) = (ring.normal, ring.radius, ring.height);
    let (v, w, onset) = (scene.velocity, scene.turning, scene.onset);
    let (mut t1, mut t2, mut t3) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let mut factor = [0.0; LANES];
    for l in 0..LANES {
        t1[l] = v[0] - w[2] * h + w[1] * r * s[l] - into[l] * n_r * c[l];
        t2[l] = v[1] + r * (w[2] * c[l] - w[0] * s[l]) - into[l] * n_z;
        t3[l] = v[2] + w[0] * h - w[1] * r * c[l] - into[l] * n_r * s[l];
    }
    for l in 0..LANES {
        let slip = (t1[l] * t1[l] + t2[l] * t2[l] + t3[l] * t3[l]).sqrt();
        factor[l] = pressure[l] / if slip > onset { slip } else { onset };
    }
    for l in 0..LANES {
        (t1[l], t2[l], t3[l]) = (factor[l] * t1[l], factor[l] * t2[l], factor[l] * t3[l]);
    }
    let [f1, f2, f3, cross, around, along, grown] = sums;
    for l in 0..LANES {
        f1[l] += t1[l];
        f2[l] += t2[l];
        f3[l] += t3[l];
        grown[l] += factor[l];
    }
    for l in 0..LANES {
        cross[l] += s[l] * t2[l];
        around[l] += s[l] * t1[l] - c[l] * t3[l];
        along[l] += c[l] * t2[l];
    }
}
