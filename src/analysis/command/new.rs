//! `revolve new`: writes an example deck from `input/`, with its user subroutine if it has one.

use super::CommandStatus;
use std::error::Error;
use std::fs::OpenOptions;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::options::QuietOption;
use super::words::print_out;

/// Write an example deck to start from.
#[derive(Args)]
pub struct NewCommand {
    /// Example to copy.
    #[arg(default_value = "taylor")]
    template: StarterDeck,
    /// Folder for the files.
    #[arg(short, long, default_value = ".")]
    out: PathBuf,
    #[command(flatten)]
    quiet: QuietOption,
}

/// Example to copy.
#[derive(Clone, Copy, ValueEnum)]
enum StarterDeck {
    /// Taylor test: a copper bar strikes a rigid wall (plasticity, histories, frames).
    Taylor,
    /// Rigid ogive projectile into a cavity-expansion target without a mesh.
    Ogive,
    /// Steel rod through an aluminium plate (contact, Johnson-Cook plasticity and failure).
    Plate,
    /// The ogive projectile with its resistance in a Fortran VDLOAD.
    Vdload,
}

type TemplateFile = (&'static str, &'static str);

impl StarterDeck {
    fn files(self) -> &'static [TemplateFile] {
        match self {
            StarterDeck::Taylor => &[("taylor_copper.inp", include_str!("../../../input/taylor_copper.inp"))],
            StarterDeck::Ogive => &[("ogive.inp", include_str!("../../../input/ogive.inp"))],
            StarterDeck::Plate => &[("rod_plate.inp", include_str!("../../../input/rod_plate.inp"))],
            StarterDeck::Vdload => &[
                ("ogive_user.inp", include_str!("../../../input/ogive_user.inp")),
                ("vdload_cavity.f", include_str!("../../../input/vdload_cavity.f")),
            ],
        }
    }
}

impl NewCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        std::fs::create_dir_all(&self.out).map_err(|e| format!("cannot create folder {}: {e}", self.out.display()))?;
        let files = self.template.files();
        let paths: Vec<PathBuf> = files.iter().map(|(name, _)| self.out.join(name)).collect();
        for (count, (path, (_, text))) in paths.iter().zip(files).enumerate() {
            if let Err(why) = write_new(path, text) {
                // With a part of the files, the command could not be repeated.
                paths[..count].iter().for_each(|path| drop(std::fs::remove_file(path)));
                return Err(why.into());
            }
        }
        if self.quiet.quiet {
            return Ok(CommandStatus::SUCCESS);
        }
        let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        print_out!("wrote {}", paths.join(" and "));
        let user = paths.get(1).map_or(String::new(), |routine| format!(" --user {routine}"));
        print_out!("  revolve check {}{user}", paths[0]);
        print_out!("  revolve run {}{user}", paths[0]);
        Ok(super::output_status())
    }
}

/// Writes a new file; an existing file is not overwritten.
fn write_new(path: &Path, text: &str) -> Result<(), String> {
    let cannot = |e: io::Error| format!("cannot write {}: {e}", path.display());
    let mut file = OpenOptions::new().write(true).create_new(true).open(path).map_err(cannot)?;
    file.write_all(text.as_bytes()).map_err(|e| {
        // An incomplete deck must not be taken for a complete one.
        let _ = std::fs::remove_file(path);
        cannot(e)
    })
}
