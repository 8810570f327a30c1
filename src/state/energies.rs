//! Energies of what deforms, summed over a run.
//! Never here: the balance of the whole scene.

use super::archive::persist_struct;

/// Energies so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic, at the instant's own time: half v(i-1/2) m v(i+1/2), which central differences conserve exactly together
    /// with the strain energy of a linear body.
    pub kinetic: f64,
    /// Work of the stress.
    pub internal: f64,
    /// Plastic dissipation.
    pub plastic: f64,
    /// Work of the bulk viscosity.
    pub viscous: f64,
    /// Work of the hourglass control.
    pub artificial: f64,
    /// Work of distortion control.
    pub distortion: f64,
    /// Work of forces and prescribed motions.
    pub external: f64,
    /// Lost where surfaces meet.
    pub contact: f64,
    /// Held and lost by penalty springs of contact.
    pub penalty: f64,
    /// Dissipated by friction, where surfaces meet and in a target that is not meshed.
    pub friction: f64,
    /// Dissipated by opening the cavity in a target that is not meshed.
    pub cavity: f64,
}

impl Energies {
    /// What is kept or lost, less the work from outside: constant but for what rigid bodies take.
    pub fn sum(&self) -> f64 {
        let dissipated = self.viscous + self.contact + self.friction + self.cavity + self.distortion;
        self.kinetic + self.internal + self.artificial + dissipated + self.penalty
    }
}

persist_struct!(Energies {
    kinetic,
    internal,
    plastic,
    viscous,
    artificial,
    external,
    contact,
    friction,
    cavity,
    distortion,
    penalty
});
