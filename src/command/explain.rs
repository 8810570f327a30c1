//! `revolve explain`.

use std::error::Error;
use std::process::ExitCode;

use clap::Args;
use revolve::explain::explain;

use super::words::say;

/// Explain a keyword, an output variable or a diagnostic code; `keywords` and `variables` print all of them.
#[derive(Args)]
pub struct Explain {
    /// Keyword, variable or code.
    word: Vec<String>,
}

impl Explain {
    /// Carries it out.
    pub fn execute(self) -> Result<ExitCode, Box<dyn Error>> {
        let word = self.word.join(" ");
        match explain(&word) {
            Some(text) => {
                say!("{}", text.trim_end());
                Ok(super::shown())
            }
            None => Err(format!(
                "`{word}` is no keyword, no output variable and no diagnostic code; `revolve explain keywords` and `revolve \
                 explain variables` list them"
            )
            .into()),
        }
    }
}
