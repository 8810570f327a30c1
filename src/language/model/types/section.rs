//! Sections, section controls and erosion criteria.

use super::handle::MaterialId;
use crate::deck::Span;

/// Material and elements of a solid section (`*SOLID SECTION`).
#[derive(Clone, Debug)]
pub struct SolidSection {
    /// Indices of the elements of the section.
    pub elements: Vec<usize>,
    /// Material of the section.
    pub material: MaterialId,
    /// Section controls; the defaults if the deck gives none.
    pub controls: SectionControls,
    /// Directions of fibres, unit vectors along r, z and hoop (`*ORIENTATION, LOCAL DIRECTIONS`).
    pub fibres: Vec<[f64; 3]>,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Layer of a shell section.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellLayer {
    /// Material of the layer.
    pub material: MaterialId,
    /// Initial thickness, length.
    pub thickness: f64,
    /// Number of Simpson integration points through the layer, odd and at least 3.
    pub points: usize,
    /// Angle from the meridian to direction 1 of the layer, degrees.
    pub angle: f64,
}

/// Layers and elements of a shell section (`*SHELL SECTION`).
#[derive(Clone, Debug, PartialEq)]
pub struct ShellSection {
    /// Indices of the elements of the section.
    pub elements: Vec<usize>,
    /// Layers from the side SNEG to the side SPOS, at least one.
    pub layers: Vec<ShellLayer>,
    /// Distance from the middle surface to the nodes along the normal, over the thickness (`OFFSET`), -0.5 to 0.5.
    pub offset: f64,
    /// Additional mass per area (`DENSITY`).
    pub per_area: f64,
    /// Thickness change (`POISSON`).
    pub thinning: ShellThinning,
    /// Source position of the keyword line.
    pub span: Span,
}

impl ShellSection {
    /// Returns the initial thickness of all layers together.
    pub fn thickness(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness).sum()
    }

    /// Returns the distances from the nodes to the surfaces SNEG and SPOS in the initial configuration.
    pub fn distances(&self) -> [f64; 2] {
        [0.5 + self.offset, 0.5 - self.offset].map(|share| share * self.thickness())
    }
}

/// Material, elements and constitutive thickness of a cohesive section (`*COHESIVE SECTION`).
#[derive(Clone, Debug)]
pub struct CohesiveSection {
    /// Indices of the elements of the section.
    pub elements: Vec<usize>,
    /// Material of the section.
    pub material: MaterialId,
    /// Constitutive thickness, length; `None` if it is the initial distance of the faces (`THICKNESS=GEOMETRY`).
    pub thickness: Option<f64>,
    /// Section controls; the defaults if the deck gives none.
    pub controls: SectionControls,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Thickness change of shells due to in-plane strains (`POISSON` of `*SHELL SECTION`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShellThinning {
    /// From the material response at the section points (`MATERIAL`).
    #[default]
    Material,
    /// From the Poisson's ratio of the material (`ELASTIC`).
    Elastic,
    /// From the given effective Poisson's ratio; 0 keeps the thickness constant.
    Ratio(f64),
}

/// Limits beyond which elements are deleted (`*EROSION`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErosionCriteria {
    /// Source position of the keyword line.
    pub span: Span,
    /// Element indices, ascending; `None` selects all deformable elements.
    pub elements: Option<Vec<usize>>,
    /// Smallest admissible scaled Jacobian, in [0, 1); 0 is a folded element.
    pub distortion: Option<f64>,
    /// Largest admissible equivalent plastic strain.
    pub plastic: Option<f64>,
    /// Largest admissible principal logarithmic strain.
    pub strain: Option<f64>,
    /// Smallest admissible stable time increment of an element, time.
    pub increment: Option<f64>,
}

/// Element controls under a name (`*SECTION CONTROLS`).
#[derive(Clone, Debug, PartialEq)]
pub struct SectionControls {
    /// Hourglass control method; `None` uses the default of the material.
    pub hourglass: Option<HourglassMethod>,
    /// Scale factor of the hourglass stiffness or viscosity.
    pub factor: f64,
    /// Whether mass and forces use area weighting instead of volume weighting.
    pub by_area: bool,
    /// `LENGTH RATIO` of distortion control; `None` without distortion control.
    pub distortion: Option<f64>,
    /// `MAX DEGRADATION`: the damage at which an element is deleted, or the damage limit of a kept element. Default 1,
    /// or 0.99 for kept elements.
    pub max_degradation: f64,
    /// `VISCOSITY`: viscosity of the damage of cohesive elements, time.
    pub viscosity: f64,
    /// `AVERAGED PRESSURE`: whether the dilatation of triangles is averaged over nodes; `None` if not given.
    pub averaged: Option<bool>,
    /// `SUBZONAL`: whether subzonal pressures resist hourglass motion; `None` if not given.
    pub subzonal: Option<bool>,
    /// Source position of `ELEMENT DELETION=NO`; `None` if failed elements are deleted.
    pub keep_failed_elements: Option<Span>,
}

/// Form of the hourglass control (`HOURGLASS`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HourglassMethod {
    /// Stiffness whose force relaxes with plastic flow (default).
    RelaxStiffness,
    /// Elastic hourglass forces, proportional to the hourglass displacement.
    Stiffness,
    /// Viscous hourglass forces, proportional to the hourglass velocity.
    Viscous,
    /// Combined form: this weight for the stiffness, the remainder for the viscosity.
    Combined(f64),
    /// Enhanced assumed strain.
    Enhanced,
}

impl Default for SectionControls {
    fn default() -> Self {
        SectionControls {
            hourglass: None,
            factor: 1.0,
            by_area: false,
            distortion: None,
            max_degradation: 1.0,
            viscosity: 0.0,
            averaged: None,
            subzonal: None,
            keep_failed_elements: None,
        }
    }
}
