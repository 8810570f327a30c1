//! Tests that every material law must pass: rotated strains give rotated stresses, the reported energy is the work of the
//! stress, the moduli bound the stiffness, a saved state continues with the same bits, and lanes do not depend on each
//! other. [`LAWS`] is the only list of laws; a new kind of material does not compile without a number here.

#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

use std::collections::BTreeSet;

use super::same_bits::{
    AMBIENT, compacted, crushed, explosive, failing, gas, general, kinematic, lines, mooney, moving, ogden, staying,
    subroutine, table, tearing, us_up, user_eos, user_law,
};
use super::same_laws::{ceramic, concrete, impacted_concrete, porous, powder, sheet, soil, voids};
use super::solid_groups::{HardeningLaw, MaterialVisitor, SolidMaterial};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::rotation::{rotate, rotation_of_spin};
use crate::kernel::stress::{mises, undamaged};
use crate::material::equation_of_state::EquationOfState;
use crate::material::hyperelastic::NeoHooke;
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::returns::ReturnMaterial;
use crate::material::user::points::PointAccess;
use crate::material::user::{BlockKinematics, CallTime};
use crate::material::{BlockStart, Material, PlasticFlow, PointValue};
use crate::routines::{LoadFailure, MaterialAnswer, MaterialCall, PointRoutines, UserMaterial};
use crate::state::Instant;
use crate::state::archive::{Persist, StateArchive};
use crate::variables::{Variable, VariableComponent};

const DT: f64 = 0.02;
pub(super) const DENSITY: f64 = 2.0;
pub(super) const MODULI: ElasticModuli = ElasticModuli { bulk: 3.0, shear: 1.0 };
const INCREMENTS: usize = 40;
/// Volume of an element with the corners [`CORNERS`].
const VOLUME: f64 = 3.0 * std::f64::consts::PI;
const CORNERS: [[f64; 4]; 2] = [[1.0, 2.0, 2.0, 1.0], [0.0, 0.0, 1.0, 1.0]];

/// A law of the list.
pub(super) struct TestedLaw {
    pub name: &'static str,
    pub material: fn() -> SolidMaterial,
}

/// Declares the laws with a test for each: its hardening with its equation of state, or its other material.
macro_rules! laws {
    ($($name:ident: $material:expr;)*) => {
        pub(super) const LAWS: &[TestedLaw] =
            &[$(TestedLaw { name: stringify!($name), material: || $material }),*];
        $(
            #[test]
            fn $name() {
                ($material).visit(Battery { name: stringify!($name) });
            }
        )*
    };
}

use HardeningLaw::{Elastic, Failing, Kinematic, PiecewiseLinear, RateDependent, RateKinematic};
use SolidMaterial::{
    DetailedPoint, Foam, Ogden, Point, Polynomial, Return, UserEnergy, UserFlow, UserStress, VonMises,
};

laws! {
    elastic: VonMises(Elastic(None), None);
    elastic_gas: VonMises(Elastic(None), Some(gas()));
    elastic_us_up: VonMises(Elastic(None), Some(us_up()));
    elastic_table: VonMises(Elastic(None), Some(table()));
    elastic_explosive: VonMises(Elastic(None), Some(explosive()));
    elastic_compaction: VonMises(Elastic(None), Some(porous()));
    elastic_user_eos: VonMises(Elastic(None), Some(user_eos()));
    tearing_elastic: VonMises(Elastic(Some(tearing())), None);
    tearing_us_up: VonMises(Elastic(Some(tearing())), Some(us_up()));
    piecewise_linear: VonMises(PiecewiseLinear(lines()), None);
    piecewise_linear_gas: VonMises(PiecewiseLinear(lines()), Some(gas()));
    piecewise_linear_table: VonMises(PiecewiseLinear(lines()), Some(table()));
    rate_dependent: VonMises(RateDependent(general(), None), None);
    rate_dependent_us_up: VonMises(RateDependent(general(), None), Some(us_up()));
    failing_rate_dependent: VonMises(RateDependent(general(), Some(failing())), None);
    failing_gas: VonMises(RateDependent(general(), Some(failing())), Some(gas()));
    staying_rate_dependent: VonMises(Failing(general(), staying()), None);
    staying_us_up: VonMises(Failing(general(), staying()), Some(us_up()));
    linear_kinematic: VonMises(Kinematic(kinematic()), None);
    linear_kinematic_us_up: VonMises(Kinematic(kinematic()), Some(us_up()));
    rate_kinematic: VonMises(RateKinematic(moving()), None);
    rate_kinematic_gas: VonMises(RateKinematic(moving()), Some(gas()));
    neo_hooke: SolidMaterial::NeoHooke(NeoHooke { c10: 0.5, d1: 0.7 });
    mooney_rivlin: Polynomial(mooney());
    ogden_rubber: Ogden(ogden());
    volumetric_foam: Foam(compacted());
    isotropic_foam: Foam(crushed());
    drucker_prager: Return(ReturnMaterial { law: Box::new(soil()), keeps_elements: false });
    johnson_holmquist: Return(ReturnMaterial { law: Box::new(ceramic()), keeps_elements: false });
    holmquist_johnson_cook: Return(ReturnMaterial { law: Box::new(impacted_concrete()), keeps_elements: false });
    concrete_damaged_plasticity: Return(ReturnMaterial { law: Box::new(concrete()), keeps_elements: false });
    cap_plasticity: Return(ReturnMaterial { law: Box::new(powder()), keeps_elements: false });
    hill_potential: Return(ReturnMaterial { law: Box::new(sheet()), keeps_elements: false });
    porous_metal: Return(ReturnMaterial { law: Box::new(voids()), keeps_elements: false });
    law_in_rust: Point(user_law());
    detailed_law_in_rust: DetailedPoint(user_law());
    user_stress: UserStress(subroutine());
    user_energy: UserEnergy(subroutine());
    user_flow: UserFlow(subroutine());
}

/// Returns a number of each kind of material, without gaps from 0.
fn number(material: &SolidMaterial) -> usize {
    match material {
        VonMises(Elastic(None), _) => 0,
        VonMises(Elastic(Some(_)), _) => 1,
        VonMises(PiecewiseLinear(_), _) => 2,
        VonMises(RateDependent(_, None), _) => 3,
        VonMises(RateDependent(_, Some(_)), _) => 4,
        VonMises(Kinematic(_), _) => 5,
        VonMises(RateKinematic(_), _) => 6,
        SolidMaterial::NeoHooke(_) => 7,
        Polynomial(_) => 8,
        Ogden(_) => 9,
        Foam(_) => 10,
        Point(_) => 11,
        DetailedPoint(_) => 12,
        UserStress(_) => 13,
        UserFlow(_) => 14,
        VonMises(Failing(..), _) => 15,
        Return(_) => 16,
        UserEnergy(_) => 17,
    }
}

/// Returns a number of the pressure law of a material, without gaps from 0.
fn pressure_number(material: &SolidMaterial) -> Option<usize> {
    let VonMises(_, equation) = material else { return None };
    Some(match equation {
        None => 0,
        Some(EquationOfState::IdealGas(_)) => 1,
        Some(EquationOfState::UsUp(_)) => 2,
        Some(EquationOfState::Tabulated(_)) => 3,
        Some(EquationOfState::Explosive(_)) => 4,
        Some(EquationOfState::User(_)) => 5,
        Some(EquationOfState::Compacting(_)) => 6,
    })
}

#[test]
fn no_law_is_missing() {
    let kinds: BTreeSet<usize> = LAWS.iter().map(|law| number(&(law.material)())).collect();
    assert!(kinds.into_iter().eq(0..18));
    let pressures: BTreeSet<usize> = LAWS.iter().filter_map(|law| pressure_number(&(law.material)())).collect();
    assert!(pressures.into_iter().eq(0..7));
}

/// The tests of one law.
struct Battery {
    name: &'static str,
}

impl MaterialVisitor for Battery {
    type Output = ();

    fn visit(self, material: impl Material) {
        let name = self.name;
        let lanes = inline_from_fn(|l| l);
        rotated_strains_rotate_stresses(name, &material);
        reported_energy_is_the_work_of_the_stress(name, &material);
        moduli_bound_the_stiffness(name, &material);
        saved_state_continues_with_the_same_bits(name, &material, lanes);
        lanes_do_not_depend_on_each_other(name, &material, lanes);
    }
}

/// A block of elements with a prescribed motion. Each lane follows the motion of a number.
struct Specimen<'m, M: Material> {
    material: &'m M,
    state: M::State,
    stress: [Lanes; 4],
    /// Deformation gradient: rr, zz, hoop, rz, zr.
    gradient: [Lanes; 5],
    time: f64,
    count: usize,
}

impl<M: Material> Clone for Specimen<'_, M> {
    fn clone(&self) -> Self {
        Specimen { state: self.state.clone(), ..*self }
    }
}

/// Displacement gradient of an increment at its middle: rr, zz, hoop, rz, zr.
type Motion = [f64; 5];

/// Returns the motion number `id` in an increment: loading, then partial unloading in another direction.
fn motion(id: usize, increment: usize) -> Motion {
    let size = 1e-3 * (1.0 + 0.1 * id as f64);
    let direction =
        if increment < INCREMENTS / 2 { [1.0, -0.6, -0.35, 0.5, 0.1] } else { [-0.6, 0.3, 0.35, -0.2, 0.3] };
    direction.inline_map(|part| size * part)
}

/// Returns a motion in axes that are rotated in the (r, z) plane; the spin does not change.
fn turned([rr, zz, hoop, rz, zr]: Motion, rotation: [f64; 2]) -> Motion {
    let spin = 0.5 * (rz - zr);
    let [rr, zz, hoop, shear] = rotate([rr, zz, hoop, 0.5 * (rz + zr)], rotation);
    [rr, zz, hoop, shear + spin, shear - spin]
}

/// Output variables of points, of which user subroutines get none here.
struct NoAccess;

impl PointAccess for NoAccess {
    fn component(&self, _point: usize, _part: VariableComponent) -> Option<f64> {
        None
    }
}

/// User material with linear elasticity.
struct Hooke;

impl UserMaterial for Hooke {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        for i in 0..n {
            let dilation = call.strain[i] + call.strain[n + i] + call.strain[2 * n + i];
            for k in 0..4 {
                let pressure = if k < 3 { (MODULI.bulk - 2.0 / 3.0 * MODULI.shear) * dilation } else { 0.0 };
                answer.stress[k * n + i] =
                    call.stress[k * n + i] + 2.0 * MODULI.shear * call.strain[k * n + i] + pressure;
            }
        }
        Ok(())
    }
}

impl<'m, M: Material> Specimen<'m, M> {
    /// Creates `count` elements, of which each has the initial values of its number.
    fn new(material: &'m M, ids: [usize; LANES], count: usize) -> Self {
        let start = BlockStart {
            count,
            area: [1.0; LANES],
            volume: [VOLUME; LANES],
            centre: [[1.5; LANES], [0.5; LANES]],
            corners: [CORNERS; LANES],
            first: 0,
        };
        let mut state = material.initial_state(&start);
        for (l, id) in ids.into_iter().enumerate() {
            material.set(&mut state, l, PointValue::Temperature(25.0 + id as f64));
            material.set(&mut state, l, PointValue::SpecificEnergy(0.05 + 1e-3 * id as f64));
        }
        let (zero, unit) = ([0.0; LANES], [1.0; LANES]);
        let mut specimen =
            Specimen { material, state, stress: [zero; 4], gradient: [unit, unit, unit, zero, zero], time: 0.0, count };
        if M::EQUATION_OF_STATE {
            // The initial energy has a pressure.
            specimen.advance(|_| [0.0; 5]);
        }
        specimen
    }

    /// Moves the elements over an increment. Returns the results, and the work of the stress in each lane.
    fn advance(&mut self, motion: impl Fn(usize) -> Motion) -> (StressUpdate, Lanes) {
        let material = self.material;
        self.time += DT;
        material.begin(&mut self.state, self.time);
        let mut strain = StrainIncrement { dt: DT, moduli: MODULI, count: self.count, ..StrainIncrement::default() };
        let mut update = StressUpdate::default();
        update.begin();
        for l in 0..LANES {
            let [rr, zz, hoop, rz, zr] = motion(l);
            let increment = [rr, zz, hoop, 0.5 * (rz + zr)];
            strain.spin[l] = 0.5 * (rz - zr);
            let share = if M::FAILS { material.share(&self.state, l) } else { 1.0 };
            let shares = [share, if M::FAILS { material.mean_share(&self.state, l) } else { 1.0 }];
            let undamaged = if share > 0.0 { undamaged(column(&self.stress, l), shares) } else { [0.0; 4] };
            let carried = rotate(undamaged, rotation_of_spin(strain.spin[l]));
            let mean = (carried[0] + carried[1] + carried[2]) / 3.0;
            let dilation = rr + zz + hoop;
            let deviator = |k: usize| {
                let volumetric = if k < 3 { mean + 2.0 / 3.0 * MODULI.shear * dilation } else { 0.0 };
                carried[k] - volumetric + 2.0 * MODULI.shear * increment[k]
            };
            let deviator = [0, 1, 2, 3].inline_map(deviator);
            update.mean[l] = mean + MODULI.bulk * dilation;
            update.trial[l] = mises(deviator);
            // (1 - h/2)^-1 and (1 + h/2) times it.
            let [a, d, b, c] = [0.5 * rr, 0.5 * zz, 0.5 * rz, 0.5 * zr];
            let determinant = (1.0 - a) * (1.0 - d) - b * c;
            let middle = [(1.0 - d), (1.0 - a), b, c].inline_map(|part| part / determinant);
            let f = |up: f64, cross: f64, x: f64, y: f64| up * x + cross * y;
            let step = [
                f(1.0 + a, b, middle[0], middle[3]),
                f(1.0 + d, c, middle[1], middle[2]),
                f(1.0 + a, b, middle[2], middle[1]),
                f(1.0 + d, c, middle[3], middle[0]),
            ];
            let previous = self.gradient.inline_map(|list| list[l]);
            let volume_before = VOLUME * (previous[0] * previous[1] - previous[3] * previous[4]) * previous[2];
            let now = [
                step[0] * previous[0] + step[2] * previous[4],
                step[3] * previous[3] + step[1] * previous[1],
                previous[2] * (1.0 + 0.5 * hoop) / (1.0 - 0.5 * hoop),
                step[0] * previous[3] + step[2] * previous[1],
                step[3] * previous[0] + step[1] * previous[4],
            ];
            strain.volume[l] = if l < self.count { volume_before / determinant / (1.0 - 0.5 * hoop) } else { 0.0 };
            strain.current_volume[l] = VOLUME * (now[0] * now[1] - now[3] * now[4]) * now[2];
            strain.mass[l] = DENSITY * VOLUME;
            for k in 0..4 {
                strain.strain[k][l] = increment[k];
                strain.carried[k][l] = carried[k];
                update.deviator[k][l] = deviator[k];
            }
            self.gradient.iter_mut().zip(now).for_each(|(list, value)| list[l] = value);
        }
        self.call_routines(&strain);
        // Laws of the deformation gradient take the previous stress with its orientation.
        let previous = if M::OF_GRADIENT { self.stress } else { strain.carried };
        material.update(&mut self.state, &mut self.stress, &strain, &mut update);
        let work = inline_from_fn(|l| {
            let double = |k: usize| strain.strain[k][l] * (previous[k][l] + self.stress[k][l]);
            0.5 * strain.volume[l] * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)))
        });
        (update, work)
    }

    /// Calls user subroutines, if the material does.
    fn call_routines(&mut self, strain: &StrainIncrement) {
        let Some(calls) = self.material.calls() else { return };
        let mut points = calls.arguments(self.count, 1);
        let kinematics = BlockKinematics {
            strain: strain.strain,
            spin: strain.spin,
            volume: strain.volume,
            gradient: Some(&self.gradient),
            corners: &|_| CORNERS,
            nodes: &|_| unreachable!("no characteristic lengths"),
            starts: false,
        };
        calls.gather(&mut points, 0, &mut self.state, &kinematics);
        let now = Instant { step: 1, total_time: self.time, step_time: self.time, ..Instant::default() };
        let routines = PointRoutines { material: Some(&mut Hooke), ..PointRoutines::default() };
        let time = CallTime { now: &now, dt: DT };
        calls.call(&mut points, routines, time, &NoAccess, &mut calls.scratch()).expect("stresses");
        calls.scatter(&points, 0, &mut self.state);
    }

    /// Returns stresses and output variables of a lane as bits.
    fn bits(&self, lane: usize) -> Vec<u64> {
        let parts = Variable::ALL.iter().flat_map(|v| v.parts());
        let values = parts.filter_map(|part| self.material.value(&self.state, lane, part));
        column(&self.stress, lane).into_iter().chain(values).map(f64::to_bits).collect()
    }

    fn largest_stress(&self) -> f64 {
        self.stress.iter().flatten().fold(0.0, |largest, s| s.abs().max(largest))
    }
}

/// A specimen in rotated axes has the rotated stress after each increment, also during a spin without strain.
fn rotated_strains_rotate_stresses<M: Material>(name: &str, material: &M) {
    let ids = inline_from_fn(|l| l);
    let rotation = [0.7_f64.cos(), 0.7_f64.sin()];
    let (mut specimen, mut other) = (Specimen::new(material, ids, LANES), Specimen::new(material, ids, LANES));
    let (mut angle, mut largest) = (rotation, 0.0_f64);
    for increment in 0..2 * INCREMENTS {
        if increment < INCREMENTS {
            specimen.advance(|l| motion(l, increment));
            other.advance(|l| turned(motion(l, increment), rotation));
        } else {
            const SPIN: f64 = 0.03;
            specimen.advance(|_| [0.0; 5]);
            other.advance(|_| [0.0, 0.0, 0.0, SPIN, -SPIN]);
            let [c, s] = rotation_of_spin(SPIN);
            angle = [c * angle[0] - s * angle[1], s * angle[0] + c * angle[1]];
        }
        largest = largest.max(specimen.largest_stress());
        let tolerance = 1e-9 * largest;
        for l in 0..LANES {
            let expected = rotate(column(&specimen.stress, l), angle);
            for (found, expected) in column(&other.stress, l).into_iter().zip(expected) {
                assert!((found - expected).abs() <= tolerance, "{name}, {increment}, lane {l}: {found} {expected}");
            }
        }
    }
    assert!(largest > 0.0, "{name} has stress");
}

/// The work of the stress and, with an equation of state, the specific energy follow from the stresses.
fn reported_energy_is_the_work_of_the_stress<M: Material>(name: &str, material: &M) {
    let mut specimen = Specimen::new(material, inline_from_fn(|l| l), LANES);
    let energies = |specimen: &Specimen<'_, M>| -> Lanes {
        inline_from_fn(|l| {
            let energy = material.value(&specimen.state, l, Variable::SpecificEnergy.into());
            energy.map_or(0.0, |energy| DENSITY * VOLUME * energy)
        })
    };
    let (mut total, mut dissipated) = ([0.0_f64; LANES], 0.0);
    let start = energies(&specimen);
    for increment in 0..INCREMENTS {
        let (update, work) = specimen.advance(|l| motion(l, increment));
        for l in (0..LANES).filter(|l| material.share(&specimen.state, *l) == 1.0) {
            let size = work[l].abs().max(1e-3);
            assert!((update.internal[l] - work[l]).abs() < 1e-11 * size, "{name}: {} {}", update.internal[l], work[l]);
            total[l] += work[l];
        }
        dissipated += update.dissipated.iter().sum::<f64>();
        assert!(update.dissipated.iter().all(|d| *d >= -1e-12), "{name}: {:?}", update.dissipated);
    }
    let compacts = material.value(&specimen.state, 0, Variable::Distension.into()).is_some();
    let flows = matches!(M::FLOW, PlasticFlow::Deviatoric | PlasticFlow::Coupled);
    // Pores may dissipate, too: above the pressure at which they collapse.
    let dissipates = dissipated > 0.0;
    assert!(material.can_delete() || flows == dissipates || compacts && dissipates, "{name} dissipates {dissipated}");
    if M::EQUATION_OF_STATE && !M::FAILS {
        let end = energies(&specimen);
        for l in 0..LANES {
            let [rr, zz, hoop, rz, zr] = specimen.gradient.inline_map(|list| list[l]);
            let expansion = VOLUME * ((rr * zz - rz * zr) * hoop - 1.0);
            // A gas works against its ambient pressure, which is not part of the stress.
            let closes = |ambient: f64| (end[l] - start[l] + ambient * expansion - total[l]).abs() < 1e-6;
            assert!(closes(0.0) || closes(AMBIENT), "{name}: {} {}", end[l] - start[l], total[l]);
        }
    }
}

/// The longitudinal modulus along each axis, from a difference of stresses, does not exceed the reported one by more than the
/// heat of deviatoric work, and is close to it at the start.
fn moduli_bound_the_stiffness<M: Material>(name: &str, material: &M) {
    const DIFFERENCE: f64 = 1e-6;
    // The modulus of an explosive is the larger one of explosive and products. That of neo-Hooke rubber is K + 4 G.
    // Deviatoric work heats, which raises the pressure of an equation of state.
    let excess = if M::EQUATION_OF_STATE { 5e-2 } else { 1e-3 };
    let sharpness = if name == "elastic_explosive" { 0.1 } else { 0.6 };
    let mut specimen = Specimen::new(material, inline_from_fn(|l| l), LANES);
    // The yield stress of foam depends on the rate, so that the stress at rest relaxes.
    let increments = if M::FLOW == PlasticFlow::Coupled { 1 } else { INCREMENTS };
    for increment in 0..increments {
        let mut at_rest = specimen.clone();
        let (update, _) = at_rest.advance(|_| [0.0; 5]);
        for axis in 0..3 {
            let mut strained = specimen.clone();
            strained.advance(|_| inline_from_fn(|k| if k == axis { DIFFERENCE } else { 0.0 }));
            for l in (0..LANES).filter(|l| material.share(&strained.state, *l) == 1.0) {
                let slope = (strained.stress[axis][l] - at_rest.stress[axis][l]) / DIFFERENCE;
                let bulk = if M::MODULI_VARY { update.bulk[l] } else { MODULI.bulk };
                let reported = bulk + 4.0 / 3.0 * MODULI.shear;
                assert!(slope < reported * (1.0 + excess), "{name}, {increment}, axis {axis}: {slope} {reported}");
                assert!(increment > 0 || slope > sharpness * reported, "{name}, axis {axis}: {slope} {reported}");
            }
        }
        specimen.advance(|l| motion(l, increment));
    }
}

fn saved_state_continues_with_the_same_bits<M: Material>(name: &str, material: &M, ids: [usize; LANES]) {
    let mut specimen = Specimen::new(material, ids, LANES);
    (0..INCREMENTS / 2).for_each(|increment| {
        specimen.advance(|l| motion(l, increment));
    });
    let mut saved = Vec::new();
    specimen.state.persist(&mut StateArchive::writer(&mut saved));
    let mut restored = Specimen { state: Specimen::new(material, ids, LANES).state, ..specimen };
    let mut archive = StateArchive::reader(&saved);
    restored.state.persist(&mut archive);
    archive.finish().expect("all bytes are read");
    for increment in INCREMENTS / 2..INCREMENTS {
        specimen.advance(|l| motion(l, increment));
        restored.advance(|l| motion(l, increment));
    }
    for l in 0..LANES {
        assert_eq!(restored.bits(l), specimen.bits(l), "{name}, lane {l}");
    }
}

fn lanes_do_not_depend_on_each_other<M: Material>(name: &str, material: &M, ids: [usize; LANES]) {
    let mut block = Specimen::new(material, ids, LANES);
    (0..INCREMENTS).for_each(|increment| {
        block.advance(|l| motion(l, increment));
    });
    for id in [0, 3, LANES - 1] {
        let mut single = Specimen::new(material, [id; LANES], 1);
        (0..INCREMENTS).for_each(|increment| {
            single.advance(|_| motion(id, increment));
        });
        assert_eq!(single.bits(0), block.bits(id), "{name}, lane {id}");
    }
}
