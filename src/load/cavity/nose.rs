//! The resistance on the nose of a rigid body: its shape never changes and every point of it has the same velocity, so that
//! the forces are closed sums wherever one layer holds all loaded facets.
//! Never here: the law itself (`kernel::cavity`), the load as the integrator sees it.

use super::plug::{self, Inwards, plus};
use super::shadow;
use super::stack::{Stack, is_level};
use crate::kernel::cavity::Resistance;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::load::fields::FacetFields;
use crate::load::{Penetration, PenetrationOutcome};
use crate::mesh::surface::Patch;
use crate::state::BodyState;
use crate::state::archive::persist_struct;
use crate::state::limit::Limit;

/// Sums over the facets that face one way, fully in one material: because every point of the body has the same
/// velocity V, v_n = V |n_z| and the force is a polynomial in V (reference: F = pi a^2 (A Y N0 + ...)).
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// sum of A |n_z|^(k+1), k = 0, 1, 2.
    normal: [f64; 3],
    /// sum of A |t_z| |n_z|^k.
    tangential: [f64; 3],
}

impl Sums {
    fn of(facets: &[Facet]) -> Self {
        let mut sums = Sums::default();
        for facet in facets {
            sums.add(facet, facet.area);
        }
        sums
    }

    #[inline]
    fn add(&mut self, facet: &Facet, area: f64) {
        let n = facet.normal[1].abs();
        let t = facet.normal[0].abs();
        let powers = [1.0, n, n * n];
        for (k, power) in powers.iter().enumerate() {
            self.normal[k] += area * n * power;
            self.tangential[k] += area * t * power;
        }
    }

    /// Magnitudes of the axial normal and tangential (for friction 1) forces at speed V.
    #[inline]
    fn forces(&self, law: &Resistance, speed: f64) -> [f64; 2] {
        let sum = |s: &[f64; 3]| law.c0 * s[0] + speed * (law.c1 * s[1] + speed * (law.c2 * s[2]));
        [sum(&self.normal), sum(&self.tangential)]
    }
}

/// The facets that are loaded when the body moves one way.
#[derive(Clone, Debug, Default)]
struct Front {
    facets: Vec<Facet>,
    elements: Vec<usize>,
    /// Facets from the widest inwards, where that matters.
    inwards: Vec<usize>,
    sums: Sums,
    /// z of the lowest and highest point at the start.
    range: [f64; 2],
    /// Of its widest point.
    radius: f64,
    /// z of the level facets: there the force jumps when a plane is met.
    levels: Vec<f64>,
}

impl Front {
    fn new(facets: &[(usize, Facet)], sign: f64) -> Self {
        Front::of(facets.iter().filter(|(_, f)| f.normal[1] * sign > 0.0).copied().collect())
    }

    fn of(chosen: Vec<(usize, Facet)>) -> Self {
        let facets: Vec<Facet> = chosen.iter().map(|c| c.1).collect();
        let low = facets.iter().map(|f| f.low[1]).fold(f64::INFINITY, f64::min);
        let high = facets.iter().map(|f| f.high[1]).fold(f64::NEG_INFINITY, f64::max);
        let mut levels: Vec<f64> = facets.iter().filter(|f| is_level(f.normal)).map(|f| f.low[1]).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        Front {
            sums: Sums::of(&facets),
            elements: chosen.iter().map(|c| c.0).collect(),
            inwards: Vec::new(),
            range: [low, high],
            radius: facets.iter().map(|f| f.low[0].max(f.high[0])).fold(0.0, f64::max),
            facets,
            levels,
        }
    }

    /// What of it meets material that nothing further ahead has pushed aside.
    fn facing(&self, all: &[(usize, Facet)], sign: f64) -> Front {
        let own: Vec<(usize, Facet)> = self.elements.iter().copied().zip(self.facets.iter().copied()).collect();
        Front::of(shadow::facing(&own, all, sign))
    }

    fn sort_inwards(&mut self) {
        let widest = |f: &Facet| f.low[0].max(f.high[0]);
        self.inwards = (0..self.facets.len()).collect();
        self.inwards.sort_by(|&a, &b| widest(&self.facets[b]).total_cmp(&widest(&self.facets[a])));
    }
}

/// The facets of one body under the resistance of a stack.
#[derive(Clone, Debug)]
pub(super) struct Nose {
    pub(super) body: usize,
    /// Facets loaded in motion towards smaller and larger z.
    fronts: [Front; 2],
    /// Elements of facets that no axial motion loads.
    idle: Vec<usize>,
    /// Fraction of the nose's height that an increment may travel while a plane cuts the nose.
    travel: f64,
    /// Distances below this are rounding.
    rounding: f64,
    /// The layer that last held all loaded facets.
    last_layer: usize,
}

impl Nose {
    /// The nose of a body. `travel` is the fraction of the loaded facets' height that one increment may move while a plane of
    /// the stack cuts them.
    pub(super) fn new(patch: &Patch, stack: &Stack, travel: f64) -> Self {
        let facets = &patch.facets;
        let largest = |values: &mut dyn Iterator<Item = f64>| {
            values.filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()))
        };
        let extent = largest(&mut facets.iter().flat_map(|(_, f)| [f.low[1], f.high[1], f.low[0], f.high[0]]));
        let rounding = 1e-12 * extent.max(largest(&mut stack.planes.iter().copied()));
        let idle = facets.iter().filter(|(_, f)| f.normal[1] == 0.0).map(|f| f.0).collect();
        let mut fronts = [Front::new(facets, -1.0), Front::new(facets, 1.0)];
        if stack.shear_strength().is_some() {
            fronts.iter_mut().for_each(Front::sort_inwards);
        }
        Nose { body: patch.body, fronts, idle, travel, rounding, last_layer: 0 }
    }

    /// From now on nothing acts inside the tunnel that the body has opened further ahead.
    pub(super) fn separate(&mut self) {
        let of_front = |front: &Front| -> Vec<(usize, Facet)> {
            front.elements.iter().copied().zip(front.facets.iter().copied()).collect()
        };
        let all: Vec<(usize, Facet)> = self.fronts.iter().flat_map(of_front).collect();
        for (front, sign) in self.fronts.iter_mut().zip([-1.0, 1.0]) {
            let facing = front.facing(&all, sign);
            let hidden = front.elements.iter().filter(|element| !facing.elements.contains(element));
            self.idle.extend(hidden);
            let sorted = !front.inwards.is_empty();
            *front = facing;
            if sorted {
                front.sort_inwards();
            }
        }
    }

    /// Axial forces of pressure and of friction with coefficient 1, against the motion; `None` where none is finite.
    #[inline]
    pub(super) fn resist(&mut self, stack: &Stack, body: &BodyState) -> Option<[f64; 2]> {
        let direction = body.direction;
        if direction == 0.0 || self.front(direction).facets.is_empty() {
            return Some([0.0; 2]);
        }
        let [normal, tangential] = self.forces(stack, body.displacement, direction, body.velocity_load.abs());
        normal.is_finite().then_some([-direction * normal, -direction * tangential])
    }

    /// How far the next increment may go.
    pub(super) fn limit(&self, stack: &Stack, body: &BodyState) -> Limit {
        let (velocity, acceleration) = (body.velocity, body.acceleration);
        let direction = if velocity == 0.0 { acceleration } else { velocity };
        if direction == 0.0 || self.front(direction).facets.is_empty() {
            return Limit::NONE;
        }
        let sign = direction.signum();
        let (distance, jump) = self.reach(stack, body.displacement, sign);
        Limit { time: time_to_travel(distance, velocity.abs(), acceleration * sign), jump }
    }

    /// Whether the body still moves in the stack, or has left it at the side that it moves to.
    pub(super) fn penetration(&self, stack: &Stack, body: &BodyState) -> Option<Penetration> {
        let direction = body.velocity.signum();
        if body.velocity == 0.0 || body.prescribed || self.front(direction).facets.is_empty() {
            return None;
        }
        let [low, high] = self.front(direction).range.inline_map(|z| z + body.displacement);
        let (first, last) = (stack.planes[0], stack.planes[stack.planes.len() - 1]);
        let through = if direction > 0.0 { low >= last } else { high <= first };
        let inside = high > first && low < last;
        let outcome =
            if through { Some(PenetrationOutcome::Through) } else { inside.then_some(PenetrationOutcome::Moving) };
        outcome.map(|outcome| Penetration { body: self.body, outcome, in_space: None })
    }

    pub(super) fn show(&self, stack: &Stack, body: &BodyState, fields: &mut FacetFields) {
        let (velocity, shift) = (body.velocity, body.displacement);
        for (front, direction) in self.fronts.iter().zip([-1.0, 1.0]) {
            let loaded = velocity * direction > 0.0;
            let start = fields.elements.len();
            let shown = front.elements.iter().zip(&front.facets);
            shown.for_each(|(e, f)| fields.push(*e, 0.0, f.normal[1] * velocity));
            let mut largest = vec![0.0; front.facets.len()];
            self.parts(stack, front, shift, direction, |index, layer, area| {
                let facet = &front.facets[index];
                if area > largest[index] {
                    largest[index] = area;
                    fields.layer[start + index] = stack.numbers[layer] as f64;
                }
                if loaded {
                    let stress = stack.laws[layer].stress((velocity * facet.normal[1]).abs());
                    fields.pressure[start + index] += stress * area / facet.area;
                }
            });
        }
        self.idle.iter().for_each(|e| fields.push(*e, 0.0, 0.0));
    }

    pub(super) fn bytes(&self) -> usize {
        let front = |f: &Front| {
            heap_bytes(&f.facets)
                + size_of::<usize>() * (f.elements.capacity() + f.inwards.capacity())
                + heap_bytes(&f.levels)
        };
        self.fronts.iter().map(front).sum::<usize>() + heap_bytes(&self.idle)
    }

    fn front(&self, direction: f64) -> &Front {
        &self.fronts[usize::from(direction > 0.0)]
    }

    /// Calls `each(facet index, layer, area)` for the part of every facet in every layer.
    fn parts(&self, stack: &Stack, front: &Front, shift: f64, direction: f64, mut each: impl FnMut(usize, usize, f64)) {
        for (index, facet) in front.facets.iter().enumerate() {
            self.parts_of(stack, facet, shift, direction, |layer, area| each(index, layer, area));
        }
    }

    /// Calls `each(layer, area)` for the part of a facet in every layer, as far as it bears the law there.
    #[inline]
    fn parts_of(&self, stack: &Stack, facet: &Facet, shift: f64, direction: f64, mut each: impl FnMut(usize, f64)) {
        let planes = &stack.planes;
        let (low, high) = (facet.low[1] + shift, facet.high[1] + shift);
        let bounded = stack.finite.is_some();
        let bearing = |layer: usize| stack.bearing_area(layer, &facet.shifted(shift));
        if is_level(facet.normal) {
            let ahead = low + direction * self.rounding;
            if let Some(layer) = stack.layer_around(ahead, ahead) {
                each(layer, if bounded { bearing(layer) } else { facet.area });
            }
            return;
        }
        let first = planes.partition_point(|&p| p <= low).max(1);
        for layer in first - 1..stack.laws.len() {
            if planes[layer] >= high {
                break;
            }
            let whole = || facet.area_between(planes[layer] - shift, planes[layer + 1] - shift);
            each(layer, if bounded { bearing(layer) } else { whole() });
        }
    }

    /// The layer that holds all loaded facets, if one does; looks first where they were last.
    #[inline]
    fn layer_of_all(&mut self, stack: &Stack, low: f64, high: f64) -> Option<usize> {
        let planes = &stack.planes[self.last_layer..self.last_layer + 2];
        if planes[0] <= low && high <= planes[1] {
            return Some(self.last_layer);
        }
        let layer = stack.layer_around(low, high)?;
        self.last_layer = layer;
        Some(layer)
    }

    /// Axial normal and tangential force magnitudes at speed V in a direction.
    #[inline]
    fn forces(&mut self, stack: &Stack, shift: f64, direction: f64, speed: f64) -> [f64; 2] {
        let offset = shift + direction * self.rounding;
        let [low, high] = self.front(direction).range.inline_map(|z| z + offset);
        if stack.finite.is_none()
            && let Some(layer) = self.layer_of_all(stack, low, high)
        {
            return self.front(direction).sums.forces(&stack.laws[layer], speed);
        }
        if Nose::outside(stack, low, high) {
            return [0.0; 2];
        }
        self.forces_of_parts(stack, shift, direction, speed)
    }

    fn forces_of_parts(&self, stack: &Stack, shift: f64, direction: f64, speed: f64) -> [f64; 2] {
        let front = self.front(direction);
        if let Some(shear_strength) = stack.shear_strength() {
            let nose = Inwards { facets: &front.facets, order: &front.inwards, shift, direction };
            return plug::least_forces(stack, shear_strength, nose, |facet, plate| {
                let mut sum = [0.0; 2];
                self.parts_of(stack, facet, shift, direction, |layer, area| {
                    if plate.contains(&layer) {
                        sum = plus(sum, force(facet, &stack.laws[layer], area, speed));
                    }
                });
                sum
            });
        }
        let mut total = [0.0; 2];
        self.parts(stack, front, shift, direction, |index, layer, area| {
            total = plus(total, force(&front.facets[index], &stack.laws[layer], area, speed));
        });
        total
    }

    fn outside(stack: &Stack, low: f64, high: f64) -> bool {
        let planes = &stack.planes;
        high < planes[0] || low > planes[planes.len() - 1]
    }

    /// How far the body may travel, and whether the force jumps there.
    fn reach(&self, stack: &Stack, shift: f64, direction: f64) -> (f64, bool) {
        let front = self.front(direction);
        let [low, high] = [front.range[0] + shift, front.range[1] + shift];
        let (leading, trailing) = if direction > 0.0 { (high, low) } else { (low, high) };
        let gap = stack.distance_ahead(trailing, direction, self.rounding);
        let extent = high - low;
        let cut = gap < extent;
        // With bounds the force changes all the way, not only where a plane cuts the nose, and by lengths as the nose is wide.
        let inside = stack.finite.is_some() && !Nose::outside(stack, low, high);
        let ahead = if cut || inside { 0.0 } else { stack.distance_ahead(leading, direction, self.rounding) };
        let smooth = ahead + self.travel * if inside { extent.max(front.radius) } else { extent };
        let jump = front
            .levels
            .iter()
            .map(|z| stack.distance_ahead(z + shift, direction, self.rounding))
            .fold(f64::INFINITY, f64::min);
        if jump <= smooth { (jump, true) } else { (smooth, false) }
    }
}

/// Axial normal and tangential force on an area of a facet at speed V.
#[inline]
fn force(facet: &Facet, law: &Resistance, area: f64, speed: f64) -> [f64; 2] {
    let n = facet.normal[1].abs();
    let force = area * law.stress(speed * n);
    [force * n, force * facet.normal[0].abs()]
}

/// Time to cover a distance at speed v with acceleration a along the motion; infinite if the body stops before.
fn time_to_travel(distance: f64, speed: f64, acceleration: f64) -> f64 {
    let discriminant = speed * speed + 2.0 * acceleration * distance;
    if !distance.is_finite() || discriminant < 0.0 {
        return f64::INFINITY;
    }
    2.0 * distance / (speed + discriminant.sqrt())
}

persist_struct!(Nose { last_layer } derived { body, fronts, idle, travel, rounding });
