//! A block of elements and what one increment does to it: the inner loop of deformable bodies.
//! Each phase is a loop of plain arithmetic over lanes, without a branch, so that every instruction set gives the same
//! bits. Never here: which elements a block holds, threads.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use pulp::{Arch, NullaryFnOnce};

use super::assumed::Assumed;
use super::constants::Constants;
use super::control::{Control, Seen, Spring};
use super::eroded::Eroded;
use super::forces::CornerForces;
use super::subzonal::Subzones;
use crate::element::record::{Following, Record};
use crate::kernel::lanes::{Corners, InlineMap, LANES, Lanes, column, dispatch_outlined, inline_from_fn};
use crate::kernel::lists::heap_bytes;
use crate::kernel::moduli::Moduli;
use crate::kernel::quad::{Operators, UNIT, at_corners, dot3, sums};
use crate::kernel::real::Real;
use crate::kernel::rotation::{SpinOver, turned, turned_by};
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::{Material, PlasticFlow};
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};
use crate::state::nodes::{Accelerated, Node};

/// Elements side by side, each quantity an array over lanes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct ElementBlock<S, T = f64> {
    /// Nodes at the corners, counter-clockwise.
    pub nodes: [[u32; LANES]; 4],
    /// Cauchy stress: rr, zz, hoop, rz.
    pub stress: [Lanes<T>; 4],
    pub mass: Lanes<T>,
    /// One over the masses of the corners, as [`sums`].
    pub inverse_mass: [Lanes<T>; 4],
    pub state: S,
}

/// Sums over blocks in one increment, lane by lane: energies that were added, and the largest rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums<T = f64> {
    /// Work of the stress.
    pub internal: Lanes<T>,
    /// Plastic dissipation.
    pub plastic: Lanes<T>,
    /// Work of the bulk viscosity.
    pub viscous: Lanes<T>,
    /// Work of the hourglass control.
    pub artificial: Lanes<T>,
    /// Two over the stable increment of the element that limits each lane.
    pub rate: Lanes<T>,
    /// Block of that element; a float, so that lanes choose it side by side.
    pub limiting: Lanes<T>,
}

/// The corner nodes of a block beside each other, each as [`Node::as_array`] gives it; in single precision the first, and the
/// differences of the others from it, formed in double precision: what is common to all corners may be far larger. Loops over
/// lanes read them with a stride of four, which compilers turn into a transposition in registers. Ahead of a wave velocities fall
/// off without end, and squares of them leave the range of single precision, where processors are slow: there velocities are
/// rounded as they would be beside the speed of sound.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct Nodes<T = f64>(pub [[[T; 4]; LANES]; 4]);

impl<T: Real> Nodes<T> {
    /// Copies the corner nodes of a block; in single precision velocities are rounded beside the speed `sound`.
    #[inline(always)]
    pub fn collect(&mut self, nodes: &[Node], of: &[[u32; LANES]; 4], sound: f64) {
        if T::SINGLE {
            for l in 0..LANES {
                self.put(l, [0, 1, 2, 3].inline_map(|c| nodes[of[c][l] as usize].as_array()), sound);
            }
            return;
        }
        for (to, of) in self.0.iter_mut().zip(of) {
            // Two at once, both read before either is written: one wide store, which the wide loads behind can take up.
            for (to, two) in to.as_chunks_mut::<2>().0.iter_mut().zip(of.as_chunks::<2>().0) {
                *to = two.inline_map(|node| nodes[node as usize].as_array().inline_map(T::of));
            }
        }
    }

    /// Puts the corners of a lane.
    #[inline(always)]
    fn put(&mut self, l: usize, corners: [[f64; 4]; 4], sound: f64) {
        if !T::SINGLE {
            self.0.iter_mut().zip(corners).for_each(|(to, corner)| to[l] = corner.inline_map(T::of));
            return;
        }
        let beside = [0.0, 0.0, sound, sound];
        let [first, others @ ..] = corners;
        let first = [0, 1, 2, 3].inline_map(|k| first[k] + beside[k]);
        let [to, rest @ ..] = &mut self.0;
        to[l] = [0, 1, 2, 3].inline_map(|k| T::of(first[k] - beside[k]));
        for (to, other) in rest.iter_mut().zip(others) {
            to[l] = [0, 1, 2, 3].inline_map(|k| T::of((other[k] + beside[k]) - first[k]));
        }
    }

    /// Coordinates and velocities of a lane as [`sums`], coordinates over a length.
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

    /// Puts an element that is not there where nothing can go wrong: at rest as a ring of this volume over that of a ring of
    /// height 1 from r = 1 to 2, from r = 1 to 2 in units of `length`.
    pub(super) fn mask(&mut self, l: usize, volume: f64, length: f64) {
        let height = volume / (length * length);
        let places = [[1.0, 0.0], [2.0, 0.0], [2.0, height], [1.0, height]];
        self.put(l, places.inline_map(|[r, z]| [length * r, z, 0.0, 0.0]), 0.0);
    }

    /// One component of the four corners of a lane.
    #[inline(always)]
    pub(super) fn of(&self, l: usize, component: usize) -> [T; 4] {
        let Nodes(corners) = self;
        [corners[0][l][component], corners[1][l][component], corners[2][l][component], corners[3][l][component]]
    }
}

/// Hourglass and viscous stresses of the current block, which the next increment starts from.
#[repr(C, align(64))]
pub(super) struct HourglassState<T = f64> {
    /// Generalised hourglass stresses along r and z.
    pub(super) hourglass: [Lanes<T>; 2],
    /// Stress of the bulk viscosity.
    pub(super) viscous: Lanes<T>,
}

/// Elements of a block where they are: their [`Operators`], and what follows from them.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Geometry<T = f64> {
    pub(super) r: [Lanes<T>; 3],
    pub(super) z: [Lanes<T>; 3],
    pub(super) hoop: [Lanes<T>; 3],
    pub(super) volume: Lanes<T>,
    /// The hourglass pattern times the volume, by base vectors.
    pub(super) pattern: [Lanes<T>; 3],
    /// Sums over the corners of the squares of all operators, and of that pattern, over their masses.
    pub(super) squares: Lanes<T>,
    pub(super) light: Lanes<T>,
    /// Bound of the highest frequency times the volume.
    pub(super) root: Lanes<T>,
}

impl<T: Real> Geometry<T> {
    #[inline(always)]
    pub(super) fn operators(&self, l: usize) -> Operators<T> {
        let [r, z, hoop] = [&self.r, &self.z, &self.hoop].inline_map(|list| [list[0][l], list[1][l], list[2][l]]);
        Operators { r, z, hoop, volume: self.volume[l] }
    }

    #[inline(always)]
    pub(super) fn pattern(&self, l: usize) -> [T; 3] {
        [self.pattern[0][l], self.pattern[1][l], self.pattern[2][l]]
    }
}

/// Scratch memory of one task.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub struct Workspace<T = f64> {
    /// Coordinates and velocities of the corners, as [`sums`].
    pub(super) r: [Lanes<T>; 4],
    pub(super) z: [Lanes<T>; 4],
    pub(super) v_r: [Lanes<T>; 4],
    pub(super) v_z: [Lanes<T>; 4],
    /// Volume at the middle of the increment in the unit [`UNIT`], and what one division of a phase came to.
    middle: Lanes<T>,
    pub(super) inverse: Lanes<T>,
    /// The elements where they are now.
    pub(super) now: Geometry<T>,
    /// 0 for lanes without element.
    pub(super) weight: Lanes<T>,
    /// Kinematics of the block, and the stress update that its material makes of them.
    pub(super) strain: StrainIncrement<T>,
    pub(super) stress: StressUpdate<T>,
    pub(super) sums: Sums<T>,
    pub(super) block: T,
    /// Place of the block in the task.
    pub(super) at: usize,
    pub(super) task: TaskState<T>,
    /// Two over the stable increments of the elements of the block.
    pub(super) own_rate: Lanes<T>,
    /// Unit of lengths and times, in those of the scene; velocities, stresses and densities have the same in both.
    pub(super) length: f64,
    /// Highest frequency of the whole scene, where it is known to be lower than those of single elements; infinite if not.
    pub(super) cap: T,
    /// Instruction set of what is compiled once for many materials.
    pub(super) arch: Arch,
    /// Squares of the largest strain increment of the pass and of the largest change of volume, lane by lane; followed only
    /// under a cap.
    pub(super) deformed: [Lanes<T>; 2],
}

/// State of the blocks of a task beside stress and material: what options of the deck request.
#[derive(Clone, Debug, Default)]
pub struct TaskState<T = f64> {
    /// Generalised hourglass stresses along r and z; empty without hourglass stiffness.
    pub(super) hourglass: Vec<[Lanes<T>; 2]>,
    /// Stresses of assumed strains; empty without ENHANCED.
    pub(super) enhanced: Vec<Assumed>,
    /// Stresses of the bulk viscosity; empty without any.
    pub(super) viscous: Vec<Lanes<T>>,
    /// Quarters of elements; empty without subzonal pressures.
    pub(super) subzones: Vec<Subzones>,
    /// Strains and energies that outputs request; empty if none does.
    pub(super) records: Vec<Record>,
    /// Elements that were deleted from outside; empty where none can be.
    pub(super) eroded: Vec<Eroded>,
    /// Two over the stable increments of elements; empty unless elements are judged by them and no constant gives them.
    pub(super) own_rates: Vec<Lanes<T>>,
}

impl<S, T: Real> ElementBlock<S, T> {
    /// Masses of the corners of a lane, in the units of the block.
    pub(super) fn corner_masses(&self, lane: usize) -> [f64; 4] {
        at_corners(column(&self.inverse_mass, lane).inline_map(T::wide)).inline_map(|inverse| 4.0 / inverse)
    }

    /// Gives the corners of a lane other masses, in the units of the block.
    pub(super) fn set_corner_masses(&mut self, lane: usize, masses: [f64; 4]) {
        let total = (masses[0] + masses[1]) + (masses[2] + masses[3]);
        self.mass[lane] = T::of(total);
        for (list, sum) in self.inverse_mass.iter_mut().zip(sums(masses.inline_map(|mass| 1.0 / mass))) {
            list[lane] = T::of(sum);
        }
    }
}

impl<S: Clone> ElementBlock<S> {
    /// One increment: stresses at its end, corner forces, and what is added to the sums.
    #[inline(always)]
    pub fn update<M: Material<State = S>, const AREA: bool>(
        &mut self,
        material: &M,
        constants: &Constants,
        (dt, before): (f64, Accelerated<'_>),
        nodes: &mut Nodes,
        scratch: &mut Workspace,
        corners: &mut Corners,
    ) {
        let eroded = self.mask(material, nodes, scratch);
        let owed = M::EQUATION_OF_STATE.then(|| scratch.owe(corners, &self.nodes, (nodes, dt), before));
        self.measure_strain::<M, AREA>(constants, dt, nodes, scratch);
        if M::EQUATION_OF_STATE {
            self.measure_volume::<AREA>(scratch);
        }
        self.finish::<M, AREA>(material, (constants, dt), eroded.as_ref(), nodes, scratch, corners);
        if let Some(owed) = owed {
            scratch.pay(&owed, corners, nodes, dt);
            material.add_heat(&mut self.state, &scratch.stress.heat, &self.mass);
        }
    }

    /// The second part of an increment, whose strains are known: stresses and corner forces.
    #[inline(always)]
    pub(super) fn finish<M: Material<State = S>, const AREA: bool>(
        &mut self,
        material: &M,
        (constants, dt): (&Constants, f64),
        eroded: Option<&Eroded>,
        nodes: &Nodes,
        scratch: &mut Workspace,
        corners: &mut Corners,
    ) {
        let mut kept = scratch.kept();
        let enhanced = !scratch.task.enhanced.is_empty();
        let shares = if enhanced { self.shares(material) } else { [1.0; LANES] };
        self.update_stress(material, constants, scratch);
        if enhanced {
            let mut seen = Seen::default();
            self.forces::<M, _, AREA>((constants, dt), &mut kept, scratch, corners, &mut seen);
            self.enhance::<M, AREA>((material, shares), (constants, dt), (&seen, nodes), scratch, corners);
        } else {
            self.forces::<M, _, AREA>((constants, dt), &mut kept, scratch, corners, &mut Spring);
        }
        scratch.keep(kept);
        if M::EQUATION_OF_STATE {
            scratch.resist_patterns((dt, constants.hourglass.viscosity), nodes, &self.inverse_mass, corners);
        }
        self.clear(material, eroded, corners);
        if M::MODULI_VARY {
            scratch.keep_own_rates();
        }
    }

    /// Current volumes, masses and viscous stresses, which an equation of state uses.
    #[inline(always)]
    fn measure_volume<const AREA: bool>(&self, scratch: &mut Workspace) {
        for l in 0..LANES {
            let volume = Operators::of::<AREA>(column(&scratch.r, l), column(&scratch.z, l)).volume;
            scratch.strain.current_volume[l] = UNIT * volume;
        }
        scratch.strain.mass = self.mass;
        scratch.strain.viscous = scratch.task.viscous.get(scratch.at).copied().unwrap_or_default();
    }
}

impl<S: Clone, T: Real> ElementBlock<S, T> {
    /// Before an increment: masks deleted elements. Returns those that were deleted from outside.
    #[inline(always)]
    pub(super) fn mask<M: Material<T, State = S>>(
        &mut self,
        material: &M,
        nodes: &mut Nodes<T>,
        scratch: &mut Workspace<T>,
    ) -> Option<Eroded> {
        if M::FAILS {
            self.mask_deleted(material, nodes, scratch);
        }
        let eroded = scratch.task.eroded.get(scratch.at).filter(|e| e.any()).copied();
        if let Some(eroded) = &eroded {
            self.mask_eroded(eroded, nodes, scratch);
        }
        eroded
    }

    /// After the increment: clears the forces of deleted elements.
    #[inline(always)]
    pub(super) fn clear<M: Material<T, State = S>>(
        &mut self,
        material: &M,
        eroded: Option<&Eroded>,
        corners: &mut Corners<T>,
    ) {
        if M::FAILS {
            self.clear_deleted(material, corners);
        }
        if let Some(eroded) = eroded {
            self.clear_eroded(eroded, corners);
        }
    }

    /// Strain increments and elastic trial, with averaged dilation where elements have it.
    #[inline(always)]
    pub(super) fn measure_strain<M: Material<T, State = S>, const AREA: bool>(
        &mut self,
        constants: &Constants,
        dt: T,
        nodes: &Nodes<T>,
        scratch: &mut Workspace<T>,
    ) {
        self.strain::<M, AREA>(constants, dt, nodes, scratch);
        if let Some(averaging) = &scratch.strain.averaging
            && !M::MODULI_VARY
        {
            // The stress answers to the averaged strain; its work is done on the element's own.
            let bulk = T::of(constants.bulk);
            for l in 0..LANES {
                scratch.stress.mean[l] += bulk * T::of(averaging[l]);
            }
        }
        if scratch.cap < T::of(f64::INFINITY) {
            scratch.measure();
        }
    }

    /// Corner forces of stress, bulk viscosity and hourglass control, and the stable increment.
    #[inline(always)]
    pub(super) fn forces<M: Material<T>, C: Control<T>, const AREA: bool>(
        &self,
        increment: (&Constants, T),
        kept: &mut HourglassState<T>,
        scratch: &mut Workspace<T>,
        corners: &mut Corners<T>,
        control: &mut C,
    ) {
        // Branches of which compilers keep the one that the material takes.
        if !M::MODULI_VARY {
            self.forces_by::<C, AREA, false, false>(increment, kept, scratch, corners, control);
        } else if !M::EQUATION_OF_STATE {
            self.forces_by::<C, AREA, true, false>(increment, kept, scratch, corners, control);
        } else {
            self.forces_by::<C, AREA, true, true>(increment, kept, scratch, corners, control);
        }
    }

    #[inline(always)]
    fn forces_by<C: Control<T>, const AREA: bool, const VARY: bool, const EOS: bool>(
        &self,
        (constants, dt): (&Constants, T),
        kept: &mut HourglassState<T>,
        scratch: &mut Workspace<T>,
        corners: &mut Corners<T>,
        control: &mut C,
    ) {
        let ElementBlock { stress, mass, inverse_mass, .. } = self;
        let arch = scratch.arch;
        dispatch_outlined(
            arch,
            CornerForces::<C, T, AREA, VARY, EOS> {
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
        constants: &Constants,
        scratch: &mut Workspace<T>,
    ) {
        material.update(&mut self.state, &mut self.stress, &scratch.strain, &mut scratch.stress);
        if !matches!(M::FLOW, PlasticFlow::None) && !constants.hourglass.relaxes {
            scratch.stress.returned = [T::ONE; LANES];
        }
    }

    /// Strain increments at the middle of the increment, the rotation of the stress, the elastic trial.
    #[inline(always)]
    pub(super) fn strain<M: Material<T>, const AREA: bool>(
        &mut self,
        constants: &Constants,
        dt: T,
        nodes: &Nodes<T>,
        scratch: &mut Workspace<T>,
    ) {
        dispatch_outlined(scratch.arch, VelocityGradient::<T, AREA> { scratch, dt, nodes });
        self.trial::<M>(constants, dt, scratch);
    }

    /// The stress turned with the material, and the elastic trial of its mean and deviator.
    #[inline(always)]
    pub(super) fn trial<M: Material<T>>(&mut self, constants: &Constants, dt: T, scratch: &mut Workspace<T>) {
        let (bulk, shear2) = (T::of(constants.bulk), T::of(2.0 * constants.shear));
        let (half, third, unit) = (T::of(0.5), T::of(1.0 / 3.0), T::of(UNIT));
        for l in 0..LANES {
            let ([rr, zz, around, both], difference) = (column(&scratch.strain.strain, l), scratch.strain.spin[l]);
            let spin = SpinOver { dividend: difference, divisor: scratch.middle[l], inverse: scratch.inverse[l] };
            let per = dt * spin.per();
            let (d_rr, d_zz, d_hoop, d_rz) = (per * rr, per * zz, per * around, half * (per * both));
            let stress = column(&self.stress, l);
            let carried = if T::SINGLE { turned_by(stress, spin.turn_by()) } else { turned(stress, spin.turn()) };
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

/// The velocity gradient of a block of elements.
struct VelocityGradient<'a, T, const AREA: bool> {
    scratch: &'a mut Workspace<T>,
    dt: T,
    nodes: &'a Nodes<T>,
}

impl<T: Real, const AREA: bool> NullaryFnOnce for VelocityGradient<'_, T, AREA> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.scratch.velocity_gradient::<AREA>(self.dt, self.nodes);
    }
}

impl<T: Real> Workspace<T> {
    /// Where the corners are and how they move, and the velocity gradient in the middle of the increment, times the volume there:
    /// `strain` is rr, zz, hoop and the sum of rz and zr, `spin` half their difference times the increment. The division behind both
    /// ends the loop, so that the lanes behind need not wait for it.
    #[inline(always)]
    fn velocity_gradient<const AREA: bool>(&mut self, dt: T, nodes: &Nodes<T>) {
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
            let g = Operators::of::<AREA>(middle(r, v_r), middle(z, v_z));
            let (along_r, along_z) = ([v_r[1], v_r[2], v_r[3]], [v_z[1], v_z[2], v_z[3]]);
            let (rz, zr) = (dot3(g.z, along_r), dot3(g.r, along_z));
            self.strain.strain[0][l] = dot3(g.r, along_r);
            self.strain.strain[1][l] = dot3(g.z, along_z);
            self.strain.strain[2][l] = dot3(g.hoop, [v_r[0], v_r[1], v_r[2]]);
            self.strain.strain[3][l] = rz + zr;
            let spin = SpinOver::new(half * (rz - zr), g.volume);
            self.strain.spin[l] = spin.dividend;
            self.middle[l] = spin.divisor;
            self.inverse[l] = spin.inverse;
        }
    }

    /// Sets velocity gradients (rr, zz, hoop, rz and zr) in the middle of the increment times the volumes there in the unit
    /// [`UNIT`], of elements of another shape.
    #[inline(always)]
    pub(super) fn set_gradients(&mut self, dt: T, gradients: &[Lanes<T>; 5], volume: &Lanes<T>) {
        let [rr, zz, hoop, rz, zr] = gradients;
        self.strain.strain = [*rr, *zz, *hoop, inline_from_fn(|l| rz[l] + zr[l])];
        for l in 0..LANES {
            let spin = SpinOver::new(T::of(0.5) * dt * (rz[l] - zr[l]), volume[l]);
            (self.strain.spin[l], self.middle[l], self.inverse[l]) = (spin.dividend, spin.divisor, spin.inverse);
        }
    }

    /// Scratch memory of a task of so many blocks whose frequencies are not capped, with room for what its elements keep of
    /// hourglass control and bulk viscosity, in units of a length.
    pub fn new(constants: &Constants, length: f64, blocks: usize) -> Self {
        let stiff = constants.hourglass.stiffness != 0.0;
        let enhanced = constants.hourglass.enhanced != 0.0;
        let viscous = constants.bulk_viscosity != [0.0; 2];
        Workspace {
            cap: T::of(f64::INFINITY),
            length,
            task: TaskState {
                hourglass: if stiff { vec![[[T::ZERO; LANES]; 2]; blocks] } else { Vec::new() },
                enhanced: if enhanced { vec![Assumed::default(); blocks] } else { Vec::new() },
                viscous: if viscous { vec![[T::ZERO; LANES]; blocks] } else { Vec::new() },
                ..TaskState::default()
            },
            ..Workspace::default()
        }
    }

    pub(super) fn bytes(&self) -> usize {
        let TaskState { hourglass, enhanced, viscous, subzones, records, eroded, own_rates } = &self.task;
        heap_bytes(hourglass)
            + heap_bytes(enhanced)
            + heap_bytes(viscous)
            + heap_bytes(subzones)
            + heap_bytes(records)
            + heap_bytes(eroded)
            + heap_bytes(own_rates)
    }

    /// Makes room for elements of so many blocks that are deleted from outside, and for their rates where they are kept.
    pub(super) fn make_erodible(&mut self, blocks: usize, rates: bool) {
        self.task.eroded = vec![Eroded::default(); blocks];
        self.task.own_rates = if rates { vec![[T::ZERO; LANES]; blocks] } else { Vec::new() };
    }

    /// Keeps the rates of the block at hand, where anything asks for them.
    #[inline(always)]
    fn keep_own_rates(&mut self) {
        if let Some(rates) = self.task.own_rates.get_mut(self.at) {
            *rates = self.own_rate;
        }
    }

    /// A lane whose element is not there weighs nothing.
    pub(super) fn mask(&mut self, lane: usize) {
        self.weight[lane] = T::ZERO;
    }

    /// Whether a lane counts.
    pub(super) fn weighs(&self, lane: usize) -> bool {
        self.weight[lane] > T::ZERO
    }

    /// Number of the block at hand; a float, as the sums keep it.
    pub(super) fn number(&self) -> T {
        self.block
    }

    /// What the block at hand keeps; zero where nothing is kept.
    #[inline(always)]
    pub(super) fn kept(&self) -> HourglassState<T> {
        HourglassState {
            hourglass: self.task.hourglass.get(self.at).copied().unwrap_or_default(),
            viscous: self.task.viscous.get(self.at).copied().unwrap_or_default(),
        }
    }

    /// Keeps it until the next increment.
    #[inline(always)]
    pub(super) fn keep(&mut self, kept: HourglassState<T>) {
        if let Some(place) = self.task.hourglass.get_mut(self.at) {
            *place = kept.hourglass;
        }
        if let Some(place) = self.task.viscous.get_mut(self.at) {
            *place = kept.viscous;
        }
    }

    /// Sums of the pass, and what deformed in it.
    pub(super) fn parts(&self) -> (Sums, [Lanes; 2]) {
        let StressUpdate { internal, dissipated, .. } = self.stress;
        let sums = Sums { internal, plastic: dissipated, ..self.sums };
        (sums.wide(self.length), self.deformed.inline_map(|list| list.inline_map(T::wide)))
    }

    /// Begins a pass under a bound of frequencies.
    #[inline(always)]
    pub(super) fn begin(&mut self, arch: Arch, cap: f64, dt: f64, constants: &Constants) {
        self.arch = arch;
        self.sums = Sums::default();
        self.stress.begin();
        self.strain.dt = dt;
        self.strain.moduli = Moduli { bulk: constants.bulk, shear: constants.shear };
        (self.cap, self.deformed) = (T::of(cap * self.length), [[T::ZERO; LANES]; 2]);
    }

    /// Lets the record of a block of the task, by its place there, follow an increment.
    #[inline(never)]
    pub(super) fn follow(
        &mut self,
        arch: Arch,
        index: usize,
        stress: &[Lanes<T>; 4],
        flow: PlasticFlow,
        (spins, dt): (Lanes, f64),
    ) {
        let unit = self.length * self.length * self.length;
        let (increment, update, record) = (&self.strain, &self.stress, &mut self.task.records[index]);
        arch.dispatch(Following { record, stress, flow, spins, dt, unit, increment, update });
    }

    /// Spin increments, where nothing but records asks for them.
    #[inline(always)]
    fn divide_spins(&mut self) {
        for l in 0..LANES {
            let (dividend, divisor, inverse) = (self.strain.spin[l], self.middle[l], self.inverse[l]);
            self.strain.spin[l] = dividend * SpinOver { dividend, divisor, inverse }.per();
        }
    }

    /// Follows the largest strain increment.
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

    /// Prepares for a block, by its number and its place in the task, of which the first `count` lanes hold elements; the
    /// others weigh nothing.
    #[inline(always)]
    pub fn prepare(&mut self, block: usize, at: usize, count: usize) {
        self.block = T::of(block as f64);
        self.at = at;
        self.strain.count = count.min(LANES);
        self.weight = [T::ONE; LANES];
        if count < LANES {
            self.weight[count..].fill(T::ZERO);
        }
    }
}

impl<T: Real> Workspace<T> {
    /// Adds the sums of a block that was updated with other scratch memory.
    pub(super) fn add_sums(&mut self, block: &Workspace<T>) {
        self.sums.add(&block.sums);
        for l in 0..LANES {
            self.stress.internal[l] += block.stress.internal[l];
            self.stress.dissipated[l] += block.stress.dissipated[l];
            for (most, list) in self.deformed.iter_mut().zip(&block.deformed) {
                most[l] = larger(list[l], most[l]);
            }
        }
        self.stress.deleted += block.stress.deleted;
    }
}

impl<T: Real> Sums<T> {
    /// The same in double precision and in the units of the scene, of numbers in units of a length.
    fn wide(&self, length: f64) -> Sums {
        let volume = length * length * length;
        let energies = |list: &Lanes<T>| list.inline_map(|x| volume * x.wide());
        Sums {
            internal: energies(&self.internal),
            plastic: energies(&self.plastic),
            viscous: energies(&self.viscous),
            artificial: energies(&self.artificial),
            rate: self.rate.inline_map(|x| x.wide() / length),
            limiting: self.limiting.inline_map(T::wide),
        }
    }
}

impl<T: Real> Sums<T> {
    /// Adds the sums of blocks that come behind, lane by lane.
    fn add(&mut self, behind: &Sums<T>) {
        for l in 0..LANES {
            self.internal[l] += behind.internal[l];
            self.plastic[l] += behind.plastic[l];
            self.viscous[l] += behind.viscous[l];
            self.artificial[l] += behind.artificial[l];
            if is_larger(behind.rate[l], self.rate[l]) {
                (self.rate[l], self.limiting[l]) = (behind.rate[l], behind.limiting[l]);
            }
        }
    }
}

/// The larger of two; the second where one is not a number.
#[inline(always)]
pub(super) fn larger<T: Real>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Whether a rate takes the place of the largest so far. Not a number counts as the largest, and the first stays: it must
/// be found.
#[inline(always)]
pub fn is_larger<T: Real>(rate: T, largest: T) -> bool {
    (rate > largest) | (rate.is_none() & !largest.is_none())
}

/// Sum over lanes, always in the same order.
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

persist_struct!(Sums<T> [T: Persist] { internal, plastic, viscous, artificial, rate, limiting });

persist_struct!(TaskState<T> [T: Persist] {
    eroded: fixed, own_rates: fixed, records: fixed, hourglass: fixed, enhanced: fixed, viscous: fixed,
    subzones: fixed
});

// The rest of it is scratch memory of one pass; the sums hold while a task is quiescent.
persist_struct!(Workspace<T> [T: Persist] { sums, task } derived { stress, r, z, v_r, v_z, middle, inverse, now, weight, strain, block, at, own_rate, length, cap, arch, deformed } then Workspace::persist_work);

impl<T: Persist> Workspace<T> {
    fn persist_work(&mut self, archive: &mut Archive<'_>) {
        persist_fields!(archive; &mut self.stress.internal, &mut self.stress.dissipated);
    }
}
