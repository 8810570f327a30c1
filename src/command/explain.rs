//! `revolve explain`.

use super::Status;
use std::error::Error;

use crate::explain::{explain, nearest_word};
use clap::Args;

use super::words::say;

/// Explain a keyword, an output variable, an element type, a function of quantities, units, files or a diagnostic code; `keywords`
/// and `variables` print all of them.
#[derive(Args)]
pub struct Explain {
    /// What is to be explained.
    #[arg(required = true)]
    word: Vec<String>,
}

impl Explain {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let word = self.word.join(" ");
        match explain(&word) {
            Some(text) => {
                say!("{}", text.trim_end());
                Ok(super::shown())
            }
            None => {
                let near = nearest_word(&word).map_or(String::new(), |near| format!("; did you mean {near}?"));
                Err(format!(
                    "`{word}` is no keyword, output variable, element type, function, topic or diagnostic code{near}\n`revolve \
                     explain keywords` and `revolve explain variables` list them"
                )
                .into())
            }
        }
    }
}
