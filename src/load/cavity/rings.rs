//! Rings: what facets of a meridian sweep around the axis, cut into stations, as a body that moves and turns in space presses them
//! into a stack of layers whose planes are tilted. All is in the body's frame; loops over stations are plain arithmetic over lanes,
//! so that every instruction set gives the same bits.
//! Never here: where the body is, its motion over time.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::{InlineMap, inline_from_fn};
use std::f64::consts::PI;

use pulp::Arch;

use super::finite::Finite;
use super::stack::Stack;
use crate::kernel::attitude::{Vector, dot};
use crate::kernel::cavity::Resistance;
use crate::kernel::facet::Facet;
use crate::kernel::lists::heap_bytes;
use crate::load::stations::centroid;
use crate::platform::PortableMath as _;
use crate::state::rigid_body_3d::Wrench;

/// Stations side by side: enough that compilers leave loops over them to their vectoriser.
const LANES: usize = 16;
/// A number at each of them.
type Lane = [f64; LANES];

/// One facet swept around the axis.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Radial and axial part of the outward normal.
    normal: [f64; 2],
    /// Radius of the circle on which the centroids of its stations lie, and its height above the centre of mass.
    radius: f64,
    height: f64,
    /// Half the way along the facet, `[r, z]`.
    along: [f64; 2],
    /// height n_r - radius n_z: the lever of pressure about an axis across the body.
    lever: f64,
    area: f64,
}

impl Ring {
    fn new(facet: &Facet, height_of_centre: f64, stations: usize) -> Ring {
        let (low, high, [radius, z]) = (facet.low, facet.high, centroid(facet));
        let height = z - height_of_centre;
        let normal = facet.normal;
        Ring {
            normal,
            radius,
            height,
            along: [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])],
            lever: height * normal[0] - radius * normal[1],
            area: facet.area / stations as f64,
        }
    }
}

/// Cosines and sines of the angles of stations: at their middles and their edges; the last are filled up to whole lanes.
#[derive(Clone, Debug)]
pub struct Stations {
    count: usize,
    middle: [Vec<Lane>; 2],
    edges: [[Vec<Lane>; 2]; 2],
    /// 1, and 0 of what fills up.
    weight: Vec<Lane>,
    /// Half the angle between edges.
    half: f64,
}

impl Stations {
    pub fn new(count: usize) -> Stations {
        let step = 2.0 * PI / count as f64;
        let lanes = |of: &dyn Fn(usize) -> f64| -> Vec<Lane> {
            (0..count.div_ceil(LANES)).map(|i| inline_from_fn(|l| of(i * LANES + l))).collect()
        };
        let around = |shift: f64| {
            let angle = move |k: usize| step * (k as f64 + shift);
            [lanes(&|k| libm::cos(angle(k))), lanes(&|k| libm::sin(angle(k)))]
        };
        Stations {
            count,
            middle: around(0.5),
            edges: [around(0.0), around(1.0)],
            weight: lanes(&|k| f64::from(u8::from(k < count))),
            half: 0.5 * step,
        }
    }

    pub fn bytes(&self) -> usize {
        7 * heap_bytes(&self.weight)
    }
}

/// How a body moves and where the stack lies, in the body's frame.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Velocity of the centre of mass.
    pub velocity: Vector,
    /// Angular velocity.
    pub turning: Vector,
    /// Direction in which heights of the stack grow.
    pub up: Vector,
    /// Height of the centre of mass in the stack.
    pub height: f64,
    /// The way to the centre of mass from a point on the axis of the stack.
    pub beside_pivot: Vector,
    /// Speed over which pressure and friction come up: below it they are in proportion to it.
    pub onset: f64,
    /// Coulomb's coefficient.
    pub friction: f64,
}

/// What rings come to: pressure, friction, and how fast the force grows with speed where it comes up.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    pub pressure: Wrench,
    pub friction: Wrench,
    /// Force a speed.
    pub damping: f64,
}

/// Of a ring, what does not change around it.
#[derive(Clone, Copy)]
struct Around {
    /// Normal velocity v_n = mean + cosine cos + sine sin.
    mean: f64,
    cosine: f64,
    sine: f64,
    /// Height in the stack, likewise.
    height: f64,
    rise: [f64; 2],
}

impl Around {
    fn new(ring: &Ring, scene: &Scene) -> Around {
        let ([n_r, n_z], lever) = (ring.normal, ring.lever);
        let (v, w, up) = (scene.velocity, scene.turning, scene.up);
        Around {
            mean: n_z * v[1],
            cosine: n_r * v[0] - lever * w[2],
            sine: n_r * v[2] + lever * w[0],
            height: scene.height + up[1] * ring.height,
            rise: [ring.radius * up[0], ring.radius * up[2]],
        }
    }

    /// Smallest and largest normal velocity.
    fn speeds(&self) -> [f64; 2] {
        let swing = self.cosine.portable_hypot(self.sine);
        [self.mean - swing, self.mean + swing]
    }

    /// Lowest and highest place of the ring in the stack.
    fn heights(&self, ring: &Ring, scene: &Scene) -> [f64; 2] {
        let up = scene.up;
        let across = up[0].portable_hypot(up[2]);
        let extent = across * (ring.radius + ring.along[0].abs()) + up[1].abs() * ring.along[1].abs();
        [self.height - extent, self.height + extent]
    }
}

/// Facets of one body as rings.
#[derive(Clone, Debug)]
pub struct Rings {
    rings: Vec<Ring>,
    stations: Stations,
    arch: Arch,
}

impl Rings {
    /// Rings of facets, where the mesh has the centre of mass at a height.
    pub fn new<'a>(facets: impl Iterator<Item = &'a Facet>, height_of_centre: f64, stations: usize) -> Rings {
        let rings = facets.map(|f| Ring::new(f, height_of_centre, stations)).collect();
        Rings { rings, stations: Stations::new(stations), arch: Arch::new() }
    }

    /// Lowest and highest place in the stack.
    pub fn heights(&self, scene: &Scene) -> [f64; 2] {
        let all = self.rings.iter().map(|ring| Around::new(ring, scene).heights(ring, scene));
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)])
    }

    /// Resistance on all rings, in the body's frame.
    pub fn resist(&self, stack: &Stack, scene: &Scene) -> Sum {
        self.arch.dispatch(All { rings: self, stack, scene })
    }

    /// Pressure on each station of each ring.
    pub fn show(&self, stack: &Stack, scene: &Scene, mut each: impl FnMut(usize, usize, [f64; 2])) {
        for (index, ring) in self.rings.iter().enumerate() {
            let around = Around::new(ring, scene);
            for block in 0..self.stations.weight.len() {
                let loaded = Loaded::new(&around, &self.stations, block, scene.onset);
                let pressure = if loaded.is_any() {
                    pressures(ring, &around, &self.stations, block, stack, None, scene, &loaded)
                } else {
                    [0.0; LANES]
                };
                let stations = self.stations.count - block * LANES;
                for l in 0..stations.min(LANES) {
                    each(index, block * LANES + l, [pressure[l], loaded.middle[l]]);
                }
            }
        }
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.rings) + self.stations.bytes()
    }
}

/// All rings of a body, compiled for each instruction set.
struct All<'a> {
    rings: &'a Rings,
    stack: &'a Stack,
    scene: &'a Scene,
}

impl pulp::NullaryFnOnce for All<'_> {
    type Output = Sum;

    #[inline(always)]
    fn call(self) -> Sum {
        let All { rings: Rings { rings, stations, .. }, stack, scene } = self;
        let mut sum = Sum::default();
        let (first, last) = (stack.planes[0], stack.planes[stack.planes.len() - 1]);
        for ring in rings {
            let around = Around::new(ring, scene);
            let ([slowest, fastest], [low, high]) = (around.speeds(), around.heights(ring, scene));
            if fastest <= 0.0 || high <= first || low >= last {
                continue;
            }
            let layer = stack.layer_around(low, high);
            match layer {
                Some(layer) if slowest >= scene.onset && scene.friction == 0.0 && stack.finite.is_none() => {
                    closed(ring, &around, &stack.laws[layer], stations.count, &mut sum.pressure);
                }
                _ if scene.friction > 0.0 => {
                    over_stations::<true>(ring, &around, stations, stack, layer, scene, &mut sum)
                }
                _ => over_stations::<false>(ring, &around, stations, stack, layer, scene, &mut sum),
            }
        }
        sum
    }
}

/// A ring that lies in one layer and moves into it all around: means over the circle of p, p cos, p sin are closed.
#[inline(always)]
fn closed(ring: &Ring, around: &Around, law: &Resistance, stations: usize, sum: &mut Wrench) {
    let Around { mean, cosine, sine, .. } = *around;
    let area = ring.area * stations as f64;
    let level = law.c0 + mean * (law.c1 + law.c2 * mean) + 0.5 * law.c2 * (cosine * cosine + sine * sine);
    let slope = 0.5 * law.c1 + law.c2 * mean;
    add(ring, sum, [area * level, area * slope * cosine, area * slope * sine]);
}

/// Adds a pressure of these integrals over the ring: of p, p cos, p sin.
#[inline(always)]
fn add(ring: &Ring, sum: &mut Wrench, [all, cosine, sine]: [f64; 3]) {
    let [n_r, n_z] = ring.normal;
    sum.force[0] -= n_r * cosine;
    sum.force[1] -= n_z * all;
    sum.force[2] -= n_r * sine;
    sum.moment[0] -= ring.lever * sine;
    sum.moment[2] += ring.lever * cosine;
}

/// Where stations move into the material: how much of each, and at which speed.
struct Loaded {
    /// Normal velocity of the middle.
    middle: Lane,
    /// Of the part that moves in.
    speed: Lane,
    /// Mean over the station of the onset of pressure, 0 to 1.
    share: Lane,
    /// How fast that grows with the speed.
    growth: Lane,
}

impl Loaded {
    /// Between its edges the normal velocity of a station is as good as linear in the angle, so that the mean of the onset
    /// min(v/c, 1), 0 below rest, is the difference of its integral over that of the velocity.
    #[inline(always)]
    fn new(around: &Around, stations: &Stations, block: usize, onset: f64) -> Loaded {
        let Around { mean, cosine, sine, .. } = *around;
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
        Loaded { middle, speed, share, growth }
    }

    /// The same of a ring that moves in all around, beyond the onset.
    #[inline(always)]
    fn whole(around: &Around, stations: &Stations, block: usize) -> Loaded {
        let Around { mean, cosine, sine, .. } = *around;
        let [cosines, sines] = [&stations.middle[0][block], &stations.middle[1][block]];
        let mut middle = [0.0; LANES];
        for l in 0..LANES {
            middle[l] = mean + (cosine * cosines[l] + sine * sines[l]);
        }
        Loaded { middle, speed: middle, share: [1.0; LANES], growth: [0.0; LANES] }
    }

    fn is_any(&self) -> bool {
        self.share.iter().any(|&s| s > 0.0)
    }
}

/// Zero of what lies below.
#[inline(always)]
fn above_zero(v: f64) -> f64 {
    if v > 0.0 { v } else { 0.0 }
}

/// Share of the pressure at a normal velocity of at least zero.
#[inline(always)]
fn ramp(v: f64, per_onset: f64) -> f64 {
    let share = v * per_onset;
    if share < 1.0 { share } else { 1.0 }
}

/// Its integral over the normal velocity.
#[inline(always)]
fn integral(v: f64, per_onset: f64, onset: f64) -> f64 {
    let (below, above) = (0.5 * v * v * per_onset, v - 0.5 * onset);
    if v < onset { below } else { above }
}

/// The sum of lanes, in one order.
#[inline(always)]
fn total(lanes: &Lane) -> f64 {
    let mut half = [0.0; LANES / 2];
    for l in 0..LANES / 2 {
        half[l] = lanes[l] + lanes[l + LANES / 2];
    }
    ((half[0] + half[1]) + (half[2] + half[3])) + ((half[4] + half[5]) + (half[6] + half[7]))
}

/// Mean pressure on stations: the law at their normal velocity, times the share of the area that moves in, and that in each layer.
/// What bounds the stack lowers the pressure of a station by the place of its middle.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // A ring, which of its stations, where they lie, and how they move.
fn pressures(
    ring: &Ring,
    around: &Around,
    stations: &Stations,
    block: usize,
    stack: &Stack,
    layer: Option<usize>,
    scene: &Scene,
    loaded: &Loaded,
) -> Lane {
    let weight = &stations.weight[block];
    let mut pressure = [0.0; LANES];
    if let Some(layer) = layer {
        let law = &stack.laws[layer];
        for l in 0..LANES {
            pressure[l] = weight[l] * loaded.share[l] * law.stress(loaded.speed[l]);
        }
        if let Some(finite) = &stack.finite {
            bound(finite, layer, (ring, around), (stations, block), scene, &mut pressure);
        }
        return pressure;
    }
    let place = Extent::new(ring, around, stations, block, scene);
    let mut above = place.share_above(stack.planes[0]);
    for (layer, (law, plane)) in stack.laws.iter().zip(&stack.planes[1..]).enumerate() {
        let beyond = place.share_above(*plane);
        let mut here = [0.0; LANES];
        for l in 0..LANES {
            let inside = weight[l] * loaded.share[l] * (above[l] - beyond[l]);
            here[l] = inside * law.stress(loaded.speed[l]);
        }
        if let Some(finite) = &stack.finite {
            bound(finite, layer, (ring, around), (stations, block), scene, &mut here);
        }
        for l in 0..LANES {
            pressure[l] += here[l];
        }
        above = beyond;
    }
    pressure
}

/// Lowers the pressure on stations in a layer by what bounds it: free faces, whose distance is measured along each station's
/// outward normal, and the crater.
fn bound(
    finite: &Finite,
    layer: usize,
    (ring, around): (&Ring, &Around),
    (stations, block): (&Stations, usize),
    scene: &Scene,
    pressure: &mut Lane,
) {
    let (c, s) = (&stations.middle[0][block], &stations.middle[1][block]);
    let ([n_r, n_z], up) = (ring.normal, scene.up);
    for l in 0..LANES {
        if pressure[l] == 0.0 {
            continue;
        }
        let z = around.height + (around.rise[0] * c[l] + around.rise[1] * s[l]);
        let normal = [n_r * c[l], n_z, n_r * s[l]];
        let radial = [ring.radius * c[l], ring.height, ring.radius * s[l]];
        let place = inline_from_fn(|i| scene.beside_pivot[i] + radial[i]);
        pressure[l] *= match across(place, normal, up, finite.layers[layer].radius) {
            Some(distance) => finite.share(layer, z, dot(normal, up), distance, ring.radius),
            None => 0.0,
        };
    }
}

/// Distance from a place along a unit normal to a cylinder about the axis `up`; `None` outside it.
fn across(place: Vector, normal: Vector, up: Vector, radius: f64) -> Option<f64> {
    if radius == f64::INFINITY {
        return Some(radius);
    }
    let flat = |v: Vector| {
        let along = dot(v, up);
        inline_from_fn(|i| v[i] - along * up[i])
    };
    let (place, normal) = (flat(place), flat(normal));
    let (a, b, c) = (dot(normal, normal), dot(place, normal), dot(place, place) - radius * radius);
    if c >= 0.0 {
        return None;
    }
    Some(if a > 0.0 { ((b * b - a * c).sqrt() - b) / a } else { f64::INFINITY })
}

/// Where stations lie in the stack: heights of their middles, and how far they reach up and down from there along the facet and
/// around the axis.
struct Extent {
    middle: Lane,
    larger: Lane,
    smaller: Lane,
}

impl Extent {
    #[inline(always)]
    fn new(ring: &Ring, around: &Around, stations: &Stations, block: usize, scene: &Scene) -> Extent {
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
        Extent { middle, larger, smaller }
    }

    /// Share of each station that lies above a plane, taken as the parallelogram that touches it in its middle: the height is the
    /// sum of two even distributions, so that the share is a trapezoid's integral, smooth as the plane passes.
    #[inline(always)]
    fn share_above(&self, plane: f64) -> Lane {
        let mut share = [0.0; LANES];
        for l in 0..LANES {
            let (a, b) = (self.larger[l], self.smaller[l]);
            let distance = self.middle[l] - plane;
            let x = distance.abs().min(a + b);
            // Of the middle outwards: half and x/2a, less what the rounded end takes away.
            let beyond = (x - (a - b)).max(0.0);
            let rounded = beyond * beyond / (8.0 * a * b.max(1e-100));
            let half = (0.5 * x / a - rounded).min(0.5);
            share[l] = if distance > 0.0 { 0.5 + half } else { 0.5 - half };
        }
        share
    }
}

/// A ring by its stations.
#[inline(always)]
fn over_stations<const FRICTION: bool>(
    ring: &Ring,
    around: &Around,
    stations: &Stations,
    stack: &Stack,
    layer: Option<usize>,
    scene: &Scene,
    sum: &mut Sum,
) {
    let whole = around.speeds()[0] >= scene.onset;
    let mut pressed = [[0.0; LANES]; 4];
    let mut rubbed = [[0.0; LANES]; 7];
    for block in 0..stations.weight.len() {
        let loaded = if whole {
            Loaded::whole(around, stations, block)
        } else {
            Loaded::new(around, stations, block, scene.onset)
        };
        let pressure = pressures(ring, around, stations, block, stack, layer, scene, &loaded);
        let (c, s) = (&stations.middle[0][block], &stations.middle[1][block]);
        for l in 0..LANES {
            pressed[0][l] += pressure[l];
            pressed[1][l] += pressure[l] * c[l];
            pressed[2][l] += pressure[l] * s[l];
        }
        // Force a speed: the pressure that it will have come up to.
        for l in 0..if whole { 0 } else { LANES } {
            pressed[3][l] +=
                loaded.growth[l] * pressure[l] / if loaded.share[l] > 1e-3 { loaded.share[l] } else { 1e-3 };
        }
        if FRICTION {
            rub(ring, scene, [c, s], &loaded.middle, &pressure, &mut rubbed);
        }
    }
    let total = |lanes: &Lane| ring.area * total(lanes);
    add(ring, &mut sum.pressure, [total(&pressed[0]), total(&pressed[1]), total(&pressed[2])]);
    sum.damping += total(&pressed[3]);
    if FRICTION {
        let ([f1, f2, f3], (r, h)) =
            ([0, 1, 2].inline_map(|i| scene.friction * total(&rubbed[i])), (ring.radius, ring.height));
        let [cross, twist, along] = [3, 4, 5].inline_map(|i| scene.friction * r * total(&rubbed[i]));
        let Wrench { force, moment } = &mut sum.friction;
        *force = [force[0] - f1, force[1] - f2, force[2] - f3];
        *moment = [moment[0] - (h * f3 - cross), moment[1] - twist, moment[2] - (along - h * f1)];
        sum.damping += scene.friction * total(&rubbed[6]);
    }
}

/// Adds f = p v_t / max(|v_t|, c), with v_t the velocity along the surface and c the onset; sin f_2, sin f_1 - cos f_3 and cos f_2, of
/// which moments are made; and p / max(|v_t|, c).
#[inline(always)]
fn rub(ring: &Ring, scene: &Scene, [c, s]: [&Lane; 2], into: &Lane, pressure: &Lane, sums: &mut [Lane; 7]) {
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
