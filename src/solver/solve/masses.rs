//! Record of the masses before mass scaling.

use crate::state::archive::persist_struct;

/// Masses without scaling, and whether the warning of added mass has been issued.
#[derive(Clone, Debug, Default)]
pub(super) struct MassMonitor {
    /// Original mass of each element group; empty before the first scaling.
    pub original: Vec<f64>,
    /// Whether the warning has been issued.
    pub reported: bool,
}

persist_struct!(MassMonitor { original, reported });
