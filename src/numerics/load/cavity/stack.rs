//! Layers of a target that is not meshed, separated by planes of constant z.

use super::finite::StackBounds;
use crate::kernel::cavity::CavityResistance;
use crate::kernel::facet::Facet;
use crate::kernel::lists::Memory;

/// A stack of layers separated by planes of constant z.
#[derive(Clone, Debug, Memory)]
pub struct LayerStack {
    /// z of the planes, ascending; one more than layers. The outermost may be infinite.
    pub planes: Vec<f64>,
    /// Resistance of the layer between plane `i` and plane `i + 1`.
    pub laws: Vec<CavityResistance>,
    /// Number of each layer in the deck, from 1.
    pub numbers: Vec<usize>,
    /// Further bounds of the layers; `None` if they are laterally unbounded and have no free faces.
    pub bounds: Option<StackBounds>,
}

impl LayerStack {
    /// Creates a stack that starts at its impact face; the layers (thickness, resistance) follow each other in a
    /// direction, +1 or -1.
    pub fn new(front: f64, direction: f64, layers: &[(f64, CavityResistance)]) -> Self {
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
        LayerStack { planes, laws, numbers, bounds: None }
    }

    pub fn with_bounds(self, finite: StackBounds) -> Self {
        LayerStack { bounds: Some(finite), ..self }
    }

    /// Returns the shear strength for plugging, if enabled.
    pub(super) fn shear_strength(&self) -> Option<f64> {
        self.bounds.as_ref().and_then(|finite| finite.shear_strength)
    }

    /// Returns the thickness of the thinnest layer; may be infinite.
    pub(super) fn thinnest_layer(&self) -> f64 {
        self.planes.windows(2).map(|p| p[1] - p[0]).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn is_gap(&self, layer: usize) -> bool {
        self.laws[layer] == CavityResistance::NONE
    }

    /// Returns the effective area of a facet in a layer. The facet must not be normal to the axis.
    #[inline]
    pub(super) fn effective_area(&self, layer: usize, facet: &Facet) -> f64 {
        let between = [self.planes[layer], self.planes[layer + 1]];
        match &self.bounds {
            None => facet.area_between(between[0], between[1]),
            Some(finite) => finite.effective_area(layer, facet, between),
        }
    }

    /// Returns the effective area of a facet, displaced by `shift` along z, in a layer of a bounded stack.
    #[inline(never)]
    pub(super) fn area_within_bounds(&self, layer: usize, facet: &Facet, shift: f64) -> f64 {
        self.effective_area(layer, &facet.shifted(shift))
    }

    /// Returns the layer that contains an open interval of z, if any.
    pub(super) fn layer_around(&self, low: f64, high: f64) -> Option<usize> {
        let after = self.planes.iter().position(|&p| p > low)?;
        (after > 0 && high <= self.planes[after]).then(|| after - 1)
    }

    /// Returns the resistance stress at a normal velocity, averaged over the area of a facet; 0 outside the layers.
    pub fn mean_stress(&self, facet: &Facet, speed: f64) -> f64 {
        let (low, high) = (facet.low[1], facet.high[1]);
        if let Some(layer) = self.layer_around(low, high) {
            let bearing = self.bounds.as_ref().map_or(1.0, |_| self.effective_area(layer, facet) / facet.area);
            return bearing * self.laws[layer].stress(speed);
        }
        let part = |(layer, law): (usize, &CavityResistance)| self.effective_area(layer, facet) * law.stress(speed);
        if high > low { self.laws.iter().enumerate().map(part).sum::<f64>() / facet.area } else { 0.0 }
    }

    /// Returns the distance from `z` in direction `sign` to the next plane that is further than `skip`.
    pub(super) fn distance_ahead(&self, z: f64, sign: f64, skip: f64) -> f64 {
        let next = if sign > 0.0 {
            self.planes.iter().find(|&&p| p > z + skip)
        } else {
            self.planes.iter().rev().find(|&&p| p < z - skip)
        };
        next.map_or(f64::INFINITY, |p| (p - z) * sign)
    }

    /// Returns the number of the layer that contains the largest part of a facet's area; 0 outside all layers.
    pub(super) fn number_of(&self, facet: &Facet) -> usize {
        if let Some(layer) = self.layer_around(facet.low[1], facet.high[1]) {
            return self.numbers[layer];
        }
        let parts = self.planes.windows(2).map(|p| facet.area_between(p[0], p[1])).zip(&self.numbers);
        parts.fold((0.0, 0), |most, (area, &number)| if area > most.0 { (area, number) } else { most }).1
    }
}

/// Returns whether the unit normal of a face is parallel to the axis, within rounding. Such a face enters a layer as a
/// whole.
pub(super) fn is_level(normal: [f64; 2]) -> bool {
    normal[0].abs() < 1e-9
}
