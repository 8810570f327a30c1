//! A block of elements and its update over one increment: the inner loop of deformable bodies. Each phase is a
//! branch-free loop of plain arithmetic over lanes, so that every instruction set gives the same bits.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use pulp::{Arch, NullaryFnOnce};

use super::assumed::AssumedStresses;
use super::constants::ElementConstants;
use super::control::{EnhancedInput, HourglassScheme, PatternSpring};
use super::eroded::ErodedLanes;
use super::forces::CornerForceUpdate;
use super::subzonal::SubzonalPressures;
use crate::element::record::{BlockRecord, RecordUpdate};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, column, dispatch_outlined, inline_from_fn};
use crate::kernel::lists::heap_bytes;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::quad::{QuadOperators, UNIT, at_corners, dot3, sums};
use crate::kernel::real::Real;
use crate::kernel::rotation::{SpinQuotient, rotate, rotate_by_difference};
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::{Material, PlasticFlow};
use crate::state::archive::{Persist, StateArchive, persist_fields, persist_struct};
use crate::state::nodes::{Node, NodeAccelerations};

/// A block of [`LANES`] elements; each quantity is an array over lanes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct ElementBlock<S, T = f64> {
    /// Corner nodes, counter-clockwise.
    pub nodes: [[u32; LANES]; 4],
    /// Cauchy stress: rr, zz, hoop, rz.
    pub stress: [Lanes<T>; 4],
    pub mass: Lanes<T>,
    /// Inverse masses of the corners, combined as by [`sums`].
    pub inverse_mass: [Lanes<T>; 4],
    pub state: S,
}

/// Energy increments and the largest rate of a task in one increment, lane by lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneSums<T = f64> {
    /// Work of the stress.
    pub internal: Lanes<T>,
    /// Plastic dissipation in the increment, energy.
    pub plastic: Lanes<T>,
    /// Elastic energy lost by damage, a part of `plastic`.
    pub damaged: Lanes<T>,
    /// Work of the bulk viscosity.
    pub viscous: Lanes<T>,
    /// Work of the hourglass control.
    pub artificial: Lanes<T>,
    /// Two over the stable time increment of the element that limits each lane, 1/time.
    pub rate: Lanes<T>,
    /// Index of the block with that element; a float, so that lanes select it without a branch.
    pub limiting: Lanes<T>,
}

/// Corner nodes of a block, each as returned by [`Node::as_array`].
///
/// In single precision: the first corner, and the differences of the other corners from it, formed in double precision,
/// because the common part may be far larger than the differences.
///
/// Velocities ahead of a wave decay without limit. Their squares would underflow single precision, where processors are
/// slow. Velocities are therefore rounded to multiples of the spacing of numbers near the speed of sound.
///
/// Loops over lanes read the corners with a stride of four, which compilers turn into a transposition in registers.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct CornerNodes<T = f64>(pub [[[T; 4]; LANES]; 4]);

impl<T: Real> CornerNodes<T> {
    /// Copies the corner nodes `of` a block; in single precision velocities are rounded at the magnitude `sound`.
    #[inline(always)]
    pub fn collect(&mut self, nodes: &[Node], of: &[[u32; LANES]; 4], sound: f64) {
        if T::SINGLE {
            for l in 0..LANES {
                self.put(l, [0, 1, 2, 3].inline_map(|c| nodes[of[c][l] as usize].as_array()), sound);
            }
            return;
        }
        for (to, of) in self.0.iter_mut().zip(of) {
            // Two at once, both read before either is written: one wide store, which later wide loads can forward.
            for (to, two) in to.as_chunks_mut::<2>().0.iter_mut().zip(of.as_chunks::<2>().0) {
                *to = two.inline_map(|node| nodes[node as usize].as_array().inline_map(T::of));
            }
        }
    }

    /// Sets the corner coordinates and velocities of the element in a lane.
    #[inline(always)]
    fn put(&mut self, l: usize, corners: [[f64; 4]; 4], sound: f64) {
        if !T::SINGLE {
            self.0.iter_mut().zip(corners).for_each(|(to, corner)| to[l] = corner.inline_map(T::of));
            return;
        }
        let offset = [0.0, 0.0, sound, sound];
        let [first, others @ ..] = corners;
        let first = [0, 1, 2, 3].inline_map(|k| first[k] + offset[k]);
        let [to, rest @ ..] = &mut self.0;
        to[l] = [0, 1, 2, 3].inline_map(|k| T::of(first[k] - offset[k]));
        for (to, other) in rest.iter_mut().zip(others) {
            to[l] = [0, 1, 2, 3].inline_map(|k| T::of((other[k] + offset[k]) - first[k]));
        }
    }

    /// Returns coordinates and velocities of a lane combined by [`sums`], coordinates times `per_length`.
    #[inline(always)]
    fn sums(&self, l: usize, per_length: T) -> [[T; 4]; 4] {
        [0, 1, 2, 3].inline_map(|component| {
            let x = self.of(l, component);
            if !T::SINGLE {
                return sums(x);
            }
            let [first, b, c, d] = if component < 2 { x.inline_map(|x| x * per_length) } else { x };
            let (above, right) = (c - d, c - b);
            [T::of(4.0) * first + ((b + c) + d), b + above, d + right, above - b]
        })
    }

    /// Replaces a deleted element by a ring of its volume at rest, with radii 1 and 2 in units of `length`. `volume` is
    /// the volume of the element over that of a ring with radii 1 and 2 and height 1.
    pub(super) fn mask(&mut self, l: usize, volume: f64, length: f64) {
        let height = volume / (length * length);
        let places = [[1.0, 0.0], [2.0, 0.0], [2.0, height], [1.0, height]];
        self.put(l, places.inline_map(|[r, z]| [length * r, z, 0.0, 0.0]), 0.0);
    }

    /// Returns one component of the four corners of a lane.
    #[inline(always)]
    pub(super) fn of(&self, l: usize, component: usize) -> [T; 4] {
        let CornerNodes(corners) = self;
        [corners[0][l][component], corners[1][l][component], corners[2][l][component], corners[3][l][component]]
    }
}

/// Hourglass and viscous stresses of the current block at the start of the next increment.
#[repr(C, align(64))]
pub(super) struct HourglassState<T = f64> {
    /// Generalised hourglass stresses along r and z.
    pub(super) hourglass: [Lanes<T>; 2],
    /// Stress of the bulk viscosity.
    pub(super) viscous: Lanes<T>,
    /// Slow part of the volumetric strain rate.
    pub(super) slow_dilation: Lanes<T>,
}

/// Current geometry of the elements of a block: their [`QuadOperators`] and derived quantities.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct BlockGeometry<T = f64> {
    pub(super) r: [Lanes<T>; 3],
    pub(super) z: [Lanes<T>; 3],
    pub(super) hoop: [Lanes<T>; 3],
    pub(super) volume: Lanes<T>,
    /// Hourglass pattern times the volume, in base vectors.
    pub(super) pattern: [Lanes<T>; 3],
    /// Sums over the corners of the squares of all operators, and of the pattern, divided by the corner masses.
    pub(super) squares: Lanes<T>,
    pub(super) light: Lanes<T>,
    /// Bound of the highest frequency times the volume.
    pub(super) root: Lanes<T>,
}

impl<T: Real> BlockGeometry<T> {
    #[inline(always)]
    pub(super) fn operators(&self, l: usize) -> QuadOperators<T> {
        let [r, z, hoop] = [&self.r, &self.z, &self.hoop].inline_map(|list| [list[0][l], list[1][l], list[2][l]]);
        QuadOperators { r, z, hoop, volume: self.volume[l] }
    }

    #[inline(always)]
    pub(super) fn pattern(&self, l: usize) -> [T; 3] {
        [self.pattern[0][l], self.pattern[1][l], self.pattern[2][l]]
    }
}

/// Scratch memory and state of one task.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct TaskWorkspace<T = f64> {
    /// Coordinates and velocities of the corners, combined by [`sums`].
    pub(super) r: [Lanes<T>; 4],
    pub(super) z: [Lanes<T>; 4],
    pub(super) v_r: [Lanes<T>; 4],
    pub(super) v_z: [Lanes<T>; 4],
    /// Volume at the middle of the increment in [`UNIT`], and the inverse that a phase computes once for several
    /// quotients.
    middle: Lanes<T>,
    pub(super) inverse: Lanes<T>,
    /// Geometry in the current configuration.
    pub(super) now: BlockGeometry<T>,
    /// Weight of each lane: 1, or 0 for lanes without an active element.
    pub(super) weight: Lanes<T>,
    /// Kinematics of the block, and the resulting stress update.
    pub(super) strain: StrainIncrement<T>,
    pub(super) stress: StressUpdate<T>,
    pub(super) sums: LaneSums<T>,
    /// Sums of [`Self::energy_sums`] at the start of the block; only with records.
    recorded: [Lanes<T>; 3],
    pub(super) block: T,
    /// Index of the block in the task.
    pub(super) at: usize,
    pub(super) task: TaskState<T>,
    /// Two over the stable time increments of the elements of the block.
    pub(super) own_rate: Lanes<T>,
    /// Unit of lengths and times in those of the model; velocities, stresses and densities have the same value in both.
    pub(super) length: f64,
    /// Bound of the highest frequency of the whole model; infinite if unknown.
    pub(super) cap: T,
    /// Instruction set of the functions that are compiled once for many materials.
    pub(super) arch: Arch,
    /// Largest squares of the strain increment and of the volume change in the pass, lane by lane; computed only with a
    /// finite `cap`.
    pub(super) deformed: [Lanes<T>; 2],
}

/// State of the blocks of a task other than stress and material; each list is empty unless the model needs it.
#[derive(Clone, Debug, Default)]
pub struct TaskState<T = f64> {
    /// Generalised hourglass stresses along r and z; empty without hourglass stiffness.
    pub(super) hourglass: Vec<[Lanes<T>; 2]>,
    /// Stresses of assumed strains; empty without ENHANCED.
    pub(super) enhanced: Vec<AssumedStresses>,
    /// Stresses of the bulk viscosity; empty without bulk viscosity.
    pub(super) viscous: Vec<Lanes<T>>,
    /// Slow parts of volumetric strain rates; empty if the linear bulk viscosity acts on the whole rate.
    pub(super) slow_dilation: Vec<Lanes<T>>,
    /// Subzonal pressures; empty if off.
    pub(super) subzones: Vec<SubzonalPressures>,
    /// Strains and energies for output; empty if not requested.
    pub(super) records: Vec<BlockRecord>,
    /// Elements deleted by `*EROSION`; empty if no element is subject to it.
    pub(super) eroded: Vec<ErodedLanes>,
    /// Two over the stable time increments of elements; empty unless deletion criteria need them and no constant
    /// determines them.
    pub(super) own_rates: Vec<Lanes<T>>,
}

impl<S, T: Real> ElementBlock<S, T> {
    /// Returns the corner masses of a lane in the units of the block.
    pub(super) fn corner_masses(&self, lane: usize) -> [f64; 4] {
        at_corners(column(&self.inverse_mass, lane).inline_map(T::wide)).inline_map(|inverse| 4.0 / inverse)
    }

    /// Sets the corner masses of a lane, in the units of the block.
    pub(super) fn set_corner_masses(&mut self, lane: usize, masses: [f64; 4]) {
        let total = (masses[0] + masses[1]) + (masses[2] + masses[3]);
        self.mass[lane] = T::of(total);
        for (list, sum) in self.inverse_mass.iter_mut().zip(sums(masses.inline_map(|mass| 1.0 / mass))) {
            list[lane] = T::of(sum);
        }
    }
}

impl<S: Clone> ElementBlock<S> {
    /// Updates the block over one increment: stresses and corner forces at its end, and the sums.
    #[inline(always)]
    pub fn update<M: Material<State = S>, const AREA: bool>(
        &mut self,
        material: &M,
        constants: &ElementConstants,
        (dt, before): (f64, NodeAccelerations<'_>),
        nodes: &mut CornerNodes,
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
    ) {
        let eroded = self.mask(material, nodes, scratch);
        let owed =
            M::EQUATION_OF_STATE.then(|| scratch.begin_energy_correction(corners, &self.nodes, (nodes, dt), before));
        self.measure_strain::<M, AREA>(constants, dt, nodes, scratch);
        if M::EQUATION_OF_STATE {
            self.measure_volume::<AREA>(scratch);
        }
        self.finish::<M, AREA>(material, (constants, dt), eroded.as_ref(), nodes, scratch, corners);
        if let Some(owed) = owed {
            scratch.apply_energy_correction(&owed, corners, nodes, dt);
            material.add_heat(&mut self.state, &scratch.stress.heat, &self.mass);
        }
    }

    /// Updates stresses and corner forces; the second part of an increment, when strains are known.
    #[inline(always)]
    pub(super) fn finish<M: Material<State = S>, const AREA: bool>(
        &mut self,
        material: &M,
        (constants, dt): (&ElementConstants, f64),
        eroded: Option<&ErodedLanes>,
        nodes: &CornerNodes,
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
    ) {
        let mut kept = scratch.hourglass_state();
        let enhanced = !scratch.task.enhanced.is_empty();
        let shares = if enhanced { self.shares(material) } else { [1.0; LANES] };
        self.update_stress(material, constants, scratch);
        if enhanced {
            let mut seen = EnhancedInput::default();
            self.forces::<M, _, AREA>((constants, dt), &mut kept, scratch, corners, &mut seen);
            self.enhance::<M, AREA>((material, shares), (constants, dt), (&seen, nodes), scratch, corners);
        } else {
            self.forces::<M, _, AREA>((constants, dt), &mut kept, scratch, corners, &mut PatternSpring);
        }
        scratch.store_hourglass_state(kept);
        if M::EQUATION_OF_STATE {
            scratch.resist_patterns((dt, constants.hourglass.viscosity), nodes, &self.inverse_mass, corners);
        }
        self.clear(material, eroded, corners);
        if M::MODULI_VARY {
            scratch.keep_own_rates();
        }
    }

    /// Computes the current volumes, masses and viscous stresses for an equation of state.
    #[inline(always)]
    fn measure_volume<const AREA: bool>(&self, scratch: &mut TaskWorkspace) {
        for l in 0..LANES {
            let volume = QuadOperators::of::<AREA>(column(&scratch.r, l), column(&scratch.z, l)).volume;
            scratch.strain.current_volume[l] = UNIT * volume;
        }
        scratch.strain.mass = self.mass;
        scratch.strain.viscous = scratch.task.viscous.get(scratch.at).copied().unwrap_or_default();
    }
}

impl<S: Clone, T: Real> ElementBlock<S, T> {
    /// Masks deleted elements before an increment. Returns the elements that were deleted by `*EROSION`.
    #[inline(always)]
    pub(super) fn mask<M: Material<T, State = S>>(
        &mut self,
        material: &M,
        nodes: &mut CornerNodes<T>,
        scratch: &mut TaskWorkspace<T>,
    ) -> Option<ErodedLanes> {
        if M::FAILS {
            self.mask_deleted(material, nodes, scratch);
        }
        let eroded = scratch.task.eroded.get(scratch.at).filter(|e| e.any()).copied();
        if let Some(eroded) = &eroded {
            self.mask_eroded(eroded, nodes, scratch);
        }
        eroded
    }

    /// Clears the forces of deleted elements after an increment.
    #[inline(always)]
    pub(super) fn clear<M: Material<T, State = S>>(
        &mut self,
        material: &M,
        eroded: Option<&ErodedLanes>,
        corners: &mut BlockCornerForces<T>,
    ) {
        if M::FAILS {
            self.clear_deleted(material, corners);
        }
        if let Some(eroded) = eroded {
            self.clear_eroded(eroded, corners);
        }
    }

    /// Computes strain increments and the elastic trial stress, with averaged dilation where it is used.
    #[inline(always)]
    pub(super) fn measure_strain<M: Material<T, State = S>, const AREA: bool>(
        &mut self,
        constants: &ElementConstants,
        dt: T,
        nodes: &CornerNodes<T>,
        scratch: &mut TaskWorkspace<T>,
    ) {
        self.strain::<M, AREA>(constants, dt, nodes, scratch);
        if let Some(averaging) = &scratch.strain.averaging
            && !M::MODULI_VARY
        {
            // The stress follows the averaged strain; its work uses the element's own strain.
            let bulk = T::of(constants.bulk);
            for l in 0..LANES {
                scratch.stress.mean[l] += bulk * T::of(averaging[l]);
            }
        }
        if scratch.cap < T::of(f64::INFINITY) {
            scratch.measure();
        }
    }

    /// Computes the corner forces of stress, bulk viscosity and hourglass control, and the stable time increment.
    #[inline(always)]
    pub(super) fn forces<M: Material<T>, C: HourglassScheme<T>, const AREA: bool>(
        &self,
        increment: (&ElementConstants, T),
        kept: &mut HourglassState<T>,
        scratch: &mut TaskWorkspace<T>,
        corners: &mut BlockCornerForces<T>,
        control: &mut C,
    ) {
        // The conditions are constants of the material: only one branch is compiled.
        if !M::MODULI_VARY {
            self.forces_by::<C, AREA, false, false>(increment, kept, scratch, corners, control);
        } else if !M::EQUATION_OF_STATE {
            self.forces_by::<C, AREA, true, false>(increment, kept, scratch, corners, control);
        } else {
            self.forces_by::<C, AREA, true, true>(increment, kept, scratch, corners, control);
        }
    }

    #[inline(always)]
    fn forces_by<C: HourglassScheme<T>, const AREA: bool, const VARY: bool, const EOS: bool>(
        &self,
        (constants, dt): (&ElementConstants, T),
        kept: &mut HourglassState<T>,
        scratch: &mut TaskWorkspace<T>,
        corners: &mut BlockCornerForces<T>,
        control: &mut C,
    ) {
        let ElementBlock { stress, mass, inverse_mass, .. } = self;
        let arch = scratch.arch;
        dispatch_outlined(
            arch,
            CornerForceUpdate::<C, T, AREA, VARY, EOS> {
                stress,
                mass,
                inverse_mass,
                constants,
                dt,
                kept,
                scratch,
                corners,
                control,
            },
        );
    }

    #[inline(always)]
    pub(super) fn update_stress<M: Material<T, State = S>>(
        &mut self,
        material: &M,
        constants: &ElementConstants,
        scratch: &mut TaskWorkspace<T>,
    ) {
        material.update(&mut self.state, &mut self.stress, &scratch.strain, &mut scratch.stress);
        if !matches!(M::FLOW, PlasticFlow::None) && !constants.hourglass.relaxes {
            scratch.stress.returned = [T::ONE; LANES];
        }
    }

    /// Computes strain increments at mid-increment, rotates the stress, and computes the elastic trial stress.
    #[inline(always)]
    pub(super) fn strain<M: Material<T>, const AREA: bool>(
        &mut self,
        constants: &ElementConstants,
        dt: T,
        nodes: &CornerNodes<T>,
        scratch: &mut TaskWorkspace<T>,
    ) {
        dispatch_outlined(scratch.arch, VelocityGradient::<T, AREA> { scratch, dt, nodes });
        self.trial::<M>(constants, dt, scratch);
    }

    /// Rotates the stress with the material, and computes the mean and the deviator of the elastic trial stress.
    #[inline(always)]
    pub(super) fn trial<M: Material<T>>(
        &mut self,
        constants: &ElementConstants,
        dt: T,
        scratch: &mut TaskWorkspace<T>,
    ) {
        let (bulk, shear2) = (T::of(constants.bulk), T::of(2.0 * constants.shear));
        let (half, third, unit) = (T::of(0.5), T::of(1.0 / 3.0), T::of(UNIT));
        for l in 0..LANES {
            let ([rr, zz, around, both], difference) = (column(&scratch.strain.strain, l), scratch.strain.spin[l]);
            let spin = SpinQuotient { dividend: difference, divisor: scratch.middle[l], inverse: scratch.inverse[l] };
            let per = dt * spin.per();
            let (d_rr, d_zz, d_hoop, d_rz) = (per * rr, per * zz, per * around, half * (per * both));
            let stress = column(&self.stress, l);
            let carried = if T::SINGLE {
                rotate_by_difference(stress, spin.rotation_difference())
            } else {
                rotate(stress, spin.rotation())
            };
            if M::USES_SPIN || T::SINGLE {
                scratch.strain.spin[l] = difference * spin.per();
            }
            let dilation = d_rr + d_zz + d_hoop;
            let mean = (carried[0] + carried[1] + carried[2]) * third;
            let base = mean + shear2 * third * dilation;
            let deviator = [
                carried[0] - base + shear2 * d_rr,
                carried[1] - base + shear2 * d_zz,
                carried[2] - base + shear2 * d_hoop,
                carried[3] + shear2 * d_rz,
            ];
            for (i, d) in [d_rr, d_zz, d_hoop, d_rz].into_iter().enumerate() {
                scratch.strain.strain[i][l] = d;
                scratch.strain.carried[i][l] = carried[i];
                scratch.stress.deviator[i][l] = deviator[i];
            }
            scratch.stress.mean[l] = if T::SINGLE { bulk * dilation } else { mean + bulk * dilation };
            scratch.strain.volume[l] = unit * scratch.weight[l] * scratch.middle[l];
            if matches!(M::FLOW, PlasticFlow::Deviatoric | PlasticFlow::Unknown) {
                let [a, b, c, d] = deviator.inline_map(|s| s * s);
                scratch.stress.trial[l] = (T::of(1.5) * (a + b + c) + T::of(3.0) * d).root();
            }
        }
        if !(M::USES_SPIN || T::SINGLE || scratch.task.records.is_empty()) {
            scratch.divide_spins();
        }
    }
}

/// Operation that computes the velocity gradient of a block.
struct VelocityGradient<'a, T, const AREA: bool> {
    scratch: &'a mut TaskWorkspace<T>,
    dt: T,
    nodes: &'a CornerNodes<T>,
}

impl<T: Real, const AREA: bool> NullaryFnOnce for VelocityGradient<'_, T, AREA> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.scratch.velocity_gradient::<AREA>(self.dt, self.nodes);
    }
}

impl<T: Real> TaskWorkspace<T> {
    /// Computes positions and velocities of the corners, and the velocity gradient at mid-increment times the volume
    /// there: `strain` is rr, zz, hoop and the sum of rz and zr; `spin` is half the difference of rz and zr times the
    /// increment. The division ends the loop body, so that later lanes do not wait for its result.
    #[inline(always)]
    fn velocity_gradient<const AREA: bool>(&mut self, dt: T, nodes: &CornerNodes<T>) {
        let half = T::of(0.5) * dt;
        let per_length = T::of(1.0 / self.length);
        for l in 0..LANES {
            let [r, z, v_r, v_z] = nodes.sums(l, per_length);
            for i in 0..4 {
                self.r[i][l] = r[i];
                self.z[i][l] = z[i];
                self.v_r[i][l] = v_r[i];
                self.v_z[i][l] = v_z[i];
            }
            let middle = |x: [T; 4], v: [T; 4]| [0, 1, 2, 3].inline_map(|i| x[i] - half * v[i]);
            let g = QuadOperators::of::<AREA>(middle(r, v_r), middle(z, v_z));
            let (along_r, along_z) = ([v_r[1], v_r[2], v_r[3]], [v_z[1], v_z[2], v_z[3]]);
            let (rz, zr) = (dot3(g.z, along_r), dot3(g.r, along_z));
            self.strain.strain[0][l] = dot3(g.r, along_r);
            self.strain.strain[1][l] = dot3(g.z, along_z);
            self.strain.strain[2][l] = dot3(g.hoop, [v_r[0], v_r[1], v_r[2]]);
            self.strain.strain[3][l] = rz + zr;
            let spin = SpinQuotient::new(half * (rz - zr), g.volume);
            self.strain.spin[l] = spin.dividend;
            self.middle[l] = spin.divisor;
            self.inverse[l] = spin.inverse;
        }
    }

    /// Sets the velocity gradients (rr, zz, hoop, rz, zr) at mid-increment times the volumes there, in [`UNIT`], for
    /// elements of another shape.
    #[inline(always)]
    pub(super) fn set_gradients(&mut self, dt: T, gradients: &[Lanes<T>; 5], volume: &Lanes<T>) {
        let [rr, zz, hoop, rz, zr] = gradients;
        self.strain.strain = [*rr, *zz, *hoop, inline_from_fn(|l| rz[l] + zr[l])];
        for l in 0..LANES {
            let spin = SpinQuotient::new(T::of(0.5) * dt * (rz[l] - zr[l]), volume[l]);
            (self.strain.spin[l], self.middle[l], self.inverse[l]) = (spin.dividend, spin.divisor, spin.inverse);
        }
    }

    /// Creates the scratch memory of a task of `blocks` blocks, with storage for hourglass and viscous stresses if the
    /// constants require it; `length` is the unit of lengths. Frequencies are not capped.
    pub fn new(constants: &ElementConstants, length: f64, blocks: usize) -> Self {
        let stiff = constants.hourglass.stiffness != 0.0;
        let enhanced = constants.hourglass.enhanced != 0.0;
        let (viscous, filtered) = (!constants.bulk_viscosity.is_none(), constants.bulk_viscosity.filters());
        TaskWorkspace {
            cap: T::of(f64::INFINITY),
            length,
            task: TaskState {
                hourglass: if stiff { vec![[[T::ZERO; LANES]; 2]; blocks] } else { Vec::new() },
                enhanced: if enhanced { vec![AssumedStresses::default(); blocks] } else { Vec::new() },
                viscous: if viscous { vec![[T::ZERO; LANES]; blocks] } else { Vec::new() },
                slow_dilation: if filtered { vec![[T::ZERO; LANES]; blocks] } else { Vec::new() },
                ..TaskState::default()
            },
            ..TaskWorkspace::default()
        }
    }

    pub(super) fn bytes(&self) -> usize {
        let TaskState { hourglass, enhanced, viscous, slow_dilation, subzones, records, eroded, own_rates } =
            &self.task;
        heap_bytes(hourglass)
            + heap_bytes(enhanced)
            + heap_bytes(viscous)
            + heap_bytes(slow_dilation)
            + heap_bytes(subzones)
            + heap_bytes(records)
            + heap_bytes(eroded)
            + heap_bytes(own_rates)
    }

    /// Allocates the state of deletion by `*EROSION` for `blocks` blocks.
    pub(super) fn make_erodible(&mut self, blocks: usize) {
        self.task.eroded = vec![ErodedLanes::default(); blocks];
    }

    /// Allocates the rates of elements for `blocks` blocks.
    pub(super) fn store_rates(&mut self, blocks: usize) {
        self.task.own_rates.resize(blocks, [T::ZERO; LANES]);
    }

    /// Stores the rates of the current block if a list for them exists.
    #[inline(always)]
    fn keep_own_rates(&mut self) {
        if let Some(rates) = self.task.own_rates.get_mut(self.at) {
            *rates = self.own_rate;
        }
    }

    /// Sets the weight of a lane without an active element to zero.
    pub(super) fn mask(&mut self, lane: usize) {
        self.weight[lane] = T::ZERO;
    }

    /// Returns whether a lane has an active element.
    pub(super) fn is_active(&self, lane: usize) -> bool {
        self.weight[lane] > T::ZERO
    }

    /// Returns the index of the current block, as a float as in the sums.
    pub(super) fn number(&self) -> T {
        self.block
    }

    /// Returns the stored stresses of the current block; zero without storage.
    #[inline(always)]
    pub(super) fn hourglass_state(&self) -> HourglassState<T> {
        HourglassState {
            hourglass: self.task.hourglass.get(self.at).copied().unwrap_or_default(),
            viscous: self.task.viscous.get(self.at).copied().unwrap_or_default(),
            slow_dilation: self.task.slow_dilation.get(self.at).copied().unwrap_or_default(),
        }
    }

    /// Stores the stresses until the next increment.
    #[inline(always)]
    pub(super) fn store_hourglass_state(&mut self, kept: HourglassState<T>) {
        if let Some(place) = self.task.hourglass.get_mut(self.at) {
            *place = kept.hourglass;
        }
        if let Some(place) = self.task.viscous.get_mut(self.at) {
            *place = kept.viscous;
        }
        if let Some(place) = self.task.slow_dilation.get_mut(self.at) {
            *place = kept.slow_dilation;
        }
    }

    /// Returns the sums of the pass, and the squares of the largest strain increment and volume change.
    pub(super) fn parts(&self) -> (LaneSums, [Lanes; 2]) {
        let StressUpdate { internal, dissipated, damaged, .. } = self.stress;
        let sums = LaneSums { internal, plastic: dissipated, damaged, ..self.sums };
        (sums.wide(self.length), self.deformed.inline_map(|list| list.inline_map(T::wide)))
    }

    /// Begins a pass with the bound `cap` of the highest frequency.
    #[inline(always)]
    pub(super) fn begin(&mut self, arch: Arch, cap: f64, dt: f64, constants: &ElementConstants) {
        self.arch = arch;
        self.sums = LaneSums::default();
        self.stress.begin();
        self.strain.dt = dt;
        self.strain.moduli = ElasticModuli { bulk: constants.bulk, shear: constants.shear };
        self.strain.viscosity = constants.shear_viscosity;
        (self.cap, self.deformed) = (T::of(cap * self.length), [[T::ZERO; LANES]; 2]);
    }

    /// Updates the record of the block `index` of the task.
    #[inline(never)]
    pub(super) fn update_record(
        &mut self,
        arch: Arch,
        index: usize,
        stress: &[Lanes<T>; 4],
        flow: PlasticFlow,
        (spins, dt): (Lanes, f64),
    ) {
        let unit = self.length * self.length * self.length;
        let sums = self.energy_sums();
        let grown = |i: usize| inline_from_fn(|l| unit * (sums[i][l] - self.recorded[i][l]).wide());
        let energies = [0, 1, 2].inline_map(grown);
        let (increment, update, record) = (&self.strain, &self.stress, &mut self.task.records[index]);
        record.add_energies(&energies);
        arch.dispatch(RecordUpdate { record, stress, flow, spins, dt, unit, increment, update });
    }

    /// Adds work of the stress, and loss by damage, to the record of a lane in the block `index`, if records exist;
    /// energies in the units of the model.
    pub(super) fn add_to_record(&mut self, index: usize, lane: usize, energies: [f64; 2]) {
        if let Some(record) = self.task.records.get_mut(index) {
            record.add_to_lane(lane, energies);
        }
    }

    /// Returns the sums of the pass that records take: work of the stress, of hourglass control, and loss by damage.
    fn energy_sums(&self) -> [Lanes<T>; 3] {
        [self.stress.internal, self.sums.artificial, self.stress.damaged]
    }

    /// Computes the spin increments if only records need them.
    #[inline(always)]
    fn divide_spins(&mut self) {
        for l in 0..LANES {
            let (dividend, divisor, inverse) = (self.strain.spin[l], self.middle[l], self.inverse[l]);
            self.strain.spin[l] = dividend * SpinQuotient { dividend, divisor, inverse }.per();
        }
    }

    /// Updates the largest strain increment and volume change of the pass.
    #[inline(always)]
    pub(super) fn measure(&mut self) {
        for l in 0..LANES {
            let [rr, zz, hoop, rz] = column(&self.strain.strain, l);
            let square = self.weight[l] * ((rr * rr + zz * zz) + (hoop * hoop + T::of(2.0) * rz * rz));
            let dilation = self.weight[l] * (rr + zz + hoop);
            self.deformed[0][l] = larger(square, self.deformed[0][l]);
            self.deformed[1][l] = larger(dilation * dilation, self.deformed[1][l]);
        }
    }

    /// Prepares for block number `block`, at index `at` of the task. Its first `count` lanes hold elements; the others
    /// get weight 0.
    #[inline(always)]
    pub fn prepare(&mut self, block: usize, at: usize, count: usize) {
        self.block = T::of(block as f64);
        self.at = at;
        self.strain.count = count.min(LANES);
        self.weight = [T::ONE; LANES];
        if count < LANES {
            self.weight[count..].fill(T::ZERO);
        }
        if !self.task.records.is_empty() {
            self.recorded = self.energy_sums();
        }
    }
}

impl<T: Real> TaskWorkspace<T> {
    /// Adds the sums of a block that was updated with other scratch memory.
    pub(super) fn add_sums(&mut self, block: &TaskWorkspace<T>) {
        self.sums.add(&block.sums);
        for l in 0..LANES {
            self.stress.internal[l] += block.stress.internal[l];
            self.stress.dissipated[l] += block.stress.dissipated[l];
            self.stress.damaged[l] += block.stress.damaged[l];
            for (most, list) in self.deformed.iter_mut().zip(&block.deformed) {
                most[l] = larger(list[l], most[l]);
            }
        }
        self.stress.deleted += block.stress.deleted;
    }
}

impl<T: Real> LaneSums<T> {
    /// Converts the sums to double precision and to the units of the model; `length` is the unit of lengths.
    fn wide(&self, length: f64) -> LaneSums {
        let volume = length * length * length;
        let energies = |list: &Lanes<T>| list.inline_map(|x| volume * x.wide());
        LaneSums {
            internal: energies(&self.internal),
            plastic: energies(&self.plastic),
            damaged: energies(&self.damaged),
            viscous: energies(&self.viscous),
            artificial: energies(&self.artificial),
            rate: self.rate.inline_map(|x| x.wide() / length),
            limiting: self.limiting.inline_map(T::wide),
        }
    }
}

impl<T: Real> LaneSums<T> {
    /// Adds the sums of later blocks, lane by lane.
    fn add(&mut self, later: &LaneSums<T>) {
        for l in 0..LANES {
            self.internal[l] += later.internal[l];
            self.plastic[l] += later.plastic[l];
            self.damaged[l] += later.damaged[l];
            self.viscous[l] += later.viscous[l];
            self.artificial[l] += later.artificial[l];
            if is_larger(later.rate[l], self.rate[l]) {
                (self.rate[l], self.limiting[l]) = (later.rate[l], later.limiting[l]);
            }
        }
    }
}

/// Returns the larger of two numbers; `b` if either is NaN.
#[inline(always)]
pub(super) fn larger<T: Real>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Returns whether `rate` replaces the largest rate so far. NaN counts as the largest, and the first NaN is kept, so
/// that the element with the error is reported.
#[inline(always)]
pub fn is_larger<T: Real>(rate: T, largest: T) -> bool {
    (rate > largest) | (rate.is_none() & !largest.is_none())
}

/// Returns the sum over lanes, always in the same order.
pub fn across(list: &Lanes) -> f64 {
    let mut sums = *list;
    let mut width = LANES / 2;
    while width > 0 {
        for l in 0..width {
            sums[l] += sums[l + width];
        }
        width /= 2;
    }
    sums[0]
}

persist_struct!(ElementBlock<S, T> [S: Persist, T: Persist] { stress, mass, inverse_mass, state } derived { nodes });

persist_struct!(LaneSums<T> [T: Persist] { internal, plastic, damaged, viscous, artificial, rate, limiting });

persist_struct!(TaskState<T> [T: Persist] {
    eroded: fixed, own_rates: fixed, records: fixed, hourglass: fixed, enhanced: fixed, viscous: fixed,
    slow_dilation: fixed, subzones: fixed
});

// The other fields are scratch memory of one pass; the sums stay valid while a task is quiescent.
persist_struct!(TaskWorkspace<T> [T: Persist] { sums, task } derived { stress, recorded, r, z, v_r, v_z, middle, inverse, now, weight, strain, block, at, own_rate, length, cap, arch, deformed } then TaskWorkspace::persist_work);

impl<T: Persist> TaskWorkspace<T> {
    fn persist_work(&mut self, archive: &mut StateArchive<'_>) {
        persist_fields!(archive; &mut self.stress.internal, &mut self.stress.dissipated, &mut self.stress.damaged);
    }
}
