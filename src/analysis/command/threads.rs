//! Default number of threads of a command.

use std::env;

/// Environment variables with the processors that a scheduler assigns to a task, as a number or as a list of processor
/// numbers.
const GIVEN: [&str; 4] = ["SLURM_CPUS_PER_TASK", "HQ_CPUS", "PBS_NUM_PPN", "NSLOTS"];
/// Environment variables that are set in a scheduler task or in a worker process of Dask or Ray.
const WORKER: [&str; 7] =
    ["SLURM_JOB_ID", "HQ_TASK_ID", "PBS_JOBID", "SGE_TASK_ID", "LSB_JOBID", "DASK_WORKER_NAME", "RAY_RAYLET_PID"];

/// Returns the number of processors available to the process. In a scheduler task it is the number assigned to the
/// task, or 1 if the scheduler does not state it: the other processors belong to other tasks.
pub fn default() -> usize {
    of(&|name| env::var(name).ok()).unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into))
}

/// Returns the number of threads in a scheduler task; `None` outside one.
fn of(variable: &dyn Fn(&str) -> Option<String>) -> Option<usize> {
    let assigned = GIVEN.iter().find_map(|name| {
        let text = variable(name)?;
        // HyperQueue lists processors by their numbers.
        if *name == "HQ_CPUS" { Some(text.split(',').count()) } else { text.trim().parse().ok() }
    });
    let worker = || WORKER.iter().any(|name| variable(name).is_some()).then_some(1);
    assigned.filter(|count| *count > 0).or_else(worker)
}

#[cfg(test)]
mod tests {
    use super::of;

    #[test]
    fn task_uses_the_processors_assigned_by_the_scheduler() {
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
