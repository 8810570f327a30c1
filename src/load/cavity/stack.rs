//! Layers of a target that is not meshed, between planes of constant z.
//! Never here: what moves into them.

use super::finite::Finite;
use crate::kernel::cavity::Resistance;
use crate::kernel::facet::Facet;
use crate::kernel::lists::heap_bytes;

/// A stack of layers between planes of constant z.
#[derive(Clone, Debug)]
pub struct Stack {
    /// z of the planes, ascending: one more than there are layers; the outermost may be infinite.
    pub planes: Vec<f64>,
    /// Law of the layer between plane `i` and plane `i + 1`.
    pub laws: Vec<Resistance>,
    /// Number of each layer, from 1, as the deck counts them.
    pub numbers: Vec<usize>,
    /// What bounds it beside the planes.
    pub finite: Option<Finite>,
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
        Stack { planes, laws, numbers, finite: None }
    }

    pub fn within(self, finite: Finite) -> Self {
        Stack { finite: Some(finite), ..self }
    }

    /// Shear stress at which a plug is sheared out of a plate.
    pub(super) fn shear_strength(&self) -> Option<f64> {
        self.finite.as_ref().and_then(|finite| finite.shear_strength)
    }

    pub(super) fn is_gap(&self, layer: usize) -> bool {
        self.laws[layer] == Resistance::NONE
    }

    /// Area of a facet that is not level between the planes of a layer, as far as it bears the law of the layer.
    #[inline]
    pub(super) fn bearing_area(&self, layer: usize, facet: &Facet) -> f64 {
        let between = [self.planes[layer], self.planes[layer + 1]];
        match &self.finite {
            None => facet.area_between(between[0], between[1]),
            Some(finite) => finite.bearing_area(layer, facet, between),
        }
    }

    /// The layer that holds the whole open interval, if one does.
    pub(super) fn layer_around(&self, low: f64, high: f64) -> Option<usize> {
        let after = self.planes.partition_point(|&p| p <= low);
        (after > 0 && after < self.planes.len() && high <= self.planes[after]).then(|| after - 1)
    }

    /// Stress at a normal velocity, averaged over the area of a facet; nothing outside the layers.
    pub fn mean_stress(&self, facet: &Facet, speed: f64) -> f64 {
        let (low, high) = (facet.low[1], facet.high[1]);
        if let Some(layer) = self.layer_around(low, high) {
            let bearing = self.finite.as_ref().map_or(1.0, |_| self.bearing_area(layer, facet) / facet.area);
            return bearing * self.laws[layer].stress(speed);
        }
        let part = |(layer, law): (usize, &Resistance)| self.bearing_area(layer, facet) * law.stress(speed);
        if high > low { self.laws.iter().enumerate().map(part).sum::<f64>() / facet.area } else { 0.0 }
    }

    /// Distance ahead of `z` in direction `sign` to the next plane, further than `skip`.
    pub(super) fn distance_ahead(&self, z: f64, sign: f64, skip: f64) -> f64 {
        let next = if sign > 0.0 {
            self.planes.get(self.planes.partition_point(|&p| p <= z + skip))
        } else {
            self.planes.partition_point(|&p| p < z - skip).checked_sub(1).map(|i| &self.planes[i])
        };
        next.map_or(f64::INFINITY, |p| (p - z) * sign)
    }

    /// Number of the layer that takes the largest part of a facet's area; 0 outside any.
    pub(super) fn number_of(&self, facet: &Facet) -> usize {
        if let Some(layer) = self.layer_around(facet.low[1], facet.high[1]) {
            return self.numbers[layer];
        }
        let parts = self.planes.windows(2).map(|p| facet.area_between(p[0], p[1])).zip(&self.numbers);
        parts.fold((0.0, 0), |most, (area, &number)| if area > most.0 { (area, number) } else { most }).1
    }

    pub(super) fn bytes(&self) -> usize {
        heap_bytes(&self.planes)
            + heap_bytes(&self.laws)
            + heap_bytes(&self.numbers)
            + self.finite.as_ref().map_or(0, Finite::bytes)
    }
}

/// Whether a face of this unit normal is level up to rounding: such a one enters a layer as a whole.
pub(super) fn is_level(normal: [f64; 2]) -> bool {
    normal[0].abs() < 1e-9
}
