//! Regions of a mesh: named sets of elements, and patches of similar size.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::deck::files;
use crate::deck::names::nearest;
use crate::model::Model;
use crate::study::StudyError;
use crate::study::uncertainty::NamedShare;

/// A region of the error map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshRegion {
    /// Name, `R1` and so on.
    pub name: String,
    /// Labels of the elements.
    pub elements: Vec<String>,
}

/// An entry of the regions in the file of an error map.
#[derive(Deserialize)]
struct RegionEntry {
    #[serde(flatten)]
    region: MeshRegion,
    share: Option<f64>,
}

/// Contents of the file of an error map that other commands read.
#[derive(Deserialize)]
pub struct MapFile {
    /// Expression of the quantity.
    pub quantity: String,
    /// Error of the mesh that is divided into regions.
    error: f64,
    regions: Vec<RegionEntry>,
}

impl MapFile {
    /// Reads the file `<job>_map.json`.
    ///
    /// # Errors
    /// If the file cannot be read or is no error map.
    pub fn read(path: &Path) -> Result<MapFile, StudyError> {
        let wrong = |why: String| StudyError::file("--map", path, why);
        let text = files::read_text(path).map_err(|e| wrong(e.to_string()))?;
        serde_json::from_str(&text).map_err(|e| wrong(format!("not an error map: {e}")))
    }

    /// Returns the shares of the regions as fractions of the error, those of the largest magnitude first.
    pub fn shares(&self) -> Vec<NamedShare> {
        let named = |entry: &RegionEntry| {
            Some(NamedShare { name: entry.region.name.clone(), share: entry.share? / self.error })
        };
        let mut shares: Vec<NamedShare> = self.regions.iter().filter_map(named).collect();
        shares.sort_by(|a, b| b.share.abs().total_cmp(&a.share.abs()));
        shares
    }
}

/// Returns whether each element of a model is in one of the named regions: regions of an error map, or element sets.
///
/// # Errors
/// If the file of the map cannot be read, or if a name is unknown.
pub fn named(model: &Model, names: &[String], map: Option<&Path>) -> Result<Arc<[bool]>, StudyError> {
    let map = map.map(MapFile::read).transpose()?;
    let regions: Vec<MeshRegion> = map.into_iter().flat_map(|map| map.regions).map(|entry| entry.region).collect();
    let mut is_inside = vec![false; model.mesh.elements.len()];
    for name in names.iter().map(|name| name.trim()) {
        let region = regions.iter().find(|region| region.name.eq_ignore_ascii_case(name));
        let set = model.element_sets.iter().find(|set| set.0.eq_ignore_ascii_case(name));
        match (region, set) {
            (Some(region), _) => mark(model, region, &mut is_inside)?,
            (None, Some((_, set))) => set.members.iter().for_each(|&element| is_inside[element] = true),
            (None, None) => return Err(unknown(name, model, &regions)),
        }
    }
    Ok(is_inside.into())
}

fn unknown(name: &str, model: &Model, regions: &[MeshRegion]) -> StudyError {
    let known = || regions.iter().map(|r| r.name.as_str()).chain(model.element_sets.keys().map(|key| key.as_str()));
    let near = nearest(name, known()).map(|near| format!("did you mean {near}? ")).unwrap_or_default();
    let list: Vec<&str> = known().collect();
    StudyError::Setting(format!("--regions {name}: no such element set; {near}known names: {}", list.join(", ")))
}

/// Marks the elements of a region.
fn mark(model: &Model, region: &MeshRegion, is_inside: &mut [bool]) -> Result<(), StudyError> {
    let names = model.mesh.elements.iter().enumerate().map(|(at, element)| (element.name.to_string(), at));
    let places: std::collections::HashMap<String, usize> = names.collect();
    for label in &region.elements {
        let place = places.get(label).ok_or_else(|| {
            StudyError::Setting(format!("--regions {}: the deck has no element {label} of the map", region.name))
        })?;
        is_inside[*place] = true;
    }
    Ok(())
}
