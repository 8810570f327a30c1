//! Closed forms of concrete damaged plasticity at a material point.

use super::concrete::{ConcreteDamagedPlasticity, ConcreteFailure};
use super::concrete_return::ConcreteSurface;
use super::concrete_tables::{ConcreteAbscissa, ConcreteTable};
use super::law::{ReturnPoint, StressReturn, TrialStress, contraction};
use super::root::bracketed_root;
use crate::kernel::moduli::ElasticModuli;
use crate::variables::Variable;

const YOUNG: f64 = 30e3;
const CRUSHING: [[f64; 3]; 5] =
    [[15.0, 0.0, 0.0], [26.0, 0.0007, 0.0], [30.0, 0.0015, 0.0], [18.0, 0.004, 0.0], [6.0, 0.009, 0.0]];
const CRUSHING_DAMAGE: [[f64; 2]; 5] = [[0.0, 0.0], [0.05, 0.0007], [0.15, 0.0015], [0.5, 0.004], [0.8, 0.009]];
const CRACKING: [[f64; 3]; 3] = [[2.6, 0.0, 0.0], [0.9, 0.0006, 0.0], [0.2, 0.0024, 0.0]];
const CRACKING_DAMAGE: [[f64; 2]; 3] = [[0.0, 0.0], [0.55, 0.0006], [0.9, 0.0024]];

/// Returns concrete with a strength of 30 MPa.
fn concrete(tension: ConcreteTable) -> ConcreteDamagedPlasticity {
    ConcreteDamagedPlasticity {
        dilatancy: 0.7,
        eccentricity: 0.1,
        surface: ConcreteSurface::new(1.16, 0.667),
        moduli: ElasticModuli::from_young(YOUNG, 0.2),
        compression: ConcreteTable::new(ConcreteAbscissa::Strain, &CRUSHING, &CRUSHING_DAMAGE, YOUNG).unwrap(),
        tension,
        recovery: [0.0, 1.0],
        failure: None,
    }
}

fn by_displacement() -> ConcreteTable {
    ConcreteTable::new(ConcreteAbscissa::Displacement, &CRACKING, &CRACKING_DAMAGE, YOUNG).unwrap()
}

/// Loaded axes of a specimen, with the component of their stress. The other ones have a constant stress.
#[derive(Clone, Copy)]
enum Loaded {
    Radial = 0,
    Axial = 1,
}

/// Small specimen under uniform strain.
#[derive(Clone)]
struct Specimen<'a> {
    law: &'a ConcreteDamagedPlasticity,
    length: f64,
    state: Vec<f64>,
    strain: [f64; 4],
    stress: [f64; 4],
    work: f64,
    plastic: f64,
    lost: f64,
    deleted: bool,
}

impl<'a> Specimen<'a> {
    fn new(law: &'a ConcreteDamagedPlasticity, length: f64) -> Specimen<'a> {
        let ([strain, stress], [work, plastic, lost]) = ([[0.0; 4]; 2], [0.0; 3]);
        Specimen { law, length, state: law.initial_state(), strain, stress, work, plastic, lost, deleted: false }
    }

    fn strained(&self, strain: [f64; 4]) -> Specimen<'a> {
        let mut next = self.clone();
        let carried = self.stress;
        let length = self.length;
        let mut point = ReturnPoint { length, ..ReturnPoint::new(strain, carried, &mut next.state, self.law.moduli) };
        self.law.update(&mut point);
        let ReturnPoint { stress, plastic, lost, deleted, .. } = point;
        let mean = std::array::from_fn(|i| 0.5 * (carried[i] + stress[i]));
        next.work += contraction(mean, strain);
        next.plastic += contraction(mean, plastic);
        next.lost += lost;
        next.strain = std::array::from_fn(|i| self.strain[i] + strain[i]);
        (next.stress, next.deleted) = (stress, deleted);
        next
    }

    /// Strains one direction, with a stress across it.
    fn load(&mut self, loaded: Loaded, change: f64, across: f64) {
        let bound = 5.0 * change.abs();
        let strained = |free: f64| match loaded {
            Loaded::Axial => self.strained([free, change, free, 0.0]),
            Loaded::Radial => self.strained([change, free, change, 0.0]),
        };
        let outside = |free: f64| strained(free).stress[1 - loaded as usize] - across;
        *self = strained(bracketed_root(bound, -bound, 1e-9, outside));
    }

    fn value(&self, variable: Variable) -> f64 {
        self.state[self.law.output(variable.into()).unwrap()]
    }

    /// Returns the energy that the specimen can give back.
    fn recoverable(&self) -> f64 {
        let TrialStress { pressure, mises, .. } = TrialStress::of(self.stress);
        let moduli = self.law.moduli;
        let energy = pressure * pressure / (2.0 * moduli.bulk) + mises * mises / (6.0 * moduli.shear);
        energy / (1.0 - self.value(Variable::Degradation))
    }
}

/// The stress is that of the cards at the inelastic strain of the cards, at each of their rows.
#[test]
fn uniaxial_curves_are_the_tables() {
    let (law, length) = (concrete(by_displacement()), 1.25);
    for (sign, factor, rows) in [(-1.0, 1.0, &CRUSHING[..]), (1.0, 1.0 / length, &CRACKING)] {
        let mut specimen = Specimen::new(&law, length);
        for &[stress, abscissa, _] in rows {
            let end = sign * (abscissa * factor + stress / YOUNG);
            let count = ((end - specimen.strain[1]).abs() / 1e-6).ceil();
            let change = (end - specimen.strain[1]) / count;
            (0..count as usize).for_each(|_| specimen.load(Loaded::Axial, change, 0.0));
            let difference = specimen.stress[1] - sign * stress;
            assert!(difference.abs() < 2e-6 * rows[0][0], "{difference} of {stress} at {abscissa}");
        }
        // The degradation is the damage of the last row.
        let degradation = specimen.value(Variable::Degradation);
        assert!((degradation - if sign > 0.0 { 0.9 } else { 0.8 }).abs() < 1e-6, "{degradation}");
    }
}

/// Returns the largest magnitude of a stress under compression.
fn strength(loaded: Loaded, across: f64) -> f64 {
    let law = concrete(by_displacement());
    let hydrostatic = across / (3.0 * law.moduli.bulk);
    let mut specimen = Specimen::new(&law, 1.0).strained([hydrostatic, hydrostatic, hydrostatic, 0.0]);
    let mut peak = 0.0_f64;
    for _ in 0..8000 {
        specimen.load(loaded, -1e-6, across);
        peak = peak.max(-specimen.stress[loaded as usize]);
    }
    peak
}

#[test]
fn biaxial_and_confined_strengths_are_the_closed_forms() {
    // A = 0.16/1.32 and C = 3 (1 - Kc)/(2 Kc - 1).
    let [a, c] = [0.16 / 1.32, 3.0 * 0.333 / 0.334];
    let slope = 1.0 + (3.0 * a + c) / (1.0 - a);
    let confined = |cell: f64| (Loaded::Axial, cell, 30.0 + cell * slope);
    for (loaded, cell, expected) in [confined(0.0), confined(5.0), confined(15.0), (Loaded::Radial, 0.0, 34.8)] {
        let found = strength(loaded, -cell);
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} for {expected}");
    }
}

/// An element dissipates the fracture energy per area at every length.
#[test]
fn dissipation_is_the_fracture_energy() {
    let law = concrete(ConcreteTable::of_fracture_energy(&[[2.6, 0.11, 0.0]], &[], YOUNG).unwrap());
    for length in [4.0, 10.0, 20.0] {
        let mut specimen = Specimen::new(&law, length);
        // The displacement of the last row is 2 Gf/ft.
        let change = 2.0 * 0.11 / 2.6 / length / 4000.0;
        (0..4000).for_each(|_| specimen.load(Loaded::Axial, change, 0.0));
        let energy = specimen.work * length;
        assert!((energy / 0.11 - 1.0).abs() < 1e-4, "{energy} at the length {length}");
    }
}

/// Work is plastic, lost or recoverable, through cracking, closing, crushing and opening.
#[test]
fn energies_of_a_cycle_add_up() {
    let mut law = concrete(by_displacement());
    law.recovery = [0.3, 0.8];
    let mut specimen = Specimen::new(&law, 1.0);
    let mut smallest = 0.0_f64;
    for end in [4e-4, -2e-3, 2e-4, -4e-3, -1e-3] {
        let change = (end - specimen.strain[1]) / 500.0;
        for _ in 0..500 {
            let lost = specimen.lost;
            specimen.load(Loaded::Axial, change, 0.0);
            smallest = smallest.min(specimen.lost - lost);
        }
        let rest = specimen.work - specimen.plastic - specimen.lost - specimen.recoverable();
        assert!(rest.abs() < 1e-12 * specimen.work, "{rest} of {}", specimen.work);
    }
    assert!(smallest < 0.0, "no stiffness is recovered");
}

/// The strength is linear over the rate of the plastic strain, here the rate of the strain: the length of an increment is 1.
#[test]
fn steady_flow_has_the_strength_of_its_rate() {
    let rows = [[2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [4.0, 0.0, 1e-6], [4.0, 1.0, 1e-6]];
    let law = concrete(ConcreteTable::new(ConcreteAbscissa::Strain, &rows, &[], YOUNG).unwrap());
    for (change, expected) in [(2.5e-7, 2.5), (5e-7, 3.0), (4e-6, 4.0)] {
        let mut specimen = Specimen::new(&law, 1.0);
        (0..1000).for_each(|_| specimen.load(Loaded::Axial, change, 0.0));
        assert!((specimen.stress[1] - expected).abs() < 1e-5, "{} for {expected}", specimen.stress[1]);
    }
}

/// Increments up to 1000 % strain end in finite stress, below the strength in hydrostatic tension.
#[test]
fn huge_increments_end_in_finite_stress() {
    // sc0/(sc0/st0 - (1 - 2 A)/(1 - A)).
    let hydrostatic = 15.0 / (15.0 / 2.6 - 1.0 / 1.16) + 1e-9;
    let inside = |stress: f64| stress.is_finite() && stress < hydrostatic;
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut law = concrete(by_displacement());
    for (dilatancy, eccentricity, size) in [(0.7, 0.1, 1e-4), (0.7, 0.1, 1e-2), (0.7, 0.1, 10.0), (0.0, 0.0, 1.0)] {
        (law.dilatancy, law.eccentricity) = (dilatancy, eccentricity);
        let mut specimen = Specimen::new(&law, 1.0);
        for _ in 0..2000 {
            specimen = specimen.strained([0.0; 4].map(|_| size * random()));
            assert!(specimen.stress[..3].iter().all(|&stress| inside(stress)), "{:?}", specimen.stress);
        }
        // Equal expansion: no deviator gives the direction of the flow.
        specimen = Specimen::new(&law, 1.0).strained([size, size, size, 0.0]);
        assert!(inside(specimen.stress[0]));
    }
}

#[test]
fn limits_delete_the_element() {
    let none = ConcreteFailure::default();
    // Rows of the tables: the strain at a limit follows from the stress there.
    for (sign, failure, strain) in [
        (1.0, ConcreteFailure { cracking_strain: Some(0.0003), ..none }, 0.0003 + 0.9 / YOUNG),
        (1.0, ConcreteFailure { cracking_displacement: Some(0.0006), ..none }, 0.0003 + 0.9 / YOUNG),
        (1.0, ConcreteFailure { tension_damage: Some(0.9), ..none }, 0.0012 + 0.2 / YOUNG),
        (-1.0, ConcreteFailure { inelastic_strain: Some(0.004), ..none }, 0.004 + 18.0 / YOUNG),
        (-1.0, ConcreteFailure { compression_damage: Some(0.5), ..none }, 0.004 + 18.0 / YOUNG),
    ] {
        let mut law = concrete(by_displacement());
        law.failure = Some(failure);
        let mut specimen = Specimen::new(&law, 2.0);
        while !specimen.deleted && specimen.strain[1].abs() < 0.1 {
            specimen.load(Loaded::Axial, sign * 2e-6, 0.0);
        }
        assert!((specimen.strain[1].abs() - strain).abs() < 4e-6, "{} for {failure:?}", specimen.strain[1]);
    }
}
