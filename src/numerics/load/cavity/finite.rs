//! Finite targets: lateral faces, free surfaces and a crater at the front reduce the resistance of an unbounded target.
//! The reduction is expressed as a factor or as an effective area of a facet.

use crate::kernel::facet::Facet;
use crate::kernel::free_surface::FiniteSphere;
use crate::kernel::lists::Memory;

/// Free surfaces of a stack of layers, and the effects of finite thickness that are requested for it.
#[derive(Clone, Debug, Memory)]
pub struct StackBounds {
    /// Bounds of each layer, ascending in z as in the stack.
    pub layers: Vec<LayerBounds>,
    /// Region of reduced resistance at the front face.
    pub crater: Option<EntryCrater>,
    /// Shear strength for plugging; `None` without plugging.
    pub shear_strength: Option<f64>,
}

/// Free surfaces of one layer and the reduction of the resistance near them.
#[derive(Clone, Copy, Debug)]
pub struct LayerBounds {
    /// Radius of the lateral face; may be infinite.
    pub radius: f64,
    /// z of the next free faces below and above, which belong to this layer or to a layer bonded to it; may be
    /// infinite.
    pub faces: [f64; 2],
    /// Reduction of the resistance near free surfaces.
    pub decay: Option<FiniteSphere>,
}

/// Crater phase: the resistance grows linearly from zero over the depth of the crater, F = c z (Forrestal, Altman,
/// Cargile and Hanchak 1994, eq. 1), applied to each point of the nose at its own depth.
#[derive(Clone, Copy, Debug)]
pub struct EntryCrater {
    /// z of the front face.
    pub front: f64,
    /// Direction into the target along z, 1 or -1.
    pub direction: f64,
    /// Depth of the crater.
    pub depth: f64,
}

impl EntryCrater {
    /// Equation (3.2).
    fn share(&self, z: f64) -> f64 {
        (self.direction * (z - self.front) / self.depth).clamp(0.0, 1.0)
    }
}

impl LayerBounds {
    /// Returns the distance from height `z` to the next free face along a unit normal with z component `n_z`.
    #[inline]
    fn along(&self, z: f64, n_z: f64) -> f64 {
        let [low, high] = self.faces;
        let distance = if n_z < 0.0 {
            (low - z) / n_z
        } else if n_z > 0.0 {
            (high - z) / n_z
        } else {
            f64::INFINITY
        };
        distance.max(0.0)
    }
}

impl StackBounds {
    /// Returns the area of a facet between two planes that, in an unbounded layer, would have the same resistance. The
    /// factor of the free surfaces is evaluated at the midpoint of the part: the distance is measured along the outward
    /// normal, and the cavity radius is the radius of that point.
    #[inline]
    pub fn effective_area(&self, layer: usize, facet: &Facet, between: [f64; 2]) -> f64 {
        let radius = self.layers[layer].radius;
        let Some(part) = facet.part(between, radius) else { return 0.0 };
        let ([r, z], [n_r, n_z]) = (part.middle, facet.normal);
        let across = if n_r > 0.0 { (radius - r) / n_r } else { f64::INFINITY };
        part.area * self.share(layer, z, n_z, across, r)
    }

    /// Returns the factor on the resistance of an unbounded layer at height `z`. `n_z` is the z component of the
    /// outward normal, `across` the distance along the normal to the lateral face, `radius` the radius of the body.
    #[inline]
    pub fn share(&self, layer: usize, z: f64, n_z: f64, across: f64, radius: f64) -> f64 {
        let bounds = &self.layers[layer];
        let distance = || bounds.along(z, n_z).min(across.max(0.0));
        let free = bounds.decay.map_or(1.0, |decay| decay.factor(radius, distance()));
        free * self.crater.map_or(1.0, |crater| crater.share(z))
    }
}
