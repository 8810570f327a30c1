//! Collects the result files of a folder into the data of a report page.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::data::{ColumnSummaryRow, ReportPage, ReportRun};
use super::read::{in_file, json, text, verified_json, verified_text};
use super::units::UnitNames;
use super::{PageOptions, ReportError, balance, compare, frames, history, limits, pack, search, study, sweep};
use crate::output::sums::Checksums;
use crate::output::{HISTORY, VTKHDF};
use crate::study::cases::{LOG, finished_table};
use crate::study::chart::{Chart, ChartSeries, SeriesForm};
use crate::study::record::CERTIFICATE;

/// Largest number of runs on a page.
const RUNS: usize = 6;
/// Largest number of history columns in the table of a run.
const COLUMNS: usize = 200;

/// Reads the results in a folder, with labels of quantities and reference curves.
pub fn page(folder: &Path, options: &PageOptions) -> Result<ReportPage, ReportError> {
    let (names, sums) = (file_names(folder)?, Checksums::of(folder)?);
    let with = |ending: &str| -> BTreeSet<String> {
        names.iter().filter_map(|n| n.strip_suffix(ending)).filter(|n| !n.is_empty()).map(str::to_owned).collect()
    };
    let (sweeps, studies) = (with("_sweep.csv"), with("_study.json"));
    let mut jobs = with(".pvd");
    jobs.extend(with(".json").into_iter().filter(|n| is_run(&folder.join(format!("{n}.json")))));
    let mut page = ReportPage {
        folder: folder.display().to_string(),
        version: env!("CARGO_PKG_VERSION"),
        ..ReportPage::default()
    };
    if jobs.len() > RUNS {
        page.notes.push(format!("{RUNS} of {} runs are shown", jobs.len()));
    }
    for name in jobs.iter().take(RUNS) {
        page.runs.push(run(folder, name, &sums)?);
    }
    for name in &sweeps {
        let path = folder.join(format!("{name}_sweep.csv"));
        page.sweeps.push(in_file(&path, sweep::table(name, &verified_text(&path, &sums)?))?);
    }
    let unfinished = with(LOG);
    for name in &unfinished {
        let path = folder.join(format!("{name}{LOG}"));
        let (table, [count, failed]) =
            finished_table(&text(&path)?).ok_or_else(|| format!("{}: the table is damaged", path.display()))?;
        let mut table = in_file(&path, sweep::table(name, &table))?;
        table.notes.push(format!(
            "the sweep is running or was interrupted: {count} cases have finished, {failed} of them without a result; \
             --resume continues it"
        ));
        page.sweeps.push(table);
    }
    for name in &studies {
        page.studies.push(study::read(name, &verified_json(&folder.join(format!("{name}_study.json")), &sums)?));
    }
    for kind in search::KINDS {
        for name in with(&format!("_{}.csv", kind.0)) {
            page.searches.push(search::read(folder, &name, kind, &sums)?);
        }
    }
    let searched = page.searches.iter().map(|search| &search.table.name);
    let job_names: BTreeSet<&String> =
        jobs.iter().chain(&sweeps).chain(&unfinished).chain(&studies).chain(searched).collect();
    if job_names.is_empty() {
        return Err(nothing_found(folder).into());
    }
    page.title = job_names.into_iter().cloned().collect::<Vec<_>>().join(", ");
    if let Some(file) = &options.compare {
        compare_runs(folder, file, &mut page)?;
    }
    options.labels.apply_to_page(&mut page)?;
    Ok(page)
}

/// Returns the message of a folder without results.
fn nothing_found(folder: &Path) -> String {
    format!(
        "{} contains no run (<job>.json, <job>.pvd), no sweep (<job>_sweep.csv), no study (<job>_study.json) and no table \
         of limit, identify or scatter (<job>_limit.csv)",
        folder.display()
    )
}

/// Returns the name of the only run in a folder.
pub fn only_run(folder: &Path) -> Result<String, String> {
    let names = file_names(folder)?;
    let runs: Vec<&str> = names.iter().filter_map(|n| n.strip_suffix(HISTORY)).collect();
    let series: Vec<&str> = names.iter().filter_map(|n| n.strip_suffix(".pvd")).collect();
    let run_names: BTreeSet<&str> = runs.into_iter().chain(series).collect();
    let mut remaining_names = run_names.into_iter();
    match (remaining_names.next(), remaining_names.next()) {
        (Some(name), None) => Ok(name.to_owned()),
        (None, _) => Err(format!("{} contains no run", folder.display())),
        _ => Err(format!("{} contains several runs; use a separate result folder for each run", folder.display())),
    }
}

/// Returns the targets and analytical planes from the summary of a run; null without a summary.
pub fn scene(folder: &Path, name: &str, sums: &Checksums) -> Result<Value, String> {
    let path = folder.join(format!("{name}.json"));
    if !path.is_file() {
        return Ok(Value::Null);
    }
    Ok(verified_json(&path, sums)?.get("scene").cloned().unwrap_or_default())
}

fn file_names(folder: &Path) -> Result<Vec<String>, String> {
    let entries = in_file(folder, std::fs::read_dir(folder))?;
    Ok(entries.filter_map(|e| e.ok()?.file_name().into_string().ok()).collect())
}

/// Returns whether a JSON file is the summary of a run.
fn is_run(path: &Path) -> bool {
    json(path).is_ok_and(|v| v.get("status").is_some() && v.get("ledger").is_some())
}

/// Reads the existing files of a run.
fn run(folder: &Path, name: &str, sums: &Checksums) -> Result<ReportRun, String> {
    let mut run = run_without_frames(folder, name, sums)?;
    let list = folder.join(format!("{name}.pvd"));
    if list.is_file() {
        sums.verify(&list)?;
        let series = frames::series(&list)?;
        let scene = run.summary.get("scene").cloned().unwrap_or_default();
        run.meridian = pack::pack(&series, &scene, (&UnitNames::of(&run.summary), sums), &mut run.notes)?;
    } else if folder.join(format!("{name}{VTKHDF}")).is_file() {
        run.notes.push(format!("there are no pictures: the frames are in {name}{VTKHDF}, for ParaView"));
    } else {
        run.notes.push("there are no frames: the deck requests no field output".into());
    }
    Ok(run)
}

/// Reads the existing files of a run except its frames.
pub(crate) fn run_without_frames(folder: &Path, name: &str, sums: &Checksums) -> Result<ReportRun, String> {
    let file = |ending: &str| folder.join(format!("{name}{ending}"));
    let mut run = ReportRun { name: name.to_owned(), ..ReportRun::default() };
    if !sums.has(&file(".pvd")) && !sums.has(&file(HISTORY)) {
        run.notes.push("there is no list of checksums (.sfv): the files cannot be verified".into());
    }
    if file(".json").is_file() {
        run.summary = verified_json(&file(".json"), sums)?;
    } else {
        run.notes.push("there is no summary: the run has not finished".into());
    }
    if let Some(Value::Object(history)) = run.summary.as_object_mut().and_then(|s| s.shift_remove("history")) {
        run.columns = history.iter().map(|(name, values)| column(name, values)).collect();
    }
    if file(CERTIFICATE).is_file() {
        run.uncertainties = certificate_lines(&verified_json(&file(CERTIFICATE), sums)?);
    }
    if file(HISTORY).is_file() {
        sums.verify(&file(HISTORY))?;
        histories(&file(HISTORY), &mut run)?;
    }
    run.columns.truncate(COLUMNS);
    let limits = run.summary.as_object_mut().and_then(|s| s.shift_remove("limits")).unwrap_or_default();
    run.charts.extend(limits::chart(&limits, &UnitNames::of(&run.summary)));
    Ok(run)
}

/// Returns the conclusions of a certificate of `revolve run --uncertainty`.
fn certificate_lines(certificate: &Value) -> Vec<String> {
    let lines = certificate.get("conclusions").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    lines.iter().filter_map(|line| line.as_str().map(str::to_owned)).collect()
}

/// Adds the reference curves of a file to the charts of the only run on a page.
fn compare_runs(folder: &Path, file: &Path, page: &mut ReportPage) -> Result<(), String> {
    let [run] = &mut page.runs[..] else {
        return Err(format!("--compare {}: the folder must contain exactly one run", file.display()));
    };
    for curve in compare::curves(file, &folder.join(format!("{}{HISTORY}", run.name)))? {
        run.deviations.push(curve.sentence());
        let has = |chart: &&mut Chart| chart.series.iter().any(|s| s.name == curve.column);
        let Some(chart) = run.charts.iter_mut().find(has) else {
            run.notes.push(format!("the column {} and its reference are not drawn", curve.column));
            continue;
        };
        chart.series.push(ChartSeries::new(curve.name(), SeriesForm::Marks, curve.points));
    }
    Ok(())
}

/// Returns the unit names of the run of a history file.
pub(super) fn units(history: &Path) -> UnitNames {
    let name = history.file_name().and_then(|n| n.to_str()?.strip_suffix(HISTORY));
    let summary = name.and_then(|name| json(&history.with_file_name(format!("{name}.json"))).ok());
    UnitNames::of(&summary.unwrap_or_default())
}

fn column(name: &str, values: &Value) -> ColumnSummaryRow {
    let number = |key: &str| values.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN);
    ColumnSummaryRow { name: name.to_owned(), last: number("final"), min: number("min"), max: number("max") }
}

fn histories(path: &Path, run: &mut ReportRun) -> Result<(), String> {
    let choice = history::choose(&history::names(path)?, &run.columns);
    let mut drawn_columns: Vec<String> = choice.charts.iter().flat_map(|c| c.1.clone()).collect();
    drawn_columns
        .extend(balance::columns().map(str::to_owned).filter(|c| !drawn_columns.contains(c)).collect::<Vec<_>>());
    let history = history::read(path, &drawn_columns)?;
    let units = UnitNames::of(&run.summary);
    if history.times.len() > 1 {
        let chart_of = |(title, columns): &(String, Vec<String>)| history::chart(title, columns, &history, &units);
        run.charts = balance::chart(&history, &units).into_iter().chain(choice.charts.iter().map(chart_of)).collect();
    }
    if choice.left_out > 0 {
        run.notes.push(format!(
            "{} history columns are not drawn (energies that are zero, and the columns of a variable with the smallest variation)",
            choice.left_out
        ));
    }
    if run.columns.len() > COLUMNS {
        run.notes.push(format!("{COLUMNS} of {} columns are in the table", run.columns.len()));
    }
    Ok(())
}
