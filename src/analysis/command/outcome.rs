//! Terminal summary of a run: status, warnings, key results and run time.

use crate::job::{FrameOutput, RunSummary, RunVerdict};
use crate::output::clock::seconds;
use crate::output::columns::aligned_table;
use crate::output::{self, HISTORY};

use super::words::{print_out, write};

/// Largest number of history columns that are printed.
const SHOWN: usize = 24;
/// Width of the bars of the profile, in characters.
const BAR: usize = 40;

pub fn print(summary: &RunSummary, job: &output::JobFiles, frames: FrameOutput, profile: bool) {
    print_out!("{}", completion(summary));
    warnings(summary);
    for rest in &summary.rests {
        print_out!("  {} came to rest at time {:.6e}, displacement {:.6e}", rest.body, rest.time, rest.displacement);
    }
    summary.unfinished.iter().for_each(|how| print_out!("  {how}"));
    histories(summary, job);
    increments(summary);
    print_out!("energy drift: {:.1e} of the energy put in", summary.energy.drift);
    if let Some(added) = summary.energy.added_mass {
        let energy = summary.energy.mass_scaling.unwrap_or(0.0);
        let places = summary.steps.last().and_then(|step| step.added_mass_at).unwrap_or_default().describe();
        print_out!("mass scaling: {added:.2} % added to the mass of the deformable bodies{places}, ALLMW {energy:.3e}");
    }
    if let Some(changes) = summary.mesh_changes {
        let lost = summary.energy.advection.unwrap_or(0.0);
        print_out!("adaptive meshes: {changes} changes (NADAPT), kinetic energy lost by transport (ALLADV) {lost:.3e}");
    }
    if let Some(count) = summary.new_meshes {
        let lost = summary.energy.advection.unwrap_or(0.0);
        let elements = summary.new_elements.unwrap_or(0);
        print_out!(
            "new meshes: {count} (NREMESH) with {elements} new elements, kinetic energy lost by transport (ALLADV) {lost:.3e}"
        );
    }
    if let Some(shape) = summary.mesh_shape.filter(|shape| shape.turned_corners > 0) {
        print_out!("{} elements have a corner that has turned over", shape.turned_corners);
    }
    if summary.deleted_elements > 0 {
        print_out!("{} elements were deleted", summary.deleted_elements);
    }
    if let Some(seconds) = summary.timing.checkpoint_seconds {
        print_out!("checkpoints: {:.2} % of the run time", 100.0 * seconds / summary.timing.seconds);
    }
    if profile {
        print_profile(summary);
    }
    print_out!("digest {}", summary.digest);
    print_out!("results in {}", frames.file(job).unwrap_or_else(|| job.path(HISTORY)).display());
}

/// Prints the verdict, and its reasons with places and cards.
pub fn print_verdict(verdict: &RunVerdict) {
    print_out!("verdict: {}", verdict.verdict.word());
    verdict.reasons.iter().for_each(|reason| print_out!("  {}", reason.line()));
}

fn completion(summary: &RunSummary) -> String {
    let run_time = seconds(summary.timing.seconds);
    let how = if summary.ended_by_user { "ended by a user subroutine" } else { summary.status };
    let resumed = summary.timing.resumed_at.map_or(String::new(), |at| format!(", restarted from increment {at}"));
    format!("{how}: {} increments in {run_time}{resumed}", summary.timing.increments)
}

fn warnings(summary: &RunSummary) {
    if !summary.warnings.is_empty() {
        let count = summary.warnings.len();
        print_out!(
            "{count} warning{} (printed above and listed in the summary file)",
            if count == 1 { "" } else { "s" }
        );
    }
}

fn histories(summary: &RunSummary, job: &output::JobFiles) {
    let columns = &summary.history.summary.0;
    if columns.is_empty() {
        return;
    }
    let number = |value: f64| format!("{value:.6e}");
    let mut header = vec!["history", "final", "min", "max"];
    if !summary.column_units.is_empty() {
        header.push("unit");
    }
    let row = |(name, column): (&String, &output::ColumnSummary)| {
        let unit = summary.column_units.get(name).cloned();
        [name.clone(), number(column.last), number(column.min), number(column.max)].into_iter().chain(unit).collect()
    };
    let rows: Vec<_> = columns.iter().take(SHOWN).map(row).collect();
    write(format_args!("{}", aligned_table(&header, &rows, false)), false);
    if columns.len() > SHOWN {
        print_out!("  and {} more columns in {}", columns.len() - SHOWN, job.path(HISTORY).display());
    }
}

fn increments(summary: &RunSummary) {
    for step in &summary.steps {
        let Some(element) = &step.limiting_element else { continue };
        let estimates = step.global_estimates.map_or(String::new(), |count| format!(", {count} global estimates"));
        print_out!(
            "{}: smallest stable time increment {:.3e} (element {element}){estimates}",
            step.name,
            step.smallest_increment
        );
    }
}

/// Prints the ledger rows in the order of their share of the run time.
fn print_profile(summary: &RunSummary) {
    let mut rows: Vec<_> = summary.ledger.effects.iter().filter_map(|row| Some((row, row.share?))).collect();
    rows.sort_by(|a, b| b.1.total_cmp(&a.1));
    let cells = |(row, share): &(&crate::plan::ledger::LedgerRow, f64)| {
        let time = share * summary.timing.seconds;
        let per = time / summary.timing.increments.max(1) as f64;
        vec![
            row.effect.clone(),
            format!("{} {}", row.count, row.unit),
            format!("{:.1} %", 100.0 * share),
            seconds(time),
            format!("{:.0}", 1e9 * per),
            format!("{:.2}", 1e9 * per / row.count.max(1) as f64),
            "#".repeat((BAR as f64 * share).round() as usize),
        ]
    };
    let rows: Vec<_> = rows.iter().map(cells).collect();
    let header = ["effect", "count", "share", "time", "ns/increment", "ns each", ""];
    write(format_args!("{}", aligned_table(&header, &rows, false)), false);
}
