//! Finite targets: free surfaces, gaps, craters, plugs, and separation from the tunnel wall.
//!
//! Goal: residual velocity, depth and energies of bodies in finite targets.
//! Source: the exact factor of a finite elastic, perfectly plastic sphere (Hill 1950, V.2) over the distance along the
//! outward normal; an independent quadrature of m V dV/dz = -F(z, V) over the smooth ogive; closed forms for a flat
//! nose.
//! Parameters: projectile of 7.11 mm, CRH 3 and 21 g into plates of 6061-T6511 with E = 68.9 GPa.

use std::f64::consts::PI;

use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common;

const A: f64 = 3.555e-3;
const Y: f64 = 276e6;
const RHO: f64 = 2710.0;
const E: f64 = 68.9e9;
const MASS: f64 = 0.021;
const TERMS: [f64; 3] = [5.0394, 0.983, 0.9402];
/// Height of the nose in mm.
const HEIGHT: f64 = 11.790_601;

/// Plate between two depths, the end of the material for its free surface, and its lateral radius.
#[derive(Clone, Copy)]
struct TargetPlate {
    from: f64,
    to: f64,
    back: f64,
    radius: f64,
    free: bool,
    crater: f64,
}

impl TargetPlate {
    fn new(from: f64, to: f64) -> TargetPlate {
        TargetPlate { from, to, back: to, radius: f64::INFINITY, free: true, crater: 0.0 }
    }
}

fn free_surface_factor(ratio: f64) -> f64 {
    let q = 2.0 * E / (3.0 * Y);
    let whole = 1.0 + q.ln();
    if ratio.powi(3) > q { (whole - q * ratio.powi(-3)) / whole } else { 3.0 * ratio.ln() / whole }
}

/// Returns the axial force on the smooth ogive at nose-tip depth `z` and speed `v`.
fn axial_force(plates: &[TargetPlate], z: f64, v: f64) -> f64 {
    let (big, height) = (6.0 * A, 11f64.sqrt() * A);
    let mut total = 0.0;
    for plate in plates {
        let (from, to) = ((z - plate.to).clamp(0.0, height), (z - plate.from).clamp(0.0, height));
        let panels = 100;
        for i in 0..panels {
            let (a, b) = (from + (to - from) * f64::from(i) / 100.0, from + (to - from) * f64::from(i + 1) / 100.0);
            for x in [-1.0, 1.0f64] {
                let s = 0.5 * (a + b) + 0.5 * (b - a) * x / 3f64.sqrt();
                let t = ((height - s) / big).asin();
                let (r, n) = (A - big * (1.0 - t.cos()), t.sin());
                let mut stress = Y * (TERMS[0] + v * n * (TERMS[1] * (RHO / Y).sqrt() + v * n * TERMS[2] * RHO / Y));
                if plate.free {
                    let distance = ((plate.back - (z - s)) / n).min((plate.radius - r) / t.cos());
                    stress *= free_surface_factor(1.0 + distance.max(0.0) / r);
                }
                if plate.crater > 0.0 {
                    stress *= ((z - s) / plate.crater).min(1.0);
                }
                let outside = r > plate.radius;
                total += if outside { 0.0 } else { 0.5 * (b - a) * 2.0 * PI * r * stress * n / t.cos() };
            }
        }
    }
    total
}

/// Returns the depth at rest or the residual velocity.
fn quadrature(plates: &[TargetPlate], v0: f64) -> (f64, f64) {
    let end = plates[plates.len() - 1].to + 11f64.sqrt() * A;
    let (mut z, mut energy, h) = (0.0, 0.5 * MASS * v0 * v0, 2e-5);
    let slope = |z: f64, energy: f64| -axial_force(plates, z, (2.0 * energy.max(0.0) / MASS).sqrt());
    while z < end {
        let k1 = slope(z, energy);
        if energy + 0.5 * h * k1 <= 0.0 {
            return (z + energy / -k1, 0.0);
        }
        let k2 = slope(z + 0.5 * h, energy + 0.5 * h * k1);
        energy += h * k2;
        z += h;
        if energy <= 0.0 {
            return (z + energy / -k2, 0.0);
        }
    }
    (z, (2.0 * energy / MASS).sqrt())
}

fn deck(target: &str, layers: &str) -> String {
    common::ogive()
        .replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, accuracy=1e-6\n")
        .replace("*Density\n <rho>,\n", "*Density\n <rho>,\n*Elastic\n 68.9e9, 0.3333\n")
        .replace("direction=-1\n AL6061, 0.5\n", &format!("direction=-1{target}\n{layers}"))
}

fn run_shot(text: &str, v: f64, facets: &str) -> Outcome {
    let v = format!("{v}");
    let set = [("V", v.as_str()), ("n", facets), ("B", "0.983"), ("C", "0.9402")];
    let (outcome, _) = common::run(text, &set, &Routines::none());
    assert_eq!(outcome.halt, None);
    assert!(outcome.energy.drift < 1e-6, "energy drift {:.2e}", outcome.energy.drift);
    outcome
}

fn residual_velocity(text: &str, v: f64, facets: &str) -> f64 {
    let outcome = run_shot(text, v, facets);
    assert_eq!(outcome.rests, []);
    -outcome.exits.first().expect("perforation").velocity
}

fn final_depth(text: &str, v: f64, facets: &str) -> f64 {
    -run_shot(text, v, facets).rests.first().expect("it stops").displacement
}

fn assert_close(value: f64, exact: f64, relative: f64, what: &str) {
    let off = value / exact - 1.0;
    assert!(off.abs() <= relative, "{what}: {value}, expected {exact}, relative {off:.2e}");
}

/// The quadrature uses the nose of the deck.
#[test]
fn nose_height_matches_the_deck() {
    assert_close(11f64.sqrt() * A * 1e3, HEIGHT, 1e-6, "height");
    let (_, memory) = common::run(&common::ogive(), &[("n", "4")], &Routines::none());
    let widest = |[r, _]: &&[f64; 2]| (r - A).abs() < 1e-12;
    let shoulder = memory.frames[0].points.iter().find(widest).expect("a shoulder");
    assert_close(shoulder[1] * 1e3, HEIGHT, 1e-6, "height of the shoulder");
}

#[test]
fn thin_plate_with_free_surfaces_matches_quadrature() {
    // Plates thinner than the nose, as thick as the nose, and three times as thick, at low and high velocity. The error
    // is largest just above the ballistic limit.
    for (thickness, v) in [(0.006, 250.0), (0.006, 900.0), (0.012, 320.0), (0.036, 520.0), (0.036, 1100.0)] {
        let text = deck(", free surface=ON", &format!(" AL6061, {thickness}\n"));
        let (_, exact) = quadrature(&[TargetPlate::new(0.0, thickness)], v);
        assert_close(residual_velocity(&text, v, "400"), exact, 2e-4, &format!("{thickness} at {v}"));
        let whole = deck("", &format!(" AL6061, {thickness}\n"));
        assert!(
            residual_velocity(&text, v, "40")
                > 1.005 * if v > 300.0 { residual_velocity(&whole, v, "40") } else { 0.0 }
        );
    }
}

#[test]
fn facets_converge_with_second_order_at_free_surfaces() {
    let text = deck(", free surface=ON, radius=0.02", " AL6061, 0.03\n");
    let plate = TargetPlate { radius: 0.02, ..TargetPlate::new(0.0, 0.03) };
    let (_, exact) = quadrature(&[plate], 600.0);
    let errors = ["10", "20", "40"].map(|n| residual_velocity(&text, 600.0, n) - exact);
    let orders = [(errors[0] / errors[1]).abs().log2(), (errors[1] / errors[2]).abs().log2()];
    assert!(orders.iter().all(|o| (o - 2.0).abs() < 0.3), "orders {orders:?} of errors {errors:?}");
    assert!(errors[2].abs() < 1e-3 * exact, "{errors:?}");
}

#[test]
fn lateral_free_surface_weakens_a_target() {
    for (radius, v) in [(0.010, 500.0), (0.030, 800.0)] {
        let text = deck(&format!(", free surface=ON, radius={radius}"), " AL6061, 0.5\n");
        let plate = TargetPlate { radius, ..TargetPlate::new(0.0, 0.5) };
        assert_close(final_depth(&text, v, "400"), quadrature(&[plate], v).0, 2e-4, "depth");
    }
}

#[test]
fn very_large_target_equals_one_without_free_surfaces() {
    let law = deck("", " AL6061, 9.\n");
    let free = deck(", free surface=ON, radius=1e6", " AL6061, 1e6\n");
    assert_close(final_depth(&free, 800.0, "100"), final_depth(&law, 800.0, "100"), 1e-6, "depth");
}

#[test]
fn layers_are_bonded_unless_each_has_free_surfaces() {
    let layers = " AL6061, 0.01\n AL6061, 0.01\n";
    let one = residual_velocity(&deck(", free surface=ON", " AL6061, 0.02\n"), 500.0, "200");
    let held = residual_velocity(&deck(", free surface=ON", layers), 500.0, "200");
    assert_close(held, one, 1e-6, "two bonded layers");
    let (_, exact) = quadrature(&[TargetPlate::new(0.0, 0.01), TargetPlate::new(0.01, 0.02)], 500.0);
    let loose = residual_velocity(&deck(", free surface=LAYERS", layers), 500.0, "400");
    assert_close(loose, exact, 2e-4, "two loose layers");
    assert!(loose > 1.02 * one);
}

#[test]
fn plates_with_a_gap_match_quadrature() {
    let layers = " AL6061, 0.01\n , 0.025\n AL6061, 0.008, 0.02\n";
    let plates = [TargetPlate::new(0.0, 0.01), TargetPlate { radius: 0.02, ..TargetPlate::new(0.035, 0.043) }];
    let (_, exact) = quadrature(&plates, 450.0);
    assert_close(residual_velocity(&deck(", free surface=ON", layers), 450.0, "400"), exact, 2e-4, "residual velocity");
    let law = [TargetPlate::new(0.0, 0.01), TargetPlate::new(0.035, 0.043)].map(|p| TargetPlate { free: false, ..p });
    let (_, exact) = quadrature(&law, 450.0);
    let text = deck("", " AL6061, 0.01\n , 0.025\n AL6061, 0.008\n");
    assert_close(residual_velocity(&text, 450.0, "400"), exact, 2e-4, "without free surfaces");
}

#[test]
fn crater_matches_quadrature() {
    for (crater, v) in [(0.005, 500.0), (0.03, 800.0)] {
        let text = deck(&format!(", crater={crater}"), " AL6061, 0.5\n");
        let plate = TargetPlate { crater, free: false, ..TargetPlate::new(0.0, 0.5) };
        assert_close(final_depth(&text, v, "400"), quadrature(&[plate], v).0, 1e-4, "depth");
    }
}

/// Returns the deck of a cylinder of radius A with a flat nose at z = 0, flying in the direction of -z.
fn flat_nose(target: &str, layers: &str) -> String {
    let text = deck(target, layers);
    let nodes = text.find("*Node\n").expect("nodes");
    let rest = text.find("*Nset, nset=REF").expect("sets");
    let elements = text.find("*Element, type=RAX2").expect("elements");
    let mass = text.find("*Element, type=MASS").expect("a mass");
    let mesh = "*Node\n 1, 0., 0.\n 2, <a>, 0.\n 3, <a>, 0.02\n 9999, 0., 0.02\n";
    let rax2 = "*Element, type=RAX2, elset=NOSE\n 1, 1, 2\n 2, 2, 3\n";
    [&text[..nodes], mesh, &text[rest..elements], rax2, &text[mass..]].concat()
}

/// In the crater m V V' = -(z/h) (alpha + beta V^2) with B = 0, so V^2 + alpha/beta decays as exp(-beta z^2/(m h)).
#[test]
fn flat_nose_in_a_crater_matches_closed_form() {
    let area = PI * A * A;
    let (alpha, beta) = (area * TERMS[0] * Y, area * TERMS[2] * RHO);
    let (v, crater) = (600.0f64, 0.01);
    let (_, memory) = common::run(
        &flat_nose(&format!(", crater={crater}"), " AL6061, 0.5\n")
            .replace("number interval=200", "number interval=2000"),
        &[("V", "600"), ("C", "0.9402")],
        &Routines::none(),
    );
    let rows: Vec<&Vec<f64>> = memory.rows.iter().map(|row| &row.1).filter(|row| -row[0] < crater).collect();
    assert!(rows.len() > 10);
    for row in rows {
        let z = -row[0];
        let square = (v * v + alpha / beta) * (-beta * z * z / (MASS * crater)).exp() - alpha / beta;
        assert_close(-row[1], square.sqrt(), 1e-6, "velocity in the crater");
    }
}

/// The plug shears out where the shear force 2 pi a h tau is below the cavity force; m V^2/2 decreases by the area
/// below the smaller force.
#[test]
fn flat_nose_plugging_matches_closed_form() {
    let (thickness, tau, v) = (0.008, 400e6, 300.0f64);
    let area = PI * A * A;
    // With A alone the cavity force does not depend on velocity.
    let cavity = area * TERMS[0] * Y;
    let plug = 2.0 * PI * A * tau;
    // Remaining thickness at which shearing needs the smaller force.
    let left = (cavity / plug).min(thickness);
    let work = cavity * (thickness - left) + 0.5 * plug * left * left;
    let exact = (v * v - 2.0 * work / MASS).sqrt();
    let text = flat_nose(&format!(", shear strength={tau}"), &format!(" AL6061, {thickness}\n"));
    let (outcome, _) = common::run(&text, &[("V", "300"), ("C", "0")], &Routines::none());
    assert_close(-outcome.exits.first().expect("perforation").velocity, exact, 1e-5, "residual velocity");
    assert!(outcome.energy.drift < 1e-5, "{}", outcome.energy.drift);
    assert!(0.002 < left && left < thickness, "both ways of failing take part: {left}");
}

/// A shear strength that is never reached changes nothing; plugging helps a flat nose more than a pointed one.
#[test]
fn plugging_occurs_only_with_the_smaller_force() {
    let layers = " AL6061, 0.008\n";
    let strong = residual_velocity(&deck(", shear strength=1e15", layers), 300.0, "40");
    assert_close(strong, residual_velocity(&deck("", layers), 300.0, "40"), 1e-9, "a plug that does not shear out");
    let gain = |make: fn(&str, &str) -> String| {
        let lost = |target: &str| 300.0 * 300.0 - residual_velocity(&make(target, layers), 300.0, "40").powi(2);
        1.0 - lost(", shear strength=300e6") / lost("")
    };
    let (flat, pointed) = (gain(flat_nose), gain(deck));
    assert!(pointed > 0.0 && flat > 2.0 * pointed, "work saved: flat {flat}, pointed {pointed}");
}

/// A flare after a neck: with separation only the part wider than the tunnel is loaded.
#[test]
fn flare_is_loaded_where_wider_than_the_tunnel() {
    let with = |target: &str, points: &[[f64; 2]]| {
        let text = flat_nose(target, " AL6061, 0.5\n");
        let list = |p: (usize, &[f64; 2])| format!(" {}, {}, {}\n", p.0 + 1, p.1[0], p.1[1]);
        let nodes: String = points.iter().enumerate().map(list).collect();
        let elements: String = (1..points.len()).map(|i| format!(" {i}, {i}, {}\n", i + 1)).collect();
        let text = text.replace(" 1, 0., 0.\n 2, <a>, 0.\n 3, <a>, 0.02\n", &nodes);
        text.replace(" 1, 1, 2\n 2, 2, 3\n", &elements)
    };
    let necked = [[0.0, 0.0], [0.003, 0.003], [0.002, 0.004], [0.002, 0.006], [0.004, 0.008]];
    // The same for a flare that begins at the tunnel radius, with a step that carries no load.
    let straight = [[0.0, 0.0], [0.003, 0.003], [0.003, 0.007], [0.004, 0.008]];
    let set = [("V", "300"), ("C", "0.9402")];
    let stop = |text: &str| -common::run(text, &set, &Routines::none()).0.rests[0].displacement;
    let separated = stop(&with(", separation", &necked));
    assert_close(separated, stop(&with("", &straight)), 1e-5, "depth");
    assert!(separated > 1.05 * stop(&with("", &necked)), "without separation the whole flare is loaded");
    assert_close(stop(&with(", separation", &straight)), stop(&with("", &straight)), 1e-9, "a body without a neck");
}

/// A ring moves outward, back, and further outward. The cavity work is A Y times the opened volume: once if the wall
/// stays, and again on the second outward motion if it follows the ring.
#[test]
fn returning_ring_meets_the_tunnel_wall() {
    let text = |target: &str| {
        format!(
            "*Node\n 1, 9., 0.\n 2, 10., 0.\n 3, 10., 1.\n 4, 9., 1.\n*Element, type=CAX4R, elset=RING\n 1, 1, 2, 3, 4\n\
             *Nset, nset=ALL\n 1, 2, 3, 4\n*Surface, name=OUT\n RING, S2\n\
             *Material, name=STEEL\n*Density\n 7.85e-9,\n*Elastic\n 2e5, 0.3\n*Solid Section, elset=RING, material=STEEL\n\
             *Material, name=SOIL\n*Density\n 2e-9,\n*Cavity Expansion, yield=20.\n 3., 0., 0.\n\
             *Target, name=WALL, front=5., direction=-1{target}\n SOIL, 100.\n\
             *Amplitude, name=WAY\n 0., 0., 1e-3, 0.5, 2e-3, 0.2, 3e-3, 0.8\n\
             *Boundary\n ALL, 2\n*Step\n*Dynamic, Explicit\n , 3e-3\n*Boundary, amplitude=WAY\n ALL, 1, 1, 1.\n\
             *Dsload, target=WALL\n OUT, CAVITY\n\
             *Output, history, number interval=30\n*Energy Output\n ALLCAV, ETOTAL\n*End Step\n"
        )
    };
    let work = |target: &str| {
        let (outcome, memory) = common::run(&text(target), &[], &Routines::none());
        assert_eq!(outcome.halt, None);
        assert!(outcome.energy.drift < 1e-6, "{:.2e}", outcome.energy.drift);
        memory.rows.last().expect("rows").1[0]
    };
    let opened = |from: f64, to: f64| 60.0 * PI * (to * to - from * from);
    assert_close(work(", separation"), opened(10.0, 10.8), 1e-3, "wall that stays");
    assert_close(work(""), opened(10.0, 10.5) + opened(10.2, 10.8), 1e-3, "wall that follows");
}

/// A hard steel projectile with a convex nose hardly separates from the wall, except for elastic waves.
#[test]
fn hard_nose_hardly_separates_from_the_wall() {
    let text = std::fs::read_to_string(common::project("input/ogive_steel.inp")).expect("the deck");
    let stop = |target: &str| {
        let text = text.replace("direction=-1\n", &format!("direction=-1{target}\n"));
        let set = [("nn", "6"), ("ns", "10"), ("JCA", "9e9")];
        let (outcome, memory) = common::run(&text, &set, &Routines::none());
        assert_eq!(outcome.halt, None);
        assert!(outcome.energy.drift < 1e-3, "{:.2e}", outcome.energy.drift);
        memory.rows.iter().map(|row| row.1[0]).fold(0.0, f64::min)
    };
    assert_close(stop(", separation"), stop(""), 5e-3, "depth");
}

#[test]
fn invalid_finite_targets_are_errors() {
    for (code, target, layers) in [
        ("M103", ", free surface=FRONT", " AL6061, 0.1\n"),
        ("M103", ", radius=0.", " AL6061, 0.1\n"),
        ("M103", ", crater=-1.", " AL6061, 0.1\n"),
        ("M103", ", separation=PARTLY", " AL6061, 0.1\n"),
        ("M103", "", " AL6061, 0.1, -2.\n"),
        ("M103", "", " , 0.1\n AL6061, 0.1\n"),
        ("M103", "", " AL6061, 0.1\n , 0.1\n"),
        ("M103", "", " AL6061, 0.1\n ,\n AL6061, 0.1\n"),
    ] {
        assert_error(&deck(target, layers), code);
    }
    let soft = deck(", free surface=ON", " AL6061, 0.1\n");
    assert_error(&soft.replace("*Elastic\n 68.9e9, 0.3333\n", ""), "M181");
    assert_error(&soft.replace("68.9e9", "400e6"), "M181");
    let steel = std::fs::read_to_string(common::project("input/ogive_steel.inp")).expect("the deck");
    assert_error(&steel.replace("direction=-1\n", "direction=-1, shear strength=1e8\n"), "P015");
}

fn assert_error(text: &str, code: &str) {
    let diagnostics = revolve::job::prepare_text("target.inp", text, &[], &Routines::none()).diagnostics;
    let codes: Vec<_> =
        diagnostics.iter().filter(|d| d.severity == revolve::deck::Severity::Error).map(|d| d.code).collect();
    assert_eq!(codes, [code], "{text}");
}

/// Returns the deck of an oblique impact with options that bound its plate.
fn inclined_deck(bounds: &str) -> String {
    let text = std::fs::read_to_string(common::project("input/oblique.inp")).expect("the deck");
    text.replace("*Density\n <rho>,\n", "*Density\n <rho>,\n*Elastic\n 68.9e9, 0.3333\n")
        // Rotated about its tip, which is at the origin of the target plane.
        .replace(" 9999, 0., <h>\n", " 9999, 0., 0.\n")
        .replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, accuracy=1e-6\n")
        .replace("direction=-1,", &format!("direction=-1{bounds},"))
}

/// Returns the final speed and whether the body has six degrees of freedom.
fn final_speed(text: &str, settings: &[(&str, &str)]) -> (f64, bool) {
    let set: Vec<_> = settings.iter().copied().chain([("stations", "32"), ("n", "60")]).collect();
    let prepared = common::prepared(text, &set, &Routines::none());
    let mut memory = common::RecordedOutput::default();
    let (outcome, _) = revolve::solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    assert_eq!(outcome.halt, None);
    assert!(outcome.energy.drift < 1e-4, "{:.2e}", outcome.energy.drift);
    let last = &memory.rows.last().expect("rows").1;
    let named =
        prepared.plan.columns.iter().zip(last).filter(|c| ["V1@REF", "V2@REF", "V3@REF"].contains(&c.0.name.as_str()));
    (named.map(|(_, v)| v * v).sum::<f64>().sqrt(), !outcome.penetrations.is_empty())
}

/// In a target inclined by a vanishing angle, stations of a body with six degrees of freedom give the free-surface
/// effect of facets.
#[test]
fn inclined_target_has_the_same_free_surfaces() {
    for (bounds, v) in
        [(", free surface=ON", "600"), (", free surface=ON, radius=0.012", "600"), (", crater=0.01", "700")]
    {
        let end = |obliquity: &str| final_speed(&inclined_deck(bounds), &[("V", v), ("obliquity", obliquity)]);
        let ((level, none), (tilted, one)) = (end("0"), end("1e-6"));
        assert_eq!([none, one], [false, true]);
        assert_close(tilted, level, 1e-3, bounds);
    }
}

/// A projectile with its axis inclined by 20 degrees flies along the normal of a level plate; the same with the
/// projectile upright and plate and velocity inclined. The free surfaces, including the lateral face, rotate with the
/// plate.
#[test]
fn rotated_scene_has_the_rotated_result() {
    let bounds = ", free surface=ON, radius=0.05";
    let leaning = final_speed(&inclined_deck(bounds), &[("V", "700"), ("obliquity", "0"), ("yaw", "20")]).0;
    let (sine, cosine) = 20f64.to_radians().sin_cos();
    let velocity = format!(" REF, 1, {}\n REF, 2, {}\n", 700.0 * sine, -700.0 * cosine);
    let text = inclined_deck(bounds).replace(" REF, 2, <z1>\n", &velocity);
    let upright = final_speed(&text, &[("V", "700"), ("obliquity", "20")]).0;
    assert_close(upright, leaning, 1e-6, "residual speed");
    let level = final_speed(&inclined_deck(""), &[("V", "700"), ("obliquity", "0"), ("yaw", "20")]).0;
    assert!(leaning > 1.01 * level, "free surfaces weaken the plate: {leaning} against {level}");
}
