//! The precision of a group's numbers: what a block does in an increment, in which units, where its corner forces go.
//! Never here: arithmetic that both precisions share.

use super::block::{Block, Nodes, Workspace};
use super::constants::Constants;
use crate::kernel::lanes::{Corners, near, wide};
use crate::kernel::quad::UNIT;
use crate::kernel::real::Real;
use crate::material::failure::Failure;
use crate::material::plasticity::{Flow, Hardening};
use crate::material::volumetric::Volumetric;
use crate::mesh::corner_forces::Slots;
use crate::state::archive::Persist;
use crate::state::nodes::Accelerated;

/// A block of elements with these laws.
pub type Lawful<H, V, F, T> = Block<<H as Hardening>::State, <V as Volumetric>::State, <F as Failure>::State, T>;

/// What one increment of a block is given, beside its corner nodes.
pub struct Behind<'a> {
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

    /// One increment of a block.
    fn update<H: Hardening, V: Volumetric, F: Failure, const AREA: bool>(
        block: &mut Lawful<H, V, F, Self>,
        laws: (&H, &V, &F),
        constants: &Constants,
        behind: &Behind<'_>,
        nodes: &mut Nodes<Self>,
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
    fn update<H: Hardening, V: Volumetric, F: Failure, const AREA: bool>(
        block: &mut Lawful<H, V, F, f64>,
        laws: (&H, &V, &F),
        constants: &Constants,
        behind: &Behind<'_>,
        nodes: &mut Nodes,
        scratch: &mut Workspace,
        corners: &mut Corners,
    ) {
        block.update::<H, V, F, AREA>(laws, constants, (behind.dt, behind.before), nodes, scratch, corners);
    }
}

/// Exponent of a positive number.
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
    fn update<H: Hardening, V: Volumetric, F: Failure, const AREA: bool>(
        block: &mut Lawful<H, V, F, f32>,
        laws: (&H, &V, &F),
        constants: &Constants,
        behind: &Behind<'_>,
        nodes: &mut Nodes<f32>,
        scratch: &mut Workspace<f32>,
        corners: &mut Corners<f32>,
    ) {
        const { assert!(!V::EOS) };
        block.update_single::<H, V, F, AREA>(laws, constants, behind.dt, nodes, scratch, corners);
    }
}

impl<S: Clone, Q: Clone, X: Clone> Block<S, Q, X, f32> {
    /// One increment in single precision: stresses at its end, corner forces, and what is added to the sums. The plastic strain,
    /// a sum of many small increments, is in double precision.
    #[inline(always)]
    fn update_single<H: Hardening<State = S>, V: Volumetric<State = Q>, F: Failure<State = X>, const AREA: bool>(
        &mut self,
        (hardening, volumetric, failure): (&H, &V, &F),
        constants: &Constants,
        dt: f64,
        nodes: &mut Nodes<f32>,
        scratch: &mut Workspace<f32>,
        corners: &mut Corners<f32>,
    ) {
        if F::FAILS {
            self.mask_deleted(failure, nodes, scratch);
        }
        let eroded = scratch.eroded.get(scratch.at).filter(|e| e.any()).copied();
        if let Some(eroded) = &eroded {
            self.mask_eroded(eroded, nodes, scratch);
        }
        let own_dt = f32::of(dt / scratch.length);
        let mut kept = scratch.kept();
        self.strain::<H, V, AREA>(constants, own_dt, nodes, scratch);
        if let Some(lacking) = &scratch.lacking {
            let bulk = f32::of(constants.bulk);
            scratch.mean.iter_mut().zip(lacking).for_each(|(mean, lacks)| *mean += bulk * f32::of(*lacks));
        }
        if scratch.cap < f32::INFINITY {
            scratch.measure();
        }
        if H::BACKSTRESS {
            scratch.back = hardening.back_stress(&self.state).each_ref().map(near);
            scratch.shift();
        }
        if H::PLASTIC {
            let (trial, mut increment) = (wide(&scratch.trial), wide(&scratch.flow));
            let (shear3, count) = (3.0 * constants.shear, scratch.count);
            hardening.flow(&mut self.state, &mut Flow { trial: &trial, shear3, dt, count, increment: &mut increment });
            scratch.flow = near(&increment);
            if H::BACKSTRESS {
                let [back, deviator] = [&scratch.back, &scratch.deviator].map(|list| list.each_ref().map(wide));
                hardening.follow(&mut self.state, &back, &deviator, &trial, &increment);
            }
        }
        self.stress::<H>(constants, &mut kept, scratch);
        if F::FAILS {
            self.fail((hardening, volumetric, failure), constants, dt, scratch);
        }
        self.forces::<V, _, AREA>((constants, own_dt), &mut kept, scratch, corners, &mut super::control::Spring);
        scratch.keep(kept);
        if F::FAILS {
            self.clear_deleted(failure, corners);
        }
        if let Some(eroded) = &eroded {
            self.clear_eroded(eroded, corners);
        }
    }
}

impl<T: Real> Forces<'_, T> {
    /// Whether nothing pulls.
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
        *to = from.map(T::wide);
    }
}
