//! A load with memory: a bed that is crushed under a rigid disc and unloads along a steeper line. The disc's velocity after the
//! rebound is compared with the closed form, and with a run that was interrupted under load and restarted.
//! `cargo run --release --example own_load`.

use std::error::Error;
use std::sync::atomic::{AtomicUsize, Ordering};

use revolve::job::{self, FrameOutput, JobOptions, PreparedJob, RestartRequirement, RunSummary};
use revolve::output::JobFiles;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

/// Pressure per depth during loading and unloading. The largest depth of each point is its memory.
pub struct Bed {
    loading: f64,
    unloading: f64,
}

impl UserLoad for Bed {
    fn memory(&self) -> usize {
        1
    }

    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        for (i, p) in pressure.iter_mut().enumerate() {
            let (depth, deepest) = (-points.z[i], &points.memory[i]);
            deepest.set(deepest.get().max(depth));
            let crushed = deepest.get() * (1.0 - self.loading / self.unloading);
            *p = (self.unloading * (depth - crushed)).max(0.0);
        }
        Ok(())
    }
}

const VELOCITY: f64 = -10.0;
const BED: Bed = Bed { loading: 1e8, unloading: 4e8 };
const DECK: &str = "*Node, nset=REF\n 1, 0., 0.\n*Node\n 2, 0.1, 0.\n*Element, type=RAX2, elset=DISC\n 1, 1, 2
*Surface, name=BOTTOM\n DISC, SNEG\n*Rigid Body, elset=DISC, ref node=1, density=7850.\n 0.01,
*Initial Conditions, type=VELOCITY\n REF, 2, -10.\n*Step\n*Dynamic, Explicit, direct user control\n 1.e-6, 4.e-3
*Dsload\n BOTTOM, PNU\n*Output, history, number interval=100\n*Node Output, nset=REF\n U2, V2\n*End Step\n";

/// Prepares the disc with a new load, as another process would.
pub fn prepared() -> PreparedJob {
    job::prepare_text("disc.inp", DECK, &[], &Routines::none().with_load(BED))
}

/// Runs to files in a folder, from its checkpoint if there is one; interrupts after a fraction of the time.
fn run_part(folder: &std::path::Path, end: f64) -> Result<RunSummary, Box<dyn Error>> {
    let (prepared, signal) = (prepared(), AtomicUsize::new(0));
    let files = JobFiles { folder: folder.into(), name: "disc".into() };
    let (from, _) =
        job::find_checkpoint(&prepared, &files, "", RestartRequirement::Whole).map_err(|why| why.message)?;
    let options = JobOptions { interrupt: Some(&signal), from, frames: FrameOutput::Absent, ..JobOptions::default() };
    let mut follow = |progress: &revolve::solve::Progress<'_>| {
        if progress.fraction >= end {
            signal.store(2, Ordering::Relaxed);
        }
    };
    Ok(job::run_with(&prepared, &files, options, &mut follow)?)
}

/// Returns the velocity after the rebound: of an uninterrupted run, of one restarted in the given empty folder at a quarter of
/// the time, and that of the closed form. The bed returns the share `loading / unloading` of the energy.
pub fn velocities(folder: &std::path::Path) -> Result<[f64; 3], Box<dyn Error>> {
    let history = job::run_to_end(&prepared())?;
    let interrupted = run_part(folder, 0.25)?.halt.ok_or("the run was not interrupted")?;
    println!("{interrupted}");
    let restarted = run_part(folder, 2.0)?.history.summary;
    Ok([history.0["V2@REF"].last, restarted.0["V2@REF"].last, -VELOCITY * (BED.loading / BED.unloading).sqrt()])
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::temp_dir().join(format!("own_load_{}", std::process::id()));
    let [velocity, restarted, exact] = velocities(&folder)?;
    println!("velocity {velocity:.6}, after a restart {restarted:.6}, closed form {exact:.6}");
    std::fs::remove_dir_all(folder)?;
    if velocity == restarted && (velocity / exact - 1.0).abs() < 1e-5 { Ok(()) } else { Err("they differ".into()) }
}
