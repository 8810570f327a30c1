//! Material laws in Rust, evaluated one material point at a time.

use super::LoadFailure;
pub use crate::kernel::moduli::ElasticModuli;

/// A quantity of a material point that a law requests by [`MaterialLaw::uses`]. Others are not computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PointQuantity {
    /// [`MaterialPoint::temperature`].
    Temperature,
    /// [`MaterialPoint::density`].
    Density,
    /// [`MaterialPoint::energy`].
    Energy,
    /// [`MaterialPoint::place`].
    Place,
    /// [`MaterialPoint::gradient`].
    Gradient,
    /// [`MaterialPoint::spin`].
    Spin,
    /// [`MaterialPoint::moduli`].
    Moduli,
}

/// A material point in one increment. Tensors have the components rr, zz, hoop, rz (tensor shear) along the global axes.
#[derive(Debug)]
#[non_exhaustive]
pub struct MaterialPoint<'a> {
    /// Constants of `*USER MATERIAL`.
    pub constants: &'a [f64],
    /// Strain increment.
    pub strain: [f64; 4],
    /// Previous stress, rotated with the spin of the material (Jaumann rate); the law replaces it.
    pub stress: [f64; 4],
    /// State variables of `*DEPVAR`, at least [`MaterialLaw::state_variables`]; the law updates them. Tensors among them
    /// have not been rotated.
    pub state: &'a mut [f64],
    /// Energy per volume dissipated in the increment; 0 on entry.
    pub dissipated: f64,
    /// Length of the increment.
    pub dt: f64,
    /// Total time at the end of the increment.
    pub total_time: f64,
    /// Temperature at the start of the increment: the initial one plus the rise by [`MaterialPoint::dissipated`] in an
    /// adiabatic analysis, or that of the nodes. NaN unless requested, as the next five fields.
    pub temperature: f64,
    /// Mass per volume at the end of the increment, without mass scaling.
    pub density: f64,
    /// Internal energy per mass at the start of the increment: the initial one plus the work of the stress.
    pub energy: f64,
    /// Centre `[r, z]` of the element at the end of the increment; of its part around the point for six-node triangles.
    pub place: [f64; 2],
    /// Deformation gradient at the end of the increment: rr, zz, hoop, rz, zr.
    pub gradient: [f64; 5],
    /// Spin increment in the (r, z) plane, half of the displacement gradient rz minus that of zr; an angle in radians.
    pub spin: f64,
    /// Moduli for the stable time increment and hourglass control, on entry those of the previous increment. The law
    /// replaces them if it requests [`PointQuantity::Moduli`]; otherwise they have no effect.
    pub moduli: ElasticModuli,
}

/// A material law in Rust. [`super::Routines::with_law`] registers it under the name of its material; the constants are
/// those of `*USER MATERIAL`. Several threads may use it at once.
///
/// ```
/// use revolve::user::{LoadFailure, MaterialLaw, MaterialPoint, ElasticModuli, Routines};
///
/// /// Linear elasticity with the constants K and G.
/// struct Hooke;
///
/// impl MaterialLaw for Hooke {
///     fn moduli(&self, constants: &[f64]) -> Result<ElasticModuli, LoadFailure> {
///         let &[bulk, shear] = constants else { return Err(LoadFailure::new("constants: K, G")) };
///         Ok(ElasticModuli { bulk, shear })
///     }
///
///     fn update(&self, point: &mut MaterialPoint<'_>) {
///         let (bulk, shear) = (point.constants[0], point.constants[1]);
///         let dilation = point.strain[0] + point.strain[1] + point.strain[2];
///         for (i, (stress, strain)) in point.stress.iter_mut().zip(point.strain).enumerate() {
///             *stress += 2.0 * shear * strain;
///             *stress += if i < 3 { (bulk - 2.0 / 3.0 * shear) * dilation } else { 0.0 };
///         }
///     }
/// }
///
/// let routines = Routines::none().with_law("HOOKE", Hooke);
/// ```
pub trait MaterialLaw: Send + Sync {
    /// Returns upper bounds of the moduli, from which the stable time increment, hourglass control and bulk viscosity
    /// are computed.
    ///
    /// # Errors
    /// If the constants are invalid; the deck is then rejected.
    fn moduli(&self, constants: &[f64]) -> Result<ElasticModuli, LoadFailure>;

    /// Returns the number of state variables that the law needs; `*DEPVAR` must define at least as many.
    fn state_variables(&self) -> usize {
        0
    }

    /// Returns the quantities of [`MaterialPoint`] that the law uses; others are not computed and have no cost.
    fn uses(&self) -> &'static [PointQuantity] {
        &[]
    }

    /// Updates stress and state variables of a point over an increment.
    fn update(&self, point: &mut MaterialPoint<'_>);
}
