//! Batch script of Slurm that started the program.

use std::{env, process};

use crate::platform::process_status;

/// Name of a process that runs a batch script: `slurmd` stores the script under this name.
const SCRIPT: &str = "slurm_script";
/// Largest number of ancestors that are examined.
const MOST_ANCESTORS: usize = 64;
/// Bit of SIGTERM in the masks of `/proc/<id>/status`.
const SIGTERM_BIT: u64 = 1 << 14;

/// Returns whether a batch script of Slurm started this process by an ordinary command and does not handle SIGTERM.
///
/// At the time limit Slurm sends SIGTERM to the script and the process. The script ends, with it the job step, and the
/// process is killed before it can write a checkpoint. A process that was started with `exec` or `srun` is a child of
/// `slurmstepd` instead, and has `KillWait` seconds.
pub fn has_no_grace_period() -> bool {
    env::var_os("SLURM_JOB_ID").is_some() && script_ends_at_sigterm(process::id(), &process_status)
}

/// Returns whether an ancestor of process `id` is a batch script that neither catches nor ignores SIGTERM. `status`
/// returns the text of `/proc/<id>/status`.
fn script_ends_at_sigterm(id: u32, status: &dyn Fn(u32) -> Option<String>) -> bool {
    let mut id = id;
    for _ in 0..MOST_ANCESTORS {
        let Some(text) = status(id) else { return false };
        let value = |name: &str| text.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
        let Some(parent) = value("PPid:").and_then(|text| text.parse().ok()) else { return false };
        // Subshells of the script have its name.
        let parent_is_script = || status(parent).is_some_and(|text| name_of(&text) == Some(SCRIPT));
        if name_of(&text) == Some(SCRIPT) && !parent_is_script() {
            let mask = |name: &str| value(name).and_then(|text| u64::from_str_radix(text, 16).ok());
            return ["SigCgt:", "SigIgn:"].iter().all(|name| mask(name).is_some_and(|mask| mask & SIGTERM_BIT == 0));
        }
        id = parent;
    }
    false
}

/// Returns the name of a process from its status.
fn name_of(status: &str) -> Option<&str> {
    status.lines().find_map(|line| line.strip_prefix("Name:")).map(str::trim)
}

#[cfg(test)]
mod tests {
    use super::script_ends_at_sigterm;

    /// Returns the result for a process with these ancestors, nearest first; a mask contains the caught signals.
    fn result(ancestors: &[(&str, &str)]) -> bool {
        let processes = [&[("revolve", "0")], ancestors].concat();
        let status = |id: u32| {
            let (name, caught) = processes.get(id as usize - 1)?;
            let parent = if (id as usize) < processes.len() { id + 1 } else { 0 };
            Some(format!("Name:\t{name}\nPPid:\t{parent}\nSigIgn:\t0000000000000000\nSigCgt:\t{caught}\n"))
        };
        script_ends_at_sigterm(1, &status)
    }

    #[test]
    fn only_ordinary_commands_of_a_batch_script_have_no_grace_period() {
        let (script, daemon) = (("slurm_script", "0000000000010002"), ("slurmstepd", "0000000000004000"));
        assert!(result(&[script, daemon]));
        assert!(result(&[("timeout", "0000000000004000"), script, daemon]));
        assert!(result(&[script, script, daemon]));
        assert!(!result(&[daemon]));
        assert!(!result(&[("bash", "0"), daemon]));
        assert!(!result(&[("salloc", "0"), ("bash", "0")]));
        // The script has `trap ... TERM`.
        assert!(!result(&[("slurm_script", "0000000000014002"), daemon]));
        assert!(!result(&[script, ("slurm_script", "0000000000014002"), daemon]));
    }
}
