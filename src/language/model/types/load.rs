//! Loads and targets without mesh.

use super::SideSelection;
use super::handle::{AmplitudeId, MaterialId, TargetId};
use crate::deck::Span;

/// A load in force in a step, mechanical or thermal.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Type of the load and the region on which it acts.
    pub kind: LoadKind,
    /// Reference magnitude of the data line; 1 for load types without a magnitude.
    pub magnitude: f64,
    /// Amplitude; `None` for a constant load.
    pub amplitude: Option<AmplitudeId>,
    /// Source position of the data line.
    pub span: Span,
}

/// Type of a load and the region on which it acts.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadKind {
    /// `*CLOAD`: a force on each node, along one degree of freedom.
    Concentrated {
        /// Node indices.
        nodes: Vec<usize>,
        /// Degree of freedom: 1 = r, 2 = z.
        dof: u8,
        /// Name of the node set, or the node, as written in the deck.
        set: String,
    },
    /// `*DLOAD … GRAV`: an acceleration.
    Gravity {
        /// Element indices; `None` selects everything that has mass.
        elements: Option<Vec<usize>>,
        /// Unit vector along r and z; in oblique impact along directions 1, 2, 3.
        direction: [f64; 3],
    },
    /// `P`: a pressure on element sides.
    Pressure(SideSelection),
    /// `PNU`, `P1NU` to `P4NU`: a pressure given by the user subroutine VDLOAD.
    User {
        /// Faces on which the pressure acts.
        sides: SideSelection,
        /// Load type code `jltyp` of VDLOAD.
        load_type: i32,
    },
    /// `BRNU`, `BZNU`: a body force per volume along r or z, given by the user subroutine VDLOAD.
    UserBody {
        /// Indices of the elements on which the load acts.
        elements: Vec<usize>,
        /// Name of the element set, or the element, as written in the deck.
        set: String,
        /// Load type code `jltyp` of VDLOAD: 1 along r, 2 along z.
        load_type: i32,
    },
    /// `CAVITY` (extension): the resistance of a target without mesh.
    Cavity {
        /// Faces on which the resistance acts.
        sides: SideSelection,
        /// Target whose resistance acts on the faces.
        target: TargetId,
        /// Coulomb friction coefficient.
        friction: f64,
    },
    /// `*CFLUX`: a heat flux (energy per time) into each node.
    NodalHeat {
        /// Node indices.
        nodes: Vec<usize>,
        /// Name of the node set, or the node, as written in the deck.
        set: String,
    },
    /// `*DFLUX S1` to `S4`, `*DSFLUX`: a heat flux per area into the body.
    SurfaceHeat(SideSelection),
    /// `*DFLUX BF`: a heat source per volume.
    BodyHeat {
        /// Indices of the elements on which the load acts.
        elements: Vec<usize>,
        /// Name of the element set, or the element, as written in the deck.
        set: String,
    },
    /// `*FILM`, `*SFILM`: convection; the magnitude is the fluid temperature.
    Film {
        /// Cooled or heated sides.
        sides: SideSelection,
        /// Film coefficient: heat flux per area and temperature difference.
        coefficient: f64,
        /// Amplitude of the film coefficient; `None` for a constant coefficient.
        amplitude: Option<AmplitudeId>,
    },
}

/// A target without mesh: a stack of material layers (`*TARGET`, extension).
#[derive(Clone, Debug)]
pub struct TargetStack {
    /// Upper-case name.
    pub name: String,
    /// z of the impact face, length.
    pub front: f64,
    /// Stacking direction of the layers along z: +1 or -1.
    pub direction: f64,
    /// Rotation angle of the layer planes about direction 3, in degrees, through the point where the impact face meets
    /// the axis.
    pub obliquity: f64,
    /// Layers, starting at the impact face.
    pub layers: Vec<TargetLayer>,
    /// Free surfaces that reduce the resistance.
    pub free_surfaces: FreeSurfaces,
    /// Depth of the entry crater over which the resistance increases, length.
    pub crater: Option<f64>,
    /// Shear strength at which a plug is sheared out.
    pub shear_strength: Option<f64>,
    /// Whether the tunnel wall stays where the projectile displaced it, so that the projectile can separate from the
    /// wall.
    pub separation: bool,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Free surfaces of a target that reduce its resistance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeSurfaces {
    /// None: each layer resists as an infinite body.
    Off,
    /// Outer faces, faces at gaps, and lateral faces; layers in contact are bonded.
    Plates,
    /// The faces of every layer; layers in contact are not bonded.
    Layers,
}

/// A layer of a target, or a gap between plates.
#[derive(Clone, Copy, Debug)]
pub struct TargetLayer {
    /// Material with density and cavity expansion constants; `None` for a gap between plates.
    pub material: Option<MaterialId>,
    /// Thickness, length; may be infinite.
    pub thickness: f64,
    /// Radius of the lateral face, length; may be infinite.
    pub radius: f64,
    /// Source position of the data line.
    pub span: Span,
}
