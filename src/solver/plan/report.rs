//! The report of the passes: diagnostics, the ledger, the user subroutines that are called, and what effects share.

use indexmap::IndexMap;

use crate::deck::{Diagnostic, Diagnostics, Sources, Span};
use crate::model::Model;
use crate::plan::Shared;
use crate::plan::ledger::{Ledger, UnusedCard};
use crate::state::EffectId;
use crate::user::Routines;

/// Ledger row of each card and effect.
pub type LedgerRows = IndexMap<(Span, &'static str), EffectId>;

/// Diagnostics, ledger and shared objects of a plan. Every pass adds to it.
pub struct Report<'a> {
    sources: &'a Sources,
    pub routines: &'a Routines,
    pub diagnostics: Diagnostics,
    pub ledger: Ledger,
    pub ledger_rows: LedgerRows,
    /// Names of the user subroutines that are called.
    pub called_routines: Vec<&'static str>,
    /// User amplitudes and surfaces that effects share.
    pub shared: Shared,
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
            shared: Shared::default(),
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

    /// Marks a user subroutine as called, for which `asks` is the reason. `None` if it is missing or cannot be called, which
    /// is an error.
    pub fn require_routine(&mut self, span: Span, label: &str, asks: &str, name: &'static str) -> Option<()> {
        self.called_routines.push(name);
        if known_routines(self.routines).iter().any(|known| known.name == name && known.is_given) {
            return Some(());
        }
        let calls = format!("this {label} calls a user subroutine");
        if let Some(uncallable) = self.routines.uncallable.iter().find(|m| m.routine == name) {
            let code = if uncallable.code == "U004" { "U004" } else { "U005" };
            return self.refuse(Diagnostic::error(code, format!("{asks}: {}", uncallable.message)).at(span, calls));
        }
        let user_files =
            if self.routines.any() { "the given files do not define it" } else { "no user subroutine was given" };
        let finding = Diagnostic::error("P004", format!("{asks}, but {user_files}")).at(span, calls);
        self.refuse(finding.help(format!("give a file that defines {name} with --user FILE")))
    }

    /// Notes user subroutines that are never called.
    pub fn note_uncalled_routines(&mut self) {
        let known = known_routines(self.routines).into_iter();
        let uncalled = known.filter(|known| known.is_given && !self.called_routines.contains(&known.name));
        let uncalled: Vec<(&str, &str)> = uncalled.map(|known| (known.name, known.never_called)).collect();
        let unsupported = self.routines.unsupported.iter().map(|name| (*name, "Revolve does not support it"));
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

/// A user subroutine that a deck may call.
struct KnownRoutine {
    name: &'static str,
    is_given: bool,
    /// Reason why a given one is not called.
    never_called: &'static str,
}

fn known_routines(routines: &Routines) -> [KnownRoutine; 10] {
    let known = |name, is_given, never_called| KnownRoutine { name, is_given, never_called };
    [
        known("vdload", routines.load.is_some(), "there is no load PNU, BRNU or BZNU"),
        known("vuamp", routines.amplitude.is_some(), "no *AMPLITUDE, DEFINITION=USER is used"),
        known("vdisp", routines.motion.is_some(), "there is no *BOUNDARY, USER"),
        known("vumat", routines.material.is_some(), "no element has a *USER MATERIAL"),
        known("vuanisohyper_inv", routines.energy.is_some(), "no element has *ANISOTROPIC HYPERELASTIC, USER"),
        known("vuhard", routines.hardening.is_some(), "no element has *PLASTIC, HARDENING=USER"),
        known("vusdfld", routines.fields.is_some(), "no element has a *USER DEFINED FIELD"),
        known(
            "vufield",
            routines.nodal_fields.is_some(),
            "there is no *FIELD, USER of a variable that a material reads",
        ),
        known("vfriction", routines.friction.is_some(), "no contact has a *FRICTION, USER"),
        known("vucharlength", routines.lengths.is_some(), "no element uses a length of *CHARACTERISTIC LENGTH"),
    ]
}
