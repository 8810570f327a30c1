//! The version of the program: commit, date, target.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=REVOLVE_TARGET={}", std::env::var("TARGET").unwrap_or_default());
    println!("cargo::rustc-env=REVOLVE_COMMIT={}", commit().unwrap_or_default());
}

/// Returns the commit and its date; `None` in a source archive. `REVOLVE_COMMIT` gives it where there is no git.
fn commit() -> Option<String> {
    println!("cargo::rerun-if-env-changed=REVOLVE_COMMIT");
    if let Ok(commit) = std::env::var("REVOLVE_COMMIT") {
        return Some(commit);
    }
    let commit = git(&["log", "-1", "--format=%h %cs"])?;
    // The folder of the profile is the third above the output. Other profiles keep the commit of their first compilation, so
    // that a commit compiles nothing again.
    let output = std::env::var("OUT_DIR").unwrap_or_default();
    let profile = Path::new(&output).ancestors().nth(3).and_then(Path::file_name).unwrap_or_default();
    if profile != "dist" {
        return Some(commit + " or later");
    }
    let is_modified = git(&["status", "--porcelain", "--untracked-files=no"]).is_none_or(|changes| !changes.is_empty());
    let commit = if is_modified { commit + " modified" } else { commit };
    for name in ["HEAD", "logs/HEAD", "index"] {
        let file = git(&["rev-parse", "--git-path", name])?;
        // A file that does not exist would run this again each time.
        if Path::new(&file).exists() {
            println!("cargo::rerun-if-changed={file}");
        }
    }
    Some(commit)
}

fn git(words: &[&str]) -> Option<String> {
    // A folder inside another project's checkout is a source archive.
    if !Path::new("../../.git").exists() {
        return None;
    }
    let output = Command::new("git").args(words).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
