//! Frames of a run whose body has new meshes: reports and pictures show every frame with its own mesh.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use revolve::output::OutputFrame;
use revolve::report;
use revolve::report::data::MeridianFrames;
use revolve::user::Routines;
use serde_json::json;

use crate::browser::{HeadlessBrowser, PageView};
use crate::common::{self, revolve};

/// Settings of a coarse mesh.
pub const SETTINGS: [(&str, &str); 2] = [("nr", "4"), ("nz", "20")];

/// Writes the deck of the copper bar with new meshes, runs it into the folder, and returns its frames.
pub fn run_into(folder: &Path) -> Vec<OutputFrame> {
    let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("a deck");
    let text = text.replacen(
        "*Material, name",
        "*Remesh, elset=BAR, angle=59., frequency=40, increment=0.7\n*Material, name",
        1,
    );
    let deck = folder.join("bar.inp");
    std::fs::write(&deck, &text).expect("a deck");
    let [deck, out] = [&deck, folder].map(|path| path.to_str().expect("a name"));
    let settings = SETTINGS.map(|(name, value)| format!("{name}={value}"));
    assert!(revolve(&["run", deck, "-q", "-o", out, "-s", &settings[0], "-s", &settings[1]]).status.success());
    common::run(&text, &SETTINGS, &Routines::none()).1.frames
}

/// Returns the first frames with each mesh.
pub fn first_frames_of_meshes(frames: &[OutputFrame]) -> Vec<usize> {
    let elements = |frame: &OutputFrame| {
        let label = frame.cell_labels.iter().find(|label| label.name == "ELEMENT").expect("element numbers");
        label.values.clone()
    };
    let is_first = |i: &usize| *i == 0 || elements(&frames[*i]) != elements(&frames[*i - 1]);
    (0..frames.len()).filter(is_first).collect()
}

/// Renames the array MISES to TRIAX in a frame file, so that both fields exist in some frames only.
pub fn rename_field(folder: &Path, frame: usize) {
    let path = folder.join(format!("bar_{frame:04}.vtu"));
    let text = std::fs::read_to_string(&path).expect("a frame");
    std::fs::write(&path, text.replacen("Name=\"MISES\"", "Name=\"TRIAX\"", 1)).expect("a frame");
    // The checksum of the file is wrong now.
    std::fs::remove_file(folder.join("bar.sfv")).expect("a list of checksums");
}

fn numbers(text: &str) -> Vec<u16> {
    let bytes = STANDARD.decode(text).expect("base64");
    bytes.as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b)).collect()
}

/// Cell of a frame on the page: element number, corners `[r, z]`, and the packed value of a field.
type ShownCell = (i32, Vec<[f64; 2]>, u16);

/// Returns the cells of each frame on the page, read as the page reads them.
fn shown_frames(meridian: &MeridianFrames, field: &str) -> Vec<Vec<ShownCell>> {
    let first = (meridian.points, meridian.cells, &meridian.corners, &meridian.elements);
    let later = meridian.new_meshes.iter().map(|mesh| (mesh.points, mesh.cells, &mesh.corners, &mesh.elements));
    let meshes: Vec<_> = std::iter::once(first).chain(later).collect();
    let [r0, r1, z0, z1] = meridian.bounds;
    let levels = numbers(&meridian.places).into_iter().map(|level| f64::from(level) / 65534.0).collect::<Vec<_>>();
    let points: Vec<[f64; 2]> =
        levels.as_chunks::<2>().0.iter().map(|[r, z]| [r0 + (r1 - r0) * r, z0 + (z1 - z0) * z]).collect();
    let field = meridian.fields.iter().find(|packed| packed.name == field && packed.on_cells).expect("a field");
    let values = numbers(&field.values);
    let (mut point, mut value) = (0, 0);
    let frame = |i: usize| {
        let (point_count, cell_count, corners, elements) = meshes[meridian.mesh_of_frame.get(i).copied().unwrap_or(0)];
        let corners = numbers(corners);
        let cell = |c: usize| {
            let list = corners[4 * c..4 * c + 4].iter().filter(|p| **p != u16::MAX);
            let places = list.map(|p| points[point + usize::from(*p)]).collect();
            (elements[c], places, values[value + c])
        };
        let cells = (0..cell_count).map(cell).collect();
        point += point_count;
        value += cell_count;
        cells
    };
    let frames = (0..meridian.times.len()).map(frame).collect();
    assert_eq!((point, value), (points.len(), values.len()), "nothing is left over");
    frames
}

#[test]
fn report_shows_each_frame_with_its_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = run_into(folder.path());
    let mesh_count = first_frames_of_meshes(&frames).len();
    assert!((3..=8).contains(&mesh_count), "{mesh_count}");
    let page = report::gather(folder.path()).expect("a page");
    let meridian = page.runs[0].meridian.as_ref().expect("frames");
    assert_eq!((frames.len(), meridian.times.len(), meridian.new_meshes.len()), (21, 21, mesh_count - 1));
    assert!(page.runs[0].notes.iter().all(|note| !note.contains("frame")), "{:?}", page.runs[0].notes);
    let mises = meridian.fields.iter().find(|field| field.name == "MISES").expect("a field");
    let [r0, r1, z0, z1] = meridian.bounds;
    let level = f64::max(r1 - r0, z1 - z0) / 65534.0;
    for (frame, cells) in frames.iter().zip(shown_frames(meridian, "MISES")) {
        let labels = &frame.cell_labels.iter().find(|label| label.name == "ELEMENT").expect("numbers").values;
        let values = &frame.cell_fields.iter().find(|field| field.name == "MISES").expect("a field").values;
        assert_eq!(cells.len(), frame.cells.len(), "frame at {}", frame.time);
        for (c, (element, corners, value)) in cells.into_iter().enumerate() {
            assert_eq!(element, labels[c]);
            let cell = frame.cells.iter().nth(c).expect("a cell");
            assert_eq!(corners.len(), cell.len());
            for (corner, point) in corners.iter().zip(cell) {
                let [r, z] = frame.points[*point as usize];
                assert!((corner[0] - r).abs() <= level && (corner[1] - z).abs() <= level, "{corner:?} {r} {z}");
            }
            let page_value = mises.low + (mises.high - mises.low) * f64::from(value) / 65534.0;
            assert!((page_value - values[c]).abs() <= (mises.high - mises.low) / 65534.0, "{page_value} {}", values[c]);
        }
    }
}

#[test]
fn fields_that_some_frames_lack_have_no_values_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let last = run_into(folder.path()).len() - 1;
    rename_field(folder.path(), last);
    let page = report::gather(folder.path()).expect("a page");
    let meridian = page.runs[0].meridian.as_ref().expect("frames");
    let has_values = |field: &str| -> Vec<bool> {
        shown_frames(meridian, field).iter().map(|cells| cells.iter().all(|cell| cell.2 != u16::MAX)).collect()
    };
    let (mises, triax) = (has_values("MISES"), has_values("TRIAX"));
    assert!(mises.iter().zip(0..).all(|(has, frame)| *has == (frame != last)), "{mises:?}");
    assert!(triax.iter().zip(0..).all(|(has, frame)| *has == (frame == last)), "{triax:?}");
    assert_eq!(meridian.fields[0].name, "MISES", "the most common field comes first");
}

/// A film has all frames in one size; a frame without the field is drawn without values.
#[test]
fn films_and_pictures_show_each_frame_with_its_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = run_into(folder.path());
    let name = |file: &str| folder.path().join(file).to_str().expect("a name").to_owned();
    let out = folder.path().to_str().expect("a name");
    let chart = |arguments: &[&str]| revolve(&[&["chart", out, "-q"], arguments].concat()).status.code();
    let svg = |field: &str, frame: usize| {
        let arguments = ["--field", field, "--frame", &frame.to_string(), "--out", &name("a.svg")];
        assert_eq!(chart(&arguments), Some(0));
        std::fs::read_to_string(name("a.svg")).expect("a picture")
    };
    // Each cell on both sides; the axis, and the ticks of the colour bar.
    let cells = |text: &str| text.matches("<path").count() / 2;
    for frame in [1, 21] {
        let (drawn, expected) = (cells(&svg("MISES", frame)), frames[frame - 1].cells.len());
        assert!((expected..expected + 10).contains(&drawn), "{drawn} {expected}");
    }
    rename_field(folder.path(), 20);
    assert_eq!(chart(&["--field", "MISES", "--animate", &name("a.gif")]), Some(0));
    let film = std::fs::read(name("a.gif")).expect("a film");
    assert_eq!(film.windows(3).filter(|w| *w == [0x21, 0xf9, 0x04]).count(), frames.len());
    assert!(
        svg("MISES", 21).contains("no values in this frame") && svg("TRIAX", 1).contains("no values in this frame")
    );
    assert!(!svg("TRIAX", 21).contains("no values"));
    assert_eq!(chart(&["--field", "PRESS", "--out", &name("b.svg")]), Some(2));
}

#[test]
fn page_draws_frames_with_new_meshes_in_a_browser() {
    let Some(mut browser) = HeadlessBrowser::start() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let frames = run_into(folder.path());
    assert!(revolve(&["report", folder.path().to_str().expect("a name")]).status.success());
    let result = browser.self_test(&folder.path().join("report.html"), PageView { width: 1400, dark: false });
    assert_eq!(result["faults"], json!([]));
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
    let meridian = &result["meridians"][0];
    assert_eq!((&meridian["frames"], &meridian["different_frames"]), (&json!(frames.len()), &json!(frames.len())));
    // Both sides of the axis are drawn, so each cell twice.
    let cells: Vec<usize> = frames.iter().map(|frame| 2 * frame.cells.len()).collect();
    assert_eq!(meridian["cells"], json!(cells));
}
