//! Reads the list of a `.pvd` series and its frames.

use std::path::{Path, PathBuf};

use super::read;
use crate::deck::printable;
use crate::kernel::stress::mises;
use crate::model::vtk_file;
use crate::model::vtk_mesh::BLANKING;
use crate::output::EntityLabels;
use crate::output::sums::Checksums;
use crate::output::vtu::REFERENCE;
use crate::variables::Variable;

/// Arrays of the node numbers of points, and of the element and material numbers of cells.
const NODE: &str = "NODE";
const ELEMENT: &str = "ELEMENT";
const MATERIAL: &str = "MATERIAL";

/// Contents of a frame file, with vectors and tensors split into scalars.
#[derive(Clone, Debug, Default)]
pub struct FrameData {
    pub time: f64,
    /// `[r, z]` of each point.
    pub points: Vec<[f64; 2]>,
    pub cells: Vec<Vec<usize>>,
    /// Node number of each point in the deck; empty if the file has none.
    pub nodes: Vec<i32>,
    /// Whether the element of each cell is deleted; empty if none is.
    pub deleted: Vec<bool>,
    /// Element number of each cell in the deck; empty if the file has none.
    pub elements: Vec<i32>,
    /// Material number of each cell, counted from 1; empty if the file has none.
    pub materials: Vec<i32>,
    pub scalars: Vec<ScalarField>,
}

impl FrameData {
    /// Returns the values of a scalar field.
    pub fn values(&self, name: &str, on_cells: bool) -> Option<&[f64]> {
        let field = self.scalars.iter().find(|field| field.name == name && field.on_cells == on_cells);
        field.map(|field| &field.values[..])
    }
}

#[derive(Clone, Debug)]
pub struct ScalarField {
    pub name: String,
    pub on_cells: bool,
    pub values: Vec<f64>,
    /// Array of the file from which it was made.
    pub array: String,
}

/// Reads the times and files of a series.
pub fn series(pvd: &Path) -> Result<Vec<(f64, PathBuf)>, String> {
    let text = read::text(pvd)?;
    let folder = pvd.parent().unwrap_or(Path::new(""));
    // Only files of the same folder are read, so that a foreign list cannot refer to other files.
    let entry = |tag: &str| {
        let time = attribute(tag, "timestep")?.parse().ok()?;
        let name = unescape(attribute(tag, "file")?);
        (!name.contains('/')).then(|| (time, folder.join(name)))
    };
    let wrong = |tag: &str| format!("{}: `{}` is not a frame in this folder", pvd.display(), printable(tag.trim()));
    let first_line = |tag: &str| tag.lines().next().unwrap_or_default().chars().take(80).collect::<String>();
    if !text.contains("</VTKFile>") {
        return Err(format!("{}: the file is truncated", pvd.display()));
    }
    text.split("<DataSet").skip(1).map(|tag| entry(tag).ok_or_else(|| wrong(&first_line(tag)))).collect()
}

pub fn read(time: f64, path: &Path, sums: &Checksums) -> Result<FrameData, String> {
    read_arrays(time, path, sums, &|_| true)
}

/// Reads a frame with the arrays whose names `wanted` accepts, and those of its mesh and shape.
pub fn read_arrays(
    time: f64,
    path: &Path,
    sums: &Checksums,
    wanted: &dyn Fn(&str) -> bool,
) -> Result<FrameData, String> {
    let text = read::verified_text(path, sums)?;
    let is_reference = text.contains(REFERENCE);
    let of_mesh = |name: &str| [BLANKING, NODE, ELEMENT, MATERIAL].contains(&name) || name == "U" && is_reference;
    let needed = |name: &str| of_mesh(name) || wanted(name);
    let mesh = read::in_file(path, vtk_file::read(path, &needed))?;
    let is_field = |name: &str| name != BLANKING && !EntityLabels::is_name(name);
    let mut scalars = Vec::new();
    for (on_cells, arrays, count) in
        [(false, &mesh.point_arrays, mesh.points.len()), (true, &mesh.cell_arrays, mesh.cells.len())]
    {
        for (array, values) in arrays.iter().filter(|array| is_field(&array.0)) {
            let field = |(name, values)| ScalarField { name, on_cells, values, array: array.clone() };
            scalars.extend(split(array, values, count, &text).into_iter().map(field));
        }
    }
    let around = |cell: Vec<usize>| match cell[..] {
        [a, b, c, ab, bc, ca] => vec![a, ab, b, bc, c, ca],
        _ => cell,
    };
    let moved = mesh.point_arrays.iter().find(|(name, _)| name == "U" && is_reference);
    let shift = |i: usize| moved.map_or([0.0; 2], |(_, values)| [values[3 * i], values[3 * i + 1]]);
    let places = mesh.points.iter().enumerate().map(|(i, p)| [p[0] + shift(i)[0], p[1] + shift(i)[1]]).collect();
    let of_cells = |name: &str| mesh.cell_arrays.iter().find(|array| array.0 == name).map_or(&[][..], |array| &array.1);
    let [elements, materials] = [ELEMENT, MATERIAL].map(|name| of_cells(name).iter().map(|v| *v as i32).collect());
    let nodes = mesh.point_arrays.iter().find(|array| array.0 == NODE).map_or(&[][..], |array| &array.1);
    let nodes = nodes.iter().map(|number| *number as i32).collect();
    let deleted = of_cells(BLANKING).iter().map(|v| *v != 0.0).collect();
    let cells = mesh.cells.into_iter().map(around).collect();
    Ok(FrameData { time, points: places, cells, nodes, deleted, elements, materials, scalars })
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let tag = &tag[..tag.find('>')?];
    tag.split_once(&format!(" {name}=\""))?.1.split('"').next()
}

fn unescape(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

/// Splits an array into scalars: a vector into magnitude and two components, a stress into its components and the Mises
/// stress.
fn split(name: &str, values: &[f64], count: usize, text: &str) -> Vec<(String, Vec<f64>)> {
    let parts = values.len().checked_div(count).unwrap_or(0);
    if parts == 0 || values.len() != parts * count {
        return Vec::new();
    }
    if parts == 1 {
        return vec![(name.to_owned(), values.to_vec())];
    }
    let component = |i: usize| values.iter().skip(i).step_by(parts).copied().collect::<Vec<f64>>();
    let names = component_names(name, parts, text);
    if parts == 3 {
        let magnitude = values.chunks_exact(3).map(|v| libm::hypot(v[0], v[1])).collect();
        let [first, second, _] = <[String; 3]>::try_from(names).unwrap_or_default();
        return vec![(format!("|{name}|"), magnitude), (first, component(0)), (second, component(1))];
    }
    let mut scalars: Vec<_> = names.into_iter().enumerate().map(|(i, n)| (n, component(i))).collect();
    // The last two components of a symmetric tensor are zero in axisymmetric models.
    scalars.truncate(if parts == 6 { 4 } else { parts });
    if name == Variable::Stress.name() && scalars.len() == 4 {
        let stresses = values.chunks_exact(parts);
        scalars.insert(0, ("S_MISES".into(), stresses.map(|s| mises([s[0], s[1], s[2], s[3]])).collect()));
    }
    scalars
}

/// Returns the component names of the file, or numbered names.
fn component_names(name: &str, parts: usize, text: &str) -> Vec<String> {
    let tag = text.split("<DataArray").find(|t| attribute(t, "Name").is_some_and(|n| unescape(n) == name));
    let named = |i: usize| tag.and_then(|t| attribute(t, &format!("ComponentName{i}"))).map(unescape);
    (0..parts).map(|i| named(i).unwrap_or_else(|| format!("{name}{}", i + 1))).collect()
}

/// Returns the sort rank of a field: the most common fields come first.
pub fn rank(name: &str) -> usize {
    const FIRST: [&str; 9] = ["S_MISES", "MISES", "PEEQ", "PRESSURE", "|V|", "V2", "|U|", "TEMP", "STATUS"];
    FIRST.iter().position(|f| *f == name).unwrap_or(FIRST.len())
}

/// Returns whether a field on cells belongs to the facets of rigid bodies; the others belong to elements.
pub fn is_facet_field(name: &str) -> bool {
    ["PRESSURE", "NORMAL_VELOCITY", "LAYER"].contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stress_gives_mises_stress() {
        let split = split("S", &[300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 100.0], 2, "");
        assert_eq!(split[0].0, "S_MISES");
        assert!((split[0].1[0] - 300.0).abs() < 1e-12, "uniaxial");
        assert!((split[0].1[1] - 100.0 * 3.0_f64.sqrt()).abs() < 1e-12, "shear");
        assert_eq!(split[4], ("S4".to_owned(), vec![0.0, 100.0]));
    }
}
