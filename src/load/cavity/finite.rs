//! What bounds a target: lateral faces, free surfaces, a crater at its front. All of it as the share of a facet that bears the law
//! of a body without end.
//! Never here: the law itself (`kernel::cavity`), what moves into the target.

use crate::kernel::facet::Facet;
use crate::kernel::free_surface::FiniteSphere;
use crate::kernel::lists::heap_bytes;

/// Bounds of a stack.
#[derive(Clone, Debug)]
pub struct Finite {
    /// Of each layer, ascending in z as the stack has them.
    pub layers: Vec<Bounds>,
    /// Where the front is broken away.
    pub crater: Option<Crater>,
    /// Shear stress at which a plug is sheared out.
    pub shear_strength: Option<f64>,
}

/// Bounds of one layer.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Radius of its lateral face; may be infinite.
    pub radius: f64,
    /// z of the faces below and above it that border on nothing, be they its own or those of layers that it holds together with; may be
    /// infinite.
    pub faces: [f64; 2],
    /// What free surfaces take from it.
    pub decay: Option<FiniteSphere>,
}

/// Over its depth the resistance grows from nothing: the force of the crater phase, F = c z (Forrestal, Altman, Cargile and Hanchak
/// 1994, eq. 1), spread over the nose by the depth of each of its points.
#[derive(Clone, Copy, Debug)]
pub struct Crater {
    /// z of the front.
    pub front: f64,
    /// 1 or -1: the way into the target.
    pub direction: f64,
    /// Its depth.
    pub depth: f64,
}

impl Crater {
    fn share(&self, z: f64) -> f64 {
        (self.direction * (z - self.front) / self.depth).clamp(0.0, 1.0)
    }
}

impl Bounds {
    /// Distance from a height along a unit normal with this part along z to the next free face.
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

impl Finite {
    /// Area of a facet between two planes that would feel in a body without end what it feels in this layer. The factor of a free
    /// surface is that of the middle of the part: its distance to it is measured along the facet's outward normal, the cavity has
    /// the radius of that point.
    #[inline]
    pub fn bearing_area(&self, layer: usize, facet: &Facet, between: [f64; 2]) -> f64 {
        let radius = self.layers[layer].radius;
        let Some(part) = facet.part(between, radius) else { return 0.0 };
        let ([r, z], [n_r, n_z]) = (part.middle, facet.normal);
        let across = if n_r > 0.0 { (radius - r) / n_r } else { f64::INFINITY };
        part.area * self.share(layer, z, n_z, across, r)
    }

    /// Share of the law of a body without end that acts at a height on a surface whose outward normal has this part along z, at this
    /// distance along the normal from the lateral face, where the body has this radius.
    #[inline]
    pub fn share(&self, layer: usize, z: f64, n_z: f64, across: f64, radius: f64) -> f64 {
        let bounds = &self.layers[layer];
        let distance = || bounds.along(z, n_z).min(across.max(0.0));
        let free = bounds.decay.map_or(1.0, |decay| decay.factor(radius, distance()));
        free * self.crater.map_or(1.0, |crater| crater.share(z))
    }

    pub(super) fn bytes(&self) -> usize {
        heap_bytes(&self.layers)
    }
}
