//! Resistance of sheet with directions (`*POTENTIAL`) and of solids with an equation of state, with and without pores: closed
//! forms, similarity solutions and meshed cavities.

use revolve::model::derive::expansion_target;
use revolve::resistance::similarity::ExpandingCavity;
use revolve::resistance::{
    CavityShape, ExpansionTarget, ResistanceError, ScaledTarget, TargetMaterial, TargetSizes, YieldCurve,
};
use revolve::study::expansion::{self, MeasuredMaterial};

use crate::resistance::{POROUS_METAL, material_of};

fn target(cards: &str, shape: CavityShape) -> Box<dyn ExpansionTarget> {
    expansion_target(&material_of("M", cards), &TargetSizes { shape, ..TargetSizes::default() }).expect("a target")
}

/// Returns the pressure on a cavity that opens at a velocity, stress.
fn stress(target: &dyn ExpansionTarget, velocity: f64) -> Result<f64, ResistanceError> {
    target.pressures().and_then(|at| at(velocity)).map(|point| point.stress * target.scale().yield_stress)
}

/// Returns the extrapolated pressure of meshes with the material, stress.
fn meshed(cards: &str, shape: CavityShape, velocity: f64) -> f64 {
    let scale = target(cards, shape).scale();
    let material = MeasuredMaterial::Law(Box::new(material_of("M", cards)));
    let measured = expansion::measure(&material, scale, &[velocity]).expect("runs");
    println!("levels {:?}, drift {:e}", measured[0].levels, measured[0].drift);
    measured[0].estimate.limit * scale.yield_stress
}

fn sheet(ratios: &str) -> String {
    let [elastic_plastic, _] = POROUS_METAL.split("*Porous").collect::<Vec<_>>().try_into().expect("two parts");
    format!("{elastic_plastic}*Potential\n {ratios}, 1., 1.\n")
}

fn solid(eos: &str, [shear, yield_stress]: [f64; 2]) -> String {
    format!("*Density\n 2700.,\n{eos}*Elastic, type=SHEAR\n {shear:e},\n*Plastic\n {yield_stress:e}, 0.\n")
}

/// Equal ratios are the von Mises stress, around a sphere and a cylinder. Other ratios have a pressure around a cylinder only: a
/// hole along the axis, around which the axes are radial. It is within .5 % of a mesh.
#[test]
fn hill_yield_around_a_cavity() {
    for shape in [CavityShape::Spherical, CavityShape::Cylindrical] {
        let isotropic = target(&sheet("1., 1., 1., 1."), shape);
        let drucker_prager = POROUS_METAL.split("*Plastic").next().expect("cards").to_owned()
            + "*Drucker Prager\n 1.e-6, 1., 0.\n*Drucker Prager Hardening\n 300.e6, 0.\n 500.e6, 1.\n";
        let mises = target(&drucker_prager, shape);
        for velocity in [0.0, 300.0] {
            let [hill, mises] = [&isotropic, &mises].map(|target| stress(&**target, velocity).expect("a pressure"));
            println!("{shape:?} {velocity}: {hill:e} {mises:e}");
            assert!((hill / mises - 1.0).abs() < 1e-5, "{hill:e} {mises:e}");
        }
    }
    for ratios in ["1., 1.3, 1., 1.", "1., 1.1, 0.8, 0.9"] {
        let cards = sheet(ratios);
        let sphere = expansion_target(&material_of("M", &cards), &TargetSizes::default());
        let message = sphere.err().expect("no sphere").message;
        assert!(
            message.contains("axes r, z and hoop are not radial") && message.contains("mesh the target"),
            "{message}"
        );
        let hole = stress(&*target(&cards, CavityShape::Cylindrical), 300.0).expect("a pressure");
        let mesh = meshed(&cards, CavityShape::Cylindrical, 300.0);
        println!("{ratios}: {hole:e}, meshed {mesh:e} {:+.3} %", 100.0 * (hole / mesh - 1.0));
        assert!((hole / mesh - 1.0).abs() < 5e-3, "{hole:e} {mesh:e}");
    }
}

/// An equation of state whose pressure is linear in the volume, as in the similarity solution. Tolerance 1e-4. The strength is low,
/// because the elastic zone of the similarity solution is that of small strains.
#[test]
fn solid_with_an_equation_of_state_matches_the_similarity_solution() {
    let cards = solid("*Eos, type=USUP\n 5000., 0., 0.\n", [27e9, 30e6]);
    let found = target(&cards, CavityShape::Spherical);
    let bulk = 2700.0 * 5000.0 * 5000.0;
    let [young, poisson] = [9.0 * bulk * 27e9 / (3.0 * bulk + 27e9), (3.0 * bulk - 54e9) / (6.0 * bulk + 54e9)];
    let known = TargetMaterial {
        shape: CavityShape::Spherical,
        young,
        poisson,
        density: 2700.0,
        yield_stress: 30e6,
        curve: YieldCurve::Perfect,
        pressure_slope: 0.0,
        tension: None,
        rate: None,
    };
    let known = ScaledTarget::new(&known).expect("a target");
    let known = ExpandingCavity::new(&known).expect("an expansion");
    for velocity in [0.0, 300.0, 1000.0] {
        let (found, exact) = (stress(&*found, velocity), known.pressure(velocity).expect("a pressure").stress * 30e6);
        let found = found.expect("a pressure");
        println!("{velocity}: {found:e} {exact:e} {:+.1e}", found / exact - 1.0);
        assert!((found / exact - 1.0).abs() < 1e-4, "{found:e} {exact:e}");
    }
}

/// Pores that close at a negligible pressure, and an almost incompressible solid (snow-plough). With the ratio x = n^(1/3) of cavity
/// and front, mass and momentum give rho0 V² x at the front and, integrated to the wall, rhoS V² (2 (1 - x) - (1 - x⁴)/2) and
/// 2 Y ln(1/x) more. The front is slower than the elastic wave in the first case, a shock into material at rest in the others.
#[test]
fn instantaneous_crush_matches_the_snow_plough() {
    let (porosity, density, strength): (f64, f64, f64) = (0.2, 2700.0, 1e5);
    let eos = "*Eos, type=USUP\n 1.e6, 1.34, 0.\n*Eos Compaction\n 3500., 0.2, 2.e4, 4.e4\n";
    let soil = target(&solid(eos, [5e9, strength]), CavityShape::Spherical);
    let x = porosity.cbrt();
    for velocity in [300.0, 1000.0, 2500.0, 5000.0] {
        let at_front = density * (1.0 - porosity) * velocity * velocity * x;
        let inertia = density * velocity * velocity * (2.0 * (1.0 - x) - 0.5 * (1.0 - x.powi(4)));
        let exact = at_front + inertia - 2.0 * strength * x.ln();
        let found = stress(&*soil, velocity).expect("a pressure");
        println!("{velocity}: {found:e} {exact:e} {:+.2e}", found / exact - 1.0);
        assert!((found / exact - 1.0).abs() < 2e-3, "{velocity}: {found:e} {exact:e}");
    }
}

/// Porous aluminium whose shocks are heated, and sand whose shocks are faster than its elastic waves, on meshes. Tolerance 1 %.
#[test]
fn resistance_of_porous_solids_matches_their_meshed_cavities() {
    let aluminium = "*Eos, type=USUP\n 5350., 1.34, 2.\n*Eos Compaction\n 3500., 0.2, 80.e6, 700.e6\n";
    let sand = "*Eos, type=USUP\n 3600., 1.8, 1.\n*Eos Compaction\n 400., 0.4, 1.e6, 200.e6\n";
    for (cards, velocity) in [
        (solid("*Eos, type=USUP\n 5350., 1.34, 2.\n", [27e9, 300e6]), 500.0),
        (solid(aluminium, [20e9, 200e6]), 300.0),
        (solid(aluminium, [20e9, 200e6]), 1000.0),
        (solid(sand, [0.1e9, 1e6]), 50.0),
        (solid(sand, [0.1e9, 1e6]), 400.0),
    ] {
        let found = stress(&*target(&cards, CavityShape::Spherical), velocity);
        println!("{velocity}: {found:?}");
        let mesh = meshed(&cards, CavityShape::Spherical, velocity);
        let found = found.expect("a pressure");
        println!("{velocity}: {found:e}, meshed {mesh:e} {:+.2} %", 100.0 * (found / mesh - 1.0));
        assert!((found / mesh - 1.0).abs() < 1e-2, "{velocity}: {found:e} {mesh:e}");
    }
}

/// A fluid, a gas and a rate have no derived resistance, for a reason each.
#[test]
fn unsuitable_equations_of_state_are_refused_as_targets() {
    let usup = "*Eos, type=USUP\n 5000., 1.3, 2.\n";
    for (cards, word) in [
        (format!("*Density\n 1000.,\n{usup}*Plastic\n 1.e6, 0.\n"), "fluid"),
        (format!("{}*Rate Dependent, type=power law\n 8.e5, 3.\n", solid(usup, [27e9, 3e8])), "RATE DEPENDENT"),
        (solid("*Eos, type=IDEAL GAS\n 287., 0.\n", [27e9, 3e8]), "USUP and TABULAR"),
    ] {
        let error = expansion_target(&material_of("M", &cards), &TargetSizes::default()).err().expect("no target");
        assert!(error.code == "M104" && error.message.contains(word), "{} {}", error.code, error.message);
    }
}
