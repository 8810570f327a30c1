//! Error against time: which settings are worth their time, and what an accuracy costs.

use serde::Serialize;

use super::refinement::{Study, StudyRow};
use super::table::{duration, short};

/// What a setting costs and is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SettingCost {
    row: usize,
    bound: f64,
    seconds: f64,
    longest: f64,
    shortest: f64,
    cycles: f64,
}

fn offers(study: &Study) -> Vec<SettingCost> {
    let offer = |(row, r): (usize, &StudyRow)| {
        let run = r.run.as_ref().ok()?;
        let (time, cycles) = (run.seconds, run.element_cycles());
        Some(SettingCost { row, bound: r.bound?, seconds: time.median, longest: time.max, shortest: time.min, cycles })
    };
    study.rows.iter().enumerate().filter_map(offer).collect()
}

/// Rows that no other beats in both time and error, from the fastest on.
pub fn front(study: &Study) -> Vec<usize> {
    let mut offers = offers(study);
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

/// The cheapest setting whose error is below `bound`: within a family the one with the fewest element-cycles, between families
/// the fastest, or the fewest cycles where times overlap.
pub fn cheapest(study: &Study, bound: f64) -> Option<usize> {
    let mut best: Vec<SettingCost> = Vec::new();
    for offer in offers(study).into_iter().filter(|o| o.bound <= bound) {
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
pub struct Price {
    /// Error that is held: relative, or in the units of the quantity where the reference is zero.
    pub tolerance: f64,
    /// Row of the cheapest setting that holds it.
    pub run: usize,
    /// Seconds it takes, median.
    pub seconds: f64,
}

/// The run time for each power of ten of the error, from the widest on; of several of one setting the narrowest.
pub fn list(study: &Study) -> Vec<Price> {
    let unit = study.scale.unwrap_or(1.0);
    let bounds: Vec<f64> = offers(study).iter().map(|o| o.bound / unit).filter(|b| *b > 0.0).collect();
    let (low, high) = bounds.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), b| (l.min(*b), h.max(*b)));
    if bounds.is_empty() {
        return Vec::new();
    }
    let power = |b: f64| libm::log10(b).ceil().clamp(-300.0, 300.0) as i32;
    let mut prices: Vec<Price> = Vec::new();
    for exponent in (power(low)..=power(high)).rev() {
        let tolerance = libm::pow(10.0, f64::from(exponent));
        let Some(run) = cheapest(study, tolerance * unit) else { continue };
        let Ok(of) = &study.rows[run].run else { continue };
        // Who pays more for less has not seen this one.
        prices.retain(|p| p.run != run && p.seconds < of.seconds.median);
        prices.push(Price { tolerance, run, seconds: of.seconds.median });
    }
    prices
}

/// The list in a line that a person can act on; empty without prices.
pub fn sentence(study: &Study) -> String {
    let one = |p: &Price| {
        let tolerance = tolerance_in_words(p.tolerance, study.scale.is_some());
        format!("{tolerance} costs {} ({})", duration(p.seconds), setting(study, p.run))
    };
    list(study).iter().map(one).collect::<Vec<_>>().join(", ")
}

/// A tolerance with its unit: per cent, or as it is.
pub fn tolerance_in_words(tolerance: f64, relative: bool) -> String {
    if relative { format!("{} %", short(100.0 * tolerance)) } else { format!("an error of {}", short(tolerance)) }
}

/// The values of a row's axes: `n = 40, load-velocity = lagged`.
pub fn setting(study: &Study, row: usize) -> String {
    let of = study.axes.iter().zip(&study.rows[row].values);
    of.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
}
