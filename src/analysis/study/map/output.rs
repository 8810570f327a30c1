//! Table and sentences of an error map.

use super::{ErrorMap, FactorSource, RegionShare};
use crate::study::table::{TextTable, cell, digits, short};

/// Number of regions that the sentences name.
const NAMED: usize = 3;
/// Largest relative difference between the changes by half the element size and by the second level.
const SAME_CHANGE: f64 = 0.1;

/// Returns the table of an error map with few digits or with all digits.
pub fn table(map: &ErrorMap, all_digits: bool) -> TextTable {
    let header = [
        "region",
        "elements",
        "r from",
        "r to",
        "z from",
        "z to",
        "share",
        "share % of error",
        "uncertainty",
        "change forward",
        "change backward",
        "note",
    ];
    let number = |value: Option<f64>| cell(value, 4, all_digits);
    let percent = |value: f64| 100.0 * value / map.error;
    let row = |name: &str, share: Option<f64>| {
        let mut cells = vec![String::new(); header.len()];
        cells[0] = name.to_owned();
        (cells[6], cells[7]) = (number(share), cell(share.map(percent), 3, all_digits));
        cells
    };
    let of_region = |region: &RegionShare| {
        let mut cells = row(&region.region.name, region.share);
        cells[1] = region.region.elements.len().to_string();
        let [low, high] = region.bounds;
        for (at, value) in [low[0], high[0], low[1], high[1]].into_iter().enumerate() {
            cells[2 + at] = number(Some(value));
        }
        cells[8] = number(region.uncertainty);
        (cells[9], cells[10]) = (number(region.forward), number(region.backward));
        cells[11] = if region.failure.is_some() { "failed run".into() } else { String::new() };
        cells
    };
    let mut rows: Vec<Vec<String>> = map.regions.iter().map(of_region).collect();
    rows.push(row("increment", Some(map.increment)));
    rows.push(row("sum", Some(map.sum)));
    rows.push(row("uniform study", Some(map.error)));
    TextTable { header: header.map(String::from).to_vec(), rows }
}

/// Returns the lines below the table.
pub fn conclusions(map: &ErrorMap) -> Vec<String> {
    let percent = |value: f64| format!("{} %", short(100.0 * value / map.error));
    let mut largest: Vec<&RegionShare> = map.regions.iter().filter(|region| region.share.is_some()).collect();
    largest.sort_by(|a, b| magnitude(b).total_cmp(&magnitude(a)));
    let names = largest.iter().take(NAMED).map(|region| {
        let share = region.share.unwrap_or_default();
        let uncertainty = |value: f64| format!(" (+- {})", short((100.0 * value / map.error).abs()));
        let uncertainty = region.uncertainty.map(uncertainty).unwrap_or_default();
        format!("{} {}{uncertainty}", region.region.name, percent(share))
    });
    let mut lines = vec![
        format!(
            "error of {} on the mesh of {}: {} +- {} (limit minus {})",
            map.quantity,
            map.setting,
            short(map.error),
            short(map.error_uncertainty),
            digits(map.value, 7)
        ),
        format!("largest shares of this error: {}", names.collect::<Vec<_>>().join(", ")),
        format!(
            "sum of the shares {} (time increment {}): {} of the error, difference {}",
            short(map.sum),
            short(map.increment),
            percent(map.sum),
            short(map.difference)
        ),
        format!("assumption: {}", assumption(map)),
        format!(
            "{} companion runs, {} times the element-cycles of one run of each level",
            map.companions,
            short(map.cost)
        ),
    ];
    if map.level_change.is_some_and(|level| (map.uniform_change - level).abs() > SAME_CHANGE * level.abs()) {
        lines.push(format!(
            "half the element size changes the quantity by {}, the second level by {}: the parameter of the study changes more \
             than the element size; use --refine mesh=1,2,4",
            short(map.uniform_change),
            short(map.level_change.unwrap_or_default())
        ));
    }
    if map.regions.iter().all(|region| region.backward.is_none()) {
        lines.push(
            "the uncertainty of the shares is not estimated: runs in the reverse order would cost more than twice the study; \
             add a finer level"
                .into(),
        );
    }
    if map.regions.iter().any(|region| region.share.is_none()) {
        lines.push("the sum does not contain regions without a share".into());
    }
    if map.noise > 0.0 {
        lines.push(format!("noise of a share: {} ({})", short(map.noise), percent(map.noise)));
    }
    let failures = map.regions.iter().filter_map(|region| Some((region, region.failure.as_ref()?)));
    lines
        .extend(failures.map(|(region, failure)| format!("{}: a companion run failed: {failure}", region.region.name)));
    lines
}

fn magnitude(region: &RegionShare) -> f64 {
    region.share.unwrap_or_default().abs()
}

fn assumption(map: &ErrorMap) -> String {
    let factor = short(map.factor);
    match map.factor_source {
        FactorSource::Observed => {
            format!("the error of each region decreases with the order of the study; factor {factor} on changes")
        }
        FactorSource::Limit => format!(
            "the error of each region decreases as that of the whole mesh; factor {factor} on changes, without a credible order"
        ),
        FactorSource::Assumed => {
            format!(
                "the error of each region is of second order, because the study has no credible order; factor {factor} on changes"
            )
        }
    }
}
