//! How many threads a command takes where nobody says it.

use std::env;

/// Variables that say how many processors a scheduler gives a task, as a number or as a list of them.
const GIVEN: [&str; 4] = ["SLURM_CPUS_PER_TASK", "HQ_CPUS", "PBS_NUM_PPN", "NSLOTS"];
/// Variables that are there in a task of a scheduler, and in a worker of what hands out tasks.
const WORKER: [&str; 7] =
    ["SLURM_JOB_ID", "HQ_TASK_ID", "PBS_JOBID", "SGE_TASK_ID", "LSB_JOBID", "DASK_WORKER_NAME", "RAY_RAYLET_PID"];

/// All processors that the process may use; in a task of a scheduler those it was given, or one: the others are its neighbours'.
pub fn default() -> usize {
    of(&|name| env::var(name).ok()).unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into))
}

/// The same in a task; `None` elsewhere.
fn of(variable: &dyn Fn(&str) -> Option<String>) -> Option<usize> {
    let given = GIVEN.iter().find_map(|name| {
        let text = variable(name)?;
        // HyperQueue lists processors by their numbers.
        if *name == "HQ_CPUS" { Some(text.split(',').count()) } else { text.trim().parse().ok() }
    });
    let worker = || WORKER.iter().any(|name| variable(name).is_some()).then_some(1);
    given.filter(|count| *count > 0).or_else(worker)
}

#[cfg(test)]
mod tests {
    use super::of;

    #[test]
    fn a_task_takes_what_it_is_given() {
        let with = |pairs: &[(&str, &str)]| {
            let pairs: Vec<(String, String)> = pairs.iter().map(|p| (p.0.to_owned(), p.1.to_owned())).collect();
            of(&move |name| pairs.iter().find(|p| p.0 == name).map(|p| p.1.clone()))
        };
        assert_eq!(with(&[]), None);
        assert_eq!(with(&[("SLURM_JOB_ID", "7")]), Some(1));
        assert_eq!(with(&[("SLURM_JOB_ID", "7"), ("SLURM_CPUS_PER_TASK", "4")]), Some(4));
        assert_eq!(with(&[("HQ_TASK_ID", "0"), ("HQ_CPUS", "2,3,5")]), Some(3));
        assert_eq!(with(&[("HQ_TASK_ID", "0"), ("HQ_CPUS", "11")]), Some(1));
        assert_eq!(with(&[("SLURM_JOB_ID", "7"), ("SLURM_CPUS_PER_TASK", "?")]), Some(1));
    }
}
