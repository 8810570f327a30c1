//! What a mesh amounts to: quality, where it is worst, volumes against those of the profile.

use super::mesh::{Mesh, MeshPart, SurfacePart};
use super::profile::{Piece, Point};
use super::quality::{aspect, height, least_scaled_jacobian, volume};

/// Volumes of a part: of the mesh and of the profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartVolume {
    /// What the elements sweep about the axis.
    pub meshed: f64,
    /// What the profile does.
    pub exact: f64,
}

impl PartVolume {
    /// Relative error of the meshed volume; below rounding it is 0.
    pub fn error(&self) -> f64 {
        let error = if self.exact > 0.0 { self.meshed / self.exact - 1.0 } else { 0.0 };
        if error.abs() < 1e-12 { 0.0 } else { error }
    }
}

/// A mesh in figures. Where there is a place, it is the middle of the element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshMeasure {
    /// Number of nodes and of elements.
    pub counts: [usize; 2],
    /// Least scaled Jacobian, and where.
    pub jacobian: (f64, Point),
    /// Largest ratio of sides, and where.
    pub aspect: (f64, Point),
    /// Least height of an element (area over longest side), and where.
    pub height: (f64, Point),
    /// The projectile without its fill, or its case.
    pub case: PartVolume,
    /// The fill.
    pub fill: PartVolume,
}

impl Mesh {
    /// Measures the mesh.
    pub fn measure(&self) -> MeshMeasure {
        let (mut jacobian, mut stretched, mut low) =
            ((f64::INFINITY, [0.0; 2]), (0.0, [0.0; 2]), (f64::INFINITY, [0.0; 2]));
        let mut volumes = [0.0; 2];
        for (element, belongs) in self.belongs.iter().enumerate() {
            let corners = self.corners_of(element);
            let middle = [0, 1].map(|k| 0.25 * corners.iter().map(|p| p[k]).sum::<f64>());
            let [j, a, h] = [least_scaled_jacobian(corners), aspect(corners), height(corners)];
            jacobian = if j < jacobian.0 { (j, middle) } else { jacobian };
            stretched = if a > stretched.0 { (a, middle) } else { stretched };
            low = if h < low.0 { (h, middle) } else { low };
            volumes[usize::from(*belongs == MeshPart::Fill)] += volume(corners);
        }
        let [case, fill] = [0, 1].map(|k| PartVolume { meshed: volumes[k], exact: self.exact()[k] });
        let counts = [self.sheet.points.len(), self.sheet.elements.len()];
        MeshMeasure { counts, jacobian, aspect: stretched, height: low, case, fill }
    }
}

impl Mesh {
    /// Order of convergence of the volume when every side on the profile is halved. `None` for an exact profile.
    pub fn order(&self) -> Option<f64> {
        let case = self.measure().case;
        let arc =
            self.outline.nose.first().filter(|piece| matches!(piece, Piece::Arc { .. }) && case.error() != 0.0)?;
        let gained = |&(element, side, wall): &(usize, usize, SurfacePart)| {
            let corners = self.corners_of(element);
            let [a, b] = [corners[side - 1], corners[side % 4]];
            let middle = arc.between(a, b).filter(|_| wall == SurfacePart::Nose)?;
            let [once, twice] = [vec![a, b], vec![a, middle, b]]
                .map(|p| p.windows(2).map(|p| Piece::Line(p[0], p[1]).volume()).sum::<f64>());
            Some((twice - once).abs())
        };
        let gained: f64 = self.walls.iter().filter_map(gained).sum();
        let missing = case.exact - case.meshed;
        Some(libm::log2(missing / (missing - gained)))
    }
}
