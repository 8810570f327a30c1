//! Available energy: the largest work that a material can do from its initial state, without work or heat from outside.

/// Energy that an element can release, and the total time from which it can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AvailableEnergy {
    pub energy: f64,
    /// Total time at which a detonation front arrives; negative infinity for energy that is available from the start.
    pub from: f64,
}

impl AvailableEnergy {
    pub const NONE: AvailableEnergy = AvailableEnergy::initial(0.0);

    /// Creates energy that is available from the start.
    pub const fn initial(energy: f64) -> Self {
        AvailableEnergy { energy, from: f64::NEG_INFINITY }
    }
}
