//! `revolve mesh refine`: writes a deck with its mesh refined or coarsened.

use std::error::Error;
use std::path::PathBuf;

use clap::Args;

use super::options::{CurvedOption, QuietOption, SetOption};
use super::words::print_out;
use super::{CommandStatus, accept};
use crate::{deck, model};

/// Arguments of `revolve mesh refine`.
#[derive(Args)]
pub struct RefineArguments {
    /// Input deck.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    /// Number of parts of each edge; 1 lists the mesh as it is, and 1/2 or 1/3 merges elements.
    #[arg(short = 'k', value_name = "PARTS")]
    parts: String,
    #[command(flatten)]
    curved: CurvedOption,
    #[command(flatten)]
    set: SetOption,
    /// Deck to write. It contains all included files.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    quiet: QuietOption,
}

impl RefineArguments {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let mut settings = self.set.pairs()?;
        settings.push((deck::MESH_SETTINGS[0].to_owned(), self.parts));
        settings.extend(self.curved.setting());
        let (deck, mut findings) = deck::read(&self.deck, &settings);
        let mut text = String::new();
        if !findings.has_errors() {
            let (written, write_findings) = model::relisting::write(&deck);
            text = written;
            findings.append(write_findings);
        }
        accept(&findings, &deck.sources, true)?;
        super::mesh::write(&self.out, text.as_bytes())?;
        if !self.quiet.quiet {
            print_out!("wrote {}", self.out.display());
        }
        Ok(super::output_status())
    }
}
