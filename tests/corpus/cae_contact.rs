//! Decks of ABAQUS/CAE with general contact, couplings and large strains.

use std::f64::consts::PI;
use std::fmt::Write;

use crate::cae::{CaeModel, EXPLICIT, node_set, outputs, part, rigid_instance, step, surface};
use crate::grid::{Grid, Side};
use crate::run::{Deck, assert_near};

/// Interaction property of frictionless general contact, as exported.
const FRICTIONLESS: &str =
    "*Surface Interaction, name=IntProp-1\n*Friction\n0.,\n*Surface Behavior, pressure-overclosure=HARD\n";

/// General contact of everything, within the step.
const GENERAL: &str = "** \n** INTERACTIONS\n** \n** Interaction: Int-1\n*Contact, op=NEW\n*Contact Inclusions, ALL EXTERIOR\n\
                       *Contact Property Assignment\n ,  , IntProp-1\n";

/// Returns a smooth step from 0 to 1 over a time.
fn smooth(time: f64) -> String {
    format!(
        "*Amplitude, name=Amp-1, definition=SMOOTH STEP\n             0.,              0., {time:>14},              1.\n"
    )
}

/// A tube of shells is crushed between two analytical plates in general contact, with mass scaling.
///
/// Estimate: the mean force of concertina folds is `M0 (20.79 sqrt(D/t) + 11.9) / (0.86 - 0.568 sqrt(t/D))` with `M0 =
/// σ t² / (2 √3)` (Abramowicz and Jones, Int. J. Impact Eng. 2 (1984) 263). It assumes complete folds: tolerance 20 %.
/// The profile of the ram begins on the axis, so that it faces upwards: one warning.
#[test]
fn crushed_tube_has_the_mean_force_of_abramowicz_and_jones() {
    let (rows, length, radius, thickness): (u32, f64, f64, f64) = (40, 60.0, 25.0, 1.5);
    let time = 4e-3;
    let mut tube = String::from("*Part, name=Tube\n*Node\n");
    for j in 0..=rows {
        // A small wave of the radius starts the first fold.
        let z = length * f64::from(j) / f64::from(rows);
        let _ = writeln!(tube, "{:>7}, {:>12}, {z:>12}", j + 1, radius + 0.05 * (0.4 * z).sin());
    }
    tube += "*Element, type=SAX1\n";
    for j in 1..=rows {
        let _ = writeln!(tube, "{j:>3}, {j:>3}, {:>3}", j + 1);
    }
    let _ = write!(
        tube,
        "*Nset, nset=Set-1, generate\n  1, {}, 1\n*Elset, elset=Set-1, generate\n  1, {rows}, 1\n\
         ** Section: Section-1\n*Shell Section, elset=Set-1, material=Steel\n{thickness}, 5\n*End Part\n**  \n",
        rows + 1
    );
    let (gap, top) = (-0.01, length + 0.01);
    let model = CaeModel {
        job: "crush",
        parts: tube + "*Part, name=Base\n*End Part\n**  \n*Part, name=Ram\n*End Part\n**  \n",
        instances: "*Instance, name=Tube-1, part=Tube\n*End Instance\n**  \n".to_owned()
            + &rigid_instance(
                "Base",
                gap,
                &format!("START,           0.,         {gap}\n LINE,          60.,         {gap}\n"),
            )
            + &rigid_instance(
                "Ram",
                top,
                &format!("START,           0.,        {top}\n LINE,          60.,        {top}\n"),
            ),
        sets: "*Nset, nset=BaseRef, instance=Base-1\n 1,\n*Nset, nset=RamRef, instance=Ram-1\n 1,\n".to_owned(),
        amplitudes: smooth(time),
        materials: "*Material, name=Steel\n*Density\n 7.85e-09,\n*Elastic\n200000., 0.3\n*Plastic\n250.,0.\n",
        interactions: FRICTIONLESS,
        steps: step("Crush", EXPLICIT, time)
            + "** Mass Scaling: Semi-Automatic\n**               Whole Model\n*Fixed Mass Scaling, factor=9.\n\
               ** \n** BOUNDARY CONDITIONS\n** \n** Name: BC-1 Type: Symmetry/Antisymmetry/Encastre\n*Boundary\nBaseRef, ENCASTRE\n\
               ** Name: BC-2 Type: Displacement/Rotation\n*Boundary, amplitude=Amp-1\nRamRef, 1, 1\nRamRef, 2, 2, -30.\nRamRef, 6, 6\n"
            + GENERAL
            + &outputs("*Node Output, nset=RamRef\nRF2, U2\n", time),
        ..CaeModel::default()
    };
    let run = Deck::new(&model.text()).completes(&["P110"]);
    let (moment, slender) = (250.0 * thickness.powi(2) / (2.0 * 3.0_f64.sqrt()), (2.0 * radius / thickness).sqrt());
    let force = moment * (20.79 * slender + 11.9) / (0.86 - 0.568 / slender);
    assert_near("mean force", run.last("ALLWK") / 30.0, force, 0.2);
}

/// A billet is upset between an anvil in contact and a ram that is coupled to its upper face.
///
/// Estimate: without friction the force is `Y A H / h` at the height `h` (volume is conserved; Hill, The Mathematical
/// Theory of Plasticity, chapter 10). Inertia is small: tolerance 2 %.
#[test]
fn ram_coupled_to_a_billet_upsets_it_with_the_flow_stress() {
    let grid = Grid::uniform([0.0, 0.0], [10.0, 20.0], 8, 16);
    let time = 1e-3;
    let model = CaeModel {
        job: "upsetting",
        parts: part("Billet", &grid, "CAX4R", "Metal", "EC-1") + "*Part, name=Anvil\n*End Part\n**  \n",
        instances: "*Instance, name=Billet-1, part=Billet\n*End Instance\n**  \n".to_owned()
            + &rigid_instance("Anvil", 0.0, "START,           0.,           0.\n LINE,          40.,           0.\n"),
        sets: "*Node\n      1,           0.,          30.,           0.\n*Nset, nset=RamRef\n 1,\n".to_owned()
            + &node_set("Axis", "Billet-1", &grid.side_nodes(Side::Inner))
            + "*Nset, nset=AnvilRef, instance=Anvil-1\n 1,\n"
            + &surface("Upper", "Billet-1", &grid, Side::Top)
            + &surface("Lower", "Billet-1", &grid, Side::Bottom)
            + "** Constraint: Ram\n*Coupling, constraint name=Ram, ref node=RamRef, surface=Upper\n*Kinematic\n2, 2\n",
        amplitudes: smooth(time),
        controls: "*Section Controls, name=EC-1, DISTORTION CONTROL=YES, hourglass=RELAX STIFFNESS\n1., 1., 1.\n"
            .to_owned(),
        materials: "*Material, name=Metal\n*Density\n 7.85e-09,\n*Elastic\n200000., 0.3\n*Plastic\n300.,0.\n",
        interactions: FRICTIONLESS,
        steps: step("Upset", EXPLICIT, time)
            + "** Mass Scaling: Semi-Automatic\n**               Whole Model\n*Variable Mass Scaling, dt=2e-07, type=below min, frequency=100\n\
               ** \n** BOUNDARY CONDITIONS\n** \n** Name: BC-1 Type: Displacement/Rotation\n*Boundary\nAxis, 1, 1\n\
               ** Name: BC-2 Type: Symmetry/Antisymmetry/Encastre\n*Boundary\nAnvilRef, ENCASTRE\n\
               ** Name: BC-3 Type: Displacement/Rotation\n*Boundary, amplitude=Amp-1\nRamRef, 1, 1\nRamRef, 2, 2, -4.\nRamRef, 6, 6\n\
               ** \n** INTERACTIONS\n** \n** Interaction: Int-1\n\
               *Contact Pair, interaction=IntProp-1, mechanical constraint=KINEMATIC, cpset=Int-1\nAnvil-1.Profile, Lower\n"
            + &outputs("*Node Output, nset=RamRef\nRF2, U2\n", time),
        ..CaeModel::default()
    };
    let run = Deck::new(&model.text()).completes(&[]);
    let middle = 0.6 * time;
    let height = 20.0 + run.at("U2@RAMREF", middle);
    let force = 300.0 * PI * 100.0 * 20.0 / height;
    assert_near("force", -run.mean("RF2@RAMREF", middle - 2e-5, middle + 2e-5), force, 0.02);
}

/// A rubber disc is compressed between two analytical plates in general contact, with scaled mass.
///
/// Estimate: the force of an incompressible Neo-Hookean disc is `2 C10 (1/λ² - λ) A` (Treloar, The Physics of Rubber
/// Elasticity, chapter 4). The bulk modulus is 100 times the shear modulus: tolerance 3 %.
#[test]
fn compressed_rubber_disc_has_the_neo_hookean_force() {
    let grid = Grid::uniform([0.0, 0.0], [10.0, 8.0], 10, 8);
    let time = 0.02;
    let model = CaeModel {
        job: "seal",
        parts: part("Seal", &grid, "CAX4R", "Rubber", "")
            + "*Part, name=Lower\n*End Part\n**  \n*Part, name=Upper\n*End Part\n**  \n",
        instances: "*Instance, name=Seal-1, part=Seal\n*End Instance\n**  \n".to_owned()
            + &rigid_instance("Lower", 0.0, "START,           0.,           0.\n LINE,          30.,           0.\n")
            + &rigid_instance("Upper", 8.0, "START,          30.,           8.\n LINE,           0.,           8.\n"),
        sets: node_set("Axis", "Seal-1", &grid.side_nodes(Side::Inner))
            + "*Nset, nset=LowerRef, instance=Lower-1\n 1,\n*Nset, nset=UpperRef, instance=Upper-1\n 1,\n",
        amplitudes: smooth(time),
        materials: "*Material, name=Rubber\n*Density\n 1.1e-09,\n*Hyperelastic, neo hooke\n0.5, 0.02\n",
        interactions: FRICTIONLESS,
        steps: step("Squeeze", EXPLICIT, time)
            + "** Mass Scaling: Semi-Automatic\n**               Whole Model\n*Fixed Mass Scaling, dt=5e-06, type=uniform\n\
               ** \n** BOUNDARY CONDITIONS\n** \n** Name: BC-1 Type: Displacement/Rotation\n*Boundary\nAxis, 1, 1\n\
               ** Name: BC-2 Type: Symmetry/Antisymmetry/Encastre\n*Boundary\nLowerRef, ENCASTRE\n\
               ** Name: BC-3 Type: Displacement/Rotation\n*Boundary, amplitude=Amp-1\nUpperRef, 1, 1\nUpperRef, 2, 2, -2.4\nUpperRef, 6, 6\n"
            + GENERAL
            + &outputs("*Node Output, nset=UpperRef\nRF2, U2\n", time),
        ..CaeModel::default()
    };
    let run = Deck::new(&model.text()).completes(&[]);
    let stretch: f64 = 0.7;
    let force = 2.0 * 0.5 * (1.0 / stretch.powi(2) - stretch) * PI * 100.0;
    assert_near("force", -run.mean("RF2@UPPERREF", 0.98 * time, time), force, 0.03);
}

/// A tapered rigid mandrel is pressed through a ring.
///
/// Estimate: the pressure of an oversize `δ` in a thick ring is `E δ / (a ((b² + a²)/(b² - a²) + ν))` (Lamé;
/// Timoshenko, Strength of Materials, part II). The force on the inner face is `2π a h p`: tolerance 3 %.
#[test]
fn mandrel_pressed_into_a_ring_has_the_pressure_of_lame() {
    let (inner, outer, height, oversize): (f64, f64, f64, f64) = (20.0, 30.0, 10.0, 0.05);
    let grid = Grid::uniform([inner, 0.0], [outer, height], 8, 8);
    let time = 6e-4;
    // Downwards along the outside of the mandrel: the outward normal is to the left.
    let profile =
        "START,         19.9,          -1.\n LINE,        20.05,         -16.\n LINE,        20.05,         -40.\n";
    let model = CaeModel {
        job: "press-fit",
        parts: part("Ring", &grid, "CAX4R", "Steel", "") + "*Part, name=Mandrel\n*End Part\n**  \n",
        instances: "*Instance, name=Ring-1, part=Ring\n*End Instance\n**  \n".to_owned()
            + &rigid_instance("Mandrel", -40.0, profile),
        sets: node_set("Shoulder", "Ring-1", &[grid.node(8, 8)])
            + "*Nset, nset=MandrelRef, instance=Mandrel-1\n 1,\n"
            + &surface("Bore", "Ring-1", &grid, Side::Inner),
        amplitudes: smooth(time),
        materials: "*Material, name=Steel\n*Damping, alpha=20000.\n*Density\n 7.85e-09,\n*Elastic\n210000., 0.3\n",
        interactions: FRICTIONLESS,
        steps: step("Press", EXPLICIT, time)
            + "** \n** BOUNDARY CONDITIONS\n** \n** Name: BC-1 Type: Displacement/Rotation\n*Boundary\nShoulder, 2, 2\n\
               ** Name: BC-2 Type: Displacement/Rotation\n*Boundary, amplitude=Amp-1\nMandrelRef, 1, 1\nMandrelRef, 2, 2, 33.\nMandrelRef, 6, 6\n\
               ** \n** INTERACTIONS\n** \n** Interaction: Fit\n\
               *Contact Pair, interaction=IntProp-1, mechanical constraint=PENALTY, cpset=Fit\nMandrel-1.Profile, Bore\n"
            + &outputs("*Node Output, nset=MandrelRef\nRF2, U2\n*Contact Output, cpset=Fit\nCFN, \n", time),
        ..CaeModel::default()
    };
    let run = Deck::new(&model.text()).completes(&[]);
    let (a2, b2) = (inner * inner, outer * outer);
    let pressure = 210_000.0 * oversize / (inner * ((b2 + a2) / (b2 - a2) + 0.3));
    let force = run.mean(run.columns_with("CFN1")[0], 0.9 * time, time).abs();
    assert_near("force on the inner face", force, pressure * 2.0 * PI * inner * height, 0.03);
}

/// A rigid flat projectile perforates a plate with Johnson-Cook damage; general contact with interior faces and
/// erosion.
///
/// Estimate: a plug of the projectile's radius leaves with it, `v_r² = (m/(m+m_p))² v² - 2W/(m+m_p)` with the shearing
/// work `W = τ π D h²/2` (Recht and Ipson, J. Appl. Mech. 30 (1963) 384, DOI 10.1115/1.3636566). Tolerance 5 %.
#[test]
fn projectile_has_the_residual_velocity_of_recht_and_ipson() {
    let plate = Grid::uniform([0.0, -2.0], [20.0, 0.0], 50, 6);
    let shot = Grid::uniform([0.0, 0.01], [5.0, 10.01], 5, 8);
    let (time, speed) = (4e-5, 3e5);
    let model = CaeModel {
        job: "perforation",
        parts: part("Plate", &plate, "CAX4R", "Metal", "EC-1") + &part("Shot", &shot, "CAX4R", "Tungsten", ""),
        instances: "*Instance, name=Plate-1, part=Plate\n*End Instance\n**  \n*Instance, name=Shot-1, part=Shot\n*End Instance\n**  \n"
            .to_owned(),
        sets: "*Node\n      1,           0.,          15.,           0.\n*Nset, nset=ShotRef\n 1,\n".to_owned()
            + &node_set("Axis", "Plate-1", &plate.side_nodes(Side::Inner))
            + &node_set("Clamp", "Plate-1", &plate.side_nodes(Side::Outer))
            + "*Elset, elset=Body, instance=Shot-1, generate\n  1,  40,   1\n\
               *Elset, elset=_Erode, internal, instance=Plate-1, generate\n   1,  300,    1\n\
               *Surface, type=ELEMENT, name=Erode\n_Erode,\n_Erode, interior\n\
               ** Constraint: Rigid\n*Rigid Body, ref node=ShotRef, elset=Body\n",
        controls: "*Section Controls, name=EC-1, ELEMENT DELETION=YES\n1., 1., 1.\n".to_owned(),
        materials: "*Material, name=Metal\n*Damage Initiation, criterion=JOHNSON COOK\n 0.3,   0.,   0.,   0.,   0., 900.,  20.,   1.\n\
                    *Damage Evolution, type=DISPLACEMENT\n0.02,\n*Density\n 7.85e-09,\n*Elastic\n200000., 0.3\n\
                    *Plastic, hardening=JOHNSON COOK\n400., 100.,  0.5,   1., 1500.,  20.\n\
                    *Material, name=Tungsten\n*Density\n 1.8e-08,\n*Elastic\n400000., 0.28\n",
        interactions: FRICTIONLESS,
        initial: format!("*Initial Conditions, type=VELOCITY\nShotRef, 2, {}.\n", -speed),
        steps: step("Strike", EXPLICIT, time)
            + "** \n** BOUNDARY CONDITIONS\n** \n** Name: BC-1 Type: Displacement/Rotation\n*Boundary\nAxis, 1, 1\n\
               ** Name: BC-2 Type: Symmetry/Antisymmetry/Encastre\n*Boundary\nClamp, ENCASTRE\n\
               ** Name: BC-3 Type: Displacement/Rotation\n*Boundary\nShotRef, 1, 1\nShotRef, 6, 6\n\
               ** \n** INTERACTIONS\n** \n** Interaction: Int-1\n*Contact, op=NEW\n*Contact Inclusions\n , Erode\n\
               *Contact Property Assignment\n ,  , IntProp-1\n"
            + &outputs("*Node Output, nset=ShotRef\nV2, U2\n", time),
        ..CaeModel::default()
    };
    let run = Deck::new(&model.text()).completes(&[]);
    let (mass, plug) = (1.8e-8 * PI * 250.0, 7.85e-9 * PI * 50.0);
    let work = 400.0 / 3.0_f64.sqrt() * PI * 10.0 * 4.0 / 2.0;
    let share: f64 = mass / (mass + plug);
    let residual = (share.powi(2) * speed * speed - 2.0 * work / (mass + plug)).sqrt();
    assert_near("residual velocity", -run.last("V2@SHOTREF"), residual, 0.05);
}

/// The struck end of an elastic bar is coupled to a reference node: the nodes in contact follow the coupling.
///
/// Estimate: as for a rod without coupling, the force is `ρ c v A` during `2L/c`, then the bar leaves with its velocity
/// (Graff, Wave Motion in Elastic Solids, chapter 2). Tolerance 2 % on the force and 5 % on the velocity.
#[test]
fn bar_with_a_coupled_end_rebounds_from_an_anvil() {
    let grid = Grid::uniform([0.0, 0.0], [5.0, 100.0], 2, 100);
    let (time, wave) = (5e-5, (200_000.0_f64 / 7.85e-9).sqrt());
    let model = CaeModel {
        job: "punch",
        parts: part("Bar", &grid, "CAX4R", "Steel", "") + "*Part, name=Anvil\n*End Part\n**  \n",
        instances: "*Instance, name=Bar-1, part=Bar\n*End Instance\n**  \n".to_owned()
            + &rigid_instance("Anvil", 0.0, "START,           0.,           0.\n LINE,          20.,           0.\n"),
        sets: "*Node\n      1,           0.,           0.,           0.\n*Nset, nset=Grip\n 1,\n".to_owned()
            + &node_set("Axis", "Bar-1", &grid.side_nodes(Side::Inner))
            + &node_set("Middle", "Bar-1", &[grid.node(0, 50)])
            + "*Nset, nset=AnvilRef, instance=Anvil-1\n 1,\n"
            + &surface("Foot", "Bar-1", &grid, Side::Bottom)
            + "** Constraint: Grip\n*Coupling, constraint name=Grip, ref node=Grip, surface=Foot\n*Kinematic\n2, 2\n",
        materials: crate::cae::BAR_STEEL,
        interactions: FRICTIONLESS,
        initial: "*Initial Conditions, type=VELOCITY\nBar-1.Set-1, 2, -5000.\nGrip, 2, -5000.\n".to_owned(),
        steps: step("Strike", EXPLICIT, time)
            + "** \n** BOUNDARY CONDITIONS\n** \n** Name: BC-1 Type: Displacement/Rotation\n*Boundary\nAxis, 1, 1\n\
               ** Name: BC-2 Type: Symmetry/Antisymmetry/Encastre\n*Boundary\nAnvilRef, ENCASTRE\n\
               ** \n** INTERACTIONS\n** \n** Interaction: Int-1\n\
               *Contact Pair, interaction=IntProp-1, mechanical constraint=KINEMATIC, cpset=Int-1\nAnvil-1.Profile, Foot\n"
            + &outputs(
                "*Node Output, nset=AnvilRef\nRF2, \n*Node Output, nset=Middle\nV2, \n*Node Output, nset=Grip\nU2, V2\n",
                time,
            ),
        ..CaeModel::default()
    };
    let run = Deck::new(&model.text()).completes(&[]);
    let (duration, force) = (200.0 / wave, 7.85e-9 * wave * 5000.0 * PI * 25.0);
    assert_near("anvil force", run.mean("RF2@ANVILREF", 0.1 * duration, 0.9 * duration).abs(), force, 0.02);
    assert_near("rebound velocity", run.mean("V2@MIDDLE", 1.05 * duration, time), 5000.0, 0.05);
}

/// An O-ring between two lubricated plates is compressed by a quarter; general contact, Mooney-Rivlin rubber.
///
/// Estimate: the force per length is `E d (1.25 δ^1.5 + 50 δ^6)` for the compression `δ` of the diameter `d` (Lindley,
/// J. Inst. Rubber Ind. 1 (1967)), times the mean circumference, with `E = 6 (C10 + C01)`. Without friction the ring is
/// free to extend. Tolerance 8 %.
#[test]
fn compressed_o_ring_has_the_force_of_lindley() {
    // The section is a square that is mapped onto a disc.
    let (n, radius, mean, time): (u32, f64, f64, f64) = (10, 2.0, 20.0, 0.02);
    let mut grid = String::from("*Part, name=Ring\n*Node\n");
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (at(i), at(j));
            let [r, z] = [x * (1.0 - 0.5 * y * y).sqrt(), y * (1.0 - 0.5 * x * x).sqrt()];
            let _ = writeln!(grid, "{:>7}, {:>12.8}, {:>12.8}", j * (n + 1) + i + 1, mean + radius * r, radius * z);
        }
    }
    grid += "*Element, type=CAX4R\n";
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i + 1;
            let _ = writeln!(grid, "{:>3}, {a:>3}, {:>3}, {:>3}, {:>3}", j * n + i + 1, a + 1, a + n + 2, a + n + 1);
        }
    }
    let _ = write!(
        grid,
        "*Elset, elset=Set-1, generate\n  1, {}, 1\n** Section: Section-1\n*Solid Section, elset=Set-1, material=Rubber\n,\n*End Part\n**  \n",
        n * n
    );
    let plate = |z: f64, from: f64, to: f64| format!("START, {from}, {z}\n LINE, {to}, {z}\n");
    let model = CaeModel {
        job: "o-ring",
        parts: grid + "*Part, name=Lower\n*End Part\n**  \n*Part, name=Upper\n*End Part\n**  \n",
        instances: "*Instance, name=Ring-1, part=Ring\n*End Instance\n**  \n".to_owned()
            + &rigid_instance("Lower", -radius, &plate(-radius, 10.0, 30.0))
            + &rigid_instance("Upper", radius, &plate(radius, 30.0, 10.0)),
        sets: "*Nset, nset=LowerRef, instance=Lower-1\n 1,\n*Nset, nset=UpperRef, instance=Upper-1\n 1,\n".to_owned(),
        amplitudes: smooth(time),
        materials: "*Material, name=Rubber\n*Density\n 1.1e-09,\n*Hyperelastic, mooney-rivlin\n0.8, 0.2, 0.02\n",
        interactions: FRICTIONLESS,
        steps: step("Squeeze", EXPLICIT, time)
            + "** Mass Scaling: Semi-Automatic\n**               Whole Model\n*Fixed Mass Scaling, factor=16.\n\
               ** \n** BOUNDARY CONDITIONS\n** \n** Name: BC-1 Type: Symmetry/Antisymmetry/Encastre\n*Boundary\nLowerRef, ENCASTRE\n\
               ** Name: BC-2 Type: Displacement/Rotation\n*Boundary, amplitude=Amp-1\nUpperRef, 1, 1\nUpperRef, 2, 2, -1.\nUpperRef, 6, 6\n"
            + GENERAL
            + &outputs("*Node Output, nset=UpperRef\nRF2, U2\n", time),
        ..CaeModel::default()
    };
    let run = Deck::new(&model.text()).completes(&[]);
    let (squeeze, diameter): (f64, f64) = (0.25, 2.0 * radius);
    let per_length = 6.0 * diameter * (1.25 * squeeze.powf(1.5) + 50.0 * squeeze.powi(6));
    assert_near("force", -run.mean("RF2@UPPERREF", 0.95 * time, time), per_length * 2.0 * PI * mean, 0.08);
}
