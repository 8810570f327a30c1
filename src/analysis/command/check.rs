//! The command `revolve check`: diagnostics, model summary and ledger without a run.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use crate::deck::Finding;
use crate::job::{self, PreparedJob};
use crate::overview::{self, DeckOverview, StorageEstimate};
use crate::plan::ledger::Ledger;
use clap::Args;
use serde::Serialize;

use super::options::{DeckOptions, OutputOptions, QuietOption};
use super::words::print_err;
use super::{CommandStatus, accept, words};

/// Check a deck without running it: diagnostics, model summary and ledger of the simulated effects.
#[derive(Args)]
pub struct CheckCommand {
    /// Input deck; `-` reads from standard input.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    #[command(flatten)]
    options: DeckOptions,
    /// Skip the short trial run that estimates increments and run time.
    #[arg(long)]
    no_look: bool,
    /// Show the memory of each effect in bytes, and the reason for each card without effect.
    #[arg(long)]
    bytes: bool,
    #[command(flatten)]
    output: OutputOptions,
}

/// JSON object printed by `--json`.
#[derive(Serialize)]
struct CheckReport<'a> {
    accepted: bool,
    diagnostics: Vec<Finding>,
    #[serde(skip_serializing_if = "Option::is_none")]
    overview: Option<&'a DeckOverview>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ledger: Option<&'a Ledger>,
}

impl CheckCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let (routines, _) = self.options.user.routines(self.output.is_silent(), false)?;
        let OutputOptions { quiet: QuietOption { quiet }, json } = self.output;
        let (mut prepared, mut overview) = job::examine(&self.deck, &self.options.settings()?, &routines);
        let free = job::default_job(&self.deck, None).ok().and_then(|job| super::free_space(&job.folder));
        if let Some(overview) = overview.as_mut().filter(|_| !quiet) {
            let (plan, state) = (&prepared.plan, std::mem::take(&mut prepared.state));
            let (sizes, state) = StorageEstimate::of(plan, state, true, false);
            // Only diagnostics need the texts. The trial run takes the state itself, without a copy.
            if prepared.diagnostics.is_empty() {
                Arc::make_mut(&mut prepared.deck.sources).release_texts(|_| true);
            }
            overview.effort = if self.no_look { None } else { overview::measure(plan, state, 1.0) };
            overview.output = Some(sizes.with_effort(plan, overview.effort.as_ref()));
        }
        if json {
            return self.print_json(&prepared, overview.as_ref());
        }
        accept(&prepared.diagnostics, &prepared.deck.sources, quiet)?;
        if quiet {
            return Ok(CommandStatus::SUCCESS);
        }
        if let Some(overview) = &overview {
            words::write(format_args!("{}", overview.render()), true);
            let output = overview.output.as_ref().map(|output| output.render(free)).unwrap_or_default();
            words::write(format_args!("{output}"), true);
        }
        words::write(format_args!("{}", prepared.plan.ledger.render(self.bytes)), false);
        // On standard error: two checks of a deck give the same text on standard output.
        if let Some(run_time) = overview.as_ref().and_then(DeckOverview::run_time) {
            print_err!("note: {run_time}");
        }
        Ok(super::output_status())
    }

    fn print_json(
        &self,
        prepared: &PreparedJob,
        overview: Option<&DeckOverview>,
    ) -> Result<CommandStatus, Box<dyn Error>> {
        let accepted = overview.is_some();
        let diagnostics = prepared.diagnostics.findings(&prepared.deck.sources);
        let ledger = accepted.then_some(&prepared.plan.ledger);
        self.output.print_json(&CheckReport { accepted, diagnostics, overview, ledger })?;
        Ok(if accepted { super::output_status() } else { CommandStatus::REFUSED })
    }
}
