//! A block of elements and its update over one increment: the inner loop of deformable bodies. Each phase is a
//! branch-free loop of plain arithmetic over lanes, so that every instruction set gives the same bits.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use pulp::NullaryFnOnce;

use super::compatible::EnergyCorrection;
use super::constants::ElementConstants;
use super::deletion::{clear_deleted, clear_eroded, mask_deleted, mask_eroded};
use super::enhanced::{AssumedStrains, shares};
use super::eroded::ErodedLanes;
use super::forces::{CornerForceUpdate, HourglassScheme, PatternSpring};
use super::strain::measure;
use super::subzonal::resist_patterns;
use super::workspace::{ControlStresses, CornerNodes, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, column, dispatch_outlined};
use crate::kernel::quad::{QuadOperators, UNIT, at_corners, sums};
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::{Material, PlasticFlow};
use crate::state::archive::Persist;
use crate::state::nodes::NodeAccelerations;

/// A block of [`LANES`] elements; each quantity is an array over lanes.
#[derive(Clone, Debug, Persist)]
#[repr(C, align(64))]
#[persist(derived: nodes)]
pub struct ElementBlock<S> {
    /// Corner nodes, counter-clockwise.
    pub nodes: [[u32; LANES]; 4],
    /// Cauchy stress: rr, zz, hoop, rz.
    pub stress: [Lanes; 4],
    pub mass: Lanes,
    /// Inverse masses of the corners, combined as by [`sums`].
    pub inverse_mass: [Lanes; 4],
    pub state: S,
}

impl<S> ElementBlock<S> {
    /// Creates a block of integration points at rest, with the given masses and without nodes.
    pub(super) fn of_points(state: S, mass: Lanes) -> Self {
        let (nodes, zeros) = ([[0; LANES]; 4], [[0.0; LANES]; 4]);
        ElementBlock { nodes, stress: zeros, mass, inverse_mass: zeros, state }
    }

    /// Returns the corner masses of a lane in the units of the block.
    pub(super) fn corner_masses(&self, lane: usize) -> [f64; 4] {
        at_corners(column(&self.inverse_mass, lane)).inline_map(|inverse| 4.0 / inverse)
    }

    /// Sets the corner masses of a lane, in the units of the block.
    pub(super) fn set_corner_masses(&mut self, lane: usize, masses: [f64; 4]) {
        let total = (masses[0] + masses[1]) + (masses[2] + masses[3]);
        self.mass[lane] = total;
        for (list, sum) in self.inverse_mass.iter_mut().zip(sums(masses.inline_map(|mass| 1.0 / mass))) {
            list[lane] = sum;
        }
    }
}

impl<S: Clone> ElementBlock<S> {
    /// Updates the block over one increment: stresses and corner forces at its end, and the sums.
    #[inline(always)]
    pub fn update<M: Material<State = S>>(
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
            M::EQUATION_OF_STATE.then(|| EnergyCorrection::begin(scratch, corners, &self.nodes, (nodes, dt), before));
        self.measure_strain::<M>(constants, dt, nodes, scratch);
        if M::EQUATION_OF_STATE {
            self.measure_volume(scratch);
        }
        self.finish(material, (constants, dt), eroded, nodes, scratch, corners);
        if let Some(owed) = owed {
            owed.apply(scratch, corners, nodes, dt);
            material.add_heat(&mut self.state, &scratch.stress.heat, &self.mass);
        }
    }

    /// Updates stresses and corner forces; the second part of an increment, when strains are known.
    #[inline(always)]
    pub(super) fn finish<M: Material<State = S>>(
        &mut self,
        material: &M,
        (constants, dt): (&ElementConstants, f64),
        eroded: bool,
        nodes: &CornerNodes,
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
    ) {
        let mut controls = std::mem::take(&mut scratch.task.controls);
        let stresses_of_block = &mut controls[scratch.at];
        let mut enhanced = std::mem::take(&mut scratch.task.enhanced);
        if let Some(stresses) = enhanced.get_mut(scratch.at) {
            let shares_at_start = shares(material, &self.state);
            self.update_stress(material, constants, scratch);
            let law = (material, &self.state);
            let mut control = AssumedStrains::new(law, shares_at_start, constants, stresses, scratch);
            self.forces::<M, _>((constants, dt), stresses_of_block, scratch, corners, &mut control);
        } else {
            self.update_stress(material, constants, scratch);
            self.forces::<M, _>((constants, dt), stresses_of_block, scratch, corners, &mut PatternSpring);
        }
        scratch.task.enhanced = enhanced;
        scratch.task.controls = controls;
        if M::EQUATION_OF_STATE {
            resist_patterns(scratch, (dt, constants.hourglass.viscosity), nodes, &self.inverse_mass, corners);
        }
        self.clear(material, eroded, scratch, corners);
        if M::MODULI_VARY {
            scratch.keep_own_rates();
        }
    }

    /// Computes the current volumes, masses and viscous stresses for an equation of state.
    #[inline(always)]
    fn measure_volume(&self, scratch: &mut TaskWorkspace) {
        for l in 0..LANES {
            let volume = QuadOperators::of::<false>(column(&scratch.r, l), column(&scratch.z, l)).volume;
            scratch.strain.current_volume[l] = UNIT * volume;
        }
        scratch.strain.mass = self.mass;
        scratch.strain.viscous = scratch.task.controls[scratch.at].viscous;
    }
}

/// Operation that updates the stresses of a block. Elements of all shapes share the compiled code of a material.
struct MaterialUpdate<'a, M: Material> {
    material: &'a M,
    state: &'a mut M::State,
    stress: &'a mut [Lanes; 4],
    strain: &'a StrainIncrement,
    update: &'a mut StressUpdate,
}

impl<M: Material> NullaryFnOnce for MaterialUpdate<'_, M> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.material.update(self.state, self.stress, self.strain, self.update);
    }
}

impl<S: Clone> ElementBlock<S> {
    /// Masks deleted elements before an increment. Returns whether some were deleted by `*EROSION`.
    #[inline(always)]
    pub(super) fn mask<M: Material<State = S>>(
        &mut self,
        material: &M,
        nodes: &mut CornerNodes,
        scratch: &mut TaskWorkspace,
    ) -> bool {
        if M::FAILS {
            mask_deleted((material, &self.state), &mut self.stress, nodes, scratch);
        }
        let eroded = scratch.task.eroded.get(scratch.at).is_some_and(ErodedLanes::any);
        if eroded {
            mask_eroded(&mut self.stress, nodes, scratch);
        }
        eroded
    }

    /// Clears the forces of deleted elements after an increment.
    #[inline(always)]
    pub(super) fn clear<M: Material<State = S>>(
        &mut self,
        material: &M,
        eroded: bool,
        scratch: &TaskWorkspace,
        corners: &mut BlockCornerForces,
    ) {
        if M::FAILS {
            clear_deleted(material, &self.state, corners);
        }
        if eroded {
            clear_eroded(&mut self.stress, &scratch.task.eroded[scratch.at], corners);
        }
    }

    /// Computes strain increments and the elastic trial stress, with averaged dilation where it is used.
    #[inline(always)]
    pub(super) fn measure_strain<M: Material<State = S>>(
        &mut self,
        constants: &ElementConstants,
        dt: f64,
        nodes: &CornerNodes,
        scratch: &mut TaskWorkspace,
    ) {
        measure::<M>(&self.stress, constants, dt, nodes, scratch);
        if M::USES_PLACE {
            scratch.set_places(|l| nodes.places(l));
        }
        if let Some(averaging) = &scratch.strain.averaging
            && !M::MODULI_VARY
        {
            // The stress follows the averaged strain; its work uses the element's own strain.
            let bulk = constants.bulk;
            for l in 0..LANES {
                scratch.stress.mean[l] += bulk * averaging[l];
            }
        }
        if scratch.cap < f64::INFINITY {
            scratch.measure();
        }
    }

    /// Computes the corner forces of stress, bulk viscosity and hourglass control, and the stable time increment.
    #[inline(always)]
    pub(super) fn forces<M: Material, C: HourglassScheme>(
        &self,
        increment: (&ElementConstants, f64),
        kept: &mut ControlStresses,
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
        control: &mut C,
    ) {
        // Conditions on the material are constants: one branch is compiled. Area weighting needs constant moduli.
        if !M::MODULI_VARY {
            if increment.0.by_area {
                self.forces_by::<C, true, false, false>(increment, kept, scratch, corners, control);
            } else {
                self.forces_by::<C, false, false, false>(increment, kept, scratch, corners, control);
            }
        } else if !M::EQUATION_OF_STATE {
            self.forces_by::<C, false, true, false>(increment, kept, scratch, corners, control);
        } else {
            self.forces_by::<C, false, true, true>(increment, kept, scratch, corners, control);
        }
    }

    #[inline(always)]
    fn forces_by<C: HourglassScheme, const AREA: bool, const VARY: bool, const EOS: bool>(
        &self,
        (constants, dt): (&ElementConstants, f64),
        kept: &mut ControlStresses,
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
        control: &mut C,
    ) {
        let ElementBlock { stress, mass, inverse_mass, .. } = self;
        let arch = scratch.arch;
        dispatch_outlined(
            arch,
            CornerForceUpdate::<C, AREA, VARY, EOS> {
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
    pub(super) fn update_stress<M: Material<State = S>>(
        &mut self,
        material: &M,
        constants: &ElementConstants,
        scratch: &mut TaskWorkspace,
    ) {
        let TaskWorkspace { strain, stress: update, arch, .. } = scratch;
        let ElementBlock { state, stress, .. } = self;
        dispatch_outlined(*arch, MaterialUpdate { material, state, stress, strain, update });
        if !matches!(M::FLOW, PlasticFlow::None) && !constants.hourglass.relaxes {
            scratch.stress.returned = [1.0; LANES];
        }
    }
}
