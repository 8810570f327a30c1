//! Options that several commands have. Each is defined once.

use std::path::PathBuf;

use clap::Args;

use super::threads;
use crate::deck::CURVE_SETTING;
use crate::report::QuantityLabels;

/// Option for curved boundaries of a refined mesh.
#[derive(Args)]
pub struct CurvedOption {
    /// Fit smooth curves to the boundaries of a refined mesh; they have corners where a boundary of the deck turns by more
    /// than this angle in degrees.
    #[arg(long, value_name = "ANGLE", num_args = 0..=1, require_equals = true, default_missing_value = "30")]
    curved: Option<String>,
}

impl CurvedOption {
    /// Returns the setting of the deck.
    pub fn setting(&self) -> Option<(String, String)> {
        self.curved.as_ref().map(|angle| (CURVE_SETTING.to_owned(), angle.clone()))
    }
}

/// Number of threads of a command that runs decks.
#[derive(Args, Clone, Copy)]
pub struct ThreadOption {
    /// Number of threads (default: all cores; in a scheduler task the assigned cores, or one); results are bit-identical
    /// for any number.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl ThreadOption {
    /// Returns the number of threads.
    pub fn count(self) -> usize {
        self.threads.map_or_else(threads::default, Into::into)
    }
}

/// Result folder of a command that writes several files.
#[derive(Args, Clone)]
pub struct FolderOption {
    /// Result folder (default: out/<deck name>).
    #[arg(short, long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

/// Suppression of informational output.
#[derive(Args, Clone, Copy)]
pub struct QuietOption {
    /// Print errors only.
    #[arg(short, long)]
    pub quiet: bool,
}

/// Form of the output of a command with a JSON object.
#[derive(Args, Clone, Copy)]
pub struct OutputOptions {
    #[command(flatten)]
    pub quiet: QuietOption,
    /// Print only one JSON object.
    #[arg(long)]
    pub json: bool,
}

impl OutputOptions {
    /// Returns whether informational output is suppressed.
    pub fn is_silent(self) -> bool {
        self.quiet.quiet || self.json
    }
}

/// Labels of quantities in pictures.
#[derive(Args, Clone)]
pub struct LabelOption {
    /// Label shown in pictures for a quantity, a column or a parameter, for example U2@REF="depth"; can be repeated.
    #[arg(long, value_name = "COLUMN=TEXT")]
    pub label: Vec<String>,
}

impl LabelOption {
    /// Parses the labels; a label of a name that is not among the `known` ones is an error.
    pub fn checked(&self, known: impl IntoIterator<Item = impl Into<String>>) -> Result<QuantityLabels, String> {
        let labels = QuantityLabels::parse(&self.label)?;
        labels.check(&known.into_iter().map(Into::into).collect::<Vec<_>>())?;
        Ok(labels)
    }
}
