//! `revolve explain`.

use std::process::ExitCode;

use clap::Args;
use revolve::explain::explain;

/// Explain a keyword or a diagnostic code; `keywords` prints the whole manual.
#[derive(Args)]
pub struct Explain {
    /// Keyword or code.
    word: Vec<String>,
}

impl Explain {
    /// Carries it out.
    pub fn execute(self) -> Result<ExitCode, String> {
        let word = self.word.join(" ");
        match explain(&word) {
            Some(text) => {
                println!("{}", text.trim_end());
                Ok(ExitCode::SUCCESS)
            }
            None => Err(format!(
                "`{word}` is no keyword and no diagnostic code; `revolve explain keywords` lists all keywords"
            )),
        }
    }
}
