//! Numbers that all elements of a group share.
//! Never here: state.

/// Elastic moduli, hourglass control and bulk viscosity of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Bulk modulus.
    pub bulk: f64,
    /// Shear modulus.
    pub shear: f64,
    /// Hourglass stiffness over the shear modulus.
    pub hourglass_stiffness: f64,
    /// Hourglass viscosity, a fraction of the critical.
    pub hourglass_viscosity: f64,
    /// Linear and quadratic bulk viscosity.
    pub bulk_viscosity: [f64; 2],
}
