//! Reads `<job>_study.json`: the runs or effects as a table, single values as facts, and charts of the error.

use serde_json::{Map, Value};

use super::data::{EffectSavings, ReportStudy, ReportTable};
use super::shorten;
use crate::study::chart::{AxisScale, Chart, ChartSeries, SeriesForm};

const ROWS: usize = 500;
/// Largest number of lines of the chart of orders.
const LINES: usize = 8;

/// JSON object of the file.
type JsonObject = Map<String, Value>;

pub fn read(name: &str, file: &Value) -> ReportStudy {
    let mut table = ReportTable { name: name.to_owned(), ..ReportTable::default() };
    let Some(file) = file.as_object() else { return ReportStudy { table, ..ReportStudy::default() } };
    for (key, value) in file {
        facts(key, value, &mut table.facts);
    }
    table.facts.extend(list(file, "prices").iter().filter_map(price));
    let effects = file.get("ablation").and_then(Value::as_object).map_or(&[][..], |record| list(record, "effects"));
    let runs = if file.contains_key("runs") { list(file, "runs") } else { effects };
    let runs: Vec<&JsonObject> = runs.iter().filter_map(Value::as_object).collect();
    let front = list(file, "front");
    let best: Vec<bool> = (0..runs.len()).map(|i| front.iter().any(|row| row.as_u64() == Some(i as u64))).collect();
    fill_table(&runs, &mut table);
    table.charts.extend(price_chart(&runs, &best));
    table.charts.extend(order_chart(file));
    ReportStudy { table, pareto: best.into_iter().take(ROWS).collect(), effects: effects_by_savings(effects) }
}

/// Returns the list of that name; empty if there is none.
fn list<'a>(record: &'a JsonObject, key: &str) -> &'a [Value] {
    record.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// Returns the run time for an accuracy as text.
fn price(price: &Value) -> Option<(String, String)> {
    let (tolerance, seconds) = (price.get("tolerance")?.as_f64()?, price.get("seconds")?.as_f64()?);
    Some((format!("error below {tolerance:e}"), format!("{} s", shorten(seconds))))
}

/// Collects single values, and the values of objects one level deeper.
fn facts(key: &str, value: &Value, into: &mut Vec<(String, String)>) {
    match value {
        Value::Object(record) => {
            for (name, value) in record.iter().filter(|(_, v)| !v.is_object() && !v.is_array()) {
                into.push((format!("{key}, {name}").replace('_', " "), cell(value)));
            }
        }
        Value::Array(_) | Value::Null => {}
        value => into.push((key.replace('_', " "), cell(value))),
    }
}

/// Flattens a record into columns: medians of run times, the order of the first estimate, and the values of inner
/// records.
fn flat(record: &JsonObject) -> Vec<(String, Value)> {
    let mut columns = Vec::new();
    for (key, value) in record {
        match value {
            Value::Object(inner) if inner.contains_key("median") => {
                columns.push((key.clone(), inner["median"].clone()))
            }
            Value::Array(inner) if key == "estimates" => {
                let order = inner.first().and_then(|e| e.get("order")).cloned();
                columns.push(("order".into(), order.unwrap_or_default()));
            }
            Value::Object(inner) => columns.extend(inner.iter().map(|(k, v)| (k.clone(), v.clone()))),
            Value::Array(_) => {}
            value => columns.push((key.clone(), value.clone())),
        }
    }
    columns
}

fn fill_table(runs: &[&JsonObject], table: &mut ReportTable) {
    for (key, value) in runs.iter().flat_map(|run| flat(run)) {
        if !value.is_null() && !table.header.contains(&key) {
            table.header.push(key);
        }
    }
    if runs.len() > ROWS {
        table.notes.push(format!("{ROWS} of {} rows are shown", runs.len()));
    }
    for run in runs.iter().take(ROWS) {
        let values = flat(run);
        let cell_of = |key: &String| values.iter().find(|v| v.0 == *key).map_or(String::new(), |v| cell(&v.1));
        table.rows.push(table.header.iter().map(cell_of).collect());
    }
}

fn cell(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => number.as_f64().map_or(String::new(), |v| shorten(v).to_string()),
        Value::Null => String::new(),
        value => value.to_string(),
    }
}

/// Returns the chart of error, or its bound if there is one, against run time; the Pareto front is a line.
fn price_chart(runs: &[&JsonObject], best: &[bool]) -> Option<Chart> {
    let mut settings = ChartSeries::new("all settings", SeriesForm::Marks, Vec::new());
    let mut front: Vec<(f64, f64)> = Vec::new();
    for (run, best) in runs.iter().zip(best) {
        let columns = flat(run);
        let number = |keys: &[&str]| {
            let magnitude_of = |key: &&str| columns.iter().find(|c| c.0 == *key)?.1.as_f64().map(f64::abs);
            keys.iter().find_map(magnitude_of).filter(|v| *v > 0.0)
        };
        let (Some(x), Some(y)) = (number(&["seconds"]), number(&["bound", "error"])) else { continue };
        settings.points.push((x, y));
        let words = columns.iter().filter(|c| !c.1.is_null());
        settings.words.push(words.take(6).map(|(k, v)| format!("{k} {}", cell(v))).collect::<Vec<_>>().join(", "));
        if *best {
            front.push((x, y));
        }
    }
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let series = vec![settings, ChartSeries::new("Pareto front", SeriesForm::Line, front)];
    logarithmic(Chart::new("Error against time", ["seconds", "error"], series))
}

/// Returns the chart of error over size: one line per series of refinement, and lines of the observed and formal order
/// through the finest point of the first.
fn order_chart(file: &JsonObject) -> Option<Chart> {
    let runs = list(file, "runs");
    let error = |run: &Value| {
        let run = runs.get(usize::try_from(run.as_u64()?).ok()?)?;
        run.get("error")?.as_f64().map(f64::abs).filter(|error| *error > 0.0)
    };
    let line = |refined: &Value| {
        let refined = refined.as_object()?;
        let point = |(run, size): (&Value, &Value)| Some((size.as_f64()?, error(run)?));
        let points: Vec<_> = list(refined, "runs").iter().zip(list(refined, "sizes")).filter_map(point).collect();
        let words = ["along", "at"].iter().filter_map(|key| refined.get(*key)?.as_str()).filter(|w| !w.is_empty());
        let order = refined.get("order").and_then(Value::as_f64).map(|order| format!("order {order:.2}"));
        let name = words.map(str::to_owned).chain(order).collect::<Vec<_>>().join(", ");
        (points.len() > 1).then(|| ChartSeries::new(name, SeriesForm::Line, points))
    };
    let refinements = list(file, "refinements").iter();
    let lines: Vec<(ChartSeries, &Value)> = refinements.filter_map(|r| Some((line(r)?, r))).take(LINES).collect();
    let guides = lines.first().map_or(Vec::new(), |(line, refined)| slopes(line, refined));
    let series = lines.into_iter().map(|l| l.0).chain(guides).collect();
    logarithmic(Chart::new("Error over size", ["size relative to the finest", "error"], series))
}

/// Sets logarithmic axes and removes empty series; `None` if no series is left.
fn logarithmic(mut chart: Chart) -> Option<Chart> {
    chart.series.retain(|series| !series.points.is_empty());
    (!chart.series.is_empty()).then_some(Chart { scale: AxisScale::LogLog, ..chart })
}

/// Returns lines with the slopes of the observed and the formal order.
fn slopes(line: &ChartSeries, refined: &Value) -> Vec<ChartSeries> {
    let ((coarsest, _), (finest, error)) = (line.points[0], line.points[line.points.len() - 1]);
    let slope = |(key, word): (&str, &str)| {
        let order = refined.get(key)?.as_f64()?;
        let end = shorten(error * libm::pow(coarsest / finest, order));
        let name = format!("slope of the {word} order {}", (100.0 * order).round() / 100.0);
        Some(ChartSeries::new(name, SeriesForm::Guide, vec![(coarsest, end), (finest, error)]))
    };
    [("order", "observed"), ("formal_order", "formal")].into_iter().filter_map(slope).collect()
}

/// Returns the removed effects, those that save most run time first.
fn effects_by_savings(list: &[Value]) -> Vec<EffectSavings> {
    let effect = |record: &Value| {
        let number = |key: &str| record.get(key).and_then(Value::as_f64);
        Some(EffectSavings {
            name: record.get("effect")?.as_str()?.to_owned(),
            error: number("relative_change").map(f64::abs),
            saved: number("time_ratio").map(|ratio| 1.0 - ratio),
            matters: record.get("matters").and_then(Value::as_bool).unwrap_or(false),
        })
    };
    let mut effects: Vec<EffectSavings> = list.iter().filter_map(effect).collect();
    effects.sort_by(|a, b| b.saved.unwrap_or(f64::NEG_INFINITY).total_cmp(&a.saved.unwrap_or(f64::NEG_INFINITY)));
    effects
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_and_effects_are_drawn() {
        let file = serde_json::json!({
            "runs": [{"error": 0.16}, {"error": -0.04}, {"error": 0.01}],
            "refinements": [{"along": "n", "at": "", "runs": [0, 1, 2], "sizes": [4.0, 2.0, 1.0], "order": 1.5, "formal_order": 2.0}],
        });
        let chart = &read("job", &file).table.charts[0];
        let names: Vec<&str> = chart.series.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["n, order 1.50", "slope of the observed order 1.5", "slope of the formal order 2"]);
        assert_eq!(chart.series.iter().map(|s| s.points[0].1).collect::<Vec<_>>(), [0.16, 0.08, 0.16]);
        let file = serde_json::json!({"ablation": {"effects": [
            {"effect": "friction", "relative_change": -0.1, "time_ratio": 0.9, "matters": true},
            {"effect": "wall", "time_ratio": 0.5, "matters": true},
        ]}});
        let effects = read("job", &file).effects;
        assert_eq!((effects[0].name.as_str(), effects[0].error, effects[0].saved), ("wall", None, Some(0.5)));
        assert_eq!((effects[1].error, effects[1].matters), (Some(0.1), true));
    }

    #[test]
    fn prices_and_pareto_front_are_read_from_their_keys() {
        let run = |n: &str, error: f64, seconds: f64| {
            let seconds = serde_json::json!({"median": seconds, "min": 0.4, "max": 9.0});
            serde_json::json!({"setting": {"n": n}, "value": 1.0 + error, "bound": error, "seconds": seconds,
                "estimates": [{"order": 1.98}]})
        };
        let file = serde_json::json!({
            "quantity": "final(U2@REF)", "order": {"observed": 2.01},
            "runs": [run("10", 0.1, 0.5), run("20", 0.02, 1.0), run("30", 0.03, 2.0)],
            "front": [0, 1], "prices": [{"tolerance": 0.2, "run": 0, "seconds": 0.5}],
        });
        let study = read("job", &file);
        assert_eq!(study.table.header, ["n", "value", "bound", "seconds", "order"]);
        assert_eq!(study.table.rows[1], ["20", "1.02", "0.02", "1", "1.98"]);
        assert_eq!(study.pareto, [true, true, false]);
        let [all, front] = &study.table.charts[0].series[..] else { panic!("two series") };
        assert_eq!((all.points.len(), &front.points), (3, &vec![(0.5, 0.1), (1.0, 0.02)]));
        assert!(study.table.facts.contains(&("error below 2e-1".into(), "0.5 s".into())));
        assert!(study.table.facts.contains(&("order, observed".into(), "2.01".into())));
        let file =
            serde_json::json!({"ablation": {"value": 64.8, "effects": [{"effect": "entry phase", "change": -5.2}]}});
        let left_out = read("job", &file);
        assert_eq!(left_out.table.rows, [["entry phase", "-5.2"]]);
        assert_eq!(left_out.table.facts, [("ablation, value".to_owned(), "64.8".to_owned())]);
    }
}
