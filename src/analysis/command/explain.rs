//! The command `revolve explain`: documentation of keywords, variables, codes and topics.

use super::CommandStatus;
use std::error::Error;

use crate::explain::{explain, nearest_word, search};
use clap::Args;

use super::words::print_out;

/// Explain a keyword, output variable, element type, quantity function, diagnostic code or topic such as units or
/// files. Other words are searched in all these texts. `explain keywords` and `explain variables` print the complete lists.
#[derive(Args)]
pub struct ExplainCommand {
    /// Word to explain, for example *PLASTIC, S11, CAX4R, D407 or units; or words to search, for example johnson cook.
    #[arg(required = true)]
    word: Vec<String>,
}

impl ExplainCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let word = self.word.join(" ");
        match explain(&word).or_else(|| search(&word)) {
            Some(text) => {
                print_out!("{}", text.trim_end());
                Ok(super::output_status())
            }
            None => {
                let near = nearest_word(&word).map_or(String::new(), |near| format!("; did you mean {near}?"));
                Err(format!(
                    "`{word}` is not a keyword, output variable, element type, function, topic or diagnostic code{near}\n`revolve \
                     explain keywords` and `revolve explain variables` print the complete lists"
                )
                .into())
            }
        }
    }
}
