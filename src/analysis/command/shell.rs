//! Shell completions, manual page and version text.

use std::error::Error;
use std::sync::LazyLock;

use crate::job::Instructions;
use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::line::ProgramArguments;
use super::{CommandStatus, words};

/// Print completions for a shell; `source <(revolve completions bash)` activates them.
#[derive(Args)]
pub struct CompletionsCommand {
    /// Shell for which completions are printed.
    shell: Shell,
}

/// Print the manual page; `revolve man | man -l -` displays it.
#[derive(Args)]
pub struct ManCommand {}

impl CompletionsCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let mut bytes = Vec::new();
        clap_complete::generate(self.shell, &mut ProgramArguments::command(), "revolve", &mut bytes);
        words::write(format_args!("{}", String::from_utf8(bytes)?), false);
        Ok(super::output_status())
    }
}

impl ManCommand {
    /// Prints the manual page of the program, followed by those of its commands.
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let mut program = ProgramArguments::command();
        program.build();
        let mut bytes = Vec::new();
        clap_mangen::Man::new(program.clone()).render(&mut bytes)?;
        for command in program.get_subcommands().filter(|c| c.get_name() != "help") {
            let page = clap_mangen::Man::new(command.clone());
            page.render_name_section(&mut bytes)?;
            page.render_synopsis_section(&mut bytes)?;
            page.render_options_section(&mut bytes)?;
        }
        words::write(format_args!("{}", String::from_utf8(bytes)?), false);
        Ok(super::output_status())
    }
}

/// Returns version, commit and date (from `build.rs`), features, target, threads and instruction set.
pub fn version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(long_version);
    &TEXT
}

fn long_version() -> String {
    let commit = super::COMMIT;
    let commit = if commit.is_empty() { String::new() } else { format!(" ({commit})") };
    let features = [("mesh-files", cfg!(feature = "mesh-files")), ("parquet", cfg!(feature = "parquet"))];
    let features: Vec<&str> = features.iter().filter(|f| f.1).map(|f| f.0).collect();
    let has = |set: &Instructions| set.arch().is_some();
    let sets = [("avx512", Instructions::Avx512), ("avx2", Instructions::Avx2), ("scalar", Instructions::Scalar)];
    let best = sets.iter().find(|(_, set)| has(set)).map_or("scalar", |(name, _)| name);
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!(
        "{}{commit}\nfeatures: {}\ntarget: {}\nthis machine: {threads} threads, instructions {best}",
        env!("CARGO_PKG_VERSION"),
        features.join(", "),
        env!("REVOLVE_TARGET")
    )
}
