//! `identify`: least-squares fit of deck parameters to a table of shots, with confidence intervals and correlations.

use std::path::Path;

use super::StudyError;
use super::chart::{Chart, ChartSeries, SeriesForm};
use super::evaluate::SampleEvaluator;
use super::grid::CaseGrid;
use super::statistics::least_squares::{ParameterFit, fit};

/// Correlations above this size are reported.
const CLOSE: f64 = 0.95;
/// Relative step of the difference quotients; smaller steps would resolve single time increments.
const STEP: f64 = 1e-2;

/// Table of measured shots: known parameters, measured values and their standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct ShotTable {
    /// Names of the known parameters.
    pub names: Vec<String>,
    /// Values of the known parameters, one row per shot.
    pub rows: Vec<Vec<f64>>,
    /// Measured values, one per shot.
    pub measured: Vec<f64>,
    /// Standard deviation of each measurement; 1 if not given.
    pub deviations: Vec<f64>,
}

impl ShotTable {
    /// Parses a CSV file with a column of measurements, optionally a column of their standard deviations, and columns
    /// of parameters.
    pub fn parse(path: &Path, text: &str, measured: &str, deviation: Option<&str>) -> Result<ShotTable, StudyError> {
        let wrong = |message: String| StudyError::file("--shots", path, message);
        let table = CaseGrid::table("--shots", path, text)?;
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
            let absent = || wrong(format!("there is no column {name}; the columns are {}", known.join(", ")));
            place.ok_or_else(absent).map(|place| columns.remove(place).1)
        };
        let measured = take(measured)?;
        let deviations = deviation.map(&mut take).transpose()?.unwrap_or_else(|| vec![1.0; measured.len()]);
        if let Some(at) = deviations.iter().position(|d| *d <= 0.0) {
            return Err(wrong(format!("shot {}: a standard deviation must be above zero", at + 1)));
        }
        let rows = (0..measured.len()).map(|i| columns.iter().map(|column| column.1[i]).collect()).collect();
        Ok(ShotTable { names: columns.into_iter().map(|column| column.0).collect(), rows, measured, deviations })
    }

    /// Returns the given value of each shot over the first parameter, or over the shot number without parameters.
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

    /// Returns a chart of the measured values and of those computed with the fitted parameters, over the first
    /// parameter.
    pub fn chart(&self, title: &str, measured: &str, quantity: &str, found: &ParameterFit) -> Chart {
        let computed: Vec<f64> =
            (0..self.rows.len()).map(|i| self.measured[i] + found.residuals[i] * self.deviations[i]).collect();
        let form = if self.names.len() == 1 { SeriesForm::Line } else { SeriesForm::Marks };
        let series = vec![
            ChartSeries::new(measured, SeriesForm::Marks, self.points(self.measured.iter().copied())),
            ChartSeries::new(format!("{quantity}, fitted"), form, self.points(computed.into_iter())),
        ];
        Chart::new(title, [self.names.first().map_or("shot", String::as_str), measured], series)
    }
}

/// Fits the unknown parameters, starting at `start`. The evaluator must have the parameters of the shots, followed by
/// the unknown parameters, and one quantity.
pub fn identify(
    evaluator: &SampleEvaluator,
    shots: &ShotTable,
    start: &[f64],
    threads: usize,
) -> Result<ParameterFit, StudyError> {
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
        let why = format!(
            "{shots} shots do not determine {unknown} parameters and their errors; at least {} shots are needed",
            unknown + 1
        );
        return Err(StudyError::Comparison(why));
    }
    let found = fit(start, STEP, model)?;
    found.ok_or_else(|| match first {
        Some(failure) => failure.reason,
        None => StudyError::Comparison("the quantity cannot be computed with the initial parameters".into()),
    })
}

/// Returns remarks on a fit: convergence, insensitive parameters, bounds and correlations.
pub fn sentences(found: &ParameterFit, names: &[String]) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    if !found.converged {
        said.push("the fit did not converge: choose initial values closer to the solution".into());
    }
    said.extend(found.insensitive.iter().map(|i| format!("no shot depends on {}: it cannot be identified", names[*i])));
    let edge =
        |i: &usize| format!("{} is at the edge of its valid range: its interval extends beyond that edge", names[*i]);
    said.extend(found.edges.iter().map(edge));
    for one in 0..names.len() {
        for other in one + 1..names.len() {
            match found.correlation(one, other) {
                Some(r) if r.abs() > CLOSE => {
                    let (how, what) = if r > 0.0 {
                        ("increasing or decreasing both", "difference")
                    } else {
                        ("increasing one and decreasing the other", "sum")
                    };
                    said.push(format!(
                        "{} and {} are hardly distinguishable (correlation {r:.3}): {how} fits nearly as well; the shots determine a weighted \
                         {what} of the two",
                        names[one], names[other]
                    ));
                }
                _ => {}
            }
        }
    }
    if found.covariance.is_none() && found.insensitive.is_empty() {
        said.push(format!(
            "the shots do not determine {}: a combined change of these parameters leaves all computed values unchanged",
            names.join(" and ")
        ));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::{ShotTable, sentences};
    use crate::study::statistics::least_squares::ParameterFit;

    #[test]
    fn shot_tables_are_parsed() {
        let parse = |text: &str, deviation| ShotTable::parse("a.csv".as_ref(), text, "P", deviation);
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
    fn indistinguishable_parameters_are_reported() {
        let names = ["A".to_owned(), "mu".to_owned()];
        let with = |covariance: Option<[f64; 4]>, idle: &[usize]| {
            let covariance = covariance.map(|c| c.to_vec());
            sentences(
                &ParameterFit {
                    values: vec![1.0; 2],
                    residuals: vec![0.0; 4],
                    freedom: 2,
                    covariance,
                    insensitive: idle.to_vec(),
                    edges: Vec::new(),
                    converged: true,
                },
                &names,
            )
        };
        assert!(with(Some([1.0, 0.5, 0.5, 1.0]), &[]).is_empty());
        assert!(
            with(Some([1.0, -0.99, -0.99, 1.0]), &[])[0]
                .contains("A and mu are hardly distinguishable (correlation -0.990)")
        );
        assert!(with(None, &[])[0].contains("do not determine"));
        assert_eq!(with(None, &[1]), ["no shot depends on mu: it cannot be identified"]);
    }
}
