//! Elements of a run that expand along their circumference, from a frame.

use std::path::Path;

use super::frame_mesh::{NO_CORNER, corners};
use super::frames::{FrameData, read_arrays, series};
use super::read::in_file;
use super::{ReportError, find};
use crate::model::vtk_file;
use crate::output::EntityLabels;
use crate::output::sums::Checksums;
use crate::study::fragments::ExpandingElement;

/// Expanding elements of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExpandingBody {
    /// Name of the run.
    pub job: String,
    /// Total time of the frame.
    pub time: f64,
    pub elements: Vec<ExpandingElement>,
    /// Mass of the elements whose circumference does not grow.
    pub other_mass: f64,
}

/// Reads the elements of the only run in a folder from the frame next to a time, by default the last one. `set` is the name
/// of an element set. Masses are the volumes of this frame times the density.
///
/// # Errors
/// If there is no run, frame, velocity or set, or if no element expands.
pub fn expanding_body(
    folder: &Path,
    time: Option<f64>,
    set: Option<&str>,
    density: f64,
) -> Result<ExpandingBody, ReportError> {
    let job = find::only_run(folder)?;
    let list = folder.join(format!("{job}.pvd"));
    if !list.is_file() {
        return Err(format!("{} is missing: request frames with *OUTPUT, FIELD", list.display()).into());
    }
    let sums = Checksums::of(folder)?;
    sums.verify(&list)?;
    let frames = series(&list)?;
    let distance = |instant: f64| time.map_or(-instant, |time| (instant - time).abs());
    let nearest = frames.iter().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
    let (time, path) = nearest.ok_or_else(|| format!("{} lists no frames", list.display()))?;
    let frame = read_arrays(*time, path, &sums, &|name| name == "V" || EntityLabels::is_name(name))?;
    let Some(velocities) = frame.values("V1", false) else {
        return Err(format!("{}: no velocities: request V with *NODE OUTPUT", path.display()).into());
    };
    let members = match set {
        Some(set) => members(path, set, frame.cells.len())?,
        None => vec![true; frame.cells.len()],
    };
    let mut body = ExpandingBody { job, time: *time, ..ExpandingBody::default() };
    for cell in (0..frame.cells.len()).filter(|cell| members[*cell]) {
        body.add(&frame, cell, velocities, density);
    }
    if body.elements.is_empty() {
        return Err(format!(
            "{}: the circumference of no solid element grows at time {time:e}: choose a frame with --time, or another --set",
            path.display()
        )
        .into());
    }
    Ok(body)
}

impl ExpandingBody {
    /// Adds the element of a cell; lines and deleted elements have no volume.
    fn add(&mut self, frame: &FrameData, cell: usize, velocities: &[f64], density: f64) {
        let listed = corners(&frame.cells[cell]).into_iter().filter(|corner| *corner != NO_CORNER);
        let corners: Vec<usize> = listed.map(|corner| corner as usize).collect();
        if corners.len() < 3 || frame.deleted.get(cell) == Some(&true) {
            return;
        }
        let places: Vec<[f64; 2]> = corners.iter().map(|corner| frame.points[*corner]).collect();
        let [area, radius] = area_and_radius(&places);
        let count = corners.len() as f64;
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count;
        let speed = mean(&mut corners.iter().map(|corner| velocities[*corner]));
        let rate = speed / mean(&mut places.iter().map(|place| place[0]));
        let mass = density * 2.0 * std::f64::consts::PI * radius * area;
        if rate > 0.0 && mass > 0.0 {
            self.elements.push(ExpandingElement { mass, radius, rate });
        } else if mass > 0.0 {
            self.other_mass += mass;
        }
    }
}

/// Returns the area of a polygon and the radius of its centroid.
fn area_and_radius(places: &[[f64; 2]]) -> [f64; 2] {
    let (mut twice, mut moment) = (0.0, 0.0);
    for (i, a) in places.iter().enumerate() {
        let b = places[(i + 1) % places.len()];
        let cross = a[0] * b[1] - b[0] * a[1];
        twice += cross;
        moment += cross * (a[0] + b[0]);
    }
    [0.5 * twice.abs(), moment / (3.0 * twice)]
}

/// Returns which cells belong to an element set of the deck.
fn members(path: &Path, set: &str, cells: usize) -> Result<Vec<bool>, String> {
    const PREFIX: &str = "ELSET_";
    let mesh = in_file(path, vtk_file::read(path, &EntityLabels::is_name))?;
    let name_of = |array: &str| array.strip_prefix(PREFIX).map(str::to_owned);
    let arrays = || mesh.cell_arrays.iter().filter_map(|(name, values)| Some((name_of(name)?, values)));
    let found = arrays().find(|(name, values)| name.eq_ignore_ascii_case(set) && values.len() == cells);
    found.map(|(_, values)| values.iter().map(|value| *value != 0.0).collect()).ok_or_else(|| {
        let names: Vec<String> = arrays().map(|array| array.0).collect();
        format!("--set {set}: the frame has no such element set; it has {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::area_and_radius;

    /// Source: a trapezium as a square and a triangle, whose centroids are at 3/2 and 7/3; a triangle.
    #[test]
    fn area_and_centroid_of_polygons_are_exact() {
        let [area, radius] = area_and_radius(&[[1.0, 0.0], [3.0, 0.0], [2.0, 1.0], [1.0, 1.0]]);
        assert!(
            (area - 1.5).abs() < 1e-14 && (radius - (1.5 + 0.5 * 7.0 / 3.0) / 1.5).abs() < 1e-14,
            "{area} {radius}"
        );
        let [area, radius] = area_and_radius(&[[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]);
        assert!((area - 4.5).abs() < 1e-14 && (radius - 1.0).abs() < 1e-14);
    }
}
