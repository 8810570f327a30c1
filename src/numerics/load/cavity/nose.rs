//! Resistance on the nose of a rigid body that moves along z. Its shape is constant and all points have the same
//! velocity, so the forces are closed sums over the facets inside a layer; only facets cut by a plane are evaluated singly.

use super::plug::{self, PluggingNose, plus};
use super::profile::{FacetSums, NoseProfile, force_on};
use super::shadow;
use super::stack::{LayerStack, is_level};
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::load::fields::FacetFields;
use crate::load::{PenetrationOutcome, PenetrationRecord};
use crate::mesh::surface::RigidFacets;
use crate::state::BodyState;
use crate::state::archive::Persist;
use crate::state::limit::IncrementLimit;

/// Facets that are loaded in one direction of motion.
#[derive(Clone, Debug, Default, Memory)]
struct NoseFront {
    facets: Vec<Facet>,
    elements: Vec<usize>,
    /// Indices of the facets in descending order of radius; only with plugging.
    inwards: Vec<usize>,
    sums: FacetSums,
    /// The facets in order along z; `None` if they overlap along z.
    profile: Option<NoseProfile>,
    /// Initial z of the lowest and highest point.
    range: [f64; 2],
    /// Largest radius of the nose, length.
    radius: f64,
    /// Initial z of the facets normal to the axis: the force jumps when such a facet reaches a plane.
    levels: Vec<f64>,
}

impl NoseFront {
    fn new(facets: &[(usize, Facet)], sign: f64) -> Self {
        let mut chosen = Vec::with_capacity(facets.len());
        chosen.extend(facets.iter().filter(|(_, f)| f.normal[1] * sign > 0.0));
        NoseFront::of(chosen)
    }

    fn of(chosen: Vec<(usize, Facet)>) -> Self {
        let facets: Vec<Facet> = chosen.iter().map(|c| c.1).collect();
        let low = facets.iter().map(|f| f.low[1]).fold(f64::INFINITY, f64::min);
        let high = facets.iter().map(|f| f.high[1]).fold(f64::NEG_INFINITY, f64::max);
        let mut levels: Vec<f64> = facets.iter().filter(|f| is_level(f.normal)).map(|f| f.low[1]).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        NoseFront {
            sums: FacetSums::of(&facets),
            profile: NoseProfile::of(&facets),
            elements: chosen.iter().map(|c| c.0).collect(),
            inwards: Vec::new(),
            range: [low, high],
            radius: facets.iter().map(|f| f.low[0].max(f.high[0])).fold(0.0, f64::max),
            facets,
            levels,
        }
    }

    /// Returns the parts that are not in the shadow of facets further ahead.
    fn exposed_part(&self, all: &[(usize, Facet)], sign: f64) -> NoseFront {
        let numbered_facets: Vec<(usize, Facet)> =
            self.elements.iter().copied().zip(self.facets.iter().copied()).collect();
        NoseFront::of(shadow::exposed_parts(&numbered_facets, all, sign))
    }

    fn sort_inwards(&mut self) {
        let widest = |f: &Facet| f.low[0].max(f.high[0]);
        self.inwards = (0..self.facets.len()).collect();
        self.inwards.sort_by(|&a, &b| widest(&self.facets[b]).total_cmp(&widest(&self.facets[a])));
    }
}

/// Facets of one body in a stack of layers.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(derived: body, fronts, idle, travel, rounding)]
pub(super) struct NoseResistance {
    pub(super) body: usize,
    /// Facets loaded in motion along -z and +z.
    fronts: [NoseFront; 2],
    /// Elements of facets that axial motion never loads.
    idle: Vec<usize>,
    /// Fraction of the nose height that the body may travel in one increment while a plane intersects the nose.
    travel: f64,
    /// Tolerance of distances for rounding errors.
    rounding: f64,
    /// The layer that contained all loaded facets at the last evaluation.
    last_layer: usize,
}

impl NoseResistance {
    /// Creates the nose of a body. `travel` is the fraction of the height of the loaded facets that the body may travel
    /// in one increment while a plane of the stack intersects them.
    pub(super) fn new(patch: &RigidFacets, stack: &LayerStack, travel: f64) -> Self {
        let facets = &patch.facets;
        let largest = |values: &mut dyn Iterator<Item = f64>| {
            values.filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()))
        };
        let extent = largest(&mut facets.iter().flat_map(|(_, f)| [f.low[1], f.high[1], f.low[0], f.high[0]]));
        let rounding = 1e-12 * extent.max(largest(&mut stack.planes.iter().copied()));
        let idle = facets.iter().filter(|(_, f)| f.normal[1] == 0.0).map(|f| f.0).collect();
        let mut fronts = [NoseFront::new(facets, -1.0), NoseFront::new(facets, 1.0)];
        if stack.shear_strength().is_some() {
            fronts.iter_mut().for_each(NoseFront::sort_inwards);
        }
        NoseResistance { body: patch.body, fronts, idle, travel, rounding, last_layer: 0 }
    }

    /// Ignores facets inside the tunnel that the body has opened further ahead.
    pub(super) fn ignore_opened_tunnel(&mut self) {
        let of_front = |front: &NoseFront| -> Vec<(usize, Facet)> {
            front.elements.iter().copied().zip(front.facets.iter().copied()).collect()
        };
        let numbered_facets: Vec<(usize, Facet)> = self.fronts.iter().flat_map(of_front).collect();
        for (front, sign) in self.fronts.iter_mut().zip([-1.0, 1.0]) {
            let facing = front.exposed_part(&numbered_facets, sign);
            let hidden = front.elements.iter().filter(|element| !facing.elements.contains(element));
            self.idle.extend(hidden);
            let sorted = !front.inwards.is_empty();
            *front = facing;
            if sorted {
                front.sort_inwards();
            }
        }
    }

    /// Returns the axial forces of pressure and of friction with coefficient 1, against the motion; `None` if they are
    /// not finite.
    #[inline]
    pub(super) fn resist(&mut self, stack: &LayerStack, body: &BodyState) -> Option<[f64; 2]> {
        let direction = body.direction;
        if direction == 0.0 || self.front(direction).facets.is_empty() {
            return Some([0.0; 2]);
        }
        let [normal, tangential] = self.forces(stack, body.displacement, direction, body.velocity_load.abs());
        normal.is_finite().then_some([-direction * normal, -direction * tangential])
    }

    /// Returns the limit on the next time increment.
    pub(super) fn limit(&self, stack: &LayerStack, body: &BodyState) -> IncrementLimit {
        let (velocity, acceleration) = (body.velocity, body.acceleration);
        let direction = if velocity == 0.0 { acceleration } else { velocity };
        if direction == 0.0 || self.front(direction).facets.is_empty() {
            return IncrementLimit::NONE;
        }
        let sign = direction.signum();
        let (distance, jump) = self.distance_to_change(stack, body.displacement, sign);
        IncrementLimit { time: time_to_travel(distance, velocity.abs(), acceleration * sign), jump }
    }

    /// Returns the outcome of a body without prescribed motion. Only the far side of the stack counts as perforation: a
    /// body in front of the stack has not met the stack, or other forces have moved the body back.
    pub(super) fn penetration(&self, stack: &LayerStack, body: &BodyState) -> Option<PenetrationRecord> {
        let [low, high] = self.facing_range(body.velocity)?;
        let side = |shift: f64| {
            let below = high + shift <= stack.planes[0];
            let above = low + shift >= stack.planes[stack.planes.len() - 1];
            i32::from(above) - i32::from(below)
        };
        let outcome = match side(body.displacement) {
            0 if body.velocity == 0.0 => PenetrationOutcome::AtRest,
            0 => PenetrationOutcome::Moving,
            now if now == side(0.0) => PenetrationOutcome::NotMet,
            _ => PenetrationOutcome::Through,
        };
        (!body.prescribed).then_some(PenetrationRecord { body: self.body, outcome, in_space: None })
    }

    /// Returns the initial z of the lowest and highest point of the facets that face the motion, or of all facets if the
    /// body is at rest or has no such facets.
    fn facing_range(&self, velocity: f64) -> Option<[f64; 2]> {
        let ahead = (velocity != 0.0).then(|| self.front(velocity.signum())).filter(|f| !f.facets.is_empty());
        let ranges = self.fronts.iter().filter(|f| !f.facets.is_empty()).map(|f| f.range);
        ahead.map(|f| f.range).or_else(|| ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]))
    }

    pub(super) fn show(&self, stack: &LayerStack, body: &BodyState, fields: &mut FacetFields) {
        let (velocity, shift) = (body.velocity, body.displacement);
        for (front, direction) in self.fronts.iter().zip([-1.0, 1.0]) {
            let loaded = velocity * direction > 0.0;
            let start = fields.elements.len();
            let numbered_facets = front.elements.iter().zip(&front.facets);
            numbered_facets.for_each(|(e, f)| fields.push(*e, 0.0, f.normal[1] * velocity));
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

    /// Returns the facets that are loaded in a direction of motion.
    pub(super) fn facets(&self, direction: f64) -> &[Facet] {
        &self.front(direction).facets
    }

    /// Returns these facets in order along z; `None` if they overlap along z.
    pub(super) fn profile(&self, direction: f64) -> Option<&NoseProfile> {
        self.front(direction).profile.as_ref()
    }

    /// Returns the tolerance of distances for rounding errors.
    pub(super) fn rounding(&self) -> f64 {
        self.rounding
    }

    fn front(&self, direction: f64) -> &NoseFront {
        &self.fronts[usize::from(direction > 0.0)]
    }

    /// Calls `each(facet index, layer, area)` for the part of every facet in every layer.
    fn parts(
        &self,
        stack: &LayerStack,
        front: &NoseFront,
        shift: f64,
        direction: f64,
        mut each: impl FnMut(usize, usize, f64),
    ) {
        for (index, facet) in front.facets.iter().enumerate() {
            self.parts_of(stack, facet, shift, direction, |layer, area| each(index, layer, area));
        }
    }

    /// Calls `each(layer, area)` for the effective area of a facet in every layer.
    #[inline]
    fn parts_of(
        &self,
        stack: &LayerStack,
        facet: &Facet,
        shift: f64,
        direction: f64,
        mut each: impl FnMut(usize, f64),
    ) {
        let (low, high) = (facet.low[1] + shift, facet.high[1] + shift);
        let bounded = stack.bounds.is_some();
        let bearing = |layer: usize| stack.area_within_bounds(layer, facet, shift);
        if is_level(facet.normal) {
            let ahead = low + direction * self.rounding;
            if let Some(layer) = stack.layer_around(ahead, ahead) {
                each(layer, if bounded { bearing(layer) } else { facet.area });
            }
            return;
        }
        if NoseResistance::outside(stack, low, high) {
            return;
        }
        for (layer, planes) in stack.planes.windows(2).enumerate() {
            let (from, end) = (planes[0], planes[1]);
            if low < end && from < high {
                each(layer, if bounded { bearing(layer) } else { facet.area_between(from - shift, end - shift) });
            }
        }
    }

    /// Returns the layer that contains all loaded facets, if any; the layer of the last evaluation is tried first.
    #[inline]
    fn layer_of_all(&mut self, stack: &LayerStack, low: f64, high: f64) -> Option<usize> {
        let planes = &stack.planes[self.last_layer..self.last_layer + 2];
        if planes[0] <= low && high <= planes[1] {
            return Some(self.last_layer);
        }
        let layer = stack.layer_around(low, high)?;
        self.last_layer = layer;
        Some(layer)
    }

    /// Returns the magnitudes of the axial normal and tangential forces at speed V in a direction.
    #[inline]
    fn forces(&mut self, stack: &LayerStack, shift: f64, direction: f64, speed: f64) -> [f64; 2] {
        let offset = shift + direction * self.rounding;
        let [low, high] = self.front(direction).range.inline_map(|z| z + offset);
        if stack.bounds.is_none()
            && let Some(layer) = self.layer_of_all(stack, low, high)
        {
            return self.front(direction).sums.forces(&stack.laws[layer], speed);
        }
        if NoseResistance::outside(stack, low, high) {
            return [0.0; 2];
        }
        self.forces_of_parts(stack, shift, direction, speed)
    }

    fn forces_of_parts(&self, stack: &LayerStack, shift: f64, direction: f64, speed: f64) -> [f64; 2] {
        let front = self.front(direction);
        if let Some(shear_strength) = stack.shear_strength() {
            let nose = PluggingNose { facets: &front.facets, order: &front.inwards, shift, direction };
            return plug::least_forces(stack, shear_strength, nose, |facet, plate| {
                let mut sum = [0.0; 2];
                self.parts_of(stack, facet, shift, direction, |layer, area| {
                    if plate.contains(&layer) {
                        sum = plus(sum, force_on(facet, &stack.laws[layer], area, speed));
                    }
                });
                sum
            });
        }
        if let (Some(profile), None) = (&front.profile, &stack.bounds) {
            return profile.forces(stack, [shift, shift + direction * self.rounding], speed);
        }
        let mut total = [0.0; 2];
        self.parts(stack, front, shift, direction, |index, layer, area| {
            total = plus(total, force_on(&front.facets[index], &stack.laws[layer], area, speed));
        });
        total
    }

    fn outside(stack: &LayerStack, low: f64, high: f64) -> bool {
        let planes = &stack.planes;
        high < planes[0] || low > planes[planes.len() - 1]
    }

    /// Returns the distance that the body may travel in the next increment, and whether the force jumps there.
    fn distance_to_change(&self, stack: &LayerStack, shift: f64, direction: f64) -> (f64, bool) {
        let front = self.front(direction);
        let [low, high] = [front.range[0] + shift, front.range[1] + shift];
        let (leading, trailing) = if direction > 0.0 { (high, low) } else { (low, high) };
        let gap = stack.distance_ahead(trailing, direction, self.rounding);
        let extent = high - low;
        let cut = gap < extent;
        // In a bounded stack the force changes everywhere, over lengths of the order of the nose radius, not only where
        // a plane intersects the nose.
        let inside = stack.bounds.is_some() && !NoseResistance::outside(stack, low, high);
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

/// Returns the time to cover a distance at initial speed v and acceleration a along the motion; infinite if the body
/// stops earlier.
fn time_to_travel(distance: f64, speed: f64, acceleration: f64) -> f64 {
    let discriminant = speed * speed + 2.0 * acceleration * distance;
    if !distance.is_finite() || discriminant < 0.0 {
        return f64::INFINITY;
    }
    2.0 * distance / (speed + discriminant.sqrt())
}
