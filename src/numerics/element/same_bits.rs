//! Tests that every material law gives the same bits on every instruction set, and with any numbers in
//! scratch memory.

use std::sync::Arc;

use pulp::Arch;

use super::battery::{DENSITY, LAWS, MODULI, TestedLaw};
use super::solid_groups::MaterialVisitor;
use crate::element::constants::{ElementConstants, HourglassControl};
use crate::element::group::{ElementGroup, ElementPass, GroupSetting};
use crate::element::quad::{QuadGroup, spoil_scratch};
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::kernel::hardening::{FlowStress, JohnsonCook, LinearTable, RateFactor, StaticYield};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::lanes::LANES;
use crate::material::PointValue;
use crate::material::eos::{IdealGas, Tabulated, UsUp};
use crate::material::equation_of_state::EquationOfState;
use crate::material::explosive::{DetonationPoint, HighExplosive, JwlProducts};
use crate::material::failed::KeptFailure;
use crate::material::failure::{EvolutionLaw, FailureStrain, MaterialFailure, StrainCriterion, TensionCutoff};
use crate::material::foam::{FoamHardening, FoamMaterial};
use crate::material::hyperelastic::HyperelasticMaterial;
use crate::material::kinematic::KinematicHardening;
use crate::material::kinematic_rate::RateKinematicHardening;
use crate::material::plasticity::{PiecewiseLinearHardening, RateDependentHardening};
use crate::material::point_law::{PointLaw, PointLawData};
use crate::material::strain_energy::{OgdenEnergy, PolynomialEnergy, VolumetricEnergy};
use crate::material::user::SubroutineMaterial;
use crate::material::user::description::{BuiltInPlasticity, UserMaterialData, YieldSource};
use crate::material::user::energy::{AnisotropicEnergy, HolzapfelEnergy};
use crate::material::user_eos::UserEos;
use crate::material::{Material, PlasticFlow};
use crate::mesh::corner_forces::CornerForces;
use crate::routines::{
    ElasticModuli, EosLaw, EosResponse, LoadFailure, MaterialLaw, MaterialPoint, PointQuantity, PointRoutines,
};
use crate::state::Instant;
use crate::state::nodes::{Node, NodeAccelerations};
use crate::variables::Variable;

/// Ambient pressure of the gas.
pub(super) const AMBIENT: f64 = 0.01;
const COLUMNS: usize = 5;
const ROWS: usize = 4;
const DT: f64 = 0.02;

/// Returns a distorted mesh of twenty elements (the last block is not full) with irregular velocities.
fn nodes() -> Vec<Node> {
    let wobble = |i: usize| ((i * 7919) % 101) as f64 * 1e-3;
    let node = |n: usize| {
        let (i, j) = (n % (COLUMNS + 1), n / (COLUMNS + 1));
        let (v_r, v_z) = (wobble(n + 5) - 0.03, wobble(n + 9) - 0.06);
        Node { r: i as f64 + wobble(n), z: j as f64 - wobble(n + 3), v_r, v_z }
    };
    (0..(COLUMNS + 1) * (ROWS + 1)).map(node).collect()
}

fn elements() -> Vec<[u32; 4]> {
    let row = COLUMNS as u32 + 1;
    let corner = |e: usize| (e / COLUMNS * (COLUMNS + 1) + e % COLUMNS) as u32;
    (0..COLUMNS * ROWS).map(corner).map(|n| [n, n + 1, n + row + 1, n + row]).collect()
}

/// Results of a combination of laws after some increments of a given motion.
#[derive(Debug, PartialEq)]
struct CompositionResult {
    bits: Vec<u64>,
    plastic: f64,
    deleted: usize,
}

/// Runs a material on an instruction set, without or with assumed strains.
struct CompositionRun {
    arch: Arch,
    enhanced: f64,
}

impl MaterialVisitor for CompositionRun {
    /// `None` for materials that call user subroutines.
    type Output = Option<CompositionResult>;

    fn visit(self, material: impl Material) -> Option<CompositionResult> {
        run(material, self.arch, self.enhanced)
    }
}

fn run<M: Material>(material: M, arch: Arch, enhanced: f64) -> Option<CompositionResult> {
    if M::CALLS {
        return None;
    }
    let (nodes, elements) = (nodes(), elements());
    let can_delete = material.can_delete();
    let mut quads = QuadGroup::new(material, constants(enhanced), DENSITY, &elements, &nodes).on(arch);
    if M::EQUATION_OF_STATE {
        quads = quads.with_subzones(&elements, &nodes);
    }
    let corners = &mut CornerForces::new(elements.len().div_ceil(LANES));
    let compacts = quads.value(0, Variable::Distension.into()).is_some();
    let result = moved(quads, nodes, corners, !matches!(arch, Arch::Scalar));
    // Energy stored in a deleted element counts as dissipated, and so does the collapse of pores.
    let dissipates = can_delete || compacts || matches!(M::FLOW, PlasticFlow::Deviatoric | PlasticFlow::Coupled);
    assert_eq!(dissipates, result.plastic > 0.0, "{}", result.plastic);
    assert_eq!(can_delete, result.deleted > 0, "{} deleted", result.deleted);
    assert!(result.deleted < elements.len(), "all elements are deleted");
    Some(result)
}

fn constants(enhanced: f64) -> ElementConstants {
    ElementConstants {
        bulk: 3.0,
        shear: 1.0,
        hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.01, relaxes: true, enhanced },
        bulk_viscosity: BulkViscosity::default(),
        shear_viscosity: 0.0,
        by_area: false,
    }
}

/// Moves a group over some increments. `spoils`: scratch memory contains other numbers before each.
fn moved(
    mut quads: impl ElementGroup,
    mut nodes: Vec<Node>,
    corners: &mut CornerForces,
    spoils: bool,
) -> CompositionResult {
    let (elements, blocks) = (quads.len(), quads.len().div_ceil(LANES));
    for e in 0..elements {
        quads.set(e, PointValue::Temperature(25.0 + e as f64));
        quads.set(e, PointValue::SpecificEnergy(1e-3 * (1 + e) as f64));
    }
    quads.configure(GroupSetting::Records);
    let (mut bits, mut plastic) = (Vec::new(), 0.0);
    for _ in 0..20 {
        nodes.iter_mut().for_each(|n| (n.r, n.z) = (n.r + DT * n.v_r, n.z + DT * n.v_z));
        if spoils {
            spoil_scratch();
        }
        let totals = quads.update(ElementPass {
            nodes: &nodes,
            dt: DT,
            before: NodeAccelerations::default(),
            now: &Instant::default(),
            threads: false,
            user: PointRoutines::default(),
            corners: corners.slots(0..blocks),
            tiles: None,
            dilation_correction: None,
            prefetches: true,
        });
        plastic += totals.plastic;
        let sums = [totals.internal, totals.plastic, totals.viscous, totals.artificial, totals.rate];
        assert!(sums.iter().all(|x| x.is_finite()) && totals.rate > 0.0, "{totals:?}");
        let corners = &*corners;
        let forces = (0..elements).flat_map(|e| (0..4).flat_map(move |c| corners.of(e / LANES, e % LANES, c)));
        bits.extend(forces.chain(sums).map(f64::to_bits));
    }
    let mut deleted = 0;
    for e in 0..elements {
        deleted += usize::from(quads.value(e, Variable::Status.into()) == Some(0.0));
        let values = Variable::ALL.iter().flat_map(|v| v.parts()).filter_map(|part| quads.value(e, part));
        bits.extend(values.map(f64::to_bits));
    }
    CompositionResult { bits, plastic, deleted }
}

/// Compares a law on all available instruction sets.
fn assert_same_bits(law: &TestedLaw, enhanced: f64) {
    let (name, run) = (law.name, |arch| (law.material)().visit(CompositionRun { arch, enhanced }));
    println!("{name}");
    let scalar = run(Arch::Scalar);
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(v3) = pulp::x86::V3::try_new() {
            assert!(scalar == run(Arch::V3(v3)), "{name}: AVX2");
        }
        if let Some(v4) = pulp::x86::V4::try_new() {
            assert!(scalar == run(Arch::V4(v4)), "{name}: AVX-512");
        }
    }
    assert!(scalar == run(Arch::new()), "{name}: default instruction set");
}

pub(super) fn lines() -> PiecewiseLinearHardening {
    PiecewiseLinearHardening::new(&[[0.02, 0.0], [0.03, 0.1]], 1.0).expect("slopes fall")
}

fn johnson_cook() -> FlowStress {
    let base = JohnsonCook { a: 0.02, b: 0.01, n: 0.3, m: 1.1, melt: 500.0, transition: 20.0 };
    let factor = Some(RateFactor::JohnsonCook { c: 0.02, reference: 1e-3 });
    FlowStress { base: StaticYield::JohnsonCook(base), factor }
}

pub(super) fn general() -> RateDependentHardening {
    RateDependentHardening { law: johnson_cook(), heating: PlasticHeating::Constant(50.0) }
}

pub(super) fn kinematic() -> KinematicHardening {
    KinematicHardening { yield_stress: 0.02, slope: 0.1 }
}

pub(super) fn moving() -> RateKinematicHardening {
    let slope = LinearTable { rows: vec![[0.1, 20.0], [0.05, 200.0]] };
    RateKinematicHardening { size: johnson_cook(), slope, heating: PlasticHeating::Constant(50.0) }
}

pub(super) fn gas() -> EquationOfState {
    EquationOfState::IdealGas(IdealGas {
        gas_constant: 0.4,
        specific_heat: 1.0,
        ambient: AMBIENT,
        absolute_zero: -273.0,
    })
}

pub(super) fn us_up() -> EquationOfState {
    EquationOfState::UsUp(UsUp { density: 2.0, c0: 1.2, s: 1.5, gamma0: 2.0 })
}

pub(super) fn table() -> EquationOfState {
    let rows = [[-0.4, 1.8, 0.2], [0.0, 2.0, 0.0], [0.5, 2.1, -0.1], [3.0, 2.5, -0.5]];
    EquationOfState::Tabulated(Tabulated::new(2.0, &rows))
}

/// Returns an explosive: some elements burn, the front has not reached the others.
pub(super) fn explosive() -> EquationOfState {
    let products = JwlProducts { density: 2.0, pressures: [3.0, 0.1], exponents: [4.0, 1.0], omega: 0.3 };
    let points =
        vec![DetonationPoint { place: [0.0, 0.0], time: -1.0 }, DetonationPoint { place: [5.0, 4.0], time: -0.5 }];
    EquationOfState::Explosive(HighExplosive { products, speed: 2.0, energy: 0.1, unburnt: 0.4, points })
}

pub(super) fn mooney() -> HyperelasticMaterial<PolynomialEnergy> {
    let terms = vec![(0.4, 1, 0), (0.1, 0, 1), (0.02, 3, 0), (0.01, 1, 1)];
    HyperelasticMaterial {
        shape: PolynomialEnergy { terms },
        volume: VolumetricEnergy { inverse: vec![2.0, 0.5] },
        shear: 1.0,
    }
}

pub(super) fn ogden() -> HyperelasticMaterial<OgdenEnergy> {
    let terms = vec![[0.7, 1.3], [0.3, -2.0]];
    HyperelasticMaterial { shape: OgdenEnergy { terms }, volume: VolumetricEnergy { inverse: vec![2.0] }, shear: 1.0 }
}

fn foam(growth: FoamHardening) -> FoamMaterial {
    let hardening = LinearTable { rows: vec![[0.02, 0.0], [0.03, 0.1]] };
    let rate =
        RateFactor::PowerLaw { d: LinearTable { rows: vec![[10.0, 0.0]] }, n: LinearTable { rows: vec![[2.0, 0.0]] } };
    FoamMaterial { growth, hardening, rate: Some(rate), moduli: [3.0, 1.0] }
}

pub(super) fn compacted() -> FoamMaterial {
    foam(FoamHardening::Volumetric { compression: 1.1, tension: 0.1 })
}

pub(super) fn crushed() -> FoamMaterial {
    foam(FoamHardening::Isotropic { compression: 1.1, ratio: 0.1 })
}

/// Returns displacement-based damage that some elements complete, with the Johnson-Cook failure strain.
pub(super) fn failing() -> MaterialFailure {
    let strain =
        FailureStrain::JohnsonCook { d: [5e-4, 1e-3, 1.5, 0.01, 1.0], melt: 500.0, transition: 20.0, reference: 1e-3 };
    MaterialFailure {
        criteria: vec![StrainCriterion { strain, evolution: EvolutionLaw::Displacement(0.002) }],
        ..MaterialFailure::default()
    }
}

/// Returns the same damage with failed elements that stay.
pub(super) fn staying() -> KeptFailure {
    let failure = MaterialFailure { cutoff: tearing().cutoff, ..failing() };
    KeptFailure { failure, residual: 0.1, speed: 0.05 / DT }
}

/// Returns a tensile cutoff that some elements reach.
pub(super) fn tearing() -> MaterialFailure {
    MaterialFailure { cutoff: Some(TensionCutoff { stress: 0.005, deletes: true }), ..MaterialFailure::default() }
}

/// Isentropic gas of a law in Rust.
struct RustGas;

impl EosLaw for RustGas {
    fn respond(&self, constants: &[f64], density: f64, energy: f64) -> EosResponse {
        let pressure = constants[0] * density * energy;
        EosResponse { pressure, sound_speed: ((1.0 + constants[0]) * pressure / density).sqrt() }
    }
}

pub(super) fn user_eos() -> EquationOfState {
    EquationOfState::User(UserEos::new(Arc::new(RustGas), vec![0.4], DENSITY))
}

/// Linear elasticity as a law in Rust that uses some quantities.
struct RustLaw(&'static [PointQuantity]);

impl MaterialLaw for RustLaw {
    fn moduli(&self, _constants: &[f64]) -> Result<ElasticModuli, LoadFailure> {
        Ok(MODULI)
    }

    fn uses(&self) -> &'static [PointQuantity] {
        self.0
    }

    fn update(&self, point: &mut MaterialPoint<'_>) {
        let dilation = point.strain[0] + point.strain[1] + point.strain[2];
        for k in 0..4 {
            let volumetric = if k < 3 { (MODULI.bulk - 2.0 / 3.0 * MODULI.shear) * dilation } else { 0.0 };
            point.stress[k] += 2.0 * MODULI.shear * point.strain[k] + volumetric;
        }
        if !self.0.is_empty() {
            point.state[0] += point.energy + point.density + point.temperature + point.place[1] + point.gradient[3];
        }
    }
}

pub(super) fn user_law<const DETAILED: bool>() -> PointLaw<DETAILED> {
    use PointQuantity::{Density, Energy, Gradient, Moduli, Place, Spin, Temperature};
    let quantities: &[PointQuantity] = &[Temperature, Density, Energy, Place, Gradient, Spin, Moduli];
    PointLaw(PointLawData {
        law: Arc::new(RustLaw(if DETAILED { quantities } else { &[] })),
        constants: Vec::new(),
        variables: 1,
        delete: None,
        moduli: MODULI,
        density: DENSITY,
        heating: PlasticHeating::None,
    })
}

/// Returns a material of VUMAT, of a strain energy with fibres, or of built-in plasticity that is evaluated point by point.
pub(super) fn subroutine<const FLOWS: bool, const ENERGY: bool>() -> SubroutineMaterial<FLOWS, ENERGY> {
    let yields = YieldSource::Law(Arc::new(johnson_cook()));
    let flow = BuiltInPlasticity { bulk: MODULI.bulk, shear: MODULI.shear, elasticity: None, yields };
    let description = UserMaterialData {
        name: String::new(),
        properties: Vec::new(),
        variables: 1,
        delete: None,
        fields: 0,
        field_constants: None,
        length_constants: None,
        // Fibres along the hoop: the material is isotropic in the (r, z) plane.
        energy: ENERGY.then(|| AnisotropicEnergy {
            fibres: vec![[0.0, 0.0, 1.0]],
            built_in: Some(HolzapfelEnergy { c10: 0.5, d: 0.7, k1: 0.4, k2: 0.3, kappa: 0.1 }),
        }),
        flow: FLOWS.then_some(flow),
        heating: PlasticHeating::Constant(50.0),
        density: DENSITY,
    };
    SubroutineMaterial { description, names: Vec::new(), nodes: 4 }
}

#[test]
fn every_law_gives_the_same_bits_on_every_instruction_set() {
    LAWS.iter().for_each(|law| [0.0, 1.0].iter().for_each(|enhanced| assert_same_bits(law, *enhanced)));
}
