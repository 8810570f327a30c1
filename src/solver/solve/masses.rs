//! Record of the masses before mass scaling.

use crate::state::archive::Persist;

/// Masses without scaling, and the largest kinetic energy with added mass.
#[derive(Clone, Debug, Default, Persist)]
pub(super) struct MassMonitor {
    /// Original mass of each element group; empty before the first scaling.
    pub original: Vec<f64>,
    /// Original mass of each rigid body; empty before the first scaling.
    pub bodies: Vec<f64>,
    /// Mass that scaling has added to the rigid bodies.
    pub added_to_bodies: f64,
    /// Ratio of added to original mass of each element group, since the last scaling.
    pub added_shares: Vec<f64>,
    /// Largest kinetic energy of the deformable bodies while added mass was above the limit of the warning.
    pub kinetic: f64,
}
