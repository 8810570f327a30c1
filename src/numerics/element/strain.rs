//! Strain increments at mid-increment, the stress rotated with the material, and the elastic trial stress of a block of
//! elements.

use pulp::{Simd, WithSimd};

use super::constants::ElementConstants;
use super::workspace::{CornerNodes, TaskWorkspace};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, dispatch_outlined};
use crate::kernel::pack::{Pack, PackPosition};
use crate::kernel::quad::{QuadOperators, UNIT, dot3, sums};
use crate::kernel::real::Real;
use crate::kernel::rotation::{SpinQuotient, rotate};
use crate::material::{Material, PlasticFlow};

/// Operation that measures the strain increments of a block. It is compiled once for all materials.
pub(super) struct StrainMeasurement<'a, const AREA: bool> {
    stress: &'a [Lanes; 4],
    constants: &'a ElementConstants,
    dt: f64,
    /// Corner nodes of quadrilaterals; `None` if [`TaskWorkspace::set_gradients`] has set the velocity gradients.
    nodes: Option<&'a CornerNodes>,
    /// Whether spin increments, and von Mises stresses of the trial, are needed.
    spin: bool,
    mises: bool,
    scratch: &'a mut TaskWorkspace,
}

/// Velocity gradient of a pack at mid-increment times the volume there (rr, zz, hoop and the sum of rz and zr), and the
/// spin increment.
struct PackGradient<S: Simd> {
    rates: [Pack<S>; 4],
    spin: SpinQuotient<Pack<S>>,
}

impl<'a, const AREA: bool> StrainMeasurement<'a, AREA> {
    /// Creates the operation for elements of a material with these stresses.
    #[inline(always)]
    pub fn new<M: Material>(
        stress: &'a [Lanes; 4],
        (constants, dt): (&'a ElementConstants, f64),
        nodes: Option<&'a CornerNodes>,
        scratch: &'a mut TaskWorkspace,
    ) -> Self {
        let spin = M::USES_SPIN || !scratch.task.records.is_empty();
        let mises = matches!(M::FLOW, PlasticFlow::Deviatoric | PlasticFlow::Unknown);
        StrainMeasurement { stress, constants, dt, nodes, spin, mises, scratch }
    }

    /// Returns the velocity gradient of a pack of quadrilaterals. Equation (5.4).
    #[inline(always)]
    fn gradient<S: Simd>(&self, at: PackPosition<S>) -> PackGradient<S> {
        let TaskWorkspace { r, z, v_r, v_z, .. } = &*self.scratch;
        let [r, z, v_r, v_z] = [r, z, v_r, v_z].inline_map(|list| at.load_all(list));
        let half = at.splat(0.5 * self.dt);
        let middle = |x: [Pack<S>; 4], v: [Pack<S>; 4]| [0, 1, 2, 3].inline_map(|i: usize| x[i] - half * v[i]);
        let g = QuadOperators::of::<AREA>(middle(r, v_r), middle(z, v_z));
        let (along_r, along_z) = ([v_r[1], v_r[2], v_r[3]], [v_z[1], v_z[2], v_z[3]]);
        let (rz, zr) = (dot3(g.z, along_r), dot3(g.r, along_z));
        let hoop = dot3(g.hoop, [v_r[0], v_r[1], v_r[2]]);
        PackGradient {
            rates: [dot3(g.r, along_r), dot3(g.z, along_z), hoop, rz + zr],
            spin: SpinQuotient::new(half * (rz - zr), g.volume),
        }
    }

    /// Returns the velocity gradient of a pack that [`TaskWorkspace::set_gradients`] has set.
    #[inline(always)]
    fn stored_gradient<S: Simd>(&self, at: PackPosition<S>) -> PackGradient<S> {
        let TaskWorkspace { strain, turned, middle, .. } = &*self.scratch;
        PackGradient { rates: at.load_all(&strain.strain), spin: SpinQuotient::new(at.load(turned), at.load(middle)) }
    }

    /// Stores strain increments, rotated stress, mean and deviator of the elastic trial stress of a pack. Equations
    /// (5.4), (6.1).
    #[inline(always)]
    fn store_trial<S: Simd>(&mut self, at: PackPosition<S>, PackGradient { rates, spin }: PackGradient<S>) {
        let ElementConstants { bulk, shear, .. } = *self.constants;
        let scratch = &mut *self.scratch;
        let (shear2, third) = (2.0 * shear, 1.0 / 3.0);
        let [rr, zz, around, both] = rates;
        let spin_per = spin.per();
        let per = self.dt * spin_per;
        let [d_rr, d_zz, d_hoop, d_rz] = [per * rr, per * zz, per * around, 0.5 * (per * both)];
        let carried = rotate(at.load_all(self.stress), spin.rotation());
        if self.spin {
            at.store(spin.dividend * spin_per, &mut scratch.strain.spin);
        }
        let dilation = d_rr + d_zz + d_hoop;
        let mean = third * (carried[0] + carried[1] + carried[2]);
        let base = mean + shear2 * third * dilation;
        let deviator = [
            carried[0] - base + shear2 * d_rr,
            carried[1] - base + shear2 * d_zz,
            carried[2] - base + shear2 * d_hoop,
            carried[3] + shear2 * d_rz,
        ];
        at.store_all([d_rr, d_zz, d_hoop, d_rz], &mut scratch.strain.strain);
        at.store_all(carried, &mut scratch.strain.carried);
        at.store_all(deviator, &mut scratch.stress.deviator);
        at.store(mean + bulk * dilation, &mut scratch.stress.mean);
        let volume = UNIT * at.load(&scratch.weight) * spin.divisor;
        at.store(volume, &mut scratch.strain.volume);
        if self.mises {
            let [a, b, c, d] = deviator.inline_map(|s| s * s);
            let square = 1.5 * (a + b + c) + 3.0 * d;
            at.store(square.root(), &mut scratch.stress.trial);
        }
    }
}

/// Computes strain increments at mid-increment, the stress rotated with the material, and the elastic trial stress of
/// quadrilaterals.
#[inline(always)]
pub(super) fn measure<M: Material>(
    stress: &[Lanes; 4],
    constants: &ElementConstants,
    dt: f64,
    nodes: &CornerNodes,
    scratch: &mut TaskWorkspace,
) {
    let (arch, increment) = (scratch.arch, (constants, dt));
    if constants.by_area && !M::MODULI_VARY {
        let measurement = StrainMeasurement::<true>::new::<M>(stress, increment, Some(nodes), scratch);
        dispatch_outlined(arch, measurement);
    } else {
        let measurement = StrainMeasurement::<false>::new::<M>(stress, increment, Some(nodes), scratch);
        dispatch_outlined(arch, measurement);
    }
}

/// Computes the stress rotated with the material, and the mean and the deviator of the elastic trial stress, for the
/// gradients of [`TaskWorkspace::set_gradients`].
#[inline(always)]
pub(super) fn measure_gradients<M: Material>(
    stress: &[Lanes; 4],
    constants: &ElementConstants,
    dt: f64,
    scratch: &mut TaskWorkspace,
) {
    let arch = scratch.arch;
    dispatch_outlined(arch, StrainMeasurement::<false>::new::<M>(stress, (constants, dt), None, scratch));
}

impl<const AREA: bool> WithSimd for StrainMeasurement<'_, AREA> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        if let Some(nodes) = self.nodes {
            combine_corners(self.scratch, nodes);
        }
        for index in 0..PackPosition::<S>::COUNT {
            let position = PackPosition::new(simd, index);
            let gradient = if self.nodes.is_some() { self.gradient(position) } else { self.stored_gradient(position) };
            self.store_trial(position, gradient);
        }
    }
}

/// Combines coordinates and velocities of the corners by [`sums`].
#[inline(always)]
fn combine_corners(scratch: &mut TaskWorkspace, nodes: &CornerNodes) {
    for l in 0..LANES {
        let ([r, z], [v_r, v_z]) = (nodes.places(l).inline_map(sums), nodes.velocities(l).inline_map(sums));
        for i in 0..4 {
            scratch.r[i][l] = r[i];
            scratch.z[i][l] = z[i];
            scratch.v_r[i][l] = v_r[i];
            scratch.v_z[i][l] = v_z[i];
        }
    }
}
