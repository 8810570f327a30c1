//! Resistance of a target that is not meshed (`CAVITY`): dynamic cavity expansion in layers, with Coulomb friction.
//! Facets are clipped by area at the target's faces and between layers; only those that move into the material are loaded.
//! Never here: the law itself (`kernel::cavity`), deck words.

use crate::kernel::cavity::Resistance;
use crate::kernel::facet::Facet;
use crate::load::Account;
use crate::load::FacetFields;
use crate::load::Force;
use crate::load::Slot;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::{BodyState, Instant};

/// A stack of layers between planes of constant z.
#[derive(Clone, Debug)]
pub struct Stack {
    /// z of the planes, ascending: one more than there are layers; the outermost may be infinite.
    pub planes: Vec<f64>,
    /// Law of the layer between plane `i` and plane `i + 1`.
    pub laws: Vec<Resistance>,
    /// Number of each layer, from 1, as the deck counts them.
    pub numbers: Vec<usize>,
}

impl Stack {
    /// A stack from its impact face on, in the direction (+1 or -1) in which the layers follow each other.
    pub fn new(front: f64, direction: f64, layers: &[(f64, Resistance)]) -> Self {
        let mut planes = vec![front];
        for (thickness, _) in layers {
            planes.push(planes[planes.len() - 1] + direction * thickness);
        }
        let mut laws: Vec<_> = layers.iter().map(|l| l.1).collect();
        let mut numbers: Vec<_> = (1..=layers.len()).collect();
        if direction < 0.0 {
            planes.reverse();
            laws.reverse();
            numbers.reverse();
        }
        Stack { planes, laws, numbers }
    }

    /// The layer that holds the whole open interval, if one does.
    fn layer_around(&self, low: f64, high: f64) -> Option<usize> {
        let after = self.planes.partition_point(|&p| p <= low);
        (after > 0 && after < self.planes.len() && high <= self.planes[after]).then(|| after - 1)
    }

    /// Stress at a normal velocity, averaged over the area of a facet; nothing outside the layers.
    pub fn mean_stress(&self, facet: &Facet, speed: f64) -> f64 {
        let (low, high) = (facet.low[1], facet.high[1]);
        if let Some(layer) = self.layer_around(low, high) {
            return self.laws[layer].stress(speed);
        }
        let between = self.planes.windows(2).zip(&self.laws);
        let part = |(planes, law): (&[f64], &Resistance)| facet.area_between(planes[0], planes[1]) * law.stress(speed);
        if high > low { between.map(part).sum::<f64>() / facet.area } else { 0.0 }
    }

    /// Distance ahead of `z` in direction `sign` to the next plane, further than `skip`.
    fn distance_ahead(&self, z: f64, sign: f64, skip: f64) -> f64 {
        let next = if sign > 0.0 {
            self.planes.get(self.planes.partition_point(|&p| p <= z + skip))
        } else {
            self.planes.partition_point(|&p| p < z - skip).checked_sub(1).map(|i| &self.planes[i])
        };
        next.map_or(f64::INFINITY, |p| (p - z) * sign)
    }
}

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
    sums: Sums,
    /// z of the lowest and highest point at the start.
    range: [f64; 2],
    /// z of the level facets: there the force jumps when a plane is met.
    levels: Vec<f64>,
}

impl Front {
    fn new(facets: &[(usize, Facet)], sign: f64) -> Self {
        let chosen: Vec<_> = facets.iter().filter(|(_, f)| f.normal[1] * sign > 0.0).copied().collect();
        let facets: Vec<Facet> = chosen.iter().map(|c| c.1).collect();
        let low = facets.iter().map(|f| f.low[1]).fold(f64::INFINITY, f64::min);
        let high = facets.iter().map(|f| f.high[1]).fold(f64::NEG_INFINITY, f64::max);
        let mut levels: Vec<f64> = facets.iter().filter(|f| is_level(f)).map(|f| f.low[1]).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        Front {
            sums: Sums::of(&facets),
            elements: chosen.iter().map(|c| c.0).collect(),
            facets,
            range: [low, high],
            levels,
        }
    }
}

/// Level up to rounding: such a facet enters a layer as a whole.
fn is_level(facet: &Facet) -> bool {
    facet.normal[0].abs() < 1e-9
}

/// The resistance of one stack on the facets of one body.
#[derive(Debug)]
pub struct CavityExpansion {
    cause: EffectId,
    body: usize,
    friction: f64,
    stack: Stack,
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

impl CavityExpansion {
    /// The resistance of `stack` on facets (with element index) of a body. `travel` is the fraction of the loaded
    /// facets' height that one increment may move while a plane of the stack cuts them.
    pub fn new(
        cause: EffectId,
        body: usize,
        friction: f64,
        stack: Stack,
        facets: &[(usize, Facet)],
        travel: f64,
    ) -> Self {
        let largest = |values: &mut dyn Iterator<Item = f64>| {
            values.filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()))
        };
        let extent = largest(&mut facets.iter().flat_map(|(_, f)| [f.low[1], f.high[1], f.low[0], f.high[0]]));
        let rounding = 1e-12 * extent.max(largest(&mut stack.planes.iter().copied()));
        let idle = facets.iter().filter(|(_, f)| f.normal[1] == 0.0).map(|f| f.0).collect();
        let fronts = [Front::new(facets, -1.0), Front::new(facets, 1.0)];
        CavityExpansion { cause, body, friction, stack, fronts, idle, travel, rounding, last_layer: 0 }
    }

    fn front(&self, direction: f64) -> &Front {
        &self.fronts[usize::from(direction > 0.0)]
    }

    /// Calls `each(facet index, layer, area)` for the part of every facet in every layer.
    fn parts(&self, front: &Front, shift: f64, direction: f64, mut each: impl FnMut(usize, usize, f64)) {
        let planes = &self.stack.planes;
        for (index, facet) in front.facets.iter().enumerate() {
            let (low, high) = (facet.low[1] + shift, facet.high[1] + shift);
            if is_level(facet) {
                let ahead = low + direction * self.rounding;
                if let Some(layer) = self.stack.layer_around(ahead, ahead) {
                    each(index, layer, facet.area);
                }
                continue;
            }
            let first = planes.partition_point(|&p| p <= low).max(1);
            for layer in first - 1..self.stack.laws.len() {
                if planes[layer] >= high {
                    break;
                }
                let area = facet.area_between(planes[layer] - shift, planes[layer + 1] - shift);
                each(index, layer, area);
            }
        }
    }

    /// The layer that holds all loaded facets, if one does; looks first where they were last.
    #[inline]
    fn layer_of_all(&mut self, low: f64, high: f64) -> Option<usize> {
        let planes = &self.stack.planes[self.last_layer..self.last_layer + 2];
        if planes[0] <= low && high <= planes[1] {
            return Some(self.last_layer);
        }
        let layer = self.stack.layer_around(low, high)?;
        self.last_layer = layer;
        Some(layer)
    }

    /// Axial normal and tangential force magnitudes at speed V in a direction.
    #[inline]
    fn forces(&mut self, shift: f64, direction: f64, speed: f64) -> [f64; 2] {
        let offset = shift + direction * self.rounding;
        let [low, high] = self.front(direction).range.map(|z| z + offset);
        if let Some(layer) = self.layer_of_all(low, high) {
            return self.front(direction).sums.forces(&self.stack.laws[layer], speed);
        }
        if self.outside(low, high) {
            return [0.0; 2];
        }
        self.forces_of_parts(shift, direction, speed)
    }

    fn forces_of_parts(&self, shift: f64, direction: f64, speed: f64) -> [f64; 2] {
        let front = self.front(direction);
        let mut total = [0.0; 2];
        self.parts(front, shift, direction, |index, layer, area| {
            let facet = &front.facets[index];
            let n = facet.normal[1].abs();
            let force = area * self.stack.laws[layer].stress(speed * n);
            total[0] += force * n;
            total[1] += force * facet.normal[0].abs();
        });
        total
    }

    fn outside(&self, low: f64, high: f64) -> bool {
        let planes = &self.stack.planes;
        high < planes[0] || low > planes[planes.len() - 1]
    }

    /// How far the body may travel, and whether the force jumps there.
    fn reach(&self, shift: f64, direction: f64) -> (f64, bool) {
        let front = self.front(direction);
        let [low, high] = [front.range[0] + shift, front.range[1] + shift];
        let (leading, trailing) = if direction > 0.0 { (high, low) } else { (low, high) };
        let gap = self.stack.distance_ahead(trailing, direction, self.rounding);
        let extent = high - low;
        let cut = gap < extent;
        let ahead = if cut { 0.0 } else { self.stack.distance_ahead(leading, direction, self.rounding) };
        let smooth = ahead + self.travel * extent;
        let jump = front
            .levels
            .iter()
            .map(|z| self.stack.distance_ahead(z + shift, direction, self.rounding))
            .fold(f64::INFINITY, f64::min);
        if jump <= smooth { (jump, true) } else { (smooth, false) }
    }
}

/// Time to cover a distance at speed v with acceleration a along the motion; infinite if the body stops before.
fn time_to_travel(distance: f64, speed: f64, acceleration: f64) -> f64 {
    let discriminant = speed * speed + 2.0 * acceleration * distance;
    if !distance.is_finite() || discriminant < 0.0 {
        return f64::INFINITY;
    }
    2.0 * distance / (speed + discriminant.sqrt())
}

impl Force for CavityExpansion {
    fn cause(&self) -> EffectId {
        self.cause
    }

    fn slots(&self) -> Vec<Slot> {
        let mut slots = vec![Slot { body: self.body, account: Account::Cavity }];
        if self.friction > 0.0 {
            slots.push(Slot { body: self.body, account: Account::Friction });
        }
        slots
    }

    fn evaluate(&mut self, now: &Instant, bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt> {
        let direction = bodies[self.body].direction;
        if direction == 0.0 || self.front(direction).facets.is_empty() {
            out.fill(0.0);
            return Ok(());
        }
        let speed = bodies[self.body].velocity_load.abs();
        let [normal, tangential] = self.forces(bodies[self.body].displacement, direction, speed);
        if !normal.is_finite() {
            let reason = format!("the resistance is not finite at time {:e}, speed {speed:e}", now.total_time);
            return Err(Halt { code: "R202", reason });
        }
        out[0] = -direction * normal;
        if let Some(friction) = out.get_mut(1) {
            *friction = -direction * self.friction * tangential;
        }
        Ok(())
    }

    fn limit(&self, _now: &Instant, bodies: &[BodyState]) -> Limit {
        let (velocity, acceleration) = (bodies[self.body].velocity, bodies[self.body].acceleration);
        let direction = if velocity == 0.0 { acceleration } else { velocity };
        if direction == 0.0 || self.front(direction).facets.is_empty() {
            return Limit::NONE;
        }
        let sign = direction.signum();
        let (distance, jump) = self.reach(bodies[self.body].displacement, sign);
        Limit { time: time_to_travel(distance, velocity.abs(), acceleration * sign), jump }
    }

    fn resists(&self) -> bool {
        true
    }

    fn reads_velocity(&self) -> bool {
        true
    }

    fn facet_fields(&self, bodies: &[BodyState]) -> Option<FacetFields> {
        let (velocity, shift) = (bodies[self.body].velocity, bodies[self.body].displacement);
        let mut fields = FacetFields::default();
        for (front, direction) in self.fronts.iter().zip([-1.0, 1.0]) {
            let loaded = velocity * direction > 0.0;
            let start = fields.elements.len();
            fields.elements.extend(&front.elements);
            fields.pressure.resize(fields.elements.len(), 0.0);
            fields.layer.resize(fields.elements.len(), 0.0);
            fields.normal_velocity.extend(front.facets.iter().map(|f| f.normal[1] * velocity));
            let mut largest = vec![0.0; front.facets.len()];
            self.parts(front, shift, direction, |index, layer, area| {
                let facet = &front.facets[index];
                if area > largest[index] {
                    largest[index] = area;
                    fields.layer[start + index] = self.stack.numbers[layer] as f64;
                }
                if loaded {
                    let stress = self.stack.laws[layer].stress((velocity * facet.normal[1]).abs());
                    fields.pressure[start + index] += stress * area / facet.area;
                }
            });
        }
        fields.elements.extend(&self.idle);
        for array in [&mut fields.pressure, &mut fields.normal_velocity, &mut fields.layer] {
            array.resize(fields.elements.len(), 0.0);
        }
        Some(fields)
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let facets = self.fronts.iter().map(|f| size_of_val(&f.facets[..])).sum();
        let stack = size_of_val(&self.stack.planes[..]) + size_of_val(&self.stack.laws[..]);
        vec![("facets", facets), ("layers", stack)]
    }
}

impl Persist for CavityExpansion {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let CavityExpansion {
            cause: _,
            body: _,
            friction: _,
            stack: _,
            fronts: _,
            idle: _,
            travel: _,
            rounding: _,
            last_layer,
        } = self;
        last_layer.persist(archive);
    }
}
