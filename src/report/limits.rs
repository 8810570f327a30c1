//! What limited the increments over time, from a summary.
//! Never here: how that is kept (`solve::limits`).

use serde_json::Value;

use super::data::{Chart, Series};
use super::shorten;
use super::units::Names;
use crate::study::chart::Form;

/// Title of the chart.
pub const TITLE: &str = "Increment";
/// Names that have a series of their own; the others share one.
const NAMES: usize = 7;

/// A span: time, shortest increment, what limited it.
type Span = (f64, f64, String);

/// The chart of what a summary tells of each step; `None` where a summary tells nothing.
pub fn chart(limits: &Value, units: &Names) -> Option<Chart> {
    let spans: Vec<Span> = limits.as_array()?.iter().flat_map(spans).collect();
    if spans.len() < 2 {
        return None;
    }
    let mut names: Vec<(&str, usize)> = Vec::new();
    for (_, _, name) in &spans {
        match names.iter_mut().find(|n| n.0 == name) {
            Some(known) => known.1 += 1,
            None => names.push((name, 1)),
        }
    }
    names.sort_by_key(|n| std::cmp::Reverse(n.1));
    let own: Vec<&str> =
        names.iter().take(if names.len() > NAMES + 1 { NAMES } else { NAMES + 1 }).map(|n| n.0).collect();
    let mut series = vec![points("shortest of each span", Form::Guide, spans.iter())];
    series.extend(own.iter().map(|name| points(name, Form::Marks, spans.iter().filter(|s| s.2 == *name))));
    if own.len() < names.len() {
        let others = format!("{} others", names.len() - own.len());
        series.push(points(&others, Form::Marks, spans.iter().filter(|s| !own.contains(&s.2.as_str()))));
    }
    Some(Chart {
        title: TITLE.into(),
        x_label: "time".into(),
        y_label: "increment".into(),
        units: units.over_time(TITLE),
        words: "and what limited it".into(),
        series,
        ..Chart::default()
    })
}

fn points<'a>(name: &str, form: Form, spans: impl Iterator<Item = &'a Span>) -> Series {
    let mut series = Series { name: name.to_owned(), form, ..Series::default() };
    for (time, increment, by) in spans {
        series.x.push(shorten(*time));
        series.y.push(shorten(*increment));
        if form == Form::Marks && by != name {
            series.words.push(by.clone());
        }
    }
    series
}

fn spans(step: &Value) -> Vec<Span> {
    let list = |key: &str| step.get(key)?.as_array();
    let (Some(times), Some(increments), Some(by)) = (list("time"), list("increment"), list("by")) else {
        return Vec::new();
    };
    let span = |((time, increment), by): ((&Value, &Value), &Value)| {
        let name = list("names")?.get(usize::try_from(by.as_u64()?).ok()?)?.as_str()?;
        Some((time.as_f64()?, increment.as_f64()?, name.to_owned()))
    };
    times.iter().zip(increments).zip(by).filter_map(span).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crowd_of_names_shares_a_series() {
        let count = 12;
        let names: Vec<String> = (0..count).map(|i| format!("element {i}")).collect();
        let time: Vec<usize> = (0..2 * count).collect();
        let by: Vec<usize> = (0..2 * count).map(|i| if i < count { i } else { 0 }).collect();
        let increment = vec![1e-7; 2 * count];
        let steps = serde_json::json!([{"time": time, "increment": increment, "by": by, "names": names}]);
        let chart = chart(&steps, &Names::default()).expect("a chart");
        assert_eq!(chart.series.len(), 1 + NAMES + 1);
        assert_eq!((chart.series[1].name.as_str(), chart.series[1].x.len()), ("element 0", count + 1));
        let others = chart.series.last().expect("others");
        assert_eq!((others.name.as_str(), others.words.len()), ("5 others", 5));
        let drawn: usize = chart.series[1..].iter().map(|s| s.x.len()).sum();
        assert_eq!(drawn, 2 * count);
        assert!(super::chart(&Value::Null, &Names::default()).is_none());
    }
}
