//! Decks with a refined or coarsened mesh that `revolve mesh refine` writes.
//!
//! Goal: a written deck gives the results of the deck run with the same refinement, to the last bit: coordinates are
//! written with the shortest digits that read back to the same number.
//! Source: the same decks with the setting `mesh`.

use std::fs;

use revolve::deck;
use revolve::model::relisting;
use revolve::user::Routines;

use crate::common::solid::{copper_bar, grid, in_six_node_triangles, material};
use crate::common::spheres::SKEWED;
use crate::common::{self, pairs, project};

/// Returns the text of a deck with a listed mesh.
fn written(text: &str, settings: &[(&str, &str)]) -> String {
    let path = project("input/deck.inp");
    let (deck, found) = deck::read_text(path.to_str().expect("a path"), text, &pairs(settings));
    assert!(!found.has_errors(), "{}", found.render(&deck.sources));
    let (text, found) = relisting::write(&deck);
    assert!(!found.has_errors(), "{}", found.render(&deck.sources));
    text
}

/// Asserts that the written deck lists its mesh and has the results of the deck.
fn assert_same_results(what: &str, text: &str, settings: &[(&str, &str)]) {
    let listed = written(text, settings);
    for keyword in ["*Ngen", "*Nfill", "*Elgen", "*Include", "generate"] {
        assert!(!listed.to_lowercase().contains(&keyword.to_lowercase()), "{what}: {keyword}");
    }
    let (expected, rows) = common::run(text, settings, &Routines::none());
    let (outcome, listed_rows) = common::run(&listed, &[], &Routines::none());
    assert_eq!(outcome.halt.map(|halt| halt.code()), expected.halt.map(|halt| halt.code()), "{what}");
    assert_eq!((outcome.digest, outcome.increments), (expected.digest, expected.increments), "{what}\n{listed}");
    assert!(outcome.increments > 5, "{what}: {} increments", outcome.increments);
    assert!(rows.rows == listed_rows.rows && !rows.rows.is_empty(), "{what}: {:?}\n{:?}", rows.rows, listed_rows.rows);
}

fn input(name: &str) -> String {
    fs::read_to_string(project("input").join(name)).expect("an input deck")
}

#[test]
fn written_decks_have_the_results_of_refined_decks() {
    let short = |name: &str, from: &str, to: &str| {
        let text = input(name);
        assert!(text.contains(from), "{name}");
        text.replace(from, to)
    };
    let taylor = short("taylor_copper.inp", "80.e-6", "2.e-6");
    assert_same_results("Taylor bar", &taylor, &[("nr", "4"), ("nz", "20"), ("mesh", "2")]);
    assert_same_results("merged Taylor bar", &taylor, &[("nr", "4"), ("nz", "20"), ("mesh", "1/2")]);
    assert_same_results("listed Taylor bar", &taylor, &[("nr", "4"), ("nz", "20"), ("mesh", "1")]);
    let rod = short("rod_plate_deletion.inp", "40.e-6", "4.e-6");
    let sizes = [("nr", "2"), ("nz", "10"), ("mr", "10"), ("mz", "5"), ("mesh", "3")];
    assert_same_results("rod and plate", &rod, &sizes);
    assert_same_results("ogive", &input("ogive.inp"), &[("n", "5"), ("V", "500"), ("mesh", "4")]);
    let bar = |triangles| copper_bar([4, 8], triangles, SKEWED).replace("80.e-6", "5.e-6");
    let curved = [("mesh", "2"), ("mesh-curved", "45")];
    assert_same_results("curved triangles", &bar(true), &curved);
    assert_same_results("triangles", &bar(true), &[("mesh", "2")]);
    assert_same_results("six-node triangles", &in_six_node_triangles(&bar(false), [4, 8]), &[("mesh", "2")]);
}

/// Two tied blocks with constraints, loads, conditions and output at nodes, elements and faces.
fn blocks(mesh_data: &str, history: &str) -> String {
    let upper = "*Node\n 101, 1., 1.\n 102, 2., 1.\n 103, 3., 1.\n 104, 1., 2.\n 105, 2., 2.\n 106, 3., 2.\n 900, 2., 3.\n\
                 *Nset, nset=A\n 101, 102, 103\n*Nset, nset=TOP, unsorted\n 106, 105, 104\n";
    upper.to_owned()
        + &grid(2, 1, false, |i, j| [1.0 + i as f64, j as f64])
        + "*Element, type=CAX4R, elset=SOLID\n 11, 101, 102, 105, 104\n 12, 102, 103, 106, 105\n*Elset, elset=LEFT\n 11,\n"
        + &material(1e5, 0.3, 1.0, "")
        + mesh_data
        + "*Step\n*Dynamic, Explicit\n , 0.05\n"
        + history
        + "*Output, history, number interval=5\n*Node Output, nset=106\n U\n*Node Output, nset=1\n U, V\n*Element Output, \
           elset=LEFT\n S22\n*Element Output, elset=2\n S11\n*Energy Output\n ALLKE, ALLIE, ALLWK\n*End Step\n"
}

#[test]
fn words_that_refer_to_the_mesh_are_replaced() {
    let loads = "*Boundary\n 1, 2, 2\n 2, 2, 2, 0.\n 3, 2, 2\n*Cload\n TOP, 2, 3.\n*Dload\n LEFT, P4, 2.\n 2, P2, 1.\n 2, GRAV, 9., 0., -1.\n\
                 *Dsload\n FACES, P, 0.5\n";
    let constraints = "*Surface, name=FACES\n LEFT, S3\n 12, S2\n*Initial Conditions, type=VELOCITY\n 104, 2, 1.\n 105, 2, 2.\n 106, 2, 4.\n\
                       *Initial Conditions, type=STRESS\n 2, 5., 0., 0., 0.\n";
    for (what, kind) in [
        ("equations", "*Equation\n 2\n A, 2, 1., J1, 2, -1.\n 2\n A, 1, 1., J1, 1, -1.\n"),
        ("pins", "*Mpc\n PIN, A, J1\n"),
        ("a beam", "*Nset, nset=B, unsorted\n 103, 102\n*Mpc\n BEAM, B, 101\n"),
        ("a tie", "*Surface, name=S\n 11, S1\n 12, S1\n*Tie, name=T\n S, J1\n"),
        ("a tie of nodes", "*Surface, type=NODE, name=S\n 101,\n 102,\n 103,\n*Tie, name=T\n S, J1\n"),
        ("a mass", "*Element, type=MASS, elset=POINT\n 50, 106\n*Mass, elset=POINT\n 2.\n*Mpc\n TIE, A, J1\n"),
    ] {
        for factor in ["1", "2", "3"] {
            assert_same_results(what, &blocks(&format!("{constraints}{kind}"), loads), &[("mesh", factor)]);
        }
    }
}

/// Two instances of one part, the second turned: each is a separate part in the written deck.
#[test]
fn instances_become_parts() {
    let text = fs::read_to_string(project("tests/deck/words/parts.inp")).expect("a deck");
    let text = text.replace(" , 0.2\n", " , 3.\n");
    for factor in ["1", "2"] {
        assert_same_results("instances", &text, &[("mesh", factor)]);
    }
    assert_eq!(written(&text, &[("mesh", "2")]).matches("*Part").count(), 2, "the part without instance is left out");
    let profile = "*Surface, name=WALL, type=SEGMENTS\n START, 0., 0.\n LINE, 1., 0.\n*End Part\n*Part, name=Q";
    let (deck, found) =
        deck::read_text("deck.inp", &text.replacen("*End Part\n*Part, name=Q", profile, 1), &pairs(&[("mesh", "2")]));
    assert!(!found.has_errors());
    let (_, found) = relisting::write(&deck);
    assert!(found.iter().any(|d| d.code == "M192" && !d.labels.is_empty()), "{}", found.render(&deck.sources));
}

/// Comments, parameters and their overrides, and materials keep their text; included files become part of the deck.
#[test]
fn other_cards_keep_their_text() {
    let text = input("gauntlet/void.inp").replace("rectangle.inc", "gauntlet/rectangle.inc");
    let listed = written(&text, &[("mesh", "2")]);
    let is_kept = |line: &&str| line.starts_with("**") || line.starts_with("*Material") || line.starts_with("*Dynamic");
    for line in text.lines().filter(is_kept) {
        assert!(listed.contains(line), "{line}\n{listed}");
    }
    let text = "*Parameter\nname = \"M\" ; e = 1e5 # modulus\nn = 4\n".to_owned()
        + &grid(4, 1, false, |i, j| [i as f64, j as f64])
        + "*Solid Section, elset=SOLID, material=<name>\n*Material, name=M\n*Density\n 1.,\n*Elastic\n <e>, 0.3\n*Step\n*Dynamic, Explicit\n \
           , 0.1\n*Boundary\n J0, 2, 2\n*Dsload\n J1, P, 1.\n*Output, history, number interval=3\n*Energy Output\n ALLKE\n*End Step\n";
    assert_same_results("overrides", &text, &[("e", "8e4"), ("mesh", "2")]);
    let listed = written(&text, &[("name", "M"), ("e", "8e4"), ("mesh", "2")]);
    assert!(listed.contains("name = \"M\" ; e = 8e4 # modulus\nn = 4\n"), "{listed}");
}
