//! A study's file (`<job>_study.json`): every list of records becomes a table, single values become facts, and error
//! over time a chart.
//! Never here: the study itself (`study`).

use serde_json::{Map, Value};

use super::data::{Chart, Effect, Series, Study, Table};
use crate::study::chart::Form;

/// Rows that are shown.
const ROWS: usize = 500;

/// Lines of the plot of orders.
const LINES: usize = 8;

/// Names that the list of settings may have.
const LISTS: [&str; 3] = ["runs", "levels", "combinations"];

/// Reads a study.
pub fn read(name: &str, file: &Value) -> Study {
    let mut study = Study { table: Table { name: name.to_owned(), ..Table::default() }, ..Study::default() };
    let Some(file) = file.as_object() else { return study };
    for (key, value) in file {
        facts(key, value, &mut study.table.facts);
    }
    study.table.facts.extend(prices(file));
    let left_out = || file.get("ablation")?.get("effects")?.as_array();
    let list = LISTS.iter().find_map(|key| file.get(*key)?.as_array()).or_else(left_out);
    let list: Vec<Map<String, Value>> = list.into_iter().flatten().filter_map(Value::as_object).cloned().collect();
    let front: Vec<u64> =
        file.get("front").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_u64).collect();
    let best = |(i, record): (usize, &Map<String, Value>)| {
        front.contains(&(i as u64)) || record.get("pareto").and_then(Value::as_bool) == Some(true)
    };
    let best: Vec<bool> = list.iter().enumerate().map(best).collect();
    fill_table(&list, &mut study.table);
    study.table.charts.extend(price(&list, &best));
    study.table.charts.extend(orders(file));
    study.effects = effects(file);
    study.pareto = best.into_iter().take(ROWS).collect();
    study
}

/// What an accuracy costs, as the study says it.
fn prices(file: &Map<String, Value>) -> Vec<(String, String)> {
    let price = |p: &Value| {
        let (tolerance, seconds) = (p.get("tolerance")?.as_f64()?, p.get("seconds")?.as_f64()?);
        Some((format!("error below {tolerance:e}"), format!("{} s", super::shorten(seconds))))
    };
    file.get("prices").and_then(Value::as_array).into_iter().flatten().filter_map(price).collect()
}

/// Single values, and those of a record one level down.
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

/// A record's values by column; of a spread the median counts, other records within it bring their own columns. The order
/// observed stands in the first estimate.
fn flat(record: &Map<String, Value>) -> Vec<(String, Value)> {
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

fn fill_table(list: &[Map<String, Value>], table: &mut Table) {
    for record in list {
        for (key, value) in flat(record) {
            if key != "pareto" && !value.is_null() && !table.header.contains(&key) {
                table.header.push(key);
            }
        }
    }
    if list.len() > ROWS {
        table.notes.push(format!("{ROWS} of {} rows are shown", list.len()));
    }
    for record in list.iter().take(ROWS) {
        let values = flat(record);
        let of = |key: &String| values.iter().find(|v| v.0 == *key).map_or(String::new(), |v| cell(&v.1));
        table.rows.push(table.header.iter().map(of).collect());
    }
}

fn cell(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => {
            number.as_f64().map_or(String::new(), |v| super::shorten(v).to_string())
        }
        Value::Null => String::new(),
        value => value.to_string(),
    }
}

/// Error against seconds on logarithmic axes; what nothing beats is joined. Where a bound of the error is told, it counts.
fn price(list: &[Map<String, Value>], best: &[bool]) -> Option<Chart> {
    let mut all = Series { name: "all settings".into(), form: Form::Marks, ..Series::default() };
    let mut front: Vec<(f64, f64)> = Vec::new();
    for (record, best) in list.iter().zip(best) {
        let columns = flat(record);
        let number = |keys: &[&str]| {
            let of = |key: &&str| columns.iter().find(|c| c.0 == *key)?.1.as_f64().map(f64::abs);
            keys.iter().find_map(of).filter(|v| *v > 0.0)
        };
        let (Some(x), Some(y)) = (number(&["seconds"]), number(&["bound", "error"])) else { continue };
        all.x.push(x);
        all.y.push(y);
        let words = columns.iter().filter(|c| c.0 != "pareto" && !c.1.is_null());
        all.words.push(words.take(6).map(|(k, v)| format!("{k} {}", cell(v))).collect::<Vec<_>>().join(", "));
        if *best {
            front.push((x, y));
        }
    }
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (x, y) = front.into_iter().unzip();
    let best = Series { name: "best for its price".into(), form: Form::Line, x, y, words: Vec::new() };
    let series: Vec<Series> = [all, best].into_iter().filter(|s| !s.x.is_empty()).collect();
    (!series.is_empty()).then(|| Chart {
        title: "Error against time".into(),
        x_label: "seconds".into(),
        y_label: "error".into(),
        logarithmic: true,
        series,
        ..Chart::default()
    })
}

/// Error over size on logarithmic axes, one line for each refinement, with the slopes of the orders through the finest point of
/// the first.
fn orders(file: &Map<String, Value>) -> Option<Chart> {
    let runs = file.get("runs")?.as_array()?;
    let error = |run: &Value| {
        let run = runs.get(usize::try_from(run.as_u64()?).ok()?)?;
        run.get("error")?.as_f64().map(f64::abs).filter(|error| *error > 0.0)
    };
    let line = |refined: &Value| {
        let (runs, sizes) = (refined.get("runs")?.as_array()?, refined.get("sizes")?.as_array()?);
        let point = |(run, size): (&Value, &Value)| Some((size.as_f64()?, error(run)?));
        let (x, y): (Vec<f64>, Vec<f64>) = runs.iter().zip(sizes).filter_map(point).unzip();
        let words = ["along", "at"].iter().filter_map(|key| refined.get(*key)?.as_str()).filter(|w| !w.is_empty());
        let order = refined.get("order").and_then(Value::as_f64).map(|order| format!("order {order:.2}"));
        let name = words.map(str::to_owned).chain(order).collect::<Vec<_>>().join(", ");
        (x.len() > 1).then(|| Series { name, x, y, ..Series::default() })
    };
    let lines: Vec<(Series, &Value)> = file
        .get("refinements")?
        .as_array()?
        .iter()
        .filter_map(|refined| Some((line(refined)?, refined)))
        .take(LINES)
        .collect();
    let guides = lines.first().map_or(Vec::new(), |(line, refined)| slopes(line, refined));
    let series: Vec<Series> = lines.into_iter().map(|l| l.0).chain(guides).collect();
    (!series.is_empty()).then(|| Chart {
        title: "Error over size".into(),
        x_label: "size over the finest".into(),
        y_label: "error".into(),
        logarithmic: true,
        series,
        ..Chart::default()
    })
}

/// Straight lines of the observed and of the formal order.
fn slopes(line: &Series, refined: &Value) -> Vec<Series> {
    let (coarsest, finest) = (line.x[0], line.x[line.x.len() - 1]);
    let error = line.y[line.y.len() - 1];
    let slope = |(key, word): (&str, &str)| {
        let order = refined.get(key)?.as_f64()?;
        let end = super::shorten(error * libm::pow(coarsest / finest, order));
        let name = format!("slope of the {word} order {}", (100.0 * order).round() / 100.0);
        Some(Series { name, form: Form::Guide, x: vec![coarsest, finest], y: vec![end, error], words: Vec::new() })
    };
    [("order", "observed"), ("formal_order", "formal")].into_iter().filter_map(slope).collect()
}

/// Effects left out, those that save most first.
fn effects(file: &Map<String, Value>) -> Vec<Effect> {
    let list = file.get("ablation").and_then(|a| a.get("effects")?.as_array());
    let effect = |record: &Value| {
        let number = |key: &str| record.get(key).and_then(Value::as_f64);
        Some(Effect {
            name: record.get("effect")?.as_str()?.to_owned(),
            error: number("relative_change").map(f64::abs),
            saved: number("time_ratio").map(|ratio| 1.0 - ratio),
            matters: record.get("matters").and_then(Value::as_bool).unwrap_or(false),
        })
    };
    let mut effects: Vec<Effect> = list.into_iter().flatten().filter_map(effect).collect();
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
        assert_eq!(chart.series.iter().map(|s| s.y[0]).collect::<Vec<_>>(), [0.16, 0.08, 0.16]);
        let file = serde_json::json!({"ablation": {"effects": [
            {"effect": "friction", "relative_change": -0.1, "time_ratio": 0.9, "matters": true},
            {"effect": "wall", "time_ratio": 0.5, "matters": true},
        ]}});
        let effects = read("job", &file).effects;
        assert_eq!((effects[0].name.as_str(), effects[0].error, effects[0].saved), ("wall", None, Some(0.5)));
        assert_eq!((effects[1].error, effects[1].matters), (Some(0.1), true));
    }

    #[test]
    fn the_price_list_and_its_front_are_found_by_their_keys() {
        let file = serde_json::json!({
            "quantity": "final(U2@REF)", "order": {"observed": 2.01},
            "levels": [
                {"values": {"n": 10}, "value": 1.1, "error": 0.1, "seconds": 0.5, "pareto": true},
                {"values": {"n": 20}, "value": 1.02, "error": 0.02, "seconds": 1.0, "pareto": true},
                {"values": {"n": 30}, "value": 1.03, "error": 0.03, "seconds": 2.0, "pareto": false},
            ],
        });
        let study = read("job", &file);
        assert_eq!(study.table.header, ["n", "value", "error", "seconds"]);
        assert_eq!(study.table.rows[1], ["20", "1.02", "0.02", "1"]);
        assert_eq!(study.pareto, [true, true, false]);
        assert_eq!(study.table.charts[0].series[0].x.len(), 3);
        assert_eq!(study.table.charts[0].series[1].y, [0.1, 0.02]);
        let file = serde_json::json!({
            "runs": [{"setting": {"n": "10"}, "value": 1.0, "bound": 0.2, "seconds": {"median": 0.5, "min": 0.4, "max": 0.6},
                "estimates": [{"order": 1.98}]}],
            "front": [0], "prices": [{"tolerance": 0.2, "run": 0, "seconds": 0.5}],
        });
        let other = read("job", &file);
        assert_eq!(other.table.header, ["n", "value", "bound", "seconds", "order"]);
        assert_eq!((&other.table.charts[0].series[1].x, &other.pareto), (&vec![0.5], &vec![true]));
        assert_eq!(other.table.facts, [("error below 2e-1".to_owned(), "0.5 s".to_owned())]);
        let file =
            serde_json::json!({"ablation": {"value": 64.8, "effects": [{"effect": "entry phase", "change": -5.2}]}});
        let left_out = read("job", &file);
        assert_eq!(left_out.table.rows, [["entry phase", "-5.2"]]);
        assert_eq!(left_out.table.facts, [("ablation, value".to_owned(), "64.8".to_owned())]);
        assert!(study.table.facts.contains(&("order, observed".into(), "2.01".into())));
    }
}
