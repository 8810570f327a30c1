//! The model builder: reads the cards of a deck in order, each with the families of cards that it changes.

use super::context::Context;
use super::families::{
    ConditionReader, MaterialReader, MeshReader, OutputReader, PartReader, SectionReader, StepReader,
};
use super::readers::find_reader;
use super::refinement::pass::ReadPass;
use super::relisting::edits::DeckEdits;
use super::types::Model;
use super::{completion, contact, copies, elements, infinite, links, materials, order, steps, unused};
use crate::deck::keywords::KeywordTier;
use crate::deck::{Card, Deck, Diagnostic, Diagnostics};

/// State of reading a deck.
pub struct ModelBuilder<'a> {
    pub context: Context<'a>,
    pub parts: PartReader<'a>,
    pub mesh: MeshReader,
    pub materials: MaterialReader,
    pub sections: SectionReader,
    pub conditions: ConditionReader,
    pub steps: StepReader,
    pub output: OutputReader,
}

impl<'a> ModelBuilder<'a> {
    /// Creates a builder of a deck whose cards have been checked.
    pub fn checked(deck: &'a Deck) -> Self {
        let mut context = Context::new(deck);
        (context.model.origin.inert, context.missing.faulty) = super::check::check(deck, &mut context.diagnostics);
        ModelBuilder {
            context,
            parts: PartReader::default(),
            mesh: MeshReader::default(),
            materials: MaterialReader::default(),
            sections: SectionReader::default(),
            conditions: ConditionReader::default(),
            steps: StepReader::default(),
            output: OutputReader::default(),
        }
    }

    /// Reads all cards of the deck.
    pub fn read_cards(&mut self) {
        let deck = self.context.deck;
        for card in order::ordered(&deck.cards.iter().collect::<Vec<_>>(), &deck.sources) {
            self.read_card(card);
        }
    }

    /// Reads a deck without errors again, with another mesh: `change_mesh` acts between the cards of the mesh and all other
    /// cards. If the deck is to be written, the changes of its text are recorded.
    pub fn with_changed_mesh(deck: &'a Deck, is_written: bool, change_mesh: impl FnOnce(&mut Context<'a>)) -> Self {
        let mut builder = ModelBuilder::checked(deck);
        builder.context.scaling.pass = ReadPass::Mesh;
        builder.read_cards();
        change_mesh(&mut builder.context);
        builder.context.scaling.edits = is_written.then(|| Box::new(DeckEdits::of(&builder.context.model)));
        builder.context.scaling.pass = ReadPass::Rest;
        builder.read_cards();
        builder
    }

    /// Reads a card, or records it if a part is open. Notes what an erroneous card would have defined.
    pub fn read_card(&mut self, card: &'a Card) {
        if self.parts.record(card) || !self.context.scaling.pass.reads(card) {
            return;
        }
        let name = card.keyword.name;
        let is_of_output = name.ends_with(" OUTPUT") || name == "OUTPUT EXPRESSION";
        if card.keyword.tier == KeywordTier::Used && !is_of_output {
            self.output.close(&mut self.context);
        }
        self.mesh.current_card = card.span;
        let faulty = card.faulty || self.context.missing.faulty.contains(&card.span);
        let errors_before = self.context.diagnostics.error_count();
        // After a *MATERIAL without a name, its cards belong to no material.
        let is_lost = card.keyword.place.is_below("MATERIAL")
            && self.context.model.materials.is_empty()
            && !self.materials.in_interaction;
        if let Some(reader) = find_reader(name).filter(|reader| !is_lost && (reader.always || !faulty)) {
            (reader.read)(self, card);
        }
        if faulty || self.context.diagnostics.error_count() > errors_before {
            self.context.missing.note_faulty_card(card);
        }
    }

    /// Completes the model after all cards are read.
    pub fn finish(mut self) -> (Model, Diagnostics) {
        self.output.close(&mut self.context);
        let context = &mut self.context;
        for block in std::mem::take(&mut self.parts.blocks) {
            let message = format!("this *{} is not closed", block.kind);
            let diagnostic = Diagnostic::error("M105", message).at(block.span, "opened here");
            context.diagnostics.push(diagnostic.help(format!("end it with *END {}", block.kind)));
        }
        steps::close_step(context, &mut self.steps);
        links::end_coupling(context, &mut self.conditions);
        context.model.discrete.masses.retain(|p| p.mass > 0.0);
        elements::report_duplicate_labels(context);
        elements::report_shape_faults(context, &mut self.mesh);
        copies::report_regenerated_nodes(context, &mut self.mesh);
        copies::check_transforms(context, &mut self.mesh);
        materials::apply_controls(context, &mut self.sections);
        contact::apply_interactions(context);
        infinite::add_absorbing_loads(context);
        completion::complete(context, &mut self.materials, &mut self.conditions);
        unused::list_unused(context);
        context.reduce_output_sets();
        let mesh = &mut *context.model.mesh;
        mesh.points.shrink_to_fit();
        mesh.node_names.shrink_to_fit();
        mesh.elements.shrink_to_fit();
        context.model.origin.bodies_read = !context.missing.bodies;
        (self.context.model, self.context.diagnostics)
    }
}
