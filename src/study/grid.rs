//! The values a sweep runs through: lists and ranges per parameter, several make a grid.
//! Never here: runs.

use super::StudyError;

/// The most combinations of one sweep.
const MOST: usize = 10_000_000;

/// Parameters with the values each takes; the last varies fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    axes: Vec<(String, Vec<String>)>,
}

impl Grid {
    /// From `NAME=v1,v2,…`, `NAME=start:stop:step` (stop included where it is met) or `NAME=start:stop:#count`.
    ///
    /// # Errors
    /// In words, for a form that is none of these or an absurd number of combinations.
    pub fn parse(settings: &[String]) -> Result<Grid, StudyError> {
        Grid::read(settings).map_err(StudyError::Setting)
    }

    /// The same in words, of the option that a sweep has.
    pub(super) fn read(settings: &[String]) -> Result<Grid, String> {
        let mut grid = Grid::default();
        for setting in settings {
            let (name, values) = axis(setting)?;
            if grid.axes.iter().any(|a| a.0 == name) {
                return Err(format!("--set {name} is given twice"));
            }
            grid.axes.push((name, values));
        }
        let count = grid.axes.iter().try_fold(1_usize, |n, a| n.checked_mul(a.1.len()));
        match count {
            Some(count) if count <= MOST => Ok(grid),
            _ => Err(format!("the sweep has more than {MOST} combinations; that is taken for a slip")),
        }
    }

    /// Names of the parameters.
    pub fn names(&self) -> Vec<&str> {
        self.axes.iter().map(|a| a.0.as_str()).collect()
    }

    /// Parameters with their values, as given.
    pub fn axes(&self) -> &[(String, Vec<String>)] {
        &self.axes
    }

    /// How many combinations there are.
    pub fn count(&self) -> usize {
        self.axes.iter().map(|a| a.1.len()).product()
    }

    /// The combination with that index as `--set` pairs.
    pub fn combination(&self, index: usize) -> Vec<(String, String)> {
        let mut rest = index;
        let mut pairs: Vec<_> = self
            .axes
            .iter()
            .rev()
            .map(|(name, values)| {
                let value = values[rest % values.len()].clone();
                rest /= values.len();
                (name.clone(), value)
            })
            .collect();
        pairs.reverse();
        pairs
    }
}

fn axis(setting: &str) -> Result<(String, Vec<String>), String> {
    let (name, text) = setting.split_once('=').ok_or_else(|| format!("--set {setting}: NAME=value is the form"))?;
    let values =
        if text.contains(':') { range(setting, text)? } else { text.split(',').map(|v| v.trim().to_owned()).collect() };
    if name.trim().is_empty() || values.iter().any(String::is_empty) {
        return Err(format!("--set {setting}: a name or a value is missing"));
    }
    Ok((name.trim().to_owned(), values))
}

fn range(setting: &str, text: &str) -> Result<Vec<String>, String> {
    let wrong = || format!("--set {setting}: a range is start:stop:step or start:stop:#count");
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [start, stop, step] = parts[..] else { return Err(wrong()) };
    let number = |t: &str| t.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
    let (start, stop) = (number(start)?, number(stop)?);
    let intervals = match step.strip_prefix('#') {
        Some(count) => count.parse::<usize>().ok().filter(|c| *c > 0).ok_or_else(wrong)? as f64 - 1.0,
        None => (((stop - start) / number(step)?) * (1.0 + 1e-12)).floor(),
    };
    if !(0.0..MOST as f64).contains(&intervals) {
        return Err(format!("--set {setting}: this range has no values, or more than {MOST}"));
    }
    let width = if step.starts_with('#') { (stop - start) / intervals.max(1.0) } else { number(step)? };
    Ok((0..=intervals as usize).map(|i| format!("{}", start + i as f64 * width)).collect())
}

#[cfg(test)]
mod tests {
    use super::Grid;

    fn values(setting: &str) -> Result<Vec<String>, String> {
        let grid = Grid::read(&[setting.to_owned()])?;
        Ok((0..grid.count()).map(|i| grid.combination(i)[0].1.clone()).collect())
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(values("V=569,570"), Ok(vec!["569".into(), "570".into()]));
        assert_eq!(values("V=1:2:0.5"), Ok(vec!["1".into(), "1.5".into(), "2".into()]));
        assert_eq!(values("V=0:1:#3"), Ok(vec!["0".into(), "0.5".into(), "1".into()]));
        for wrong in ["V", "V=", "=1", "V=1:2", "V=2:1:1", "V=0:1:0", "V=0:1e99:1", "V=1,,2"] {
            assert!(values(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_last_parameter_varies_fastest() {
        let grid = Grid::parse(&["a=1,2".into(), "b=3,4,5".into()]).expect("a grid");
        assert_eq!(grid.count(), 6);
        let pair = |i: usize| grid.combination(i).into_iter().map(|p| p.1).collect::<Vec<_>>().join("");
        assert_eq!((0..6).map(pair).collect::<Vec<_>>().join(" "), "13 14 15 23 24 25");
    }
}
