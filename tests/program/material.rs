//! Stress-strain curves of materials by `revolve material`.
//!
//! Sources: the closed form of the Johnson-Cook law, the rows of a table, Young's modulus.

use std::fs;
use std::path::Path;

use revolve::study::material::{TensionCurve, TensionPoint};

use crate::common::revolve;

/// A deck with the given material cards and an element for each material.
fn deck(materials: &[(&str, &str)]) -> String {
    let mut text = String::from("*Heading\n Materials\n*Units\n m, kg, s, K\n*Node, nset=ALL\n");
    for i in 0..=materials.len() {
        text += &format!(" {}, 0., {i}e-3\n {}, 1e-3, {i}e-3\n", 2 * i + 1, 2 * i + 2);
    }
    for (i, (name, cards)) in materials.iter().enumerate() {
        let n = 2 * i + 1;
        text += &format!("*Element, type=CAX4R, elset=E{i}\n {}, {n}, {}, {}, {}\n", i + 1, n + 1, n + 3, n + 2);
        text += &format!("*Solid Section, elset=E{i}, material={name}\n*Material, name={name}\n{cards}");
    }
    text + "*Step\n*Dynamic, Explicit\n , 1e-5\n*Boundary\n 1, 2, 2\n*End Step\n"
}

const ELASTIC: &str = "*Density\n 7850.,\n*Elastic\n 210e9, 0.3\n";

/// Rows of the curves: rate, initial temperature, strain, stress, plastic strain.
fn curves(text: &str, folder: &Path, options: &[&str]) -> Vec<[f64; 5]> {
    let path = folder.join("bar.inp");
    fs::write(&path, text).expect("a deck");
    let (path, out) = (path.to_string_lossy().into_owned(), folder.to_string_lossy().into_owned());
    let output = revolve(&[&["material", &path, "--out", &out], options].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for ending in ["svg", "png"] {
        assert!(folder.join(format!("bar_material.{ending}")).exists(), "{ending}");
    }
    let csv = fs::read_to_string(folder.join("bar_material.csv")).expect("curves");
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').skip(1).map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        [cells[0], cells[1], cells[2], cells[3], cells[4]]
    };
    csv.lines().skip(1).map(row).collect()
}

/// σ = (A + B εⁿ) (1 + C ln(ε'/ε₀')) (1 - Tᵐ) without heating, at two rates and two temperatures.
#[test]
fn johnson_cook_curves_match_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let cards = format!(
        "{ELASTIC}*Plastic, hardening=JOHNSON COOK\n 792e6, 510e6, 0.26, 1.03, 1793., 293.\n\
         *Rate Dependent, type=JOHNSON COOK\n 0.014, 1.\n"
    );
    let options = ["--rates", "10,1e4", "--temperatures", "293,600", "--strain", "0.3"];
    let rows = curves(&deck(&[("STEEL", &cards)]), folder.path(), &options);
    let mut count = 0;
    for &[rate, temperature, strain, stress, plastic] in rows.iter().filter(|row| row[2] > 0.01) {
        let softening = 1.0 - ((temperature - 293.0) / 1500.0_f64).powf(1.03);
        let exact = (792e6 + 510e6 * plastic.powf(0.26)) * (1.0 + 0.014 * rate.ln()) * softening;
        assert!((stress / exact - 1.0).abs() < 1e-3, "{rate} {temperature} {strain}: {stress:e}, {exact:e}");
        assert!((plastic + stress / 210e9 - strain).abs() < 1e-4, "{rate} {strain}: {plastic}");
        count += 1;
    }
    assert!(count > 3000, "{count} points");
}

/// A table is followed between its rows; an elastic material has the slope E.
#[test]
fn table_and_elastic_curves_match_their_cards() {
    let folder = tempfile::tempdir().expect("a folder");
    let cards = format!("{ELASTIC}*Plastic\n 400e6, 0.\n 500e6, 0.1\n 560e6, 0.3\n");
    let rows = curves(&deck(&[("TABLE", &cards)]), folder.path(), &["--rates", "1", "--strain", "0.25"]);
    for &[_, _, strain, stress, plastic] in rows.iter().filter(|row| row[2] > 0.01) {
        let exact = if plastic < 0.1 { 400e6 + 1e9 * plastic } else { 500e6 + 300e6 * (plastic - 0.1) };
        assert!((stress / exact - 1.0).abs() < 1e-3, "{strain}: {stress:e}, {exact:e}");
    }
    let rows = curves(&deck(&[("ELASTIC", ELASTIC)]), folder.path(), &["--rates", "1e-3", "--strain", "0.01"]);
    for &[_, _, strain, stress, _] in rows.iter().filter(|row| row[2] > 1e-3) {
        assert!((stress / (210e9 * strain) - 1.0).abs() < 1e-3, "{strain}: {stress:e}");
    }
}

/// The failure strain of a deleted element, and the element length of damage evolution.
#[test]
fn failure_strain_follows_the_element_length() {
    let folder = tempfile::tempdir().expect("a folder");
    let cards = format!(
        "{ELASTIC}*Plastic\n 400e6, 0.\n*Damage Initiation, criterion=DUCTILE\n 0.1, 0.3333, 0.\n\
         *Damage Evolution, type=DISPLACEMENT\n 1e-4,\n"
    );
    let end = |length: &str| {
        let options = ["--rates", "1", "--strain", "0.4", "--length", length];
        curves(&deck(&[("FAILS", &cards)]), folder.path(), &options).last().expect("a point")[2]
    };
    // 0.1 until damage begins, then 1e-4 over the length.
    assert!((end("1e-3") - 0.2).abs() < 5e-3, "{}", end("1e-3"));
    assert!((end("2e-3") - 0.15).abs() < 5e-3, "{}", end("2e-3"));
}

/// The softening strain is at the end of a plateau or at a maximum; a hardening curve has none.
#[test]
fn softening_begins_at_the_last_largest_stress() {
    let curve = |stress: &dyn Fn(f64) -> f64| {
        let point = |i: u32| {
            let strain = 1e-3 * f64::from(i);
            TensionPoint { strain, stress: stress(strain), plastic: strain, temperature: f64::NAN }
        };
        let points = (0..=500).map(point).collect();
        TensionCurve { rate: 1.0, temperature: None, points, failure: None, halt: None }.softening_strain()
    };
    assert_eq!(curve(&|strain| strain), None);
    assert_eq!(curve(&|strain| if strain < 0.1 { 1.0 + 1e-8 * (0.1 - strain) } else { 1.1 - strain }), Some(0.1));
    assert!(curve(&|strain| 2.0 - (strain - 0.2).powi(2)).is_some_and(|strain| (strain - 0.2).abs() < 2e-3));
}

/// Half of the tensile strength of concrete remains at the crack opening Gf/ft of linear softening: at the strain
/// ft/(2 E) + Gf/(ft L) in an element of the length L. Tolerance 2 %: rows are 1e-5 apart, strains are finite.
#[test]
fn length_of_concrete_is_that_of_the_option() {
    let concrete = "*Density\n 2400.,\n*Elastic\n 30e9, 0.2\n*Concrete Damaged Plasticity\n 35., 0.1, 1.16, 0.667\n*Concrete \
                    Compression Hardening\n 30e6, 0.\n 30e6, 0.01\n*Concrete Tension Stiffening, type=GFI\n 2.5e6, 110.\n";
    for length in [0.01, 0.03] {
        let folder = tempfile::tempdir().expect("a folder");
        let option = length.to_string();
        let options = ["--rates", "1", "--strain", "0.01", "--length", &option];
        let rows = curves(&deck(&[("CONCRETE", concrete)]), folder.path(), &options);
        let expected = 2.5e6 / 60e9 + 110.0 / (2.5e6 * length);
        let peak = rows.iter().position(|row| row[3] > 2.45e6).expect("the strength");
        let half = rows[peak..].iter().find(|row| row[3] < 1.25e6).expect("softening")[2];
        assert!((half / expected - 1.0).abs() < 2e-2, "{length}: {half} {expected}");
    }
}

/// A law of strength over pressure has a yield surface and paths: pictures, a table and JSON with the same points. The peak of
/// triaxial compression at the pressure p is (p tan(beta) + d)/(1 - tan(beta)/3).
#[test]
fn strength_over_pressure_has_surface_and_paths() {
    let folder = tempfile::tempdir().expect("a folder");
    let soil = "*Density\n 2000.,\n*Elastic\n 10e9, 0.25\n*Drucker Prager\n 40., 1., 10.\n*Drucker Prager Hardening\n 20e6, 0.\n";
    let path = folder.path().join("soil.inp");
    fs::write(&path, deck(&[("SOIL", soil)])).expect("a deck");
    let (path, out) = (path.to_string_lossy().into_owned(), folder.path().to_string_lossy().into_owned());
    let arguments =
        ["material", &path, "--out", &out, "--rates", "1", "--strain", "0.02", "--confinements", "0,10e6,40e6"];
    let output = revolve(&[&arguments[..], &["--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let record: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let paths = record["strengths"][0]["paths"].as_array().expect("paths");
    let tangent = 40.0_f64.to_radians().tan();
    for (path, cell) in paths.iter().zip([0.0, 10e6, 40e6]) {
        assert_eq!(path["confinement"].as_f64(), Some(cell));
        let peak =
            path["points"].as_array().expect("points").iter().filter_map(|p| p["mises"].as_f64()).fold(0.0, f64::max);
        let expected = 20e6 + cell * tangent / (1.0 - tangent / 3.0);
        assert!((peak / expected - 1.0).abs() < 1e-6, "{peak:e} {expected:e}");
    }
    assert!(paths.len() == 4 && paths[3]["confinement"].is_null());
    let csv = fs::read_to_string(folder.path().join("soil_material_strength.csv")).expect("a table");
    let rows = csv.lines().skip(1).count();
    assert_eq!(rows, record["strengths"][0]["surface"].as_array().expect("a surface").len() + 4 * 101);
    for ending in ["surface.svg", "surface.png", "paths.svg", "paths.png"] {
        assert!(folder.path().join(format!("soil_material_{ending}")).exists(), "{ending}");
    }
    let output = revolve(&[&arguments[..8], &["--confinements=-1"]].concat());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && errors.contains("at least zero"), "{errors}");
}

/// Materials without strength are named with the reason; a misspelt name gets the nearest one.
#[test]
fn unsuitable_and_unknown_materials_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("two.inp");
    let water = "*Density\n 1000.,\n*Eos, type=USUP\n 1500., 2., 0.1\n";
    fs::write(&path, deck(&[("STEEL", ELASTIC), ("WATER", water)])).expect("a deck");
    let (path, out) = (path.to_string_lossy().into_owned(), folder.path().to_string_lossy().into_owned());
    let arguments = ["material", &path, "--out", &out, "--rates", "1", "--strain", "0.01"];
    let output = revolve(&arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && errors.contains("WATER has no curve: a fluid"), "{errors}");
    let output = revolve(&[&arguments[..], &["--material", "STEAL"]].concat());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && errors.contains("did you mean STEEL?"), "{errors}");
}

/// `resistance` and `material` warn of a density and a modulus of different unit systems, as `check` does.
#[test]
fn units_are_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("units.inp");
    let cards = "*Density\n 7850.,\n*Elastic\n 210e3, 0.3\n*Plastic\n 400., 0.\n";
    fs::write(&path, deck(&[("STEEL", cards)])).expect("a deck");
    let (path, out) = (path.to_string_lossy().into_owned(), folder.path().to_string_lossy().into_owned());
    let commands: [&[&str]; 2] =
        [&["material", &path, "--out", &out, "--rates", "1"], &["resistance", &path, "--to", "1"]];
    for arguments in commands {
        let errors = String::from_utf8_lossy(&revolve(arguments).stderr).into_owned();
        assert!(errors.contains("P119"), "{arguments:?}: {errors}");
    }
}
