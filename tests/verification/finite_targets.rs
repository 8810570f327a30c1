//! Targets that end: free surfaces, gaps, craters, plugs, and bodies that part from the wall of their tunnel.
//!
//! Goal: residual velocity, depth and energies of bodies in targets with faces.
//! Source: the exact factor of a finite elastic, perfectly plastic sphere (Hill 1950, V.2) over the distance along the outward normal;
//! a quadrature of m V dV/dz = -F(z, V) over the smooth ogive, which shares no line with the solver; closed forms for a flat nose.
//! Parameters: the seed's projectile (7.11 mm, CRH 3, 21 g) into plates of 6061-T6511 with E = 68.9 GPa.

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
/// Height of the nose.
const HEIGHT: f64 = 11.790_601;

/// A plate between two depths, with the depth at which it ends for what its free surface takes, and its lateral radius.
#[derive(Clone, Copy)]
struct Plate {
    from: f64,
    to: f64,
    back: f64,
    radius: f64,
    free: bool,
    crater: f64,
}

impl Plate {
    fn new(from: f64, to: f64) -> Plate {
        Plate { from, to, back: to, radius: f64::INFINITY, free: true, crater: 0.0 }
    }
}

fn factor(ratio: f64) -> f64 {
    let q = 2.0 * E / (3.0 * Y);
    let whole = 1.0 + q.ln();
    if ratio.powi(3) > q { (whole - q * ratio.powi(-3)) / whole } else { 3.0 * ratio.ln() / whole }
}

/// Axial force at nose-tip depth `z` and speed `v` on the smooth ogive.
fn force(plates: &[Plate], z: f64, v: f64) -> f64 {
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
                    stress *= factor(1.0 + distance.max(0.0) / r);
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

/// Depth at rest, or the velocity behind the last plate.
fn quadrature(plates: &[Plate], v0: f64) -> (f64, f64) {
    let end = plates[plates.len() - 1].to + 11f64.sqrt() * A;
    let (mut z, mut energy, h) = (0.0, 0.5 * MASS * v0 * v0, 2e-5);
    let slope = |z: f64, energy: f64| -force(plates, z, (2.0 * energy.max(0.0) / MASS).sqrt());
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

fn run(text: &str, v: f64, facets: &str) -> Outcome {
    let v = format!("{v}");
    let set = [("V", v.as_str()), ("n", facets), ("B", "0.983"), ("C", "0.9402")];
    let (outcome, _) = common::run(text, &set, &Routines::none());
    assert_eq!(outcome.halt, None);
    assert!(outcome.energy.drift < 1e-6, "energy drift {:.2e}", outcome.energy.drift);
    outcome
}

fn residual(text: &str, v: f64, facets: &str) -> f64 {
    let outcome = run(text, v, facets);
    assert_eq!(outcome.rests, []);
    -outcome.exits.first().expect("it goes through").velocity
}

fn depth(text: &str, v: f64, facets: &str) -> f64 {
    -run(text, v, facets).rests.first().expect("it stops").displacement
}

fn close(value: f64, exact: f64, relative: f64, what: &str) {
    let off = value / exact - 1.0;
    assert!(off.abs() <= relative, "{what}: {value} against {exact}, relative {off:.2e}");
}

/// The quadrature is over the nose that the deck has.
#[test]
fn the_height_of_the_nose_is_that_of_the_deck() {
    close(11f64.sqrt() * A * 1e3, HEIGHT, 1e-6, "height");
    let (_, memory) = common::run(&common::ogive(), &[("n", "4")], &Routines::none());
    let widest = |[r, _]: &&[f64; 2]| (r - A).abs() < 1e-12;
    let shoulder = memory.frames[0].points.iter().find(widest).expect("a shoulder");
    close(shoulder[1] * 1e3, HEIGHT, 1e-6, "height of the shoulder");
}

#[test]
fn a_thin_plate_with_free_surfaces_against_quadrature() {
    // Thinner than the nose, as thick as it, three times; slow and fast. The worst is what barely goes through.
    for (thickness, v) in [(0.006, 250.0), (0.006, 900.0), (0.012, 320.0), (0.036, 520.0), (0.036, 1100.0)] {
        let text = deck(", free surface=ON", &format!(" AL6061, {thickness}\n"));
        let (_, exact) = quadrature(&[Plate::new(0.0, thickness)], v);
        close(residual(&text, v, "400"), exact, 2e-4, &format!("{thickness} at {v}"));
        let whole = deck("", &format!(" AL6061, {thickness}\n"));
        assert!(residual(&text, v, "40") > 1.005 * if v > 300.0 { residual(&whole, v, "40") } else { 0.0 });
    }
}

#[test]
fn facets_converge_with_order_two_at_free_surfaces() {
    let text = deck(", free surface=ON, radius=0.02", " AL6061, 0.03\n");
    let plate = Plate { radius: 0.02, ..Plate::new(0.0, 0.03) };
    let (_, exact) = quadrature(&[plate], 600.0);
    let errors = ["10", "20", "40"].map(|n| residual(&text, 600.0, n) - exact);
    let orders = [(errors[0] / errors[1]).abs().log2(), (errors[1] / errors[2]).abs().log2()];
    assert!(orders.iter().all(|o| (o - 2.0).abs() < 0.3), "orders {orders:?} of errors {errors:?}");
    assert!(errors[2].abs() < 1e-3 * exact, "{errors:?}");
}

#[test]
fn a_lateral_radius_weakens_a_target_all_the_way() {
    for (radius, v) in [(0.010, 500.0), (0.030, 800.0)] {
        let text = deck(&format!(", free surface=ON, radius={radius}"), " AL6061, 0.5\n");
        let plate = Plate { radius, ..Plate::new(0.0, 0.5) };
        close(depth(&text, v, "400"), quadrature(&[plate], v).0, 2e-4, "depth");
    }
}

#[test]
fn a_target_without_end_is_that_without_free_surfaces() {
    let law = deck("", " AL6061, 9.\n");
    let free = deck(", free surface=ON, radius=1e6", " AL6061, 1e6\n");
    close(depth(&free, 800.0, "100"), depth(&law, 800.0, "100"), 1e-6, "depth");
}

#[test]
fn layers_hold_together_unless_each_has_its_own_free_surfaces() {
    let layers = " AL6061, 0.01\n AL6061, 0.01\n";
    let one = residual(&deck(", free surface=ON", " AL6061, 0.02\n"), 500.0, "200");
    let held = residual(&deck(", free surface=ON", layers), 500.0, "200");
    close(held, one, 1e-6, "two layers that hold together");
    let (_, exact) = quadrature(&[Plate::new(0.0, 0.01), Plate::new(0.01, 0.02)], 500.0);
    let loose = residual(&deck(", free surface=LAYERS", layers), 500.0, "400");
    close(loose, exact, 2e-4, "two layers that lie on each other");
    assert!(loose > 1.02 * one);
}

#[test]
fn plates_with_a_gap_between_them() {
    let layers = " AL6061, 0.01\n , 0.025\n AL6061, 0.008, 0.02\n";
    let plates = [Plate::new(0.0, 0.01), Plate { radius: 0.02, ..Plate::new(0.035, 0.043) }];
    let (_, exact) = quadrature(&plates, 450.0);
    close(residual(&deck(", free surface=ON", layers), 450.0, "400"), exact, 2e-4, "residual velocity");
    let law = [Plate::new(0.0, 0.01), Plate::new(0.035, 0.043)].map(|p| Plate { free: false, ..p });
    let (_, exact) = quadrature(&law, 450.0);
    let text = deck("", " AL6061, 0.01\n , 0.025\n AL6061, 0.008\n");
    close(residual(&text, 450.0, "400"), exact, 2e-4, "without free surfaces");
}

#[test]
fn a_crater_against_quadrature() {
    for (crater, v) in [(0.005, 500.0), (0.03, 800.0)] {
        let text = deck(&format!(", crater={crater}"), " AL6061, 0.5\n");
        let plate = Plate { crater, free: false, ..Plate::new(0.0, 0.5) };
        close(depth(&text, v, "400"), quadrature(&[plate], v).0, 1e-4, "depth");
    }
}

/// A cylinder of radius A with a flat nose at z = 0, flying towards smaller z.
fn flat(target: &str, layers: &str) -> String {
    let text = deck(target, layers);
    let nodes = text.find("*Node\n").expect("nodes");
    let rest = text.find("*Nset, nset=REF").expect("sets");
    let elements = text.find("*Element, type=RAX2").expect("elements");
    let mass = text.find("*Element, type=MASS").expect("a mass");
    let mesh = "*Node\n 1, 0., 0.\n 2, <a>, 0.\n 3, <a>, 0.02\n 9999, 0., 0.02\n";
    let rax2 = "*Element, type=RAX2, elset=NOSE\n 1, 1, 2\n 2, 2, 3\n";
    [&text[..nodes], mesh, &text[rest..elements], rax2, &text[mass..]].concat()
}

/// In the crater m V V' = -(z/h) (alpha + beta V^2) with B = 0: V^2 + alpha/beta falls by exp(-beta z^2/(m h)).
#[test]
fn a_flat_nose_in_a_crater_in_closed_form() {
    let area = PI * A * A;
    let (alpha, beta) = (area * TERMS[0] * Y, area * TERMS[2] * RHO);
    let (v, crater) = (600.0f64, 0.01);
    let (_, memory) = common::run(
        &flat(&format!(", crater={crater}"), " AL6061, 0.5\n").replace("number interval=200", "number interval=2000"),
        &[("V", "600"), ("C", "0.9402")],
        &Routines::none(),
    );
    let rows: Vec<&Vec<f64>> = memory.rows.iter().map(|row| &row.1).filter(|row| -row[0] < crater).collect();
    assert!(rows.len() > 10);
    for row in rows {
        let z = -row[0];
        let square = (v * v + alpha / beta) * (-beta * z * z / (MASS * crater)).exp() - alpha / beta;
        close(-row[1], square.sqrt(), 1e-6, "velocity in the crater");
    }
}

/// Where shearing 2 pi a h tau takes less than the cavity, the plug goes: m V^2/2 falls by the area below the lesser force.
#[test]
fn a_flat_nose_shears_a_plug_in_closed_form() {
    let (thickness, tau, v) = (0.008, 400e6, 300.0f64);
    let area = PI * A * A;
    // A alone: the force of the cavity does not depend on velocity.
    let cavity = area * TERMS[0] * Y;
    let plug = 2.0 * PI * A * tau;
    // The way that is left when shearing becomes cheaper.
    let left = (cavity / plug).min(thickness);
    let work = cavity * (thickness - left) + 0.5 * plug * left * left;
    let exact = (v * v - 2.0 * work / MASS).sqrt();
    let text = flat(&format!(", shear strength={tau}"), &format!(" AL6061, {thickness}\n"));
    let (outcome, _) = common::run(&text, &[("V", "300"), ("C", "0")], &Routines::none());
    close(-outcome.exits.first().expect("it goes through").velocity, exact, 1e-5, "residual velocity");
    assert!(outcome.energy.drift < 1e-5, "{}", outcome.energy.drift);
    assert!(0.002 < left && left < thickness, "both ways of failing take part: {left}");
}

/// With a strength that no plug reaches nothing changes; a pointed nose is helped less by plugging than a flat one.
#[test]
fn a_plug_goes_only_where_it_is_cheaper() {
    let layers = " AL6061, 0.008\n";
    let strong = residual(&deck(", shear strength=1e15", layers), 300.0, "40");
    close(strong, residual(&deck("", layers), 300.0, "40"), 1e-9, "a plug that nothing shears out");
    let gain = |make: fn(&str, &str) -> String| {
        let lost = |target: &str| 300.0 * 300.0 - residual(&make(target, layers), 300.0, "40").powi(2);
        1.0 - lost(", shear strength=300e6") / lost("")
    };
    let (flat, pointed) = (gain(flat), gain(deck));
    assert!(pointed > 0.0 && flat > 2.0 * pointed, "work saved: flat {flat}, pointed {pointed}");
}

/// A flare behind a neck: with separation only what is wider than the shoulder ahead of it bears.
#[test]
fn a_flare_bears_where_it_is_wider_than_the_tunnel() {
    let with = |target: &str, points: &[[f64; 2]]| {
        let text = flat(target, " AL6061, 0.5\n");
        let list = |p: (usize, &[f64; 2])| format!(" {}, {}, {}\n", p.0 + 1, p.1[0], p.1[1]);
        let nodes: String = points.iter().enumerate().map(list).collect();
        let elements: String = (1..points.len()).map(|i| format!(" {i}, {i}, {}\n", i + 1)).collect();
        let text = text.replace(" 1, 0., 0.\n 2, <a>, 0.\n 3, <a>, 0.02\n", &nodes);
        text.replace(" 1, 1, 2\n 2, 2, 3\n", &elements)
    };
    let necked = [[0.0, 0.0], [0.003, 0.003], [0.002, 0.004], [0.002, 0.006], [0.004, 0.008]];
    // The same where the flare begins at the tunnel's radius, with a step that bears nothing.
    let bare = [[0.0, 0.0], [0.003, 0.003], [0.003, 0.007], [0.004, 0.008]];
    let set = [("V", "300"), ("C", "0.9402")];
    let stop = |text: &str| -common::run(text, &set, &Routines::none()).0.rests[0].displacement;
    let separated = stop(&with(", separation", &necked));
    close(separated, stop(&with("", &bare)), 1e-5, "depth");
    assert!(separated > 1.05 * stop(&with("", &necked)), "without separation the whole flare bears");
    close(stop(&with(", separation", &bare)), stop(&with("", &bare)), 1e-9, "a body that is nowhere narrower");
}

/// A ring that is driven outwards, back, and further out. The cavity takes A Y times the volume that is opened: once, where the
/// wall stays; again on the way back out, where it does not.
#[test]
fn a_ring_that_comes_back_meets_the_wall_where_it_left_it() {
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
    close(work(", separation"), opened(10.0, 10.8), 1e-3, "with the wall left where it was");
    close(work(""), opened(10.0, 10.5) + opened(10.2, 10.8), 1e-3, "with a wall that follows");
}

/// Hard steel with a convex nose: hardly anything parts from the wall, elastic waves aside.
#[test]
fn a_hard_nose_stays_at_the_wall() {
    let text = std::fs::read_to_string(common::project("input/ogive_steel.inp")).expect("the deck");
    let stop = |target: &str| {
        let text = text.replace("direction=-1\n", &format!("direction=-1{target}\n"));
        let set = [("nn", "6"), ("ns", "10"), ("JCA", "9e9")];
        let (outcome, memory) = common::run(&text, &set, &Routines::none());
        assert_eq!(outcome.halt, None);
        assert!(outcome.energy.drift < 1e-3, "{:.2e}", outcome.energy.drift);
        memory.rows.iter().map(|row| row.1[0]).fold(0.0, f64::min)
    };
    close(stop(", separation"), stop(""), 5e-3, "depth");
}

#[test]
fn targets_that_cannot_be_are_refused_with_a_reason() {
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
        refused(&deck(target, layers), code);
    }
    let soft = deck(", free surface=ON", " AL6061, 0.1\n");
    refused(&soft.replace("*Elastic\n 68.9e9, 0.3333\n", ""), "M181");
    refused(&soft.replace("68.9e9", "400e6"), "M181");
    let steel = std::fs::read_to_string(common::project("input/ogive_steel.inp")).expect("the deck");
    refused(&steel.replace("direction=-1\n", "direction=-1, shear strength=1e8\n"), "P015");
}

fn refused(text: &str, code: &str) {
    let told = revolve::job::prepare_text("target.inp", text, &[], &Routines::none()).diagnostics;
    let codes: Vec<_> = told.iter().filter(|d| d.severity == revolve::deck::Severity::Error).map(|d| d.code).collect();
    assert_eq!(codes, [code], "{text}");
}

/// The deck of an oblique impact with bounds of its plate.
fn tilted(bounds: &str) -> String {
    let text = std::fs::read_to_string(common::project("input/oblique.inp")).expect("the deck");
    text.replace("*Density\n <rho>,\n", "*Density\n <rho>,\n*Elastic\n 68.9e9, 0.3333\n")
        // Turned about its tip, which stands where planes are turned about.
        .replace(" 9999, 0., <h>\n", " 9999, 0., 0.\n")
        .replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, accuracy=1e-6\n")
        .replace("direction=-1,", &format!("direction=-1{bounds},"))
}

/// Speed at the end, and whether the body had six degrees of freedom.
fn speed(text: &str, settings: &[(&str, &str)]) -> (f64, bool) {
    let set: Vec<_> = settings.iter().copied().chain([("stations", "32"), ("n", "60")]).collect();
    let prepared = common::prepared(text, &set, &Routines::none());
    let mut memory = common::Memory::default();
    let (outcome, _) = revolve::solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    assert_eq!(outcome.halt, None);
    assert!(outcome.energy.drift < 1e-4, "{:.2e}", outcome.energy.drift);
    let last = &memory.rows.last().expect("rows").1;
    let named =
        prepared.plan.columns.iter().zip(last).filter(|c| ["V1@REF", "V2@REF", "V3@REF"].contains(&c.0.name.as_str()));
    (named.map(|(_, v)| v * v).sum::<f64>().sqrt(), !outcome.penetrations.is_empty())
}

/// In a target that is tilted by next to nothing the stations of a body with six degrees of freedom feel what facets feel.
#[test]
fn a_tilted_target_has_the_same_free_surfaces() {
    for (bounds, v) in
        [(", free surface=ON", "600"), (", free surface=ON, radius=0.012", "600"), (", crater=0.01", "700")]
    {
        let end = |obliquity: &str| speed(&tilted(bounds), &[("V", v), ("obliquity", obliquity)]);
        let ((level, none), (tilted, one)) = (end("0"), end("1e-6"));
        assert_eq!([none, one], [false, true]);
        close(tilted, level, 1e-3, bounds);
    }
}

/// A projectile whose axis leans by 20 degrees flies along the normal of a level plate; the same with projectile upright, plate
/// and velocity leaning. Free surfaces lean with the plate, its lateral face too.
#[test]
fn turning_the_scene_turns_the_answer() {
    let bounds = ", free surface=ON, radius=0.05";
    let leaning = speed(&tilted(bounds), &[("V", "700"), ("obliquity", "0"), ("yaw", "20")]).0;
    let (sine, cosine) = 20f64.to_radians().sin_cos();
    let velocity = format!(" REF, 1, {}\n REF, 2, {}\n", 700.0 * sine, -700.0 * cosine);
    let text = tilted(bounds).replace(" REF, 2, <z1>\n", &velocity);
    let upright = speed(&text, &[("V", "700"), ("obliquity", "20")]).0;
    close(upright, leaning, 1e-6, "speed behind the plate");
    let level = speed(&tilted(""), &[("V", "700"), ("obliquity", "0"), ("yaw", "20")]).0;
    assert!(leaning > 1.01 * level, "free surfaces weaken the plate: {leaning} against {level}");
}
