//! Laws that are evaluated for all lanes of a block at once.

use std::any::Any;

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
        let soil = law.downcast_ref().map(LaneLaw::DruckerPrager);
        let concrete = || law.downcast_ref().map(LaneLaw::Concrete);
        let porous_metal = || law.downcast_ref().map(LaneLaw::PorousMetal);
        let sheet = || law.downcast_ref().map(LaneLaw::Hill);
        soil.or_else(concrete).or_else(porous_metal).or_else(sheet)
    }
}
