//! `revolve mesh`: shapes, quality, sets and surfaces, invalid requests, and runs of the written decks. Volumes are
//! compared with closed forms of bodies of revolution.

use std::f64::consts::PI;

use revolve::generate::{
    CaseCavity, CavityFill, DeckLabels, MeshMeasure, MeshRequest, NoseShape, ProjectileMesh, RectangleMesh,
    RectangleRequest,
};
use revolve::job;
use revolve::user::Routines;

use crate::common::{self, revolve};

fn mesh_request(nose: NoseShape, length: f64, size: f64) -> MeshRequest {
    MeshRequest { nose, radius: 1.0, length, size, along: 1.0, across: 1.0, cavity: None }
}

fn hollow(fill: CavityFill, through: Option<usize>, wall: f64, base: f64) -> MeshRequest {
    let cavity = Some(CaseCavity { wall, through, front: 4.0, base, fill });
    MeshRequest { cavity, ..mesh_request(NoseShape::Ogive { crh: 3.0 }, 10.0, 0.25) }
}

fn measure(mesh_request: &MeshRequest) -> MeshMeasure {
    ProjectileMesh::new(mesh_request).unwrap_or_else(|e| panic!("{mesh_request:?}: {e:?}")).measure()
}

fn refusal(mesh_request: &MeshRequest) -> &'static str {
    ProjectileMesh::new(mesh_request).expect_err("a refusal").code
}

/// Returns the diagnostics of a deck with this mesh, loaded on its whole outer surface, after running it.
fn findings(mesh_request: &MeshRequest) -> String {
    let labels = DeckLabels { first: 1001, prefix: "P_".into(), material: "STEEL".into(), fill: "SOFT".into() };
    let mesh = ProjectileMesh::new(mesh_request).expect("a mesh").deck(&labels, &["a comment".into()]);
    let text = format!(
        "{mesh}*Material, name=STEEL\n*Density\n 7800.\n*Elastic\n 2.e11, 0.3\n*Material, name=SOFT\n*Density\n 1600.\n*Elastic\n \
         1.e9, 0.3\n*Material, name=AL\n*Density\n 2700.\n*Cavity Expansion, yield=2.76e8\n 5., 1., 1.\n*Target, name=BLOCK, \
         front=0., direction=-1\n AL, 50.\n*Initial Conditions, type=VELOCITY\n P_PROJECTILE, 2, -500.\n*Step\n*Dynamic, \
         Explicit\n , 1.e-6\n*Dsload, target=BLOCK\n P_OUTER, CAVITY\n*Output, history, number interval=2\n*Node Output, \
         nset=P_TIP\n U2\n*Node Output, nset=P_BACK\n U2\n*Node Output, nset=P_RIM\n U2\n*Node Output, nset=P_SHOULDER\n \
         U1\n*End Step\n"
    );
    let prepared = job::prepare_text("made.inp", &text, &[], &Routines::none());
    // The only note allowed for a solid projectile is that of an unused material.
    let message_text = prepared.diagnostics.render(&prepared.deck.sources);
    assert!(!prepared.diagnostics.has_errors(), "{mesh_request:?}: {message_text}");
    let (outcome, _) = job::run_in_memory(&prepared);
    assert!(outcome.halt.is_none(), "{mesh_request:?}: {:?}", outcome.halt);
    message_text
}

/// The volume of an ogive in closed form (nose of radius 1: integral of pi r^2, r = c + sqrt(R^2 - x^2); plus the
/// shank). The order of the meshed volume over three halvings of the size is 2, that of a polygon inscribed in an arc,
/// within 0.3 because nodes along the flank move with the size.
#[test]
fn volumes_converge_with_order_two() {
    for (crh, length) in [(1.0, 4.0), (3.0, 6.0), (6.0, 8.0)] {
        let arc = 2.0 * crh;
        let (centre, height) = (1.0 - arc, (4.0_f64 * crh - 1.0).sqrt());
        let segment = 0.5 * (height * (arc * arc - height * height).sqrt() + arc * arc * (height / arc).asin());
        let nose = PI
            * (centre * centre * height + 2.0 * centre * segment + arc * arc * height - height * height * height / 3.0);
        let exact = nose + PI * (length - height);
        let errors = [0.4, 0.05].map(|size| {
            let mesh = ProjectileMesh::new(&mesh_request(NoseShape::Ogive { crh }, length, size)).expect("a mesh");
            let measure = mesh.measure();
            assert!((measure.case.exact / exact - 1.0).abs() < 1e-12, "{crh}");
            assert!((mesh.order().expect("an arc") - 2.0).abs() < 0.05, "{crh} {:?}", mesh.order());
            1.0 - measure.case.meshed / exact
        });
        let order = (errors[0] / errors[1]).log2() / 3.0;
        println!("CRH {crh}: errors {errors:?}, order {order:.2}");
        assert!((order - 2.0).abs() < 0.3, "{order}");
    }
    let half = measure(&mesh_request(NoseShape::Sphere, 3.0, 0.1)).case;
    assert!((half.exact / (2.0 / 3.0 * PI + 2.0 * PI) - 1.0).abs() < 1e-12 && half.error().abs() < 2e-3, "{half:?}");
    for exact in [
        NoseShape::Cone { half_angle: 20.0 },
        NoseShape::Blunt,
        NoseShape::Polyline(vec![[0.0, 0.0], [0.6, 1.0], [1.0, 3.0], [0.9, 5.0]]),
    ] {
        let made = measure(&mesh_request(exact, 5.0, 0.2)).case;
        assert_eq!(made.error(), 0.0, "{made:?}");
    }
}

/// The smallest scaled Jacobian is at least 0.8 times the sine of the sharpest corner of the profile, which is an upper
/// bound for quadrilateral meshes with a node there (at the tip, or the rim of a blunt cone); without sharp corners 0.6
/// suffices. This also holds for walls as thin as a fiftieth of the radius.
#[test]
fn element_quality_is_near_the_bound_of_the_sharpest_corner() {
    let ogive = |crh: f64| (NoseShape::Ogive { crh }, ((2.0 * crh - 1.0) / (2.0 * crh)).acos().to_degrees());
    let cone = |half_angle: f64| (NoseShape::Cone { half_angle }, f64::min(half_angle, 90.0 - half_angle));
    let shapes = [ogive(1.0), ogive(3.0), ogive(6.0), cone(10.0), cone(30.0), cone(60.0), (NoseShape::Sphere, 90.0)];
    for (nose, sharpest) in shapes {
        for size in [0.5, 0.25, 0.11] {
            let made = measure(&mesh_request(nose.clone(), 8.0, size));
            let bound = f64::min(0.8 * sharpest.to_radians().sin(), 0.6);
            println!(
                "{nose:?} {size}: {:.3} (bound {bound:.3}), aspect {:.1}",
                made.quality.jacobian.0, made.quality.aspect.0
            );
            assert!(made.quality.jacobian.0 > bound, "{nose:?} {size}: {:?} {bound}", made.quality.jacobian);
            assert!(made.quality.height.0 > 0.1 * size, "{nose:?} {size}: {:?}", made.quality.height);
        }
    }
    for wall in [0.3, 0.1, 0.02] {
        let made = measure(&hollow(CavityFill::None, None, wall, 0.5));
        assert!(made.quality.jacobian.0 > 0.8 * 33.56_f64.to_radians().sin(), "{wall}: {:?}", made.quality.jacobian);
    }
}

/// Case and fill have the volumes of the cylinder and the rest; a separate fill has its own nodes, a bonded one shares
/// them.
#[test]
fn case_and_fill_match_closed_form_volumes() {
    let whole = measure(&mesh_request(NoseShape::Ogive { crh: 3.0 }, 10.0, 0.25)).case.exact;
    let inner = PI * 0.8 * 0.8 * 5.5;
    let [none, bonded, apart] =
        [CavityFill::None, CavityFill::Bonded, CavityFill::Apart].map(|fill| measure(&hollow(fill, None, 0.2, 0.5)));
    for made in [&none, &bonded, &apart] {
        assert!((made.case.exact / (whole - inner) - 1.0).abs() < 1e-12 && made.case.error().abs() < 2e-3, "{made:?}");
    }
    assert_eq!(none.fill.exact, 0.0);
    assert!((bonded.fill.meshed / inner - 1.0).abs() < 1e-12 && (apart.fill.meshed / inner - 1.0).abs() < 1e-12);
    assert_eq!(bonded.quality.counts[1], apart.quality.counts[1]);
    assert!(none.quality.counts[0] < bonded.quality.counts[0] && bonded.quality.counts[0] < apart.quality.counts[0]);
    let three = measure(&hollow(CavityFill::None, Some(3), 0.2, 0.0));
    let five = measure(&hollow(CavityFill::None, Some(5), 0.2, 0.0));
    assert!(five.quality.counts[1] > three.quality.counts[1]);
}

/// Element sizes grow as requested: the largest aspect ratio of a cylinder is that of its last row, and with `across`
/// that of its surface.
#[test]
fn sizes_grow_along_and_across() {
    let even = measure(&mesh_request(NoseShape::Blunt, 8.0, 0.25));
    let along = measure(&MeshRequest { along: 4.0, ..mesh_request(NoseShape::Blunt, 8.0, 0.25) });
    let across = measure(&MeshRequest { across: 3.0, ..mesh_request(NoseShape::Blunt, 8.0, 0.25) });
    assert!((even.quality.aspect.0 - 1.0).abs() < 1e-9, "{:?}", even.quality.aspect);
    assert!(
        (3.0..4.0).contains(&along.quality.aspect.0) && along.quality.aspect.1[1] > 7.0,
        "{:?}",
        along.quality.aspect
    );
    assert!(across.quality.aspect.0 > 1.5 && across.quality.height.1[0] > 0.8, "{across:?}");
    assert!(along.quality.counts[1] < even.quality.counts[1] && across.quality.counts[1] == even.quality.counts[1]);
}

/// The deck of every shape has no diagnostics except for unused materials, and runs with its outer surface loaded.
#[test]
fn every_shape_runs_in_a_deck() {
    let level = NoseShape::Polyline(vec![[0.0, 0.0], [0.3, 0.0], [1.0, 2.0], [1.0, 5.0]]);
    let pointed = NoseShape::Polyline(vec![[0.0, 1.0], [0.5, 1.6], [1.0, 3.0], [1.0, 7.0], [0.8, 9.0]]);
    let shapes = [
        NoseShape::Ogive { crh: 3.0 },
        NoseShape::Sphere,
        NoseShape::Cone { half_angle: 12.0 },
        NoseShape::Blunt,
        level,
        pointed,
    ];
    for nose in shapes {
        let message_text = findings(&mesh_request(nose.clone(), 6.0, 0.4));
        assert!(!message_text.contains("warning"), "{nose:?}: {message_text}");
    }
    for (fill, base) in [
        (CavityFill::None, 0.5),
        (CavityFill::None, 0.0),
        (CavityFill::Bonded, 0.0),
        (CavityFill::Apart, 0.5),
        (CavityFill::Apart, 0.0),
    ] {
        let message_text = findings(&hollow(fill, None, 0.2, base));
        // Two unconnected parts give a warning; they need the fill APART.
        assert!(fill == CavityFill::Apart || !message_text.contains("warning"), "{fill:?} {base}: {message_text}");
    }
}

#[test]
fn invalid_shapes_are_rejected_with_a_message() {
    let ogive = mesh_request(NoseShape::Ogive { crh: 3.0 }, 10.0, 0.25);
    let profile = |points: &[[f64; 2]]| mesh_request(NoseShape::Polyline(points.to_vec()), 1.0, 0.2);
    let cavity = |wall: f64, front: f64, base: f64| {
        let cavity = Some(CaseCavity { wall, through: None, front, base, fill: CavityFill::None });
        MeshRequest { cavity, ..ogive.clone() }
    };
    let cases = [
        ("G001", MeshRequest { radius: -1.0, ..ogive.clone() }),
        ("G001", MeshRequest { size: f64::NAN, ..ogive.clone() }),
        ("G001", MeshRequest { size: 2.0, ..ogive.clone() }),
        ("G001", MeshRequest { size: 1e-4, ..ogive.clone() }),
        ("G001", MeshRequest { along: 0.0, ..ogive.clone() }),
        ("G002", mesh_request(NoseShape::Ogive { crh: 0.4 }, 10.0, 0.25)),
        ("G002", mesh_request(NoseShape::Cone { half_angle: 90.0 }, 10.0, 0.25)),
        ("G003", mesh_request(NoseShape::Ogive { crh: 3.0 }, 3.0, 0.25)),
        ("G004", profile(&[[0.0, 0.0]])),
        ("G004", profile(&[[0.0, 0.0], [1.0, 2.0], [0.5, 1.0]])),
        ("G004", profile(&[[0.0, 0.0], [1.0, 2.0], [0.0, 3.0]])),
        ("G004", profile(&[[0.0, 0.0], [0.8, 2.0], [0.5, 3.0], [1.0, 4.0]])),
        ("G004", profile(&[[0.0, 0.0], [0.5, 2.0], [1.0, 2.0], [1.0, 4.0]])),
        ("G005", cavity(1.0, 4.0, 0.5)),
        ("G005", cavity(0.2, 3.0, 0.5)),
        ("G005", cavity(0.2, 4.0, 6.5)),
    ];
    for (code, case) in cases {
        assert_eq!(refusal(&case), code, "{case:?}");
        assert!(revolve::explain::explain(code).is_some());
    }
}

/// The command: what it prints, writes and rejects; it reproduces the mesh of input/ogive_rod.inp.
#[test]
fn command_reproduces_the_stored_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = |file: &str| folder.path().join(file).to_str().expect("a name").to_owned();
    let kept = std::fs::read_to_string(common::project("input/ogive_rod_mesh.inp")).expect("the kept mesh");
    let ogive = ["mesh", "ogive", "--crh", "3", "--radius", "3.555e-3", "--length", "71.1e-3", "--size", "0.6e-3"];
    let (out, picture) = (name("rod.inp"), name("rod.svg"));
    let message_text = revolve(&[&ogive[..], &["--material", "VAR4340", "-o", &out, "--picture", &picture]].concat());
    let rendered = String::from_utf8_lossy(&message_text.stdout).into_owned();
    assert!(
        message_text.status.success()
            && rendered.contains("smallest scaled Jacobian 0.5")
            && rendered.contains("order 2.00"),
        "{rendered}"
    );
    assert_eq!(std::fs::read_to_string(&out).expect("a mesh"), kept);
    assert!(std::fs::read_to_string(&picture).expect("a picture").matches("<path").count() > 1400);
    let message_text = revolve(&[&ogive[..], &["--target-mass", "0.021", "-o", &out]].concat());
    assert!(String::from_utf8_lossy(&message_text.stdout).contains("density 8.0443"), "{message_text:?}");
    let heavy = ["--wall", "1.e-3", "--cavity-front", "20.e-3", "--fill", "bonded", "--fill-density", "1.e6"];
    let message_text = revolve(&[&ogive[..], &heavy, &["--target-mass", "0.021", "-o", &name("no.inp")]].concat());
    assert_eq!(message_text.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&message_text.stderr).contains("G007"), "{message_text:?}");
    std::fs::write(name("points.txt"), "# tip\n0, 0\n1; 2\n1 x\n").expect("a file");
    let message_text = revolve(&["mesh", "polyline", &name("points.txt"), "--size", "0.2", "-o", &name("no.inp")]);
    assert_eq!(message_text.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&message_text.stderr).contains("line 4"), "{message_text:?}");
    assert!(!folder.path().join("no.inp").exists());
}

/// `revolve mesh refine` writes a deck that gives the digest of `run --mesh-refine`; invalid input is refused.
#[test]
fn refined_decks_are_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_str().expect("a path").to_owned();
    let (deck, out) = (file("fine.inp"), file("results"));
    let digest = |arguments: &[&str]| {
        let output = revolve(&[arguments, &["--no-frames", "--json", "--out", &out]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a summary");
        summary["digest"].as_str().expect("a digest").to_owned()
    };
    let curved = ["-s", "n=10", "--curved=20"];
    let written = revolve(&[&["mesh", "refine", "input/ogive.inp", "-k", "2", "--out", &deck], &curved[..]].concat());
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let expected = digest(&[&["run", "input/ogive.inp", "--mesh-refine", "2"], &curved[..]].concat());
    assert_eq!(digest(&["run", &deck]), expected);
    for (parts, message) in [("0", "D408"), ("1/7", "M191")] {
        let refused = revolve(&["mesh", "refine", "input/ogive.inp", "-k", parts, "--out", &file("none.inp")]);
        let text = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && text.contains(message), "{text}");
    }
    assert!(!folder.path().join("none.inp").exists());
}

/// Command, arguments, and the ranges of r and z.
type Shape<'a> = (&'a str, &'a [&'a str], [f64; 2], [f64; 2]);

/// Blocks, plates, discs, rings and tubes have the volume of the body to rounding, elements of the size asked for at the
/// fine end and graded by the factor, and run in a deck that uses all their sets and surfaces.
#[test]
fn bodies_with_rectangular_sections_are_exact_and_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let shapes: [Shape; 6] = [
        ("block", &["--inner", "3", "--outer", "5.3", "--height", "1.7"], [3.0, 5.3], [0.0, 1.7]),
        ("block", &["--outer", "5", "--height", "2", "--z", "-4", "--along", "3"], [0.0, 5.0], [-4.0, -2.0]),
        ("ring", &["--inner", "1", "--outer", "2", "--height", "3", "--across", "0.25"], [1.0, 2.0], [0.0, 3.0]),
        ("plate", &["--radius", "9", "--thickness", "1.1", "--across", "8"], [0.0, 9.0], [-1.1, 0.0]),
        ("disc", &["--radius", "2", "--thickness", "3.3", "--z", "7"], [0.0, 2.0], [7.0, 10.3]),
        ("tube", &["--inner", "2", "--wall", "0.35", "--length", "4"], [2.0, 2.35], [0.0, 4.0]),
    ];
    for (n, (shape, dimensions, [inner, outer], [bottom, top])) in shapes.into_iter().enumerate() {
        let mesh = folder.path().join(format!("{n}.inp"));
        let out = mesh.to_str().expect("a name");
        let more = ["--size", "0.1", "--first", "101", "--name", "P", "--density", "2", "-o", out];
        let made = revolve(&[&["mesh", shape], dimensions, &more[..]].concat());
        let (shown, errors) = (String::from_utf8_lossy(&made.stdout), String::from_utf8_lossy(&made.stderr));
        assert!(made.status.success(), "{shape}: {errors}");
        let exact = PI * (outer * outer - inner * inner) * (top - bottom);
        let mass = shown.split("mass ").nth(1).and_then(|rest| rest.split(' ').next()?.parse::<f64>().ok());
        assert!(
            mass.is_some_and(|mass| (mass / (2.0 * exact) - 1.0).abs() < 1e-6) && shown.contains(", exact"),
            "{shown}"
        );
        let left = if inner > 0.0 { "INNER" } else { "AXIS" };
        let inside = if inner > 0.0 { "*Dsload\n P_INNER, P, 1.\n" } else { "" };
        let text = format!(
            "*Include, input={n}.inp\n*Material, name=STEEL\n*Density\n 2.,\n*Elastic\n 100., 0.3\n*Boundary\n P_{left}, 1, 1\n\
             P_BOTTOM, 2, 2\n*Step\n*Dynamic, Explicit\n , 1e-3\n*Dsload\n P_TOP, P, 1.\n P_RIM, P, 1.\n P_OUTER, P, 1.\n{inside}\
             *Output, history, number interval=1\n*Node Output, nset=P_RIM\n U1\n*Node Output, nset=P_TOP\n U2\n*End Step\n"
        );
        let deck = folder.path().join(format!("deck{n}.inp"));
        std::fs::write(&deck, text).expect("a deck");
        let results = folder.path().join(format!("out{n}"));
        let options = ["run", deck.to_str().expect("a name"), "-q", "-o", results.to_str().expect("a name")];
        let output = revolve(&options);
        assert!(output.status.success(), "{shape}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let refused = revolve(&["mesh", "ring", "--outer", "2", "--height", "1", "--size", "0.1"]);
    assert!(!refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("G001"));
}

/// Graded widths and heights: the smallest has the size or up to half of it less, the ratio of the outer ones is the factor.
#[test]
fn rectangular_sections_are_graded_from_the_smallest_size() {
    let request = RectangleRequest { radii: [1.0, 9.0], bottom: -2.0, height: 6.0, size: 0.1, across: 5.0, along: 0.2 };
    let mesh = RectangleMesh::new(&request).expect("a mesh");
    let [nodes, elements] = mesh.quality().counts;
    // Progressions from 0.1 to 0.5 with the sums 8 and 6: mean size 0.4/ln 5 = 0.2485.
    let [columns, rows] = [8.0_f64, 6.0].map(|length| (length / 0.248_534).ceil());
    assert_eq!((nodes, elements), (((columns + 1.0) * (rows + 1.0)) as usize, (columns * rows) as usize));
    let height = mesh.quality().height.0;
    assert!((0.08..=0.1001).contains(&height), "{height}");
    assert!((mesh.volume().meshed / (PI * 80.0 * 6.0) - 1.0).abs() < 1e-12);
    for wrong in [
        RectangleRequest { size: 0.0, ..request },
        RectangleRequest { radii: [2.0, 2.0], ..request },
        RectangleRequest { radii: [-1.0, 2.0], ..request },
        RectangleRequest { across: f64::NAN, ..request },
        RectangleRequest { size: 1e-6, ..request },
    ] {
        assert_eq!(RectangleMesh::new(&wrong).expect_err("a refusal").code, "G001", "{wrong:?}");
    }
}
