//! The setup file `<job>.setup`: what is known of a run at its start, with the keys of the summary. `revolve view` shows
//! it until the summary is written, which takes its place.

use std::io;

use serde::Serialize;

use super::{DeckSummary, PreparedJob};
use crate::deck::Finding;
use crate::model::{DeckUnits, scene::SceneOutline};
use crate::output::{JobFiles, SETUP, write_whole};
use crate::plan::ledger::Ledger;

/// Contents of the setup file; the fields are those of [`super::RunSummary`].
#[derive(Serialize)]
struct RunSetup<'a> {
    ledger: &'a Ledger,
    diagnostics: Vec<Finding>,
    scene: &'a SceneOutline,
    units: Option<&'a DeckUnits>,
    materials: &'a [String],
    deck: DeckSummary,
    version: &'static str,
}

/// Writes the setup file of a job.
///
/// # Errors
/// If it cannot be written.
pub(super) fn write_setup(prepared: &PreparedJob, job: &JobFiles) -> io::Result<()> {
    let setup = RunSetup {
        ledger: &prepared.plan.ledger,
        diagnostics: prepared.diagnostics.findings(&prepared.deck.sources),
        scene: &prepared.scene,
        units: prepared.units.as_ref(),
        materials: prepared.plan.labels.material_names(),
        deck: DeckSummary::of(prepared),
        version: env!("CARGO_PKG_VERSION"),
    };
    write_whole(&job.path(SETUP), serde_json::to_string_pretty(&setup)?.as_bytes())
}
