//! The command `revolve fragments`.
//!
//! Source: closed form of a ring with a uniform radial velocity, whose number of fragments by Mott's law,
//! `2 pi v (rho gamma/(2 sigma))^(1/2)/1.67`, does not depend on the radius.

use serde_json::Value;

use crate::common::revolve;

/// A ring of four elements with a radial velocity of 200 m/s.
const RING: &str = "\
*Node
 1, 0.016, 0.
 3, 0.017, 0.
 7, 0.016, 0.001
 9, 0.017, 0.001
*Ngen, nset=LOW
 1, 3, 1
*Ngen, nset=HIGH
 7, 9, 1
*Nfill
 LOW, HIGH, 2, 3
*Element, type=CAX4R, elset=RING
 1, 1, 2, 5, 4
*Elgen, elset=RING
 1, 2, 1, 1, 2, 3, 2
*Nset, nset=ALL, generate
 1, 9
*Elset, elset=PART
 1, 2
*Material, name=AL
*Density
 2700.,
*Elastic
 70.e9, 0.33
*Plastic
 1.e8, 0.
*Solid Section, elset=RING, material=AL
*Initial Conditions, type=VELOCITY
 ALL, 1, 200.
*Step
*Dynamic, Explicit
 , 1.e-6
*Output, field, number interval=2
*Node Output
 U, V
*End Step
";

/// Runs `revolve fragments` on a folder and returns its exit status, output and messages.
fn fragments(folder: &str, words: &[&str]) -> (Option<i32>, String, String) {
    let output = revolve(&[&["fragments", folder, "--density", "2700", "--shape", "ring"], words].concat());
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn ring_has_the_fragments_of_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = ["ring.inp", "out", "counted.csv"].map(|name| folder.path().join(name));
    let [deck, out, counted] = [&paths[0], &paths[1], &paths[2]].map(|path| path.to_str().expect("a name"));
    std::fs::write(deck, RING).expect("a deck");
    std::fs::write(counted, "mass,count\n1e-5,3\n4e-5,8\n").expect("a table");
    assert!(revolve(&["run", deck, "--out", out, "--quiet"]).status.success());
    let laws = ["--flow-stress", "1e8", "--gamma", "25", "--fracture-energy", "2e4"];
    let more = ["--time", "0", "--counted", counted, "--json"];
    let (status, text, errors) = fragments(out, &[&laws[..], &more].concat());
    assert_eq!((status, errors.as_str()), (Some(0), ""));
    let found: Value = serde_json::from_str(&text).expect("an object");
    let number = |law: usize, key: &str| found["laws"][law][key].as_f64().expect("a number");
    let pi = std::f64::consts::PI;
    let by_mott = 2.0 * pi * 200.0 * (2700.0 * 25.0 / 2e8_f64).sqrt() / 1.67;
    assert!((number(0, "fragments") / by_mott - 1.0).abs() < 1e-3, "{text}");
    let rate: f64 = 200.0 / 0.0165;
    let by_grady = 2.0 * pi * 0.0165 / (24.0 * 2e4 / (2700.0 * rate * rate)).cbrt();
    assert!((number(1, "fragments") / by_grady - 1.0).abs() < 1e-3, "{text}");
    let mass = 2700.0 * pi * (0.017_f64.powi(2) - 0.016_f64.powi(2)) * 0.001;
    assert!((found["mass"].as_f64().expect("a mass") / mass - 1.0).abs() < 1e-6, "{text}");
    assert_eq!(found["counted"].as_array().map(Vec::len), Some(11));
    // A part of the body has its mass alone; the report shows table and picture.
    let (_, text, _) = fragments(out, &[&laws[..], &["--set", "part", "--time", "0", "--json"]].concat());
    let part: Value = serde_json::from_str(&text).expect("an object");
    assert!((part["mass"].as_f64().expect("a mass") / mass - 0.5).abs() < 1e-6, "{text}");
    assert!(revolve(&["report", out, "--quiet"]).status.success());
    let page = std::fs::read_to_string(paths[1].join("report.html")).expect("a page");
    assert!(page.contains("\"Fragments\"") && page.contains("ring_fragments.svg"));
    for (words, message) in [
        (&[][..], "give --flow-stress and --gamma for the law of Mott"),
        (&["--fracture-energy", "0"], "expected a number above zero, found `0`"),
        (&["--fracture-energy", "1", "--set", "RNG"], "no such element set; it has RING, PART"),
        (&["--fracture-energy", "1", "--counted", deck], "line 2: expected a mass, or a mass and a count"),
        (&["--flow-stress", "1e8"], "--gamma"),
    ] {
        let (status, _, errors) = fragments(out, words);
        assert!(status == Some(2) && errors.contains(message), "{words:?}: {errors}");
    }
    std::fs::write(deck, RING.replace(" U, V\n", " U\n").replace("1, 200.", "1, -200.")).expect("a deck");
    assert!(revolve(&["run", deck, "--out", out, "--quiet"]).status.success());
    let (status, _, errors) = fragments(out, &["--fracture-energy", "1"]);
    assert!(status == Some(2) && errors.contains("request V with *NODE OUTPUT"), "{errors}");
}

#[test]
fn contracting_bodies_have_no_fragments() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = ["ring.inp", "out"].map(|name| folder.path().join(name));
    let [deck, out] = [&paths[0], &paths[1]].map(|path| path.to_str().expect("a name"));
    std::fs::write(deck, RING.replace("1, 200.", "1, -200.")).expect("a deck");
    assert!(revolve(&["run", deck, "--out", out, "--quiet"]).status.success());
    let (status, _, errors) = fragments(out, &["--fracture-energy", "1", "--time", "0"]);
    assert!(status == Some(2) && errors.contains("the circumference of no solid element grows"), "{errors}");
}
