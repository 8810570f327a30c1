//! Result files read by other programs: the VTK library (if installed) and vtkio.

use std::process::Command;

use vtkio::Vtk;

use crate::common;

/// Returns a Python with the vtk wheel, or `None` with a printed note. CI requires it.
pub fn python() -> Option<String> {
    let python = std::env::var("REVOLVE_PYTHON").unwrap_or_else(|_| "python3".into());
    let found = Command::new(&python).args(["-c", "import vtkmodules"]).output().is_ok_and(|o| o.status.success());
    assert!(found || std::env::var_os("CI").is_none(), "in CI the vtk wheel must be installed");
    if !found {
        println!("left out: reading results with VTK (no Python with the vtk wheel)");
    }
    found.then_some(python)
}

#[test]
fn vtk_library_reads_the_series() {
    let folder = tempfile::tempdir().expect("a folder");
    common::run_ogive(folder.path(), &[("n", "8")]);
    let Some(python) = python() else { return };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/read_vtk.py");
    let output = Command::new(python).arg(script).arg(folder.path().join("ogive.pvd")).output().expect("python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let series: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let frames = series.as_array().expect("frames");
    assert_eq!(frames.len(), 21, "20 intervals and the start");
    for frame in frames {
        assert_eq!(frame["time"], frame["timestep"]);
        assert_eq!(frame["cell_types"].as_array().map(Vec::len), Some(8));
        assert_eq!(frame["cell_types"][0], 3, "lines");
        assert_eq!(frame["point"]["U"]["components"], 3);
        assert_eq!(frame["point"]["U"]["names"][1], "U2");
        assert_eq!(frame["point"]["V"]["type"], "double");
        for name in ["PRESSURE", "NORMAL_VELOCITY", "LAYER"] {
            assert_eq!(frame["cell"][name]["components"], 1, "{name}");
        }
    }
    let last = &frames[20];
    let depth = last["point"]["U"]["values"][0][1].as_f64().expect("a number");
    assert!((depth + 0.0648).abs() < 5e-4, "{depth}");
    assert_eq!(last["cell"]["LAYER"]["values"][0], 1.0);
    assert_eq!(last["time"], 1e-3);
}

#[test]
fn vtkio_reads_a_frame_with_all_its_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    common::run_ogive(folder.path(), &[]);
    let vtk = Vtk::import(folder.path().join("ogive_0003.vtu")).expect("a frame");
    let vtkio::model::DataSet::UnstructuredGrid { pieces, .. } = vtk.data else { panic!("an unstructured grid") };
    let vtkio::model::Piece::Inline(piece) = &pieces[0] else { panic!("an inline piece") };
    assert_eq!(piece.cells.types.len(), 20);
    let names =
        |arrays: &[vtkio::model::Attribute]| -> Vec<String> { arrays.iter().map(|a| a.name().to_owned()).collect() };
    assert_eq!(names(&piece.data.point), ["U", "V", "NODE", "NSET_NOSE", "NSET_REF"]);
    assert_eq!(names(&piece.data.cell)[..5], ["PRESSURE", "NORMAL_VELOCITY", "LAYER", "ELEMENT", "MATERIAL"]);
}

/// Pictures drawn by pyvista: no pixel of deleted elements, the deformed shape equals the warped one and differs from
/// the initial one; the body of revolution is as high and as wide as its meridian, and a tensor glyph as long as the
/// largest eigenvalue.
#[test]
fn pyvista_pictures_match_the_results() {
    let Some(python) = python() else { return };
    if !Command::new(&python).args(["-c", "import pyvista"]).output().is_ok_and(|o| o.status.success()) {
        assert!(std::env::var_os("CI").is_none(), "in CI pyvista must be installed");
        return println!("left out: pictures (no pyvista)");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    for points in ["current", "reference"] {
        let output =
            common::revolve(&["run", "input/rod_plate_deletion.inp", "-q", "-o", &out(points), "--points", points]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/pictures.py");
    let series = ["current", "reference"].map(|points| format!("{}/rod_plate_deletion.pvd", out(points)));
    let output = Command::new(python).arg(script).args(series).arg(folder.path()).output().expect("python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    println!("{found}");
    let number = |key: &str| found[key].as_f64().expect("a number");
    assert!(number("gone") > 1.0 && number("drawn") > 1e4, "{found}");
    assert_eq!(number("warped_differs"), 0.0, "{found}");
    assert!(number("undeformed_differs") > 0.1 * number("drawn"), "{found}");
    for (i, wide) in [0, 1].into_iter().zip(found["width"].as_array().expect("numbers")) {
        let high = found["height"][i].as_f64().expect("a number");
        assert!(high.abs() < 1e-5 && wide.as_f64().is_some_and(|w| (w - 1.0).abs() < 1e-6), "{found}");
    }
    // A sphere of 64 by 64 facets.
    assert!(number("glyph") < 0.01, "{found}");
}

/// The last frame of a perforation with element deletion: VTK, PyVista and vedo see as many cells as remain, and the bounding
/// box, the area and the largest average at nodes that follow from the arrays in the file, as meshio reads them. No point
/// is beyond the axis.
#[test]
fn readers_see_no_deleted_elements() {
    let Some(python) = python() else { return };
    if !Command::new(&python).args(["-c", "import meshio, pyvista, vedo"]).output().is_ok_and(|o| o.status.success()) {
        assert!(std::env::var_os("CI").is_none(), "in CI meshio, pyvista and vedo must be installed");
        return println!("left out: other readers (no meshio, pyvista or vedo)");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let name = |ending: &str| folder.path().join(format!("rod_plate_deletion{ending}"));
    let out = folder.path().to_str().expect("a name");
    let output = common::revolve(&["run", "input/rod_plate_deletion.inp", "-q", "-o", out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/readers.py");
    let output = Command::new(python).arg(script).arg(name("_0020.vtu")).output().expect("python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let summary = std::fs::read_to_string(name(".json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let deleted = summary["deleted_elements"].as_u64().expect("a number");
    assert!(deleted > 0);
    let numbers = |reader: &str| -> Vec<f64> {
        let entry = &found[reader];
        let bounds = entry["bounds"].as_array().expect("bounds");
        bounds.iter().chain([&entry["area"], &entry["peeq"]]).filter_map(serde_json::Value::as_f64).collect()
    };
    let expected = numbers("meshio");
    assert!(expected.len() == 8 && expected[0] == 0.0, "{found}");
    for reader in ["meshio", "vtk", "pyvista", "vedo"] {
        assert_eq!(found[reader]["cells"], 280 - deleted, "{reader}");
        let pairs = || numbers(reader).into_iter().zip(&expected);
        assert!(pairs().all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs()), "{reader}: {found}");
    }
}

/// A rod through a plate with element deletion: initial points warped by U are the points of the deformed body; deleted
/// elements and their free nodes are not in the frame; tensors have the form that VTK expects.
#[test]
fn vtk_library_warps_and_reads_tensors_of_frames_without_deleted_elements() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let out = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    for (name, points) in [("now", "current"), ("start", "reference")] {
        let output =
            common::revolve(&["run", "input/rod_plate_deletion.inp", "-q", "-o", &out(name), "--points", points]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/warp_vtk.py");
    let series = |name: &str| format!("{}/rod_plate_deletion.pvd", out(name));
    let output = Command::new(python).args([script, &series("now"), &series("start")]).output().expect("python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let number = |key: &str| found[key].as_f64().expect("a number");
    assert!(number("moved") > 1.0 && number("apart") < 1e-12 * number("moved"), "{found}");
    let summary = std::fs::read_to_string(format!("{}/rod_plate_deletion.json", out("now"))).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    let deleted = summary["deleted_elements"].as_f64().expect("a number");
    assert!(deleted >= 1.0);
    assert_eq!((number("cells"), number("shown")), (280.0 - deleted, 280.0 - deleted), "{found}");
    assert!(number("smallest") > 0.0 && number("unused") == 0.0, "{found}");
    assert_eq!(found["stress"], serde_json::json!(["S11", "S22", "S33", "S12", "S23", "S13"]));
    assert_eq!(found["materials"], serde_json::json!([1, 2]));
    let elements: Vec<i64> = found["elements"].as_array().expect("numbers").iter().filter_map(|n| n.as_i64()).collect();
    let different: std::collections::BTreeSet<_> = elements.iter().collect();
    assert_eq!(different.len() as f64, 280.0 - deleted, "the deck's numbers");
}
