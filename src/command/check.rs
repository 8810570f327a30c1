//! `revolve check`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use revolve::job;
use revolve::model::Precision;

use super::{REFUSED, UserFiles, accepted, pairs, words};

/// Check a deck: diagnostics and the ledger of what it would simulate.
#[derive(Args)]
pub struct Check {
    /// The input deck.
    deck: PathBuf,
    /// Replace the value of a *PARAMETER: NAME=VALUE.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Precision of solid elements: double or single.
    #[arg(long, value_name = "DIGITS", default_value = "double")]
    precision: Precision,
    #[command(flatten)]
    user: UserFiles,
}

impl Check {
    /// Carries it out.
    pub fn execute(self) -> Result<ExitCode, Box<dyn Error>> {
        let Some(routines) = self.user.routines(false) else { return Ok(ExitCode::from(REFUSED)) };
        let prepared = job::prepare_in(self.precision, &self.deck, &pairs(&self.set)?, &routines);
        if !accepted(&prepared, false) {
            return Ok(ExitCode::from(REFUSED));
        }
        words::write(format_args!("{}", prepared.plan.ledger.render()), false);
        Ok(super::shown())
    }
}
