//! Search for the equations that another one depends on, for messages only: results may differ in the last bits from
//! machine to machine.

/// Returns the rows whose linear combination is `last`, from the least squares solution by a pivoted QR decomposition.
#[cfg(feature = "dense")]
pub(super) fn sources(rows: &[Vec<f64>], last: &[f64]) -> Vec<usize> {
    use faer::Mat;
    use faer::prelude::SolveLstsq;
    if rows.is_empty() {
        return Vec::new();
    }
    let before = Mat::from_fn(last.len(), rows.len(), |f, i| rows[i][f]);
    let own = Mat::from_fn(last.len(), 1, |f, _| last[f]);
    let parts = before.col_piv_qr().solve_lstsq(&own);
    let largest = (0..rows.len()).map(|i| parts[(i, 0)].abs()).fold(0.0, f64::max);
    (0..rows.len()).filter(|&i| parts[(i, 0)].abs() > 1e-8 * largest).collect()
}

/// Returns all rows that share degrees of freedom with `last`; used without dense linear algebra.
#[cfg(not(feature = "dense"))]
pub(super) fn sources(rows: &[Vec<f64>], last: &[f64]) -> Vec<usize> {
    let shares = |row: &Vec<f64>| row.iter().zip(last).any(|(a, b)| a * b != 0.0);
    (0..rows.len()).filter(|&i| shares(&rows[i])).collect()
}
