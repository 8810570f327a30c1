//! Spacing of nodes along a line: uniform or graded.

/// Returns the fractions from 0 to 1 of `count` divisions in geometric progression; the first is `ratio` times the
/// last.
pub fn graded(count: usize, ratio: f64) -> Vec<f64> {
    let factor = if count > 1 { libm::pow(1.0 / ratio, 1.0 / (count - 1) as f64) } else { 1.0 };
    let mut sums = vec![0.0];
    let mut division = 1.0;
    for n in 0..count {
        sums.push(sums[n] + division);
        division *= factor;
    }
    let whole = sums[count];
    sums.iter_mut().for_each(|s| *s /= whole);
    sums[count] = 1.0;
    sums
}

/// Returns the z coordinates of rows from the first to the last break, all breaks included. The spacing grows
/// exponentially from `size` by the factor `growth` in total.
pub fn rows(breaks: &[f64], size: f64, growth: f64) -> Vec<f64> {
    let (start, end) = (breaks[0], breaks[breaks.len() - 1]);
    let rate = libm::log(growth) / (end - start);
    let even = libm::fabs(rate) * (end - start) < 1e-9;
    // Number of local sizes up to z, the integral of dz/s with s = size e^(rate (z - from)), and its inverse.
    let counted = |z: f64| if even { (z - start) / size } else { -libm::expm1(-rate * (z - start)) / (rate * size) };
    let height = |n: f64| if even { start + n * size } else { start - libm::log1p(-rate * size * n) / rate };
    let mut rows = vec![start];
    for pair in breaks.windows(2) {
        let [low, high] = [pair[0], pair[1]].map(counted);
        let count = ((high - low).round() as usize).max(1);
        rows.extend((1..count).map(|n| height(low + (high - low) * n as f64 / count as f64)));
        rows.push(pair[1]);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graded_lines_have_their_ratio_and_meet_their_breaks() {
        let shares = graded(5, 4.0);
        let divisions: Vec<f64> = shares.windows(2).map(|p| p[1] - p[0]).collect();
        assert!((divisions[0] / divisions[4] - 4.0).abs() < 1e-12, "{divisions:?}");
        let rows = rows(&[1.0, 3.0, 9.0], 0.1, 8.0);
        assert!(rows.contains(&3.0) && rows[0] == 1.0 && rows[rows.len() - 1] == 9.0);
        let sizes: Vec<f64> = rows.windows(2).map(|p| p[1] - p[0]).collect();
        assert!((sizes[0] / 0.1 - 1.0).abs() < 0.1 && (sizes[sizes.len() - 1] / 0.8 - 1.0).abs() < 0.15, "{sizes:?}");
    }
}
