//! Geometry and motion of the elements of a block in the current configuration, from which corner forces follow: gradient
//! operators, hourglass pattern, and the bound of the highest frequency.

use pulp::Simd;

#[cfg(test)]
use crate::kernel::lanes::LANES;
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

/// Geometry and motion of a block, without velocities.
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

impl BlockMotion {
    /// Returns values that are not numbers.
    #[cfg(test)]
    pub(super) fn spoilt() -> BlockMotion {
        let list = [f64::NAN; LANES];
        BlockMotion {
            r: [list; 3],
            z: [list; 3],
            hoop: [list; 3],
            shape: [list; 3],
            rates: [list; 4],
            sizes: [list; 3],
        }
    }

    /// Computes the operators of a pack, the bound of its highest frequency and its hourglass pattern, from combined
    /// coordinates along r and z and combined inverse masses. `modulus` is that of longitudinal waves. Equation (4.7).
    ///
    /// A root and a division take long and are not needed before the corner forces: the earlier this is called, the more
    /// work a core has meanwhile.
    #[inline(always)]
    pub(super) fn measure<S: Simd, const AREA: bool>(
        &mut self,
        [r, z]: [&[Lanes; 4]; 2],
        inverse_mass: &[Lanes; 4],
        modulus: Pack<S>,
        at: PackPosition<S>,
    ) {
        let (r, z, inverse_mass) = (at.load_all(r), at.load_all(z), at.load_all(inverse_mass));
        let g = QuadOperators::of::<AREA>(r, z);
        // ω² ≤ c_d² ρ V Σ (b_r² + b_z² + b_θ²)/m; this is the sum.
        let sums_of_all =
            SquareSums::of_gradient(g.r).plus(SquareSums::of_gradient(g.z)).plus(SquareSums::of_hoop(g.hoop));
        let squares = sums_of_all.weighted(inverse_mass);
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
            period = g.volume / (UNIT * modulus * square * inverse_mass[0] * g.volume).root();
        }
        at.store_all(g.r, &mut self.r);
        at.store_all(g.z, &mut self.z);
        at.store_all(g.hoop, &mut self.hoop);
        at.store_all(pattern.inline_map(|part| per * part), &mut self.shape);
        at.store_all([squares, square, root, inverse], &mut self.rates);
        at.store_all([g.volume, per, period], &mut self.sizes);
    }

    /// Returns the results of [`Self::measure`] of a pack with its combined velocities along r and z.
    #[inline(always)]
    pub(super) fn of_pack<S: Simd>(
        &self,
        [v_r, v_z]: [&[Lanes; 4]; 2],
        modulus: Pack<S>,
        at: PackPosition<S>,
    ) -> LaneMotion<Pack<S>> {
        let (v_r, [_, w1, w2, w3]) = (at.load_all(v_r), at.load_all(v_z));
        let [squares, square, root, inverse] = at.load_all(&self.rates);
        let [volume, per, period] = at.load_all(&self.sizes);
        let [r, z, hoop] = [at.load_all(&self.r), at.load_all(&self.z), at.load_all(&self.hoop)];
        let along = [[v_r[1], v_r[2], v_r[3]], [w1, w2, w3]];
        let (g, shape) = (QuadOperators { r, z, hoop, volume }, at.load_all(&self.shape));
        LaneMotion { g, v_r, along, shape, modulus, squares, square, root, inverse, per, omega: root * per, period }
    }
}
