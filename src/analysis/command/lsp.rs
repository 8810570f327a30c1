//! The command `revolve lsp`: a language server for editors.

use std::error::Error;
use std::io::{self, BufReader};

use clap::Args;

use super::CommandStatus;

/// Serve an editor: diagnostics, completion, documentation and navigation of decks by the language server protocol, on
/// standard input and output. Editors start the command; docs/editor.md says how.
#[derive(Args)]
pub struct LspCommand {
    /// Communicate through standard input and output, which is always so. Some editors give this option.
    #[arg(long)]
    stdio: bool,
}

impl LspCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        revolve_editor::serve(BufReader::new(io::stdin()), io::stdout().lock())?;
        Ok(CommandStatus::SUCCESS)
    }
}
