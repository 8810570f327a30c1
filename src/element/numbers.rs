//! The precision of a group's numbers: what a block does in an increment, in which units, where its corner forces go.
//! Never here: arithmetic that both precisions share.

use super::block::{ElementBlock, Nodes, Workspace};
use super::constants::Constants;
use super::control::Spring;
use super::eroded::Eroded;
use crate::kernel::lanes::{Corners, InlineMap};
use crate::kernel::quad::UNIT;
use crate::kernel::real::Real;
use crate::material::Material;
use crate::mesh::corner_forces::Slots;
use crate::state::archive::Persist;
use crate::state::nodes::Accelerated;

/// The increment that a block is updated over.
pub struct IncrementInput<'a> {
    /// Length of the increment.
    pub dt: f64,
    /// What carried nodes over it.
    pub before: Accelerated<'a>,
}

/// Corner forces of a group's blocks: its own, or wider ones.
pub enum Forces<'a, T> {
    /// Of the same precision.
    Own(&'a mut [Corners<T>]),
    /// Of a scene in which other groups are in double precision.
    Wider(&'a mut [Corners]),
}

/// What a block of a group is made of.
pub trait Numbers: Real + Persist {
    /// Unit of lengths and times for elements of volumes from the least to the largest.
    fn length(volumes: [f64; 2]) -> f64;

    /// Speed of sound to a power of two, by its square; 0 where nothing asks for it.
    fn sound(square: f64) -> f64;

    /// The corner forces of a group.
    fn forces(slots: Slots<'_>) -> Forces<'_, Self>;

    fn update<M: Material<Self>, const AREA: bool>(
        block: &mut ElementBlock<M::State, Self>,
        material: &M,
        constants: &Constants,
        increment: &IncrementInput<'_>,
        nodes: &mut Nodes<Self>,
        scratch: &mut Workspace<Self>,
        corners: &mut Corners<Self>,
    );

    /// The second part of an increment, whose strains are known: stresses and corner forces.
    fn finish<M: Material<Self>, const AREA: bool>(
        block: &mut ElementBlock<M::State, Self>,
        material: &M,
        increment: (&Constants, f64),
        eroded: Option<&Eroded>,
        nodes: &Nodes<Self>,
        scratch: &mut Workspace<Self>,
        corners: &mut Corners<Self>,
    );
}

impl Numbers for f64 {
    fn length(_volumes: [f64; 2]) -> f64 {
        1.0
    }

    fn sound(_square: f64) -> f64 {
        0.0
    }

    fn forces(slots: Slots<'_>) -> Forces<'_, f64> {
        match slots {
            Slots::Double(list) => Forces::Own(list),
            Slots::Single(_) => unreachable!("corner forces are single where all groups are"),
        }
    }

    #[inline(always)]
    fn update<M: Material, const AREA: bool>(
        block: &mut ElementBlock<M::State>,
        material: &M,
        constants: &Constants,
        increment: &IncrementInput<'_>,
        nodes: &mut Nodes,
        scratch: &mut Workspace,
        corners: &mut Corners,
    ) {
        block.update::<M, AREA>(material, constants, (increment.dt, increment.before), nodes, scratch, corners);
    }

    #[inline(always)]
    fn finish<M: Material, const AREA: bool>(
        block: &mut ElementBlock<M::State>,
        material: &M,
        increment: (&Constants, f64),
        eroded: Option<&Eroded>,
        nodes: &Nodes,
        scratch: &mut Workspace,
        corners: &mut Corners,
    ) {
        block.finish::<M, AREA>(material, increment, eroded, nodes, scratch, corners);
    }
}

fn exponent(value: f64) -> i32 {
    (value.to_bits() >> 52) as i32 - 1023
}

impl Numbers for f32 {
    /// A power of two, which costs no digit, so that products of volumes keep within the range of the numbers: in metres the
    /// third power of the volume of an element of ten micrometres would not.
    fn length([least, largest]: [f64; 2]) -> f64 {
        2f64.powi((exponent(least / UNIT) + exponent(largest / UNIT)).div_euclid(6))
    }

    fn sound(square: f64) -> f64 {
        2f64.powi(exponent(square).div_euclid(2))
    }

    fn forces(slots: Slots<'_>) -> Forces<'_, f32> {
        match slots {
            Slots::Double(list) => Forces::Wider(list),
            Slots::Single(list) => Forces::Own(list),
        }
    }

    #[inline(always)]
    fn update<M: Material<f32>, const AREA: bool>(
        block: &mut ElementBlock<M::State, f32>,
        material: &M,
        constants: &Constants,
        increment: &IncrementInput<'_>,
        nodes: &mut Nodes<f32>,
        scratch: &mut Workspace<f32>,
        corners: &mut Corners<f32>,
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
        (constants, dt): (&Constants, f64),
        eroded: Option<&Eroded>,
        _nodes: &Nodes<f32>,
        scratch: &mut Workspace<f32>,
        corners: &mut Corners<f32>,
    ) {
        let dt = f32::of(dt / scratch.length);
        let mut kept = scratch.kept();
        block.update_stress(material, constants, scratch);
        block.forces::<M, _, AREA>((constants, dt), &mut kept, scratch, corners, &mut Spring);
        scratch.keep(kept);
        block.clear(material, eroded, corners);
    }
}

impl<T: Real> Forces<'_, T> {
    pub fn are_zero(&self) -> bool {
        match self {
            Forces::Own(list) => list.iter().all(|c| c.0.as_flattened().as_flattened().iter().all(|f| *f == T::ZERO)),
            Forces::Wider(list) => list.iter().all(|c| c.0.as_flattened().as_flattened().iter().all(|f| *f == 0.0)),
        }
    }
}

/// The same forces in double precision.
pub fn widen<T: Real>(from: &Corners<T>, to: &mut Corners) {
    for (to, from) in to.0.as_flattened_mut().iter_mut().zip(from.0.as_flattened()) {
        *to = from.inline_map(T::wide);
    }
}
