//! Studies that leave out one effect at a time.
//!
//! Goal: leaving out an effect gives the bits of a deck without its card; known results without the effect are
//! reproduced; an effect below the error estimate is reported as such. Source: the same decks without the card; closed
//! forms (`verification/rigid.rs`).

use std::f64::consts::PI;

use revolve::deck;
use revolve::job::ParameterOverrides;
use revolve::model;
use revolve::study::effects::{self, AblatedEffect, EffectAblation};
use revolve::study::quantity::Quantity;
use revolve::study::refinement;
use revolve::study::runner::StudyRunner;
use revolve::study::settings;

use crate::common;
use crate::common::solid::{grid, material};

fn left_out(text: &str, refine: &str, quantity: &str) -> EffectAblation {
    let source = |overrides: &ParameterOverrides| deck::read_text("case.inp", text, overrides);
    let measure = Quantity::parse(quantity).expect("a quantity");
    let (read, _) = source(&[]);
    let parameters: Vec<String> = read.parameters.iter().map(|p| p.0.clone()).collect();
    let axes = settings::axes(&[refine.to_owned()], &parameters).expect("levels");
    let mut bench = StudyRunner::new(&source, &[], None, &measure, 1, &|| {});
    effects::leave_out(&mut bench, &axes, &model::build(&read).0).expect("effects")
}

fn find<'a>(effects: &'a EffectAblation, name: &str) -> &'a AblatedEffect {
    let names: Vec<&str> = effects.effects.iter().map(|e| e.effect.as_str()).collect();
    effects.effects.iter().find(|e| e.effect == name).unwrap_or_else(|| panic!("no {name} among {names:?}"))
}

#[test]
fn effects_of_a_rigid_shot_match_closed_forms() {
    let text = common::ogive()
        .replace("friction = 0.", "friction = 0.05")
        .replace("*Output, field", "*Dload\n , GRAV, 9.81, 0., -1.\n*Output, field");
    let effects = left_out(&text, "n=20,40", "-final(U2@REF)");
    effects.conclusions().iter().for_each(|line| println!("{line}"));
    // Without friction: quadrature of the entry integrals; gravity adds g t^2 / 2, less than a thousandth.
    let frictionless = find(&effects, "friction").value.expect("a value");
    assert!((frictionless / 64.8475307e-3 - 1.0).abs() < 1e-3, "{frictionless}");
    assert!(find(&effects, "friction").matters && find(&effects, "entry phase").matters);
    let gravity = find(&effects, "gravity");
    let fall = 0.5 * 9.81 * 2e-4_f64 * 2e-4;
    let change = gravity.change.expect("a change").abs();
    assert!(!gravity.matters && change > 0.2 * fall && change < 2.0 * fall, "{change:e} {fall:e}");
    assert!(effects.conclusions().iter().any(|l| l.starts_with("warning: gravity changes the quantity by less")));

    let smooth = left_out(&common::ogive(), "n=20,40", "-final(U2@REF)");
    // Embedded from the start: the closed form.
    let embedded = find(&smooth, "entry phase").value.expect("a value");
    assert!((embedded / 59.612643939e-3 - 1.0).abs() < 1e-3, "{embedded}");
    assert!(smooth.effects.iter().all(|e| e.effect != "friction" && e.effect != "gravity"), "only existing effects");
    // Static resistance only: m V^2 / 2 over pi a^2 A Y, with the entry phase; without it, by hand.
    let embedded = common::ogive().replace("front = 0.", "front = 0.1");
    let without = left_out(&embedded, "n=20,40", "-final(U2@REF)");
    let depth = find(&without, "resistance quadratic in velocity").value.expect("a value");
    let area = PI * 3.555e-3 * 3.555e-3;
    let expected = 0.5 * 0.021 * 569.0 * 569.0 / (area * 5.0394 * 276e6);
    assert!((depth / expected - 1.0).abs() < 1e-3, "{depth} {expected}");
}

#[test]
fn omitted_layer_is_replaced_by_its_neighbour() {
    let materials = "*Material, name=TWIN\n*Density\n 2710.,\n*Cavity Expansion, yield=276.e6\n 5.0394, 0., 0.9830\n\
        *Material, name=HARD\n*Density\n 7850.,\n*Cavity Expansion, yield=600.e6\n 4.2, 0.5, 1.1\n*Target";
    let stack = |layers: &str| common::ogive().replace("*Target", materials).replace(" AL6061, 0.5\n", layers);
    let effects = left_out(&stack(" AL6061, 0.02\n TWIN, 0.01\n HARD, 0.5\n"), "n=20,40", "-final(U2@REF)");
    effects.conclusions().iter().for_each(|line| println!("{line}"));
    assert_eq!(find(&effects, "layer 1 of BLOCK").change, Some(0.0), "its neighbour has the same law");
    assert!(!find(&effects, "layer 2 of BLOCK").matters);
    let soft = find(&effects, "layer 3 of BLOCK");
    let alone = left_out(&common::ogive().replace("AL6061, 0.5", "AL6061, 0.53"), "n=20,40", "-final(U2@REF)");
    // Increments end at the planes between layers; the error is that of the requested accuracy, 1e-4.
    assert!(soft.matters && (soft.value.expect("a value") / alone.value - 1.0).abs() < 1e-5, "{soft:?}");
}

/// Returns a hot, compressed bar of Johnson-Cook material with all terms of the law.
fn bar(plastic: &str, dynamic: &str, more: &str) -> String {
    grid(3, 6, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64])
        + &material(206e3, 0.3, 7.83e-9, plastic)
        + "*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n*Initial Conditions, type=VELOCITY\n ALL, 2, -1.e5\n*Step\n"
        + dynamic
        + more
        + "*Boundary\n J0, 2, 2\n*Output, history, number interval=10\n*Energy Output\n ALLKE, ALLPD, ALLIE\n*End Step\n"
}

#[test]
fn omitted_effect_matches_a_deck_without_the_card() {
    let (rate, heat) = (
        "*Rate Dependent, type=JOHNSON COOK\n 0.0089, 1.\n",
        "*Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 4.6e8,\n",
    );
    let yields = "*Plastic, hardening=JOHNSON COOK\n 806., 614., 0.168, 1.1, 1540., 20.\n";
    let failure = "*Shear Failure\n 0.008,\n";
    let (adiabatic, plain) = ("*Dynamic, Explicit, adiabatic\n , 1.e-7\n", "*Dynamic, Explicit\n , 1.e-7\n");
    let whole = bar(&format!("{yields}{rate}{heat}{failure}"), adiabatic, "");
    let effects = left_out(&whole, "increment=1,0.5", "final(ALLIE)");
    effects.conclusions().iter().for_each(|line| println!("{line}"));
    let value = |text: &str| left_out(text, "increment=1,0.5", "final(ALLIE)").value;
    for (name, without) in [
        ("rate dependence", bar(&format!("{yields}{heat}{failure}"), adiabatic, "")),
        ("heating by plastic work", bar(&format!("{yields}{rate}{heat}{failure}"), plain, "")),
        ("failure", bar(&format!("{yields}{rate}{heat}"), adiabatic, "")),
        ("plasticity", bar("", plain, "")),
        ("bulk viscosity", bar(&format!("{yields}{rate}{heat}{failure}"), adiabatic, "*Bulk Viscosity\n 0., 0.\n")),
        (
            "hourglass control",
            whole
                .replace(
                    "material=M\n",
                    "material=M, controls=C\n*Section Controls, name=C, hourglass=VISCOUS\n , , , \n",
                )
                .replace("hourglass=VISCOUS\n , , , \n", "hourglass=VISCOUS\n 0.\n"),
        ),
    ] {
        assert_ne!(without, whole, "{name}");
        let found = find(&effects, name).value.expect("a value");
        assert_eq!(found.to_bits(), value(&without).to_bits(), "{name}: {found}");
        assert_ne!(found, effects.value, "{name} is felt");
    }
}

/// A gas compressed by a piston in skewed elements.
#[test]
fn omitted_subzonal_pressures_match_the_deck() {
    let gas = |section: &str| {
        grid(4, 10, false, |i, j| [0.01 * i as f64, 0.01 * j as f64 + 0.002 * (i * (j % 10).min(1)) as f64])
            + &format!("*Solid Section, elset=SOLID, material=GAS{section}\n")
            + "*Material, name=GAS\n*Density\n 1.,\n*Eos, type=IDEAL GAS\n 0.6666666, 0.\n*Specific Heat\n 1.,\n\
               *Initial Conditions, type=SPECIFIC ENERGY\n SOLID, 1.e-6\n*Initial Conditions, type=VELOCITY\n J0, 2, 1.\n\
               *Step\n*Dynamic, Explicit\n , 0.03\n*Boundary\n I0, 1, 1\n I1, 1, 1\n J1, 2, 2\n\
               *Boundary, type=VELOCITY\n J0, 2, 2, 1.\n\
               *Output, history, number interval=10\n*Energy Output\n ALLKE, ALLIE\n*End Step\n"
    };
    let effects = left_out(&gas(""), "increment=1,0.5", "final(ALLKE)");
    effects.conclusions().iter().for_each(|line| println!("{line}"));
    let without = gas(", controls=C\n*Section Controls, name=C, subzonal=NO");
    let expected = left_out(&without, "increment=1,0.5", "final(ALLKE)");
    let found = find(&effects, "subzonal pressures").value.expect("a value");
    assert_eq!(found.to_bits(), expected.value.to_bits(), "{found}");
    assert_ne!(found, effects.value, "it is felt");
    assert!(expected.effects.iter().all(|e| e.effect != "subzonal pressures"), "it does not exist");
}

/// Blocks that slide on each other, in a contact pair and in general contact: without friction equal to a coefficient
/// of zero, without contact equal to a deck without it.
#[test]
fn omitted_contact_and_friction_match_the_deck() {
    use crate::common::bodies::{assembly, elastic, part};
    for contact in [
        "*Contact Pair, interaction=I\n LOWER.J1, UPPER.J0\n",
        "*Contact\n*Contact Inclusions, all exterior\n*Contact Property Assignment\n , , I\n",
    ] {
        let blocks = |friction: f64, contact: &str| {
            let block = |name, from: f64| part(name, [3, 2], |i, j| [1.0 + i as f64, from + j as f64], "");
            block("LOWER", -2.0)
                + &block("UPPER", 0.0)
                + &assembly(&["LOWER", "UPPER"], "")
                + &elastic("LOWER", [100.0, 0.3, 1.0], "")
                + &elastic("UPPER", [100.0, 0.3, 1.0], "")
                + &format!("*Surface Interaction, name=I\n*Friction\n {friction},\n")
                + "*Initial Conditions, type=VELOCITY\n UPPER.ALL, 2, -1.\n UPPER.ALL, 1, .5\n*Step\n*Dynamic, Explicit\n , 0.2\n\
                   *Boundary\n LOWER.J0, 1, 2\n"
                + contact
                + "*Output, history, number interval=10\n*Energy Output\n ALLKE\n*End Step\n"
        };
        let effects = left_out(&blocks(0.3, contact), "increment=1,0.5", "final(ALLKE)");
        let found = find(&effects, "friction").value.expect("a value");
        let passing = find(&effects, "contact").value.expect("a value");
        let of = |deck: &str| left_out(deck, "increment=1,0.5", "final(ALLKE)").value;
        let [expected, apart] = [of(&blocks(0.0, contact)), of(&blocks(0.3, ""))];
        assert_eq!(found.to_bits(), expected.to_bits(), "{contact}: {found}");
        assert_eq!(passing.to_bits(), apart.to_bits(), "{contact}: {passing}");
        assert!(found != effects.value && passing != effects.value, "they have an effect");
    }
}

/// A stiff disc driven into a target, made rigid: the closed form of m V' = -k0 - k2 V^2.
#[test]
fn body_made_rigid_matches_closed_form() {
    let (a, thickness, density, v): (f64, f64, f64, f64) = (5.0, 5.0, 7.85e-9, 300e3);
    let text = grid(6, 6, false, |i, j| [a * i as f64 / 6.0, thickness * j as f64 / 6.0])
        + &material(200e3, 0.3, density, "")
        + &format!(
            "*Material, name=ROCK\n*Density\n 2.7e-9,\n*Cavity Expansion, yield=100.\n 4., 0., 1.\n*Target, name=WALL, front=1., direction=-1\n ROCK, 900.\n\
             *Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n*Step\n*Dynamic, Explicit, accuracy=1e-6\n , 1.e-5\n*Dsload, target=WALL\n J0, CAVITY\n\
             *Output, history, number interval=10\n*Energy Output\n ALLKE\n*End Step\n",
            -v
        );
    let effects = left_out(&text, "increment=1,0.5", "final(ALLKE)");
    let (k0, k2, m): (f64, f64, f64) = (400.0, 2.7e-9, density * thickness);
    let start = (v * (k2 / k0).sqrt()).atan();
    let speed = (k0 / k2).sqrt() * (start - (k0 * k2).sqrt() / m * 1e-5).tan();
    let expected = 0.5 * m * PI * a * a * speed * speed;
    let rigid = find(&effects, "deformation of the body");
    let found = rigid.value.expect("a value");
    println!("{}", effects.conclusions().join("\n"));
    // The requested accuracy.
    assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
}

/// Without conduction, free nodes keep their temperature; with it, the series solution of the slab, order 2 in the
/// mesh.
#[test]
fn omitted_conduction_keeps_temperatures() {
    let text = grid(1, 8, false, |i, j| [1.0 + i as f64, j as f64 / 8.0]).replace("type=CAX4R", "type=CAX4RT")
        + &material(0.01, 0.3, 2.0, "*Conductivity\n 0.1,\n*Specific Heat\n 0.5,\n")
        + "*Nset, nset=LOW\n 1\n*Initial Conditions, type=TEMPERATURE\n ALL, 3.\n*Step\n\
           *Dynamic Temperature-displacement, Explicit\n , 2.\n*Boundary\n J1, 11, 11, 4.\n\
           *Output, history, number interval=10\n*Node Output, nset=LOW\n NT\n*End Step\n";
    let effects = left_out(&text, "increment=1,0.5", "final(NT11@LOW)");
    let conduction = find(&effects, "heat conduction");
    assert!(conduction.matters, "{:?}", effects.conclusions());
    assert_eq!(conduction.value, Some(3.0));
}

/// Terms of the material law of shells are left out like those of solids.
#[test]
fn omitted_shell_plasticity_matches_the_deck() {
    let text = "*Node, nset=ALL\n 1, 1., 0.\n 2, 1., 1.\n*Nset, nset=A\n 1\n*Element, type=SAX1, elset=SHELL\n 1, 1, 2\n\
                *Shell Section, elset=SHELL, material=M\n 0.01, 3\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 100., 0.\n\
                *Plastic\n 1., 0.\n*Initial Conditions, type=VELOCITY\n ALL, 1, 0.5\n*Step\n*Dynamic, Explicit\n , 0.1\n\
                *Boundary\n ALL, 2, 2\n ALL, 6, 6\n*Output, history, number interval=10\n*Node Output, nset=A\n U1\n*End Step\n";
    let effects = left_out(text, "increment=0.1,0.05,0.025", "final(U1@A)");
    assert!(find(&effects, "plasticity").matters, "{:?}", effects.conclusions());
}

/// A field on shells compared with the finest mesh: order 2.
#[test]
fn norms_on_shells_converge_with_order_two() {
    let text = "*Parameter\nn = 4\nlast = n + 1\n*Node\n 1, 0., 0.\n <last>, 0.1, 0.01\n*Ngen, nset=ALL\n 1, <last>\n\
                *Element, type=SAX1\n 1, 1, 2\n*Elgen, elset=SHELL\n 1, <n>\n*Nset, nset=A\n 1\n*Nset, nset=B\n <last>\n\
                *Shell Section, elset=SHELL, material=M\n 0.002, 5\n*Material, name=M\n*Density\n 7800.,\n*Elastic\n 2.e11, 0.3\n\
                *Step\n*Dynamic, Explicit\n , 1.e-4\n*Boundary\n A, XSYMM\n B, ENCASTRE\n*Dload\n SHELL, P, 1.e5\n\
                *Output, history, number interval=20\n*Node Output, nset=A\n U2\n*End Step\n";
    let source = |overrides: &ParameterOverrides| deck::read_text("case.inp", text, overrides);
    let measure = Quantity::parse("norm(U2)").expect("a quantity");
    let axes = settings::axes(&["n=8,16,32".to_owned()], &["n".to_owned(), "last".to_owned()]).expect("levels");
    let mut bench = StudyRunner::new(&source, &[], None, &measure, 1, &|| {});
    let study = refinement::grid(&mut bench, &axes, None).expect("a study");
    let row = study.rows.last().expect("rows");
    let order = row.estimates.last().copied().flatten().and_then(|e| e.order).expect("an order");
    assert!((order - 2.0).abs() < 0.15, "{order}");
}
