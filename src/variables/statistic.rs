//! What a history shows of a whole set in place of a column for each member.
//! Never here: sets, values of members.

/// One number of many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Statistic {
    /// The smallest.
    Min,
    /// The largest.
    Max,
    /// The mean: of what lives at integration points weighted by the volumes of the elements now, of all else not weighted.
    Mean,
    /// The sum.
    Sum,
}

impl Statistic {
    /// All of them, in the order of columns.
    pub const ALL: [Statistic; 4] = [Statistic::Min, Statistic::Max, Statistic::Mean, Statistic::Sum];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Statistic::Min => "MIN",
            Statistic::Max => "MAX",
            Statistic::Mean => "MEAN",
            Statistic::Sum => "SUM",
        }
    }

    /// The one of that name, in any case.
    pub fn parse(word: &str) -> Option<Statistic> {
        Statistic::ALL.into_iter().find(|statistic| word.eq_ignore_ascii_case(statistic.name()))
    }

    /// The name of a variable without that of a statistic behind it, and the statistic: `PEEQ_MAX` is `PEEQ` and `MAX`.
    pub fn split(label: &str) -> (&str, Option<Statistic>) {
        let parts = label.rsplit_once('_').and_then(|(stem, name)| Some((stem, Statistic::parse(name)?)));
        parts.map_or((label, None), |(stem, statistic)| (stem, Some(statistic)))
    }

    /// What values with weights come to; not a number of none, of which the sum is 0.
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
    fn of_some_values_and_of_none() {
        let values = || [(3.0, 1.0), (-1.0, 2.0), (4.0, 1.0)].into_iter();
        assert_eq!(Statistic::ALL.map(|s| s.of(values())), [-1.0, 4.0, 1.25, 6.0]);
        let none = Statistic::ALL.map(|s| s.of([].into_iter()));
        assert!(none[..3].iter().all(|x| x.is_nan()) && none[3] == 0.0, "{none:?}");
    }

    #[test]
    fn names_behind_variables() {
        assert_eq!(Statistic::split("S11_MAX"), ("S11", Some(Statistic::Max)));
        assert_eq!(Statistic::split("S11_SNEG_MIN"), ("S11_SNEG", Some(Statistic::Min)));
        assert_eq!(Statistic::split("S11_SNEG"), ("S11_SNEG", None));
        assert_eq!(Statistic::split("PEEQ"), ("PEEQ", None));
    }
}
