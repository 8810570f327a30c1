//! What a deck says of a material that asks the user's routines at its points.
//! Never here: asking them.

use std::sync::Arc;

use crate::kernel::hardening::YieldStress;
use crate::kernel::heating::Heating;

/// What a deck says of a user material.
#[derive(Clone, Debug)]
pub struct Description {
    /// Name, upper case (`cmname`).
    pub name: String,
    /// Constants.
    pub properties: Vec<f64>,
    /// Variables that each element keeps.
    pub variables: usize,
    /// The one of them, counted from 0, that deletes an element when it becomes zero.
    pub delete: Option<usize>,
    /// Field variables.
    pub fields: usize,
    /// Constants of the routine of fields, where there is one (`*USER DEFINED FIELD`).
    pub asks_fields: Option<Vec<f64>>,
    /// Elasticity and plasticity, where the routine does not give the stress itself.
    pub flow: Option<Flow>,
    /// Rise of temperature by inelastic work.
    pub heating: Heating,
    /// Mass a volume at the start.
    pub density: f64,
}

/// Who gives the yield stress.
#[derive(Clone)]
pub enum Yield {
    /// Nobody: the material is elastic.
    Never,
    /// A law that is built in.
    Law(Arc<dyn YieldStress>),
    /// The user's routine, with these constants.
    User(Vec<f64>),
}

impl std::fmt::Debug for Yield {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Yield::Never => f.write_str("Never"),
            Yield::Law(_) => f.write_str("Law"),
            Yield::User(properties) => f.debug_tuple("User").field(properties).finish(),
        }
    }
}

/// Isotropic elasticity and von Mises plasticity.
#[derive(Clone, Debug)]
pub struct Flow {
    /// Bulk modulus.
    pub bulk: f64,
    /// Shear modulus.
    pub shear: f64,
    /// Yield stress.
    pub yields: Yield,
}
