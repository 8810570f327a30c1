//! Equations of state in Rust.

use super::LoadFailure;

/// Pressure and sound speed of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EosResponse {
    /// Pressure, positive in compression.
    pub pressure: f64,
    /// Sound speed at constant entropy, from which the stable time increment follows; length per time.
    pub sound_speed: f64,
}

/// An equation of state in Rust. [`super::Routines::with_eos`] registers it under the name of its material, whose card is
/// `*EOS, TYPE=USER, PROPERTIES=n` with n constants. Several threads may use it at once.
///
/// ```
/// use revolve::user::{EosLaw, EosResponse, Routines};
///
/// /// Gas of constant heat capacities; the constant is their ratio.
/// struct Gas;
///
/// impl EosLaw for Gas {
///     fn respond(&self, constants: &[f64], density: f64, energy: f64) -> EosResponse {
///         let pressure = (constants[0] - 1.0) * density * energy;
///         EosResponse { pressure, sound_speed: (constants[0] * pressure / density).sqrt() }
///     }
/// }
///
/// let routines = Routines::none().with_eos("GAS", Gas);
/// ```
pub trait EosLaw: Send + Sync {
    /// Returns pressure and sound speed at a density (mass per volume) and a specific energy (energy per mass). The
    /// pressure must be a smooth function of the energy: the energy balance of an increment is solved for it.
    fn respond(&self, constants: &[f64], density: f64, energy: f64) -> EosResponse;

    /// Checks the constants.
    ///
    /// # Errors
    /// If the constants are invalid; the deck is then rejected.
    fn check(&self, _constants: &[f64]) -> Result<(), LoadFailure> {
        Ok(())
    }
}
