//! Loads and targets without mesh.

use super::SideSelection;
use super::handle::{AmplitudeId, MaterialId, TargetId};
use crate::deck::Span;
use crate::kernel::blast_wave::BurstShape;

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
    /// `TRVEC`, `TRSHR`, `VP`: a traction that is no pressure.
    Traction {
        /// Faces on which the traction acts.
        sides: SideSelection,
        /// Direction of the traction.
        law: SurfaceTraction,
    },
    /// `BR`, `BZ`, `CENTRIF`: a force per volume.
    Body {
        /// Indices of the elements on which the load acts.
        elements: Vec<usize>,
        /// Name of the element set, or the element, as written in the deck.
        set: String,
        /// Direction and meaning of the magnitude.
        law: BodyForce,
    },
    /// `*INCIDENT WAVE INTERACTION, CONWEP`: the blast of a charge on the axis. The magnitude is a factor on the pressure.
    Blast {
        /// Faces on which the pressure acts.
        sides: SideSelection,
        /// The charge.
        charge: BlastCharge,
        /// Coordinate z of the charge.
        height: f64,
        /// Total time of the detonation.
        detonation: f64,
    },
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

/// Nodes, elements or faces on which a load acts.
#[derive(Clone, Copy, Debug)]
pub enum LoadRegion<'a> {
    /// Node indices.
    Nodes(&'a [usize]),
    /// Element indices.
    Elements(&'a [usize]),
    /// Faces of elements.
    Sides(&'a SideSelection),
    /// Everything that has mass.
    Whole,
}

/// Changeable nodes, elements or faces on which a load acts.
pub(in crate::model) enum LoadRegionMut<'a> {
    Nodes(&'a mut Vec<usize>),
    Elements(&'a mut Vec<usize>),
    Sides(&'a mut SideSelection),
    Whole,
}

/// Returns the region of a load in the form of one of the two types of regions.
macro_rules! region_of {
    ($kind:expr, $region:ident) => {
        match $kind {
            LoadKind::Concentrated { nodes, .. } | LoadKind::NodalHeat { nodes, .. } => $region::Nodes(nodes),
            LoadKind::Gravity { elements: None, .. } => $region::Whole,
            LoadKind::Gravity { elements: Some(elements), .. }
            | LoadKind::Body { elements, .. }
            | LoadKind::UserBody { elements, .. }
            | LoadKind::BodyHeat { elements, .. } => $region::Elements(elements),
            LoadKind::Pressure(sides)
            | LoadKind::SurfaceHeat(sides)
            | LoadKind::Traction { sides, .. }
            | LoadKind::Blast { sides, .. }
            | LoadKind::User { sides, .. }
            | LoadKind::Cavity { sides, .. }
            | LoadKind::Film { sides, .. } => $region::Sides(sides),
        }
    };
}

impl LoadKind {
    /// Returns the nodes, elements or faces on which the load acts.
    pub fn region(&self) -> LoadRegion<'_> {
        region_of!(self, LoadRegion)
    }

    pub(in crate::model) fn region_mut(&mut self) -> LoadRegionMut<'_> {
        region_of!(self, LoadRegionMut)
    }

    /// Returns the faces on which the load acts; `None` if it acts on nodes or volumes.
    pub fn sides(&self) -> Option<&SideSelection> {
        if let LoadRegion::Sides(sides) = self.region() { Some(sides) } else { None }
    }

    /// Returns whether the load is a source of heat.
    pub fn is_thermal(&self) -> bool {
        use LoadKind::{BodyHeat, Film, NodalHeat, SurfaceHeat};
        matches!(self, NodalHeat { .. } | SurfaceHeat(_) | BodyHeat { .. } | Film { .. })
    }

    /// Returns whether a user subroutine gives the load.
    pub fn is_user(&self) -> bool {
        matches!(self, LoadKind::User { .. } | LoadKind::UserBody { .. })
    }
}

/// A blast wave by its name (`*INCIDENT WAVE INTERACTION PROPERTY`).
#[derive(Clone, Debug)]
pub(in crate::model) struct BlastProperty {
    /// Upper-case name.
    pub name: String,
    pub charge: BlastCharge,
    /// Whether a charge has been given.
    pub has_charge: bool,
}

/// A charge of TNT (`*CONWEP CHARGE PROPERTY`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlastCharge {
    /// Shape of the wave.
    pub shape: BurstShape,
    /// Mass, kg.
    pub mass: f64,
    /// Factors from the units of the model to metres, seconds and pascals.
    pub units: [f64; 3],
}

/// Direction of a traction that is no pressure; directions are unit vectors along r and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceTraction {
    /// `TRVEC`: in a direction, which rotates with the surface or not.
    Vector {
        /// Direction.
        direction: [f64; 2],
        /// Whether the direction rotates with the surface (`FOLLOWER=YES`).
        follows: bool,
    },
    /// `TRSHR`: along the surface, in the direction that is nearest to the given one at the start.
    Shear {
        /// Direction before projection to the surface.
        direction: [f64; 2],
    },
    /// `VP`: against the normal velocity; the magnitude is a pressure per velocity.
    Viscous {
        /// Node to whose motion the velocity refers (`REF NODE`); `None` is at rest.
        reference: Option<usize>,
    },
    /// Infinite elements: against the normal velocity and the velocity along the face; the magnitude is the impedance of
    /// pressure waves.
    Absorbing {
        /// Impedance of shear waves over that of pressure waves.
        shear_ratio: f64,
    },
}

/// Direction of a body force and meaning of its magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BodyForce {
    /// `BR`: force per volume along r.
    Radial,
    /// `BZ`: force per volume along z.
    Axial,
    /// `CENTRIF`: squared angular velocity of a rotation about the axis of symmetry, 1/time².
    Centrifugal,
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
