//! The rod of `input/ogive_rod.inp` with elements of any size, shared by several examples.

use std::error::Error;

use revolve::generate::{DeckLabels, MeshRequest, NoseShape, ProjectileMesh};

/// Element sizes, m, for the extrapolation of a depth to size 0 with order 1, the order observed on five sizes.
pub const SIZES: [f64; 2] = [0.6e-3, 0.3e-3];

/// Returns the deck with a mesh of the given element size, and the volume of that mesh.
pub fn deck(size: f64) -> Result<(String, f64), Box<dyn Error>> {
    let wanted = MeshRequest {
        nose: NoseShape::Ogive { crh: 3.0 },
        radius: 3.555e-3,
        length: 71.1e-3,
        size,
        along: 1.0,
        across: 1.0,
        cavity: None,
    };
    let mesh = ProjectileMesh::new(&wanted).map_err(|refused| refused.message)?;
    let labels = DeckLabels { first: 1, prefix: String::new(), material: "VAR4340".into(), fill: "FILL".into() };
    let text = std::fs::read_to_string("input/ogive_rod.inp")?;
    let included = "*Include, input=ogive_rod_mesh.inp\n";
    if !text.contains(included) {
        return Err("input/ogive_rod.inp includes no mesh".into());
    }
    Ok((text.replace(included, &mesh.deck(&labels, &[])), mesh.measure().case.meshed))
}
