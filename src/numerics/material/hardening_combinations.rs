//! Tests of all hardening laws with all forms of rate dependence over random strain paths.
#![allow(clippy::needless_range_loop)] // Lanes index several lists at once.

use super::increment::{StrainIncrement, StressUpdate};
use super::kinematic::KinematicHardening;
use super::kinematic_rate::RateKinematicHardening;
use super::plasticity::{HardeningLaw, PiecewiseLinearHardening, RateDependentHardening};
use super::volumetric::ConstantBulkModulus;
use super::von_mises::VonMises;
use super::{BlockStart, Material};
use crate::kernel::hardening::{
    FlowStress, JohnsonCook, LinearTable, RateFactor, StaticYield, TableOverTemperature, YieldStress,
};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::lanes::{LANES, Lanes};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::stress::mises;
use crate::variables::Variable;

const MODULI: ElasticModuli = ElasticModuli { bulk: 70e3, shear: 26e3 };
const YIELD: f64 = 200.0;
/// Slope of the stress over the plastic strain.
const SLOPE: f64 = 400.0;
const DT: f64 = 1e-7;

/// A block of one material with scratch memory that another block has used.
struct TestBlock<M: Material> {
    material: M,
    state: M::State,
    stress: [Lanes; 4],
    update: StressUpdate,
    count: usize,
}

impl<M: Material> TestBlock<M> {
    /// Creates a block whose first `count` lanes hold elements. The other lanes are never strained.
    fn new(material: M, count: usize) -> Self {
        let unity = [1.0; LANES];
        let corners = [[[0.0; 4]; 2]; LANES];
        let start = BlockStart { count, area: unity, volume: unity, centre: [unity; 2], corners, first: 0 };
        let state = material.initial_state(&start);
        TestBlock { material, state, stress: [[0.0; LANES]; 4], update: StressUpdate::default(), count }
    }

    /// Applies strain increments (rr, zz, hoop, rz) of each lane over an increment.
    fn strain(&mut self, strains: &[[f64; 4]; LANES], dt: f64) {
        let mut strain = StrainIncrement { carried: self.stress, dt, moduli: MODULI, ..StrainIncrement::default() };
        strain.count = self.count;
        self.update.begin();
        // Results of the previous block of the task.
        (self.update.flow, self.update.plastic) = ([1e-3; LANES], [[7.0; LANES]; 4]);
        for l in 0..LANES {
            let components = if l < self.count { strains[l] } else { [0.0; 4] };
            strain.volume[l] = if l < self.count { 1.0 } else { 0.0 };
            let dilation = components[0] + components[1] + components[2];
            let mean = (self.stress[0][l] + self.stress[1][l] + self.stress[2][l]) / 3.0;
            self.update.mean[l] = mean + MODULI.bulk * dilation;
            let mut deviator = [0.0; 4];
            for i in 0..4 {
                strain.strain[i][l] = components[i];
                let part = if i < 3 { (mean, dilation / 3.0) } else { (0.0, 0.0) };
                deviator[i] = self.stress[i][l] - part.0 + 2.0 * MODULI.shear * (components[i] - part.1);
                self.update.deviator[i][l] = deviator[i];
            }
            self.update.trial[l] = mises(deviator);
        }
        self.material.update(&mut self.state, &mut self.stress, &strain, &mut self.update);
    }

    fn stress_of(&self, lane: usize) -> [f64; 4] {
        [0, 1, 2, 3].map(|i| self.stress[i][lane])
    }

    fn plastic_strain(&self, lane: usize) -> f64 {
        self.material.value(&self.state, lane, Variable::PlasticStrain.into()).expect("it is plastic")
    }

    fn is_finite(&self) -> bool {
        let StressUpdate { internal, dissipated, returned, .. } = &self.update;
        let lists = self.stress.iter().chain([internal, dissipated, returned]);
        lists.flatten().all(|value| value.is_finite()) && (0..self.count).all(|l| self.plastic_strain(l).is_finite())
    }
}

fn constant(value: f64) -> LinearTable {
    LinearTable { rows: vec![[value, 0.0]] }
}

/// Returns all forms of `*RATE DEPENDENT`.
fn rates() -> Vec<(&'static str, Option<RateFactor>)> {
    let power = |d: f64, n: f64| Some(RateFactor::PowerLaw { d: constant(d), n: constant(n) });
    let ratios = LinearTable { rows: vec![[1.0, 0.0], [1.2, 1e2], [1.5, 1e4], [1.9, 1e6]] };
    vec![
        ("no rate", None),
        ("POWER LAW, n = 4", power(6500.0, 4.0)),
        ("POWER LAW, n = 1", power(6500.0, 1.0)),
        ("POWER LAW, n = .5", power(65000.0, 0.5)),
        ("POWER LAW, n = 20", power(40.0, 20.0)),
        ("YIELD RATIO", Some(RateFactor::Ratio(TableOverTemperature { tables: vec![(0.0, ratios)] }))),
        ("JOHNSON COOK", Some(RateFactor::JohnsonCook { c: 0.02, reference: 1.0 })),
    ]
}

fn table(rows: &[[f64; 2]]) -> StaticYield {
    StaticYield::Tables(TableOverTemperature { tables: vec![(0.0, LinearTable { rows: rows.to_vec() })] })
}

fn johnson_cook(n: f64) -> StaticYield {
    let law = JohnsonCook { a: YIELD, b: SLOPE, n, m: 1.0, melt: 900.0, transition: 20.0 };
    StaticYield::JohnsonCook(law)
}

fn isotropic(base: StaticYield, factor: Option<RateFactor>, heating: PlasticHeating) -> RateDependentHardening {
    RateDependentHardening { law: FlowStress { base, factor }, heating }
}

fn kinematic(factor: Option<RateFactor>, slope: f64, heating: PlasticHeating) -> RateKinematicHardening {
    let size = FlowStress { base: table(&[[YIELD, 0.0]]), factor };
    RateKinematicHardening { size, slope: constant(slope), heating }
}

/// Returns a number from -1 to 1 of a linear congruential sequence.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Strain increments of all lanes: zero, tiny or up to a yield strain or ten, in directions that reverse at random.
fn random_strains(seed: &mut u64) -> [[f64; 4]; LANES] {
    std::array::from_fn(|_| {
        let size = match ((random(seed) + 1.0) * 5.0) as usize {
            0 | 1 => 0.0,
            2 => 1e-300,
            3 => 1e-20,
            4 => 1e-9,
            5..=7 => 2e-3,
            _ => 3e-2,
        };
        std::array::from_fn(|_| size * random(seed))
    })
}

fn stays_finite<H: HardeningLaw>(name: &str, hardening: impl Fn() -> H) {
    for count in [1, 3, 15, LANES] {
        let mut block = TestBlock::new(VonMises::new(hardening(), ConstantBulkModulus), count);
        let seed = &mut (count as u64);
        for increment in 0..300 {
            let dt = if increment % 50 == 0 { 0.0 } else { DT * 10f64.powf(2.0 * random(seed)) };
            let strains = if dt == 0.0 { [[0.0; 4]; LANES] } else { random_strains(seed) };
            block.strain(&strains, dt);
            let StressUpdate { internal, dissipated, returned, .. } = &block.update;
            let plastic: Vec<f64> = (0..count).map(|l| block.plastic_strain(l)).collect();
            let lists = (&block.stress, internal, dissipated, returned, plastic, strains[..count].to_vec(), dt);
            assert!(block.is_finite(), "{name}, {count} elements, increment {increment}: {lists:?}");
        }
        assert!((0..count).all(|l| block.plastic_strain(l) > 0.1), "{name}: has not yielded");
    }
}

#[test]
fn every_hardening_with_every_rate_is_finite_on_random_paths() {
    let heatings = || [PlasticHeating::None, PlasticHeating::Constant(0.4)];
    for (name, rate) in rates() {
        for heating in heatings() {
            let rows = [[YIELD, 0.0], [240.0, 0.1], [250.0, 1.0]];
            stays_finite(&format!("tables, {name}"), || isotropic(table(&rows), rate.clone(), heating.clone()));
            let rows = [[YIELD, 0.0], [100.0, 0.1]];
            stays_finite(&format!("softening, {name}"), || isotropic(table(&rows), rate.clone(), heating.clone()));
            for n in [0.2, 1.0] {
                let law = || isotropic(johnson_cook(n), rate.clone(), heating.clone());
                stays_finite(&format!("Johnson-Cook, {name}"), law);
            }
            for slope in [0.0, SLOPE] {
                stays_finite(&format!("kinematic {slope}, {name}"), || kinematic(rate.clone(), slope, heating.clone()));
            }
        }
    }
    stays_finite("kinematic", || KinematicHardening { yield_stress: YIELD, slope: SLOPE });
    let lines = || PiecewiseLinearHardening::new(&[[YIELD, 0.0], [240.0, 0.1]], MODULI.shear).expect("slopes fall");
    stays_finite("lines", lines);
}

/// Without hardening the yield surface does not move, so that kinematic and isotropic hardening agree on any path, at
/// any rate. Increments without plastic flow are among them.
#[test]
fn without_slope_kinematic_hardening_is_isotropic_on_any_path() {
    for (name, rate) in rates() {
        let law = kinematic(rate.clone(), 0.0, PlasticHeating::None);
        let mut kinematic = TestBlock::new(VonMises::new(law, ConstantBulkModulus), 13);
        let law = isotropic(table(&[[YIELD, 0.0]]), rate, PlasticHeating::None);
        let mut isotropic = TestBlock::new(VonMises::new(law, ConstantBulkModulus), 13);
        let seed = &mut 5;
        for _ in 0..200 {
            let strains = random_strains(seed);
            kinematic.strain(&strains, DT);
            isotropic.strain(&strains, DT);
        }
        for l in 0..13 {
            let ([a, b], [p, q]) = (
                [kinematic.stress_of(l), isotropic.stress_of(l)],
                [kinematic.plastic_strain(l), isotropic.plastic_strain(l)],
            );
            assert!((0..4).all(|i| (a[i] - b[i]).abs() < 1e-6 * YIELD), "{name}: {a:?} {b:?}");
            assert!((p / q - 1.0).abs() < 1e-6 && p > 0.1, "{name}: {p} {q}");
        }
    }
}

/// Under monotonic shear at a constant rate the stress is that of the yield surface plus the back stress: the flow
/// stress is size(rate) + C p, also with the first yield at rate zero and after unloading and reloading.
#[test]
fn monotonic_kinematic_hardening_reaches_its_flow_stress() {
    for (name, rate) in rates() {
        let law = kinematic(rate.clone(), SLOPE, PlasticHeating::None);
        let size = FlowStress { base: table(&[[YIELD, 0.0]]), factor: rate.clone() };
        let mut block = TestBlock::new(VonMises::new(law, ConstantBulkModulus), 3);
        let rows = [[YIELD, 0.0], [YIELD + 10.0 * SLOPE, 10.0]];
        let law = isotropic(table(&rows), None, PlasticHeating::None);
        let mut same = TestBlock::new(VonMises::new(law, ConstantBulkModulus), 3);
        let shear = |rate: f64| [[0.0, 0.0, 0.0, 0.5 * 3f64.sqrt() * rate * DT]; LANES];
        let path = [(0.0, 10), (2e3, 200), (-2e3, 3), (2e3, 200), (2e5, 60)];
        for (speed, increments) in path {
            for _ in 0..increments {
                block.strain(&shear(speed), DT);
                same.strain(&shear(speed), DT);
            }
            let previous = block.plastic_strain(1);
            block.strain(&shear(speed), DT);
            same.strain(&shear(speed), DT);
            let (p, stress) = (block.plastic_strain(1), mises(block.stress_of(1)));
            if speed <= 0.0 {
                // At once after fast flow a viscous overstress remains, which flows on.
                assert!(p >= previous, "{name}: {p} {previous}");
                continue;
            }
            let expected = size.at(0.0, (p - previous) / DT, 0.0) + SLOPE * p;
            assert!(p > previous && (stress / expected - 1.0).abs() < 1e-9, "{name}: {stress} {expected}");
            if rate.is_none() {
                let isotropic = same.stress_of(1);
                assert!((block.stress_of(1)[3] / isotropic[3] - 1.0).abs() < 1e-9, "{isotropic:?}");
            }
        }
    }
}
