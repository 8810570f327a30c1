//! `revolve mesh refine`: writes a deck with its mesh refined or coarsened.

use std::error::Error;
use std::path::PathBuf;

use clap::Args;

use super::options::{CurvedOption, QuietOption, SetOption};
use super::words::print_out;
use super::{CommandStatus, accept};
use crate::study::map::regions;
use crate::{deck, model};

/// Arguments of `revolve mesh refine`.
#[derive(Args)]
pub struct RefineArguments {
    /// Input deck.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    /// Number of parts of each edge; 1 lists the mesh as it is, and 1/2 or 1/3 merges elements.
    #[arg(short = 'k', value_name = "PARTS", required_unless_present = "regions")]
    parts: Option<String>,
    /// Divide only the edges of the named element sets, or regions of --map, into two parts; neighbouring elements are replaced
    /// by conforming transitions.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', conflicts_with = "parts")]
    regions: Vec<String>,
    /// Error map `<job>_map.json` of `revolve study --map` that defines the regions.
    #[arg(long, value_name = "FILE", requires = "regions")]
    map: Option<PathBuf>,
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
        settings.extend(self.parts.clone().map(|parts| (deck::MESH_SETTINGS[0].to_owned(), parts)));
        settings.extend(self.curved.setting());
        let (mut deck, mut findings) = deck::read(&self.deck, &settings);
        if !self.regions.is_empty() && !findings.has_errors() {
            let (model, build_findings) = model::build(&deck);
            accept(&build_findings, &deck.sources, true)?;
            deck.refine_elements(regions::named(&model, &self.regions, self.map.as_deref())?);
        }
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
