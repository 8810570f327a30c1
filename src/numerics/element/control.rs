//! Resistance to hourglass patterns, which one integration point cannot detect: an hourglass spring and dashpot, or
//! stresses of assumed strains ([`super::enhanced`]). Both are computed with the corner forces of the uniform stress.

use pulp::Simd;

use super::block::{ControlStresses, TaskWorkspace};
use super::forces::ForceFactors;
use super::motion::LaneMotion;
use crate::kernel::lanes::Lanes;
use crate::kernel::pack::{Pack, PackPosition};
use crate::kernel::real::Real;

/// Largest ratio of the squared frequency of an hourglass pattern to that of the strains. The value 1/4 leaves the
/// stable time increment of undistorted elements unchanged.
const SLOW: f64 = 0.25;

/// Type of hourglass resistance of a block.
pub(super) trait HourglassScheme {
    /// Updates the stresses of a pack over an increment, adds their work to the sums, and returns their forces.
    /// `VARY`: the moduli vary; `EOS`: the material has an equation of state.
    fn resist<S: Simd, const VARY: bool, const EOS: bool>(
        &mut self,
        pattern: PatternMotion<'_, S>,
        kept: &mut ControlStresses,
        scratch: &mut TaskWorkspace,
    ) -> PatternForces<Pack<S>>;
}

/// Motion of the hourglass pattern of a pack.
pub(super) struct PatternMotion<'a, S: Simd> {
    pub at: PackPosition<S>,
    pub factors: &'a ForceFactors,
    pub lane: &'a LaneMotion<Pack<S>>,
    /// Products of the pattern with the velocities along r and z.
    pub rate: [Pack<S>; 2],
    pub inverse_mass: &'a [Lanes; 4],
}

/// Generalised forces of hourglass resistance.
pub(super) struct PatternForces<T> {
    /// On the pattern along r and z.
    pub pattern: [T; 2],
    /// On the operators of hoop strains along r and z ([`crate::kernel::assumed::hoop`]); `None` if there are none.
    pub hoop: Option<[T; 2]>,
}

/// Hourglass spring and dashpot.
pub(super) struct PatternSpring;

impl HourglassScheme for PatternSpring {
    /// Computes the hourglass stresses along r and z (Flanagan and Belytschko 1981, eqs. 25 to 45) for the pattern
    /// orthogonal to linear fields. The elastic part may be scaled back with the stress in plastic flow.
    #[inline(always)]
    fn resist<S: Simd, const VARY: bool, const EOS: bool>(
        &mut self,
        PatternMotion { at, factors, lane, rate: [q_r, q_z], .. }: PatternMotion<'_, S>,
        kept: &mut ControlStresses,
        scratch: &mut TaskWorkspace,
    ) -> PatternForces<Pack<S>> {
        let dt = factors.dt;
        let LaneMotion { root, inverse, per, omega, square, .. } = *lane;
        let volume = lane.g.volume;
        // The mass that moves with the pattern, a sixteenth of the element mass for a square, vanishes as an element
        // folds. The stiffness is therefore bounded, so that the pattern's frequency stays below that of the strains,
        // and damping is a fraction of the critical damping.
        let moved = root * (volume * (inverse * (root * volume)));
        let (unbounded, most) = (factors.stiffness * (4.0 * square) * per, SLOW * dt * omega * moved);
        let spring = unbounded.at_most(most);
        let dashpot = factors.viscosity2 * moved;
        let ([old_r, old_z], left) = (at.load_all(&kept.hourglass), at.load(&scratch.stress.returned));
        let (new_r, new_z) = (left * (old_r + spring * q_r), left * (old_z + spring * q_z));
        at.store_all([new_r, new_z], &mut kept.hourglass);
        let (drag_r, drag_z) = (dashpot * q_r, dashpot * q_z);
        let power = q_r * (0.5 * (old_r + new_r) + drag_r) + q_z * (0.5 * (old_z + new_z) + drag_z);
        at.add(dt * at.load(&scratch.weight) * power, &mut scratch.sums.artificial);
        PatternForces { pattern: [new_r + drag_r, new_z + drag_z], hoop: None }
    }
}
