//! Variables of material states that move with the material through a mesh that does not follow it. Each state lists all
//! its fields: those that are carried, per mass, and the others.

use crate::kernel::lanes::Lanes;

/// An element after a transport, with its new places and masses.
#[derive(Clone, Copy, Debug)]
pub struct ArrivedElement {
    /// Places `[r, z]` of the corners.
    pub corners: [[f64; 2]; 4],
    /// Mass of the element.
    pub mass: f64,
    /// Stress (rr, zz, hoop, rz).
    pub stress: [f64; 4],
}

/// A state with variables that can be moved from element to element.
pub trait CarriedState {
    /// Passes each variable to `visit`, always in the same order. Values per mass can be averaged with the masses.
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes));
}

impl CarriedState for () {
    fn carry(&mut self, _visit: &mut dyn FnMut(&mut Lanes)) {}
}

impl CarriedState for Lanes {
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes)) {
        visit(self);
    }
}

impl<T: CarriedState, const N: usize> CarriedState for [T; N] {
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes)) {
        self.iter_mut().for_each(|part| part.carry(visit));
    }
}

impl CarriedState for Vec<Lanes> {
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes)) {
        self.iter_mut().for_each(visit);
    }
}

impl<T: CarriedState> CarriedState for Option<Box<T>> {
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes)) {
        self.iter_mut().for_each(|part| part.carry(visit));
    }
}

/// Implements [`CarriedState`] from the fields of a type: those that are carried, and those that stay with the element.
#[macro_export]
macro_rules! carried_state {
    ($name:ident $(<$($argument:ident),+>)? { $($field:ident),* $(,)? } $(stay { $($stays:ident),+ $(,)? })?) => {
        impl $(<$($argument: $crate::material::carried::CarriedState),+>)? $crate::material::carried::CarriedState
            for $name $(<$($argument),+>)?
        {
            fn carry(&mut self, visit: &mut dyn FnMut(&mut $crate::kernel::lanes::Lanes)) {
                let $name { $($field,)* $($($stays: _,)+)? } = self;
                $($crate::material::carried::CarriedState::carry($field, visit);)*
            }
        }
    };
}
pub use carried_state;
