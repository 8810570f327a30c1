//! Stages of a rigid body on its way through layers: between the events at which an end of a facet reaches a plane, the
//! factors of the force are quadratic polynomials of the distance, because the part of a frustum up to a plane is.

use super::nose::NoseResistance;
use super::profile::{FacetSums, NoseProfile};
use super::stack::{LayerStack, is_level};
use crate::kernel::cavity::CavityResistance;
use crate::kernel::facet::Facet;
use crate::kernel::lanes::InlineMap;
use crate::kernel::shot_stages::ForceStage;

/// Numbers of a resistance on which the force depends linearly, or their derivatives by a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ResistanceConstants {
    /// Resistance of each layer, ascending along z.
    pub laws: Vec<CavityResistance>,
    /// Coulomb coefficient.
    pub friction: f64,
}

/// Resistance of a stack of laterally unbounded layers on a rigid body that moves along z.
#[derive(Clone, Copy)]
pub struct AxialResistance<'a> {
    pub(super) nose: &'a NoseResistance,
    pub(super) stack: &'a LayerStack,
    pub(super) friction: f64,
}

impl AxialResistance<'_> {
    /// Returns the index of the rigid body.
    pub fn body(&self) -> usize {
        self.nose.body
    }

    /// Returns the Coulomb coefficient.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Returns the laws and the friction.
    pub fn constants(&self) -> ResistanceConstants {
        ResistanceConstants { laws: self.stack.laws.clone(), friction: self.friction }
    }

    /// Returns the planes between the layers, ascending along z.
    pub fn planes(&self) -> &[f64] {
        &self.stack.planes
    }

    /// Returns whether no term of the resistance can push the body.
    pub fn only_resists(&self) -> bool {
        let resists = |law: &CavityResistance| [law.c0, law.c1, law.c2].iter().all(|c| *c >= 0.0 && c.is_finite());
        self.friction >= 0.0 && self.stack.laws.iter().all(resists)
    }

    /// Adds the distances after which an end of a facet reaches a plane.
    fn add_events(&self, direction: f64, events: &mut Vec<f64>) {
        for facet in self.nose.facets(direction) {
            for plane in self.stack.planes.iter().filter(|plane| plane.is_finite()) {
                events.extend([facet.low, facet.high].inline_map(|end| direction * (plane - end[1])));
            }
        }
    }

    /// Adds the force between two events to `force`.
    fn add_to(&self, force: &mut StageForce) {
        let (facets, profile) = (self.nose.facets(force.direction), self.nose.profile(force.direction));
        let [_, middle, _] = force.shifts;
        for facet in profile.map_or(facets, NoseProfile::level).iter().filter(|facet| is_level(facet.normal)) {
            let z = facet.low[1] + middle;
            if let Some(layer) = self.stack.layer_around(z, z) {
                force.add_whole(FacetSums::of(&[*facet]).factors(&self.stack.laws[layer], self.friction));
            }
        }
        for (planes, law) in self.stack.planes.windows(2).zip(&self.stack.laws) {
            let (from, to) = (planes[0] - middle, planes[1] - middle);
            let mut cut = |facet: &Facet| {
                force.add_cut(|shift| {
                    let mut sums = FacetSums::default();
                    sums.add(facet, facet.area_between(planes[0] - shift, planes[1] - shift));
                    sums.factors(law, self.friction)
                });
            };
            let whole = match profile {
                Some(profile) => profile.whole_between(from, to, &mut cut).unwrap_or_default(),
                None => whole_between(facets, from, to, &mut cut),
            };
            force.add_whole(whole.factors(law, self.friction));
        }
    }
}

/// Returns the sums of the facets between two planes, as [`NoseProfile::whole_between`], for facets that overlap along z.
fn whole_between(facets: &[Facet], from: f64, to: f64, cut: &mut impl FnMut(&Facet)) -> FacetSums {
    let mut sums = FacetSums::default();
    for facet in facets.iter().filter(|facet| !is_level(facet.normal)) {
        let [low, high] = [facet.low[1], facet.high[1]];
        if from <= low && high <= to {
            sums.add(facet, facet.area);
        } else if low < to && from < high {
            cut(facet);
        }
    }
    sums
}

/// Force between two events.
struct StageForce {
    /// Direction of the motion, +1 or -1.
    direction: f64,
    /// Displacements at the start, in the middle and at the end.
    shifts: [f64; 3],
    /// Factors of V⁰, V¹ and V² there.
    factors: [[f64; 3]; 3],
    is_constant: bool,
}

impl StageForce {
    /// Adds the factors of facets that are inside a layer over the whole stage.
    fn add_whole(&mut self, factors: [f64; 3]) {
        self.factors.iter_mut().for_each(|sums| (0..3).for_each(|k| sums[k] += factors[k]));
    }

    /// Adds the factors of a facet that a plane cuts, as a function of the displacement.
    fn add_cut(&mut self, factors: impl Fn(f64) -> [f64; 3]) {
        self.is_constant = false;
        for (sums, shift) in self.factors.iter_mut().zip(self.shifts) {
            let more = factors(shift);
            (0..3).for_each(|k| sums[k] += more[k]);
        }
    }

    /// Returns the factors of ξ⁰, ξ¹ and ξ² of each factor.
    fn polynomials(&self) -> [[f64; 3]; 3] {
        let [first, middle, last] = &self.factors;
        [0, 1, 2].inline_map(|k| {
            if self.is_constant {
                return [middle[k], 0.0, 0.0];
            }
            let curvature = 2.0 * (first[k] - 2.0 * middle[k] + last[k]);
            [first[k], last[k] - first[k] - curvature, curvature]
        })
    }
}

/// Returns the stages of a body that moves from its initial position in a direction, +1 or -1, along z. The last one has
/// infinite length. Equation (2.18).
pub fn force_stages(resistances: &[AxialResistance<'_>], direction: f64) -> Vec<ForceStage> {
    let rounding = resistances.iter().map(|resistance| resistance.nose.rounding()).fold(0.0, f64::max);
    let mut events = vec![0.0];
    resistances.iter().for_each(|resistance| resistance.add_events(direction, &mut events));
    events.retain(|distance| *distance >= 0.0);
    events.sort_by(f64::total_cmp);
    events.dedup_by(|next, previous| *next - *previous <= rounding);
    let ends = events.iter().skip(1).copied().chain([f64::INFINITY]);
    events.iter().zip(ends).map(|(start, end)| stage_between(resistances, direction, [*start, end])).collect()
}

/// Returns the derivatives of the forces of [`force_stages`] by a parameter; the lengths of the stages do not depend on it.
/// `slopes` are the derivatives of the constants of each resistance. The force is linear in the laws for a given friction,
/// and linear in the friction. Equation (2.18).
pub fn force_stage_slopes(
    resistances: &[AxialResistance<'_>],
    slopes: &[ResistanceConstants],
    direction: f64,
) -> Vec<ForceStage> {
    let with_laws = |resistance: &AxialResistance<'_>, laws: Vec<CavityResistance>| LayerStack {
        planes: resistance.stack.planes.clone(),
        laws,
        numbers: resistance.stack.numbers.clone(),
        bounds: None,
    };
    let mut stacks = Vec::new();
    for (resistance, slope) in resistances.iter().zip(slopes) {
        stacks.push((resistance.nose, with_laws(resistance, slope.laws.clone()), resistance.friction));
        // The difference between friction coefficients of 1 and 0.
        for (factor, friction) in [(slope.friction, 1.0), (-slope.friction, 0.0)] {
            if factor != 0.0 {
                let scaled = resistance.stack.laws.iter().map(|law| law.scaled(factor)).collect();
                stacks.push((resistance.nose, with_laws(resistance, scaled), friction));
            }
        }
    }
    let terms: Vec<AxialResistance<'_>> =
        stacks.iter().map(|(nose, stack, friction)| AxialResistance { nose, stack, friction: *friction }).collect();
    force_stages(&terms, direction)
}

/// Returns the stage between two events. Equation (2.18).
fn stage_between(resistances: &[AxialResistance<'_>], direction: f64, [start, end]: [f64; 2]) -> ForceStage {
    let length = end - start;
    let span = if length.is_finite() { length } else { 1.0 };
    let shifts = [0.0, 0.5, 1.0].inline_map(|part| direction * (start + part * span));
    let mut force = StageForce { direction, shifts, factors: [[0.0; 3]; 3], is_constant: true };
    resistances.iter().for_each(|resistance| resistance.add_to(&mut force));
    ForceStage { length, force: force.polynomials() }
}
