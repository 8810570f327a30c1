//! Error against run time: the Pareto front of the settings and the run time for a given accuracy.

use serde::Serialize;

use super::refinement::{RefinementStudy, StudyRow};
use super::table::{duration, short};

/// Error bound and run time of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SettingCost {
    row: usize,
    bound: f64,
    seconds: f64,
    longest: f64,
    shortest: f64,
    cycles: f64,
}

fn setting_costs(study: &RefinementStudy) -> Vec<SettingCost> {
    let offer = |(row, r): (usize, &StudyRow)| {
        let run = r.run.as_ref().ok()?;
        let (time, cycles) = (run.seconds, run.element_cycles());
        Some(SettingCost { row, bound: r.bound?, seconds: time.median, longest: time.max, shortest: time.min, cycles })
    };
    study.rows.iter().enumerate().filter_map(offer).collect()
}

/// Returns the rows on the Pareto front of run time and error, fastest first.
pub fn pareto_front(study: &RefinementStudy) -> Vec<usize> {
    let mut offers = setting_costs(study);
    offers.sort_by(|a, b| a.seconds.total_cmp(&b.seconds).then(a.bound.total_cmp(&b.bound)));
    let mut best = f64::INFINITY;
    let mut front = Vec::new();
    for offer in offers {
        if offer.bound < best {
            best = offer.bound;
            front.push(offer.row);
        }
    }
    front
}

/// Returns the cheapest setting with an error below `bound` that is not in `excluded`: within a family the one with the fewest element-cycles,
/// between families the fastest one, or the one with the fewest element-cycles if the ranges of run time overlap.
pub fn cheapest(study: &RefinementStudy, bound: f64, excluded: &[usize]) -> Option<usize> {
    let mut best: Vec<SettingCost> = Vec::new();
    for offer in setting_costs(study).into_iter().filter(|o| o.bound <= bound && !excluded.contains(&o.row)) {
        let family = study.rows[offer.row].family;
        match best.iter_mut().find(|o| study.rows[o.row].family == family) {
            Some(known) if known.cycles <= offer.cycles => {}
            Some(known) => *known = offer,
            None => best.push(offer),
        }
    }
    let fastest = *best.iter().min_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
    let alike = best.iter().filter(|o| o.shortest <= fastest.longest);
    alike.min_by(|a, b| a.cycles.total_cmp(&b.cycles)).map(|o| o.row)
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AccuracyCost {
    /// Error bound: relative, or in the units of the quantity if the reference is zero.
    pub tolerance: f64,
    /// Row of the cheapest setting within this error.
    pub run: usize,
    /// Median run time in seconds.
    pub seconds: f64,
}

/// Returns the run time for each power of ten of the error, largest error first. A setting is listed once, with its
/// smallest power of ten.
pub fn list(study: &RefinementStudy) -> Vec<AccuracyCost> {
    let unit = study.scale.unwrap_or(1.0);
    let bounds: Vec<f64> = setting_costs(study).iter().map(|o| o.bound / unit).filter(|b| *b > 0.0).collect();
    let (low, high) = bounds.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), b| (l.min(*b), h.max(*b)));
    if bounds.is_empty() {
        return Vec::new();
    }
    let power = |b: f64| libm::log10(b).ceil().clamp(-300.0, 300.0) as i32;
    let mut prices: Vec<AccuracyCost> = Vec::new();
    for exponent in (power(low)..=power(high)).rev() {
        let tolerance = libm::pow(10.0, f64::from(exponent));
        let Some(run) = cheapest(study, tolerance * unit, &[]) else { continue };
        let Ok(of) = &study.rows[run].run else { continue };
        // A setting for a larger error must not take longer than this one.
        prices.retain(|p| p.run != run && p.seconds < of.seconds.median);
        prices.push(AccuracyCost { tolerance, run, seconds: of.seconds.median });
    }
    prices
}

/// Formats the list in one line; empty without entries.
pub fn sentence(study: &RefinementStudy) -> String {
    let cost_text = |p: &AccuracyCost| {
        let tolerance = tolerance_in_words(p.tolerance, study.scale.is_some());
        format!("{tolerance} takes {} ({})", duration(p.seconds), setting(study, p.run))
    };
    list(study).iter().map(cost_text).collect::<Vec<_>>().join(", ")
}

/// Formats an error in per cent if it is relative, otherwise as a number.
pub fn tolerance_in_words(tolerance: f64, relative: bool) -> String {
    if relative { format!("{} %", short(100.0 * tolerance)) } else { format!("an error of {}", short(tolerance)) }
}

/// Formats the setting of a row, for example `n = 40, load-velocity = lagged`.
pub fn setting(study: &RefinementStudy, row: usize) -> String {
    setting_without(study, row, &[])
}

/// Formats the setting of a row without some axes.
pub fn setting_without(study: &RefinementStudy, row: usize, axes: &[&str]) -> String {
    let pairs = study.axes.iter().zip(&study.rows[row].values).filter(|(name, _)| !axes.contains(&name.as_str()));
    pairs.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
}
