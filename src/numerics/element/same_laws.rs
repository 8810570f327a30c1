//! Laws with a yield surface that depends on pressure, porosity or direction, for the tests that every law must pass. Their
//! moduli are those of the tests; the motions of the tests make each law yield.

use super::battery::{DENSITY, MODULI};
use crate::kernel::hardening::{LinearTable, RateFactor};
use crate::material::compaction::PorousCompaction;
use crate::material::eos::UsUp;
use crate::material::equation_of_state::EquationOfState;
use crate::material::returns::cap::CapPlasticity;
use crate::material::returns::concrete::ConcreteDamagedPlasticity;
use crate::material::returns::concrete_return::ConcreteSurface;
use crate::material::returns::concrete_tables::{ConcreteAbscissa, ConcreteTable};
use crate::material::returns::drucker_prager::{DruckerPrager, DruckerPragerShape, YieldTest};
use crate::material::returns::hill::HillPotential;
use crate::material::returns::holmquist_johnson_cook::HolmquistJohnsonCook;
use crate::material::returns::johnson_holmquist::JohnsonHolmquist;
use crate::material::returns::porous_metal::{PorousMetal, VoidNucleation};

fn hardening() -> LinearTable {
    LinearTable { rows: vec![[0.02, 0.0], [0.03, 0.02], [0.04, 0.5]] }
}

pub(super) fn soil() -> DruckerPrager {
    DruckerPrager {
        shape: DruckerPragerShape::Linear { friction: 0.7, ratio: 0.85 },
        dilatancy: 0.3,
        eccentricity: 0.1,
        hardening: hardening(),
        test: YieldTest::Compression,
        rate: None,
        moduli: MODULI,
    }
}

pub(super) fn ceramic() -> JohnsonHolmquist {
    JohnsonHolmquist {
        shear: MODULI.shear,
        intact: [0.9, 0.6, f64::INFINITY],
        fractured: [0.4, 0.6, f64::INFINITY],
        rate: RateFactor::JohnsonCook { c: 0.01, reference: 1.0 },
        tension: 0.01,
        elastic_limit: [0.06, 0.04],
        bulking: 1.0,
        fracture: [0.01, 1.0],
        fracture_range: [0.0, f64::INFINITY],
        compression: [MODULI.bulk, 0.0, 0.0],
        deletion: 0.0,
    }
}

pub(super) fn impacted_concrete() -> HolmquistJohnsonCook {
    let (lock, compression) = ([0.5, 0.1], [5.0, 10.0, 0.0]);
    HolmquistJohnsonCook {
        shear: MODULI.shear,
        strength: [0.8, 1.6, 0.6],
        largest_strength: 7.0,
        compressive: 0.02,
        rate: RateFactor::JohnsonCook { c: 0.01, reference: 1.0 },
        tension: 0.004,
        fracture: [0.04, 1.0, 0.01],
        crush: [0.01, 0.01 / MODULI.bulk],
        lock,
        compression,
        deletion: 0.0,
        compacted: HolmquistJohnsonCook::compacted(lock, compression).expect("compaction"),
    }
}

pub(super) fn concrete() -> ConcreteDamagedPlasticity {
    let young = 9.0 * MODULI.bulk * MODULI.shear / (3.0 * MODULI.bulk + MODULI.shear);
    let table = |rows: &[[f64; 3]], damages: &[[f64; 2]]| {
        ConcreteTable::new(ConcreteAbscissa::Strain, rows, damages, young).expect("table")
    };
    ConcreteDamagedPlasticity {
        dilatancy: 0.6,
        eccentricity: 0.1,
        surface: ConcreteSurface::new(1.16, 2.0 / 3.0),
        moduli: MODULI,
        compression: table(&[[0.02, 0.0, 0.0], [0.03, 0.02, 0.0], [0.01, 0.1, 0.0]], &[[0.0, 0.0], [0.5, 0.1]]),
        tension: table(&[[0.004, 0.0, 0.0], [0.001, 0.02, 0.0]], &[[0.0, 0.0], [0.7, 0.02]]),
        recovery: [0.0, 1.0],
        failure: None,
    }
}

pub(super) fn powder() -> CapPlasticity {
    CapPlasticity {
        cohesion: 0.005,
        friction: 1.0,
        eccentricity: 0.4,
        transition: 0.03,
        compaction: 0.0,
        hardening: LinearTable { rows: vec![[0.02, 0.0], [0.1, 0.03], [0.5, 0.1]] },
        moduli: MODULI,
    }
}

pub(super) fn sheet() -> HillPotential {
    // Isotropic in the r-z plane, so that rotated motions give rotated stresses.
    let shear = (1.5_f64 / (2.0 - 0.5 / 1.44)).sqrt();
    HillPotential::new([1.0, 1.0, 1.2, shear], hardening(), MODULI).expect("closed surface")
}

pub(super) fn voids() -> PorousMetal {
    PorousMetal {
        constants: [1.5, 1.0, 2.25],
        voids: 0.02,
        hardening: hardening(),
        nucleation: Some(VoidNucleation { mean: 0.02, deviation: 0.01, fraction: 0.04 }),
        failure: None,
        moduli: MODULI,
    }
}

pub(super) fn porous() -> EquationOfState {
    let solid = UsUp { density: 1.25 * DENSITY, c0: 1.5, s: 1.3, gamma0: 1.5 };
    EquationOfState::Compacting(PorousCompaction::new(solid, 1.0, 0.2, [0.01, 0.2]))
}
