//! Rings: the surfaces that the facets of a meridian form around the axis, divided into stations, and the resistance of
//! a stack of inclined layers on them. All vectors are in the body frame. Loops over stations are plain arithmetic over
//! lanes, so that every instruction set gives the same bits.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::{InlineMap, inline_from_fn};
use std::f64::consts::PI;

use pulp::Arch;

use super::finite::StackBounds;
use super::stack::LayerStack;
use crate::kernel::attitude::{SpatialVector, dot};
use crate::kernel::cavity::CavityResistance;
use crate::kernel::facet::Facet;
use crate::kernel::lists::Memory;
use crate::load::stations::centroid;
use crate::platform::PortableMath as _;
use crate::state::rigid_body_3d::Wrench;

/// Number of stations per array, large enough that compilers vectorise loops over them.
const LANES: usize = 16;
/// Values of one quantity at a block of stations.
type StationLanes = [f64; LANES];

/// Surface of revolution of one facet.
#[derive(Clone, Copy, Debug)]
pub struct FacetRing {
    /// Radial and axial component of the outward normal.
    normal: [f64; 2],
    /// Radius of the circle through the centroids of the stations, and its height above the centre of mass.
    radius: f64,
    height: f64,
    /// Half the vector along the facet, `[r, z]`.
    along: [f64; 2],
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
}

/// Cosines and sines of the angles of stations, at their midpoints and edges, padded to whole arrays.
#[derive(Clone, Debug, Memory)]
pub struct StationAngles {
    count: usize,
    middle: [Vec<StationLanes>; 2],
    edges: [[Vec<StationLanes>; 2]; 2],
    /// 1 for stations, 0 for padding.
    weight: Vec<StationLanes>,
    /// Half the angle of a station.
    half: f64,
}

impl StationAngles {
    pub fn new(count: usize) -> StationAngles {
        let step = 2.0 * PI / count as f64;
        let lanes = |of: &dyn Fn(usize) -> f64| -> Vec<StationLanes> {
            (0..count.div_ceil(LANES)).map(|i| inline_from_fn(|l| of(i * LANES + l))).collect()
        };
        let around = |shift: f64| {
            let angle = move |k: usize| step * (k as f64 + shift);
            [lanes(&|k| libm::cos(angle(k))), lanes(&|k| libm::sin(angle(k)))]
        };
        StationAngles {
            count,
            middle: around(0.5),
            edges: [around(0.0), around(1.0)],
            weight: lanes(&|k| f64::from(u8::from(k < count))),
            half: 0.5 * step,
        }
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
}

/// Forces and moments on rings, and their slope over the speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct RingForces {
    pub pressure: Wrench,
    pub friction: Wrench,
    /// Slope of the force over the speed in the regularised range.
    pub damping: f64,
}

/// Normal velocity and height of a ring as Fourier series in the angle: mean, cosine and sine terms.
#[derive(Clone, Copy)]
struct RingHarmonics {
    /// Normal velocity v_n = mean + cosine cos + sine sin.
    mean: f64,
    cosine: f64,
    sine: f64,
    /// Height in the stack: `height + rise[0] cos + rise[1] sin`.
    height: f64,
    rise: [f64; 2],
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

    /// Returns the smallest and largest normal velocity.
    fn speeds(&self) -> [f64; 2] {
        let swing = self.cosine.portable_hypot(self.sine);
        [self.mean - swing, self.mean + swing]
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
        for ring in rings {
            let around = RingHarmonics::new(ring, scene);
            let ([slowest, fastest], [low, high]) = (around.speeds(), around.heights(ring, scene));
            if fastest <= 0.0 || high <= first || low >= last {
                continue;
            }
            let layer = stack.layer_around(low, high);
            match layer {
                Some(layer) if slowest >= scene.onset && scene.friction == 0.0 && stack.bounds.is_none() => {
                    add_closed_form(ring, &around, &stack.laws[layer], stations.count, &mut sum.pressure);
                }
                _ if scene.friction > 0.0 => {
                    add_by_stations::<true>(ring, &around, stations, stack, layer, scene, &mut sum)
                }
                _ => add_by_stations::<false>(ring, &around, stations, stack, layer, scene, &mut sum),
            }
        }
        sum
    }
}

/// Adds the resistance on a ring that is inside one layer and moves into it along its whole circumference. The means of
/// p, p cos and p sin over the circle have closed forms. Equation (13.5).
#[inline(always)]
fn add_closed_form(
    ring: &FacetRing,
    around: &RingHarmonics,
    law: &CavityResistance,
    stations: usize,
    sum: &mut Wrench,
) {
    let RingHarmonics { mean, cosine, sine, .. } = *around;
    let area = ring.area * stations as f64;
    let level = law.c0 + mean * (law.c1 + law.c2 * mean) + 0.5 * law.c2 * (cosine * cosine + sine * sine);
    let slope = 0.5 * law.c1 + law.c2 * mean;
    add_pressure(ring, sum, [area * level, area * slope * cosine, area * slope * sine]);
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

/// The part of each station that moves into the material, and its speed.
struct LoadedStations {
    /// Normal velocity at the midpoint.
    middle: StationLanes,
    /// Normal velocity of the part that moves into the material.
    speed: StationLanes,
    /// Mean over the station of the regularisation factor of the pressure, 0 to 1.
    share: StationLanes,
    /// Derivative of that factor with respect to the speed.
    growth: StationLanes,
}

impl LoadedStations {
    /// Evaluates a block of stations with regularisation. The normal velocity of a station is nearly linear in the
    /// angle. The mean of the regularisation factor min(v/c, 1), 0 for v < 0, is therefore the difference of its
    /// integral at the edges over the difference of the velocities.
    #[inline(always)]
    fn new(around: &RingHarmonics, stations: &StationAngles, block: usize, onset: f64) -> LoadedStations {
        let RingHarmonics { mean, cosine, sine, .. } = *around;
        let [cosines, sines] = [&stations.middle[0][block], &stations.middle[1][block]];
        let [first_cosines, first_sines] = [&stations.edges[0][0][block], &stations.edges[0][1][block]];
        let [second_cosines, second_sines] = [&stations.edges[1][0][block], &stations.edges[1][1][block]];
        let (mut middle, mut speed, mut share, mut growth) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let (per, small) = (1.0 / onset, 1e-3 * onset);
        for l in 0..LANES {
            let v = mean + (cosine * cosines[l] + sine * sines[l]);
            let first = mean + (cosine * first_cosines[l] + sine * first_sines[l]);
            let second = mean + (cosine * second_cosines[l] + sine * second_sines[l]);
            let (a, b, m) = (above_zero(first), above_zero(second), above_zero(v));
            let difference = second - first;
            let even = difference.abs() < small;
            let over = 1.0 / if even { 1.0 } else { difference };
            let mean_of_line = (integral(b, per, onset) - integral(a, per, onset)) * over;
            share[l] = if even { ramp(m, per) } else { mean_of_line };
            let inside = if m > 0.0 { if m < onset { per } else { 0.0 } } else { 0.0 };
            growth[l] = if even { inside } else { (ramp(b, per) - ramp(a, per)) * over };
            let crossed = 0.5 * (a + b);
            speed[l] = if first.min(second) > 0.0 { m } else { crossed };
            middle[l] = v;
        }
        LoadedStations { middle, speed, share, growth }
    }

    /// Evaluates a block like [`LoadedStations::new`] for a ring that moves into the material everywhere at more than the
    /// regularisation speed.
    #[inline(always)]
    fn whole(around: &RingHarmonics, stations: &StationAngles, block: usize) -> LoadedStations {
        let RingHarmonics { mean, cosine, sine, .. } = *around;
        let [cosines, sines] = [&stations.middle[0][block], &stations.middle[1][block]];
        let mut middle = [0.0; LANES];
        for l in 0..LANES {
            middle[l] = mean + (cosine * cosines[l] + sine * sines[l]);
        }
        LoadedStations { middle, speed: middle, share: [1.0; LANES], growth: [0.0; LANES] }
    }

    fn is_any(&self) -> bool {
        self.share.iter().any(|&s| s > 0.0)
    }
}

/// Returns the positive part.
#[inline(always)]
fn above_zero(v: f64) -> f64 {
    if v > 0.0 { v } else { 0.0 }
}

/// Returns the regularisation factor at a normal velocity of at least zero. Equation (13.6).
#[inline(always)]
fn ramp(v: f64, per_onset: f64) -> f64 {
    let share = v * per_onset;
    if share < 1.0 { share } else { 1.0 }
}

/// Returns the integral of [`ramp`] over the normal velocity.
#[inline(always)]
fn integral(v: f64, per_onset: f64, onset: f64) -> f64 {
    let (below, above) = (0.5 * v * v * per_onset, v - 0.5 * onset);
    if v < onset { below } else { above }
}

/// Returns the sum of lanes in a fixed order.
#[inline(always)]
fn total(lanes: &StationLanes) -> f64 {
    let mut half = [0.0; LANES / 2];
    for l in 0..LANES / 2 {
        half[l] = lanes[l] + lanes[l + LANES / 2];
    }
    ((half[0] + half[1]) + (half[2] + half[3])) + ((half[4] + half[5]) + (half[6] + half[7]))
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

/// Extent of stations in the stack: heights of their midpoints, and half extents along the facet and around the axis.
struct StationExtent {
    middle: StationLanes,
    larger: StationLanes,
    smaller: StationLanes,
}

impl StationExtent {
    #[inline(always)]
    fn new(
        ring: &FacetRing,
        around: &RingHarmonics,
        stations: &StationAngles,
        block: usize,
        scene: &RingKinematics,
    ) -> StationExtent {
        let ([cosines, sines], up) = (&stations.middle, scene.up);
        let (c, s) = (&cosines[block], &sines[block]);
        let (mut middle, mut larger, mut smaller) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let least = 1e-9 * (ring.radius + ring.along[0].abs() + ring.along[1].abs());
        for l in 0..LANES {
            middle[l] = around.height + (around.rise[0] * c[l] + around.rise[1] * s[l]);
            let along = (ring.along[1] * up[1] + ring.along[0] * (up[0] * c[l] + up[2] * s[l])).abs();
            let across = stations.half * (around.rise[1] * c[l] - around.rise[0] * s[l]).abs();
            larger[l] = along.max(across).max(least);
            smaller[l] = along.min(across);
        }
        StationExtent { middle, larger, smaller }
    }

    /// Returns the part of each station above a plane. A station is approximated by the parallelogram that is tangent
    /// at its midpoint: its height is the sum of two uniform distributions, so the result is the integral of a
    /// trapezoid, which is smooth in the position of the plane.
    #[inline(always)]
    fn share_above(&self, plane: f64) -> StationLanes {
        let mut share = [0.0; LANES];
        for l in 0..LANES {
            let (a, b) = (self.larger[l], self.smaller[l]);
            let distance = self.middle[l] - plane;
            let x = distance.abs().min(a + b);
            // From the midpoint outwards: 1/2 + x/2a minus the contribution of the rounded end.
            let beyond = (x - (a - b)).max(0.0);
            let rounded = beyond * beyond / (8.0 * a * b.max(1e-100));
            let half = (0.5 * x / a - rounded).min(0.5);
            share[l] = if distance > 0.0 { 0.5 + half } else { 0.5 - half };
        }
        share
    }
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
    let whole = around.speeds()[0] >= scene.onset;
    let mut pressure_sums = [[0.0; LANES]; 4];
    let mut friction_sums = [[0.0; LANES]; 7];
    for block in 0..stations.weight.len() {
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
        // Slope of the force over the speed, from the pressure without the regularisation factor.
        for l in 0..if whole { 0 } else { LANES } {
            pressure_sums[3][l] +=
                loaded.growth[l] * pressure[l] / if loaded.share[l] > 1e-3 { loaded.share[l] } else { 1e-3 };
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
    sum.damping += total(&pressure_sums[3]);
    if FRICTION {
        let ([f1, f2, f3], (r, h)) =
            ([0, 1, 2].inline_map(|i| scene.friction * total(&friction_sums[i])), (ring.radius, ring.height));
        let [cross, twist, along] = [3, 4, 5].inline_map(|i| scene.friction * r * total(&friction_sums[i]));
        let Wrench { force, moment } = &mut sum.friction;
        *force = [force[0] - f1, force[1] - f2, force[2] - f3];
        *moment = [moment[0] - (h * f3 - cross), moment[1] - twist, moment[2] - (along - h * f1)];
        sum.damping += scene.friction * total(&friction_sums[6]);
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
