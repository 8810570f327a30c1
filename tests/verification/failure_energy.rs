//! Energy of materials that fail: ALLDMD and ALLSE of states far from the reference state, of limited tension, and of
//! averaged pressures.
//!
//! Goal: no failure model takes or creates energy that the material does not have.
//! Source: isentropes integrated here, the energy put in, and the same scene without the card. The tolerance is stated at
//! each test.

use crate::common::bodies::{DeckRun, run};
use crate::common::solid::grid;

/// Constants of copper: density, sound speed, slope of the Hugoniot, Grueneisen coefficient; shear modulus, yield stress.
const DENSITY: f64 = 8930.0;
const SPEED: f64 = 3940.0;
const SLOPE: f64 = 1.489;
const GRUENEISEN: f64 = 2.02;
const SHEAR: f64 = 4.77e10;
const YIELD: f64 = 1e8;

/// Returns the cards of copper.
fn copper(failure: &str) -> String {
    format!(
        "*Density\n {DENSITY},\n*Eos, type=USUP\n {SPEED}, {SLOPE}, {GRUENEISEN}\n*Elastic, type=SHEAR\n {SHEAR:e}\n\
         *Plastic\n {YIELD:e}, 0.\n{failure}"
    )
}

/// Returns the pressure of copper at a volume ratio and a specific energy.
fn pressure(ratio: f64, energy: f64) -> f64 {
    let eta = 1.0 - ratio;
    let cold = DENSITY * SPEED * SPEED * eta * (1.0 - 0.5 * GRUENEISEN * eta) / (1.0 - SLOPE * eta).powi(2);
    cold + GRUENEISEN * DENSITY * energy
}

/// Returns the specific energy after an adiabatic change of the volume ratio at a plastic work per mass and logarithmic
/// strain, and the work per mass of the pressure, by the midpoint rule.
fn advance(energy: f64, [from, to]: [f64; 2], plastic: f64) -> [f64; 2] {
    let (n, mut state) = (4000, [energy, 0.0]);
    let step = (to - from) / f64::from(n);
    for i in 0..n {
        let ratio = from + step * f64::from(i);
        let half = state[0] - 0.5 * step * pressure(ratio, state[0]) / DENSITY;
        let work = step * pressure(ratio + 0.5 * step, half) / DENSITY;
        state = [state[0] - work + plastic * step / (ratio + 0.5 * step), state[1] + work];
    }
    state
}

/// Returns the work per mass on the isentrope from a volume ratio to zero pressure.
fn released(energy: f64, ratio: f64) -> f64 {
    let (mut low, mut high) = (0.9, ratio);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        let in_tension = pressure(middle, advance(energy, [ratio, middle], 0.0)[0]) < 0.0;
        *(if in_tension { &mut high } else { &mut low }) = middle;
    }
    advance(energy, [ratio, high], 0.0)[1]
}

const ENERGIES: &str = "*Output, history, number interval=100\n*Energy Output\n ALLKE, ALLIE, ALLSE, ALLPD, ALLDMD, ALLVD, \
                        ALLAE, ALLWK\n";

/// Runs one element of copper (radius and height 1 mm) that is stretched along the axis at 10 m/s.
fn stretch(failure: &str, time: f64) -> DeckRun {
    let deck = grid(1, 1, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n"
        + &copper(failure)
        + &format!(
            "*Step\n*Dynamic, Explicit\n , {time:e}\n*Boundary\n ALL, 1, 1\n J0, 2, 2\n*Boundary, type=VELOCITY\n J1, 2, 2, 10.\n"
        )
        + ENERGIES
        + "*Element Output, elset=SOLID\n PEEQ, SPECIFIC_ENERGY\n*End Step\n";
    run(&deck).whole()
}

/// Mass of the element of [`stretch`].
const MASS: f64 = DENSITY * std::f64::consts::PI * 1e-9;

/// Returns the last value of a column.
fn last(ran: &DeckRun, name: &str) -> f64 {
    ran.column(name).last().expect("a row")[1]
}

/// An element that fails beyond the largest tension of the isentrope, where the bulk modulus is below zero, loses the work
/// of the isentrope to zero pressure. Tolerance 1 %: the work of half an increment is .2 %, the heat of viscosity .3 %.
#[test]
fn deleted_element_loses_the_work_of_its_isentrope() {
    let ran = stretch("*Shear Failure\n 0.27,\n", 6e-5);
    // The elastic part of the equivalent strain is the yield stress over three shear moduli.
    let ratio = (1.5 * (last(&ran, "PEEQ@SOLID") + YIELD / (3.0 * SHEAR))).exp();
    let [energy, _] = advance(0.0, [1.0, ratio], YIELD * 2.0 / 3.0 / DENSITY);
    let expected = MASS * (released(energy, ratio) + YIELD * YIELD / (6.0 * SHEAR * DENSITY));
    let [lost, stored] = ["ALLDMD", "ALLSE"].map(|name| last(&ran, name));
    println!("volume ratio {ratio:.4}: ALLDMD {lost:.4}, expected {expected:.4}; ALLSE {stored:.4}");
    assert!((lost / expected - 1.0).abs() < 1e-2, "{lost} {expected}");
    assert!(stored.abs() < 1e-2 * expected, "{stored}");
}

/// The specific energy of a material whose tension is limited has the work of the limited tension: all work of the
/// element, to the energy of an increment of the viscosity. ALLDMD is the limit times the growth of the volume beyond it.
/// Tolerance 1 %.
#[test]
fn limited_tension_gives_its_own_work_to_the_specific_energy() {
    let limit = 2e9;
    let ran = stretch(&format!("*Tensile Failure, element deletion=NO\n {limit:e},\n"), 5e-5);
    let internal = last(&ran, "ALLIE") + last(&ran, "ALLVD");
    let energy = MASS * last(&ran, "SPECIFIC_ENERGY@SOLID");
    // The tension is 2 GPa at a strain of 1.4 %.
    let (lost, bound) = (last(&ran, "ALLDMD"), limit * 0.5 * MASS / DENSITY);
    println!("specific energy {energy:.4}, work {internal:.4}; ALLDMD {lost:.4}, bound {bound:.4}");
    assert!((energy / internal - 1.0).abs() < 1e-2, "{energy} {internal}");
    assert!((lost / bound - (1.0 - 0.014 / 0.5)).abs() < 1e-2, "{lost} {bound}");
}

/// Bodies that hit a rigid wall: cells and size of the grid, velocity and time.
struct WallImpact {
    cells: [usize; 2],
    size: [f64; 2],
    triangles: bool,
    velocity: f64,
    time: f64,
}

impl WallImpact {
    /// Runs the impact with the cards of the section, of the material, of the contact and of the step.
    fn run(&self, [section, material, contact, step]: [&str; 4]) -> EnergyRange {
        let ([n, m], [radius, height]) = (self.cells, self.size);
        let place = |i: usize, j: usize| [radius * i as f64 / n as f64, height * j as f64 / m as f64];
        let deck = grid(n, m, self.triangles, place)
            + &format!("*Nset, nset=AXIS, generate\n 1, {}, {}\n", 1 + m * (n + 1), n + 1)
            + section
            + "*Surface, name=SKIN\n SOLID,\n*Node, nset=REF\n 9000, 0., 0.\n*Surface, type=SEGMENTS, name=WALL\n START, 0., 0.\n \
               LINE, 0.1, 0.\n*Rigid Body, ref node=9000, analytical surface=WALL\n*Material, name=M\n"
            + material
            + "*Surface Interaction, name=I\n"
            + contact
            + &format!(
                "*Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n*Boundary\n AXIS, 1, 1\n REF, 1, 6\n*Step\n\
                 *Dynamic, Explicit\n , {:e}\n*Contact Pair, interaction=I\n SKIN, WALL\n",
                -self.velocity, self.time
            )
            + step
            + ENERGIES
            + "*End Step\n";
        EnergyRange::of(&run(&deck).whole())
    }
}

/// Terms of the energy relative to the initial kinetic energy, the energy put in.
#[derive(Debug)]
struct EnergyRange {
    least_strain: f64,
    least_artificial: f64,
    largest_damage: f64,
    viscous: f64,
}

impl EnergyRange {
    fn of(ran: &DeckRun) -> EnergyRange {
        let put_in = ran.column("ALLKE")[0][1];
        let least = |name: &str| ran.column(name).iter().map(|row| row[1]).fold(f64::INFINITY, f64::min) / put_in;
        let has_damage = ran.prepared.plan.columns.iter().any(|column| column.name == "ALLDMD");
        let damage = if has_damage { ran.column("ALLDMD") } else { Vec::new() };
        EnergyRange {
            least_strain: least("ALLSE"),
            least_artificial: least("ALLAE"),
            largest_damage: damage.iter().map(|row| row[1]).fold(0.0, f64::max) / put_in,
            viscous: last(ran, "ALLVD") / put_in,
        }
    }
}

const SECTION: &str = "*Solid Section, elset=SOLID, material=M\n";

/// Limited tension on a moving mesh dissipates as much as without the card; ALLSE is not below the expansion by heat.
/// Tolerances 5 % and 1 % of the energy put in.
#[test]
fn limited_tension_dissipates_as_much_on_a_moving_mesh() {
    let impact = WallImpact { cells: [6, 12], size: [5e-3, 1e-2], triangles: false, velocity: 800.0, time: 6e-6 };
    let material = copper("*Tensile Failure, element deletion=NO\n 2.e9,\n");
    let [fixed, moving] =
        ["", "*Adaptive Mesh, elset=SOLID, frequency=1\n"].map(|card| impact.run([SECTION, &material, "", card]));
    println!("{fixed:?}\n{moving:?}");
    assert!((moving.largest_damage / fixed.largest_damage - 1.0).abs() < 0.05);
    assert!(moving.least_strain > -0.01 && fixed.least_strain > -0.01);
}

/// Subzonal pressures of a fluid whose tension is limited create no energy, and the viscosity dissipates as much as
/// without them. Tolerances .1 % of the energy put in and 10 %.
#[test]
fn subzonal_pressures_follow_the_limit_of_the_tension() {
    let impact = WallImpact { cells: [8, 14], size: [5e-3, 1e-2], triangles: false, velocity: 200.0, time: 6e-5 };
    let water =
        "*Density\n 1000.,\n*Eos, type=USUP\n 1483., 1.75, 0.28\n*Tensile Failure, element deletion=NO\n 1.e5,\n";
    let [with, without] = ["YES", "NO"].map(|subzonal| {
        let section = format!(
            "*Section Controls, name=SC, subzonal={subzonal}\n*Solid Section, elset=SOLID, material=M, controls=SC\n"
        );
        impact.run([&section, water, "", ""])
    });
    println!("{with:?}\n{without:?}");
    assert!(with.least_artificial > -1e-3);
    assert!((with.viscous / without.viscous - 1.0).abs() < 0.1);
}

/// Averaged pressures of triangles with damage create no energy: ALLSE is not below zero, and the viscosity dissipates no
/// more than 15 % beyond its value without damage.
#[test]
fn averaged_pressures_follow_damage() {
    let impact = WallImpact { cells: [7, 10], size: [7.4e-3, 9.4e-3], triangles: true, velocity: 71.45, time: 5.72e-5 };
    let lead = "*Density\n 11340.,\n*Elastic\n 1.6e10, 0.42\n*Plastic\n 1.e7, 0.\n";
    let damage = "*Damage Initiation, criterion=JOHNSON COOK\n .2, 1., -1.5, .01, 0., 600., 293., 1.\n\
                  *Damage Evolution, type=DISPLACEMENT\n 1.e-4,\n";
    let [whole, damaged] =
        ["", damage].map(|card| impact.run([SECTION, &format!("{lead}{card}"), "*Friction, rough\n", ""]));
    println!("{whole:?}\n{damaged:?}");
    assert!(damaged.least_strain > -1e-3);
    assert!(damaged.viscous < 1.15 * whole.viscous);
}
