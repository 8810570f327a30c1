//! Measures of a mesh: element quality with positions, and volumes compared with the exact profile.

use super::mesh::{FreeSide, MeshPart, ProjectileMesh, SurfacePart};
use super::profile::{MeridianPoint, ProfilePiece};
use super::quality::{aspect, height, least_scaled_jacobian, volume};
use super::sheet::QuadMesh;

/// Volume of a part, meshed and exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartVolume {
    /// Volume of the elements, revolved about the axis.
    pub meshed: f64,
    /// Volume of the exact profile, revolved about the axis.
    pub exact: f64,
}

impl PartVolume {
    /// Returns the relative error of the meshed volume; rounding errors are set to 0.
    pub fn error(&self) -> f64 {
        let error = if self.exact > 0.0 { self.meshed / self.exact - 1.0 } else { 0.0 };
        if error.abs() < 1e-12 { 0.0 } else { error }
    }
}

/// Quality of the elements of a mesh. Positions are element centres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadQuality {
    /// Number of nodes and of elements.
    pub counts: [usize; 2],
    /// Smallest scaled Jacobian, and its position.
    pub jacobian: (f64, MeridianPoint),
    /// Largest aspect ratio, and its position.
    pub aspect: (f64, MeridianPoint),
    /// Smallest element height (area over longest side), and its position.
    pub height: (f64, MeridianPoint),
}

/// Quality and volumes of a projectile mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshMeasure {
    /// Quality of the elements.
    pub quality: QuadQuality,
    /// Volume of the projectile without fill, or of its case.
    pub case: PartVolume,
    /// Volume of the fill of the cavity; zero without one.
    pub fill: PartVolume,
}

impl QuadMesh {
    /// Computes the number of nodes and elements and the quality of the elements.
    pub fn quality(&self) -> QuadQuality {
        let (mut jacobian, mut stretched, mut low) =
            ((f64::INFINITY, [0.0; 2]), (0.0, [0.0; 2]), (f64::INFINITY, [0.0; 2]));
        for element in 0..self.elements.len() {
            let corners = self.corners(element);
            let middle = [0, 1].map(|k| 0.25 * corners.iter().map(|p| p[k]).sum::<f64>());
            let [j, a, h] = [least_scaled_jacobian(corners), aspect(corners), height(corners)];
            jacobian = if j < jacobian.0 { (j, middle) } else { jacobian };
            stretched = if a > stretched.0 { (a, middle) } else { stretched };
            low = if h < low.0 { (h, middle) } else { low };
        }
        let counts = [self.points.len(), self.elements.len()];
        QuadQuality { counts, jacobian, aspect: stretched, height: low }
    }
}

impl ProjectileMesh {
    /// Computes the quality of the elements and the volumes.
    pub fn measure(&self) -> MeshMeasure {
        let mut volumes = [0.0; 2];
        for (element, part) in self.parts.iter().enumerate() {
            volumes[usize::from(*part == MeshPart::Fill)] += volume(self.sheet.corners(element));
        }
        let [case, fill] = [0, 1].map(|k| PartVolume { meshed: volumes[k], exact: self.exact()[k] });
        MeshMeasure { quality: self.sheet.quality(), case, fill }
    }

    /// Returns the order of convergence of the volume when all element sides on the profile are halved; `None` for
    /// exact profiles.
    pub fn order(&self) -> Option<f64> {
        let case = self.measure().case;
        let arc = self
            .outline
            .nose
            .first()
            .filter(|piece| matches!(piece, ProfilePiece::Arc { .. }) && case.error() != 0.0)?;
        let gained = |&FreeSide { element, side, part }: &FreeSide| {
            let corners = self.sheet.corners(element);
            let [a, b] = [corners[side - 1], corners[side % 4]];
            let middle = arc.between(a, b).filter(|_| part == SurfacePart::Nose)?;
            let [once, twice] = [vec![a, b], vec![a, middle, b]]
                .map(|p| p.windows(2).map(|p| ProfilePiece::Line(p[0], p[1]).volume()).sum::<f64>());
            Some((twice - once).abs())
        };
        let gained: f64 = self.walls.iter().filter_map(gained).sum();
        let missing = case.exact - case.meshed;
        Some(libm::log2(missing / (missing - gained)))
    }
}
