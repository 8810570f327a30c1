//! Parameter values of a sweep: lists, ranges and distributions per parameter, combined to a grid of cases.

use std::path::Path;

use rand_chacha::rand_core::RngCore as _;
use serde_json::{Number, Value};

use super::StudyError;
use super::statistics::design::{draws, unit};
use super::statistics::distribution::ParameterDistribution;
use super::table::TextTable;
use crate::output::csv;

/// Largest number of cases of one sweep.
const MOST: usize = 10_000_000;

/// Returns the value of a parameter for JSON: a number, or a text that is none.
pub fn json_value(text: &str) -> Value {
    let number = serde_json::from_str(text).ok().or_else(|| Number::from_f64(text.parse().ok()?));
    number.map_or_else(|| Value::from(text), Value::Number)
}

/// Parameters with their values, and the order of the cases.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CaseGrid {
    axes: Vec<(String, Vec<String>)>,
    order: CaseOrder,
}

/// Combination of the values of several parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum CaseOrder {
    /// All combinations; the last parameter varies fastest.
    #[default]
    Product,
    /// Rows of a table of samples.
    Rows,
    /// Random draws; the values are distributions. A draw depends only on the seed and its own index.
    Random { count: usize, seed: u64 },
}

impl CaseGrid {
    /// Parses `NAME=v1,v2,…`, `NAME=start:stop:step` (includes `stop` if a step reaches it) or
    /// `NAME=start:stop:#count`.
    pub fn parse(settings: &[String]) -> Result<CaseGrid, StudyError> {
        CaseGrid::read(settings).map_err(StudyError::Setting)
    }

    /// Reads a CSV text of samples with one column per parameter and one row per run; `settings` give one value to each
    /// other parameter.
    pub fn samples(path: &Path, text: &str, settings: &[String]) -> Result<CaseGrid, StudyError> {
        CaseGrid::table("--samples", path, text)?.with_fixed_parameters(settings, "--samples")
    }

    /// Reads the rows of a CSV file that an option names.
    pub(super) fn table(option: &'static str, path: &Path, text: &str) -> Result<CaseGrid, StudyError> {
        CaseGrid::rows(text).map_err(|message| StudyError::file(option, path, message))
    }

    /// Removes a column of numbers that is no parameter from rows of samples.
    pub fn take_column(&mut self, name: &str) -> Result<Vec<f64>, StudyError> {
        let wrong = |message: String| StudyError::Setting(format!("--compare-column {name}: {message}"));
        let Some(place) = self.axes.iter().position(|axis| axis.0 == name) else {
            return Err(wrong(format!("--samples has no such column; it has {}", self.names().join(", "))));
        };
        if self.axes.len() == 1 {
            return Err(wrong("--samples has no other column, so no parameter varies".into()));
        }
        let number = |(i, text): (usize, &String)| {
            let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| wrong(format!("`{text}` in row {} is not a number", i + 1)))
        };
        let numbers = self.axes[place].1.iter().enumerate().map(number).collect::<Result<_, _>>()?;
        self.axes.remove(place);
        Ok(numbers)
    }

    /// Adds other parameters with one value each from `settings`; `option` names the source of the rows in messages.
    pub(super) fn with_fixed_parameters(mut self, settings: &[String], option: &str) -> Result<CaseGrid, StudyError> {
        let count = self.count();
        for (name, values) in CaseGrid::parse(settings)?.axes {
            if values.len() > 1 {
                let message = format!("--set {name} has {} values; with {option} only one is allowed", values.len());
                return Err(StudyError::Setting(message));
            }
            if self.axes.iter().any(|axis| axis.0 == name) {
                return Err(StudyError::Setting(format!(
                    "parameter {name} is given by --set and by {option}; remove one"
                )));
            }
            self.axes.push((name, vec![values[0].clone(); count]));
        }
        Ok(self)
    }

    fn rows(text: &str) -> Result<CaseGrid, String> {
        let TextTable { header, rows } = records(text, false)?;
        if rows.len() > MOST {
            return Err(format!("more than {MOST} rows"));
        }
        Ok(CaseGrid::of_rows(header, rows))
    }

    /// Creates cases from rows of values.
    pub(super) fn of_rows(names: Vec<String>, rows: Vec<Vec<String>>) -> CaseGrid {
        let mut axes: Vec<(String, Vec<String>)> = names.into_iter().map(|name| (name, Vec::new())).collect();
        for row in rows {
            axes.iter_mut().zip(row).for_each(|(axis, value)| axis.1.push(value));
        }
        CaseGrid { axes, order: CaseOrder::Rows }
    }

    /// Creates `count` random draws from `NAME=DISTRIBUTION`; other parameters have one value each.
    pub fn random(settings: &[String], count: usize, seed: u64) -> Result<CaseGrid, StudyError> {
        let mut grid = CaseGrid { axes: Vec::new(), order: CaseOrder::Random { count, seed } };
        for setting in settings {
            let wrong = |why: String| StudyError::Setting(format!("--set {setting}: {why}"));
            let (name, text) =
                setting.split_once('=').ok_or_else(|| wrong("expected NAME=VALUE or NAME=DISTRIBUTION".into()))?;
            let values = if is_distribution(text) {
                ParameterDistribution::parse(text).map_err(wrong)?;
                vec![text.trim().to_owned()]
            } else {
                let (_, values) = axis(setting).map_err(StudyError::Setting)?;
                if values.len() > 1 {
                    return Err(wrong("with --random a parameter has a distribution or one value".into()));
                }
                values
            };
            grid.add(name.trim().to_owned(), values).map_err(StudyError::Setting)?;
        }
        if !grid.axes.iter().any(|axis| is_distribution(&axis.1[0])) || count == 0 {
            return Err(StudyError::Setting(
                "--random: no parameter has a distribution; use --set NAME=low..high".into(),
            ));
        }
        if count > MOST {
            return Err(StudyError::Setting(format!("--random: more than {MOST} cases are not allowed")));
        }
        Ok(grid)
    }

    /// Parses like [`parse`](Self::parse), but returns errors as texts that name the option `--set`.
    pub(super) fn read(settings: &[String]) -> Result<CaseGrid, String> {
        let mut grid = CaseGrid::default();
        for setting in settings {
            if let Some((_, text)) = setting.split_once('=')
                && SettingForm::of(text) == SettingForm::Distribution
            {
                return Err(format!("--set {setting}: expected values; {}", SettingForm::Distribution.accepted_by()));
            }
            let (name, values) = axis(setting)?;
            grid.add(name, values)?;
        }
        let count = grid.axes.iter().try_fold(1_usize, |n, a| n.checked_mul(a.1.len()));
        match count {
            Some(count) if count <= MOST => Ok(grid),
            _ => Err(format!("the sweep has more than {MOST} combinations; reduce the number of values")),
        }
    }

    fn add(&mut self, name: String, values: Vec<String>) -> Result<(), String> {
        if self.axes.iter().any(|axis| axis.0 == name) {
            return Err(format!("--set {name} is given twice"));
        }
        self.axes.push((name, values));
        Ok(())
    }

    /// Returns the parameter names.
    pub fn names(&self) -> Vec<&str> {
        self.axes.iter().map(|a| a.0.as_str()).collect()
    }

    /// Returns whether the cases are samples and not all combinations of values.
    pub fn is_scattered(&self) -> bool {
        self.order != CaseOrder::Product
    }

    /// Returns the parameters with their values, as given.
    pub fn axes(&self) -> &[(String, Vec<String>)] {
        &self.axes
    }

    /// Returns the number of cases.
    pub fn count(&self) -> usize {
        match self.order {
            CaseOrder::Product => self.axes.iter().map(|a| a.1.len()).product(),
            CaseOrder::Rows => self.axes.first().map_or(0, |a| a.1.len()),
            CaseOrder::Random { count, .. } => count,
        }
    }

    /// Returns the parameter values of the case with that index, from 0.
    pub fn combination(&self, index: usize) -> Vec<(String, String)> {
        if self.order == CaseOrder::Rows {
            return self.axes.iter().map(|(name, values)| (name.clone(), values[index].clone())).collect();
        }
        if let CaseOrder::Random { seed, .. } = self.order {
            let mut draws = draws(seed, index as u64);
            let value = |of: &Vec<String>| match ParameterDistribution::parse(&of[0]) {
                Ok(distribution) => distribution.quantile(unit(draws.next_u64())).to_string(),
                Err(_) => of.concat(),
            };
            let values: Vec<String> = self.axes.iter().map(|axis| &axis.1).map(value).collect();
            return self.axes.iter().map(|axis| axis.0.clone()).zip(values).collect();
        }
        let mut remaining = index;
        let mut pairs: Vec<_> = self
            .axes
            .iter()
            .rev()
            .map(|(name, values)| {
                let value = values[remaining % values.len()].clone();
                remaining /= values.len();
                (name.clone(), value)
            })
            .collect();
        pairs.reverse();
        pairs
    }
}

/// Form of the right side of `NAME=…`, the same for all commands and options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingForm {
    /// One value: a number, an expression or a text.
    Value,
    /// A list `v1,v2` of numbers, or a range `start:stop:step` or `start:stop:#count`.
    Values,
    /// `low..high`, `normal(mean, deviation)` and other distributions.
    Distribution,
}

impl SettingForm {
    /// Returns the form of a text.
    pub fn of(text: &str) -> SettingForm {
        let is_list = || text.contains(',') && text.split(',').all(|value| value.trim().parse::<f64>().is_ok());
        if is_distribution(text) && ParameterDistribution::parse(text).is_ok() {
            SettingForm::Distribution
        } else if text.contains(':') && range(text, text).is_ok() || is_list() {
            SettingForm::Values
        } else {
            SettingForm::Value
        }
    }

    /// Returns which options accept the form, for messages.
    pub fn accepted_by(self) -> &'static str {
        match self {
            SettingForm::Value => "one value is given by `--set`",
            SettingForm::Values => "several values are accepted by `sweep --set`, `study --refine` and `limit --over`",
            SettingForm::Distribution => {
                "a distribution is accepted by `--distribution` of `scatter` and `limit`, and by `sweep --random N --set`"
            }
        }
    }
}

/// Returns whether a text is a distribution and not a value.
fn is_distribution(text: &str) -> bool {
    text.contains("..") || text.contains('(')
}

fn axis(setting: &str) -> Result<(String, Vec<String>), String> {
    let (name, text) = setting.split_once('=').ok_or_else(|| format!("--set {setting}: expected NAME=VALUE"))?;
    let values =
        if text.contains(':') { range(setting, text)? } else { text.split(',').map(|v| v.trim().to_owned()).collect() };
    if name.trim().is_empty() || values.iter().any(String::is_empty) {
        return Err(format!("--set {setting}: a name or a value is missing"));
    }
    Ok((name.trim().to_owned(), values))
}

fn range(setting: &str, text: &str) -> Result<Vec<String>, String> {
    let wrong = || format!("--set {setting}: expected start:stop:step or start:stop:#count, for example 500:1100:50");
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [start, stop, step] = parts[..] else { return Err(wrong()) };
    let number = |t: &str| t.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
    let (start, stop) = (number(start)?, number(stop)?);
    let intervals = match step.strip_prefix('#') {
        Some(count) => count.parse::<usize>().ok().filter(|c| *c > 0).ok_or_else(wrong)? as f64 - 1.0,
        None => (((stop - start) / number(step)?) * (1.0 + 1e-12)).floor(),
    };
    if !(0.0..MOST as f64).contains(&intervals) {
        return Err(format!("--set {setting}: the range has no values or more than {MOST}"));
    }
    let width = if step.starts_with('#') { (stop - start) / intervals.max(1.0) } else { number(step)? };
    Ok((0..=intervals as usize).map(|i| format!("{}", start + i as f64 * width)).collect())
}

/// Parses a CSV table with named columns and at least one row. `gaps` allows empty cells.
pub(super) fn records(text: &str, gaps: bool) -> Result<TextTable, String> {
    let mut lines = csv::lines(text);
    let (_, header) = lines.next().ok_or("the file is empty")?;
    let cells = |line| csv::fields(line).into_iter().map(|cell| cell.trim().to_owned()).collect::<Vec<String>>();
    let names = cells(header);
    for (i, name) in names.iter().enumerate() {
        if name.is_empty() || names[..i].contains(name) {
            return Err(format!("line 1: the name `{name}` of column {} is empty or occurs twice", i + 1));
        }
    }
    let mut rows = Vec::new();
    for (i, line) in lines {
        let values = cells(line);
        if values.len() != names.len() || !gaps && values.iter().any(String::is_empty) {
            return Err(format!("line {i}: {} values, but the header has {}", values.len(), names.len()));
        }
        rows.push(values);
    }
    if rows.is_empty() {
        return Err("the file has no rows below the header".into());
    }
    Ok(TextTable { header: names, rows })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{CaseGrid, SettingForm, json_value};

    #[test]
    fn numbers_are_numbers_in_json() {
        let texts = ["569", "-2.5e-3", ".5", "2.", "1/2", "plane", "inf"];
        let values = [json!(569), json!(-2.5e-3), json!(0.5), json!(2.0), json!("1/2"), json!("plane"), json!("inf")];
        assert_eq!(texts.map(json_value), values);
    }

    #[test]
    fn settings_have_one_of_three_forms() {
        use SettingForm::{Distribution, Value, Values};
        for (text, form) in [
            ("821", Value),
            ("2*V + max(1, 2)", Value),
            ("a,b", Value),
            ("C:/decks", Value),
            ("1,2.5", Values),
            ("500:1100:50", Values),
            ("0:1:#3", Values),
            ("0..1", Distribution),
            ("normal(800, 10)", Distribution),
        ] {
            assert_eq!(SettingForm::of(text), form, "{text}");
        }
        assert!(values("V=0..1").is_err_and(|e| e.contains("sweep --random N")));
    }

    fn values(setting: &str) -> Result<Vec<String>, String> {
        let grid = CaseGrid::read(&[setting.to_owned()])?;
        Ok((0..grid.count()).map(|i| grid.combination(i)[0].1.clone()).collect())
    }

    #[test]
    fn lists_and_ranges_are_parsed() {
        assert_eq!(values("V=569,570"), Ok(vec!["569".into(), "570".into()]));
        assert_eq!(values("V=1:2:0.5"), Ok(vec!["1".into(), "1.5".into(), "2".into()]));
        assert_eq!(values("V=0:1:#3"), Ok(vec!["0".into(), "0.5".into(), "1".into()]));
        for wrong in ["V", "V=", "=1", "V=1:2", "V=2:1:1", "V=0:1:0", "V=0:1e99:1", "V=1,,2"] {
            assert!(values(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn samples_are_combined_with_fixed_parameters() {
        let read = |text: &str, settings: &[String]| CaseGrid::samples("doe.csv".as_ref(), text, settings);
        let grid = read("V, mu\n569, 0.1\n\n# the last\n821,0.2\n", &["n=10".into()]).expect("a grid");
        assert_eq!((grid.count(), grid.names()), (2, vec!["V", "mu", "n"]));
        let pair = |i: usize| grid.combination(i).into_iter().map(|p| p.1).collect::<Vec<_>>().join(" ");
        assert_eq!([pair(0), pair(1)], ["569 0.1 10", "821 0.2 10"]);
        for (text, setting) in
            [("", "n=1"), ("V\n", "n=1"), ("V,V\n1,2\n", "n=1"), ("V,W\n1\n", "n=1"), ("V\n1\n", "n=1,2")]
        {
            assert!(read(text, &[setting.to_owned()]).is_err(), "{text}");
        }
        assert!(read("V\n1\n", &["V=1".into()]).is_err_and(|e| e.to_string().contains("--samples")));
    }

    #[test]
    fn a_draw_depends_on_seed_and_number_alone() {
        let settings = ["V=500..600".to_owned(), "n=20".into(), "mu=0..0.2".into()];
        let grid = |count: usize, seed: u64| CaseGrid::random(&settings, count, seed).expect("a grid");
        let (few, many) = (grid(10, 7), grid(1000, 7));
        assert_eq!((few.count(), few.names()), (10, vec!["V", "n", "mu"]));
        assert!((0..10).all(|i| few.combination(i) == many.combination(i)));
        assert_ne!(few.combination(3), grid(10, 8).combination(3));
        let drawn = |axis: usize| -> Vec<f64> {
            (0..1000).map(|i| many.combination(i)[axis].1.parse().expect("a number")).collect()
        };
        for (axis, low, high) in [(0, 500.0, 600.0), (2, 0.0, 0.2)] {
            let values = drawn(axis);
            assert!(values.iter().all(|v| (low..high).contains(v)));
            // Four standard errors of the mean: exceeded once in 16 000 samples.
            let mean = values.iter().sum::<f64>() / 1000.0;
            assert!((mean - 0.5 * (low + high)).abs() < 4.0 * (high - low) / 12_000_f64.sqrt(), "{mean}");
        }
        assert!(drawn(1).iter().all(|n| *n == 20.0));
        for wrong in [&["V=1,2"][..], &["V=1"], &["V=2..1"], &["V=a..b"], &["V=0..1", "V=0..2"], &[]] {
            let settings: Vec<String> = wrong.iter().map(|s| (*s).to_owned()).collect();
            assert!(CaseGrid::random(&settings, 5, 1).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn the_last_parameter_varies_fastest() {
        let grid = CaseGrid::parse(&["a=1,2".into(), "b=3,4,5".into()]).expect("a grid");
        assert_eq!(grid.count(), 6);
        let pair = |i: usize| grid.combination(i).into_iter().map(|p| p.1).collect::<Vec<_>>().join("");
        assert_eq!((0..6).map(pair).collect::<Vec<_>>().join(" "), "13 14 15 23 24 25");
    }
}
