//! Sections, their controls, and erosion.
//! Never here: what controls do.

use super::handle::MaterialId;
use crate::deck::Span;

/// `*SOLID SECTION`.
#[derive(Clone, Debug)]
pub struct SolidSection {
    /// Element indices.
    pub elements: Vec<usize>,
    /// Its material.
    pub material: MaterialId,
    /// Its section controls; those of the default where the deck gives none.
    pub controls: SectionControls,
    /// The card.
    pub span: Span,
}

/// `*SHELL SECTION`.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellSection {
    /// Element indices.
    pub elements: Vec<usize>,
    /// Its material.
    pub material: MaterialId,
    /// Thickness, length.
    pub thickness: f64,
    /// Points of Simpson's rule through it, odd and at least 3.
    pub points: usize,
    /// Mass per area beside that of the material (`DENSITY`).
    pub per_area: f64,
    /// How the thickness changes (`POISSON`).
    pub thinning: ShellThinning,
    /// The card.
    pub span: Span,
}

/// `POISSON` of `*SHELL SECTION`: how the thickness follows from strains in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShellThinning {
    /// By the material at the points through the thickness (`MATERIAL`).
    #[default]
    Material,
    /// By the Poisson's ratio of the material (`ELASTIC`).
    Elastic,
    /// By a ratio; 0 keeps the thickness.
    Ratio(f64),
}

/// `*EROSION`: limits whose passing deletes an element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Erosion {
    /// The card.
    pub span: Span,
    /// Its elements, ascending; `None` for all that deform.
    pub elements: Option<Vec<usize>>,
    /// Least scaled Jacobian, from 0 (folded) on and below 1.
    pub distortion: Option<f64>,
    /// Largest equivalent plastic strain.
    pub plastic: Option<f64>,
    /// Largest principal logarithmic strain.
    pub strain: Option<f64>,
    /// Least stable increment of an element, time.
    pub increment: Option<f64>,
}

/// `*SECTION CONTROLS`.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionControls {
    /// What resists hourglassing; by the material where the card says nothing.
    pub hourglass: Option<Hourglass>,
    /// Factor on it.
    pub factor: f64,
    /// Whether the equation of motion is weighted by area instead of by volume.
    pub by_area: bool,
    /// LENGTH RATIO of distortion control; `None` without it.
    pub distortion: Option<f64>,
    /// MAX DEGRADATION: the damage at which an element is deleted or that it keeps; 1 or, where it is kept, 0.99 if the deck says
    /// nothing.
    pub most_damage: f64,
    /// `AVERAGED PRESSURE`, where the deck says it: whether triangles average their dilation over nodes.
    pub averaged: Option<bool>,
    /// SUBZONAL: whether quarters of elements push back; `None` where the deck says nothing.
    pub subzonal: Option<bool>,
    /// `ELEMENT DELETION=NO`, where the deck says so.
    pub keeps_failed: Option<Span>,
}

/// What resists hourglassing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hourglass {
    /// A spring whose force relaxes as the material flows: what elements have without a word.
    RelaxStiffness,
    /// A spring.
    Stiffness,
    /// A dashpot.
    Viscous,
    /// Both: this weight for the spring, the rest for the dashpot.
    Combined(f64),
    /// The stresses of assumed strains that vary across the element.
    Enhanced,
}

impl Default for SectionControls {
    fn default() -> Self {
        SectionControls {
            hourglass: None,
            factor: 1.0,
            by_area: false,
            distortion: None,
            most_damage: 1.0,
            averaged: None,
            subzonal: None,
            keeps_failed: None,
        }
    }
}
