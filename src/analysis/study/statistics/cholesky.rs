//! Cholesky factorisation of small symmetric positive definite matrices, for correlations and normal equations.

/// Lower triangular matrix L of A = L L^T, stored by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct CholeskyFactor {
    size: usize,
    rows: Vec<f64>,
}

impl CholeskyFactor {
    /// Factorises a matrix given by rows; `None` if a pivot is below `least` times the diagonal entry.
    pub fn of(matrix: &[f64], size: usize, least: f64) -> Option<CholeskyFactor> {
        let mut rows = matrix.to_vec();
        for i in 0..size {
            for j in 0..=i {
                let dot: f64 = (0..j).map(|k| rows[i * size + k] * rows[j * size + k]).sum();
                let difference = matrix[i * size + j] - dot;
                rows[i * size + j] = if i > j {
                    difference / rows[j * size + j]
                } else if difference > least * matrix[i * size + i] {
                    difference.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(CholeskyFactor { size, rows })
    }

    /// Replaces x by the product L x.
    pub fn multiply(&self, x: &mut [f64]) {
        for i in (0..self.size).rev() {
            x[i] = (0..=i).map(|k| self.rows[i * self.size + k] * x[k]).sum();
        }
    }

    /// Replaces the right-hand side b in `x` by the solution of A x = b.
    pub fn solve(&self, x: &mut [f64]) {
        let (n, l) = (self.size, &self.rows);
        for i in 0..n {
            let known: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
            x[i] = (x[i] - known) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
            x[i] = (x[i] - known) / l[i * n + i];
        }
    }

    /// Returns the inverse of A by rows.
    pub fn inverse(&self) -> Vec<f64> {
        let n = self.size;
        let mut inverse = vec![0.0; n * n];
        for (i, row) in inverse.chunks_exact_mut(n.max(1)).enumerate() {
            row[i] = 1.0;
            self.solve(row);
        }
        inverse
    }
}

#[cfg(test)]
mod tests {
    use super::CholeskyFactor;

    #[test]
    fn factor_solves_and_inverts() {
        let a = [4.0, 2.0, 0.4, 2.0, 5.0, 1.0, 0.4, 1.0, 3.0];
        let factor = CholeskyFactor::of(&a, 3, 0.0).expect("positive definite");
        let times =
            |x: &[f64]| -> Vec<f64> { a.chunks(3).map(|r| r.iter().zip(x).map(|(a, x)| a * x).sum()).collect() };
        let mut x = vec![1.0, 2.0, 3.0];
        factor.solve(&mut x);
        assert!(times(&x).iter().zip([1.0, 2.0, 3.0]).all(|(b, known)| (b - known).abs() < 1e-14));
        for (i, row) in factor.inverse().chunks(3).enumerate() {
            assert!(times(row).iter().enumerate().all(|(j, b)| (b - f64::from(u8::from(i == j))).abs() < 1e-14));
        }
        assert_eq!(CholeskyFactor::of(&[1.0, 2.0, 2.0, 1.0], 2, 0.0), None);
        assert_eq!(CholeskyFactor::of(&[1.0, 1.0 - 1e-14, 1.0 - 1e-14, 1.0], 2, 1e-10), None);
    }
}
