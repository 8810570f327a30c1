//! A block of elements and what one increment does to it: the inner loop of deformable bodies.
//! Each phase is a loop of plain arithmetic over lanes, without a branch, so that every instruction set gives the same
//! bits. Never here: which elements a block holds, threads.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use pulp::Arch;

use super::assumed::Assumed;
use super::constants::{CHANGE, Constants, damped};
use super::control::{Control, Lane, Seen, Spring};
use super::eroded::Eroded;
use super::shock::{BY_DIRECTION, by_direction, principal_compression};
use super::subzonal::Subzones;
use crate::element::record::{Following, Record};
use crate::kernel::lanes::{Corners, LANES, Lanes, column};
use crate::kernel::moduli::Moduli;
use crate::kernel::quad::{Operators, UNIT, at_corners, dot3, squares, sums};
use crate::kernel::real::Real;
use crate::kernel::rotation::{SpinOver, turned, turned_by};
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::{Material, PlasticFlow};
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};
use crate::state::nodes::{Accelerated, Node};

/// The largest square of the frequency of an hourglass pattern over that of the strains: a quarter leaves the stable increment
/// of elements that are not folded as it is.
const SLOW: f64 = 0.25;

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
                self.put(l, [0, 1, 2, 3].map(|c| nodes[of[c][l] as usize].as_array()), sound);
            }
            return;
        }
        for (to, of) in self.0.iter_mut().zip(of) {
            // Two at once, both read before either is written: one wide store, which the wide loads behind can take up.
            for (to, two) in to.as_chunks_mut::<2>().0.iter_mut().zip(of.as_chunks::<2>().0) {
                *to = two.map(|node| nodes[node as usize].as_array().map(T::of));
            }
        }
    }

    /// Puts the corners of a lane.
    #[inline(always)]
    fn put(&mut self, l: usize, corners: [[f64; 4]; 4], sound: f64) {
        if !T::SINGLE {
            self.0.iter_mut().zip(corners).for_each(|(to, corner)| to[l] = corner.map(T::of));
            return;
        }
        let beside = [0.0, 0.0, sound, sound];
        let [first, others @ ..] = corners;
        let first = [0, 1, 2, 3].map(|k| first[k] + beside[k]);
        let [to, rest @ ..] = &mut self.0;
        to[l] = [0, 1, 2, 3].map(|k| T::of(first[k] - beside[k]));
        for (to, other) in rest.iter_mut().zip(others) {
            to[l] = [0, 1, 2, 3].map(|k| T::of((other[k] + beside[k]) - first[k]));
        }
    }

    /// Coordinates and velocities of a lane as [`sums`], coordinates over a length.
    #[inline(always)]
    fn sums(&self, l: usize, per_length: T) -> [[T; 4]; 4] {
        [0, 1, 2, 3].map(|component| {
            let x = self.of(l, component);
            if !T::SINGLE {
                return sums(x);
            }
            let [first, b, c, d] = if component < 2 { x.map(|x| x * per_length) } else { x };
            let (above, right) = (c - d, c - b);
            [T::of(4.0) * first + ((b + c) + d), b + above, d + right, above - b]
        })
    }

    /// Puts an element that is not there where nothing can go wrong: at rest as a ring of this volume over that of a ring of
    /// height 1 from r = 1 to 2, from r = 1 to 2 in units of `length`.
    pub(super) fn mask(&mut self, l: usize, volume: f64, length: f64) {
        let height = volume / (length * length);
        let places = [[1.0, 0.0], [2.0, 0.0], [2.0, height], [1.0, height]];
        self.put(l, places.map(|[r, z]| [length * r, z, 0.0, 0.0]), 0.0);
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
    hourglass: [Lanes<T>; 2],
    /// Stress of the bulk viscosity.
    viscous: Lanes<T>,
}

/// Elements of a block where they are: their [`Operators`], and what follows from them.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
struct Geometry<T = f64> {
    r: [Lanes<T>; 3],
    z: [Lanes<T>; 3],
    hoop: [Lanes<T>; 3],
    volume: Lanes<T>,
    /// The hourglass pattern times the volume, by base vectors.
    pattern: [Lanes<T>; 3],
    /// Sums over the corners of the squares of all operators, and of that pattern, over their masses.
    squares: Lanes<T>,
    light: Lanes<T>,
    /// Bound of the highest frequency times the volume.
    root: Lanes<T>,
}

impl<T: Real> Geometry<T> {
    #[inline(always)]
    fn operators(&self, l: usize) -> Operators<T> {
        let [r, z, hoop] = [&self.r, &self.z, &self.hoop].map(|list| [list[0][l], list[1][l], list[2][l]]);
        Operators { r, z, hoop, volume: self.volume[l] }
    }

    #[inline(always)]
    fn pattern(&self, l: usize) -> [T; 3] {
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
    inverse: Lanes<T>,
    /// The elements where they are now.
    now: Geometry<T>,
    /// 0 for lanes without element.
    pub(super) weight: Lanes<T>,
    /// Kinematics of the block, and the stress update that its material makes of them.
    pub(super) strain: StrainIncrement<T>,
    pub(super) stress: StressUpdate<T>,
    pub(super) sums: Sums<T>,
    block: T,
    /// Place of the block in the task.
    pub(super) at: usize,
    pub(super) task: TaskState<T>,
    /// Two over the stable increments of the elements of the block.
    own_rate: Lanes<T>,
    /// Unit of lengths and times, in those of the scene; velocities, stresses and densities have the same in both.
    pub(super) length: f64,
    /// Highest frequency of the whole scene, where it is known to be lower than those of single elements; infinite if not.
    pub(super) cap: T,
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
        at_corners(column(&self.inverse_mass, lane).map(T::wide)).map(|inverse| 4.0 / inverse)
    }

    /// Gives the corners of a lane other masses, in the units of the block.
    pub(super) fn set_corner_masses(&mut self, lane: usize, masses: [f64; 4]) {
        let total = (masses[0] + masses[1]) + (masses[2] + masses[3]);
        self.mass[lane] = T::of(total);
        for (list, sum) in self.inverse_mass.iter_mut().zip(sums(masses.map(|mass| 1.0 / mass))) {
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

    /// Lets the material update the stress.
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
        scratch.velocity_gradient::<AREA>(dt, nodes);
        self.trial::<M>(constants, dt, scratch);
    }

    /// The stress turned with the material, and the elastic trial of its mean and deviator.
    #[inline(always)]
    fn trial<M: Material<T>>(&mut self, constants: &Constants, dt: T, scratch: &mut Workspace<T>) {
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
                let [a, b, c, d] = deviator.map(|s| s * s);
                scratch.stress.trial[l] = (T::of(1.5) * (a + b + c) + T::of(3.0) * d).root();
            }
        }
        if !(M::USES_SPIN || T::SINGLE || scratch.task.records.is_empty()) {
            scratch.divide_spins();
        }
    }

    /// The elements where they are now: operators, the bound of their highest frequencies, the hourglass pattern. What takes long
    /// ends a loop, so that the lanes behind need not wait for it.
    #[inline(always)]
    fn measure_now<M: Material<T>, const AREA: bool>(&self, constants: &Constants, scratch: &mut Workspace<T>) {
        let [shear43, modulus] = wave(constants);
        let unit = T::of(UNIT);
        let Workspace { r, z, now, stress: StressUpdate { bulk, .. }, inverse, .. } = scratch;
        for l in 0..LANES {
            let modulus = if M::MODULI_VARY { bulk[l] + shear43 } else { modulus };
            let (r, z, inverse_mass) = (column(r, l), column(z, l), column(&self.inverse_mass, l));
            let g = Operators::of::<AREA>(r, z);
            // omega^2 <= c_d^2 rho V sum (b_r^2 + b_z^2 + b_theta^2)/m, of which this is the sum.
            let lists = [
                [T::ZERO, g.r[0], g.r[1], g.r[2]],
                [T::ZERO, g.z[0], g.z[1], g.z[2]],
                [g.hoop[0], g.hoop[1], g.hoop[2], T::ZERO],
            ];
            let all = squares(&lists, inverse_mass);
            let pattern = g.pattern([r[3], z[3]]);
            for i in 0..3 {
                now.r[i][l] = g.r[i];
                now.z[i][l] = g.z[i];
                now.hoop[i][l] = g.hoop[i];
                now.pattern[i][l] = pattern[i];
            }
            now.volume[l] = g.volume;
            now.squares[l] = all;
            now.light[l] = squares(&[[T::ZERO, pattern[0], pattern[1], pattern[2]]], inverse_mass);
            now.root[l] = (modulus * unit * all * g.volume).root();
        }
        for l in 0..LANES {
            inverse[l] = T::ONE / (now.volume[l] * (now.root[l] * now.light[l]));
        }
    }

    /// Corner forces of stress, bulk viscosity and hourglass control, and the stable increment.
    #[inline(always)]
    pub(super) fn forces<M: Material<T>, C: Control<T>, const AREA: bool>(
        &mut self,
        (constants, dt): (&Constants, T),
        kept: &mut HourglassState<T>,
        scratch: &mut Workspace<T>,
        corners: &mut Corners<T>,
        control: &mut C,
    ) {
        let [shear43, modulus] = wave::<T>(constants);
        let pressing = modulus / T::of(constants.bulk);
        let [linear, quadratic] = constants.bulk_viscosity.map(T::of);
        let quadratic2 = quadratic * quadratic;
        let (zero, half, two, four, unit) = (T::ZERO, T::of(0.5), T::of(2.0), T::of(4.0), T::of(UNIT));
        let stiffness = dt * unit * T::of(constants.hourglass.stiffness) * T::of(constants.shear);
        let viscosity2 = T::of(2.0 * constants.hourglass.viscosity);
        let per_dt = if dt > zero { T::ONE / dt } else { zero };
        // The unit of forces is that of areas.
        let against = T::of(-scratch.length * scratch.length);
        let (slow, block) = (T::of(SLOW), scratch.block);
        // Values of their own: a number of the scratch memory read in the loop could be one that the loop writes, and would keep
        // it from becoming one of vectors.
        let cap = scratch.cap;
        // Without an increment behind, the velocities say how fast the volume changes.
        let starts = M::MODULI_VARY && per_dt == zero;
        let shocks = M::EQUATION_OF_STATE;
        let directed = T::of(if constants.shear == 0.0 { 2.0 * BY_DIRECTION } else { 0.0 });
        self.measure_now::<M, AREA>(constants, scratch);
        for l in 0..LANES {
            let modulus = if M::MODULI_VARY { scratch.stress.bulk[l] + shear43 } else { modulus };
            let ([v0, v1, v2, v3], [_, w1, w2, w3]) = (column(&scratch.v_r, l), column(&scratch.v_z, l));
            let (along_r, along_z, ring) = ([v1, v2, v3], [w1, w2, w3], [v0, v1, v2]);
            let now = &scratch.now;
            let (g, inverse_mass, all) = (now.operators(l), column(&self.inverse_mass, l), now.squares[l]);
            // omega = root / V; one division has served 1/V, 1/omega and the mass that the pattern moves.
            let (root, light, inverse) = (now.root[l], now.light[l], scratch.inverse[l]);
            let inverse_root = inverse * (g.volume * light);
            let per = inverse * (root * light);
            let omega = root * per;
            let square = dot3(g.r, g.r) + dot3(g.z, g.z);
            // Bulk viscosity (ABAQUS Analysis User's Guide, "Explicit dynamic analysis"): no part of the stress. The length
            // is 2 c/omega, so that the linear coefficient is the fraction of critical damping in the highest mode, also
            // of a flat element: then rho c times the length is 2 (K + 4/3 G)/omega.
            let mut period = g.volume * inverse_root;
            if AREA {
                // Of the section alone: the ring would show in what is spherical.
                period = g.volume / (modulus * unit * square * inverse_mass[0] * g.volume).root();
            }
            let dilation = scratch.strain.strain[0][l] + scratch.strain.strain[1][l] + scratch.strain.strain[2][l];
            let mut dilation_rate = dilation * per_dt;
            if starts {
                dilation_rate = (dot3(g.r, along_r) + dot3(g.z, along_z) + dot3(g.hoop, ring)) / g.volume;
            }
            let compression = if dilation_rate < zero { dilation_rate } else { zero };
            let mut fraction = linear - quadratic2 * two * period * compression;
            let mut sided = [zero; 4];
            if shocks {
                let rates = if starts {
                    let shear = half * (dot3(g.z, along_r) + dot3(g.r, along_z));
                    [dot3(g.r, along_r), dot3(g.z, along_z), shear].map(|sum| sum / g.volume)
                } else {
                    [0, 1, 3].map(|i: usize| scratch.strain.strain[i][l] * per_dt)
                };
                // The section is a quarter of the hoop operators' first part.
                let length = half * (T::of(0.25) * g.hoop[0] * (self.mass[l] * all)).root() / g.volume;
                let squeezed = principal_compression(rates, -compression);
                fraction = length * (linear + quadratic2 * length * two * period * squeezed);
                let viscosity = if dilation_rate < zero { directed * modulus * period * fraction } else { zero };
                sided = by_direction(rates, dilation_rate, viscosity);
            }
            let damping = two * modulus * period * dilation_rate * fraction;
            let work = scratch.strain.volume[l] * half * (kept.viscous[l] + damping) * dilation;
            scratch.sums.viscous[l] += work;
            if M::EQUATION_OF_STATE {
                scratch.stress.heat[l] = work - scratch.stress.heat[l];
            }
            kept.viscous[l] = damping;
            // Hourglass control (Flanagan and Belytschko 1981, eqs. 25 to 45) on the pattern free of linear fields. Its spring
            // may return to the yield surface with the stress.
            let shape = now.pattern(l).map(|part| per * part);
            let (q_r, q_z) = (dot3(shape, along_r), dot3(shape, along_z));
            let (mut f_r, mut f_z) = (zero, zero);
            if C::ENHANCED {
                control.see(l, &Lane { g: &g, per, shape, rate: [q_r, q_z], v_r: [v0, v1, v2, v3], squares: all });
            } else {
                // The mass that the pattern moves, a sixteenth of a square's, vanishes as an element folds: no more stiffness
                // than that the pattern stays slow beside the strains, and a fraction of what is critical at their frequency.
                let moved = root * (g.volume * (inverse * (root * g.volume)));
                let (wanted, most) = (stiffness * (four * square) * per, slow * dt * omega * moved);
                let spring = if wanted < most { wanted } else { most };
                let dashpot = viscosity2 * moved;
                let (old_r, old_z) = (kept.hourglass[0][l], kept.hourglass[1][l]);
                let left = scratch.stress.returned[l];
                let (new_r, new_z) = (left * (old_r + spring * q_r), left * (old_z + spring * q_z));
                kept.hourglass[0][l] = new_r;
                kept.hourglass[1][l] = new_z;
                let (drag_r, drag_z) = (dashpot * q_r, dashpot * q_z);
                let power = q_r * (half * (old_r + new_r) + drag_r) + q_z * (half * (old_z + new_z) + drag_z);
                scratch.sums.artificial[l] += dt * scratch.weight[l] * power;
                (f_r, f_z) = (new_r + drag_r, new_z + drag_z);
            }
            // What viscosity does by direction is heat by the compatible energy.
            let viscous = if shocks { [0, 1, 2].map(|i: usize| damping + sided[i]) } else { [damping; 3] };
            let s_rr = unit * (self.stress[0][l] + viscous[0]);
            let s_zz = unit * (self.stress[1][l] + viscous[1]);
            let s_hoop = unit * (self.stress[2][l] + viscous[2]);
            let s_rz = unit * if shocks { self.stress[3][l] + sided[3] } else { self.stress[3][l] };
            // Weighted by area the equation of motion itself is integrated over the section, its terms with 1/r included; the
            // ring is put back node by node (area.rs).
            let flat = if AREA { T::ONE / (four * unit * scratch.r[0][l]) } else { T::ONE };
            let (hoop_r, hoop_z) = if AREA { (s_hoop - s_rr, -s_rz) } else { (s_hoop, zero) };
            let stressed_r = |i: usize| s_rr * g.r[i] + s_rz * g.z[i];
            let stressed_z = |i: usize| s_zz * g.z[i] + s_rz * g.r[i];
            let along_r = at_corners([
                hoop_r * g.hoop[0],
                stressed_r(0) + (hoop_r * g.hoop[1] + f_r * shape[0]),
                stressed_r(1) + (hoop_r * g.hoop[2] + f_r * shape[1]),
                stressed_r(2) + f_r * shape[2],
            ]);
            let along_z = at_corners([
                hoop_z * g.hoop[0],
                stressed_z(0) + f_z * shape[0],
                stressed_z(1) + f_z * shape[1],
                stressed_z(2) + f_z * shape[2],
            ]);
            for i in 0..4 {
                let [force_r, force_z] = [along_r[i], along_z[i]].map(|f| if T::SINGLE { against * f } else { -f });
                corners.0[i][l] = if AREA { [flat * force_r, flat * force_z] } else { [force_r, force_z] };
            }
            // With damping 1/dt = omega/2 (sqrt(1 + xi^2) + xi) (the same section), in which 1 + xi^2/2 stands for the
            // root, never below it.
            // A mode of the whole: bulk viscosity is no more than 2 xi/omega times its stiffness to uniform pressure.
            let share = cap * period;
            let capped = share < T::ONE;
            let xi = if capped { fraction * share * pressing } else { fraction };
            // In a cold gas, where xi has no bound, the root itself.
            let damped = if M::MODULI_VARY { xi + (T::ONE + xi * xi).root() } else { damped(xi) };
            let highest = if capped { cap } else { omega };
            // Two over the increment in which the element would lose or gain as much of its volume as it may.
            let (stable, changing) = (highest * damped, dilation_rate.size() * T::of(2.0 / CHANGE));
            if M::MODULI_VARY {
                scratch.own_rate[l] = stable;
            }
            let rate = scratch.weight[l] * if changing > stable { changing } else { stable };
            // Not a number counts as the largest: it must be found.
            let (best, limiting) = (scratch.sums.rate[l], scratch.sums.limiting[l]);
            let larger = is_larger(rate, best);
            scratch.sums.rate[l] = if larger { rate } else { best };
            scratch.sums.limiting[l] = if larger { block } else { limiting };
        }
    }
}

/// What the moduli of a wave are made of: 4/3 of the shear modulus, and with the bulk modulus.
fn wave<T: Real>(constants: &Constants) -> [T; 2] {
    let shear43 = 4.0 / 3.0 * constants.shear;
    [shear43, constants.bulk + shear43].map(T::of)
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
            let middle = |x: [T; 4], v: [T; 4]| [0, 1, 2, 3].map(|i| x[i] - half * v[i]);
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
        size_of::<[Lanes<T>; 2]>() * hourglass.capacity()
            + size_of::<Assumed>() * enhanced.capacity()
            + size_of::<Lanes<T>>() * viscous.capacity()
            + size_of::<Subzones>() * subzones.capacity()
            + size_of::<Record>() * records.capacity()
            + size_of::<Eroded>() * eroded.capacity()
            + size_of::<Lanes<T>>() * own_rates.capacity()
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
        (sums.wide(self.length), self.deformed.map(|list| list.map(T::wide)))
    }

    /// Begins a pass under a bound of frequencies.
    #[inline(always)]
    pub(super) fn begin(&mut self, cap: f64, dt: f64, constants: &Constants) {
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
        let energies = |list: &Lanes<T>| list.map(|x| volume * x.wide());
        Sums {
            internal: energies(&self.internal),
            plastic: energies(&self.plastic),
            viscous: energies(&self.viscous),
            artificial: energies(&self.artificial),
            rate: self.rate.map(|x| x.wide() / length),
            limiting: self.limiting.map(T::wide),
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
persist_struct!(Workspace<T> [T: Persist] { sums, task } derived { stress, r, z, v_r, v_z, middle, inverse, now, weight, strain, block, at, own_rate, length, cap, deformed } then Workspace::persist_work);

impl<T: Persist> Workspace<T> {
    fn persist_work(&mut self, archive: &mut Archive<'_>) {
        persist_fields!(archive; &mut self.stress.internal, &mut self.stress.dissipated);
    }
}
