//! Geometry and motion of the elements of a block in the current configuration, from which corner forces follow: gradient
//! operators, hourglass pattern, and the bound of the highest frequency.

use pulp::Simd;

use super::block::TaskWorkspace;
use super::constants::ElementConstants;
use crate::kernel::lanes::{InlineMap, Lanes};
use crate::kernel::pack::{Pack, PackPosition};
use crate::kernel::quad::{QuadOperators, SquareSums, UNIT, dot3};
use crate::kernel::real::Real;

/// Geometry and motion of a lane, or of a pack of lanes.
pub(super) struct LaneMotion<T> {
    pub g: QuadOperators<T>,
    /// Velocities along r, combined by [`sums`](crate::kernel::quad::sums).
    pub v_r: [T; 4],
    /// Combined velocities along r and z without the mean.
    pub along: [[T; 3]; 2],
    /// Hourglass pattern in base vectors.
    pub shape: [T; 3],
    /// Modulus of longitudinal waves.
    pub modulus: T,
    /// Sum of the squares of all operators over the corner masses, and the sum of squares without the hoop operator.
    pub squares: T,
    pub square: T,
    /// Highest frequency times the volume, and a common inverse: 1/V and 1/ω follow from it without another division.
    pub root: T,
    pub inverse: T,
    /// One over the volume.
    pub per: T,
    pub omega: T,
    /// One over the frequency that bulk viscosity damps.
    pub period: T,
}

impl<T: Real> LaneMotion<T> {
    /// Returns the volumetric strain rate of the current velocities.
    #[inline(always)]
    pub fn dilation_rate(&self) -> T {
        let (g, [along_r, along_z], [ring, first, second, _]) = (&self.g, self.along, self.v_r);
        (dot3(g.r, along_r) + dot3(g.z, along_z) + dot3(g.hoop, [ring, first, second])) / g.volume
    }
}

/// Results of [`TaskWorkspace::measure_motion`] for a block.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct BlockMotion {
    r: [Lanes; 3],
    z: [Lanes; 3],
    hoop: [Lanes; 3],
    shape: [Lanes; 3],
    /// `squares`, `square`, `root` and `inverse` of [`LaneMotion`].
    rates: [Lanes; 4],
    /// Volume, `per` and `period`.
    sizes: [Lanes; 3],
}

/// Input of [`TaskWorkspace::measure_motion`] that is the same for all packs.
pub(super) struct MotionInput<'a> {
    inverse_mass: &'a [Lanes; 4],
    shear43: f64,
    modulus: f64,
}

impl<'a> MotionInput<'a> {
    #[inline(always)]
    pub fn new(constants: &ElementConstants, inverse_mass: &'a [Lanes; 4]) -> Self {
        let [shear43, modulus] = wave(constants);
        MotionInput { inverse_mass, shear43, modulus }
    }
}

impl TaskWorkspace {
    /// Computes the operators of a pack, the bound of its highest frequency and its hourglass pattern, from combined
    /// coordinates. With `VARY` the modulus follows from the stress update.
    ///
    /// A root and a division take long and are not needed before the corner forces: the earlier this is called, the more
    /// work a core has meanwhile.
    #[inline(always)]
    pub(super) fn measure_motion<S: Simd, const AREA: bool, const VARY: bool>(
        &mut self,
        input: &MotionInput<'_>,
        at: PackPosition<S>,
    ) {
        let modulus = if VARY { input.shear43 + at.load(&self.stress.bulk) } else { at.splat(input.modulus) };
        let (r, z, inverse_mass) = (at.load_all(&self.r), at.load_all(&self.z), at.load_all(input.inverse_mass));
        let g = QuadOperators::of::<AREA>(r, z);
        // ω² ≤ c_d² ρ V Σ (b_r² + b_z² + b_θ²)/m; this is the sum.
        let all = SquareSums::of_gradient(g.r).plus(SquareSums::of_gradient(g.z)).plus(SquareSums::of_hoop(g.hoop));
        let squares = all.weighted(inverse_mass);
        let pattern = g.pattern([r[3], z[3]]);
        let light = SquareSums::of_gradient(pattern).weighted(inverse_mass);
        let root = (UNIT * modulus * squares * g.volume).root();
        // ω = root / V. One division yields 1/V, 1/ω and the mass that moves with the pattern.
        let inverse = 1.0 / (g.volume * (root * light));
        let inverse_root = inverse * (g.volume * light);
        let per = inverse * (root * light);
        let square = dot3(g.r, g.r) + dot3(g.z, g.z);
        // Bulk viscosity (ABAQUS Analysis User's Guide, "Explicit dynamic analysis"); it is not part of the stored
        // stress. The length is 2 c/ω, so that the linear coefficient is the fraction of critical damping in the
        // highest mode, also in flat elements: ρ c times the length is then 2 (K + 4/3 G)/ω.
        let mut period = g.volume * inverse_root;
        if AREA {
            // From the plane section only: the hoop term would disturb spherical symmetry.
            period = g.volume / (UNIT * modulus * square * at.load(&input.inverse_mass[0]) * g.volume).root();
        }
        let motion = &mut self.motion;
        at.store_all(g.r, &mut motion.r);
        at.store_all(g.z, &mut motion.z);
        at.store_all(g.hoop, &mut motion.hoop);
        at.store_all(pattern.inline_map(|part| per * part), &mut motion.shape);
        at.store_all([squares, square, root, inverse], &mut motion.rates);
        at.store_all([g.volume, per, period], &mut motion.sizes);
    }

    /// Returns the results of [`Self::measure_motion`] of a pack with its velocities.
    #[inline(always)]
    pub(super) fn motion<S: Simd, const VARY: bool>(
        &self,
        input: &MotionInput<'_>,
        at: PackPosition<S>,
    ) -> LaneMotion<Pack<S>> {
        let TaskWorkspace { v_r, v_z, stress, motion, .. } = self;
        let modulus = if VARY { input.shear43 + at.load(&stress.bulk) } else { at.splat(input.modulus) };
        let (v_r, [_, w1, w2, w3]) = (at.load_all(v_r), at.load_all(v_z));
        let [squares, square, root, inverse] = at.load_all(&motion.rates);
        let [volume, per, period] = at.load_all(&motion.sizes);
        let [r, z, hoop] = [at.load_all(&motion.r), at.load_all(&motion.z), at.load_all(&motion.hoop)];
        let along = [[v_r[1], v_r[2], v_r[3]], [w1, w2, w3]];
        let (g, shape) = (QuadOperators { r, z, hoop, volume }, at.load_all(&motion.shape));
        LaneMotion { g, v_r, along, shape, modulus, squares, square, root, inverse, per, omega: root * per, period }
    }
}

/// Returns 4/3 of the shear modulus, and the longitudinal modulus K + 4/3 G.
pub(super) fn wave(constants: &ElementConstants) -> [f64; 2] {
    let shear43 = 4.0 / 3.0 * constants.shear;
    [shear43, constants.bulk + shear43]
}
