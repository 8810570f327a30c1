//! `revolve study --map`: shares of regions in the error of a quantity, and decks that are refined in some regions.
//!
//! Source: the closed form of a plastic sphere (R. Hill, The Mathematical Theory of Plasticity, 1950, chapter 5).

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{project, revolve};

/// Deck of a plastic sphere, its quantity, and its setting for a coarse mesh.
fn sphere() -> String {
    project("docs/accuracy/scenes/hill_sphere.inp").display().to_string()
}
const QUANTITY: &str = "final(U1@RIM)";
const COARSE: &str = "n=6";

/// Outer displacement of a sphere of yield stress 3e-6 and outer radius 2 that is plastic up to 1.5: Y c³ (1 - nu) / (E b²).
const EXACT: f64 = 3e-6 * 3.375 * 0.7 / 4.0;

fn numbers(map: &Value, key: &str) -> Vec<f64> {
    let regions = map["regions"].as_array().expect("regions");
    regions.iter().map(|region| region[key].as_f64().expect("a number")).collect()
}

/// The changes add up to that of uniform refinement, the shares to the true error within 30 %. The deck refined in the two
/// regions with the largest shares has less than half of the error.
#[test]
fn shares_add_up_to_the_true_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let (deck, out) = (sphere(), folder.path().join("out").display().to_string());
    let setting = ["--set", COARSE, "--quantity", QUANTITY, "--out", &out];
    let ran = revolve(&[&["study", &deck, "--map", "--repeat", "1", "--json"], &setting[..]].concat());
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let path = format!("{out}/hill_sphere_map.json");
    let map: Value = serde_json::from_str(&fs::read_to_string(&path).expect("a map")).expect("JSON");
    let number = |key: &str| map[key].as_f64().expect("a number");
    let true_error = EXACT - number("value");
    println!("true {true_error:e}, sum {:e}, cost {}", number("sum"), number("cost"));
    assert!((number("sum") / true_error - 1.0).abs() < 0.3);
    let increment = number("increment") / number("factor");
    for key in ["forward", "backward"] {
        let sum: f64 = numbers(&map, key).iter().sum::<f64>() + increment;
        assert!((sum / number("uniform_change") - 1.0).abs() < 1e-9, "{key}: {sum:e}");
    }
    assert!(number("cost") <= 2.0);
    for ending in ["_map.csv", "_map.svg", "_map.png", "_map.sfv"] {
        assert!(Path::new(&format!("{out}/hill_sphere{ending}")).is_file(), "{ending}");
    }
    let shares = numbers(&map, "share");
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|a, b| shares[*b].total_cmp(&shares[*a]));
    let names = order[..2].iter().map(|at| format!("r{}", at + 1)).collect::<Vec<_>>().join(",");
    let local = folder.path().join("local.inp").display().to_string();
    let arguments = ["mesh", "refine", &deck, "--set", COARSE, "--regions", &names, "--map", &path, "--out", &local];
    let refined = revolve(&arguments);
    assert!(refined.status.success(), "{}", String::from_utf8_lossy(&refined.stderr));
    let ran = revolve(&["run", &local, "--quantity", QUANTITY, "--no-frames", "--out", &out, "--json"]);
    let report: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
    let value = report["quantities"][QUANTITY].as_f64().expect("a value");
    assert!((value - EXACT).abs() < 0.5 * true_error.abs(), "{value:e}");
    let line = revolve(&[&["run", &deck, "--uncertainty", "--map", &path, "--no-frames"], &setting[..]].concat());
    let line = String::from_utf8_lossy(&line.stdout).into_owned();
    assert!(line.contains(&format!(": R{} ", order[0] + 1)), "{line}");
}

/// `--target --local` reaches the target with fewer element-cycles than a uniform mesh. The deck that it writes has the same
/// value. Source: J. D. Eshelby 1957, Proc. R. Soc. A 241, 376, elongation of a spherical cavity.
#[test]
fn a_local_mesh_reaches_the_target_at_a_lower_cost() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = project("docs/accuracy/scenes/cavity_tension.inp").display().to_string();
    let (quantity, exact) = ("final(U2@POLE)", 1e-7 * (0.35 + 9.1 / 5.5));
    let out = folder.path().join("out").display().to_string();
    let run = |deck: &str, more: &[&str]| {
        let ran =
            revolve(&[&["run", deck, "--quantity", quantity, "--no-frames", "--out", &out, "--json"], more].concat());
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        serde_json::from_slice::<Value>(&ran.stdout).expect("JSON")
    };
    let report = run(&deck, &["--target", "0.5%", "--local"]);
    let value = report["quantities"][quantity].as_f64().expect("a value");
    let mesh = &report["certificate"]["target"]["local"];
    println!("{value:e}, exact {exact:e}, {mesh}");
    assert!((value / exact - 1.0).abs() < 0.005, "{value:e}");
    let cycles = |key: &str| mesh[key].as_f64().expect("a number");
    assert!(cycles("element_cycles") < cycles("uniform_element_cycles"), "{mesh}");
    let regions = mesh["regions"].as_array().expect("regions");
    let bisections: Vec<u64> = regions.iter().filter_map(|region| region["bisections"].as_u64()).collect();
    assert!(bisections.contains(&0) && bisections.iter().any(|count| *count > 0), "{mesh}");
    let again = run(&format!("{out}/cavity_tension_local.inp"), &[]);
    assert_eq!(again["quantities"][quantity].as_f64(), Some(value));
}

/// The map of a body with an adaptive mesh: no companion run fails, the changes add up to that of uniform refinement, and the
/// region below the indenter has the largest share.
#[test]
fn an_adaptive_mesh_has_shares_of_all_regions() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = project("input/indentation.inp").display().to_string();
    let out = folder.path().join("out").display().to_string();
    let setting = ["--set", "n=10", "--set", "depth=1.5e-3", "--quantity", "mean(RF2@SPHERE, 1.e-5, 2.5e-5)"];
    let options = ["--repeat", "1", "--jitter", "0", "--out", &out];
    let ran = revolve(&[&["study", &deck, "--map"], &setting[..], &options].concat());
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let path = format!("{out}/indentation_map.json");
    let map: Value = serde_json::from_str(&fs::read_to_string(&path).expect("a map")).expect("JSON");
    let shares = numbers(&map, "share");
    let number = |key: &str| map[key].as_f64().expect("a number");
    let increment = number("increment") / number("factor");
    for key in ["forward", "backward"] {
        let sum: f64 = numbers(&map, key).iter().sum::<f64>() + increment;
        assert!((sum / number("uniform_change") - 1.0).abs() < 1e-9, "{key}: {sum:e}");
    }
    let largest = (0..shares.len()).max_by(|a, b| shares[*a].abs().total_cmp(&shares[*b].abs())).expect("regions");
    let [low, high] = [0, 1].map(|end| map["regions"][largest]["bounds"][end].clone());
    println!("{shares:?}: largest {low} {high}");
    assert!(shares.len() >= 8 && low[0] == 0.0 && high[1] == 0.0, "{low} {high}");
}

/// Unknown regions, files that are no map, and studies without a series are refused with the reason.
#[test]
fn invalid_requests_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = sphere();
    let [file, out] = ["out.inp", "out"].map(|name| folder.path().join(name).display().to_string());
    let refine = ["mesh", "refine", &deck, "--out", &file];
    let study = ["study", &deck, "--map", "--set", COARSE, "--repeat", "1", "--out", &out];
    let choices = ["--refine", "hourglass=viscous,enhanced", "--exact", "1", "--quantity", QUANTITY];
    let cases: [(&[&str], &[&str], &str); 5] = [
        (&refine, &["--regions", "NONE"], "no such element set"),
        (&refine, &["--regions", "NONE", "--map", &deck], "not an error map"),
        (&refine, &[], "-k <PARTS>"),
        (&study, &["--quantity", "norm(S11)"], "must be a number"),
        (&study, &choices, "--map: give one --refine"),
    ];
    for (command, more, reason) in cases {
        let ran = revolve(&[command, more].concat());
        let text = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert!(!ran.status.success() && text.contains(reason), "{more:?}: {text}");
    }
}
