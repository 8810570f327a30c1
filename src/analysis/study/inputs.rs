//! Random deck parameters with their distributions and correlations.

use super::StudyError;
use super::grid::SettingForm;
use super::statistics::cholesky::CholeskyFactor;
use super::statistics::distribution::ParameterDistribution;
use super::statistics::normal;

/// Random parameters with their distributions.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomInputs {
    /// Names of the parameters.
    pub names: Vec<String>,
    distributions: Vec<ParameterDistribution>,
    /// Cholesky factor of the correlation matrix; `None` if all correlations are zero.
    correlation_factor: Option<CholeskyFactor>,
}

impl RandomInputs {
    /// Parses `NAME=DISTRIBUTION` and correlations `NAME:OTHER=NUMBER`.
    pub fn parse(distributions: &[String], correlations: &[String]) -> Result<RandomInputs, StudyError> {
        let mut inputs = RandomInputs { names: Vec::new(), distributions: Vec::new(), correlation_factor: None };
        for text in distributions {
            let wrong = |why: String| StudyError::Setting(format!("--distribution {text}: {why}"));
            let (name, definition) = text
                .split_once('=')
                .ok_or_else(|| wrong("expected NAME=DISTRIBUTION, for example V=800..850".into()))?;
            if inputs.names.iter().any(|known| known == name.trim()) {
                return Err(wrong("the parameter has two distributions".into()));
            }
            let named = |why| match SettingForm::of(definition) {
                SettingForm::Values => wrong(format!("expected a distribution; {}", SettingForm::Values.accepted_by())),
                _ => wrong(why),
            };
            inputs.distributions.push(ParameterDistribution::parse(definition).map_err(named)?);
            inputs.names.push(name.trim().to_owned());
        }
        if !correlations.is_empty() {
            inputs.correlation_factor = Some(inputs.correlated(correlations)?);
        }
        Ok(inputs)
    }

    fn correlated(&self, correlations: &[String]) -> Result<CholeskyFactor, StudyError> {
        let size = self.names.len();
        let mut matrix: Vec<f64> = (0..size * size).map(|k| f64::from(u8::from(k % (size + 1) == 0))).collect();
        for text in correlations {
            let wrong = |why: &str| StudyError::Setting(format!("--correlation {text}: {why}"));
            let parts = text.split_once('=').and_then(|(pair, number)| Some((pair.split_once(':')?, number)));
            let ((first_name, second_name), number) =
                parts.ok_or_else(|| wrong("expected NAME:OTHER=NUMBER, for example V:m=0.5"))?;
            let position = |name: &str| self.names.iter().position(|known| known == name.trim());
            let (Some(i), Some(j)) = (position(first_name), position(second_name)) else {
                return Err(wrong("both parameters need a --distribution"));
            };
            let number = number.trim().parse::<f64>().ok().filter(|r| r.abs() < 1.0);
            let number = number.ok_or_else(|| wrong("expected a number between -1 and 1"))?;
            if i == j || matrix[i * size + j] != 0.0 {
                return Err(wrong("expected two different parameters that have no other --correlation"));
            }
            matrix[i * size + j] = number;
            matrix[j * size + i] = number;
        }
        let impossible = "--correlation: the correlations are inconsistent: their matrix is not positive definite";
        CholeskyFactor::of(&matrix, size, 1e-12).ok_or_else(|| StudyError::Setting(impossible.into()))
    }

    /// Maps a point of the unit cube to parameter values. The correlations are those of a Gaussian copula (Nelsen, An
    /// Introduction to Copulas, section 2.3); for normal distributions they are the correlations of the parameters
    /// themselves.
    pub fn values(&self, point: &[f64], values: &mut [f64]) {
        values.copy_from_slice(point);
        if let Some(together) = &self.correlation_factor {
            values.iter_mut().for_each(|u| *u = normal::quantile(*u));
            together.multiply(values);
            values.iter_mut().for_each(|z| *z = normal::cumulative(*z));
        }
        values.iter_mut().zip(&self.distributions).for_each(|(value, of)| *value = of.quantile(*value));
    }
}

#[cfg(test)]
mod tests {
    use super::RandomInputs;
    use crate::study::statistics::design::{SampleDesign, SamplingScheme};

    fn words(words: &[&str]) -> Vec<String> {
        words.iter().map(|w| (*w).to_owned()).collect()
    }

    fn correlation(pairs: &[[f64; 2]]) -> f64 {
        let count = pairs.len() as f64;
        let mean = [0, 1].map(|i| pairs.iter().map(|p| p[i]).sum::<f64>() / count);
        let product = |i: usize, j: usize| pairs.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>();
        product(0, 1) / (product(0, 0) * product(1, 1)).sqrt()
    }

    fn ranks(values: impl Iterator<Item = f64>) -> Vec<f64> {
        let values: Vec<f64> = values.collect();
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let mut ranks = vec![0.0; values.len()];
        order.into_iter().enumerate().for_each(|(rank, i)| ranks[i] = rank as f64);
        ranks
    }

    /// Source: normal parameters have the given correlation r; the rank correlation is 6/pi asin(r/2) for any
    /// distributions.
    #[test]
    fn samples_have_the_requested_correlations() {
        let distributions = words(&["V=normal(800, 20)", "m=normal(0.02, 0.001)", "A=lognormal(4, 1)", "mu=0..0.2"]);
        let inputs = RandomInputs::parse(&distributions, &words(&["V:m=0.6", "m : A=-0.5"])).expect("inputs");
        let count = 1 << 14;
        let (mut points, mut samples) = (vec![0.0; 4 * count], vec![0.0; 4 * count]);
        SampleDesign::new(SamplingScheme::Sobol, 4, count, 5).expect("a design").fill(&mut points);
        points.chunks(4).zip(samples.chunks_mut(4)).for_each(|(point, values)| inputs.values(point, values));
        let pair = |i: usize, j: usize| -> Vec<[f64; 2]> { samples.chunks(4).map(|v| [v[i], v[j]]).collect() };
        assert!((correlation(&pair(0, 1)) - 0.6).abs() < 0.01);
        assert!(correlation(&pair(0, 3)).abs() < 0.01 && correlation(&pair(0, 2)).abs() < 0.01);
        let ranked: Vec<[f64; 2]> = ranks(samples.chunks(4).map(|v| v[1]))
            .into_iter()
            .zip(ranks(samples.chunks(4).map(|v| v[2])))
            .map(|(a, b)| [a, b])
            .collect();
        let of_ranks = 6.0 / std::f64::consts::PI * libm::asin(-0.25);
        assert!((correlation(&ranked) - of_ranks).abs() < 0.01);
        let mean = samples.chunks(4).map(|v| v[2]).sum::<f64>() / count as f64;
        assert!((mean - 4.0).abs() < 0.01, "correlations leave the distributions as they are: {mean}");
    }

    #[test]
    fn invalid_distributions_and_correlations_are_errors() {
        let two = words(&["V=0..1", "m=0..1", "A=0..1"]);
        for (distributions, correlations) in [
            (words(&["V"]), vec![]),
            (words(&["V=1"]), vec![]),
            (words(&["V=0..1", "V=0..2"]), vec![]),
            (two.clone(), words(&["V:x=0.5"])),
            (two.clone(), words(&["V:m"])),
            (two.clone(), words(&["V:m=1"])),
            (two.clone(), words(&["V:V=0.5"])),
            (two.clone(), words(&["V:m=0.5", "m:V=0.5"])),
            (two, words(&["V:m=0.9", "m:A=0.9", "V:A=-0.9"])),
        ] {
            assert!(RandomInputs::parse(&distributions, &correlations).is_err(), "{distributions:?} {correlations:?}");
        }
        let list = RandomInputs::parse(&words(&["V=500,600"]), &[]).expect_err("an error").to_string();
        assert!(list.contains("sweep --set"), "{list}");
    }
}
