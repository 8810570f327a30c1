//! `revolve report`: the data read from a folder, the contents of the page, and the page in a browser.

use std::path::Path;
use std::process::Output;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use revolve::report;
use revolve::report::data::MeridianFrames;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use tiny_skia::{Pixmap, PremultipliedColorU8};

use crate::browser::{HeadlessBrowser, PageView};
use crate::common::{self, revolve};

/// A desktop screen with a light theme.
const DESK: PageView = PageView { width: 1400, dark: false };

fn folder() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let name = folder.path().to_str().expect("a name").to_owned();
    (folder, name)
}

/// Runs a deck of the project into a folder.
fn run(deck: &str, out: &str, settings: &[&str]) -> Output {
    let mut arguments = vec!["run", deck, "--quiet", "--out", out];
    settings.iter().for_each(|s| arguments.extend(["--set", s]));
    revolve(&arguments)
}

fn numbers(text: &str) -> Vec<u16> {
    let bytes = STANDARD.decode(text).expect("base64");
    bytes.as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b)).collect()
}

/// Returns the smallest and largest z of a frame on the page.
fn extent(meridian: &MeridianFrames, frame: usize) -> [f64; 2] {
    let [_, _, low, high] = meridian.bounds;
    let places = numbers(&meridian.places);
    let points = |frame: usize| match meridian.mesh_of_frame.get(frame) {
        Some(&mesh) if mesh > 0 => meridian.new_meshes[mesh - 1].points,
        _ => meridian.points,
    };
    let first: usize = (0..frame).map(points).sum();
    let of_frame = &places[2 * first..2 * (first + points(frame))];
    let z = of_frame.iter().skip(1).step_by(2).map(|&q| low + (high - low) * f64::from(q) / 65534.0);
    z.fold([f64::INFINITY, f64::NEG_INFINITY], |e, z| [e[0].min(z), e[1].max(z)])
}

#[test]
fn rigid_run_shows_frames_histories_ledger_and_target() {
    let (folder, out) = folder();
    assert!(run("input/ogive.inp", &out, &[]).status.success());
    let page = report::gather(folder.path()).expect("a page");
    assert_eq!((page.runs.len(), page.sweeps.len(), page.studies.len()), (1, 0, 0));
    let run = &page.runs[0];
    let titles: Vec<&str> = run.charts.iter().map(|c| c.title.as_str()).collect();
    assert_eq!(titles, ["Energy balance", "Energy", "U2", "V2", "A2", "Increment"]);
    let energies: Vec<&str> = run.charts[1].series.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(energies, ["ALLKE", "ALLCAV", "ETOTAL"], "those that are not always zero");
    let limits: Vec<&str> = run.charts[5].series.iter().map(|s| s.name.as_str()).collect();
    assert!(limits.contains(&"accuracy of the motion") && limits.contains(&"a body comes to rest"), "{limits:?}");
    assert!(run.summary.get("history").is_none() && run.summary["ledger"]["effects"].is_array());
    assert_eq!(run.summary["scene"]["targets"][0]["layers"][0], json!({"material": "AL6061", "thickness": 0.5}));

    let meridian = run.meridian.as_ref().expect("frames");
    assert_eq!((meridian.times.len(), meridian.cells, meridian.points), (21, 20, 21));
    // The tip starts at the front face and stops at the depth in the summary; coordinates have 65535 levels.
    let depth = run.columns.iter().find(|c| c.name == "U2@REF").expect("a column").last;
    let step = (meridian.bounds[3] - meridian.bounds[2]) / 65534.0;
    assert!((extent(meridian, 0)[0]).abs() <= step, "{:?}", extent(meridian, 0));
    assert!((extent(meridian, 20)[0] - depth).abs() <= step, "{:?} {depth}", extent(meridian, 20));
    let pressure = meridian.fields.iter().find(|f| f.name == "PRESSURE").expect("a field");
    assert!(pressure.on_cells && numbers(&pressure.values).len() == 21 * 20);
    assert!(pressure.high > 276e6 * 5.0394, "more than A Y at high velocity: {}", pressure.high);
}

#[test]
fn deformable_run_shows_its_shape_and_limiting_element() {
    let (folder, out) = folder();
    assert!(run("input/taylor_copper.inp", &out, &["nr=5", "nz=28"]).status.success());
    let page = report::gather(folder.path()).expect("a page");
    let run = &page.runs[0];
    let meridian = run.meridian.as_ref().expect("frames");
    let final_length = run.columns.iter().find(|c| c.name == "COOR2@TIP").expect("a column").last;
    let [low, high] = extent(meridian, meridian.times.len() - 1);
    // The rear face is flat within some micrometres; a level of the coordinates is half a micrometre.
    assert!((high - low - final_length).abs() < 1e-5, "{low} {high} {final_length}");
    let names: Vec<&str> = meridian.fields.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(&names[..3], ["MISES", "PEEQ", "|V|"]);
    assert!(!names.contains(&"S_MISES"), "not twice");
    let shortest = run.summary["steps"][0]["limiting_element"].as_str().expect("an element");
    let limits = run.charts.iter().find(|c| c.title == "Increment").expect("a chart");
    let name = format!("element {shortest}");
    assert!(limits.series.iter().any(|s| s.name == name || s.words.contains(&name)), "{limits:?}");
    let velocity = meridian.fields.iter().find(|f| f.name == "V2").expect("a field");
    assert!((velocity.low + 227.0).abs() < 23.0, "the bar starts at -227: {}", velocity.low);
}

/// The page hides elements with STATUS below half of its range; without deletion none may be hidden.
#[test]
fn no_element_is_hidden_without_deletion() {
    let (folder, out) = folder();
    let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("a deck");
    let text = text.replace("*Element Output\n", "*Element Output\n STATUS\n");
    let deck = folder.path().join("whole.inp");
    std::fs::write(&deck, text).expect("a deck");
    assert!(run(deck.to_str().expect("a name"), &out, &["nr=4", "nz=20"]).status.success());
    let page = report::gather(folder.path()).expect("a page");
    let fields = &page.runs[0].meridian.as_ref().expect("frames").fields;
    let status = fields.iter().find(|f| f.name == "STATUS").expect("a field");
    assert_eq!([status.low, status.high], [0.0, 1.0]);
    assert!(numbers(&status.values).iter().all(|v| *v == 65534), "all are shown");
}

#[test]
fn large_run_stays_within_the_size_limit() {
    let (folder, out) = folder();
    let name = folder.path().join("large.inp");
    // A hundred frames of 14 400 elements in some hundred increments.
    let text = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("a deck");
    let text = text.replace(", 80.e-6", ", 1.e-6").replace("field, number interval=20", "field, number interval=100");
    std::fs::write(&name, text).expect("a deck");
    assert!(run(name.to_str().expect("a name"), &out, &["nr=60", "nz=240"]).status.success());
    let page = report::gather(folder.path()).expect("a page");
    let run = &page.runs[0];
    let meridian = run.meridian.as_ref().expect("frames");
    assert!(meridian.cells <= report::CELLS && meridian.cells > report::CELLS / 4, "{}", meridian.cells);
    assert!(meridian.times.len() <= report::FRAMES && meridian.times.len() >= 10, "{}", meridian.times.len());
    assert_eq!(meridian.times.last(), Some(&1e-6), "the last frame is among them");
    assert!(run.notes.iter().any(|n| n.contains("drawn coarser")), "{:?}", run.notes);
    assert!(run.notes.iter().any(|n| n.contains("frames are shown")), "{:?}", run.notes);
    let html = report::html(&page).expect("a page");
    assert!(html.len() < report::BYTES + 500_000, "{} bytes", html.len());
}

#[test]
fn halted_and_frameless_runs_and_empty_folders_are_reported() {
    let text = common::ogive();
    let (halted, out) = folder();
    let deck = halted.path().join("stuck.inp");
    // A force for which the acceleration overflows.
    std::fs::write(&deck, text.replace("*Output, field", "*Cload\n REF, 2, -1.e308\n*Output, field")).expect("a deck");
    let output = run(deck.to_str().expect("a name"), &out, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let page = report::gather(halted.path()).expect("a page");
    assert_eq!(page.runs[0].summary["status"], "halted");
    assert!(page.runs[0].summary["reason"].as_str().is_some_and(|r| r.starts_with("R203")));

    let (bare, out) = folder();
    let deck = bare.path().join("bare.inp");
    let field = text.find("*Output, field").expect("a card")..text.find("*Output, history").expect("a card");
    // With an unknown variable, so that there is a warning.
    std::fs::write(&deck, text.replace(&text[field], "").replace("U2, V2, A2", "U2, V2, A2, VV2")).expect("a deck");
    assert!(run(deck.to_str().expect("a name"), &out, &[]).status.success());
    let page = report::gather(bare.path()).expect("a page");
    assert!(page.runs[0].meridian.is_none());
    assert!(page.runs[0].notes.iter().any(|n| n.starts_with("there are no frames")), "{:?}", page.runs[0].notes);

    let finding = &page.runs[0].summary["diagnostics"][0];
    assert_eq!((&finding["code"], &finding["severity"]), (&json!("M141"), &json!("warning")));
    assert!(finding["place"].as_str().is_some_and(|p| p.contains("bare.inp:")), "{finding}");

    let (_empty, out) = folder();
    for (folder, word) in [(out.as_str(), "contains no run"), ("no/such/folder", "no/such/folder")] {
        let output = revolve(&["report", folder]);
        assert_eq!(output.status.code(), Some(2));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(message.starts_with("error: ") && message.contains(word), "{message}");
    }
}

#[test]
fn damaged_frames_are_rejected_with_a_message() {
    let (folder, out) = folder();
    common::run_ogive(folder.path(), &[]);
    std::fs::write(folder.path().join("ogive_0003.vtu"), "<VTKFile>").expect("a file");
    let output = revolve(&["report", &out]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("ogive_0003.vtu"));
    assert!(!folder.path().join("report.html").exists());
}

/// The colour bar has the given range, smooth shading divides elements, and an animation has all frames.
#[test]
fn pictures_of_frames_have_a_colour_bar_and_animations_all_frames() {
    let (folder, out) = folder();
    let deck = ["input/validation/taylor_bar.inp", "--set", "nr=4", "--set", "time=20e-6"];
    assert!(revolve(&[&["run", deck[0], "--out", &out], &deck[1..]].concat()).status.success());
    let file = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let draw = |arguments: &[&str]| {
        let output = revolve(&[&["chart", &out][..], arguments].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let svg = |arguments: &[&str]| {
        assert_eq!(draw(&[arguments, &["--field", "PEEQ", "--out", &file("a.svg")]].concat()).0, Some(0));
        std::fs::read_to_string(file("a.svg")).expect("a picture")
    };
    let plain = svg(&["--range", "0..2"]);
    assert!(plain.contains("PEEQ (0 to 2)") && plain.contains(">0.5<") && plain.contains(">1.5<"), "{plain}");
    let paths = |text: &str| text.matches("<path").count();
    assert!(paths(&svg(&["--smooth", "--range", "run"])) > 8 * paths(&plain));
    // A window of 2 x 10 mm is drawn five times as high as wide, with marks up to 10 mm.
    let part = svg(&["--window", "0..10e-3,1e-3"]);
    let size = |text: &str, name: &str| -> f64 {
        let (_, rest) = text.split_once(&format!("{name}=\"")).expect("a size");
        rest.split('"').next().and_then(|number| number.parse().ok()).expect("a number")
    };
    let (_, clip) = part.split_once("<clipPath").expect("a plot");
    let ratio = size(clip, "height") / size(clip, "width");
    assert!((ratio.max(1.0 / ratio) - 5.0).abs() < 0.01 && part != plain, "{ratio}");
    assert_eq!(draw(&["--field", "PEEQ", "--animate", &file("a.gif"), "--duration", "1"]).0, Some(0));
    let animation = std::fs::read(file("a.gif")).expect("an animation");
    // Each frame has a graphic control extension, here with a delay of 0.33 s.
    let control = [0x21, 0xf9, 0x04];
    let delays: Vec<u8> = animation.windows(5).filter(|w| w[..3] == control).map(|w| w[4]).collect();
    assert!(animation.starts_with(b"GIF89a") && delays == [33; 3], "{delays:?}");
    for (arguments, word) in [
        (&["--field", "PEEQ", "--range", "2..1"][..], "LOW..HIGH"),
        (&["--field", "PEEQ", "--window", "1..0,1"], "LOW..HIGH,R"),
        (&["--field", "PEEQ", "--animate", "a.mp4"], ".gif"),
        (&["--field", "PEEQ", "--animate", "a.gif", "--duration", "0"], "--duration 0"),
    ] {
        let (status, message) = draw(arguments);
        assert!(status == Some(2) && message.contains(word), "{message}");
    }
}

#[test]
fn chart_command_writes_charts_and_pictures() {
    let (folder, out) = folder();
    assert!(run("input/ogive.inp", &out, &[]).status.success());
    let draw = |arguments: &[&str], file: &str| {
        let file = folder.path().join(file);
        let output = revolve(&[&["chart", &out][..], arguments, &["--out", file.to_str().expect("a name")]].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), message, std::fs::read(file).unwrap_or_default())
    };
    let svg = |arguments: &[&str]| {
        let (status, message, bytes) = draw(arguments, "a.svg");
        assert_eq!(status, Some(0), "{message}");
        String::from_utf8(bytes).expect("text")
    };
    let columns = svg(&["--column", "u2@ref", "--column", "V2@REF"]);
    assert!(columns.contains("U2@REF") && columns.contains("V2@REF"));
    assert!(svg(&["--energy"]).contains("opening the cavity"));
    let named = svg(&["--column", "U2@REF", "--label", "U2@REF=depth of the tip"]);
    assert!(named.contains("depth of the tip") && !named.contains("U2@REF"));
    let filtered = svg(&["--column", "V2@REF", "--filter", "5000"]);
    assert!(filtered != svg(&["--column", "V2@REF"]));
    // Twenty facets on both sides of the axis, the axis, and the ticks of the colour bar, of which each has a label.
    let picture = svg(&["--field", "PRESSURE", "--frame", "3"]);
    assert!((2 * 20 + 1 + 2..2 * 20 + 1 + 10).contains(&picture.matches("<path").count()));
    assert!(picture.contains("BLOCK: AL6061") && picture.contains("frame 3 of 21"));
    let (_, _, png) = draw(&["--field", "V2"], "a.png");
    assert!(png.starts_with(b"\x89PNG") && png.len() > 5000, "{}", png.len());
    for (arguments, file, word) in [
        (&["--column", "U2@REFF"][..], "b.png", "did you mean `U2@REF`?"),
        (&["--field", "MISES"], "b.png", "there is no field `MISES`"),
        (&["--column", "V2@REF", "--filter", "1e9"], "b.png", "needs one every"),
        (&["--field", "V2", "--frame", "22"], "b.png", "the run has 21"),
        (&["--energy"], "b.gif", ".png or .svg"),
        (&["--energy", "--frame", "1"], "b.png", "--frame"),
        (&[], "b.png", "--energy"),
        (&["--column", "U2@REF", "--label", "V2@REF=speed"], "b.png", "there is no quantity `V2@REF`"),
        (&["--column", "U2@REF", "--label", "depth"], "b.png", "COLUMN=TEXT"),
    ] {
        let (status, message, bytes) = draw(arguments, file);
        assert_eq!(status, Some(2), "{arguments:?}");
        assert!(message.contains(word) && bytes.is_empty(), "{message}");
    }
}

/// A reference curve that is the shifted result has exactly this shift as deviation, in the chart command and in the
/// report.
#[test]
fn reference_curves_are_compared_by_their_rms() {
    let (folder, out) = folder();
    common::run_ogive(folder.path(), &[]);
    let history = std::fs::read_to_string(folder.path().join("ogive_history.csv")).expect("a history");
    let column = history.lines().next().and_then(|h| h.split(',').position(|c| c == "U2@REF")).expect("a column");
    let shifted = |line: &str| {
        let fields: Vec<f64> = line.split(',').map(|f| f.parse().expect("a number")).collect();
        format!("{},{}\n", fields[0], fields[column] + 1.5e-3)
    };
    let curve: String = history.lines().skip(1).step_by(7).map(shifted).collect();
    let file = folder.path().join("curve.csv");
    let put = |head: &str, tail: &str| std::fs::write(&file, format!("{head}\n{curve}{tail}")).expect("a file");
    put("time,u2@ref", "1.,0.\n");
    let file = file.to_str().expect("a name");
    let picture = folder.path().join("chart.svg");
    let arguments =
        ["chart", &out, "--column", "U2@REF", "--compare", file, "--out", picture.to_str().expect("a name")];
    let output = revolve(&arguments);
    let message_text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(message_text.contains("rms deviation of U2@REF from the reference: 1.50000e-3"), "{message_text}");
    assert!(message_text.contains("times outside the run: 1"), "{message_text}");
    assert!(std::fs::read_to_string(&picture).expect("a picture").contains("U2@REF, reference"));
    let label = ["--label", "U2@REF=depth"];
    let output = revolve(&[&["report", &out, "--compare", file][..], &label].concat());
    assert!(String::from_utf8_lossy(&output.stdout).contains("1.50000e-3"), "{output:?}");
    let html = std::fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(html.contains("U2@REF, reference") && html.contains("\"name\":\"depth\""));
    put("time,U2@TIPP", "");
    let output = revolve(&["report", &out, "--compare", file]);
    let message_text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code() == Some(2) && message_text.contains("the history has no column `U2@TIPP`"),
        "{message_text}"
    );
}

/// Ten by ten elements with nodal forces have a large hourglass energy, which is reported in all outputs.
#[test]
fn energies_out_of_bounds_are_reported_everywhere() {
    let (folder, out) = folder();
    let output = revolve(&["run", "input/gauntlet/point_load.inp", "--out", &out]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && message.contains("warning: R302: ALLAE is "), "{message}");
    let page = report::gather(folder.path()).expect("a page");
    let message_text = page.runs[0].summary["warnings"][0].as_str().expect("a warning").to_owned();
    assert!(
        message_text.contains("since time") && message_text.contains("The largest hourglass distortion is in element"),
        "{message_text}"
    );
    assert!(message.contains(&message_text) && report::html(&page).expect("a page").contains("ALLAE is "));

    let Some(mut browser) = HeadlessBrowser::start() else { return };
    assert!(revolve(&["report", &out]).status.success());
    let result = browser.self_test(&folder.path().join("report.html"), DESK);
    assert_eq!((&result["faults"], &result["warnings"]), (&json!([]), &json!([message_text])));
}

/// The page has the tables and pictures of `limit`, `identify` and `scatter`, and no picture of an earlier command.
#[test]
fn searches_show_their_tables_and_pictures() {
    let (folder, out) = folder();
    let search = |words: &[&str]| {
        let output = revolve(&[words, &["--quiet", "--out", &out]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let quantity = "-1000*final(U2@REF)";
    let shots = ["--shots", "input/reference/shots_6061.csv", "--measured", "depth", "--quantity", quantity];
    search(&["limit", "input/plate_6061.inp", "--velocity", "V", "--tolerance", "1", "--between", "200,900"]);
    search(&["scatter", "input/plate_6061.inp", "-d", "V=500..600", "--quantity", "-final(V2@REF)", "--count", "8"]);
    search(&[&["identify", "input/ogive.inp", "--unknown", "A=4", "--set", "B=0.983"][..], &shots].concat());
    std::fs::write(folder.path().join("plate_6061_limit_scatter.svg"), "<svg/>").expect("an old picture");
    let page = report::gather(folder.path()).expect("a page");
    assert_eq!(page.title, "ogive, plate_6061");
    for (found, [title, name]) in page.searches.iter().zip([
        ["Limit", "plate_6061_limit"],
        ["Identification", "ogive_identify"],
        ["Scatter", "plate_6061_scatter"],
    ]) {
        let csv = std::fs::read_to_string(folder.path().join(format!("{name}.csv"))).expect("a table");
        assert_eq!((found.title, found.table.rows.len() + 1), (title, csv.lines().count()));
        assert_eq!(Some(found.table.header.join(",").as_str()), csv.lines().next());
        let pictures: Vec<&str> = found.pictures.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(pictures, [format!("{name}.svg")]);
        assert!(found.pictures[0].source.starts_with("data:image/svg+xml;base64,"));
    }
    let limit = &page.searches[0].table.rows[0];
    assert!(revolve(&["report", &out, "--quiet"]).status.success());
    let path = folder.path().join("report.html");
    let html = std::fs::read_to_string(&path).expect("a page");
    assert!(html.contains(&serde_json::to_string(limit).expect("a row")), "{limit:?}");

    let Some(mut browser) = HeadlessBrowser::start() else { return };
    for view in [420, 1400].into_iter().flat_map(|width| [false, true].map(|dark| PageView { width, dark })) {
        let result = browser.self_test(&path, view);
        assert_eq!((&result["faults"], &result["overflow"], &result["wide"]), (&json!([]), &json!(0), &json!([])));
        assert_eq!((&result["tables"], &result["pictures"]), (&json!(3), &json!(3)), "{view:?}");
        assert!(browser.errors.is_empty() && browser.requests.is_empty(), "{:?}", browser.errors);
        browser.open(&path, "", view);
        let picture = browser.picture("img.picture");
        let light = picture.pixels()[0].red() > 128;
        assert!(light != view.dark && picture.width() > 240, "{view:?}");
    }
}

#[test]
fn page_works_in_a_browser_without_network() {
    let (folder, out) = folder();
    let sweep = "V=569,821,1147";
    let quantity = "-1000*final(U2@REF)";
    let reference = "input/reference/piekutowski_1999.csv";
    assert!(run("input/taylor_copper.inp", &out, &["nr=4", "nz=20", "speed=100"]).status.success());
    assert!(run("input/ogive.inp", &out, &[]).status.success());
    let arguments =
        ["sweep", "input/ogive.inp", "--quiet", "--set", sweep, "--quantity", quantity, "--compare", reference];
    assert!(revolve(&[&arguments[..], &["--out", &out]].concat()).status.success());
    let study = ["study", "input/ogive.inp", "--quiet", "--refine", "n=5,10,20", "--quantity", quantity];
    assert!(revolve(&[&study[..], &["--out", &out]].concat()).status.success());
    let output = revolve(&["report", &out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = folder.path().join("report.html");
    let html = std::fs::read_to_string(&page).expect("a page");
    assert!(html.contains("default-src 'none'"));
    for reference in ["http:", "https:", " src=", "url(", "@import", "fetch(", "XMLHttpRequest"] {
        let found = html.matches(reference).count();
        // The only address is the SVG namespace.
        assert_eq!(found, usize::from(reference == "http:"), "{reference}");
    }

    let Some(mut browser) = HeadlessBrowser::start() else { return };
    let result = browser.self_test(&page, DESK);
    assert_eq!(result["faults"], json!([]));
    assert_eq!((&result["requests"], &browser.requests[..]), (&json!([]), &[][..]), "nothing is fetched");
    assert!(browser.errors.is_empty(), "{:?}", browser.errors);
    assert_eq!(result["not_a_number"], false);
    // Six charts of the ogive, seven of the bar, two of the sweep, one of the study.
    assert_eq!(result["charts"], 16);
    assert_eq!(result["tips"], 16, "every chart has a cursor");
    let list = |key: &str| result[key].as_array().expect("a list").clone();
    assert!(list("axes").iter().all(|n| *n == 2) && list("ticks").iter().all(|n| n.as_u64() >= Some(6)));
    for zoom in list("zooms") {
        let [near, whole] = [0, 1].map(|i| zoom[i].as_f64().expect("a part"));
        assert!((0.15..0.35).contains(&near) && (whole - 1.0).abs() < 1e-9, "{zoom}");
    }
    assert_eq!(result["areas"], 2 + 5, "kinetic and cavity; the bar's five energies");
    assert!(result["legends"].as_u64() >= Some(40), "{}", result["legends"]);
    let meridians = result["meridians"].as_array().expect("pictures");
    assert_eq!(meridians.len(), 2);
    // The projectile is at rest after 221 microseconds: frames 0 to 4 differ, all later frames equal the fifth.
    assert_eq!((&meridians[0]["frames"], &meridians[0]["different_frames"]), (&json!(21), &json!(6)));
    assert_eq!((&meridians[1]["frames"], &meridians[1]["different_frames"]), (&json!(21), &json!(21)));
    assert_eq!(
        meridians[1]["different_fields"],
        meridians[1]["fields"].as_array().map_or(json!(0), |f| json!(f.len()))
    );
}

/// The policy permits the script of the page by its hash and no other: a script that is added to a page does not run.
#[test]
fn page_policy_permits_only_the_script_of_the_page() {
    let (folder, out) = folder();
    assert!(run("input/ogive.inp", &out, &[]).status.success());
    assert!(revolve(&["report", &out]).status.success());
    let path = folder.path().join("report.html");
    let html = std::fs::read_to_string(&path).expect("a page");
    let between = |begin: &str, end: &str| {
        let from = html.find(begin).expect("the beginning") + begin.len();
        &html[from..from + html[from..].find(end).expect("the end")]
    };
    let permitted = between("script-src 'sha256-", "'");
    let script = between("<script>", "</script>");
    assert_eq!(permitted, STANDARD.encode(Sha256::digest(script.as_bytes())));
    assert!(!between("script-src ", ";").contains("unsafe-inline"));

    let Some(mut browser) = HeadlessBrowser::start() else { return };
    let foreign = html.replace("</body>", "<script>document.title = 'foreign'</script></body>");
    assert_ne!(foreign, html);
    std::fs::write(&path, &foreign).expect("a page");
    browser.open(&path, "", DESK);
    assert_ne!(browser.value("document.title"), json!("foreign"));
    assert!(browser.value("document.querySelectorAll('svg').length").as_u64() > Some(0), "the page's script runs");
    std::fs::write(&path, foreign.replace(&format!("'sha256-{permitted}'"), "'unsafe-inline'")).expect("a page");
    browser.open(&path, "", DESK);
    assert_eq!(browser.value("document.title"), json!("foreign"));
}

/// On a phone and a desktop screen, light and dark, with units: nothing is cut off, too small or too low in contrast,
/// curves can be hidden and removed, and the body is visible.
#[test]
fn page_is_readable_on_any_screen_with_units() {
    let (folder, out) = folder();
    let deck = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("a deck");
    let path = folder.path().join("bar.inp");
    std::fs::write(&path, deck).expect("a deck");
    let deck = path.to_str().expect("a name");
    assert!(run(deck, &out, &["nr=4", "nz=20"]).status.success());
    let ablation = ["study", "input/ogive.inp", "--quiet", "--ablate", "--refine", "n=5,10", "--out", &out];
    assert!(revolve(&[&ablation[..], &["--quantity", "-1000*final(U2@REF)"]].concat()).status.success());
    assert!(revolve(&["report", &out]).status.success());
    let page = folder.path().join("report.html");
    let Some(mut browser) = HeadlessBrowser::start() else { return };
    for view in [420, 1000, 1400].into_iter().flat_map(|width| [false, true].map(|dark| PageView { width, dark })) {
        let result = browser.self_test(&page, view);
        assert_eq!((&result["faults"], &result["width"]), (&json!([]), &json!(view.width)), "{view:?}");
        assert!(
            browser.errors.is_empty() && browser.requests.is_empty(),
            "{:?} {:?}",
            browser.errors,
            browser.requests
        );
        assert_eq!((&result["overflow"], &result["wide"]), (&json!(0), &json!([])), "{view:?}");
        assert!(result["smallest_text"].as_f64().is_some_and(|s| s >= 11.0), "{view:?}: {}", result["smallest_text"]);
        // WCAG 2, level AA.
        assert!(result["contrast"][0].as_f64().is_some_and(|c| c >= 4.5), "{view:?}: {}", result["contrast"]);
        assert_eq!(result["switched"], 1, "one line is hidden");
        assert!(result["effects"].as_u64() >= Some(2), "{}", result["effects"]);
        let fields: Vec<u64> = result["csv"].as_array().expect("lines").iter().filter_map(Value::as_u64).collect();
        assert!(fields.len() > 20 && fields.iter().all(|n| *n == fields[0]), "{fields:?}");
        let labels = result["y_labels"].to_string();
        assert!(labels.contains("energy, J") && labels.contains("U2, 10⁻³ m\""), "{labels}");
        look_at(&mut browser, &page, view);
    }
}

/// Checks the picture of the page: background of the theme, the coloured body, the coloured curves.
fn look_at(browser: &mut HeadlessBrowser, page: &Path, view: PageView) {
    browser.open(page, "", view);
    let ground = browser.picture("header");
    let light = ground.pixels()[0].red() > 128;
    assert_eq!(light, !view.dark, "{view:?}");
    // Colours of viridis and of curves are far from grey.
    let coloured = |picture: &Pixmap| {
        let is_coloured = |p: &&PremultipliedColorU8| {
            let [low, high] = [u8::min, u8::max].map(|f| f(f(p.red(), p.green()), p.blue()));
            high - low > 40
        };
        picture.pixels().iter().filter(is_coloured).count() as f64 / picture.pixels().len() as f64
    };
    let meridian = browser.picture("canvas");
    assert!(coloured(&meridian) > 0.05, "{view:?}: the body covers {} of its picture", coloured(&meridian));
    for selector in [".charts .plot", ".charts .card:nth-child(2) .plot"] {
        let chart = browser.picture(selector);
        assert!(coloured(&chart) > 0.002 && chart.width() > 240, "{view:?}: {selector} {}", coloured(&chart));
    }
}
