//! Loads, and targets that are not meshed.
//! Never here: forces.

use super::Sides;
use super::handle::{AmplitudeId, MaterialId, TargetId};
use crate::deck::Span;

/// A load in force in a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// What acts.
    pub kind: LoadKind,
    /// Magnitude as on the data line (1 where the load has none).
    pub magnitude: f64,
    /// The amplitude, if it varies.
    pub amplitude: Option<AmplitudeId>,
    /// The data line.
    pub span: Span,
}

/// What a load acts on and how.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadKind {
    /// `*CLOAD`: a force on each node in a degree of freedom.
    Concentrated {
        /// Node indices.
        nodes: Vec<usize>,
        /// 1 = r, 2 = z.
        dof: u8,
        /// What the deck called them.
        set: String,
    },
    /// `*DLOAD … GRAV`: an acceleration; the direction is a unit vector.
    Gravity {
        /// Element indices; `None` means everything with mass.
        elements: Option<Vec<usize>>,
        /// Unit vector along r, z; in oblique impact along 1, 2, 3.
        direction: [f64; 3],
    },
    /// `P`: a pressure on sides.
    Pressure(Sides),
    /// `PNU`, `P1NU` to `P4NU`: the user's routine gives the pressure.
    User {
        /// Where.
        sides: Sides,
        /// VDLOAD's code of the load, `jltyp`.
        load_type: i32,
    },
    /// `BRNU`, `BZNU`: the user's routine gives the force a volume along r or z.
    UserBody {
        /// Element indices.
        elements: Vec<usize>,
        /// What the deck called them.
        set: String,
        /// VDLOAD's code of the load, `jltyp`: 1 along r, 2 along z.
        load_type: i32,
    },
    /// `CAVITY` (extension): a target's resistance.
    Cavity {
        /// Where.
        sides: Sides,
        /// The target.
        target: TargetId,
        /// Coulomb friction coefficient.
        friction: f64,
    },
    /// `*CFLUX`: heat a time into each node.
    NodalHeat {
        /// Node indices.
        nodes: Vec<usize>,
        /// What the deck called them.
        set: String,
    },
    /// `*DFLUX S1` to `S4`, `*DSFLUX`: heat a time and area into the body.
    SurfaceHeat(Sides),
    /// `*DFLUX BF`: heat a time and volume.
    BodyHeat {
        /// Element indices.
        elements: Vec<usize>,
        /// What the deck called them.
        set: String,
    },
    /// `*FILM`, `*SFILM`: the magnitude is the temperature of the fluid.
    Film {
        /// Where.
        sides: Sides,
        /// Heat a time, area and temperature.
        coefficient: f64,
        /// The amplitude of the coefficient, if it varies.
        amplitude: Option<AmplitudeId>,
    },
}

/// A target that is not meshed: layers of material, one behind the other (extension).
#[derive(Clone, Debug)]
pub struct Target {
    /// Upper-case name.
    pub name: String,
    /// z of the impact face.
    pub front: f64,
    /// +1 or -1: the way the layers follow each other along z.
    pub direction: f64,
    /// Angle in degrees by which its planes are turned about direction 3, through the point where the front meets the axis.
    pub obliquity: f64,
    /// From the front on.
    pub layers: Vec<Layer>,
    /// Which of its faces weaken what it resists with.
    pub free_surfaces: FreeSurfaces,
    /// Depth of the crater over which the resistance grows, length.
    pub crater: Option<f64>,
    /// Shear stress at which a plug is sheared out.
    pub shear_strength: Option<f64>,
    /// Whether the wall of the tunnel stays where the body has pushed it.
    pub separation: bool,
    /// The card.
    pub span: Span,
}

/// Which faces of a target are free surfaces that weaken what it resists with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeSurfaces {
    /// None: layers are as strong as a body without end.
    Off,
    /// Those that border on nothing: the outer ones, those at gaps, lateral ones.
    Plates,
    /// Those of every layer: layers lie on each other and do not hold together.
    Layers,
}

/// One layer of a target.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// A material with density and cavity expansion; `None` in a gap between plates.
    pub material: Option<MaterialId>,
    /// Thickness, length; may be infinite.
    pub thickness: f64,
    /// Radius of its lateral face, length; may be infinite.
    pub radius: f64,
    /// The data line.
    pub span: Span,
}
