//! Precision of an element group: units and block update in single and double precision, destination of corner forces.

use super::block::{CornerNodes, ElementBlock, TaskWorkspace};
use super::constants::ElementConstants;
use super::control::PatternSpring;
use super::eroded::ErodedLanes;
use crate::kernel::lanes::{BlockCornerForces, InlineMap};
use crate::kernel::quad::UNIT;
use crate::kernel::real::Real;
use crate::material::Material;
use crate::mesh::corner_forces::CornerForceSlots;
use crate::state::archive::Persist;
use crate::state::nodes::NodeAccelerations;

/// Input of a block update that describes the increment.
pub struct IncrementInput<'a> {
    /// Length of the increment.
    pub dt: f64,
    /// Accelerations that moved the nodes over the increment.
    pub before: NodeAccelerations<'a>,
}

/// Corner forces of a group's blocks, in the precision of the group or in double precision.
pub enum BlockForces<'a, T> {
    /// Same precision as the group.
    Own(&'a mut [BlockCornerForces<T>]),
    /// Double precision: other groups of the model are in double precision.
    Wider(&'a mut [BlockCornerForces]),
}

/// Floating-point type of an element group.
pub trait ElementPrecision: Real + Persist {
    /// Returns the unit of lengths and times for elements with the given smallest and largest volume.
    fn length(volumes: [f64; 2]) -> f64;

    /// Returns the speed of sound rounded to a power of two, from its square; 0 in double precision.
    fn sound(square: f64) -> f64;

    /// Returns the corner forces of a group.
    fn forces(slots: CornerForceSlots<'_>) -> BlockForces<'_, Self>;

    fn update<M: Material<Self>, const AREA: bool>(
        block: &mut ElementBlock<M::State, Self>,
        material: &M,
        constants: &ElementConstants,
        increment: &IncrementInput<'_>,
        nodes: &mut CornerNodes<Self>,
        scratch: &mut TaskWorkspace<Self>,
        corners: &mut BlockCornerForces<Self>,
    );

    /// Updates stresses and corner forces; the second part of an increment, when strains are known.
    fn finish<M: Material<Self>, const AREA: bool>(
        block: &mut ElementBlock<M::State, Self>,
        material: &M,
        increment: (&ElementConstants, f64),
        eroded: Option<&ErodedLanes>,
        nodes: &CornerNodes<Self>,
        scratch: &mut TaskWorkspace<Self>,
        corners: &mut BlockCornerForces<Self>,
    );
}

impl ElementPrecision for f64 {
    fn length(_volumes: [f64; 2]) -> f64 {
        1.0
    }

    fn sound(_square: f64) -> f64 {
        0.0
    }

    fn forces(slots: CornerForceSlots<'_>) -> BlockForces<'_, f64> {
        match slots {
            CornerForceSlots::Double(list) => BlockForces::Own(list),
            CornerForceSlots::Single(_) => unreachable!("corner forces are single where all groups are"),
        }
    }

    #[inline(always)]
    fn update<M: Material, const AREA: bool>(
        block: &mut ElementBlock<M::State>,
        material: &M,
        constants: &ElementConstants,
        increment: &IncrementInput<'_>,
        nodes: &mut CornerNodes,
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
    ) {
        block.update::<M, AREA>(material, constants, (increment.dt, increment.before), nodes, scratch, corners);
    }

    #[inline(always)]
    fn finish<M: Material, const AREA: bool>(
        block: &mut ElementBlock<M::State>,
        material: &M,
        increment: (&ElementConstants, f64),
        eroded: Option<&ErodedLanes>,
        nodes: &CornerNodes,
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
    ) {
        block.finish::<M, AREA>(material, increment, eroded, nodes, scratch, corners);
    }
}

fn exponent(value: f64) -> i32 {
    (value.to_bits() >> 52) as i32 - 1023
}

impl ElementPrecision for f32 {
    /// Returns a power of two, so that scaling is exact. This unit keeps products of volumes in the range of the type:
    /// in metres, the third power of the volume of a 10 µm element would underflow.
    fn length([least, largest]: [f64; 2]) -> f64 {
        2f64.powi((exponent(least / UNIT) + exponent(largest / UNIT)).div_euclid(6))
    }

    fn sound(square: f64) -> f64 {
        2f64.powi(exponent(square).div_euclid(2))
    }

    fn forces(slots: CornerForceSlots<'_>) -> BlockForces<'_, f32> {
        match slots {
            CornerForceSlots::Double(list) => BlockForces::Wider(list),
            CornerForceSlots::Single(list) => BlockForces::Own(list),
        }
    }

    #[inline(always)]
    fn update<M: Material<f32>, const AREA: bool>(
        block: &mut ElementBlock<M::State, f32>,
        material: &M,
        constants: &ElementConstants,
        increment: &IncrementInput<'_>,
        nodes: &mut CornerNodes<f32>,
        scratch: &mut TaskWorkspace<f32>,
        corners: &mut BlockCornerForces<f32>,
    ) {
        const { assert!(!M::MODULI_VARY) };
        let dt = f32::of(increment.dt / scratch.length);
        let eroded = block.mask(material, nodes, scratch);
        block.measure_strain::<M, AREA>(constants, dt, nodes, scratch);
        let increment = (constants, increment.dt);
        Self::finish::<M, AREA>(block, material, increment, eroded.as_ref(), nodes, scratch, corners);
    }

    #[inline(always)]
    fn finish<M: Material<f32>, const AREA: bool>(
        block: &mut ElementBlock<M::State, f32>,
        material: &M,
        (constants, dt): (&ElementConstants, f64),
        eroded: Option<&ErodedLanes>,
        _nodes: &CornerNodes<f32>,
        scratch: &mut TaskWorkspace<f32>,
        corners: &mut BlockCornerForces<f32>,
    ) {
        let dt = f32::of(dt / scratch.length);
        let mut kept = scratch.hourglass_state();
        block.update_stress(material, constants, scratch);
        block.forces::<M, _, AREA>((constants, dt), &mut kept, scratch, corners, &mut PatternSpring);
        scratch.store_hourglass_state(kept);
        block.clear(material, eroded, corners);
    }
}

impl<T: Real> BlockForces<'_, T> {
    pub fn are_zero(&self) -> bool {
        match self {
            BlockForces::Own(list) => {
                list.iter().all(|c| c.0.as_flattened().as_flattened().iter().all(|f| *f == T::ZERO))
            }
            BlockForces::Wider(list) => {
                list.iter().all(|c| c.0.as_flattened().as_flattened().iter().all(|f| *f == 0.0))
            }
        }
    }
}

/// Converts corner forces to double precision.
pub fn widen<T: Real>(from: &BlockCornerForces<T>, to: &mut BlockCornerForces) {
    for (to, from) in to.0.as_flattened_mut().iter_mut().zip(from.0.as_flattened()) {
        *to = from.inline_map(T::wide);
    }
}
