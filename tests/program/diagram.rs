//! The diagram of `docs/architecture.md`: one box per folder of a crate in `src`, one arrow per import, made from the `use` lines.
//! An arrow that follows from others (a -> b -> c implies a -> c) is left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;

use crate::common::project;
use crate::tidy::{LAYERS, SourceTree, folder};

const FILE: &str = "docs/architecture.svg";
/// Size of a box and the distances between boxes and between layers, pixels.
const BOX: [f64; 2] = [92.0, 26.0];
const GAP: f64 = 22.0;
const LAYER: f64 = 62.0;
const WIDTH: f64 = 720.0;

type FolderImports = BTreeMap<String, BTreeSet<String>>;

/// Returns the folders that each folder imports.
fn imports() -> FolderImports {
    let tree = SourceTree::read();
    let mut imports = FolderImports::new();
    for (from, to, _) in tree.imports() {
        let (Some(user), Some(used)) = (folder(from), folder(&to)) else { continue };
        if user != used {
            imports.entry(user.to_owned()).or_default().insert(used.to_owned());
        }
    }
    imports
}

/// Returns whether a folder reaches another one by two imports or more.
fn reaches_indirectly(imports: &FolderImports, from: &str, to: &str) -> bool {
    let next = |folder: &str| imports.get(folder).into_iter().flatten();
    let mut open: Vec<&String> = next(from).filter(|folder| *folder != to).collect();
    let mut seen = BTreeSet::new();
    while let Some(folder) = open.pop() {
        if folder == to {
            return true;
        }
        if seen.insert(folder) {
            open.extend(next(folder));
        }
    }
    false
}

/// Returns the centre of the box of each folder.
fn centres() -> BTreeMap<&'static str, [f64; 2]> {
    let mut centres = BTreeMap::new();
    for (layer, (_, folders)) in LAYERS.iter().enumerate() {
        let length = folders.len() as f64 * (BOX[0] + GAP) - GAP;
        for (place, folder) in folders.iter().enumerate() {
            let x = 0.5 * (WIDTH - length + BOX[0]) + place as f64 * (BOX[0] + GAP);
            centres.insert(*folder, [x, 30.0 + layer as f64 * LAYER]);
        }
    }
    centres
}

fn draw_arrow(svg: &mut String, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) {
    let half = 0.5 * BOX[1];
    let path = if y0 == y1 {
        let side = 0.5 * BOX[0] * (x1 - x0).signum();
        let lift = if (x1 - x0).abs() > BOX[0] + GAP { 2.2 * half } else { 0.0 };
        // An arrow over another box is an arc above it.
        let [start, end] = if lift > 0.0 { [x0, x1] } else { [x0 + side, x1 - side] };
        let [from, over] = if lift > 0.0 { [y0 - half, y0 - half - lift] } else { [y0, y0] };
        format!("M{start} {from}C{start} {over} {end} {over} {end} {from}")
    } else {
        let (start, end) = (y0 + half, y1 - half);
        let middle = 0.5 * (start + end);
        format!("M{x0} {start}C{x0} {middle} {x1} {middle} {x1} {end}")
    };
    let _ = writeln!(svg, "<path d=\"{path}\" marker-end=\"url(#head)\"/>");
}

fn draw(imports: &FolderImports) -> String {
    let height = 30.0 + LAYERS.len() as f64 * LAYER - 20.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <title>Folders of src and their imports</title>\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#ffffff\"/>\n\
         <defs><marker id=\"head\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"7\" markerHeight=\"7\" orient=\"auto\">\
         <path d=\"M0 0L8 4L0 8z\" fill=\"#6b7686\"/></marker></defs>\n\
         <g fill=\"none\" stroke=\"#6b7686\">\n"
    );
    let centres = centres();
    for (from, list) in imports {
        for to in list.iter().filter(|to| !reaches_indirectly(imports, from, to)) {
            draw_arrow(&mut svg, centres[from.as_str()], centres[to.as_str()]);
        }
    }
    svg += "</g>\n<g font-size=\"11\" fill=\"#6b7686\">\n";
    for (layer, (name, _)) in LAYERS.iter().enumerate() {
        if layer == 0 || LAYERS[layer - 1].0 != *name {
            let _ = writeln!(svg, "<text x=\"8\" y=\"{}\">{name}</text>", 34.0 + layer as f64 * LAYER);
        }
    }
    svg += "</g>\n<g text-anchor=\"middle\" fill=\"#16202c\">\n";
    for (folder, [x, y]) in &centres {
        let (left, top) = (x - 0.5 * BOX[0], y - 0.5 * BOX[1]);
        let _ = writeln!(
            svg,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" rx=\"4\" fill=\"#e8eef6\" stroke=\"#3a5a86\"/>\
             <text x=\"{x}\" y=\"{}\">{folder}</text>",
            BOX[0],
            BOX[1],
            y + 4.5
        );
    }
    svg + "</g>\n</svg>\n"
}

#[test]
fn architecture_diagram_matches_the_imports() {
    let drawn = draw(&imports());
    if std::env::var_os("REVOLVE_UPDATE_DIAGRAM").is_some() {
        fs::write(project(FILE), &drawn).expect("the diagram");
    }
    let kept = fs::read_to_string(project(FILE)).unwrap_or_default();
    assert!(kept == drawn, "{FILE} is out of date: run this test with REVOLVE_UPDATE_DIAGRAM=1");
}
