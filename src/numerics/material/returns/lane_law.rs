//! Laws that are evaluated for all lanes of a block at once.

use std::any::{Any, TypeId};

use super::concrete::ConcreteDamagedPlasticity;
use super::drucker_prager::DruckerPrager;
use super::hill::HillPotential;
use super::law::StressReturn;
use super::porous_metal::PorousMetal;

/// A law that is evaluated in the lanes of a block.
#[derive(Clone, Copy)]
pub(super) enum LaneLaw<'a> {
    DruckerPrager(&'a DruckerPrager),
    Concrete(&'a ConcreteDamagedPlasticity),
    PorousMetal(&'a PorousMetal),
    Hill(&'a HillPotential),
}

impl<'a> LaneLaw<'a> {
    /// Returns the law for loops over the lanes of a block; `None` for laws that are updated point by point.
    #[inline]
    pub fn of(law: &'a (dyn StressReturn + 'static)) -> Option<LaneLaw<'a>> {
        let law: &dyn Any = law;
        let id = law.type_id();
        if id == TypeId::of::<DruckerPrager>() {
            law.downcast_ref().map(LaneLaw::DruckerPrager)
        } else if id == TypeId::of::<ConcreteDamagedPlasticity>() {
            law.downcast_ref().map(LaneLaw::Concrete)
        } else if id == TypeId::of::<PorousMetal>() {
            law.downcast_ref().map(LaneLaw::PorousMetal)
        } else if id == TypeId::of::<HillPotential>() {
            law.downcast_ref().map(LaneLaw::Hill)
        } else {
            None
        }
    }
}
