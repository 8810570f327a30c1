//! The coarsest level of a study, whose mesh an error map divides into regions.

use std::sync::Arc;

use crate::deck::{self, Deck, Diagnostics, MESH_SETTINGS, MeshScaling};
use crate::model;
use crate::study::StudyError;
use crate::study::quantity::Quantity;
use crate::study::runner::{DeckReader, RunSource, StudyRun, StudyRunner};
use crate::study::settings::{ModelEdit, StudyAxis, StudyParameter, without_mesh};

/// Elements that are refined in a run.
pub type ElementMarks = Arc<[bool]>;

/// Coarsest level of a study: its deck, and the edits of its model.
pub struct MapBase<'a> {
    source: RunSource<'a>,
    quantity: &'a Quantity,
    overrides: Vec<(String, String)>,
    edits: Vec<ModelEdit>,
    /// Text of the deck if its mesh is refined or coarsened from another one.
    text: Option<String>,
}

impl<'a> MapBase<'a> {
    /// Returns the level with these values of the axes. A mesh that is refined or coarsened is listed, and its text is read
    /// again.
    ///
    /// # Errors
    /// If a value is invalid, or the deck cannot be listed.
    pub fn of(bench: &StudyRunner<'a>, axes: &[StudyAxis], values: &[String]) -> Result<MapBase<'a>, StudyError> {
        let (overrides, edits) = bench.setting(axes, values)?;
        let base = MapBase { source: bench.source(), quantity: bench.measure(), overrides, edits, text: None };
        let (deck, _) = base.read();
        if deck.mesh_scaling.is_none_or(|scaling| scaling == MeshScaling::Refine(1)) {
            return Ok(base);
        }
        let text = listed(&deck)?;
        let is_mesh = |axis: &StudyAxis| axis.parameter == StudyParameter::Mesh;
        let has_mesh = axes.iter().any(is_mesh);
        let is_scaling = |name: &str| MESH_SETTINGS.contains(&name) && (has_mesh || name != MESH_SETTINGS[1]);
        let overrides = base.overrides.into_iter().filter(|(name, _)| !is_scaling(name)).collect();
        Ok(MapBase { overrides, text: Some(text), ..base })
    }

    /// Whether the mesh is refined or coarsened from that of the deck, and listed.
    pub fn is_listed(&self) -> bool {
        self.text.is_some()
    }

    /// Reads the deck of the level.
    pub fn read(&self) -> (Deck, Diagnostics) {
        match &self.text {
            Some(text) => deck::read_text("base.inp", text, &self.overrides),
            None => (self.source.deck)(&self.overrides),
        }
    }

    /// Runs the deck with some elements refined and with further edits.
    pub fn run(&self, marks: Option<&ElementMarks>, more: &[ModelEdit]) -> Result<StudyRun, StudyError> {
        self.run_deck(
            &|_| {
                let (mut deck, diagnostics) = self.read();
                if let Some(marks) = marks {
                    deck.refine_elements(Arc::clone(marks));
                }
                (deck, diagnostics)
            },
            more,
        )
    }

    /// Runs another deck with the edits of the level and with further ones.
    pub fn run_deck(&self, reader: &DeckReader<'_>, more: &[ModelEdit]) -> Result<StudyRun, StudyError> {
        let source = RunSource { deck: reader, ..self.source };
        source.run(&self.overrides, &[&self.edits, more], std::slice::from_ref(self.quantity)).swap_remove(0)
    }

    /// Overrides of a deck that lists the mesh.
    pub fn overrides_of_listed_mesh(&self) -> Vec<(String, String)> {
        without_mesh(&self.overrides)
    }
}

/// Returns the text of a deck with its mesh listed.
///
/// # Errors
/// If the deck or its mesh is invalid.
pub fn listed(deck: &Deck) -> Result<String, StudyError> {
    let (text, diagnostics) = model::relisting::write(deck);
    if diagnostics.has_errors() {
        return Err(StudyError::Setting(format!("the mesh cannot be listed: {}", diagnostics.render(&deck.sources))));
    }
    Ok(text)
}
