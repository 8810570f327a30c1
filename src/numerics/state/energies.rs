//! Energies of deformable bodies, summed over a run.

use serde::Serialize;

use super::archive::Persist;

/// Flow through the Eulerian boundaries of adaptive meshes since the start of the analysis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct BoundaryFlow {
    /// Mass that has entered.
    pub mass_in: f64,
    /// Mass that has left.
    pub mass_out: f64,
    /// Momentum along z that has entered less that which has left.
    pub momentum: f64,
    /// Kinetic energy that has entered less that which has left.
    pub kinetic: f64,
}

/// Kind of an impact, by which the energy that contact absorbs is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImpactKind {
    /// Faces that have been exposed since the start of the analysis.
    #[default]
    FirstTouch,
    /// A face that element deletion has exposed: surfaces meet across the gap of a deleted element.
    ClosingGap,
    /// A node whose elements are all deleted.
    FreePoint,
}

/// Energy that contact has absorbed normal to the surfaces, by the kind of the impact. Penalty springs do not count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist, Serialize)]
pub struct ImpactLosses {
    /// Loss of faces that have been exposed since the start.
    pub first_touch: f64,
    /// Loss of faces that element deletion has exposed.
    pub closing_gaps: f64,
    /// Loss of nodes without elements.
    pub free_points: f64,
    /// Loss of nodes without elements whose mass has joined their body.
    pub merged_points: f64,
}

impl ImpactLosses {
    /// Adds the loss of an impact.
    pub fn add(&mut self, kind: ImpactKind, loss: f64) {
        match kind {
            ImpactKind::FirstTouch => self.first_touch += loss,
            ImpactKind::ClosingGap => self.closing_gaps += loss,
            ImpactKind::FreePoint => self.free_points += loss,
        }
    }

    /// Returns the sum of all kinds.
    pub fn sum(&self) -> f64 {
        self.first_touch + self.closing_gaps + self.free_points + self.merged_points
    }
}

/// Energies since the start of the analysis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct EnergyTotals {
    /// Kinetic energy at the current instant: v(i-1/2) m v(i+1/2)/2. For a linear body, central differences conserve
    /// the sum of this value and the strain energy exactly.
    pub kinetic: f64,
    /// Work of the stress.
    pub internal: f64,
    /// Energy dissipated by plastic flow and damage.
    pub plastic: f64,
    /// Elastic energy lost by damage, a part of `plastic`.
    pub damaged: f64,
    /// Work of the bulk viscosity.
    pub viscous: f64,
    /// Work of the hourglass control.
    pub artificial: f64,
    /// Work of distortion control.
    pub distortion: f64,
    /// Kinetic energy lost in the transport of momentum through adaptive meshes.
    pub advection: f64,
    /// Mass, momentum and kinetic energy that have entered and left through Eulerian boundaries.
    pub flow: BoundaryFlow,
    /// Work of external forces and prescribed motions.
    pub external: f64,
    /// Energy lost in contact impulses.
    pub contact: f64,
    /// Parts of `contact` by the kind of the impact.
    pub impacts: ImpactLosses,
    /// Energy stored and dissipated by contact penalty springs.
    pub penalty: f64,
    /// Energy of the overlaps with which soft contact began. Contact may release it; it is not part of the sum.
    pub initial_overlap: f64,
    /// Energy that thermal expansion has put in, and that preloaded springs have released. It is not part of the sum.
    pub supplied: f64,
    /// Energy dissipated by friction, in contact and in an unmeshed target.
    pub friction: f64,
    /// Energy dissipated by cavity expansion in an unmeshed target.
    pub cavity: f64,
}

impl EnergyTotals {
    /// Returns the sum of stored and dissipated energies, without external work, less the energy that has entered through
    /// Eulerian boundaries.
    pub fn sum(&self) -> f64 {
        let dissipated = self.viscous + self.contact + self.friction + self.cavity + self.distortion + self.advection;
        self.kinetic + self.internal + self.artificial + dissipated + self.penalty - self.flow.kinetic
    }
}
