//! Probability distributions of one parameter, evaluated by their quantile function.

use super::normal;
use crate::deck::lists::split;

/// Probability distribution of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterDistribution {
    /// Uniform distribution between two ends.
    Uniform {
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// Normal distribution, without limits.
    Normal {
        /// Mean of the parameter.
        mean: f64,
        /// Standard deviation of the parameter.
        deviation: f64,
    },
    /// Lognormal distribution of values above zero.
    LogNormal {
        /// Mean of the logarithm.
        mean: f64,
        /// Standard deviation of the logarithm.
        deviation: f64,
    },
    /// Truncation of another distribution to an interval.
    Truncated {
        /// The distribution before truncation.
        of: Box<ParameterDistribution>,
        /// Lower end, and its cumulative probability before truncation.
        low: (f64, f64),
        /// Upper end, and its cumulative probability before truncation.
        high: (f64, f64),
    },
}

const FORMS: &str = "low..high, uniform(low, high), normal(mean, deviation), lognormal(mean, deviation), \
                     truncated(normal(…), low, high)";

impl ParameterDistribution {
    /// Parses `low..high`, `uniform(low, high)`, `normal(mean, deviation)`, `lognormal(mean, deviation)` (mean and
    /// standard deviation of the parameter, not of its logarithm) or `truncated(D, low, high)`, where an end may be
    /// `-inf` or `inf`.
    pub fn parse(text: &str) -> Result<ParameterDistribution, String> {
        let text = text.trim();
        if let Some((low, high)) = text.split_once("..").filter(|_| !text.contains('(')) {
            return ParameterDistribution::uniform(number(low)?, number(high)?);
        }
        let call = text.strip_suffix(')').and_then(|t| t.split_once('('));
        let (name, arguments) = call.ok_or_else(|| format!("`{text}` is not a distribution; expected {FORMS}"))?;
        match (name.trim(), &split(arguments)[..]) {
            ("uniform", [low, high]) => ParameterDistribution::uniform(number(low)?, number(high)?),
            ("normal", [mean, deviation]) => ParameterDistribution::normal(number(mean)?, number(deviation)?),
            ("lognormal", [mean, deviation]) => ParameterDistribution::log_normal(number(mean)?, number(deviation)?),
            ("truncated", [of, low, high]) => ParameterDistribution::parse(of)?.truncated(end(low)?, end(high)?),
            _ => Err(format!("`{text}` is not a distribution; expected {FORMS}")),
        }
    }

    fn uniform(low: f64, high: f64) -> Result<ParameterDistribution, String> {
        let rise = low < high && (high - low).is_finite();
        if rise {
            Ok(ParameterDistribution::Uniform { low, high })
        } else {
            Err(format!("{low}..{high}: the lower end must be below the upper end"))
        }
    }

    fn normal(mean: f64, deviation: f64) -> Result<ParameterDistribution, String> {
        above_zero("a standard deviation", deviation)?;
        Ok(ParameterDistribution::Normal { mean, deviation })
    }

    /// Creates a lognormal distribution from mean and deviation of the parameter: s^2 = ln(1 + (deviation/mean)^2), m =
    /// ln(mean) - s^2/2, with mean m and deviation s of the logarithm.
    fn log_normal(mean: f64, deviation: f64) -> Result<ParameterDistribution, String> {
        above_zero("the mean of a lognormal", mean)?;
        above_zero("a standard deviation", deviation)?;
        let square = libm::log1p((deviation / mean) * (deviation / mean));
        Ok(ParameterDistribution::LogNormal { mean: libm::log(mean) - 0.5 * square, deviation: square.sqrt() })
    }

    fn truncated(self, low: f64, high: f64) -> Result<ParameterDistribution, String> {
        let below = [low, high].map(|x| self.cumulative(x));
        // With less probability the quantiles would not be accurate.
        if below[1] - below[0] < 1e-9 {
            return Err(format!("the probability between {low} and {high} is below 1e-9; widen the interval"));
        }
        Ok(ParameterDistribution::Truncated { of: Box::new(self), low: (low, below[0]), high: (high, below[1]) })
    }

    /// Returns the cumulative probability at `x`.
    pub fn cumulative(&self, x: f64) -> f64 {
        match self {
            ParameterDistribution::Uniform { low, high } => ((x - low) / (high - low)).clamp(0.0, 1.0),
            ParameterDistribution::Normal { mean, deviation } => normal::cumulative((x - mean) / deviation),
            ParameterDistribution::LogNormal { .. } if x <= 0.0 => 0.0,
            ParameterDistribution::LogNormal { mean, deviation } => {
                normal::cumulative((libm::log(x) - mean) / deviation)
            }
            ParameterDistribution::Truncated { of, low, high } => {
                ((of.cumulative(x) - low.1) / (high.1 - low.1)).clamp(0.0, 1.0)
            }
        }
    }

    /// Returns the quantile for the probability `part`.
    pub fn quantile(&self, part: f64) -> f64 {
        match self {
            ParameterDistribution::Uniform { low, high } => low + part * (high - low),
            ParameterDistribution::Normal { mean, deviation } => mean + deviation * normal::quantile(part),
            ParameterDistribution::LogNormal { mean, deviation } => {
                libm::exp(mean + deviation * normal::quantile(part))
            }
            ParameterDistribution::Truncated { of, low, high } => {
                of.quantile(low.1 + part * (high.1 - low.1)).clamp(low.0, high.0)
            }
        }
    }
}

fn above_zero(what: &str, value: f64) -> Result<(), String> {
    if value > 0.0 { Ok(()) } else { Err(format!("{what} must be above zero, found {value}")) }
}

fn number(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    number.ok_or_else(|| format!("`{}` is not a number", text.trim()))
}

/// Parses a finite or infinite end of an interval.
fn end(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|v| !v.is_nan());
    number.ok_or_else(|| format!("`{}` is not a number", text.trim()))
}

#[cfg(test)]
mod tests {
    use super::ParameterDistribution;

    fn parse(text: &str) -> ParameterDistribution {
        ParameterDistribution::parse(text).expect(text)
    }

    /// Computes mean and deviation by the midpoint rule over quantiles.
    fn moments(of: &ParameterDistribution) -> [f64; 2] {
        let n = 200_000;
        let values = || (0..n).map(|i| of.quantile((f64::from(i) + 0.5) / f64::from(n)));
        let mean = values().sum::<f64>() / f64::from(n);
        [mean, (values().map(|x| (x - mean) * (x - mean)).sum::<f64>() / f64::from(n)).sqrt()]
    }

    /// Source: closed-form moments; for the truncated normal distribution Johnson, Kotz and Balakrishnan, Continuous
    /// Univariate Distributions 1, section 13.10: within one deviation of the mean sqrt(1 - 2 phi(1)/(2 Phi(1) - 1)).
    #[test]
    fn quantiles_have_the_given_moments() {
        for (text, mean, deviation) in [
            ("500..600", 550.0, 100.0 / 12_f64.sqrt()),
            ("uniform(-1, 1)", 0.0, 2.0 / 12_f64.sqrt()),
            ("normal(800, 20)", 800.0, 20.0),
            ("lognormal(2, 0.5)", 2.0, 0.5),
            ("truncated(normal(3, 1), 2, 4)", 3.0, 0.539_560),
            ("truncated( normal(3,1), -inf, inf )", 3.0, 1.0),
        ] {
            let distribution = parse(text);
            let [m, s] = moments(&distribution);
            assert!((m - mean).abs() < 1e-3 * deviation && (s / deviation - 1.0).abs() < 1e-3, "{text}: {m} {s}");
            for part in [1e-6, 0.1, 0.5, 0.9, 1.0 - 1e-6] {
                assert!(
                    (distribution.cumulative(distribution.quantile(part)) - part).abs() < 1e-12,
                    "{text} at {part}"
                );
            }
        }
        let cut = parse("truncated(normal(0, 1), 1, 2)");
        assert_eq!([0.0, 1.0].map(|u| (1.0..=2.0).contains(&cut.quantile(u))), [true; 2]);
    }

    #[test]
    fn invalid_distributions_are_errors() {
        for wrong in [
            "",
            "5",
            "2..1",
            "a..b",
            "normal(1)",
            "normal(1, 0)",
            "normal(1, -1)",
            "normal(x, 1)",
            "lognormal(-1, 1)",
            "gamma(1, 2)",
            "truncated(normal(0, 1), 2, 1)",
            "truncated(normal(0, 1), 50, 60)",
            "truncated(normal(0, 1), 2)",
            "uniform(1, nan)",
            "normal(1, 2",
        ] {
            assert!(ParameterDistribution::parse(wrong).is_err(), "{wrong}");
        }
    }
}
