//! The command `revolve check`: diagnostics, model summary and ledger without a run.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::deck::Finding;
use crate::job::{self, PreparedJob};
use crate::overview::{self, DeckOverview, StorageEstimate};
use crate::plan::ledger::Ledger;
use clap::Args;
use serde::Serialize;

use super::options::{CurvedOption, OutputOptions, QuietOption};
use super::words::print_out;
use super::{CommandStatus, REFUSED, UserFiles, accept, deck_settings, words};

/// Wall-clock time of the trial run from which the run time of the whole analysis is estimated.
const TRIAL_TIME: Duration = Duration::from_millis(500);

/// Check a deck without running it: diagnostics, model summary and ledger of the simulated effects.
#[derive(Args)]
pub struct CheckCommand {
    /// Input deck; `-` reads from standard input.
    deck: PathBuf,
    /// Override a *PARAMETER of the deck: NAME=VALUE; can be repeated.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Divide each edge of the mesh into N equal parts. Sets, surfaces, loads and constraints follow.
    #[arg(long, value_name = "N")]
    mesh_refine: Option<u32>,
    #[command(flatten)]
    curved: CurvedOption,
    #[command(flatten)]
    user: UserFiles,
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
        let (routines, _) = self.user.routines(self.output.is_silent(), false)?;
        let OutputOptions { quiet: QuietOption { quiet }, json } = self.output;
        let settings = deck_settings(&self.set, self.mesh_refine, &self.curved)?;
        let (mut prepared, mut overview) = job::examine(&self.deck, &settings, &routines);
        let free = job::default_job(&self.deck, None).ok().and_then(|job| super::free_space(&job.folder));
        if let Some(overview) = overview.as_mut().filter(|_| !quiet) {
            let (plan, state) = (&prepared.plan, std::mem::take(&mut prepared.state));
            let (sizes, state) = StorageEstimate::of(plan, state, true, false);
            // Only diagnostics need the texts. The trial run takes the state itself, without a copy.
            if prepared.diagnostics.is_empty() {
                Arc::make_mut(&mut prepared.deck.sources).release_texts(|_| true);
            }
            overview.effort = if self.no_look { None } else { overview::measure(plan, state, TRIAL_TIME) };
            overview.output = Some(sizes.with_effort(plan, overview.effort.as_ref()));
        }
        if json {
            return print_json(&prepared, overview.as_ref());
        }
        accept(&prepared, quiet)?;
        if quiet {
            return Ok(CommandStatus::SUCCESS);
        }
        if let Some(overview) = &overview {
            words::write(format_args!("{}", overview.render()), true);
            let output = overview.output.as_ref().map(|output| output.render(free)).unwrap_or_default();
            words::write(format_args!("{output}"), true);
        }
        words::write(format_args!("{}", prepared.plan.ledger.render(self.bytes)), false);
        Ok(super::output_status())
    }
}

fn print_json(prepared: &PreparedJob, overview: Option<&DeckOverview>) -> Result<CommandStatus, Box<dyn Error>> {
    let accepted = overview.is_some();
    let report = CheckReport {
        accepted,
        diagnostics: prepared.diagnostics.findings(&prepared.deck.sources),
        overview,
        ledger: accepted.then_some(&prepared.plan.ledger),
    };
    print_out!("{}", serde_json::to_string_pretty(&report)?);
    Ok(if accepted { super::output_status() } else { CommandStatus::from(REFUSED) })
}
