//! A study's file (`<job>_study.json`): every list of records becomes a table, single values become facts, and error
//! over time a chart.
//! Never here: the study itself (`study`).

use serde_json::{Map, Value};

use super::data::{Chart, Series, Study, Table};

/// Rows that are shown.
const ROWS: usize = 500;

/// Reads a study.
pub fn read(name: &str, file: &Value) -> Study {
    let mut study = Study { table: Table { name: name.to_owned(), ..Table::default() }, ..Study::default() };
    let Some(file) = file.as_object() else { return study };
    for (key, value) in file {
        facts(key, value, &mut study.facts);
    }
    let records = |v: &Value| v.as_array().map(|a| a.iter().filter_map(Value::as_object).cloned().collect::<Vec<_>>());
    let lists = file.values().filter_map(records);
    let Some(list) = lists.max_by_key(Vec::len).filter(|l| !l.is_empty()) else { return study };
    fill_table(&list, &mut study.table);
    study.pareto = list.iter().take(ROWS).map(|r| r.get("pareto").and_then(Value::as_bool).unwrap_or(false)).collect();
    study.table.charts.extend(price(&list));
    study
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

/// A record's values by column; records within it bring their own columns.
fn flat(record: &Map<String, Value>) -> Vec<(String, Value)> {
    let mut columns = Vec::new();
    for (key, value) in record {
        match value {
            Value::Object(inner) => columns.extend(inner.iter().map(|(k, v)| (k.clone(), v.clone()))),
            Value::Array(_) => {}
            value => columns.push((key.clone(), value.clone())),
        }
    }
    columns
}

fn fill_table(list: &[Map<String, Value>], table: &mut Table) {
    for record in list {
        for (key, _) in flat(record) {
            if key != "pareto" && !table.header.contains(&key) {
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

/// Error against seconds on logarithmic axes; what nothing beats is joined.
fn price(list: &[Map<String, Value>]) -> Option<Chart> {
    let number = |r: &Map<String, Value>, keys: &[&str]| keys.iter().find_map(|k| r.get(*k)?.as_f64()).map(f64::abs);
    let mut all = Series { name: "combinations".into(), ..Series::default() };
    let mut front: Vec<(f64, f64)> = Vec::new();
    for record in list {
        let (Some(x), Some(y)) =
            (number(record, &["seconds", "cost", "time"]), number(record, &["error", "relative_error"]))
        else {
            continue;
        };
        if x > 0.0 && y > 0.0 {
            all.x.push(x);
            all.y.push(y);
            let words = flat(record).into_iter().filter(|c| c.0 != "pareto");
            all.words.push(words.map(|(k, v)| format!("{k} {}", cell(&v))).collect::<Vec<_>>().join(", "));
            if record.get("pareto").and_then(Value::as_bool) == Some(true) {
                front.push((x, y));
            }
        }
    }
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (x, y) = front.into_iter().unzip();
    let best = Series { name: "best for its price".into(), joined: true, x, y, words: Vec::new() };
    let series: Vec<Series> = [all, best].into_iter().filter(|s| !s.x.is_empty()).collect();
    (!series.is_empty()).then(|| Chart {
        title: "Error against time".into(),
        x_label: "seconds".into(),
        y_label: "error".into(),
        logarithmic: true,
        series,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(study.facts.contains(&("order, observed".into(), "2.01".into())));
    }
}
