//! Strain energies of invariants with fibres (`*ANISOTROPIC HYPERELASTIC`, VUANISOHYPER_INV).
//!
//! Goal: stresses are the derivatives of the energy, in motions with rotation and with every invariant; the built-in energy of
//! Holzapfel, Gasser and Ogden equals the same energy of a subroutine; tension of bodies with fibres has its closed form and its
//! energy; stiffening fibres stay stable. Sources: derivatives of the energy by differences, and stretches without lateral stress.
//! Needs gfortran for Fortran files; without it these tests are left out, except in CI.

use std::fmt::Write as _;

use revolve::job;
use revolve::user::{EnergyAnswer, EnergyCall, LoadFailure, Routines, UserEnergy};

use crate::common::solid::{grid, in_six_node_triangles};
use crate::common::{self, RecordedOutput};
use crate::material::{compiled, last, moving};
use crate::subroutines::{UserFolder, message_text};

type Matrix = [[f64; 3]; 3];

/// Constants C10, D, k1, k2, kappa.
const TISSUE: [f64; 5] = [2.0, 0.01, 5.0, 1.5, 0.08];

/// Returns cards of a material with fibres in these directions.
fn cards(energy: &str, fibres: &[[f64; 3]]) -> String {
    let n = fibres.len();
    let mut text = format!("*Anisotropic Hyperelastic, {energy}, local directions={n}\n");
    writeln!(text, " {}", TISSUE.map(|x| format!("{x:e}")).join(", ")).expect("text");
    writeln!(text, "*Orientation, name=FIBRES, local directions={n}\n 1., 0., 0., 0., 1., 0.\n 1, 0.").expect("text");
    fibres.iter().for_each(|[r, z, hoop]| writeln!(text, " {r:e}, {z:e}, {hoop:e}").expect("text"));
    text
}

/// Adds the orientation of the cards to the section of a deck.
fn oriented(deck: &str) -> String {
    deck.replace("elset=SOLID, material=M", "elset=SOLID, material=M, orientation=FIBRES")
}

/// Families that are mirrored at the r-z plane, so that they do not twist the body, and one in this plane.
const FIBRES: [[f64; 3]; 3] = [[0.0, 0.6, 0.8], [0.0, 0.6, -0.8], [0.8, 0.6, 0.0]];

/// Energy of all invariants of two families.
struct EveryInvariant;

/// Coefficients of the energy: of (Ī1 - 3), (Ī2 - 3), (J - 1)²/2, then of the squares of the changes of Ī4 and Ī5 of the
/// families 11, 12 and 22, and of (Ī1 - 3)(J - 1) and (Ī1 - 3)(Ī4(11) - 1).
const EVERY: [f64; 11] = [3.0, 1.5, 80.0, 2.0, 0.7, 1.2, 0.4, 1.8, 0.6, 5.0, 1.1];

/// Returns the values of the fourth and fifth invariants in the initial configuration.
fn initial(cosine: f64) -> [f64; 6] {
    [1.0, 1.0, cosine, cosine, 1.0, 1.0]
}

impl UserEnergy for EveryInvariant {
    fn energy(&mut self, call: &EnergyCall<'_>, answer: &mut EnergyAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        assert_eq!(
            (call.families, call.invariants.len(), call.cosines.len(), answer.first.len()),
            (2, 9 * n, n, 9 * n)
        );
        assert!(answer.second.len() == 45 * n && answer.first.iter().chain(&*answer.second).all(|d| *d == 0.0));
        let packed = |a: usize, b: usize| a + b * (b + 1) / 2;
        for k in 0..n {
            let value = |a: usize| call.invariants[a * n + k];
            let [first, volume] = [value(0) - 3.0, value(2) - 1.0];
            answer.first[k] = EVERY[0] + EVERY[9] * volume + EVERY[10] * (value(3) - 1.0);
            answer.first[n + k] = EVERY[1];
            answer.first[2 * n + k] = EVERY[2] * volume + EVERY[9] * first;
            answer.second[packed(2, 2) * n + k] = EVERY[2];
            answer.second[packed(0, 2) * n + k] = EVERY[9];
            answer.second[packed(0, 3) * n + k] = EVERY[10];
            for (a, start) in initial(call.cosines[k]).into_iter().enumerate() {
                answer.first[(3 + a) * n + k] = 2.0 * EVERY[3 + a] * (value(3 + a) - start);
                answer.second[packed(3 + a, 3 + a) * n + k] = 2.0 * EVERY[3 + a];
            }
            answer.first[3 * n + k] += EVERY[10] * first;
        }
        Ok(())
    }
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn applied(a: &Matrix, v: [f64; 3]) -> [f64; 3] {
    a.map(|row| dot(row, v))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn determinant(f: &Matrix) -> f64 {
    f[0][0] * (f[1][1] * f[2][2] - f[1][2] * f[2][1]) - f[0][1] * (f[1][0] * f[2][2] - f[1][2] * f[2][0])
        + f[0][2] * (f[1][0] * f[2][1] - f[1][1] * f[2][0])
}

/// Returns J and the isochoric right Cauchy-Green tensor.
fn isochoric(f: &Matrix) -> (f64, Matrix) {
    let (j, transposed) = (determinant(f), [0, 1, 2].map(|i| [0, 1, 2].map(|k| f[k][i])));
    (j, product(&transposed, f).map(|row| row.map(|x| x * j.powf(-2.0 / 3.0))))
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| x / dot(v, v).sqrt())
}

/// Returns the energy of [`EveryInvariant`] with the fibres of the first and the last family of [`FIBRES`].
fn energy_of_every(f: &Matrix) -> f64 {
    let (j, c) = isochoric(f);
    let square = product(&c, &c);
    let trace = |t: &Matrix| t[0][0] + t[1][1] + t[2][2];
    let (first, second) = (trace(&c), 0.5 * (trace(&c).powi(2) - trace(&square)));
    let [a, b] = [unit(FIBRES[0]), unit(FIBRES[2])];
    let pairs = [(a, a), (a, b), (b, b)];
    let values = pairs.map(|(a, b)| [dot(a, applied(&c, b)), dot(a, applied(&square, b))]);
    let along = values.as_flattened().iter().zip(initial(dot(a, b))).enumerate();
    let fibres: f64 = along.map(|(k, (value, start))| EVERY[3 + k] * (value - start).powi(2)).sum();
    EVERY[0] * (first - 3.0)
        + EVERY[1] * (second - 3.0)
        + 0.5 * EVERY[2] * (j - 1.0).powi(2)
        + fibres
        + EVERY[9] * (first - 3.0) * (j - 1.0)
        + EVERY[10] * (first - 3.0) * (values[0][0] - 1.0)
}

/// Returns the energy of Holzapfel, Gasser and Ogden.
fn energy_of_tissue(f: &Matrix, fibres: &[[f64; 3]]) -> f64 {
    let [c10, d, k1, k2, kappa] = TISSUE;
    let (j, c) = isochoric(f);
    let first = c[0][0] + c[1][1] + c[2][2];
    let of_fibre = |fibre: &[f64; 3]| {
        let along = dot(unit(*fibre), applied(&c, unit(*fibre)));
        let strain = (kappa * (first - 3.0) + (1.0 - 3.0 * kappa) * (along - 1.0)).max(0.0);
        0.5 * k1 / k2 * ((k2 * strain * strain).exp() - 1.0)
    };
    c10 * (first - 3.0) + ((j * j - 1.0) / 2.0 - j.ln()) / d + fibres.iter().map(of_fibre).sum::<f64>()
}

/// Returns the stresses rr, zz, hoop, rz: derivatives of the energy by the deformation gradient, from differences of fourth order.
fn stress(f: &Matrix, energy: impl Fn(&Matrix) -> f64) -> [f64; 4] {
    let slope = |i: usize, k: usize| {
        let at = |change: f64| {
            let mut changed = *f;
            changed[i][k] += change;
            energy(&changed)
        };
        let step = 1e-4;
        (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)
    };
    let nominal = [0, 1, 2].map(|i| [0, 1, 2].map(|k| slope(i, k)));
    let cauchy = |i: usize, k: usize| dot(nominal[i], f[k]) / determinant(f);
    [cauchy(0, 0), cauchy(1, 1), cauchy(2, 2), cauchy(0, 1)]
}

/// Stretch, shear and rotation about the hoop direction; the gradient of the velocity is constant.
const VELOCITY: [[f64; 2]; 2] = [[0.2, 0.0], [0.9, -0.15]];

/// Compares the stresses in uniform motion with derivatives of an energy, for quadrilaterals and six-node triangles.
fn assert_derivatives(name: &str, material: &str, routines: &Routines, energy: impl Fn(&Matrix) -> f64) {
    let velocity = |[r, z]: [f64; 2]| VELOCITY.map(|row| row[0] * r + row[1] * z);
    let deck = oriented(&moving(velocity, material, " S\n"));
    for text in [in_six_node_triangles(&deck, [2, 2]), deck] {
        let (outcome, memory) = common::run(&text, &[], routines);
        assert_eq!(outcome.halt, None);
        let mut worst = 0.0_f64;
        // At the start the fibres are at the limit of compression, where the energy has no second derivative.
        for (time, row) in &memory.rows[1..] {
            let [[rr, _], [zr, zz]] = VELOCITY.map(|row| row.map(|x| x * time));
            let f = [[1.0 + rr, 0.0, 0.0], [zr, 1.0 + zz, 0.0], [0.0, 0.0, 1.0 + rr]];
            let expected = stress(&f, &energy);
            let size = expected.iter().fold(1.0, |size: f64, s| size.max(s.abs()));
            assert!(size > 1.0, "{expected:?}");
            for (found, expected) in row.iter().zip(expected) {
                worst = worst.max((found - expected).abs() / size);
            }
        }
        println!("{name}: error of the stress {worst:.1e}");
        assert!(memory.rows.len() == 11 && worst < 1e-8, "{name}: {worst}");
    }
}

#[test]
fn stresses_are_derivatives_of_the_energy() {
    let routines = Routines::none().with_energy(EveryInvariant);
    let user = cards("user, formulation=invariant, properties=5", &[FIBRES[0], FIBRES[2]]);
    assert_derivatives("every invariant", &user, &routines, energy_of_every);
    let built_in = cards("holzapfel", &FIBRES);
    assert_derivatives("Holzapfel", &built_in, &Routines::none(), |f| energy_of_tissue(f, &FIBRES));
    // Directions along rotated axes: 30 degrees about the hoop, from axes that are exchanged.
    let turned = built_in.replace("1., 0., 0., 0., 1., 0.\n 1, 0.", "0., 1., 0., 1., 0., 0.\n 3, 30.");
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    let fibres = FIBRES.map(|[a, b, c]| [sine * a + cosine * b, cosine * a - sine * b, c]);
    assert_derivatives("rotated axes", &turned, &Routines::none(), |f| energy_of_tissue(f, &fibres));
}

/// The example in Fortran gives the stresses of the built-in energy.
#[test]
fn energy_in_fortran_matches_the_built_in_one() {
    if !common::fortran("vuanisohyper_inv in Fortran") {
        return;
    }
    let file = std::fs::read_to_string(common::project("input/vuanisohyper_fibres.f90")).expect("the example");
    let routines = compiled(&file).expect("it compiles");
    let deck = |energy: &str| oriented(&moving(|[r, z]| [0.3 * r - 0.2 * z, r], &cards(energy, &FIBRES), " S\n"));
    let rows = |energy: &str, routines: &Routines| {
        let (outcome, memory): (_, RecordedOutput) = common::run(&deck(energy), &[], routines);
        assert_eq!(outcome.halt, None);
        memory.rows
    };
    let expected = rows("holzapfel", &Routines::none());
    let found = rows("user, formulation=invariant, properties=5", &routines);
    for ((_, a), (_, b)) in expected.iter().zip(&found) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-11 * (1.0 + a.abs())), "{a:?} {b:?}");
    }
    assert!(expected.len() == 11 && expected[10].1[1] > 1.0, "{expected:?}");
}

/// Returns the stretch without stress along a direction of a diagonal deformation gradient, found by bisection.
fn free_stretch(energy: impl Fn(&Matrix) -> f64, f: impl Fn(f64) -> Matrix, axis: usize) -> f64 {
    let [mut low, mut high] = [0.3, 1.2];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if stress(&f(middle), &energy)[axis] > 0.0 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Returns a cylinder of radius and length 1 with a prescribed slow motion of a node set along an axis, damped.
fn pulled_cylinder(material: &str, (set, dof, stretch): (&str, usize, f64)) -> String {
    oriented(
        &(grid(2, 2, false, |i, j| [0.5 * i as f64, 0.5 * j as f64])
            + "*Elset, elset=ONE\n 4,\n*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.,\n\
               *Damping, alpha=1.\n"
            + material
            + "*Amplitude, name=RISE, definition=SMOOTH STEP\n 0., 0., 60., 1.\n*Step\n*Dynamic, Explicit\n , 80.\n\
               *Boundary\n J0, 2, 2\n*Boundary, amplitude=RISE\n"
            + &format!(" {set}, {dof}, {dof}, {:e}\n", stretch - 1.0)
            + "*Output, history, number interval=20\n*Element Output, elset=ONE\n S\n\
               *Energy Output\n ALLSE, ALLIE, ALLPD, ALLAE, ALLKE\n*End Step\n"),
    )
}

/// A cylinder with axial fibres under tension, and a disc with radial and hoop fibres in biaxial tension: both are in uniform
/// stress, with the stretch without stress along the free direction.
#[test]
fn tension_of_cylinders_matches_the_closed_form() {
    let axial: &[[f64; 3]] = &[[0.0, 1.0, 0.0]];
    let plane: &[[f64; 3]] = &[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let stretch = 1.3;
    for (name, fibres, motion, free) in
        [("axial", axial, ("J1", 2, stretch), 0), ("biaxial", plane, ("I1", 1, stretch), 1)]
    {
        let energy = |f: &Matrix| energy_of_tissue(f, fibres);
        let shape = |s: f64| {
            let [radial, along] = if free == 0 { [s, stretch] } else { [stretch, s] };
            [[radial, 0.0, 0.0], [0.0, along, 0.0], [0.0, 0.0, radial]]
        };
        let f = shape(free_stretch(energy, shape, free));
        let (expected, stored) = (stress(&f, energy), std::f64::consts::PI * energy(&f));
        let text = pulled_cylinder(&cards("holzapfel", fibres), motion);
        let routines = Routines::none();
        let (outcome, memory) = common::run(&text, &[], &routines);
        assert_eq!(outcome.halt, None);
        let value = |name: &str| last(&text, &routines, &memory, name);
        let loaded = expected[1 - free];
        let errors = ["S11@ONE", "S22@ONE", "S33@ONE"].iter().zip(expected).map(|(s, e)| (value(s) - e).abs() / loaded);
        let error = errors.fold(0.0, f64::max);
        let excess = value("ALLSE") / stored - 1.0;
        println!(
            "{name}: stress {loaded:.4}, error {error:.1e}, strain energy {excess:.1e}, drift {:.1e}",
            outcome.energy.drift
        );
        assert!(error < 1e-4 && excess.abs() < 1e-4 && outcome.energy.drift < 1e-3, "{error} {excess}");
        assert!(value("ALLPD") == 0.0 && value("ALLAE").abs() < 1e-6 * stored);
    }
}

/// The cylinder with axial fibres on new meshes, with the energy of a subroutine: uniform stress is moved without error.
#[test]
fn new_meshes_keep_the_stress_of_fibres() {
    if !common::fortran("vuanisohyper_inv in Fortran") {
        return;
    }
    let file = std::fs::read_to_string(common::project("input/vuanisohyper_fibres.f90")).expect("the example");
    let routines = compiled(&file).expect("it compiles");
    let (fibres, stretch): (&[[f64; 3]], f64) = (&[[0.0, 1.0, 0.0]], 1.3);
    let energy = |f: &Matrix| energy_of_tissue(f, fibres);
    let shape = |s: f64| [[s, 0.0, 0.0], [0.0, stretch, 0.0], [0.0, 0.0, s]];
    let expected = stress(&shape(free_stretch(energy, shape, 0)), energy)[1];
    let card = "*Remesh, elset=SOLID, frequency=20, angle=1., increment=0.9999\n*Amplitude, name=RISE";
    let material = cards("user, formulation=invariant, properties=5", fibres);
    let text = pulled_cylinder(&material, ("J1", 2, stretch))
        .replace("*Amplitude, name=RISE", card)
        .replace("*Element Output, elset=ONE\n S\n", "*Element Output, elset=SOLID, statistics=\"MIN, MAX\"\n S\n");
    let (outcome, memory) = common::run(&text, &[], &routines);
    assert_eq!(outcome.halt, None);
    let meshes = outcome.new_meshes.iter().map(|meshes| meshes.count).sum::<u64>();
    let errors =
        ["MIN", "MAX"].map(|kind| last(&text, &routines, &memory, &format!("S22_{kind}@SOLID")) / expected - 1.0);
    println!("{meshes} meshes: {errors:?}, drift {:.1e}", outcome.energy.drift);
    assert!(meshes >= 10 && errors.iter().all(|error| error.abs() < 1e-3), "{errors:?}");
}

/// A bar that stretches by its inertia until its stiffening fibres stop it: the increments follow the stiffness, and the energy
/// is kept.
#[test]
fn stiffening_fibres_stay_stable() {
    let material = cards("holzapfel", &[[0.0, 0.8, 0.6], [0.0, 0.8, -0.6]])
        .replace(&TISSUE.map(|x| format!("{x:e}")).join(", "), "2., .01, 5., 40., 0.");
    let mut deck = grid(4, 8, false, |i, j| [0.25 * i as f64, 0.25 * j as f64])
        + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.,\n"
        + &material
        + "*Initial Conditions, type=VELOCITY\n";
    for node in 6..=45 {
        writeln!(deck, " {node}, 2, {:e}", 1.5 * 0.25 * f64::from((node - 1) / 5)).expect("text");
    }
    deck += "*Step\n*Dynamic, Explicit\n , 1.2\n*Boundary\n J0, 2, 2\n*Output, history, number interval=200\n\
             *Node Output, nset=CORNER\n U2\n*Energy Output\n ALLSE\n*End Step\n";
    let deck = oriented(&deck.replace("*Solid Section", "*Nset, nset=CORNER\n 45,\n*Solid Section"));
    for text in [in_six_node_triangles(&deck, [4, 8]), deck] {
        let (outcome, memory) = common::run(&text, &[], &Routines::none());
        assert_eq!(outcome.halt, None);
        let longest = memory.rows.iter().map(|row| row.1[0]).fold(0.0, f64::max);
        let energy = outcome.energy;
        println!("stiffening: {} increments, longest way {longest:.3}, {energy:?}", outcome.increments);
        let end = memory.rows.last().expect("a row").1[0];
        assert!(longest > 0.3 && end < 0.9 * longest && energy.drift < 5e-3, "{longest} {end} {energy:?}");
    }
}

/// A subroutine in its own process has the bits of the run without.
#[test]
fn isolated_energies_have_the_same_bits() {
    if !common::fortran("vuanisohyper_inv in Fortran") {
        return;
    }
    let user_dir = UserFolder::new();
    let material = cards("user, formulation=invariant, properties=5", &FIBRES);
    let deck = user_dir.write("tissue.inp", &oriented(&moving(|[r, _]| [0.1 * r, r], &material, " S\n")));
    let law = std::fs::read_to_string(common::project("input/vuanisohyper_fibres.f90")).expect("the example");
    let file = user_dir.write("fibres.f90", &law);
    let digests = [&[][..], &["--isolate"]].map(|options| {
        let output = user_dir.run(&deck, &[&file], options);
        assert!(output.status.success(), "{}", message_text(&output));
        user_dir.summary("tissue")["digest"].as_str().expect("a digest").to_owned()
    });
    assert_eq!(digests[0], digests[1]);
}

/// Missing and contradictory cards, a missing bulk modulus and a derivative that is not finite name what is wrong.
#[test]
fn invalid_energies_are_reported() {
    let user = "user, formulation=invariant, properties=5";
    let deck = |material: &str| oriented(&moving(|[r, _]| [0.1 * r, 0.0], material, " S\n"));
    let good = cards(user, &FIBRES[..2]);
    for (text, code, part) in [
        (deck(&good), "P004", "vuanisohyper_inv"),
        (deck(&cards("user, formulation=strain, properties=5", &FIBRES)), "M104", "VUANISOHYPER_STRAIN"),
        (deck(&good).replace(", orientation=FIBRES", ""), "M101", "gives 0"),
        (deck(&good.replace("FIBRES, local directions=2", "FIBRES, local directions=1")), "M103", "2 lines follow"),
        (
            deck(&good.replace("properties=5, local directions=2", "properties=5, local directions=3")),
            "M101",
            "gives 2",
        ),
        (deck(&good.replace("properties=5", "properties=4")), "M103", "PROPERTIES=4"),
        (deck(&cards("fung-orthotropic", &FIBRES)), "M1", "HOLZAPFEL"),
        (deck(&cards("local direction=2, holzapfel, user", &FIBRES)), "", "HOLZAPFEL"),
        (deck(&format!("*Elastic\n 1., .3\n{}", cards("holzapfel", &FIBRES))), "P041", "*ANISOTROPIC HYPERELASTIC"),
        (deck(&cards("holzapfel", &[[0.0; 3]])), "M103", "component that is not 0"),
    ] {
        let prepared = job::prepare_text("test.inp", &text, &[], &Routines::none());
        let found = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(prepared.diagnostics.has_errors() && found.contains(code) && found.contains(part), "{text}{found}");
    }
    let text = deck(&cards("holzapfel", &FIBRES));
    let read = revolve::deck::read_text("test.inp", &text, &[]);
    let prepared = job::prepare_edited(read, &mut |model| model.sections[0].fibres.clear(), &Routines::none());
    let found = prepared.diagnostics.render(&prepared.deck.sources);
    assert!(found.contains("P041") && found.contains("3 directions of fibres, but its section has 0"), "{found}");
    struct Faulty(f64, f64);
    impl UserEnergy for Faulty {
        fn energy(&mut self, call: &EnergyCall<'_>, answer: &mut EnergyAnswer<'_>) -> Result<(), LoadFailure> {
            let n = call.count;
            answer.first[..n].fill(if call.now.total_time > 0.0 { self.0 } else { 1.0 });
            answer.second[5 * n..6 * n].fill(self.1);
            Ok(())
        }
    }
    for (routine, part) in [(Faulty(f64::NAN, 9.0), "duDi(k, 1)"), (Faulty(1.0, 0.0), "bulk modulus")] {
        let (outcome, _): (_, RecordedOutput) = common::run(&deck(&good), &[], &Routines::none().with_energy(routine));
        let halt = outcome.halt.expect("a halt").to_string();
        assert!(halt.contains("user material `M`") && halt.contains(part), "{halt}");
    }
}
