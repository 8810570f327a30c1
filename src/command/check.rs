//! `revolve check`.

use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;

use crate::deck::Finding;
use crate::job::{self, Prepared};
use crate::model::Precision;
use crate::overview::{self, Overview};
use crate::plan::ledger::Ledger;
use clap::Args;
use serde::Serialize;

use super::words::say;
use super::{REFUSED, Status, UserFiles, accept, pairs, words};

/// A run is looked at for so long to say what all of it will take.
const LOOK: Duration = Duration::from_millis(500);

/// Check a deck: diagnostics, what it amounts to, and the ledger of what it would simulate.
#[derive(Args)]
pub struct Check {
    /// The input deck; `-` reads it from standard input.
    deck: PathBuf,
    /// Replace the value of a *PARAMETER: NAME=VALUE.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Precision of solid elements: double or single.
    #[arg(long, value_name = "DIGITS", default_value = "double")]
    precision: Precision,
    #[command(flatten)]
    user: UserFiles,
    /// Do not run the first moments, which tell what the whole run will take.
    #[arg(long)]
    no_look: bool,
    /// Show the bytes of each effect.
    #[arg(long)]
    bytes: bool,
    /// Print one JSON object: diagnostics, overview, ledger.
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    accepted: bool,
    diagnostics: Vec<Finding>,
    #[serde(skip_serializing_if = "Option::is_none")]
    overview: Option<&'a Overview>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ledger: Option<&'a Ledger>,
}

impl Check {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let (routines, _) = self.user.routines(self.json, false)?;
        let (prepared, mut overview) = job::examine(self.precision, &self.deck, &pairs(&self.set)?, &routines);
        if let Some(overview) = overview.as_mut().filter(|_| !self.no_look) {
            overview.effort = overview::measure(&prepared.plan, &prepared.state, LOOK);
        }
        if self.json {
            return print_json(&prepared, overview.as_ref());
        }
        accept(&prepared, false)?;
        if let Some(overview) = &overview {
            words::write(format_args!("{}", overview.render()), true);
        }
        words::write(format_args!("{}", prepared.plan.ledger.render(self.bytes)), false);
        Ok(super::shown())
    }
}

fn print_json(prepared: &Prepared, overview: Option<&Overview>) -> Result<Status, Box<dyn Error>> {
    let accepted = overview.is_some();
    let report = Report {
        accepted,
        diagnostics: prepared.diagnostics.findings(&prepared.deck.sources),
        overview,
        ledger: accepted.then_some(&prepared.plan.ledger),
    };
    say!("{}", serde_json::to_string_pretty(&report)?);
    Ok(if accepted { super::shown() } else { Status::from(REFUSED) })
}
