//! Statistics over a set, which a history can contain instead of one column for each member.

/// Statistic of a list of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Statistic {
    /// The smallest value.
    Min,
    /// The largest value.
    Max,
    /// The mean, weighted by the current volumes of elements for variables at integration points, else not weighted.
    Mean,
    /// The sum of all values, without weights.
    Sum,
}

impl Statistic {
    /// All statistics, in the order of columns.
    pub const ALL: [Statistic; 4] = [Statistic::Min, Statistic::Max, Statistic::Mean, Statistic::Sum];

    /// Returns the upper-case name in column names.
    pub fn name(self) -> &'static str {
        match self {
            Statistic::Min => "MIN",
            Statistic::Max => "MAX",
            Statistic::Mean => "MEAN",
            Statistic::Sum => "SUM",
        }
    }

    /// Returns the statistic with this name (case-insensitive).
    pub fn parse(word: &str) -> Option<Statistic> {
        Statistic::ALL.into_iter().find(|statistic| word.eq_ignore_ascii_case(statistic.name()))
    }

    /// Splits a label into the name of the variable and the statistic at its end: `PEEQ_MAX` into `PEEQ` and `MAX`.
    pub fn split(label: &str) -> (&str, Option<Statistic>) {
        let parts = label.rsplit_once('_').and_then(|(stem, name)| Some((stem, Statistic::parse(name)?)));
        parts.map_or((label, None), |(stem, statistic)| (stem, Some(statistic)))
    }

    /// Returns the statistic of values with weights. Without values it is NaN; the sum is 0.
    pub fn of(self, values: impl Iterator<Item = (f64, f64)>) -> f64 {
        match self {
            Statistic::Min => values.map(|(value, _)| value).fold(f64::NAN, f64::min),
            Statistic::Max => values.map(|(value, _)| value).fold(f64::NAN, f64::max),
            Statistic::Sum => values.map(|(value, _)| value).fold(0.0, |sum, value| sum + value),
            Statistic::Mean => {
                let (sum, weights) =
                    values.fold((0.0, 0.0), |(s, w), (value, weight)| (s + weight * value, w + weight));
                sum / weights
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Statistic;

    #[test]
    fn statistics_match_hand_calculation() {
        let values = || [(3.0, 1.0), (-1.0, 2.0), (4.0, 1.0)].into_iter();
        assert_eq!(Statistic::ALL.map(|s| s.of(values())), [-1.0, 4.0, 1.25, 6.0]);
        let none = Statistic::ALL.map(|s| s.of([].into_iter()));
        assert!(none[..3].iter().all(|x| x.is_nan()) && none[3] == 0.0, "{none:?}");
    }

    #[test]
    fn labels_split_into_variable_and_statistic() {
        assert_eq!(Statistic::split("S11_MAX"), ("S11", Some(Statistic::Max)));
        assert_eq!(Statistic::split("S11_SNEG_MIN"), ("S11_SNEG", Some(Statistic::Min)));
        assert_eq!(Statistic::split("S11_SNEG"), ("S11_SNEG", None));
        assert_eq!(Statistic::split("PEEQ"), ("PEEQ", None));
    }
}
