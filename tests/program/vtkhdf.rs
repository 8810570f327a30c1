//! Frames in one VTKHDF file.
//!
//! Goal: VTK reads the same times, cells, points and arrays as from the `.vtu` frames, also after a kill, after a restart,
//! with deleted elements, and with arrays that only some frames have. Source: the `.pvd` series. Tolerance: none.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use revolve::output::pvd::FrameWriter;
use revolve::output::{EntityLabels, FieldArray, FrameFormat, FramePoints, FrameStyle, JobFiles, OutputFrame};
use serde_json::Value;

use crate::common;
use crate::vtk::python;

/// Runs a deck and returns the folder of its results.
fn run(folder: &Path, deck: &str, more: &[&str]) -> String {
    let out = folder.join(more.join("")).to_str().expect("a name").to_owned();
    let output = common::revolve(&[&["run", deck, "-q", "-o", &out], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

/// Compares a VTKHDF file with a series; returns the numbers of steps, frames and cells.
fn compare(python: &str, hdf: &str, pvd: &str) -> Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/read_vtkhdf.py");
    let output = Command::new(python).args([script, hdf, pvd]).output().expect("python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Writes the deck of a rod through a plate, with many frames, and returns its path.
fn many_frames(folder: &Path) -> String {
    let text = fs::read_to_string(common::project("input/rod_plate_deletion.inp")).expect("the deck");
    let [old, new] = ["*Output, field, number interval=20", "*Output, field, number interval=600"];
    assert!(text.contains(old));
    let deck = folder.join("rod.inp");
    fs::write(&deck, text.replace(old, new)).expect("a deck");
    deck.to_str().expect("a name").to_owned()
}

#[test]
fn vtkhdf_file_has_the_frames_of_the_series() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for points in ["current", "reference"] {
        let deck = "input/rod_plate_deletion.inp";
        let series = run(folder.path(), deck, &["--points", points]);
        let file = run(folder.path(), deck, &["--points", points, "--format", "vtkhdf"]);
        let [series, path] = [format!("{series}/rod_plate_deletion.pvd"), format!("{file}/rod_plate_deletion.vtkhdf")];
        let found = compare(&python, &path, &series);
        assert_eq!((&found["steps"], &found["frames"]), (&21.into(), &21.into()), "{found}");
        let summary = fs::read_to_string(format!("{file}/rod_plate_deletion.json")).expect("a summary");
        let summary: Value = serde_json::from_str(&summary).expect("JSON");
        let deleted = summary["deleted_elements"].as_u64().expect("a number");
        assert!(deleted > 0);
        assert_eq!(found["cells"][20].as_u64(), Some(280 - deleted), "{found}");
        assert!(!Path::new(&file).join("rod_plate_deletion.pvd").exists());
        let sums = fs::read_to_string(format!("{file}/rod_plate_deletion.sfv")).expect("checksums");
        assert!(sums.contains("rod_plate_deletion.vtkhdf "), "{sums}");
        // At most as large as the series, and in one file.
        let sizes = fs::read_dir(Path::new(&series).parent().expect("a folder")).expect("files");
        let frames = sizes.filter_map(Result::ok).filter(|file| file.path().extension().is_some_and(|e| e == "vtu"));
        let of_frames: u64 = frames.map(|file| file.metadata().expect("a size").len()).sum();
        assert!(fs::metadata(&path).expect("a size").len() < of_frames);
    }
    let report = common::revolve(&["report", &folder.path().join("--pointscurrent--formatvtkhdf").to_string_lossy()]);
    assert!(report.status.success(), "{}", String::from_utf8_lossy(&report.stderr));
}

/// Killed runs leave complete frames, which a restart continues.
#[test]
#[cfg(unix)]
fn vtkhdf_frames_survive_kills_and_restarts() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let deck = many_frames(folder.path());
    let series = format!("{}/rod.pvd", run(folder.path(), &deck, &[]));
    let out = folder.path().join("killed");
    let path = out.join("rod.vtkhdf");
    let (hdf, out_name) = (path.to_str().expect("a name"), out.to_str().expect("a name"));
    let mut early = 0;
    for size in [0, 200_000, 900_000, 2_500_000, 5_000_000] {
        let options = ["-q", "-o", out_name, "--format", "vtkhdf", "--checkpoint-every", "100"];
        fs::remove_file(&path).ok();
        let mut child = Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args(["run", &deck])
            .args(options)
            .stdout(Stdio::null())
            .spawn()
            .expect("the program runs");
        while fs::metadata(&path).map_or(0, |file| file.len()) <= size && child.try_wait().expect("a state").is_none() {
            sleep(Duration::from_micros(500));
        }
        // The file is valid from its first frame on.
        let is_over = child.try_wait().expect("a state").is_some();
        child.kill().ok();
        child.wait().expect("an end");
        if size > 0 {
            let found = compare(&python, hdf, &series);
            assert!(is_over || found["steps"].as_u64() >= Some(1), "{found}");
            early += u32::from(found["steps"] != found["frames"]);
        }
    }
    assert!(early >= 2, "kills before the end: {early}");
    let refused = common::revolve(&["run", &deck, "-q", "-o", out_name, "--resume"]);
    let message = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success() && message.contains("use --format vtkhdf"), "{message}");
    let resumed = common::revolve(&["run", &deck, "-q", "-o", out_name, "--resume", "--format", "vtkhdf"]);
    assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
    let found = compare(&python, hdf, &series);
    assert_eq!(found["steps"], found["frames"]);
    let summary = fs::read_to_string(out.join("rod.json")).expect("a summary");
    assert!(summary.contains("\"resumed_at\""), "the run was restarted from a checkpoint");
}

/// Frames of another mesh and another set of arrays each, so that all parts of the file grow.
#[test]
fn vtkhdf_file_has_meshes_and_arrays_of_some_frames_only() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let path = |format: FrameFormat| folder.path().join("job").with_extension(&format.suffix()[1..]);
    for format in [FrameFormat::Pvd, FrameFormat::Vtkhdf] {
        let job = JobFiles { folder: folder.path().to_owned(), name: "job".into() };
        let style = FrameStyle { points: FramePoints::Current, format };
        let own = folder.path().join(format.suffix());
        fs::create_dir(&own).expect("a folder");
        let mut writer =
            FrameWriter::new(JobFiles { folder: own.clone(), ..job }, style, String::new()).expect("a series");
        for k in 0..600 {
            writer.write(&changing_frame(k)).expect("a frame");
        }
        let name = path(format);
        fs::rename(own.join(name.file_name().expect("a name")), &name).expect("a file");
        if format == FrameFormat::Pvd {
            for entry in fs::read_dir(&own).expect("files").filter_map(Result::ok) {
                fs::rename(entry.path(), folder.path().join(entry.file_name())).expect("a frame");
            }
        }
    }
    let [pvd, hdf] = [FrameFormat::Pvd, FrameFormat::Vtkhdf].map(|format| path(format).to_string_lossy().into_owned());
    assert_eq!(compare(&python, &hdf, &pvd)["steps"], 600);
}

/// Returns a strip of squares and triangles whose length depends on the frame.
fn changing_frame(k: usize) -> OutputFrame {
    let count = 3 + (k / 7) % 50;
    let points: Vec<[f64; 2]> =
        (0..2 * count + 2).map(|i| [(i / 2) as f64 + 1e-3 * k as f64, (i % 2) as f64]).collect();
    let cells = (0..count).map(|c| {
        let corners = [2 * c, 2 * c + 2, 2 * c + 3, 2 * c + 1];
        if c % 3 == 1 { corners[..3].to_vec() } else { corners.to_vec() }
    });
    let field = |name: &str, components: usize, names: &[&str], length: usize| FieldArray {
        name: name.into(),
        components,
        component_names: names.iter().map(|&name| name.into()).collect(),
        values: (0..components * length).map(|i| (i * k) as f64 / 7.0).collect(),
    };
    let mut frame = OutputFrame {
        time: k as f64,
        start: points.clone(),
        point_fields: vec![field("V", 2, &["V1", "V2"], points.len())],
        cell_labels: vec![EntityLabels { name: "ELEMENT".into(), values: (1..=count as i32).collect() }],
        cells: cells.collect(),
        points,
        ..OutputFrame::default()
    };
    if k % 4 != 1 {
        frame.cell_fields.push(field("S", 4, &["S11", "S22", "S33", "S12"], count));
    }
    if k > 10 {
        frame.cell_fields.push(field("LATE", 1, &[], count));
    }
    frame
}
