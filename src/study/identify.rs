//! `identify`: parameters of a deck that best fit a table of shots, how well the shots tell them, and which they cannot tell apart.

use std::path::Path;

use super::StudyError;
use super::chart::{Chart, Form, Series};
use super::evaluate::Evaluator;
use super::grid::Grid;
use super::statistics::least_squares::{Fit, fit};

/// Two parameters that go together more closely than this are told.
const CLOSE: f64 = 0.95;
/// Relative step of the derivatives; smaller ones would resolve single increments.
const STEP: f64 = 1e-2;

/// A table of shots.
#[derive(Clone, Debug, PartialEq)]
pub struct Shots {
    /// Parameters that were set.
    pub names: Vec<String>,
    /// One value a parameter, a row a shot.
    pub rows: Vec<Vec<f64>>,
    /// What was measured.
    pub measured: Vec<f64>,
    /// Standard deviation of each measurement, or 1.
    pub deviations: Vec<f64>,
}

impl Shots {
    /// Reads a CSV file: a column of measurements, perhaps one of their standard deviations, and parameters.
    pub fn parse(path: &Path, text: &str, measured: &str, deviation: Option<&str>) -> Result<Shots, StudyError> {
        let wrong = |message: String| StudyError::file("--shots", path, message);
        let table = Grid::table("--shots", path, text)?;
        let mut columns = Vec::new();
        for (name, values) in table.axes() {
            let number = |(i, v): (usize, &String)| {
                let number = v.parse::<f64>().ok().filter(|v| v.is_finite());
                number.ok_or_else(|| wrong(format!("shot {}, column {name}: `{v}` is not a number", i + 1)))
            };
            columns.push((name.clone(), values.iter().enumerate().map(number).collect::<Result<Vec<f64>, _>>()?));
        }
        let mut take = |name: &str| {
            let place = columns.iter().position(|column| column.0 == name);
            let known: Vec<&str> = columns.iter().map(|column| column.0.as_str()).collect();
            let absent = || wrong(format!("no column is named {name}; there are {}", known.join(", ")));
            place.ok_or_else(absent).map(|place| columns.remove(place).1)
        };
        let measured = take(measured)?;
        let deviations = deviation.map(&mut take).transpose()?.unwrap_or_else(|| vec![1.0; measured.len()]);
        if let Some(at) = deviations.iter().position(|d| *d <= 0.0) {
            return Err(wrong(format!("shot {}: a standard deviation must be above zero", at + 1)));
        }
        let rows = (0..measured.len()).map(|i| columns.iter().map(|column| column.1[i]).collect()).collect();
        Ok(Shots { names: columns.into_iter().map(|column| column.0).collect(), rows, measured, deviations })
    }

    /// The same shots, parameters, and measurements and computed values.
    fn points(&self, values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> = self
            .rows
            .iter()
            .enumerate()
            .map(|(i, row)| row.first().copied().unwrap_or(i as f64 + 1.0))
            .zip(values)
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    }

    /// Measurements, and what is computed with the fitted parameters, over the first parameter.
    pub fn chart(&self, title: &str, measured: &str, quantity: &str, found: &Fit) -> Chart {
        let computed: Vec<f64> =
            (0..self.rows.len()).map(|i| self.measured[i] + found.residuals[i] * self.deviations[i]).collect();
        let form = if self.names.len() == 1 { Form::Line } else { Form::Marks };
        let series = vec![
            Series::new(measured, Form::Marks, self.points(self.measured.iter().copied())),
            Series::new(format!("{quantity}, fitted"), form, self.points(computed.into_iter())),
        ];
        Chart::new(title, [self.names.first().map_or("shot", String::as_str), measured], series)
    }
}

/// Fits from `start` on; the evaluator has the parameters of the shots, then the unknown ones, and one quantity.
pub fn identify(evaluator: &Evaluator, shots: &Shots, start: &[f64], threads: usize) -> Result<Fit, StudyError> {
    let mut first = None;
    let model = &mut |points: &[Vec<f64>]| -> Result<Vec<Vec<f64>>, StudyError> {
        let samples: Vec<f64> = points
            .iter()
            .flat_map(|point| shots.rows.iter().flat_map(move |row| row.iter().chain(point)))
            .copied()
            .collect();
        let (table, failures) = evaluator.table(&samples, threads)?;
        first = first.take().or_else(|| failures.into_iter().next());
        let weigh = |values: &[f64]| {
            let known = shots.measured.iter().zip(&shots.deviations);
            values.iter().zip(known).map(|(value, (measured, deviation))| (value - measured) / deviation).collect()
        };
        Ok(table.chunks(shots.rows.len().max(1)).map(weigh).collect())
    };
    if shots.rows.len() <= start.len() {
        let (shots, unknown) = (shots.rows.len(), start.len());
        let why =
            format!("{shots} shots cannot tell {unknown} parameters and their errors; one more is needed at least");
        return Err(StudyError::Comparison(why));
    }
    let found = fit(start, STEP, model)?;
    found.ok_or_else(|| match first {
        Some(failure) => failure.reason,
        None => StudyError::Comparison("the deck has no value with the parameters of the start".into()),
    })
}

/// What is to be known of a fit, in sentences.
pub fn sentences(found: &Fit, names: &[String]) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    if !found.settled {
        said.push("the search was given up before the sum of squares was least: start nearer".into());
    }
    said.extend(found.idle.iter().map(|i| format!("no shot depends on {}: it cannot be told", names[*i])));
    let edge =
        |i: &usize| format!("{} came to the edge of what the deck takes: its interval reaches beyond", names[*i]);
    said.extend(found.edges.iter().map(edge));
    for one in 0..names.len() {
        for other in one + 1..names.len() {
            match found.correlation(one, other) {
                Some(r) if r.abs() > CLOSE => {
                    let (how, what) = if r > 0.0 {
                        ("both higher or both lower", "difference")
                    } else {
                        ("one higher and the other lower", "sum")
                    };
                    said.push(format!(
                        "these shots hardly tell {} and {} apart (correlation {r:.3}): {how} fit nearly as well; they tell a weighted \
                         {what} of both",
                        names[one], names[other]
                    ));
                }
                _ => {}
            }
        }
    }
    if found.covariance.is_none() && found.idle.is_empty() {
        said.push(format!(
            "these shots cannot tell {} apart at all: some change of them together leaves every shot as it is",
            names.join(" and ")
        ));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::{Shots, sentences};
    use crate::study::statistics::least_squares::Fit;

    #[test]
    fn tables_are_taken_apart() {
        let parse = |text: &str, deviation| Shots::parse("a.csv".as_ref(), text, "P", deviation);
        let shots = parse("V,P,s,m\n1,2,0.5,3\n4,5,1,6\n", Some("s")).expect("shots");
        assert_eq!(shots.names, ["V", "m"]);
        assert_eq!((&shots.rows[1][..], shots.measured[1], shots.deviations[0]), (&[4.0, 6.0][..], 5.0, 0.5));
        for (text, deviation) in [
            ("V,Q\n1,2\n", None),
            ("V,P\n1,x\n", None),
            ("V,P\n1\n", None),
            ("V,P,s\n1,2,0\n", Some("s")),
            ("V,P\n1,2\n", Some("s")),
        ] {
            assert!(parse(text, deviation).is_err_and(|e| e.to_string().contains("--shots a.csv")), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_told_apart_is_said() {
        let names = ["A".to_owned(), "mu".to_owned()];
        let with = |covariance: Option<[f64; 4]>, idle: &[usize]| {
            let covariance = covariance.map(|c| c.to_vec());
            sentences(
                &Fit {
                    values: vec![1.0; 2],
                    residuals: vec![0.0; 4],
                    freedom: 2,
                    covariance,
                    idle: idle.to_vec(),
                    edges: Vec::new(),
                    settled: true,
                },
                &names,
            )
        };
        assert!(with(Some([1.0, 0.5, 0.5, 1.0]), &[]).is_empty());
        assert!(with(Some([1.0, -0.99, -0.99, 1.0]), &[])[0].contains("A and mu apart (correlation -0.990)"));
        assert!(with(None, &[])[0].contains("at all"));
        assert_eq!(with(None, &[1]), ["no shot depends on mu: it cannot be told"]);
    }
}
