//! `revolve new`: a deck to start from, with its user subroutine. They are the examples in `input/`.

use super::Status;
use std::error::Error;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::words::say;

/// Write a deck to start from, with a user subroutine where one belongs to it.
#[derive(Args)]
pub struct New {
    /// What to start from.
    #[arg(default_value = "taylor")]
    template: Template,
    /// Folder to write into.
    #[arg(short, long, default_value = ".")]
    out: PathBuf,
}

/// What to start from.
#[derive(Clone, Copy, ValueEnum)]
enum Template {
    /// A copper bar that is shot at a wall: plasticity, histories, frames.
    Taylor,
    /// A rigid ogive into a target that is not meshed: cavity expansion.
    Ogive,
    /// A steel rod through an aluminium plate: contact, Johnson-Cook, failure.
    Plate,
    /// The ogive with its resistance in a Fortran VDLOAD.
    Vdload,
}

type File = (&'static str, &'static str);

impl Template {
    fn files(self) -> &'static [File] {
        match self {
            Template::Taylor => &[("taylor_copper.inp", include_str!("../../input/taylor_copper.inp"))],
            Template::Ogive => &[("ogive.inp", include_str!("../../input/ogive.inp"))],
            Template::Plate => &[("rod_plate.inp", include_str!("../../input/rod_plate.inp"))],
            Template::Vdload => &[
                ("ogive_user.inp", include_str!("../../input/ogive_user.inp")),
                ("vdload_cavity.f", include_str!("../../input/vdload_cavity.f")),
            ],
        }
    }
}

impl New {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        std::fs::create_dir_all(&self.out)
            .map_err(|e| format!("cannot make the folder {}: {e}", self.out.display()))?;
        let files = self.template.files();
        for (name, text) in files {
            write_new(&self.out.join(name), text)?;
        }
        let paths: Vec<String> = files.iter().map(|(name, _)| self.out.join(name).display().to_string()).collect();
        say!("wrote {}", paths.join(" and "));
        let user = paths.get(1).map_or(String::new(), |routine| format!(" --user {routine}"));
        say!("  revolve check {}{user}", paths[0]);
        say!("  revolve run {}{user}", paths[0]);
        Ok(super::shown())
    }
}

/// Writes a file that is not there yet: nobody's deck is overwritten.
fn write_new(path: &Path, text: &str) -> Result<(), String> {
    let write = || OpenOptions::new().write(true).create_new(true).open(path)?.write_all(text.as_bytes());
    write().map_err(|e| format!("cannot write {}: {e}", path.display()))
}
