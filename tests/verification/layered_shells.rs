//! Shells with layers, offset nodes and laminas (`*SHELL SECTION, COMPOSITE`, `OFFSET`; `*ELASTIC, TYPE=LAMINA`).
//!
//! Goal: stretching, bending and their coupling as in laminated plate theory; nodes away from the middle surface change
//! neither stiffness nor mass; output in the directions of layers; conservation of energy; contact at the true surfaces.
//! Source: Jones 1999, Mechanics of Composite Materials, 2nd ed., chapters 2 and 4 (reduced stiffnesses, A, B, D);
//! Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells (circular plate, edge moment on a long cylinder), with
//! D - B²/A of the section in place of D.
//! Tolerance: 1 % or less against theory without transverse shear; rounding where two sections are the same.

use crate::common::solid::{column, last, run};
use crate::contact_analytical::straight_tool;
use crate::shells::{assert_close, shell_line, smooth_amplitude, static_value, step};
use revolve::deck::{Diagnostic, Severity};
use revolve::job;
use revolve::user::Routines;

/// Reduced stiffnesses of a lamina E1 = 140, E2 = 10, G12 = 5 GPa, ν12 = 0.3 in the directions meridian and hoop, by
/// inversion of its compliance in these directions with the shear strain held at zero: an independent path to that of the
/// program, which turns the stiffness.
fn lamina_stiffness(degrees: f64) -> [f64; 3] {
    let [e1, e2, ratio, g] = [140e9, 10e9, 0.3, 5e9];
    let (c, s) = (degrees.to_radians().cos(), degrees.to_radians().sin());
    let mixed = 1.0 / g - 2.0 * ratio / e1;
    let s11 = c.powi(4) / e1 + mixed * (s * c).powi(2) + s.powi(4) / e2;
    let s22 = s.powi(4) / e1 + mixed * (s * c).powi(2) + c.powi(4) / e2;
    let s12 = (1.0 / e1 + 1.0 / e2 - 1.0 / g) * (s * c).powi(2) - ratio / e1 * (s.powi(4) + c.powi(4));
    let (p, q) = (2.0 / e1 + 2.0 * ratio / e1 - 1.0 / g, 2.0 / e2 + 2.0 * ratio / e1 - 1.0 / g);
    let s16 = p * s * c.powi(3) - q * s.powi(3) * c;
    let s26 = p * s.powi(3) * c - q * s * c.powi(3);
    let s66 = 2.0 * (2.0 / e1 + 2.0 / e2 + 4.0 * ratio / e1 - 1.0 / g) * (s * c).powi(2) + (s.powi(4) + c.powi(4)) / g;
    // Cramer's rule for the inverse of the symmetric compliance.
    let determinant = s11 * (s22 * s66 - s26 * s26) - s12 * (s12 * s66 - s26 * s16) + s16 * (s12 * s26 - s22 * s16);
    [
        (s22 * s66 - s26 * s26) / determinant,
        (s16 * s26 - s12 * s66) / determinant,
        (s11 * s66 - s16 * s16) / determinant,
    ]
}

const LAMINA: &str =
    "*Material, name=CARBON\n*Density\n 1600.,\n*Elastic, type=LAMINA\n 140.e9, 10.e9, 0.3, 5.e9, 5.e9, 3.e9\n";

/// Returns a card of a composite section with layers of the lamina.
fn laminate(layers: &[(f64, f64)]) -> String {
    let lines: String = layers.iter().map(|(thickness, angle)| format!(" {thickness}, 3, CARBON, {angle}\n")).collect();
    format!("*Shell section, elset=SHELL, composite\n{lines}")
}

/// Radius of the cylinder, and internal pressure.
const CYLINDER: (f64, f64) = (0.1, 1e4);

/// Returns axial strain and hoop strain of a free cylinder under internal pressure, for layers of the lamina.
fn cylinder_strains(layers: &[(f64, f64)]) -> [f64; 2] {
    let mut a = [0.0; 3];
    for (thickness, angle) in layers {
        lamina_stiffness(*angle).iter().zip(&mut a).for_each(|(q, sum)| *sum += q * thickness);
    }
    let (determinant, (radius, p)) = (a[0] * a[2] - a[1] * a[1], CYLINDER);
    [-a[1], a[0]].map(|factor| p * radius * factor / determinant)
}

/// Returns the deck of a free cylinder under internal pressure with this section.
fn pressed_cylinder(section: &str) -> String {
    let places: Vec<[f64; 2]> = (0..=4).map(|i| [CYLINDER.0, 0.005 * f64::from(i)]).collect();
    shell_line(&places, section, "")
        + LAMINA
        + "*Boundary\n A, YSYMM\n B, 6\n"
        + &smooth_amplitude(4e-3)
        + &step(
            5e-3,
            // The normal of a cylinder whose elements run upward points inward.
            &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {:e}\n", -CYLINDER.1),
            "*Node output, nset=B\n U1, U2\n*Element output, elset=E1\n S, S_SPOS, S_SNEG, SE, SF, LE\n*Energy output\n ETOTAL, ALLWK\n",
        )
}

/// Orientations of the section and of layers give the strains of laminate theory for the resulting angles, and the rows of
/// layers with these angles: rotations about the normal after projection, the hoop as direction 1, points with an origin.
#[test]
fn orientations_of_layers_match_laminate_theory() {
    let along = |name: &str, line: &str| format!("*Orientation, name={name}\n 0., 1., 0., -1., 0., 0.\n{line}");
    let section = |more: &str, angles: [&str; 4]| {
        let lines: String = angles.iter().map(|angle| format!(" 5e-4, 3, CARBON, {angle}\n")).collect();
        format!("*Shell section, elset=SHELL, composite{more}\n{lines}")
    };
    let moved = "*Orientation, name=ORI-2, system=RECTANGULAR\n 5., 8., 0., 4., 7., 0., 5., 7., 0.\n 3, -30.\n";
    let decks = [
        along("SKIN", " 3, 30.\n") + &section(", orientation=SKIN", ["0.", "-60.", "-60.", ""]),
        along("A", " 3, 30.\n") + moved + &section("", ["A", "ORI-2", "ORI-2", "A"]),
        // Direction 1 is the hoop before the rotation by -60 degrees.
        along("HOOP", " 2, -60.\n") + &section("", ["HOOP", "-30.", "-30.", "HOOP"]),
        "*Orientation, name=UP\n 1., 0., 0., 0., 1., 0.\n 1, 30.\n".to_owned()
            + &section(", orientation=UP", ["", "-60.", "-60.", "0."]),
    ];
    let angles = [30.0, -30.0, -30.0, 30.0].map(|angle| (5e-4, angle));
    let [axial, hoop] = cylinder_strains(&angles);
    let (_, expected) = run(&pressed_cylinder(&laminate(&angles)));
    for cards in decks {
        let text = pressed_cylinder(&cards);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let value = |name: &str| static_value(&text, &memory, name);
        assert_close("radius", value("U1@B") / CYLINDER.0, hoop, 1e-3);
        assert_close("length", value("U2@B") / 0.02, axial, 2e-3);
        assert_eq!(memory.rows.last(), expected.rows.last(), "{cards}");
    }
    for (cards, part) in [
        // The default projects direction 2, which is normal to the cylinder.
        (along("SKIN", "") + &section(", orientation=SKIN", [""; 4]), "no direction along shell element"),
        (along("SKIN", " 4, 30.\n") + &section(", orientation=SKIN", [""; 4]), "is 1, 2 or 3, found 4"),
        (section("", ["MISSING", "", "", ""]), "there is no orientation `MISSING`"),
        ("*Orientation, name=A\n 0., 1., 1., 1., 0., 0.\n".to_owned() + &section("", ["A"; 4]), "span the r-z plane"),
        (along("A", "").replace("name=A", "name=A, system=CYLINDRICAL") + &section("", ["A"; 4]), "SYSTEM=RECTANGULAR"),
    ] {
        let prepared = job::prepare_text("test.inp", &pressed_cylinder(&cards), &[], &Routines::none());
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(prepared.diagnostics.has_errors() && text.contains(part), "{cards}{text}");
    }
}

/// Free cylinders under internal pressure: hoop strain p R A11 / (A11 A22 - A12²), stress of each layer from the strains.
#[test]
fn laminated_cylinder_under_pressure_matches_laminate_theory() {
    let (radius, p) = CYLINDER;
    for layers in [
        &[(1e-3, 0.0)][..],
        &[(1e-3, 90.0)],
        &[(5e-4, 0.0), (5e-4, 90.0), (5e-4, 90.0), (5e-4, 0.0)],
        &[(5e-4, 30.0), (5e-4, -30.0), (5e-4, -30.0), (5e-4, 30.0)],
    ] {
        let [axial, hoop] = cylinder_strains(layers);
        let text = pressed_cylinder(&laminate(layers));
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let value = |name: &str| static_value(&text, &memory, name);
        assert_close("radius", value("U1@B") / radius, hoop, 1e-3);
        assert_close("length", value("U2@B") / 0.02, axial, 2e-3);
        assert_close("hoop force", value("SF2@E1"), p * radius, 1e-3);
        assert!(last(&text, &memory, "ETOTAL").abs() < 1e-9 * last(&text, &memory, "ALLWK"));
        // Stress along the fibres of the outermost layers, from the strains in their directions.
        let angle = layers[0].1.to_radians();
        let (c, s) = (angle.cos(), angle.sin());
        let [along, across] = [c * c * axial + s * s * hoop, s * s * axial + c * c * hoop];
        let reduced = lamina_stiffness(0.0);
        for name in ["S11_SNEG@E1", "S11_SPOS@E1"] {
            let expected = reduced[0] * along + reduced[1] * across;
            assert!((value(name) - expected).abs() < 1e-3 * 140e9 * hoop, "{name}: {} {expected}", value(name));
        }
        // The shear stress in the layer of the middle point is G12 times its shear strain.
        let middle = layers[layers.len() / 2].1.to_radians();
        let shear = 2.0 * middle.sin() * middle.cos() * (hoop - axial);
        let found = [value("S12@E1") / 5e9, value("LE12@E1")];
        assert!(found.iter().all(|f| (f - shear).abs() < 3e-3 * hoop), "{found:?} {shear}");
    }
}

const BIMETAL: &str = "*Material, name=SOFT\n*Density\n 2700.,\n*Elastic\n 70.e9, 0.3\n";

/// Returns membrane stiffness, coupling and bending stiffness of two layers with ν = 0.3 about a height.
fn two_layers(moduli: [f64; 2], thickness: [f64; 2], reference: f64) -> [f64; 3] {
    let total = thickness[0] + thickness[1];
    let bounds = [-0.5 * total, thickness[0] - 0.5 * total, 0.5 * total].map(|z| z - reference);
    let mut sums = [0.0; 3];
    for layer in 0..2 {
        for (power, sum) in sums.iter_mut().enumerate() {
            let exponent = power as i32 + 1;
            let range = bounds[layer + 1].powi(exponent) - bounds[layer].powi(exponent);
            *sum += moduli[layer] / (1.0 - 0.09) * range / f64::from(exponent);
        }
    }
    sums
}

fn plate(n: usize, section: &str, materials: &str, cards: &str) -> String {
    let places: Vec<[f64; 2]> = (0..=n).map(|i| [0.1 * i as f64 / n as f64, 0.0]).collect();
    shell_line(&places, section, "") + materials + "*Boundary\n A, XSYMM\n B, ENCASTRE\n" + cards
}

/// Clamped plate of steel on aluminium under pressure: w = p a⁴ / (64 (D - B²/A)), wherever the nodes are. With clamped
/// edges no force in the plane acts. Transverse shear adds less than 0.3 %.
#[test]
fn bimetal_plate_deflection_matches_theory_for_any_offset() {
    let (a, p) = (0.1_f64, 100.0);
    let [membrane, coupling, bending] = two_layers([70e9, 200e9], [1.2e-3, 8e-4], 0.0);
    let expected = p * a.powi(4) / (64.0 * (bending - coupling * coupling / membrane));
    let loads = smooth_amplitude(0.02)
        + &step(
            0.03,
            &format!("*Dload, amplitude=SLOWLY\n SHELL, P, {p}\n"),
            "*Node output, nset=A\n U2\n*Element output, elset=E1\n SM, SF\n*Energy output\n ETOTAL, ALLWK\n",
        );
    let deflection = |offset: &str| {
        let section = format!("*Shell section, elset=SHELL, composite{offset}\n 1.2e-3, 3, SOFT\n 8.e-4, 5, M\n");
        let text = plate(40, &section, BIMETAL, &loads);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        assert!(last(&text, &memory, "ETOTAL").abs() < 1e-9 * last(&text, &memory, "ALLWK"));
        static_value(&text, &memory, "U2@A")
    };
    let centred = deflection("");
    assert_close("deflection", centred, expected, 5e-3);
    for offset in [", offset=SPOS", ", offset=SNEG", ", offset=0.2"] {
        assert_close(offset, deflection(offset), centred, 1e-3);
    }
}

/// A long cylinder pulled along its nodes, which are off the middle surface by e: the eccentric force N is a moment N e on
/// the edge, and the edge moves by N e / (2 β² D).
#[test]
fn eccentric_pull_bends_the_edge_of_a_cylinder() {
    // The force is small: tension stiffens the edge, by 6 % at 1e4 N/m.
    let (radius, thickness, force) = (0.1, 5e-4, 1e2);
    let modulus: f64 = 200e9;
    let bending = modulus * thickness * thickness * thickness / (12.0 * 0.91);
    let beta = (3.0_f64 * 0.91).powf(0.25) / (radius * thickness).sqrt();
    let of = |offset: &str| {
        let places: Vec<[f64; 2]> = (0..=80).map(|i| [radius, 5e-4 * f64::from(i)]).collect();
        let section = format!("*Shell section, elset=SHELL, material=M{offset}\n {thickness}, 5\n");
        let text = shell_line(&places, &section, "")
            + "*Boundary\n A, YSYMM\n"
            + &smooth_amplitude(3e-3)
            + &step(
                4e-3,
                &format!("*Cload, amplitude=SLOWLY\n B, 2, {:e}\n", 2.0 * std::f64::consts::PI * radius * force),
                "*Node output, nset=B\n U1\n",
            );
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        static_value(&text, &memory, "U1@B")
    };
    let middle = of("");
    assert_close("contraction", middle, -0.3 * force / (modulus * thickness) * radius, 1e-2);
    let expected = force * 0.5 * thickness / (2.0 * beta * beta * bending);
    // The normal points inward. Nodes at SPOS are inside of the middle surface, and the moment turns the edge outward.
    assert_close("inner nodes", of(", offset=SPOS") - middle, expected, 5e-3);
    assert_close("outer nodes", of(", offset=SNEG") - middle, -expected, 5e-3);
}

/// A section of layers of one material is the uniform section, also with plastic flow, heat of its own points, and SYMMETRIC.
#[test]
fn layers_of_one_material_behave_as_one() {
    let flows = "*Plastic\n 24.e6, 0.\n 234.e6, 0.2\n";
    let history = |section: &str| {
        let places: Vec<[f64; 2]> = (0..=20).map(|i| [0.1, 1e-3 * f64::from(i)]).collect();
        let text = shell_line(&places, section, flows)
            + "*Boundary\n A, YSYMM\n"
            + &step(
                2e-4,
                "*Dload\n SHELL, P, -2.e6\n",
                "*Node output, nset=B\n U1\n*Element output, elset=E1\n PEEQ, SF\n*Energy output\n ETOTAL, ALLPD, ALLWK\n",
            );
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        assert!(outcome.energy.plastic > 0.0);
        // The sudden load causes a drift of 2e-8 with any section.
        assert!(last(&text, &memory, "ETOTAL").abs() < 1e-7 * last(&text, &memory, "ALLWK"));
        ["U1@B", "PEEQ@E1", "SF2@E1", "ALLPD"].map(|name| last(&text, &memory, name))
    };
    let uniform = history("*Shell section, elset=SHELL, material=M\n 2.e-3, 5\n");
    for section in [
        "*Shell section, elset=SHELL, composite\n 5.e-4, 3, M\n 1.e-3, 5, M\n 5.e-4, 3, M\n",
        "*Shell section, elset=SHELL, composite, symmetric\n 5.e-4, 3, M\n 5.e-4, , M\n",
    ] {
        for (layered, uniform) in history(section).into_iter().zip(uniform) {
            assert_close(section, layered, uniform, 1e-9);
        }
    }
}

/// SYMMETRIC repeats the layers in reverse order: bending does not move a simply supported edge in the plane, as it does
/// with two different layers, by B/A times its rotation.
#[test]
fn symmetric_layers_do_not_couple() {
    let edge = |section: &str| {
        let loads = smooth_amplitude(0.02)
            + &step(0.03, "*Dload, amplitude=SLOWLY\n SHELL, P, 1.\n", "*Node output, nset=B\n U1, UR3\n");
        let text = plate(20, section, BIMETAL, &loads).replace(" B, ENCASTRE", " B, 2");
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        ["U1@B", "UR3@B"].map(|name| static_value(&text, &memory, name))
    };
    let [coupled, turned] = edge("*Shell section, elset=SHELL, composite\n 1.e-3, 3, SOFT\n 1.e-3, 3, M\n");
    let [membrane, coupling, _] = two_layers([70e9, 200e9], [1e-3, 1e-3], 0.0);
    // A counter-clockwise rotation gives the curvature of the meridian -w'.
    assert_close("coupled", coupled, coupling / membrane * turned, 1e-2);
    let [symmetric, _] = edge("*Shell section, elset=SHELL, composite, symmetric\n 5.e-4, 3, SOFT\n 5.e-4, 3, M\n");
    assert!(symmetric.abs() < 1e-3 * coupled.abs(), "{symmetric} {coupled}");
}

/// Frequencies of a clamped plate do not depend on the offset of its nodes beyond the added rotary inertia, and the stable
/// increment holds: without damping the energy stays constant over many periods.
#[test]
fn offset_plate_keeps_its_frequency() {
    let crossings = |offset: &str| {
        let section = format!("*Shell section, elset=SHELL, material=M{offset}\n 2.e-3, 5\n");
        let cards = step(
            0.02,
            "*Bulk viscosity\n 0., 0.\n*Dload\n SHELL, P, 100.\n",
            "*Node output, nset=A\n U2\n*Energy output\n ETOTAL, ALLWK, ALLIE\n",
        );
        let text = plate(20, &section, "", &cards);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        // The sudden load causes a drift of 1e-7 with any section.
        assert!(outcome.energy.drift < 5e-7, "{:e}", outcome.energy.drift);
        let rows = column(&text, &memory, "U2@A");
        let mean = rows.iter().map(|r| r.1).sum::<f64>() / rows.len() as f64;
        let rises: Vec<f64> = rows
            .windows(2)
            .filter(|w| w[0].1 <= mean && w[1].1 > mean)
            .map(|w| w[0].0 + (w[1].0 - w[0].0) * (mean - w[0].1) / (w[1].1 - w[0].1))
            .collect();
        (rises.len() - 1) as f64 / (rises[rises.len() - 1] - rises[0])
    };
    let centred = crossings("");
    for offset in [", offset=SPOS", ", offset=-0.5"] {
        assert_close(offset, crossings(offset), centred, 1e-2);
    }
}

/// A shell of thickness 0.05 touches an analytical plane at the distance of its surface SNEG from its nodes: none, the whole
/// thickness, and half of it.
#[test]
fn contact_is_at_the_surfaces_of_an_offset_shell() {
    for (offset, way) in [("SNEG", 0.1), ("SPOS", 0.05), ("0.", 0.075)] {
        let deck = format!(
            "*Node, nset=ALL\n 1, 0., 0.1\n 2, 0.5, 0.1\n 3, 1., 0.1\n*Element, type=SAX1, elset=SHELL\n 1, 1, 2\n 2, 2, 3\n\
             *Surface, name=UNDER\n SHELL, SNEG\n*Shell Section, elset=SHELL, composite, offset={offset}\n 0.02, 3, M\n 0.03, 3, M\n\
             *Material, name=M\n*Density\n 1.,\n*Elastic\n 1., 0.3\n"
        ) + &straight_tool(true, [[0.0, 0.0], [2.0, 0.0]], 1)
            + "*Nset, nset=RIM\n 3\n*Surface Interaction, name=DRY\n*Initial Conditions, type=VELOCITY\n ALL, 2, -0.1\n\
               *Step\n*Dynamic, Explicit\n , 1.5\n*Boundary\n REF, 2, 2\n 1, 1, 1\n 1, 6, 6\n*Contact Pair, interaction=DRY\n UNDER, TOOL\n\
               *Output, history, number interval=10\n*Node Output, nset=RIM\n U2\n*End Step\n";
        let (outcome, memory) = run(&deck);
        assert_eq!(outcome.halt, None);
        let fallen = -last(&deck, &memory, "U2@RIM");
        assert!((fallen - way).abs() < 1e-12, "{offset} {fallen}");
    }
}

/// Returns the codes of the errors and warnings of a plate.
fn codes(section: &str, materials: &str) -> Vec<&'static str> {
    let text = plate(2, section, materials, &step(1e-6, "", "*Energy output\n ALLKE\n"));
    let prepared = job::prepare_text("layers.inp", &text, &[], &Routines::none());
    let is_finding = |d: &&Diagnostic| d.severity != Severity::Note;
    prepared.diagnostics.iter().filter(is_finding).map(|d| d.code).collect()
}

#[test]
fn invalid_layers_are_reported() {
    let layered = "*Shell section, elset=SHELL, composite\n 1.e-3, 3, CARBON, 0.\n";
    assert_eq!(codes(layered, LAMINA), [""; 0]);
    assert_eq!(codes(&laminate(&[(1e-3, 30.0), (1e-3, -30.0)]), LAMINA), [""; 0]);
    for (section, materials, code) in [
        // Layers that resist twist.
        (layered.replace("CARBON, 0.", "CARBON, 30."), LAMINA.into(), "P129"),
        (layered.replace("composite", "composite, material=M"), LAMINA.into(), "M103"),
        (layered.replace("CARBON", "NONE"), LAMINA.into(), "M111"),
        (layered.replace("composite", "composite, poisson=ELASTIC"), LAMINA.into(), "P023"),
        (layered.into(), format!("{LAMINA}*Plastic\n 1.e9, 0.\n"), "P023"),
        (layered.into(), LAMINA.replace("0.3, 5", "4., 5"), "M103"),
        (layered.replace("1.e-3, 3", "1.e-3, 4"), LAMINA.into(), "M103"),
        ("*Shell section, elset=SHELL, material=M, symmetric\n 1.e-3, 5\n".into(), String::new(), "M103"),
    ] {
        assert!(codes(&section, &materials).contains(&code), "{section}: {:?}", codes(&section, &materials));
    }
}
