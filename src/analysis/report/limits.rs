//! Chart of the time increment and its limiting elements over time, from a summary.

use serde_json::Value;

use super::shorten;
use super::units::UnitNames;
use crate::study::chart::{Chart, ChartSeries, SeriesForm};

pub const TITLE: &str = "Increment";
/// Number of limiting elements with a separate series; the others share one.
const NAMES: usize = 7;

/// Shortest increment of a time span, and the name of what limits it.
struct LimitSpan {
    time: f64,
    increment: f64,
    by: String,
}

/// Returns the chart of the increments of all steps; `None` without data.
pub fn chart(limits: &Value, units: &UnitNames) -> Option<Chart> {
    let spans: Vec<LimitSpan> = limits.as_array()?.iter().flat_map(spans).collect();
    if spans.len() < 2 {
        return None;
    }
    let mut names: Vec<(&str, usize)> = Vec::new();
    for LimitSpan { by, .. } in &spans {
        match names.iter_mut().find(|n| n.0 == by) {
            Some(known) => known.1 += 1,
            None => names.push((by, 1)),
        }
    }
    names.sort_by_key(|n| std::cmp::Reverse(n.1));
    let named: Vec<&str> =
        names.iter().take(if names.len() > NAMES + 1 { NAMES } else { NAMES + 1 }).map(|n| n.0).collect();
    let mut series = vec![points("shortest increment of each time span", SeriesForm::Guide, spans.iter())];
    series.extend(named.iter().map(|name| points(name, SeriesForm::Marks, spans.iter().filter(|s| s.by == *name))));
    if named.len() < names.len() {
        let others = format!("{} others", names.len() - named.len());
        series.push(points(&others, SeriesForm::Marks, spans.iter().filter(|s| !named.contains(&s.by.as_str()))));
    }
    let words = "with the element or contact that limits it".into();
    Some(Chart { units: units.over_time(TITLE), words, ..Chart::new(TITLE, ["time", "increment"], series) })
}

fn points<'a>(name: &str, form: SeriesForm, spans: impl Iterator<Item = &'a LimitSpan>) -> ChartSeries {
    let mut series = ChartSeries::new(name, form, Vec::new());
    for LimitSpan { time, increment, by } in spans {
        series.points.push((shorten(*time), shorten(*increment)));
        if form == SeriesForm::Marks && by != name {
            series.words.push(by.clone());
        }
    }
    series
}

fn spans(step: &Value) -> Vec<LimitSpan> {
    let list = |key: &str| step.get(key)?.as_array();
    let (Some(times), Some(increments), Some(by)) = (list("time"), list("increment"), list("by")) else {
        return Vec::new();
    };
    let span = |((time, increment), by): ((&Value, &Value), &Value)| {
        let name = list("names")?.get(usize::try_from(by.as_u64()?).ok()?)?.as_str()?;
        Some(LimitSpan { time: time.as_f64()?, increment: increment.as_f64()?, by: name.to_owned() })
    };
    times.iter().zip(increments).zip(by).filter_map(span).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rare_limits_share_a_series() {
        let count = 12;
        let names: Vec<String> = (0..count).map(|i| format!("element {i}")).collect();
        let time: Vec<usize> = (0..2 * count).collect();
        let limit_indices: Vec<usize> = (0..2 * count).map(|i| if i < count { i } else { 0 }).collect();
        let increment = vec![1e-7; 2 * count];
        let steps = serde_json::json!([{"time": time, "increment": increment, "by": limit_indices, "names": names}]);
        let chart = chart(&steps, &UnitNames::default()).expect("a chart");
        assert_eq!(chart.series.len(), 1 + NAMES + 1);
        assert_eq!((chart.series[1].name.as_str(), chart.series[1].points.len()), ("element 0", count + 1));
        let others = chart.series.last().expect("others");
        assert_eq!((others.name.as_str(), others.words.len()), ("5 others", 5));
        let drawn: usize = chart.series[1..].iter().map(|s| s.points.len()).sum();
        assert_eq!(drawn, 2 * count);
        assert!(super::chart(&Value::Null, &UnitNames::default()).is_none());
    }
}
