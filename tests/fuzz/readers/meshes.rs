//! Mesh files, selected by the first byte: VTK (XML and legacy), Gmsh, decks as meshes.
use std::sync::Once;

use revolve::job;
use revolve::user::Routines;

static BEGIN: Once = Once::new();

/// Reads the data as a mesh file; must not panic, hang or use much memory.
pub fn read(data: &[u8]) {
    // Panics of vtkio are converted to errors by the program and do not count here.
    BEGIN.call_once(revolve::model::silence_caught_panics);
    let Some((first, content)) = data.split_first() else { return };
    let ending = ["vtu", "vtk", "vtp", "msh", "inp"][usize::from(*first) % 5];
    let path = super::folder().join(format!("mesh.{ending}"));
    std::fs::write(&path, content).expect("a file");
    let text = format!("*Mesh, input=\"{}\"\n", path.display());
    let prepared = job::prepare_text("fuzz.inp", &text, &[], &Routines::none());
    let _ = prepared.diagnostics.render(&prepared.deck.sources);
}
