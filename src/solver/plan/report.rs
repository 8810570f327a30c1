//! The report of the passes: diagnostics, the ledger, and the user subroutines that are called.

use indexmap::IndexMap;

use crate::deck::{Diagnostic, Diagnostics, Sources, Span};
use crate::model::Model;
use crate::plan::ledger::{Ledger, UnusedCard};
use crate::state::EffectId;
use crate::user::Routines;

/// Ledger row of each card and effect.
pub type LedgerRows = IndexMap<(Span, &'static str), EffectId>;

/// Diagnostics and ledger of a plan. Every pass adds to it.
pub struct Report<'a> {
    sources: &'a Sources,
    pub routines: &'a Routines,
    pub diagnostics: Diagnostics,
    pub ledger: Ledger,
    pub ledger_rows: LedgerRows,
    /// Names of the user subroutines that are called.
    pub called_routines: Vec<&'static str>,
}

impl<'a> Report<'a> {
    pub fn new(model: &'a Model, routines: &'a Routines) -> Report<'a> {
        Report {
            sources: &model.origin.sources,
            routines,
            diagnostics: Diagnostics::default(),
            ledger: Ledger::default(),
            ledger_rows: IndexMap::new(),
            called_routines: Vec::new(),
        }
    }

    /// Adds a diagnostic.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Adds a diagnostic and returns `None`, for use in place of the value that could not be created.
    pub fn refuse<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.diagnostics.refuse(diagnostic)
    }

    /// Returns the ledger row of an effect of the card at `span`. The row is created at the first call, so that a load
    /// that is active in several steps has one row.
    pub fn ledger_row(
        &mut self,
        span: Span,
        effect: &'static str,
        count: usize,
        unit: &'static str,
        detail: String,
    ) -> EffectId {
        let (ledger, sources) = (&mut self.ledger, self.sources);
        let row = self.ledger_rows.entry((span, effect));
        *row.or_insert_with(|| ledger.add(effect, count, unit, sources.describe(span), detail))
    }

    /// Lists a card without effect in the ledger.
    pub fn add_unused_card(&mut self, span: Span, what: impl Into<String>, why: impl Into<String>) {
        let asked_by = self.sources.describe(span);
        self.ledger.unused.insert(UnusedCard { what: what.into(), asked_by, why: why.into() });
    }

    /// Adds the card at `other`, which repeats the card at `first`, to the ledger rows of the latter.
    pub fn share_ledger_rows(&mut self, first: Span, other: Span) {
        if first == other {
            return;
        }
        let asked_by = self.sources.describe(other);
        let rows: Vec<(&'static str, usize)> = self
            .ledger_rows
            .iter()
            .filter(|((span, _), _)| *span == first)
            .map(|((_, effect), row)| (*effect, *row))
            .collect();
        for (effect, row) in rows {
            self.ledger_rows.entry((other, effect)).or_insert(row);
            let places = &mut self.ledger.effects[row].asked_by;
            if !places.contains(&asked_by) {
                places.push(asked_by.clone());
            }
        }
    }

    /// Reports that a user subroutine that the deck needs is missing, or the reason why it cannot be called.
    pub fn refuse_missing_routine(&mut self, span: Span, label: &str, asks: &str, name: &'static str) {
        self.called_routines.push(name);
        if let Some(uncallable) = self.routines.uncallable.iter().find(|m| m.routine == name) {
            let code = if uncallable.code == "U004" { "U004" } else { "U005" };
            let finding = Diagnostic::error(code, format!("{asks}: {}", uncallable.message));
            return self.diagnostics.push(finding.at(span, format!("this {label} calls a user subroutine")));
        }
        let given =
            if self.routines.any() { "the given files do not define it" } else { "no user subroutine was given" };
        let finding = Diagnostic::error("P004", format!("{asks}, but {given}"));
        let finding = finding.at(span, format!("this {label} calls a user subroutine"));
        self.diagnostics.push(finding.help(format!("give a file that defines {name} with --user FILE")));
    }

    /// Notes user subroutines that are never called.
    pub fn note_uncalled_routines(&mut self) {
        let routines = self.routines;
        let there = [
            ("vdload", routines.load.is_some(), "there is no load PNU, BRNU or BZNU"),
            ("vuamp", routines.amplitude.is_some(), "no *AMPLITUDE, DEFINITION=USER is used"),
            ("vdisp", routines.motion.is_some(), "there is no *BOUNDARY, USER"),
            ("vumat", routines.material.is_some(), "no element has a *USER MATERIAL"),
            ("vuhard", routines.hardening.is_some(), "no element has *PLASTIC, HARDENING=USER"),
            ("vusdfld", routines.fields.is_some(), "no element has a *USER DEFINED FIELD"),
            ("vucharlength", routines.lengths.is_some(), "no element uses a length of *CHARACTERISTIC LENGTH"),
        ];
        let uncalled: Vec<(&str, &str)> =
            there.into_iter().filter(|r| r.1 && !self.called_routines.contains(&r.0)).map(|r| (r.0, r.2)).collect();
        let unsupported = routines.unsupported.iter().map(|name| (*name, "Revolve does not support it"));
        for (name, why) in uncalled.into_iter().chain(unsupported) {
            self.add_unused_card(Span::default(), format!("routine {name}"), format!("it is never called: {why}"));
            self.diagnostics.push(Diagnostic::note("U009", format!("user subroutine `{name}` is never called: {why}")));
        }
    }

    /// Adds the ledger row of VEXTERNALDB.
    pub fn add_events_row(&mut self) {
        if self.routines.events.is_some() {
            self.ledger.add("user events", 1, "routine", "--user".into(), "vexternaldb".into());
        }
    }
}
