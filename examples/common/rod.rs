//! The rod of `input/ogive_rod.inp` with elements of any size: what several examples share.
//! Never here: shots.

use std::error::Error;

use revolve::generate::{DeckLabels, Mesh, MeshRequest, Nose};

/// The sizes of elements, m, from which a depth is extrapolated to size 0 with order 1, as depths on five sizes have it.
pub const SIZES: [f64; 2] = [0.6e-3, 0.3e-3];

/// The deck with a mesh of a size in place of the kept one, and the volume of that mesh.
pub fn deck(size: f64) -> Result<(String, f64), Box<dyn Error>> {
    let wanted = MeshRequest {
        nose: Nose::Ogive { crh: 3.0 },
        radius: 3.555e-3,
        length: 71.1e-3,
        size,
        along: 1.0,
        across: 1.0,
        cavity: None,
    };
    let mesh = Mesh::new(&wanted).map_err(|refused| refused.message)?;
    let labels = DeckLabels { first: 1, prefix: String::new(), material: "VAR4340".into(), fill: "FILL".into() };
    let text = std::fs::read_to_string("input/ogive_rod.inp")?;
    let included = "*Include, input=ogive_rod_mesh.inp\n";
    if !text.contains(included) {
        return Err("input/ogive_rod.inp includes no mesh".into());
    }
    Ok((text.replace(included, &mesh.deck(&labels, &[])), mesh.measure().case.meshed))
}
