//! `revolve study --map`: shares of regions in the error of a quantity, and decks that are refined in some regions.
//!
//! Source: Lamé's closed form for a thick cylinder under a slowly applied internal pressure, whose error is at the inner
//! radius.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::revolve;

/// A cylinder of radii 1 and 5 under a pressure that increases slowly, and a rigid link that nothing loads.
fn cylinder(folder: &Path) -> String {
    let text = "*Parameter\nn = 24\nlast = 1 + n\n*Node\n 1, 1., 0.\n <last>, 5., 0.\n 101, 1., 0.5\n 125, 5., 0.5\n*Ngen, nset=LOWER\n \
                1, <last>, 1\n*Ngen, nset=UPPER\n 101, 125, 1\n*Nset, nset=ALL\n LOWER, UPPER\n*Nset, nset=INNER\n 1,\n*Element, type=CAX4R\n \
                1, 1, 2, 102, 101\n*Elgen, elset=SOLID\n 1, <n>, 1, 1\n*Elset, elset=FIRST\n 1,\n*Surface, name=BORE\n FIRST, S4\n\
                *Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.\n*Elastic\n 1000., 0.3\n\
                *Amplitude, name=SLOW, definition=SMOOTH STEP\n 0., 0., 20., 1.\n*Step\n*Dynamic, Explicit\n , 20.\n*Boundary\n \
                ALL, 2, 2\n*Dsload, amplitude=SLOW\n BORE, P, 1.\n*Output, history, number interval=20\n*Node Output, nset=INNER\n U1\n\
                *End Step\n";
    let path = folder.join("cylinder.inp");
    fs::write(&path, text).expect("a deck");
    path.display().to_string()
}

/// Displacement of the inner radius in plane strain: (1 + nu) p a / E ((1 - 2 nu) a² + b²) / (b² - a²).
const EXACT: f64 = 1.3e-3 * (0.4 + 25.0) / 24.0;

fn numbers(map: &Value, key: &str) -> Vec<f64> {
    let regions = map["regions"].as_array().expect("regions");
    regions.iter().map(|region| region[key].as_f64().expect("a number")).collect()
}

/// The changes add up to that of uniform refinement, the shares to the true error within 30 %; the inner region has the
/// largest share per element. The deck refined there has a smaller error.
#[test]
fn error_of_a_cylinder_is_at_the_inner_radius() {
    let folder = tempfile::tempdir().expect("a folder");
    let (deck, out) = (cylinder(folder.path()), folder.path().join("out").display().to_string());
    let quantity = "final(U1@INNER)";
    let study = ["study", &deck, "--map", "--quantity", quantity, "--repeat", "1", "--out", &out, "--json"];
    let ran = revolve(&study);
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let path = format!("{out}/cylinder_map.json");
    let map: Value = serde_json::from_str(&fs::read_to_string(&path).expect("a map")).expect("JSON");
    let number = |key: &str| map[key].as_f64().expect("a number");
    let (error, factor) = (number("error"), number("factor"));
    let true_error = EXACT - number("value");
    println!("error {error:e}, true {true_error:e}, sum {:e}, cost {}", number("sum"), number("cost"));
    assert!((number("sum") / true_error - 1.0).abs() < 0.3);
    let increment = number("increment") / factor;
    for key in ["forward", "backward"] {
        let sum: f64 = numbers(&map, key).iter().sum::<f64>() + increment;
        assert!((sum / number("uniform_change") - 1.0).abs() < 1e-9, "{key}: {sum:e}");
    }
    assert!(number("cost") <= 2.0);
    let shares = numbers(&map, "share");
    assert!(shares.len() >= 4 && shares.iter().skip(1).all(|share| share.abs() < shares[0].abs()), "{shares:?}");
    for ending in ["_map.csv", "_map.svg", "_map.png", "_map.sfv"] {
        assert!(Path::new(&format!("{out}/cylinder{ending}")).is_file(), "{ending}");
    }
    let local = folder.path().join("local.inp").display().to_string();
    let refined = revolve(&["mesh", "refine", &deck, "--regions", "r1", "--map", &path, "--out", &local]);
    assert!(refined.status.success(), "{}", String::from_utf8_lossy(&refined.stderr));
    let value = |arguments: &[&str]| {
        let ran =
            revolve(&[&["run"], arguments, &["--quantity", quantity, "--no-frames", "--out", &out, "--json"]].concat());
        let report: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
        report["quantities"][quantity].as_f64().expect("a value")
    };
    assert!((value(&[&local]) - EXACT).abs() < 0.7 * true_error.abs());
    let line =
        revolve(&["run", &deck, "--uncertainty", "--quantity", quantity, "--map", &path, "--no-frames", "--out", &out]);
    let line = String::from_utf8_lossy(&line.stdout).into_owned();
    assert!(line.contains(": R1 "), "{line}");
}

/// Unknown regions, files that are no map, and studies without a series are refused with the reason.
#[test]
fn invalid_requests_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let (deck, out) = (cylinder(folder.path()), folder.path().join("out.inp").display().to_string());
    for (arguments, reason) in [
        (vec!["mesh", "refine", &deck, "--regions", "SOLD", "--out", &out], "did you mean SOLID?"),
        (vec!["mesh", "refine", &deck, "--regions", "SOLID", "--map", &deck, "--out", &out], "not an error map"),
        (vec!["mesh", "refine", &deck, "--out", &out], "--regions"),
        (vec!["study", &deck, "--map", "--quantity", "norm(S11)"], "must be a number"),
        (
            vec![
                "study",
                &deck,
                "--map",
                "--refine",
                "hourglass=viscous,enhanced",
                "--exact",
                "1",
                "--quantity",
                "final(U1@INNER)",
            ],
            "--map: give one --refine",
        ),
    ] {
        let ran = revolve(&arguments);
        let text = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert!(!ran.status.success() && text.contains(reason), "{arguments:?}: {text}");
    }
}
