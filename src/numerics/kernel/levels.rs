//! Tables over several variables, with linear interpolation, constant beyond the ends.

/// A table over several variables, nested by variable (ABAQUS Analysis User's Guide, "Material data definition": in a
/// table of several independent variables the first varies fastest).
#[derive(Clone, Debug, PartialEq)]
pub enum NestedTable {
    /// Value without further variables.
    Value(f64),
    /// Tables at ascending values of a variable.
    Over(Vec<(f64, NestedTable)>),
}

impl NestedTable {
    /// Creates a table from rows of a value and its variables, the same number in each row. `None` if rows with the
    /// same value of a slower variable are not consecutive, or if a variable is not ascending.
    pub fn new<R: AsRef<[f64]>>(rows: &[R]) -> Option<NestedTable> {
        let rows: Vec<&[f64]> = rows.iter().map(AsRef::as_ref).collect();
        let length = rows.first()?.len();
        rows.iter().all(|r| r.len() == length).then(|| NestedTable::of(&rows, length.checked_sub(1)?)).flatten()
    }

    fn of(rows: &[&[f64]], variable: usize) -> Option<NestedTable> {
        if variable == 0 {
            let [row] = rows else { return None };
            return Some(NestedTable::Value(row[0]));
        }
        let parts = rows.chunk_by(|a, b| a[variable] == b[variable]);
        let entry = |part: &[&[f64]]| Some((part[0][variable], NestedTable::of(part, variable - 1)?));
        let entries: Vec<(f64, NestedTable)> = parts.map(entry).collect::<Option<_>>()?;
        let ascends = entries.windows(2).all(|w| w[0].0 < w[1].0);
        (ascends && !entries.is_empty()).then_some(NestedTable::Over(entries))
    }

    /// Returns the interpolated value; variables in the order of the rows.
    pub fn at(&self, variables: &[f64]) -> f64 {
        let (entries, Some((&x, faster))) = (self.entries(), variables.split_last()) else { return self.value() };
        let after = entries.partition_point(|e| e.0 <= x);
        match (after.checked_sub(1).map(|i| &entries[i]), entries.get(after)) {
            (Some((low, a)), Some((high, b))) => {
                let (a, b) = (a.at(faster), b.at(faster));
                a + (b - a) * (x - low) / (high - low)
            }
            (Some((_, only)), None) | (None, Some((_, only))) => only.at(faster),
            (None, None) => self.value(),
        }
    }

    fn entries(&self) -> &[(f64, NestedTable)] {
        match self {
            NestedTable::Value(_) => &[],
            NestedTable::Over(entries) => entries,
        }
    }

    fn value(&self) -> f64 {
        match self {
            NestedTable::Value(value) => *value,
            NestedTable::Over(_) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::NestedTable;

    /// 1 + x + 10 y + 100 z is linear: the table reproduces it inside, and returns the closest edge value outside.
    #[test]
    fn linear_functions_are_reproduced_exactly() {
        let f = |x: f64, y: f64, z: f64| 1.0 + x + 10.0 * y + 100.0 * z;
        let mut rows = Vec::new();
        for z in [0.0, 2.0] {
            for y in [-1.0, 1.0, 2.0] {
                rows.extend([0.0, 1.0, 5.0].map(|x| [f(x, y, z), x, y, z]));
            }
        }
        let levels = NestedTable::new(&rows).expect("a table");
        for (x, y, z) in [(0.0, -1.0, 0.0), (0.5, 0.0, 0.5), (4.0, 1.5, 1.0), (5.0, 2.0, 2.0)] {
            assert!((levels.at(&[x, y, z]) - f(x, y, z)).abs() < 1e-12, "{x} {y} {z}");
        }
        assert!((levels.at(&[9.0, -7.0, 1.0]) - f(5.0, -1.0, 1.0)).abs() < 1e-12);
        rows.swap(0, 8);
        assert_eq!(NestedTable::new(&rows), None);
        assert_eq!(NestedTable::new(&[[1.0, 0.0, 0.0, 0.0]; 2]), None, "two rows at one place");
        assert_eq!(NestedTable::new::<[f64; 4]>(&[]), None);
        assert_eq!(NestedTable::new(&[vec![1.0, 0.0], vec![2.0]]), None, "rows of different lengths");
    }
}
